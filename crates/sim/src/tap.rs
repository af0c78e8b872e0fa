//! Looks on while bits go around the ring.

use encoring_ring::Lines;
use encoring_ring::Slave;
use encoring_ring::frame::Outgoing;
use encoring_ring::profile::{DEVICE_DELAY_BITS, IDLE};
use encoring_ring::slave::{Lamps, Phase};
use encoring_ring::telegram::Bits;
use encoring_trace::wave::{Id, Signals, UNIT_NS, Value};
use encoring_words::{Duration, OutWord};

use crate::injector::Segments;

/// The service bit of both words.
const SERVICE: u32 = 1 << 31;

/// The position of a chip that has none.
const NO_POSITION: Value = Value::Unknown;

/// A change that waits for those of other segments that come before it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Change {
    /// In units of time.
    pub(crate) at: u64,
    pub(crate) id: Id,
    pub(crate) value: Value,
}

/// The code of what a chip does.
const fn phase_code(phase: Phase) -> u32 {
    match phase {
        Phase::Off => 0,
        Phase::Held => 1,
        Phase::Reset => 2,
        Phase::Lost => 3,
        Phase::Pause => 4,
        Phase::Identification => 5,
        Phase::Data => 6,
        Phase::Check => 7,
        Phase::End => 8,
    }
}

/// The service bit of an OUT or IN word.
pub(crate) fn service_bit(word: u32) -> Value {
    Value::from(word & SERVICE != 0)
}

/// What an OUT word shows, and its service bit.
pub(crate) fn out_values(OutWord(word): OutWord) -> [Value; 2] {
    [Value::Bits(word), service_bit(word)]
}

/// What was seen on the line since it was taken last. That is what one cycle brings: some changes a line bit and
/// segment at most.
#[derive(Clone, Debug)]
pub(crate) struct Tap {
    /// Units of time of a line bit.
    bit: u64,
    segments: Vec<Segment>,
    chips: Vec<Chip>,
    changes: Vec<Change>,
}

#[derive(Clone, Copy, Debug)]
struct Segment {
    line: Channel,
    hit: Channel,
}

/// A signal of single bits.
#[derive(Clone, Copy, Debug)]
struct Channel {
    id: Id,
    last: bool,
}

#[derive(Clone, Copy, Debug)]
struct Chip {
    ids: ChipIds,
    seen: Seen,
}

#[derive(Clone, Copy, Debug)]
struct ChipIds {
    phase: Id,
    position: Id,
    outgoing: Id,
    latch: Id,
    out: Id,
    out_service: Id,
    /// U, BA, RC, RD.
    lamps: [Id; 4],
}

/// What can be seen of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seen {
    phase: Phase,
    position: Option<u16>,
    outgoing: Outgoing,
    lamps: Lamps,
    out: OutWord,
    /// The line bit at which OUT data were taken last.
    taken: Option<u64>,
}

impl Seen {
    /// How a chip is at line bit `now`.
    fn of(slave: &Slave, now: u64) -> Self {
        let out = slave.latched().first_chunk().map_or(0, |bytes| u32::from_be_bytes(*bytes));
        Self {
            phase: slave.phase(),
            position: slave.position(),
            outgoing: slave.outgoing(),
            lamps: slave.lamps(),
            out: OutWord(out),
            taken: slave.ages().1.and_then(|age| now.checked_sub(age)),
        }
    }

    fn position_value(&self) -> Value {
        self.position.map_or(NO_POSITION, |position| Value::Bits(position.into()))
    }

    fn outgoing_value(&self) -> Value {
        Value::from(self.outgoing == Outgoing::On)
    }

    const fn lamp_values(&self) -> [bool; 4] {
        let Lamps { u, ba, rc, rd } = self.lamps;
        [u, ba, rc, rd]
    }
}

impl Tap {
    pub(crate) const fn new(bit: Duration) -> Self {
        let bit = bit.as_nanos() / UNIT_NS;
        Self { bit, segments: Vec::new(), chips: Vec::new(), changes: Vec::new() }
    }

    /// The lines of a ring with so many devices.
    pub(crate) fn add_lines(&mut self, signals: &mut Signals, devices: usize) {
        let mut add = |scope: &str, suffix: &str, first: bool| {
            signals.scope(scope);
            let channel = |segment: usize| Channel {
                id: signals.add(format!("segment_{segment}{suffix}"), 1, first.into()),
                last: first,
            };
            (0..=devices).map(channel).collect::<Vec<_>>()
        };
        let lines = add("line", "", IDLE);
        let hits = add("hit", "_hit", false);
        self.segments = lines.into_iter().zip(hits).map(|(line, hit)| Segment { line, hit }).collect();
    }

    /// The chip of the next device.
    pub(crate) fn add_chip(&mut self, signals: &mut Signals, slave: &Slave) {
        let seen = Seen::of(slave, 0);
        let [out, out_service] = out_values(seen.out);
        let [u, ba, rc, rd] = seen.lamp_values().map(Value::from);
        let ids = ChipIds {
            phase: signals.add("state", 4, Value::Bits(phase_code(seen.phase))),
            position: signals.add("position", 9, seen.position_value()),
            outgoing: signals.add("outgoing", 1, seen.outgoing_value()),
            latch: signals.add("latch", 1, Value::Bits(0)),
            out: signals.add("out", 32, out),
            out_service: signals.add("out_service", 1, out_service),
            lamps: [
                signals.add("lamp_u", 1, u),
                signals.add("lamp_ba", 1, ba),
                signals.add("lamp_rc", 1, rc),
                signals.add("lamp_rd", 1, rd),
            ],
        };
        self.chips.push(Chip { ids, seen });
    }

    pub(crate) const fn changes_mut(&mut self) -> &mut Vec<Change> {
        &mut self.changes
    }

    /// When a line bit is seen behind so many devices.
    const fn time(&self, bit: u64, devices: usize) -> u64 {
        (bit + DEVICE_DELAY_BITS as u64 * devices as u64).saturating_mul(self.bit)
    }

    /// What went into a segment, and what came out of it.
    fn heard(&mut self, segment: usize, at: u64, sent: Bits, heard: Bits) {
        let begins = self.time(at, segment);
        let bit = self.bit;
        let Some(channels) = self.segments.get_mut(segment) else { return };
        channels.line.follow(begins, bit, heard, &mut self.changes);
        if sent != heard || channels.hit.last {
            let hits = Bits { bits: sent.bits ^ heard.bits, count: heard.count };
            channels.hit.follow(begins, bit, hits, &mut self.changes);
        }
    }

    /// How the chips are, now that some bits from `at` on have passed.
    fn look(&mut self, at: u64, count: u32, slaves: &[Slave]) {
        let ends = at + u64::from(count);
        for position in 0..self.chips.len() {
            let (began, ended) = (self.time(at, position), self.time(ends, position));
            let (Some(chip), Some(slave)) = (self.chips.get_mut(position), slaves.get(position)) else {
                return;
            };
            let now = Seen::of(slave, ends);
            if now == chip.seen {
                continue;
            }
            let before = std::mem::replace(&mut chip.seen, now);
            let ids = chip.ids;
            let mut show = |at, id, value| self.changes.push(Change { at, id, value });
            // What it is in the middle of, it was in from the first of these bits on; the rest is what they led to.
            show(began, ids.phase, Value::Bits(phase_code(now.phase)));
            show(ended, ids.position, now.position_value());
            show(ended, ids.outgoing, now.outgoing_value());
            for (id, lit) in ids.lamps.into_iter().zip(now.lamp_values()) {
                show(ended, id, lit.into());
            }
            let [out, out_service] = out_values(now.out);
            let mut word_at = ended;
            if let Some(taken) = now.taken.filter(|_| now.taken != before.taken) {
                word_at = (taken + u64::from(DEVICE_DELAY_BITS) * position as u64).saturating_mul(self.bit);
                show(word_at, ids.latch, Value::Bits(1));
                show(word_at.saturating_add(self.bit), ids.latch, Value::Bits(0));
            }
            show(word_at, ids.out, out);
            show(word_at, ids.out_service, out_service);
        }
    }
}

impl Channel {
    /// Notes where the bits change, the first of them at `begins`.
    fn follow(&mut self, begins: u64, bit: u64, line: Bits, changes: &mut Vec<Change>) {
        let Bits { bits, count } = line;
        if count == 0 {
            return;
        }
        // Each bit beside the one before it.
        let before = bits >> 1 | u64::from(self.last) << (count - 1);
        let mut edges = bits ^ before;
        while edges != 0 {
            let edge = edges.ilog2();
            edges ^= 1 << edge;
            let at = begins.saturating_add(u64::from(count - 1 - edge) * bit);
            changes.push(Change { at, id: self.id, value: Value::from(bits >> edge & 1 != 0) });
        }
        self.last = bits & 1 != 0;
    }
}

/// Segments with a tap on them.
pub(crate) struct Tapped<'a> {
    pub(crate) segments: &'a mut Segments,
    pub(crate) tap: &'a mut Tap,
}

impl Lines for Tapped<'_> {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        let heard = self.segments.pass(segment, at, line);
        self.tap.heard(segment, at, line, heard);
        heard
    }

    fn passed(&mut self, at: u64, count: u32, slaves: &[Slave]) {
        self.tap.look(at, count, slaves);
    }
}
