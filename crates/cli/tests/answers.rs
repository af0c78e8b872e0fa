//! What `decode` says of a request against what an encoder does with it.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a test may panic")]

use encoring_encoder::{ServiceTimes, Unit};
use encoring_sim::{Node, Surroundings};
use encoring_words::explain::{Answer, Foreign};
use encoring_words::model::{MODELS, Sensor};
use encoring_words::word::{In, Out};
use encoring_words::{ErrorStatus, InWord, Instant, Model, OutWord};

const DATA_CHECK: OutWord = OutWord(0x8800_0000);

fn new(model: Model) -> Node {
    let sensor = match model {
        Model::La66 => Sensor::Linear { rod_um: 500_000 },
        Model::Ce100M | Model::Ce65M => Sensor::Rotary { steps_per_turn: 4096 },
    };
    let mut unit = Unit::new(model, sensor).unwrap();
    unit.service_times = ServiceTimes::ZERO;
    Node::new(unit)
}

/// A request from normal mode, and its reply.
fn ask(node: &mut Node, at: &mut u64, request: OutWord) -> InWord {
    let mut step = |out| {
        *at += 1_000_000;
        node.step(Instant(*at), out, &Surroundings::default()).expect("it is on")
    };
    step(OutWord(0));
    step(request)
}

#[test]
fn the_answer_foretold_is_the_answer_given() {
    let data = [
        0, 1, 2, 7, 8, 0xF, 0x10, 0x1F, 0x20, 0x21, 0x63, 0x64, 0xFFFF, 0x1_0000, 0x01_0108, 0x80_8018,
        0xFF_FF21, 0xFF_FFFF,
    ];
    // Large enough for the factory length with any denominator up to 15.
    const NUMERATOR: u32 = 0xC300_FFFF;
    for model in MODELS {
        for code in 0x80..=0xFF_u32 {
            for data in data {
                let request = OutWord(code << 24 | data);
                let Out::Request(fields) = request.decode() else { panic!("a request") };
                let mut node = new(model);
                let mut at = 0;
                let numerator = ask(&mut node, &mut at, OutWord(NUMERATOR));
                if numerator.error_bit() {
                    // The LA-66 has no numerator.
                    ask(&mut node, &mut at, DATA_CHECK);
                }
                let reply = ask(&mut node, &mut at, request);
                let answer = Answer::to(fields, model);
                // The factory length is the largest value, so no preset is above it.
                assert_eq!(reply.error_bit(), answer.sets_error_bit(), "{model} {request} {answer:?}");
                assert_eq!(Foreign::judge(reply, model), Ok(()), "{model} {request}: {reply}");
                let In::Reply(check) = ask(&mut node, &mut at, DATA_CHECK).decode() else {
                    panic!("a reply")
                };
                let mut expected = match answer {
                    Answer::Invalid { status } | Answer::Refused { status } => status,
                    _ => ErrorStatus::empty(),
                };
                // Legal on its own, the value may still be too much together with the others.
                let shown = ErrorStatus::from_bits_retain(check.data as u16);
                expected |= shown & ErrorStatus::LENGTH_TOO_LARGE;
                assert_eq!(shown, expected, "{model} {request} {answer:?}");
            }
        }
    }
}

#[test]
fn above_the_measuring_length_presets_are_refused_or_found_by_the_check_as_foretold() {
    for (model, request) in [
        (Model::Ce100M, 0xC600_0101),
        (Model::Ce65M, 0xC600_0101),
        (Model::Ce100M, 0xC400_0101),
        (Model::Ce100M, 0xC500_0101),
    ] {
        let mut node = new(model);
        let mut at = 0;
        ask(&mut node, &mut at, OutWord(0xC200_0100));
        ask(&mut node, &mut at, DATA_CHECK);
        let Out::Request(fields) = OutWord(request).decode() else { panic!("a request") };
        let reply = ask(&mut node, &mut at, OutWord(request));
        let In::Reply(check) = ask(&mut node, &mut at, DATA_CHECK).decode() else { panic!("a reply") };
        let (refused, status) = match Answer::to(fields, model) {
            Answer::RefusedAboveLength { status } => (true, status),
            Answer::CheckedAgainstLength { status } => (false, status),
            other => panic!("{model} {request:08X}: {other:?}"),
        };
        assert_eq!(reply.error_bit(), refused, "{model} {request:08X}");
        assert_eq!(check.data, u32::from(status.bits()), "{model} {request:08X}");
    }
}
