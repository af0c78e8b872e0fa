//! The EEPROM: one record for each value, two slots for each record [R97, R144].
//!
//! A slot is `marker, write count (4), value, check (4)`. A write goes to the slot that is not the newest: its
//! marker is invalidated first and set last, so a cut after any byte leaves the old or the new value. A slot whose
//! check fails leaves the older one in force. Nothing is written that is there already.

use crc::{CRC_32_ISO_HDLC, Crc};
use embedded_storage::Storage;
use encoring_words::model::{Effect, Model, SensorKind};
use encoring_words::parameter::PARAMETERS;
use encoring_words::{Parameter, ParameterSet};

use crate::position::Offset;
use crate::unit::Unit;

/// Bytes of memory that an encoder needs.
pub const EEPROM_BYTES: usize = 512;

/// A slot in force begins with this byte; any other, also a blank one's FFh, is none.
const IN_FORCE: u8 = 0xA5;
const INVALID: u8 = 0x00;

/// With a table of 1 KiB: bit by bit, it would be more than half of what a read service costs.
static CHECK: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Bytes of a slot beside its value.
const OVERHEAD: usize = 9;
const SET_BYTES: usize = 3 * PARAMETERS.len();
const LONGEST: usize = SET_BYTES;

/// Something that the memory keeps on its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Record {
    /// The programmed value of one parameter.
    Programmed(Parameter),
    /// The whole accepted set.
    Accepted,
    /// The preset offset.
    Offset,
    /// The last sample before power-off.
    TurnCount,
}

/// A value did not reach the memory, or did not read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotStored;

/// A record cannot be read: both slots fail their check, or the memory does not answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lost;

impl Record {
    /// First byte and the distance of its two slots. No slot crosses a page of 16 bytes unless it is longer.
    const fn place(self) -> (u32, u32) {
        match self {
            Self::Programmed(parameter) => (parameter as u32 * 32, 16),
            Self::Accepted => (224, 32),
            Self::Offset => (288, 16),
            Self::TurnCount => (320, 32),
        }
    }

    /// Every record of a model: there is an accepted set only where values wait for the data check, and only a shaft
    /// has turns to count.
    pub fn of(model: Model) -> impl Iterator<Item = Self> {
        let values =
            PARAMETERS.into_iter().filter(move |p| p.service().known_to(model)).map(Self::Programmed);
        let accepted = (model.effect() == Effect::AtDataCheck).then_some(Self::Accepted);
        let turns = (model.sensor_kind() == SensorKind::Rotary).then_some(Self::TurnCount);
        values.chain([Self::Offset]).chain(accepted).chain(turns)
    }
}

/// A value as the memory keeps it.
pub(crate) trait Stored<const N: usize>: Sized + PartialEq {
    fn to_bytes(&self) -> [u8; N];
    /// `None` if no encoder would have stored these bytes.
    fn from_bytes(bytes: [u8; N]) -> Option<Self>;
}

/// 24 bits of a service's data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Data(pub(crate) u32);

impl Stored<3> for Data {
    fn to_bytes(&self) -> [u8; 3] {
        let [b0, b1, b2, _] = self.0.to_le_bytes();
        [b0, b1, b2]
    }

    fn from_bytes([b0, b1, b2]: [u8; 3]) -> Option<Self> {
        Some(Self(u32::from_le_bytes([b0, b1, b2, 0])))
    }
}

impl Stored<SET_BYTES> for ParameterSet {
    fn to_bytes(&self) -> [u8; SET_BYTES] {
        let mut bytes = [0; SET_BYTES];
        for (place, parameter) in bytes.as_chunks_mut().0.iter_mut().zip(PARAMETERS) {
            *place = Data(self.value(parameter)).to_bytes();
        }
        bytes
    }

    fn from_bytes(bytes: [u8; SET_BYTES]) -> Option<Self> {
        let mut set = Self::default();
        for (place, parameter) in bytes.as_chunks().0.iter().zip(PARAMETERS) {
            set.set(parameter, Data::from_bytes(*place)?.0);
        }
        Some(set)
    }
}

impl Stored<5> for Offset {
    fn to_bytes(&self) -> [u8; 5] {
        let [b0, b1, b2, b3] = self.num.to_le_bytes();
        [b0, b1, b2, b3, self.denominator]
    }

    fn from_bytes([b0, b1, b2, b3, denominator]: [u8; 5]) -> Option<Self> {
        let num = u32::from_le_bytes([b0, b1, b2, b3]);
        (denominator != 0).then_some(Self { num, denominator })
    }
}

/// The last sample before power-off; `None` before the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TurnCount(pub(crate) Option<i64>);

impl Stored<9> for TurnCount {
    fn to_bytes(&self) -> [u8; 9] {
        let [b0, b1, b2, b3, b4, b5, b6, b7] = self.0.unwrap_or(0).to_le_bytes();
        [u8::from(self.0.is_some()), b0, b1, b2, b3, b4, b5, b6, b7]
    }

    fn from_bytes([known, b0, b1, b2, b3, b4, b5, b6, b7]: [u8; 9]) -> Option<Self> {
        Some(Self((known == 1).then(|| i64::from_le_bytes([b0, b1, b2, b3, b4, b5, b6, b7]))))
    }
}

struct Slot<const N: usize> {
    count: u32,
    value: [u8; N],
}

/// The slots of a record as far as they are in force.
struct Slots<const N: usize> {
    slots: [Option<Slot<N>>; 2],
    /// Both could be read, in force or not.
    readable: bool,
}

impl<const N: usize> Slots<N> {
    fn newest(&self) -> Option<(usize, &Slot<N>)> {
        match &self.slots {
            [Some(first), Some(second)] => {
                // Counts are compared around their end, so that the record outlives 2^32 writes.
                if second.count.wrapping_sub(first.count) < 1 << 31 {
                    Some((1, second))
                } else {
                    Some((0, first))
                }
            }
            [Some(first), None] => Some((0, first)),
            [None, Some(second)] => Some((1, second)),
            [None, None] => None,
        }
    }
}

fn check<const N: usize>(record: Record, count: [u8; 4], value: &[u8; N]) -> [u8; 4] {
    let mut digest = CHECK.digest();
    // The place is part of the check: a record copied elsewhere is none.
    digest.update(&record.place().0.to_le_bytes());
    digest.update(&count);
    digest.update(value);
    digest.finalize().to_le_bytes()
}

fn slots<const N: usize>(memory: &mut impl Storage, record: Record) -> Slots<N> {
    let (base, stride) = record.place();
    let slots = [base, base + stride].map(|at| slot(memory, record, at));
    let readable = slots.iter().all(Result::is_ok);
    Slots { slots: slots.map(|slot| slot.unwrap_or(None)), readable }
}

/// One slot; `None` if it is not in force.
fn slot<const N: usize, M: Storage>(
    memory: &mut M,
    record: Record,
    mut at: u32,
) -> Result<Option<Slot<N>>, M::Error> {
    let (mut marker, mut count, mut value, mut sum) = ([0; 1], [0; 4], [0; N], [0; 4]);
    for bytes in [&mut marker[..], &mut count, &mut value, &mut sum] {
        memory.read(at, bytes)?;
        at += bytes.len() as u32;
    }
    let in_force = marker == [IN_FORCE] && sum == check(record, count, &value);
    Ok(in_force.then(|| Slot { count: u32::from_le_bytes(count), value }))
}

/// Reads a record from its newest slot in force.
pub(crate) fn read<const N: usize, T: Stored<N>>(
    memory: &mut impl Storage,
    record: Record,
) -> Result<T, Lost> {
    let slots = slots(memory, record);
    let (_, slot) = slots.newest().ok_or(Lost)?;
    T::from_bytes(slot.value).ok_or(Lost)
}

/// Writes a record, unless that value is there already, and reads it back.
pub(crate) fn write<const N: usize, T: Stored<N>>(
    memory: &mut impl Storage,
    record: Record,
    value: &T,
) -> Result<(), NotStored> {
    const { assert!(N <= LONGEST) }
    let slots = slots::<N>(memory, record);
    let bytes = value.to_bytes();
    let (target, count) = match slots.newest() {
        Some((_, slot)) if slot.value == bytes => return Ok(()),
        // What cannot be read now may be the newer copy: it is left alone.
        _ if !slots.readable => return Err(NotStored),
        Some((newest, slot)) => (1 - newest as u32, slot.count.wrapping_add(1)),
        None => (0, 1),
    };
    let (base, stride) = record.place();
    let at = base + target * stride;
    let count = count.to_le_bytes();
    let sum = check(record, count, &bytes);
    if put(memory, at, count, &bytes, sum) && reads_back(memory, at, count, &bytes, sum) {
        return Ok(());
    }
    // The device goes on with the old value, so the next power-up must find the old one too.
    let _ = memory.write(at, &[INVALID]);
    Err(NotStored)
}

/// Writes a slot, its marker last; `false` as soon as the memory refuses.
fn put(memory: &mut impl Storage, at: u32, count: [u8; 4], value: &[u8], sum: [u8; 4]) -> bool {
    let after_value = at + 5 + value.len() as u32;
    memory.write(at, &[INVALID]).is_ok()
        && memory.write(at + 1, &count).is_ok()
        && memory.write(at + 5, value).is_ok()
        && memory.write(after_value, &sum).is_ok()
        && memory.write(at, &[IN_FORCE]).is_ok()
}

fn reads_back(memory: &mut impl Storage, at: u32, count: [u8; 4], value: &[u8], sum: [u8; 4]) -> bool {
    debug_assert!(value.len() <= LONGEST, "a record of {} bytes, the longest has {LONGEST}", value.len());
    let mut image = [0_u8; OVERHEAD + LONGEST];
    let Some(slot) = image.get_mut(..OVERHEAD + value.len()) else { return false };
    let expected = [IN_FORCE].into_iter().chain(count).chain(value.iter().copied()).chain(sum);
    memory.read(at, slot).is_ok() && slot.iter().copied().eq(expected)
}

/// How often a record has been written; 0 for one that is lost.
#[must_use]
pub fn write_count(memory: &mut impl Storage, record: Record) -> u32 {
    fn count<const N: usize>(memory: &mut impl Storage, record: Record) -> u32 {
        slots::<N>(memory, record).newest().map_or(0, |(_, slot)| slot.count)
    }
    match record {
        Record::Programmed(_) => count::<3>(memory, record),
        Record::Accepted => count::<SET_BYTES>(memory, record),
        Record::Offset => count::<5>(memory, record),
        Record::TurnCount => count::<9>(memory, record),
    }
}

/// Prepares the memory of a new device: every record with its factory value.
///
/// # Errors
/// [`NotStored`] if the memory refuses.
pub fn format(unit: &Unit, memory: &mut impl Storage) -> Result<(), NotStored> {
    let factory = ParameterSet::factory(unit.model(), unit.sensor());
    for record in Record::of(unit.model()) {
        match record {
            Record::Programmed(parameter) => write(memory, record, &Data(factory.value(parameter)))?,
            Record::Accepted => write(memory, record, &factory)?,
            Record::Offset => write(memory, record, &Offset::NONE)?,
            Record::TurnCount => write(memory, record, &TurnCount(None))?,
        }
    }
    Ok(())
}
