//! A generator of PLC behaviour beside the referee: it shares nothing with the rules but their names.
//!
//! A program with a scan time runs against an encoder on a ring with a cycle time. Programs keep the handshake, or break
//! one rule once. What the referee sees is each write and each cycle, or the cycles only.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

use encoring_host::referee::{LineSeen, Observed, Referee, Vantage};
use encoring_host::{Outcome, Request, Session, Timing};
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter, Written};

/// Chance with a seed.
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    fn between(&mut self, low: u64, high: u64) -> u64 {
        low + self.below(high - low + 1)
    }
}

/// What a program does wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mistake {
    None,
    Torn,
    Together,
    Changed,
    Dropped,
    GaveUp,
    Kept,
    Hasty,
    NoCheck,
    Refused,
    Backwards,
    Again,
}

const MISTAKES: [(Mistake, &[&str]); 12] = [
    (Mistake::None, &[]),
    (Mistake::Torn, &["torn_words"]),
    (Mistake::Together, &["data_with_service_bit"]),
    (Mistake::Changed, &["data_changed_in_service"]),
    (Mistake::Dropped, &["dropped_before_acknowledgement"]),
    (Mistake::GaveUp, &["withdrawn"]),
    (Mistake::Kept, &["never_dropped"]),
    (Mistake::Hasty, &["next_before_end"]),
    (Mistake::NoCheck, &["no_data_check"]),
    (Mistake::Refused, &["unknown_service"]),
    (Mistake::Backwards, &["wrong_direction"]),
    (Mistake::Again, &["preset_repeated"]),
];

/// An encoder: it latches the word of the rise, and answers after its time.
struct Device {
    request: Option<(u32, u64)>,
    error: bool,
    slow_us: u64,
}

impl Device {
    /// A good cycle at `now` brings `out`; gives IN of the next.
    fn cycle(&mut self, now: u64, out: u32) -> u32 {
        if out >> 31 == 0 {
            self.request = None;
            return 0x64 | u32::from(self.error) << 29;
        }
        let (word, due) = *self.request.get_or_insert((out, now + self.slow_us));
        if now < due {
            return 0x64 | u32::from(self.error) << 29;
        }
        let (number, write) = (word >> 24 & 0xF, word >> 30 & 1 == 1);
        match (number, write) {
            (8, false) => {
                self.error = false;
                0x8800_0000
            }
            (6, false) | (8, true) | (7, _) => {
                self.error = true;
                0xA000_0000 | word & 0x4F00_0000 | if write { word & 0xFF_FFFF } else { 0 }
            }
            (_, true) => word | u32::from(self.error) << 29,
            (_, false) => word & 0x8F00_0000 | 0x270F | u32::from(self.error) << 29,
        }
    }
}

/// A program and its ring.
struct Plant {
    now: u64,
    next_cycle: u64,
    cycle_us: u64,
    scan_us: u64,
    out: u32,
    /// IN as the image shows it.
    input: u32,
    answer: u32,
    device: Device,
    referees: [Referee; 2],
}

impl Plant {
    fn new(chance: &mut Chance) -> Self {
        let model = Some(Model::Ce65M);
        Self {
            now: 0,
            next_cycle: 1_000,
            cycle_us: chance.between(460, 14_000),
            scan_us: chance.between(1_000, 100_000),
            out: 0,
            input: 0x64,
            answer: 0x64,
            device: Device { request: None, error: false, slow_us: chance.below(20_000) },
            referees: [Vantage::Writes, Vantage::Cycles].map(|vantage| Referee::new(vantage, model)),
        }
    }

    /// Lets the ring run until `until`.
    fn run(&mut self, until: u64) {
        while self.next_cycle <= until {
            self.now = self.next_cycle;
            // The ring brings what the encoder put out at the end of the cycle before.
            self.input = self.answer;
            let (out, input) = (OutWord(self.out), Some(InWord(self.input)));
            let seen = Observed::Cycle { at: Instant(self.now * 1_000), out, input, line: LineSeen::Good };
            self.referees.iter_mut().for_each(|referee| referee.observe(seen));
            self.answer = self.device.cycle(self.now, self.out);
            self.next_cycle += self.cycle_us;
        }
        self.now = until;
    }

    fn wait(&mut self, time_us: u64) {
        self.run(self.now + time_us);
    }

    fn write(&mut self, written: Written) {
        self.out = OutWord(self.out).after(written).0;
        let seen = Observed::Write { at: Instant(self.now * 1_000), client: 1, written };
        self.referees[0].observe(seen);
    }

    fn put(&mut self, word: u32) {
        self.write(Written::Both(OutWord(word)));
    }

    /// A scan, and long enough for a cycle to be seen.
    fn scan(&mut self) {
        self.wait(self.scan_us.max(2 * self.cycle_us));
    }

    /// Scans until IN bit 31 is `bit` in the image.
    fn until(&mut self, bit: u32) {
        let mut scans = 0;
        loop {
            self.scan();
            scans += 1;
            if self.input >> 31 == bit || scans > 1_000 {
                break;
            }
        }
    }

    fn serve(&mut self, word: u32) {
        self.put(word & 0x7FFF_FFFF);
        self.scan();
        self.put(word);
        self.until(1);
        self.put(word & 0x7FFF_FFFF);
        self.until(0);
    }

    fn err(&mut self, chance: &mut Chance, mistake: Mistake) {
        let value = 0x100 + chance.below(0x2000) as u32;
        let word = 0xC600_0000 | value;
        let rest = word & 0x7FFF_FFFF;
        match mistake {
            Mistake::None => {}
            Mistake::Torn => {
                self.write(Written::High((word >> 16) as u16));
                self.wait(chance.below(self.cycle_us / 2));
                self.write(Written::Low(word as u16 ^ 1));
                self.until(1);
                self.put(rest);
                self.until(0);
            }
            Mistake::Together => {
                self.put(rest ^ 3);
                self.scan();
                self.put(word);
                self.until(1);
                self.put(rest);
                self.until(0);
            }
            Mistake::Changed => {
                self.device.slow_us = 200_000;
                self.put(rest);
                self.scan();
                self.put(word);
                self.wait(2 * self.cycle_us);
                self.put(word ^ 4);
                self.until(1);
                self.put(rest);
                self.until(0);
            }
            Mistake::Dropped | Mistake::GaveUp => {
                let late = mistake == Mistake::GaveUp;
                self.device.slow_us = 5_000_000;
                self.put(rest);
                self.scan();
                self.put(word);
                let stood =
                    if late { chance.between(1_050_000, 3_000_000) } else { chance.between(40_000, 900_000) };
                self.wait(stood);
                self.put(rest);
                self.scan();
            }
            Mistake::Kept => {
                self.put(rest);
                self.scan();
                self.put(word);
                self.until(1);
                self.wait(chance.between(11_000_000, 15_000_000));
                self.put(rest);
                self.until(0);
            }
            Mistake::Hasty => {
                self.put(rest);
                self.scan();
                self.put(word);
                self.until(1);
                // The next number stands there already: the bit falls and rises before the end is seen.
                self.put(0x0200_0000);
                let seen = self.next_cycle + 1;
                self.run(seen);
                self.put(0x8200_0000);
                self.until(1);
                self.put(0);
                self.until(0);
            }
            Mistake::NoCheck => {
                self.serve(0xC200_0000 | value);
                self.wait(chance.between(10_500_000, 12_000_000));
            }
            Mistake::Refused | Mistake::Backwards => {
                let refused = if mistake == Mistake::Refused { 0x8700_0000 } else { 0x8600_0000 };
                self.serve(refused);
                self.serve(0x8800_0000);
            }
            Mistake::Again => {
                self.serve(word);
                self.serve(word);
            }
        }
    }
}

fn names(referee: &Referee) -> Vec<&'static str> {
    referee.findings().map(|finding| finding.rule.name()).collect()
}

// [R30, R33, R38, R39, R40]
#[test]
fn each_mistake_of_a_generated_program_is_named_and_nothing_else() {
    let mut asked = 0;
    for seed in 0..2_400_u64 {
        let mut chance = Chance(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1);
        let (mistake, wanted) = MISTAKES[seed as usize % MISTAKES.len()];
        let mut plant = Plant::new(&mut chance);
        // A scan below a tenth of a second keeps 08 within its second.
        plant.wait(chance.between(20_000, 500_000));
        plant.serve(0x8200_0000);
        plant.serve(0xC300_0000 | chance.between(1, 0xFFFF) as u32);
        plant.serve(0x8800_0000);
        plant.err(&mut chance, mistake);
        plant.wait(20_000);
        let cycles_show_it = !matches!(mistake, Mistake::Torn);
        for (k, referee) in plant.referees.iter_mut().enumerate() {
            referee.finish();
            let told =
                format!("seed {seed}, {mistake:?}, cycle {} us, scan {} us", plant.cycle_us, plant.scan_us);
            if k == 0 || cycles_show_it {
                assert_eq!(names(referee), wanted, "{told}, {:?}", referee.vantage());
            } else {
                // What cycles show of a torn word is another mistake, or none.
                let others = ["data_with_service_bit", "data_changed_in_service"];
                assert!(
                    names(referee).iter().all(|name| others.contains(name)),
                    "{told}: {:?}",
                    names(referee)
                );
            }
            assert_eq!(referee.flaws(), Default::default(), "{told}");
            asked += referee.services();
        }
    }
    assert!(asked > 10_000, "{asked}");
}

// [R30..R41]
#[test]
fn our_own_session_breaks_no_rule() {
    let requests = [
        Request::write(Model::Ce65M, Parameter::MeasuringLength, 9_999).unwrap(),
        Request::write(Model::Ce65M, Parameter::Numerator, 10).unwrap(),
        Request::data_check(),
        Request::read(Model::Ce65M, Parameter::MeasuringLength).unwrap(),
        Request::preset(Model::Ce65M, 5, 9_999).unwrap(),
    ];
    for seed in 0..200 {
        let mut chance = Chance(seed);
        let mut plant = Plant::new(&mut chance);
        let timing = Timing { settle: Duration::from_micros(2 * plant.cycle_us), ..Timing::DIRECT };
        let mut session = Session::new(timing, OutWord(0));
        plant.wait(5 * plant.cycle_us);
        for request in requests {
            let at = Instant(plant.now * 1_000);
            let first = session.start(at, request).unwrap();
            plant.put(first.0);
            let outcome = loop {
                plant.wait(plant.cycle_us + chance.below(3_000));
                let seen = encoring_host::Seen { input: InWord(plant.input), age: Duration::ZERO };
                let (out, outcome) = session.cycle(Instant(plant.now * 1_000), Some(seen));
                if out.0 != plant.out {
                    plant.put(out.0);
                }
                if let Some(outcome) = outcome {
                    break outcome;
                }
            };
            assert!(matches!(outcome, Outcome::Done { .. }), "seed {seed}: {outcome:?}");
        }
        for referee in &mut plant.referees {
            referee.finish();
            assert_eq!(names(referee), [""; 0], "seed {seed}, {:?}", referee.vantage());
            assert_eq!(referee.services(), 5);
        }
    }
}
