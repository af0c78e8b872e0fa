//! The score as numbers: each goal, the confusion matrix, the worst kinds of misses.

use std::collections::BTreeMap;
use std::fmt::Write;

use encoring_diagnosis::{CAUSES, Likelihood};

use crate::score::{Named, Score, Seen};

/// A share with what it shall be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Goal {
    pub(crate) what: &'static str,
    pub(crate) hits: usize,
    pub(crate) of: usize,
    /// In hundredths.
    pub(crate) goal: Wanted,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Wanted {
    AtLeast(u32),
    AtMost(u32),
}

impl Goal {
    /// In hundredths.
    pub(crate) fn percent(&self) -> f64 {
        if self.of == 0 { 0.0 } else { self.hits as f64 * 100.0 / self.of as f64 }
    }

    pub(crate) fn is_reached(&self) -> bool {
        match self.goal {
            Wanted::AtLeast(least) => self.of > 0 && self.percent() >= f64::from(least),
            Wanted::AtMost(most) => self.of > 0 && self.percent() <= f64::from(most),
        }
    }
}

/// The goals of the diagnosis.
pub(crate) fn goals(score: &Score) -> Vec<Goal> {
    let named = |what, goal, wanted: &dyn Fn(&Named) -> bool| {
        let all: Vec<&Named> = score.named.iter().filter(|named| wanted(named)).collect();
        Goal { what, hits: all.iter().filter(|named| named.is_right()).count(), of: all.len(), goal }
    };
    let seen = |what, goal, wanted: &dyn Fn(&Seen) -> bool, hit: &dyn Fn(&Seen) -> bool| {
        let all: Vec<&Seen> = score.seen.iter().filter(|seen| wanted(seen)).collect();
        Goal { what, hits: all.iter().filter(|seen| hit(seen)).count(), of: all.len(), goal }
    };
    vec![
        named("of the causes that are named, right", Wanted::AtLeast(95), &|_| true),
        named("of those that are certain, right", Wanted::AtLeast(99), &|named| {
            named.certainty == Likelihood::Certain
        }),
        named("of those that are likely, right", Wanted::AtLeast(90), &|named| {
            named.certainty == Likelihood::Likely
        }),
        seen(
            "of the jumps that can be told, named or among three alternatives",
            Wanted::AtLeast(95),
            &|seen| seen.decidable,
            &|seen| seen.told,
        ),
        seen(
            "the same, against all that the data sheet allows the axis",
            Wanted::AtLeast(95),
            &|seen| seen.decidable && seen.decidable_within_the_data_sheet,
            &|seen| seen.told,
        ),
        seen(
            "of the jumps that cannot be told, another cause as certain or likely",
            Wanted::AtMost(5),
            &|seen| !seen.decidable,
            &|seen| seen.wrongly_sure,
        ),
    ]
}

/// The whole report, as Markdown.
pub(crate) fn markdown(score: &Score) -> String {
    let mut page = String::new();
    let decidable = score.seen.iter().filter(|seen| seen.decidable).count();
    let _ = writeln!(
        page,
        "{} recordings, {} jumps, of which {decidable} can be told, {} causes named.\n",
        score.recordings,
        score.seen.len(),
        score.named.len()
    );
    let _ = writeln!(page, "| what | seen | of | share | goal |\n|---|--:|--:|--:|---|");
    for goal in goals(score) {
        let wanted = match goal.goal {
            Wanted::AtLeast(least) => format!("at least {least} %"),
            Wanted::AtMost(most) => format!("at most {most} %"),
        };
        let missed = if goal.is_reached() { "" } else { ", missed" };
        let _ = writeln!(
            page,
            "| {} | {} | {} | {:.1} % | {wanted}{missed} |",
            goal.what,
            goal.hits,
            goal.of,
            goal.percent()
        );
    }
    let _ = writeln!(page, "\n{}\n{}", causes(score), matrix(score));
    page
}

/// Each cause: jumps that can be told, and that were.
fn causes(score: &Score) -> String {
    let mut page = String::from(
        "| cause | jumps | can be told | of these told | cannot | another cause as sure | named | right |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for cause in CAUSES {
        let name = cause.name();
        let of: Vec<&Seen> = score.seen.iter().filter(|seen| seen.cause == name).collect();
        let named: Vec<&Named> = score.named.iter().filter(|named| named.cause == name).collect();
        if of.is_empty() && named.is_empty() {
            continue;
        }
        let count = |wanted: &dyn Fn(&&Seen) -> bool| of.iter().copied().filter(wanted).count();
        let _ = writeln!(
            page,
            "| {name} | {} | {} | {} | {} | {} | {} | {} |",
            of.len(),
            count(&|seen| seen.decidable),
            count(&|seen| seen.decidable && seen.told),
            count(&|seen| !seen.decidable),
            count(&|seen| !seen.decidable && seen.wrongly_sure),
            named.len(),
            named.iter().filter(|named| named.is_right()).count()
        );
    }
    page
}

/// Truth by row, what was named by column. A jump for which nothing was named counts in the last.
fn matrix(score: &Score) -> String {
    let columns: Vec<&str> = CAUSES.iter().map(|cause| cause.name()).collect();
    let mut page = String::from(
        "The rows are what happened, the columns what was named, by the numbers of the rows.\n\n| |",
    );
    for number in 1..=columns.len() {
        let _ = write!(page, " {number} |");
    }
    let _ = writeln!(page, " nothing |\n|---|{}", "--:|".repeat(columns.len() + 1));
    let rows = columns.iter().map(|name| Some(*name)).chain([None]);
    for (number, truth) in (1..).zip(rows) {
        let name = truth.map_or("nothing".to_owned(), |name| format!("{number} {name}"));
        let _ = write!(page, "| {name} |");
        for column in &columns {
            let count =
                score.named.iter().filter(|named| named.truth == truth && named.cause == *column).count();
            let _ = if count == 0 { write!(page, " |") } else { write!(page, " {count} |") };
        }
        let nothing =
            |seen: &&Seen| Some(seen.cause) == truth && seen.named.iter().all(|named| *named == "unclear");
        let _ = writeln!(page, " {} |", score.seen.iter().filter(nothing).count());
    }
    page
}

/// The most frequent kinds of mistakes, with seeds to look at.
pub(crate) fn misses(score: &Score) -> String {
    let mut kinds: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for seen in score.seen.iter().filter(|seen| seen.decidable && !seen.told) {
        let said = if seen.named.is_empty() { "nothing".to_owned() } else { seen.named.join(" ") };
        let kind = format!("{} can be told, but said: {said}", seen.cause);
        kinds.entry(kind).or_default().push(format!("{} line {}", seen.seed, seen.line));
    }
    for seen in score.seen.iter().filter(|seen| !seen.decidable && seen.wrongly_sure) {
        let kind = format!("{} cannot be told, but is sure of: {}", seen.cause, seen.named.join(" "));
        kinds.entry(kind).or_default().push(format!("{} line {}", seen.seed, seen.line));
    }
    for named in score.named.iter().filter(|named| !named.is_right()) {
        let truth = named.truth.unwrap_or("nothing");
        let kind = format!("{} named as {} where there was {truth}", named.cause, named.certainty.name());
        kinds.entry(kind).or_default().push(format!("{} line {}", named.seed, named.line));
    }
    let mut ordered: Vec<(String, Vec<String>)> = kinds.into_iter().collect();
    ordered.sort_by_key(|(_, seeds)| std::cmp::Reverse(seeds.len()));
    let mut page = String::new();
    for (kind, seeds) in ordered.iter().take(80) {
        let shown: Vec<&str> = seeds.iter().map(String::as_str).take(6).collect();
        let _ = writeln!(page, "{:5} {kind}; seeds {}", seeds.len(), shown.join(", "));
    }
    page
}
