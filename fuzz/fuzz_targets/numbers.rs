//! Any text as a word, as half a word and as a value: what is read, printed and typed again is the same.
#![no_main]

use encoring_words::number::{Bare, Size, half, value, word};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    for bare in [Bare::Hexadecimal, Bare::Decimal] {
        match word([text], bare) {
            Ok(found) => {
                let printed = format!("0x{:08X}", found.bits);
                assert_eq!(word([printed.as_str()], bare).map(|again| again.bits), Ok(found.bits));
                let pieces = text.split_whitespace();
                assert_eq!(word(pieces, bare), Ok(found), "pieces are arguments too");
                // A letter beside a note would have been a hexadecimal digit.
                let letter = |text: &str| text.bytes().any(|byte| matches!(byte, b'a'..=b'f' | b'A'..=b'F'));
                assert!(found.note.is_none() || bare == Bare::Hexadecimal && !text.split_whitespace().all(letter));
            }
            Err(refused) => assert!(refused.to_string().len() < 600, "{refused}"),
        }
        match half(text, bare) {
            Ok(found) => assert!(found.bits <= Size::Half.largest()),
            Err(refused) => assert!(refused.to_string().len() < 600, "{refused}"),
        }
    }
    match value(text) {
        Ok(found) => assert_eq!(value(&found.to_string()), Ok(found)),
        Err(refused) => assert!(refused.to_string().len() < 600, "{refused}"),
    }
});
