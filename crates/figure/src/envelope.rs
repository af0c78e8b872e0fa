//! Samples over any span of time, in bounded memory.

use crate::plot::PlotSample;

/// How many buckets there are at most.
const BUCKETS: usize = 4_096;

/// The samples of a bucket.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Bucket {
    /// Its number, counted from time 0 in its width.
    number: u64,
    pub(crate) first: i64,
    pub(crate) least: i64,
    pub(crate) most: i64,
    pub(crate) last: i64,
}

/// The first, least, most and last of the samples in each of some thousand equal spans of time. When there are too many
/// spans, two become one: memory is the same for any number of samples, and no peak is lost.
///
/// Samples come in the order of time; one that lies before the last counts as that of the last.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Envelope {
    /// A bucket lasts 2^`doublings` nanoseconds.
    doublings: u32,
    buckets: Vec<Bucket>,
    ends: Option<(u64, u64)>,
}

impl Envelope {
    /// One without samples.
    #[must_use]
    pub const fn new() -> Self {
        Self { doublings: 0, buckets: Vec::new(), ends: None }
    }

    /// Adds a sample.
    pub fn add(&mut self, sample: PlotSample) {
        let PlotSample { time_ns, value } = sample;
        let (from, to) = self.ends.unwrap_or((time_ns, time_ns));
        let time_ns = time_ns.max(to);
        self.ends = Some((from, time_ns));
        let number = time_ns >> self.doublings;
        match self.buckets.last_mut().filter(|last| last.number >= number) {
            Some(last) => last.join(&Bucket { number, first: value, least: value, most: value, last: value }),
            None => {
                self.buckets.push(Bucket { number, first: value, least: value, most: value, last: value });
                while self.buckets.len() > BUCKETS {
                    self.halve();
                }
            }
        }
    }

    /// When the first and the last sample were.
    #[must_use]
    pub const fn ends(&self) -> Option<(u64, u64)> {
        self.ends
    }

    /// The buckets that lie between two times at least in part, each with its middle.
    pub(crate) fn between(&self, from: u64, to: u64) -> impl Iterator<Item = (u64, &Bucket)> {
        let (first, last) = (from >> self.doublings, to >> self.doublings);
        let begins = self.buckets.partition_point(|bucket| bucket.number < first);
        let within = self.buckets.get(begins..).unwrap_or_default();
        let half = (1_u64 << self.doublings) / 2;
        within.iter().take_while(move |bucket| bucket.number <= last).map(move |bucket| {
            ((bucket.number << self.doublings).saturating_add(half).clamp(from, to.max(from)), bucket)
        })
    }

    fn halve(&mut self) {
        self.doublings = (self.doublings + 1).min(63);
        let mut joined: Vec<Bucket> = Vec::with_capacity(BUCKETS + 1);
        for bucket in &self.buckets {
            let bucket = Bucket { number: bucket.number / 2, ..*bucket };
            match joined.last_mut().filter(|last| last.number == bucket.number) {
                Some(last) => last.join(&bucket),
                None => joined.push(bucket),
            }
        }
        self.buckets = joined;
    }
}

impl Bucket {
    /// Takes in what came later.
    fn join(&mut self, later: &Self) {
        self.least = self.least.min(later.least);
        self.most = self.most.max(later.most);
        self.last = later.last;
    }
}
