//! A generator of PLC behaviour beside the referee: it shares nothing with the rules but their names.
//!
//! A program with a scan time runs against an encoder on a ring with a cycle time, over a way with a latency. Programs keep
//! the handshake, or break one rule. Referees see each write and each cycle, the cycles, the exchanges, and a log.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

use encoring_host::referee::{Referee, Ruling, Vantage};
use encoring_host::{Outcome, Request, Session, Timing};
use encoring_words::model::MODELS;
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter};

mod mistake;
mod plant;

use mistake::{MISTAKES, Mistake};
use plant::{Chance, PLACES, Plant, name};

fn names(referee: &Referee) -> Vec<&'static str> {
    referee.findings().map(name).collect()
}

/// What was found, and whether it is certain.
fn certain(referee: &Referee, is_certain: bool) -> Vec<&'static str> {
    let found = referee.findings().filter(|finding| (finding.verdict != Ruling::Suspected) == is_certain);
    found.map(name).collect()
}

/// What was seen of the generated programs from one place.
#[derive(Debug, Default, PartialEq, Eq)]
struct Tally {
    /// Programs with a mistake that is certain from there, and how many of them were named as certain.
    certain: (u32, u32),
    /// Programs with a mistake that is not, and how many of them were named all the same.
    doubtful: (u32, u32),
    /// Rules named as certain that the program did not break.
    wrong: u32,
    /// Programs without a mistake, and how many of them were suspected of one.
    right: (u32, u32),
}

impl Tally {
    fn count(&mut self, referee: &Referee, wanted: &[&str], is_certain: bool, allowed: &[&str]) {
        let sure = certain(referee, true);
        let all = names(referee);
        self.wrong +=
            sure.iter().filter(|name| !wanted.contains(name) && !allowed.contains(name)).count() as u32;
        let slot = if wanted.is_empty() {
            self.right.1 += u32::from(!all.is_empty());
            self.right.0 += 1;
            return;
        } else if is_certain {
            self.certain.1 += u32::from(wanted.iter().all(|name| sure.contains(name)));
            &mut self.certain.0
        } else {
            self.doubtful.1 += u32::from(wanted.iter().all(|name| all.contains(name)));
            &mut self.doubtful.0
        };
        *slot += 1;
    }

    fn row(&self, place: &str) -> String {
        let Self { certain, doubtful, wrong, right } = self;
        format!(
            "| {place} | {} of {} | {} of {} | {wrong} | {} of {} |\n",
            certain.1, certain.0, doubtful.1, doubtful.0, right.1, right.0
        )
    }
}

/// A program of a seed, judged from all places.
fn program(seed: u64) -> (Plant, Mistake, &'static [&'static str], &'static str) {
    let mut chance = Chance::of(seed);
    let (mistake, _, certain) = MISTAKES[seed as usize % MISTAKES.len()];
    let model = MODELS[seed as usize / MISTAKES.len() % MODELS.len()];
    let mut plant = Plant::new(&mut chance, model);
    plant.program(&mut chance, mistake);
    plant.referees.iter_mut().for_each(Referee::finish);
    let wanted = mistake.breaks(plant.model);
    (plant, mistake, wanted, certain)
}

fn tallies(seeds: std::ops::Range<u64>) -> [Tally; 4] {
    let mut tallies: [Tally; 4] = Default::default();
    for seed in seeds {
        let (plant, mistake, wanted, certain_from) = program(seed);
        for (k, (letter, referee)) in ["w", "c", "x", "p"].into_iter().zip(&plant.referees).enumerate() {
            // Halves are not seen elsewhere: a word that changes in two steps is.
            let torn = mistake == Mistake::Torn && letter != "w";
            let others: &[&str] =
                if torn { &["data_with_service_bit", "data_changed_in_service"] } else { &[] };
            let is_certain = certain_from.contains(letter);
            tallies[k].count(referee, wanted, is_certain, others);
            if k < 2 && !torn {
                assert_eq!(names(referee), wanted, "seed {seed}, {mistake:?}, {letter}: {}", plant.told());
            }
            let sure = certain(referee, true);
            let wrong: Vec<_> =
                sure.iter().filter(|name| !wanted.contains(name) && !others.contains(name)).collect();
            assert!(wrong.is_empty(), "seed {seed}, {mistake:?}, {letter}: {wrong:?}, {}", plant.told());
            let named = wanted.iter().all(|name| sure.contains(name));
            assert!(named || !is_certain, "seed {seed}, {mistake:?}, {letter}: {sure:?}, {}", plant.told());
        }
    }
    tallies
}

// [R30, R33, R38, R39, R40]
#[test]
fn each_mistake_of_a_generated_program_is_named_and_what_is_certain_is_never_wrong() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/referee.md");
    let page = std::fs::read_to_string(page).unwrap();
    let rows: String = ["w", "c", "x", "p"]
        .into_iter()
        .zip(tallies(0..4_200))
        .map(|(place, tally)| tally.row(place))
        .collect();
    assert!(page.contains(&rows), "docs/referee.md must hold these rows:\n{rows}");
}

#[test]
#[ignore = "some minutes; .ci/long runs it"]
fn a_hundred_thousand_generated_programs_are_judged_as_they_should_be() {
    for (place, tally) in ["w", "c", "x", "p"].into_iter().zip(tallies(4_200..104_200)) {
        print!("{}", tally.row(place));
    }
}

// [R30..R41]
#[test]
fn our_own_session_breaks_no_rule() {
    let requests = [
        Request::write(Model::Ce65M, Parameter::MeasuringLength, 9_999).unwrap(),
        Request::write(Model::Ce65M, Parameter::Numerator, 10).unwrap(),
        Request::data_check(),
        Request::read(Model::Ce65M, Parameter::MeasuringLength).unwrap(),
        Request::preset(Model::Ce65M, 5, 9_999).unwrap(),
    ];
    for seed in 0..200 {
        let mut chance = Chance(seed);
        let mut plant = Plant::new(&mut chance, Model::Ce65M);
        let timing = Timing { settle: Duration::from_micros(2 * plant.cycle_us), ..Timing::DIRECT };
        let mut session = Session::new(timing, OutWord(0));
        plant.wait(5 * plant.cycle_us);
        for request in requests {
            let at = Instant(plant.now * 1_000);
            let first = session.start(at, request).unwrap();
            plant.put(first.0);
            let outcome = loop {
                plant.wait(plant.cycle_us + chance.below(3_000));
                let seen = encoring_host::Seen { input: InWord(plant.input), age: Duration::ZERO };
                let (out, outcome) = session.cycle(Instant(plant.now * 1_000), Some(seen));
                if out.0 != plant.out {
                    plant.put(out.0);
                }
                if let Some(outcome) = outcome {
                    break outcome;
                }
            };
            assert!(matches!(outcome, Outcome::Done { .. }), "seed {seed}: {outcome:?}");
        }
        for (vantage, referee) in PLACES.into_iter().zip(&mut plant.referees) {
            referee.finish();
            if vantage == Vantage::Log {
                // A row seldom shows every word.
                assert_eq!(certain(referee, true), [""; 0], "seed {seed}");
            } else {
                assert_eq!(names(referee), [""; 0], "seed {seed}, {vantage:?}");
                assert_eq!(referee.services(), 5);
            }
        }
    }
}
