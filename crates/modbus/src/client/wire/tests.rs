use super::*;

use proptest::prelude::*;
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};

const PLACE: RegisterPlace = RegisterPlace { table: Table::Input, first: 0 };
const SECOND: Duration = Duration::from_secs(1);

/// The answer to the first request of a connection, function 4, two registers.
const TCP_ANSWER: [u8; 13] = [0, 0, 0, 0, 0, 7, 9, 4, 4, 0x12, 0x34, 0x56, 0x78];

fn deadline() -> Deadline {
    Deadline { at: Instant::now() + Span::from_secs(1), within: SECOND }
}

/// A peer that answers each request with the next of these, and then leaves or stays silent.
async fn play(mut peer: impl Stream, request: usize, answers: Vec<Vec<u8>>, then: Then) {
    for answer in answers {
        let mut asked = vec![0; request];
        if peer.read_exact(&mut asked).await.is_err() {
            return;
        }
        peer.write_all(&answer).await.unwrap();
    }
    if then == Then::Silent {
        std::future::pending::<()>().await;
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Then {
    Leaves,
    Silent,
}

async fn tcp_read(answer: &[u8], then: Then) -> Result<Vec<u16>, ModbusError> {
    let (ours, theirs) = duplex(1024);
    let mut wire = Wire::tcp(ours, 9, Accept::default());
    tokio::select! {
        biased;
        result = wire.read(PLACE, 2, deadline()) => result,
        () = async {
            play(theirs, 12, vec![answer.to_vec()], then).await;
            std::future::pending::<()>().await;
        } => unreachable!(),
    }
}

/// The marker's answer goes first, as it should.
async fn rtu_read(answer: &[u8], then: Then) -> Result<Vec<u16>, ModbusError> {
    let (ours, theirs) = duplex(1024);
    let answers = vec![with_crc(&[9, 4, 2, 0, 0]), answer.to_vec()];
    let talk = async {
        let mut wire = Wire::rtu(ours, 9, Span::from_millis(2), PLACE, deadline()).await.unwrap();
        wire.read(PLACE, 2, deadline()).await
    };
    tokio::select! {
        biased;
        result = talk => result,
        () = async {
            play(theirs, 8, answers, then).await;
            std::future::pending::<()>().await;
        } => unreachable!(),
    }
}

/// The checksum of a serial line once more, bit by bit.
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

fn rtu_answer() -> Vec<u8> {
    with_crc(&[9, 4, 4, 0x12, 0x34, 0x56, 0x78])
}

/// Every answer that differs from a good one in one byte, or ends before it.
fn near(good: &[u8]) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for index in 0..good.len() {
        for byte in 0..=u8::MAX {
            if byte != good[index] {
                let mut changed = good.to_vec();
                changed[index] = byte;
                all.push(changed);
            }
        }
        all.push(good[..index].to_vec());
    }
    all
}

/// What must become of the answer on a network, read from the rules alone.
fn by_the_rules(answer: &[u8]) -> Result<Vec<u16>, &'static str> {
    if answer.len() < 7 {
        return Err("lost");
    }
    let length = usize::from(answer[4]) * 256 + usize::from(answer[5]);
    if length == 0 {
        return Err("garbled");
    }
    if answer.len() < 6 + length {
        return Err("lost");
    }
    let (header, pdu) = (&answer[..7], &answer[7..6 + length]);
    if header[..4] != [0; 4] || header[6] != 9 {
        return Err("garbled");
    }
    match pdu {
        [0x84, _] if answer.len() == 9 => Err("refused"),
        [4, 4, a, b, c, d] => Ok(vec![u16::from_be_bytes([*a, *b]), u16::from_be_bytes([*c, *d])]),
        _ => Err("garbled"),
    }
}

fn told(result: Result<Vec<u16>, ModbusError>) -> Result<Vec<u16>, &'static str> {
    result.map_err(|error| match error {
        ModbusError::Bus(BusError::NoConnection(_)) => "lost",
        ModbusError::Refused { .. } => "refused",
        ModbusError::Garbled { .. } => "garbled",
        ModbusError::Bus(BusError::NoAnswer { .. }) => "silent",
        ModbusError::Bus(_) => "else",
    })
}

#[tokio::test(start_paused = true)]
async fn a_good_answer_is_taken() {
    assert_eq!(tcp_read(&TCP_ANSWER, Then::Silent).await, Ok(vec![0x1234, 0x5678]));
    assert_eq!(rtu_read(&rtu_answer(), Then::Silent).await, Ok(vec![0x1234, 0x5678]));
}

#[tokio::test(start_paused = true)]
async fn every_single_byte_change_and_every_truncation_is_judged_by_the_rules() {
    let mut taken = 0;
    for answer in near(&TCP_ANSWER) {
        let result = told(tcp_read(&answer, Then::Leaves).await);
        assert_eq!(result, by_the_rules(&answer), "{answer:02X?}");
        taken += usize::from(result.is_ok());
    }
    // The four bytes of data, and nothing else, may be anything.
    assert_eq!(taken, 4 * 255);
}

#[tokio::test(start_paused = true)]
async fn an_answer_that_does_not_end_is_told_with_its_bytes() {
    for cut in 0..TCP_ANSWER.len() {
        let error = tcp_read(&TCP_ANSWER[..cut], Then::Silent).await.unwrap_err();
        let expected = match cut {
            0 => BusError::NoAnswer { within: SECOND }.into(),
            bytes => ModbusError::Garbled { function: 4, register: 0, got: Garbled::Unfinished { bytes } },
        };
        assert_eq!(error, expected);
    }
}

#[tokio::test(start_paused = true)]
async fn nothing_near_a_good_serial_answer_is_taken() {
    for then in [Then::Leaves, Then::Silent] {
        for answer in near(&rtu_answer()) {
            let result = rtu_read(&answer, then).await;
            assert!(result.is_err(), "{answer:02X?}: {result:?}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn noise_before_a_serial_answer_is_passed_over() {
    for noise in [&[0xFF][..], &[0x00], &[0x00, 0x00, 0x00], &[9, 0x55]] {
        let answer = [noise, &rtu_answer()].concat();
        assert_eq!(rtu_read(&answer, Then::Silent).await, Ok(vec![0x1234, 0x5678]), "{noise:02X?}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_bad_checksum_is_no_answer_but_not_silence_either() {
    let mut answer = rtu_answer();
    answer[4] ^= 1;
    let error = rtu_read(&answer, Then::Silent).await.unwrap_err();
    let got = Garbled::Unfinished { bytes: 9 };
    assert_eq!(error, ModbusError::Garbled { function: 4, register: 0, got });
    let silence = rtu_read(&[], Then::Silent).await.unwrap_err();
    assert_eq!(silence, BusError::NoAnswer { within: SECOND }.into());
}

#[tokio::test(start_paused = true)]
async fn serial_answers_of_the_wrong_kind_are_refused() {
    for (pdu, expected) in [
        (&[9, 3, 4, 0x12, 0x34, 0x56, 0x78][..], Garbled::Function { got: 3, wanted: 4 }),
        (&[8, 4, 4, 0x12, 0x34, 0x56, 0x78], Garbled::Unit { got: 8, wanted: 9 }),
        (&[9, 4, 2, 0x12, 0x34], Garbled::Registers { got: 1, wanted: 2 }),
        (&[9, 4, 6, 1, 2, 3, 4, 5, 6], Garbled::Registers { got: 3, wanted: 2 }),
        (&[9, 4, 0], Garbled::Registers { got: 0, wanted: 2 }),
        (&[9, 4, 3, 1, 2, 3], Garbled::Foreign),
        (&[9, 16, 0, 0, 0, 2], Garbled::Function { got: 16, wanted: 4 }),
        (&[9, 0x83, 2], Garbled::Function { got: 0x83, wanted: 4 }),
    ] {
        let error = rtu_read(&with_crc(pdu), Then::Silent).await.unwrap_err();
        assert_eq!(error, ModbusError::Garbled { function: 4, register: 0, got: expected }, "{pdu:02X?}");
    }
    let error = rtu_read(&with_crc(&[9, 0x84, 0x0B]), Then::Silent).await.unwrap_err();
    assert_eq!(error, ModbusError::Refused { function: 4, register: 0, exception: 0x0B });
}

#[tokio::test(start_paused = true)]
async fn no_function_code_and_no_length_of_an_answer_is_too_strange() {
    for function in 0..=u8::MAX {
        for length in 0..16_u8 {
            for fill in [0, 1, 0x0E, 0xFF] {
                let mut pdu = vec![function];
                pdu.resize(usize::from(length), fill);
                let frame = [&[0, 0, 0, 0, 0, length + 1, 9][..], &pdu].concat();
                let result = tcp_read(&frame, Then::Leaves).await;
                assert_eq!(told(result), by_the_rules(&frame), "{frame:02X?}");
                let frame = with_crc(&[&[9][..], &pdu].concat());
                let result = rtu_read(&frame, Then::Leaves).await;
                assert!(result.is_err() || pdu[..] == [4, 4, fill, fill, fill, fill], "{frame:02X?}");
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn what_came_unasked_is_thrown_away() {
    let (ours, mut theirs) = duplex(1024);
    let mut wire = Wire::tcp(ours, 9, Accept::default());
    // As the answer to a request that was given up would.
    theirs.write_all(&[0, 0, 0, 0, 0, 7, 9, 4, 4, 1, 1, 1, 1]).await.unwrap();
    let (result, ()) = tokio::join!(
        wire.read(PLACE, 2, deadline()),
        play(theirs, 12, vec![TCP_ANSWER.to_vec()], Then::Leaves)
    );
    assert_eq!(result, Ok(vec![0x1234, 0x5678]));
}

#[tokio::test(start_paused = true)]
async fn a_peer_that_never_stops_sending_is_given_up() {
    struct Flood;
    impl tokio::io::AsyncRead for Flood {
        fn poll_read(
            self: std::pin::Pin<&mut Self>,
            _: &mut std::task::Context<'_>,
            buffer: &mut tokio::io::ReadBuf<'_>,
        ) -> std::task::Poll<io::Result<()>> {
            buffer.initialize_unfilled();
            buffer.set_filled(buffer.capacity());
            std::task::Poll::Ready(Ok(()))
        }
    }
    let wire = Wire::tcp(tokio::io::join(Flood, tokio::io::sink()), 9, Accept::default());
    let error = wire.clear().await.unwrap_err();
    assert_eq!(error, lost(io::ErrorKind::InvalidData));
}

#[tokio::test(start_paused = true)]
async fn a_late_serial_answer_is_overtaken_by_no_marker() {
    // A request before this connection was given up; its answer comes late, in the place of the marker's.
    let (ours, theirs) = duplex(1024);
    let late = with_crc(&[9, 4, 4, 0xDE, 0xAD, 0xDE, 0xAD]);
    let talk = Wire::rtu(ours, 9, Span::from_millis(2), PLACE, deadline());
    let (result, ()) = tokio::join!(talk, play(theirs, 8, vec![late], Then::Leaves));
    let got = Garbled::Registers { got: 2, wanted: 1 };
    assert_eq!(result.err(), Some(ModbusError::Garbled { function: 4, register: 0, got }));
}

fn block<T>(work: impl Future<Output = T>) -> T {
    tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .start_paused(true)
        .build()
        .unwrap()
        .block_on(work)
}

proptest! {
    #[test]
    fn any_bytes_end_in_an_answer_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let result = block(tcp_read(&bytes, Then::Leaves));
        prop_assert_eq!(told(result), by_the_rules(&bytes));
        let _ = block(rtu_read(&bytes, Then::Leaves));
        let _ = block(rtu_read(&with_crc(&bytes), Then::Leaves));
    }

    #[test]
    fn any_payload_behind_a_good_header_ends_in_an_answer_or_an_error(
        pdu in prop::collection::vec(any::<u8>(), 0..252),
    ) {
        let frame = [&[0, 0, 0, 0, 0, pdu.len() as u8 + 1, 9][..], &pdu].concat();
        prop_assert_eq!(told(block(tcp_read(&frame, Then::Leaves))), by_the_rules(&frame));
        let _ = block(rtu_read(&with_crc(&[&[9][..], &pdu].concat()), Then::Leaves));
    }
}
