//! An EEPROM in memory that fails on demand.

use std::fmt;

use embedded_storage::{ReadStorage, Storage};
use encoring_encoder::Ram;
use encoring_encoder::records::EEPROM_BYTES;

/// One encoder's EEPROM, and what is wrong with it.
#[derive(Clone, PartialEq, Eq)]
pub struct Eeprom {
    cells: Ram,
    faults: Vec<Fault>,
    /// Bytes that can still be written before the power is cut.
    cut_after: Option<u64>,
    written: u64,
}

/// How a cell fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellFault {
    /// Reading it fails.
    Read,
    /// Writing it fails.
    Write,
    /// It always reads as this byte, whatever is written.
    Stuck(u8),
}

/// A fault of one cell, or of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fault {
    kind: CellFault,
    cell: Option<usize>,
}

/// The memory did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MemoryError {
    /// A cell is defective.
    Cell,
    /// The power was cut during a write, and everything fails until it is back.
    PowerCut,
    /// Past the last byte.
    OutOfBounds,
}

impl fmt::Display for MemoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cell => "a cell of the memory is defective",
            Self::PowerCut => "the power was cut",
            Self::OutOfBounds => "past the end of the memory",
        })
    }
}

impl std::error::Error for MemoryError {}

impl Eeprom {
    /// A memory as it comes from its maker: every byte FFh.
    #[must_use]
    pub const fn blank() -> Self {
        Self::from_image([0xFF; EEPROM_BYTES])
    }

    /// A sound memory with these bytes.
    #[must_use]
    pub const fn from_image(image: [u8; EEPROM_BYTES]) -> Self {
        Self { cells: Ram::from_image(image), faults: Vec::new(), cut_after: None, written: 0 }
    }

    /// Its bytes, whatever its faults.
    #[must_use]
    pub const fn image(&self) -> &[u8; EEPROM_BYTES] {
        self.cells.image()
    }

    /// Bytes written so far, those of failing cells too.
    #[must_use]
    pub const fn written(&self) -> u64 {
        self.written
    }

    /// Makes one cell fail, or with `None` every cell.
    pub fn fail(&mut self, kind: CellFault, cell: Option<usize>) {
        let fault = Fault { kind, cell };
        if !self.faults.contains(&fault) {
            self.faults.push(fault);
        }
    }

    /// Cuts the power after this many more bytes have been written.
    pub const fn cut_after(&mut self, bytes: u64) {
        self.cut_after = Some(bytes);
    }

    /// `true` once the power has been cut in a write.
    #[must_use]
    pub const fn is_cut(&self) -> bool {
        matches!(self.cut_after, Some(0))
    }

    /// The power is back; defective cells stay defective.
    pub const fn power_back(&mut self) {
        if self.is_cut() {
            self.cut_after = None;
        }
    }

    /// Takes every fault away.
    pub fn repair(&mut self) {
        self.faults.clear();
        self.cut_after = None;
    }

    fn fault(&self, cell: usize, wanted: impl Fn(CellFault) -> bool) -> Option<CellFault> {
        let hits = |fault: &&Fault| fault.cell.is_none_or(|at| at == cell) && wanted(fault.kind);
        self.faults.iter().find(hits).map(|fault| fault.kind)
    }

    fn span(offset: u32, length: usize) -> Result<std::ops::Range<usize>, MemoryError> {
        let start = offset as usize;
        match start.checked_add(length) {
            Some(end) if end <= EEPROM_BYTES => Ok(start..end),
            _ => Err(MemoryError::OutOfBounds),
        }
    }
}

impl fmt::Debug for Eeprom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Eeprom").field("faults", &self.faults).field("cut_after", &self.cut_after).finish()
    }
}

impl ReadStorage for Eeprom {
    type Error = MemoryError;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), MemoryError> {
        let span = Self::span(offset, bytes.len())?;
        if self.is_cut() {
            return Err(MemoryError::PowerCut);
        }
        self.cells.read(offset, bytes).map_err(|_| MemoryError::OutOfBounds)?;
        if self.faults.is_empty() {
            return Ok(());
        }
        for (cell, byte) in span.zip(bytes) {
            if self.fault(cell, |kind| kind == CellFault::Read).is_some() {
                return Err(MemoryError::Cell);
            }
            if let Some(CellFault::Stuck(value)) =
                self.fault(cell, |kind| matches!(kind, CellFault::Stuck(_)))
            {
                *byte = value;
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        EEPROM_BYTES
    }
}

impl Storage for Eeprom {
    /// Writes byte by byte in rising order, so that a cut leaves a prefix.
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), MemoryError> {
        let span = Self::span(offset, bytes.len())?;
        for (cell, byte) in span.zip(bytes) {
            match &mut self.cut_after {
                Some(0) => return Err(MemoryError::PowerCut),
                Some(left) => *left -= 1,
                None => {}
            }
            self.written += 1;
            if self.fault(cell, |kind| kind == CellFault::Write).is_some() {
                return Err(MemoryError::Cell);
            }
            if let Some(place) = self.cells.image_mut().get_mut(cell) {
                *place = *byte;
            }
        }
        if self.is_cut() { Err(MemoryError::PowerCut) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cut_leaves_exactly_the_bytes_before_it() {
        let mut memory = Eeprom::blank();
        memory.cut_after(2);
        assert_eq!(memory.write(10, &[1, 2, 3]), Err(MemoryError::PowerCut));
        assert_eq!(memory.image()[10..14], [1, 2, 0xFF, 0xFF]);
        assert_eq!(memory.read(10, &mut [0]), Err(MemoryError::PowerCut));
        memory.power_back();
        assert_eq!(memory.write(10, &[1, 2, 3]), Ok(()));
    }

    #[test]
    fn each_fault_hits_its_cell_and_no_other() {
        for cell in 0..4 {
            let mut memory = Eeprom::from_image([7; EEPROM_BYTES]);
            memory.fail(CellFault::Read, Some(cell));
            let results: Vec<bool> = (0..4).map(|at| memory.read(at, &mut [0]).is_ok()).collect();
            assert_eq!(results.iter().filter(|ok| !**ok).count(), 1);
            assert!(!results[cell]);
            memory.repair();
            memory.fail(CellFault::Stuck(9), Some(cell));
            assert_eq!(memory.write(0, &[1, 2, 3, 4]), Ok(()));
            let mut back = [0; 4];
            memory.read(0, &mut back).unwrap();
            let mut expected = [1, 2, 3, 4];
            expected[cell] = 9;
            assert_eq!(back, expected);
        }
        let mut memory = Eeprom::blank();
        memory.fail(CellFault::Write, None);
        assert_eq!(memory.write(500, &[1]), Err(MemoryError::Cell));
        assert_eq!(memory.write(511, &[1, 2]), Err(MemoryError::OutOfBounds));
    }

    #[test]
    fn without_faults_nothing_is_changed() {
        let mut memory = Eeprom::blank();
        memory.repair();
        assert_eq!(memory.write(0, &[1, 2, 3]), Ok(()));
        let mut back = [0; 3];
        memory.read(0, &mut back).unwrap();
        assert_eq!(back, [1, 2, 3]);
    }
}
