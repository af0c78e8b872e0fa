//! Polls that are made up, with a wrong bit in one of them.

#![allow(clippy::unwrap_used, reason = "tests")]

use encoring_host::validity::Why;
use encoring_words::model::Sensor;
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter};

use super::*;

fn subject() -> Subject {
    let values = [
        (Parameter::CountingDirection, 0),
        (Parameter::MeasuringLength, 0x00FF_FFFF),
        (Parameter::Numerator, 4_096),
        (Parameter::Denominator, 1),
    ];
    let sensor = Sensor::Rotary { steps_per_turn: 4_096 };
    let judge =
        Judge::new(Model::Ce65M, Some(sensor), &values, Tolerance::of_sheet(Duration::from_millis(100)));
    Subject { position: 4, judge: judge.unwrap() }
}

/// One wrong bit in poll 300, and from poll 500 on positions that are elsewhere.
fn poll(number: u64) -> Poll {
    let at = Instant(number * 10_000_000);
    let right = 70_000 + 40 * number as u32;
    let shown = match number {
        300 => right ^ 1 << 20,
        500.. => right + 1_234_567,
        _ => right,
    };
    let step = Why::Speed { from: right, to: shown, within: Duration::from_millis(10) };
    let sight = Sight {
        position: 4,
        at,
        input: Some(InWord(shown)),
        age: None,
        out: Some(OutWord(0)),
        verdict: if shown == right { Judgement::Valid(right) } else { Judgement::Implausible(step) },
        stop: matches!(number, 300 | 500).then_some(Stop::Implausible(step)),
    };
    Poll { number, due: at, at, sights: vec![sight], ..Poll::default() }
}

#[test]
fn the_cause_of_a_jump_is_known_a_few_polls_behind_it() {
    let (mut causes, subjects) = (Causes::default(), [subject()]);
    let mut told = Vec::new();
    for number in 0..400 {
        told.extend(causes.take(&poll(number), &subjects).into_iter().map(|caused| (number, caused)));
    }
    let [(number, caused)] = told.as_slice() else { unreachable!("{told:?}") };
    assert!((310..=320).contains(number), "{number}");
    assert_eq!((caused.position, caused.found.cause), (4, "single_bit"));
    assert!(caused.found.to_string().starts_with("cause of the jump: one wrong bit, likely: "), "{told:?}");
    assert!(causes.rest(&subjects).is_empty());
}

#[test]
fn a_cause_stands_beside_the_verdict_as_long_as_that_stands() {
    let (mut causes, subjects) = (Causes::default(), [subject()]);
    (0..400).for_each(|number| drop(causes.take(&poll(number), &subjects)));
    assert_eq!(causes.of(4), None);
    (400..530).for_each(|number| drop(causes.take(&poll(number), &subjects)));
    assert!(causes.of(4).unwrap().to_string().starts_with("cause of the jump: "), "{causes:?}");
    (0..1).for_each(|number| drop(causes.take(&poll(number), &subjects)));
    assert_eq!(causes.of(4), None);
}

#[test]
fn a_jump_with_the_last_poll_is_told_as_far_as_it_is_known() {
    let (mut causes, subjects) = (Causes::default(), [subject()]);
    for number in 0..=300 {
        assert!(causes.take(&poll(number), &subjects).is_empty());
    }
    let rest = causes.rest(&subjects);
    assert_eq!(rest.len(), 1);
    assert_eq!(rest[0].found.cause, "unclear");
}
