//! `encoring ssi sweep`: one clock rate after the other.

use std::fmt;
use std::path::Path;

use clap::Args;
use encoring_sim::Scenario;
use encoring_sim::ssi_bench::{Sweep, SweepRow, sweep};
use encoring_words::ssi_frame::{CLOCK_HZ, CLOCK_HZ_LIMIT};
use serde::Serialize;

use super::decode::Edge;
use super::format::{FormatArguments, FormatText};
use crate::arguments::{Output, whole};
use crate::output::{Answer, Failure, bad_input};

/// A shaft that stands where many bits of a position are 1.
const BENCH: &str = "\
version = 1
seed = 1
[[device]]
position = 0
model = \"ce-65-m\"
motion = { kind = \"hold\", raw = 9_999 }
";

/// Kilohertz that are tried without --khz.
const RATES: [u32; 16] = [40, 45, 49, 50, 51, 60, 70, 80, 100, 200, 500, 800, 1_000, 1_050, 1_100, 1_200];

/// Read a simulated CE-65-M at one clock rate after the other
///
/// Below 50 kHz the word breaks at t_M. From 50 to 80 kHz it works, but is not guaranteed. Above 1 MHz nothing is
/// guaranteed. The simulated encoder has no delay of its own: words are wrong there only with --delay.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  every rate from 80 kHz to 1 MHz brings the position
  1  one of them does not
  2  wrong usage
  3  none of them was tried

Examples:
  encoring ssi sweep
  encoring ssi sweep --delay 600
  encoring ssi sweep --delay 600 --edge rising --khz 900 --khz 1000 --format json")]
pub(crate) struct Arguments {
    #[command(flatten)]
    format: FormatArguments,
    /// Number of clocks of each transfer, 1 to 1000 [default: one more than the field has bits]
    #[arg(long, value_name = "K", value_parser = whole::<u32>(1..=1_000))]
    clocks: Option<u32>,
    /// Clock edge at which the receiver takes the data
    #[arg(long, value_name = "EDGE", default_value = "falling")]
    edge: Edge,
    /// Delay from a rising edge to the data at the receiver in ns, 0 to 1000000
    #[arg(long, value_name = "NS", default_value_t = 0, value_parser = whole::<u32>(0..=1_000_000))]
    delay: u32,
    /// Clock rate to try in kHz, 1 to 10000 (repeatable) [default: 16 rates from 40 to 1200]
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=10_000))]
    khz: Vec<u32>,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct SweepView {
    #[serde(skip)]
    heading: String,
    rates: Vec<RateView>,
}

#[derive(Serialize)]
struct RateView {
    khz: u32,
    guaranteed: bool,
    right: u32,
    wrong: u32,
    faulty: u32,
    fault: Option<&'static str>,
    meaning: &'static str,
}

impl RateView {
    fn new(row: &SweepRow) -> Self {
        let SweepRow { hz, right, wrong, faulty, fault } = *row;
        Self {
            khz: hz / 1_000,
            guaranteed: (CLOCK_HZ.0..=CLOCK_HZ.1).contains(&hz),
            right,
            wrong,
            faulty,
            fault: fault.map(encoring_host::ssi_receiver::SsiFault::name),
            meaning: meaning(hz, right > 0 && wrong + faulty == 0),
        }
    }
}

fn meaning(hz: u32, is_right: bool) -> &'static str {
    match (hz, is_right) {
        (hz, false) if hz < CLOCK_HZ_LIMIT.0 => "the word breaks at t_M",
        (hz, true) if hz < CLOCK_HZ.0 => "works, not guaranteed",
        (hz, true) if hz <= CLOCK_HZ.1 => "guaranteed, works",
        (hz, false) if hz >= CLOCK_HZ.0 && hz <= CLOCK_HZ.1 => {
            "guaranteed by the encoder, and wrong with this delay or edge"
        }
        (_, true) => "outside the guarantee, works here",
        (_, false) => "outside the guarantee",
    }
}

impl fmt::Display for SweepView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n\n   kHz  right  wrong  faulty", self.heading)?;
        for RateView { khz, right, wrong, faulty, fault, meaning, .. } in &self.rates {
            let fault = fault.map(|fault| format!(" ({fault})")).unwrap_or_default();
            writeln!(f, "{khz:>6}  {right:>5}  {wrong:>5}  {faulty:>6}  {meaning}{fault}")?;
        }
        Ok(())
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let mut scenario = Scenario::parse("bench", BENCH, Path::new("")).map_err(bad_input)?;
    let format = arguments.format.format();
    if let (Some(device), Some(firmware)) = (scenario.devices.first_mut(), arguments.format.firmware()) {
        device.unit.firmware = firmware;
    }
    let how = Sweep {
        values: arguments.format.values(),
        clocks: arguments.clocks.unwrap_or(u32::from(format.bits()) + 1),
        taken_at: arguments.edge.taken_at(),
        delay_ns: arguments.delay,
    };
    let rates = if arguments.khz.is_empty() { &RATES[..] } else { &arguments.khz };
    let rows: Result<Vec<SweepRow>, _> =
        rates.iter().map(|khz| sweep(&scenario, 0, &how, khz * 1_000)).collect();
    let rates: Vec<RateView> = rows?.iter().map(RateView::new).collect();
    let edge = match arguments.edge {
        Edge::Rising => "rising",
        Edge::Falling => "falling",
    };
    let heading = format!(
        "{}, {} clocks, taken at the {edge} edge, data {} ns late; 10 transfers at each rate",
        FormatText(format),
        how.clocks,
        arguments.delay
    );
    let guaranteed = || rates.iter().filter(|rate| rate.guaranteed);
    let answer = match guaranteed().next() {
        None => Answer::Unknown,
        Some(_) if guaranteed().all(|rate| rate.wrong + rate.faulty == 0) => Answer::Yes,
        Some(_) => Answer::No,
    };
    arguments.output.print(&SweepView { heading, rates })?;
    Ok(answer)
}
