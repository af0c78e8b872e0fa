//! `encoring referee`: which rule of the handshake a PLC program broke.

mod input;
mod view;

use std::io::{self, Write};

use clap::{Args, ValueEnum};
use encoring_bus::Referees;
use encoring_host::referee::Vantage;
use encoring_station::FindingView;
use encoring_words::{Duration, Model};

use crate::arguments::{Output, TableArguments, span};
use crate::interrupt::Interrupt;
use crate::output::{Answer, Failure, note, page};

/// Judge a PLC program: which rules of the handshake did it break
///
/// It reads files of every write and every ring cycle, recordings (`sim --record`), tables with a column `line`, and logs of
/// PLCs and gateways. What can be judged depends on where the trace was taken; the output lists what could not be judged.
/// No trace shows whether the program used a position while bit 31 was 1.
#[derive(Args, Debug)]
#[command(after_help = "\
The trace is seen from: w every write and every ring cycle, c the master's image at
every ring cycle, x the exchanges at the encoder, p a log. A finding is \"broken\" if it
is certain from there, and \"suspected\" if a right program could look the same.
docs/referee.md has every rule.

Exit codes:
  0  no rule of severity error is certainly broken
  1  a rule of severity error is broken
  2  the trace or the options are wrong
  3  no service was seen, or Ctrl-C came before the end

Examples:
  encoring referee bus.csv
  encoring referee recording.csv --format json
  encoring referee plc.csv --model ce-65-m --columns \"time_ms=Zeit,out=QD 256,in=ID 256\"")]
pub(crate) struct Arguments {
    /// The trace, or `-` for standard input
    #[arg(value_name = "TRACE.csv")]
    trace: String,

    /// Model of the encoder, if the trace does not name it; without it only rules of every model are certain
    #[arg(long, value_name = "MODEL")]
    model: Option<Model>,

    /// Where a table of another program was taken [default: c with a column `line`, else p]
    #[arg(long, value_name = "VANTAGE")]
    seen_from: Option<SeenFrom>,

    /// After so long without a reply a program may give up a request: a note, no error
    #[arg(long, value_name = "TIME", default_value = "1s", value_parser = span)]
    withdrawn_after: Duration,

    #[command(flatten)]
    output: Output,

    #[command(flatten)]
    table: TableArguments,
}

/// Where a table was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum SeenFrom {
    /// The master's image at every ring cycle
    C,
    /// The exchanges at the encoder
    X,
    /// A log of a PLC or a gateway
    P,
}

impl SeenFrom {
    const fn vantage(self) -> Vantage {
        match self {
            Self::C => Vantage::Cycles,
            Self::X => Vantage::Exchanges,
            Self::P => Vantage::Log,
        }
    }
}

/// Tells what was wrong with the trace.
fn tell_flaws(referees: &Referees, name: &str) {
    for (position, referee) in referees.each() {
        let flaws = referee.flaws();
        let told = [
            (flaws.gaps, "pauses far longer than usual: across them nothing is judged"),
            (flaws.unseen_writes, "words that nobody was seen to write: these requests are not judged"),
            (flaws.lone_halves, "writes of half a word whose other half is not known: they are left out"),
            (flaws.backwards, "rows before the row before them: left out"),
        ];
        for (count, what) in told.into_iter().filter(|(count, _)| *count > 0) {
            note(&format!("note: {name}: position {position}: {count} {what}"));
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let interrupt = Interrupt::new()?;
    interrupt.only_looks();
    let mut referees = input::read(arguments, &interrupt)?;
    referees.finish();
    tell_flaws(&referees, input::name(arguments));
    let mut out = io::stdout().lock();
    for (position, finding) in referees.findings() {
        let view = FindingView::new(position, finding, referees.vantage());
        out.write_all(page(arguments.output.format, &view)?.as_bytes())?;
    }
    let end = view::EndView::new(&referees);
    out.write_all(page(arguments.output.format, &end)?.as_bytes())?;
    out.flush()?;
    Ok(match referees.services() {
        _ if referees.is_broken() => Answer::No,
        _ if interrupt.is_interrupted() => Answer::Unknown,
        0 => Answer::Unknown,
        _ => Answer::Yes,
    })
}
