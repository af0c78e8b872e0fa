//! What pages that look on cost the ring: the time from a word that is written to the end of the cycle that carries it,
//! at the speed of a real ring, with no page, with 200 that read, and with 200 that never read. The three take turns, so
//! that what else the machine does meets all of them alike.
//!
//! `cargo bench -p encoring-benches --bench page`
#![allow(
    clippy::unwrap_used,
    clippy::disallowed_methods,
    missing_docs,
    reason = "a benchmark measures real time"
)]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use encoring_dashboard::{WebOptions, start};
use encoring_sim::{Scenario, World};
use encoring_station::{Controlled, Options, Station};
use encoring_words::OutWord;
use hdrhistogram::Histogram;

/// Cycles that are timed in each turn, and turns.
const CYCLES: u32 = 2_000;
const TURNS: usize = 6;

/// Pages that are open.
const STREAMS: usize = 200;

/// What the pages do.
#[derive(Clone, Copy)]
enum Pages {
    None,
    Reading,
    NeverReading,
}

impl Pages {
    const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reading => "200 that read",
            Self::NeverReading => "200 that never read",
        }
    }

    fn open(self, page: SocketAddr) -> Vec<TcpStream> {
        let count = if matches!(self, Self::None) { 0 } else { STREAMS };
        let open = || {
            let mut stream = TcpStream::connect(page).unwrap();
            write!(stream, "GET /api/events HTTP/1.1\r\nHost: {page}\r\n\r\n").unwrap();
            stream
        };
        let streams: Vec<TcpStream> = (0..count).map(|_| open()).collect();
        if matches!(self, Self::Reading) {
            for mut stream in streams.iter().map(|stream| stream.try_clone().unwrap()) {
                thread::spawn(move || {
                    let mut bytes = [0; 16 * 1024];
                    while stream.read(&mut bytes).is_ok_and(|read| read > 0) {}
                });
            }
        }
        streams
    }
}

/// What was timed, and cycles that were dropped of all.
struct Row {
    pages: Pages,
    times: Histogram<u64>,
    dropped: u64,
    cycles: u64,
}

impl Row {
    fn new(pages: Pages) -> Self {
        Self { pages, times: Histogram::new(3).unwrap(), dropped: 0, cycles: 0 }
    }

    fn print(&self) {
        let us = |quantile: f64| self.times.value_at_quantile(quantile) / 1_000;
        let Self { pages, times, dropped, cycles } = self;
        let (name, most) = (pages.name(), times.max() / 1_000);
        println!("| {name} | {} | {} | {} | {most} | {dropped} of {cycles} |", us(0.5), us(0.99), us(0.999));
    }
}

fn turn(row: &mut Row) {
    let scenario = Scenario::built_in().unwrap();
    let units = scenario.devices.iter().map(|device| device.unit).collect();
    let station = Station::start(World::new(&scenario).unwrap(), Options::default()).unwrap();
    let ring = station.handle().clone();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let controlled = Controlled { ring: ring.clone(), units, gateway: None };
    let page = start(listener, Arc::new(controlled), &WebOptions::default()).unwrap();
    let streams = row.pages.open(address);
    for k in 0..CYCLES {
        let began = Instant::now();
        ring.write_out(1, OutWord(0x0200_0000 | k & 1)).unwrap();
        row.times.record(u64::try_from(began.elapsed().as_nanos()).unwrap()).unwrap();
    }
    let counters = ring.view().unwrap().counters;
    row.dropped += counters.dropped_cycles;
    row.cycles += counters.cycles;
    streams.iter().for_each(|stream| drop(stream.shutdown(std::net::Shutdown::Both)));
    drop(page);
    station.stop().unwrap();
}

fn main() {
    let mut rows = [Pages::None, Pages::Reading, Pages::NeverReading].map(Row::new);
    for _ in 0..TURNS {
        rows.iter_mut().for_each(turn);
    }
    println!("| pages | median in us | 99 % | 99.9 % | most | cycles dropped |\n|---|---|---|---|---|---|");
    rows.iter().for_each(Row::print);
}
