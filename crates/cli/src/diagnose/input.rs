//! The kinds of input, each as samples of a detector.

use std::fs::File;
use std::io::{self, BufRead, BufReader};

use encoring_diagnosis::{Detector, Picture, Sample};
use encoring_trace::RowKind;
use encoring_trace::bus::{BusReader, MARK};

use super::{Arguments, Diagnosed};
use crate::arguments::tell_doubts;
use crate::interrupt::Interrupt;
use crate::output::reading::{self, Beside};
use crate::output::{Failure, bad_input};

/// Reads a file up to its end or a signal.
pub(super) fn read(file: &str, arguments: &Arguments, interrupt: &Interrupt) -> Result<Diagnosed, Failure> {
    let name = if file == "-" { "standard input" } else { file };
    let mut source: Box<dyn BufRead> = if file == "-" {
        Box::new(io::stdin().lock())
    } else {
        let file = File::open(name).map_err(|error| bad_input(format!("cannot open {name}: {error}")))?;
        let bar = reading::bar(&file, Beside::Nothing);
        Box::new(BufReader::new(bar.wrap_read(file)))
    };
    let begins = source.fill_buf().map_err(|error| bad_input(format!("cannot read {name}: {error}")))?;
    let is_bus = begins.starts_with(MARK.as_bytes());
    let mut intake =
        Intake { detector: Detector::new(arguments.options()), picture: arguments.drawn.picture(), rows: 0 };
    if is_bus {
        bus(name, arguments, source, interrupt, &mut intake)?;
    } else {
        table(name, arguments, source, interrupt, &mut intake)?;
    }
    let Intake { detector, picture, rows } = intake;
    Ok(Diagnosed { name: name.to_owned(), rows, conclusion: detector.finish(), picture })
}

/// What has been taken in.
struct Intake {
    detector: Detector,
    picture: Option<Picture>,
    rows: u64,
}

impl Intake {
    fn take(&mut self, sample: Option<Sample>) {
        if let Some(sample) = sample {
            self.rows += 1;
            self.detector.sample(sample);
            if let Some(picture) = &mut self.picture {
                picture.sample(&sample);
                picture.look(sample.position, self.detector.told(sample.position));
            }
        }
    }
}

fn bus(
    name: &str,
    arguments: &Arguments,
    source: impl BufRead,
    interrupt: &Interrupt,
    intake: &mut Intake,
) -> Result<(), Failure> {
    if !arguments.table.says_nothing() {
        return Err(bad_input(format!(
            "{name} says itself what its columns are; leave --columns, --decimal and --period out"
        )));
    }
    for row in BusReader::new(name, source).map_err(bad_input)? {
        intake.take(Sample::of_bus(&row.map_err(bad_input)?));
        if interrupt.is_interrupted() {
            break;
        }
    }
    Ok(())
}

fn table(
    name: &str,
    arguments: &Arguments,
    source: impl BufRead,
    interrupt: &Interrupt,
    intake: &mut Intake,
) -> Result<(), Failure> {
    let mut reader = arguments.table.reader(name, source)?;
    for row in &mut reader {
        let row = row.map_err(bad_input)?;
        if row.kind == RowKind::SsiEdge {
            continue;
        }
        intake.take(Sample::of_row(&row));
        if interrupt.is_interrupted() {
            break;
        }
    }
    tell_doubts(&reader, name);
    Ok(())
}
