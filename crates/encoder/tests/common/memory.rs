//! What can be wrong with an EEPROM.

use embedded_storage::{ReadStorage, Storage};
use encoring_encoder::Ram;

/// How a cell fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CellFault {
    /// Reading it is answered with an error.
    Read,
    /// Writing it is answered with an error, and it keeps its byte.
    Write,
    /// It is written without complaint and always reads as this byte.
    Stuck(u8),
}

/// What goes wrong with one single call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hiccup {
    /// It is not done and answered with an error.
    NotDone,
    /// It is done and answered with an error all the same.
    DoneAfterAll,
}

/// The memory did not do what it was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refused;

#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Memory {
    cells: Ram,
    faults: Vec<(Option<usize>, CellFault)>,
    /// Bytes that can still be written before the power is cut.
    budget: Option<usize>,
    cut: bool,
    written: usize,
    /// How many calls from now the hiccup comes.
    hiccup: Option<(usize, Hiccup)>,
}

impl Memory {
    /// As it comes from its maker.
    pub fn blank() -> Self {
        Self::on(Ram::blank())
    }

    pub fn from_image(bytes: Vec<u8>) -> Self {
        Self::on(Ram::from_image(bytes.try_into().unwrap()))
    }

    fn on(cells: Ram) -> Self {
        Self { cells, faults: Vec::new(), budget: None, cut: false, written: 0, hiccup: None }
    }

    pub fn image(&self) -> &[u8] {
        self.cells.image()
    }

    pub fn image_mut(&mut self) -> &mut [u8] {
        self.cells.image_mut()
    }

    /// Makes one cell fail.
    pub fn break_cell(&mut self, cell: usize, fault: CellFault) {
        self.faults.push((Some(cell), fault));
    }

    /// Makes every cell fail.
    pub fn break_all(&mut self, fault: CellFault) {
        self.faults.push((None, fault));
    }

    pub fn repair(&mut self) {
        self.faults.clear();
    }

    /// Cuts the power when so many more bytes have been written: from then on nothing is written or read.
    pub fn cut_after(&mut self, bytes: usize) {
        self.budget = Some(bytes);
    }

    /// The power is back.
    pub fn power_back(&mut self) {
        self.budget = None;
        self.cut = false;
    }

    /// The call after `calls` more ones goes wrong, and only that.
    pub fn hiccup_after(&mut self, calls: usize, hiccup: Hiccup) {
        self.hiccup = Some((calls, hiccup));
    }

    /// `true` if a hiccup is still to come.
    pub fn hiccup_is_ahead(&self) -> bool {
        self.hiccup.is_some()
    }

    /// Counts a call; gives the hiccup if it comes now.
    fn call(&mut self) -> Option<Hiccup> {
        let (calls, hiccup) = self.hiccup.take()?;
        if calls == 0 {
            return Some(hiccup);
        }
        self.hiccup = Some((calls - 1, hiccup));
        None
    }

    /// Bytes written so far.
    pub fn written(&self) -> usize {
        self.written
    }

    fn faults_at(&self, cell: usize) -> impl Iterator<Item = CellFault> {
        self.faults.iter().filter(move |(at, _)| at.is_none_or(|at| at == cell)).map(|(_, fault)| *fault)
    }
}

impl ReadStorage for Memory {
    type Error = Refused;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Refused> {
        if self.cut || self.call().is_some() {
            return Err(Refused);
        }
        for (cell, byte) in (offset as usize..).zip(bytes) {
            *byte = *self.cells.image().get(cell).ok_or(Refused)?;
            for fault in self.faults_at(cell) {
                match fault {
                    CellFault::Read => return Err(Refused),
                    CellFault::Stuck(stuck) => *byte = stuck,
                    CellFault::Write => {}
                }
            }
        }
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.cells.capacity()
    }
}

impl Storage for Memory {
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Refused> {
        let hiccup = self.call();
        if hiccup == Some(Hiccup::NotDone) {
            return Err(Refused);
        }
        for (cell, byte) in (offset as usize..).zip(bytes) {
            if self.cut || self.budget == Some(0) {
                self.cut = true;
                return Err(Refused);
            }
            if self.faults_at(cell).any(|fault| fault == CellFault::Write) {
                return Err(Refused);
            }
            *self.cells.image_mut().get_mut(cell).ok_or(Refused)? = *byte;
            self.written += 1;
            if let Some(budget) = &mut self.budget {
                *budget -= 1;
            }
        }
        if hiccup.is_some() { Err(Refused) } else { Ok(()) }
    }
}
