use super::*;
use crate::plain::{Plain, diagnosis, image, inline_requests, requests};
use encoring_ring::ENCODERS_MAX;
use encoring_words::OutWord;

const ORDERS: [WordOrder; 2] = [WordOrder::HighFirst, WordOrder::LowFirst];

fn answer(image: &mut ProcessImage, request: &[u8]) -> Vec<u8> {
    respond(request, image, RegisterMap::Plain, WordOrder::HighFirst, &mut |_, _| {}).as_bytes().to_vec()
}

fn inline_answer(image: &mut ProcessImage, request: &[u8]) -> Vec<u8> {
    respond(request, image, RegisterMap::Inline, WordOrder::HighFirst, &mut |_, _| {}).as_bytes().to_vec()
}

/// The answer on a ring of three, which must leave the image as it was.
fn refused(request: &[u8]) -> Vec<u8> {
    refused_by(RegisterMap::Plain, request)
}

fn refused_by(layout: RegisterMap, request: &[u8]) -> Vec<u8> {
    let mut changed = image(3);
    let pdu = respond(request, &mut changed, layout, WordOrder::HighFirst, &mut |_, _| {});
    assert!(pdu.is_exception(), "{request:02X?}");
    assert_eq!(changed, image(3), "{request:02X?}");
    pdu.as_bytes().to_vec()
}

/// What a ring does with many requests, each on a fresh image, against the plain reading of the rules.
struct Comparison {
    plain: Plain,
    layout: RegisterMap,
    order: WordOrder,
    fresh: ProcessImage,
    compared: usize,
}

impl Comparison {
    fn new(encoders: usize, layout: RegisterMap, order: WordOrder) -> Self {
        let plain = Plain::new(encoders, layout, order);
        Self { plain, layout, order, fresh: image(encoders), compared: 0 }
    }

    fn check(&mut self, request: &[u8]) {
        let mut image = self.fresh.clone();
        self.plain.image.clone_from(&self.fresh);
        let answer = respond(request, &mut image, self.layout, self.order, &mut |_, _| {});
        assert_eq!(
            answer.as_bytes(),
            self.plain.respond(request),
            "{} {:?} {request:02X?}",
            self.layout,
            self.order
        );
        assert_eq!(image, self.plain.image, "{} {:?} {request:02X?}", self.layout, self.order);
        let succeeded = matches!(answer.as_bytes(), [6 | 16 | 23, ..]);
        assert!(succeeded || image == self.fresh, "{request:02X?} changed the image");
        self.compared += 1;
    }

    /// Every change of one byte, and every length, cut or filled up in three ways. Of the many values that a long
    /// request writes each is changed once.
    fn sweep(&mut self, request: &[u8]) {
        self.check(request);
        let mut changed = request.to_vec();
        for at in 0..request.len() {
            let values = if at < 16 { 0..=u8::MAX } else { !request[at]..=!request[at] };
            for value in values {
                changed[at] = value;
                self.check(&changed);
            }
            changed[at] = request[at];
        }
        for length in 0..=260 {
            for filler in [&[0x00], &[0xFF], request] {
                let longer = request.iter().chain(filler.iter().cycle()).take(length);
                self.check(&longer.copied().collect::<Vec<_>>());
            }
        }
    }
}

#[test]
fn whatever_changes_in_a_request_the_answer_is_the_one_of_the_plain_rules() {
    let plain = [&requests()[..], &diagnosis()].concat();
    for (layout, requests) in [(RegisterMap::Plain, plain), (RegisterMap::Inline, inline_requests().to_vec())]
    {
        for order in ORDERS {
            let mut ring = Comparison::new(3, layout, order);
            for request in &requests {
                ring.sweep(request);
            }
            assert_eq!(ring.compared, requests.iter().map(|request| 1 + 256 * request.len() + 3 * 261).sum());
        }
    }
}

#[test]
fn whatever_changes_in_the_longest_requests_the_answer_is_the_one_of_the_plain_rules() {
    let mut ring = Comparison::new(ENCODERS_MAX, RegisterMap::Plain, WordOrder::LowFirst);
    ring.sweep(&[3, 0x03, 0xE8, 0, 125]);
    ring.sweep(&[4, 0, 131, 0, 125]);
    let values = |count: usize| (0..2 * count).map(|k| k as u8 ^ 0x5A);
    ring.sweep(&[16, 0, 133, 0, 123, 246].into_iter().chain(values(123)).collect::<Vec<_>>());
    ring.sweep(&[23, 0, 0, 0, 125, 0, 10, 0, 121, 242].into_iter().chain(values(121)).collect::<Vec<_>>());
    ring.sweep(&[3, 0x03, 0x84, 0, 99]);
    ring.sweep(&[4, 0x03, 0x8A, 0, 125]);

    let mut ring = Comparison::new(ENCODERS_MAX, RegisterMap::Inline, WordOrder::LowFirst);
    ring.sweep(&[3, 0x05, 0x7C, 0, 125]);
    // From the last IN word on into the OUT words, and up to the last of these.
    ring.sweep(&[4, 0x20, 0x3F, 0, 125]);
    ring.sweep(&[16, 0x20, 0xC5, 0, 123, 246].into_iter().chain(values(123)).collect::<Vec<_>>());
}

#[test]
fn every_address_and_every_count_is_judged_by_the_plain_rules() {
    every_address_and_every_count(RegisterMap::Plain, [0, 0], &[[0, 0], [0, 5], [0x03, 0x84], [0x03, 0x89]]);
}

#[test]
fn every_address_and_every_count_is_judged_by_the_plain_rules_in_the_inline_layout_too() {
    let reads = [[0x03, 0x84], [0x05, 0x78], [0x1F, 0x40], [0x1F, 0x4B]];
    every_address_and_every_count(RegisterMap::Inline, [0x1F, 0x46], &reads);
}

/// `out` is where the OUT words begin.
fn every_address_and_every_count(layout: RegisterMap, [out_1, out_0]: [u8; 2], reads: &[[u8; 2]]) {
    let mut ring = Comparison::new(3, layout, WordOrder::HighFirst);
    for any in 0..=u16::MAX {
        let [high, low] = any.to_be_bytes();
        for code in [3, 4] {
            for count in [1, 2, 126] {
                ring.check(&[code, high, low, 0, count]);
            }
            for [address_1, address_0] in reads {
                ring.check(&[code, *address_1, *address_0, high, low]);
            }
        }
        ring.check(&[6, high, low, 0xAB, 0xCD]);
        ring.check(&[16, high, low, 0, 1, 2, 0xAB, 0xCD]);
        ring.check(&[16, high, low, 0, 2, 4, 0xAB, 0xCD, 0xEF, 0x01]);
        ring.check(&[16, out_1, out_0, high, low, 2, 0xAB, 0xCD]);
        ring.check(&[23, high, low, 0, 2, out_1, out_0, 0, 1, 2, 0xAB, 0xCD]);
        ring.check(&[23, out_1, out_0, 0, 2, high, low, 0, 1, 2, 0xAB, 0xCD]);
        ring.check(&[23, out_1, out_0, high, low, out_1, out_0, 0, 1, 2, 0xAB, 0xCD]);
        ring.check(&[23, out_1, out_0, 0, 2, out_1, out_0, high, low, 2, 0xAB, 0xCD]);
    }
}

#[test]
fn both_words_of_a_request_are_written_by_function_16() {
    let mut image = image(3);
    let request = [16, 0, 2, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F];
    assert_eq!(answer(&mut image, &request), [16, 0, 2, 0, 2]);
    assert_eq!(image.out(), [OutWord(0x4000_4001), OutWord(0xC200_270F), OutWord(0x4004_4005)]);
}

#[test]
fn two_writes_of_one_register_each_tear_the_word_between_them() {
    let mut image = image(1);
    image.out_mut()[0] = OutWord(0x0000_FFFF);
    assert_eq!(answer(&mut image, &[6, 0, 0, 0xC2, 0x00]), [6, 0, 0, 0xC2, 0x00]);
    // Here a cycle of the ring may run; the encoder would take FFFFh.
    assert_eq!(image.out(), [OutWord(0xC200_FFFF)]);
    assert_eq!(answer(&mut image, &[6, 0, 1, 0x27, 0x0F]), [6, 0, 1, 0x27, 0x0F]);
    assert_eq!(image.out(), [OutWord(0xC200_270F)]);
}

#[test]
fn function_23_writes_first_and_reads_what_it_wrote() {
    let mut image = image(1);
    let request = [23, 0, 0, 0, 2, 0, 0, 0, 2, 4, 1, 2, 3, 4];
    assert_eq!(answer(&mut image, &request), [23, 4, 1, 2, 3, 4]);
}

#[test]
fn function_23_writes_out_and_reads_in_by_way_of_the_mirror() {
    let mut image = image(1);
    let request = [23, 0x03, 0xE8, 0, 2, 0, 0, 0, 2, 4, 1, 2, 3, 4];
    assert_eq!(answer(&mut image, &request), [23, 4, 0x80, 0x00, 0x80, 0x01]);
    assert_eq!(image.out(), [OutWord(0x0102_0304)]);
}

#[test]
fn function_23_writes_nothing_if_either_part_is_refused() {
    // Of the read: too far, none, too many.
    assert_eq!(refused(&[23, 0, 5, 0, 2, 0, 0, 0, 1, 2, 1, 2]), [0x97, 2]);
    assert_eq!(refused(&[23, 0, 0, 0, 0, 0, 0, 0, 1, 2, 1, 2]), [0x97, 3]);
    assert_eq!(refused(&[23, 0, 0, 0, 126, 0, 0, 0, 1, 2, 1, 2]), [0x97, 3]);
    // Of the write: too far, the mirror, none.
    assert_eq!(refused(&[23, 0, 0, 0, 1, 0, 5, 0, 2, 4, 1, 2, 3, 4]), [0x97, 2]);
    assert_eq!(refused(&[23, 0, 0, 0, 1, 0x03, 0xE8, 0, 1, 2, 1, 2]), [0x97, 2]);
    assert_eq!(refused(&[23, 0, 0, 0, 1, 0, 0, 0, 0, 0]), [0x97, 3]);
    // 122 registers fit into a PDU but not into the function.
    let mut long = vec![23, 0, 0, 0, 1, 0, 0, 0, 122, 244];
    long.resize(10 + 244, 0);
    assert_eq!(refused(&long), [0x97, 3]);
}

#[test]
fn a_function_that_is_not_served_is_exception_01_whatever_follows() {
    for function in (0..=u8::MAX).filter(|function| ![3, 4, 6, 16, 23].contains(function)) {
        for length in 1..=PDU_MAX {
            let mut request = vec![0; length];
            request[0] = function;
            assert_eq!(refused(&request), [function | 0x80, 1]);
        }
    }
    assert_eq!(refused(&[0x0F, 0x00, 0x00, 0x03, 0xE8, 0x01, 0xFF]), [0x8F, 1]);
    assert_eq!(refused(&[]), [0x80, 1]);
}

#[test]
fn a_byte_count_other_than_two_for_each_register_is_exception_03() {
    for bytes in (0..=u8::MAX).filter(|bytes| *bytes != 4) {
        // Whether the values that came agree with the count or with the byte count.
        for came in [4, usize::from(bytes)] {
            let mut request = vec![16, 0, 0, 0, 2, bytes];
            request.resize(6 + came, 0xEE);
            assert_eq!(refused(&request), [0x90, 3]);
        }
    }
}

#[test]
fn a_length_that_does_not_fit_the_function_is_exception_03() {
    for request in requests() {
        let code = request[0] | 0x80;
        for length in 1..request.len() {
            assert_eq!(refused(&request[..length]), [code, 3]);
        }
        assert_eq!(refused(&[&request[..], &[0]].concat()), [code, 3]);
    }
}

#[test]
fn a_range_that_reaches_past_the_last_encoder_is_exception_02_and_writes_nothing() {
    assert_eq!(refused(&[3, 0, 0, 0, 7]), [0x83, 2]);
    assert_eq!(refused(&[4, 0, 5, 0, 2]), [0x84, 2]);
    assert_eq!(refused(&[6, 0, 6, 1, 2]), [0x86, 2]);
    assert_eq!(refused(&[16, 0, 5, 0, 2, 4, 1, 2, 3, 4]), [0x90, 2]);
    assert_eq!(refused(&[3, 0xFF, 0xFF, 0, 2]), [0x83, 2]);
}

#[test]
fn the_mirror_is_read_and_not_written() {
    assert_eq!(answer(&mut image(3), &[3, 0x03, 0xEC, 0, 2]), [3, 4, 0x80, 0x04, 0x80, 0x05]);
    assert_eq!(refused(&[6, 0x03, 0xE8, 1, 2]), [0x86, 2]);
    assert_eq!(refused(&[16, 0x03, 0xE8, 0, 1, 2, 1, 2]), [0x90, 2]);
}

#[test]
fn the_diagnosis_is_read_and_not_written() {
    let seen = [0xB0, 0xE0, 0xB3, 0x80, 0xC0, 0x00, 0xC0, 0x01, 0xC0, 0x02, 0xC0, 0x03];
    assert_eq!(answer(&mut image(3), &[3, 0x03, 0x84, 0, 6]), [&[3, 12], &seen[..]].concat());
    assert_eq!(answer(&mut image(3), &[4, 0x03, 0x84, 0, 6]), [&[4, 12], &seen[..]].concat());
    // Function 23 writes OUT and reads what the master says.
    let mut written = image(3);
    let request = [23, 0x03, 0x84, 0, 6, 0, 0, 0, 2, 4, 1, 2, 3, 4];
    assert_eq!(answer(&mut written, &request), [&[23, 12], &seen[..]].concat());
    assert_eq!(written.out()[0], OutWord(0x0102_0304));
    for register in [0x84, 0x85, 0x86, 0x89] {
        assert_eq!(refused(&[6, 0x03, register, 0, 0]), [0x86, 2]);
        assert_eq!(refused(&[16, 0x03, register, 0, 1, 2, 0, 0]), [0x90, 2]);
        assert_eq!(refused(&[23, 0, 0, 0, 2, 0x03, register, 0, 1, 2, 0, 0]), [0x97, 2]);
        // Past the segment that leads home.
        assert_eq!(refused(&[3, 0x03, register, 0, 0x8B - register]), [0x83, 2]);
    }
}

#[test]
fn in_the_inline_layout_function_23_is_exception_01_and_only_out_is_written() {
    let mut ring = image(3);
    assert_eq!(inline_answer(&mut ring, &[3, 0x05, 0x78, 0, 4]), [3, 8, 0, 3, 2, 0x33, 2, 0x33, 2, 0x33]);
    let write = [16, 0x1F, 0x46, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F];
    assert_eq!(inline_answer(&mut ring, &write), write[..5]);
    assert_eq!(inline_answer(&mut ring, &[6, 0x1F, 0x48, 1, 2]), [6, 0x1F, 0x48, 1, 2]);
    assert_eq!(ring.out(), [OutWord(0xC200_270F), OutWord(0x0102_4003), OutWord(0x4004_4005)]);
    let read = inline_answer(&mut ring, &[3, 0x1F, 0x44, 0, 4]);
    assert_eq!(read, [3, 8, 0x80, 0x04, 0x80, 0x05, 0xC2, 0x00, 0x27, 0x0F]);

    let refused = |request: &[u8]| refused_by(RegisterMap::Inline, request);
    assert_eq!(refused(&[23, 0x1F, 0x46, 0, 2, 0x1F, 0x46, 0, 1, 2, 1, 2]), [0x97, 1]);
    assert_eq!(refused(&[23]), [0x97, 1]);
    // IN, from IN into OUT, the directory, past the last encoder, and what only the plain layout has.
    assert_eq!(refused(&[6, 0x1F, 0x45, 1, 2]), [0x86, 2]);
    assert_eq!(refused(&[16, 0x1F, 0x45, 0, 2, 4, 1, 2, 3, 4]), [0x90, 2]);
    assert_eq!(refused(&[6, 0x05, 0x78, 1, 2]), [0x86, 2]);
    assert_eq!(refused(&[3, 0x1F, 0x4B, 0, 2]), [0x83, 2]);
    assert_eq!(refused(&[6, 0, 0, 1, 2]), [0x86, 2]);
}

#[test]
fn a_wrong_count_is_named_before_a_wrong_address() {
    assert_eq!(refused(&[3, 0xFF, 0xFF, 0, 0]), [0x83, 3]);
    assert_eq!(refused(&[4, 0xFF, 0xFF, 0, 126]), [0x84, 3]);
    assert_eq!(refused(&[16, 0x03, 0xE8, 0, 1, 3, 1, 2]), [0x90, 3]);
    assert_eq!(refused(&[23, 0xFF, 0xFF, 0, 1, 0, 0, 0, 0, 0]), [0x97, 3]);
}

#[test]
fn the_limits_of_a_request_are_125_registers_read_and_123_or_121_written() {
    let mut longest = image(ENCODERS_MAX);
    let write = |head: &[u8], registers: u8| {
        let mut request = [head, &[0, registers, 2 * registers]].concat();
        request.resize(request.len() + 2 * usize::from(registers), 0);
        request
    };
    for code in [3, 4] {
        assert_eq!(answer(&mut longest, &[code, 0, 0, 0, 125]).len(), 252);
        assert_eq!(answer(&mut longest, &[code, 0, 0, 0, 126]), [code | 0x80, 3]);
    }
    assert_eq!(answer(&mut longest, &write(&[16, 0, 0], 123)), [16, 0, 0, 0, 123]);
    assert_eq!(answer(&mut longest, &write(&[16, 0, 0], 124)), [0x90, 3]);
    assert_eq!(answer(&mut longest, &write(&[23, 0, 0, 0, 125, 0, 0], 121)).len(), 252);
    assert_eq!(answer(&mut longest, &write(&[23, 0, 0, 0, 126, 0, 0], 121)), [0x97, 3]);
    assert_eq!(answer(&mut longest, &write(&[23, 0, 0, 0, 125, 0, 0], 122)), [0x97, 3]);
}

#[test]
fn a_ring_without_encoders_has_a_diagnosis_and_no_words() {
    let mut image = image(0);
    for request in requests() {
        assert_eq!(answer(&mut image, &request), [request[0] | 0x80, 2]);
    }
    assert_eq!(answer(&mut image, &[3, 0x03, 0x84, 0, 3]), [3, 6, 0xB0, 0xE0, 0xB3, 0x80, 0xC0, 0x00]);
    assert_eq!(inline_answer(&mut image, &[3, 0x05, 0x78, 0, 1]), [3, 2, 0, 0]);
    assert_eq!(inline_answer(&mut image, &[3, 0x1F, 0x40, 0, 1]), [0x83, 2]);
}

// [R5]
#[test]
fn whoever_looks_on_is_told_of_each_word_once_and_of_a_refused_write_never() {
    let told = |request: &[u8], order| {
        let mut told = Vec::new();
        let mut image = image(3);
        let _ = respond(request, &mut image, RegisterMap::Plain, order, &mut |position, written| {
            told.push((position, written));
        });
        told
    };
    let word = |word| Written::Both(OutWord(word));
    let two_and_a_half = [16, 0, 1, 0, 5, 10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10];
    assert_eq!(
        told(&two_and_a_half, WordOrder::HighFirst),
        [(0, Written::Low(0x0102)), (1, word(0x0304_0506)), (2, word(0x0708_090A))]
    );
    assert_eq!(
        told(&two_and_a_half, WordOrder::LowFirst),
        [(0, Written::High(0x0102)), (1, word(0x0506_0304)), (2, word(0x090A_0708))]
    );
    assert_eq!(told(&[6, 0, 4, 0xC2, 0], WordOrder::HighFirst), [(2, Written::High(0xC200))]);
    assert_eq!(told(&[16, 0, 5, 0, 2, 4, 0, 0, 0, 0], WordOrder::HighFirst), []);
    assert_eq!(told(&[4, 0, 0, 0, 2], WordOrder::HighFirst), []);
}
