//! A watch of a simulated ring.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_bus::watch::{HandshakePhase, Plan, Subject};
use encoring_bus::{Judge, Judgement, Tolerance, Watch};
use encoring_sim::Fault;
use encoring_sim::scenario::Change;
use encoring_sim::{Scenario, World};
use encoring_station::{Simulated, Speed};
use encoring_words::{Duration, OutWord};

const STALE: Tolerance = Tolerance::of_sheet(Duration::from_millis(100));
const EVERY: Plan = Plan { every: Duration::from_millis(100), lasting: None };

fn mark() -> Arc<AtomicBool> {
    Arc::new(AtomicBool::new(false))
}

fn built_in() -> Simulated {
    Simulated::new(World::new(&Scenario::built_in().unwrap()).unwrap(), Speed::Max)
}

fn subjects(ring: &Simulated) -> Vec<Subject> {
    let units: Vec<_> =
        ring.world().with(|world| world.places().iter().map(|place| *place.node().unit()).collect());
    let judge =
        |unit: encoring_encoder::Unit| Judge::new(unit.model(), Some(unit.sensor()), &[], STALE).unwrap();
    units.into_iter().enumerate().map(|(position, unit)| Subject { position, judge: judge(unit) }).collect()
}

#[test]
fn minutes_of_the_built_in_ring_are_valid_throughout() {
    let mut ring = built_in();
    let world = ring.world().clone();
    let subjects = subjects(&ring);
    let plan = Plan { every: Duration::from_millis(100), lasting: Some(Duration::from_secs(200)) };
    let mut watch = Watch::new(&mut ring, subjects, plan, mark());
    let mut polls = 0;
    while let Some(poll) = watch.poll_with(|position| world.insight(position)) {
        polls += 1;
        for sight in &poll.sights {
            assert!(matches!(sight.verdict, Judgement::Valid(_)), "{sight:?}");
            assert_eq!((sight.out, sight.phase()), (Some(OutWord(0)), Some(HandshakePhase::Normal)));
            let lamps = world.lamps(sight.position).unwrap();
            assert!(lamps.u && lamps.ba && lamps.rc && lamps.rd == (sight.position == 2));
        }
    }
    assert_eq!(polls, 2_000);
    assert!(watch.subjects().iter().all(|subject| subject.judge.blind().is_empty()));
    assert_eq!(watch.subjects()[0].judge.measuring_length(), Some(50_000));
}

#[test]
fn polls_come_at_their_times_without_drift() {
    let mut ring = built_in();
    let subjects = subjects(&ring);
    let mut watch = Watch::new(&mut ring, subjects, EVERY, mark());
    let first = watch.poll().unwrap().at.as_nanos();
    for k in 1..500_u64 {
        let at = watch.poll().unwrap().at.as_nanos();
        assert!(at.abs_diff(first + k * 100_000_000) <= 2 * 677_000, "poll {k} at {at}");
    }
}

#[test]
fn without_a_pause_every_cycle_of_the_ring_is_seen_once() {
    let mut ring = built_in();
    let subjects = subjects(&ring);
    let plan = Plan { every: Duration::ZERO, lasting: Some(Duration::from_millis(100)) };
    let mut watch = Watch::new(&mut ring, subjects, plan, mark());
    let mut before = watch.now();
    let mut polls = 0;
    while let Some(poll) = watch.poll() {
        assert_eq!(poll.at.since(before), Duration::from_micros(677));
        before = poll.at;
        polls += 1;
    }
    assert_eq!(polls, 148);
}

#[test]
fn a_ring_that_stands_still_has_no_positions_and_an_encoder_without_supply_is_known_by_its_lamps() {
    let mut ring = built_in();
    let encoders = subjects(&ring);
    let mut watch = Watch::new(&mut ring, encoders, EVERY, mark());
    watch.poll();
    drop(watch);
    ring.world().with(|world| {
        world.trouble(1, Fault::Silent, Duration::from_secs(1));
        world.change(2, &[Change::Supply(0)]);
    });
    let encoders = subjects(&ring);
    let mut watch = Watch::new(&mut ring, encoders, EVERY, mark());
    let words: Vec<_> = (0..3).map(|_| watch.poll().unwrap().sights[0].verdict.word()).collect();
    assert_eq!(words.last(), Some(&"ring_stopped"), "{words:?}");
    assert!(!ring.world().lamps(2).unwrap().u);
}
