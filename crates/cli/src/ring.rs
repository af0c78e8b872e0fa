//! `encoring ring`: what can be told of a ring by its size.

use std::fmt;

use clap::{Args, Subcommand};
use encoring_ring::cycle_time::{CABLE_M_MAX, REMOTE_DEVICES_MAX, Terms};
use encoring_ring::profile::{BIT_2M, BIT_500K, DATA_BYTES_MAX, DEVICES_MAX, ENCODER_BYTES, FRAME_BYTES};
use encoring_ring::{CycleTime, ENCODERS_MAX};
use encoring_words::model::MODELS;
use encoring_words::{Duration, Model};
use serde::Serialize;

use crate::arguments::Output;
use crate::output::{Answer, Failure, bad_input};

/// The longest software time that is taken, in microseconds.
const SOFTWARE_US_MAX: u32 = 1_000_000;

/// Compute times of a ring before it is built
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  encoring ring cycle-time --encoders 3
  encoring ring cycle-time --encoders 128 --cable-m 1000 --format json")]
pub(crate) struct Arguments {
    #[command(subcommand)]
    question: Question,
}

#[derive(Subcommand, Debug)]
enum Question {
    CycleTime(CycleTimeArguments),
}

/// Compute the cycle time term by term, and the worst reaction time
#[derive(Args, Debug)]
#[command(after_help = "\
The cycle takes (13 * (6 + bytes) + 1.5 * devices) bits, the software time of the master
and the delay of the cable.

Exit codes:
  0  computed
  2  wrong usage

Examples:
  encoring ring cycle-time --encoders 10
  encoring ring cycle-time --encoders 10 --cable-m 1000 --kbit 2000
  encoring ring cycle-time --bytes 48 --devices 14 --software-us 700")]
struct CycleTimeArguments {
    /// Number of encoders on a ring of encoders only, 1 to 128
    #[arg(long, value_name = "N", conflicts_with_all = ["bytes", "devices"])]
    encoders: Option<u32>,
    /// User data of all devices in bytes, 0 to 512; needs --devices
    #[arg(long, value_name = "N")]
    bytes: Option<u32>,
    /// Number of remote bus devices, 1 to 254; needs --bytes
    #[arg(long, value_name = "M")]
    devices: Option<u32>,
    /// Bit rate of the line in kbit/s
    #[arg(long, value_name = "500|2000", default_value = "500", value_parser = ["500", "2000"])]
    kbit: String,
    /// Length of the remote bus cable in metres, 0 to 12800
    #[arg(long, value_name = "M", default_value_t = 0)]
    cable_m: u32,
    /// Software time of the master in each cycle in us, 0 to 1000000; see the manual of the master
    #[arg(long, value_name = "US", default_value_t = 200)]
    software_us: u32,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct CycleTimeView {
    encoders: Option<u32>,
    bytes: u32,
    devices: u32,
    kbit_s: u32,
    cable_m: u32,
    terms: TermsView,
    cycle_ns: u64,
    cycles_per_s: f64,
    reactions: Vec<ReactionView>,
}

/// How long a motion takes at worst until the master sees it.
#[derive(Serialize)]
struct ReactionView {
    model: &'static str,
    refresh_ns: u64,
    /// `false`: its manual does not say, and the refresh is assumed.
    refresh_stated: bool,
    worst_ns: u64,
}

impl ReactionView {
    fn of(cycle: Duration) -> Vec<Self> {
        let view = |model: Model| Self {
            model: model.name(),
            refresh_ns: model.refresh().as_nanos(),
            refresh_stated: model.data_sheet().refresh.is_some(),
            worst_ns: CycleTime::worst_reaction(cycle, model.refresh()).as_nanos(),
        };
        MODELS.into_iter().map(view).collect()
    }
}

/// How the worst reaction comes about.
const REACTION: &str = "\
reaction: until the master has a position that shows a motion, at worst. The encoder
has just looked at the shaft (one refresh), the new position has just missed the cycle
that is loaded (one cycle), and the next one carries it (one cycle). The PLC's own
cycle and a gateway come on top.
";

#[derive(Serialize)]
struct TermsView {
    telegrams_ns: u64,
    devices_ns: u64,
    software_ns: u64,
    cable_ns: u64,
}

impl fmt::Display for CycleTimeView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { bytes, devices, kbit_s, cable_m, .. } = self;
        let TermsView { telegrams_ns, devices_ns, software_ns, cable_ns } = self.terms;
        let rows = [
            ("telegrams", format!("13 * ({FRAME_BYTES} + {bytes}) bits at {kbit_s} kbit/s"), telegrams_ns),
            ("devices", format!("1.5 * {devices} bits"), devices_ns),
            ("software", "the master's own time".to_owned(), software_ns),
            ("cable", format!("16 us a km, {cable_m} m"), cable_ns),
            ("cycle", format!("{:.1} a second", self.cycles_per_s), self.cycle_ns),
        ];
        for (name, formula, nanos) in rows {
            writeln!(f, "{name:<10} {formula:<44} {:>9} us", micros(nanos))?;
        }
        for reaction in &self.reactions {
            let assumed = if reaction.refresh_stated { "" } else { ", assumed" };
            let formula =
                format!("{}: 2 cycles + {} us refresh{assumed}", reaction.model, micros(reaction.refresh_ns));
            writeln!(f, "{:<10} {formula:<44} {:>9} us", "reaction", micros(reaction.worst_ns))?;
        }
        write!(f, "\n{REACTION}")
    }
}

/// Microseconds with the decimals that there are.
fn micros(nanos: u64) -> String {
    match (nanos / 1_000, nanos % 1_000) {
        (whole, 0) => whole.to_string(),
        (whole, rest) => format!("{whole}.{rest:03}").trim_end_matches('0').to_owned(),
    }
}

fn within(option: &str, value: u32, low: u32, high: u32, why: &str) -> Result<u32, Failure> {
    if (low..=high).contains(&value) {
        return Ok(value);
    }
    Err(bad_input(format!("{option} {value}; allowed are {low} to {high}: {why}")))
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let Question::CycleTime(arguments) = &arguments.question;
    let (bytes, devices) = match (arguments.encoders, arguments.bytes, arguments.devices) {
        (Some(encoders), ..) => {
            let why = format!("an encoder has 32 of the {} I/O points of a ring", DATA_BYTES_MAX * 8);
            let encoders = within("--encoders", encoders, 1, ENCODERS_MAX as u32, &why)?;
            (encoders * ENCODER_BYTES as u32, encoders)
        }
        (None, None, _) | (None, _, None) => {
            return Err(bad_input(
                "the size of the ring is missing: give --encoders N, or --bytes N with --devices M",
            ));
        }
        (None, Some(bytes), Some(devices)) => {
            let points = format!("a ring has {} I/O points", DATA_BYTES_MAX * 8);
            let remote = format!(
                "a ring has {DEVICES_MAX} devices, {REMOTE_DEVICES_MAX} of them on the remote bus, and the formula \
                 counts these"
            );
            (
                within("--bytes", bytes, 0, DATA_BYTES_MAX as u32, &points)?,
                within("--devices", devices, 1, REMOTE_DEVICES_MAX, &remote)?,
            )
        }
    };
    let cable_m = within("--cable-m", arguments.cable_m, 0, CABLE_M_MAX, "metres of remote bus")?;
    let software =
        within("--software-us", arguments.software_us, 0, SOFTWARE_US_MAX, "a second is no cycle any more")?;
    let (kbit_s, bit) = if arguments.kbit == "2000" { (2_000, BIT_2M) } else { (500, BIT_500K) };
    let cycle_time = CycleTime { bit, software: Duration::from_micros(software.into()), cable_m };
    let Terms { telegrams, devices: delay, software, cable } = cycle_time.terms(bytes, devices);
    let cycle_ns = cycle_time.of(bytes, devices).as_nanos();
    let view = CycleTimeView {
        encoders: arguments.encoders,
        bytes,
        devices,
        kbit_s,
        cable_m,
        terms: TermsView {
            telegrams_ns: telegrams.as_nanos(),
            devices_ns: delay.as_nanos(),
            software_ns: software.as_nanos(),
            cable_ns: cable.as_nanos(),
        },
        cycle_ns,
        // One decimal is what people read; programs have the time itself.
        reactions: ReactionView::of(Duration::from_nanos(cycle_ns)),
        cycles_per_s: (1e10 / cycle_ns as f64).round() / 10.0,
    };
    arguments.output.print(&view)?;
    Ok(Answer::Yes)
}
