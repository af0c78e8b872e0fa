//! `encoring watch`: what encoders show, as it happens.

mod live;
mod screen;
mod seen;
#[cfg(test)]
mod tests;

use std::io::{self, IsTerminal, Write};
use std::sync::atomic::AtomicBool;

use clap::Args;
use encoring_bus::watch::{Plan, Subject, Watch};
use encoring_station::causes::Causes;
use encoring_station::{SharedWorld, Speed};
use encoring_words::Duration;
use serde::Serialize;

use crate::acknowledging::Acknowledging;
use crate::arguments::{Lasting, Output, every};
use crate::bus::AnyBus;
use crate::news::{Calendar, News, TurnedRound, news};
use crate::output::printer::Printer;
use crate::output::time::seconds;
use crate::output::{Answer, Failure, Format};
use crate::subjects::SubjectArguments;
use crate::told::{FaultSeen, Faults, looked};
use screen::Update;
use seen::Seen;

/// An encoder that shows the same for so long is told of again.
const AGAIN_AFTER: Duration = Duration::from_secs(10);

/// Watch the encoders of a ring live: words, position, verdict
///
/// It only reads and never writes an OUT word, so the PLC can go on working.
///
/// On a terminal it shows a live view. Keys: q quits, the arrows scroll, l switches between blocks and a list, a
/// acknowledges jumps. Elsewhere it prints lines: one for each encoder at first, one for each change, one every 10 s without
/// a change. SIGUSR1 acknowledges jumps.
///
/// No parameter can be read without writing OUT. Behind a gateway name files with them (--parameters); without them neither
/// range nor jumps can be judged, and the output says so.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  ended by the user or by --for
  1  with --exit-on-fault: a fault was seen
  2  wrong usage
  3  no poll brought a word; with --exit-on-fault: no fault was seen,
     but an encoder could not be judged at some time

Examples:
  encoring watch --bus sim
  encoring watch --bus modbus-tcp://192.168.1.10 --at 0-2 --model la-66,ce-100-m,ce-65-m
  encoring watch --bus modbus-tcp://192.168.1.10 --at 2 --parameters axis-2.toml
  encoring watch --bus sim:ring.toml --for 10s --format json | jq .value")]
pub(crate) struct Arguments {
    #[command(flatten)]
    subjects: SubjectArguments,
    /// Shortest time between two lines of a moving position, at least 10ms; a new verdict is shown at once
    #[arg(long, value_name = "TIME", default_value = "200ms", value_parser = every)]
    every: Duration,
    /// Time from poll to poll, at least 10ms; a poll waits for the answer to the one before
    #[arg(long, value_name = "TIME", default_value = "10ms", value_parser = every)]
    poll: Duration,
    /// End at the first fault: error bit, implausible position, stopped ring
    #[arg(long)]
    exit_on_fault: bool,
    #[command(flatten)]
    lasting: Lasting,
    #[command(flatten)]
    output: Output,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let mut opened = arguments.subjects.ring.open(Speed::REAL)?;
    let subjects = arguments.subjects.subjects(&opened)?;
    let plan = Plan { every: arguments.poll.min(arguments.every), lasting: arguments.lasting.lasting };
    let about = About {
        address: opened.address.clone(),
        simulated: opened.is_simulated(),
        poll: plan.every,
        every: arguments.every,
    };
    opened.only_looks();
    let (stop, quit) = (opened.stop(), opened.stop());
    let untold = opened.untold_ring();
    let watch = Watch::new(&mut *opened.bus, subjects, plan, stop);
    let calendar = Calendar::at(watch.now());
    let watch = Watched {
        watch,
        world: opened.world.clone(),
        calendar,
        untold,
        turned_round: TurnedRound::default(),
        acknowledging: Acknowledging::by_signal()?,
        faults: arguments.exit_on_fault.then(Faults::default),
        causes: Causes::default(),
    };
    let answer = if arguments.output.format == Format::Text && io::stdout().is_terminal() {
        live::run(watch, about, &quit)?
    } else {
        Lines::new(about, arguments.output.format)?.run(watch, &quit)?
    };
    opened.close()?;
    Ok(answer)
}

/// A watch, and what is behind the ring if it is simulated.
struct Watched<'a> {
    watch: Watch<'a, AnyBus>,
    world: Option<SharedWorld>,
    calendar: Calendar,
    /// What is still to be said of a ring of which nobody tells whether it runs.
    untold: Option<&'static str>,
    turned_round: TurnedRound,
    acknowledging: Acknowledging,
    /// Those that it is to end with.
    faults: Option<Faults>,
    causes: Causes,
}

impl Watched<'_> {
    /// Waits for the next poll, and makes of it what is shown.
    fn poll(&mut self) -> Option<Update> {
        if self.faults.as_ref().is_some_and(|faults| faults.first().is_some()) {
            return None;
        }
        if self.acknowledging.take() {
            self.watch.acknowledge();
        }
        let world = self.world.as_ref();
        self.watch.poll_with(|position| world?.insight(position))?;
        let poll = self.watch.latest();
        if let Some(faults) = &mut self.faults {
            faults.take(poll);
        }
        let (at, polls) = (poll.at, poll.number + 1);
        let (sights, mut news) = (poll.sights.clone(), news(poll, &self.calendar, &self.acknowledging));
        if let Some(text) = self.untold.take() {
            news.push(News::of_ring("ring_untold", at, &self.calendar, text));
        }
        news.extend(self.turned_round.take(&self.watch, &self.calendar));
        for caused in self.causes.take(poll, self.watch.subjects()) {
            news.push(News::of_cause(caused, at, &self.calendar));
        }
        let lamps = |position| world.and_then(|world| world.lamps(position));
        let seen = sights.iter().zip(self.watch.subjects());
        let seen = seen.map(|(sight, subject)| {
            let mut seen = Seen::new(sight, &subject.judge, lamps(sight.position));
            seen.text.extend(self.causes.of(sight.position).map(ToString::to_string));
            seen
        });
        Some(Update { polls, seen: seen.collect(), news })
    }

    /// What is to be told when no poll follows: the causes of the last jumps, and what else was left.
    fn end(&mut self) -> Vec<News> {
        let (at, calendar) = (self.watch.now(), self.calendar);
        let rest = self.causes.rest(self.watch.subjects());
        let rest = rest.into_iter().map(|caused| News::of_cause(caused, at, &calendar));
        rest.chain(news(self.watch.end(), &calendar, &self.acknowledging)).collect()
    }
}

/// What is watched, and how.
pub(crate) struct About {
    pub(crate) address: String,
    pub(crate) simulated: bool,
    /// From one poll to the next.
    pub(crate) poll: Duration,
    pub(crate) every: Duration,
}

/// What stands in the first line for programs.
#[derive(Serialize)]
struct Watching<'a> {
    event: &'static str,
    bus: &'a str,
    simulated: bool,
    poll_ns: u64,
    every_ns: u64,
    positions: Vec<usize>,
}

/// The last line for programs.
#[derive(Serialize)]
struct Ended {
    event: &'static str,
    time_ns: u64,
    polls: u64,
    fault: Option<FaultSeen>,
}

/// The output that is no screen.
struct Lines {
    about: About,
    format: Format,
    out: Printer,
    /// Of each encoder what was last told.
    told: Vec<Seen>,
}

impl Lines {
    fn new(about: About, format: Format) -> io::Result<Self> {
        Ok(Self { about, format, out: Printer::start(io::stdout(), format)?, told: Vec::new() })
    }

    fn run(mut self, mut watched: Watched<'_>, quit: &AtomicBool) -> io::Result<Answer> {
        self.begin(watched.watch.subjects())?;
        let mut polls = 0;
        while let Some(update) = watched.poll() {
            polls = update.polls;
            self.poll(update.seen, &update.news)?;
        }
        self.poll(Vec::new(), &watched.end())?;
        let fault = watched.faults.as_ref().and_then(Faults::first);
        self.end(watched.watch.now().as_nanos(), polls, fault)?;
        self.out.close().wait(quit)?;
        Ok(looked(&watched.watch, watched.faults.as_ref()))
    }

    fn begin(&mut self, subjects: &[Subject]) -> io::Result<()> {
        let mut out = Vec::new();
        match self.format {
            Format::Json => {
                let line = Watching {
                    event: "watching",
                    bus: &self.about.address,
                    simulated: self.about.simulated,
                    poll_ns: self.about.poll.as_nanos(),
                    every_ns: self.about.every.as_nanos(),
                    positions: subjects.iter().map(|subject| subject.position).collect(),
                };
                writeln!(out, "{}", serde_json::to_string(&line)?)?;
            }
            Format::Text => {
                let simulated = if self.about.simulated { ", a simulation" } else { "" };
                let About { address, poll, every, .. } = &self.about;
                writeln!(out, "{address}{simulated}, judged every {poll}, shown every {every}")?;
                writeln!(
                    out,
                    "      time  at  model        position  verdict            OUT       IN        handshake"
                )?;
            }
        }
        self.out.print(String::from_utf8_lossy(&out).into_owned())
    }

    fn poll(&mut self, seen: Vec<Seen>, happened: &[News]) -> io::Result<()> {
        self.out.check()?;
        let mut out = Vec::new();
        for event in happened {
            match self.format {
                Format::Json => writeln!(out, "{}", serde_json::to_string(event)?)?,
                Format::Text => writeln!(out, "{}", event.advised())?,
            }
        }
        for new in seen {
            let old = self.told.iter_mut().find(|old| old.position == new.position);
            let known = old.as_ref().map(|old| old.blind.as_slice());
            if self.format == Format::Text && known != Some(new.blind.as_slice()) {
                for blind in &new.blind {
                    writeln!(out, "note: position {}: {}", new.position, blind.text())?;
                }
            }
            let due = old.as_ref().is_none_or(|old| {
                let time = Duration::from_nanos(new.time_ns.saturating_sub(old.time_ns));
                old.verdict != new.verdict
                    || old.key() != new.key() && time >= self.about.every
                    || old.blind != new.blind
                    || new.time_ns.saturating_sub(old.time_ns) >= AGAIN_AFTER.as_nanos()
            });
            if !due {
                continue;
            }
            match self.format {
                Format::Json => writeln!(out, "{}", serde_json::to_string(&new)?)?,
                Format::Text => writeln!(out, "{}", line(&new))?,
            }
            let began = old.as_ref().is_none_or(|old| old.verdict != new.verdict);
            if self.format == Format::Text && began {
                for cause in &new.causes {
                    writeln!(out, "{:>10}  {cause}", "")?;
                }
            }
            match old {
                Some(old) => *old = new,
                None => self.told.push(new),
            }
        }
        self.out.print(String::from_utf8_lossy(&out).into_owned())
    }

    fn end(&mut self, time_ns: u64, polls: u64, fault: Option<&FaultSeen>) -> io::Result<()> {
        let mut out = Vec::new();
        match self.format {
            Format::Json => {
                let ended = Ended { event: "ended", time_ns, polls, fault: fault.cloned() };
                writeln!(out, "{}", serde_json::to_string(&ended)?)?;
            }
            Format::Text => {
                writeln!(out, "{polls} polls in {} s", seconds(time_ns))?;
                if let Some(fault) = fault {
                    writeln!(out, "ended by a fault: {fault}")?;
                }
            }
        }
        self.out.print(String::from_utf8_lossy(&out).into_owned())
    }
}

/// An encoder in one line.
fn line(seen: &Seen) -> String {
    let value = seen.value.map_or_else(|| "-".to_owned(), |value| value.to_string());
    let word = |word: &Option<String>| word.clone().unwrap_or_else(|| "-".to_owned());
    let mut line = format!(
        "{:>10}  {:>2}  {:<8}  {value:>11}  {:<17}  {:<8}  {:<8}  {}",
        seconds(seen.time_ns),
        seen.position,
        seen.model,
        seen.verdict,
        word(&seen.out),
        word(&seen.input),
        seen.phase.unwrap_or("-"),
    );
    for text in &seen.text {
        line += "; ";
        line += text;
    }
    line
}
