//! The kinds of input, each as samples of a detector.

use std::io::BufRead;
use std::str::FromStr;

use encoring_diagnosis::{Detector, Options, Picture, Sample};
use encoring_trace::bus::{BusReader, MARK};
use encoring_trace::{Columns, DeviceLine, Reader, RowKind, TableLayout};
use encoring_words::Model;

use super::{Arguments, Diagnosed};
use crate::arguments::tell_doubts;
use crate::interrupt::Interrupt;
use crate::output::reading;
use crate::output::{Failure, bad_input};

/// How what `ssi decode --format csv` prints begins.
const SSI_HEADER: &str = "time_ns,clocks,field,position,fault";

/// Reads a file up to its end or a signal.
pub(super) fn read(file: &str, arguments: &Arguments, interrupt: &Interrupt) -> Result<Diagnosed, Failure> {
    let name = reading::name(file);
    let mut source = reading::open(file, interrupt.stop())?;
    let begins = source.fill_buf().map_err(|error| bad_input(format!("cannot read {name}: {error}")))?;
    let is_bus = begins.starts_with(MARK.as_bytes());
    let mut intake = Intake { detector: None, picture: arguments.drawn.picture(), rows: 0 };
    let is_ssi = begins.starts_with(SSI_HEADER.as_bytes());
    if is_bus {
        bus(name, arguments, source, interrupt, &mut intake)?;
    } else {
        table(name, arguments, source, is_ssi, interrupt, &mut intake)?;
    }
    let Intake { detector, picture, rows } = intake;
    let conclusion = detector.map(Detector::finish).unwrap_or_default();
    Ok(Diagnosed { name: name.to_owned(), rows, conclusion, picture })
}

/// What has been taken in.
struct Intake {
    /// Made with the first row.
    detector: Option<Detector>,
    picture: Option<Picture>,
    rows: u64,
}

impl Intake {
    fn take(
        &mut self,
        sample: Option<Sample>,
        options: impl FnOnce() -> Result<Options, Failure>,
    ) -> Result<(), Failure> {
        let Some(sample) = sample else { return Ok(()) };
        let detector = match &mut self.detector {
            Some(detector) => detector,
            none => none.insert(Detector::new(options()?)),
        };
        self.rows += 1;
        detector.sample(sample);
        if let Some(picture) = &mut self.picture {
            picture.sample(&sample);
            picture.look(sample.position, detector.told(sample.position));
        }
        Ok(())
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
    let reader = BusReader::new(name, source).map_err(bad_input)?;
    let model = model(name, reader.devices())?;
    for row in reader {
        intake.take(Sample::of_bus(&row.map_err(bad_input)?), || arguments.about.options(0, model))?;
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
    is_ssi: bool,
    interrupt: &Interrupt,
    intake: &mut Intake,
) -> Result<(), Failure> {
    let mut reader = if is_ssi && arguments.table.says_nothing() {
        ssi(name, source)?
    } else {
        arguments.table.reader(name, source)?
    };
    let model = model(name, reader.recording().map_or(&[][..], |recording| &recording.devices))?;
    while let Some(row) = reader.next() {
        let row = row.map_err(bad_input)?;
        if row.kind == RowKind::SsiEdge {
            continue;
        }
        intake.take(Sample::of_row(&row), || arguments.about.options(reader.origin_ns(), model))?;
        if interrupt.is_interrupted() {
            break;
        }
    }
    tell_doubts(&reader, name);
    Ok(())
}

/// What `ssi decode --format csv` prints: its column `position` is one in steps, and none where a fault stands beside it.
fn ssi<R: BufRead>(name: &str, source: R) -> Result<Reader<R>, Failure> {
    let columns = Columns::from_str("time_ns=time_ns,value=position").map_err(bad_input)?;
    let faults = Some("fault".to_owned());
    let layout = TableLayout { columns: Some(columns), faults, ..TableLayout::default() };
    Reader::with(name, source, &layout).map_err(bad_input)
}

/// The model that a recording names, if all its encoders are of one.
fn model(name: &str, devices: &[DeviceLine]) -> Result<Option<Model>, Failure> {
    let mut models = Vec::new();
    for device in devices {
        let wrong = |error| bad_input(format!("{name} line {}: {}: {error}", device.line, device.model));
        let model = Model::from_str(&device.model).map_err(wrong)?;
        if !models.contains(&model) {
            models.push(model);
        }
    }
    Ok(models.pop().filter(|_| models.is_empty()))
}
