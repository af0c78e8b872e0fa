//! `encoring sim`: a ring of encoders that runs until it is stopped, reached over Modbus TCP.

use std::fs::{self, File};
use std::io::{self, BufWriter, IsTerminal, Write};
use std::net::{Ipv4Addr, SocketAddr, ToSocketAddrs};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration as Real;

use clap::Args;
use encoring_encoder::Unit;
use encoring_modbus::{RegisterMap, ServerCounts, Snapshot, WordOrder};
use encoring_sim::scenario::BUILT_IN;
use encoring_sim::{Level, Scenario, Waveform, World, device_line};
use encoring_station::station::Recorder;
use encoring_station::{Finished, Keeper, Options, RingEvent, Station, View};
use encoring_trace::Writer;
use encoring_trace::wave::{Format as WaveFormat, Sink};
use encoring_words::Duration;
use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use tokio::net::TcpListener;
use tokio::sync::{Notify, watch};

use crate::arguments::fault::{self, Faults};
use crate::arguments::span;
use crate::arguments::{Lasting, Output, Pace, State};
use crate::memories::remember;
use crate::output::{Answer, Failure, Format, bad_input, note};

/// Where the Modbus server listens unless told otherwise: a port that needs no privileges.
const MODBUS_DEFAULT: &str = "127.0.0.1:5020";

/// How often a stop by itself is looked for.
const LOOK_EVERY: Real = Real::from_millis(20);

const EXAMPLES: &str = "\
Examples:
  encoring sim                                    the built-in ring on 127.0.0.1:5020
  encoring sim --example > ring.toml              a scenario to start from
  encoring sim ring.toml --state memories         encoders that remember
  encoring sim --for 10s --speed max --record ring.csv --modbus off
  encoring sim --level bit --for 50ms --speed max --record ring.vcd --modbus off && gtkwave ring.vcd
  encoring sim --control 127.0.0.1:5021           and: echo '{\"verb\":\"view\"}' | nc 127.0.0.1 5021
  mbpoll -m tcp -p 5020 -a 1 -t 3:hex -r 1 -c 6 127.0.0.1    every IN word
  encoring sim --level bit --fault silent:2@5s+1s    a broken cable, searched and found

";

/// Runs encoders on a simulated ring, reached over Modbus TCP.
///
/// Without a scenario: an LA-66 of 500 mm, a CE-100-M and a CE-65-M, all moving. Position k of the ring has its OUT
/// word in holding registers 2k and 2k+1 and its IN word in input registers 2k and 2k+1, high word first. Holding
/// registers 900, 901 and 902+k are the master's status, its parameter and the faulty cycles on segment k.
///
/// Ends on Ctrl-C, on SIGTERM and after --for, with exit code 0 and the memories saved.
#[derive(Args)]
#[command(after_help = format!("{EXAMPLES}{}", fault::help()))]
pub(crate) struct Arguments {
    /// What hangs on the ring and what happens to it.
    scenario: Option<PathBuf>,
    /// Address of the Modbus server: HOST:PORT, PORT on this machine, or off.
    #[arg(long, value_name = "ADDR", default_value = MODBUS_DEFAULT)]
    modbus: String,
    /// Which register holds what: plain, or inline as an Inline bus coupler has it.
    #[arg(long, value_name = "LAYOUT", default_value = "plain")]
    layout: RegisterMap,
    /// Which word of an encoder has the lower register.
    #[arg(long, value_name = "ORDER", default_value = "high-first")]
    word_order: WordOrder,
    /// Modbus connections at one time.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u16).range(1..=1024))]
    modbus_connections: u16,
    /// Seconds after which an idle Modbus connection is closed.
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=86_400))]
    modbus_idle: u32,
    /// Address of the control port: HOST:PORT, PORT on this machine, or off.
    #[arg(long, value_name = "ADDR", default_value = "off")]
    control: String,
    /// The page in the browser; only off so far.
    #[arg(long, value_name = "ADDR", default_value = "off", value_parser = ["off"])]
    web: String,
    #[command(flatten)]
    memories: State,
    #[command(flatten)]
    lasting: Lasting,
    #[command(flatten)]
    pace: Pace,
    /// How the ring is simulated, in place of what the scenario says: all words of a cycle at once, or every bit on
    /// every segment.
    #[arg(long, value_name = "word|bit", value_parser = level)]
    level: Option<Level>,
    #[command(flatten)]
    faults: Faults,
    /// Writes every exchange of every encoder to a trace that `replay` reads; to a file that ends in .vcd or .fst,
    /// signals over time for GTKWave: at bit level every line bit of every segment.
    #[arg(long, value_name = "FILE.csv|.vcd|.fst")]
    record: Option<PathBuf>,
    /// Tells the counters each time so much has passed on the ring, as fast as it can be told: 10, 1m.
    #[arg(long, value_name = "TIME", value_parser = span)]
    counters: Option<Duration>,
    /// Prints the scenario of the built-in ring and ends.
    #[arg(long, conflicts_with = "scenario")]
    example: bool,
    #[command(flatten)]
    output: Output,
}

fn level(text: &str) -> Result<Level, &'static str> {
    match text {
        "word" => Ok(Level::Word),
        "bit" => Ok(Level::Bit),
        _ => Err("the levels are word and bit"),
    }
}

/// An address to listen on; `None` for `off`.
fn address(option: &str, text: &str) -> Result<Option<SocketAddr>, Failure> {
    if text == "off" {
        return Ok(None);
    }
    if let Ok(port) = text.parse::<u16>() {
        return Ok(Some(SocketAddr::from((Ipv4Addr::LOCALHOST, port))));
    }
    let found = text.to_socket_addrs().ok().and_then(|mut addresses| addresses.next());
    let wrong = || bad_input(format!("{option} {text}: no address; write HOST:PORT, PORT or off"));
    found.map(Some).ok_or_else(wrong)
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
    let scenario = match &arguments.scenario {
        Some(path) => Scenario::read(path),
        None => Scenario::built_in(),
    };
    let mut scenario = scenario.map_err(bad_input)?;
    scenario.level = arguments.level.unwrap_or(scenario.level);
    fault::add(&arguments.faults, &mut scenario)?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    runtime.block_on(simulate(arguments, &scenario))
}

async fn simulate(arguments: &Arguments, scenario: &Scenario) -> Result<Answer, Failure> {
    // From here on a signal ends the simulation in order, also between its first line and its first wait.
    let signalled = Arc::new(Notify::new());
    let for_handler = Arc::clone(&signalled);
    ctrlc::set_handler(move || for_handler.notify_one()).map_err(io::Error::other)?;
    // Everything that can be refused is looked at before anything is written.
    if let Some(record) = &arguments.record {
        recordable(record, arguments.scenario.as_deref())?;
    }
    let modbus = listen("--modbus", address("--modbus", &arguments.modbus)?).await?;
    let control = listen("--control", address("--control", &arguments.control)?).await?;
    let mut world = World::new(scenario).map_err(bad_input)?;
    let units: Vec<Unit> = scenario.devices.iter().map(|device| device.unit).collect();
    let _lock = match &arguments.memories.state {
        Some(folder) => Some(remember(folder, &units, &mut world)?),
        None => None,
    };
    let recording = arguments.record.as_deref().map(|file| Recording::start(file, &mut world)).transpose()?;
    let (partial, record) = recording.map_or((None, None), |(partial, record)| (Some(partial), Some(record)));
    let options = Options { speed: arguments.pace.or_real(), until: arguments.lasting.lasting, record };
    let station = Station::start(world, options)?;
    let keeper = match &arguments.memories.state {
        Some(folder) => {
            Some(Keeper::start(station.handle().clone(), folder.clone(), units.clone()).map_err(bad_input)?)
        }
        None => None,
    };

    let (stop, stopped) = watch::channel(());
    let until_stopped = |mut stopped: watch::Receiver<()>| async move {
        // The sender goes when the ring stops.
        while stopped.changed().await.is_ok() {}
    };
    let mut report = Report {
        format: arguments.output.format,
        layout: arguments.layout,
        next_event: 0,
        counters: arguments.counters,
        next_counters_ns: arguments.counters.map_or(0, Duration::as_nanos),
        modbus: where_it_listens("modbus", modbus.as_ref())?,
        control: where_it_listens("control", control.as_ref())?,
    };
    report.start(station.first_view())?;

    let served = modbus.is_some().then(Arc::<ServerCounts>::default);
    if let Some((listener, counters)) = modbus.zip(served.clone()) {
        let options = encoring_modbus::Options {
            layout: arguments.layout,
            word_order: arguments.word_order,
            connections: usize::from(arguments.modbus_connections),
            idle: Real::from_secs(u64::from(arguments.modbus_idle)),
        };
        let image = station.handle().image().clone();
        tokio::spawn(encoring_modbus::serve(
            listener,
            image,
            options,
            counters,
            until_stopped(stopped.clone()),
        ));
    }
    if let Some(listener) = control {
        let options = encoring_control::Options::default();
        let ring = station.handle().clone();
        tokio::spawn(encoring_control::serve(listener, ring, units.clone(), options, until_stopped(stopped)));
    }
    let progress = Progress::new(arguments.lasting.lasting);
    tokio::select! {
        () = signalled.notified() => {}
        ended = finished(&station, &progress, &mut report) => ended?,
    }
    drop(progress);
    drop(stop);

    let outcome = station.stop().map_err(bad_input)?;
    if let Some(keeper) = keeper {
        keeper.finish(&outcome.memories).map_err(bad_input)?;
    }
    finish_recording(partial, &outcome)?;
    report.events(&outcome.events)?;
    if let Some(counters) = served {
        report.served(counters.snapshot())?;
    }
    report.end(&outcome.view)?;
    Ok(Answer::Yes)
}

/// Waits until the ring has stopped by itself, and tells meanwhile what happens on it.
async fn finished(station: &Station, progress: &Progress, report: &mut Report) -> io::Result<()> {
    while !station.is_finished() {
        progress.show(station);
        if let Ok(events) = station.handle().events(report.next_event) {
            report.events(&events)?;
        }
        if report.counters.is_some()
            && let Ok(view) = station.handle().view()
        {
            report.counters(&view)?;
        }
        tokio::time::sleep(LOOK_EVERY).await;
    }
    Ok(())
}

/// Refuses a recording that could not be finished, or whose end would cost something else: it takes the place of what
/// has its name, and a folder, a device, a link or the scenario must not be lost to it.
fn recordable(file: &Path, scenario: Option<&Path>) -> Result<(), Failure> {
    let refused = |why: &str| Err(bad_input(format!("--record {}: {why}", file.display())));
    let same = |path: &Path| {
        fs::canonicalize(file).is_ok_and(|file| fs::canonicalize(path).is_ok_and(|p| p == file))
    };
    if fs::symlink_metadata(file).is_ok_and(|found| !found.is_file()) {
        return refused("not an ordinary file; name a new one");
    }
    if scenario.is_some_and(same) {
        return refused("this is the scenario");
    }
    match file.parent() {
        Some(folder) if folder.as_os_str().is_empty() || folder.is_dir() => Ok(()),
        _ => refused("there is no such folder"),
    }
}

/// A recording under way: it gets its name when it is whole.
struct Recording {
    file: PathBuf,
    partial: PathBuf,
}

impl Recording {
    fn start(file: &Path, world: &mut World) -> Result<(Self, Recorder), Failure> {
        let mut partial = file.as_os_str().to_owned();
        partial.push(".partial");
        let partial = PathBuf::from(partial);
        let problem = |cause: io::Error| bad_input(format!("--record {}: {cause}", file.display()));
        let sink = BufWriter::with_capacity(1 << 16, File::create(&partial).map_err(problem)?);
        let record = match WaveFormat::of(file) {
            Some(format) => waveform(format, sink, world),
            None => exchanges(sink, world),
        };
        Ok((Self { file: file.to_owned(), partial }, record.map_err(problem)?))
    }
}

fn exchanges(sink: BufWriter<File>, world: &World) -> io::Result<Recorder> {
    let devices: Vec<_> = world
        .places()
        .iter()
        .enumerate()
        .map(|(position, place)| {
            device_line::to_device(position as u8, place.node().unit(), place.node().memory())
        })
        .collect();
    let sink: Box<dyn Write + Send> = Box::new(sink);
    Writer::recording(sink, &devices).map(Recorder::Exchanges)
}

fn waveform(format: WaveFormat, sink: BufWriter<File>, world: &mut World) -> io::Result<Recorder> {
    let writer = concat!("encoring ", env!("CARGO_PKG_VERSION"));
    let sink: Box<dyn Sink + Send> = Box::new(sink);
    Waveform::new(format, sink, writer, world).map(|waveform| Recorder::Waveform(Box::new(waveform)))
}

fn finish_recording(recording: Option<Recording>, outcome: &Finished) -> Result<(), Failure> {
    let Some(Recording { file, partial }) = recording else { return Ok(()) };
    if let Err(cause) = &outcome.recording {
        return Err(bad_input(format!(
            "--record {}: {cause}; what was written is in {}",
            file.display(),
            partial.display()
        )));
    }
    fs::rename(&partial, &file).map_err(|cause| bad_input(format!("--record {}: {cause}", file.display())))
}

/// A bar on the terminal for a run whose end is known.
struct Progress(Option<ProgressBar>);

impl Progress {
    fn new(lasting: Option<Duration>) -> Self {
        let bar = lasting.filter(|_| io::stderr().is_terminal()).map(|lasting| {
            let bar = ProgressBar::new(lasting.as_nanos() / 1_000_000);
            let style =
                ProgressStyle::with_template("{bar:40} {percent:>3} % of the time on the ring, {eta} left");
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        Self(bar)
    }

    fn show(&self, station: &Station) {
        if let (Some(bar), Ok(view)) = (&self.0, station.handle().view()) {
            bar.set_position(view.time_ns / 1_000_000);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = &self.0 {
            bar.finish_and_clear();
        }
    }
}

/// The address that a server got, with a warning if it is open to others.
fn where_it_listens(name: &str, listener: Option<&TcpListener>) -> io::Result<Option<String>> {
    let Some(listener) = listener else { return Ok(None) };
    let address = listener.local_addr()?;
    if !address.ip().to_canonical().is_loopback() {
        note(&format!(
            "note: {name} {address} can be reached from the network, and asks nobody for a password"
        ));
    }
    Ok(Some(address.to_string()))
}

/// What is printed.
struct Report {
    format: Format,
    layout: RegisterMap,
    /// Number of the first event not yet told.
    next_event: u64,
    counters: Option<Duration>,
    next_counters_ns: u64,
    modbus: Option<String>,
    control: Option<String>,
}

/// The first line for programs.
#[derive(Serialize)]
struct Listening<'a> {
    event: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    modbus: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    control: Option<&'a str>,
}

/// What the Modbus server has seen, the line before the last.
#[derive(Serialize)]
struct Served {
    event: &'static str,
    requests: u64,
    exceptions: u64,
    closed: Closed,
    accept_errors: u64,
}

/// Connections that the server closed, and why.
#[derive(Serialize)]
struct Closed {
    bad_frames: u64,
    idle: u64,
    too_many: u64,
}

/// A line of counters for programs, and the last of all.
#[derive(Serialize)]
struct CountersLine<'a> {
    event: &'static str,
    time_ns: u64,
    #[serde(flatten)]
    counters: encoring_station::view::Counters,
    segment_faults: &'a [u16],
}

impl Report {
    fn start(&self, view: &View) -> io::Result<()> {
        let (modbus, control) = (self.modbus.as_deref(), self.control.as_deref());
        let mut out = io::stdout().lock();
        if self.format == Format::Json {
            let line = Listening { event: "listening", modbus, control };
            writeln!(out, "{}", serde_json::to_string(&line)?)?;
            return out.flush();
        }
        let encoders = match view.devices.len() {
            1 => "1 encoder".to_owned(),
            several => format!("{several} encoders"),
        };
        writeln!(
            out,
            "{encoders} on a simulated ring, a cycle every {}",
            Duration::from_nanos(view.cycle_ns)
        )?;
        let places = |position| self.layout.places(position, view.devices.len());
        let [out_head, in_head] = places(0).map(|(table, _)| table);
        // Registers of the Inline layout have four digits.
        let wide = if self.layout == RegisterMap::Inline { 10 } else { 8 };
        let in_head = format!("IN {in_head}");
        writeln!(out, "position  device  model     OUT {out_head}  {in_head:<wide$}  position now")?;
        for device in &view.devices {
            let [out_registers, in_registers] =
                places(device.position).map(|(_, first)| format!("{first}, {}", first + 1));
            writeln!(
                out,
                "{:>8}  {:<6}  {:<8}  {out_registers:<11}  {in_registers:<wide$}  {}",
                device.position,
                device.device_number,
                device.model.name(),
                device.value.map_or_else(|| "off".to_owned(), |value| value.to_string()),
            )?;
        }
        for (name, address) in [("modbus", modbus), ("control", control)] {
            if let Some(address) = address {
                writeln!(out, "{name} {address}")?;
            }
        }
        out.flush()
    }

    fn events(&mut self, events: &[RingEvent]) -> io::Result<()> {
        let mut out = io::stdout().lock();
        for event in events.iter().filter(|event| event.number >= self.next_event) {
            match self.format {
                Format::Json => writeln!(out, "{}", serde_json::to_string(event)?)?,
                Format::Text => writeln!(out, "{event}")?,
            }
        }
        self.next_event = events.last().map_or(self.next_event, |event| event.number + 1);
        out.flush()
    }

    fn counters(&mut self, view: &View) -> io::Result<()> {
        let (Some(every), true) = (self.counters, view.time_ns >= self.next_counters_ns) else {
            return Ok(());
        };
        let passed = view.time_ns.checked_div(every.as_nanos()).unwrap_or_default();
        self.next_counters_ns = every.as_nanos().saturating_mul(passed.saturating_add(1));
        let counters = view.counters;
        let mut out = io::stdout().lock();
        if self.format == Format::Json {
            let segment_faults = view.diagnosis.segment_faults.as_slice();
            let line = CountersLine { event: "counters", time_ns: view.time_ns, counters, segment_faults };
            writeln!(out, "{}", serde_json::to_string(&line)?)?;
        } else {
            let (cycles, faulty, dropped) =
                (counters.cycles, counters.faulty_cycles, counters.dropped_cycles);
            let at = Duration::from_nanos(view.time_ns);
            writeln!(out, "{at}: {cycles} cycles, {faulty} faulty, {dropped} dropped")?;
        }
        out.flush()
    }

    /// What the Modbus server has seen.
    fn served(&self, seen: Snapshot) -> io::Result<()> {
        let Snapshot { requests, exceptions, .. } = seen;
        let closed = Closed {
            bad_frames: seen.closed_bad_frames,
            idle: seen.closed_idle,
            too_many: seen.refused_connections,
        };
        let mut out = io::stdout().lock();
        if self.format == Format::Json {
            let accept_errors = seen.accept_errors;
            let line = Served { event: "served", requests, exceptions, closed, accept_errors };
            return writeln!(out, "{}", serde_json::to_string(&line)?);
        }
        if requests > 0 {
            writeln!(out, "modbus: {requests} requests, {exceptions} of them answered with an exception")?;
        }
        let Closed { bad_frames, idle, too_many } = closed;
        if bad_frames + idle + too_many > 0 {
            writeln!(
                out,
                "modbus: connections closed: {bad_frames} sent no Modbus, {idle} were idle, {too_many} were too many"
            )?;
        }
        if seen.accept_errors > 0 {
            writeln!(out, "modbus: {} connections that the system could not hand over", seen.accept_errors)?;
        }
        Ok(())
    }

    fn end(&self, view: &View) -> io::Result<()> {
        let mut out = io::stdout().lock();
        let counters = view.counters;
        let segment_faults = view.diagnosis.segment_faults.as_slice();
        if self.format == Format::Json {
            let line = CountersLine { event: "stopped", time_ns: view.time_ns, counters, segment_faults };
            writeln!(out, "{}", serde_json::to_string(&line)?)?;
        } else {
            writeln!(
                out,
                "stopped after {} on the ring: {} cycles, {} faulty, {} dropped",
                Duration::from_nanos(view.time_ns),
                counters.cycles,
                counters.faulty_cycles,
                counters.dropped_cycles
            )?;
            for (segment, faults) in segment_faults.iter().enumerate().filter(|(_, faults)| **faults > 0) {
                writeln!(out, "faulty cycles on segment {segment}: {faults}")?;
            }
        }
        out.flush()
    }
}
