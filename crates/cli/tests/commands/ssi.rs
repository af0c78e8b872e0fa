//! `encoring ssi`.

mod bench;
mod decode;

use serde_json::Value;

use super::{Run, encoring, refused};

/// What `ssi encode` says of positions.
fn encoded(options: &[&str], positions: &[u32]) -> Vec<[String; 4]> {
    let mut arguments = vec!["ssi".to_owned(), "encode".to_owned(), "--format".to_owned(), "json".to_owned()];
    arguments.extend(options.iter().map(|option| (*option).to_owned()));
    arguments.extend(positions.iter().map(u32::to_string));
    let Run { code, out, err } = encoring(&arguments, b"");
    assert_eq!(code, Some(0), "{arguments:?}: {err}");
    let views = out.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    let keys = ["field", "line", "rising", "falling"];
    let views: Vec<_> = views.map(|view| keys.map(|key| view[key].as_str().unwrap().to_owned())).collect();
    assert_eq!(views.len(), positions.len());
    views
}

/// As the worked values have it: spaces are for people.
fn bits(text: &str) -> String {
    text.replace(' ', "")
}

// [R116, R117, R119, C18] The strings are those of the project's worked values.
#[test]
fn the_worked_values_are_what_encode_says() {
    let ak40 = [
        (0, 0x0000_0001_u32),
        (1, 0x0000_0002),
        (2, 0x0000_0004),
        (3, 0x0000_0007),
        (0x27_0F, 0x0000_4E1F),
        (0x12_3456, 0x0024_68AC),
        (0xFF_FFFF, 0x01FF_FFFF),
    ];
    for (position, word) in ak40 {
        let [field, line, rising, falling] = &encoded(&["--bits", "31"], &[position])[0];
        assert_eq!(*field, format!("{word:032b}"));
        assert_eq!(*line, format!("{word:032b}0"));
        assert_eq!((rising, falling), (&format!("1{word:032b}"), &format!("1{word:032b}")));
    }
    let plain = [
        (vec!["--bits", "24"], "0000 0000 0010 0111 0000 1111"),
        (vec!["--bits", "25"], "0 0000 0000 0010 0111 0000 1111"),
        (vec!["--bits", "14"], "10 0111 0000 1111"),
        (vec!["--bits", "32"], "0000 0000 0000 0000 0010 0111 0000 1111"),
    ];
    for (options, expected) in plain {
        assert_eq!(encoded(&options, &[9_999])[0][0], bits(expected), "{options:?}");
    }
    let left_justified = &encoded(&["--bits", "14", "--clocks", "24"], &[9_999])[0][1];
    assert_eq!(*left_justified, bits("10 0111 0000 1111 00 0000 0000"));
    assert_eq!(encoded(&["--bits", "8", "--code", "gray"], &[0x180])[0][0], bits("0100 0000"));
    let repeated = &encoded(&["--repetition", "--clocks", "52"], &[9_999])[0][1];
    let once = bits("0000 0000 0010 0111 0000 1111 00");
    assert_eq!(*repeated, once.clone() + &once);
}

/// Positions that a fixed rule gives, all bits of them in use.
fn positions() -> Vec<u32> {
    let mut state = 0x2545_F491_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    [0, 1, 0xFF_FFFF, 0x80_0000].into_iter().chain(std::iter::repeat_with(&mut next).take(16)).collect()
}

// [R105, R116, R117, R119, C19] Beside a second way to the bits: digits of numbers, and no shift register.
#[test]
fn every_number_of_bits_code_repetition_and_firmware_sends_what_a_second_reading_says() {
    let positions = positions();
    for n in 8_usize..=32 {
        for gray in [false, true] {
            for firmware in ["40/1997", "41/1997"] {
                let ak40 = n == 31 && firmware == "41/1997";
                let expected = |position: u32| {
                    if ak40 {
                        let digits = format!("{position:031b}");
                        let parity = if digits.matches('1').count() % 2 == 0 { "1" } else { "0" };
                        return digits + parity;
                    }
                    let value = if gray { position ^ position >> 1 } else { position };
                    let digits = format!("{value:032b}");
                    digits[32 - n..].to_owned()
                };
                let (bits, code) = (n.to_string(), if gray { "gray" } else { "binary" });
                let options = ["--bits", &bits, "--code", code, "--firmware", firmware];
                for (view, position) in encoded(&options, &positions).iter().zip(&positions) {
                    let [field, line, rising, falling] = view;
                    assert_eq!(*field, expected(*position), "{options:?} {position}");
                    assert_eq!(*line, format!("{field}0"), "{options:?} {position}");
                    assert_eq!(*rising, format!("1{field}"), "{options:?} {position}");
                    assert_eq!(falling, rising, "{options:?} {position}");
                }
                // Up to three times as many clocks.
                let clocks = (3 * n).to_string();
                let options = [&options[..], &["--clocks", &clocks]].concat();
                for ([field, line, ..], _) in encoded(&options, &positions).iter().zip(&positions) {
                    assert_eq!(*line, format!("{field:0<width$}", width = 3 * n), "{options:?}");
                }
            }
        }
    }
    for gray in ["binary", "gray"] {
        let once = encoded(&["--code", gray], &positions);
        let options = ["--repetition", "--bits", "31", "--code", gray, "--clocks", "78"];
        for (repeated, once) in encoded(&options, &positions).iter().zip(once) {
            assert_eq!(repeated[0], once[0], "there are 24 bits, and no AK-40");
            assert_eq!(repeated[1], format!("{}00", once[0]).repeat(3));
        }
    }
}

#[test]
fn a_figure_for_a_terminal_stands_below_the_bits() {
    let run = encoring(&["ssi", "encode", "9999", "--bits", "14", "--code", "gray"], b"");
    insta::assert_snapshot!("encode", run.out);
}

#[test]
fn a_figure_is_written_once_and_replaced_only_if_told() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.svg");
    let file = file.to_str().unwrap();
    let draw = |position: &str, more: &[&str]| {
        encoring(&[&["ssi", "encode", position, "--svg", file], more].concat(), b"")
    };
    assert_eq!(draw("1", &[]).code, Some(0));
    let first = std::fs::read_to_string(file).unwrap();
    assert!(first.starts_with("<svg ") && first.contains("position 1 (000001h), 24 bits binary"), "{first}");
    let again = draw("2", &[]);
    assert_eq!((again.code, again.out.as_str()), (Some(2), ""));
    assert!(
        again.err.ends_with("it is there already; name a new one, or give --overwrite\n"),
        "{}",
        again.err
    );
    assert_eq!(std::fs::read_to_string(file).unwrap(), first);
    assert_eq!(draw("2", &["--overwrite"]).code, Some(0));
    assert!(std::fs::read_to_string(file).unwrap().contains("position 2 (000002h)"));
}

#[test]
fn what_cannot_be_encoded_is_refused_with_what_is_allowed() {
    refused(
        &["ssi", "encode", "16777216"],
        b"",
        "error: invalid value '16777216' for '<POSITION>...': 16777216: above \
         16777215, the largest number of 24 bits",
    );
    refused(
        &["ssi", "encode", "1", "2", "--svg", "a.svg"],
        b"",
        "error: --svg: a figure is of one position, not of 2",
    );
    for (option, value) in [("--bits", "7"), ("--bits", "33"), ("--clocks", "0"), ("--firmware", "54/1997")] {
        assert_eq!(encoring(&["ssi", "encode", "1", option, value], b"").code, Some(2), "{option} {value}");
    }
}

#[test]
fn what_has_no_effect_and_what_is_not_sent_is_told() {
    let run = encoring(&["ssi", "encode", "1", "--bits", "31", "--code", "gray"], b"");
    assert_eq!(run.err, "note: --code gray: AK-40 is always binary\n");
    let run = encoring(&["ssi", "encode", "1", "--bits", "20", "--repetition"], b"");
    assert_eq!(run.err, "note: --bits 20: with repetition the encoder makes it 24\n");
    let run = encoring(&["ssi", "encode", "9999", "--bits", "8"], b"");
    assert!(run.out.contains("the position has 14 bits; the upper 6 are not sent, and no error tells it"));
}

// [R109] Edge by edge, by arithmetic on a list of times.
#[test]
fn what_receivers_take_follows_the_delay_of_the_cable() {
    for (delay, late_falling, late_rising) in
        [(0, 0, 0), (499, 0, 0), (500, 1, 0), (650, 1, 0), (999, 1, 0), (1_000, 1, 1)]
    {
        let delay = delay.to_string();
        let views = encoded(&["--bits", "14", "--clock-rate", "1MHz", "--delay", &delay], &[9_999]);
        let [field, line, rising, falling] = &views[0];
        let late = |bits: usize| format!("{}{field}", "1".repeat(1 + bits))[..line.len()].to_owned();
        assert_eq!((falling, rising), (&late(late_falling), &late(late_rising)), "{delay} ns");
        assert_eq!(*line, format!("{field}0"));
    }
}

#[test]
fn the_figures_of_the_page_are_what_the_program_draws() {
    let folder = tempfile::tempdir().unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/");
    let page = std::fs::read_to_string(format!("{root}ssi.md")).unwrap();
    let mut figures = 0;
    for line in page.lines().filter_map(|line| line.strip_prefix("$ encoring ")) {
        let Some((command, file)) = line.split_once(" --svg docs/") else { continue };
        let drawn = folder.path().join("drawn.svg");
        let mut arguments: Vec<&str> = command.split(' ').collect();
        arguments.extend(["--svg", drawn.to_str().unwrap(), "--overwrite"]);
        let run = encoring(&arguments, b"");
        assert_eq!(run.code, Some(0), "{line}: {}", run.err);
        let committed = std::fs::read_to_string(format!("{root}{file}")).unwrap();
        assert!(
            std::fs::read_to_string(&drawn).unwrap() == committed,
            "docs/{file}: draw it anew with {line}"
        );
        assert!(page.contains(&format!("]({file})")), "the page shows {file}");
        figures += 1;
    }
    assert_eq!(figures, 4);
}
