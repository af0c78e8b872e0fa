//! `encoring diagnose`: why a position jumped.

mod input;
mod view;

use clap::Args;
use encoring_diagnosis::{Conclusion, Options};
use encoring_words::Model;

use crate::arguments::{Output, TableArguments, model};
use crate::interrupt::Interrupt;
use crate::output::{Answer, Failure, note};

/// Say why a position jumped: the cause of each step change in a recording
///
/// Reads logs (`encoring log`), recordings (`sim --record`, `sim --record-bus`), what `ssi decode --format csv` prints,
/// and tables of other programs. Each step change is told with its cause, how sure that is, what speaks for it, what
/// else it may be, and what would tell them apart.
#[derive(Args, Debug)]
#[command(after_help = "\
Certain: the recording itself says so, or nothing else makes these words. Likely:
others would need a coincidence. Possible: others explain it as well; they stand
beside it. docs/diagnosis.md has every cause.

Exit codes: 0 no fault (ends of the range, presets and other scalings are none);
1 a fault; 2 bad input; 3 only what cannot be told, or nothing could be judged.

Examples:
  encoring diagnose axis.csv
  encoring log axis.csv --bus ... ; encoring diagnose axis.csv --model ce-65-m
  encoring diagnose plc.csv --columns \"time_ms=Zeit,in=ID 256\" --format json")]
pub(crate) struct Arguments {
    /// The recordings, or `-` for standard input
    #[arg(value_name = "FILE", required = true)]
    files: Vec<String>,

    /// The encoder, where the recording does not name it
    #[arg(long, value_name = "MODEL", value_parser = model())]
    model: Option<Model>,

    #[command(flatten)]
    table: TableArguments,

    #[command(flatten)]
    output: Output,
}

impl Arguments {
    fn options(&self) -> Options {
        Options { model: self.model, ..Options::default() }
    }
}

/// What a file says.
struct Diagnosed {
    name: String,
    rows: u64,
    conclusion: Conclusion,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let interrupt = Interrupt::new()?;
    interrupt.only_looks();
    let mut diagnosed = Vec::new();
    for file in &arguments.files {
        diagnosed.push(input::read(file, arguments, &interrupt)?);
        if interrupt.is_interrupted() {
            note("note: interrupted: this is what the part that was read says");
            break;
        }
    }
    arguments.output.print(&view::ReportView::new(&diagnosed))?;
    Ok(answer(&diagnosed))
}

fn answer(diagnosed: &[Diagnosed]) -> Answer {
    let episodes = || diagnosed.iter().flat_map(|file| &file.conclusion.episodes);
    if episodes().any(|episode| episode.cause.is_fault()) {
        return Answer::No;
    }
    let is_unclear = episodes().any(|episode| episode.cause == encoring_diagnosis::JumpCause::Unclear);
    let is_empty = diagnosed.iter().all(|file| file.rows == 0);
    if is_unclear || is_empty { Answer::Unknown } else { Answer::Yes }
}
