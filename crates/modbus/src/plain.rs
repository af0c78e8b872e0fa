//! The rules of `docs/modbus.md` once more, for the tests: register by register and from a table of functions, with
//! nothing of the code under test but the types of its input and output.

use encoring_ring::ProcessImage;
use encoring_ring::image::SsiShown;
use encoring_words::{InWord, OutWord};

use crate::place::WordOrder;
use crate::registers::RegisterMap;

/// A function: where its fields stand in the PDU, counted from the function code.
struct Row {
    code: u8,
    /// Bytes before the values.
    head: usize,
    /// Register table, place of the address, place of the count.
    read: Option<(usize, usize, usize)>,
    /// RegisterPlace of the address, place of the count (function 6 has none), the most registers.
    write: Option<(usize, Option<usize>, u16)>,
    byte_count: Option<usize>,
}

/// The register tables, each of 65536 places, most of them empty.
const HOLDING: usize = 0;
const INPUT: usize = 1;

static ROWS: [Row; 5] = [
    Row { code: 3, head: 5, read: Some((HOLDING, 1, 3)), write: None, byte_count: None },
    Row { code: 4, head: 5, read: Some((INPUT, 1, 3)), write: None, byte_count: None },
    Row { code: 6, head: 3, read: None, write: Some((1, None, 1)), byte_count: None },
    Row { code: 16, head: 6, read: None, write: Some((1, Some(3), 123)), byte_count: Some(5) },
    Row {
        code: 23,
        head: 10,
        read: Some((HOLDING, 1, 3)),
        write: Some((5, Some(7), 121)),
        byte_count: Some(9),
    },
];

/// What stands in a register: half of a word, given by its lowest bit, or a number that no request changes.
#[derive(Clone, Copy)]
enum Cell {
    Out(usize, u32),
    In(usize, u32),
    Always(u16),
}

pub(crate) struct Plain {
    pub(crate) image: ProcessImage,
    tables: [Vec<Option<Cell>>; 2],
    rows: &'static [Row],
}

const STATUS: u16 = 0xB0E0;
const PARAMETER: u16 = 0xB380;
const FAULTS: u16 = 0xC000;
const SSI: u16 = 0xD000;

fn number(pdu: &[u8], at: usize) -> u16 {
    u16::from(pdu[at]) * 256 + u16::from(pdu[at + 1])
}

/// An image in which no two registers are alike.
pub(crate) fn image(encoders: usize) -> ProcessImage {
    let mut image = ProcessImage::new(encoders).unwrap();
    let words = (0..).map(|k: u32| (0x4000 + 2 * k) << 16 | (0x4001 + 2 * k));
    image.out_mut().iter_mut().zip(words).for_each(|(word, value)| *word = OutWord(value));
    let words = (0..).map(|k: u32| (0x8000 + 2 * k) << 16 | (0x8001 + 2 * k));
    image.input_mut().iter_mut().zip(words).for_each(|(word, value)| *word = InWord(value));
    image.diagnose(STATUS, PARAMETER, u32::from(FAULTS)..);
    for (position, at) in (0..encoders).zip((SSI..).step_by(4)) {
        let field = u32::from(at) << 16 | u32::from(at + 1);
        image.show_ssi(position, SsiShown { field, verdict: at + 2, count: at + 3 });
    }
    image
}

impl Plain {
    pub(crate) fn new(encoders: usize, layout: RegisterMap, order: WordOrder) -> Self {
        let [first, second] = match order {
            WordOrder::HighFirst => [16, 0],
            WordOrder::LowFirst => [0, 16],
        };
        let mut tables = [HOLDING, INPUT].map(|_| vec![None; 65536]);
        for table in [HOLDING, INPUT] {
            tables[table][900] = Some(Cell::Always(STATUS));
            tables[table][901] = Some(Cell::Always(PARAMETER));
            for k in 0..=encoders {
                tables[table][902 + k] = Some(Cell::Always(FAULTS + k as u16));
            }
        }
        match layout {
            RegisterMap::Plain => {
                // Here the diagnosis ends, and 1000 begins the mirror.
                tables[HOLDING][999..].fill(None);
                for k in 0..encoders {
                    for (register, bit) in [(2 * k, first), (2 * k + 1, second)] {
                        tables[HOLDING][register] = Some(Cell::Out(k, bit));
                        tables[HOLDING][1000 + register] = Some(Cell::In(k, bit));
                        tables[INPUT][register] = Some(Cell::In(k, bit));
                    }
                    let [high, low] = if first == 16 { [0, 1] } else { [1, 0] };
                    for (register, shown) in [high, low, 2, 3].into_iter().enumerate() {
                        let shown = SSI + 4 * k as u16 + shown;
                        tables[INPUT][2000 + 4 * k + register] = Some(Cell::Always(shown));
                    }
                }
            }
            RegisterMap::Inline => {
                for table in &mut tables {
                    table[1400] = Some(Cell::Always(encoders as u16));
                    for k in 0..encoders {
                        table[1401 + k] = Some(Cell::Always(0x0233));
                        for (register, bit) in [(2 * k, first), (2 * k + 1, second)] {
                            table[8000 + register] = Some(Cell::In(k, bit));
                            table[8000 + 2 * encoders + register] = Some(Cell::Out(k, bit));
                        }
                    }
                }
            }
        }
        let rows = match layout {
            RegisterMap::Plain => &ROWS[..],
            // All but function 23.
            RegisterMap::Inline => &ROWS[..4],
        };
        Self { image: image(encoders), tables, rows }
    }

    fn cell(&self, table: usize, first: u16, k: u16) -> Option<Cell> {
        *self.tables[table].get(usize::from(first) + usize::from(k))?
    }

    /// The answer to a PDU; a success of a writing function has changed the image.
    pub(crate) fn respond(&mut self, pdu: &[u8]) -> Vec<u8> {
        let code = pdu.first().copied().unwrap_or(0);
        self.judge(pdu, code).unwrap_or_else(|exception| vec![code | 0x80, exception])
    }

    fn judge(&mut self, pdu: &[u8], code: u8) -> Result<Vec<u8>, u8> {
        let row = self.rows.iter().find(|row| row.code == code).ok_or(1)?;
        if pdu.len() < row.head {
            return Err(3);
        }
        let read = row.read.map(|(table, at, count)| (table, number(pdu, at), number(pdu, count)));
        if read.is_some_and(|(_, _, count)| count == 0 || count > 125) {
            return Err(3);
        }
        let mut length = row.head;
        let mut write = None;
        if let Some((at, count, most)) = row.write {
            let count = count.map_or(1, |count| number(pdu, count));
            if count == 0 || count > most {
                return Err(3);
            }
            length += 2 * usize::from(count);
            if row.byte_count.is_some_and(|at| u16::from(pdu[at]) != 2 * count) {
                return Err(3);
            }
            write = Some((number(pdu, at), count));
        }
        if pdu.len() != length {
            return Err(3);
        }

        let mut to = Vec::new();
        if let Some((first, count)) = write {
            for k in 0..count {
                match self.cell(HOLDING, first, k) {
                    Some(Cell::Out(position, bit)) => to.push((position, bit)),
                    _ => return Err(2),
                }
            }
        }
        let mut from = Vec::new();
        if let Some((table, first, count)) = read {
            for k in 0..count {
                from.push(self.cell(table, first, k).ok_or(2)?);
            }
        }

        for (k, (position, bit)) in to.into_iter().enumerate() {
            let value = u32::from(number(pdu, row.head + 2 * k));
            let word = &mut self.image.out_mut()[position].0;
            *word = *word & !(0xFFFF << bit) | value << bit;
        }
        if row.read.is_none() {
            return Ok(pdu[..5].to_vec());
        }
        let mut answer = vec![code, u8::try_from(2 * from.len()).unwrap()];
        for cell in from {
            let half = match cell {
                Cell::Out(position, bit) => self.image.out()[position].0 >> bit,
                Cell::In(position, bit) => self.image.input()[position].0 >> bit,
                Cell::Always(value) => value.into(),
            };
            answer.extend([(half >> 8) as u8, half as u8]);
        }
        Ok(answer)
    }
}

/// One valid request of each function for a ring of three encoders.
pub(crate) fn requests() -> [Vec<u8>; 5] {
    [
        vec![3, 0, 0, 0, 6],
        vec![4, 0, 2, 0, 3],
        vec![6, 0, 1, 0x27, 0x0F],
        vec![16, 0, 2, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F],
        vec![23, 0x03, 0xE8, 0, 4, 0, 4, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F],
    ]
}

/// Valid requests for the diagnosis of a ring of three encoders.
pub(crate) fn diagnosis() -> [Vec<u8>; 3] {
    [
        vec![3, 0x03, 0x84, 0, 6],
        vec![4, 0x03, 0x86, 0, 4],
        vec![23, 0x03, 0x84, 0, 6, 0, 4, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F],
    ]
}

/// One valid request of each function for a ring of three encoders in the Inline layout, and one for its directory.
pub(crate) fn inline_requests() -> [Vec<u8>; 5] {
    [
        vec![3, 0x1F, 0x40, 0, 12],
        vec![4, 0x1F, 0x45, 0, 2],
        vec![6, 0x1F, 0x46, 0x27, 0x0F],
        vec![16, 0x1F, 0x48, 0, 2, 4, 0xC2, 0x00, 0x27, 0x0F],
        vec![3, 0x05, 0x78, 0, 4],
    ]
}

/// The request with a header in front of it.
pub(crate) fn framed(transaction: u16, unit: u8, pdu: &[u8]) -> Vec<u8> {
    let length = u16::try_from(pdu.len() + 1).unwrap();
    let mut frame = [transaction, 0, length].map(u16::to_be_bytes).concat();
    frame.push(unit);
    frame.extend(pdu);
    frame
}
