//! Why nothing was done.

use encoring_bus::MasterError;
use encoring_files::toml_text::Wrong;
use encoring_host::RequestError;
use encoring_host::session::TimedOut;
use encoring_words::Model;

use crate::serving::NotServed;
use crate::station::RingStopped;

/// Why a line was refused. Nothing was done then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}", self.said())]
pub enum Refused {
    /// No JSON object.
    NotAnObject,
    /// Malformed JSON, or a key or type that does not belong there.
    Json {
        /// Where in the line it was noticed, from 1.
        column: usize,
        /// What is wrong.
        problem: String,
    },
    /// Nothing is asked.
    NoVerb,
    /// No such verb.
    UnknownVerb {
        /// As it was written.
        verb: String,
    },
    /// Too long to be echoed, or no scalar.
    Id {
        /// Its length as it was written.
        bytes: usize,
    },
    /// There is nothing on this ring that the verb could change or show.
    NotHere {
        /// Which.
        verb: &'static str,
        /// Those that are.
        others: String,
    },
    /// Whoever asks may only look.
    OnlyLooks,
    /// No such encoder.
    Position {
        /// As asked.
        position: i64,
        /// Where there is one.
        known: String,
    },
    /// A value that this encoder cannot be given.
    Set {
        /// Its position.
        position: usize,
        /// Its model.
        model: Model,
        /// Key, value and limit.
        problem: Wrong,
    },
    /// A motion from a file.
    File {
        /// Of which encoder.
        position: usize,
    },
    /// A fault without its place.
    NoSegment {
        /// The one that leads back to the master.
        last: usize,
    },
    /// No such segment.
    Segment {
        /// As asked.
        segment: i64,
        /// The one that leads back to the master.
        last: usize,
    },
    /// No span of time.
    ForS {
        /// As asked.
        for_s: f64,
    },
    /// A place or time with the end of all faults.
    NoneWith {
        /// Which.
        key: &'static str,
    },
    /// Two things of the gateway at once.
    FaultAndEnd,
    /// There is no gateway.
    NoGateway,
    /// The gateway does not take it.
    Gateway(String),
    /// A text that is no word, or one with two meanings.
    Word {
        /// As it was written.
        written: String,
        /// What is wrong with it.
        problem: String,
    },
    /// A service number that no manual lists.
    Service {
        /// As asked.
        service: i64,
    },
    /// A value where none is taken.
    ValueOfCheck,
    /// A service that is only written.
    ReadOfPreset,
    /// No value.
    Value {
        /// As asked.
        value: i64,
    },
    /// A service or value that this encoder does not take. Nothing was sent.
    Request {
        /// Its position.
        position: usize,
        /// Service, value and limit.
        problem: RequestError,
    },
    /// A service that was not carried out here.
    NotServed {
        /// Which encoder.
        position: usize,
        /// Why.
        problem: NotServed,
    },
    /// A service that was given up because the program ends.
    GivenUp {
        /// Which encoder.
        position: usize,
    },
    /// The bus did not take it.
    Bus {
        /// Which encoder.
        position: usize,
        /// Why.
        problem: MasterError,
    },
    /// A service that came to no end in time.
    TimedOut {
        /// Which encoder.
        position: usize,
        /// What was waited for.
        timed_out: TimedOut,
    },
    /// There is nothing left to change or look at.
    Stopped(RingStopped),
}

impl From<RingStopped> for Refused {
    fn from(stopped: RingStopped) -> Self {
        Self::Stopped(stopped)
    }
}
