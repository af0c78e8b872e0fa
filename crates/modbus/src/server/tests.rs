use super::*;

mod misdeeds;

use crate::counters::Snapshot;
use crate::plain::{Plain, framed, image, requests};

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use encoring_words::{InWord, OutWord};
use tokio::io::{AsyncReadExt, AsyncWriteExt, DuplexStream, duplex};
use tokio::sync::oneshot;
use tokio::task::{JoinHandle, yield_now};
use tokio::time::Instant;

const ENCODERS: usize = 3;

struct Server {
    address: SocketAddr,
    image: SharedImage,
    counters: Arc<ServerCounts>,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Server {
    async fn start(options: Options) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let image = SharedImage::new(image(ENCODERS));
        let counters = Arc::new(ServerCounts::default());
        let (stop, stopped) = oneshot::channel();
        let stopped = async move {
            let _ = stopped.await;
        };
        let task = tokio::spawn(serve(listener, image.clone(), options, Arc::clone(&counters), stopped));
        Self { address, image, counters, stop, task }
    }

    async fn connect(&self) -> TcpStream {
        let client = TcpStream::connect(self.address).await.unwrap();
        client.set_nodelay(true).unwrap();
        client
    }

    fn seen(&self) -> Snapshot {
        self.counters.snapshot()
    }

    async fn until(&self, condition: impl Fn(Snapshot) -> bool) {
        while !condition(self.seen()) {
            yield_now().await;
        }
    }

    /// A new connection still gets a right answer.
    async fn goes_on(&self) {
        let mut client = self.connect().await;
        assert_eq!(ask(&mut client, &[4, 0, 0, 0, 2]).await, [4, 4, 0x80, 0x00, 0x80, 0x01]);
    }
}

/// The bytes of the next answer, header included; `None` when the connection is closed.
async fn next_answer(client: &mut (impl AsyncRead + Unpin)) -> Option<Vec<u8>> {
    let mut answer = vec![0; 6];
    client.read_exact(&mut answer).await.ok()?;
    let length = usize::from(u16::from_be_bytes([answer[4], answer[5]]));
    answer.resize(6 + length, 0);
    client.read_exact(&mut answer[6..]).await.ok()?;
    Some(answer)
}

async fn ask(client: &mut (impl AsyncRead + AsyncWrite + Unpin), pdu: &[u8]) -> Vec<u8> {
    client.write_all(&framed(0xBEEF, 1, pdu)).await.unwrap();
    let answer = next_answer(client).await.unwrap();
    assert_eq!(answer[..4], [0xBE, 0xEF, 0, 0]);
    answer[7..].to_vec()
}

/// Everything the server says to these bytes and the end of them, until it closes the connection.
async fn whole_answer(server: &Server, bytes: &[u8]) -> Vec<u8> {
    let mut client = server.connect().await;
    client.write_all(bytes).await.unwrap();
    // The server may have closed already.
    let _ = client.shutdown().await;
    let mut answer = Vec::new();
    let mut buffer = [0; 1024];
    // A connection that is closed over unread bytes is reset, after what was answered.
    while let Ok(count @ 1..) = client.read(&mut buffer).await {
        answer.extend(&buffer[..count]);
    }
    answer
}

/// What the rules say to a stream of bytes and its end.
fn plain_answer(plain: &mut Plain, mut bytes: &[u8]) -> Vec<u8> {
    let mut answers = Vec::new();
    while let [t1, t0, 0, 0, 0, length @ 2..=254, unit, rest @ ..] = bytes {
        let Some((pdu, after)) = rest.split_at_checked(usize::from(*length) - 1) else { break };
        let transaction = u16::from_be_bytes([*t1, *t0]);
        answers.extend(framed(transaction, *unit, &plain.respond(pdu)));
        bytes = after;
    }
    answers
}

async fn compare(server: &Server, plain: &mut Plain, bytes: &[u8]) {
    server.image.with(|shared| *shared = image(ENCODERS));
    plain.image = image(ENCODERS);
    let (answer, wanted) = (whole_answer(server, bytes).await, plain_answer(plain, bytes));
    assert_eq!(answer, wanted, "to {bytes:02X?}");
    server.image.with(|shared| assert_eq!(*shared, plain.image, "after {bytes:02X?}"));
}

#[tokio::test]
async fn whatever_changes_in_a_header_there_is_an_answer_or_an_end() {
    let server = Server::start(Options::default()).await;
    let mut plain = Plain::new(ENCODERS, RegisterMap::Plain, WordOrder::HighFirst);
    let [read, .., write, _] = requests();
    for pdu in [read, write] {
        let frame = framed(0x1234, 1, &pdu);
        // The transaction and the unit do not end the connection, so all their values can use one.
        let mut stream = Vec::new();
        for at in [0, 1, 6] {
            for value in 0..=u8::MAX {
                let mut changed = frame.clone();
                changed[at] = value;
                stream.extend(changed);
            }
        }
        compare(&server, &mut plain, &stream).await;
        for at in [2, 3, 4, 5] {
            for value in 0..=u8::MAX {
                let mut changed = frame.clone();
                changed[at] = value;
                compare(&server, &mut plain, &changed).await;
            }
        }
    }
    server.goes_on().await;
}

#[tokio::test]
async fn whatever_length_a_stream_has_there_is_an_answer_or_an_end() {
    let server = Server::start(Options::default()).await;
    let mut plain = Plain::new(ENCODERS, RegisterMap::Plain, WordOrder::HighFirst);
    for pdu in requests() {
        let frame = framed(0x1234, 1, &pdu);
        for length in 0..frame.len() {
            compare(&server, &mut plain, &frame[..length]).await;
        }
    }
    // The header says what came, so that each is one request, until the length is not allowed any more.
    for length in 0..=260 {
        let pdu = [vec![16, 0, 2, 0, 2, 4], vec![0xAB; 260]].concat();
        compare(&server, &mut plain, &framed(0x1234, 1, &pdu[..length])).await;
    }
    server.goes_on().await;
}

#[tokio::test]
async fn any_unit_is_answered_with_its_own_number() {
    let server = Server::start(Options::default()).await;
    let mut client = server.connect().await;
    for unit in 0..=u8::MAX {
        let transaction = u16::from(unit) << 8;
        client.write_all(&framed(transaction, unit, &[4, 0, 0, 0, 1])).await.unwrap();
        let answer = next_answer(&mut client).await.unwrap();
        assert_eq!(answer, framed(transaction, unit, &[4, 2, 0x80, 0x00]));
    }
}

#[tokio::test]
async fn requests_in_one_segment_are_answered_in_order() {
    let server = Server::start(Options::default()).await;
    let mut plain = Plain::new(ENCODERS, RegisterMap::Plain, WordOrder::HighFirst);
    let mut stream = Vec::new();
    for k in 0..200 {
        for (index, pdu) in (0..).zip(requests()) {
            stream.extend(framed(10 * k + index, 1, &pdu));
        }
        stream.extend(framed(10 * k + 9, 1, &[3, 0, 0, 0, 0]));
    }
    compare(&server, &mut plain, &stream).await;
    assert_eq!(server.seen().requests, 1200);
    assert_eq!(server.seen().exceptions, 200);
}

#[tokio::test]
async fn a_request_may_come_byte_by_byte() {
    let server = Server::start(Options::default()).await;
    let mut client = server.connect().await;
    for pdu in requests() {
        for byte in framed(7, 1, &pdu) {
            client.write_all(&[byte]).await.unwrap();
            client.flush().await.unwrap();
            yield_now().await;
        }
        assert_eq!(next_answer(&mut client).await.unwrap()[7], pdu[0]);
    }
}

#[tokio::test]
async fn what_is_not_modbus_ends_its_connection_and_no_other() {
    let server = Server::start(Options::default()).await;
    let mut other = server.connect().await;
    assert_eq!(ask(&mut other, &[4, 0, 0, 0, 1]).await, [4, 2, 0x80, 0x00]);
    let bad: [&[u8]; 5] = [
        b"GET / HTTP/1.1\r\n\r\n",
        &[0, 1, 0, 1, 0, 6, 1, 3, 0, 0, 0, 1],
        &[0, 1, 0, 0, 0, 0, 1, 3, 0, 0, 0, 1],
        &[0, 1, 0, 0, 0, 1, 1],
        &[0, 1, 0, 0, 0, 255, 1],
    ];
    for (before, bytes) in (0..).zip(bad) {
        assert_eq!(server.seen().closed_bad_frames, before);
        let mut client = server.connect().await;
        client.write_all(bytes).await.unwrap();
        // The client leaves its side open: it is the server that ends this.
        assert_eq!(next_answer(&mut client).await, None);
        assert_eq!(server.seen().closed_bad_frames, before + 1);
    }
    assert_eq!(ask(&mut other, &[4, 0, 0, 0, 1]).await, [4, 2, 0x80, 0x00]);
}

#[tokio::test]
async fn an_unknown_function_with_a_wrong_byte_count_is_exception_01_and_the_connection_stays() {
    let server = Server::start(Options::default()).await;
    let mut client = server.connect().await;
    assert_eq!(ask(&mut client, &[0x0F, 0x00, 0x00, 0x03, 0xE8, 0x01, 0xFF]).await, [0x8F, 1]);
    assert_eq!(ask(&mut client, &[0x10, 0, 0, 0, 2, 3, 1, 2, 3]).await, [0x90, 3]);
    assert_eq!(ask(&mut client, &[4, 0, 0, 0, 1]).await, [4, 2, 0x80, 0x00]);
    assert_eq!(server.seen().exceptions, 2);
    assert_eq!(server.seen().closed_bad_frames, 0);
}

#[tokio::test]
async fn low_first_holds_for_a_whole_server() {
    let options = Options { word_order: WordOrder::LowFirst, ..Options::default() };
    let server = Server::start(options).await;
    let mut client = server.connect().await;
    ask(&mut client, &[16, 0, 0, 0, 2, 4, 0x27, 0x0F, 0xC2, 0x00]).await;
    assert_eq!(server.image.with(|image| image.out()[0]), OutWord(0xC200_270F));
    assert_eq!(ask(&mut client, &[4, 0, 0, 0, 2]).await, [4, 4, 0x80, 0x01, 0x80, 0x00]);
}

#[tokio::test]
async fn the_inline_layout_holds_for_a_whole_server() {
    let options =
        Options { layout: RegisterMap::Inline, word_order: WordOrder::LowFirst, ..Options::default() };
    let server = Server::start(options).await;
    let mut client = server.connect().await;
    ask(&mut client, &[16, 0x1F, 0x46, 0, 2, 4, 0x27, 0x0F, 0xC2, 0x00]).await;
    assert_eq!(server.image.with(|image| image.out()[0]), OutWord(0xC200_270F));
    assert_eq!(ask(&mut client, &[3, 0x1F, 0x40, 0, 2]).await, [3, 4, 0x80, 0x01, 0x80, 0x00]);
    assert_eq!(ask(&mut client, &[23, 0, 0, 0, 2, 0, 0, 0, 1, 2, 1, 2]).await, [0x97, 1]);
    assert_eq!(ask(&mut client, &[3, 0, 0, 0, 1]).await, [0x83, 2]);
}

#[tokio::test]
async fn two_writes_of_one_register_each_leave_the_word_torn_between_them() {
    let server = Server::start(Options::default()).await;
    server.image.with(|image| image.out_mut()[0] = OutWord(0x0000_FFFF));
    let mut client = server.connect().await;
    ask(&mut client, &[6, 0, 0, 0xC2, 0x00]).await;
    assert_eq!(server.image.with(|image| image.out()[0]), OutWord(0xC200_FFFF));
    ask(&mut client, &[6, 0, 1, 0x27, 0x0F]).await;
    assert_eq!(server.image.with(|image| image.out()[0]), OutWord(0xC200_270F));
}

#[tokio::test]
async fn both_words_are_read_and_written_at_once_while_the_ring_runs() {
    let server = Server::start(Options::default()).await;
    server.image.with(|image| (image.out_mut()[0], image.input_mut()[0]) = (OutWord(0), InWord(0)));
    let done = Arc::new(AtomicBool::new(false));
    let ring = {
        let (image, done) = (server.image.clone(), Arc::clone(&done));
        thread::spawn(move || {
            let mut torn = 0;
            for k in (0..=0xFFFF).cycle() {
                let out = image.with(|image| {
                    image.input_mut()[0] = InWord(k << 16 | k);
                    image.out()[0]
                });
                torn += u32::from(out.high() != out.low());
                if done.load(Ordering::Relaxed) {
                    break;
                }
            }
            torn
        })
    };
    let mut client = server.connect().await;
    for k in 0..2000_u16 {
        let [h, l] = k.to_be_bytes();
        assert_eq!(ask(&mut client, &[16, 0, 0, 0, 2, 4, h, l, h, l]).await, [16, 0, 0, 0, 2]);
        let read = ask(&mut client, &[4, 0, 0, 0, 2]).await;
        assert_eq!(read[2..4], read[4..6]);
        let both = ask(&mut client, &[23, 0x03, 0xE8, 0, 2, 0, 0, 0, 2, 4, l, h, l, h]).await;
        assert_eq!(both[2..4], both[4..6]);
    }
    done.store(true, Ordering::Relaxed);
    assert_eq!(ring.join().unwrap(), 0, "words seen torn by the ring");
}

#[tokio::test]
async fn a_connection_over_the_limit_is_closed_at_once_and_a_place_is_free_again_after_one_ends() {
    let server = Server::start(Options { connections: 2, ..Options::default() }).await;
    let (mut first, mut second) = (server.connect().await, server.connect().await);
    ask(&mut first, &[4, 0, 0, 0, 1]).await;
    ask(&mut second, &[4, 0, 0, 0, 1]).await;
    assert_eq!(server.seen().open_connections, 2);

    let mut third = server.connect().await;
    assert_eq!(next_answer(&mut third).await, None);
    assert_eq!(server.seen().refused_connections, 1);
    ask(&mut first, &[4, 0, 0, 0, 1]).await;

    drop(second);
    server.until(|seen| seen.open_connections == 1).await;
    server.goes_on().await;
    assert_eq!(server.seen().refused_connections, 1);
}

#[tokio::test]
async fn an_idle_connection_is_closed() {
    let server = Server::start(Options { idle: Duration::from_millis(20), ..Options::default() }).await;
    let mut client = server.connect().await;
    ask(&mut client, &[4, 0, 0, 0, 1]).await;
    assert_eq!(next_answer(&mut client).await, None);
    assert_eq!(server.seen().closed_idle, 1);
    server.until(|seen| seen.open_connections == 0).await;
}

/// A conversation in virtual time.
fn converse_with(capacity: usize) -> (DuplexStream, Arc<ServerCounts>, JoinHandle<()>) {
    let (client, stream) = duplex(capacity);
    let counters = Arc::new(ServerCounts::default());
    let task = {
        let counters = Arc::clone(&counters);
        let image = SharedImage::new(image(ENCODERS));
        tokio::spawn(async move {
            converse(stream, &image, Options::default(), &counters, &GatewayFaults::default(), 1).await;
        })
    };
    (client, counters, task)
}

#[tokio::test(start_paused = true)]
async fn bytes_that_make_no_whole_request_do_not_keep_a_connection_open() {
    let start = Instant::now();
    let (mut client, counters, task) = converse_with(1024);
    sleep(Duration::from_secs(50)).await;
    ask(&mut client, &[4, 0, 0, 0, 1]).await;
    let frame = framed(1, 1, &[4, 0, 0, 0, 1]);
    for byte in &frame[..11] {
        sleep(Duration::from_secs(5)).await;
        client.write_all(&[*byte]).await.unwrap();
    }
    assert_eq!(counters.snapshot().closed_idle, 0, "55 s after the last whole request");
    task.await.unwrap();
    assert_eq!(start.elapsed().as_secs(), 110);
    assert_eq!(counters.snapshot().closed_idle, 1);
    assert_eq!(counters.snapshot().requests, 1);
}

#[tokio::test(start_paused = true)]
async fn a_client_that_takes_no_answers_is_closed() {
    let (mut client, counters, task) = converse_with(64);
    let flood = async move {
        let frame = framed(1, 1, &[4, 0, 0, 0, 6]);
        while client.write_all(&frame).await.is_ok() {}
    };
    let (ended, ()) = tokio::join!(task, flood);
    ended.unwrap();
    assert_eq!(counters.snapshot().closed_idle, 1);
}

#[tokio::test]
async fn a_client_that_leaves_in_the_middle_of_a_request_is_no_bad_frame() {
    let server = Server::start(Options::default()).await;
    let frame = framed(1, 1, &[4, 0, 0, 0, 1]);
    assert_eq!(whole_answer(&server, &frame[..8]).await, []);
    server.until(|seen| seen.open_connections == 0).await;
    assert_eq!(server.seen(), Snapshot::default());
}

#[tokio::test]
async fn accept_errors_are_counted_and_do_not_end_the_server() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let mut errors = 3;
    let accept = move |context: &mut Context<'_>| {
        if errors > 0 {
            errors -= 1;
            return Poll::Ready(Err(io::ErrorKind::ConnectionAborted.into()));
        }
        listener.poll_accept(context).map_ok(|(socket, _)| socket)
    };
    let counters = Arc::new(ServerCounts::default());
    let image = SharedImage::new(image(ENCODERS));
    let served = serve_from(
        accept,
        image,
        Options::default(),
        Arc::clone(&counters),
        GatewayFaults::default(),
        std::future::pending(),
    );
    let served = tokio::spawn(served);
    let mut client = TcpStream::connect(address).await.unwrap();
    assert_eq!(ask(&mut client, &[4, 0, 0, 0, 1]).await, [4, 2, 0x80, 0x00]);
    assert_eq!(counters.snapshot().accept_errors, 3);
    served.abort();
}

#[tokio::test(start_paused = true)]
async fn a_lasting_accept_error_is_met_with_patience_and_can_be_stopped() {
    let accept = |_: &mut Context<'_>| Poll::Ready(Err(io::ErrorKind::Other.into()));
    let counters = Arc::new(ServerCounts::default());
    let image = SharedImage::new(image(ENCODERS));
    let stop = sleep(Duration::from_secs(1));
    serve_from(accept, image, Options::default(), Arc::clone(&counters), GatewayFaults::default(), stop)
        .await;
    let errors = counters.snapshot().accept_errors;
    assert!((50..=100).contains(&errors), "{errors} errors in a second");
}

#[tokio::test]
async fn stop_closes_every_connection_and_then_the_server_returns() {
    let server = Server::start(Options::default()).await;
    let (mut quiet, mut busy) = (server.connect().await, server.connect().await);
    ask(&mut quiet, &[4, 0, 0, 0, 1]).await;
    busy.write_all(&[0, 1, 0]).await.unwrap();
    server.until(|seen| seen.open_connections == 2).await;

    server.stop.send(()).unwrap();
    server.task.await.unwrap();
    assert_eq!(server.counters.snapshot().open_connections, 0);
    assert_eq!(next_answer(&mut quiet).await, None);
    assert_eq!(next_answer(&mut busy).await, None);
}
