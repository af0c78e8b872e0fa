//! What the master's side costs: services a second in this process, beside the bare cycles of the same ring, and over
//! Modbus TCP, beside the limit that the ring's cycle and the settling rule set.
#![allow(missing_docs, clippy::unwrap_used, clippy::disallowed_methods, reason = "a benchmark")]

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::thread;
use std::time::{Duration as Real, Instant as Clock};

use encoring_bus::{Bus, EncoderMaster};
use encoring_host::service::read;
use encoring_modbus::{Address, Client, ServerCounts};
use encoring_sim::{Scenario, World};
use encoring_station::{Options, Simulated, Speed, Station};
use encoring_words::{Duration, InWord, Model, Parameter};

const PATIENCE: Duration = Duration::from_secs(10);
const IN_PROCESS: u32 = 100_000;
const OVER_MODBUS_FOR: Real = Real::from_secs(4);

fn world() -> World {
    let scenario = Scenario::parse("bench", &encoring_benches::scenario(3), Path::new("")).unwrap();
    World::new(&scenario).unwrap()
}

/// Reads the numerator of the encoder at position 1 again and again.
fn services<B: Bus>(bus: &mut B, more: impl Fn(u32) -> bool) -> (u32, Real) {
    let mut master = EncoderMaster::new(bus, 1, PATIENCE, Arc::new(AtomicBool::new(false))).unwrap();
    let started = Clock::now();
    let mut done = 0;
    while more(done) {
        assert_eq!(read(&mut master, Model::Ce100M, Parameter::Numerator).unwrap().value, 4096);
        done += 1;
    }
    (done, started.elapsed())
}

fn in_process() {
    let mut bus = Simulated::new(world(), Speed::Max);
    let before = bus.now();
    let (done, took) = services(&mut bus, |done| done < IN_PROCESS);
    let cycles = bus.now().since(before).as_nanos() / bus.world().with(|world| world.cycle_time()).as_nanos();
    let mut bare = Simulated::new(world(), Speed::Max);
    let started = Clock::now();
    for _ in 0..cycles {
        bare.cycle(None, 1, &mut [InWord(0)]).unwrap();
    }
    let bare = started.elapsed();
    println!("| services | cycles each | services/s | bare cycles/s | of the time of the bare cycles |");
    println!("|--:|--:|--:|--:|--:|");
    println!(
        "| {done} | {:.2} | {:.0} | {:.0} | {:.2} times |\n",
        cycles as f64 / f64::from(done),
        f64::from(done) / took.as_secs_f64(),
        cycles as f64 / bare.as_secs_f64(),
        took.as_secs_f64() / bare.as_secs_f64(),
    );
}

fn over_modbus(settle: Duration) {
    let station = Station::start(world(), Options::default()).unwrap();
    let cycle = Real::from_nanos(station.first_view().cycle_ns);
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    listener.set_nonblocking(true).unwrap();
    let port = listener.local_addr().unwrap().port();
    let image = station.handle().image().clone();
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let server = thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            let listener = tokio::net::TcpListener::from_std(listener).unwrap();
            let options = encoring_modbus::Options::default();
            let stopped = async move {
                let _ = stopped.await;
            };
            encoring_modbus::serve(listener, image, options, Arc::new(ServerCounts::default()), stopped)
                .await;
        });
    });
    let mut client = Client::new(Address { settle, ..Address::tcp("127.0.0.1", port) }).unwrap();
    let started = Clock::now();
    let (done, took) = services(&mut client, |_| started.elapsed() < OVER_MODBUS_FOR);
    drop(client);
    drop(stop);
    server.join().unwrap();
    station.stop().unwrap();
    // The word before the request stands for the settling time. A word is taken at the end of the cycle in which it
    // came, half a cycle later on average, and answered by the next one; so it goes for the request and for its end.
    let limit = 1.0 / (settle.as_nanos() as f64 * 1e-9 + 3.0 * cycle.as_secs_f64());
    let rate = f64::from(done) / took.as_secs_f64();
    println!("| {settle} | {done} | {rate:.0} | {limit:.0} | {:.2} |", rate / limit);
}

fn main() {
    in_process();
    println!("| settling time | services | services/s | limit | of the limit |");
    println!("|--:|--:|--:|--:|--:|");
    for settle in [2, 5, 20].map(Duration::from_millis) {
        over_modbus(settle);
    }
}
