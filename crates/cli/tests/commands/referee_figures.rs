//! `docs/referee/`: a figure of each rule, a program that keeps it above one that breaks it. The traces are judged here, and
//! drawn; a figure that differs is written anew and reviewed as a diff.

use encoring_figure::{Lane, LaneLevel, TimingFigure};
use encoring_host::referee::{HandshakeRule, LineSeen, Observed, RULES, Referee, Vantage};
use encoring_words::{InWord, Instant, Model, OutWord, Written};

/// So long OUT is put out so and the image shows that; OUT is written at the beginning.
#[derive(Clone, Copy)]
struct Step {
    ms: u64,
    written: Written,
    input: u32,
    line: LineSeen,
}

const POSITION: u32 = 0x64;

fn step(ms: u64, out: u32, input: u32) -> Step {
    Step { ms, written: Written::Both(OutWord(out)), input, line: LineSeen::Good }
}

/// A service with its five steps, each so long; an error bit in the reply stands behind it too.
fn service(ms: u64, word: u32, reply: u32) -> Vec<Step> {
    service_at(POSITION, ms, word, reply)
}

/// The same at a position; a preset adjustment makes another one of it.
fn service_at(position: u32, ms: u64, word: u32, reply: u32) -> Vec<Step> {
    let becomes = if reply >> 24 == 0xC6 { reply & 0x00FF_FFFF } else { position };
    let (rest, after) = (word & 0x7FFF_FFFF, becomes | reply & 0x2000_0000);
    vec![
        step(ms, rest, position),
        step(ms, word, position),
        step(ms, word, reply),
        step(ms, rest, reply),
        step(ms, rest, after),
    ]
}

fn write(ms: u64, word: u32) -> Vec<Step> {
    service(ms, word, word)
}

/// What a program does that keeps the rule, what one that breaks it, and what to look at there: the step, and why.
fn traces(rule: HandshakeRule) -> (Vec<Step>, Vec<Step>, usize, &'static str) {
    let preset = || write(4, 0xC600_0005);
    let half = |written, input| Step { ms: 4, written, input, line: LineSeen::Good };
    let idle = |ms, input| vec![step(ms, 0, input)];
    let replaced = |mut steps: Vec<Step>, at: usize, with: &[Step]| {
        steps.splice(at..=at, with.iter().copied());
        steps
    };
    match rule {
        HandshakeRule::TornWords => {
            let torn = [half(Written::High(0xC600), POSITION), half(Written::Low(5), POSITION)];
            let steps = replaced(preset(), 1, &torn);
            (
                preset(),
                replaced(steps, 0, &idle(4, POSITION)),
                2,
                "the second half comes when the encoder may have read the first",
            )
        }
        HandshakeRule::DataWithServiceBit => (
            preset(),
            replaced(preset(), 0, &idle(4, POSITION)),
            1,
            "number, data and service bit change at once",
        ),
        HandshakeRule::DataChangedInService => {
            let changed = [step(4, 0xC600_0005, POSITION), step(4, 0xC600_0007, POSITION)];
            (preset(), replaced(preset(), 1, &changed), 2, "the data change before the reply is there")
        }
        HandshakeRule::DroppedBeforeAcknowledgement => {
            let steps = [
                step(4, 0x4600_0005, POSITION),
                step(8, 0xC600_0005, POSITION),
                step(8, 0x4600_0005, POSITION),
            ];
            (preset(), steps.to_vec(), 2, "no reply has come yet")
        }
        HandshakeRule::Withdrawn => {
            let steps = [(200, 0x4600_0005), (1_200, 0xC600_0005), (300, 0x4600_0005)];
            let steps = steps.map(|(ms, out)| step(ms, out, POSITION)).to_vec();
            (write(200, 0xC600_0005), steps, 2, "after more than a second without a reply: a note")
        }
        HandshakeRule::NeverDropped => {
            let long = [step(11_000, 0xC600_0005, 0xC600_0005)];
            (
                write(900, 0xC600_0005),
                replaced(write(900, 0xC600_0005), 2, &long),
                2,
                "10 s after its reply the bit still stands, and there is no position",
            )
        }
        HandshakeRule::NextBeforeEnd => {
            let hasty = [
                step(4, 0x0200_0000, POSITION),
                step(4, 0x8200_0000, POSITION),
                step(4, 0x8200_0000, 0x8200_270F),
            ];
            let next = [
                step(4, 0x0800_0000, 0x8200_270F),
                step(4, 0x8800_0000, 0x8200_270F),
                step(4, 0x8800_0000, 0x8800_0000),
            ];
            let end = [step(4, 0x0800_0000, 0x8800_0000), step(4, 0x0800_0000, POSITION)];
            let steps = [&hasty[..], &next, &end].concat();
            (
                [service(4, 0x8200_0000, 0x8200_270F), write(4, 0x8800_0000)].concat(),
                steps,
                4,
                "IN bit 31 still belongs to the service before",
            )
        }
        HandshakeRule::ForeignReply => (
            preset(),
            service(4, 0xC600_0005, 0xC600_0004),
            3,
            "the reply has other data, and the program takes it for its own",
        ),
        HandshakeRule::NeverAcknowledged => {
            let steps = vec![step(900, 0x4600_0005, POSITION), step(11_000, 0xC600_0005, POSITION)];
            (write(900, 0xC600_0005), steps, 1, "10 s after this there is no reply, and nobody gives up")
        }
        HandshakeRule::NoDataCheck => {
            let length = || write(500, 0xC200_270F);
            (
                [length(), write(500, 0x8800_0000), idle(6_500, POSITION)].concat(),
                [length(), idle(9_000, POSITION)].concat(),
                4,
                "in 10 s from here on no data check (08): the old values count",
            )
        }
        HandshakeRule::StatusNotRead | HandshakeRule::ErrorIgnored => {
            let read = || service(100, 0x8200_0000, 0xA200_270F);
            let check =
                [vec![step(100, 0x0800_0000, POSITION | 1 << 29)], write(100, 0x8800_0000)[1..].to_vec()]
                    .concat();
            let ignored = vec![step(1_200, 0, POSITION | 1 << 29)];
            match rule {
                HandshakeRule::StatusNotRead => (
                    [read(), check].concat(),
                    [read(), ignored].concat(),
                    2,
                    "the reply has bit 29, and in a second from here on nobody asks why (08)",
                ),
                _ => {
                    let stands = || vec![step(100, 0, POSITION), step(200, 0, POSITION | 1 << 29)];
                    (
                        [stands(), check].concat(),
                        [stands(), ignored].concat(),
                        1,
                        "bit 29 stands in normal mode, and in a second from here on nobody asks why (08)",
                    )
                }
            }
        }
        HandshakeRule::OutOfRange => {
            let check = || write(4, 0x8800_0000);
            (
                [write(4, 0xC200_270F), check()].concat(),
                [service(4, 0xC200_0000, 0xE200_0000), check()].concat(),
                1,
                "the model has no measuring length of 0",
            )
        }
        HandshakeRule::UnknownService => (
            service(4, 0x8200_0000, 0x8200_270F),
            [service(4, 0x8700_0000, 0xA700_0000), write(4, 0x8800_0000)].concat(),
            1,
            "no encoder has a service 07",
        ),
        HandshakeRule::WrongDirection => (
            write(4, 0x8800_0000),
            [service(4, 0xC800_0000, 0xE800_0000), write(4, 0x8800_0000)].concat(),
            1,
            "08 is written, and it can only be read",
        ),
        HandshakeRule::MemoryWear | HandshakeRule::EqualWrites => {
            let step = u32::from(rule == HandshakeRule::MemoryWear);
            // The first equal write is a change.
            let writes = (0..11).flat_map(|k| write(40, 0xC200_2000 + k * step)).collect();
            (
                [write(40, 0xC200_2000), write(40, 0x8800_0000)].concat(),
                [writes, write(40, 0x8800_0000)].concat(),
                5 * 9 + 1,
                "02 is written for the tenth time in a row, each time with another value",
            )
        }
        HandshakeRule::Polled => {
            let reads = (0..10).flat_map(|_| service(40, 0x8200_0000, 0x8200_270F)).collect();
            (
                service(40, 0x8200_0000, 0x8200_270F),
                reads,
                5 * 9 + 1,
                "02 is read for the tenth time in a row",
            )
        }
        HandshakeRule::PresetRepeated => (
            preset(),
            [preset(), service_at(5, 4, 0xC600_0005, 0xC600_0005)].concat(),
            6,
            "the same preset adjustment once more",
        ),
        HandshakeRule::PresetWhileMoving => {
            let moved = |k: u32, step: Step| Step { input: POSITION + 10 * k, ..step };
            let moving = (0..5).map(|k| moved(k, step(20, 0, POSITION)));
            let preset = write(20, 0xC600_0005);
            let begun = (5..).zip(&preset[..2]).map(|(k, step)| moved(k, *step));
            let moving = moving.chain(begun).chain(preset[2..].iter().copied()).collect::<Vec<_>>();
            let still = vec![step(100, 0, POSITION)];
            ([still, write(20, 0xC600_0005)].concat(), moving, 6, "the axis still moves")
        }
        HandshakeRule::StaleServiceBit => {
            let silent = |out| Step { line: LineSeen::Silent, ..step(40, out, POSITION) };
            let begun = [step(10, 0x4600_0005, POSITION), step(10, 0xC600_0005, POSITION)];
            let right =
                [&begun[..], &[silent(0xC600_0005), silent(0x4600_0005), step(20, 0x4600_0005, POSITION)]]
                    .concat();
            let wrong = [
                &begun[..],
                &[silent(0xC600_0005), step(20, 0xC600_0005, POSITION), step(10, 0x4600_0005, POSITION)],
            ];
            (right, wrong.concat(), 3, "the ring runs again, and the encoder takes the bit for no request")
        }
    }
}

fn judged(steps: &[Step]) -> Vec<HandshakeRule> {
    let mut referee = Referee::new(Vantage::Writes, Some(Model::Ce65M));
    let (mut at, mut out) = (0, OutWord(0));
    let mut cycle = |referee: &mut Referee, out, input, line| {
        let seen = Observed::Cycle { at: Instant(at * 1_000_000), out, input: Some(InWord(input)), line };
        referee.observe(seen);
        at += 1;
        Instant(at * 1_000_000)
    };
    let mut now = cycle(&mut referee, out, POSITION, LineSeen::Good);
    for Step { ms, written, input, line } in steps {
        out = out.after(*written);
        referee.observe(Observed::Write { at: Instant(now.0 - 1_000_000), client: 1, written: *written });
        for _ in 0..*ms {
            now = cycle(&mut referee, out, *input, *line);
        }
    }
    referee.finish();
    referee.findings().map(|finding| finding.rule).collect()
}

fn lasting(steps: &[Step]) -> u64 {
    steps.iter().map(|step| step.ms * 1_000_000).sum()
}

/// Lines of a program up to the end of the figure, and when its steps begin.
fn lanes(name: &str, steps: &[Step], end: u64) -> (Vec<Lane>, Vec<u64>) {
    let mut bits = ["OUT 31", "IN 31"].map(|bit| Lane::levels(&format!("{name}: {bit}"), LaneLevel::Low));
    let mut words = ["OUT", "IN"].map(|word| Lane::words(&format!("{name}: {word}")));
    let (mut at, mut out) = (0, OutWord(0));
    let mut begins = Vec::new();
    let mut runs: [Vec<(u64, u64, String)>; 2] = Default::default();
    for Step { ms, written, input, line } in steps {
        out = out.after(*written);
        begins.push(at);
        let until = at + ms * 1_000_000;
        bits[0].change(at, out.service_bit().into());
        let silent = *line == LineSeen::Silent;
        bits[1].change(at, if silent { LaneLevel::Unknown } else { (input >> 31 == 1).into() });
        let shown = if silent { "silent".to_owned() } else { InWord(*input).to_string() };
        for (run, text) in runs.iter_mut().zip([out.to_string(), shown]) {
            match run.last_mut() {
                Some((_, to, same)) if *same == text => *to = until,
                _ => run.push((at, until, text)),
            }
        }
        at = until;
    }
    for (lane, run) in words.iter_mut().zip(runs) {
        for (from, to, text) in run {
            lane.word(from, if to == at { end } else { to }, text);
        }
    }
    let ([out_bit, in_bit], [out, input]) = (bits, words);
    (vec![out, out_bit, input, in_bit], begins)
}

fn figure(rule: HandshakeRule) -> String {
    let (right, wrong, at, why) = traces(rule);
    let end = lasting(&right).max(lasting(&wrong));
    let ((kept, _), (broken, begins)) = (lanes("right", &right, end), lanes("wrong", &wrong, end));
    let mut figure = TimingFigure::new(rule.name(), 0, end);
    kept.into_iter().chain(broken).for_each(|lane| figure.lane(lane));
    figure.mark(begins[at], format!("wrong: {why}"));
    figure.svg()
}

/// The name of a rule's figure; the rule of equal writes shares that of changing ones.
fn drawn() -> impl Iterator<Item = HandshakeRule> {
    RULES.into_iter().filter(|rule| *rule != HandshakeRule::EqualWrites)
}

#[test]
fn of_each_pair_of_traces_one_keeps_its_rule_and_the_other_breaks_it() {
    for rule in RULES {
        let (right, wrong, ..) = traces(rule);
        assert_eq!(judged(&right), [], "{}", rule.name());
        // A reply with bit 29 leaves it in normal mode too.
        let also = (rule == HandshakeRule::StatusNotRead).then_some(HandshakeRule::ErrorIgnored);
        let wanted: Vec<_> = [rule].into_iter().chain(also).collect();
        assert_eq!(judged(&wrong), wanted, "{}", rule.name());
    }
}

#[test]
fn the_page_shows_each_rule_as_it_is_drawn() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs");
    let page = std::fs::read_to_string(format!("{folder}/referee.md")).unwrap();
    let mut anew = Vec::new();
    for rule in drawn() {
        let name = format!("referee/{}.svg", rule.name());
        assert!(page.contains(&format!("]({name})")), "docs/referee.md does not show {name}");
        assert!(page.contains(rule.advice()), "docs/referee.md does not say: {}", rule.advice());
        let (path, svg) = (format!("{folder}/{name}"), figure(rule));
        if std::fs::read_to_string(&path).ok().as_ref() != Some(&svg) {
            std::fs::write(&path, svg).unwrap();
            anew.push(name);
        }
    }
    assert!(anew.is_empty(), "written anew, to be looked at: {anew:?}");
}
