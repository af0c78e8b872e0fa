//! `encoring sim`: a ring of encoders that runs until it is stopped, reached over Modbus TCP.

use std::convert::Infallible;
use std::io::{self, Write};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration as Real;

use clap::Args;
use encoring_encoder::Unit;
use encoring_modbus::{GatewayFault, GatewayFaults, RegisterMap, ServerCounts, WordOrder};
use encoring_sim::scenario::{BUILT_IN, NO_LEVEL};
use encoring_sim::ssi::PlacedReader;
use encoring_sim::{Scenario, World};
use encoring_station::{Controlled, Keeper, Options, RefereeMode, Station};
use encoring_words::Duration;
use tokio::net::TcpListener;
use tokio::sync::{Notify, watch};

use crate::arguments::fault::{self, Faults};
use crate::arguments::{Lasting, Output, Pace, State, span, whole};
use crate::bus;
use crate::memories::can_be_written;
use crate::output::printer::{Closing, READER_PATIENCE};
use crate::output::progress::{Progress, RING_TIME};
use crate::output::{Answer, Failure, bad_input, note};
use crate::signals;
use crate::web::{Nature, Page, WebAccess, listening_address};
use report::{Addresses, Report};

mod gateway;
mod record;
mod report;

/// Where the Modbus server listens unless told otherwise: a port that needs no privileges.
const MODBUS_DEFAULT: &str = "127.0.0.1:5020";

/// Threads that wait for the ring on behalf of peers of the control port; more questions wait their turn.
const THREADS_FOR_PEERS: usize = 4;

/// How often a stop by itself is looked for.
const LOOK_EVERY: Real = Real::from_millis(20);

const EXIT_CODES_AND_EXAMPLES: &str = "\
Exit codes:
  0  ended by Ctrl-C, SIGTERM, --for or a closed pipe; the memories are saved
  1  with --referee strict: a client broke a rule of the handshake
  2  refused before the start
  3  output, recording or memories could not be written

Examples:
  encoring sim                              # the built-in ring, Modbus TCP on 127.0.0.1:5020
  mbpoll -m tcp -p 5020 -a 1 -t 3:hex -r 1 -c 6 127.0.0.1    # all IN words of that ring
  encoring sim --example > ring.toml        # a scenario to start from
  encoring sim ring.toml --state memories   # encoders that keep their parameters
  encoring sim --for 10s --speed max --record ring.csv --modbus off
  encoring sim --for 50ms --speed max --record ring.fst --lines --modbus off
  encoring sim --referee strict             # ends with 1 when a client breaks the handshake
  encoring sim --record-bus bus.csv         # then: encoring referee bus.csv
  encoring sim --control 127.0.0.1:5021     # then: echo '{\"verb\":\"view\"}' | nc 127.0.0.1 5021
  encoring sim --fault silent:2@5s+1s       # segment 2 is broken from 5 s to 6 s
  encoring sim --gateway-fault late=700#20  # the answer to request 20 comes 700 ms late
  encoring sim --ssi 2=500,25,10ms          # a reader on the SSI of position 2

";

/// Run encoders on a simulated ring with a Modbus TCP server
///
/// Without SCENARIO the ring has an LA-66 of 500 mm, a CE-100-M and a CE-65-M, all moving.
///
/// The encoder at position k has OUT in the holding registers 2k and 2k+1, and IN in the input registers 2k and 2k+1. The
/// high half has the lower register. The holding registers 900 and 901 have the master's diagnostic status register and
/// diagnostic parameter register. Holding register 902+k has the number of faulty cycles on segment k.
///
/// The command runs until Ctrl-C, SIGTERM or --for, or until the reader of its output is gone. It notices that with the
/// next line, and --counters prints one regularly.
#[derive(Args)]
#[command(after_help = format!("{EXIT_CODES_AND_EXAMPLES}{}", fault::help() + &fault::gateway_help()))]
pub(crate) struct Arguments {
    /// Scenario file with devices, motions, events and faults (docs/scenario.md) [default: the built-in ring]
    scenario: Option<PathBuf>,
    /// Address of the Modbus TCP server: HOST:PORT, PORT on this machine, or off
    #[arg(long, value_name = "ADDR", default_value = MODBUS_DEFAULT)]
    modbus: String,
    /// Register layout: plain, or inline as on an Inline bus coupler (docs/modbus.md)
    #[arg(long, value_name = "LAYOUT", default_value = "plain")]
    layout: RegisterMap,
    /// Which half of a word has the lower register: high-first or low-first
    #[arg(long, value_name = "ORDER", default_value = "high-first")]
    word_order: WordOrder,
    /// Most Modbus connections at one time, 1 to 1024
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = whole::<u16>(1..=1024))]
    modbus_connections: u16,
    /// Idle time after which a Modbus connection is closed, 1 to 86400 s
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = whole::<u32>(1..=86_400))]
    modbus_idle: u32,
    /// Address of the control port (docs/control.md): HOST:PORT, PORT on this machine, or off
    #[arg(long, value_name = "ADDR", default_value = "off")]
    control: String,
    /// Address of the page in the browser (docs/page.md): HOST:PORT, PORT on this machine, or off [default: 127.0.0.1:8051;
    /// off if that port is taken, and with --speed max]
    #[arg(long, value_name = "ADDR")]
    web: Option<String>,
    #[command(flatten)]
    web_access: WebAccess,
    #[command(flatten)]
    memories: State,
    #[command(flatten)]
    lasting: Lasting,
    #[command(flatten)]
    pace: Pace,
    /// Told why there is none.
    #[arg(long, hide = true, value_parser = level)]
    level: Option<Infallible>,
    #[command(flatten)]
    faults: Faults,
    /// Add an SSI reader to the encoder at POSITION: KHZ clock rate, CLOCKS a transfer, EVERY from transfer to transfer
    /// (repeatable); behind that ,bits=N and ,code=gray for one that is set otherwise than the encoder
    #[arg(long = "ssi", value_name = "POSITION=KHZ,CLOCKS,EVERY")]
    readers: Vec<PlacedReader>,
    /// Make the Modbus server misbehave (repeatable; kinds below)
    #[arg(long = "gateway-fault", value_name = "FAULT")]
    gateway_faults: Vec<GatewayFault>,
    /// Record every exchange to a .csv for `replay`, or the signals to a .vcd or .fst for GTKWave
    #[arg(long, value_name = "FILE.csv|.vcd|.fst")]
    record: Option<PathBuf>,
    /// Record the master's image at every cycle, and every write of a client, to a .csv for `referee`
    #[arg(long, value_name = "FILE.csv")]
    record_bus: Option<PathBuf>,
    /// Replace the file of a recording if it exists, as soon as the recording is complete
    #[arg(long)]
    overwrite: bool,
    /// Add every line bit, and what each chip does with it, to the .vcd or .fst
    #[arg(long, requires = "record")]
    lines: bool,
    /// Add signals of several bits to a .vcd for GTKWave; logic analysers do not read them. A .fst always has them
    #[arg(long, requires = "record")]
    words: bool,
    /// Judge the handshake of clients: on, off, or strict, which ends at the first error (docs/referee.md)
    #[arg(long, value_name = "MODE", default_value = "on")]
    referee: RefereeMode,
    /// Print counters every TIME of ring time, such as 10 or 1m
    #[arg(long, value_name = "TIME", value_parser = span)]
    counters: Option<Duration>,
    /// Print the scenario of the built-in ring and end
    #[arg(long, conflicts_with = "scenario")]
    example: bool,
    #[command(flatten)]
    output: Output,
}

fn level(_: &str) -> Result<Infallible, &'static str> {
    Err(NO_LEVEL)
}

async fn listen(option: &str, address: Option<SocketAddr>) -> Result<Option<TcpListener>, Failure> {
    let Some(address) = address else { return Ok(None) };
    match TcpListener::bind(address).await {
        Ok(listener) => Ok(Some(listener)),
        Err(cause) if cause.kind() == io::ErrorKind::AddrInUse => {
            Err(bad_input(format!("{option} {address}: the port is in use; choose another, or 0 for any")))
        }
        Err(cause) => Err(bad_input(format!("{option} {address}: {cause}"))),
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    if arguments.example {
        io::stdout().lock().write_all(BUILT_IN.as_bytes())?;
        return Ok(Answer::Yes);
    }
    let mut scenario = bus::scenario(arguments.scenario.as_deref())?;
    for reader in &arguments.readers {
        scenario.hang_reader(*reader).map_err(|problem| bad_input(format!("--ssi {reader}: {problem}")))?;
    }
    fault::add(&arguments.faults, &mut scenario)?;
    let mut runtime = tokio::runtime::Builder::new_current_thread();
    let runtime = runtime.enable_all().max_blocking_threads(THREADS_FOR_PEERS).build()?;
    let faults = gateway::faults(&scenario, arguments.scenario.as_deref(), &arguments.gateway_faults)?;
    runtime.block_on(simulate(arguments, &scenario, faults))
}

async fn simulate(
    arguments: &Arguments,
    scenario: &Scenario,
    faults: GatewayFaults,
) -> Result<Answer, Failure> {
    // From here on a signal ends the simulation in order, also between its first line and its first wait.
    let signalled = Arc::new(Notify::new());
    let for_handler = Arc::clone(&signalled);
    signals::on_each(move || for_handler.notify_one())?;
    // Everything that can be refused is looked at before anything is written.
    arguments.recordable()?;
    let modbus = listen("--modbus", listening_address("--modbus", &arguments.modbus)?).await?;
    let control = listen("--control", listening_address("--control", &arguments.control)?).await?;
    let web = Page::beside(arguments.web.as_deref(), arguments.pace.or_real())?;
    let web_options = arguments.web_access.options(web.address()?, Nature::Simulated)?;
    let addresses = Addresses {
        modbus: where_it_listens("modbus", modbus.as_ref().map(TcpListener::local_addr))?,
        control: where_it_listens("control", control.as_ref().map(TcpListener::local_addr))?,
        web: web.address()?.map(|address| address.to_string()),
    };
    let mut world = World::new(scenario).map_err(bad_input)?;
    let units: Vec<Unit> = scenario.devices.iter().map(|device| device.unit).collect();
    let memories = arguments.memories.open(&mut world)?;
    memories.as_ref().map_or(Ok(()), can_be_written)?;
    let (files, records): (Vec<_>, Vec<_>) = arguments.record(&mut world)?.into_iter().unzip();
    let options = Options {
        speed: arguments.pace.or_real(),
        until: arguments.lasting.lasting,
        records,
        referee: arguments.referee,
    };
    let lasting = arguments.lasting.lasting;
    let progress = lasting.map(|lasting| Progress::start(Some(lasting), RING_TIME)).transpose()?;
    let mut report = Report::new(arguments.output.format, arguments.layout, arguments.counters)?;
    let station = Station::start(world, options)?;
    let keeper = memories.map(|folder| Keeper::start(station.handle().clone(), folder, units.clone()));
    let served = modbus.is_some().then(Arc::<ServerCounts>::default);
    let modbus = modbus.map(|listener| (listener, faults));
    let gateway = modbus.as_ref().map(|(_, faults)| gateway::told(faults.clone()));
    let controlled = Controlled { ring: station.handle().clone(), units: units.into(), gateway };
    let stop = serve(arguments, &station, modbus, control, controlled.clone(), served.clone());

    // Whatever ends it, what was acknowledged is kept: from here on nothing returns before the end.
    let (page, mut told) = match web.serve(Arc::new(controlled), &web_options) {
        Ok(page) => (page, report.start(station.first_view(), &addresses)),
        Err(cause) => (None, Err(cause)),
    };
    let mut patience = None;
    if told.is_ok() {
        tokio::select! {
            () = signalled.notified() => patience = Some(READER_PATIENCE),
            ended = finished(&station, progress.as_ref(), &mut report) => told = ended,
        }
    }
    drop((progress, stop, page));
    let outcome = station.stop().map_err(bad_input)?;
    let saved = keeper.map_or(Ok(()), |keeper| keeper.finish(&outcome.memories));
    let recorded = arguments.recordings().into_iter().zip(files).zip(outcome.recorded);
    let recorded: Vec<_> = recorded.map(|((wanted, file), recorded)| wanted.finish(file, recorded)).collect();
    let told = told
        .and_then(|()| report.events(&outcome.events))
        .and_then(|()| outcome.view.referee.as_ref().map_or(Ok(()), |referee| report.judged(referee)))
        .and_then(|()| served.map_or(Ok(()), |counters| report.served(counters.snapshot())))
        .and_then(|()| report.stopped(&outcome.view));
    let printed = printed(report.close(), patience, &signalled).await;
    all_kept([saved.map_err(|error| format!("--state {error}"))].into_iter().chain(recorded))?;
    told.and(printed)?;
    let strict = arguments.referee == RefereeMode::Strict;
    let broken = strict && outcome.view.referee.is_some_and(|referee| referee.is_broken());
    Ok(if broken { Answer::No } else { Answer::Yes })
}

/// Whether everything that was to be kept is; otherwise all that is not.
fn all_kept(results: impl Iterator<Item = Result<(), String>>) -> Result<(), Failure> {
    let troubles: Vec<String> = results.filter_map(Result::err).collect();
    if troubles.is_empty() { Ok(()) } else { Err(Failure::NoAnswer(troubles.join("; "))) }
}

/// Lets others at the ring until what this gives is dropped.
fn serve(
    arguments: &Arguments,
    station: &Station,
    modbus: Option<(TcpListener, GatewayFaults)>,
    control: Option<TcpListener>,
    controlled: Controlled,
    served: Option<Arc<ServerCounts>>,
) -> watch::Sender<()> {
    let (stop, stopped) = watch::channel(());
    let until_stopped = |mut stopped: watch::Receiver<()>| async move {
        // The sender goes when the ring stops.
        while stopped.changed().await.is_ok() {}
    };
    if let Some(((listener, faults), counters)) = modbus.zip(served) {
        let options = encoring_modbus::Options {
            layout: arguments.layout,
            word_order: arguments.word_order,
            connections: usize::from(arguments.modbus_connections),
            idle: Real::from_secs(u64::from(arguments.modbus_idle)),
        };
        let image = station.handle().image().clone();
        let until = until_stopped(stopped.clone());
        tokio::spawn(encoring_modbus::server::serve_faulty(
            listener, image, options, counters, faults, until,
        ));
    }
    if let Some(listener) = control {
        let options = encoring_control::Options::default();
        tokio::spawn(encoring_control::serve(listener, controlled, options, until_stopped(stopped)));
    }
    stop
}

/// Waits until the ring has stopped by itself, and tells meanwhile what happens on it.
async fn finished(station: &Station, progress: Option<&Progress>, report: &mut Report) -> io::Result<()> {
    while !station.is_finished() {
        if let Some(progress) = progress
            && let Ok(view) = station.handle().view()
        {
            progress.show(Duration::from_nanos(view.time_ns), String::new);
        }
        if let Ok(events) = station.handle().events(report.next_event()) {
            report.events(&events)?;
        }
        if report.tells_counters()
            && let Ok(view) = station.handle().view()
        {
            report.counters(&view)?;
        }
        tokio::time::sleep(LOOK_EVERY).await;
    }
    Ok(())
}

/// Waits for the reader of the last lines: as long as it takes, or only so long if a signal ended the simulation.
async fn printed(closing: Closing, patience: Option<Real>, signalled: &Notify) -> io::Result<()> {
    let all = async {
        while !closing.is_done() {
            tokio::time::sleep(LOOK_EVERY).await;
        }
    };
    let enough = async {
        match patience {
            Some(patience) => tokio::time::sleep(patience).await,
            None => signalled.notified().await,
        }
    };
    tokio::select! {
        () = all => {}
        () = enough => {}
    }
    closing.end()
}

/// The address that a server got, with a warning if it is open to others.
fn where_it_listens(name: &str, address: Option<io::Result<SocketAddr>>) -> io::Result<Option<String>> {
    let Some(address) = address.transpose()? else { return Ok(None) };
    if !address.ip().to_canonical().is_loopback() {
        note(&format!(
            "note: {name} {address} can be reached from the network, and asks nobody for a password"
        ));
    }
    Ok(Some(address.to_string()))
}
