//! What a whole capture says, for people.

use std::collections::BTreeMap;
use std::fmt;

use encoring_host::ssi_receiver::{FieldBits, SsiFault, SsiTransfer, TakenAt};
use encoring_host::ssi_timings::{Spread, SsiTimings};
use encoring_words::Duration;
use encoring_words::ssi_frame::{CLOCK_HZ, SsiFormat};

use super::super::format::FormatText;
use crate::output::Answer;

/// Transfers that are shown; the other formats have all.
const SHOWN: usize = 10;

/// Different clock counts that are told apart.
const COUNTS: usize = 8;

/// A clock period should last so many samples.
const SAMPLES_PER_PERIOD: u64 = 8;

/// What is known of all transfers.
pub(super) struct Summary {
    format: SsiFormat,
    taken_at: TakenAt,
    pub(super) timings: SsiTimings,
    transfers: u64,
    first: Vec<Shown>,
    faulty: Vec<Shown>,
    faults: BTreeMap<SsiFault, u64>,
    clocks: BTreeMap<u32, u64>,
    other_clocks: u64,
    positions: Option<Positions>,
    end_ns: i128,
    resolution_ns: Option<u64>,
}

struct Shown {
    time_ns: i128,
    clocks: u32,
    field: FieldBits,
    position: Option<u32>,
    fault: Option<SsiFault>,
}

struct Positions {
    first: u32,
    last: u32,
    least: u32,
    most: u32,
    changes: u64,
}

impl Summary {
    pub(super) fn new(format: SsiFormat, taken_at: TakenAt) -> Self {
        Self {
            format,
            taken_at,
            timings: SsiTimings::default(),
            transfers: 0,
            first: Vec::new(),
            faulty: Vec::new(),
            faults: BTreeMap::new(),
            clocks: BTreeMap::new(),
            other_clocks: 0,
            positions: None,
            end_ns: 0,
            resolution_ns: None,
        }
    }

    pub(super) fn transfer(&mut self, time_ns: i128, transfer: &SsiTransfer) {
        self.transfers += 1;
        let SsiTransfer { clocks, fault, .. } = *transfer;
        let list = if fault.is_some() { &mut self.faulty } else { &mut self.first };
        if list.len() < SHOWN {
            list.push(Shown {
                time_ns,
                clocks,
                field: transfer.bits(),
                position: transfer.position(),
                fault,
            });
        }
        if let Some(fault) = fault {
            *self.faults.entry(fault).or_default() += 1;
        }
        if self.clocks.len() < COUNTS || self.clocks.contains_key(&clocks) {
            *self.clocks.entry(clocks).or_default() += 1;
        } else {
            self.other_clocks += 1;
        }
        let Some(position) = transfer.position() else { return };
        let Some(known) = &mut self.positions else {
            let (first, last, least, most) = (position, position, position, position);
            self.positions = Some(Positions { first, last, least, most, changes: 0 });
            return;
        };
        known.changes += u64::from(known.last != position);
        (known.last, known.least, known.most) =
            (position, known.least.min(position), known.most.max(position));
    }

    pub(super) fn end(&mut self, end_ns: i128, resolution_ns: Option<u64>) {
        (self.end_ns, self.resolution_ns) = (end_ns, resolution_ns);
    }

    /// A transfer that the capture cut off says nothing of the line.
    fn cut(&self) -> u64 {
        self.faults.get(&SsiFault::Cut).copied().unwrap_or(0)
    }

    fn wrong(&self) -> u64 {
        self.faults.values().sum::<u64>() - self.cut()
    }

    pub(super) fn answer(&self) -> Answer {
        match (self.wrong(), self.transfers - self.cut()) {
            (_, 0) => Answer::Unknown,
            (0, _) => Answer::Yes,
            _ => Answer::No,
        }
    }

    fn write_lists(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = usize::from(self.format.bits()).max(5);
        for (list, all, what) in [
            (&self.first, self.transfers - self.wrong() - self.cut(), "good"),
            (&self.faulty, self.wrong() + self.cut(), "with a fault"),
        ] {
            if list.is_empty() {
                continue;
            }
            let first =
                if all > list.len() as u64 { format!(", the first {}", list.len()) } else { String::new() };
            writeln!(f, "\n{all} {what}{first}:\n{:>16}  clocks  {:<width$}  position", "time", "field")?;
            for Shown { time_ns, clocks, field, position, fault } in list {
                let position = position.map(|position| position.to_string()).unwrap_or_default();
                let fault = fault.map_or("", SsiFault::name);
                let line = format!(
                    "{:>16}  {clocks:>6}  {field:<width$}  {position:>8}  {fault}",
                    seconds(*time_ns)
                );
                writeln!(f, "{}", line.trim_end())?;
            }
        }
        Ok(())
    }

    fn write_timing(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let SsiTimings { period, pause, mono, .. } = &self.timings;
        writeln!(f)?;
        if let (Some(hz), Some(Spread { shortest, longest, .. })) = (self.timings.clock_hz(), period) {
            writeln!(f, "clock       {}, period {shortest} to {longest}", rate(hz))?;
            if !(u64::from(CLOCK_HZ.0)..=u64::from(CLOCK_HZ.1)).contains(&hz) {
                writeln!(f, "            outside the guarantee of 80 kHz to 1 MHz")?;
            }
            if let Some(step) =
                self.resolution_ns.filter(|step| step * SAMPLES_PER_PERIOD > shortest.as_nanos())
            {
                writeln!(
                    f,
                    "            the file tells times in steps of {}, coarse for such a clock: capture with a higher rate",
                    Duration(step)
                )?;
            }
        }
        if let Some(Spread { shortest, longest, .. }) = pause {
            writeln!(
                f,
                "pause       {shortest} to {longest} from the last falling edge to the first of the next transfer"
            )?;
        }
        if let Some(Spread { shortest, longest, count }) = mono {
            writeln!(
                f,
                "t_M         {shortest} to {longest} until data are High again, seen {count} times; 20 us are stated"
            )?;
        }
        Ok(())
    }
}

/// Seconds with all nanoseconds.
fn seconds(time_ns: i128) -> String {
    let (sign, ns) = if time_ns < 0 { ("-", time_ns.unsigned_abs()) } else { ("", time_ns.unsigned_abs()) };
    format!("{sign}{}.{:09} s", ns / 1_000_000_000, ns % 1_000_000_000)
}

/// A rate in kHz or MHz with three decimals.
fn rate(hz: u64) -> String {
    match hz {
        1_000_000.. => format!("{}.{:03} MHz", hz / 1_000_000, hz / 1_000 % 1_000),
        1_000.. => format!("{}.{:03} kHz", hz / 1_000, hz % 1_000),
        _ => format!("{hz} Hz"),
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let edge = match self.taken_at {
            TakenAt::Rising => "rising",
            TakenAt::Falling => "falling",
        };
        let count = self.transfers;
        write!(
            f,
            "{count} transfers in {}, {} good, {} with a fault",
            seconds(self.end_ns),
            count - self.wrong() - self.cut(),
            self.wrong()
        )?;
        if self.cut() > 0 {
            write!(f, ", {} cut off by the capture", self.cut())?;
        }
        writeln!(f, "\nread as {}, taken at the {edge} edge", FormatText(self.format))?;
        self.write_lists(f)?;
        self.write_timing(f)?;
        if !self.clocks.is_empty() {
            let counts: Vec<_> =
                self.clocks.iter().map(|(clocks, times)| format!("{clocks} ({times})")).collect();
            let others = if self.other_clocks > 0 {
                format!(", others ({})", self.other_clocks)
            } else {
                String::new()
            };
            writeln!(f, "clocks      {}{others}", counts.join(", "))?;
        }
        if let Some(Positions { first, last, least, most, changes }) = &self.positions {
            writeln!(f, "positions   {first} first, {last} last, from {least} to {most}, {changes} changes")?;
        }
        if !self.faults.is_empty() {
            let faults: Vec<_> =
                self.faults.iter().map(|(fault, times)| format!("{fault} ({times})")).collect();
            writeln!(f, "faults      {}", faults.join(", "))?;
        }
        Ok(())
    }
}
