#![allow(clippy::panic, clippy::float_cmp, reason = "a test may panic")]

use super::*;
use crate::bus::{Cause, Cycle, Link, Settling};
use crate::history::RingNews;
use crate::judge::{Blind, Ring, Tolerance};
use encoring_host::referee::Ruling;
use encoring_host::validity::Why;
use encoring_words::model::Sensor;
use encoring_words::{Duration, ErrorStatus, Model, Parameter};
use std::collections::VecDeque;
use std::io::ErrorKind;

const STALE: Tolerance = Tolerance::of_sheet(Duration::from_millis(100));
const EVERY: Plan = Plan { every: Duration::from_millis(100), lasting: None };
/// Often enough for ten turns.
const OFTEN: Plan = Plan { every: Duration::from_millis(5), lasting: None };

fn mark() -> Arc<AtomicBool> {
    Arc::new(AtomicBool::new(false))
}

/// A bus that shows what it is told, one word after the other.
struct Script {
    now: Instant,
    /// IN words of position 0, or why there is none.
    words: VecDeque<Result<u32, BusError>>,
    out: Result<OutWord, BusError>,
    /// OUT words that are shown before that one.
    outs: VecDeque<u32>,
    asked_out: u32,
    cycles: Vec<(usize, usize)>,
    writes: u32,
    events: Vec<LinkEvent>,
    /// What the master says, and at last for ever.
    says: VecDeque<Result<Diagnosis, BusError>>,
}

impl Script {
    fn new(words: impl IntoIterator<Item = Result<u32, BusError>>) -> Self {
        Self {
            now: Instant::ZERO,
            words: words.into_iter().collect(),
            out: Ok(OutWord(0)),
            outs: VecDeque::new(),
            asked_out: 0,
            cycles: Vec::new(),
            writes: 0,
            events: Vec::new(),
            says: VecDeque::new(),
        }
    }
}

impl Bus for Script {
    fn now(&self) -> Instant {
        self.now
    }

    fn out(&mut self, _position: usize) -> Result<OutWord, BusError> {
        self.asked_out += 1;
        self.outs.pop_front().map_or_else(|| self.out.clone(), |out| Ok(OutWord(out)))
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        self.writes += u32::from(write.is_some());
        self.cycles.push((first, input.len()));
        self.now = self.now + Duration::from_millis(1);
        let word = self.words.pop_front().unwrap_or(Ok(0))?;
        input.iter_mut().for_each(|input| *input = InWord(word));
        Ok(Cycle { at: self.now, age: Duration::from_millis(1) })
    }

    fn wait(&mut self, span: Duration) {
        self.now = self.now + span;
    }

    fn settling(&self) -> Settling {
        Settling { cycles: 1, time: Duration::ZERO }
    }

    fn diagnosis(&mut self) -> Result<Diagnosis, BusError> {
        match self.says.len() {
            0 => Ok(Diagnosis::default()),
            1 => self.says[0].clone(),
            _ => self.says.pop_front().unwrap(),
        }
    }

    fn link_event(&mut self) -> Option<LinkEvent> {
        self.events.pop()
    }
}

/// What a judge makes of one word after the other, 5 ms apart.
fn verdicts(judge: Judge, words: impl IntoIterator<Item = Result<u32, BusError>>) -> Vec<Judgement> {
    let mut script = Script::new(words);
    let polls = script.words.len();
    let subjects = vec![Subject { position: 0, judge }];
    let mut watch = Watch::new(&mut script, subjects, OFTEN, mark());
    (0..polls).map(|_| watch.poll().unwrap().sights[0].verdict.clone()).collect()
}

fn blind(model: Model) -> Judge {
    Judge::new(model, None, &[], STALE).unwrap()
}

/// 10 turns of 1000 steps.
fn ten_turns() -> Judge {
    let values = [
        (Parameter::CountingDirection, 0),
        (Parameter::MeasuringLength, 9_999),
        (Parameter::Numerator, 10),
        (Parameter::Denominator, 1),
    ];
    Judge::new(Model::Ce65M, None, &values, STALE).unwrap()
}

const LOST: BusError = BusError::NoConnection(Cause::System(ErrorKind::ConnectionRefused));

#[test]
fn it_never_writes_and_reads_neighbours_together() {
    let mut script = Script::new([]);
    let at = [5, 0, 1, 2, 1].map(|position| Subject { position, judge: blind(Model::La66) });
    let mut watch = Watch::new(&mut script, at.to_vec(), EVERY, mark());
    let positions: Vec<_> = watch.poll().unwrap().sights.iter().map(|sight| sight.position).collect();
    assert_eq!(positions, [0, 1, 2, 5]);
    assert_eq!((script.cycles, script.asked_out, script.writes), (vec![(0, 3), (5, 1)], 4, 0));
}

#[test]
fn a_gateway_that_does_not_tell_the_out_words_is_asked_once() {
    let refused = BusError::client(Answered::Refused, std::fmt::Error);
    for (error, asked) in [(refused, 1), (BusError::NoAnswer { within: Duration::from_millis(100) }, 3)] {
        let mut script = Script { out: Err(error), ..Script::new([]) };
        let at = [0, 1].map(|position| Subject { position, judge: blind(Model::La66) });
        let mut watch = Watch::new(&mut script, at.to_vec(), EVERY, mark());
        for _ in 0..3 {
            let sight = &watch.poll().unwrap().sights[0];
            assert_eq!((sight.out, sight.phase(), &sight.verdict), (None, None, &Judgement::Unchecked(0)));
        }
        assert_eq!(script.asked_out, asked);
    }
}

#[test]
fn a_failed_poll_is_told_and_the_next_is_made_all_the_same() {
    let event = LinkEvent { at: Instant(7), what: Link::Up { down_for: Duration::ZERO } };
    let mut script = Script { events: vec![event.clone()], ..Script::new([Ok(5), Err(LOST), Ok(6)]) };
    let at = vec![Subject { position: 0, judge: ten_turns() }];
    let mut watch = Watch::new(&mut script, at, OFTEN, mark());
    assert!(!watch.is_unanswered());
    assert_eq!(watch.poll().unwrap().link, [event]);
    let poll = watch.poll().unwrap();
    let sight = &poll.sights[0];
    assert_eq!((sight.input, sight.out, sight.age), (None, None, None));
    assert_eq!((&sight.verdict, poll.link.len()), (&Judgement::NoAnswer(LOST), 0));
    assert_eq!(watch.poll().unwrap().sights[0].verdict, Judgement::Valid(6));
}

#[test]
fn polls_that_never_brought_a_word_are_known() {
    let mut script = Script::new([Err(LOST), Ok(5)]);
    let at = vec![Subject { position: 0, judge: ten_turns() }];
    let mut watch = Watch::new(&mut script, at, EVERY, mark());
    watch.poll();
    assert!(watch.is_unanswered());
    watch.poll();
    assert!(!watch.is_unanswered());
}

#[test]
fn it_stops_when_it_is_told_to_and_after_its_time() {
    let stop = mark();
    let mut script = Script::new([]);
    let at = || vec![Subject { position: 0, judge: blind(Model::La66) }];
    let long = Plan { every: Duration::from_secs(1_000_000), lasting: None };
    let mut watch = Watch::new(&mut script, at(), long, Arc::clone(&stop));
    assert!(watch.poll().is_some());
    stop.store(true, Ordering::Relaxed);
    assert!(watch.poll().is_none());
    assert!(script.now < Instant(1_000_000_000));
    let plan = Plan { lasting: Some(Duration::from_secs(1)), ..EVERY };
    let mut watch = Watch::new(&mut script, at(), plan, mark());
    let polls = std::iter::from_fn(|| watch.poll().map(|poll| poll.number)).count();
    assert_eq!(polls, 10);
}

#[test]
fn a_late_poll_is_not_made_up_for() {
    let mut script = Script::new([]);
    let at = vec![Subject { position: 0, judge: blind(Model::La66) }];
    let mut watch = Watch::new(&mut script, at, EVERY, mark());
    watch.poll();
    watch.bus.now = Instant(10_000_000_000);
    let late: Vec<u64> = (0..3).map(|_| watch.poll().unwrap().at.as_nanos() / 1_000_000).collect();
    assert_eq!(late, [10_001, 10_101, 10_201]);
}

#[test]
fn the_phases_are_those_of_bit_31_in_both_words() {
    for (out, input, name) in [
        (0, 0, "normal"),
        (0x8200_0000, 0x0000_1234, "requested"),
        (0x8200_0000, 0x8200_270F, "acknowledged"),
        (0x0200_0000, 0x8200_270F, "ending"),
    ] {
        assert_eq!(HandshakePhase::of(OutWord(out), InWord(input)).name(), name);
    }
}

#[test]
fn with_all_parameters_everything_is_judged() {
    let words = [0, 9_999, 10_000, 0x0100_0000, 0x2000_0000, 0x8200_270F, 1].map(Ok);
    let found: Vec<_> = verdicts(ten_turns(), words).iter().map(Judgement::word).collect();
    let range = "implausible_range";
    assert_eq!(found, ["valid", "valid", range, "implausible_bits", "faulty", "in_service", "valid"]);
    let mut script = Script::new([0, 5_000].map(Ok));
    let at = vec![Subject { position: 0, judge: ten_turns() }];
    let mut watch = Watch::new(&mut script, at, OFTEN, mark());
    watch.poll();
    let sight = &watch.poll().unwrap().sights[0];
    assert!(matches!(sight.verdict, Judgement::Implausible(Why::Speed { .. })), "{sight:?}");
    assert!(matches!(sight.stop, Some(Stop::Implausible(Why::Speed { .. }))));
}

#[test]
fn without_parameters_nothing_is_called_valid_or_wrongly_implausible() {
    for model in encoring_words::model::MODELS {
        let words = [0, 0xFF_FFFF, 0x80_0000, 1, 0x12_3456].map(Ok);
        let found = verdicts(blind(model), words);
        assert_eq!(found, [0, 0xFF_FFFF, 0x80_0000, 1, 0x12_3456].map(Judgement::Unchecked), "{model}");
        let found = verdicts(blind(model), [0x4000_0000, 0x2000_0001, 0x8800_0000].map(Ok));
        let found: Vec<_> = found.iter().map(Judgement::word).collect();
        assert_eq!(found, ["implausible_bits", "faulty", "in_service"], "{model}");
    }
    assert_eq!(blind(Model::Ce65M).blind(), [Blind::Code, Blind::Range, Blind::Motion]);
    assert_eq!(blind(Model::Ce100M).blind(), [Blind::Range, Blind::Motion]);
    assert_eq!(blind(Model::La66).blind(), [Blind::Range, Blind::Motion]);
}

#[test]
fn the_measuring_length_alone_is_enough_to_judge_the_range() {
    let judge = Judge::new(Model::Ce100M, None, &[(Parameter::MeasuringLength, 9_999)], STALE).unwrap();
    assert_eq!(judge.blind(), [Blind::Motion]);
    let found = verdicts(judge, [0, 9_999, 10_000].map(Ok));
    assert_eq!(found[..2], [Judgement::Unchecked(0), Judgement::Unchecked(9_999)]);
    assert!(matches!(found[2], Judgement::Implausible(Why::Range { .. })));
    // Not while the code is unknown: 9999 in Gray code is 13448.
    let judge = Judge::new(Model::Ce65M, None, &[(Parameter::MeasuringLength, 9_999)], STALE).unwrap();
    assert_eq!(verdicts(judge, [Ok(13_448)]), [Judgement::Unchecked(13_448)]);
}

#[test]
fn values_that_no_encoder_has_are_refused() {
    for values in [
        [(Parameter::MeasuringLength, 99_999), (Parameter::Numerator, 1), (Parameter::Denominator, 1)],
        [(Parameter::MeasuringLength, 1), (Parameter::Numerator, 1), (Parameter::Denominator, 1)],
        [(Parameter::MeasuringLength, 99), (Parameter::Numerator, 0), (Parameter::Denominator, 1)],
    ] {
        assert!(Judge::new(Model::Ce100M, None, &values, STALE).is_err(), "{values:?}");
    }
    // 8192 steps per turn are an option, and are assumed where the values need them.
    let values =
        [(Parameter::MeasuringLength, 8_191), (Parameter::Numerator, 1), (Parameter::Denominator, 1)];
    assert!(Judge::new(Model::Ce65M, None, &values, STALE).is_ok());
    let sensor = Some(Sensor::Rotary { steps_per_turn: 4096 });
    let all = [&values[..], &[(Parameter::CountingDirection, 0)]].concat();
    assert!(Judge::new(Model::Ce65M, None, &all, STALE).is_ok());
    assert!(Judge::new(Model::Ce65M, sensor, &all, STALE).is_err());
}

#[test]
fn the_reply_to_a_data_check_tells_the_status() {
    let found = verdicts(ten_turns(), [0x2000_0001, 0xA800_0080, 0x2000_0001].map(Ok));
    let unknown = ErrorStatus::UNKNOWN_COMMAND;
    assert_eq!(
        found,
        [Judgement::Faulty(None), Judgement::Faulty(Some(unknown)), Judgement::Faulty(Some(unknown))]
    );
}

#[test]
fn after_somebody_has_written_parameters_what_was_known_counts_no_longer() {
    let mut judge = ten_turns();
    let mut see = |word: u32| {
        let seen = Seen { input: InWord(word), age: Duration::ZERO };
        judge.judge(Instant(1), Ok(seen), Ring::Runs).0
    };
    assert_eq!(see(1), Judgement::Valid(1));
    // A refused write changes nothing, nor does a read.
    assert_eq!(see(0xE200_0000).word(), "faulty");
    assert_eq!(see(0x8200_270F), Judgement::InService);
    assert_eq!(see(1), Judgement::Valid(1));
    assert_eq!(see(0xC200_FFFF), Judgement::InService);
    assert_eq!(see(50_000), Judgement::Unchecked(50_000));
    assert!(judge.blind().contains(&Blind::Changed));
    assert_eq!(judge.measuring_length(), None);
}

#[test]
fn after_a_preset_adjustment_the_next_position_is_taken_as_it_comes() {
    let mut judge = ten_turns();
    let mut see = |ms: u64, word: u32| {
        let seen = Seen { input: InWord(word), age: Duration::ZERO };
        judge.judge(Instant(ms * 1_000_000), Ok(seen), Ring::Runs).0
    };
    assert_eq!(see(0, 0), Judgement::Valid(0));
    assert!(matches!(see(1, 5_000), Judgement::Implausible(Why::Speed { .. })));
    assert_eq!(see(2, 0), Judgement::Valid(0));
    assert_eq!(see(3, 0xC600_1388), Judgement::InService);
    assert_eq!(see(4, 5_000), Judgement::Valid(5_000));
}

#[test]
fn a_jump_stays_marked_until_the_position_is_back_or_somebody_acknowledges_it() {
    let mut judge = ten_turns();
    let see = |judge: &mut Judge, k: u64, value: u32| {
        let seen = Seen { input: InWord(value), age: Duration::ZERO };
        judge.judge(Instant(k * 2_000_000), Ok(seen), Ring::Runs).0.word()
    };
    see(&mut judge, 0, 0);
    for k in 1..1_000 {
        assert_eq!(see(&mut judge, k, 5_000), "implausible_speed", "{k}");
    }
    assert_eq!(see(&mut judge, 1_000, 0), "valid");
    assert!(!judge.acknowledge());
    assert_eq!(see(&mut judge, 1_001, 5_000), "implausible_speed");
    assert!(judge.acknowledge());
    assert_eq!(see(&mut judge, 1_002, 5_000), "valid");
}

/// 4096 turns of 4096 steps, as from the factory.
fn factory() -> Judge {
    let values = [
        (Parameter::CountingDirection, 0),
        (Parameter::MeasuringLength, 0xFF_FFFF),
        (Parameter::Numerator, 4_096),
        (Parameter::Denominator, 1),
    ];
    Judge::new(Model::Ce65M, Some(Sensor::Rotary { steps_per_turn: 4096 }), &values, STALE).unwrap()
}

/// What `watch` and `log` do unless they are told otherwise.
const DEFAULTS: Plan = Plan { every: Duration::from_millis(10), lasting: None };

#[test]
fn a_jump_of_16_turns_is_caught_at_the_defaults_and_stays_marked_for_minutes() {
    let far = 1_000_000 + 16 * 4_096;
    let words = [vec![1_000_000; 3], vec![far; 20_000], vec![1_000_000; 2]].concat();
    let mut script = Script::new(words.into_iter().map(Ok));
    let mut watch =
        Watch::new(&mut script, vec![Subject { position: 0, judge: factory() }], DEFAULTS, mark());
    let mut see = || watch.poll().unwrap().sights[0].verdict.word();
    for _ in 0..3 {
        assert_eq!(see(), "valid");
    }
    for poll in 0..20_000 {
        assert_eq!(see(), "implausible_speed", "{poll}");
    }
    assert_eq!([see(), see()], ["valid"; 2], "it is back");
}

#[test]
fn a_second_jump_from_a_marked_place_is_no_return() {
    let turns = |turns: u32| 1_000_000 + turns * 4_096;
    let words = [vec![turns(0); 3], vec![turns(16); 500], vec![turns(32); 500]].concat();
    let mut script = Script::new(words.into_iter().map(Ok));
    let mut watch =
        Watch::new(&mut script, vec![Subject { position: 0, judge: factory() }], DEFAULTS, mark());
    let found: Vec<_> = (0..1_003).map(|_| watch.poll().unwrap().sights[0].verdict.word()).collect();
    assert!(found[3..].iter().all(|word| *word == "implausible_speed"));
    watch.acknowledge();
    let poll = watch.poll().unwrap();
    assert_eq!(poll.acknowledged, [0]);
    assert!(watch.poll().unwrap().acknowledged.is_empty());
}

#[test]
fn polls_between_which_half_of_the_range_can_be_travelled_leave_a_position_unchecked_and_say_why() {
    let ten_turns_slower = |max_rpm| {
        let values = [
            (Parameter::CountingDirection, 0),
            (Parameter::MeasuringLength, 9_999),
            (Parameter::Numerator, 10),
            (Parameter::Denominator, 1),
        ];
        Judge::new(Model::Ce65M, None, &values, Tolerance { max_rpm, ..STALE }).unwrap()
    };
    for (max_rpm, every_ms, word) in [
        (None, 10, "valid"),
        (None, 100, "unchecked"),
        (std::num::NonZeroU32::new(1_000), 100, "valid"),
        (std::num::NonZeroU32::new(1_000), 1_000, "unchecked"),
    ] {
        let mut script = Script::new([Ok(5), Ok(6)]);
        let plan = Plan { every: Duration::from_millis(every_ms), lasting: None };
        let at = vec![Subject { position: 0, judge: ten_turns_slower(max_rpm) }];
        let mut watch = Watch::new(&mut script, at, plan, mark());
        assert_eq!(watch.poll().unwrap().sights[0].verdict.word(), "valid", "the first is taken as it comes");
        assert_eq!(watch.poll().unwrap().sights[0].verdict.word(), word, "{every_ms}");
        let slow = watch.subjects()[0].judge.blind() == [Blind::Slow];
        assert_eq!(slow, word == "unchecked");
    }
}

#[test]
fn a_ring_that_stands_takes_the_numbers_away_and_is_told_once_until_it_runs() {
    let says = |status, parameter| Ok(Diagnosis { status: Some(status), parameter: Some(parameter) });
    let stopped = [says(0x1090, 0x0BDF), says(0x1094, 0x0300), says(0x1094, 0x0300)];
    let refused = BusError::client(Answered::Refused, std::fmt::Error);
    let all =
        [&[says(0x00E0, 0)][..], &stopped, &[Err(refused.clone()), Err(refused), says(0x00E0, 0)]].concat();
    let mut script = Script { says: all.into(), ..Script::new([5; 7].map(Ok)) };
    let at = vec![Subject { position: 0, judge: factory() }];
    let mut watch = Watch::new(&mut script, at, DEFAULTS, mark());
    let mut seen = Vec::new();
    for _ in 0..7 {
        let poll = watch.poll().unwrap();
        let news = match poll.ring {
            None => "",
            Some(RingNews::Stopped(_)) => "stopped",
            Some(RingNews::Says(_)) => "says",
            Some(RingNews::Runs { .. }) => "runs",
            Some(RingNews::Unread(_)) => "unread",
            Some(RingNews::FaultyCycle(_)) => "faulty",
        };
        let sight = &poll.sights[0];
        assert!(sight.stop.is_none(), "{sight:?}");
        seen.push((sight.verdict.word(), sight.verdict.value(), news));
    }
    assert_eq!(
        seen,
        [
            ("valid", Some(5), ""),
            ("ring_stopped", None, "stopped"),
            ("ring_stopped", None, "says"),
            ("ring_stopped", None, ""),
            ("unchecked", Some(5), "unread"),
            ("unchecked", Some(5), ""),
            // Told when it has run for a second.
            ("valid", Some(5), ""),
        ]
    );
}

#[test]
fn that_the_next_attempt_is_not_due_hides_no_answer_that_was_none() {
    let waiting = || {
        let next = Duration::from_millis(100);
        Err(BusError::NoConnection(Cause::Waiting { last: ErrorKind::InvalidData, next }))
    };
    let garbled = Err(BusError::client(Answered::Garbled, std::fmt::Error));
    let words = [waiting(), garbled, waiting(), Ok(5), waiting()];
    let told = verdicts(blind(Model::Ce65M), words);
    let (none, no_answer) = ("no_answer_no_connection", "no_answer_garbled");
    let told: Vec<_> = told.iter().map(Judgement::word).collect();
    assert_eq!(told, [none, no_answer, no_answer, "unchecked", none]);
}

#[test]
fn every_verdict_has_one_word_of_its_own() {
    let mut words = Judgement::WORDS.to_vec();
    words.sort_unstable();
    words.dedup();
    assert_eq!(words.len(), Judgement::WORDS.len());
    assert!(words.iter().all(|word| word.bytes().all(|byte| byte == b'_' || byte.is_ascii_lowercase())));
    assert_eq!(Judgement::NoAnswer(LOST).word(), "no_answer_no_connection");
    assert_eq!(
        Judgement::NoAnswer(BusError::NoEncoder { position: 0, encoders: 0 }).word(),
        "no_answer_no_encoder"
    );
}

/// What is found of whoever writes OUT, by polls that see these words one after the other and then end.
fn found(words: &[(u32, u32)]) -> Vec<(HandshakeRule, Ruling)> {
    let mut bus = Script::new(words.iter().map(|(_, input)| Ok(*input)));
    bus.outs = words.iter().map(|(out, _)| *out).collect();
    let subjects = vec![Subject { position: 0, judge: blind(Model::Ce65M) }];
    let mut watch = Watch::new(&mut bus, subjects, EVERY, mark());
    let mut found = Vec::new();
    for _ in words {
        let poll = watch.poll().unwrap();
        assert!(poll.findings.iter().all(|(position, _)| *position == 0));
        found.extend(poll.findings.iter().map(|(_, finding)| (finding.rule, finding.verdict)));
    }
    let end = watch.end();
    assert!(end.sights.is_empty() && end.number == words.len() as u64);
    found.extend(end.findings.iter().map(|(_, finding)| (finding.rule, finding.verdict)));
    found
}

/// A service as polls see it that look at each of its steps.
fn service(out: u32) -> [(u32, u32); 5] {
    let rest = out & 0x7FFF_FFFF;
    [(rest, 0x64), (out, 0x64), (out, out), (rest, out), (rest, 0x64)]
}

// [R38], [R143], [R97]
#[test]
fn what_stands_for_long_or_is_written_in_a_circle_is_told_of_whoever_writes_out() {
    let dropped = service(0xC600_0005);
    let stands = [&dropped[..3], &[dropped[2]; 101]].concat();
    assert_eq!(found(&stands), [(HandshakeRule::NeverDropped, Ruling::Suspected)]);
    // Ten seconds are not over, but nothing more comes, and one is.
    assert_eq!(found(&stands[..20]), [(HandshakeRule::NeverDropped, Ruling::Suspected)]);
    assert_eq!(found(&stands[..10]), []);
    let ignored = [(0, 0x64), (0, 0x2000_0064)].into_iter().chain([(0, 0x2000_0064); 12]).collect::<Vec<_>>();
    assert_eq!(found(&ignored), [(HandshakeRule::ErrorIgnored, Ruling::Suspected)]);
    assert_eq!(found(&ignored[..8]), []);
    let writes =
        |step: u32| (0..12_u32).flat_map(move |k| service(0xC200_2000 + k * step)).collect::<Vec<_>>();
    assert_eq!(found(&writes(1)), [(HandshakeRule::MemoryWear, Ruling::Broken)]);
    assert_eq!(found(&writes(0)), [(HandshakeRule::EqualWrites, Ruling::Note)]);
    assert_eq!(found(&writes(1)[..40]), []);
}

#[test]
fn beside_words_that_no_encoder_sends_nothing_is_said_of_whoever_writes_out() {
    // A shaft that passes 2000h in its lower half, which a gateway exchanges with the upper one.
    let turned = (0x1FF0..0x2050_u32).map(|low| (0, low << 16)).collect::<Vec<_>>();
    assert_eq!(found(&turned), []);
    let mut bus = Script::new([Ok(0x1F00_0000), Ok(0x2000_0000)]);
    let subjects = vec![Subject { position: 0, judge: blind(Model::Ce65M) }];
    let mut watch = Watch::new(&mut bus, subjects, EVERY, mark());
    let ways = [0, 1].map(|_| {
        watch.poll().unwrap();
        watch.misread(0)
    });
    assert_eq!(ways, [Some(Misread::Halves); 2]);
}

#[test]
fn what_a_right_program_could_look_like_between_two_polls_is_not_told() {
    // The number comes with the bit, the bit falls before a reply was seen, and the data change.
    assert_eq!(
        found(&[(0, 0x64), (0xC600_0005, 0x64), (0xC600_0007, 0x64), (0x4600_0007, 0x64), (0, 0x64)]),
        []
    );
}
