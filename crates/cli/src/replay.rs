//! `encoring replay`: a trace played into an encoder, and its answers compared or printed.

use std::fs::File;
use std::io::{self, BufWriter, Read, Write};

use clap::{Args, ValueEnum};
use encoring_encoder::{ServiceTimes, StaleService, Unit};
use encoring_sim::replay::{Difference, compare, play};
use encoring_sim::{Node, device_line};
use encoring_trace::{DeviceLine, Reader, Row, Writer};
use encoring_words::model::{MODELS, Sensor, Series};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::arguments;

use crate::arguments::{Output, TableArguments, TypeLabel, tell_doubts};
use crate::output::reading::{self, Beside};
use crate::output::{self, Answer, Failure, Format, bad_input};

/// Play a trace into an encoder and compare every IN word
#[derive(Args, Debug)]
#[command(after_help = "\
A trace starts from a new encoder with factory values and with 4096 steps per turn,
unless --native is given. A recording begins with `# encoring-trace 1` and names its
encoders: --at chooses one, and its model, memory and settings come from the file. The
FILE.partial of a killed run replays up to its last complete row.

The command also reads tables of other programs: PLC traces, spreadsheets, exports. The
header names the columns, or --columns does (docs/tables.md). A note says what was
assumed.

The output has the first ten differences. Its last line is always like
`4000 rows, 0 differences`. With --print the trace goes to standard output, and the
differences and the last line go to standard error.

Exit codes:
  0  no difference
  1  a difference
  2  the trace or the options are wrong
  3  nothing was compared: no row has an IN word

Examples:
  encoring replay --model ce-65-m --native 8192 trace.csv
  encoring replay --model la-66 --rod-mm 500 --print commands.csv > answers.csv
  encoring replay --at 2 recording.csv
  encoring replay --model ce-65-m --columns \"time_ms=Zeit,out=QD 256,in=ID 256\" plc.csv")]
pub(crate) struct Arguments {
    /// The trace or recording, or `-` for standard input
    #[arg(value_name = "TRACE.csv")]
    trace: String,

    #[command(flatten)]
    label: TypeLabel,

    /// Rod length of an LA-66 on its type label, in mm with up to two decimals [default: 500]
    #[arg(long, value_name = "N", value_parser = arguments::millimetres)]
    rod_mm: Option<u32>,

    /// Time that the services take [default: zero]
    #[arg(long, value_name = "TIMES")]
    service_times: Option<Times>,

    /// What the encoder does with a service bit that is 1 in the first exchange after power-up: ignored or executed [default:
    /// ignored]
    #[arg(long, value_name = "WHAT")]
    stale_service: Option<StaleService>,

    /// Print the trace with the IN words of the simulated encoder, columns in the order of docs/tables.md
    #[arg(long)]
    print: bool,

    /// Ring position in the recording, 0 to 127
    #[arg(long, value_name = "POSITION", value_parser = arguments::whole::<u8>(0..=127))]
    at: Option<u8>,

    #[command(flatten)]
    output: Output,

    #[command(flatten)]
    table: TableArguments,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Times {
    /// No time: each reply is in the exchange of its request
    Zero,
    /// Read 0, write 10 ms, data check 20 ms, preset adjustment 10 ms
    Default,
}

impl Times {
    fn times(self) -> ServiceTimes {
        match self {
            Self::Zero => ServiceTimes::ZERO,
            Self::Default => ServiceTimes::default(),
        }
    }
}

impl Arguments {
    /// What the options say the encoder measures with; `None` where they say nothing.
    fn sensor(&self) -> Option<Sensor> {
        self.label
            .native
            .map(|steps_per_turn| Sensor::Rotary { steps_per_turn })
            .or(self.rod_mm.map(|rod_um| Sensor::Linear { rod_um }))
    }

    /// The option behind [`sensor`](Self::sensor), to begin a message with.
    fn sensor_option(&self) -> &'static str {
        if self.label.native.is_some() { "--native" } else { "--rod-mm" }
    }

    /// The encoder of a trace.
    fn unit(&self) -> Result<Unit, Failure> {
        let Some(model) = self.label.model else {
            return Err(bad_input(format!(
                "--model is missing: a trace does not name its encoder; it is {}",
                Series(&MODELS, "or")
            )));
        };
        let unit = Unit::new(model, self.sensor().unwrap_or(model.usual_sensor()));
        let mut unit = unit.map_err(|error| bad_input(format!("{}: {error}", self.sensor_option())))?;
        unit.service_times = self.service_times.unwrap_or(Times::Zero).times();
        unit.stale_service = self.stale_service.unwrap_or_default();
        Ok(unit)
    }

    /// Refuses options that contradict the encoder of a recording.
    fn agree_with(&self, unit: &Unit) -> Result<(), Failure> {
        let contradiction = if self.label.model.is_some_and(|model| model != unit.model()) {
            "--model"
        } else if self.sensor().is_some_and(|sensor| sensor != unit.sensor()) {
            self.sensor_option()
        } else if self.service_times.is_some_and(|times| times.times() != unit.service_times) {
            "--service-times"
        } else if self.stale_service.is_some_and(|stale_service| stale_service != unit.stale_service) {
            "--stale-service"
        } else {
            return Ok(());
        };
        let own = match unit.sensor() {
            Sensor::Rotary { steps_per_turn } => format!("{steps_per_turn} steps per turn"),
            Sensor::Linear { rod_um } => {
                format!("a rod of {}.{:03} mm", rod_um / 1000, rod_um % 1000)
            }
        };
        let stale = match self.stale_service {
            Some(_) => format!(", and a stale service bit is {}", unit.stale_service),
            None => String::new(),
        };
        let ServiceTimes { read, write, data_check, preset_adjustment } = unit.service_times;
        Err(bad_input(format!(
            "{contradiction} contradicts the recording: it holds a {} with {own} and service times of {read}, \
             {write}, {data_check} and {preset_adjustment}{stale}; leave the option out",
            unit.model(),
        )))
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    if arguments.label.native.is_some() && arguments.rod_mm.is_some() {
        return Err(bad_input("--native and --rod-mm: an encoder turns or is a rod, not both"));
    }
    let source = Source::open(arguments)?;
    let mut reader = arguments.table.reader(source.name, source.progress.wrap_read(source.bytes))?;
    let mut player = Player::new(arguments, &reader, source.name, &source.progress)?;
    let played = reader.try_for_each(|row| player.row(row.map_err(|error| bad_input(error.to_string()))?));
    source.progress.finish_and_clear();
    // Rows before a bad one are shown all the same.
    player.flush()?;
    played?;
    tell_doubts(&reader, source.name);
    player.finish()
}

/// Where the rows come from.
struct Source<'a> {
    /// What messages call it.
    name: &'a str,
    bytes: Box<dyn Read>,
    progress: ProgressBar,
}

impl<'a> Source<'a> {
    fn open(arguments: &'a Arguments) -> Result<Self, Failure> {
        let name = arguments.trace.as_str();
        if name == "-" {
            let bytes = Box::new(io::stdin().lock());
            return Ok(Self { name: "standard input", bytes, progress: ProgressBar::hidden() });
        }
        let file = File::open(name).map_err(|error| bad_input(format!("cannot open {name}: {error}")))?;
        let beside = if arguments.print { Beside::Rows } else { Beside::Nothing };
        let progress = reading::bar(&file, beside);
        Ok(Self { name, bytes: Box::new(file), progress })
    }
}

/// How many differences are shown.
const SHOWN: usize = 10;

/// An encoder under replay, with what was found so far.
struct Player<'a> {
    node: Node,
    /// The position whose rows are played; without `--at` that of the first row.
    position: Option<u8>,
    /// `--at` was given: rows of other positions are for other encoders.
    chosen: bool,
    file: &'a str,
    /// What was assumed of a table of another program.
    assumed: Option<String>,
    format: Format,
    progress: &'a ProgressBar,
    lines: io::Stdout,
    printed: Option<Writer<BufWriter<io::StdoutLock<'static>>>>,
    /// The OUT word of the row before.
    out: u32,
    rows: u64,
    /// Rows that say what the encoder should answer.
    judged: u64,
    differences: u64,
    first: Vec<Difference>,
}

impl<'a> Player<'a> {
    fn new<R: Read>(
        arguments: &Arguments,
        reader: &Reader<R>,
        file: &'a str,
        progress: &'a ProgressBar,
    ) -> Result<Self, Failure> {
        let mut devices = Vec::new();
        let node = match reader.recording() {
            Some(recording) => {
                let device = device_at(arguments.at, &recording.devices, file)?;
                let problem =
                    |error| format!("{file} line {}: device {}: {error}", device.line, device.position);
                let (unit, memory) =
                    device_line::from_device(device).map_err(|error| bad_input(problem(error)))?;
                arguments.agree_with(&unit)?;
                devices.push(device.clone());
                Node::with_memory(unit, memory)
            }
            None => Node::new(arguments.unit()?),
        };
        let printed = if arguments.print {
            let sink = BufWriter::new(io::stdout().lock());
            // What is printed of a recording is one again, so that it replays.
            Some(if devices.is_empty() { Writer::new(sink) } else { Writer::recording(sink, &devices) }?)
        } else {
            None
        };
        Ok(Self {
            node,
            position: arguments.at,
            chosen: arguments.at.is_some(),
            file,
            assumed: reader.assumed().map(str::to_owned),
            format: arguments.output.format,
            progress,
            lines: io::stdout(),
            printed,
            out: 0,
            rows: 0,
            judged: 0,
            differences: 0,
            first: Vec::with_capacity(SHOWN),
        })
    }

    fn row(&mut self, mut row: Row) -> Result<(), Failure> {
        if !self.takes(&row)? {
            return Ok(());
        }
        // What a row does not say stands as it did before.
        self.out = row.out.unwrap_or(self.out);
        row.out = Some(self.out);
        let got = play(&mut self.node, &row);
        self.rows += u64::from(got.is_some());
        self.judged += u64::from(row.input.is_some());
        if let Some(difference) = compare(&row, got) {
            self.differences += 1;
            if self.first.len() < SHOWN {
                self.first.push(difference);
                if self.format == Format::Text {
                    self.progress.suspend(|| self.say(&difference.to_string()))?;
                }
            }
        }
        if let Some(writer) = &mut self.printed {
            row.input = got;
            writer.write(&row)?;
        }
        Ok(())
    }

    /// Whether the row is for the encoder that is played.
    fn takes(&mut self, row: &Row) -> Result<bool, Failure> {
        let problem = |what: String| Err(bad_input(format!("{} line {}: {what}", self.file, row.line)));
        match (row.position, self.position) {
            (None, None) => Ok(true),
            (Some(found), Some(wanted)) if found == wanted => Ok(true),
            (Some(_), Some(_)) if self.chosen => Ok(false),
            (Some(found), Some(first)) => {
                problem(format!("position {found} after position {first}; choose one with --at"))
            }
            (None, Some(wanted)) => {
                problem(format!("no column position, so nothing is at {wanted}; leave --at out"))
            }
            (Some(found), None) => {
                self.position = Some(found);
                Ok(true)
            }
        }
    }

    /// A line for the user: beside the trace if that is printed, else in its place.
    fn say(&self, line: &str) -> io::Result<()> {
        if self.printed.is_some() {
            output::note(line);
            Ok(())
        } else {
            writeln!(&self.lines, "{line}")
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.printed.as_mut().map_or(Ok(()), Writer::flush)
    }

    fn finish(&self) -> Result<Answer, Failure> {
        let Self { rows, judged: compared, differences, .. } = *self;
        match self.format {
            Format::Text => self.say(&format!("{rows} rows, {differences} differences"))?,
            Format::Json => {
                let first = self.first.iter().map(DifferenceView::new).collect();
                let assumed = self.assumed.as_deref();
                let summary = Summary { rows, compared, differences, assumed, first };
                self.say(&serde_json::to_string(&summary)?)?;
            }
        }
        Ok(match self.judged {
            // What was printed was all that there was to do.
            0 if self.printed.is_some() => Answer::Yes,
            0 => {
                output::note(&format!(
                    "note: nothing compared: no row of {} that was played has an IN word",
                    self.file
                ));
                Answer::Unknown
            }
            _ if differences == 0 => Answer::Yes,
            _ => Answer::No,
        })
    }
}

/// The encoder to play; a recording never leaves the choice to chance.
fn device_at<'a>(at: Option<u8>, devices: &'a [DeviceLine], file: &str) -> Result<&'a DeviceLine, Failure> {
    let positions = devices.iter().map(|device| device.position.to_string()).collect::<Vec<_>>().join(", ");
    let positions = if positions.is_empty() { "none".to_owned() } else { positions };
    match at {
        None => Err(bad_input(format!(
            "{file} is a recording: choose an encoder with --at; positions: {positions}"
        ))),
        Some(at) => devices.iter().find(|device| device.position == at).ok_or_else(|| {
            bad_input(format!("--at {at}: {file} has no encoder there; positions: {positions}"))
        }),
    }
}

#[derive(Serialize)]
struct Summary<'a> {
    rows: u64,
    compared: u64,
    differences: u64,
    assumed: Option<&'a str>,
    first: Vec<DifferenceView>,
}

#[derive(Serialize)]
struct DifferenceView {
    line: u64,
    out: String,
    expected: String,
    got: String,
}

impl DifferenceView {
    fn new(difference: &Difference) -> Self {
        let Difference { line, out, expected, got } = difference;
        Self { line: *line, out: format!("{out:08X}"), expected: expected.to_string(), got: got.to_string() }
    }
}
