//! The sentences of a data sheet that hold values, or that no manual states.

use encoring_texts::{Hex, Said, texts};

texts! {
    "sheet";

    fn jumper(connector: &str, one: u8, other: u8) =
        "So that the next device is found: {connector}, pin {one} joined to pin {other}.";
    fn lamp_names() =
        "The manual gives names only; the meanings of RC and BA are those of other vendors' documents.";
    fn with_value(word: Hex<8>) = "{word} + value";
    fn replies() =
        "The data of a read have no meaning. The reply to a write is the word itself, that to a read has the value in \
         bits 2^23..2^0; with an error 2^29 is set in both.";
    fn written(effect: Said) = "A written value {effect}.";
    fn always_0(bits: String, last: String) = "Always 0: {bits} and {last}.";
    fn status_bit(bit: u8) = "status 2^{bit}";
    fn edition_with_index(index: &str, date: &str, what: Said) = "index {index}, {date}: {what}";
    fn edition(date: &str, what: Said) = "{date}: {what}";
    fn ssi_rest() = "SSI: at rest Data+ and Clock+ are at +5 V, High.";
}
