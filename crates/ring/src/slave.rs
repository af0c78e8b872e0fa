//! The protocol chip of a device: a piece of the ring's shift register with a receiver, a sender and a switch [R6].
//!
//! [`Slave::clock`] is the whole chip: one line bit in, one line bit out, and now and then a strobe for the device
//! behind it. It is total: there is no line that it does not follow. [`Slave::regenerate`] is the same without the
//! delay of [A4] and many bits at a time; a ring that moves all its delay to the master's end uses that.

use encoring_words::{Duration, OutWord};

use crate::crc::Crc;
use crate::frame::{Control, EndWord, Outgoing, bad};
use crate::ident::Ident;
use crate::profile::{
    BUS_ACTIVE_FOR, DEVICE_BYTES_MAX, DEVICE_DELAY_BITS, END_GOOD, END_LATE, END_UNTOLD, IDLE, MESSAGE_CRC,
    MESSAGE_MODULE, MESSAGE_RECONFIGURE, RESET_AFTER, TELEGRAM_BITS,
};
use crate::sound_slot::{SoundSlot, copy};
use crate::telegram::{Bits, CLOSING_BITS, CycleKind, Decoder, Part, Pause, Step, byte_of};

mod register;
mod taken;

use register::Register;
use taken::Holding;

pub use taken::Taken;

/// What a chip tells the device behind it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strobe {
    /// Nothing.
    None,
    /// The IN data have just been loaded; what comes later goes with the next cycle.
    Load,
    /// New OUT data have just been taken.
    Latch,
}

/// The jumper in the outgoing plug that says that there is a next device [R137, C33].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Jumper {
    /// The outgoing bus can be switched on.
    #[default]
    Closed,
    /// It cannot.
    Open,
}

/// Whether the chip works at all.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Condition {
    /// It does.
    #[default]
    Running,
    /// It has no supply.
    Off,
    /// Its reset input is held: as without supply, but the lamp U is on.
    Held,
}

/// The lamps of a device [R139].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lamps {
    /// U, green: supply.
    pub u: bool,
    /// BA, green: a data cycle was taken in the last 640 ms.
    pub ba: bool,
    /// RC, green: the incoming bus is connected and not in reset.
    pub rc: bool,
    /// RD, red: the outgoing bus is switched off.
    pub rd: bool,
}

/// What a chip is in the middle of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Nothing: it has no supply.
    Off,
    /// Nothing: its reset input is held.
    Held,
    /// Nothing: the line is dead, or was never heard.
    Reset,
    /// It hears no telegram that it could follow.
    Lost,
    /// Status telegrams.
    Pause,
    /// Loopback word and identification words of an ID cycle.
    Identification,
    /// Loopback word and data of a data cycle.
    Data,
    /// The check word.
    Check,
    /// The end word.
    End,
}

/// A protocol chip.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slave {
    ident: Ident,
    jumper: Jumper,
    condition: Condition,
    messages: u16,
    decoder: Decoder,
    outgoing: Outgoing,
    /// The place that the master told, once it has.
    position: Option<u16>,
    /// The line was silent for too long, or never heard.
    in_reset: bool,
    /// As at the beginning while none passes.
    frame: Frame,
    register: Register,
    input: [u8; DEVICE_BYTES_MAX],
    latched: [u8; DEVICE_BYTES_MAX],
    /// The beginning of `latched`, as encoders read it.
    holding: Holding,
    times: Times,
    /// The last bits sent, still inside of the chip.
    pipe: u8,
}

/// Times in line bits since the chip was made.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Times {
    now: u64,
    heard: u64,
    taken: Option<u64>,
    reset_after: u64,
    active_for: u64,
}

/// What a chip knows of the frame that passes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Frame {
    received: Crc,
    sent: Crc,
    check_word: u16,
    end_word: u16,
    sending: Sending,
}

/// The byte that is being sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Sending {
    /// What is received, bit by bit.
    #[default]
    Copy,
    Byte(u8),
}

impl Slave {
    /// A chip that shows this identification word, on a line with bits of this length. It has as many bytes as the
    /// length code says; none if that is reserved or less than a byte.
    #[must_use]
    pub fn new(ident: Ident, bit: Duration) -> Self {
        let bits = |time: Duration| time.as_nanos().checked_div(bit.as_nanos()).unwrap_or(u64::MAX);
        Self {
            ident: ident.identity(),
            jumper: Jumper::Closed,
            condition: Condition::Running,
            messages: 0,
            decoder: Decoder::default(),
            outgoing: Outgoing::Off,
            position: None,
            in_reset: true,
            frame: Frame::default(),
            register: Register::EMPTY,
            input: [0; DEVICE_BYTES_MAX],
            latched: [0; DEVICE_BYTES_MAX],
            holding: Holding::default(),
            times: Times {
                now: 0,
                heard: 0,
                taken: None,
                reset_after: bits(RESET_AFTER),
                active_for: bits(BUS_ACTIVE_FOR),
            },
            pipe: 0b11,
        }
    }

    /// One bit of the incoming line; the bit of the outgoing line, and what the device should know.
    pub fn clock(&mut self, rx: bool) -> (bool, Strobe) {
        let (tx, strobe) = self.step(rx);
        self.pipe = self.pipe << 1 | u8::from(tx);
        (self.pipe >> DEVICE_DELAY_BITS & 1 != 0, strobe)
    }

    /// Some bits of the incoming line; the same number for the outgoing line, which [`Slave::clock`] would give
    /// [`DEVICE_DELAY_BITS`] later.
    pub fn regenerate(&mut self, line: Bits) -> Bits {
        let telegram = line.bits as u16;
        if self.condition == Condition::Running
            && line.count == TELEGRAM_BITS as u32
            && self.decoder.data(telegram)
        {
            return Bits::telegram(self.telegram(telegram, Part::Data, false));
        }
        self.regenerate_others(line)
    }

    /// What is not one more byte of the data. Most telegrams are, and need none of what this sets up.
    #[inline(never)]
    fn regenerate_others(&mut self, line: Bits) -> Bits {
        if self.condition != Condition::Running {
            self.pass_time(line.count);
            return Bits::idle(line.count);
        }
        if line.count == TELEGRAM_BITS as u32
            && let Some((part, opens)) = self.decoder.telegram(line.bits as u16)
        {
            return Bits::telegram(self.telegram(line.bits as u16, part, opens));
        }
        if let Some(pause) = self.decoder.pause(line) {
            match pause {
                Pause::Silence => {
                    self.pass_time(line.count);
                    self.look_for_silence(line.count);
                }
                Pause::Statuses => {
                    self.pass_time(line.count);
                    self.hear();
                }
                Pause::Closing => {
                    self.pass_time(CLOSING_BITS);
                    self.close();
                    self.pass_time(line.count - CLOSING_BITS);
                    self.hear();
                }
            }
            return line;
        }
        let mut sent = 0;
        for k in (0..line.count.min(64)).rev() {
            let (tx, _) = self.step(line.bits >> k & 1 != 0);
            sent = sent << 1 | u64::from(tx);
        }
        Bits { bits: sent, count: line.count }
    }

    /// One bit, without the delay.
    fn step(&mut self, rx: bool) -> (bool, Strobe) {
        self.pass_time(1);
        if self.condition != Condition::Running {
            return (IDLE, Strobe::None);
        }
        match self.decoder.clock(rx) {
            Step::Quiet => {
                self.look_for_silence(1);
                (IDLE, Strobe::None)
            }
            Step::Broken => {
                self.note_bad();
                (IDLE, Strobe::None)
            }
            Step::Header => (rx, Strobe::None),
            Step::Opens(cycle) => (rx, self.open(cycle)),
            Step::Closes => (rx, self.close()),
            Step::Status => {
                self.hear();
                (rx, Strobe::None)
            }
            Step::Data(part, bit) => {
                if bit == 0 {
                    self.frame.sending = self.sends(part, rx);
                }
                let tx = match self.frame.sending {
                    Sending::Copy => rx,
                    Sending::Byte(byte) => byte << bit & 0x80 != 0,
                };
                (tx, Strobe::None)
            }
            Step::Ends(part, byte) => {
                self.pass(part, byte);
                if part != Part::EndLow {
                    if !self.decoder.is_framed() {
                        self.note_bad();
                    }
                    return (true, Strobe::None);
                }
                if !rx {
                    self.note_bad();
                }
                (self.ends_with_stop(rx), Strobe::None)
            }
        }
    }

    /// A whole sound telegram, without the delay. It and what it calls are inlined, so that a byte of the data, which
    /// most are, chooses no part of the frame.
    #[inline(always)]
    fn telegram(&mut self, telegram: u16, part: Part, opens: bool) -> u16 {
        self.pass_time(TELEGRAM_BITS as u32);
        if opens {
            self.open(self.decoder.cycle());
        }
        let byte = byte_of(telegram);
        self.frame.sending = self.sends(part, byte & 0x80 != 0);
        let sent = self.pass(part, byte);
        let stop = part != Part::EndLow || self.ends_with_stop(true);
        telegram & !(0xFF << 1 | 1) | u16::from(sent) << 1 | u16::from(stop)
    }

    /// The stop bit of an end word. Nothing can be sent after it, so it goes on as it came, and not as a stop bit at all
    /// if the end word turned out to be none.
    fn ends_with_stop(&self, rx: bool) -> bool {
        match self.frame.sending {
            Sending::Byte(byte) => byte != END_LATE,
            Sending::Copy => rx && EndWord::decode(self.frame.end_word) != EndWord::Unknown,
        }
    }

    /// A frame begins: what the device shows is loaded.
    fn open(&mut self, cycle: CycleKind) -> Strobe {
        self.frame = Frame::default();
        match cycle {
            CycleKind::Id => {
                let word = self.identification().0;
                self.register.load(&word.to_be_bytes());
                Strobe::None
            }
            CycleKind::Data => {
                // The message of a bad cycle tells of the last data cycle, and of no earlier one.
                self.messages &= !MESSAGE_CRC;
                let length = self.bytes();
                self.register.load(self.input.get(..length).unwrap_or_default());
                Strobe::Load
            }
        }
    }

    /// What the chip sends in a telegram whose first data bit is `first`.
    #[inline(always)]
    fn sends(&self, part: Part, first: bool) -> Sending {
        let own = || self.position.map_or(END_UNTOLD, bad);
        match part {
            Part::Data => self.register.oldest().map_or(Sending::Copy, Sending::Byte),
            Part::CheckHigh => Sending::Byte((self.frame.sent.word() >> 8) as u8),
            Part::CheckLow => Sending::Byte(self.frame.sent.word() as u8),
            // The predecessor's verdict stands, if it has one: its segment comes first.
            Part::EndHigh if !first && self.is_segment_bad() => Sending::Byte((own() >> 8) as u8),
            Part::EndHigh => Sending::Copy,
            Part::EndLow => match (self.frame.sending, self.frame.end_word) {
                (Sending::Byte(_), _) => Sending::Byte(own() as u8),
                (Sending::Copy, END_GOOD) if !self.is_segment_bad() => Sending::Copy,
                (Sending::Copy, high) if high & 0x80 != 0 => Sending::Copy,
                // Turned bad since, or hit: a second hit behind this chip must not make it good again.
                (Sending::Copy, _) => Sending::Byte(END_LATE),
            },
        }
    }

    /// The end of a telegram; the byte that was sent in it.
    #[inline(always)]
    fn pass(&mut self, part: Part, byte: u8) -> u8 {
        let sent = match self.frame.sending {
            Sending::Copy => byte,
            Sending::Byte(sent) => sent,
        };
        let Frame { received, sent: outgoing, check_word, end_word, .. } = &mut self.frame;
        match part {
            Part::Data => {
                received.push(byte);
                outgoing.push(sent);
                self.register.shift(byte);
            }
            Part::CheckHigh | Part::CheckLow => *check_word = *check_word << 8 | u16::from(byte),
            Part::EndHigh | Part::EndLow => *end_word = *end_word << 8 | u16::from(byte),
        }
        if !self.decoder.is_bad() {
            self.hear();
        }
        sent
    }

    /// The frame is over. What it brought is taken, if every segment so far was good.
    fn close(&mut self) -> Strobe {
        let register = core::mem::replace(&mut self.register, Register::EMPTY);
        let strobe = self.judge(&register);
        self.frame = Frame::default();
        strobe
    }

    fn judge(&mut self, register: &Register) -> Strobe {
        if self.is_segment_bad() || self.frame.end_word != END_GOOD {
            self.note_bad();
            return Strobe::None;
        }
        match self.decoder.cycle() {
            CycleKind::Id => {
                let mut word = [0; 2];
                for (place, byte) in word.iter_mut().zip(register.bytes()) {
                    *place = byte;
                }
                self.obey(Control(u16::from_be_bytes(word)));
                Strobe::None
            }
            // A device that was reset since takes nothing before it has its place.
            CycleKind::Data if self.position.is_none() => Strobe::None,
            CycleKind::Data => {
                for (place, byte) in self.latched.iter_mut().zip(register.bytes()) {
                    *place = byte;
                }
                self.latch(self.times.now);
                Strobe::Latch
            }
        }
    }

    /// OUT data are there since this time.
    fn latch(&mut self, at: u64) {
        // A device with fewer bytes is no encoder.
        let word = self.latched().first_chunk().map_or(0, |bytes| u32::from_be_bytes(*bytes));
        self.holding.change(Taken { word: Some(OutWord(word)), ..self.taken() }, at);
        self.times.taken = Some(at);
    }

    fn obey(&mut self, control: Control) {
        if control.resets() {
            self.reset(self.times.now);
            return;
        }
        self.position = Some(control.position());
        self.outgoing = match self.jumper {
            Jumper::Closed => control.outgoing(),
            Jumper::Open => Outgoing::Off,
        };
    }

    /// Header and stop bits, and the check word once it is here.
    fn is_segment_bad(&self) -> bool {
        self.decoder.is_bad() || self.frame.check_word != self.frame.received.word()
    }

    fn note_bad(&mut self) {
        self.messages |= MESSAGE_CRC;
    }

    /// A sound telegram came. One status telegram alone may be noise on a dead line.
    fn hear(&mut self) {
        if !self.decoder.is_in_step() {
            return;
        }
        self.times.heard = self.times.now;
        self.in_reset = false;
    }

    fn pass_time(&mut self, bits: u32) {
        self.times.now = self.times.now.saturating_add(u64::from(bits));
    }

    /// Looks at so many bits of silence.
    fn look_for_silence(&mut self, bits: u32) {
        let Times { now, heard, reset_after, .. } = self.times;
        if !self.in_reset && now - heard > reset_after {
            // The first of these bits that was too much.
            let at = now.saturating_sub(u64::from(bits)).max(heard + reset_after).saturating_add(1);
            self.reset(at.min(now));
        }
    }

    fn reset(&mut self, at: u64) {
        self.in_reset = true;
        self.outgoing = Outgoing::Off;
        self.position = None;
        self.latched = [0; DEVICE_BYTES_MAX];
        self.holding.change(self.taken().reset(), at);
        self.messages &= !MESSAGE_CRC;
    }

    /// Whether a data cycle on sound lines would pass it as the master means it: it follows the line, has its place and
    /// so many bytes, and its switch is as it is to be. A chip that does not work follows no line, and one that has its
    /// place is not in reset.
    pub(crate) fn is_sound(&self, bytes: usize, outgoing: Outgoing) -> bool {
        self.decoder.is_ready()
            && self.position.is_some()
            && self.bytes() == bytes
            && self.outgoing == outgoing
    }

    /// What the bits of a sound slot would do, at once: it takes `out`, and shows its own bytes in `input`.
    pub(crate) fn take(&mut self, slot: &SoundSlot, out: &[u8], input: &mut [u8]) {
        let began = self.times.now;
        let closed = began.saturating_add(slot.frame + u64::from(CLOSING_BITS));
        let ended = began.saturating_add(slot.bits);
        self.messages &= !MESSAGE_CRC;
        self.decoder = slot.decoder;
        // Of a frame that was lost before.
        self.frame = Frame::default();
        self.register = Register::EMPTY;
        copy(out, &mut self.latched);
        self.latch(closed);
        self.times.now = ended;
        self.times.heard = ended;
        copy(&self.input, input);
    }

    /// What it shows in an ID cycle.
    #[must_use]
    pub const fn identification(&self) -> Ident {
        Ident(self.ident.0 | self.messages)
    }

    /// Makes it show another identification word, with another length.
    pub const fn set_ident(&mut self, ident: Ident) {
        self.ident = ident.identity();
    }

    /// The bytes of its register.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.ident.bytes().unwrap_or_default()
    }

    /// Gives it the IN data to be loaded at the start of the next cycle; what is missing stays.
    pub fn load(&mut self, bytes: &[u8]) {
        copy(bytes, &mut self.input);
    }

    /// The OUT data taken last; zeros before the first and in reset.
    #[must_use]
    pub fn latched(&self) -> &[u8] {
        self.latched.get(..self.bytes()).unwrap_or_default()
    }

    /// Whether the jumper of its outgoing plug is there.
    #[must_use]
    pub const fn jumper(&self) -> Jumper {
        self.jumper
    }

    /// Opens or closes the jumper of its outgoing plug.
    pub fn set_jumper(&mut self, jumper: Jumper) {
        self.jumper = jumper;
        if jumper == Jumper::Open {
            self.outgoing = Outgoing::Off;
        }
    }

    /// Says whether it works. While it does not it forgets everything; only the plugs stay.
    pub fn set_condition(&mut self, condition: Condition) {
        if condition != Condition::Running {
            self.reset(self.times.now);
            self.decoder = Decoder::default();
            self.times.taken = None;
            self.input = [0; DEVICE_BYTES_MAX];
            self.pipe = 0b11;
        }
        self.condition = condition;
    }

    /// Whether it works.
    #[must_use]
    pub const fn condition(&self) -> Condition {
        self.condition
    }

    /// The module behind the chip has a fault, or has it no longer. For modules other than encoders, which have none to
    /// tell; the master's services at run time will answer it.
    pub const fn set_module_fault(&mut self, fault: ModuleFault) {
        match fault {
            ModuleFault::None => self.messages &= !MESSAGE_MODULE,
            ModuleFault::Present => self.messages |= MESSAGE_MODULE,
        }
    }

    /// The device asks to be configured anew, from now on. No encoder does; the master's services at run time will answer
    /// it.
    pub const fn request_reconfiguration(&mut self) {
        self.messages |= MESSAGE_RECONFIGURE;
    }

    /// Its switch towards the next device.
    #[must_use]
    pub const fn outgoing(&self) -> Outgoing {
        self.outgoing
    }

    /// The place that the master told it; `None` since its last reset.
    #[must_use]
    pub const fn position(&self) -> Option<u16> {
        self.position
    }

    /// The OUT word that it has taken, and how often it was reset.
    #[must_use]
    pub const fn taken(&self) -> Taken {
        self.holding.now()
    }

    /// The same so many line bits ago. What it held before the last change but one is forgotten.
    #[must_use]
    pub const fn taken_before(&self, bits: u64) -> Taken {
        self.holding.after(self.times.now.saturating_sub(bits))
    }

    /// What it is in the middle of.
    #[must_use]
    pub fn phase(&self) -> Phase {
        match (self.condition, self.decoder.passing(), self.decoder.cycle()) {
            (Condition::Off, _, _) => Phase::Off,
            (Condition::Held, _, _) => Phase::Held,
            (Condition::Running, Some(Part::Data), CycleKind::Id) => Phase::Identification,
            (Condition::Running, Some(Part::Data), CycleKind::Data) => Phase::Data,
            (Condition::Running, Some(Part::CheckHigh | Part::CheckLow), _) => Phase::Check,
            (Condition::Running, Some(Part::EndHigh | Part::EndLow), _) => Phase::End,
            (Condition::Running, None, _) if self.in_reset => Phase::Reset,
            (Condition::Running, None, _) if self.decoder.is_in_step() => Phase::Pause,
            (Condition::Running, None, _) => Phase::Lost,
        }
    }

    /// Line bits since the last sound telegram, and since OUT data were taken.
    #[must_use]
    pub fn ages(&self) -> (u64, Option<u64>) {
        let Times { now, heard, taken, .. } = self.times;
        (now - heard, taken.map(|at| now - at))
    }

    /// Its lamps.
    #[must_use]
    pub fn lamps(&self) -> Lamps {
        let u = self.condition != Condition::Off;
        let active = self.ages().1.is_some_and(|age| age <= self.times.active_for);
        Lamps { u, ba: u && active, rc: u && !self.in_reset, rd: u && self.outgoing == Outgoing::Off }
    }
}

/// Whether the module behind a chip has a fault.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ModuleFault {
    /// None.
    #[default]
    None,
    /// It has.
    Present,
}
