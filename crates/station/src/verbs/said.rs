//! Why nothing was done, in sentences. The terminal has the English ones, the page those of its own language.

use encoring_bus::MasterError;
use encoring_files::toml_text::{Outside, Wrong};
use encoring_host::RequestError;
use encoring_host::session::{Fate, TimedOut, WaitedFor};
use encoring_sim::scenario::SECONDS_MAX;
use encoring_texts::{Hex, Said, SaidTemplate, own, retold, texts};
use encoring_words::Duration;

use super::{ID_BYTES_MAX, Refused, names};
use crate::serving::NotServed;

texts! {
    "refused";

    fn not_an_object() = "not a JSON object; a line looks like {{\"verb\":\"help\"}}";
    fn json(column: usize, problem: Said) = "column {column}: {problem}";
    fn no_verb(verbs: String) = "verb is missing; the verbs are {verbs}";
    fn unknown_verb(verb: &str, verbs: String) = "verb {verb}; the verbs are {verbs}";
    fn id(bytes: usize, most: usize) =
        "id of {bytes} bytes; an id is a string, a number, true, false or null of at most {most}";
    fn not_here(verb: &str, others: &str) = "verb {verb} is not for this ring; the verbs are {others}";
    fn only_looks() = "this page only shows; started with --allow-control it changes something too";
    fn position(position: i64, known: &str) = "position {position}; the encoders are at {known}";
    fn of_model(position: usize, model: &str, problem: Said) = "position {position}, a {model}: {problem}";
    fn file(position: usize) =
        "position {position}: motion kind \"csv\" opens a file, which a peer cannot ask for; use moves";
    fn no_segment(last: usize) = "segment is missing; the segments are 0 to {last}";
    fn segment(segment: i64, last: usize) = "segment {segment}; the segments are 0 to {last}";
    fn for_s(for_s: String, most: String) = "for_s {for_s}; the limits are 0 and {most}";
    fn none_with(key: &str) =
        "{key} with fault \"none\", which ends every fault of the line and takes no other key";
    fn fault_and_end() = "fault and end in one line; fault begins one, end ends one";
    fn no_gateway() = "there is no Modbus server whose answers could be spoilt";
    fn word(problem: Said) = "word: {problem}";
    fn service(service: i64) = "service {service}; the services are 1 to 6, 8, 9 and 13";
    fn value_of_check() = "value with service 8, the data check, which is only read";
    fn read_of_preset() = "service 6, the preset adjustment, cannot be read; value is missing";
    fn value(value: i64) = "value {value}; the limits are 0 and 16777215";
    fn at(position: usize, problem: Said) = "position {position}: {problem}";
    fn given_up() = "given up, the program ends";
    fn stopped() = "the ring has stopped";
}

/// What other crates say of what went wrong, in their words.
mod elsewhere {
    use super::{Duration, Hex, Said, retold};

    retold! {
        "problem";

        fn limits(key: &str, value: &str, low: &str, high: &str);
        fn no_word(word: &str);
        fn range(service: Hex<2>, value: String, low: String, high: String);
        fn above_length(value: String, length: String);
        fn no_service(service: Hex<2>, model: &str);
        fn no_encoder(position: usize);
        fn under_way(out: Hex<8>);
        fn overwritten(out: Hex<8>, ours: Hex<8>);
        fn not_prepared(word: Hex<8>);
        fn in_service(word: Hex<8>);
        fn misread(word: Hex<8>);
        fn stale(age_ns: Duration);
        fn interrupted();
        fn no_normal(time_ns: Duration, fate: Said);
        fn no_reply(time_ns: Duration, fate: Said);
        fn no_end(time_ns: Duration, fate: Said);
        fn not_sent();
        fn unknown();
        fn carried_out();
    }
}

/// Every sentence that says why nothing was done.
pub fn refusals() -> impl Iterator<Item = &'static SaidTemplate> {
    TEXTS.iter().chain(elsewhere::RETOLD)
}

impl Refused {
    /// As a sentence.
    #[must_use]
    pub fn said(&self) -> Said {
        match self {
            Self::NotAnObject => not_an_object(),
            Self::Json { column, problem } => json(*column, own(problem)),
            Self::NoVerb => no_verb(names()),
            Self::UnknownVerb { verb } => unknown_verb(verb, names()),
            Self::Id { bytes } => id(*bytes, ID_BYTES_MAX),
            Self::NotHere { verb, others } => not_here(verb, others),
            Self::OnlyLooks => only_looks(),
            Self::Position { position: asked, known } => position(*asked, known),
            Self::Set { position, model, problem } => of_model(*position, model.name(), of_value(problem)),
            Self::File { position } => file(*position),
            Self::NoSegment { last } => no_segment(*last),
            Self::Segment { segment: asked, last } => segment(*asked, *last),
            Self::ForS { for_s: asked } => for_s(asked.to_string(), SECONDS_MAX.to_string()),
            Self::NoneWith { key } => none_with(key),
            Self::FaultAndEnd => fault_and_end(),
            Self::NoGateway => no_gateway(),
            Self::Gateway(problem) => own(problem),
            Self::Word { written, problem } => word(elsewhere::no_word(problem, written)),
            Self::Service { service: asked } => service(*asked),
            Self::ValueOfCheck => value_of_check(),
            Self::ReadOfPreset => read_of_preset(),
            Self::Value { value: asked } => value(*asked),
            Self::Request { position, problem } => at(*position, of_request(problem)),
            Self::NotServed { position, problem } => at(*position, of_service(*problem)),
            Self::GivenUp { position } => at(*position, given_up()),
            Self::Bus { position, problem } => at(*position, of_bus(problem)),
            Self::TimedOut { position, timed_out } => at(*position, of_time(*timed_out)),
            Self::Stopped(_) => stopped(),
        }
    }
}

fn of_value(wrong: &Wrong) -> Said {
    match wrong.beyond() {
        Some(Outside { key, value, low, high }) => elsewhere::limits(wrong, key, value, low, high),
        None => own(wrong),
    }
}

fn of_request(problem: &RequestError) -> Said {
    match *problem {
        RequestError::Range { service, typed, low, high } => {
            let [low, high] = [low, high].map(|limit| typed.like(limit).to_string());
            elsewhere::range(problem, Hex(service.number().into()), typed.to_string(), low, high)
        }
        RequestError::AboveLength { typed, length } => {
            elsewhere::above_length(problem, typed.to_string(), typed.like(length).to_string())
        }
        RequestError::Unknown { service, model } => {
            elsewhere::no_service(problem, Hex(service.number().into()), model.name())
        }
    }
}

fn of_service(problem: NotServed) -> Said {
    match problem {
        NotServed::NoEncoder { position } => elsewhere::no_encoder(&problem, position),
        NotServed::UnderWay { out } => elsewhere::under_way(&problem, Hex(out.0)),
        NotServed::Overwritten { out, ours } => elsewhere::overwritten(&problem, Hex(out.0), Hex(ours.0)),
    }
}

fn of_bus(problem: &MasterError) -> Said {
    match *problem {
        MasterError::Bus(ref failed) => own(failed),
        MasterError::NotPrepared { word, .. } => elsewhere::not_prepared(problem, Hex(word.0)),
        MasterError::OtherMaster { out } => elsewhere::under_way(problem, Hex(out.0)),
        MasterError::Overwritten { out, ours } => elsewhere::overwritten(problem, Hex(out.0), Hex(ours.0)),
        MasterError::InService { input } => elsewhere::in_service(problem, Hex(input.0)),
        MasterError::Misread { input, .. } => elsewhere::misread(problem, Hex(input.0)),
        MasterError::Stale { age } => elsewhere::stale(problem, age),
        MasterError::Interrupted => elsewhere::interrupted(problem),
    }
}

fn of_time(timed_out: TimedOut) -> Said {
    let TimedOut { waited_for, time, fate, .. } = timed_out;
    // What became of it is a part of the text already.
    let fate = match fate {
        Fate::NotSent => elsewhere::not_sent(""),
        Fate::Unknown => elsewhere::unknown(""),
        Fate::CarriedOut(_) => elsewhere::carried_out(""),
    };
    match waited_for {
        WaitedFor::Normal => elsewhere::no_normal(&timed_out, time, fate),
        WaitedFor::Acknowledgement => elsewhere::no_reply(&timed_out, time, fate),
        WaitedFor::End => elsewhere::no_end(&timed_out, time, fate),
    }
}
