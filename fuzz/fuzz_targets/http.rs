//! Any bytes to the page's server: it answers in HTTP or closes, goes on, and does nothing that was not asked of it under
//! a name of its own and as JSON.
#![no_main]

use std::io::{Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use encoring_dashboard::{ServedPage, WebOptions, start};
use encoring_station::answer::{LineFate, ToldBack};
use encoring_station::shown::{AboutRing, ShownUnit};
use encoring_station::{Permission, RingEvent, RingStopped, ShownRing, WordHistory};
use libfuzzer_sys::fuzz_target;
use serde_json::{Value, json};

/// Longer nobody waits for an answer; what is too slow for the server it closes long before.
const PATIENCE: Duration = Duration::from_secs(5);

/// A ring that counts what it is told.
struct Counting {
    told: Arc<AtomicU64>,
    history: WordHistory,
}

impl ShownRing for Counting {
    fn about(&self) -> AboutRing {
        AboutRing { bus: None, simulated: true, poll_ns: None }
    }

    fn units(&self) -> Vec<ShownUnit> {
        Vec::new()
    }

    fn seen(&self) -> Result<Value, RingStopped> {
        Ok(json!({ "time_ns": 0, "devices": [] }))
    }

    fn history(&self) -> &WordHistory {
        &self.history
    }

    fn happened(&self, _from: u64) -> Result<Vec<RingEvent>, RingStopped> {
        Ok(Vec::new())
    }

    fn told(&self, _line: &str, _permission: Permission) -> ToldBack {
        self.told.fetch_add(1, Ordering::Relaxed);
        ToldBack { line: r#"{"ok":true}"#.to_owned(), fate: LineFate::Done }
    }
}

struct Page {
    address: SocketAddr,
    told: Arc<AtomicU64>,
    _served: ServedPage,
}

fn page() -> &'static Page {
    static PAGE: OnceLock<Page> = OnceLock::new();
    PAGE.get_or_init(|| {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port of this machine");
        let address = listener.local_addr().expect("it is bound");
        let told = Arc::<AtomicU64>::default();
        let ring = Counting { told: Arc::clone(&told), history: WordHistory::default() };
        let options =
            WebOptions { permission: Permission::Change, slow: Duration::from_millis(50), ..WebOptions::default() };
        let served = start(listener, Arc::new(ring), &options).expect("a thread");
        Page { address, told, _served: served }
    })
}

fn holds(bytes: &[u8], part: &str) -> bool {
    bytes.to_ascii_lowercase().windows(part.len()).any(|window| window == part.as_bytes())
}

/// All that comes until the server closes; of a stream of events, which does not end, its head.
fn answer(stream: &mut TcpStream) -> Vec<u8> {
    let (mut answer, mut part) = (Vec::new(), [0; 4096]);
    while !holds(answer.get(..512).unwrap_or(&answer), "text/event-stream") {
        match stream.read(&mut part) {
            Ok(read @ 1..) => answer.extend_from_slice(&part[..read]),
            _ => break,
        }
    }
    answer
}

/// How many commands an input may ask for: none without a name of the server's own and JSON.
fn asked(bytes: &[u8]) -> u64 {
    let asked = ["host:", "application/json"].into_iter().all(|part| holds(bytes, part));
    let here = ["127.0.0.1", "localhost", "::1"].into_iter().any(|name| holds(bytes, name));
    let lower = bytes.to_ascii_lowercase();
    let commands = lower.windows(12).filter(|window| window == b"/api/command").count();
    if asked && here { commands as u64 } else { 0 }
}

fuzz_target!(|bytes: &[u8]| {
    // A command may be done after its connection has ended, so all are counted together.
    static ASKED: AtomicU64 = AtomicU64::new(0);
    let page = page();
    let asked = ASKED.fetch_add(asked(bytes), Ordering::Relaxed) + asked(bytes);
    let mut stream = TcpStream::connect(page.address).expect("the server goes on");
    stream.set_read_timeout(Some(PATIENCE)).expect("a time");
    // A server that has said its last word takes no more.
    let _ = stream.write_all(bytes);
    let _ = stream.shutdown(Shutdown::Write);
    let answer = answer(&mut stream);
    assert!(answer.is_empty() || answer.starts_with(b"HTTP/1."), "{}", String::from_utf8_lossy(&answer));
    assert!(page.told.load(Ordering::Relaxed) <= asked, "{}", String::from_utf8_lossy(bytes));
});
