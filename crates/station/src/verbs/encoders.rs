//! The encoders that a line may name.

use encoring_encoder::Unit;
use encoring_words::Model;

use super::{Refused, SaidTo, VERBS, Verb};

/// The encoders that a line may name.
#[derive(Clone, Copy, Debug)]
pub enum Encoders<'a> {
    /// Those of a ring that is simulated here, by position.
    Simulated(&'a [Unit]),
    /// Those of a ring behind a bus, with their positions.
    Polled(&'a [(usize, Model)]),
}

impl<'a> From<&'a [Unit]> for Encoders<'a> {
    fn from(units: &'a [Unit]) -> Self {
        Self::Simulated(units)
    }
}

impl<'a> Encoders<'a> {
    /// Whether there is something here that this verb could change or show.
    pub(crate) const fn take(self, verb: &Verb) -> bool {
        match verb.said_to {
            SaidTo::Any => true,
            SaidTo::Simulated => matches!(self, Self::Simulated(_)),
            SaidTo::Polled => matches!(self, Self::Polled(_)),
        }
    }

    /// The names of those verbs.
    pub(super) fn verbs(self) -> String {
        let here = VERBS.iter().filter(|verb| self.take(verb));
        here.map(|verb| verb.name).collect::<Vec<_>>().join(", ")
    }

    pub(super) const fn count(self) -> usize {
        match self {
            Self::Simulated(units) => units.len(),
            Self::Polled(placed) => placed.len(),
        }
    }

    fn unknown(self, position: i64) -> Refused {
        let known = match self {
            Self::Simulated(units) => format!("0 to {}", units.len().saturating_sub(1)),
            Self::Polled(placed) => {
                placed.iter().map(|(position, _)| position.to_string()).collect::<Vec<_>>().join(", ")
            }
        };
        Refused::Position { position, known }
    }

    /// The model at a position.
    pub(super) fn placed(self, asked: i64) -> Result<(usize, Model), Refused> {
        let position = usize::try_from(asked).map_err(|_| self.unknown(asked))?;
        let model = match self {
            Self::Simulated(units) => units.get(position).map(Unit::model),
            Self::Polled(placed) => {
                placed.iter().find(|(place, _)| *place == position).map(|(_, model)| *model)
            }
        };
        Ok((position, model.ok_or_else(|| self.unknown(asked))?))
    }

    /// The simulated encoder at a position.
    pub(super) fn simulated(self, asked: i64) -> Result<(usize, &'a Unit), Refused> {
        let Self::Simulated(units) = self else { return Err(self.unknown(asked)) };
        let position = usize::try_from(asked).map_err(|_| self.unknown(asked))?;
        Ok((position, units.get(position).ok_or_else(|| self.unknown(asked))?))
    }
}
