//! Compares the encoders, word by word, with a plain reading of their manuals; see docs/proof.md.

mod couple;
mod device;
mod parts;
mod reading;

use std::num::NonZero;
use std::process::ExitCode;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Parser, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};

use crate::couple::Tally;
use crate::parts::Part;
use crate::reading::{BOOKS, Book};

/// Compare every word and every first request with a plain reading of the manuals.
#[derive(Parser)]
#[command(name = "exhaustive", max_term_width = 100)]
struct Arguments {
    /// What to compare.
    #[arg(long, value_enum, default_value_t = Parts::All)]
    part: Parts,
    /// Normal mode with a new encoder only, of the first requests what lies at a boundary and a stride through the
    /// rest, and pairs only if they are asked for.
    #[arg(long)]
    dense: bool,
    /// Threads; all cores if not given.
    #[arg(long)]
    threads: Option<NonZero<usize>>,
    /// Only this encoder; may be repeated.
    #[arg(long = "model", value_parser = model())]
    models: Vec<&'static Book>,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Parts {
    /// All 2^31 words with service bit 0.
    Normal,
    /// All 2^31 words with service bit 1, as the first request of a new encoder.
    Requests,
    /// Two requests in a row, from every state of the error latch.
    Pairs,
    /// Everything.
    All,
}

fn model() -> impl TypedValueParser<Value = &'static Book> {
    PossibleValuesParser::new(BOOKS.iter().map(|book| book.name))
        .try_map(|name| BOOKS.iter().find(|book| book.name == name).ok_or("no such encoder"))
}

impl Arguments {
    fn parts(&self) -> Vec<Part> {
        use Part::{DenseRequests, Normal, NormalProgrammed, Pairs, Requests};
        match (self.part, self.dense) {
            (Parts::Normal, true) => vec![Normal],
            (Parts::Normal, false) => vec![Normal, NormalProgrammed],
            (Parts::Requests, true) => vec![DenseRequests],
            (Parts::Requests, false) => vec![Requests],
            (Parts::Pairs, _) => vec![Pairs],
            (Parts::All, true) => vec![Normal, DenseRequests],
            (Parts::All, false) => vec![Normal, NormalProgrammed, Pairs, Requests],
        }
    }

    fn books(&self) -> Vec<&'static Book> {
        if self.models.is_empty() { BOOKS.iter().collect() } else { self.models.clone() }
    }

    fn threads(&self) -> usize {
        self.threads.or_else(|| thread::available_parallelism().ok()).map_or(1, NonZero::get)
    }
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut tally = Tally::default();
    for part in arguments.parts() {
        for book in arguments.books() {
            tally.add(compare(part, book, arguments.threads()));
        }
    }
    for difference in &tally.differences {
        let words: Vec<String> = difference.words.iter().map(|word| format!("{word:08X}")).collect();
        println!(
            "{} ({}): OUT {}: expected {}, got {}",
            difference.model,
            difference.state,
            words.join(" "),
            difference.expected,
            difference.got
        );
    }
    println!("{} passed, {} failed", tally.passed, tally.failed);
    if tally.failed == 0 && tally.passed > 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// One part for one encoder, on all threads.
fn compare(part: Part, book: &Book, threads: usize) -> Tally {
    let chunks = part.chunks(book);
    let bar = ProgressBar::new(chunks.into()).with_message(format!("{}, {}", book.name, part.name()));
    if let Ok(style) = ProgressStyle::with_template("{msg:38} {wide_bar} {percent:>3} % {eta:>4} to go") {
        bar.set_style(style);
    }
    let next = AtomicU32::new(0);
    let total = Mutex::new((0, Tally::default()));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let chunk = next.fetch_add(1, Ordering::Relaxed);
                    if chunk >= chunks {
                        break;
                    }
                    let mut tally = Tally::default();
                    let count = part.compare(book, chunk, &mut tally);
                    let mut total = total.lock().unwrap_or_else(PoisonError::into_inner);
                    total.0 += count;
                    total.1.add(tally);
                    bar.inc(1);
                }
            });
        }
    });
    let (count, tally) = total.into_inner().unwrap_or_else(PoisonError::into_inner);
    let seconds = bar.elapsed().as_secs_f64();
    bar.finish_and_clear();
    println!(
        "{}, {}: {count} of them, {} passed, {} failed, {seconds:.1} s, {:.1} ns each on one of {threads} threads",
        book.name,
        part.name(),
        tally.passed,
        tally.failed,
        seconds * 1e9 * threads as f64 / count as f64,
    );
    tally
}
