//! Any bytes as a stream of Modbus TCP requests to a process image, judged beside plain lists of registers.
#![no_main]

use encoring_modbus::{RegisterMap, WordOrder};
use encoring_modbus::pdu::{PDU_MAX, respond};
use encoring_ring::ProcessImage;
use encoring_ring::image::SsiShown;
use encoring_words::{InWord, OutWord};
use libfuzzer_sys::fuzz_target;

const DIAGNOSIS: usize = 900;
const MIRROR: usize = 1000;
const MODULES: usize = 1400;
const SSI: usize = 2000;
const PROCESS: usize = 8000;

/// The halves of the words in the order of their registers.
fn registers(words: impl Iterator<Item = u32>, order: WordOrder) -> Vec<u16> {
    let halves = |word: u32| match order {
        WordOrder::HighFirst => [(word >> 16) as u16, word as u16],
        WordOrder::LowFirst => [word as u16, (word >> 16) as u16],
    };
    words.flat_map(halves).collect()
}

fn out(image: &ProcessImage, order: WordOrder) -> Vec<u16> {
    registers(image.out().iter().map(|word| word.0), order)
}

fn input(image: &ProcessImage, order: WordOrder) -> Vec<u16> {
    registers(image.input().iter().map(|word| word.0), order)
}

fn diagnosis(image: &ProcessImage) -> Vec<u16> {
    [&[image.status(), image.parameter()], image.faults()].concat()
}

/// Field, verdict and count of what hangs on each SSI.
fn ssi(image: &ProcessImage, order: WordOrder) -> Vec<u16> {
    let of = |shown: &SsiShown| [registers(std::iter::once(shown.field), order), vec![shown.verdict, shown.count]].concat();
    image.ssi().iter().flat_map(of).collect()
}

fn number(request: &[u8], at: usize) -> usize {
    usize::from(u16::from_be_bytes([request[at], request[at + 1]]))
}

/// Writes big-endian values into the registers from `address` on; one that does not exist is out of bounds.
fn write(registers: &mut [u16], address: usize, values: &[u8]) {
    for (register, value) in (address..).zip(values.chunks(2)) {
        registers[register] = u16::from_be_bytes([value[0], value[1]]);
    }
}

fn judge(request: &[u8], image: &mut ProcessImage, layout: RegisterMap, order: WordOrder) {
    let before = image.clone();
    let (mut outputs, inputs) = (out(image, order), input(image, order));
    let encoders = image.encoders();
    let first_out = if layout == RegisterMap::Inline { PROCESS + inputs.len() } else { 0 };
    let answer = respond(request, image, layout, order, &mut |_, _| {});
    let exception = answer.is_exception();
    let answer = answer.as_bytes();
    assert!((2..=PDU_MAX).contains(&answer.len()), "{request:02X?} -> {answer:02X?}");
    assert_eq!(image.input(), before.input(), "{request:02X?} changed what only encoders say");
    assert_eq!(diagnosis(image), diagnosis(&before), "{request:02X?} changed what only the master says");

    let function = request[0];
    let served = match layout {
        RegisterMap::Plain => [3, 4, 6, 16, 23].contains(&function),
        RegisterMap::Inline => [3, 4, 6, 16].contains(&function),
    };
    if exception {
        assert_eq!(*image, before, "{request:02X?} was refused and changed the image");
        assert_eq!(answer[0], function | 0x80, "{request:02X?} -> {answer:02X?}");
        assert_eq!(answer.len(), 2, "{request:02X?} -> {answer:02X?}");
        assert!((1..=3).contains(&answer[1]), "{request:02X?} -> {answer:02X?}");
        assert_eq!(answer[1] == 1, !served, "{request:02X?} -> {answer:02X?}");
        return;
    }
    assert!(served, "{request:02X?} -> {answer:02X?}");
    assert_eq!(answer[0], function, "{request:02X?} -> {answer:02X?}");

    // What is written: the registers named, and no others. One before the OUT words is out of bounds too.
    match function {
        6 => write(&mut outputs, number(request, 1) - first_out, &request[3..]),
        16 => write(&mut outputs, number(request, 1) - first_out, &request[6..]),
        23 => write(&mut outputs, number(request, 5) - first_out, &request[10..]),
        _ => {}
    }
    assert_eq!(out(image, order), outputs, "{request:02X?}");

    // What is read: after the write, from the registers named.
    if [6, 16].contains(&function) {
        assert_eq!(answer, &request[..5]);
        return;
    }
    let (address, count) = (number(request, 1), number(request, 3));
    let shown = match (layout, address) {
        (RegisterMap::Inline, PROCESS..) => (PROCESS, [inputs, outputs].concat()),
        (RegisterMap::Inline, MODULES..) => (MODULES, [vec![encoders as u16], vec![0x0233; encoders]].concat()),
        (RegisterMap::Plain, MIRROR..) if function != 4 => (MIRROR, inputs),
        (RegisterMap::Plain, SSI..) => (SSI, ssi(image, order)),
        (_, DIAGNOSIS..) => (DIAGNOSIS, diagnosis(image)),
        (RegisterMap::Plain, _) if function == 4 => (0, inputs),
        (RegisterMap::Plain, _) => (0, outputs),
        (RegisterMap::Inline, _) => panic!("{request:02X?} -> {answer:02X?}"),
    };
    let read = &shown.1[address - shown.0..address - shown.0 + count];
    let expected: Vec<u8> = read.iter().flat_map(|value| value.to_be_bytes()).collect();
    assert_eq!(usize::from(answer[1]), 2 * count, "{request:02X?} -> {answer:02X?}");
    assert_eq!(&answer[2..], expected, "{request:02X?} -> {answer:02X?}");
}

fuzz_target!(|bytes: &[u8]| {
    // The ring is picked by the first byte, the rest is the stream.
    let Some((&first, mut stream)) = bytes.split_first() else { return };
    let encoders = [0, 1, 3, 128][usize::from(first & 3)];
    let order = if first & 4 == 0 { WordOrder::HighFirst } else { WordOrder::LowFirst };
    let layout = if first & 8 == 0 { RegisterMap::Plain } else { RegisterMap::Inline };
    let mut image = ProcessImage::new(encoders).expect("at most 128");
    for (position, word) in (1..).zip(image.input_mut()) {
        *word = InWord(0x0102_0304 * position);
    }
    for (position, word) in (1..).zip(image.out_mut()) {
        *word = OutWord(0x4030_2010_u32.wrapping_add(position));
    }
    for position in 0..encoders {
        let at = position as u32;
        image.show_ssi(position, SsiShown { field: 0x0506_0708_u32.wrapping_mul(at + 1), verdict: at as u16, count: 0x0F0F });
    }
    image.diagnose(0x10E0, 0x0301, 0xFF80..);
    // Transaction, protocol, length, unit.
    while let [_, _, 0, 0, length_1, length_0, _, rest @ ..] = stream {
        let length = usize::from(u16::from_be_bytes([*length_1, *length_0]));
        if !(2..=PDU_MAX + 1).contains(&length) || rest.len() < length - 1 {
            break;
        }
        let (request, next) = rest.split_at(length - 1);
        judge(request, &mut image, layout, order);
        stream = next;
    }
});
