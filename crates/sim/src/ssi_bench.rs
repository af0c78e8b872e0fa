//! A CE-65-M on a bench: its SSI captured as a logic analyser sees it, and clocked at one rate after the other.
//!
//! The reader is that of the world ([`crate::ssi`]); here is only who looks on.

use std::io;

use encoring_host::ssi_receiver::{SsiFault, TakenAt};
use encoring_ring::TooManyEncoders;
use encoring_ring::master::State;
use encoring_words::parameter::SsiValues;
use encoring_words::ssi_frame::Level;
use encoring_words::{Duration, InWord, OutWord, Parameter};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use crate::fault::{PER_MILLION, SsiTrouble};
use crate::ssi::{Seen, SsiSettings};
use crate::{Scenario, World, scenario};

/// How a capture is made.
#[derive(Clone, Copy, Debug)]
pub struct BenchCapture {
    /// What service 0D programs before; `None` leaves what the encoder has.
    pub values: Option<SsiValues>,
    /// How long it goes on.
    pub lasting: Duration,
    /// Each edge is seen late by up to so much, by chance.
    pub jitter: Duration,
    /// Of a million changes so many are followed by a spike on one of the lines.
    pub spikes_per_million: u32,
}

/// How long a spike is at most.
const SPIKE_NS: u64 = 100;

/// Cycles within which an encoder answers a service.
const CYCLES_MAX: u32 = 1_000;

/// Why there is no capture.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The scenario has too many encoders.
    #[error(transparent)]
    TooMany(#[from] TooManyEncoders),
    /// The encoder did not take its SSI values.
    #[error("the encoder at position {position} did not take the SSI values: {seen} came for {wanted}")]
    NotProgrammed {
        /// Its ring position.
        position: usize,
        /// The reply that was waited for.
        wanted: InWord,
        /// What came instead.
        seen: InWord,
    },
    /// Whoever is told could not go on.
    #[error(transparent)]
    Sink(#[from] io::Error),
}

/// A world with the words of its bus.
struct Bench {
    world: World,
    position: usize,
    out: Vec<OutWord>,
    input: Vec<InWord>,
}

impl Bench {
    fn new(scenario: &Scenario, position: usize) -> Result<Self, TooManyEncoders> {
        let world = World::new(scenario)?;
        let encoders = world.places().len();
        Ok(Self { world, position, out: vec![OutWord(0); encoders], input: vec![InWord(0); encoders] })
    }

    fn cycle(&mut self) {
        self.world.cycle(&self.out, &mut self.input);
    }

    fn seen(&self) -> InWord {
        self.input.get(self.position).copied().unwrap_or(InWord(0))
    }

    /// Requests a service and ends it.
    fn serve(&mut self, request: OutWord, wanted: InWord) -> Result<(), BenchError> {
        for (word, reply) in [(request, wanted), (OutWord(0), InWord(0))] {
            if let Some(out) = self.out.get_mut(self.position) {
                *out = word;
            }
            let is_answered = |seen: InWord| if word.0 == 0 { seen.0 >> 31 == 0 } else { seen == reply };
            let mut cycles = 0;
            while !is_answered(self.seen()) {
                self.cycle();
                cycles += 1;
                if cycles > CYCLES_MAX {
                    return Err(BenchError::NotProgrammed {
                        position: self.position,
                        wanted,
                        seen: self.seen(),
                    });
                }
            }
        }
        Ok(())
    }

    /// Programs service 0D and has it accepted, once the ring runs and the encoder has seen an end of services [D1].
    fn program(&mut self, values: SsiValues) -> Result<(), BenchError> {
        let mut cycles = 0;
        while self.world.ring().master().state() != State::Run && cycles < CYCLES_MAX {
            self.cycle();
            cycles += 1;
        }
        self.cycle();
        self.cycle();
        let service = u32::from(Parameter::SsiValues.service().number());
        let write = 0xC000_0000 | service << 24 | values.data();
        self.serve(OutWord(write), InWord(write))?;
        self.serve(OutWord(0x8800_0000), InWord(0x8800_0000))
    }
}

/// Tells the levels of Clock+ and Data+ at every change, in nanoseconds from the beginning of the capture, and gives its
/// end.
///
/// # Errors
/// [`BenchError`].
pub fn capture(
    scenario: &Scenario,
    position: usize,
    recording: &BenchCapture,
    mut each: impl FnMut(u64, Level, Level) -> io::Result<()>,
) -> Result<u64, BenchError> {
    let mut bench = Bench::new(scenario, position)?;
    if let Some(values) = recording.values {
        bench.program(values)?;
    }
    let begun = bench.world.now();
    bench.world.keep_ssi();
    let mut view = View::new(scenario.seed, recording);
    while bench.world.now().since(begun) < recording.lasting {
        bench.cycle();
        let seen: Vec<Seen> = bench.world.take_ssi(position).collect();
        for Seen { at, clock, data } in seen {
            view.change(at.since(begun).as_nanos(), (clock, data), &mut each)?;
        }
    }
    let end = bench.world.now().since(begun).as_nanos();
    view.end(end, &mut each)?;
    Ok(end)
}

/// What a logic analyser sees of the lines.
struct View {
    chance: Pcg64Mcg,
    jitter_ns: u64,
    spikes_per_million: u32,
    /// What is shown since when.
    shown: Option<(u64, (Level, Level))>,
}

type Each<'a> = &'a mut dyn FnMut(u64, Level, Level) -> io::Result<()>;

impl View {
    fn new(seed: u64, recording: &BenchCapture) -> Self {
        let BenchCapture { jitter, spikes_per_million, .. } = *recording;
        let chance = Pcg64Mcg::seed_from_u64(seed);
        Self { chance, jitter_ns: jitter.as_nanos(), spikes_per_million, shown: None }
    }

    fn change(&mut self, at: u64, levels: (Level, Level), each: Each<'_>) -> io::Result<()> {
        if self.shown.is_some_and(|(_, shown)| shown == levels) {
            return Ok(());
        }
        let late = if self.jitter_ns == 0 { 0 } else { self.chance.random_range(0..=self.jitter_ns) };
        let at = (at + late).max(self.shown.map_or(0, |(since, _)| since));
        self.spike(at, each)?;
        self.shown = Some((at, levels));
        each(at, levels.0, levels.1)
    }

    /// Perhaps a spike between the last change and the next.
    fn spike(&mut self, until: u64, each: Each<'_>) -> io::Result<()> {
        let Some((since, (clock, data))) = self.shown else { return Ok(()) };
        if self.spikes_per_million == 0 || self.chance.random_range(0..PER_MILLION) >= self.spikes_per_million
        {
            return Ok(());
        }
        let from = since + (until - since) / 4;
        let to = (from + SPIKE_NS).min(until);
        let other = |level| if level == Level::High { Level::Low } else { Level::High };
        let (noisy_clock, noisy_data) =
            if self.chance.random_range(0..2) == 0 { (other(clock), data) } else { (clock, other(data)) };
        each(from, noisy_clock, noisy_data)?;
        each(to, clock, data)
    }

    fn end(&mut self, at: u64, each: Each<'_>) -> io::Result<()> {
        self.spike(at.max(self.shown.map_or(0, |(since, _)| since)), each)
    }
}

/// What came at a clock rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SweepRow {
    /// The clock rate in hertz.
    pub hz: u32,
    /// Transfers that brought the position; also those that the receiver calls too fast.
    pub right: u32,
    /// Transfers that brought another one, without a fault that the receiver sees.
    pub wrong: u32,
    /// Transfers with a fault.
    pub faulty: u32,
    /// The last fault.
    pub fault: Option<SsiFault>,
}

/// How a sweep is clocked.
#[derive(Clone, Copy, Debug)]
pub struct Sweep {
    /// What service 0D programs.
    pub values: SsiValues,
    /// Clocks of a transfer.
    pub clocks: u32,
    /// The edge at which the receiver takes the data.
    pub taken_at: TakenAt,
    /// How much later the data come than the encoder puts them out, in nanoseconds.
    pub delay_ns: u32,
}

/// Transfers at each rate.
const TRANSFERS: u32 = 10;

/// Reads the encoder at a position, which must stand still, at a clock rate.
///
/// # Errors
/// [`BenchError`]; what is wrong with the rate or the clocks as [`BenchError::Sink`].
pub fn sweep(scenario: &Scenario, position: usize, sweep: &Sweep, hz: u32) -> Result<SweepRow, BenchError> {
    let refused = |problem| io::Error::new(io::ErrorKind::InvalidInput, problem);
    let least = Duration(u64::from(sweep.clocks) * 1_000_000_000_u64.div_ceil(u64::from(hz.max(1))));
    let every = least + Duration::from_millis(1);
    let settings = SsiSettings::new(hz, sweep.clocks, every, sweep.taken_at).map_err(refused)?;
    let mut bench = Bench::new(scenario, position)?;
    bench.program(sweep.values)?;
    let trouble = (sweep.delay_ns > 0).then_some(SsiTrouble::Skew(sweep.delay_ns));
    bench
        .world
        .change(position, &[scenario::Change::SsiTrouble(trouble), scenario::Change::Ssi(Some(settings))]);
    bench.cycle();
    let truth = bench.seen().0 & encoring_words::word::DATA_MAX;
    let mut row = SweepRow { hz, right: 0, wrong: 0, faulty: 0, fault: None };
    let mut count = 0;
    while count < u64::from(TRANSFERS) {
        bench.cycle();
        let Some(reader) = bench.world.places().get(position).and_then(crate::world::Place::ssi) else {
            break;
        };
        let (Some(read), true) = (reader.read(), reader.count() > count) else { continue };
        count = reader.count();
        row.fault = read.transfer.fault.or(row.fault);
        match read.transfer.fault {
            // A clock that is too fast is no reason for a wrong word.
            None | Some(SsiFault::ClockLimit) if read.transfer.reading() == Some(truth) => row.right += 1,
            None => row.wrong += 1,
            Some(_) => row.faulty += 1,
        }
    }
    Ok(row)
}
