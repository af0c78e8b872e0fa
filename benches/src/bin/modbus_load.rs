//! The Modbus servers of Encoring, libmodbus and pymodbus under one load generator; `benches/modbus-peers/run` builds
//! them and calls this.
//!
//! One thread drives all connections, each with one outstanding request: function 4, always the same registers.
//! Every answer is checked. Servers are started anew for every figure, one at a time, and the rounds are interleaved,
//! so that what else the machine does meets all of them alike.

use std::fmt::Display;
use std::fs;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

use clap::Parser;
use encoring_benches::scenario;
use hdrhistogram::Histogram;
use mio::net::TcpStream;
use mio::{Events, Interest, Poll, Token};

/// An encoder has two registers, so 100 registers are 50 encoders.
const ENCODERS: usize = 50;
const REGISTERS: [u16; 2] = [2, 100];
const CONNECTIONS: [usize; 2] = [1, 8];

/// Time on the ring after which our server ends even if nobody ends it.
const LIFETIME: &str = "300s";

/// Without an answer for so long a run has failed.
const SILENCE: Duration = Duration::from_secs(10);

const INPUT_REGISTERS: u8 = 4;
/// Transaction, protocol, length and unit.
const HEADER: usize = 7;
/// Function code and number of bytes.
const HEAD: usize = 2;
const ANSWER_MAX: usize = 260;

type Failure = Box<dyn std::error::Error>;

/// Modbus servers under the same load.
#[derive(Parser)]
struct Arguments {
    /// The program `encoring`.
    #[arg(long)]
    encoring: PathBuf,
    /// The program made of libmodbus_server.c.
    #[arg(long)]
    libmodbus: Option<PathBuf>,
    /// The Python that has pymodbus; pymodbus_server.py is looked for in --peers.
    #[arg(long)]
    pymodbus: Option<PathBuf>,
    /// The folder benches/modbus-peers.
    #[arg(long, default_value = "benches/modbus-peers")]
    peers: PathBuf,
    /// Where the scenario of the ring is written.
    #[arg(long, default_value = "target/modbus-peers")]
    folder: PathBuf,
    /// Measured requests of a run.
    #[arg(long, default_value_t = 100_000)]
    requests: usize,
    /// Measured requests of a run with pymodbus.
    #[arg(long, default_value_t = 20_000)]
    pymodbus_requests: usize,
    /// How often everything is measured.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
}

/// One of the servers that are compared.
struct Server {
    name: &'static str,
    program: PathBuf,
    arguments: Vec<String>,
    requests: usize,
    /// Ends in order on SIGTERM, and says then what its ring did.
    has_a_ring: bool,
}

/// What one run gave.
struct Figures {
    per_second: f64,
    p50_us: f64,
    p99_us: f64,
    /// Processor time of the server for one request, all of its threads together.
    cpu_us: f64,
}

/// A server that runs; it ends with this.
struct Running {
    child: Child,
    out: BufReader<ChildStdout>,
    address: SocketAddr,
}

impl Running {
    fn start(server: &Server) -> Result<Self, Failure> {
        let mut command = Command::new(&server.program);
        let started = command.args(&server.arguments).stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
        let mut child = started.map_err(|cause| format!("{}: {cause}", server.program.display()))?;
        let out = child.stdout.take().ok_or("no standard output")?;
        let address = SocketAddr::from(([127, 0, 0, 1], 0));
        let mut running = Self { child, out: BufReader::new(out), address };
        let mut line = String::new();
        running.out.read_line(&mut line)?;
        let (_, port) = line.split_once("127.0.0.1:").ok_or_else(|| format!("no address in {line:?}"))?;
        let digits: String = port.chars().take_while(char::is_ascii_digit).collect();
        running.address.set_port(digits.parse()?);
        Ok(running)
    }

    /// The processor time of all threads so far.
    fn cpu(&self) -> Result<Duration, Failure> {
        let mut sum = 0;
        for task in fs::read_dir(format!("/proc/{}/task", self.child.id()))? {
            let text = fs::read_to_string(task?.path().join("schedstat"))?;
            sum += text.split_whitespace().next().unwrap_or_default().parse::<u64>()?;
        }
        Ok(Duration::from_nanos(sum))
    }

    /// The last line of a server that ends in order.
    fn last_words(mut self) -> Result<String, Failure> {
        Command::new("kill").args(["-TERM", &self.child.id().to_string()]).status()?;
        let mut text = String::new();
        self.out.read_to_string(&mut text)?;
        self.child.wait()?;
        Ok(text.lines().last().unwrap_or_default().to_owned())
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

struct Connection {
    stream: TcpStream,
    request: [u8; HEADER + 5],
    answer: [u8; ANSWER_MAX],
    got: usize,
    asked_at: Instant,
}

impl Connection {
    fn new(address: SocketAddr, registers: u16) -> io::Result<Self> {
        let stream = std::net::TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        stream.set_nonblocking(true)?;
        let [high, low] = registers.to_be_bytes();
        let request = [0, 0, 0, 0, 0, 6, 1, INPUT_REGISTERS, 0, 0, high, low];
        let stream = TcpStream::from_std(stream);
        Ok(Self { stream, request, answer: [0; ANSWER_MAX], got: 0, asked_at: now() })
    }

    fn ask(&mut self) -> io::Result<()> {
        let [t1, t0, ..] = &mut self.request;
        [*t1, *t0] = u16::from_be_bytes([*t1, *t0]).wrapping_add(1).to_be_bytes();
        self.got = 0;
        self.asked_at = now();
        self.stream.write_all(&self.request)
    }

    /// Takes what has come; `true` if that completes the right answer.
    fn take(&mut self) -> Result<bool, Failure> {
        let [t1, t0, .., high, low] = self.request;
        let bytes = 2 * usize::from(u16::from_be_bytes([high, low]));
        let wanted = HEADER + HEAD + bytes;
        loop {
            match self.stream.read(self.answer.get_mut(self.got..).unwrap_or_default()) {
                Ok(0) => return Err("the server closed a connection".into()),
                Ok(count) => self.got += count,
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(false),
                Err(error) => return Err(error.into()),
            }
            if self.got < wanted {
                continue;
            }
            let start = [t1, t0, 0, 0, 0, (wanted - 6) as u8, 1, INPUT_REGISTERS, bytes as u8];
            if self.got != wanted || !self.answer.starts_with(&start) {
                let came = self.answer.get(..self.got).unwrap_or_default();
                return Err(format!("a wrong answer: {came:02X?}").into());
            }
            return Ok(true);
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "a load is measured by the clock")]
fn now() -> Instant {
    Instant::now()
}

/// Connections under load.
struct Load {
    poll: Poll,
    connections: Vec<Connection>,
}

impl Load {
    fn new(address: SocketAddr, connections: usize, registers: u16) -> Result<Self, Failure> {
        let poll = Poll::new()?;
        let connect = |_| Connection::new(address, registers);
        let mut connections = (0..connections).map(connect).collect::<Result<Vec<_>, _>>()?;
        for (index, connection) in connections.iter_mut().enumerate() {
            poll.registry().register(&mut connection.stream, Token(index), Interest::READABLE)?;
        }
        Ok(Self { poll, connections })
    }

    /// Asks so often and waits for every answer; gives the latencies in nanoseconds and the whole time.
    fn run(&mut self, requests: usize) -> Result<(Histogram<u64>, Duration), Failure> {
        let mut latencies = Histogram::new_with_bounds(100, 60_000_000_000, 3)?;
        let mut events = Events::with_capacity(64);
        let started = now();
        let (mut asked, mut answered) = (0, 0);
        for connection in self.connections.iter_mut().take(requests) {
            connection.ask()?;
            asked += 1;
        }
        while answered < requests {
            self.poll.poll(&mut events, Some(SILENCE))?;
            if events.is_empty() {
                return Err(format!("no answer for {} s", SILENCE.as_secs()).into());
            }
            for event in &events {
                let Some(connection) = self.connections.get_mut(event.token().0) else { continue };
                // Nothing more can come after a whole answer, so there is no need to read until nothing is left.
                if connection.take()? {
                    latencies.saturating_record(connection.asked_at.elapsed().as_nanos() as u64);
                    answered += 1;
                    if asked < requests {
                        connection.ask()?;
                        asked += 1;
                    }
                }
            }
        }
        Ok((latencies, started.elapsed()))
    }
}

/// A server from its start to its end.
fn measure(server: &Server, connections: usize, registers: u16) -> Result<(Figures, String), Failure> {
    let running = Running::start(server)?;
    let mut load = Load::new(running.address, connections, registers)?;
    load.run(server.requests.div_ceil(20))?;
    let before = running.cpu()?;
    let (latencies, time) = load.run(server.requests)?;
    let cpu = running.cpu()?.saturating_sub(before);
    let requests = server.requests as f64;
    let figures = Figures {
        per_second: requests / time.as_secs_f64(),
        p50_us: latencies.value_at_quantile(0.5) as f64 / 1e3,
        p99_us: latencies.value_at_quantile(0.99) as f64 / 1e3,
        cpu_us: cpu.as_secs_f64() * 1e6 / requests,
    };
    let said = if server.has_a_ring { running.last_words()? } else { String::new() };
    Ok((figures, said))
}

fn servers(arguments: &Arguments, ring: &Path) -> Vec<Server> {
    let sim =
        ["sim", &ring.to_string_lossy(), "--modbus", "127.0.0.1:0", "--format", "json", "--for", LIFETIME];
    let ours = Server {
        name: "encoring",
        program: arguments.encoring.clone(),
        arguments: sim.map(str::to_owned).to_vec(),
        requests: arguments.requests,
        has_a_ring: true,
    };
    let libmodbus = arguments.libmodbus.clone().map(|program| Server {
        name: "libmodbus",
        program,
        arguments: Vec::new(),
        requests: arguments.requests,
        has_a_ring: false,
    });
    let script = arguments.peers.join("pymodbus_server.py").to_string_lossy().into_owned();
    let pymodbus = arguments.pymodbus.clone().map(|program| Server {
        name: "pymodbus",
        program,
        arguments: vec![script],
        requests: arguments.pymodbus_requests,
        has_a_ring: false,
    });
    [Some(ours), libmodbus, pymodbus].into_iter().flatten().collect()
}

/// The middle one; of an even number the upper of the two.
fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

fn cell(value: Option<f64>, decimals: usize) -> impl Display {
    value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    fs::create_dir_all(&arguments.folder)?;
    let ring = arguments.folder.join("ring.toml");
    fs::write(&ring, scenario(ENCODERS))?;
    let servers = servers(&arguments, &ring);
    let cases: Vec<(usize, u16)> = CONNECTIONS
        .into_iter()
        .flat_map(|connections| REGISTERS.map(|registers| (connections, registers)))
        .collect();

    // By case, by server, by round.
    let mut all: Vec<Vec<Vec<Figures>>> =
        cases.iter().map(|_| servers.iter().map(|_| Vec::new()).collect()).collect();
    let mut ring_said = String::new();
    for round in 0..arguments.rounds {
        eprintln!("round {} of {}", round + 1, arguments.rounds);
        for (&(connections, registers), of_case) in cases.iter().zip(&mut all) {
            // Another one goes first in every round.
            for turn in 0..servers.len() {
                let index = (turn + round) % servers.len();
                let (Some(server), Some(figures)) = (servers.get(index), of_case.get_mut(index)) else {
                    continue;
                };
                let (measured, said) = measure(server, connections, registers)
                    .map_err(|cause| format!("{}, {connections} connections: {cause}", server.name))?;
                figures.push(measured);
                if server.has_a_ring {
                    ring_said = said;
                }
            }
        }
    }

    println!(
        "| connections | registers | server | requests/s, median | best | to libmodbus | p50 us | p99 us | server's CPU us/request |"
    );
    println!("|--:|--:|---|--:|--:|--:|--:|--:|--:|");
    for (&(connections, registers), of_case) in cases.iter().zip(&all) {
        let peer = servers.iter().zip(of_case).find(|(server, _)| server.name == "libmodbus");
        for (server, figures) in servers.iter().zip(of_case) {
            let best = figures.iter().map(|one| one.per_second).max_by(f64::total_cmp);
            // Within a round, so that a slow minute of the machine counts for neither.
            let ratios = peer.into_iter().flat_map(|(_, peer)| {
                figures.iter().zip(peer).map(|(one, peer)| one.per_second / peer.per_second)
            });
            println!(
                "| {connections} | {registers} | {} | {} | {} | {} | {} | {} | {} |",
                server.name,
                cell(median(figures.iter().map(|one| one.per_second)), 0),
                cell(best, 0),
                cell(median(ratios), 2),
                cell(median(figures.iter().map(|one| one.p50_us)), 0),
                cell(median(figures.iter().map(|one| one.p99_us)), 0),
                cell(median(figures.iter().map(|one| one.cpu_us)), 1),
            );
        }
    }
    println!(
        "\n{} rounds of {} requests a figure ({} with pymodbus), median of the rounds; the ring of the last run: {ring_said}",
        arguments.rounds, arguments.requests, arguments.pymodbus_requests
    );
    Ok(())
}
