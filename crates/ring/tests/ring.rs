//! The ring: it opens, moves words, and follows what happens to its segments and devices.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use encoring_ring::diagnostics::{FaultPlace, PERIPHERAL_FAULT, SEARCHING, status};
use encoring_ring::ident::{ENCODER, Ident};
use encoring_ring::master::{ConfigurationError, Ended, State, WhenBroken, WrongState};
use encoring_ring::profile::BIT_500K;
use encoring_ring::slave::{Condition, Jumper, ModuleFault};
use encoring_ring::telegram::Bits;
use encoring_ring::{BitRing, CycleTime, Slave, Sound, Verdict};
use encoring_words::{InWord, Instant, OutWord};

fn encoders(count: usize) -> BitRing<Vec<Slave>> {
    let slaves = (0..count).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
    let mut ring = BitRing::new(slaves, BIT_500K);
    ring.bring_up(&mut Sound, 100_000).unwrap();
    ring.begin_time();
    ring
}

// [R1]
#[test]
fn words_move_both_ways_through_every_length_of_ring() {
    for count in [1, 2, 3, 16, 128] {
        let mut ring = encoders(count);
        let cycle = CycleTime::default().of_encoders(count as u32).as_nanos();
        for k in 1..4_u32 {
            let out: Vec<OutWord> = (0..count as u32).map(|p| OutWord(0xC200_0000 ^ k << 16 ^ p)).collect();
            let answers: Vec<_> =
                (0..count as u32).map(|p| Some(InWord(0xE3A5_E3A5_u32.rotate_left(k) ^ p))).collect();
            let mut input = vec![InWord(0); count];
            let cycled = ring.cycle(Instant(u64::from(k) * cycle), &out, &mut input, &answers, &mut Sound);
            assert_eq!((cycled.ended, cycled.verdict), (Ended::Good, Verdict::Good), "{count}");
            for p in 0..count {
                assert_eq!(ring.out_word(p), out[p]);
                assert_eq!(Some(input[p]), answers[p]);
            }
        }
        assert_eq!(ring.master().status(), 0x00E0);
        assert_eq!(ring.master().parameter(), 0);
    }
}

/// A line that is cut before a segment, or sound.
fn cut(before: Option<usize>) -> impl FnMut(usize, u64, Bits) -> Bits {
    move |segment, _, line| if before == Some(segment) { Bits::idle(line.count) } else { line }
}

struct Bench {
    ring: BitRing<Vec<Slave>>,
    slot: u64,
    input: Vec<InWord>,
}

impl Bench {
    fn of(count: usize) -> Self {
        Self { ring: encoders(count), slot: 0, input: vec![InWord(0); count] }
    }

    fn slot(&mut self, cut_before: Option<usize>) -> Ended {
        self.slot += 1;
        let count = self.input.len() as u32;
        let cycle = CycleTime::default().of_encoders(count).as_nanos();
        let out: Vec<OutWord> = (0..count).map(|k| OutWord(0xC200_0000 | k)).collect();
        let answers: Vec<_> = (0..count).map(|k| Some(InWord(k + 1))).collect();
        let now = Instant(self.slot * cycle);
        self.ring.cycle(now, &out, &mut self.input, &answers, &mut cut(cut_before)).ended
    }

    fn until(&mut self, cut_before: Option<usize>, wanted: impl Fn(&Self, Ended) -> bool) -> u64 {
        (1..3_000)
            .find(|_| {
                let ended = self.slot(cut_before);
                wanted(self, ended)
            })
            .unwrap()
    }

    fn held(&self) -> Vec<u32> {
        (0..self.input.len()).map(|position| self.ring.out_word(position).0).collect()
    }
}

#[test]
fn a_break_is_searched_with_all_outputs_0_found_and_mended_without_a_restart() {
    for segment in 0..=3 {
        let mut bench = Bench::of(3);
        assert_eq!(bench.slot(None), Ended::Good);
        let input = bench.input.clone();
        for _ in 0..5 {
            assert_eq!(bench.slot(Some(segment)), Ended::Faulty);
        }
        assert_eq!(bench.ring.master().state(), State::Ready);
        assert_eq!(bench.ring.master().status() & (status::DETECT | status::RUN), status::DETECT);
        assert_eq!(bench.ring.master().parameter(), SEARCHING);
        bench.until(Some(segment), |bench, _| bench.ring.master().place().is_some());
        let expected =
            if segment == 0 || segment == 3 { FaultPlace::Nowhere } else { FaultPlace::Break(segment) };
        assert_eq!(bench.ring.master().place(), Some(expected));
        assert_eq!(bench.ring.master().parameter(), expected.parameter(3));
        for _ in 0..500 {
            bench.slot(Some(segment));
            assert_eq!(bench.held(), [0, 0, 0], "outputs are 0 while the master looks");
            assert_eq!(bench.input, input, "the master keeps what it saw last");
        }
        bench.until(None, |_, ended| ended == Ended::Good);
        assert_eq!(bench.held(), [0xC200_0000, 0xC200_0001, 0xC200_0002]);
        assert_eq!((bench.ring.master().status(), bench.ring.master().place()), (0x00E0, None));
    }
}

#[test]
fn with_permission_the_master_runs_on_with_the_devices_before_a_break() {
    let mut bench = Bench::of(3);
    bench.ring.master_mut().set_when_broken(WhenBroken::RunOn);
    bench.slot(None);
    bench.until(Some(2), |_, ended| ended == Ended::Good);
    assert_eq!(bench.ring.master().devices(), 2);
    assert_eq!(bench.ring.master().place(), Some(FaultPlace::Break(2)));
    assert_eq!(bench.ring.master().status(), 0x00E4, "it runs, and the bus has a fault");
    assert_eq!(bench.ring.master().parameter(), 0x0280);
    for _ in 0..100 {
        assert_eq!(bench.slot(Some(2)), Ended::Good);
        assert_eq!(bench.held(), [0xC200_0000, 0xC200_0001, 0]);
    }
    let lamps = |position| bench.ring.lamps(position).unwrap();
    assert!(lamps(0).ba && !lamps(0).rd);
    assert!(lamps(1).ba && lamps(1).rd, "the next interface is switched off");
    assert!(!lamps(2).rc);
    // The third one is back only when somebody says so.
    bench.ring.master_mut().activate();
    bench.ring.master_mut().start().unwrap();
    bench.until(None, |_, ended| ended == Ended::Good);
    assert_eq!(bench.held(), [0xC200_0000, 0xC200_0001, 0xC200_0002]);
}

// [R1]
#[test]
fn ready_active_run_and_back() {
    let slaves: Vec<Slave> = (0..3).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
    let mut bench = Bench { ring: BitRing::new(slaves, BIT_500K), slot: 0, input: vec![InWord(0); 3] };
    assert_eq!(bench.ring.master().status(), 0x0080);
    assert_eq!(bench.ring.master_mut().start(), Err(WrongState { state: State::Ready }));
    bench.slot(None);
    assert_eq!(bench.ring.master().state(), State::Ready);
    bench.ring.master_mut().activate();
    // Nobody said how long the ring is, and the last one has a jumper that it should not have.
    bench.until(None, |bench, _| bench.ring.master().place().is_some());
    assert_eq!(
        bench.ring.master().place(),
        Some(FaultPlace::Break(3)),
        "an open ring behind the last one [R137]"
    );
    bench.ring.slaves_mut()[2].set_jumper(Jumper::Open);
    bench.until(None, |bench, _| bench.ring.master().state() == State::Active);
    assert_eq!(bench.ring.master().status(), 0x00C0);
    assert_eq!(bench.ring.master().devices(), 3);
    assert_eq!(bench.ring.master().found(2), Some(ENCODER));
    assert_eq!(bench.held(), [0; 3], "ID cycles move no words");
    bench.ring.master_mut().start().unwrap();
    assert_eq!(bench.slot(None), Ended::Good);
    assert_eq!(bench.ring.master().status(), 0x00E0);
    assert_eq!(bench.ring.master_mut().deactivate(), Err(WrongState { state: State::Run }));
    bench.ring.master_mut().stop().unwrap();
    for _ in 0..100 {
        assert_eq!(bench.slot(None), Ended::Id);
    }
    assert_eq!(
        bench.held(),
        [0xC200_0000, 0xC200_0001, 0xC200_0002],
        "the line lives, so they keep their words"
    );
    bench.ring.master_mut().start().unwrap();
    assert_eq!(bench.slot(None), Ended::Good);
    bench.ring.master_mut().alarm_stop();
    for _ in 0..40 {
        assert_eq!(bench.slot(None), Ended::Idle);
    }
    assert_eq!(bench.held(), [0; 3]);
    assert_eq!(bench.ring.master().status(), 0x0080);
}

// [R137]
#[test]
fn without_its_jumper_a_device_hides_those_behind_it_from_the_search() {
    for position in 0..3 {
        let slaves: Vec<Slave> = (0..4).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
        let mut ring = BitRing::new(slaves, BIT_500K);
        ring.slaves_mut()[position].set_jumper(Jumper::Open);
        ring.master_mut().activate();
        for _ in 0..1_000 {
            ring.run(Instant(0), &mut Sound);
        }
        assert_eq!(ring.master().state(), State::Active);
        assert_eq!(ring.master().devices(), position + 1);
        assert!(ring.lamps(position).unwrap().rd);
    }
}

#[test]
fn a_module_fault_is_told_when_the_ring_is_identified() {
    let mut bench = Bench::of(2);
    bench.ring.slaves_mut()[1].set_module_fault(ModuleFault::Present);
    bench.ring.master_mut().stop().unwrap();
    bench.slot(None);
    bench.ring.master_mut().start().unwrap();
    bench.slot(None);
    assert_eq!(bench.ring.master().status(), 0x00E0 | status::PF);
    assert_eq!(bench.ring.master().parameter(), PERIPHERAL_FAULT);
}

#[test]
fn the_most_devices_that_a_ring_can_have_are_opened_and_no_more() {
    let of = |count: usize, ident: Ident| -> BitRing<Vec<Slave>> {
        BitRing::new((0..count).map(|_| Slave::new(ident, BIT_500K)).collect(), BIT_500K)
    };
    let byte = Ident::new(0x02, 0x09);
    let mut ring = of(512, byte);
    ring.bring_up(&mut Sound, 10_000).unwrap();
    ring.run(Instant(0), &mut Sound);
    assert_eq!((ring.master().state(), ring.master().devices()), (State::Run, 512));
    let error = of(513, Ident::new(0x02, 0x00)).bring_up(&mut Sound, 1);
    assert_eq!(error, Err(ConfigurationError::Devices { devices: 513 }));
    let error = of(129, ENCODER).bring_up(&mut Sound, 1);
    assert_eq!(error, Err(ConfigurationError::Bytes { bytes: 516 }));
    let error = of(1, Ident::new(0x02, 0x08)).bring_up(&mut Sound, 1);
    assert_eq!(error, Err(ConfigurationError::Length { position: 0, code: 0x08 }));
}

#[test]
fn a_device_that_was_away_takes_nothing_before_it_has_its_place_again() {
    let mut bench = Bench::of(3);
    bench.slot(None);
    bench.ring.slaves_mut()[1].set_condition(Condition::Off);
    bench.slot(None);
    bench.ring.slaves_mut()[1].set_condition(Condition::Running);
    let mut slots = 0;
    while bench.slot(None) != Ended::Good {
        assert_eq!(bench.held()[1], 0);
        slots += 1;
        assert!(slots < 200);
    }
    assert_eq!(bench.held(), [0xC200_0000, 0xC200_0001, 0xC200_0002]);
}
