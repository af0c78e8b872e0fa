//! What the master of a ring sees of a cycle, and what clients wrote before it.

use encoring_bus::SharedImage;
use encoring_bus::image::ClientWrite;
use encoring_ring::{ProcessImage, Verdict};
use encoring_trace::bus::{BusEvent, BusRow};
use encoring_trace::{CycleSeen, Input};
use encoring_words::{InWord, Instant, OutWord};

/// A cycle as the master's image shows it, with the writes before it. Used again for the next one.
#[derive(Debug, Default)]
pub(crate) struct BusSeen {
    /// The end of the cycle before: that is also the time of the writes.
    pub(crate) began: Instant,
    /// The end of the cycle.
    pub(crate) ended: Instant,
    pub(crate) line: Option<CycleSeen>,
    pub(crate) writes: Vec<ClientWrite>,
    /// Writes that were too many to be kept, after those that were.
    pub(crate) lost: u64,
    /// What went out, by position.
    pub(crate) out: Vec<OutWord>,
    /// What the image shows then.
    pub(crate) input: Vec<InWord>,
}

impl BusSeen {
    /// Runs a cycle on the image, and keeps what was seen of it if the image keeps writes.
    pub(crate) fn cycle<R>(&mut self, image: &SharedImage, run: impl FnOnce(&mut ProcessImage) -> R) -> R {
        image.with_writes(|image, writes| {
            let Some(writes) = writes else { return run(image) };
            self.lost = writes.take(&mut self.writes);
            self.out.clear();
            self.out.extend(image.out());
            let result = run(image);
            self.input.clear();
            self.input.extend(image.input());
            // Services that the ring's thread carries out itself.
            writes.note_changes(&self.out, image.out());
            result
        })
    }

    /// Says when the cycle was and how it went. A slot without data is silent for the encoders.
    pub(crate) fn went(&mut self, began: Instant, ended: Instant, data: Option<Verdict>) {
        (self.began, self.ended) = (began, ended);
        self.line = Some(match data {
            Some(Verdict::Good) => CycleSeen::Good,
            Some(Verdict::Bad { .. }) => CycleSeen::Bad,
            Some(Verdict::Silent { .. }) | None => CycleSeen::Silent,
        });
    }

    /// The rows of the writes, then one for each encoder.
    pub(crate) fn rows(&self) -> impl Iterator<Item = BusRow> {
        let row = |time: Instant, position: usize, event| {
            // A ring has at most 128.
            let position = u8::try_from(position).ok()?;
            Some(BusRow { line: 0, time_ns: time.as_nanos(), position, event })
        };
        let writes = self.writes.iter().filter_map(move |&ClientWrite { client, position, written }| {
            row(self.began, position, BusEvent::Write { client, written })
        });
        let cycles =
            self.out.iter().zip(&self.input).enumerate().filter_map(move |(position, (out, input))| {
                // Of a cycle that was not good nothing came into the image.
                let input = (self.line == Some(CycleSeen::Good)).then_some(Input::Word(input.0));
                row(self.ended, position, BusEvent::Cycle { out: out.0, input, line: self.line })
            });
        writes.chain(cycles)
    }
}
