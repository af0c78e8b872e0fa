//! `encoring diagnose`: why a position jumped.

mod about;
mod drawn;
mod input;
mod view;

use std::io::{self, IsTerminal, Write};

use clap::Args;
use encoring_diagnosis::{Diagnosed, DiagnosisReport, JumpCause};

use crate::arguments::{Output, TableArguments};
use crate::interrupt::Interrupt;
use crate::output::{Answer, Failure, Format, note};

/// Find the causes of the step changes in a recording: why did the position jump
///
/// It reads logs (`encoring log`), recordings (`sim --record`, `sim --record-bus`), the output of `ssi decode --format csv`
/// and tables of other programs. For each step change it prints the cause, how certain it is, the evidence and the
/// alternatives. It also prints what would tell them apart.
#[derive(Args, Debug)]
#[command(after_help = "\
A cause is \"certain\" if the recording itself shows it, or if nothing else makes these
words. It is \"likely\" if other causes need a coincidence. It is \"possible\" if other
causes explain it as well; the output names them. docs/diagnosis.md has every cause.

Exit codes:
  0  no fault; an end of the range, a preset and a new scaling are none
  1  a fault
  2  wrong input
  3  no cause is clear, or nothing could be judged

Examples:
  encoring diagnose axis.csv
  encoring diagnose axis.csv --format json
  encoring diagnose axis.csv --plot axis.svg --report axis.html
  encoring diagnose plc.csv --model ce-65-m --columns \"time_ms=Zeit,in=ID 256\"")]
pub(crate) struct Arguments {
    /// The recordings, or `-` for standard input
    #[arg(value_name = "FILE", required = true)]
    files: Vec<String>,

    #[command(flatten)]
    about: about::AboutArguments,

    #[command(flatten)]
    drawn: drawn::DrawnArguments,

    #[command(flatten)]
    output: Output,

    #[command(flatten)]
    table: TableArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let interrupt = Interrupt::new()?;
    interrupt.only_looks();
    arguments.drawn.check()?;
    let mut diagnosed = Vec::new();
    for file in &arguments.files {
        diagnosed.push(input::read(file, arguments, &interrupt)?);
        if interrupt.is_interrupted() {
            note("note: interrupted: this is what the part that was read says");
            break;
        }
    }
    let charts = drawn::charts(&mut diagnosed);
    arguments.drawn.write(&diagnosed, &charts)?;
    if arguments.output.format == Format::Text && io::stdout().is_terminal() {
        io::stdout().lock().write_all(drawn::small(&diagnosed, &charts).as_bytes())?;
    }
    arguments.output.print(&view::ReportView(DiagnosisReport::new(&diagnosed)))?;
    Ok(answer(&diagnosed))
}

fn answer(diagnosed: &[Diagnosed]) -> Answer {
    let episodes = || diagnosed.iter().flat_map(|file| &file.conclusion.episodes);
    if episodes().any(|episode| episode.cause.is_fault()) {
        return Answer::No;
    }
    let is_unclear = episodes().any(|episode| episode.cause == JumpCause::Unclear);
    let is_judged = diagnosed.iter().any(Diagnosed::is_judged);
    if is_unclear || !is_judged { Answer::Unknown } else { Answer::Yes }
}
