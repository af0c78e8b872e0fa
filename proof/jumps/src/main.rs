//! What can be told of a jump, and recordings whose jumps are known; see README.md of this folder.

mod cause;
mod chance;
mod clean;
mod corpus;
mod decidable;
mod device;
mod faults;
mod file;
mod plan;
mod polled;
mod report;
mod scene;
mod score;
mod stage;
mod table;
#[cfg(test)]
mod tests;
mod travel;

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};

use encoring_diagnosis::Likelihood;

use crate::clean::Beside;
use crate::corpus::Case;
use crate::score::Score;

/// Tell what can be told of a jump, and make recordings whose jumps are known.
#[derive(Parser)]
#[command(name = "jumps", max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Print the tables of docs/diagnosis.md: cause, period and speed.
    Table,
    /// Write the recording of a seed as FILE, and its truth beside it as FILE.json.
    Write {
        /// 0 to 9999 are the corpus.
        seed: u64,
        /// The table, as CSV; what is there is replaced.
        file: PathBuf,
    },
    /// Say what the diagnosis finds in the recording of a seed, below the truth.
    Look { seed: u64 },
    /// Give the recordings to the diagnosis, and say how often it was right.
    Score {
        /// Which half of the seeds 0 to 9999.
        #[arg(long, value_enum, default_value_t = Half::Development)]
        half: Half,
        /// Only so many of them.
        #[arg(long, default_value_t = 5_000)]
        recordings: usize,
        /// Also the most frequent kinds of mistakes, with seeds.
        #[arg(long)]
        misses: bool,
    },
    /// Give the diagnosis clean motion at the limits of the data sheet, and count its false alarms.
    Clean {
        #[arg(long, default_value_t = 24)]
        hours: u64,
        /// Microseconds from row to row; all of 1, 10, 100 ms and 1 s if not given.
        #[arg(long)]
        period_us: Option<u64>,
    },
    /// Give the diagnosis clean logs of pollers, and count its false alarms.
    CleanPolls {
        /// How many logs.
        #[arg(long, default_value_t = 10_000)]
        logs: u64,
        /// The seed of the first.
        #[arg(long, default_value_t = 0)]
        first: u64,
        /// Logs with findings that are shown.
        #[arg(long, default_value_t = 20)]
        shown: u64,
    },
    /// Count the causes of a range of seeds, and how many of them can be told.
    Count {
        /// How many seeds, from 0.
        seeds: u64,
    },
}

/// Half of the corpus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Half {
    /// Even seeds: to look at while the diagnosis is made.
    Development,
    /// Odd seeds: for the final figures only.
    Final,
}

impl Half {
    fn seeds(self, recordings: usize) -> Vec<u64> {
        let first = match self {
            Self::Development => 0,
            Self::Final => 1,
        };
        (first..10_000).step_by(2).take(recordings).collect()
    }
}

fn main() -> ExitCode {
    let done = match Arguments::parse().command {
        Command::Table => {
            print!("{}", table::markdown());
            Ok(())
        }
        Command::Write { seed, file } => write(seed, &file),
        Command::Look { seed } => {
            look(seed);
            Ok(())
        }
        Command::Score { half, recordings, misses } => {
            let score = Score::of_many(&half.seeds(recordings));
            print!("{}", report::markdown(&score));
            if misses {
                print!("\n{}", report::misses(&score));
            }
            Ok(())
        }
        Command::Clean { hours, period_us } => clean(hours, period_us),
        Command::CleanPolls { logs, first, shown } => clean_polls(first..first.saturating_add(logs), shown),
        Command::Count { seeds } => {
            count(seeds);
            Ok(())
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn write(seed: u64, file: &Path) -> io::Result<()> {
    let case = Case::of(seed);
    std::fs::write(file, file::table(&case))?;
    let mut beside = file.as_os_str().to_owned();
    beside.push(".json");
    std::fs::write(beside, format!("{:#}\n", file::truth(&case)))
}

fn look(seed: u64) {
    let case = Case::of(seed);
    println!("{:#}", file::truth(&case));
    for episode in score::diagnosed(&case) {
        println!("{episode:#?}");
    }
}

fn clean(hours: u64, period_us: Option<u64>) -> io::Result<()> {
    let periods = period_us.map_or_else(|| vec![1_000, 10_000, 100_000, 1_000_000], |period| vec![period]);
    let mut alarms = 0;
    for period_us in periods {
        for beside in [Beside::Nothing, Beside::Model] {
            let (rows, found) = clean::alarms(period_us, period_us, hours * 3_600, beside);
            println!(
                "{hours} h, a row every {period_us} us, told {beside:?}: {rows} rows, {} false alarms",
                found.len()
            );
            found.iter().take(3).for_each(|episode| println!("  {episode:?}"));
            alarms += found.len();
        }
    }
    if alarms == 0 { Ok(()) } else { Err(io::Error::other(format!("{alarms} false alarms"))) }
}

/// Of the clean logs of pollers so many may have one with a finding that is certain or likely: some swing over the end of
/// their range at the limits of the data sheet.
const SURE_ONE_IN: u64 = 1_000;

fn clean_polls(seeds: Range<u64>, shown: u64) -> io::Result<()> {
    let mut counts: BTreeMap<(&str, &str), u64> = BTreeMap::new();
    let (mut logs, mut sure, mut loud) = (0_u64, 0_u64, 0_u64);
    for alarms in seeds.map(polled::alarms) {
        logs += 1;
        for episode in &alarms.found {
            *counts.entry((episode.cause.name(), episode.certainty.name())).or_default() += 1;
        }
        let is_sure = alarms.found.iter().any(|episode| episode.certainty >= Likelihood::Likely);
        sure += u64::from(is_sure);
        loud += u64::from(!alarms.found.is_empty());
        if is_sure && sure <= shown || !alarms.found.is_empty() && loud <= shown {
            println!("{alarms}");
        }
    }
    println!("{logs} clean logs: {loud} with a finding, {sure} with one that is certain or likely");
    counts.iter().for_each(|((cause, certainty), count)| println!("  {cause} {certainty}: {count}"));
    let most = logs / SURE_ONE_IN;
    if sure <= most {
        Ok(())
    } else {
        Err(io::Error::other(format!("{sure} false alarms, at most {most} pass")))
    }
}

fn count(seeds: u64) {
    let mut counts: BTreeMap<&str, (u32, u32)> = BTreeMap::new();
    let mut clean = 0;
    for case in (0..seeds).map(Case::of) {
        clean += u32::from(case.jumps.is_empty());
        for jump in case.jumps {
            let (all, told) = counts.entry(jump.cause.name()).or_default();
            *all += 1;
            *told += u32::from(jump.rivals.is_empty());
        }
    }
    println!("{clean} of {seeds} recordings without a jump");
    for (name, (all, told)) in counts {
        println!("{name:18} {all:6} jumps, {told:6} can be told");
    }
}
