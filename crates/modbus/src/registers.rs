//! Which register holds what. The table in `docs/modbus.md` is printed from [`MAP`].

use std::fmt::{self, Display};
use std::str::FromStr;

use encoring_ring::image::{ENCODERS_MAX, Half, ProcessImage};

/// The registers of one encoder in each [`Block`]: the halves of a 32-bit word.
pub const REGISTERS_PER_ENCODER: usize = 2;

/// The two register tables of Modbus that are served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// Holding registers: functions 3, 6, 16 and 23.
    Holding,
    /// Input registers: function 4.
    Input,
}

impl Display for Table {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Holding => "holding",
            Self::Input => "input",
        })
    }
}

/// What the registers of a block show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// The OUT words. They can be written.
    Out,
    /// The IN words. They can only be read.
    In,
}

/// Registers without a gap: two for each encoder of the ring, in the order of the ring positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Where the functions look for it.
    pub table: Table,
    /// The address of position 0's first register.
    pub first: u16,
    /// What it shows.
    pub content: Content,
}

/// Every register there is.
///
/// The mirror is for clients and functions that know holding registers only: with it, function 23 writes OUT and
/// reads IN in one request.
pub const MAP: [Block; 3] = [
    Block { table: Table::Holding, first: 0, content: Content::Out },
    Block { table: Table::Holding, first: 1000, content: Content::In },
    Block { table: Table::Input, first: 0, content: Content::In },
];

// The blocks of one table keep clear of each other on the longest ring, with a gap that no range can cross.
const _: () = assert!(ENCODERS_MAX * REGISTERS_PER_ENCODER < 1000);

/// Which half of a 32-bit word stands in the register with the lower address. Modbus does not say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WordOrder {
    /// Bits 31..16 first, as the encoders' own word addresses "1" and "2" [R5].
    #[default]
    HighFirst,
    /// Bits 15..0 first.
    LowFirst,
}

/// A word order was to be something else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("word order {given:?}; it must be high-first or low-first")]
pub struct UnknownWordOrder {
    /// What was given.
    pub given: String,
}

impl FromStr for WordOrder {
    type Err = UnknownWordOrder;

    fn from_str(given: &str) -> Result<Self, Self::Err> {
        match given {
            "high-first" => Ok(Self::HighFirst),
            "low-first" => Ok(Self::LowFirst),
            _ => Err(UnknownWordOrder { given: given.to_owned() }),
        }
    }
}

impl Display for WordOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::HighFirst => "high-first",
            Self::LowFirst => "low-first",
        })
    }
}

impl WordOrder {
    /// The word that two registers hold.
    #[must_use]
    pub fn word(self, registers: [u16; REGISTERS_PER_ENCODER]) -> u32 {
        let [first, second] = registers.map(u32::from);
        match self {
            Self::HighFirst => first << 16 | second,
            Self::LowFirst => second << 16 | first,
        }
    }

    /// The registers that hold a word.
    #[must_use]
    pub const fn registers(self, word: u32) -> [u16; REGISTERS_PER_ENCODER] {
        let (high, low) = ((word >> 16) as u16, word as u16);
        match self {
            Self::HighFirst => [high, low],
            Self::LowFirst => [low, high],
        }
    }

    /// The halves in the order of their registers.
    const fn halves(self) -> [Half; REGISTERS_PER_ENCODER] {
        match self {
            Self::HighFirst => [Half::High, Half::Low],
            Self::LowFirst => [Half::Low, Half::High],
        }
    }
}

/// Some registers of one block, all of which exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    content: Content,
    /// From the block's first register.
    offset: usize,
    count: usize,
}

impl Registers {
    /// `count` registers of a table from `address` on; `None` if one of them does not exist on a ring of this many
    /// encoders.
    #[must_use]
    pub fn find(table: Table, address: u16, count: u16, encoders: usize) -> Option<Self> {
        let count = usize::from(count);
        MAP.iter().filter(|block| block.table == table).find_map(|block| {
            let offset = usize::from(address.checked_sub(block.first)?);
            let fits = offset + count <= encoders * REGISTERS_PER_ENCODER;
            fits.then_some(Self { content: block.content, offset, count })
        })
    }

    /// `true` for OUT words.
    #[must_use]
    pub fn writable(&self) -> bool {
        self.content == Content::Out
    }

    /// Position and half of each register.
    fn places(self, order: WordOrder) -> impl Iterator<Item = (usize, Half)> {
        let first = self.offset / REGISTERS_PER_ENCODER;
        let whole = (first..).flat_map(move |position| order.halves().map(|half| (position, half)));
        whole.skip(self.offset % REGISTERS_PER_ENCODER).take(self.count)
    }

    /// The registers' values, as they stand in the image they were found for.
    pub fn read(self, image: &ProcessImage, order: WordOrder) -> impl Iterator<Item = u16> {
        self.places(order).filter_map(move |(position, half)| match self.content {
            Content::Out => image.out_half(position, half),
            Content::In => image.input_half(position, half),
        })
    }

    /// Replaces the registers' values, the other half of a word staying as it is. What cannot be written stays.
    pub fn write(self, image: &mut ProcessImage, order: WordOrder, values: impl IntoIterator<Item = u16>) {
        if self.writable() {
            for ((position, half), value) in self.places(order).zip(values) {
                image.set_out_half(position, half, value);
            }
        }
    }
}

/// The map as the table of the documentation.
#[must_use]
pub fn markdown() -> String {
    let mut page =
        String::from("| Registers | Addresses for position k | Hold | Functions |\n|---|---|---|---|\n");
    for block in MAP {
        let table = block.table;
        let read = match table {
            Table::Holding => "3, 23",
            Table::Input => "4",
        };
        let addresses = match block.first {
            0 => "2k, 2k+1".to_owned(),
            first => format!("{first}+2k, {first}+2k+1"),
        };
        let (content, functions) = match block.content {
            Content::Out => ("OUT", format!("read {read}; write 6, 16, 23")),
            Content::In => ("IN", format!("read {read}")),
        };
        page += &format!("| {table} | {addresses} | {content} | {functions} |\n");
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;
    use encoring_words::{InWord, OutWord};

    fn image() -> ProcessImage {
        let mut image = ProcessImage::new(2).unwrap();
        image.out_mut().copy_from_slice(&[OutWord(0xC200_270F), OutWord(0x0102_0304)]);
        image.input_mut().copy_from_slice(&[InWord(0x0000_1234), InWord(0xC800_5678)]);
        image
    }

    fn read(table: Table, address: u16, count: u16, order: WordOrder) -> Option<Vec<u16>> {
        Some(Registers::find(table, address, count, 2)?.read(&image(), order).collect())
    }

    #[test]
    fn the_documentation_holds_the_map() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/modbus.md");
        let page = std::fs::read_to_string(page).unwrap();
        assert!(page.contains(&markdown()), "docs/modbus.md must hold this table:\n{}", markdown());
    }

    #[test]
    fn position_k_has_registers_2k_and_2k_plus_1_with_the_high_word_first() {
        let order = WordOrder::default();
        assert_eq!(read(Table::Holding, 0, 4, order).unwrap(), [0xC200, 0x270F, 0x0102, 0x0304]);
        assert_eq!(read(Table::Input, 0, 4, order).unwrap(), [0x0000, 0x1234, 0xC800, 0x5678]);
        assert_eq!(read(Table::Holding, 1000, 4, order).unwrap(), [0x0000, 0x1234, 0xC800, 0x5678]);
        assert_eq!(read(Table::Holding, 1, 2, order).unwrap(), [0x270F, 0x0102]);
    }

    #[test]
    fn low_first_swaps_out_in_and_mirror_alike() {
        let order = WordOrder::LowFirst;
        assert_eq!(read(Table::Holding, 0, 4, order).unwrap(), [0x270F, 0xC200, 0x0304, 0x0102]);
        assert_eq!(read(Table::Input, 0, 4, order).unwrap(), [0x1234, 0x0000, 0x5678, 0xC800]);
        assert_eq!(read(Table::Holding, 1000, 4, order).unwrap(), [0x1234, 0x0000, 0x5678, 0xC800]);

        let mut image = image();
        Registers::find(Table::Holding, 2, 2, 2).unwrap().write(&mut image, order, [0x0005, 0xC500]);
        assert_eq!(image.out(), [OutWord(0xC200_270F), OutWord(0xC500_0005)]);
    }

    #[test]
    fn a_word_is_made_of_its_registers_in_either_order() {
        assert_eq!(WordOrder::HighFirst.registers(0xC200_270F), [0xC200, 0x270F]);
        assert_eq!(WordOrder::LowFirst.registers(0xC200_270F), [0x270F, 0xC200]);
        for order in [WordOrder::HighFirst, WordOrder::LowFirst] {
            assert_eq!(order.word(order.registers(0x1234_5678)), 0x1234_5678);
        }
    }

    #[test]
    fn a_range_ends_with_the_last_encoder() {
        for (table, first) in [(Table::Holding, 0), (Table::Holding, 1000), (Table::Input, 0)] {
            assert!(Registers::find(table, first, 4, 2).is_some());
            assert!(Registers::find(table, first, 5, 2).is_none());
            assert!(Registers::find(table, first + 4, 1, 2).is_none());
            assert!(Registers::find(table, first, 1, 0).is_none());
        }
        assert!(Registers::find(Table::Holding, 999, 2, 2).is_none());
        assert!(Registers::find(Table::Holding, u16::MAX, u16::MAX, ENCODERS_MAX).is_none());
    }

    #[test]
    fn the_mirror_cannot_be_written() {
        let mut changed = image();
        let mirror = Registers::find(Table::Holding, 1000, 2, 2).unwrap();
        assert!(!mirror.writable());
        mirror.write(&mut changed, WordOrder::HighFirst, [1, 2]);
        assert_eq!(changed, image());
    }

    #[test]
    fn a_word_order_is_named_as_on_the_command_line() {
        for order in [WordOrder::HighFirst, WordOrder::LowFirst] {
            assert_eq!(order.to_string().parse(), Ok(order));
        }
        let error = "big".parse::<WordOrder>().unwrap_err();
        assert_eq!(error.to_string(), "word order \"big\"; it must be high-first or low-first");
    }
}
