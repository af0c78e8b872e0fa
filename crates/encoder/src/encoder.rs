//! The encoder: the parts joined in the order of one exchange.

use embedded_storage::Storage;
use encoring_words::model::{Listed, Sensor, Takes};
use encoring_words::ssi_frame::{Level, SsiFormat, SsiFrame};
use encoring_words::word::{In, Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, ErrorStatus, InWord, Instant, OutWord, Parameter, ParameterSet, Service};

use crate::handshake::Handshake;
use crate::parameters::{Parameters, TakenOver};
use crate::position::{Offset, Scale, found_at_power_up};
use crate::preset_input::PresetInput;
use crate::records::{self, Record, TurnCount};
use crate::ssi_output::SsiOutput;
use crate::unit::Unit;

/// Whether the LA-66's magnet is over the rod at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Magnet {
    /// It is; its place may still lie beyond the rod's ends.
    #[default]
    Present,
    /// It has been taken away.
    Missing,
}

/// What an encoder senses of the world at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Terminals {
    /// Rotary: the shaft in sensor steps, clockwise positive, unwrapped. Linear: the magnet in micrometres from
    /// the start of the rod. Within +-2^62; a shaft that travels farther than 2^63 steps in all wraps.
    pub raw: i64,
    /// The magnet of the LA-66; the others have none.
    pub magnet: Magnet,
    /// The preset inputs in millivolts.
    pub preset_mv: [u32; 2],
}

/// An encoder with its supply on.
#[derive(Clone, Debug)]
pub struct Encoder {
    unit: Unit,
    now: Instant,
    powered_up: Instant,
    /// The next multiple of the refresh time since power-up.
    next_sample: Instant,
    /// Shaft: what must be added to the sensor's value to count all turns.
    epoch: i64,
    /// Shaft: counted steps. Rod: the last good place of the magnet since power-up, 0 before.
    sample: i64,
    magnet_missing: bool,
    handshake: Handshake,
    parameters: Parameters,
    offset: Offset,
    scale: Scale,
    /// The position of `sample` under `scale`.
    position: u32,
    errors: Errors,
    preset_inputs: [PresetInput; 2],
    ssi: SsiOutput,
}

/// Bit 29 and what the next data check will tell of it.
#[derive(Clone, Copy, Debug, Default)]
struct Errors {
    pending: bool,
    latched: ErrorStatus,
}

impl Errors {
    fn raise(&mut self, status: ErrorStatus) {
        self.pending = true;
        self.latched |= status;
    }
}

impl Encoder {
    /// Switches the supply on and takes the first sample.
    #[must_use]
    pub fn power_up(unit: &Unit, now: Instant, terminals: &Terminals, memory: &mut impl Storage) -> Self {
        let (parameters, mut faults, taken_over) = Parameters::power_up(unit, memory);
        let offset = records::read(memory, Record::Offset).unwrap_or_else(|records::Lost| {
            faults |= ErrorStatus::READING_DATA;
            Offset::NONE
        });
        let epoch = match unit.sensor() {
            Sensor::Linear { .. } => 0,
            Sensor::Rotary { steps_per_turn } => {
                let TurnCount(last) =
                    records::read(memory, Record::TurnCount).unwrap_or_else(|records::Lost| {
                        faults |= ErrorStatus::READING_DATA;
                        TurnCount(None)
                    });
                found_at_power_up(terminals.raw, last, steps_per_turn, unit.zero_loss)
                    .wrapping_sub(terminals.raw)
            }
        };
        let mut errors = Errors::default();
        if !faults.is_empty() {
            errors.raise(faults);
        }
        errors.pending |= taken_over == TakenOver::No;
        let scale = Scale::new(unit.sensor(), parameters.active(), offset);
        let mut encoder = Self {
            unit: *unit,
            now,
            powered_up: now,
            next_sample: now,
            epoch,
            sample: 0,
            magnet_missing: false,
            handshake: Handshake::power_up(unit.stale_service),
            parameters,
            offset,
            scale,
            position: scale.position(0),
            errors,
            preset_inputs: [PresetInput::POWER_UP; 2],
            ssi: SsiOutput::POWER_UP,
        };
        encoder.look(now, terminals);
        encoder
    }

    /// One bus cycle: takes the OUT word and gives the IN word. A time before the last one told counts as that one.
    pub fn exchange(
        &mut self,
        now: Instant,
        out: OutWord,
        terminals: &Terminals,
        memory: &mut impl Storage,
    ) -> InWord {
        self.request(now, out, terminals);
        self.work(terminals, memory);
        self.answer()
    }

    /// First part of an exchange: sample, magnet, OUT word.
    pub fn request(&mut self, now: Instant, out: OutWord, terminals: &Terminals) {
        self.look(now, terminals);
        let times = self.unit.service_times;
        self.handshake.request(self.now, out, |request| match request.decode() {
            Out::Request(fields) => times.of(known(fields.service), fields.access),
            Out::Normal(_) => times.read,
        });
    }

    /// Second part of an exchange: the service that is due, and the preset inputs. Only here is the memory written.
    pub fn work(&mut self, terminals: &Terminals, memory: &mut impl Storage) {
        if let Some(request) = self.handshake.due(self.now)
            && let Out::Request(fields) = request.decode()
        {
            let reply = self.serve(fields, memory);
            self.handshake.complete(reply);
        }
        let service_mode = self.handshake.is_service_mode();
        for (number, service) in self.unit.model().preset_inputs().iter().enumerate() {
            let millivolts = terminals.preset_mv.get(number).copied().unwrap_or(0);
            let input = self.preset_inputs.get_mut(number);
            if input.is_some_and(|input| input.exchange(self.now, millivolts, service_mode))
                && let Some(parameter) = Parameter::from_service(*service)
            {
                self.adjust(self.parameters.active().value(parameter), memory);
            }
        }
    }

    /// Last part of an exchange: the IN word.
    #[must_use]
    pub fn answer(&self) -> InWord {
        self.handshake.reply().unwrap_or_else(|| {
            let shown = self.parameters.active().counting_direction().code.encode(self.position);
            InWord::position(shown, self.errors.pending)
        })
    }

    /// Switches the supply off: the reserve in the device lasts for writing the turn count.
    pub fn power_off(self, memory: &mut impl Storage) {
        if matches!(self.unit.sensor(), Sensor::Rotary { .. }) {
            // Nobody is left to report a fault to; the next power-up finds the older count.
            let _ = records::write(memory, Record::TurnCount, &TurnCount(Some(self.sample)));
        }
    }

    /// An edge of the SSI clock; gives the level of Data+. A model without the output stays Low.
    pub fn ssi_clock(&mut self, now: Instant, clock: Level, terminals: &Terminals) -> Level {
        if !self.unit.model().has_ssi_output() {
            return Level::Low;
        }
        self.look(now, terminals);
        let (position, format) = (self.position, self.ssi_format());
        self.ssi.clock(self.now, clock, || SsiFrame::new(position, format))
    }

    /// The level of Data+ at `now`, and when it will change without a clock edge.
    #[must_use]
    pub fn ssi_level(&self, now: Instant) -> (Level, Option<Instant>) {
        if self.unit.model().has_ssi_output() {
            self.ssi.level(self.now.max(now))
        } else {
            (Level::Low, None)
        }
    }

    /// How the SSI's bits are laid out from the next transfer on: as the active set says, and the firmware can.
    #[must_use]
    pub const fn ssi_format(&self) -> SsiFormat {
        SsiFormat::new(self.parameters.active().ssi_values(), self.unit.firmware)
    }

    /// The last multiple of the refresh time since power-up that is not after `now`: the moment whose shaft the
    /// encoder would show in an exchange at `now`.
    #[must_use]
    pub fn refreshed_at(&self, now: Instant) -> Instant {
        let refresh = self.unit.model().refresh().as_nanos();
        // No model looks without a pause; one that did would look now.
        let since = now.since(self.powered_up).as_nanos().checked_rem(refresh).unwrap_or_default();
        Instant(now.as_nanos().saturating_sub(since))
    }

    /// What it was built as.
    #[must_use]
    pub const fn unit(&self) -> &Unit {
        &self.unit
    }

    /// Its parameter sets.
    #[must_use]
    pub const fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// Where the handshake stands.
    #[must_use]
    pub const fn handshake(&self) -> &Handshake {
        &self.handshake
    }

    /// The position of the present sample in binary code, whatever the IN word shows.
    #[must_use]
    pub const fn position(&self) -> u32 {
        self.position
    }

    /// How far presets have moved the positions, in steps: see [`Scale::preset_shift`].
    #[must_use]
    pub const fn preset_shift(&self) -> i64 {
        self.scale.preset_shift()
    }

    /// Bit 29 as normal mode shows it.
    #[must_use]
    pub const fn error_pending(&self) -> bool {
        self.errors.pending
    }

    /// The latched status bits that the next data check will report, without those of the programmed values.
    #[must_use]
    pub fn latched_status(&self) -> ErrorStatus {
        self.errors.latched & self.unit.model().status_mask()
    }

    /// Takes the time, and with it the sample and the magnet if a refresh has come.
    fn look(&mut self, now: Instant, terminals: &Terminals) {
        self.now = self.now.max(now);
        let refreshed = self.now >= self.next_sample;
        if refreshed {
            let refresh = self.unit.model().refresh();
            let next = self.next_sample + refresh;
            // Only after a pause is there more than one multiple to step over.
            self.next_sample = if self.now < next { next } else { self.refreshed_at(self.now) + refresh };
        }
        match self.unit.sensor() {
            Sensor::Rotary { .. } => {
                if refreshed {
                    self.move_to(terminals.raw.wrapping_add(self.epoch));
                }
            }
            Sensor::Linear { rod_um } => {
                let on_rod = (0..=i64::from(rod_um)).contains(&terminals.raw);
                self.magnet_missing = terminals.magnet == Magnet::Missing || !on_rod;
                if self.magnet_missing {
                    self.errors.raise(ErrorStatus::OUTSIDE_RANGE);
                } else if refreshed {
                    self.move_to(terminals.raw);
                }
            }
        }
    }

    fn move_to(&mut self, sample: i64) {
        if sample != self.sample {
            self.sample = sample;
            self.position = self.scale.position(sample);
        }
    }

    /// Does what was requested, all of it in this exchange, and forms the reply.
    fn serve(&mut self, request: ServiceFields, memory: &mut impl Storage) -> InWord {
        let ServiceFields { access, service, data, .. } = request;
        let listed = self.unit.model().admits(service, access);
        let answer = listed.and_then(|listed| self.carry_out(listed, access, data, memory));
        let answer = answer.unwrap_or_else(|status| {
            self.errors.raise(status);
            0
        });
        InWord::from(In::Reply(ServiceFields {
            access,
            error: self.errors.pending,
            reserve: false,
            service,
            data: match access {
                Access::Read => answer,
                Access::Write => data,
            },
        }))
    }

    /// Does what the model admits; gives the data of a read.
    fn carry_out(
        &mut self,
        listed: &Listed,
        access: Access,
        data: u32,
        memory: &mut impl Storage,
    ) -> Result<u32, ErrorStatus> {
        match (listed.service, Parameter::from_service(listed.service), access) {
            (Service::DataCheck, ..) => Ok(u32::from(self.check(memory).bits())),
            // No value of its own: the preset adjustment.
            (_, None, _) => {
                if data > listed.takes.largest(self.parameters.active().measuring_length()) {
                    return Err(ErrorStatus::WRITING_DATA);
                }
                self.adjust(data, memory);
                Ok(data)
            }
            (_, Some(parameter), Access::Read) => {
                self.parameters.read(parameter, memory).ok_or(ErrorStatus::READING_DATA)
            }
            (_, Some(parameter), Access::Write) => self.program(parameter, listed.takes, data, memory),
        }
    }

    fn program(
        &mut self,
        parameter: Parameter,
        takes: Takes,
        data: u32,
        memory: &mut impl Storage,
    ) -> Result<u32, ErrorStatus> {
        let refused = ErrorStatus::WRITING_DATA;
        let value = takes.normalise(data).map_err(|_| refused)?;
        self.parameters.program(parameter, value, memory).map_err(|records::NotStored| refused)?;
        let invalid = takes.invalid(value);
        if !invalid.is_empty() {
            // Stored all the same, and latched, so that a data check can name the error even if the value was put
            // right before it [R82, C6].
            self.errors.raise(invalid);
        }
        self.rescale();
        Ok(value)
    }

    /// The data check: tells and clears what is latched, and takes the programmed set over if it is valid [C23, C38].
    fn check(&mut self, memory: &mut impl Storage) -> ErrorStatus {
        let validity = self.parameters.validity();
        let mut status = self.errors.latched | validity;
        self.errors.latched =
            if self.magnet_missing { ErrorStatus::OUTSIDE_RANGE } else { ErrorStatus::empty() };
        self.errors.pending = !validity.is_empty() || self.magnet_missing;
        if validity.is_empty() {
            match self.parameters.accept(memory) {
                Ok(()) => self.rescale(),
                Err(records::NotStored) => {
                    status |= ErrorStatus::WRITING_DATA;
                    self.errors.pending = true;
                }
            }
        }
        status & self.unit.model().status_mask()
    }

    /// Makes the present sample show `value`; if the offset cannot be stored, the old one stays.
    fn adjust(&mut self, value: u32, memory: &mut impl Storage) {
        let offset = self.scale.preset(self.sample, value);
        match records::write(memory, Record::Offset, &offset) {
            Ok(()) => {
                self.offset = offset;
                self.rescale();
            }
            Err(records::NotStored) => self.errors.raise(ErrorStatus::WRITING_DATA),
        }
    }

    fn rescale(&mut self) {
        self.scale = Scale::new(self.unit.sensor(), self.parameters.active(), self.offset);
        self.position = self.scale.position(self.sample);
    }

    /// The set that the position is computed with.
    #[must_use]
    pub const fn active(&self) -> &ParameterSet {
        self.parameters.active()
    }
}

const fn known(service: ServiceNumber) -> Option<Service> {
    match service {
        ServiceNumber::Known(service) => Some(service),
        ServiceNumber::Unknown(_) => None,
    }
}
