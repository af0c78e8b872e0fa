//! What a command of the master's side tells, compared with the encoder itself.

use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_bus::release::{Release, ReleaseError};
use encoring_bus::{Behind, Bus, BusError, EncoderMaster, MasterError};
use encoring_host::preset::{Done, Preset};
use encoring_host::program::{Back, Prepared, Program, Report, Stopped};
use encoring_host::request::Request;
use encoring_host::service::{self, Services};
use encoring_host::session::{Fate, GivenUp, TimedOut};
use encoring_host::{Outcome, service::Failure};
use encoring_station::view::DeviceView;
use encoring_words::{Duration, Model, OutWord, Parameter};

const MODEL: Model = Model::Ce65M;
/// The reply of a read stands while it does.
const LEFT: OutWord = OutWord(0x8200_0000);
/// Nothing is to be released; with its halves exchanged it has the service bit.
const AT_REST: OutWord = OutWord(0x0200_9388);

/// A simulated ring behind a gateway whose faults can be switched on, with one CE-65-M that turns.
pub(crate) trait Ringed: Bus {
    /// When and how it fails.
    type Faults: Debug + Clone;

    /// From here on it fails so; requests are counted from now.
    fn arm(&mut self, faults: &Self::Faults);

    /// So many requests since.
    fn requests(&self) -> u32;

    /// So many of the faults were met since.
    fn met(&self) -> u32;

    /// The encoder and its OUT word when nothing is on its way any more. No fault is left afterwards.
    fn truth(&mut self) -> DeviceView;

    /// How long a step is waited for.
    fn patience(&self) -> Duration;
}

/// A command of the master's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    Read,
    Check,
    Write,
    Program,
    Preset,
    /// A service bit stands on OUT.
    Release,
    /// None does.
    NeedlessRelease,
}

/// What became of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Done,
    Failed,
}

/// A command that has ended, and what it told that is not so.
#[derive(Debug)]
pub(crate) struct Ended {
    pub(crate) end: End,
    pub(crate) requests: u32,
    pub(crate) met: u32,
    pub(crate) wrong: Vec<String>,
}

/// What a user was told.
#[derive(Default)]
struct Told {
    /// Words with a service bit that may stand, or were found standing.
    service_bits: Vec<OutWord>,
    wrong: Vec<String>,
}

impl Told {
    fn wrong(&mut self, what: impl Debug) {
        self.wrong.push(format!("{what:?}"));
    }

    /// No other master is at work, the ring runs, and the encoder is there.
    fn error(&mut self, error: MasterError) {
        match error {
            MasterError::OtherMaster { out } => self.service_bits.push(out),
            MasterError::Bus(
                BusError::NoEncoder { .. } | BusError::NotShown { .. } | BusError::NotAnEncoder { .. },
            )
            | MasterError::Overwritten { .. }
            | MasterError::InService { .. }
            | MasterError::Stale { .. } => self.wrong(error),
            // Every write is carried out as it came.
            MasterError::NotPrepared { behind, .. } if !matches!(behind, Behind::Bus(_)) => {
                self.wrong(behind);
            }
            MasterError::Bus(_)
            | MasterError::NotPrepared { .. }
            | MasterError::Misread { .. }
            | MasterError::Interrupted => {}
        }
    }

    /// What is told of a request: the encoder refuses none, and no error is pending.
    fn failure(&mut self, failure: Failure<MasterError>) -> Option<Fate> {
        match failure {
            Failure::TimedOut { timed_out: TimedOut { fate, .. }, .. }
            | Failure::GivenUp { given_up: GivenUp { fate, .. }, .. } => Some(fate),
            Failure::Bus(error) => {
                self.error(error);
                Some(Fate::NotSent)
            }
            Failure::NotActive { .. } => Some(Fate::NotSent),
            Failure::Request(_)
            | Failure::Refused(_)
            | Failure::ErrorPending { .. }
            | Failure::Unreadable { .. } => {
                self.wrong(failure);
                None
            }
        }
    }
}

/// What the encoder holds and works with.
fn values(device: &DeviceView, parameter: Parameter) -> (u32, u32) {
    let number = parameter.service().number();
    let row = device.parameters.iter().find(|row| row.service == number).unwrap();
    (row.programmed, row.active)
}

/// Runs a command against faults, and compares.
pub(crate) fn run<B: Ringed>(bus: &mut B, command: Command, faults: &B::Faults) -> Ended {
    command.prepare(bus);
    let before = bus.truth();
    bus.arm(faults);
    let mut told = Told::default();
    let judged = command.carry_out(bus, &mut told);
    let (requests, met) = (bus.requests(), bus.met());
    let after = bus.truth();
    let end = judged(&before, &after, &mut told);
    // With two writes on their way nobody knows which of them stands; that one may is told.
    if after.out.service_bit() && command != Command::Release && told.service_bits.is_empty() {
        told.wrong(format!("the service bit of {} was not told", after.out));
    }
    Ended { end, requests, met, wrong: told.wrong }
}

/// Compares what was told with the encoder before and after.
type Judge = Box<dyn FnOnce(&DeviceView, &DeviceView, &mut Told) -> End>;

impl Command {
    /// What it finds.
    fn prepare<B: Ringed>(self, bus: &mut B) {
        match self {
            Self::Check => {
                // Something to make count, so that a data check can be seen.
                let request = Request::write(MODEL, Parameter::MeasuringLength, 9_999).unwrap();
                let patience = bus.patience();
                at_last(|| {
                    let mut master = EncoderMaster::new(bus, 0, patience, Arc::default()).ok()?;
                    matches!(master.serve(request), Ok(Outcome::Done { .. })).then_some(())
                });
            }
            Self::Release => stand(bus, LEFT),
            Self::NeedlessRelease => stand(bus, AT_REST),
            Self::Read | Self::Write | Self::Program | Self::Preset => {}
        }
    }

    fn carry_out<B: Ringed>(self, bus: &mut B, told: &mut Told) -> Judge {
        match self {
            Self::Read => read(bus, told),
            Self::Check => check(bus, told),
            Self::Write => program(bus, told, &[(Parameter::MeasuringLength, 9_999)]),
            Self::Program => {
                program(bus, told, &[(Parameter::MeasuringLength, 9_999), (Parameter::Numerator, 10)])
            }
            Self::Preset => preset(bus, told),
            Self::Release | Self::NeedlessRelease => release(bus, told),
        }
    }
}

/// Does what no fault hinders; over a real line it may be late all the same.
fn at_last<T>(mut work: impl FnMut() -> Option<T>) -> T {
    (0..100).find_map(|_| work()).unwrap()
}

fn stand<B: Ringed>(bus: &mut B, out: OutWord) {
    at_last(|| bus.cycle(Some((0, out)), 0, &mut []).ok());
    bus.wait(Duration::from_millis(50));
}

/// Lets a master work as a command does. `None` if it could not even begin.
fn serve<B: Ringed, T>(
    bus: &mut B,
    told: &mut Told,
    work: impl FnOnce(&mut EncoderMaster<'_, B>) -> T,
) -> Option<T> {
    let patience = bus.patience();
    match EncoderMaster::new(bus, 0, patience, Arc::default()) {
        Ok(mut master) => {
            let worked = work(&mut master);
            told.service_bits.extend(master.withdraw());
            Some(worked)
        }
        Err(error) => {
            told.error(error);
            None
        }
    }
}

fn read<B: Ringed>(bus: &mut B, told: &mut Told) -> Judge {
    let result = serve(bus, told, |master| service::read(master, MODEL, Parameter::MeasuringLength));
    Box::new(move |_, after, told| match result {
        Some(Ok(read)) if read.error_before || read.value != values(after, Parameter::MeasuringLength).0 => {
            told.wrong(read);
            End::Done
        }
        Some(Ok(_)) => End::Done,
        Some(Err(failure)) => {
            told.failure(failure);
            End::Failed
        }
        None => End::Failed,
    })
}

fn check<B: Ringed>(bus: &mut B, told: &mut Told) -> Judge {
    let result = serve(bus, told, |master| service::check(master));
    Box::new(move |before, after, told| {
        let was_run = |device: &DeviceView| {
            let (programmed, active) = values(device, Parameter::MeasuringLength);
            programmed == active
        };
        assert!(!was_run(before), "a data check would be seen");
        let fate = match &result {
            Some(Ok(check)) if !check.is_good() => {
                told.wrong(check);
                None
            }
            Some(Ok(_)) => Some(true),
            Some(Err(failure)) => told.failure(failure.clone()).and_then(known),
            None => Some(false),
        };
        if fate.is_some_and(|run| run != was_run(after)) {
            told.wrong((&result, "but the encoder has done the other"));
        }
        if matches!(result, Some(Ok(_))) { End::Done } else { End::Failed }
    })
}

/// Whether a request was carried out, if that is said.
fn known(fate: Fate) -> Option<bool> {
    match fate {
        Fate::NotSent => Some(false),
        Fate::CarriedOut(_) => Some(true),
        Fate::Unknown => None,
    }
}

fn program<B: Ringed>(bus: &mut B, told: &mut Told, wanted: &[(Parameter, u32)]) -> Judge {
    let mut program = Program::new(MODEL, None);
    for (parameter, value) in wanted {
        program.set(*parameter, *value).unwrap();
    }
    let Some(prepared): Option<Prepared<MasterError>> = serve(bus, told, |master| program.prepare(master))
    else {
        return Box::new(|_, _, _| End::Failed);
    };
    let report = serve(bus, told, |master| prepared.run(master));
    Box::new(move |before, after, told| match report {
        Some(report) => judge_report(&report, before, after, told),
        None => End::Failed,
    })
}

fn judge_report(
    report: &Report<MasterError>,
    before: &DeviceView,
    after: &DeviceView,
    told: &mut Told,
) -> End {
    for row in report.rows.iter().flatten() {
        let ((was, worked), (programmed, active)) =
            (values(before, row.parameter), values(after, row.parameter));
        let wrong = row.before.is_some_and(|before| before != was)
            || row.now.is_some_and(|now| now != programmed)
            || match report.back {
                Back::NothingWritten => (was, worked) != (programmed, active),
                Back::NotNeeded => row.wanted.unwrap_or(was) != programmed || programmed != active,
                Back::Restored => was != programmed || programmed != active,
                Back::Failed => false,
            };
        if wrong {
            told.wrong((report.back, &report.result, row, "but the encoder holds", programmed, active));
        }
    }
    match report.result.clone() {
        Ok(()) => return End::Done,
        Err(Stopped::Service(failure)) => {
            told.failure(failure);
        }
        // The values are sound, and the encoder keeps them.
        Err(stopped) => told.wrong(stopped),
    }
    End::Failed
}

fn preset<B: Ringed>(bus: &mut B, told: &mut Told) -> Judge {
    let result = match serve(bus, told, |master| Preset::prepare(master, MODEL, 1_234)) {
        Some(Ok(preset)) => serve(bus, told, |master| preset.adjust(master).result),
        Some(Err(failure)) => Some(Err(failure)),
        None => None,
    };
    Box::new(move |before, after, told| {
        let made = after.memory_writes.offset - before.memory_writes.offset;
        let fate = match &result {
            None => Some(false),
            Some(Ok(_)) => Some(true),
            Some(Err(failure)) => told.failure(failure.clone()).and_then(known),
        };
        if made > 1 || fate.is_some_and(|fate| u32::from(fate) != made) {
            told.wrong((&result, "but the zero was set", made));
        }
        if result == Some(Ok(Done::Confirmed)) { End::Done } else { End::Failed }
    })
}

fn release<B: Ringed>(bus: &mut B, told: &mut Told) -> Judge {
    let (stop, patience) = (AtomicBool::new(false), bus.patience());
    let mut release = Release::new(bus, 0, patience, &stop);
    let result = release.look().and_then(|was| {
        if !was.out.service_bit() {
            return Ok(None);
        }
        release.watch(was)?;
        release.clear(was).map(Some)
    });
    if let Err(error @ (ReleaseError::InUse { .. } | ReleaseError::Interrupted)) = &result {
        told.wrong(error);
    }
    Box::new(move |before, after, told| {
        let cleared = OutWord(before.out.0 & 0x7FFF_FFFF);
        let wrong = match &result {
            Ok(None) => before.out.service_bit() || after.out != before.out,
            Ok(Some(now)) => !before.out.service_bit() || after.out != cleared || now.out != cleared,
            Err(ReleaseError::Stays { .. }) => !after.out.service_bit(),
            Err(_) => after.out != before.out && after.out != cleared,
        };
        if wrong {
            told.wrong((&result, "but OUT was and is", before.out, after.out));
        }
        if result.is_ok() { End::Done } else { End::Failed }
    })
}
