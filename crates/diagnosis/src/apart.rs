//! What would tell causes from each other, in sentences.

use encoring_texts::{Said, texts};

use crate::cause::JumpCause;
use crate::services::Services;

texts! {
    "apart";

    fn bit_31() = "log the whole word: bit 31 tells a reply";
    fn torn() = "log faster, both halves in one access: a torn word stands where the high half changes";
    fn wrong_bit() = "log faster: a wrong bit comes anywhere, not only where the high half changes";
    fn whole_word() = "log the whole word";
    fn code() = "read service 01: its byte 1 is the code";
    fn range() = "give S with --parameters";
    fn input() = "an input that made a preset shows at its pin";
    fn evenly() = "let the axis go on evenly";
    fn master() = "log the master's status too";
    fn preset() = "log OUT too: service 06 shows there; an input shows at its pin";
    fn services() = "log OUT too: services 01, 02, 03, 09 show there; or let the axis go on evenly";
    fn mark() = "look at the mark, and give what it shows with --known";
    fn refresh() = "log once a refresh time, or slower than 4 of them";
    fn faster() = "log faster, and give what the axis does at most with --max-rpm";
    fn thrice() = "let the axis pass the bit three times";
    fn still() = "let the axis stand still";
    fn out_and_master() = "log OUT and the master's status too";
    fn beside() = "log the encoder beside it too";
    fn coupling() = "look at the mark on shaft and coupling";
    fn poll_faster() = "poll faster, and `encoring diagnose` a log of it";
}

/// What shows whether it is this cause or another; `None` if nothing would.
pub(crate) fn telling(cause: JumpCause, seen: &Services) -> Option<Said> {
    Some(match cause {
        JumpCause::ReplyAsPosition => bit_31(),
        JumpCause::TornWords => torn(),
        JumpCause::SingleBit => wrong_bit(),
        JumpCause::HalvesExchanged => whole_word(),
        JumpCause::GrayAsBinary | JumpCause::BinaryAsGray => code(),
        JumpCause::Wrap => range(),
        JumpCause::Preset if seen.shows_out() => input(),
        JumpCause::Rescaled | JumpCause::Direction if seen.shows_out() => evenly(),
        JumpCause::Frozen if seen.shows_out() => master(),
        JumpCause::Preset => preset(),
        JumpCause::Rescaled | JumpCause::Direction => services(),
        JumpCause::ZeroLost => mark(),
        JumpCause::Aliasing => refresh(),
        JumpCause::OverSpeed | JumpCause::OverAcceleration => faster(),
        JumpCause::StuckBit => thrice(),
        JumpCause::Noise => still(),
        JumpCause::Frozen => out_and_master(),
        JumpCause::OtherSource => beside(),
        JumpCause::Mechanical => coupling(),
        JumpCause::Unclear => return None,
    })
}
