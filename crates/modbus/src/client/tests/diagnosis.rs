//! What the ring's master says, wherever the gateway shows it.

use super::*;

use encoring_bus::Answered;
use encoring_ring::diagnostics::Diagnosis;

const STATUS: u16 = 0x1094;
const PARAMETER: u16 = 0x0300;

/// A server of a ring that stands still, and what a client at this address is told, with how many requests.
fn told(options: &str) -> (Result<Diagnosis, BusError>, u64) {
    let server = Server::start(1, Options::default());
    server.image.with(|image| image.diagnose(STATUS, PARAMETER, [0, 0]));
    let mut client = server.client(options);
    let diagnosis = client.diagnosis();
    assert_eq!(drained(&mut client).len(), usize::from(!options.is_empty()));
    // Whatever came of it, the words come.
    assert_eq!(read(&mut client, 0, 1).unwrap(), [0x8000_8001]);
    (diagnosis, server.counters.snapshot().requests - 1)
}

#[test]
fn registers_beside_one_another_are_read_together_and_others_apart() {
    let both = Diagnosis { status: Some(STATUS), parameter: Some(PARAMETER) };
    assert_eq!(told("?status=holding:900&parameter=holding:901"), (Ok(both), 1));
    assert_eq!(told("?status=input:900&parameter=holding:901"), (Ok(both), 2));
    // Named the other way round.
    let exchanged = Diagnosis { status: Some(PARAMETER), parameter: Some(STATUS) };
    assert_eq!(told("?parameter=holding:900&status=holding:901"), (Ok(exchanged), 1));
    assert_eq!(told("?parameter=holding:900&status=holding:902").1, 2);
}

#[test]
fn one_register_alone_leaves_the_other_unknown() {
    let status = Diagnosis { status: Some(STATUS), parameter: None };
    assert_eq!(told("?status=holding:900"), (Ok(status), 1));
    assert_eq!(status.reaches(0), Some(false));
    let parameter = Diagnosis { status: None, parameter: Some(PARAMETER) };
    assert_eq!(told("?parameter=holding:901"), (Ok(parameter), 1));
    assert_eq!(parameter.reaches(0), None, "without the status nobody tells whether the ring runs");
}

#[test]
fn without_registers_in_the_address_nothing_is_asked() {
    assert_eq!(told(""), (Ok(Diagnosis::default()), 0));
}

#[test]
fn a_refusal_is_one_of_the_gateway_and_the_connection_is_kept() {
    for (options, register) in
        [("?status=holding:5000", 5000), ("?status=holding:900&parameter=holding:5000", 5000)]
    {
        let error = told(options).0.unwrap_err();
        assert_eq!(error, ModbusError::Refused { function: 3, register, exception: 2 }.into());
        let BusError::Client(client) = error else { panic!("{error}") };
        assert_eq!(client.answered(), Answered::Refused);
    }
}
