//! Where on an unknown gateway the encoders are, found out by reading: table, first register, word order, layout.
//!
//! [`probe`] looks at registers all over the range in which gateways put process data, reads what is there several
//! times, and tells from the words which of them are IN words ([`reading`] says how). It never writes.
//!
//! Most of what it can tell it tells from motion. An encoder at rest shows a number, and so does everything else.

use std::fmt::{self, Display};
use std::ops::ControlFlow;

use encoring_bus::{Bus, BusError};
use encoring_words::Duration;

use crate::address::{Address, Layout};
use crate::client::{Client, reading as function};
use crate::error::ModbusError;
use crate::inline::{Directory, MODULES_MAX};
use crate::pdu::READ_MAX;
use crate::place::{DATA, MODULES, REGISTERS_PER_ENCODER, RegisterPlace, Table, WordOrder};

pub mod reading;

use reading::{Hypothesis, Readout};

/// Registers of one request; even, so that a word that begins with the block is never torn.
const CHUNK: u16 = READ_MAX - 1;
/// The first registers of blocks that are looked for are multiples of this, besides [`ODD_STARTS`].
const STEP: usize = 100;
/// Where blocks of gateways begin that count in powers of two, and what counts from 1.
const ODD_STARTS: [u16; 10] = [1, 0x100, 0x200, 0x400, 0x800, 0x1000, 0x2000, 0x3000, 0x4000, 0x8000];
/// The longest block that is looked at in one piece: twice the longest ring.
const BLOCK_MAX: u16 = 512;

/// How far a probe goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reach {
    /// The last register at which a block is looked for.
    pub last: u16,
    /// How often each block is read; motion is seen between two readings.
    pub passes: u32,
    /// The pause before each reading but the first.
    pub pause: Duration,
    /// The most requests, all in all.
    pub requests: u32,
}

impl Default for Reach {
    fn default() -> Self {
        Self { last: 10_000, passes: 6, pause: Duration::from_millis(50), requests: 2_000 }
    }
}

/// Where a probe is, told before each request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Requests so far.
    pub requests: u32,
    /// What it is about.
    pub stage: Stage,
    /// What is read next.
    pub place: RegisterPlace,
}

/// What a probe is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Which registers there are.
    Looking,
    /// Which of them move.
    Watching {
        /// The reading, from 2.
        pass: u32,
        /// How many there will be.
        of: u32,
    },
}

/// What a probe found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Findings {
    /// What the gateway may be, the most probable first.
    pub candidates: Vec<Candidate>,
    /// Registers that there are, without a gap each.
    pub blocks: Vec<(RegisterPlace, u16)>,
    /// How many requests it took.
    pub requests: u32,
    /// How it ended.
    pub end: End,
}

/// How a probe ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// It has looked at everything.
    Whole,
    /// It was told to stop.
    Stopped,
    /// It has used up its requests.
    Limit,
}

/// What may stand in some registers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Candidate {
    /// How sure that is.
    pub certainty: Certainty,
    /// The bus address that reads it so.
    pub address: Address,
    /// How many encoders that gives.
    pub encoders: usize,
    /// What speaks for it and what is open.
    pub evidence: Vec<Evidence>,
}

/// How sure a probe is, in rising order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Certainty {
    /// The registers can be read so, and otherwise too.
    Possible,
    /// Something moves as a position does; where it begins, or what is beside it, is open.
    Likely,
    /// Something moves as a position does, and no other reading of these registers makes words of encoders.
    Certain,
}

/// What speaks for a candidate, and what is open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Words that change as positions do: the low half more often than the high one, the upper byte 00h or 20h.
    Moves {
        /// How many.
        words: usize,
    },
    /// No word changes.
    Rests,
    /// Words that are replies to a service.
    Replies {
        /// How many.
        words: usize,
    },
    /// There are no registers before or after it.
    Alone,
    /// There are other registers around it; where it begins is a guess.
    Embedded,
    /// In the other word order there would be a word that no encoder sends, or one whose high half moves alone.
    OrderSure {
        /// That word.
        otherwise: u32,
    },
    /// The other word order fits as well.
    OrderOpen,
    /// The directory of an Inline coupler.
    Directory {
        /// Modules in all.
        modules: usize,
    },
    /// The same words stand elsewhere.
    SameAs(RegisterPlace),
    /// The OUT words are believed to be here, as there are as many holding registers; nothing was written.
    OutGuessed(u16),
    /// No holding registers for the OUT words were found.
    OutUnknown,
}

/// Why a probe came to no end.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{error}; that was request {}, for {count} {} from {place} on", .requests.saturating_add(1), registers(*.count))]
pub struct ProbeError {
    /// What happened.
    pub error: ModbusError,
    /// Where.
    pub place: RegisterPlace,
    /// How many registers were asked for.
    pub count: u16,
    /// How many requests there had been.
    pub requests: u32,
}

const fn registers(count: u16) -> &'static str {
    if count == 1 { "register" } else { "registers" }
}

/// Looks for encoders behind a gateway, from the way, unit and time-out that the client's address names; what else
/// it names is not looked at.
///
/// `progress` is called before each request and can end the search, which then reports what it has.
///
/// # Errors
/// [`ProbeError`] if the gateway cannot be reached, or twice in a row does not answer in time or answers what is no
/// answer. Registers that do not exist are no error, and neither is a function that the gateway does not know.
pub fn probe(
    client: &mut Client,
    limits: Reach,
    progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Findings, ProbeError> {
    let address = client.address().clone();
    search(client, &address, limits, progress)
}

/// What a probe needs of a gateway.
trait Source {
    fn registers(&mut self, place: RegisterPlace, count: u16) -> Result<Vec<u16>, ModbusError>;
    fn pause(&mut self, span: Duration);
}

impl Source for Client {
    fn registers(&mut self, place: RegisterPlace, count: u16) -> Result<Vec<u16>, ModbusError> {
        Self::registers(self, place, count)
    }

    fn pause(&mut self, span: Duration) {
        self.wait(span);
    }
}

/// Why a search goes no further.
enum Halt {
    End(End),
    Error(ProbeError),
}

struct Search<'a, S, P> {
    source: &'a mut S,
    progress: P,
    limits: Reach,
    requests: u32,
    stage: Stage,
    /// Registers of one request, as far as the gateway gives them; even.
    chunk: u16,
}

fn search(
    source: &mut impl Source,
    address: &Address,
    limits: Reach,
    progress: impl FnMut(Progress) -> ControlFlow<()>,
) -> Result<Findings, ProbeError> {
    let chunk = (address.max_registers / 2 * 2).min(CHUNK);
    let mut search = Search { source, progress, limits, requests: 0, stage: Stage::Looking, chunk };
    let mut blocks = Vec::new();
    let mut couplers = Vec::new();
    let end = match search.run(&mut blocks, &mut couplers) {
        Ok(()) => End::Whole,
        Err(Halt::End(end)) => end,
        Err(Halt::Error(error)) => return Err(error),
    };
    let candidates = judge(address, &blocks, &couplers);
    let blocks = blocks.iter().map(|block| (block.place, block.count)).collect();
    Ok(Findings { candidates, blocks, requests: search.requests, end })
}

impl<S: Source, P: FnMut(Progress) -> ControlFlow<()>> Search<'_, S, P> {
    fn run(&mut self, blocks: &mut Vec<Readout>, couplers: &mut Vec<(Table, Directory)>) -> Result<(), Halt> {
        for table in [Table::Input, Table::Holding] {
            self.look(table, blocks)?;
            if let Some(directory) = self.directory(table)? {
                couplers.push((table, directory));
            }
        }
        for pass in 2..=self.limits.passes {
            self.source.pause(self.limits.pause);
            self.stage = Stage::Watching { pass, of: self.limits.passes };
            // What is nothing but zeros is not watched.
            for block in blocks.iter_mut().filter(|block| block.holds_something()) {
                let mut values = Vec::with_capacity(block.count.into());
                for (place, count) in pieces(block.place, block.count, self.chunk) {
                    // A register that was there and is not any more ends the block's reading, not the search.
                    values.extend(self.read(place, count)?.unwrap_or_default());
                }
                block.add(values);
            }
        }
        Ok(())
    }

    /// Finds the blocks of a table.
    fn look(&mut self, table: Table, blocks: &mut Vec<Readout>) -> Result<(), Halt> {
        let mut starts: Vec<u16> = (0..=self.limits.last).step_by(STEP).collect();
        starts.extend(ODD_STARTS);
        starts.sort_unstable();
        starts.dedup();
        // The first register that is not known yet.
        let mut unknown = 0;
        for start in starts {
            if usize::from(start) < unknown {
                continue;
            }
            let place = RegisterPlace { table, first: start };
            if self.read(place, 1)?.is_none() {
                if start == 0 && !self.knows(table)? {
                    return Ok(());
                }
                unknown = usize::from(start) + 1;
                continue;
            }
            // A block that begins between two places that were looked at is followed back to its first register.
            let back = unknown.max((usize::from(start) + 1).saturating_sub(self.chunk.into()));
            let first = self.begin(place, back)?;
            let (values, sharp_end) = self.extend(RegisterPlace { table, first })?;
            let known_before =
                std::mem::replace(&mut unknown, usize::from(first) + values.len() + usize::from(sharp_end));
            // Behind a block that was cut at its greatest length, or followed back only so far, it may go on.
            let touches = blocks.last().is_some_and(|block| {
                block.place.table == table && block.end() == usize::from(first) && !block.sharp.1
            });
            let sharp_start = !touches && (usize::from(first) > back || back <= known_before);
            blocks.push(Readout::new(RegisterPlace { table, first }, (sharp_start, sharp_end), values));
        }
        Ok(())
    }

    /// Whether the gateway knows the function at all: exception 01 for register 0 says it does not.
    fn knows(&mut self, table: Table) -> Result<bool, Halt> {
        let place = RegisterPlace { table, first: 0 };
        match self.ask(place, 1)? {
            Err(ModbusError::Refused { exception: 1, .. }) => Ok(false),
            _ => Ok(true),
        }
    }

    /// The first register of the block that holds this one: nothing before `back` is in it.
    fn begin(&mut self, place: RegisterPlace, back: usize) -> Result<u16, Halt> {
        let (mut there, mut not) = (usize::from(place.first), back);
        // `there` is in the block; what is before `not` is not.
        while not < there {
            let middle = not + (there - not) / 2;
            let Ok(first) = u16::try_from(middle) else { break };
            let reaches = self.read(RegisterPlace { first, ..place }, self.span(middle, there))?.is_some();
            if reaches { there = middle } else { not = middle + 1 }
        }
        Ok(u16::try_from(there).unwrap_or(place.first))
    }

    fn span(&self, from: usize, to: usize) -> u16 {
        u16::try_from(to - from + 1).unwrap_or(CHUNK).min(self.chunk)
    }

    /// Reads a block from its first register on; `true` if its last was found, and not only the longest.
    fn extend(&mut self, place: RegisterPlace) -> Result<(Vec<u16>, bool), Halt> {
        let mut values: Vec<u16> = Vec::new();
        let room = u32::from(u16::MAX - place.first) + 1;
        let longest = u16::try_from(room.min(BLOCK_MAX.into())).unwrap_or(BLOCK_MAX);
        while let Some(left) = longest.checked_sub(values.len() as u16).filter(|left| *left > 0) {
            let from = RegisterPlace { first: place.first + values.len() as u16, ..place };
            let wanted = left.min(self.chunk);
            if let Some(read) = self.read(from, wanted)? {
                values.extend(read);
                continue;
            }
            // As many as there are: `yes` can be read, `no` cannot.
            let (mut yes, mut no) = (0, wanted);
            let mut found = Vec::new();
            while no - yes > 1 {
                let middle = yes + (no - yes) / 2;
                match self.read(from, middle)? {
                    Some(read) => (yes, found) = (middle, read),
                    None => no = middle,
                }
            }
            values.extend(found);
            // A register that is there by itself was not missing: the gateway gives no more than that at a time.
            let next = from.first.checked_add(yes).map(|first| RegisterPlace { first, ..from });
            match next {
                Some(next) if yes > 0 && self.read(next, 1)?.is_some() => self.chunk = (yes / 2 * 2).max(2),
                _ => return Ok((values, true)),
            }
        }
        Ok((values, u32::from(longest) == room))
    }

    /// What an Inline coupler says of its modules, if it is one.
    fn directory(&mut self, table: Table) -> Result<Option<Directory>, Halt> {
        let Some(count) = self.read(RegisterPlace { table, first: MODULES }, 1)? else { return Ok(None) };
        let count = count.first().copied().unwrap_or_default();
        if !(1..=MODULES_MAX).contains(&count) {
            return Ok(None);
        }
        let mut described = Vec::new();
        for (place, count) in pieces(RegisterPlace { table, first: MODULES + 1 }, count, self.chunk) {
            let Some(read) = self.read(place, count)? else { return Ok(None) };
            described.extend(read);
        }
        let directory = Directory::parse(&described, function(table)).ok();
        Ok(directory.filter(|directory| directory.encoders().next().is_some()))
    }

    /// Reads registers; `None` if they are not all there.
    fn read(&mut self, place: RegisterPlace, count: u16) -> Result<Option<Vec<u16>>, Halt> {
        match self.ask(place, count)? {
            Ok(values) => Ok(Some(values)),
            // Some say 03 or 04 instead of 02; 01 is for the whole table.
            Err(ModbusError::Refused { exception: 1..=4, .. }) => Ok(None),
            Err(error) => Err(Halt::Error(ProbeError { error, place, count, requests: self.requests })),
        }
    }

    fn ask(&mut self, place: RegisterPlace, count: u16) -> Result<Result<Vec<u16>, ModbusError>, Halt> {
        if self.requests >= self.limits.requests {
            return Err(Halt::End(End::Limit));
        }
        let progress = Progress { requests: self.requests, stage: self.stage, place };
        if (self.progress)(progress).is_break() {
            return Err(Halt::End(End::Stopped));
        }
        self.requests += 1;
        let answer = self.source.registers(place, count);
        if matches!(answer, Err(ModbusError::Bus(BusError::NoAnswer { .. }) | ModbusError::Garbled { .. })) {
            // Lines lose an answer now and then; one that is lost twice is not there.
            self.requests += 1;
            return Ok(self.source.registers(place, count));
        }
        Ok(answer)
    }
}

/// The requests that read a block.
fn pieces(place: RegisterPlace, count: u16, chunk: u16) -> impl Iterator<Item = (RegisterPlace, u16)> {
    (0..count).step_by(usize::from(chunk.max(1))).filter_map(move |offset| {
        let first = place.first.checked_add(offset)?;
        Some((RegisterPlace { first, ..place }, (count - offset).min(chunk)))
    })
}

fn judge(address: &Address, blocks: &[Readout], couplers: &[(Table, Directory)]) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = Vec::new();
    for (table, directory) in couplers {
        candidates.extend(inline(address, *table, directory, blocks));
    }
    let is_coupler = |block: &&Readout| {
        !couplers.iter().any(|(table, _)| {
            let of_coupler = [MODULES, DATA.first];
            *table == block.place.table && of_coupler.iter().any(|register| block.holds(*register))
        })
    };
    let mut plain = Vec::new();
    for block in blocks.iter().filter(is_coupler).filter(|block| !block.is_diagnosis()) {
        plain.extend(reading::hypotheses(block).into_iter().map(|hypothesis| (block, hypothesis)));
    }
    for (block, hypothesis) in &plain {
        let place = RegisterPlace { first: block.place.first + hypothesis.offset as u16, ..block.place };
        let mut evidence = evidence(hypothesis);
        let twin = plain.iter().find(|(other, same)| {
            other.place != block.place
                && other.place.table == Table::Input
                && block.place.table == Table::Holding
                && same.order == hypothesis.order
                && other.looks_like(same, block, hypothesis)
        });
        if let Some((other, same)) = twin {
            evidence.push(Evidence::SameAs(RegisterPlace {
                first: other.place.first + same.offset as u16,
                ..other.place
            }));
        }
        let out = out_words(blocks, place, hypothesis.words);
        evidence.push(out.map_or(Evidence::OutUnknown, Evidence::OutGuessed));
        let layout = Layout::Plain { out: out.unwrap_or_default(), input: place };
        candidates.push(Candidate {
            certainty: hypothesis.certainty,
            address: found(address, layout, hypothesis.order),
            encoders: hypothesis.words,
            evidence,
        });
    }
    // Stable: what a block's own ranking says stays, and input registers come before holding registers.
    candidates.sort_by_key(|candidate| std::cmp::Reverse(candidate.certainty));
    candidates
}

/// The address that reads words there and in this order. The order of OUT cannot be read, so it is taken to be the same.
fn found(address: &Address, layout: Layout, order: WordOrder) -> Address {
    Address { layout, order_in: order, order_out: order, ..address.clone() }
}

fn evidence(hypothesis: &Hypothesis) -> Vec<Evidence> {
    let mut evidence = Vec::new();
    match hypothesis.moving {
        0 => evidence.push(Evidence::Rests),
        words => evidence.push(Evidence::Moves { words }),
    }
    if hypothesis.replies > 0 {
        evidence.push(Evidence::Replies { words: hypothesis.replies });
    }
    evidence.push(if hypothesis.alone { Evidence::Alone } else { Evidence::Embedded });
    evidence.push(match hypothesis.otherwise {
        Some(otherwise) => Evidence::OrderSure { otherwise },
        None => Evidence::OrderOpen,
    });
    evidence
}

/// Holding registers that may be the OUT words of these IN words: from the same address on in the other table, or
/// from 0 on, and as many; or else the only block of just that length.
fn out_words(blocks: &[Readout], input: RegisterPlace, words: usize) -> Option<u16> {
    let length = words * REGISTERS_PER_ENCODER;
    let fits = |first: u16| {
        let apart = input.table == Table::Input
            || usize::from(first) + length <= usize::from(input.first)
            || usize::from(input.first) + length <= usize::from(first);
        apart
            && blocks.iter().any(|block| {
                block.place.table == Table::Holding
                    && block.place.first <= first
                    && usize::from(first) + length <= block.end()
            })
    };
    let mut blocks_alike = blocks.iter().filter(|block| {
        block.place.table == Table::Holding && block.place != input && usize::from(block.count) == length
    });
    let only = match (blocks_alike.next(), blocks_alike.next()) {
        (Some(block), None) => Some(block.place.first),
        _ => None,
    };
    [input.first, 0].into_iter().find(|first| fits(*first)).or(only)
}

/// An Inline coupler: the directory says where, only the order is open.
fn inline(address: &Address, table: Table, directory: &Directory, blocks: &[Readout]) -> Vec<Candidate> {
    let data = RegisterPlace { table, ..DATA };
    let block = blocks.iter().find(|block| block.place.table == table && block.holds(data.first));
    let base = block.map(|block| usize::from(data.first - block.place.first)).unwrap_or_default();
    let offsets: Vec<usize> = directory
        .encoders()
        .filter_map(|position| directory.offsets(position).ok())
        .map(|offsets| base + offsets.input)
        .collect();
    let weighed = |order| block.and_then(|block| reading::weigh(block, &offsets, order));
    let (high, low) = (weighed(WordOrder::HighFirst), weighed(WordOrder::LowFirst));
    let mut candidates = Vec::new();
    for (order, this, other) in [(WordOrder::HighFirst, &high, &low), (WordOrder::LowFirst, &low, &high)] {
        let Some(weight) = this else { continue };
        if weight.against.is_some() {
            continue;
        }
        let otherwise = other.as_ref().and_then(|other| other.against);
        let certainty = match (otherwise, weight.moving) {
            (Some(_), 1..) => Certainty::Certain,
            (Some(_), 0) => Certainty::Likely,
            (None, _) => Certainty::Possible,
        };
        let mut evidence = vec![Evidence::Directory { modules: directory.modules() }];
        match weight.moving {
            0 => evidence.push(Evidence::Rests),
            words => evidence.push(Evidence::Moves { words }),
        }
        if weight.replies > 0 {
            evidence.push(Evidence::Replies { words: weight.replies });
        }
        evidence.push(match otherwise {
            Some(otherwise) => Evidence::OrderSure { otherwise },
            None => Evidence::OrderOpen,
        });
        let address = found(address, Layout::Inline { data }, order);
        candidates.push(Candidate { certainty, address, encoders: offsets.len(), evidence });
    }
    candidates
}

impl Findings {
    /// The one candidate that is more than possible and as sure as no other. Where the same words stand again does not
    /// count as another.
    #[must_use]
    pub fn stands_out(&self) -> Option<&Candidate> {
        let (best, others) = self.candidates.split_first()?;
        let rival = |other: &Candidate| {
            let mirror = other.evidence.iter().any(|evidence| matches!(evidence, Evidence::SameAs(_)));
            other.certainty == best.certainty && !mirror
        };
        (best.certainty > Certainty::Possible && !others.iter().any(rival)).then_some(best)
    }

    /// What there is to say about it in one sentence.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        match self.candidates.first().map(|candidate| candidate.certainty) {
            None if self.blocks.is_empty() => "no registers were found",
            None => "there are registers, but nothing in them can be told for words of encoders",
            Some(Certainty::Possible) => {
                "nothing moved as a position does; turn a shaft and probe again to tell these apart"
            }
            Some(_) if self.stands_out().is_some() => "one place stands out",
            Some(_) => "several places fit equally well",
        }
    }
}

impl Display for Certainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Possible => "possible",
            Self::Likely => "likely",
            Self::Certain => "certain",
        })
    }
}

impl Display for Evidence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Moves { words } => write!(f, "{words} moving as positions do, upper byte 00h or 20h"),
            Self::Rests => f.write_str("nothing moves"),
            Self::Replies { words } => write!(f, "{words} replying to a service"),
            Self::Alone => f.write_str("no other registers around them"),
            Self::Embedded => f.write_str("other registers around them: where they begin is a guess"),
            Self::OrderSure { otherwise } => {
                write!(f, "in the other word order {otherwise:08X}h, which no encoder sends so")
            }
            Self::OrderOpen => f.write_str("the other word order fits as well"),
            Self::Directory { modules } => write!(f, "a directory of {modules} modules at {MODULES}"),
            Self::SameAs(place) => write!(f, "the same words as at {place}"),
            Self::OutGuessed(first) => {
                write!(
                    f,
                    "OUT words believed to be at holding:{first}, nothing was written; their word order cannot be read, it is \
                     taken to be the same (order_out)"
                )
            }
            Self::OutUnknown => f.write_str("no registers for OUT words were found"),
        }
    }
}

#[cfg(test)]
mod tests;
