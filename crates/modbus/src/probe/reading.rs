//! What some registers, read several times, can be: without any input or output.
//!
//! An IN word in normal mode is 00h or 20h and a position; in a reply it is 8xh, Axh, Cxh or Exh and data [R17..R24].
//! That leaves two word orders and two ways to begin. They are told apart by
//!
//! - words that no encoder sends: with both halves exchanged, the upper byte is one of the position's;
//! - motion: the low half of a position changes at least as often as the high one;
//! - edges: a reading that is one register off leaves the first and the last register over.

use encoring_bus::misread::can_be_sent;
use encoring_ring::diagnostics::status::{self, DC_RESULT, QUALITY};
use encoring_words::InWord;
use encoring_words::word::In;

use super::Certainty;
use crate::place::{DIAGNOSIS, REGISTERS_PER_ENCODER, RegisterPlace, WordOrder};

/// A master whose bus runs.
const RUNNING: u16 = status::READY | status::ACTIVE | status::RUN;
/// What it is with a fault: it repeats, searches, or has found a place.
const STATES: [u16; 3] =
    [RUNNING, status::READY | status::DETECT, status::READY | status::DETECT | status::BUS];

/// Registers without a gap and what stood in them, one row for each reading.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Readout {
    /// The first.
    pub place: RegisterPlace,
    /// How many.
    pub count: u16,
    /// Whether it is known that there is none before the first, and none after the last.
    pub sharp: (bool, bool),
    readings: Vec<Vec<u16>>,
}

impl Readout {
    /// A block as it was first read.
    #[must_use]
    pub fn new(place: RegisterPlace, sharp: (bool, bool), values: Vec<u16>) -> Self {
        let count = u16::try_from(values.len()).unwrap_or(u16::MAX);
        Self { place, count, sharp, readings: vec![values] }
    }

    /// What it held when it was read again; a reading that is not whole is not taken.
    pub fn add(&mut self, values: Vec<u16>) {
        if values.len() == usize::from(self.count) {
            self.readings.push(values);
        }
    }

    /// The register after the last.
    #[must_use]
    pub fn end(&self) -> usize {
        usize::from(self.place.first) + usize::from(self.count)
    }

    /// Whether a register is in it.
    #[must_use]
    pub fn holds(&self, register: u16) -> bool {
        self.place.first <= register && usize::from(register) < self.end()
    }

    /// Whether it is more than zeros.
    #[must_use]
    pub fn holds_something(&self) -> bool {
        self.readings.iter().flatten().any(|value| *value != 0)
    }

    /// Whether it is what our own server shows as the master's diagnosis: it begins there, with a status that a master
    /// can have. Of the words that these two registers would be, an encoder can send one of each order only.
    pub(super) fn is_diagnosis(&self) -> bool {
        let is_status = |reading: &Vec<u16>| match reading.first_chunk() {
            Some(&[state, parameter]) => match state & !QUALITY {
                RUNNING => parameter == 0,
                state => state & DC_RESULT != 0 && STATES.contains(&(state & !DC_RESULT)),
            },
            None => false,
        };
        self.place.first == DIAGNOSIS && self.readings.iter().all(is_status)
    }

    /// Whether all that is not zero stands in a run of words at these offsets.
    fn holds_nothing_but(&self, run: &[usize]) -> bool {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return false };
        let inside = *first..last + REGISTERS_PER_ENCODER;
        let values = self.readings.iter().flat_map(|reading| reading.iter().enumerate());
        values.filter(|(_, value)| **value != 0).all(|(offset, _)| inside.contains(&offset))
    }

    /// The word at an offset in each reading.
    fn words(&self, offset: usize, order: WordOrder) -> impl Iterator<Item = u32> {
        self.readings.iter().filter_map(move |reading| {
            let halves = reading.get(offset..)?.first_chunk::<REGISTERS_PER_ENCODER>()?;
            Some(order.word(*halves))
        })
    }

    /// Whether this hypothesis about it shows the same as that one about another block: as many words, and in the
    /// same upper bytes. What moves differs between two requests.
    pub(super) fn looks_like(&self, mine: &Hypothesis, other: &Self, theirs: &Hypothesis) -> bool {
        let upper = |block: &Self, hypothesis: &Hypothesis| -> Vec<u32> {
            let offsets = (hypothesis.offset..).step_by(REGISTERS_PER_ENCODER).take(hypothesis.words);
            offsets
                .filter_map(|offset| block.words(offset, hypothesis.order).last())
                .map(|word| word >> 16)
                .collect()
        };
        upper(self, mine) == upper(other, theirs)
    }
}

/// One way to read a block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hypothesis {
    /// Where the words begin, from the block's first register.
    pub offset: usize,
    /// How many there are.
    pub words: usize,
    /// Which half comes first.
    pub order: WordOrder,
    /// How many of them move as positions do.
    pub moving: usize,
    /// How many of them are replies.
    pub replies: usize,
    /// Whether they are all that there is.
    pub alone: bool,
    /// Whether they begin where the registers begin or end where those end; more than one reading of a block can.
    pub edge: bool,
    /// A word that the other order would give and no encoder sends.
    pub otherwise: Option<u32>,
    /// All that in one.
    pub certainty: Certainty,
}

/// What speaks for some words and against them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Weight {
    /// How many move as positions do.
    pub moving: usize,
    /// How many are replies.
    pub replies: usize,
    /// One that no encoder sends, or that moves as no position does.
    pub against: Option<u32>,
}

/// Weighs the words at these offsets; `None` if there are none.
#[must_use]
pub fn weigh(block: &Readout, offsets: &[usize], order: WordOrder) -> Option<Weight> {
    let mut weight = Weight::default();
    let mut seen = false;
    for offset in offsets {
        let (mut low, mut high) = (0, 0);
        let mut last: Option<u32> = None;
        let mut reply = false;
        for word in block.words(*offset, order) {
            seen = true;
            if !can_be_sent(InWord(word)) {
                weight.against.get_or_insert(word);
            }
            match InWord(word).decode() {
                In::Position { .. } => {
                    if let Some(last) = last {
                        low += usize::from(last as u16 != word as u16);
                        high += usize::from(last >> 16 != word >> 16);
                    }
                    last = Some(word);
                }
                In::Reply(_) | In::Foreign(_) => {
                    reply = true;
                    last = None;
                }
            }
        }
        if high > low
            && let Some(word) = last
        {
            weight.against.get_or_insert(word);
        }
        weight.moving += usize::from(low > 0 && low >= high);
        weight.replies += usize::from(reply);
    }
    seen.then_some(weight)
}

/// The ways to read a block, the best first; of ways that overlap, a certain one leaves no other.
#[must_use]
pub fn hypotheses(block: &Readout) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for order in [WordOrder::HighFirst, WordOrder::LowFirst] {
        for parity in 0..REGISTERS_PER_ENCODER {
            all.extend(runs(block, order, parity));
        }
    }
    all.sort_by_key(|h| {
        let even = (usize::from(block.place.first) + h.offset).is_multiple_of(2);
        std::cmp::Reverse((h.certainty, h.alone, h.edge, h.moving, h.otherwise.is_some(), h.words, even))
    });
    let mut kept: Vec<Hypothesis> = Vec::new();
    for mut hypothesis in all {
        let rivals = kept.iter().filter(|better| better.overlaps(&hypothesis));
        match rivals.map(|better| better.certainty).max() {
            Some(Certainty::Certain) => {}
            Some(_) => {
                hypothesis.certainty = Certainty::Possible;
                kept.push(hypothesis);
            }
            None => kept.push(hypothesis),
        }
    }
    kept
}

impl Hypothesis {
    fn overlaps(&self, other: &Self) -> bool {
        let end = |h: &Self| h.offset + h.words * REGISTERS_PER_ENCODER;
        self.offset < end(other) && other.offset < end(self)
    }
}

/// The longest runs of words that encoders can send.
fn runs(block: &Readout, order: WordOrder, parity: usize) -> Vec<Hypothesis> {
    let count = usize::from(block.count);
    let mut found = Vec::new();
    let mut run: Vec<usize> = Vec::new();
    let ends = (parity..count.saturating_sub(1)).step_by(REGISTERS_PER_ENCODER).map(Some).chain([None]);
    for offset in ends {
        match offset {
            Some(offset) if weigh(block, &[offset], order).is_some_and(|weight| weight.against.is_none()) => {
                run.push(offset);
            }
            _ => found.extend(hypothesis(block, order, &std::mem::take(&mut run))),
        }
    }
    found
}

fn hypothesis(block: &Readout, order: WordOrder, run: &[usize]) -> Option<Hypothesis> {
    let zero = |offset: &usize| block.words(*offset, order).all(|word| word == 0);
    let begins = run.iter().position(|offset| !zero(offset))?;
    let ends = run.iter().rposition(|offset| !zero(offset))?;
    let core = run.get(begins..=ends)?;
    let at_start = block.sharp.0 && run.first() == Some(&0);
    let at_end = block.sharp.1
        && run.last().is_some_and(|last| last + REGISTERS_PER_ENCODER == usize::from(block.count));
    // An encoder may stand at 0, but not most of them.
    let zeros = run.iter().filter(|offset| zero(offset)).count();
    let alone = at_start && at_end && zeros * 2 <= run.len();
    let edge = at_start && begins == 0 || at_end && ends + 1 == run.len();
    let run = if alone { run } else { core };
    let weight = weigh(block, run, order)?;
    if weight.moving == 0 && !alone && !block.holds_nothing_but(run) {
        return None;
    }
    let other = match order {
        WordOrder::HighFirst => WordOrder::LowFirst,
        WordOrder::LowFirst => WordOrder::HighFirst,
    };
    let otherwise = weigh(block, run, other)?.against;
    let certainty = match (weight.moving, otherwise) {
        (1.., Some(_)) if alone => Certainty::Certain,
        (1.., Some(_)) => Certainty::Likely,
        _ => Certainty::Possible,
    };
    let Weight { moving, replies, .. } = weight;
    let offset = *run.first()?;
    Some(Hypothesis { offset, words: run.len(), order, moving, replies, alone, edge, otherwise, certainty })
}
