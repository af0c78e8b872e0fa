//! The thread that cycles the ring, and the handle that others hold on it.

use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::{Duration as Real, Instant as Clock};

use encoring_bus::SharedImage;
use encoring_host::Request as Service;
use encoring_ring::{ProcessImage, Verdict};
use encoring_sim::scenario::Change;
use encoring_sim::{Eeprom, Fault, World};
use encoring_words::{Duration, OutWord};

use crate::bus_seen::BusSeen;
use crate::events::{Events, Happened, Kept, RingEvent};
use crate::history::{Looks, Watched, WordHistory};
use crate::pace::{Pace, Speed};
use crate::recording::Recorder;
use crate::refereeing::{RefereeMode, Refereeing};
use crate::serving::{Served, Serving};
use crate::view::{Counters, View};

/// How many requests may wait for the ring's thread; whoever asks more waits too.
const REQUESTS_WAITING: usize = 64;

/// How a station runs.
pub struct Options {
    /// How fast.
    pub speed: Speed,
    /// Time on the ring after which it stops by itself.
    pub until: Option<Duration>,
    /// What is written meanwhile. If one breaks off, that is an event, and the ring goes on.
    pub records: Vec<Recorder>,
    /// Whether what clients write is judged.
    pub referee: RefereeMode,
}

impl Default for Options {
    fn default() -> Self {
        Self { speed: Speed::REAL, until: None, records: Vec::new(), referee: RefereeMode::Off }
    }
}

/// A ring that runs.
#[derive(Debug)]
pub struct Station {
    handle: Handle,
    first_view: View,
    thread: JoinHandle<Finished>,
}

/// How a station ended.
#[derive(Debug)]
pub struct Finished {
    /// The last view.
    pub view: View,
    /// The last events.
    pub events: Vec<RingEvent>,
    /// The memories as they are after the supply was switched off, by position.
    pub memories: Vec<Eeprom>,
    /// Why recordings broke off, if they did, in the order of [`Options::records`].
    pub recorded: Vec<io::Result<()>>,
}

/// A handle on a running ring.
#[derive(Clone, Debug)]
pub struct Handle {
    image: SharedImage,
    events: Arc<Kept>,
    history: WordHistory,
    requests: SyncSender<Request>,
}

/// The ring has stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the ring has stopped")]
pub struct RingStopped;

enum Request {
    Change { position: usize, changes: Vec<Change>, done: SyncSender<()> },
    Trouble { segment: usize, fault: Option<(Fault, Duration)>, done: SyncSender<()> },
    View(SyncSender<View>),
    Memories(SyncSender<Vec<Memory>>),
    WriteOut { position: usize, word: OutWord, done: SyncSender<()> },
    Serve { position: usize, service: Service, done: SyncSender<Served> },
    Tell(Happened),
    Stop,
}

/// An encoder's memory while it runs.
#[derive(Clone, Debug)]
pub struct Memory {
    /// What the EEPROM holds.
    pub now: Eeprom,
    /// What it would hold if the supply failed now: with the turn count.
    pub at_power_off: Eeprom,
}

impl Station {
    /// Starts to cycle the ring of `world`. When this returns, two cycles have run: if they were good, the image shows
    /// the positions.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(mut world: World, options: Options) -> io::Result<Self> {
        let image = ProcessImage::new(world.places().len()).map_err(io::Error::other)?;
        let (requests, waiting) = sync_channel(REQUESTS_WAITING);
        let (events, watched) = (Events::new(), Watched::new(image.encoders(), Looks::EveryCycle));
        let handle = Handle {
            image: SharedImage::new(image),
            events: Arc::clone(events.kept()),
            history: watched.history().clone(),
            requests,
        };
        for recorder in &options.records {
            recorder.begin(&mut world);
        }
        let refereeing = Refereeing::new(&world, options.referee);
        if refereeing.is_some() || options.records.iter().any(Recorder::is_of_bus) {
            handle.image.keep_writes();
        }
        let mut ring = Running {
            world,
            image: handle.image.clone(),
            verdict: Verdict::Good,
            counters: Counters::default(),
            events,
            watched,
            serving: Serving::default(),
            carried: Vec::new(),
            bus: BusSeen::default(),
            refereeing,
            records: options.records.into_iter().map(Ok).collect(),
        };
        // A device shows its position from the second cycle on.
        ring.cycle();
        ring.cycle();
        let first_view = ring.view();
        let (speed, until) = (options.speed, options.until);
        let thread =
            thread::Builder::new().name("ring".to_owned()).spawn(move || ring.run(speed, until, &waiting))?;
        Ok(Self { handle, first_view, thread })
    }

    /// The handle to give away.
    #[must_use]
    pub const fn handle(&self) -> &Handle {
        &self.handle
    }

    /// The ring as it was before real time began.
    #[must_use]
    pub const fn first_view(&self) -> &View {
        &self.first_view
    }

    /// `true` once the ring has stopped by itself.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Stops the ring and switches every encoder off.
    ///
    /// # Errors
    /// [`RingStopped`] if its thread has died.
    pub fn stop(self) -> Result<Finished, RingStopped> {
        // If it has ended by itself, nobody listens any more.
        let _ = self.handle.requests.send(Request::Stop);
        self.thread.join().map_err(|_| RingStopped)
    }
}

impl Handle {
    /// The process image.
    #[must_use]
    pub const fn image(&self) -> &SharedImage {
        &self.image
    }

    /// Each change of the words of each encoder.
    #[must_use]
    pub const fn history(&self) -> &WordHistory {
        &self.history
    }

    /// Changes what surrounds an encoder, between two cycles; returns when it is done.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs.
    pub fn change(&self, position: usize, changes: Vec<Change>) -> Result<(), RingStopped> {
        self.ask(|done| Request::Change { position, changes, done })
    }

    /// Writes the OUT word of an encoder whole; returns when a cycle of the ring has carried it. Past the last encoder
    /// nothing happens.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs.
    pub fn write_out(&self, position: usize, word: OutWord) -> Result<(), RingStopped> {
        self.ask(|done| Request::WriteOut { position, word, done })
    }

    /// Carries a service out as a master does that sees every cycle; returns when it is over.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs, also if it stops meanwhile.
    pub fn serve(&self, position: usize, service: Service) -> Result<Served, RingStopped> {
        self.ask(|done| Request::Serve { position, service, done })
    }

    /// Troubles a segment for a time, or with `None` ends every trouble; returns when it is done.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs.
    pub fn trouble(&self, segment: usize, fault: Option<(Fault, Duration)>) -> Result<(), RingStopped> {
        self.ask(|done| Request::Trouble { segment, fault, done })
    }

    /// Looks at the whole ring, between two cycles.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs.
    pub fn view(&self) -> Result<View, RingStopped> {
        self.ask(Request::View)
    }

    /// The events from number `from` on, as far as they are kept.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs.
    pub fn events(&self, from: u64) -> Result<Vec<RingEvent>, RingStopped> {
        self.events.since(from).ok_or(RingStopped)
    }

    /// The same, but waits until there is one; after `within` of real time there is none.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs, also if it stops meanwhile.
    pub fn wait_event(&self, from: u64, within: Real) -> Result<Vec<RingEvent>, RingStopped> {
        self.events.wait(from, within).ok_or(RingStopped)
    }

    /// Copies the memories, by position.
    ///
    /// # Errors
    /// [`RingStopped`] if the ring no longer runs.
    pub fn memories(&self) -> Result<Vec<Memory>, RingStopped> {
        self.ask(Request::Memories)
    }

    /// Adds something that happened beside the ring to its events; nothing if the ring no longer runs.
    pub(crate) fn tell(&self, what: Happened) {
        let _ = self.requests.send(Request::Tell(what));
    }

    fn ask<R>(&self, request: impl FnOnce(SyncSender<R>) -> Request) -> Result<R, RingStopped> {
        let (answer, answered) = sync_channel(1);
        self.requests.send(request(answer)).map_err(|_| RingStopped)?;
        answered.recv().map_err(|_| RingStopped)
    }
}

/// What the thread owns.
struct Running {
    world: World,
    image: SharedImage,
    verdict: Verdict,
    counters: Counters,
    events: Events,
    watched: Watched,
    serving: Serving,
    /// Who waits for the next cycle to be over.
    carried: Vec<SyncSender<()>>,
    /// What the master sees of the cycle.
    bus: BusSeen,
    refereeing: Option<Refereeing>,
    /// Recordings, and why some broke off.
    records: Vec<io::Result<Recorder>>,
}

/// Whether to go on.
enum Next {
    Go,
    Stop,
}

impl Running {
    #[expect(clippy::disallowed_methods, reason = "this thread is where real time enters")]
    fn run(mut self, speed: Speed, until: Option<Duration>, requests: &Receiver<Request>) -> Finished {
        let mut pace = Pace::new(self.world.cycle_time(), speed);
        let started = Clock::now();
        let ended = |world: &World| until.is_some_and(|until| world.now().as_nanos() >= until.as_nanos());
        'ring: loop {
            loop {
                match requests.try_recv() {
                    Ok(request) => match self.serve(request) {
                        Next::Go => {}
                        Next::Stop => break 'ring,
                    },
                    Err(TryRecvError::Empty) => break,
                    Err(TryRecvError::Disconnected) => break 'ring,
                }
            }
            let due = pace.due(started.elapsed());
            self.counters.dropped_cycles = pace.dropped();
            self.events.dropped(self.world.now(), pace.dropped());
            for _ in 0..due {
                if ended(&self.world) {
                    break 'ring;
                }
                self.cycle();
                if self.refereeing.as_ref().is_some_and(Refereeing::ends) {
                    break 'ring;
                }
            }
            if due == 0 {
                // The wait for the next cycle is also the wait for a request.
                match requests.recv_timeout(pace.wait(started.elapsed())) {
                    Ok(request) => match self.serve(request) {
                        Next::Go => {}
                        Next::Stop => break,
                    },
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => break,
                }
            } else if speed == Speed::Max {
                // Without a wait nobody else would get at the image.
                thread::yield_now();
            }
        }
        self.finish()
    }

    fn cycle(&mut self) {
        let (world, watched, serving) = (&mut self.world, &mut self.watched, &mut self.serving);
        let (began, data_cycles) = (world.now(), world.ring().master().counts().cycles);
        let cycled = self.bus.cycle(&self.image, |image| {
            let (out, input) = image.both();
            let cycled = world.cycle(out, input);
            world.diagnose(image);
            watched.cycled(cycled.at, image.out(), image.input());
            serving.cycled(cycled.at, cycled.verdict == Verdict::Good, world.cycle_time(), image);
            cycled
        });
        self.carried.drain(..).for_each(|done| {
            let _ = done.send(());
        });
        self.verdict = cycled.verdict;
        let master = self.world.ring().master();
        let data = (master.counts().cycles != data_cycles).then_some(cycled.verdict);
        self.events.slot(cycled.at, data, master);
        self.bus.went(began, cycled.at, data);
        if self.bus.lost > 0 {
            self.events.push(began, Happened::WritesLost { writes: self.bus.lost });
        }
        if let Some(refereeing) = &mut self.refereeing {
            refereeing.cycled(&self.bus);
            refereeing
                .news()
                .for_each(|finding| self.events.push(cycled.at, Happened::Finding(Box::new(finding))));
        }
        self.counters.cycles += 1;
        self.counters.faulty_cycles += u64::from(cycled.verdict != Verdict::Good);
        self.record(|recorder, world, bus| recorder.cycled(world, &cycled, bus));
    }

    fn record(&mut self, mut keep: impl FnMut(&mut Recorder, &mut World, &BusSeen) -> io::Result<()>) {
        for record in &mut self.records {
            let Ok(recorder) = record else { continue };
            if let Err(cause) = keep(recorder, &mut self.world, &self.bus) {
                recorder.broke_off(&mut self.world);
                self.events.push(self.world.now(), Happened::RecordingEnded { problem: cause.to_string() });
                *record = Err(cause);
            }
        }
    }

    fn serve(&mut self, request: Request) -> Next {
        // Whoever asked may have gone; then there is nobody to tell.
        match request {
            Request::Change { position, changes, done } => {
                self.world.change(position, &changes);
                self.record(|recorder, world, _| recorder.changed(world));
                let _ = done.send(());
            }
            Request::Trouble { segment, fault, done } => {
                match fault {
                    Some((fault, lasting)) => self.world.trouble(segment, fault, lasting),
                    None => self.world.end_trouble(),
                }
                let _ = done.send(());
            }
            Request::View(answer) => {
                let _ = answer.send(self.view());
            }
            Request::Memories(answer) => {
                let memories = self.world.places().iter().map(|place| Memory {
                    now: place.node().memory().clone(),
                    at_power_off: place.node().memory_at_power_off(),
                });
                let _ = answer.send(memories.collect());
            }
            Request::WriteOut { position, word, done } => {
                self.image.with_own(|image| image.out_mut().get_mut(position).map(|out| *out = word));
                self.carried.push(done);
            }
            Request::Serve { position, service, done } => {
                let (now, serving) = (self.world.now(), &mut self.serving);
                self.image.with_own(|image| serving.begin(now, (position, service), image, done));
            }
            Request::Tell(what) => self.events.push(self.world.now(), what),
            Request::Stop => return Next::Stop,
        }
        Next::Go
    }

    fn view(&self) -> View {
        let image = self.image.with(|image| image.clone());
        let referee = self.refereeing.as_ref().map(Refereeing::view);
        View { referee, ..View::of(&self.world, &image, self.verdict, self.counters) }
    }

    fn finish(mut self) -> Finished {
        if let Some(refereeing) = &mut self.refereeing {
            let now = self.world.now();
            refereeing.finish();
            refereeing.news().for_each(|finding| self.events.push(now, Happened::Finding(Box::new(finding))));
        }
        let memories = self.world.places().iter().map(|place| place.node().memory_at_power_off()).collect();
        let (view, events) = (self.view(), self.events.all());
        let recorded = self.records.into_iter().map(|record| record.and_then(Recorder::finish)).collect();
        Finished { view, events, memories, recorded }
    }
}
