//! An Inline bus coupler: a directory, and the process data of all its modules behind each other.

use super::*;

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::Mutex;

use crate::probe::{Certainty, Evidence, Reach, probe};

/// Function, first register, count.
type Request = (u8, u16, u16);

struct Coupler {
    address: String,
    holding: Arc<Mutex<BTreeMap<u16, u16>>>,
    requests: Arc<Mutex<Vec<Request>>>,
}

impl Coupler {
    fn start(modules: &[u16]) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = format!("modbus-tcp://{}?layout=inline", listener.local_addr().unwrap());
        let mut holding: BTreeMap<u16, u16> = (1401..).zip(modules.iter().copied()).collect();
        holding.insert(1400, modules.len() as u16);
        let (holding, requests) = (Arc::new(Mutex::new(holding)), Arc::new(Mutex::new(Vec::new())));
        let (served, told) = (Arc::clone(&holding), Arc::clone(&requests));
        // It ends with the tests.
        thread::spawn(move || {
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                let mut header = [0; 7];
                while stream.read_exact(&mut header).is_ok() {
                    let mut pdu = vec![0; usize::from(header[5]) - 1];
                    stream.read_exact(&mut pdu).unwrap();
                    let answer = respond(&pdu, &mut served.lock().unwrap(), &told);
                    header[5] = answer.len() as u8 + 1;
                    stream.write_all(&[&header[..], &answer].concat()).unwrap();
                }
            }
        });
        Self { address, holding, requests }
    }

    fn client(&self) -> Client {
        Client::new(self.address.parse().unwrap()).unwrap()
    }

    fn set(&self, first: u16, values: &[u16]) {
        self.holding.lock().unwrap().extend((first..).zip(values.iter().copied()));
    }

    fn at(&self, register: u16) -> u16 {
        self.holding.lock().unwrap()[&register]
    }

    fn requests(&self) -> Vec<Request> {
        std::mem::take(&mut self.requests.lock().unwrap())
    }
}

fn respond(pdu: &[u8], holding: &mut BTreeMap<u16, u16>, told: &Mutex<Vec<Request>>) -> Vec<u8> {
    let number = |at: usize| u16::from_be_bytes([pdu[at], pdu[at + 1]]);
    let (function, first, count) = (pdu[0], number(1), number(3));
    told.lock().unwrap().push((function, first, count));
    if !(function == 3 || function == 16) {
        return vec![function | 0x80, 1];
    }
    let registers: Vec<u16> = (first..).take(count.into()).collect();
    if !registers.iter().all(|register| holding.contains_key(register)) {
        return vec![function | 0x80, 2];
    }
    match function {
        3 => {
            let values = registers.iter().flat_map(|register| holding[register].to_be_bytes());
            [3, 2 * count as u8].into_iter().chain(values).collect()
        }
        _ => {
            holding.extend(registers.iter().enumerate().map(|(k, register)| (*register, number(6 + 2 * k))));
            pdu[..5].to_vec()
        }
    }
}

#[test]
fn the_encoder_at_a_ring_position_is_found_among_other_modules() {
    // Digital out 1 word, encoder, digital in 1 word, encoder.
    let coupler = Coupler::start(&[0x0101, 0x0233, 0x0102, 0x0233]);
    coupler.set(8000, &[0x0000, 0x1111, 0x0D0D, 0x2000, 0x2222]);
    coupler.set(8005, &[0xDDDD, 0x4100, 0x0001, 0x4300, 0x0003]);
    let mut client = coupler.client();
    assert_eq!(read(&mut client, 1, 1).unwrap(), [0x0000_1111]);
    assert_eq!(coupler.requests(), [(3, 1400, 2), (3, 1401, 4), (3, 8000, 2)]);
    assert_eq!(read(&mut client, 3, 1).unwrap(), [0x2000_2222]);
    assert_eq!(client.out(3).unwrap(), OutWord(0x4300_0003));
    let mut input = [InWord(0)];
    client.cycle(Some((3, OutWord(0xC200_270F))), 3, &mut input).unwrap();
    assert_eq!(input, [InWord(0x2000_2222)]);
    let directory = [(3, 1400, 2), (3, 1401, 4)];
    let (before, after) = ([(3, 8003, 2), (3, 8008, 2)], [(16, 8008, 2), (3, 8003, 2)]);
    assert_eq!(coupler.requests(), [before, directory, after].concat());
    assert_eq!(
        [8005, 8006, 8007, 8008, 8009].map(|register| coupler.at(register)),
        [0xDDDD, 0x4100, 0x0001, 0xC200, 0x270F]
    );
}

#[test]
fn a_module_that_is_no_encoder_is_neither_read_nor_written() {
    let coupler = Coupler::start(&[0x0101, 0x0233, 0x0133]);
    coupler.set(8000, &[0; 10]);
    let mut client = coupler.client();
    let error = client.cycle(Some((0, OutWord(u32::MAX))), 1, &mut [InWord(0)]).unwrap_err();
    assert_eq!(error, BusError::NotAnEncoder { position: 0, ident: 1, words: 1 });
    let error = client.cycle(Some((1, OutWord(1))), 1, &mut [InWord(0); 2]).unwrap_err();
    assert_eq!(error, BusError::NotAnEncoder { position: 2, ident: 51, words: 1 });
    assert_eq!(client.out(3).unwrap_err(), BusError::NoEncoder { position: 3, encoders: 3 });
    assert_eq!(read(&mut client, 1, 1).unwrap(), [0]);
    assert!(coupler.requests().iter().all(|(function, ..)| *function == 3));
    assert_eq!(drained(&mut client), [Link::Up { down_for: Duration::ZERO }]);
}

#[test]
fn a_directory_that_cannot_be_true_is_an_error() {
    let coupler = Coupler::start(&[0x2A01, 0x0233]);
    let error = read(&mut coupler.client(), 1, 1).unwrap_err();
    let got = crate::error::Garbled::LengthCode { code: 0x2A };
    assert_eq!(error, ModbusError::Garbled { function: 3, register: 1401, got }.into());
    coupler.set(1400, &[0, 0]);
    let error = read(&mut coupler.client(), 0, 1).unwrap_err();
    assert_eq!(error, BusError::NoEncoder { position: 0, encoders: 0 });
}

#[test]
fn a_ring_that_was_changed_is_looked_at_before_anything_is_written() {
    let coupler = Coupler::start(&[0x0233]);
    coupler.set(8000, &[0, 7, 0, 8, 0, 0, 0, 0]);
    let mut client = coupler.client();
    assert_eq!(read(&mut client, 0, 1).unwrap(), [7]);
    coupler.set(1400, &[2, 0x0203, 0x0233]);
    let error = client.cycle(Some((0, OutWord(1))), 0, &mut []).unwrap_err();
    assert_eq!(error, BusError::NotAnEncoder { position: 0, ident: 3, words: 2 });
    assert_eq!(read(&mut client, 1, 1).unwrap(), [8]);
}

#[test]
fn a_probe_only_reads() {
    let coupler = Coupler::start(&[0x0101, 0x0233]);
    coupler.set(8000, &[0x0012, 0x3456, 0, 0, 0]);
    let mut client = coupler.client();
    let limits = Reach { pause: Duration::from_millis(1), ..Reach::default() };
    let report = probe(&mut client, limits, |_| std::ops::ControlFlow::Continue(())).unwrap();
    assert_eq!(report.candidates[0].address.to_string(), coupler.address);
    assert_eq!(report.candidates[0].certainty, Certainty::Likely);
    assert!(report.candidates[0].evidence.contains(&Evidence::Rests));
    assert!(coupler.requests().iter().all(|(function, ..)| [3, 4].contains(function)));
}
