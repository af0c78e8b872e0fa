//! The data cycle at word level: all words move at once, and a fault is a verdict on the cycle.
//!
//! There is no master that stops and searches. What the diagnostic registers show is what a master would have found
//! who was told the same verdicts: the place at once, and the end of the fault with the first good cycle.

use encoring_words::{InWord, Instant, OutWord};

use crate::diagnostics::{Counts, FaultPlace, status};
use crate::image::ENCODERS_MAX;
use crate::profile::{BUS_ACTIVE_FOR, RESET_AFTER, STOP_AFTER};
use crate::slave::Taken;

/// How a data cycle went. Segment k leads into the device at position k; the one after the last device leads back
/// to the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Every check word was right.
    Good,
    /// The first bad check word was on this segment: devices before it have taken their data, the others keep
    /// their old, the master takes none.
    Bad {
        /// 0..=encoders.
        segment: usize,
    },
    /// From this segment on the line is silent. The loopback word never comes home, so no check phase follows and
    /// no device takes anything.
    Silent {
        /// 0..=encoders.
        segment: usize,
    },
}

/// What each device has taken from the ring, and when it last heard of it.
#[derive(Clone, Debug)]
pub struct WordRing {
    devices: [Device; ENCODERS_MAX],
    /// End of the last cycle.
    ended: Instant,
    encoders: usize,
    /// How the last cycle went.
    verdict: Verdict,
    /// Faulty cycles in a row.
    faulty: u8,
    counts: Counts,
}

#[derive(Clone, Copy, Debug, Default)]
struct Device {
    taken: Taken,
    line: Line,
    /// End of the last data cycle that it took.
    cycled: Option<Instant>,
}

/// What a device's incoming segment carries. Status telegrams fill the pauses between cycles, so a line that is
/// not silent in a cycle has not been silent since the one before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Line {
    #[default]
    NeverHeard,
    Alive,
    SilentSince(Instant),
}

impl Default for WordRing {
    fn default() -> Self {
        Self {
            devices: [Device::default(); ENCODERS_MAX],
            ended: Instant::ZERO,
            encoders: 0,
            verdict: Verdict::Good,
            faulty: 0,
            counts: Counts::default(),
        }
    }
}

impl WordRing {
    /// Runs one data cycle that ends at `now`: `out` goes to the devices, `answers`, the IN words that they loaded
    /// when it started, to `input`. All three have one word a device; `None` is a device that has nothing to show
    /// since it was switched on, and leaves `input` as it is.
    ///
    /// A reply to the OUT word of this cycle is therefore seen by the master after the next one at the earliest.
    pub fn cycle(
        &mut self,
        now: Instant,
        out: &[OutWord],
        input: &mut [InWord],
        answers: &[Option<InWord>],
        verdict: Verdict,
    ) {
        let encoders = out.len();
        let (taking, hearing) = match verdict {
            Verdict::Good => (encoders, encoders),
            Verdict::Bad { segment } => (segment, encoders),
            Verdict::Silent { segment } => (0, segment),
        };
        for (position, (device, out)) in self.devices.iter_mut().zip(out).enumerate() {
            if position < hearing {
                // What it held before a reset does not come up again.
                if device.is_reset(now) {
                    device.taken = device.taken.reset();
                }
                device.line = Line::Alive;
            } else if device.line == Line::Alive {
                device.line = Line::SilentSince(self.ended);
            }
            if position < taking {
                device.taken.word = Some(*out);
                device.cycled = Some(now);
            }
        }
        if verdict == Verdict::Good {
            for (shown, answer) in input.iter_mut().zip(answers) {
                *shown = answer.unwrap_or(*shown);
            }
        }
        self.ended = now;
        self.encoders = encoders;
        self.note(verdict);
    }

    fn note(&mut self, verdict: Verdict) {
        self.verdict = verdict;
        match verdict {
            Verdict::Good => {
                self.counts.good();
                self.faulty = 0;
            }
            Verdict::Bad { segment } | Verdict::Silent { segment } => {
                // A bus that has stopped runs no data cycles.
                if self.faulty < STOP_AFTER {
                    self.counts.bad();
                }
                self.counts.located(segment);
                self.faulty = self.faulty.saturating_add(1);
            }
        }
    }

    /// The diagnostic status register of a master that was told how the cycles went. From the fifth faulty one in a row
    /// on [A12] it has stopped the bus, though here cycles go on.
    #[must_use]
    pub const fn status(&self) -> u16 {
        let state = if self.faulty >= STOP_AFTER {
            status::READY | status::DETECT | status::BUS
        } else {
            status::READY | status::ACTIVE | status::RUN
        };
        let result = if self.faulty > 0 { status::DC_RESULT } else { 0 };
        state | result | if self.counts.is_poor() { status::QUALITY } else { 0 }
    }

    /// The diagnostic parameter register of such a master. Where the ring is silent it would know only after a search.
    #[must_use]
    pub fn parameter(&self) -> u16 {
        let place = match self.verdict {
            Verdict::Bad { segment } => Some(FaultPlace::Segment(segment)),
            Verdict::Silent { segment: 0 } => Some(FaultPlace::Nowhere),
            Verdict::Silent { segment } => Some(FaultPlace::Break(segment)),
            Verdict::Good => None,
        };
        let is_known = self.faulty >= STOP_AFTER || !matches!(self.verdict, Verdict::Silent { .. });
        place.filter(|_| is_known).map_or(0, |place| place.parameter(self.encoders))
    }

    /// What was counted: data cycles for as long as such a master would run them, and every faulty cycle on the segment
    /// of its verdict.
    #[must_use]
    pub const fn counts(&self) -> &Counts {
        &self.counts
    }

    /// The OUT word that the device at `position` holds at `now`: the last one taken, 0 before the first and after
    /// 25 ms of silence.
    #[must_use]
    pub fn out_word(&self, position: usize, now: Instant) -> OutWord {
        self.taken(position, now).shown()
    }

    /// What the chip at `position` holds at `now`, and how often it was reset.
    #[must_use]
    pub fn taken(&self, position: usize, now: Instant) -> Taken {
        match self.devices.get(position) {
            Some(device) if device.is_reset(now) => device.taken.reset(),
            Some(device) => device.taken,
            None => Taken::default(),
        }
    }

    /// The lamp BA of the device at `position`: a data cycle was taken in the last 640 ms [R139].
    #[must_use]
    pub fn bus_active(&self, position: usize, now: Instant) -> bool {
        self.devices
            .get(position)
            .and_then(|device| device.cycled)
            .is_some_and(|at| now.since(at) <= BUS_ACTIVE_FOR)
    }

    /// The lamp RC of the device at `position`: its incoming bus is connected and not in reset [R139].
    #[must_use]
    pub fn incoming_connected(&self, position: usize, now: Instant) -> bool {
        self.devices.get(position).is_some_and(|device| !device.is_reset(now))
    }

    /// The reset input of the chip at `position` is held: it forgets what it took, and that there is a line.
    pub fn hold(&mut self, position: usize) {
        if let Some(device) = self.devices.get_mut(position) {
            *device = Device { taken: device.taken.reset(), ..Device::default() };
        }
    }

    /// A device that lost its supply has forgotten what it took.
    pub fn power_off(&mut self, position: usize) {
        if let Some(device) = self.devices.get_mut(position) {
            *device = Device::default();
        }
    }
}

impl Device {
    fn is_reset(&self, now: Instant) -> bool {
        match self.line {
            Line::NeverHeard => true,
            Line::Alive => false,
            Line::SilentSince(at) => now.since(at) > RESET_AFTER,
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use encoring_words::Duration;
    use std::vec::Vec;

    const MS: u64 = 1_000_000;

    struct Bench {
        ring: WordRing,
        out: Vec<OutWord>,
        input: Vec<InWord>,
        answers: Vec<Option<InWord>>,
    }

    impl Bench {
        fn of(encoders: u32) -> Self {
            Self {
                ring: WordRing::default(),
                out: (0..encoders).map(|k| OutWord(0x100 + k)).collect(),
                input: (0..encoders).map(|_| InWord(0)).collect(),
                answers: (0..encoders).map(|k| Some(InWord(0x200 + k))).collect(),
            }
        }

        fn cycle(&mut self, ms: u64, verdict: Verdict) {
            let Self { ring, out, input, answers } = self;
            ring.cycle(Instant(ms * MS), out, input, answers, verdict);
        }

        fn taken(&self, ms: u64) -> Vec<u32> {
            (0..self.out.len()).map(|k| self.ring.out_word(k, Instant(ms * MS)).0).collect()
        }
    }

    #[test]
    fn a_good_cycle_moves_every_word_once() {
        let mut bench = Bench::of(3);
        bench.cycle(1, Verdict::Good);
        assert_eq!(bench.taken(1), [0x100, 0x101, 0x102]);
        assert_eq!(bench.input, [InWord(0x200), InWord(0x201), InWord(0x202)]);
    }

    #[test]
    fn a_device_with_nothing_to_show_leaves_the_masters_word_alone() {
        let mut bench = Bench::of(2);
        bench.input[1] = InWord(9);
        bench.answers[1] = None;
        bench.cycle(1, Verdict::Good);
        assert_eq!(bench.input, [InWord(0x200), InWord(9)]);
        assert_eq!(bench.taken(1), [0x100, 0x101]);
    }

    #[test]
    fn after_a_bad_segment_devices_keep_their_old_word_and_the_master_takes_none() {
        for segment in 0..=3 {
            let mut bench = Bench::of(3);
            bench.cycle(1, Verdict::Bad { segment });
            let expected: Vec<u32> = (0..3).map(|k| if k < segment { 0x100 + k as u32 } else { 0 }).collect();
            assert_eq!(bench.taken(1), expected);
            assert_eq!(bench.input, [InWord(0); 3]);
        }
    }

    #[test]
    fn silence_resets_the_devices_behind_it_after_25_ms_and_the_others_never() {
        let mut bench = Bench::of(3);
        bench.cycle(0, Verdict::Good);
        bench.out.fill(OutWord(7));
        for ms in 1..=25 {
            bench.cycle(ms, Verdict::Silent { segment: 1 });
            assert_eq!(bench.taken(ms), [0x100, 0x101, 0x102]);
        }
        bench.cycle(26, Verdict::Silent { segment: 1 });
        assert_eq!(bench.taken(26), [0x100, 0, 0]);
        assert!(bench.ring.incoming_connected(0, Instant(26 * MS)));
        assert!(!bench.ring.incoming_connected(1, Instant(26 * MS)));
        // Back again: nothing of the time before the reset comes up.
        bench.cycle(27, Verdict::Bad { segment: 0 });
        assert_eq!(bench.taken(27), [0x100, 0, 0]);
        bench.cycle(28, Verdict::Good);
        assert_eq!(bench.taken(28), [7, 7, 7]);
    }

    #[test]
    fn the_diagnostic_registers_say_what_the_verdicts_say() {
        let mut bench = Bench::of(3);
        let mut said = |ms, verdict| {
            bench.cycle(ms, verdict);
            (bench.ring.status(), bench.ring.parameter())
        };
        assert_eq!(said(1, Verdict::Good), (0x00E0, 0));
        assert_eq!(said(2, Verdict::Bad { segment: 2 }), (0x10E0, 0x0300));
        assert_eq!(said(3, Verdict::Good), (0x00E0, 0));
        for ms in 4..8 {
            assert_eq!(said(ms, Verdict::Silent { segment: 1 }), (0x10E0, 0), "a search would tell");
        }
        assert_eq!(said(8, Verdict::Silent { segment: 1 }), (0x1094, 0x0180));
        assert_eq!(said(9, Verdict::Bad { segment: 3 }), (0x1094, 0x0380));
        assert_eq!(said(10, Verdict::Silent { segment: 0 }), (0x1094, 0x0BE1));
        assert_eq!(said(11, Verdict::Good), (0x00E0, 0));
        let counts = bench.ring.counts();
        assert_eq!((counts.cycles, counts.faulty), (9, 6));
        assert!(counts.segments().take(5).eq([1, 5, 1, 1, 0]));
    }

    #[test]
    fn long_pauses_between_cycles_are_filled_with_status_telegrams() {
        let mut bench = Bench::of(1);
        bench.cycle(0, Verdict::Good);
        bench.cycle(600, Verdict::Bad { segment: 0 });
        assert_eq!(bench.taken(600), [0x100]);
    }

    // [R139]
    #[test]
    fn the_lamp_ba_goes_off_640_ms_after_the_last_data_cycle() {
        let mut bench = Bench::of(1);
        assert!(!bench.ring.bus_active(0, Instant(0)));
        bench.cycle(0, Verdict::Good);
        bench.cycle(600, Verdict::Bad { segment: 0 });
        assert!(bench.ring.bus_active(0, Instant(640 * MS)));
        assert!(!bench.ring.bus_active(0, Instant(640 * MS) + Duration::from_nanos(1)));
    }
}
