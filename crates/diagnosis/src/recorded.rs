//! A recording of any kind, as samples: what the command and the page read alike.

use std::io::BufRead;
use std::str::FromStr;

use encoring_trace::bus::{BusEvent, BusReader, BusRow, MARK};
use encoring_trace::{Columns, CycleSeen, DeviceLine, LoggedEncoder, Reader, RowKind, TableLayout};

use crate::detector::Detector;
use crate::episode::Conclusion;
use crate::picture::Picture;
use crate::sample::{Sample, Sighting};
use crate::statements;
use crate::unread::Unreadable;

/// How what `ssi decode --format csv` prints begins.
const SSI_HEADER: &str = "time_ns,clocks,field,position,fault";

/// A recording that is being read.
#[derive(Debug)]
pub struct RecordedSamples<R> {
    name: String,
    rows: Kind<R>,
    /// What is wrong with the last line, if the file ends within it.
    half_line: Option<String>,
}

#[derive(Debug)]
enum Kind<R> {
    Bus(BusReader<R>, Box<Running>),
    Table(Reader<R>),
}

/// The encoders of which a cycle was seen since the ring began to run.
///
/// What comes in the first cycle is what the encoder held before: nothing, or the word of before the stop.
#[derive(Debug)]
struct Running([bool; 256]);

impl Running {
    /// What the next row shows.
    fn look(&mut self, row: &BusRow) -> Option<Sample> {
        let mut sample = Sample::of_bus(row)?;
        if let (BusEvent::Cycle { line, .. }, Some(runs)) =
            (row.event, self.0.get_mut(usize::from(row.position)))
        {
            let has_run = std::mem::replace(runs, line != Some(CycleSeen::Silent));
            if !has_run {
                sample.reading = Sighting::Nothing;
            }
        }
        Some(sample)
    }
}

/// The columns of what `ssi decode --format csv` prints: its column `position` is one in steps, and none where a fault
/// stands beside it.
fn ssi() -> Result<TableLayout, Unreadable> {
    let columns =
        Columns::from_str("time_ns=time_ns,value=position").map_err(|error| Unreadable::new(&error))?;
    Ok(TableLayout { columns: Some(columns), faults: Some("fault".to_owned()), ..TableLayout::default() })
}

impl<R: BufRead> RecordedSamples<R> {
    /// Reads it up to its first row. `layout` is what somebody says of a table; else its header says it.
    ///
    /// # Errors
    /// [`Unreadable`]
    pub fn open(name: &str, mut source: R, layout: Option<&TableLayout>) -> Result<Self, Unreadable> {
        let begins = source.fill_buf().map_err(|error| Unreadable::not_read(name, &error))?;
        let (is_bus, is_ssi) =
            (begins.starts_with(MARK.as_bytes()), begins.starts_with(SSI_HEADER.as_bytes()));
        let rows = match layout {
            _ if is_bus => {
                let reader = BusReader::new(name, source).map_err(Unreadable::from)?;
                Kind::Bus(reader, Box::new(Running([false; 256])))
            }
            None if is_ssi => Kind::Table(Reader::with(name, source, &ssi()?).map_err(Unreadable::from)?),
            None => Kind::Table(Reader::new(name, source).map_err(Unreadable::from)?),
            Some(layout) => Kind::Table(Reader::with(name, source, layout).map_err(Unreadable::from)?),
        };
        Ok(Self { name: name.to_owned(), rows, half_line: None })
    }

    /// The table, for what its reader says of it; `None` for a recording of a bus, which says itself what it is.
    #[must_use]
    pub const fn table(&self) -> Option<&Reader<R>> {
        match &self.rows {
            Kind::Bus(..) => None,
            Kind::Table(reader) => Some(reader),
        }
    }

    /// When the times of its rows begin, in nanoseconds since 1970; 0 where they have no date.
    #[must_use]
    pub fn origin_ns(&self) -> i128 {
        self.table().map_or(0, Reader::origin_ns)
    }

    /// The encoders that it starts from, with their memories.
    #[must_use]
    pub fn devices(&self) -> &[DeviceLine] {
        match &self.rows {
            Kind::Bus(reader, _) => reader.devices(),
            Kind::Table(reader) => reader.recording().map_or(&[][..], |recording| &recording.devices),
        }
    }

    /// The encoders that the head of a log names.
    #[must_use]
    pub fn logged(&self) -> &[LoggedEncoder] {
        self.table().map_or(&[], Reader::logged)
    }
}

/// The rows as samples; `None` for a row that holds no position. A half line at the end is the end.
impl<R: BufRead> Iterator for RecordedSamples<R> {
    type Item = Result<Option<Sample>, Unreadable>;

    fn next(&mut self) -> Option<Self::Item> {
        let sample = match &mut self.rows {
            Kind::Bus(reader, running) => reader.next()?.map(|row| running.look(&row)),
            Kind::Table(reader) => {
                let of_position = |row: &encoring_trace::Row| row.kind != RowKind::SsiEdge;
                reader.next()?.map(|row| of_position(&row).then(|| Sample::of_row(&row)).flatten())
            }
        };
        match sample {
            Err(error) if error.is_half => {
                self.half_line = Some(error.to_string());
                None
            }
            sample => Some(sample.map_err(Unreadable::from)),
        }
    }
}

/// What a recording says.
#[derive(Debug, Default)]
pub struct Diagnosed {
    /// The file.
    pub name: String,
    /// Rows with a position.
    pub rows: u64,
    /// What was found.
    pub conclusion: Conclusion,
    /// Its picture, if somebody wants to see it.
    pub picture: Option<Picture>,
}

impl Diagnosed {
    /// Reads a recording up to its end, or for as long as `goes_on`. `detector` is asked when the first position has come, as
    /// the beginning of the times is known then.
    ///
    /// # Errors
    /// That of `detector`, or [`Unreadable`] made into one.
    pub fn read<R: BufRead, E: From<Unreadable>>(
        recorded: &mut RecordedSamples<R>,
        mut picture: Option<Picture>,
        detector: impl Fn(&RecordedSamples<R>) -> Result<Detector, E>,
        goes_on: impl Fn() -> bool,
    ) -> Result<Self, E> {
        let (mut made, mut rows) = (None, 0);
        while let Some(sample) = recorded.next() {
            if let Some(sample) = sample? {
                let detector = match &mut made {
                    Some(made) => made,
                    none => none.insert(detector(recorded)?),
                };
                rows += 1;
                detector.sample(sample);
                if let Some(picture) = &mut picture {
                    picture.sample(&sample);
                    picture.look(sample.position, detector.told(sample.position));
                }
            }
            if !goes_on() {
                break;
            }
        }
        let mut conclusion = made.map(Detector::finish).unwrap_or_default();
        let half_line = recorded.half_line.take().map(|line| statements::half_line(&line));
        conclusion.limits.splice(0..0, half_line);
        Ok(Self { name: recorded.name.clone(), rows, conclusion, picture })
    }

    /// Whether any jump could be judged.
    #[must_use]
    pub const fn is_judged(&self) -> bool {
        self.conclusion.is_judged
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_word_behind_a_start_or_a_stop_of_the_ring_is_no_position() {
        let file = "# encoring-bus 1\n\
                    time_us,position,event,out,in,line,client,half,value\n\
                    1,0,cycle,00000000,00000000,good,,,\n\
                    2,0,cycle,00000000,00000005,good,,,\n\
                    3,0,cycle,00000000,00000005,silent,,,\n\
                    4,0,cycle,00000000,00000005,good,,,\n\
                    5,0,cycle,00000000,00000009,bad,,,\n\
                    6,0,cycle,00000000,00000007,good,,,\n";
        let rows = RecordedSamples::open("bus.csv", file.as_bytes(), None).unwrap();
        let seen: Vec<_> = rows.map(|sample| sample.unwrap().unwrap().reading).collect();
        let (nothing, word) = (Sighting::Nothing, Sighting::Word);
        assert_eq!(seen, [nothing, word(5), nothing, nothing, nothing, word(7)]);
    }
}
