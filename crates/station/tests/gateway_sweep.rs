//! Every request of every command meets every way in which a gateway fails, in virtual time, and what is told is
//! compared with the encoder itself: no success, no claim and no service bit that is not so.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_bus::misread::Misread;
use encoring_bus::{Answered, Bus, BusError, Cause, Cycle, EncoderMaster, Settling};
use encoring_encoder::records::{Record, write_count};
use encoring_host::preset::{Done, Preset};
use encoring_host::program::{Back, Program};
use encoring_host::service::{Failure, check, read};
use encoring_host::session::Fate;
use encoring_sim::{Scenario, World};
use encoring_station::{Simulated, Speed};
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter};

const TIMEOUT: Duration = Duration::from_millis(500);
const PATIENCE: Duration = Duration::from_millis(2_000);
/// What a request takes.
const ROUND_TRIP: Duration = Duration::from_millis(1);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// The request does not arrive.
    Lost,
    /// It is carried out, and the answer comes too late.
    Late,
    /// The connection is closed before it, or behind it.
    ClosedBefore,
    ClosedBehind,
    /// The answer is no answer.
    Short,
    /// Another word comes.
    Foreign,
    /// The halves of the word are exchanged.
    Exchanged,
    /// It is refused for the moment.
    Busy,
    /// It arrives after the client has given it up.
    Delayed,
    /// From here on nothing gets through.
    Dead,
    /// The same, but this request is still carried out.
    DeadBehind,
}

const WAYS: [Way; 11] = [
    Way::Lost,
    Way::Late,
    Way::ClosedBefore,
    Way::ClosedBehind,
    Way::Short,
    Way::Foreign,
    Way::Exchanged,
    Way::Busy,
    Way::Delayed,
    Way::Dead,
    Way::DeadBehind,
];

/// A gateway before a simulated ring that fails once, or from then on.
struct Faulty {
    ring: Simulated,
    requests: u32,
    at: u32,
    way: Way,
    /// A write that is still on its way, and when it arrives.
    delayed: Option<(Instant, usize, OutWord)>,
}

#[derive(Debug, thiserror::Error)]
#[error("spoilt")]
struct Spoilt;

enum Asked<'a> {
    Out(usize, &'a mut OutWord),
    Write(usize, OutWord),
    In(usize, &'a mut [InWord]),
}

impl Faulty {
    fn request(&mut self, asked: Asked<'_>) -> Result<(), BusError> {
        self.ring.wait(ROUND_TRIP);
        if let Some((when, position, word)) = self.delayed
            && self.ring.now() >= when
        {
            self.delayed = None;
            self.ring.cycle(Some((position, word)), position, &mut []).unwrap();
        }
        self.requests += 1;
        let now = self.requests.cmp(&self.at);
        let dead = matches!(self.way, Way::Dead | Way::DeadBehind);
        match (now.is_eq(), now.is_gt() && dead) {
            (false, false) => self.carry_out(asked, None),
            (false, true) => Err(self.silence()),
            (true, _) => self.fail(asked),
        }
    }

    fn silence(&mut self) -> BusError {
        self.ring.wait(TIMEOUT);
        BusError::NoAnswer { within: TIMEOUT }
    }

    fn fail(&mut self, asked: Asked<'_>) -> Result<(), BusError> {
        let closed = BusError::NoConnection(Cause::System(io::ErrorKind::ConnectionAborted));
        match self.way {
            Way::Lost | Way::Dead => Err(self.silence()),
            Way::Late | Way::DeadBehind => {
                self.carry_out(asked, None)?;
                Err(self.silence())
            }
            Way::ClosedBefore => Err(closed),
            Way::ClosedBehind => {
                self.carry_out(asked, None)?;
                Err(closed)
            }
            Way::Short => {
                self.carry_out(asked, None)?;
                Err(BusError::client(Answered::Garbled, Spoilt))
            }
            Way::Foreign => self.carry_out(asked, Some(|_| 0x5A5A_5A5A)),
            Way::Exchanged => self.carry_out(asked, Some(|word| Misread::Halves.read(InWord(word)).0)),
            Way::Busy => Err(BusError::client(Answered::Busy, Spoilt)),
            Way::Delayed => {
                if let Asked::Write(position, word) = asked {
                    let late = Duration::from_millis(900);
                    self.delayed = Some((self.ring.now() + late, position, word));
                }
                Err(self.silence())
            }
        }
    }

    fn carry_out(&mut self, asked: Asked<'_>, spoil: Option<fn(u32) -> u32>) -> Result<(), BusError> {
        let spoil = spoil.unwrap_or(|word| word);
        match asked {
            Asked::Out(position, out) => *out = OutWord(spoil(self.ring.out(position)?.0)),
            // What is written is never spoilt: that would be another request.
            Asked::Write(position, word) => {
                self.ring.cycle(Some((position, word)), position, &mut [])?;
            }
            Asked::In(first, input) => {
                self.ring.cycle(None, first, input)?;
                input.iter_mut().for_each(|word| *word = InWord(spoil(word.0)));
            }
        }
        Ok(())
    }
}

impl Bus for Faulty {
    fn now(&self) -> Instant {
        self.ring.now()
    }

    fn out(&mut self, position: usize) -> Result<OutWord, BusError> {
        let mut out = OutWord(0);
        self.request(Asked::Out(position, &mut out))?;
        Ok(out)
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        if let Some((position, word)) = write {
            self.request(Asked::Write(position, word))?;
        }
        let begun = self.now();
        if !input.is_empty() {
            self.request(Asked::In(first, input))?;
        }
        let at = self.now();
        Ok(Cycle { at, age: at.since(begun) + self.settling().time })
    }

    fn wait(&mut self, span: Duration) {
        self.ring.wait(span);
    }

    fn settling(&self) -> Settling {
        Settling { cycles: 2, time: Duration::from_millis(5) }
    }
}

fn gateway(at: u32, way: Way) -> Faulty {
    // Turning, so that a preset adjustment that is made twice sets another zero.
    let text = "version = 1\n[[device]]\nposition = 0\nmodel = \"ce-65-m\"\n\
                motion = { kind = \"speed\", per_s = 3000.0, start = 32600 }\n";
    let scenario = Scenario::parse("test", text, Path::new("")).unwrap();
    let ring = Simulated::new(World::new(&scenario).unwrap(), Speed::Max);
    Faulty { ring, requests: 0, at, way, delayed: None }
}

/// How often the zero was set.
fn zeros(bus: &Faulty) -> u32 {
    let mut memory = bus.ring.world().with(|world| world.places()[0].node().memory().clone());
    write_count(&mut memory, Record::Offset)
}

fn holds(bus: &Faulty, parameter: Parameter) -> u32 {
    let value = bus.ring.world().with(|world| {
        world.places()[0].node().encoder().map(|encoder| encoder.parameters().programmed().value(parameter))
    });
    value.unwrap()
}

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum End {
    Done,
    Failed,
}

/// Runs a command against a gateway that fails, and looks for a service bit that nobody was told of.
fn command(
    bus: &mut Faulty,
    work: impl FnOnce(&mut EncoderMaster<'_, Faulty>) -> End,
) -> (End, Option<OutWord>) {
    let Ok(mut master) = EncoderMaster::new(bus, 0, PATIENCE, Arc::new(AtomicBool::new(false))) else {
        return (End::Failed, None);
    };
    let end = work(&mut master);
    let left = master.withdraw();
    drop(master);
    let standing = bus.ring.out(0).unwrap();
    assert!(
        !standing.service_bit() || left == Some(standing),
        "{} untold at {} {:?}",
        standing,
        bus.at,
        bus.way
    );
    (end, left)
}

/// Meets every request in every way; gives how many ends were told as done of those in which the link came back.
fn sweep(name: &str, run: impl Fn(u32, Way) -> (End, u32)) {
    let (_, requests) = run(u32::MAX, Way::Lost);
    let (mut done, mut met) = (0, 0);
    for way in WAYS {
        for at in 1..=requests {
            let (end, _) = run(at, way);
            met += 1;
            done += u32::from(end == End::Done);
            // One late or lost answer ends nothing that may be repeated.
            if name != "preset" && !matches!(way, Way::Dead | Way::DeadBehind) {
                assert_eq!(end, End::Done, "{name}: request {at} of {requests}, {way:?}");
            }
        }
    }
    assert!(done < met, "{name}: a dead link ends in no success");
}

#[test]
fn a_read_tells_what_is_programmed_or_that_it_does_not_know() {
    sweep("read", |at, way| {
        let mut bus = gateway(at, way);
        let (end, _) =
            command(&mut bus, |master| match read(master, Model::Ce65M, Parameter::MeasuringLength) {
                Ok(value) => {
                    assert_eq!(value.value, 0xFF_FFFF, "{at} {way:?}");
                    End::Done
                }
                Err(_) => End::Failed,
            });
        (end, bus.requests)
    });
}

#[test]
fn a_check_tells_what_the_encoder_says() {
    sweep("check", |at, way| {
        let mut bus = gateway(at, way);
        let (end, _) = command(&mut bus, |master| match check(master) {
            Ok(check) => {
                assert!(check.is_good(), "{at} {way:?}");
                End::Done
            }
            Err(_) => End::Failed,
        });
        (end, bus.requests)
    });
}

#[test]
fn a_program_is_verified_or_taken_back_or_said_to_be_in_doubt() {
    sweep("program", |at, way| {
        let mut bus = gateway(at, way);
        let mut program = Program::new(Model::Ce65M, None);
        program.set(Parameter::MeasuringLength, 9_999).unwrap();
        program.set(Parameter::Numerator, 10).unwrap();
        let mut told = None;
        let (end, _) = command(&mut bus, |master| {
            let report = program.run(master);
            let end = if report.result.is_ok() { End::Done } else { End::Failed };
            told = Some(report);
            end
        });
        if let Some(report) = told {
            let now = (holds(&bus, Parameter::MeasuringLength), holds(&bus, Parameter::Numerator));
            match report.back {
                Back::NotNeeded => assert_eq!(now, (9_999, 10), "{at} {way:?}"),
                Back::NothingWritten | Back::Restored => assert_eq!(now, (0xFF_FFFF, 4096), "{at} {way:?}"),
                Back::Failed => {}
            }
        }
        (end, bus.requests)
    });
}

#[test]
fn a_preset_is_made_once_or_not_and_never_said_to_be_what_it_is_not() {
    sweep("preset", |at, way| {
        let mut bus = gateway(at, way);
        let before = zeros(&bus);
        let mut told = None;
        let (end, _) = command(&mut bus, |master| {
            let Ok(preset) = Preset::prepare(master, Model::Ce65M, 1_234) else { return End::Failed };
            let report = preset.adjust(master);
            let end = if report.result == Ok(Done::Confirmed) { End::Done } else { End::Failed };
            told = Some(report.result);
            end
        });
        bus.ring.wait(Duration::from_millis(200));
        let made = zeros(&bus) - before;
        let known = match told {
            None => Some(0),
            Some(Ok(_)) => Some(1),
            Some(Err(Failure::TimedOut { timed_out, .. })) => match timed_out.fate {
                Fate::NotSent => Some(0),
                Fate::CarriedOut(_) => Some(1),
                Fate::Unknown => None,
            },
            Some(Err(_)) => Some(0),
        };
        assert!(made <= 1, "{made} times at {at} {way:?}");
        assert!(known.is_none_or(|known| known == made), "{known:?} but {made} at {at} {way:?}: {told:?}");
        (end, bus.requests)
    });
}
