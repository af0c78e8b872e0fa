//! A ring that takes sound slots as a whole, beside the same ring with every bit of it run: after every slot master and
//! chips are equal in all that they hold, and so is what is told of the slot.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::ident::{ENCODER, Ident};
use encoring_ring::master::{State, WhenBroken};
use encoring_ring::profile::{BIT_500K, DATA_BYTES_MAX};
use encoring_ring::slave::{Condition, Jumper, ModuleFault};
use encoring_ring::telegram::Bits;
use encoring_ring::{BitRing, EveryBit, Lines, Master, Slave, Sound};
use encoring_words::{InWord, Instant, OutWord};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// What a segment suffers for a time.
#[derive(Clone, Copy, Debug)]
enum Fault {
    Flip,
    Idle,
    Low,
    /// Every bit is read as the one before.
    Late,
    /// Status telegrams, whatever was sent.
    Talk,
}

#[derive(Clone, Copy, Debug)]
struct Window {
    segment: usize,
    from: u64,
    to: u64,
    fault: Fault,
}

/// The segments of a ring, and what will happen to them.
#[derive(Clone, Debug, Default)]
struct Segments {
    windows: Vec<Window>,
    /// The last bit that each carried, and when the next one is due.
    last: Vec<(bool, u64)>,
    passed: u64,
}

impl Segments {
    fn of(devices: usize) -> Self {
        Self { last: vec![(true, 0); devices + 1], ..Self::default() }
    }
}

impl Lines for Segments {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        self.passed += 1;
        let ends = at + u64::from(line.count);
        let (mut last, due) = self.last[segment];
        // What went by as a whole ended with a stop bit.
        last |= due != at;
        self.last[segment] = (line.bits & 1 != 0, ends);
        let windows = || {
            let here = |window: &&Window| window.segment == segment && window.from < ends && at < window.to;
            self.windows.iter().filter(here)
        };
        if windows().next().is_none() {
            return line;
        }
        let mut changed = 0;
        for (k, time) in (0..line.count).rev().zip(at..) {
            let sent = line.bits >> k & 1 != 0;
            let came = windows().filter(|window| (window.from..window.to).contains(&time)).fold(
                sent,
                |bit, window| match window.fault {
                    Fault::Flip => !bit,
                    Fault::Idle => true,
                    Fault::Low => false,
                    Fault::Late => last,
                    Fault::Talk => (time - window.from) % 5 == 4,
                },
            );
            last = sent;
            changed = changed << 1 | u64::from(came);
        }
        Bits { bits: changed, count: line.count }
    }

    fn quiet(&self, from: u64, to: u64) -> bool {
        self.windows.iter().all(|window| window.to <= from || to <= window.from)
    }
}

/// One ring twice.
struct Both {
    idents: Vec<Ident>,
    whole: BitRing<Vec<Slave>>,
    bits: BitRing<Vec<Slave>>,
    lines: [Segments; 2],
    out: Vec<OutWord>,
    answers: Vec<Option<InWord>>,
    input: [Vec<InWord>; 2],
    now: Instant,
    slots: u64,
    /// Slots of the first one of which no bit passed a segment.
    taken_whole: u64,
}

impl Both {
    fn of(idents: &[Ident]) -> Self {
        let devices = idents.len();
        let slaves = idents.iter().map(|ident| Slave::new(*ident, BIT_500K)).collect();
        let mut ring = BitRing::new(slaves, BIT_500K);
        ring.bring_up(&mut Sound, 2_000).unwrap();
        ring.begin_time();
        Self {
            idents: idents.into(),
            whole: ring.clone(),
            bits: ring,
            lines: [Segments::of(devices), Segments::of(devices)],
            out: vec![OutWord(0); devices],
            answers: vec![None; devices],
            input: [vec![InWord(0); devices], vec![InWord(0); devices]],
            now: Instant::ZERO,
            slots: 0,
            taken_whole: 0,
        }
    }

    fn change(&mut self, change: impl Fn(&mut BitRing<Vec<Slave>>)) {
        change(&mut self.whole);
        change(&mut self.bits);
    }

    /// A fault of a segment, its time counted from the begin of the coming slot.
    fn fault(&mut self, segment: usize, from: u64, length: u64, fault: Fault) {
        let from = self.whole.sent() + from;
        for lines in &mut self.lines {
            lines.windows.push(Window { segment, from, to: from + length, fault });
        }
    }

    /// Runs a slot of both; `true` if the first one took it as a whole.
    fn slot(&mut self, nanos: u64) -> bool {
        self.now.0 += nanos;
        let began = self.whole.sent();
        let [whole, bits] = &mut self.lines;
        whole.windows.retain(|window| window.to > began);
        bits.windows.retain(|window| window.to > began);
        let passed = whole.passed;
        let [left, right] = &mut self.input;
        let one = self.whole.cycle(self.now, &self.out, left, &self.answers, whole);
        let other = self.bits.cycle(self.now, &self.out, right, &self.answers, &mut EveryBit(bits));
        assert_eq!(one, other);
        assert_eq!(left, right);
        self.compare(nanos);
        let is_whole = passed == self.lines[0].passed;
        self.slots += 1;
        self.taken_whole += u64::from(is_whole);
        is_whole
    }

    fn until(&mut self, is_so: impl Fn(&Master) -> bool) {
        let found = (0..1_000).any(|_| {
            self.slot(1_000_000);
            is_so(self.whole.master())
        });
        assert!(found);
    }

    fn compare(&self, nanos: u64) {
        let (whole, bits) = (&self.whole, &self.bits);
        assert_eq!(whole.sent(), bits.sent());
        for (position, (one, other)) in whole.slaves().iter().zip(bits.slaves()).enumerate() {
            assert!(one == other, "position {position}: {one:?}\n{other:?}");
            let held = |ring: &BitRing<Vec<Slave>>| {
                [0, nanos / 3, nanos].map(|back| ring.taken_at(position, Instant(self.now.0 - back)))
            };
            assert_eq!((held(whole), one.lamps()), (held(bits), other.lamps()));
        }
        let (one, other) = (whole.master(), bits.master());
        assert_eq!((one.status(), one.parameter()), (other.status(), other.parameter()));
        assert!(whole == bits, "{one:?}\n{other:?}");
    }
}

/// A world of chance.
struct World {
    both: Both,
    chance: Pcg64Mcg,
    /// Slots since the last one that was taken as a whole.
    troubled: u64,
}

impl World {
    fn new(seed: u64) -> Self {
        let mut chance = Pcg64Mcg::seed_from_u64(seed);
        // Evenly on a logarithm.
        let devices = match 1 << chance.random_range(0..8_u32) {
            128 => 128,
            octave => chance.random_range(octave..2 * octave),
        };
        let mut left = DATA_BYTES_MAX;
        let idents = (0..devices).map(|position| {
            let mut ident = ENCODER;
            if chance.random_range(0..4) == 0 {
                let codes = [0x00, 0x01, 0x03, 0x09, 0x0B, 0x0E, 0x12, 0x14];
                let other = Ident::new(0x03, codes[chance.random_range(0..codes.len())]);
                if other.bytes().unwrap() + 4 * (devices - position - 1) <= left {
                    ident = other;
                }
            }
            left -= ident.bytes().unwrap();
            ident
        });
        let idents: Vec<Ident> = idents.collect();
        Self { both: Both::of(&idents), chance, troubled: 0 }
    }

    fn devices(&self) -> usize {
        self.both.idents.len()
    }

    fn one_in(&mut self, slots: u64) -> bool {
        self.chance.random_range(0..slots) == 0
    }

    fn device(&mut self) -> usize {
        // The last one has nobody behind it to notice.
        let last = self.devices() - 1;
        if self.one_in(3) { last } else { self.chance.random_range(0..=last) }
    }

    fn step(&mut self) {
        let devices = self.devices() as u64;
        self.data();
        if self.one_in(120 + 6 * devices) {
            self.trouble();
        }
        if self.troubled > 60 + devices {
            self.repair();
        }
        let nanos = self.nanos();
        if self.one_in(40 + devices) {
            self.hit(nanos);
        }
        let is_whole = self.both.slot(nanos);
        self.troubled = if is_whole { 0 } else { self.troubled + 1 };
    }

    /// The time of a slot: often the shortest one, at times less than it can have, at times one that is longer than
    /// chips go without a reset.
    fn nanos(&mut self) -> u64 {
        let shortest = self.both.whole.shortest().as_nanos();
        match self.chance.random_range(0..64) {
            0..16 => shortest,
            16..20 => self.chance.random_range(0..shortest),
            20..36 => shortest + self.chance.random_range(0..400_000),
            36 if self.devices() < 16 => 30_000_000,
            _ => shortest + 200_000,
        }
    }

    /// Line bits of the frame, and of the slot if a frame is sent in it.
    fn slot_bits(&self, nanos: u64) -> (u64, u64) {
        let ring = &self.both.whole;
        let bytes: usize = ring.slaves().iter().map(Slave::bytes).sum();
        let frame = 13 * (6 + bytes as u64);
        let due = (self.both.now.0 + nanos) / BIT_500K.as_nanos();
        let least = ring.shortest().as_nanos() / BIT_500K.as_nanos();
        let bits = due.saturating_sub(ring.sent()).max(least);
        (frame, frame + (bits - frame).next_multiple_of(5))
    }

    fn data(&mut self) {
        for _ in 0..self.chance.random_range(0..4) {
            let device = self.device();
            self.both.out[device] = OutWord(self.chance.random());
            let answer = InWord(self.chance.random());
            self.both.answers[device] = if self.one_in(6) { None } else { Some(answer) };
        }
        // What is longer than a word.
        if self.one_in(3) {
            let device = self.device();
            let bytes: [[u8; 32]; 2] = [self.chance.random(), self.chance.random()];
            self.both.change(|ring| {
                ring.slaves_mut()[device].load(&bytes.concat());
                for (place, byte) in ring.master_mut().out_mut(device).iter_mut().zip(bytes.concat()) {
                    *place = !byte;
                }
            });
        }
    }

    /// A hit of few bits: in the frame, in the pause, up to the end of the slot, in the one after it.
    fn hit(&mut self, nanos: u64) {
        let segment = self.chance.random_range(0..=self.devices());
        let (frame, slot) = self.slot_bits(nanos);
        let rest = self.chance.random_range(1..30.min(slot - frame));
        let (from, length) = match self.chance.random_range(0..6) {
            0 => (self.chance.random_range(0..frame), 1),
            1 => (frame + self.chance.random_range(0..10), 1),
            2 => (slot - rest, 1),
            3 => (slot - rest, rest),
            4 => (slot, 1),
            _ => (self.chance.random_range(0..slot + 400), self.chance.random_range(1..30)),
        };
        let fault = [Fault::Flip, Fault::Idle, Fault::Low, Fault::Late][self.chance.random_range(0..4)];
        self.both.fault(segment, from, length, if length == 1 { Fault::Flip } else { fault });
    }

    /// Something that lasts, or that somebody does.
    fn trouble(&mut self) {
        let (device, other) = (self.device(), self.device());
        let kind = self.chance.random_range(0..17);
        match kind {
            0 | 1 => {
                let segment = self.chance.random_range(0..=self.devices());
                let fault = [Fault::Idle, Fault::Low, Fault::Late, Fault::Talk];
                let fault = fault[self.chance.random_range(0..4)];
                let length = self.chance.random_range(10..20_000);
                self.both.fault(segment, 0, length, fault);
            }
            // For one slot: it comes back with the rest of the ring in step.
            2 | 3 => {
                let condition = if kind == 2 { Condition::Off } else { Condition::Held };
                self.both.change(|ring| ring.slaves_mut()[device].set_condition(condition));
                self.both.slot(700_000);
                self.both.change(|ring| ring.slaves_mut()[device].set_condition(Condition::Running));
            }
            4 => self.both.change(|ring| ring.slaves_mut()[device].set_jumper(Jumper::Open)),
            5 | 6 => {
                let ident = Ident::new(0x33, self.chance.random_range(0..0x20));
                self.both.change(|ring| ring.slaves_mut()[device].set_ident(ident));
            }
            7 => self.both.change(|ring| ring.master_mut().alarm_stop()),
            8 => self.both.change(|ring| {
                let _ = ring.master_mut().stop();
            }),
            9 => self.both.change(|ring| ring.master_mut().set_when_broken(WhenBroken::RunOn)),
            10 => {
                let fewer = self.both.idents[..device].to_vec();
                self.both.change(|ring| ring.master_mut().configure(&fewer).unwrap());
            }
            // The frame comes home, and in the pause behind it chips are silent for so long that they are reset.
            11 | 12 if self.devices() < 16 => {
                let (frame, _) = self.slot_bits(40_000_000);
                self.both.fault(device, frame + 20, 13_000, Fault::Idle);
                self.both.slot(40_000_000);
            }
            11..15 => self.both.change(|ring| ring.slaves_mut()[device] = ring.slaves()[other].clone()),
            // Somebody else's bits.
            15 => {
                let count = self.chance.random_range(1..7);
                let stray = Bits { bits: self.chance.random::<u64>() >> (64 - count), count };
                self.both.change(|ring| {
                    ring.slaves_mut()[device].regenerate(stray);
                });
            }
            _ => self.both.change(|ring| {
                ring.slaves_mut()[device].set_module_fault(ModuleFault::Present);
                ring.slaves_mut()[other].request_reconfiguration();
            }),
        }
    }

    /// All is as it was in the beginning, and the ring is opened anew.
    fn repair(&mut self) {
        let idents = self.both.idents.clone();
        self.both.lines.iter_mut().for_each(|lines| lines.windows.clear());
        self.both.change(|ring| {
            for (slave, ident) in ring.slaves_mut().iter_mut().zip(&idents) {
                slave.set_condition(Condition::Running);
                slave.set_jumper(Jumper::Closed);
                slave.set_module_fault(ModuleFault::None);
                slave.set_ident(*ident);
            }
            let master = ring.master_mut();
            master.set_when_broken(WhenBroken::Wait);
            master.configure(&idents).unwrap();
            master.activate();
            master.start().unwrap();
        });
        self.troubled = 0;
    }
}

/// Runs worlds of `slots` slots each; how many slots there were, and how many were taken as a whole.
fn worlds(seeds: impl Iterator<Item = u64>, slots: u64) -> (u64, u64) {
    let mut sum = (0, 0);
    for seed in seeds {
        let mut world = World::new(seed);
        let ran = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            while world.both.slots < slots {
                world.step();
            }
        }));
        assert!(ran.is_ok(), "seed {seed}, {} devices, slot {}", world.devices(), world.both.slots);
        sum = (sum.0 + world.both.slots, sum.1 + world.both.taken_whole);
    }
    sum
}

#[test]
fn a_sound_slot_leaves_behind_what_its_bits_would_a_dense_part() {
    let (slots, whole) = worlds(0..100, 300);
    assert!(slots >= 30_000 && whole * 2 > slots && whole < slots, "{whole} of {slots}");
}

#[test]
#[ignore = "ten million slots: a quarter of an hour in release"]
fn a_sound_slot_leaves_behind_what_its_bits_would_ten_million_slots() {
    let half = |first: u64| move || worlds((first..20_000).step_by(2), 500);
    let (slots, whole) = std::thread::scope(|scope| {
        let threads = [scope.spawn(half(0)), scope.spawn(half(1))];
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .fold((0, 0), |sum, (slots, whole)| (sum.0 + slots, sum.1 + whole))
    });
    std::println!("{whole} of {slots} slots taken as a whole");
    assert!(slots >= 10_000_000 && whole * 2 > slots, "{whole} of {slots}");
}

/// A frame of so many encoders and 60 status telegrams.
const fn slot_ns(encoders: u64) -> u64 {
    (13 * (6 + 4 * encoders) + 60 * 5) * BIT_500K.as_nanos()
}

#[test]
fn the_first_slot_that_is_not_promised_is_run_and_a_hit_in_the_pause_spoils_its_frame() {
    let mut both = Both::of(&[ENCODER; 3]);
    let bits = slot_ns(3) / BIT_500K.as_nanos();
    assert!(both.slot(slot_ns(3)));
    // The FL bit of the status telegram behind the frame.
    both.fault(1, 234 + 3, 1, Fault::Flip);
    assert!(!both.slot(slot_ns(3)));
    assert_eq!(both.whole.master().counts().faulty, 1);
    both.until(|master| master.counts().cycles == 10);
    let begins = both.whole.sent();
    both.fault(3, bits, 1, Fault::Flip);
    assert!(both.slot(slot_ns(3)), "it begins with the slot after this one");
    assert_eq!(both.whole.sent(), begins + bits);
    assert!(!both.slot(slot_ns(3)));
    assert_eq!(both.whole.master().counts().faulty, 2);
    both.fault(3, bits - 1, 1, Fault::Flip);
    assert!(!both.slot(slot_ns(3)), "the last bit of this slot");
}

#[test]
fn a_ring_without_devices_whose_line_talks_in_the_silence_is_run_bit_by_bit_at_first() {
    let mut ring = BitRing::new(Vec::new(), BIT_500K);
    ring.master_mut().configure(&[]).unwrap();
    ring.master_mut().activate();
    ring.master_mut().start().unwrap();
    let mut both = Both { whole: ring.clone(), bits: ring, ..Both::of(&[]) };
    both.fault(0, 0, 13_000, Fault::Talk);
    while both.whole.sent() < 13_000 {
        assert!(!both.slot(1_000_000));
    }
    assert!(!both.slot(1_000_000), "the line was silent before");
    assert!(both.slot(1_000_000));
    assert_eq!(both.whole.master().counts().cycles, 2);
}

#[test]
fn a_ring_that_runs_on_before_a_break_is_not_sound_whatever_hangs_behind_it() {
    let mut both = Both::of(&[ENCODER; 3]);
    both.change(|ring| ring.master_mut().set_when_broken(WhenBroken::RunOn));
    both.fault(2, 0, 1_000_000, Fault::Idle);
    both.until(|master| master.devices() == 2 && master.state() == State::Run);
    both.lines.iter_mut().for_each(|lines| lines.windows.clear());
    assert!(!both.slot(slot_ns(3)));
    // Three chips in step, each with a place, and only the last one turns the line back.
    both.change(|ring| {
        let running = ring.slaves()[0].clone();
        ring.slaves_mut()[2] = ring.slaves()[1].clone();
        ring.slaves_mut()[1] = running;
    });
    assert!(!both.slot(slot_ns(3)));
}

#[test]
fn the_out_word_of_a_time_within_a_slot_is_the_one_that_was_held_then() {
    let mut both = Both::of(&[ENCODER; 2]);
    let held = |both: &Both, position: usize, back: &[u64]| -> Vec<u32> {
        let at = |back: &u64| Instant(both.now.0 - back);
        back.iter().map(|back| both.whole.taken_at(position, at(back)).shown().0).collect()
    };
    both.out.fill(OutWord(7));
    assert!(both.slot(slot_ns(2)));
    both.out.fill(OutWord(9));
    assert!(both.slot(slot_ns(2)));
    // The frame of 14 bytes and 4 bits of its first status telegram.
    let taken = (13 * 14 + 4) * 2_000;
    let at = slot_ns(2) - taken;
    assert_eq!(held(&both, 1, &[slot_ns(2), at + 1, at, 0]), [7, 7, 9, 9]);
    // Silence on the second segment, and a slot in the midst of which its device goes to reset.
    let silent_since = both.now;
    both.fault(1, 0, 20_000, Fault::Idle);
    both.slot(20_000_000);
    assert_eq!(held(&both, 1, &[20_000_000, 0]), [9, 9]);
    both.slot(20_000_000);
    let reset = 40_000_000 - 25_000_000;
    assert_eq!(both.now, Instant(silent_since.0 + 40_000_000));
    assert_eq!(held(&both, 1, &[20_000_000, reset, reset - 2_000, 0]), [9, 9, 0, 0]);
    assert_eq!(held(&both, 0, &[20_000_000, 0]), [9, 9]);
}
