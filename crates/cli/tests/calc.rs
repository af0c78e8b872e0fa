//! `encoring calc`, run as a user runs it.
#![allow(clippy::disallowed_methods, reason = "a test reads what was printed")]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, reason = "a test may panic")]

use std::process::Command;

use encoring_encoder::Unit;
use encoring_host::scaling::{Expected, HandshakeWord, Shaft, linear, rotary};
use encoring_sim::{Node, Surroundings};
use encoring_words::model::Sensor;
use encoring_words::word::In;
use encoring_words::{Instant, Model, OutWord};
use serde_json::Value;

/// Exit code, standard output and standard error of `encoring calc` with these words.
fn calc(arguments: &str) -> (Option<i32>, String, String) {
    run(&arguments.split(' ').collect::<Vec<_>>())
}

fn run(arguments: &[&str]) -> (Option<i32>, String, String) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_encoring")).arg("calc").args(arguments).output().expect("it runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn json(arguments: &str) -> Value {
    let (_, out, err) = calc(&format!("{arguments} --format json"));
    assert_eq!((out.lines().count(), err.as_str()), (1, ""), "{arguments}");
    serde_json::from_str(&out).unwrap()
}

#[test]
fn a_zero_that_the_manual_promises_and_a_siblings_does_not_is_told_as_that() {
    for (turns, promised) in [("10", false), ("8191", false), ("8192", true), ("32768", true)] {
        let (code, out, _) = calc(&format!("rotary --steps-per-turn 8 --turns {turns} --native 4096"));
        let out = out.split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(code, Some(0), "{turns}");
        assert!(out.contains("zero can be lost"), "{turns}: {out}");
        assert_eq!(
            out.contains("The manual promises the zero for a power of two"),
            promised,
            "{turns}: {out}"
        );
    }
    let (_, out, _) = calc("rotary --steps-per-turn 8 --turns 4096 --native 4096");
    assert!(out.contains("safe"), "{out}");
}

/// S, N and D.
fn values(answer: &Value) -> [Option<u64>; 3] {
    ["measuring_length", "numerator", "denominator"].map(|key| answer[key]["value"].as_u64())
}

fn refused(arguments: &str, message: &str) {
    let (code, out, err) = calc(arguments);
    assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments}: {err}");
    assert_eq!(err.lines().next(), Some(message), "{arguments}");
}

#[test]
fn the_calculations_of_a_retrofit_as_text() {
    for (name, code, arguments) in [
        ("ten_turns", 0, "rotary --steps-per-turn 1000 --turns 10"),
        ("three_and_a_half_turns", 0, "rotary --steps-per-turn 4096 --turns 3.5"),
        ("millimetres", 0, "rotary --mm-per-turn 5 --resolution-mm 0.01 --turns 7/2 --model ce-100-m"),
        ("no_exact_fraction", 0, "rotary --steps-per-turn 1000 --turns 3.1416 --model ce-65-m"),
        ("all_that_it_has", 0, "rotary --steps-per-turn 8192 --turns 2048 --native 8192"),
        ("too_many_steps", 1, "rotary --steps-per-turn 5000 --turns 10"),
        ("axis", 0, "rotary --travel-mm 50000 --mm-per-turn 3330 --model ce-65-m"),
        ("axis_that_loses_steps", 0, "rotary --travel-mm 3000 --mm-per-turn 1 --native 8192"),
        ("explained", 0, "explain --length 9999 --numerator 10 --mm-per-turn 5 --mm 12.503"),
        (
            "explained_falling",
            0,
            "explain --length 270Fh --numerator 0Ah --direction falling --model ce-65-m",
        ),
        ("explained_too_many_steps", 1, "explain --length 9999 --numerator 1"),
        ("explained_rod", 0, "explain --length 50000 --rod-mm 500 --position 12500"),
        ("rod", 0, "linear --length-mm 500 --resolution-mm 0.01"),
        ("rod_with_a_rest", 0, "linear --length-mm 500 --resolution-mm 0.03"),
    ] {
        let (status, out, err) = calc(arguments);
        assert_eq!((status, err.as_str()), (Some(code), ""), "{arguments}");
        let widest = out.lines().map(str::len).max();
        assert!(widest <= Some(92), "{arguments}: {widest:?}");
        insta::assert_snapshot!(name, out, &format!("encoring calc {arguments}"));
    }
}

#[test]
fn the_same_as_json() {
    for (name, arguments) in [
        ("json_three_and_a_half_turns", "rotary --steps-per-turn 1000 --turns 3.5"),
        ("json_no_exact_fraction", "rotary --mm-per-turn 5 --resolution-mm 0.005 --turns 3.1416"),
        ("json_too_many_steps", "rotary --steps-per-turn 5000 --turns 10"),
        ("json_rod", "linear --length-mm 500 --resolution-mm 0.01"),
    ] {
        let pretty = serde_json::to_string_pretty(&json(arguments)).unwrap();
        insta::assert_snapshot!(name, pretty, &format!("encoring calc {arguments} --format json"));
    }
}

#[test]
fn as_many_decimals_are_taken_as_people_have() {
    let makers = json("rotary --mm-per-turn 13.48073499 --resolution-mm 0.01 --turns 4096");
    assert_eq!(values(&makers), [Some(5_521_708), Some(4096), Some(1)]);
    let long = json("rotary --steps-per-turn 1000 --turns 3.43535355358774");
    assert_eq!(values(&long), [Some(3434), Some(292), Some(85)]);
    let drum = json("rotary --steps-per-turn 1000 --turns 50/3.33");
    assert_eq!(values(&drum), [Some(15_014), Some(1006), Some(67)]);
}

#[test]
fn a_point_that_may_stand_between_thousands_is_refused_with_both_meanings() {
    for (typed, whole) in [("1.000", "1"), ("1,000", "1"), ("999.000", "999")] {
        refused(
            &format!("rotary --steps-per-turn {typed} --turns 1"),
            &format!(
                "error: invalid value '{typed}' for '--steps-per-turn <STEPS>': {whole}.000 can be {whole} or {whole}000: \
                 write the one that is meant"
            ),
        );
    }
    for good in ["1000.000", "20.0", "20.00", "20.0000", "20.500"] {
        assert_eq!(calc(&format!("rotary --steps-per-turn {good} --turns 10")).0, Some(0), "{good}");
    }
}

#[test]
fn the_turns_of_an_axis_are_found_with_a_reserve_and_the_zero_kept() {
    let found = json("rotary --travel-mm 50000 --mm-per-turn 3330");
    assert_eq!(values(&found), [Some(65_535), Some(16), Some(1)]);
    assert_eq!(found["zero"]["safe"], true);
    let proposals = found["axis"]["proposals"].as_array().unwrap();
    let taken: Vec<_> = proposals.iter().filter(|proposal| proposal["taken"] == true).collect();
    assert_eq!(taken.len(), 1);
    assert_eq!((&taken[0]["purpose"], &taken[0]["range_mm"]), (&Value::from("safe"), &Value::from(53_280.0)));
    // A larger reserve needs more turns; a resolution is kept before the zero.
    assert_eq!(
        values(&json("rotary --travel-mm 50000 --mm-per-turn 3330 --reserve-mm 4000"))[1..],
        [Some(1024), Some(63)]
    );
    let fine = json("rotary --travel-mm 3000 --mm-per-turn 1 --resolution-mm 0.0002 --native 8192");
    assert_eq!(values(&fine), [Some(15_749_999), Some(3150), Some(1)]);
    refused(
        "rotary --travel-mm 70000 --mm-per-turn 1",
        "error: --travel-mm 70000 needs 70000 turns and a reserve of 3500 mm; there are 1/99..65535 turns: a gear is needed",
    );
}

/// Numbers that come again with their seed.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }
}

#[test]
fn what_calc_finds_is_explained_back_for_random_ranges() {
    const SEED: u64 = 11;
    let mut numbers = Numbers(SEED);
    let mut explained = 0;
    for _ in 0..60 {
        let steps = format!("{}.{}", 1 + numbers.below(4095), numbers.below(1000));
        let turns = match numbers.below(3) {
            0 => (1 + numbers.below(4096)).to_string(),
            1 => format!("{}/{}", 1 + numbers.below(65_535), 1 + numbers.below(99)),
            _ => format!("{}.{}", numbers.below(4000), 1 + numbers.below(9)),
        };
        let arguments = format!("rotary --steps-per-turn {steps} --turns {turns}");
        let (code, out, _) = calc(&format!("{arguments} --format json"));
        // Too few or too many positions.
        if code == Some(2) {
            continue;
        }
        let found: Value = serde_json::from_str(&out).unwrap();
        let [Some(length), Some(numerator), Some(denominator)] = values(&found) else { panic!("{found}") };
        let back =
            json(&format!("explain --length {length} --numerator {numerator} --denominator {denominator}"));
        let told = format!("seed {SEED}: {arguments}");
        assert_eq!(back["steps_per_turn"], found["steps"]["steps_per_turn"], "{told}");
        assert_eq!(back["turns"], found["fraction"]["turns"], "{told}");
        assert_eq!((&back["zero"], &back["usable"]), (&found["zero"], &found["usable"]), "{told}");
        let requests = found["sequence"].as_array().unwrap().iter();
        let requests: Vec<_> =
            requests.filter(|step| step["phase"] == "request").map(|step| &step["out"]).collect();
        let words: Vec<_> =
            back["words"].as_array().unwrap().iter().skip(1).map(|word| &word["word"]).collect();
        assert_eq!(words, requests[..3], "{told}");
        explained += 1;
    }
    assert!(explained >= 40, "{explained}");
}

#[test]
fn places_and_positions_are_explained_both_ways() {
    let values = "explain --length 9999 --numerator 10 --mm-per-turn 5";
    for (asked, position) in
        [("--mm 12.5", 2_500), ("--degrees 900", 2_500), ("--mm 0", 0), ("--mm 49.995", 9_999)]
    {
        let answer = json(&format!("{values} {asked}"));
        assert_eq!(answer["places"][0]["position"], position, "{asked}");
        assert_eq!(answer["preset"][1]["unsigned"], 0xC600_0000_u32 + position, "{asked}");
        let back = json(&format!("{values} --position {position}"));
        assert_eq!(back["places"], answer["places"], "{asked}");
    }
    for (asked, message) in [
        ("--mm 50", "--mm 50 is beyond the last position, 9999: at 50 mm the position is 0 again"),
        (
            "--degrees 3600",
            "--degrees 3600 is beyond the last position, 9999: at 3600 degrees the position is 0 again",
        ),
        ("--position 10000", "--position 10000 is beyond the last position, 9999"),
    ] {
        refused(&format!("{values} {asked}"), &format!("error: {message}"));
    }
    refused(
        "explain --length 15 --numerator 1",
        "error: --length 15 (Fh) is outside 16..16777215 (10h..FFFFFFh)",
    );
    refused(
        "explain --length 99 --numerator 1 --mm 1",
        "error: --mm needs --mm-per-turn, or --rod-mm of a rod",
    );
}

#[test]
fn the_words_of_the_worked_example_can_be_typed_from_the_screen() {
    let (_, out, _) = calc("rotary --steps-per-turn 1000 --turns 10");
    let words: Vec<Vec<&str>> = out
        .lines()
        .skip_while(|line| !line.contains("high low"))
        .skip(1)
        .take(12)
        .map(|line| line.get(31..).unwrap().split_whitespace().collect())
        .collect();
    assert_eq!(words[0], ["4200270F", "4200", "270F", "position"]);
    assert_eq!(words[1], ["C200270F", "C200", "270F", "C200270F", "C200", "270F"]);
    assert_eq!(words[2], words[0]);
    assert_eq!(words[4][0], "C300000A");
    assert_eq!(words[7][0], "C9000001");
    assert_eq!(words[9], ["08000000", "0800", "0000", "position"]);
    assert_eq!(words[10], ["88000000", "8800", "0000", "88000000", "8800", "0000"]);
    assert_eq!(words[11], words[9]);
}

#[test]
fn millimetres_count_like_the_steps_they_are() {
    let steps = json("rotary --steps-per-turn 500 --turns 7/2");
    let millimetres = json("rotary --mm-per-turn 5 --resolution-mm 0.01 --turns 7/2");
    assert_eq!(values(&millimetres), values(&steps));
    assert_eq!(values(&millimetres), [Some(1749), Some(7), Some(2)]);
    assert_eq!(millimetres["steps"]["resolution_mm"], 0.01);
    assert_eq!(values(&json("linear --length-mm 500 --resolution-mm 0.1")), [Some(0x1388), None, None]);
}

#[test]
fn the_zero_is_judged_with_the_shift_it_would_cause() {
    let shift = |arguments| {
        let zero = json(arguments)["zero"].clone();
        (zero["safe"].as_bool(), zero["shift_turns"].as_f64(), zero["shift_steps"].as_f64())
    };
    assert_eq!(shift("rotary --steps-per-turn 1000 --turns 10"), (Some(false), Some(6.0), Some(6000.0)));
    assert_eq!(shift("rotary --steps-per-turn 4096 --turns 3.5"), (Some(false), Some(1.0), Some(4096.0)));
    assert_eq!(shift("rotary --steps-per-turn 1000 --turns 0.5"), (Some(true), Some(0.0), Some(0.0)));
}

#[test]
fn what_the_encoder_would_refuse_is_shown_without_words_but_with_what_works() {
    let answer = json("rotary --steps-per-turn 5000 --turns 10");
    assert_eq!(answer["usable"], false);
    assert_eq!(answer["sequence"], serde_json::json!([]));
    let fraction = &answer["too_large"]["smallest_fraction"];
    assert_eq!([&fraction["numerator"]["value"], &fraction["denominator"]["value"]], [1001, 82]);
    assert_eq!(answer["too_large"]["largest_measuring_length"]["value"], 40_959);
    assert_eq!(json("rotary --steps-per-turn 5000 --turns 10 --native 8192")["usable"], true);
    assert_eq!(calc("rotary --steps-per-turn 4096.4 --turns 1").0, Some(0), "rounded to 4096");
    assert_eq!(calc("rotary --steps-per-turn 4097 --turns 1").0, Some(1));
}

#[test]
fn the_commands_named_after_a_refusal_give_the_words_of_what_works() {
    for (arguments, kept) in [
        ("rotary --steps-per-turn 5000 --turns 10", [49_999, 40_959]),
        ("rotary --steps-per-turn 4100 --turns 3.1416", [12_879, 12_866]),
        ("rotary --steps-per-turn 9000 --turns 1863 --native 8192", [16_766_999, 15_261_695]),
    ] {
        let (code, out, _) = calc(arguments);
        assert_eq!(code, Some(1), "{arguments}");
        let words = out.split_whitespace().collect::<Vec<_>>().join(" ");
        let commands: Vec<&str> = words
            .match_indices("encoring calc rotary ")
            .map(|(at, start)| {
                let options = &words[at + start.len()..];
                let native = if arguments.contains("--native") { 6 } else { 4 };
                let end = options.match_indices(' ').nth(native - 1).map_or(options.len(), |(end, _)| end);
                &options[..end]
            })
            .collect();
        assert_eq!(commands.len(), 2, "{out}");
        for (command, length) in commands.into_iter().zip(kept) {
            let answer = json(&format!("rotary {command}"));
            assert_eq!(
                (&answer["usable"], values(&answer)[0]),
                (&Value::Bool(true), Some(length)),
                "{command}"
            );
        }
    }
}

#[test]
fn a_decimal_comma_is_refused_with_the_number_to_write() {
    let hint = "write the decimals behind a point:";
    refused(
        "rotary --steps-per-turn 1000 --turns 3,5",
        &format!("error: invalid value '3,5' for '--turns <TURNS>': {hint} 3.5"),
    );
    refused(
        "linear --length-mm 500 --resolution-mm 0,01",
        &format!("error: invalid value '0,01' for '--resolution-mm <MM>': {hint} 0.01"),
    );
    let (code, _, err) = run(&["rotary", "--steps-per-turn", "1000", "--turns", "3, 5"]);
    assert_eq!(code, Some(2));
    assert!(err.ends_with(&format!("{hint} 3.5\n\nFor more information, try '--help'.\n")), "{err}");
}

#[test]
fn what_is_no_number_above_0_is_refused_with_what_is_allowed() {
    let number = "allowed is a number like 12 or 0.01, above 0";
    for length in ["0", "0.000", "-5", "+5", "-0.5"] {
        refused(
            &format!("linear --length-mm {length} --resolution-mm 0.01"),
            &format!("error: invalid value '{length}' for '--length-mm <MM>': not above 0; {number}"),
        );
    }
    for steps in ["1e3", "5mm", "--", "1,000.5,0"] {
        let (code, out, err) = calc(&format!("rotary --steps-per-turn {steps} --turns 1"));
        assert_eq!((code, out.as_str()), (Some(2), ""), "{steps}");
        assert!(err.starts_with("error: "), "{err}");
    }
    refused(
        "rotary --steps-per-turn 1e3 --turns 1",
        &format!(
            "error: invalid value '1e3' for '--steps-per-turn <STEPS>': not a number of digits with at most one \
             point, like 12 or 0.01; {number}"
        ),
    );
    let turns = "allowed is a number like 3.5, 7/2 or 50/3.33, above 0";
    for (given, problem) in [
        ("0", "not above 0"),
        ("-3.5", "not above 0"),
        ("7/0", "not above 0"),
        ("-7/2", "not above 0"),
        ("7/", "not a fraction of two numbers, like 7/2 or 50/3.33"),
        ("1234567890", "more than 9 digits before the point or 15 behind it"),
    ] {
        refused(
            &format!("rotary --steps-per-turn 1000 --turns {given}"),
            &format!("error: invalid value '{given}' for '--turns <TURNS>': {problem}; {turns}"),
        );
    }
}

/// The command with the options that the message names instead.
fn with_hint(arguments: &str, option: &str, hint: &str) -> String {
    let mut words: Vec<&str> = arguments.split(' ').collect();
    let at = words.iter().position(|word| *word == option).unwrap();
    words[at + 1] = hint;
    words.join(" ")
}

#[test]
fn ranges_that_cannot_be_programmed_are_refused_with_the_nearest_that_works() {
    let allowed = "allowed are 17..16777216 (measuring length 10h..FFFFFFh); nearest that works:";
    let rod = "allowed are 1..16777215 (FFFFFFh); nearest that works:";
    for (arguments, problem, hints) in [
        (
            "rotary --steps-per-turn 1000 --turns 70000",
            "70000 turns are outside 1/99..65535; nearest that works: --turns 65535".to_owned(),
            // 65535000 positions: one problem at a time.
            &[][..],
        ),
        (
            "rotary --steps-per-turn 4096 --turns 1/100",
            "0.01 turns are outside 1/99..65535; nearest that works: --turns 1/99".to_owned(),
            &[("--turns", "1/99")],
        ),
        (
            "rotary --steps-per-turn 8192 --turns 4096 --native 8192",
            format!(
                "8192 steps per turn over 4096 turns are 33554432 positions; {allowed} --steps-per-turn 4096, or \
                 --turns 2048"
            ),
            &[("--steps-per-turn", "4096"), ("--turns", "2048")],
        ),
        (
            "rotary --steps-per-turn 3 --turns 3.5",
            format!(
                "3 steps per turn over 3.5 turns are 10.5 positions; {allowed} --steps-per-turn 4.857143, or \
                 --turns 6"
            ),
            &[("--steps-per-turn", "4.857143"), ("--turns", "6")],
        ),
        (
            "rotary --mm-per-turn 5 --resolution-mm 0.001 --turns 4096",
            format!(
                "5000 steps per turn over 4096 turns are 20480000 positions; {allowed} --resolution-mm 0.001221"
            ),
            &[("--resolution-mm", "0.001221")],
        ),
        (
            "linear --length-mm 500 --resolution-mm 1001",
            format!("500 mm in steps of 1001 mm are about 0.4995 steps; {rod} --resolution-mm 500"),
            &[("--resolution-mm", "500")],
        ),
        (
            "linear --length-mm 500 --resolution-mm 0.00001",
            format!("500 mm in steps of 0.00001 mm are 50000000 steps; {rod} --resolution-mm 0.000029803"),
            &[("--resolution-mm", "0.000029803")],
        ),
    ] {
        refused(arguments, &format!("error: {problem}"));
        for (option, hint) in hints {
            let (code, _, err) = calc(&with_hint(arguments, option, hint));
            assert_eq!((code, err.as_str()), (Some(0), ""), "{arguments}: {option} {hint}");
        }
    }
}

#[test]
fn options_that_do_not_go_together_are_bad_usage() {
    refused(
        "rotary --steps-per-turn 1000 --turns 1 --native 8192 --model ce-100-m",
        "error: --native: 8192 steps per turn; a ce-100-m has 4096",
    );
    for arguments in [
        "rotary --turns 1",
        "rotary --mm-per-turn 5 --turns 1",
        "rotary --steps-per-turn 5 --resolution-mm 1 --turns 1",
        "rotary --steps-per-turn 5 --mm-per-turn 5 --resolution-mm 1 --turns 1",
        "rotary --steps-per-turn 1000",
        "rotary --steps-per-turn 1000 --turns 1 --native 4095",
        "rotary --steps-per-turn 1000 --turns 1 --model la-66",
        "linear --length-mm 500",
        "elliptic",
    ] {
        let (code, out, err) = calc(arguments);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments}");
        assert!(err.starts_with("error: "), "{arguments}: {err}");
    }
}

/// A new encoder that takes a sequence word by word; then its position at each of these shafts.
fn positions_after<const SHAFTS: usize>(
    sequence: impl Iterator<Item = HandshakeWord>,
    sensor: Sensor,
    shafts: [i64; SHAFTS],
) -> [u32; SHAFTS] {
    let model = if matches!(sensor, Sensor::Linear { .. }) { Model::La66 } else { Model::Ce65M };
    let mut node = Node::new(Unit::new(model, sensor).unwrap());
    let mut at = 0;
    let mut surroundings = Surroundings::default();
    let mut cycle = |out, shaft| {
        at += 1_000_000;
        surroundings.terminals.raw = shaft;
        node.step(Instant(at), out, &surroundings).expect("it is on")
    };
    let mut last = OutWord(0);
    for step in sequence {
        let waited = (0..1000).find(|_| {
            let seen = cycle(step.out, 0);
            match step.expected {
                Expected::Position => matches!(seen.decode(), In::Position { error: false, .. }),
                Expected::Reply(reply) => seen == reply,
            }
        });
        assert!(waited.is_some(), "{step:?}");
        last = step.out;
    }
    shafts.map(|shaft| cycle(last, shaft).0)
}

#[test]
fn an_encoder_takes_the_words_and_counts_as_calculated() {
    let shaft = Shaft::new(Model::Ce65M, 4096).unwrap();
    let found = rotary("1000".parse().unwrap(), "10".parse().unwrap(), shaft).unwrap();
    let shafts = [0, 4, 5, 4095, 4096, 40_959, 40_960, -1];
    let shown = positions_after(found.scaling.sequence(), Sensor::Rotary { steps_per_turn: 4096 }, shafts);
    assert_eq!(shown, [0, 0, 1, 999, 1000, 9999, 0, 9999]);

    let found = rotary("4096".parse().unwrap(), "3.5".parse().unwrap(), shaft).unwrap();
    let shafts = [0, 4096, 14_335, 14_336];
    let shown = positions_after(found.scaling.sequence(), Sensor::Rotary { steps_per_turn: 4096 }, shafts);
    assert_eq!(shown, [0, 4096, 14_335, 0]);

    let found = linear("500".parse().unwrap(), "0.01".parse().unwrap(), Model::La66).unwrap();
    let shafts = [0, 10, 499_990, 500_000];
    let shown = positions_after(found.scaling.sequence(), Sensor::Linear { rod_um: 500_000 }, shafts);
    assert_eq!(shown, [0, 1, 49_999, 50_000]);
}

#[test]
fn the_page_for_users_shows_what_the_program_prints() {
    let page = include_str!("../../../docs/calc.md");
    let examples: Vec<&str> = page.split("$ encoring calc ").skip(1).collect();
    assert!(examples.len() >= 3);
    for example in examples {
        let (command, rest) = example.split_once('\n').unwrap();
        let (documented, _) = rest.split_once("```").unwrap();
        assert_eq!(calc(command).1, documented, "{command}");
    }
}
