//! The same over a serial line, which is a pair of pseudo terminals.

use super::*;

use std::collections::VecDeque;

use crate::error::Garbled;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio_serial::{SerialPort, SerialStream};

type Spoil = fn(&[u8]) -> Vec<u8>;

enum Act {
    Answer,
    Spoiled(Spoil),
    /// The answer comes with the next request, before the next answer.
    Late,
}

/// A unit at the other end. IN of every position is the number of the request.
struct Unit {
    address: String,
    told: std::sync::mpsc::Receiver<u32>,
}

impl Unit {
    fn start(script: Vec<Act>) -> Self {
        let (tell_name, named) = std::sync::mpsc::channel();
        let (tell, told) = std::sync::mpsc::channel();
        thread::spawn(move || {
            let runtime = Builder::new_current_thread().enable_all().build().unwrap();
            runtime.block_on(async {
                let (master, kept) = SerialStream::pair().unwrap();
                // Kept open, so that the line does not hang up while nobody has opened it by its name.
                tell_name.send(kept.name().unwrap()).unwrap();
                unit(master, script.into(), tell).await;
            });
        });
        let address = format!("modbus-rtu:{}?baud=115200&unit=9&timeout_ms=600", named.recv().unwrap());
        Self { address, told }
    }

    fn client(&self) -> Client {
        let pause = Duration::from_millis(1);
        Client::new(self.address.parse().unwrap()).unwrap().reconnecting(Reconnect::new(pause, 1, pause))
    }

    /// How many requests there were.
    fn requests(&self) -> u32 {
        self.told.try_iter().last().unwrap()
    }
}

async fn unit(mut line: SerialStream, mut script: VecDeque<Act>, tell: std::sync::mpsc::Sender<u32>) {
    let mut late = Vec::new();
    for number in 1_u32.. {
        let mut request = vec![0; 8];
        if line.read_exact(&mut request).await.is_err() {
            return;
        }
        if request[1] == 16 {
            let mut values = vec![0; 5];
            line.read_exact(&mut values).await.unwrap();
        }
        let _ = tell.send(number);
        let mut answer = match request[1] {
            16 => request[..6].to_vec(),
            function => {
                let words = number.to_be_bytes().into_iter().cycle().take(2 * usize::from(request[5]));
                [9, function, 2 * request[5]].into_iter().chain(words).collect()
            }
        };
        answer = with_crc(&answer);
        let mut bytes = std::mem::take(&mut late);
        match script.pop_front().unwrap_or(Act::Answer) {
            Act::Answer => bytes.extend(answer),
            Act::Spoiled(spoil) => bytes.extend(spoil(&answer)),
            Act::Late => late = answer,
        }
        line.write_all(&bytes).await.unwrap();
    }
}

fn with_crc(frame: &[u8]) -> Vec<u8> {
    let mut crc = 0xFFFF_u16;
    for byte in frame {
        crc ^= u16::from(*byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xA001 } else { crc >> 1 };
        }
    }
    [frame, &crc.to_le_bytes()].concat()
}

const SILENCE: BusError = BusError::NoAnswer { within: Duration::from_millis(600) };

#[test]
fn words_come_and_go_over_a_serial_line() {
    let unit = Unit::start(Vec::new());
    let mut client = unit.client();
    assert_eq!(read(&mut client, 0, 2).unwrap(), [2, 2], "the marker was the first request");
    let mut input = [InWord(0)];
    client.cycle(Some((1, OutWord(0xC200_270F))), 0, &mut input).unwrap();
    assert_eq!(input, [InWord(4)]);
    assert_eq!(client.out(0).unwrap(), OutWord(5));
    assert_eq!(drained(&mut client), [Link::Up { down_for: Duration::ZERO }]);
}

#[test]
fn each_misbehaviour_of_a_unit_gives_its_error_and_the_next_call_its_own_answer() {
    let garbled = |got| BusError::from(ModbusError::Garbled { function: 4, register: 0, got });
    let cases: [(&str, Act, Option<BusError>); 8] = [
        ("silence", Act::Spoiled(|_| Vec::new()), Some(SILENCE)),
        ("late", Act::Late, Some(SILENCE)),
        (
            "bad checksum",
            Act::Spoiled(|good| [&good[..8], &[good[8] ^ 1]].concat()),
            Some(garbled(Garbled::Unfinished { bytes: 9 })),
        ),
        ("noise before", Act::Spoiled(|good| [&[0xFF, 0x00], good].concat()), None),
        ("noise behind", Act::Spoiled(|good| [good, &[0x00]].concat()), None),
        ("doubled", Act::Spoiled(|good| [good, good].concat()), None),
        (
            "cut short",
            Act::Spoiled(|good| good[..5].to_vec()),
            Some(garbled(Garbled::Unfinished { bytes: 5 })),
        ),
        (
            "another unit's",
            Act::Spoiled(|good| with_crc(&[&[8], &good[1..7]].concat())),
            Some(garbled(Garbled::Unit { got: 8, wanted: 9 })),
        ),
    ];
    for (name, act, expected) in cases {
        let unit = Unit::start(vec![Act::Answer, act]);
        let mut client = unit.client();
        match (read(&mut client, 0, 1), expected) {
            (Ok(words), None) => assert_eq!(words, [unit.requests()], "{name}"),
            (result, expected) => assert_eq!(result.err(), expected, "{name}"),
        }
        let mut answered = 0;
        for _ in 0..5 {
            match read(&mut client, 0, 1) {
                Ok(words) => {
                    assert_eq!(words, [unit.requests()], "after {name}");
                    answered += 1;
                }
                // What came late was seen where the marker's answer was to be.
                Err(error) => {
                    let late = garbled(Garbled::Registers { got: 2, wanted: 1 });
                    assert_eq!((name, answered, error), ("late", 0, late));
                }
            }
        }
        assert!(answered >= 4, "{name}: {answered}");
    }
}

#[test]
fn a_late_acknowledgement_is_not_taken_for_the_next_writes() {
    // The marker, the first write, the second's marker.
    let unit = Unit::start(vec![Act::Answer, Act::Late]);
    let mut client = unit.client();
    let mut write = || client.cycle(Some((0, OutWord(1))), 0, &mut []);
    assert_eq!(write().err(), Some(SILENCE));
    let error = write().unwrap_err();
    let BusError::Client(client) = error else { panic!("{error}") };
    let error = client.error().downcast_ref().unwrap();
    assert!(matches!(error, ModbusError::Garbled { function: 4, .. }), "{error}");
    write().unwrap();
    // Marker and write, marker, marker and write.
    assert_eq!(unit.requests(), 5);
}

#[test]
fn a_device_that_does_not_exist_is_told() {
    let mut client = Client::new("modbus-rtu:/dev/no-such-line".parse().unwrap()).unwrap();
    let error = read(&mut client, 0, 1).unwrap_err();
    assert_eq!(error, BusError::NoConnection(Cause::System(io::ErrorKind::NotFound)));
}

#[test]
fn a_single_register_of_the_diagnosis_is_read_with_a_neighbour() {
    let told = |script, register: &str| {
        let Unit { address, told } = Unit::start(script);
        let mut client = Client::new(format!("{address}&status={register}").parse().unwrap()).unwrap();
        let status = client.diagnosis().map(|diagnosis| diagnosis.status);
        (status, told.try_iter().last().unwrap())
    };
    // The registers of an answer are 0 and the number of the request, and the first request is the marker.
    assert_eq!(told(vec![], "holding:900"), (Ok(Some(0)), 2));
    assert_eq!(told(vec![], "holding:65535"), (Ok(Some(2)), 2), "nothing stands behind the last");
    let refused = || Act::Spoiled(|good| with_crc(&[9, good[1] | 0x80, 2]));
    assert_eq!(told(vec![Act::Answer, refused()], "holding:900"), (Ok(Some(3)), 3), "nothing is behind it");
    let error = ModbusError::Refused { function: 3, register: 899, exception: 2 };
    let (status, requests) = told(vec![Act::Answer, refused(), refused()], "holding:900");
    assert_eq!((status, requests), (Err(error.into()), 3));
}
