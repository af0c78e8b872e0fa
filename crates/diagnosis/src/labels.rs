//! What stands in a picture, in sentences. A page that shows it in another language puts its own in their place.

use encoring_texts::texts;
use encoring_words::Duration;

use crate::cause::{JumpCause, Likelihood};

texts! {
    "picture";

    fn one_of_several(name: &str, position: u8) = "{name}, position {position}";
    fn positions() = "position, steps";
    fn speeds() = "speed, steps a second";
    fn speeds_cut() = "speed, steps a second (peaks cut off)";
    fn event(cause: JumpCause, certainty: Likelihood) = "{cause}, {certainty}";
    fn event_at(line: u64, at_ns: Duration, cause: JumpCause, certainty: Likelihood) =
        "line {line}, {at_ns}: {cause}, {certainty}";
    fn unmarked(events: usize) = "{events} more are not marked here; the report has them";
    fn undrawn() = "further encoders are in the file; no more than eight are drawn";
}
