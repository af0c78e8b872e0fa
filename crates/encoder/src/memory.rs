//! An EEPROM in the memory of the computer.

use embedded_storage::{ReadStorage, Storage};

use crate::records::EEPROM_BYTES;

/// The bytes of an EEPROM that never fails.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ram([u8; EEPROM_BYTES]);

/// Bytes were asked for behind the last one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PastTheEnd;

impl Ram {
    /// As it comes from its maker: every byte FFh.
    #[must_use]
    pub const fn blank() -> Self {
        Self::from_image([0xFF; EEPROM_BYTES])
    }

    /// With these bytes.
    #[must_use]
    pub const fn from_image(image: [u8; EEPROM_BYTES]) -> Self {
        Self(image)
    }

    /// Its bytes.
    #[must_use]
    pub const fn image(&self) -> &[u8; EEPROM_BYTES] {
        &self.0
    }

    /// Its bytes, to be changed.
    #[must_use]
    pub const fn image_mut(&mut self) -> &mut [u8; EEPROM_BYTES] {
        &mut self.0
    }
}

impl ReadStorage for Ram {
    type Error = PastTheEnd;

    #[inline]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PastTheEnd> {
        let kept = self.0.get(offset as usize..).and_then(|rest| rest.get(..bytes.len()));
        bytes.copy_from_slice(kept.ok_or(PastTheEnd)?);
        Ok(())
    }

    fn capacity(&self) -> usize {
        EEPROM_BYTES
    }
}

impl Storage for Ram {
    #[inline]
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PastTheEnd> {
        let kept = self.0.get_mut(offset as usize..).and_then(|rest| rest.get_mut(..bytes.len()));
        kept.ok_or(PastTheEnd)?.copy_from_slice(bytes);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_written_is_read_and_nothing_lies_behind_the_end() {
        let mut memory = Ram::blank();
        let last = EEPROM_BYTES as u32 - 2;
        assert_eq!(memory.write(last, &[1, 2]), Ok(()));
        let mut bytes = [0; 3];
        assert_eq!(memory.read(last - 1, &mut bytes), Ok(()));
        assert_eq!(bytes, [0xFF, 1, 2]);
        assert_eq!(memory.read(last, &mut bytes), Err(PastTheEnd));
        assert_eq!(memory.write(last, &[3, 4, 5]), Err(PastTheEnd));
        assert_eq!(memory.write(u32::MAX, &[3]), Err(PastTheEnd));
        assert_eq!(memory.image()[last as usize..], [1, 2]);
    }
}
