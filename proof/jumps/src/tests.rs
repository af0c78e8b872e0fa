//! The quick part of the score, and that the corpus is what it is said to be.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use std::collections::BTreeSet;

use encoring_diagnosis::Likelihood;

use crate::cause::{CAUSES, Cause};
use crate::clean::{Beside, alarms};
use crate::corpus::Case;
use crate::file;
use crate::polled;
use crate::report::{Wanted, goals, misses};
use crate::score::Score;

/// What must be reached here, in hundredths, in the order of the goals; the goals themselves are judged on the whole corpus.
const FLOORS: [f64; 6] = [94.0, 99.0, 92.0, 95.0, 95.0, 4.0];

#[test]
fn the_same_seed_makes_the_same_recording_and_another_seed_another() {
    for seed in 0..40 {
        let (case, again, other) = (Case::of(seed), Case::of(seed), Case::of(seed + 1));
        assert_eq!(file::table(&case), file::table(&again), "seed {seed}");
        assert_eq!(file::truth(&case), file::truth(&again), "seed {seed}");
        assert_ne!(file::table(&case), file::table(&other), "seed {seed}");
    }
}

#[test]
fn every_cause_happens_where_it_can_be_told_and_clean_recordings_too() {
    let mut told = BTreeSet::new();
    let mut clean = 0;
    for case in (0..600).map(Case::of) {
        clean += u32::from(case.jumps.is_empty());
        told.extend(case.jumps.iter().filter(|jump| jump.rivals.is_empty()).map(|jump| jump.cause));
        for jump in &case.jumps {
            assert!(jump.from <= jump.to && jump.to < case.rows.len(), "seed {}: {jump:?}", case.seed);
        }
        assert!(case.rows.is_sorted_by_key(|row| row.time_us), "seed {}", case.seed);
    }
    let missing: Vec<Cause> =
        CAUSES.iter().map(|(cause, _)| *cause).filter(|cause| !told.contains(cause)).collect();
    assert_eq!(missing, [Cause::Motion]);
    assert!(clean >= 40, "{clean}");
}

/// 300 recordings of the half that may be looked at; `.ci/long` judges the whole.
#[test]
fn the_diagnosis_of_300_recordings_is_as_good_as_it_was() {
    let seeds: Vec<u64> = (0..600).step_by(2).collect();
    let score = Score::of_many(&seeds);
    assert_eq!(score.recordings, 300);
    for (goal, floor) in goals(&score).iter().zip(FLOORS) {
        let reached = match goal.goal {
            Wanted::AtLeast(_) => goal.percent() >= floor,
            Wanted::AtMost(_) => goal.percent() <= floor,
        };
        let seen = format!("{} {}: {} of {}, floor {floor}", goal.percent(), goal.what, goal.hits, goal.of);
        assert!(goal.of > 0 && reached, "{seen}\n{}", misses(&score));
    }
}

/// Part of a day; `.ci/long` has the whole.
#[test]
fn clean_motion_at_the_limits_of_the_data_sheet_is_no_false_alarm() {
    for (period_us, seconds) in
        [(500, 30), (1_000, 120), (10_000, 600), (100_000, 3_600), (1_000_000, 36_000)]
    {
        for beside in [Beside::Nothing, Beside::Model] {
            let (rows, found) = alarms(period_us, period_us, seconds, beside);
            assert!(rows >= 36_000);
            assert!(found.is_empty(), "seed {period_us}, {beside:?}: {found:#?}");
        }
    }
}

/// A few of them; `.ci/long` has many thousands.
#[test]
fn clean_logs_of_pollers_are_no_false_alarm() {
    let (mut loud, mut rows) = (0, 0);
    for seed in 0..400 {
        let alarms = polled::alarms(seed);
        let is_sure = alarms.found.iter().any(|episode| episode.certainty >= Likelihood::Likely);
        assert!(!is_sure, "{alarms}");
        loud += usize::from(!alarms.found.is_empty());
        rows += alarms.rows;
    }
    assert!(rows > 100_000 && loud <= 20, "{loud} of 400 logs have a finding that cannot be told");
}
