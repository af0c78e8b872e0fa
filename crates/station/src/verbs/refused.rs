//! Why nothing was done.

use encoring_bus::MasterError;
use encoring_host::RequestError;
use encoring_host::session::TimedOut;
use encoring_sim::scenario::SECONDS_MAX;
use encoring_words::Model;

use super::{ID_BYTES_MAX, names};
use crate::serving::NotServed;
use crate::station::RingStopped;

/// Why a line was refused. Nothing was done then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused {
    /// No JSON object.
    #[error("not a JSON object; a line looks like {{\"verb\":\"help\"}}")]
    NotAnObject,
    /// Malformed JSON, or a key or type that does not belong there.
    #[error("column {column}: {problem}")]
    Json {
        /// Where in the line it was noticed, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// Nothing is asked.
    #[error("verb is missing; the verbs are {}", names())]
    NoVerb,
    /// No such verb.
    #[error("verb {verb}; the verbs are {}", names())]
    UnknownVerb {
        /// As it was written.
        verb: String,
    },
    /// Too long to be echoed, or no scalar.
    #[error(
        "id of {bytes} bytes; an id is a string, a number, true, false or null of at most {ID_BYTES_MAX}"
    )]
    Id {
        /// Its length as it was written.
        bytes: usize,
    },
    /// There is nothing on this ring that the verb could change or show.
    #[error("verb {verb} is not for this ring; the verbs are {others}")]
    NotHere {
        /// Which.
        verb: &'static str,
        /// Those that are.
        others: String,
    },
    /// Whoever asks may only look.
    #[error("this page only shows; started with --allow-control it changes something too")]
    OnlyLooks,
    /// No such encoder.
    #[error("position {position}; the encoders are at {known}")]
    Position {
        /// As asked.
        position: i64,
        /// Where there is one.
        known: String,
    },
    /// A value that this encoder cannot be given.
    #[error("position {position}, a {model}: {problem}")]
    Set {
        /// Its position.
        position: usize,
        /// Its model.
        model: Model,
        /// Key, value and limit.
        problem: String,
    },
    /// A motion from a file.
    #[error("position {position}: motion kind \"csv\" opens a file, which a peer cannot ask for; use moves")]
    File {
        /// Of which encoder.
        position: usize,
    },
    /// A fault without its place.
    #[error("segment is missing; the segments are 0 to {last}")]
    NoSegment {
        /// The one that leads back to the master.
        last: usize,
    },
    /// No such segment.
    #[error("segment {segment}; the segments are 0 to {last}")]
    Segment {
        /// As asked.
        segment: i64,
        /// The one that leads back to the master.
        last: usize,
    },
    /// No span of time.
    #[error("for_s {for_s}; the limits are 0 and {SECONDS_MAX}")]
    ForS {
        /// As asked.
        for_s: f64,
    },
    /// A place or time with the end of all faults.
    #[error("{key} with fault \"none\", which ends every fault of the line and takes no other key")]
    NoneWith {
        /// Which.
        key: &'static str,
    },
    /// Two things of the gateway at once.
    #[error("fault and end in one line; fault begins one, end ends one")]
    FaultAndEnd,
    /// There is no gateway.
    #[error("there is no Modbus server whose answers could be spoilt")]
    NoGateway,
    /// The gateway does not take it.
    #[error("{0}")]
    Gateway(String),
    /// A text that is no word, or one with two meanings.
    #[error("word: {0}")]
    Word(String),
    /// A service number that no manual lists.
    #[error("service {service}; the services are 1 to 6, 8, 9 and 13")]
    Service {
        /// As asked.
        service: i64,
    },
    /// A value where none is taken.
    #[error("value with service 8, the data check, which is only read")]
    ValueOfCheck,
    /// A service that is only written.
    #[error("service 6, the preset adjustment, cannot be read; value is missing")]
    ReadOfPreset,
    /// No value.
    #[error("value {value}; the limits are 0 and 16777215")]
    Value {
        /// As asked.
        value: i64,
    },
    /// A service or value that this encoder does not take. Nothing was sent.
    #[error("position {position}: {problem}")]
    Request {
        /// Its position.
        position: usize,
        /// Service, value and limit.
        problem: RequestError,
    },
    /// A service that was not carried out here.
    #[error("position {position}: {problem}")]
    NotServed {
        /// Which encoder.
        position: usize,
        /// Why.
        problem: NotServed,
    },
    /// A service that was given up because the program ends.
    #[error("position {position}: given up, the program ends")]
    GivenUp {
        /// Which encoder.
        position: usize,
    },
    /// The bus did not take it.
    #[error("position {position}: {problem}")]
    Bus {
        /// Which encoder.
        position: usize,
        /// Why.
        problem: MasterError,
    },
    /// A service that came to no end in time.
    #[error("position {position}: {timed_out}")]
    TimedOut {
        /// Which encoder.
        position: usize,
        /// What was waited for.
        timed_out: TimedOut,
    },
    /// There is nothing left to change or look at.
    #[error(transparent)]
    Stopped(#[from] RingStopped),
}
