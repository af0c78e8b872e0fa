//! The built-in ring, running as fast as it can, with a control port on a port of the system's choice.
#![allow(
    dead_code,
    unreachable_pub,
    clippy::unwrap_used,
    clippy::panic,
    clippy::indexing_slicing,
    reason = "shared by tests that use parts of it; a test may panic"
)]

use std::net::SocketAddr;
use std::sync::{Arc, Mutex};

use encoring_control::{Options, serve};
use encoring_sim::{Scenario, World};
use encoring_station::answer::answer;
use encoring_station::{Controlled, Gateway, Speed, Station};
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

pub struct Ring {
    pub station: Station,
    pub controlled: Controlled,
}

/// A gateway that knows faults by heart: what begins with a letter is one.
#[derive(Default)]
pub struct Remembers(Mutex<Vec<String>>);

impl Gateway for Remembers {
    fn begin(&self, fault: &str) -> Result<(), String> {
        if !fault.starts_with(|first: char| first.is_ascii_lowercase()) {
            return Err(format!("gateway fault {fault:?}"));
        }
        self.0.lock().unwrap().push(fault.to_owned());
        Ok(())
    }

    fn end(&self, fault: &str) -> Result<(), String> {
        let mut faults = self.0.lock().unwrap();
        let index = faults.iter().position(|other| other == fault);
        index.map(|index| drop(faults.remove(index))).ok_or(format!("gateway fault {fault} is not there"))
    }

    fn end_all(&self) {
        self.0.lock().unwrap().clear();
    }

    fn faults(&self) -> Vec<String> {
        self.0.lock().unwrap().clone()
    }
}

impl Ring {
    pub fn start() -> Self {
        let scenario = Scenario::built_in().unwrap();
        let units = scenario.devices.iter().map(|device| device.unit).collect();
        let options = encoring_station::Options { speed: Speed::Max, ..encoring_station::Options::default() };
        let station = Station::start(World::new(&scenario).unwrap(), options).unwrap();
        let ring = station.handle().clone();
        Self {
            station,
            controlled: Controlled { ring, units, gateway: Some(Arc::new(Remembers::default())) },
        }
    }

    pub fn ask(&self, line: &str) -> Value {
        serde_json::from_str(&answer(line, &self.controlled)).unwrap()
    }

    pub fn done(&self, line: &str) {
        assert_eq!(self.ask(line), serde_json::json!({ "ok": true }), "{line}");
    }

    /// The message of a refusal.
    pub fn refused(&self, line: &str) -> String {
        let answer = self.ask(line);
        assert_eq!(answer["ok"], false, "{line}");
        answer["error"].as_str().unwrap().to_owned()
    }

    pub fn view(&self) -> Value {
        let answer = self.ask(r#"{"verb":"view"}"#);
        assert_eq!(answer["ok"], true);
        answer["view"].clone()
    }

    /// Looks again until it is so; time on the ring passes meanwhile.
    pub fn until(&self, so: impl Fn(&Value) -> bool) -> Value {
        let mut last = Value::Null;
        for _ in 0..100_000 {
            last = self.view();
            if so(&last) {
                return last;
            }
        }
        panic!("never so; last seen {last:#}");
    }

    pub fn cycles(&self) -> u64 {
        self.view()["counters"]["cycles"].as_u64().unwrap()
    }
}

pub struct Server {
    pub ring: Ring,
    pub address: SocketAddr,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Server {
    pub async fn start(options: Options) -> Self {
        let ring = Ring::start();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (stop, stopped) = oneshot::channel::<()>();
        let served = serve(listener, ring.controlled.clone(), options, async {
            let _ = stopped.await;
        });
        Self { ring, address, stop, task: tokio::spawn(served) }
    }

    pub async fn connect(&self) -> TcpStream {
        TcpStream::connect(self.address).await.unwrap()
    }

    /// Sends all of it, says that nothing more comes, and reads every answer.
    pub async fn exchange(&self, bytes: &[u8]) -> Vec<Value> {
        let (mut answers, mut requests) = self.connect().await.into_split();
        let send = async {
            // A server that has said its last word takes no more.
            let _ = requests.write_all(bytes).await;
            let _ = requests.shutdown().await;
        };
        let mut text = String::new();
        let (_, read) = tokio::join!(send, answers.read_to_string(&mut text));
        read.unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    }

    pub async fn stop(self) -> Ring {
        self.stop.send(()).unwrap();
        self.task.await.unwrap();
        self.ring
    }
}
