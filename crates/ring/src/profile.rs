//! The constants of the wire.
//!
//! The first part is stated in public vendor documents. The second is assumed, because the bits of the line are not
//! public: each of its constants names its row in `docs/assumptions.md`, which says why and what would refute it. No
//! other file of this crate holds an assumption.

#![expect(
    clippy::unusual_byte_groupings,
    reason = "telegrams are written in their parts: start, header, data, stop"
)]

use encoring_words::Duration;

/// A bit at 500 kbit/s [R7].
pub const BIT_500K: Duration = Duration::from_micros(2);

/// A bit at 2 Mbit/s, the fast variant of the bus.
pub const BIT_2M: Duration = Duration::from_nanos(500);

/// Line bits for each byte of the frame: the "300 kBaud net" of 500 gross [R7].
pub const TELEGRAM_BITS: u64 = 13;

/// Line bits of a status telegram.
pub const STATUS_BITS: u64 = 5;

/// Bytes of the frame beside the devices' own: loopback word, check word, end word.
pub const FRAME_BYTES: u64 = 6;

/// Bytes that one encoder adds to the frame in each direction [R3].
pub const ENCODER_BYTES: u64 = 4;

/// What the master's software adds to a cycle.
pub const MASTER_SOFTWARE: Duration = Duration::from_micros(200);

/// Delay of the cable, in nanoseconds a metre (16 us a kilometre).
pub const CABLE_NS_PER_M: u64 = 16;

/// Silence after which a device takes the line for dead: outputs 0, outgoing bus off.
pub const RESET_AFTER: Duration = Duration::from_millis(25);

/// Time without a valid data cycle after which the lamp BA goes off.
pub const BUS_ACTIVE_FOR: Duration = Duration::from_millis(640);

/// The most devices on one ring.
pub const DEVICES_MAX: usize = 512;

/// The most bytes of user data on one ring: 4096 I/O points.
pub const DATA_BYTES_MAX: usize = 512;

/// The most bytes of one device: 32 words.
pub const DEVICE_BYTES_MAX: usize = 64;

/// The line between telegrams [A1].
pub const IDLE: bool = true;

/// A data telegram without its byte: start 0, SL, CR, FL = 1, eight data bits with the highest first, stop 1; here with
/// SL and CR 0 [A2].
pub const DATA_TELEGRAM: u16 = 0b0_001_0000_0000_1;

/// SL of a data telegram: 1 in an ID cycle [A2].
pub const DATA_SL: u16 = 0b0_100_0000_0000_0;

/// CR of a data telegram: 1 while check words pass [A2].
pub const DATA_CR: u16 = 0b0_010_0000_0000_0;

/// A status telegram: the header with SL, CR and FL 0, and a stop bit [A3].
pub const STATUS_TELEGRAM: u16 = 0b0_000_1;

/// Whole bits by which a device delays the line; time stamps use the stated 1.5 [A4].
pub const DEVICE_DELAY_BITS: u32 = 2;

/// Sound status telegrams in a row that must come before a frame [A5].
pub const STATUS_BEFORE_FRAME: u8 = 2;

/// Telegrams in a row with a wrong header or stop bit after which a frame's place on the line is lost: one more than a
/// burst of 16 bits can hit [A5].
pub const FRAME_LOST_AFTER: u8 = 4;

/// The loopback word [A6].
pub const LOOPBACK: u16 = 0xE3A5;

/// Telegrams of the check phase: check word and end word [A7].
pub const CHECK_TELEGRAMS: u8 = 4;

/// What the check word starts from; the polynomial x^16+x^12+x^5+1 is stated [A8].
pub const CRC_PRESET: u16 = 0xFFFF;

/// The end word of a cycle that was good so far [A9].
pub const END_GOOD: u16 = 0;

/// Bits that every end word of a bad segment has: with both ends of the word set, no error of two bits and no burst of
/// 16 line bits makes one out of [`END_GOOD`] [A9].
pub const END_BAD: u16 = 0x8001;

/// The low byte of an end word whose high byte had gone when the segment turned bad [A9].
pub const END_LATE: u8 = 0xFF;

/// The end word of a bad segment in front of a device that was not told its position yet [A9].
pub const END_UNTOLD: u16 = 0x80FF;

/// Where position stands in control word and end word: bits 9..1 [A9, A10].
pub const POSITION_SHIFT: u32 = 1;

/// The width of a position in both: 512 devices [A9, A10].
pub const POSITION_MASK: u16 = 0x1FF;

/// Control word of an ID cycle: the outgoing bus is to be on [A10].
pub const CONTROL_OUTGOING: u16 = 1 << 0;

/// Control word of an ID cycle: the device is to reset itself [A10].
pub const CONTROL_RESET: u16 = 1 << 15;

/// Message of an identification word: the device asks to be configured anew [A11].
pub const MESSAGE_RECONFIGURE: u16 = 1 << 15;

/// Message of an identification word: a segment or an end word was bad [A11].
pub const MESSAGE_CRC: u16 = 1 << 14;

/// Message of an identification word: the module behind the chip has a fault [A11].
pub const MESSAGE_MODULE: u16 = 1 << 13;

/// Faulty cycles in a row that stop the bus [A12].
pub const STOP_AFTER: u8 = 5;

/// Telegrams for which the line home must stand still before the master takes the ring for open and sends no check
/// phase: more than a burst of 16 bits can feign [A15].
pub const STILL_TELEGRAMS: usize = 2;

/// How long the master keeps silent to reset the ring: longer than [`RESET_AFTER`] [A13].
pub const SILENCE: Duration = Duration::from_millis(26);

/// Tries of an ID cycle that nobody answers before the place counts as broken [A14].
pub const ID_TRIES: u8 = 3;

/// Faulty data cycles in a million from which the quality bit is set.
pub const QUALITY_FAULTY: u32 = 20;

/// The cycles that [`QUALITY_FAULTY`] is counted over.
pub const QUALITY_CYCLES: u32 = 1_000_000;
