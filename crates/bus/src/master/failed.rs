//! Why a service came to nothing.

use encoring_words::{Duration, InWord, OutWord};

use crate::bus::{Bus, BusError, rounded};
use crate::misread::Misread;

/// Why a service was not even begun.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MasterError {
    /// The bus cannot be read or written.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Another master's service is under way: its service bit is set [R30].
    #[error(
        "OUT holds {out}: another master's service is under way, or was left there; this request was not sent"
    )]
    OtherMaster {
        /// The OUT word that stands on the bus.
        out: OutWord,
    },
    /// Somebody else writes the OUT word.
    #[error(
        "OUT holds {out} instead of the {ours} written here: another master writes it, or the gateway does not let it be \
         written; this request was not sent"
    )]
    Overwritten {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
    /// The word that goes before the request, without the service bit, could not be seen on OUT.
    #[error("{}", not_prepared(.behind, *.word))]
    NotPrepared {
        /// The word.
        word: OutWord,
        /// What stood there instead, or how its write was answered.
        behind: Behind,
    },
    /// The encoder shows a reply that nobody here asked for.
    #[error("IN holds {input}: a service that was not asked for here is not ended; no position can be seen")]
    InService {
        /// The IN word.
        input: InWord,
    },
    /// IN shows what no encoder sends.
    #[error("IN holds {input}, which no encoder sends{}", .cure)]
    Misread {
        /// The IN word.
        input: InWord,
        /// How it is an encoder's, and what to change, if that can be told.
        cure: Cure,
    },
    /// The IN words do not come from the ring any more.
    #[error(
        "the IN word is {} old: the ring has stopped, or the encoder is not on it. Look at the lamps of master and \
         encoder, and at `encoring scan`", rounded(*.age)
    )]
    Stale {
        /// Its age.
        age: Duration,
    },
    /// The user wants to stop.
    #[error("interrupted")]
    Interrupted,
}

/// What may be behind a request that came to nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Behind {
    /// The last trouble with the bus.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// OUT was looked at, and the gateway had not let the word through as it was.
    #[error("OUT holds {out} instead of the {ours} written here: the same word with {}{cure}", .way.name())]
    Turned {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
        /// How the one is the other.
        way: Misread,
        /// What to change, if that can be told.
        cure: Cure,
    },
    /// OUT was looked at, and nothing stood there, or the word before that one.
    #[error(
        "OUT holds {out} instead of the {ours} written here: a PLC or another master writes it, or the gateway has let \
         its outputs fall, does not write what it acknowledges, or shows other registers; `encoring probe` looks for them"
    )]
    NotThere {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
    /// OUT was looked at, and another master had written it.
    #[error("OUT holds {out} instead of the {ours} written here: another master writes it")]
    OtherMaster {
        /// The OUT word that stands on the bus.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
}

/// How a word that no encoder sends is one's, and what to change.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cure(String);

impl Cure {
    /// For a word on a bus.
    pub fn of<B: Bus + ?Sized>(bus: &B, input: InWord) -> Self {
        let Some(misread) = Misread::of(input) else { return Self::default() };
        Self::by(bus, misread, format_args!("{}, a position", misread.read(input)))
    }

    /// For words whose way to the ring is this.
    pub(super) fn of_writes<B: Bus + ?Sized>(bus: &B, way: Misread) -> Self {
        Self(told(bus.cure_of_writes(way)))
    }

    /// For a word that is this if it is read so.
    pub fn by<B: Bus + ?Sized>(bus: &B, misread: Misread, is: impl std::fmt::Display) -> Self {
        Self(format!("; with {} it is {is}{}", misread.name(), told(bus.cure(misread))))
    }
}

impl std::fmt::Display for Cure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// What to change, if that can be told, as the end of a sentence.
fn told(cure: Option<String>) -> String {
    cure.map(|cure| format!(". What cures it: {cure}")).unwrap_or_default()
}

fn not_prepared(behind: &Behind, word: OutWord) -> String {
    let told = format!("this request was not sent: {behind}");
    match behind {
        Behind::Bus(_) => format!(
            "{told}. {word} was written before it, without the service bit, and where that stands is not known"
        ),
        _ => told,
    }
}
