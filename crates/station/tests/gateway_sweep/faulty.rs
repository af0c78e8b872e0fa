//! A gateway before a simulated ring, in virtual time, that spoils requests by their number.

use std::io;
use std::path::Path;

use encoring_bus::misread::Misread;
use encoring_bus::{Answered, Bus, BusError, Cause, Cycle, Settling};
use encoring_ring::{ProcessImage, Verdict};
use encoring_sim::{Scenario, World};
use encoring_station::view::{Counters, DeviceView};
use encoring_station::{Simulated, Speed, View};
use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::judge::Ringed;

const TIMEOUT: Duration = Duration::from_millis(500);
const PATIENCE: Duration = Duration::from_millis(2_000);
/// What a request takes.
const ROUND_TRIP: Duration = Duration::from_millis(1);

/// How a request fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
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

pub(crate) const WAYS: [Way; 11] = [
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

/// How long a delayed write is on its way.
const DELAY: Duration = Duration::from_millis(900);

/// The gateway. Requests are counted from 1.
pub(crate) struct Faulty {
    ring: Simulated,
    requests: u32,
    faults: Vec<(u32, Way)>,
    met: u32,
    dead: bool,
    /// Writes that are still on their way, and when they arrive.
    delayed: Vec<(Instant, usize, OutWord)>,
}

/// A request.
enum Asked<'a> {
    Out(usize, &'a mut OutWord),
    Write(usize, OutWord),
    In(usize, &'a mut [InWord]),
}

impl Faulty {
    fn request(&mut self, asked: Asked<'_>) -> Result<(), BusError> {
        self.ring.wait(ROUND_TRIP);
        self.arrive();
        self.requests += 1;
        let due = self.faults.iter().find(|(at, _)| *at == self.requests).map(|(_, way)| *way);
        match due {
            _ if self.dead => Err(self.silence()),
            None => self.carry_out(asked, None),
            Some(way) => {
                self.met += 1;
                self.dead = matches!(way, Way::Dead | Way::DeadBehind);
                self.fail(way, asked)
            }
        }
    }

    /// Writes what has been on its way for long enough.
    fn arrive(&mut self) {
        let now = self.ring.now();
        let mut on_their_way = std::mem::take(&mut self.delayed);
        on_their_way.retain(|(when, position, word)| {
            let arrives = *when <= now;
            if arrives {
                self.ring.cycle(Some((*position, *word)), *position, &mut []).unwrap();
            }
            !arrives
        });
        self.delayed = on_their_way;
    }

    fn silence(&mut self) -> BusError {
        self.ring.wait(TIMEOUT);
        BusError::NoAnswer { within: TIMEOUT }
    }

    fn fail(&mut self, way: Way, asked: Asked<'_>) -> Result<(), BusError> {
        let closed = BusError::NoConnection(Cause::System(io::ErrorKind::ConnectionAborted));
        match way {
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
                Err(BusError::client(Answered::Garbled, io::Error::other("spoilt")))
            }
            Way::Foreign => self.carry_out(asked, Some(|_| 0x5A5A_5A5A)),
            Way::Exchanged => self.carry_out(asked, Some(|word| Misread::Halves.read(InWord(word)).0)),
            Way::Busy => Err(BusError::client(Answered::Busy, io::Error::other("busy"))),
            Way::Delayed => {
                if let Asked::Write(position, word) = asked {
                    self.delayed.push((self.ring.now() + DELAY, position, word));
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

impl Faulty {
    /// With an encoder that turns on from `start`, so that a zero that is set twice is another one.
    pub(crate) fn new(start: u32) -> Self {
        let text = format!(
            "version = 1\n[[device]]\nposition = 0\nmodel = \"ce-65-m\"\n\
             motion = {{ kind = \"speed\", per_s = 3000.0, start = {start} }}\n"
        );
        let scenario = Scenario::parse("test", &text, Path::new("")).unwrap();
        let ring = Simulated::new(World::new(&scenario).unwrap(), Speed::Max);
        Self { ring, requests: 0, faults: Vec::new(), met: 0, dead: false, delayed: Vec::new() }
    }

    pub(crate) const fn ring(&mut self) -> &mut Simulated {
        &mut self.ring
    }
}

impl Ringed for Faulty {
    type Faults = Vec<(u32, Way)>;

    fn arm(&mut self, faults: &Self::Faults) {
        (self.requests, self.met, self.dead) = (0, 0, false);
        self.faults.clone_from(faults);
    }

    fn requests(&self) -> u32 {
        self.requests
    }

    fn met(&self) -> u32 {
        self.met
    }

    fn truth(&mut self) -> DeviceView {
        self.arm(&Vec::new());
        while !self.delayed.is_empty() {
            self.ring.wait(ROUND_TRIP);
            self.arrive();
        }
        self.ring.wait(Duration::from_millis(50));
        let out = self.ring.out(0).unwrap();
        let image = ProcessImage::new(1).unwrap();
        let view =
            self.ring.world().with(|world| View::of(world, &image, Verdict::Good, Counters::default()));
        let device = view.devices.into_iter().next().unwrap();
        DeviceView { out, ..device }
    }

    fn patience(&self) -> Duration {
        PATIENCE
    }
}
