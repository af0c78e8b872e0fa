use super::*;

mod coupler;
mod diagnosis;
mod misbehaving;
#[cfg(unix)]
mod serial;

use super::link::EVENTS_MAX;
use crate::place::WordOrder;
use crate::plain::image;
use crate::registers::RegisterMap;
use crate::{Options, ServerCounts, serve};

use std::net::SocketAddr;
use std::sync::Arc;
use std::thread::{self, JoinHandle};

use encoring_bus::{Cause, Link, SharedImage};
use tokio::net::TcpSocket;
use tokio::sync::oneshot;

/// Our own server on a thread of its own.
struct Server {
    address: SocketAddr,
    image: SharedImage,
    counters: Arc<ServerCounts>,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Server {
    fn start(encoders: usize, options: Options) -> Self {
        Self::on(held().0, encoders, options)
    }

    fn on(held: TcpSocket, encoders: usize, options: Options) -> Self {
        let image = SharedImage::new(image(encoders));
        let (stop, stopped) = oneshot::channel::<()>();
        let (tell, told) = std::sync::mpsc::channel();
        let served = image.clone();
        let counters = Arc::new(ServerCounts::default());
        let counted = Arc::clone(&counters);
        let thread = thread::spawn(move || {
            let runtime = Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let listener = held.listen(64).unwrap();
                tell.send(listener.local_addr().unwrap()).unwrap();
                let stopped = async {
                    let _ = stopped.await;
                };
                serve(listener, served, options, counted, stopped).await;
            });
        });
        Self { address: told.recv().unwrap(), image, counters, stop: Some(stop), thread: Some(thread) }
    }

    fn address(&self, options: &str) -> Address {
        format!("modbus-tcp://{}{options}", self.address).parse().unwrap()
    }

    fn client(&self, options: &str) -> Client {
        Client::new(self.address(options)).unwrap()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.take().unwrap().send(()).unwrap();
        self.thread.take().unwrap().join().unwrap();
    }
}

/// A port that nobody else gets, and at which nothing listens yet.
fn held() -> (TcpSocket, SocketAddr) {
    let socket = TcpSocket::new_v4().unwrap();
    socket.bind(([127, 0, 0, 1], 0).into()).unwrap();
    let at = socket.local_addr().unwrap();
    (socket, at)
}

fn read(client: &mut Client, first: usize, count: usize) -> Result<Vec<u32>, BusError> {
    let mut input = vec![InWord(0); count];
    client.cycle(None, first, &mut input)?;
    Ok(input.into_iter().map(|word| word.0).collect())
}

#[test]
fn words_come_and_go_in_either_order_and_from_either_table() {
    for order in [WordOrder::HighFirst, WordOrder::LowFirst] {
        let server = Server::start(3, Options { word_order: order, ..Options::default() });
        for table in ["input:0", "holding:1000"] {
            let mut client = server.client(&format!("?order={order}&in={table}"));
            assert_eq!(read(&mut client, 0, 3).unwrap(), [0x8000_8001, 0x8002_8003, 0x8004_8005]);
            assert_eq!(read(&mut client, 1, 1).unwrap(), [0x8002_8003]);
            assert_eq!(client.out(2).unwrap(), OutWord(0x4004_4005));

            let mut input = [InWord(0)];
            client.cycle(Some((1, OutWord(0xC200_270F))), 2, &mut input).unwrap();
            assert_eq!(input, [InWord(0x8004_8005)]);
            server.image.with(|image| {
                assert_eq!(image.out(), [OutWord(0x4000_4001), OutWord(0xC200_270F), OutWord(0x4004_4005)]);
                image.out_mut()[1] = OutWord(0x4002_4003);
            });
        }
    }
}

#[test]
fn our_own_server_is_an_inline_coupler_to_the_client_in_either_order_and_from_either_table() {
    for order in [WordOrder::HighFirst, WordOrder::LowFirst] {
        let layout = RegisterMap::Inline;
        let server = Server::start(3, Options { layout, word_order: order, ..Options::default() });
        for table in ["holding:8000", "input:8000"] {
            let mut client = server.client(&format!("?layout=inline&order={order}&in={table}"));
            assert_eq!(read(&mut client, 0, 3).unwrap(), [0x8000_8001, 0x8002_8003, 0x8004_8005]);
            assert_eq!(client.out(2).unwrap(), OutWord(0x4004_4005));
            let mut input = [InWord(0)];
            client.cycle(Some((1, OutWord(0xC200_270F))), 2, &mut input).unwrap();
            assert_eq!(input, [InWord(0x8004_8005)]);
            server.image.with(|image| {
                assert_eq!(image.out(), [OutWord(0x4000_4001), OutWord(0xC200_270F), OutWord(0x4004_4005)]);
                image.out_mut()[1] = OutWord(0x4002_4003);
            });
            let error = client.out(3).unwrap_err();
            assert_eq!(error, BusError::NoEncoder { position: 3, encoders: 3 });
        }
    }
    let longest = Server::start(128, Options { layout: RegisterMap::Inline, ..Options::default() });
    let mut client = longest.client("?layout=inline");
    let words: Vec<u32> = (0..128).map(|k| (0x8000 + 2 * k) << 16 | (0x8001 + 2 * k)).collect();
    assert_eq!(read(&mut client, 0, 128).unwrap(), words);
    assert_eq!(client.out(127).unwrap(), OutWord(0x40FE_40FF));
}

fn drained(client: &mut Client) -> Vec<Link> {
    std::iter::from_fn(|| client.link_event()).map(|event| event.what).collect()
}

#[test]
fn as_many_words_as_a_ring_has_are_read_in_pieces_that_tear_none() {
    let server = Server::start(128, Options::default());
    let mut client = server.client("?in=holding:1000");
    let words: Vec<u32> = (0..128).map(|k| (0x8000 + 2 * k) << 16 | (0x8001 + 2 * k)).collect();
    assert_eq!(read(&mut client, 0, 128).unwrap(), words);
    assert_eq!(read(&mut client, 3, 63).unwrap(), words[3..66]);
}

#[test]
fn nothing_is_written_until_it_is_asked_for() {
    let server = Server::start(2, Options::default());
    let mut client = server.client("");
    read(&mut client, 0, 2).unwrap();
    assert_eq!(client.out(0).unwrap(), OutWord(0x4000_4001));
    client.wait(Duration::from_millis(1));
    server.image.with(|image| assert_eq!(image.out(), [OutWord(0x4000_4001), OutWord(0x4002_4003)]));
}

#[test]
fn a_write_alone_needs_no_room_for_in_words() {
    let server = Server::start(2, Options::default());
    let mut client = server.client("");
    client.cycle(Some((1, OutWord(7))), 0, &mut []).unwrap();
    server.image.with(|image| assert_eq!(image.out(), [OutWord(0x4000_4001), OutWord(7)]));
}

#[test]
fn an_encoder_that_is_not_there_is_refused_and_the_connection_kept() {
    let server = Server::start(2, Options::default());
    let mut client = server.client("");
    let error = read(&mut client, 2, 1).unwrap_err();
    assert_eq!(error, BusError::NotShown { position: 2, encoders: 2 });
    assert_eq!(read(&mut client, 0, 3), Err(BusError::NotShown { position: 2, encoders: 2 }));
    assert_eq!(client.out(7), Err(BusError::NotShown { position: 7, encoders: 2 }));
    let error = client.cycle(Some((2, OutWord(1))), 0, &mut [InWord(0)]).unwrap_err();
    assert_eq!(error, ModbusError::Refused { function: 16, register: 4, exception: 2 }.into());
    assert_eq!(read(&mut client, 1, 1).unwrap(), [0x8002_8003]);
    assert_eq!(drained(&mut client), [Link::Up { down_for: Duration::ZERO }]);
    let error = read(&mut client, usize::MAX, 2).unwrap_err();
    assert_eq!(error, BusError::NoEncoder { position: usize::MAX, encoders: 32_768 });
    assert_eq!(client.out(32_768).unwrap_err(), BusError::NoEncoder { position: 32_768, encoders: 32_768 });
}

#[test]
fn a_server_that_closed_between_two_calls_costs_no_error() {
    let idle = Span::from_millis(20);
    let server = Server::start(1, Options { idle, ..Options::default() });
    let mut client = server.client("");
    for closed in 1..=4 {
        for _ in 0..2 {
            assert_eq!(read(&mut client, 0, 1).unwrap(), [0x8000_8001]);
        }
        while server.counters.snapshot().closed_idle < closed {
            client.wait(Duration::from_millis(1));
        }
    }
    // Nor a word: nothing was lost.
    assert_eq!(drained(&mut client), [Link::Up { down_for: Duration::ZERO }]);
}

#[test]
fn without_a_listener_there_is_no_connection_and_then_a_pause() {
    let (_held, at) = held();
    let address = format!("modbus-tcp://{at}?timeout_ms=40");
    let mut client = Client::new(address.parse().unwrap()).unwrap().reconnecting(Reconnect::new(
        Duration::from_secs(3_600),
        1,
        Duration::from_secs(3_600),
    ));
    let refused = io::ErrorKind::ConnectionRefused;
    assert_eq!(read(&mut client, 0, 1), Err(BusError::NoConnection(Cause::System(refused))));
    let error = read(&mut client, 0, 1).unwrap_err();
    let BusError::NoConnection(Cause::Waiting { last, next }) = error else { panic!("{error}") };
    assert_eq!(last, refused);
    assert!(next > Duration::from_secs(3_000), "{next}");
    let next = Duration::from_secs(3_600);
    assert_eq!(drained(&mut client), [Link::Failed { cause: refused, next }]);
}

#[test]
fn a_listener_that_comes_late_is_found() {
    let (held, at) = held();
    let pause = Duration::from_millis(1);
    let mut client = Client::new(format!("modbus-tcp://{at}").parse().unwrap())
        .unwrap()
        .reconnecting(Reconnect::new(pause, 2, pause));
    for _ in 0..3 {
        read(&mut client, 0, 1).unwrap_err();
    }
    let server = Server::on(held, 1, Options::default());
    assert_eq!(read(&mut client, 0, 1).unwrap(), [0x8000_8001]);
    let events = drained(&mut client);
    assert_eq!(events.len(), 4);
    assert_eq!(events[3], Link::Up { down_for: Duration::ZERO });
    drop(server);
}

#[test]
fn link_events_that_nobody_asks_for_are_bounded() {
    let (_held, at) = held();
    let mut client = Client::new(format!("modbus-tcp://{at}").parse().unwrap())
        .unwrap()
        .reconnecting(Reconnect::new(Duration::ZERO, 1, Duration::ZERO));
    for _ in 0..100 {
        read(&mut client, 0, 1).unwrap_err();
    }
    assert_eq!(drained(&mut client).len(), EVENTS_MAX);
}

#[test]
fn a_peer_that_takes_connections_and_never_answers_is_told_with_what_may_be_wrong() {
    // The system takes the connections for it.
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let at = listener.local_addr().unwrap();
    let (_held, nobody) = held();
    let advice = |address: String| {
        let mut client = Client::new(format!("{address}?timeout_ms=20&unit=3").parse().unwrap()).unwrap();
        read(&mut client, 0, 1).unwrap_err();
        client.advice()
    };
    let told = advice(format!("modbus-tcp://{at}")).unwrap();
    assert!(told.contains("unit=3 was asked") && told.contains(&format!("modbus-rtu-tcp://{at}")), "{told}");
    let told = advice(format!("modbus-rtu-tcp://{at}")).unwrap();
    assert!(told.contains(&format!("(modbus-tcp://{at})")) && told.contains("encoring probe"), "{told}");
    assert_eq!(advice(format!("modbus-tcp://{nobody}")), None, "nobody is there");
    let server = Server::start(1, Options::default());
    let mut client = server.client("");
    assert_eq!(client.advice(), None);
    read(&mut client, 0, 1).unwrap();
    assert_eq!(client.advice(), None);
}

#[test]
fn a_gateway_that_is_too_slow_is_told_with_a_time_out_that_has_room_for_a_call() {
    let ms = Duration::from_millis;
    let told = advice::slow(ms(250), ms(500));
    assert!(
        told.contains("come after 250 ms") && told.contains("in timeout_ms=500: with timeout_ms=1000 "),
        "{told}"
    );
    assert!(advice::slow(ms(490), ms(500)).contains("with timeout_ms=2000 "));
    assert!(advice::slow(ms(30), ms(60)).contains("with timeout_ms=200 "), "never less than it needs");
    assert!(advice::slow(ms(40_000), ms(60_000)).contains("with timeout_ms=60000 "), "the most there is");
}

#[test]
fn halves_that_are_exchanged_in_writes_alone_are_cured_by_the_order_of_out() {
    let cure = |options: &str| {
        let client = Client::new(format!("modbus-tcp://gateway{options}").parse().unwrap()).unwrap();
        client.cure_of_writes(Misread::Halves).unwrap()
    };
    assert!(cure("").starts_with("order_out=low-first in the address"));
    assert!(cure("?order_out=low-first").starts_with("order_out=high-first in the address"));
}

#[test]
fn exchanged_halves_are_cured_by_the_order_or_by_the_registers_beside() {
    let cure = |options: &str| {
        let client = Client::new(format!("modbus-tcp://gateway{options}").parse().unwrap()).unwrap();
        client.cure(Misread::Halves).unwrap()
    };
    let told = cure("");
    assert!(told.starts_with("order=low-first in the address, or in=input:1 if the registers"), "{told}");
    let told = cure("?in=holding:300&order=low-first");
    assert!(
        told.starts_with("order=high-first in the address, or in=holding:299 or in=holding:301 if"),
        "{told}"
    );
}
