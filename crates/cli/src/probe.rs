//! `encoring probe`: where on an unknown gateway the encoders are.

use std::fmt;
use std::io::IsTerminal;
use std::ops::ControlFlow;
use std::sync::atomic::Ordering;

use clap::Args;
use encoring_bus::Bus;
use encoring_modbus::probe::{End, Findings, Reach, Stage, probe};
use encoring_modbus::{Address, Client};
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use crate::arguments::Output;
use crate::interrupt::Interrupt;
use crate::output::{Answer, Failure, note};

/// Find the encoders of an unknown gateway: register, table and word order
///
/// It reads registers and never writes. Turn the shafts while it reads: it recognises positions by their motion.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  one place stands out
  1  several places fit, or none
  2  wrong usage
  3  no answer

Examples:
  encoring probe modbus-tcp://192.168.1.10
  encoring probe 'modbus-rtu:/dev/ttyUSB0?baud=19200&unit=3' --format json")]
pub(crate) struct Arguments {
    /// Address of the gateway: modbus-tcp://HOST[:PORT][?unit=1] or modbus-rtu:DEVICE?baud=19200
    #[arg(value_name = "ADDRESS")]
    address: Address,
    /// Last register to look at, 0 to 65535
    #[arg(long, value_name = "REGISTER", default_value_t = Reach::default().last)]
    last: u16,
    /// Most requests to send
    #[arg(long, value_name = "N", default_value_t = Reach::default().requests)]
    requests: u32,
    #[command(flatten)]
    output: Output,
}

#[derive(Serialize)]
struct ProbeView {
    verdict: &'static str,
    candidates: Vec<CandidateView>,
    requests: u32,
    /// `whole`, `stopped` or `limit`.
    end: &'static str,
}

#[derive(Serialize)]
struct CandidateView {
    bus: String,
    certainty: String,
    encoders: usize,
    evidence: Vec<String>,
}

impl ProbeView {
    fn new(report: &Findings) -> Self {
        let candidates = report.candidates.iter().map(|candidate| CandidateView {
            bus: candidate.address.to_string(),
            certainty: candidate.certainty.to_string(),
            encoders: candidate.encoders,
            evidence: candidate.evidence.iter().map(ToString::to_string).collect(),
        });
        Self {
            verdict: report.verdict(),
            candidates: candidates.collect(),
            requests: report.requests,
            end: match report.end {
                End::Whole => "whole",
                End::Stopped => "stopped",
                End::Limit => "limit",
            },
        }
    }
}

impl fmt::Display for ProbeView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.verdict)?;
        for candidate in &self.candidates {
            writeln!(f, "\n{:<8}  --bus '{}'", candidate.certainty, candidate.bus)?;
            let places = if candidate.encoders == 1 { "place" } else { "places" };
            writeln!(f, "          {} {places} for encoders", candidate.encoders)?;
            for evidence in &candidate.evidence {
                writeln!(f, "          {evidence}")?;
            }
        }
        let end = match self.end {
            "stopped" => ", then it was interrupted",
            "limit" => ", and no more are allowed (--requests)",
            _ => "",
        };
        writeln!(f, "\n{} requests{end}; nothing was written", self.requests)
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let stop = Interrupt::new()?.stop();
    let mut client = Client::new(arguments.address.clone())?;
    let limits = Reach { last: arguments.last, requests: arguments.requests, ..Reach::default() };
    let bar =
        if std::io::stderr().is_terminal() { ProgressBar::new_spinner() } else { ProgressBar::hidden() };
    let style = ProgressStyle::with_template("{spinner} {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_spinner()));
    let report = probe(&mut client, limits, |progress| {
        bar.set_message(match progress.stage {
            Stage::Looking => format!("{} requests, looking at {}", progress.requests, progress.place),
            Stage::Watching { pass, of } => format!("watching what moves, reading {pass} of {of}"),
        });
        bar.tick();
        if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    bar.finish_and_clear();
    if let Some(advice) = client.advice() {
        note(&format!("note: {}: {advice}", arguments.address.way));
    }
    let report = report.map_err(|error| Failure::NoAnswer(format!("{}: {error}", arguments.address.way)))?;
    arguments.output.print(&ProbeView::new(&report))?;
    if report.end == End::Stopped && report.candidates.is_empty() {
        return Err(Failure::NoAnswer("interrupted".to_owned()));
    }
    Ok(if report.stands_out().is_some() { Answer::Yes } else { Answer::No })
}
