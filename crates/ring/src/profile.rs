//! The constants of the wire. Each is stated in public vendor documents; none is assumed so far.

use encoring_words::Duration;

/// A bit at 500 kbit/s [R7].
pub const BIT_500K: Duration = Duration::from_micros(2);

/// A bit at 2 Mbit/s, the fast variant of the bus.
pub const BIT_2M: Duration = Duration::from_nanos(500);

/// Line bits for each byte of the frame: the "300 kBaud net" of 500 gross [R7].
pub const TELEGRAM_BITS: u64 = 13;

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
