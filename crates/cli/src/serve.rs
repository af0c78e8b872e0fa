//! `encoring serve`: the page in the browser, of a real ring.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::Args;
use encoring_bus::watch::Plan;
use encoring_bus::{Insight, LeftBit};
use encoring_station::polled::{Onlooker, PollOptions, Polled};
use encoring_station::view::LampsView;
use encoring_station::{Permission, RingEvent, SharedWorld, Speed};
use encoring_words::Duration;
use serde::Serialize;

use crate::arguments::bus::patience;
use crate::arguments::{Lasting, Output, every, span};
use crate::interrupt::Interrupt;
use crate::output::printer::Printer;
use crate::output::time::seconds;
use crate::output::{Answer, Failure, Format, bad_input, note};
use crate::subjects::SubjectArguments;
use crate::web::{Nature, Page, WebAccess};

/// Serve the page in the browser for a ring: words, handshake, trend, verdicts
///
/// It only reads, so the PLC can go on working. With --allow-control the page writes too, and asks before each write.
///
/// A gateway is polled. What begins and ends between two polls is not seen, and the page says what may be missing.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  ended by Ctrl-C, SIGTERM or --for
  2  wrong usage; an address of the page that is in use
  3  no poll brought a word

Examples:
  encoring serve --bus modbus-tcp://192.168.1.10 --at 0-2 --model la-66,ce-100-m,ce-65-m
  encoring serve --bus modbus-tcp://192.168.1.10 --at 2 --model ce-65-m --allow-control")]
pub(crate) struct Arguments {
    #[command(flatten)]
    subjects: SubjectArguments,
    /// Time from poll to poll, at least 10ms; a poll waits for the answer to the one before
    #[arg(long, value_name = "TIME", default_value = "10ms", value_parser = every)]
    poll: Duration,
    /// Longest wait for each step of a handshake, at least 3 time-outs of the address [default: 2s, or 4 time-outs if that is
    /// longer]
    #[arg(long, value_name = "TIME", value_parser = span)]
    patience: Option<Duration>,
    /// Address of the page: HOST:PORT, or PORT on this machine [default: 127.0.0.1:8051]
    #[arg(long, value_name = "ADDR")]
    web: Option<String>,
    #[command(flatten)]
    access: WebAccess,
    #[command(flatten)]
    lasting: Lasting,
    #[command(flatten)]
    output: Output,
}

/// The first line for programs.
#[derive(Serialize)]
struct Listening<'a> {
    event: &'static str,
    web: &'a str,
    bus: &'a str,
    simulated: bool,
    may_change: bool,
    poll_ns: u64,
    positions: Vec<usize>,
}

/// The last line for programs.
#[derive(Serialize)]
struct Ended {
    event: &'static str,
    time_ns: u64,
    polls: u64,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let ring = &arguments.subjects.ring;
    if arguments.access.allow_control && ring.read_only {
        return Err(bad_input(
            "--allow-control lets the page write, and --read-only refuses that; leave one out",
        ));
    }
    let page = Page::alone(arguments.web.as_deref())?;
    let address = page.address()?;
    let mut opened = ring.open(Speed::REAL)?;
    let (subjects, files) = arguments.subjects.described(&opened)?;
    let nature = if opened.is_simulated() && !ring.read_only { Nature::Simulated } else { Nature::Real };
    let web = arguments.access.options(address, nature)?;
    let patience = patience(arguments.patience, opened.timeout())?;
    let may_change = web.permission == Permission::Change;
    if !may_change {
        opened.only_looks();
    }
    if let Some(untold) = opened.untold_ring() {
        note(&format!("note: {untold}"));
    }
    let address = address.map(|address| address.to_string()).unwrap_or_default();
    let listening = Listening {
        event: "listening",
        web: &address,
        bus: &opened.address,
        simulated: opened.is_simulated(),
        may_change,
        poll_ns: arguments.poll.as_nanos(),
        positions: subjects.iter().map(|subject| subject.position).collect(),
    };
    let mut lines = Lines::start(arguments.output.format, opened.world.clone(), opened.interruption())?;
    lines.listening(&listening)?;
    let polled = Polled::new(PollOptions {
        bus: opened.address.clone(),
        simulated: opened.is_simulated(),
        subjects,
        files,
        plan: Plan { every: arguments.poll, lasting: arguments.lasting.lasting },
        patience,
    });
    let served = page.serve(Arc::new(polled.ring().clone()), &web)?;
    let (stop, quit) = (opened.stop(), opened.stop());
    let ended = polled.run(&mut *opened.bus, &stop, &mut lines)?;
    drop(served);
    lines.end(&Ended { event: "ended", time_ns: ended.time_ns, polls: ended.polls }, &quit)?;
    opened.close()?;
    Ok(if ended.answered { Answer::Yes } else { Answer::Unknown })
}

/// What is printed, and who has the ring looked at.
struct Lines {
    format: Format,
    out: Printer,
    world: Option<SharedWorld>,
    interrupt: Interrupt,
}

impl Lines {
    fn start(format: Format, world: Option<SharedWorld>, interrupt: Interrupt) -> io::Result<Self> {
        Ok(Self { format, out: Printer::start(io::stdout(), format)?, world, interrupt })
    }

    fn json(&mut self, line: &impl Serialize) -> io::Result<()> {
        self.out.print(serde_json::to_string(line)? + "\n")
    }

    fn listening(&mut self, listening: &Listening<'_>) -> io::Result<()> {
        if self.format == Format::Json {
            return self.json(listening);
        }
        let Listening { web, bus, simulated, may_change, .. } = listening;
        let what = match (simulated, may_change) {
            (true, true) => "a simulation that the page may change",
            (true, false) => "a simulation, read only",
            (false, true) => "the page asks before each write",
            (false, false) => "read only",
        };
        self.out.print(format!("{bus}: {what}\nweb {web}\n"))
    }

    fn end(mut self, ended: &Ended, quit: &AtomicBool) -> io::Result<()> {
        match self.format {
            Format::Json => self.json(ended)?,
            Format::Text => {
                self.out.print(format!("{} polls in {} s\n", ended.polls, seconds(ended.time_ns)))?;
            }
        }
        self.out.close().wait(quit)
    }
}

impl Onlooker for Lines {
    fn insight(&self, position: usize) -> Option<Insight> {
        self.world.as_ref()?.insight(position)
    }

    fn lamps(&self, position: usize) -> Option<LampsView> {
        self.world.as_ref()?.lamps(position)
    }

    fn is_over(&self) -> bool {
        self.interrupt.is_interrupted()
    }

    fn serving(&self, position: usize, left: LeftBit) {
        self.interrupt.serving(position, left);
    }

    fn happened(&mut self, events: &[RingEvent]) -> io::Result<()> {
        self.out.check()?;
        for event in events {
            match self.format {
                Format::Json => self.json(event)?,
                Format::Text => self.out.print(format!("{event}\n"))?,
            }
        }
        Ok(())
    }
}
