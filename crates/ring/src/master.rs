//! The master: it opens the ring device by device, runs data cycles, repeats what was faulty, and looks for the place
//! of what stays so.
//!
//! It works a slot at a time: [`Master::begin`] chooses what the slot is for, [`Master::transmit`] gives the telegrams
//! of a frame, [`Master::receive`] takes what comes home, and [`Master::end`] judges it and chooses what comes next.

use encoring_words::Duration;

use crate::diagnostics::{Counts, FaultPlace, PERIPHERAL_FAULT, SEARCHING, status};
use crate::frame::{Control, Outgoing};
use crate::ident::Ident;
use crate::profile::{
    DATA_BYTES_MAX, DEVICES_MAX, ID_TRIES, LOOPBACK, MESSAGE_CRC, MESSAGE_MODULE, SILENCE, STOP_AFTER,
};
use crate::sound_slot::SoundSlot;
use crate::telegram::{Bits, CycleKind};

mod configuration;
mod line;

use configuration::Table;
use line::{Home, Receiver, Sender};

pub use configuration::ConfigurationError;

/// What the master does, as its controller sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// It works, and the line is silent or the ring is being opened.
    Ready,
    /// The configuration is known, and ID cycles run.
    Active,
    /// Data cycles run.
    Run,
}

/// What the master does when it has found a break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WhenBroken {
    /// It looks again and again, until the ring is whole.
    #[default]
    Wait,
    /// It runs on with the devices before the break, until it is activated anew. To be chosen with the master's services
    /// at run time, which are not here yet.
    RunOn,
}

/// A command that does not fit the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not possible while the ring is {state:?}")]
pub struct WrongState {
    /// What the master does.
    pub state: State,
}

/// What a slot is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Job {
    /// Nothing: the line is silent.
    Rest,
    /// The line is silent until every device is in reset.
    Silence { left: u64, why: Why },
    /// An ID cycle that looks for one device more, so often in vain: nobody answered, or what came home was bad.
    Open { missing: u8, faulty: u8, why: Why },
    /// An ID cycle of the whole ring, because data cycles are not wanted.
    Identify,
    /// An ID cycle that asks who saw the last data cycle go bad.
    Locate,
    /// A data cycle.
    Data,
}

/// Why the ring is reset and opened device by device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Why {
    /// The master was activated.
    Activated,
    /// The bus stopped, and the place of its fault is looked for.
    Search,
}

/// What a slot puts on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Nothing.
    Silent,
    /// A frame and status telegrams.
    Frame,
}

/// The master of a ring.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Master {
    wanted: State,
    job: Job,
    when_broken: WhenBroken,
    /// What the ring should be, if somebody said so or it was found once.
    configuration: Option<Table>,
    /// What was found so far.
    found: Table,
    /// How many devices take part: all, or those before a break.
    devices: usize,
    out: [u8; DATA_BYTES_MAX],
    input: [u8; DATA_BYTES_MAX],
    sender: Sender,
    receiver: Receiver,
    silence_bits: u64,
    faulty: u8,
    module_fault: bool,
    dc_result: bool,
    place: Option<FaultPlace>,
    /// What a device showed that did not fit, while the place is there.
    other: Option<Ident>,
    counts: Counts,
}

impl Master {
    /// A master that is ready, for bits of this length.
    #[must_use]
    pub fn new(bit: Duration) -> Self {
        Self {
            wanted: State::Ready,
            job: Job::Rest,
            when_broken: WhenBroken::Wait,
            configuration: None,
            found: Table::EMPTY,
            devices: 0,
            out: [0; DATA_BYTES_MAX],
            input: [0; DATA_BYTES_MAX],
            sender: Sender::new(),
            receiver: Receiver::new(),
            silence_bits: SILENCE.as_nanos().checked_div(bit.as_nanos()).unwrap_or_default(),
            faulty: 0,
            module_fault: false,
            dc_result: false,
            place: None,
            other: None,
            counts: Counts::default(),
        }
    }

    /// Says what the ring should be. Without it the master takes what it finds when it is activated.
    ///
    /// # Errors
    /// [`ConfigurationError`]; [`Master::activate`] then finds what it found before.
    pub fn configure(&mut self, idents: &[Ident]) -> Result<(), ConfigurationError> {
        self.configuration = Some(Table::of(idents)?);
        Ok(())
    }

    /// Says what to do when a break is found.
    pub const fn set_when_broken(&mut self, when_broken: WhenBroken) {
        self.when_broken = when_broken;
    }

    /// Resets the ring and opens it device by device. Once it is open ID cycles run.
    pub fn activate(&mut self) {
        self.wanted = State::Active;
        self.place = None;
        self.enter(self.silence(Why::Activated));
    }

    /// Lets data cycles run, as soon as the ring is open.
    ///
    /// # Errors
    /// [`WrongState`] if the master was not activated.
    pub fn start(&mut self) -> Result<(), WrongState> {
        if self.wanted == State::Ready {
            return Err(WrongState { state: self.state() });
        }
        self.wanted = State::Run;
        if self.job == Job::Identify {
            self.enter(Job::Data);
        }
        Ok(())
    }

    /// Lets ID cycles run in place of data cycles. The devices keep what they have taken.
    ///
    /// # Errors
    /// [`WrongState`] if the master does not run.
    pub fn stop(&mut self) -> Result<(), WrongState> {
        if self.wanted != State::Run {
            return Err(WrongState { state: self.state() });
        }
        self.wanted = State::Active;
        if matches!(self.job, Job::Data | Job::Locate) {
            self.enter(Job::Identify);
        }
        Ok(())
    }

    /// Sends nothing any more: every device goes to reset and its outputs to 0.
    pub fn alarm_stop(&mut self) {
        self.wanted = State::Ready;
        self.enter(Job::Rest);
        self.out = [0; DATA_BYTES_MAX];
    }

    /// Ends the ID cycles. One of the master's services at run time: for a controller's board, which is not here yet.
    ///
    /// # Errors
    /// [`WrongState`] while data cycles are wanted.
    pub fn deactivate(&mut self) -> Result<(), WrongState> {
        if self.wanted == State::Run {
            return Err(WrongState { state: self.state() });
        }
        self.alarm_stop();
        Ok(())
    }

    /// What the master does.
    #[must_use]
    pub const fn state(&self) -> State {
        match self.job {
            Job::Rest | Job::Silence { .. } | Job::Open { .. } => State::Ready,
            Job::Identify => State::Active,
            Job::Data | Job::Locate => State::Run,
        }
    }

    /// The devices that take part.
    #[must_use]
    pub const fn devices(&self) -> usize {
        self.devices
    }

    /// What was found at a position when the ring was opened, with the messages of that time left out.
    #[must_use]
    pub fn found(&self, position: usize) -> Option<Ident> {
        self.found.ident(position)
    }

    /// What the device showed that does not fit the configuration, if [`Master::place`] is such a one.
    #[must_use]
    pub fn other(&self) -> Option<Ident> {
        self.other.filter(|_| matches!(self.place, Some(FaultPlace::Device(_))))
    }

    /// `true` from the stop of the bus until the ring is open again.
    #[must_use]
    pub const fn is_searching(&self) -> bool {
        matches!(self.job, Job::Silence { why: Why::Search, .. } | Job::Open { why: Why::Search, .. })
    }

    /// The OUT bytes of a device, to be changed; they go out with the next data cycle.
    pub fn out_mut(&mut self, position: usize) -> &mut [u8] {
        let range = self.table().range(position);
        self.out.get_mut(range).unwrap_or_default()
    }

    /// The IN bytes of a device, of the last good data cycle.
    #[must_use]
    pub fn input(&self, position: usize) -> &[u8] {
        self.input.get(self.table().range(position)).unwrap_or_default()
    }

    /// Where the ring is at fault, as far as that is known.
    #[must_use]
    pub const fn place(&self) -> Option<FaultPlace> {
        self.place
    }

    /// What was counted.
    #[must_use]
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// The diagnostic status register.
    #[must_use]
    pub fn status(&self) -> u16 {
        let state = match self.state() {
            State::Ready => status::READY,
            State::Active => status::READY | status::ACTIVE,
            State::Run => status::READY | status::ACTIVE | status::RUN,
        };
        let broken = self.is_searching() || self.devices < self.table().devices && self.state() == State::Run;
        let when = |condition: bool, bit: u16| if condition { bit } else { 0 };
        state
            | when(self.is_searching(), status::DETECT)
            | when(broken && self.place.is_some(), status::BUS)
            | when(matches!(self.place, Some(FaultPlace::Device(_))), status::USER)
            | when(self.module_fault, status::PF)
            | when(self.dc_result, status::DC_RESULT)
            | when(self.counts.is_poor(), status::QUALITY)
    }

    /// The diagnostic parameter register.
    #[must_use]
    pub fn parameter(&self) -> u16 {
        match self.place {
            Some(place) => place.parameter(self.table().devices),
            None if self.is_searching() => SEARCHING,
            None if self.module_fault => PERIPHERAL_FAULT,
            None => 0,
        }
    }

    /// The table that the image follows.
    const fn table(&self) -> &Table {
        match &self.configuration {
            Some(table) => table,
            None => &self.found,
        }
    }

    /// Begins a slot.
    pub fn begin(&mut self) -> Slot {
        match self.job {
            Job::Rest | Job::Silence { .. } => return Slot::Silent,
            Job::Open { .. } => self.compose_id(self.devices + 1, Outgoing::On),
            Job::Identify | Job::Locate => self.compose_id(self.devices, Outgoing::Off),
            Job::Data => self.compose_data(),
        }
        Slot::Frame
    }

    fn compose_data(&mut self) {
        self.sender.compose(CycleKind::Data);
        // The last device comes first.
        for position in (0..self.devices).rev() {
            let range = self.table().range(position);
            for byte in self.out.get(range).unwrap_or_default() {
                self.sender.byte(*byte);
            }
        }
    }

    /// An ID cycle. `last` is for the outgoing bus of the last device, all others are on; so is the last one's as long
    /// as the ring may go on behind it.
    fn compose_id(&mut self, devices: usize, last: Outgoing) {
        self.sender.compose(CycleKind::Id);
        for position in (0..devices).rev() {
            let is_last = position + 1 == devices;
            let ends_here = is_last && (last == Outgoing::Off || devices >= self.limit());
            let outgoing = if ends_here { Outgoing::Off } else { Outgoing::On };
            self.sender.word(Control::new(position as u16, outgoing).0);
        }
    }

    /// How many devices are looked for.
    fn limit(&self) -> usize {
        match (self.when_broken, self.place, &self.configuration) {
            (WhenBroken::RunOn, Some(FaultPlace::Break(segment)), _) if segment > 0 => segment,
            (_, _, Some(table)) => table.devices,
            (_, _, None) => DEVICES_MAX,
        }
    }

    /// The next telegram of the frame; `None` once it is whole, or broken off because nothing comes home.
    pub fn transmit(&mut self) -> Option<Bits> {
        self.sender.next(self.receiver.is_still(), self.devices)
    }

    /// Takes what came home for a telegram of the frame.
    pub fn receive(&mut self, home: Bits) {
        self.receiver.receive(home);
    }

    /// Takes what came home for a pause.
    pub fn receive_pause(&mut self, home: Bits) {
        self.receiver.pause(home);
    }

    /// Ends a slot of so many bits: judges what came home and chooses what comes next.
    pub fn end(&mut self, bits: u64) -> Ended {
        let ended = self.judge(bits);
        self.sender.clear();
        self.receiver.clear();
        ended
    }

    fn judge(&mut self, bits: u64) -> Ended {
        match self.job {
            Job::Rest => Ended::Idle,
            Job::Silence { left, why } => {
                if left > bits {
                    self.job = Job::Silence { left: left - bits, why };
                } else {
                    self.open_from_front(why);
                }
                Ended::Idle
            }
            Job::Open { missing, faulty, why } => {
                self.end_open(missing, faulty, why);
                Ended::Id
            }
            Job::Identify | Job::Locate => {
                self.end_identify();
                Ended::Id
            }
            Job::Data => self.end_data(),
        }
    }

    /// Goes over to a job, with what its beginning does.
    fn enter(&mut self, job: Job) {
        if let Job::Silence { .. } = job {
            self.counts.searches += u64::from(!self.is_searching());
            self.faulty = 0;
        }
        self.job = job;
    }

    /// The reset of the ring that comes before it is opened.
    const fn silence(&self, why: Why) -> Job {
        Job::Silence { left: self.silence_bits, why }
    }

    fn end_data(&mut self) -> Ended {
        let length = self.sender.length();
        let mut home = self.receiver.judge(CycleKind::Data, length, self.devices);
        // The loopback word comes home last; elsewhere, the ring has another length.
        if home == Home::Good && self.receiver.word_at(length.saturating_sub(2)) != Some(LOOPBACK) {
            home = Home::Bad(None);
        }
        self.dc_result = home != Home::Good;
        match home {
            Home::Good => {
                self.note_good();
                let mut at = 0;
                for position in (0..self.devices).rev() {
                    let range = self.table().range(position);
                    let length = range.len();
                    let from = self.receiver.bytes.get(at..at + length).unwrap_or_default();
                    for (place, byte) in self.input.get_mut(range).unwrap_or_default().iter_mut().zip(from) {
                        *place = *byte;
                    }
                    at += length;
                }
                return Ended::Good;
            }
            Home::Bad(Some(segment)) => {
                self.counts.bad();
                self.counts.located(segment);
                self.place = Some(FaultPlace::Segment(segment));
            }
            Home::Bad(None) => {
                self.counts.without_place();
                self.enter(Job::Locate);
            }
            Home::Silent => self.counts.without_place(),
        }
        self.faulty = self.faulty.saturating_add(1);
        if self.faulty >= STOP_AFTER {
            self.enter(self.silence(Why::Search));
        }
        Ended::Faulty
    }

    /// Nothing was wrong with a data cycle.
    fn note_good(&mut self) {
        self.counts.good();
        self.faulty = 0;
        self.dc_result = false;
        if self.devices == self.table().devices {
            self.place = None;
        }
    }

    /// Whether the coming slot is a data cycle of so many devices, and what comes home could be followed.
    pub(crate) fn is_sound(&self, devices: usize) -> bool {
        // A configuration that came meanwhile may hold fewer.
        let has_all = self.devices == devices && devices <= self.table().devices;
        self.job == Job::Data && has_all && self.receiver.is_ready()
    }

    /// The bytes that its table has for each device, by position.
    pub(crate) fn lengths(&self) -> impl Iterator<Item = usize> {
        self.table().lengths()
    }

    /// The OUT and the IN bytes of each device, by position.
    pub(crate) fn both(&mut self) -> impl Iterator<Item = (&mut [u8], &mut [u8])> {
        let table = self.configuration.as_ref().unwrap_or(&self.found);
        let (mut out, mut input) = (self.out.as_mut_slice(), self.input.as_mut_slice());
        table
            .lengths()
            .map_while(move |length| out.split_off_mut(..length).zip(input.split_off_mut(..length)))
    }

    /// What else the bits of a sound slot would do, at once.
    pub(crate) fn take(&mut self, slot: &SoundSlot) {
        self.receiver.take(slot);
        self.note_good();
    }

    fn end_identify(&mut self) {
        let home = self.receiver.judge(CycleKind::Id, self.sender.length(), self.devices);
        let intact = home == Home::Good && self.receiver.word(self.devices) == Some(LOOPBACK);
        if !intact {
            self.faulty = self.faulty.saturating_add(1);
            if self.faulty >= STOP_AFTER {
                self.enter(self.silence(Why::Search));
            }
            return;
        }
        self.module_fault = false;
        let mut first = None;
        for position in 0..self.devices {
            let ident = self.shown(self.devices - 1 - position);
            self.module_fault |= ident.0 & MESSAGE_MODULE != 0;
            if ident.0 & MESSAGE_CRC != 0 && first.is_none() {
                first = Some(position);
            }
        }
        if self.job == Job::Locate {
            self.enter(Job::Data);
            // If no device saw it, it was on the way home.
            let segment = first.unwrap_or(self.devices);
            self.counts.found(segment);
            self.place = Some(FaultPlace::Segment(segment));
        }
    }

    /// What a device showed in a good ID cycle, by its word: the last device comes first.
    fn shown(&self, word: usize) -> Ident {
        let shown = self.receiver.word(word);
        debug_assert!(shown.is_some(), "a good frame is as long as it was sent, and word {word} was");
        Ident(shown.unwrap_or_default())
    }

    fn open_from_front(&mut self, why: Why) {
        self.found = Table::EMPTY;
        self.devices = 0;
        self.module_fault = false;
        self.open_further(why);
    }

    /// Looks for one device more, if there is to be one.
    fn open_further(&mut self, why: Why) {
        if self.devices >= self.limit() {
            self.opened();
        } else {
            self.enter(Job::Open { missing: 0, faulty: 0, why });
        }
    }

    fn end_open(&mut self, missing: u8, faulty: u8, why: Why) {
        let known = self.devices;
        let devices = known + 1;
        let home = self.receiver.judge(CycleKind::Id, self.sender.length(), devices);
        let ends_at = |words| self.receiver.word(words) == Some(LOOPBACK);
        match home {
            Home::Good if ends_at(devices) => self.take_in(known, why),
            // Nobody is behind the last one, and nobody is expected.
            Home::Good if ends_at(known) && self.configuration.is_none() && known > 0 => {
                self.opened();
            }
            Home::Silent | Home::Good if missing + 1 < ID_TRIES => {
                self.enter(Job::Open { missing: missing + 1, faulty, why });
            }
            Home::Silent | Home::Good => {
                self.fail(if known == 0 { FaultPlace::Nowhere } else { FaultPlace::Break(known) });
            }
            Home::Bad(_) if faulty + 1 < STOP_AFTER => {
                self.enter(Job::Open { missing, faulty: faulty + 1, why });
            }
            Home::Bad(place) => self.fail(match place {
                // What leads home is the same segment however far the ring is open.
                Some(segment) if segment >= devices => FaultPlace::Segment(self.table().devices.max(segment)),
                Some(segment) => FaultPlace::Segment(segment),
                // As far as the ring was open before, it was good.
                None if known > 0 => FaultPlace::Segment(known),
                None => FaultPlace::Nowhere,
            }),
        }
    }

    /// A further device answers.
    fn take_in(&mut self, position: usize, why: Why) {
        let ident = self.shown(0);
        self.module_fault |= ident.0 & MESSAGE_MODULE != 0;
        let expected = self.configuration.as_ref().map(|table| table.ident(position));
        let fits = expected.is_none_or(|expected| expected == Some(ident.identity()));
        if !fits || self.found.push(ident, position + 1).is_err() {
            self.other = Some(ident.identity());
            self.fail(FaultPlace::Device(position));
            return;
        }
        self.devices = position + 1;
        self.open_further(why);
    }

    /// The ring is open as far as it goes.
    fn opened(&mut self) {
        debug_assert!(self.wanted != State::Ready, "who wants nothing opens no ring");
        if self.configuration.is_none() {
            self.configuration = Some(self.found.clone());
        }
        self.enter(match self.wanted {
            State::Run => Job::Data,
            State::Active => Job::Identify,
            State::Ready => Job::Rest,
        });
    }

    /// A place was found at which the ring cannot be opened further.
    fn fail(&mut self, place: FaultPlace) {
        self.place = Some(place);
        if let FaultPlace::Segment(segment) | FaultPlace::Break(segment) = place {
            self.counts.found(segment);
        }
        self.enter(self.silence(Why::Search));
    }
}

/// How a slot ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// The line was silent.
    Idle,
    /// An ID cycle.
    Id,
    /// A data cycle that was good throughout: the IN bytes are new.
    Good,
    /// A data cycle that was not.
    Faulty,
}
