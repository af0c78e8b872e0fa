//! `encoring decode`, as text and as JSON.

use super::{Run, encoring, refused};

/// What stands on standard output after a good run.
fn decode(arguments: &[&str]) -> String {
    let Run { code, out, err } = encoring(&[&["decode"], arguments].concat(), b"");
    assert_eq!(code, Some(0), "{arguments:?}");
    assert!(err.is_empty() || err.starts_with("note: digits without a letter "), "{arguments:?}: {err}");
    out
}

/// Asserts that the arguments are refused with a line that begins so.
fn refuses(arguments: &[&str], input: &[u8], message: &str) {
    let Run { code, out, err } = encoring(arguments, input);
    assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments:?}: {err}");
    assert!(err.starts_with(message), "{arguments:?}: {err}");
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

/// Spellings of one word, as arguments.
const SPELLINGS: [&[&str]; 26] = [
    &["C200270F"],
    &["c200270f"],
    &["  C200270F "],
    &["0xC200270F"],
    &["0Xc200270f"],
    &["C200270Fh"],
    &["C200270FH"],
    &["16#C200270F"],
    &["DW#16#C200270F"],
    &["dw#16#c200_270f"],
    &["DWORD#16#C200_270F"],
    &["C200_270F"],
    &["2#11000010000000000010011100001111"],
    &["2#1100_0010_0000_0000_0010_0111_0000_1111"],
    &["C200", "270F"],
    &["C200 270F"],
    &["W#16#C200", "W#16#270F"],
    &["KH=C200 KH=270F"],
    &["0xC200", "0x270F"],
    &["C2", "00", "27", "0F"],
    &["C2 00 27 0F"],
    &["-1040177393"],
    &["L#-1040177393"],
    &["DINT#-1040177393"],
    &["--decimal", "3254789903"],
    &["--decimal", "-15872", "9999"],
];

#[test]
fn every_spelling_of_a_word_says_the_same() {
    let whole = decode(&["C200270F"]);
    for spelling in SPELLINGS {
        let told = encoring(&[&["decode"], spelling].concat(), b"");
        assert_eq!(
            (told.code, told.out.as_str(), told.err.as_str()),
            (Some(0), whole.as_str(), ""),
            "{spelling:?}"
        );
        let (options, words): (Vec<&str>, Vec<&str>) =
            spelling.iter().partition(|text| text.starts_with("--"));
        let told = encoring(&[&["decode"], options.as_slice()].concat(), words.join(" ").as_bytes());
        assert_eq!(
            (told.code, told.out.as_str(), told.err.as_str()),
            (Some(0), whole.as_str(), ""),
            "{words:?}"
        );
    }
}

#[test]
fn digits_without_a_letter_are_hexadecimal_and_a_note_names_the_option() {
    let Run { code, out, err } = encoring(&["decode", "16777215"], b"");
    assert_eq!((code, &out[..8]), (Some(0), "16777215"));
    assert_eq!(
        err,
        "note: digits without a letter were read as hexadecimal; for decimal numbers there is --decimal\n"
    );
    let Run { out, err, .. } = encoring(&["decode", "--decimal", "16777215"], b"");
    assert_eq!((&out[..8], err.as_str()), ("00FFFFFF", ""));
    let Run { err, .. } = encoring(&["decode"], b"16777215\n16777216\n");
    assert_eq!(err.lines().count(), 1, "{err}");
}

#[test]
fn registers_of_mbpoll_are_words() {
    let printed = b"[5]: \t0xC200\n[6]: \t0x270F\n";
    let Run { code, out, err } = encoring(&["decode", "-"], printed);
    assert_eq!((code, out, err.as_str()), (Some(0), decode(&["C200270F"]), ""));
    refused(
        &["decode", "-"],
        b"[5]: 0xC200\n",
        "error: standard input line 2: register 5 is half a word: the next one is missing",
    );
}

#[test]
fn the_registers_of_the_master_are_told_in_words() {
    for spelling in [["00E4", "0380"], ["0xE4", "0380h"], ["W#16#00E4", "KH=0380"]] {
        let told = decode(&[&["--master"], spelling.as_slice()].concat());
        let words = "status     00E4  READY, ACTIVE, RUN, BUS\nparameter  0380  the outgoing interface of device 3.0\n";
        assert_eq!(told, words, "{spelling:?}");
    }
    let json = decode(&["--master", "00E0", "0000", "--format", "json"]);
    assert_eq!(
        json,
        "{\"status_hex\":\"00E0\",\"status\":[\"READY\",\"ACTIVE\",\"RUN\"],\"parameter_hex\":\"0000\",\
         \"parameter\":\"nothing to tell\"}\n"
    );
    refuses(
        &["decode", "--master", "E4", "0380"],
        b"",
        "error: E4: half a word has 4 digits; zeros may be lost",
    );
    refuses(
        &["decode", "--master", "00E4"],
        b"",
        "error: 2 values required for '--master <STATUS> <PARAMETER>'",
    );
    refuses(&["decode", "--master", "00E4", "0380", "C200270F"], b"", "error: the argument '--master");
}

#[test]
fn anything_else_is_bad_input_and_says_what_is_allowed() {
    let word = "a word is eight hexadecimal digits, as C200270F, 0xC200270F or DW#16#C200270F, ";
    refuses(
        &["decode", "C200270"],
        b"",
        "error: C200270: a word has 8 digits; zeros may be lost. Write 0C200270 or",
    );
    refuses(
        &["decode", "18"],
        b"",
        "error: 18: a word has 8 digits; zeros may be lost. Write 00000018 for 18h, or give --decimal for 18",
    );
    refuses(
        &["decode", "C200", "27"],
        b"",
        "error: 27: half a word has 4 digits; zeros may be lost. Write 0027 for 27h, or give --decimal for 27",
    );
    refuses(
        &["decode", "C2", "0", "27", "0F"],
        b"",
        "error: 0: a byte has 2 digits; zeros may be lost. Write 00 for 0h, or give --decimal for 0",
    );
    refuses(
        &["decode", "C2", "00", "27"],
        b"",
        "error: 3 numbers are no word: it is eight hexadecimal digits, ",
    );
    refuses(&["decode", ""], b"", "error: 0 numbers are no word: ");
    refuses(&["decode", "W#16#C200"], b"", "error: W#16#C200: marked as half a word, and here stands a word");
    let long = "x".repeat(100_000);
    refuses(&["decode", &long], b"", &format!("error: {}...: not a word; {word}", "x".repeat(40)));
    refused(
        &["decode", "C200270F", "--model", "ce-58"],
        b"",
        "error: invalid value 'ce-58' for '--model <MODEL>': the models are la-66, ce-100-m and ce-65-m",
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
    assert!(
        err.starts_with(
            "error: standard input line 3: nonsense: not a word; a word is eight hexadecimal digits"
        ),
        "{err}"
    );
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
        assert_eq!(code, Some(0), "{err}");
        assert!(err.starts_with("note: digits without a letter") && err.lines().count() == 1, "{err}");
        assert_eq!(out.lines().count(), words.len());
        for line in out.lines() {
            assert!(line.contains("\"foreign\":false"), "{file}: {line}");
        }
    }
}

#[test]
fn input_without_a_word_is_told_and_ends_with_3() {
    for (input, told) in [
        (&b""[..], "no word is there: standard input is empty"),
        (b"# C200270F\n\n", "no word is there: standard input is empty, or all comments"),
        (
            b"-- Polling slave 1...\nRead input register failed: timed out\n",
            "no word is there: mbpoll has read no",
        ),
    ] {
        let Run { code, out, err } = encoring(&["decode", "-"], input);
        assert_eq!((code, out.as_str()), (Some(3), ""), "{err}");
        assert!(err.starts_with(told), "{err}");
    }
}

#[test]
fn what_windows_puts_in_front_of_a_text_is_passed_over_or_named() {
    let Run { code, out, .. } = encoring(&["decode", "-"], b"\xEF\xBB\xBFC200270F\r\n");
    assert_eq!(code, Some(0));
    assert!(out.starts_with("C200270F "), "{out}");
    let told = "error: standard input line 1: the text is UTF-16; save it as UTF-8";
    refuses(&["decode", "-"], b"\xFF\xFEC\x002\x00", told);
}
