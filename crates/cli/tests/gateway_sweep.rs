//! The sweep of the master's commands over real TCP: the client, and a running ring behind a gateway that fails at one
//! request. What is told is compared with the encoder itself.
#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::panic,
    missing_docs,
    reason = "a test waits in real time, and may panic"
)]

#[path = "../../station/tests/gateway_sweep/judge.rs"]
mod judge;

use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread;

use encoring_bus::{Bus, BusError, Cycle, Settling};
use encoring_modbus::counters::ServerCounts;
use encoring_modbus::misdeeds::GatewayFaults;
use encoring_modbus::server::serve_faulty;
use encoring_modbus::{Client, GatewayFault};
use encoring_sim::{Scenario, World};
use encoring_station::view::DeviceView;
use encoring_station::{Options, Station};
use encoring_words::{Duration, InWord, Instant, OutWord};
use tokio::sync::oneshot;

use judge::{Command, End, Ringed, run};

/// Long enough for a machine that is busy, and far below the patience.
const TIMEOUT_MS: u32 = 60;
const PATIENCE: Duration = Duration::from_millis(1_200);

/// Every way to fail at one request. Late answers come when the next request is long under way.
const WAYS: [&str; 12] = [
    "silent",
    "late=90",
    "drop",
    "busy",
    "exception=0B",
    "close",
    "split",
    "garbled",
    "transaction",
    "unit=0",
    "max=1",
    "swapped",
];

/// Commands that wait most of their time.
const AT_ONCE: usize = 24;

/// A ring that runs, a gateway before it, and a client.
struct OverTcp {
    client: Client,
    station: Station,
    faults: GatewayFaults,
    counts: Arc<ServerCounts>,
    /// The number of the last request before the faults.
    before: u64,
    armed: Vec<u32>,
    /// The gateway ends when it is dropped.
    _stop: oneshot::Sender<()>,
}

impl OverTcp {
    fn start() -> Self {
        let text = "version = 1\n[[device]]\nposition = 0\nmodel = \"ce-65-m\"\n\
                    motion = { kind = \"speed\", per_s = 3000.0, start = 70000 }\n";
        let scenario = Scenario::parse("test", text, Path::new("")).unwrap();
        let station = Station::start(World::new(&scenario).unwrap(), Options::default()).unwrap();
        let (faults, counts) = (GatewayFaults::default(), Arc::<ServerCounts>::default());
        let (stop, stopped) = oneshot::channel::<()>();
        let (tell, told) = std::sync::mpsc::channel();
        let (image, gateway, counted) =
            (station.handle().image().clone(), faults.clone(), Arc::clone(&counts));
        thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
                tell.send(listener.local_addr().unwrap()).unwrap();
                let until = async { stopped.await.unwrap_or_default() };
                serve_faulty(listener, image, encoring_modbus::Options::default(), counted, gateway, until)
                    .await;
            });
        });
        let address = format!("modbus-tcp://{}?timeout_ms={TIMEOUT_MS}&settle_ms=5", told.recv().unwrap());
        let client = Client::new(address.parse().unwrap()).unwrap();
        Self { client, station, faults, counts, before: 0, armed: Vec::new(), _stop: stop }
    }
}

impl Bus for OverTcp {
    fn now(&self) -> Instant {
        self.client.now()
    }

    fn out(&mut self, position: usize) -> Result<OutWord, BusError> {
        self.client.out(position)
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        self.client.cycle(write, first, input)
    }

    fn wait(&mut self, span: Duration) {
        self.client.wait(span);
    }

    fn settling(&self) -> Settling {
        self.client.settling()
    }
}

impl Ringed for OverTcp {
    type Faults = Vec<(u32, &'static str)>;

    fn arm(&mut self, faults: &Self::Faults) {
        self.faults.clear();
        self.before = self.faults.requests();
        self.armed = faults.iter().map(|(at, _)| *at).collect();
        for (at, way) in faults {
            let fault: GatewayFault = format!("{way}#{}", self.before + u64::from(*at)).parse().unwrap();
            self.faults.add(fault).unwrap();
        }
    }

    fn requests(&self) -> u32 {
        u32::try_from(self.faults.requests() - self.before).unwrap()
    }

    fn met(&self) -> u32 {
        u32::try_from(self.armed.iter().filter(|at| **at <= self.requests()).count()).unwrap()
    }

    fn truth(&mut self) -> DeviceView {
        self.arm(&Vec::new());
        // What still waits in a connection that was given up may be carried out.
        while self.counts.snapshot().open_connections > 1 {
            self.client.wait(Duration::from_millis(1));
        }
        let cycles = |station: &Station| station.handle().view().unwrap().counters.cycles;
        let settled = cycles(&self.station) + 5;
        while cycles(&self.station) < settled {
            self.client.wait(Duration::from_millis(1));
        }
        self.station.handle().view().unwrap().devices.remove(0)
    }

    fn patience(&self) -> Duration {
        PATIENCE
    }
}

/// A command, what fails, and at which request.
type Case = (Command, &'static str, u32);

/// Runs every case, many at a time, and prints and judges what they came to.
fn sweep(cases: Vec<Case>) {
    let all = cases.len();
    let (cases, wrong) = (Mutex::new(cases), Mutex::new(Vec::new()));
    let figures = Mutex::new((0, 0));
    thread::scope(|scope| {
        for _ in 0..AT_ONCE {
            scope.spawn(|| {
                loop {
                    let Some(case) = cases.lock().unwrap().pop() else { return };
                    let (command, way, at) = case;
                    let ended = run(&mut OverTcp::start(), command, &vec![(at, way)]);
                    let mut figures = figures.lock().unwrap();
                    figures.0 += ended.met;
                    figures.1 += u32::from(ended.end == End::Done);
                    wrong
                        .lock()
                        .unwrap()
                        .extend(ended.wrong.iter().map(|wrong| format!("{case:?}: {wrong}")));
                }
            });
        }
    });
    let ((met, done), wrong) = (figures.into_inner().unwrap(), wrong.into_inner().unwrap());
    println!("{all} runs, {met} faults met, {done} told as done, {} told wrongly", wrong.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(met > 0 && done > 0, "{met} faults met, {done} done");
}

/// One in `every` of what can fail in these commands.
fn cases(every: usize) -> Vec<Case> {
    const COMMANDS: [Command; 7] = [
        Command::Read,
        Command::Check,
        Command::Write,
        Command::Program,
        Command::Preset,
        Command::Release,
        Command::NeedlessRelease,
    ];
    let of = |command| {
        let requests = run(&mut OverTcp::start(), command, &vec![]).requests;
        WAYS.into_iter().flat_map(move |way| (1..=requests).map(move |at| (command, way, at)))
    };
    COMMANDS.into_iter().flat_map(of).step_by(every).collect()
}

#[test]
fn a_gateway_that_fails_at_one_request_makes_no_command_tell_what_is_not_so() {
    sweep(cases(53));
}

#[test]
#[ignore = "minutes: in .ci/long"]
fn a_gateway_that_fails_at_any_third_request_makes_no_command_tell_what_is_not_so() {
    sweep(cases(3));
}
