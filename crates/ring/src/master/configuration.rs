//! What a ring should be: its devices, and where their bytes lie in the process image.

use core::ops::Range;

use crate::ident::Ident;
use crate::profile::{DATA_BYTES_MAX, DEVICES_MAX};

/// Why a ring cannot be configured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConfigurationError {
    /// More devices than a ring can have.
    #[error("{devices} devices on one ring; the limit is {DEVICES_MAX}")]
    Devices {
        /// How many.
        devices: usize,
    },
    /// More data than a ring can have.
    #[error("{bytes} bytes of data on one ring; the limit is {DATA_BYTES_MAX}")]
    Bytes {
        /// How many.
        bytes: usize,
    },
    /// A device whose length is reserved or less than a byte.
    #[error("length code {code:02X}h at position {position} is no number of whole bytes")]
    Length {
        /// Of the device.
        position: usize,
        /// Its length code.
        code: u8,
    },
}

/// The devices of a ring, and where their bytes lie.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Table {
    idents: [Ident; DEVICES_MAX],
    /// Where the bytes of a device begin; those of the next one begin where they end.
    offsets: [u16; DEVICES_MAX + 1],
    pub(super) devices: usize,
}

impl Table {
    pub(super) const EMPTY: Self =
        Self { idents: [Ident(0); DEVICES_MAX], offsets: [0; DEVICES_MAX + 1], devices: 0 };

    pub(super) fn of(idents: &[Ident]) -> Result<Self, ConfigurationError> {
        let mut table = Self::EMPTY;
        for ident in idents {
            table.push(*ident, idents.len())?;
        }
        Ok(table)
    }

    pub(super) fn push(&mut self, ident: Ident, devices: usize) -> Result<(), ConfigurationError> {
        let position = self.devices;
        let length = ident.bytes();
        let length = length.ok_or(ConfigurationError::Length { position, code: ident.length_code() })?;
        let bytes = self.bytes(position) + length;
        if bytes > DATA_BYTES_MAX {
            return Err(ConfigurationError::Bytes { bytes });
        }
        let (Some(place), Some(offset)) = (self.idents.get_mut(position), self.offsets.get_mut(position + 1))
        else {
            return Err(ConfigurationError::Devices { devices });
        };
        *place = ident.identity();
        *offset = bytes as u16;
        self.devices += 1;
        Ok(())
    }

    pub(super) fn ident(&self, position: usize) -> Option<Ident> {
        self.idents.get(..self.devices)?.get(position).copied()
    }

    /// The bytes of the first so many devices.
    pub(super) fn bytes(&self, devices: usize) -> usize {
        self.offsets.get(devices).copied().map_or(0, usize::from)
    }

    /// The bytes of each device, by position.
    pub(super) fn lengths(&self) -> impl Iterator<Item = usize> {
        let ends = self.offsets.get(1..=self.devices).unwrap_or_default();
        self.offsets.iter().zip(ends).map(|(begins, ends)| usize::from(ends.saturating_sub(*begins)))
    }

    pub(super) fn range(&self, position: usize) -> Range<usize> {
        self.bytes(position)..self.bytes(position + 1)
    }
}
