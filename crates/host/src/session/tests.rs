extern crate std;

use std::vec::Vec;

use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter, Written};
use proptest::prelude::*;

use super::*;
use crate::referee::{LineSeen, ORDER, Observed, Referee, Vantage};

const MS: u64 = 1_000_000;

/// A bus on which every poll is a cycle of a millisecond, and an IN word is a cycle old.
struct Bench {
    session: Session,
    now: Instant,
    out: OutWord,
    put_out: Vec<OutWord>,
    referee: Referee,
}

impl Bench {
    fn new(timing: Timing) -> Self {
        let session = Session::new(timing, OutWord(0));
        // The origin is long ago, so that words can be old.
        let referee = Referee::new(Vantage::Writes, Some(Model::Ce65M));
        Self { session, now: Instant(1_000_000 * MS), out: OutWord(0), put_out: Vec::new(), referee }
    }

    fn direct() -> Self {
        Self::new(Timing::DIRECT)
    }

    /// Like behind a gateway: what was written stands on the ring after 5 ms.
    fn gateway() -> Self {
        Self::new(Timing { settle: Duration::from_millis(5), ..Timing::DIRECT })
    }

    fn start(&mut self, request: Request) {
        let out = self.session.start(self.now, request).unwrap();
        self.put(out);
    }

    /// What the session puts out, while the referee looks on.
    fn put(&mut self, out: OutWord) {
        if out != self.out {
            let (at, written) = (self.now, Written::Both(out));
            self.referee.observe(Observed::Write { at, client: 1, written });
        }
        self.out = out;
    }

    /// Whoever gets what was asked for has kept the handshake.
    fn judge(&self, outcome: Option<Outcome>) {
        let Some(Outcome::Done { .. }) = outcome else { return };
        let broken = self.referee.findings().find(|finding| ORDER.contains(&finding.rule));
        assert!(broken.is_none() && self.referee.services() > 0, "{broken:?}");
    }

    /// One poll that brings `input`.
    fn poll(&mut self, input: u32) -> Option<Outcome> {
        self.poll_or_not(Some((input, MS)))
    }

    fn poll_or_not(&mut self, input: Option<(u32, u64)>) -> Option<Outcome> {
        self.put_out.push(self.out);
        self.now = self.now + Duration(MS);
        let seen = input.map(|(word, age)| Seen { input: InWord(word), age: Duration(age) });
        let (at, out) = (self.now, self.out);
        let input = seen.map(|seen| seen.input);
        self.referee.observe(Observed::Cycle { at, out, input, line: LineSeen::Untold });
        let (out, outcome) = self.session.cycle(self.now, seen);
        self.put(out);
        self.judge(outcome);
        outcome
    }

    /// Polls that all bring `input`, until there is an outcome; `limit` at most.
    fn poll_until(&mut self, input: u32, limit: u32) -> (u32, Outcome) {
        for polls in 1..=limit {
            if let Some(outcome) = self.poll(input) {
                return (polls, outcome);
            }
        }
        panic!("no outcome in {limit} polls; {:?}", self.session.phase());
    }

    /// A whole service that the encoder answers with `reply` at once; ends the doubt of the beginning.
    fn serve(&mut self, request: Request, reply: u32) -> Outcome {
        self.start(request);
        for _ in 0..40 {
            let input = if self.out.service_bit() { reply } else { 5 };
            if let Some(outcome) = self.poll(input) {
                return outcome;
            }
        }
        panic!("never served; {:?}", self.session.phase());
    }
}

fn write(value: u32) -> Request {
    Request::write(Model::Ce65M, Parameter::MeasuringLength, value).unwrap()
}

fn read() -> Request {
    Request::read(Model::Ce65M, Parameter::MeasuringLength).unwrap()
}

fn preset() -> Request {
    Request::preset(Model::Ce65M, 1000, 0xFF_FFFF).unwrap()
}

fn done(data: u32) -> Outcome {
    Outcome::Done { reply: Reply { data, error: false }, error_before: false }
}

// [R38]
#[test]
fn a_late_acknowledgement_never_answers_the_next_request() {
    // The same request twice: only its time tells the late reply from the right one.
    let mut bench = Bench::direct();
    bench.start(read());
    let (_, outcome) = bench.poll_until(7, 4_000);
    let Outcome::TimedOut(timed_out) = outcome else { panic!("{outcome:?}") };
    assert_eq!((timed_out.waited_for, timed_out.fate), (WaitedFor::Acknowledgement, Fate::Unknown));

    bench.start(read());
    for _ in 0..5 {
        assert_eq!(bench.poll(7), None);
    }
    assert!(bench.out.service_bit(), "the second request is out");
    // An encoder shows the reply to a withdrawn request in one cycle.
    assert_eq!(bench.poll(0x8200_1111), None);
    assert_eq!(bench.poll(7), None);
    assert!(matches!(bench.session.phase(), SessionPhase::Requesting { .. }), "the late reply was not taken");
    // The right one stands as long as the service bit.
    let mut outcome = None;
    for _ in 0..10 {
        let input = if bench.out.service_bit() { 0x8200_2222 } else { 7 };
        outcome = outcome.or(bench.poll(input));
    }
    assert_eq!(outcome, Some(done(0x2222)));
}

#[test]
fn a_late_acknowledgement_that_comes_while_clearing_is_told() {
    let mut bench = Bench::direct();
    bench.start(write(0x270F));
    while !matches!(bench.session.phase(), SessionPhase::Clearing { .. }) {
        assert_eq!(bench.poll(7), None);
    }
    assert_eq!(bench.out, OutWord(0x4200_270F), "the service bit is taken back");
    let reply = Reply { data: 0x270F, error: false };
    assert_eq!(bench.poll(7), None);
    // Once is any word with these bits.
    assert_eq!(bench.poll(0xC200_270F), None);
    assert_eq!(bench.poll(7), None);
    assert_eq!(bench.poll(0xC200_270F), None);
    assert_eq!(bench.poll(0xC200_270F), None);
    let Some(Outcome::TimedOut(timed_out)) = bench.poll(7) else { panic!("over with the position") };
    assert_eq!(timed_out.fate, Fate::CarriedOut(reply));
}

#[test]
fn a_position_with_its_halves_exchanged_is_no_reply() {
    // Each value stands for three polls, and all of bits 31..24 are gone through.
    for patience in [20, 100_000] {
        let mut bench = Bench::gateway();
        bench.session.timing.patience = Duration(patience * MS);
        bench.start(read());
        let mut outcome = None;
        for polls in 0..3 * 0x1_0000 {
            let low = 0x7F00 + polls / 3;
            outcome = bench.poll(u32::from(low as u16) << 16);
            if outcome.is_some() {
                break;
            }
        }
        match outcome {
            None => {}
            Some(Outcome::TimedOut(timed_out)) => {
                assert_ne!(
                    timed_out.fate,
                    Fate::CarriedOut(Reply { data: 0, error: false }),
                    "{timed_out:?}"
                );
            }
            other => panic!("{other:?}"),
        }
    }
}

// [R32, R33, R38]
#[test]
fn data_and_number_go_out_first_and_the_service_bit_after_them() {
    let mut bench = Bench::direct();
    assert_eq!(bench.serve(write(0x270F), 0xC200_270F), done(0x270F));
    bench.put_out.dedup();
    assert_eq!(bench.put_out, [OutWord(0x4200_270F), OutWord(0xC200_270F), OutWord(0x4200_270F)]);
}

// [R34]
#[test]
fn the_service_bit_waits_for_a_cycle_and_the_settling_time() {
    let mut bench = Bench::gateway();
    bench.start(write(0x270F));
    let rising = |bench: &mut Bench| {
        let mut polls = 0;
        while !bench.out.service_bit() {
            bench.poll(5);
            polls += 1;
        }
        polls
    };
    // The first poll shows that the word stands there, five more that it has stood for 5 ms.
    assert_eq!(rising(&mut bench), 6);

    // Polls that fail show nothing.
    let mut bench = Bench::gateway();
    bench.start(write(0x270F));
    for _ in 0..20 {
        assert_eq!(bench.poll_or_not(None), None);
        assert!(!bench.out.service_bit());
    }
    assert_eq!(rising(&mut bench), 6);
}

#[test]
fn the_service_bit_waits_until_bit_31_was_seen_0() {
    let mut bench = Bench::direct();
    bench.start(read());
    for _ in 0..20 {
        bench.poll(0xC300_0001);
        assert!(!bench.out.service_bit());
    }
    bench.poll(1);
    assert!(bench.out.service_bit());
}

#[test]
fn a_position_from_before_the_request_does_not_show_that_the_encoder_is_free() {
    let mut bench = Bench::direct();
    bench.start(read());
    for age in [20, 100, 1_000] {
        assert_eq!(bench.poll_or_not(Some((5, age * MS))), None);
        assert!(!bench.out.service_bit());
    }
    bench.poll(5);
    assert!(bench.out.service_bit());
}

#[test]
fn a_late_reply_on_a_ring_that_has_stopped_does_not_stand() {
    let mut bench = Bench::direct();
    bench.start(read());
    while !bench.out.service_bit() {
        bench.poll(5);
    }
    // In doubt, as at every beginning: the last word before the stop was a reply to somebody else's request.
    for age in 1..500 {
        assert_eq!(bench.poll_or_not(Some((0x8200_0001, age * MS))), None);
        assert!(matches!(bench.session.phase(), SessionPhase::Requesting { .. }));
    }
}

#[test]
fn what_is_seen_after_a_reply_is_its_end_however_old_it_may_be() {
    let mut bench = Bench::direct();
    assert_eq!(bench.serve(read(), 0x8200_0001), done(1));
    bench.start(read());
    while !bench.out.service_bit() {
        bench.poll(5);
    }
    // A gateway that may be slow, but shows nothing out of order.
    bench.poll_or_not(Some((0x8200_0002, 20 * MS)));
    assert_eq!(bench.poll_or_not(Some((5, 20 * MS))), Some(done(2)));
}

#[test]
fn behind_a_gateway_a_reply_must_be_seen_twice() {
    let mut bench = Bench::gateway();
    assert_eq!(bench.serve(write(0x270F), 0xC200_270F), done(0x270F));
    bench.start(read());
    while !bench.out.service_bit() {
        bench.poll(5);
    }
    // High word new, low word old.
    bench.poll(0x8200_FFFF);
    bench.poll(0x8200_1234);
    assert!(matches!(bench.session.phase(), SessionPhase::Requesting { .. }));
    bench.poll(0x8200_1234);
    assert_eq!(bench.poll(5), Some(done(0x1234)));
}

#[test]
fn the_error_bit_is_judged_apart_and_an_older_error_is_told_from_a_new_one() {
    let mut bench = Bench::direct();
    let error = |data, error_before| Outcome::Done { reply: Reply { data, error: true }, error_before };
    assert_eq!(bench.serve(write(0x270F), 0xE200_270F), error(0x270F, false));
    bench.start(read());
    let mut outcome = None;
    while outcome.is_none() {
        let input = if bench.out.service_bit() { 0xA200_270F } else { 0x2000_0005 };
        outcome = bench.poll(input);
    }
    assert_eq!(outcome, Some(error(0x270F, true)));
}

#[test]
fn each_time_out_says_what_it_waited_for_and_what_is_known() {
    let mut bench = Bench::direct();
    bench.start(write(0x270F));
    let (polls, outcome) = bench.poll_until(0xC300_0001, 2_000);
    let Outcome::TimedOut(timed_out) = outcome else { panic!("{outcome:?}") };
    assert_eq!((polls, timed_out.polls, timed_out.answered), (1_000, 1_000, 1_000));
    assert_eq!((timed_out.waited_for, timed_out.fate), (WaitedFor::Normal, Fate::NotSent));
    assert_eq!(
        std::format!("{timed_out}"),
        "waited 1 s for IN bit 31 = 0 before the request; 1000 of 1000 polls brought a word, the last was C3000001"
    );
    assert!(bench.put_out.iter().all(|out| !out.service_bit()), "nothing was sent");

    bench.start(write(0x270F));
    let mut polls = 0;
    let outcome = loop {
        polls += 1;
        // The reply stays although the service bit is 0 again.
        let input = if polls < 3 { 5 } else { 0xC200_270F };
        if let Some(outcome) = bench.poll(input) {
            break outcome;
        }
    };
    let Outcome::TimedOut(timed_out) = outcome else { panic!("{outcome:?}") };
    let reply = Reply { data: 0x270F, error: false };
    assert_eq!((timed_out.waited_for, timed_out.fate), (WaitedFor::End, Fate::CarriedOut(reply)));
}

#[test]
fn a_bus_that_brings_nothing_ends_in_a_time_out_of_at_least_three_polls() {
    let timing = Timing { patience: Duration(1), ..Timing::DIRECT };
    let mut bench = Bench::new(timing);
    bench.start(read());
    assert_eq!((bench.poll_or_not(None), bench.poll_or_not(None)), (None, None));
    let Some(Outcome::TimedOut(timed_out)) = bench.poll_or_not(None) else { panic!("out of patience") };
    assert_eq!((timed_out.polls, timed_out.answered, timed_out.last), (3, 0, None));
}

#[test]
fn a_request_that_fell_is_taken_back_and_its_fate_is_not_known() {
    let mut bench = Bench::direct();
    bench.start(preset());
    while !bench.out.service_bit() {
        bench.poll(5);
    }
    assert!(bench.session.is_unrepeatable());
    bench.poll_or_not(None);
    assert!(bench.out.service_bit(), "a lost poll alone ends nothing");
    bench.session.fell(bench.now);
    bench.poll_or_not(None);
    assert_eq!(bench.out, OutWord(0x4600_03E8), "it is not written a second time");
    let (_, outcome) = bench.poll_until(5, 4_000);
    let Outcome::TimedOut(timed_out) = outcome else { panic!("{outcome:?}") };
    assert_eq!(timed_out.fate, Fate::Unknown);
}

#[test]
fn what_is_abandoned_ends_at_once() {
    let mut bench = Bench::direct();
    assert_eq!(bench.session.abandon(), None);
    bench.start(write(0x270F));
    assert_eq!(bench.session.abandon(), Some(Outcome::GivenUp(GivenUp { fate: Fate::NotSent })));
    bench.start(write(0x270F));
    while !bench.out.service_bit() {
        bench.poll(5);
    }
    assert_eq!(bench.session.abandon(), Some(Outcome::GivenUp(GivenUp { fate: Fate::Unknown })));
    assert!(bench.session.is_resting());
}

#[test]
fn what_is_given_up_says_how_far_it_had_come() {
    let mut bench = Bench::direct();
    bench.start(write(0x270F));
    bench.session.give_up(bench.now);
    assert_eq!(bench.poll(5), Some(Outcome::GivenUp(GivenUp { fate: Fate::NotSent })));
    assert!(!bench.out.service_bit());

    bench.start(write(0x270F));
    while !bench.out.service_bit() {
        bench.poll(5);
    }
    bench.session.give_up(bench.now);
    bench.poll(5);
    assert!(!bench.out.service_bit());
    let reply = Reply { data: 0x270F, error: false };
    bench.poll(0xC200_270F);
    bench.poll(0xC200_270F);
    assert_eq!(bench.poll(5), Some(Outcome::GivenUp(GivenUp { fate: Fate::CarriedOut(reply) })));
}

#[test]
fn one_service_at_a_time() {
    let mut bench = Bench::direct();
    bench.start(read());
    assert_eq!(bench.session.start(bench.now, read()), Err(Busy));
}

#[test]
fn a_service_bit_that_stands_on_the_bus_is_not_put_out_again() {
    let mut session = Session::new(Timing::DIRECT, OutWord(0xC600_0001));
    let (out, _) = session.cycle(Instant(1), None);
    assert_eq!(out, OutWord(0x4600_0001));
}

proptest! {
    /// Whatever a bus brings, a session comes to an end, raises the service bit for its own request only, and never
    /// calls done what was not replied.
    #[test]
    fn any_words_lead_to_an_outcome_that_is_true(
        words in prop::collection::vec(prop_oneof![
            Just(None),
            Just(Some(0x8200_1234)),
            Just(Some(0xA200_1234)),
            Just(Some(5)),
            Just(Some(0x2000_0005)),
            any::<u32>().prop_map(Some),
        ], 1..60),
        gateway: bool,
    ) {
        let mut bench = if gateway { Bench::gateway() } else { Bench::direct() };
        bench.session.timing.patience = Duration(20 * MS);
        bench.start(read());
        let mut seen = Vec::new();
        let mut outcome = None;
        for word in words.iter().cycle().take(200) {
            prop_assert!(bench.out == OutWord(0x0200_0000) || bench.out == OutWord(0x8200_0000));
            // A poll that failed says neither yes nor no.
            if bench.out.service_bit() {
                seen.extend(*word);
            }
            outcome = bench.poll_or_not(word.map(|word| (word, MS)));
            if outcome.is_some() {
                break;
            }
        }
        prop_assert!(!bench.out.service_bit(), "the bit is never left");
        match outcome {
            Some(Outcome::Done { reply, .. }) => {
                let word = 0x8200_0000 | reply.data | u32::from(reply.error) << 29;
                prop_assert!(seen.windows(2).any(|two| two == [word, word]));
            }
            Some(Outcome::TimedOut(_)) => {}
            other => prop_assert!(false, "{other:?}"),
        }
    }
}

#[test]
fn the_next_look_is_told_with_its_reason() {
    let timing = Timing { settle: Duration::from_millis(8), ..Timing::DIRECT };
    let mut bench = Bench::new(timing);
    bench.start(read());
    let look = |within_us, why| NextLook { within: Duration::from_micros(within_us), why };
    assert_eq!(bench.session.next_look(), look(2_000, LookFor::Settling));
    assert_eq!(bench.poll_or_not(None), None);
    assert_eq!(bench.session.next_look(), look(4_000, LookFor::Recovery));
    while !bench.out.service_bit() {
        assert_ne!(bench.session.next_look().why, LookFor::Reply);
        assert_eq!(bench.poll(7), None);
    }
    assert_eq!(bench.session.next_look(), look(800, LookFor::Reply));
    let far = Timing { settle: Duration::from_millis(1_000), ..timing };
    assert_eq!(far.next_look(LookFor::Reply), look(1_000, LookFor::Reply));
}
