//! Every request of every command meets every way in which a gateway fails, and what is told is compared with the encoder
//! itself: no success, no claim and no service bit that is not so.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

#[path = "../common/mod.rs"]
mod common;
mod faulty;
mod judge;

use common::{assert_blameless, judged};
use faulty::{Faulty, WAYS, Way};
use judge::{Command, End, Ended, run};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg32;

/// Where the encoder turns: its words with their halves exchanged are nobody's, replies, or positions with the error bit.
const STARTS: [u32; 3] = [32_600, 70_000, 8_000];

/// What a sweep came to.
#[derive(Debug, Default)]
struct Figures {
    runs: u32,
    met: u32,
    done: u32,
    wrong: Vec<String>,
}

impl Figures {
    fn take(&mut self, ended: Ended, what: impl std::fmt::Debug) {
        self.runs += 1;
        self.met += ended.met;
        self.done += u32::from(ended.end == End::Done);
        self.wrong.extend(ended.wrong.into_iter().map(|wrong| format!("{what:?}: {wrong}")));
    }

    /// Prints them, and fails if anything was told that is not so.
    fn settle(&self, name: &str) {
        let Self { runs, met, done, wrong } = self;
        println!("{name}: {runs} runs, {met} faults met, {done} told as done, {} told wrongly", wrong.len());
        let first: Vec<_> = wrong.iter().take(20).map(String::as_str).collect();
        assert!(wrong.is_empty(), "{} told wrongly:\n{}", wrong.len(), first.join("\n"));
        assert!(0 < *done && done < runs, "some succeed, and a dead link ends in no success");
    }
}

/// Whether one answer that is late or lost must not end it.
fn repeats_everything(command: Command) -> bool {
    matches!(command, Command::Read | Command::Check | Command::Write | Command::Program)
}

/// A run without faults, at which a referee looks on; gives its requests.
fn good(command: Command, start: u32) -> u32 {
    let mut gateway = Faulty::new(start);
    gateway.ring().look_on();
    let requests = run(&mut gateway, command, &vec![]).requests;
    match command {
        Command::Read | Command::Check | Command::Write | Command::Program => {
            assert_blameless(gateway.ring());
        }
        // The axis turns.
        Command::Preset => drop(judged(gateway.ring()).unwrap()),
        // A service bit that stands is what they are for.
        Command::Release | Command::NeedlessRelease => {}
    }
    requests
}

/// Every request in every way, one fault a run.
fn one_fault(command: Command, starts: &[u32], every: usize) {
    let mut figures = Figures::default();
    for start in starts {
        let requests = good(command, *start);
        let faults = WAYS.into_iter().flat_map(|way| (1..=requests).map(move |at| (at, way)));
        for (at, way) in faults.step_by(every) {
            let ended = run(&mut Faulty::new(*start), command, &vec![(at, way)]);
            // One late or lost answer ends nothing that may be repeated.
            if repeats_everything(command) && !matches!(way, Way::Dead | Way::DeadBehind) {
                assert_eq!(
                    ended.end,
                    End::Done,
                    "{command:?} from {start}: request {at} of {requests}, {way:?}"
                );
            }
            figures.take(ended, (command, start, at, way));
        }
    }
    figures.settle(&format!("{command:?}, one fault a run"));
}

/// Any two faults, many of them close together.
fn two_faults(command: Command, runs: u32) {
    let mut figures = Figures::default();
    let requests = STARTS.map(|start| good(command, start));
    for seed in 0..runs {
        let mut random = Pcg32::seed_from_u64(seed.into());
        let place = random.random_range(0..STARTS.len());
        let mut way = || WAYS[random.random_range(0..WAYS.len())];
        let (first, second) = (way(), way());
        let at = random.random_range(1..=requests[place]);
        // Faults make requests, so the second may lie behind the last of a good run.
        let gap = if random.random() {
            random.random_range(1..=8)
        } else {
            random.random_range(1..=requests[place])
        };
        let faults = vec![(at, first), (at + gap, second)];
        let ended = run(&mut Faulty::new(STARTS[place]), command, &faults);
        figures.take(ended, (command, "seed", seed, STARTS[place], faults));
    }
    figures.settle(&format!("{command:?}, two faults a run"));
}

/// A part of the sweep that takes seconds.
fn part(command: Command, every: usize) {
    one_fault(command, &STARTS[..1], every);
    two_faults(command, 60);
}

#[test]
fn a_read_tells_what_is_programmed_or_that_it_does_not_know() {
    part(Command::Read, 3);
}

#[test]
fn a_check_tells_what_the_encoder_says_and_whether_it_has_made_values_count() {
    part(Command::Check, 5);
}

#[test]
fn a_written_value_is_verified_or_taken_back_or_said_to_be_in_doubt() {
    part(Command::Write, 17);
}

#[test]
fn a_program_is_verified_or_taken_back_or_said_to_be_in_doubt() {
    part(Command::Program, 29);
}

#[test]
fn a_preset_is_made_once_or_not_and_never_said_to_be_what_it_is_not() {
    part(Command::Preset, 7);
}

#[test]
fn a_service_bit_is_released_or_said_to_stand() {
    part(Command::Release, 53);
}

#[test]
fn nothing_is_released_where_no_service_bit_stands() {
    part(Command::NeedlessRelease, 3);
}

/// Every request in every way, and thousands of pairs of faults.
fn whole(command: Command) {
    one_fault(command, &STARTS, 1);
    two_faults(command, 5_000);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_read_and_thousands_of_pairs() {
    whole(Command::Read);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_check_and_thousands_of_pairs() {
    whole(Command::Check);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_write_and_thousands_of_pairs() {
    whole(Command::Write);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_program_and_thousands_of_pairs() {
    whole(Command::Program);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_preset_and_thousands_of_pairs() {
    whole(Command::Preset);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_release_and_thousands_of_pairs() {
    whole(Command::Release);
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn every_request_of_a_needless_release_and_thousands_of_pairs() {
    whole(Command::NeedlessRelease);
}
