//! A gateway that answers, but not as it should. Every call gets the error that fits, and the next one its own answer.

use super::*;

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicU32, Ordering};

use crate::error::Garbled;

/// What a gateway does with a good answer, which is a whole frame.
type Spoil = fn(&[u8]) -> Vec<u8>;

#[derive(Clone, Copy)]
enum Act {
    Answer,
    Spoiled(Spoil),
    /// The same, and then it hangs up.
    SpoiledAndGone(Spoil),
    /// The answer comes when the next request has come, on whatever connection.
    Late,
}

/// IN and OUT of every position are the number of the request, counted over all connections.
struct Gateway {
    address: String,
    requests: Arc<AtomicU32>,
}

impl Gateway {
    fn start(script: Vec<Act>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("modbus-tcp://{}?unit=9&timeout_ms=800", listener.local_addr().unwrap());
        let requests = Arc::new(AtomicU32::new(0));
        let counted = Arc::clone(&requests);
        // It ends with the tests.
        thread::spawn(move || serve_badly(&listener, script, &counted));
        Self { address, requests }
    }

    fn client(&self) -> Client {
        Client::new(self.address.parse().unwrap()).unwrap()
    }

    fn requests(&self) -> u32 {
        self.requests.load(Ordering::SeqCst)
    }
}

fn serve_badly(listener: &TcpListener, script: Vec<Act>, requests: &AtomicU32) {
    let mut script = script.into_iter();
    let mut late: Option<(TcpStream, Vec<u8>)> = None;
    for stream in listener.incoming() {
        let mut stream = stream.unwrap();
        loop {
            let mut header = [0; 7];
            if stream.read_exact(&mut header).is_err() {
                break;
            }
            let mut pdu = vec![0; usize::from(header[5]) - 1];
            stream.read_exact(&mut pdu).unwrap();
            let number = requests.fetch_add(1, Ordering::SeqCst) + 1;
            if let Some((mut old, answer)) = late.take() {
                // Nobody may be there any more.
                let _ = old.write_all(&answer);
            }
            let mut answer = match pdu[0] {
                16 => pdu[..5].to_vec(),
                function => {
                    let count = pdu[4];
                    let word = number.to_be_bytes();
                    let words = word.iter().copied().cycle().take(2 * usize::from(count));
                    [function, 2 * count].into_iter().chain(words).collect()
                }
            };
            answer.splice(0..0, header);
            fix(&mut answer);
            let (bytes, goes) = match script.next().unwrap_or(Act::Answer) {
                Act::Answer => (answer, false),
                Act::Spoiled(spoil) => (spoil(&answer), false),
                Act::SpoiledAndGone(spoil) => (spoil(&answer), true),
                Act::Late => {
                    late = Some((stream.try_clone().unwrap(), answer));
                    continue;
                }
            };
            let _ = stream.write_all(&bytes);
            if goes {
                break;
            }
        }
    }
}

/// The length field as the frame is.
fn fix(frame: &mut [u8]) {
    frame[5] = frame.len() as u8 - 6;
}

fn garbled(got: Garbled) -> BusError {
    ModbusError::Garbled { function: 4, register: 0, got }.into()
}

const SILENCE: BusError = BusError::NoAnswer { within: Duration::from_millis(800) };
const GONE: BusError = BusError::NoConnection(Cause::System(io::ErrorKind::ConnectionAborted));

#[test]
fn each_misbehaviour_gives_its_error_and_the_next_call_its_own_answer() {
    let cases: [(&str, Act, Option<BusError>); 18] = [
        ("late", Act::Late, Some(SILENCE)),
        ("dropped", Act::Spoiled(|_| Vec::new()), Some(SILENCE)),
        ("doubled", Act::Spoiled(|good| [good, good].concat()), None),
        (
            "short",
            Act::Spoiled(|good| {
                let mut short = good[..11].to_vec();
                short[8] = 2;
                fix(&mut short);
                short
            }),
            Some(garbled(Garbled::Registers { got: 1, wanted: 2 })),
        ),
        (
            "long",
            Act::Spoiled(|good| {
                let mut long = [good, &[0xAA, 0xBB]].concat();
                long[8] = 6;
                fix(&mut long);
                long
            }),
            Some(garbled(Garbled::Registers { got: 3, wanted: 2 })),
        ),
        (
            "empty",
            Act::Spoiled(|good| {
                let mut empty = good[..7].to_vec();
                fix(&mut empty);
                empty
            }),
            Some(garbled(Garbled::Foreign)),
        ),
        (
            "fewer bytes than its count",
            Act::Spoiled(|good| {
                let mut short = good[..11].to_vec();
                fix(&mut short);
                short
            }),
            Some(garbled(Garbled::Foreign)),
        ),
        (
            "wrong function",
            Act::Spoiled(|good| with(good, 7, 3)),
            Some(garbled(Garbled::Function { got: 3, wanted: 4 })),
        ),
        (
            "wrong unit",
            Act::Spoiled(|good| with(good, 6, 8)),
            Some(garbled(Garbled::Unit { got: 8, wanted: 9 })),
        ),
        (
            "wrong transaction",
            Act::Spoiled(|good| with(good, 0, 0x77)),
            // The second request of a connection has number 1.
            Some(garbled(Garbled::Transaction { got: 0x7700, wanted: 0 })),
        ),
        (
            "wrong protocol",
            Act::Spoiled(|good| with(good, 3, 1)),
            Some(garbled(Garbled::Protocol { got: 1 })),
        ),
        (
            "length 0",
            Act::Spoiled(|good| with(good, 5, 0)),
            Some(garbled(Garbled::Length { got: 13, wanted: 6 })),
        ),
        (
            "an exception",
            Act::Spoiled(|good| exception(good, 0x84)),
            Some(ModbusError::Refused { function: 4, register: 0, exception: 0x0B }.into()),
        ),
        (
            "another function's exception",
            Act::Spoiled(|good| exception(good, 0x83)),
            Some(garbled(Garbled::Function { got: 0x83, wanted: 4 })),
        ),
        (
            "garbage",
            Act::Spoiled(|_| b"HTTP/1.1 400 Bad Request\r\n".to_vec()),
            Some(garbled(Garbled::Unfinished { bytes: 26 })),
        ),
        (
            "an answer that stops in the middle",
            Act::Spoiled(|good| good[..10].to_vec()),
            Some(garbled(Garbled::Unfinished { bytes: 10 })),
        ),
        ("hangs up in the middle", Act::SpoiledAndGone(|good| good[..10].to_vec()), Some(GONE)),
        ("hangs up without an answer", Act::SpoiledAndGone(|_| Vec::new()), Some(GONE)),
    ];
    for (name, act, expected) in cases {
        for before in 0..2 {
            let mut script = vec![Act::Answer; before];
            script.push(act);
            let gateway = Gateway::start(script);
            let mut client = gateway.client();
            for _ in 0..before {
                read(&mut client, 0, 1).unwrap();
            }
            let expected = match &expected {
                // Asked again: it may only have closed behind its last answer.
                Some(GONE) if before > 0 && name.ends_with("without an answer") => None,
                expected => expected.clone().map(|error| numbered(error, before as u16)),
            };
            match (read(&mut client, 0, 1), &expected) {
                (Ok(words), None) => assert_eq!(words, [gateway.requests()], "{name}"),
                (result, expected) => assert_eq!(&result.err(), expected, "{name}"),
            }
            for _ in 0..3 {
                let words = read(&mut client, 0, 1).unwrap_or_else(|error| panic!("after {name}: {error}"));
                assert_eq!(words, [gateway.requests()], "after {name}");
            }
        }
    }
}

#[test]
fn a_gateway_that_hangs_up_behind_each_answer_costs_no_error_and_no_word() {
    let gateway = Gateway::start(vec![Act::SpoiledAndGone(<[u8]>::to_vec); 200]);
    let mut client = gateway.client();
    for _ in 0..20 {
        // One of them may go to nobody, and is asked again.
        let words = read(&mut client, 0, 1).unwrap();
        assert_eq!(words, [gateway.requests()]);
    }
    // From now on every request has a connection of its own, so that none is lost, and a write least of all.
    let before = gateway.requests();
    for _ in 0..20 {
        client.cycle(Some((0, OutWord(1))), 0, &mut [InWord(0)]).unwrap();
    }
    assert_eq!(gateway.requests(), before + 40);
    assert_eq!(drained(&mut client), [Link::Up { down_for: Duration::ZERO }]);
}

/// The error with the request's transaction number.
fn numbered(error: BusError, number: u16) -> BusError {
    let foreign = Garbled::Transaction { got: 0x7700, wanted: 0 };
    if error != garbled(foreign) {
        return error;
    }
    garbled(Garbled::Transaction { got: 0x7700 + number, wanted: number })
}

fn with(good: &[u8], index: usize, byte: u8) -> Vec<u8> {
    let mut frame = good.to_vec();
    frame[index] = byte;
    frame
}

fn exception(good: &[u8], function: u8) -> Vec<u8> {
    let mut frame = good[..7].to_vec();
    frame.extend([function, 0x0B]);
    fix(&mut frame);
    frame
}

#[test]
fn a_write_is_acknowledged_as_it_was_sent_or_it_is_an_error() {
    let echo = |register, count| Garbled::Echo { got: (register, count), wanted: (6, 2) };
    let cases: [(&str, Garbled, Spoil); 5] = [
        ("another register", echo(4, 2), |good| with(good, 9, 4)),
        ("another count", echo(6, 1), |good| with(good, 11, 1)),
        ("another function", Garbled::Function { got: 6, wanted: 16 }, |good| with(good, 7, 6)),
        ("too short", Garbled::Foreign, |good| {
            let mut short = good[..10].to_vec();
            fix(&mut short);
            short
        }),
        ("too long", echo(6, 2), |good| {
            let mut long = [good, &[0]].concat();
            fix(&mut long);
            long
        }),
    ];
    for (name, got, spoil) in cases {
        let gateway = Gateway::start(vec![Act::Spoiled(spoil)]);
        let mut client = gateway.client();
        let write = Some((3, OutWord(1)));
        let error = client.cycle(write, 0, &mut [InWord(0)]).unwrap_err();
        assert_eq!(error, ModbusError::Garbled { function: 16, register: 6, got }.into(), "{name}");
        let mut input = [InWord(0)];
        client.cycle(write, 0, &mut input).unwrap();
        assert_eq!(input, [InWord(gateway.requests())], "{name}");
    }
}

#[test]
fn late_answers_in_a_row_never_meet_a_later_request() {
    let gateway = Gateway::start(vec![Act::Late, Act::Answer, Act::Late, Act::Late, Act::Answer, Act::Late]);
    let mut client = gateway.client();
    let results: Vec<_> = (0..8).map(|_| read(&mut client, 0, 1)).collect();
    let expected: Vec<_> =
        (1..=8).map(|n| if [1, 3, 4, 6].contains(&n) { Err(SILENCE) } else { Ok(vec![n]) }).collect();
    assert_eq!(results, expected);
}

#[test]
fn what_happened_to_the_link_is_told_once() {
    let gateway = Gateway::start(vec![Act::Answer, Act::Late]);
    let mut client = gateway.client();
    for _ in 0..3 {
        let _ = read(&mut client, 0, 1);
    }
    assert!(matches!(
        drained(&mut client)[..],
        [
            Link::Up { down_for: Duration::ZERO },
            Link::Down { up_for: Duration(1..), cause: SILENCE },
            Link::Up { down_for: Duration(1..) },
        ]
    ));
    assert_eq!(client.link_event(), None);
}

#[test]
fn connections_that_are_of_no_use_for_one_reason_are_told_once_and_then_the_first_that_is() {
    let mut script = vec![Act::Spoiled(|good| with(good, 6, 7)); 3];
    script.push(Act::Spoiled(|good| with(good, 0, 0x77)));
    script.push(Act::Spoiled(|good| with(good, 0, 0x78)));
    let gateway = Gateway::start(script);
    let mut client = gateway.client().reconnecting(Reconnect::new(Duration::ZERO, 1, Duration::ZERO));
    for _ in 0..5 {
        read(&mut client, 0, 1).unwrap_err();
    }
    for _ in 0..2 {
        read(&mut client, 0, 1).unwrap();
    }
    let events = drained(&mut client);
    let [first, unit, transaction, last] = &events[..] else { panic!("{events:?}") };
    assert_eq!(*first, Link::Up { down_for: Duration::ZERO });
    let cause = |event: &Link| match event {
        Link::Down { cause, .. } => cause.to_string(),
        other => panic!("{other}"),
    };
    assert!(cause(unit).contains("unit 7 instead of 9"), "{unit}");
    assert!(cause(transaction).contains("transaction number"), "{transaction}");
    assert!(matches!(last, Link::Up { down_for: Duration(1..) }), "{last}");
}

#[test]
fn a_gateway_that_takes_connections_and_never_answers_is_not_hurried() {
    let gateway = Gateway::start(vec![Act::SpoiledAndGone(|_| Vec::new()); 100]);
    let hour = Duration::from_secs(3_600);
    let mut client = gateway.client().reconnecting(Reconnect::new(hour, 1, hour));
    assert_eq!(read(&mut client, 0, 1), Err(GONE));
    let error = read(&mut client, 0, 1).unwrap_err();
    assert!(
        matches!(
            error,
            BusError::NoConnection(Cause::Waiting { last: io::ErrorKind::ConnectionAborted, .. })
        ),
        "{error}"
    );
    assert_eq!(gateway.requests(), 1);
}
