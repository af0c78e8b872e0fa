//! Which register holds what: the tables of `docs/modbus.md`.

use std::fmt::{self, Display};
use std::str::FromStr;

use encoring_ring::ident::ENCODER;
use encoring_ring::image::{ENCODERS_MAX, Half, ProcessImage};
use encoring_words::{OutWord, Written};

use crate::place::{DATA, DIAGNOSIS, MODULES, REGISTERS_PER_ENCODER, Table, WordOrder};

/// Status and parameter, before the first segment.
const DIAGNOSIS_HEAD: usize = 2;

/// The registers of all words of the longest ring, of one direction.
const WORDS_MAX: usize = ENCODERS_MAX * REGISTERS_PER_ENCODER;
/// Registers of what the reader on an SSI shows.
const SSI_REGISTERS: usize = 4;
/// Those of its diagnosis.
const DIAGNOSIS_MAX: usize = DIAGNOSIS_HEAD + ENCODERS_MAX + 1;
/// Those of its diagnosis that stay clear of the mirror.
const DIAGNOSIS_BEFORE_MIRROR: usize = 99;

/// What the registers of a block show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// The OUT words, two registers each. They can be written.
    Out,
    /// The IN words, two registers each. They can only be read.
    In,
    /// Diagnostic status and parameter, then the faulty cycles of each segment. They can only be read.
    Diagnosis,
    /// How many encoders there are, then the identification of each. They can only be read.
    Directory,
    /// What the reader on the SSI of each encoder read last: field, verdict and count. They can only be read.
    Ssi,
    /// The IN words, then the OUT words. Of these only the OUT words can be written.
    Process,
}

/// Registers without a gap, as many as the ring has use for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// Where the functions look for it.
    pub table: Table,
    /// The address of its first register.
    pub first: u16,
    /// What it shows.
    pub content: Content,
    /// The most registers that it has, however long the ring is.
    pub room: usize,
}

/// Every register of the plain layout.
///
/// The mirror is for clients and functions that know holding registers only: with it, function 23 writes OUT and
/// reads IN in one request.
pub const MAP: [Block; 6] = {
    use Content::{Diagnosis, In, Out, Ssi};
    use Table::{Holding, Input};
    [
        Block { table: Holding, first: 0, content: Out, room: WORDS_MAX },
        Block { table: Holding, first: DIAGNOSIS, content: Diagnosis, room: DIAGNOSIS_BEFORE_MIRROR },
        Block { table: Holding, first: 1000, content: In, room: WORDS_MAX },
        Block { table: Input, first: 0, content: In, room: WORDS_MAX },
        Block { table: Input, first: DIAGNOSIS, content: Diagnosis, room: DIAGNOSIS_MAX },
        Block { table: Input, first: 2000, content: Ssi, room: ENCODERS_MAX * SSI_REGISTERS },
    ]
};

/// Every register of the Inline layout; both tables have the same.
pub const INLINE_MAP: [Block; 6] = {
    use Content::{Diagnosis, Directory, Process};
    use Table::{Holding, Input};
    [
        Block { table: Holding, first: DIAGNOSIS, content: Diagnosis, room: DIAGNOSIS_MAX },
        Block { table: Holding, first: MODULES, content: Directory, room: 1 + ENCODERS_MAX },
        Block { table: Holding, first: DATA.first, content: Process, room: 2 * WORDS_MAX },
        Block { table: Input, first: DIAGNOSIS, content: Diagnosis, room: DIAGNOSIS_MAX },
        Block { table: Input, first: MODULES, content: Directory, room: 1 + ENCODERS_MAX },
        Block { table: Input, first: DATA.first, content: Process, room: 2 * WORDS_MAX },
    ]
};

/// Which registers a server shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RegisterMap {
    /// [`MAP`]: OUT in holding registers, IN in input registers, from 0 on.
    #[default]
    Plain,
    /// [`INLINE_MAP`]: as an Inline bus coupler shows its modules. Function 23 is not served.
    Inline,
}

/// A layout was to be something else.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("layout {given:?}; it must be plain or inline")]
pub struct UnknownLayout {
    /// What was given.
    pub given: String,
}

impl FromStr for RegisterMap {
    type Err = UnknownLayout;

    fn from_str(given: &str) -> Result<Self, Self::Err> {
        match given {
            "plain" => Ok(Self::Plain),
            "inline" => Ok(Self::Inline),
            _ => Err(UnknownLayout { given: given.to_owned() }),
        }
    }
}

impl Display for RegisterMap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Plain => "plain",
            Self::Inline => "inline",
        })
    }
}

impl RegisterMap {
    /// Every register there is.
    #[must_use]
    pub const fn map(self) -> &'static [Block] {
        match self {
            Self::Plain => &MAP,
            Self::Inline => &INLINE_MAP,
        }
    }

    /// The first registers of the OUT and of the IN word of the encoder at a position, each with its table.
    #[must_use]
    pub const fn places(self, position: usize, encoders: usize) -> [(Table, usize); 2] {
        let offset = position * REGISTERS_PER_ENCODER;
        match self {
            Self::Plain => [(Table::Holding, offset), (Table::Input, offset)],
            Self::Inline => {
                let input = DATA.first as usize + offset;
                [(Table::Holding, input + encoders * REGISTERS_PER_ENCODER), (Table::Holding, input)]
            }
        }
    }
}

impl Block {
    /// How many registers it has on a ring of this many encoders.
    #[must_use]
    pub fn registers(&self, encoders: usize) -> usize {
        let wanted = match self.content {
            Content::Out | Content::In => encoders * REGISTERS_PER_ENCODER,
            Content::Diagnosis => DIAGNOSIS_HEAD + encoders + 1,
            Content::Directory => 1 + encoders,
            Content::Ssi => encoders * SSI_REGISTERS,
            Content::Process => 2 * encoders * REGISTERS_PER_ENCODER,
        };
        wanted.min(self.room)
    }
}

/// Some registers of one block, all of which exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Registers {
    content: Content,
    /// From the block's first register.
    offset: usize,
    count: usize,
    encoders: usize,
}

/// What one register holds.
#[derive(Clone, Copy)]
enum Cell {
    Out(usize, Half),
    In(usize, Half),
    Status,
    Parameter,
    Faults(usize),
    Encoders,
    Identification,
    SsiField(usize, Half),
    SsiVerdict(usize),
    SsiCount(usize),
}

impl Registers {
    /// `count` registers of a table from `address` on; `None` if one of them does not exist on a ring of this many
    /// encoders.
    #[must_use]
    pub fn find(
        layout: RegisterMap,
        table: Table,
        address: u16,
        count: u16,
        encoders: usize,
    ) -> Option<Self> {
        let count = usize::from(count);
        layout.map().iter().filter(|block| block.table == table).find_map(|block| {
            let offset = usize::from(address.checked_sub(block.first)?);
            let fits = offset + count <= block.registers(encoders);
            fits.then_some(Self { content: block.content, offset, count, encoders })
        })
    }

    /// `true` if all of them are of OUT words.
    #[must_use]
    pub const fn writable(&self) -> bool {
        match self.content {
            Content::Out => true,
            Content::Process => self.offset >= self.encoders * REGISTERS_PER_ENCODER,
            Content::In | Content::Diagnosis | Content::Directory | Content::Ssi => false,
        }
    }

    /// What each of them holds.
    fn cells(self, order: WordOrder) -> impl Iterator<Item = Cell> {
        let input = self.encoders * REGISTERS_PER_ENCODER;
        let position = |register: usize| register / REGISTERS_PER_ENCODER;
        (self.offset..self.offset + self.count).map(move |register| match self.content {
            Content::Out => Cell::Out(position(register), order.half(register)),
            Content::In => Cell::In(position(register), order.half(register)),
            Content::Process if register < input => Cell::In(position(register), order.half(register)),
            Content::Process => Cell::Out(position(register - input), order.half(register)),
            Content::Diagnosis => match register {
                0 => Cell::Status,
                1 => Cell::Parameter,
                _ => Cell::Faults(register - DIAGNOSIS_HEAD),
            },
            Content::Directory if register == 0 => Cell::Encoders,
            Content::Directory => Cell::Identification,
            Content::Ssi => match (register / SSI_REGISTERS, register % SSI_REGISTERS) {
                (at, half @ (0 | 1)) => Cell::SsiField(at, order.half(half)),
                (at, 2) => Cell::SsiVerdict(at),
                (at, _) => Cell::SsiCount(at),
            },
        })
    }

    /// The registers' values, as they stand in the image they were found for.
    pub fn read(self, image: &ProcessImage, order: WordOrder) -> impl Iterator<Item = u16> {
        self.cells(order).filter_map(move |cell| match cell {
            Cell::Out(position, half) => image.out_half(position, half),
            Cell::In(position, half) => image.input_half(position, half),
            Cell::Status => Some(image.status()),
            Cell::Parameter => Some(image.parameter()),
            Cell::Faults(segment) => image.faults().get(segment).copied(),
            // There are at most 128.
            Cell::Encoders => u16::try_from(image.encoders()).ok(),
            Cell::Identification => Some(ENCODER.0),
            Cell::SsiField(position, Half::High) => {
                image.ssi().get(position).map(|it| (it.field >> 16) as u16)
            }
            Cell::SsiField(position, Half::Low) => image.ssi().get(position).map(|it| it.field as u16),
            Cell::SsiVerdict(position) => image.ssi().get(position).map(|it| it.verdict),
            Cell::SsiCount(position) => image.ssi().get(position).map(|it| it.count),
        })
    }

    /// Replaces the registers' values, the other half of a word staying as it is. What cannot be written stays. `wrote` is
    /// told the position of each OUT word, and what was written to it.
    pub fn write(
        self,
        image: &mut ProcessImage,
        order: WordOrder,
        values: impl IntoIterator<Item = u16>,
        wrote: &mut dyn FnMut(usize, Written),
    ) {
        for (position, written) in self.written(order, values) {
            image.write_out(position, written);
            wrote(position, written);
        }
    }

    /// What values write to which OUT words: all of a word where both halves are among them.
    fn written(
        self,
        order: WordOrder,
        values: impl IntoIterator<Item = u16>,
    ) -> impl Iterator<Item = (usize, Written)> {
        let mut halves = self
            .cells(order)
            .zip(values)
            .filter_map(|(cell, value)| match cell {
                Cell::Out(position, half) => Some((position, half, value)),
                _ => None,
            })
            .peekable();
        std::iter::from_fn(move || {
            let (position, half, value) = halves.next()?;
            let other = halves.next_if(|(next, ..)| *next == position).map(|(.., value)| value);
            Some((
                position,
                match (half, other) {
                    (Half::High, None) => Written::High(value),
                    (Half::Low, None) => Written::Low(value),
                    (Half::High, Some(low)) => Written::Both(OutWord::from_halves(value, low)),
                    (Half::Low, Some(high)) => Written::Both(OutWord::from_halves(high, value)),
                },
            ))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use encoring_ring::image::SsiShown;
    use encoring_words::InWord;

    fn image() -> ProcessImage {
        let mut image = ProcessImage::new(2).unwrap();
        image.out_mut().copy_from_slice(&[OutWord(0xC200_270F), OutWord(0x0102_0304)]);
        image.input_mut().copy_from_slice(&[InWord(0x0000_1234), InWord(0xC800_5678)]);
        image.diagnose(0x10E0, 0x0380, [1, 2, 70_000]);
        image.show_ssi(1, SsiShown { field: 0x0102_4E1F, verdict: 7, count: 9 });
        image
    }

    fn read(table: Table, address: u16, count: u16, order: WordOrder) -> Option<Vec<u16>> {
        read_in(RegisterMap::Plain, table, address, count, order)
    }

    fn read_in(
        layout: RegisterMap,
        table: Table,
        address: u16,
        count: u16,
        order: WordOrder,
    ) -> Option<Vec<u16>> {
        Some(Registers::find(layout, table, address, count, 2)?.read(&image(), order).collect())
    }

    fn find(table: Table, address: u16, count: u16, encoders: usize) -> Option<Registers> {
        Registers::find(RegisterMap::Plain, table, address, count, encoders)
    }

    /// The map as the table of the documentation.
    fn markdown(layout: RegisterMap) -> String {
        let mut page = String::from("| Registers | Addresses | Hold | Functions |\n|---|---|---|---|\n");
        let from =
            |first: usize, text: &str| if first == 0 { text.to_owned() } else { format!("{first}+{text}") };
        for block in layout.map() {
            let first = usize::from(block.first);
            let words = format!("{}, {}", from(first, "2k"), from(first, "2k+1"));
            let rows = match block.content {
                Content::Out => vec![(words, "OUT of position k".to_owned())],
                Content::In => vec![(words, "IN of position k".to_owned())],
                Content::Process => vec![
                    (words, "IN of position k".to_owned()),
                    (
                        format!("{first}+2n+2k, {first}+2n+2k+1"),
                        "OUT of position k, of n encoders".to_owned(),
                    ),
                ],
                Content::Diagnosis => {
                    let last = block.room - DIAGNOSIS_HEAD - 1;
                    vec![
                        (first.to_string(), "diagnostic status".to_owned()),
                        ((first + 1).to_string(), "diagnostic parameter".to_owned()),
                        (
                            format!("{}+k", first + DIAGNOSIS_HEAD),
                            format!("faulty cycles on segment k, up to {last}"),
                        ),
                    ]
                }
                Content::Ssi => vec![
                    (
                        format!("{first}+4k, {first}+4k+1"),
                        "field that the SSI reader of position k read last".to_owned(),
                    ),
                    (format!("{}+4k", first + 2), "its verdict".to_owned()),
                    (format!("{}+4k", first + 3), "how many transfers it has read".to_owned()),
                ],
                Content::Directory => vec![
                    (first.to_string(), "how many encoders there are".to_owned()),
                    (format!("{}+k", first + 1), format!("identification of position k: {:04X}h", ENCODER.0)),
                ],
            };
            for (addresses, hold) in rows {
                let read = match (block.table, layout) {
                    (Table::Holding, RegisterMap::Plain) => "read 3, 23",
                    (Table::Holding, RegisterMap::Inline) => "read 3",
                    (Table::Input, _) => "read 4",
                };
                let write = match (block.table, layout) {
                    (Table::Holding, RegisterMap::Plain) if hold.starts_with("OUT") => "; write 6, 16, 23",
                    (Table::Holding, RegisterMap::Inline) if hold.starts_with("OUT") => "; write 6, 16",
                    _ => "",
                };
                page += &format!("| {} | {addresses} | {hold} | {read}{write} |\n", block.table);
            }
        }
        page
    }

    #[test]
    fn the_documentation_holds_the_map() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/modbus.md");
        let page = std::fs::read_to_string(page).unwrap();
        for layout in [RegisterMap::Plain, RegisterMap::Inline] {
            let table = markdown(layout);
            assert!(page.contains(&table), "docs/modbus.md must hold this table:\n{table}");
        }
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
        find(Table::Holding, 2, 2, 2).unwrap().write(&mut image, order, [0x0005, 0xC500], &mut |_, _| {});
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
            assert!(find(table, first, 4, 2).is_some());
            assert!(find(table, first, 5, 2).is_none());
            assert!(find(table, first + 4, 1, 2).is_none());
            assert!(find(table, first, 1, 0).is_none());
        }
        assert!(find(Table::Holding, 999, 2, 2).is_none());
        assert!(find(Table::Holding, u16::MAX, u16::MAX, ENCODERS_MAX).is_none());
    }

    #[test]
    fn no_range_reaches_from_one_block_into_another() {
        for layout in [RegisterMap::Plain, RegisterMap::Inline] {
            for (index, block) in layout.map().iter().enumerate() {
                let end = usize::from(block.first) + block.registers(ENCODERS_MAX);
                let behind = layout.map().iter().skip(index + 1).find(|other| other.table == block.table);
                let next = behind.map_or(0x1_0000, |next| usize::from(next.first));
                assert!(end < next, "{block:?} touches {next}");
            }
        }
    }

    #[test]
    fn the_diagnosis_is_status_parameter_and_a_count_for_each_segment() {
        for layout in [RegisterMap::Plain, RegisterMap::Inline] {
            for table in [Table::Holding, Table::Input] {
                let read = |address, count| read_in(layout, table, address, count, WordOrder::LowFirst);
                assert_eq!(read(900, 5).unwrap(), [0x10E0, 0x0380, 1, 2, 0xFFFF]);
                assert_eq!(read(904, 1).unwrap(), [0xFFFF]);
                assert_eq!(read(904, 2), None);
                assert_eq!(read(899, 2), None);
                assert!(!Registers::find(layout, table, 900, 1, 2).unwrap().writable());
            }
        }
    }

    #[test]
    fn what_an_ssi_reader_read_last_is_its_field_a_verdict_and_a_count() {
        let order = WordOrder::default();
        assert_eq!(read(Table::Input, 2000, 8, order).unwrap(), [0, 0, 0, 0, 0x0102, 0x4E1F, 7, 9]);
        assert_eq!(read(Table::Input, 2004, 4, WordOrder::LowFirst).unwrap(), [0x4E1F, 0x0102, 7, 9]);
        assert_eq!(read(Table::Input, 2005, 4, order), None);
        assert_eq!(read(Table::Holding, 2000, 4, order), None);
        assert!(!find(Table::Input, 2004, 4, 2).unwrap().writable());
    }

    #[test]
    fn before_the_mirror_is_room_for_97_segments_and_among_input_registers_for_all() {
        assert!(find(Table::Holding, 900, 2 + 97, 96).is_some());
        assert!(find(Table::Holding, 900, 2 + 97, 128).is_some());
        assert!(find(Table::Holding, 900, 2 + 98, 128).is_none());
        assert!(find(Table::Input, 906, 125, 128).is_some());
        assert!(find(Table::Input, 907, 125, 128).is_none());
        assert!(Registers::find(RegisterMap::Inline, Table::Holding, 906, 125, 128).is_some());
    }

    #[test]
    fn the_inline_layout_has_a_directory_and_the_in_words_before_the_out_words() {
        let read =
            |address, count, order| read_in(RegisterMap::Inline, Table::Holding, address, count, order);
        let order = WordOrder::HighFirst;
        assert_eq!(read(1400, 3, order).unwrap(), [2, 0x0233, 0x0233]);
        assert_eq!(read(1400, 4, order), None);
        let process = [0x0000, 0x1234, 0xC800, 0x5678, 0xC200, 0x270F, 0x0102, 0x0304];
        assert_eq!(read(8000, 8, order).unwrap(), process);
        assert_eq!(read(8000, 9, order), None);
        assert_eq!(read(8003, 2, WordOrder::LowFirst).unwrap(), [0xC800, 0x270F]);
        assert_eq!(read(0, 1, order), None);

        let process =
            |address, count| Registers::find(RegisterMap::Inline, Table::Holding, address, count, 2).unwrap();
        assert!(process(8004, 4).writable());
        for (address, count) in [(8000, 1), (8003, 2), (1401, 1)] {
            assert!(!process(address, count).writable(), "{address}");
        }
        let mut image = image();
        process(8006, 2).write(&mut image, WordOrder::LowFirst, [0x0005, 0xC500], &mut |_, _| {});
        assert_eq!(image.out(), [OutWord(0xC200_270F), OutWord(0xC500_0005)]);
    }

    #[test]
    fn the_first_registers_of_an_encoder_hold_its_words() {
        for layout in [RegisterMap::Plain, RegisterMap::Inline] {
            for position in 0..2 {
                let [out, input] = layout.places(position, 2).map(|(table, first)| {
                    read_in(layout, table, first as u16, 2, WordOrder::HighFirst).unwrap()
                });
                let image = image();
                assert_eq!(out, [image.out()[position].high(), image.out()[position].low()]);
                assert_eq!(input, [image.input()[position].high(), image.input()[position].low()]);
            }
        }
    }

    #[test]
    fn a_layout_is_named_as_on_the_command_line() {
        for layout in [RegisterMap::Plain, RegisterMap::Inline] {
            assert_eq!(layout.to_string().parse(), Ok(layout));
        }
        let error = "Inline".parse::<RegisterMap>().unwrap_err();
        assert_eq!(error.to_string(), "layout \"Inline\"; it must be plain or inline");
    }

    #[test]
    fn the_mirror_cannot_be_written() {
        let mut changed = image();
        let mirror = find(Table::Holding, 1000, 2, 2).unwrap();
        assert!(!mirror.writable());
        mirror.write(&mut changed, WordOrder::HighFirst, [1, 2], &mut |_, _| {});
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
