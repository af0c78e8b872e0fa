extern crate std;

use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

use proptest::prelude::*;

use super::*;

const WORD: u32 = 0xC200_270F;

fn read(text: &str) -> Result<u32, NumberError<'_>> {
    word([text], Bare::Hexadecimal).map(|reading| reading.bits)
}

fn refusal(text: &str, bare: Bare) -> String {
    word([text], bare).unwrap_err().to_string()
}

/// Every spelling of a word that needs no `--decimal`.
fn spellings(word: u32) -> Vec<String> {
    let (high, low) = (word >> 16, word & 0xFFFF);
    let [a, b, c, d] = word.to_be_bytes();
    let signed = word as i32;
    let mut spellings = std::vec![
        format!("{word:08X}"),
        format!("{word:08x}"),
        format!("0x{word:08X}"),
        format!("0X{word:x}"),
        format!("{word:08X}h"),
        format!("{word:x}H"),
        format!("16#{word:08X}"),
        format!("DW#16#{word:08X}"),
        format!("dw#16#{word:x}"),
        format!("DWORD#16#{word:08X}"),
        format!("DH={word:08X}"),
        format!("2#{word:032b}"),
        format!("2#{:04b}_{:028b}", word >> 28, word & 0xFFF_FFFF),
        format!("DWORD#2#{word:b}"),
        format!("{high:04X}_{low:04X}"),
        format!("0x{high:04x}_{low:04x}"),
        format!("DW#16#{a:02X}_{b:02X}_{c:02X}_{d:02X}"),
        format!("{high:04X} {low:04X}"),
        format!("  {high:04x}\t{low:04X} "),
        format!("W#16#{high:04X} W#16#{low:04X}"),
        format!("WORD#16#{high:X} word#16#{low:X}"),
        format!("KH={high:04X} KH={low:04X}"),
        format!("0x{high:04X} 0x{low:04X}"),
        format!("{high:04X}h {low:04X}h"),
        format!("16#{high:X} 16#{low:X}"),
        format!("2#{high:016b} 2#{low:b}"),
        format!("KF={:+} KF={:+}", high as i16, low as i16),
        format!("INT#{} UINT#{low}", high as i16),
        format!("{a:02X} {b:02X} {c:02X} {d:02X}"),
        format!("0x{a:02x} 0x{b:x} 0x{c:02x} 0x{d:x}"),
        format!("B#16#{a:02X} B#16#{b:02X} BYTE#16#{c:02X} b#16#{d:02X}"),
        format!("{signed:+}"),
        format!("L#{signed}"),
        format!("DINT#{signed:+}"),
        format!("UDINT#{word}"),
    ];
    if signed < 0 {
        spellings.push(signed.to_string());
    }
    spellings
}

#[test]
fn every_spelling_of_a_word_is_that_word() {
    for bits in [WORD, 0, 1, 0x18, 0x8000_0000, 0x7FFF_FFFF, u32::MAX, 0x1677_7215] {
        for text in spellings(bits) {
            for bare in [Bare::Hexadecimal, Bare::Decimal] {
                let marked = text.split_whitespace().all(|piece| Written::of(piece).mark != Mark::None);
                if bare == Bare::Hexadecimal || marked {
                    assert_eq!(word([text.as_str()], bare).unwrap().bits, bits, "{text}");
                }
            }
            let pieces: Vec<&str> = text.split(' ').collect();
            assert_eq!(word(pieces, Bare::Hexadecimal).unwrap().bits, bits, "{text} as arguments");
        }
        let decimal = |text: String| word([text.as_str()], Bare::Decimal).unwrap();
        let (high, low) = (bits >> 16, bits & 0xFFFF);
        for text in [
            bits.to_string(),
            (bits as i32).to_string(),
            format!("{bits:016}"),
            format!("{} {}", high as i16, low as i16),
            format!("{high} {low}"),
        ] {
            assert_eq!(decimal(text), Reading { bits, note: None });
        }
    }
}

#[test]
fn eight_digits_are_read_as_any_word_is_and_nothing_else() {
    for place in 0..8 {
        for byte in 0..=u8::MAX {
            let mut digits = *b"0a9Ff00B";
            digits[place] = byte;
            let word = str::from_utf8(&digits).ok().and_then(|text| u32::from_str_radix(text, 16).ok());
            let expected = word.filter(|_| byte.is_ascii_hexdigit());
            assert_eq!(eight_digits(&digits), expected, "{byte:#x} at {place}");
        }
    }
}

#[test]
fn what_is_no_word_is_refused_with_what_to_type() {
    for (text, told) in [
        ("", "0 numbers are no word: it is eight hexadecimal digits, as C200270F, "),
        ("C2 00 27", "3 numbers are no word: "),
        ("C200270G", "C200270G: not a word; a word is eight hexadecimal digits, as C200270F, "),
        ("0x", "0x: not a word; "),
        ("h", "h: not a word; "),
        ("0xC200270Fh", "0xC200270Fh: not a word; "),
        ("-0x18", "-0x18: not a word; "),
        ("C200__270F", "C200__270F: not a word; "),
        ("_C200270F", "_C200270F: not a word; "),
        ("C200270F_", "C200270F_: not a word; "),
        ("4.2E+65", "4.2E+65: not a word; "),
        ("\u{661}\u{661}\u{661}\u{661}\u{661}\u{661}\u{661}\u{661}", "\u{661}\u{661}"),
        (
            "18",
            "18: a word has 8 digits; zeros may be lost. Write 00000018 for 18h, or give --decimal for 18",
        ),
        ("270F", "270F: a word has 8 digits; zeros may be lost. Write 0000270F or 0x270F"),
        ("C200 27F", "27F: half a word has 4 digits; zeros may be lost. Write 027F or 0x27F"),
        ("C2 00 27 9", "9: a byte has 2 digits; zeros may be lost. Write 09 for 9h, or give --decimal for 9"),
        (
            "3254789903",
            "3254789903: a word has 8 hexadecimal digits; for 3254789903 in decimal there is --decimal",
        ),
        ("C200270F0", "C200270F0: a word has 8 hexadecimal digits"),
        ("0x1C200270F", "0x1C200270F: above FFFFFFFFh, the largest number of 32 bits"),
        ("W#16#C200", "W#16#C200: marked as half a word, and here stands a word"),
        ("KH=C200 DW#16#270F", "DW#16#270F: marked as a word, and here stands half a word"),
        ("-2147483649", "-2147483649: below -2147483648, the smallest number of 32 bits"),
        ("L#4294967296", "L#4294967296: above 4294967295, the largest number of 32 bits"),
        (
            "-15872 9999",
            "9999: 9999h, or 9999 in decimal as the number beside it; write 0x9999, or give --decimal",
        ),
        ("-32769 -1", "-32769: below -32768, the smallest number of 16 bits"),
    ] {
        let found = refusal(text, Bare::Hexadecimal);
        assert!(found.starts_with(told), "{text:?}: {found}");
    }
    assert_eq!(
        refusal("C200270F", Bare::Decimal),
        "C200270F: not decimal; beside --decimal hexadecimal is written 0xC200270F"
    );
    assert_eq!(refusal("70000 1", Bare::Decimal), "70000: above 65535, the largest number of 16 bits");
    let long = "9".repeat(100_000);
    assert!(refusal(&long, Bare::Decimal).len() < 120);
    assert!(value(&long).unwrap_err().to_string().len() < 120);
    assert!(refusal("C200\u{1b}[2J", Bare::Hexadecimal).starts_with("C200\\u{1b}[2J: "));
}

#[test]
fn digits_without_a_letter_are_hexadecimal_and_noted_where_they_could_be_decimal() {
    for (text, noted) in [
        ("16777215", true),
        ("1677 7215", true),
        ("10 20 30 40", true),
        ("0x1677 7215", true),
        ("00000000", false),
        ("00000009", false),
        ("C200 9999", false),
        ("0x16777215", false),
        ("16777215h", false),
        ("1677721F", false),
    ] {
        let reading = word([text], Bare::Hexadecimal).unwrap();
        assert_eq!(reading.note.is_some(), noted, "{text}");
    }
    assert_eq!(word(["16777215"], Bare::Hexadecimal).unwrap().bits, 0x1677_7215);
    assert_eq!(word(["16777215"], Bare::Decimal), Ok(Reading { bits: 16_777_215, note: None }));
}

#[test]
fn a_half_is_read_by_itself() {
    for text in
        ["C200", "c200", "0xC200", "C200h", "16#C200", "W#16#C200", "KH=C200", "-15872", " KF=-15872 "]
    {
        assert_eq!(half(text, Bare::Hexadecimal), Ok(Reading { bits: 0xC200, note: None }), "{text}");
    }
    assert_eq!(half("49664", Bare::Decimal).unwrap().bits, 0xC200);
    assert!(half("9999", Bare::Hexadecimal).unwrap().note.is_some());
    for wrong in ["", "18", "C200270F", "DW#16#C200", "C200 270F", "65536"] {
        half(wrong, Bare::Hexadecimal).unwrap_err();
    }
}

#[test]
fn a_value_is_decimal_or_marked() {
    for text in [
        "9999",
        "+9999",
        "9_999",
        "270Fh",
        "270fH",
        "0x270F",
        "00270Fh",
        "16#270F",
        "2#10_0111_0000_1111",
        "L#9999",
        "W#16#270F",
        "DW#16#270F",
        "KH=270F",
        " 9999 ",
    ] {
        assert_eq!(value(text).unwrap().number, 9_999, "{text}");
    }
    for (text, told) in [
        ("000018", "000018: 18, or 18h = 24; write one of them"),
        ("018", "018: 18, or 18h = 24; write one of them"),
        ("00270F", "00270F: not decimal; if 00270Fh = 9999 is meant, write the h"),
        ("1E3", "1E3: not decimal; if 1E3h = 483 is meant, write the h"),
        ("16777216", "16777216: above 16777215, the largest number of 24 bits"),
        ("0x1000000", "0x1000000: above FFFFFFh, the largest number of 24 bits"),
        ("KH=270FF", "KH=270FF: above FFFFh, the largest number of 16 bits"),
        ("INT#70000", "INT#70000: above 65535, the largest number of 16 bits"),
        ("9'999", "9'999: not a value; "),
        ("2#1000000000000000000000000", "2#1000000000000000000000000: above 2#111111111111111111111111, "),
        ("-1", "-1: below 0"),
        ("", "nothing stands here; a value is a number from 0 to 16777215; "),
        (
            "1.5",
            "1.5: not a value; a value is a number from 0 to 16777215; hexadecimal as 270Fh, 0x270F or 16#270F",
        ),
        ("1 000", "1 000: not a value; "),
    ] {
        let found = value(text).unwrap_err().to_string();
        assert!(found.starts_with(told), "{text:?}: {found}");
    }
    // One number either way.
    assert_eq!(value("000009").unwrap().number, 9);
    assert_eq!(value("0").unwrap().number, 0);
}

#[test]
fn a_limit_stands_in_the_base_that_was_typed() {
    for (text, limit) in [("4000", "3499"), ("0x4000", "DABh"), ("4000h", "DABh"), ("2#1", "2#110110101011")]
    {
        assert_eq!(value(text).unwrap().like(3_499).to_string(), limit);
    }
}

#[test]
fn two_registers_of_mbpoll_are_a_word() {
    let register = |line| Register::of(line).unwrap();
    for (high, low) in [
        ("[5]: \t0xC200", "[6]: \t0x270F"),
        ("[5]:0xc200\r", " [6]: 0x270F"),
        ("[5]: \t49664 (-15872)", "[6]: \t9999"),
        ("[5]: \t-15872", "[6]: \t9999"),
    ] {
        assert_eq!(register(high).number, 5);
        assert_eq!(register(high).followed_by(register(low)), Ok(WORD), "{high}");
    }
    for none in
        ["", "C200270F", "[5] 0xC200", "[x]: 0xC200", "[5", "[99999999999]: 1", "-- Polling slave 1..."]
    {
        assert_eq!(Register::of(none), None, "{none}");
    }
    let low = register("[6]: 0x270F");
    assert!(register("[5]: 0x1C200").followed_by(low).is_err());
    assert!(register("[5]: 1.5").followed_by(low).is_err());
}

/// The numbers that a piece without spaces can be, by another way: the marks in pairs, the digits by the standard library.
fn meanings(text: &str, size: Size) -> Vec<i64> {
    let text = text.to_ascii_lowercase();
    let mut found = Vec::new();
    let mut add = |digits: &str, radix: u32| {
        let sound =
            digits.split('_').all(|run| !run.is_empty() && run.bytes().all(|b| b.is_ascii_alphanumeric()));
        if sound && let Ok(number) = i64::from_str_radix(&digits.replace('_', ""), radix) {
            found.push(number);
        }
    };
    add(&text, 16);
    add(&text, 10);
    for mark in ["0x", "16#"] {
        if let Some(rest) = text.strip_prefix(mark) {
            add(rest, 16);
        }
    }
    if let Some(rest) = text.strip_prefix("2#") {
        add(rest, 2);
    }
    if let Some(rest) = text.strip_suffix('h') {
        add(rest, 16);
    }
    if let Some(rest) = text.strip_prefix('+') {
        add(rest, 10);
    }
    if let Some(rest) = text.strip_prefix('-') {
        let from = found.len();
        let sound = rest.bytes().all(|b| b.is_ascii_digit() || b == b'_');
        if sound && !rest.is_empty() && rest.split('_').all(|run| !run.is_empty()) {
            found.push(-rest.replace('_', "").parse::<i64>().unwrap());
        }
        assert!(found.len() <= from + 1);
    }
    found.retain(|number| (size.smallest()..=size.largest().into()).contains(number));
    found.sort_unstable();
    found.dedup();
    found
}

/// Calls `seen` with every text of up to five letters of those that numbers are written with.
fn every_short_text(seen: &mut impl FnMut(&str)) {
    fn longer(text: &mut String, left: usize, seen: &mut impl FnMut(&str)) {
        seen(text);
        if left > 0 {
            for letter in "0129aFxH#_+-".chars() {
                text.push(letter);
                longer(text, left - 1, seen);
                text.pop();
            }
        }
    }
    longer(&mut String::new(), 5, seen);
}

#[test]
fn of_every_short_text_what_is_read_is_one_of_its_meanings() {
    let (mut read_values, mut read_halves) = (0, 0);
    every_short_text(&mut |text| {
        let meanings = meanings(text, Size::Value);
        if let Ok(found) = value(text) {
            read_values += 1;
            assert!(meanings.contains(&found.number.into()), "{text:?} was read as {found}");
        } else if let [only] = *meanings
            && !text.bytes().any(|b| b.is_ascii_alphabetic())
        {
            panic!("{text:?} is {only} and nothing else, and was refused");
        }
        for bare in [Bare::Hexadecimal, Bare::Decimal] {
            if let Ok(found) = half(text, bare) {
                read_halves += 1;
                let bits = |meaning: &i64| *meaning as u32 & 0xFFFF;
                assert!(self::meanings(text, Size::Half).iter().any(|it| bits(it) == found.bits), "{text:?}");
            }
        }
    });
    assert!(read_values > 4_000 && read_halves > 10_000, "{read_values} {read_halves}");
}

#[test]
fn every_value_of_16_bits_comes_back_in_every_form() {
    for number in (0..=0xFFFF).chain([DATA_MAX - 1, DATA_MAX]) {
        for text in [
            format!("{number}"),
            format!("{number:06X}h"),
            format!("{number:x}h"),
            format!("0x{number:X}"),
            format!("16#{number:06x}"),
        ] {
            assert_eq!(value(&text).map(|value| value.number), Ok(number), "{text}");
        }
        // As tables printed it in earlier versions: never another number.
        if let Ok(found) = value(&format!("{number:06X}")) {
            assert_eq!(found.number, number);
        }
    }
}

proptest! {
    #[test]
    fn any_word_comes_back_from_all_its_spellings(bits: u32) {
        for text in spellings(bits) {
            prop_assert_eq!(read(&text).map_err(|error| error.to_string()), Ok(bits), "{}", text);
        }
        let pair = format!("{} {}", bits >> 16, bits & 0xFFFF);
        prop_assert_eq!(word([pair.as_str()], Bare::Decimal).unwrap().bits, bits);
    }

    #[test]
    fn no_text_does_harm(text: String, bare in prop::sample::select(std::vec![Bare::Hexadecimal, Bare::Decimal])) {
        for refused in [word([text.as_str()], bare).err(), half(&text, bare).err(), value(&text).err()] {
            prop_assert!(refused.is_none_or(|error| error.to_string().len() > 5));
        }
    }

    #[test]
    fn a_case_or_a_space_changes_nothing(text in "[0-9a-fA-FxXhH#+_ wWdDlL-]{0,14}") {
        let upper = text.to_ascii_uppercase();
        let spaced = format!(" {text} ");
        prop_assert_eq!(read(&text).ok(), read(&upper).ok());
        prop_assert_eq!(read(&text).ok(), read(&spaced).ok());
        prop_assert_eq!(value(&text).ok(), value(&upper).ok());
    }
}
