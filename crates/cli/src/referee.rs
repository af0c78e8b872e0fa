//! `encoring referee`: which rule of the handshake a PLC program broke.

mod input;
mod view;

use std::collections::BTreeMap;
use std::io::{self, Write};

use clap::{Args, ValueEnum};
use encoring_host::referee::{HandshakeRule, Observed, Referee, Vantage};
use encoring_words::Model;

use crate::arguments::{Output, TableArguments};
use crate::output::{Answer, Failure, Format, note};

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
  3  no service was seen

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

/// The referees of a trace, by ring position.
struct Panel {
    vantage: Vantage,
    model: Option<Model>,
    models: BTreeMap<u8, Model>,
    referees: BTreeMap<u8, Referee>,
}

impl Panel {
    fn observe(&mut self, position: u8, seen: Observed) {
        if matches!(seen, Observed::Write { .. }) && self.vantage != Vantage::Writes {
            self.vantage = Vantage::Writes;
            self.referees.values_mut().for_each(Referee::sees_writes);
        }
        let (vantage, models, model) = (self.vantage, &self.models, self.model);
        let referee = self.referees.entry(position);
        let new = || Referee::new(vantage, models.get(&position).copied().or(model));
        referee.or_insert_with(new).observe(seen);
    }

    fn finish(&mut self) {
        self.referees.values_mut().for_each(Referee::finish);
    }

    /// The rules that were not judged for some encoder.
    fn not_judged(&self) -> Vec<HandshakeRule> {
        let nobody = Referee::new(self.vantage, None);
        let none = self.referees.is_empty().then_some(&nobody);
        let mut rules: Vec<_> = self.referees.values().chain(none).flat_map(Referee::not_judged).collect();
        rules.sort_unstable();
        rules.dedup_by_key(|rule| rule.name());
        rules
    }

    fn tell_flaws(&self, name: &str) {
        for (position, referee) in &self.referees {
            let flaws = referee.flaws();
            let told = [
                (flaws.gaps, "pauses far longer than usual: across them nothing is judged"),
                (flaws.unseen_writes, "words that nobody was seen to write: these requests are not judged"),
                (flaws.backwards, "rows before the row before them: left out"),
            ];
            for (count, what) in told.into_iter().filter(|(count, _)| *count > 0) {
                note(&format!("note: {name}: position {position}: {count} {what}"));
            }
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let mut panel = input::read(arguments)?;
    panel.finish();
    panel.tell_flaws(input::name(arguments));
    let mut out = io::stdout().lock();
    for (position, referee) in &panel.referees {
        for finding in referee.findings() {
            let view = view::FindingView::new(*position, finding, panel.vantage);
            match arguments.output.format {
                Format::Text => write!(out, "{view}")?,
                Format::Json => writeln!(out, "{}", serde_json::to_string(&view)?)?,
            }
        }
    }
    let services = panel.referees.values().map(Referee::services).sum();
    let end = view::EndView::new(&panel.not_judged(), panel.vantage, services);
    match arguments.output.format {
        Format::Text => write!(out, "{end}")?,
        Format::Json => writeln!(out, "{}", serde_json::to_string(&end)?)?,
    }
    out.flush()?;
    Ok(match services {
        _ if panel.referees.values().any(Referee::is_broken) => Answer::No,
        0 => Answer::Unknown,
        _ => Answer::Yes,
    })
}
