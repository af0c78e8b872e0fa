//! Where the positions went, and a close look at each jump: gathered row by row, in bounded memory.

use std::collections::{BTreeMap, VecDeque};

use encoring_figure::{Chart, Closeup, Envelope, PlotSample};
use encoring_texts::Said;
use encoring_words::Duration;
use encoring_words::word::DATA_MAX;

use crate::episode::Episode;
use crate::labels;
use crate::sample::{Sample, Sighting};
use crate::window::ROWS;

/// Encoders that are drawn.
const ENCODERS_MAX: usize = 8;
/// Marks of an encoder, and those of them that have a close-up.
const MARKS_MAX: usize = 40;
const CLOSEUPS_MAX: usize = 24;
/// Rows before and behind a jump, and those of a stretch that are looked at.
const BESIDE: usize = 24;
const STRETCH_MAX: usize = 72;
/// Rows over which the speed is taken.
const SPEED_ROWS: usize = 4;

const NANOS_PER_S: i128 = 1_000_000_000;

/// The positions and speeds of the encoders of a recording, as a picture.
///
/// Each row goes to [`Picture::sample`]; what the detector has told so far of its encoder goes to [`Picture::look`], so that the
/// rows around a jump are kept while they are there.
#[derive(Clone, Debug, Default)]
pub struct Picture {
    strips: BTreeMap<u8, Strip>,
    left_out: bool,
}

/// What is kept of an encoder.
#[derive(Clone, Debug, Default)]
struct Strip {
    positions: Envelope,
    speeds: Envelope,
    /// The last rows, with their lines.
    recent: VecDeque<(u64, PlotSample)>,
    /// How many episodes have been looked at.
    looked_at: usize,
    /// The rows around some of them, by the line where they begin.
    kept: BTreeMap<u64, Vec<PlotSample>>,
}

impl Picture {
    /// Takes the next row.
    pub fn sample(&mut self, sample: &Sample) {
        let value = match sample.reading {
            Sighting::Word(word) => i64::from(word & DATA_MAX),
            Sighting::Bits24(bits) => i64::from(bits),
            Sighting::Bits16(half) => i64::from(half),
            Sighting::Steps(steps) => steps,
            Sighting::Nothing | Sighting::Unreached { .. } => return,
        };
        if self.strips.len() >= ENCODERS_MAX && !self.strips.contains_key(&sample.position) {
            self.left_out = true;
            return;
        }
        let strip = self.strips.entry(sample.position).or_default();
        strip.add(sample.line, PlotSample { time_ns: sample.time_ns, value });
    }

    /// Keeps the rows around what has been told of an encoder since the last look.
    pub fn look(&mut self, position: u8, told: &[Episode]) {
        if let Some(strip) = self.strips.get_mut(&position).filter(|strip| strip.looked_at < told.len()) {
            told.iter().skip(strip.looked_at).for_each(|episode| strip.keep(episode));
            strip.looked_at = told.len();
        }
    }

    /// All texts that its charts may have beside the name, with their codes and values.
    #[must_use]
    pub fn labels(&self, name: &str, episodes: &[Episode]) -> Vec<Said> {
        let always = [labels::positions(), labels::speeds(), labels::speeds_cut(), labels::undrawn()];
        let of_encoder = |position: &u8| {
            let marks = episodes.iter().filter(|episode| episode.position == *position).count();
            [labels::one_of_several(name, *position), labels::unmarked(marks.saturating_sub(MARKS_MAX))]
        };
        let of_episode = |episode: &Episode| [event_at(episode), event(episode)];
        let encoders = self.strips.keys().flat_map(of_encoder);
        always.into_iter().chain(encoders).chain(episodes.iter().flat_map(of_episode)).collect()
    }

    /// A chart for each encoder, in which the episodes are numbered from `first`; at most eight encoders are drawn.
    #[must_use]
    pub fn charts(mut self, name: &str, first: usize, episodes: &[Episode]) -> Vec<Chart> {
        let several = self.strips.len() > 1;
        let left_out = self.left_out;
        let chart = |(position, strip): (&u8, &mut Strip)| {
            let title =
                if several { labels::one_of_several(name, *position).to_string() } else { name.to_owned() };
            let numbered = (first..).zip(episodes);
            let mine = numbered.filter(|(_, episode)| episode.position == *position);
            let mut chart = strip.chart(&title, mine);
            if left_out {
                chart.remark(labels::undrawn().text());
            }
            chart
        };
        self.strips.iter_mut().map(chart).collect()
    }
}

fn event(episode: &Episode) -> Said {
    labels::event(episode.cause, episode.certainty)
}

fn event_at(episode: &Episode) -> Said {
    labels::event_at(episode.line, Duration(episode.time_ns), episode.cause, episode.certainty)
}

impl Strip {
    fn add(&mut self, line: u64, sample: PlotSample) {
        self.positions.add(sample);
        if let Some((_, before)) =
            self.recent.len().checked_sub(SPEED_ROWS).and_then(|at| self.recent.get(at))
        {
            let passed = i128::from(sample.time_ns) - i128::from(before.time_ns);
            let way = i128::from(sample.value) - i128::from(before.value);
            if let Some(speed) = (way * NANOS_PER_S).checked_div(passed.max(0)) {
                let value = i64::try_from(speed).unwrap_or(if speed < 0 { i64::MIN } else { i64::MAX });
                self.speeds.add(PlotSample { time_ns: sample.time_ns, value });
            }
        }
        // What the detector may still tell of lies among these.
        if self.recent.len() >= 2 * ROWS {
            self.recent.pop_front();
        }
        self.recent.push_back((line, sample));
    }

    fn keep(&mut self, episode: &Episode) {
        if self.kept.len() >= CLOSEUPS_MAX || self.kept.contains_key(&episode.line) {
            return;
        }
        let begins = self.recent.partition_point(|(line, _)| *line < episode.line);
        let ends = self.recent.partition_point(|(line, _)| *line <= episode.to_line);
        if begins == ends {
            return;
        }
        let from = begins.saturating_sub(BESIDE);
        let to = ends.min(begins + STRETCH_MAX).saturating_add(BESIDE).min(self.recent.len());
        let rows = self.recent.range(from..to).map(|(_, sample)| *sample);
        self.kept.insert(episode.line, rows.collect());
    }

    fn chart<'a>(&mut self, title: &str, episodes: impl Iterator<Item = (usize, &'a Episode)>) -> Chart {
        let mut chart = Chart::new(title);
        chart.curve(labels::positions().text(), self.positions.clone());
        let (whole, cut) = (labels::speeds(), labels::speeds_cut());
        chart.curve_without_peaks(whole.text(), cut.text(), self.speeds.clone());
        let mut beyond = 0;
        for (place, (number, episode)) in episodes.enumerate() {
            if place >= MARKS_MAX {
                beyond += 1;
                continue;
            }
            // What the detector tells at the end is among the last rows, or is about so many that no close look helps.
            self.keep(episode);
            let stretch = (episode.time_ns, self.until(episode));
            chart.mark(number, stretch, event_at(episode).text());
            if let Some(samples) = self.kept.remove(&episode.line) {
                chart.closeup(Closeup { number, title: event(episode).to_string(), samples, stretch });
            }
        }
        if beyond > 0 {
            chart.remark(labels::unmarked(beyond).text());
        }
        chart
    }

    /// When a stretch ended, as far as its rows are still there.
    fn until(&self, episode: &Episode) -> u64 {
        let ends = self.recent.partition_point(|(line, _)| *line <= episode.to_line);
        let last = self.recent.get(ends.saturating_sub(1)).map(|(_, sample)| sample.time_ns);
        let kept = || self.kept.get(&episode.line)?.iter().rev().nth(BESIDE).map(|sample| sample.time_ns);
        last.filter(|last| *last >= episode.time_ns).or_else(kept).unwrap_or(episode.time_ns)
    }
}
