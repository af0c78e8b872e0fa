//! `encoring decode`, as text and as JSON.

use super::{Run, encoring, refused};

/// What stands on standard output after a good run.
fn decode(arguments: &[&str]) -> String {
    let Run { code, out, err } = encoring(&[&["decode"], arguments].concat(), b"");
    assert_eq!((code, err.as_str()), (Some(0), ""), "{arguments:?}");
    out
}

#[test]
fn the_words_of_a_night_shift_as_text() {
    for (name, arguments) in [
        ("write_measuring_length", "C200270F"),
        ("end_of_request", "4200270F"),
        ("position", "0000270F --model la-66"),
        ("position_with_error_and_gray", "20003488 --direction in"),
        ("data_check_request", "88000000 --direction out"),
        ("data_check_reply", "A8002080 --direction in --model ce-65-m"),
        ("magnet_missing", "A8000020 --direction in"),
        ("status_that_fits_no_encoder", "88002020 --direction in"),
        ("unknown_service", "87000000"),
        ("read_of_preset_adjustment", "86000000 --direction out"),
        ("preset_adjustment", "C6000100 --direction out"),
        ("preset_value_2", "C5000100 --direction out"),
        ("value_outside_its_range", "C200000F --direction out"),
        ("numerator_zero", "C3000000 --model ce-100-m"),
        ("ssi_values", "CD01011F"),
        ("ak_40", "8D00011F --direction in --model ce-65-m"),
        ("counting_direction", "C1000101 --direction out"),
        ("all_ones", "FFFFFFFF"),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        insta::assert_snapshot!(
            name,
            decode(&arguments),
            &format!("encoring decode {}", arguments.join(" "))
        );
    }
}

#[test]
fn the_same_as_json() {
    for (name, word) in [
        ("json_write", "C200270F"),
        ("json_position", "20003488"),
        ("json_status", "A8002080"),
        ("json_ssi_values", "CD01011F"),
    ] {
        let line = decode(&[word, "--format", "json"]);
        assert_eq!(line.lines().count(), 1);
        let value: serde_json::Value = serde_json::from_str(&line).unwrap();
        let pretty = serde_json::to_string_pretty(&value).unwrap();
        insta::assert_snapshot!(name, pretty, &format!("encoring decode {word} --format json"));
    }
}

#[test]
fn the_three_forms_say_the_same() {
    let whole = decode(&["C200270F"]);
    assert_eq!(decode(&["C200", "270F"]), whole);
    assert_eq!(decode(&["C2", "00", "27", "0F"]), whole);
    assert_eq!(decode(&["c200270f"]), whole);
}

#[test]
fn anything_else_is_bad_input_and_says_what_is_allowed() {
    let eight = "is not 8 hex digits as a word; or give two values of 4 (high, low) or four of 2 (bytes)";
    refused(&["decode", "C200270"], b"", &format!("error: \"C200270\" {eight}"));
    refused(&["decode", "C200 270F"], b"", &format!("error: \"C200 270F\" {eight}"));
    refused(&["decode", "0xC200270F"], b"", &format!("error: \"0xC200270F\" {eight}; leave out 0x and h"));
    refused(&["decode", "C200270Fh"], b"", &format!("error: \"C200270Fh\" {eight}; leave out 0x and h"));
    refused(&["decode", "C200", "27"], b"", "error: \"27\" is not 4 hex digits as high and as low word");
    refused(&["decode", "C2", "0", "27", "0F"], b"", "error: \"0\" is not 2 hex digits as each byte");
    refused(
        &["decode", "C2", "00", "27"],
        b"",
        "error: 3 values are no word: it is 8 hex digits, or two values of 4, or four of 2",
    );
    let long = "x".repeat(100_000);
    refused(&["decode", &long], b"", &format!("error: \"{}...\" {eight}", "x".repeat(40)));
    refused(
        &["decode", "C200270F", "--model", "ce-58"],
        b"",
        "error: invalid value 'ce-58' for '--model <MODEL>'",
    );
    refused(
        &["decode", "C200270F", "--direction", "up"],
        b"",
        "error: invalid value 'up' for '--direction <DIRECTION>'",
    );
}

#[test]
fn words_come_from_standard_input_line_by_line() {
    let input = b"# a comment\n\nC200270F\r\n  C200 270F\nC2 00 27 0F";
    for arguments in [&["decode"][..], &["decode", "-"]] {
        let Run { code, out, err } = encoring(arguments, input);
        assert_eq!((code, err.as_str()), (Some(0), ""));
        let one = decode(&["C200270F"]);
        assert_eq!(out, [one.as_str(), &one, &one].join("\n"));
    }
    let Run { out, .. } = encoring(&["decode", "--format", "json"], input);
    assert_eq!(out, decode(&["C200270F", "--format", "json"]).repeat(3));
}

#[test]
fn a_bad_line_ends_the_run_after_the_words_before_it() {
    let Run { code, out, err } = encoring(&["decode"], b"C200270F\n# comment\nnonsense\n88000000\n");
    assert_eq!(code, Some(2));
    assert_eq!(out, decode(&["C200270F"]));
    assert!(err.starts_with("error: standard input line 3: \"nonsense\" is not 8 hex digits"), "{err}");
    for bad in [&b"\xFF\xFE\n"[..], b"C200270F \0\n", "\u{FF11}".repeat(8).as_bytes()] {
        assert_eq!(encoring(&["decode"], bad).code, Some(2));
    }
    let endless = vec![b'C'; 1 << 20];
    refused(&["decode"], &endless, "error: standard input line 1: longer than 4096 bytes");
}

#[test]
fn no_word_of_the_golden_traces_is_called_foreign() {
    for (file, model) in [
        ("la-66", "la-66"),
        ("ce-100-m", "ce-100-m"),
        ("ce-100-m-travel", "ce-100-m"),
        ("ce-65-m", "ce-65-m"),
        ("ce-65-m-8192", "ce-65-m"),
        ("ce-65-m-travel", "ce-65-m"),
    ] {
        let path = format!("{}/../../vectors/{file}.csv", env!("CARGO_MANIFEST_DIR"));
        let trace = std::fs::read_to_string(path).unwrap();
        let inputs = trace.lines().skip(1).filter_map(|row| row.rsplit(',').next());
        let words: Vec<&str> = inputs.filter(|input| *input != "off").collect();
        assert!(words.len() > 1000, "{file}");
        let arguments = ["decode", "--direction", "in", "--model", model, "--format", "json"];
        let Run { code, out, err } = encoring(&arguments, words.join("\n").as_bytes());
        assert_eq!((code, err.as_str()), (Some(0), ""));
        assert_eq!(out.lines().count(), words.len());
        for line in out.lines() {
            assert!(line.contains("\"foreign\":false"), "{file}: {line}");
        }
    }
}
