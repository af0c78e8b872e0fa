//! What to change in an address when what comes back shows that something in it is wrong.

use encoring_bus::misread::Misread;
use encoring_words::Duration;

use crate::address::{Address, Layout, TIMEOUT_MS, Way};
use crate::place::{RegisterPlace, WordOrder};

/// What cures words with their halves exchanged. Words that are read from one register beside look the same.
pub(super) fn halves(address: &Address) -> String {
    let order = other(address.order_in);
    let Layout::Plain { input, .. } = address.layout else { return format!("order={order} in the address") };
    let beside = [input.first.checked_sub(1), input.first.checked_add(1)]
        .map(|first| first.map(|first| format!("in={}", RegisterPlace { first, ..input })));
    let beside: Vec<_> = beside.into_iter().flatten().collect();
    format!(
        "order={order} in the address, or {} if the registers are off by one; `encoring probe` tells which",
        beside.join(" or ")
    )
}

/// What cures words that are written with their halves exchanged.
pub(super) fn written_halves(address: &Address) -> String {
    let order = other(address.order_out);
    format!("order_out={order} in the address; `encoring probe` shows the registers, and never writes")
}

/// What cures words that are turned round, where this does for their halves.
pub(super) fn turned(way: Misread, halves: String) -> String {
    match way {
        Misread::Halves => halves,
        Misread::Bytes => {
            "nothing in the address: set the byte order in the gateway; `encoring probe` shows the registers"
                .to_owned()
        }
        Misread::HalvesAndBytes => format!("the byte order, set in the gateway, and {halves}"),
    }
}

const fn other(order: WordOrder) -> WordOrder {
    match order {
        WordOrder::HighFirst => WordOrder::LowFirst,
        WordOrder::LowFirst => WordOrder::HighFirst,
    }
}

/// What gives a gateway the time it needs, whose answers come after this.
pub(super) fn slow(after: Duration, timeout: Duration) -> String {
    let millis = |span: Duration| span.as_nanos() / 1_000_000;
    format!(
        "its answers come after {} ms, and several requests of one call have no room in timeout_ms={}: with timeout_ms={} \
         in the address they have",
        millis(after),
        millis(timeout),
        enough(after, timeout)
    )
}

/// A time-out in milliseconds for the four requests of the longest call, and at least twice what was too short.
fn enough(after: Duration, timeout: Duration) -> u64 {
    let needed = after.as_nanos().saturating_mul(4).max(timeout.as_nanos().saturating_mul(2)) / 1_000_000;
    (needed.div_ceil(100) * 100).min(u64::from(*TIMEOUT_MS.end()))
}

/// What may be wrong where a gateway was there and has answered nothing.
pub(super) fn silence(address: &Address) -> String {
    let Address { way, unit, .. } = address;
    let other = match way {
        Way::Tcp { .. } => format!("a gateway that passes Modbus RTU on (modbus-rtu-tcp://{way})"),
        Way::RtuTcp { .. } => format!("a gateway of Modbus TCP (modbus-tcp://{way})"),
        Way::Rtu { .. } => {
            "other settings of the line (baud=, parity=, stop=), or its two wires exchanged".to_owned()
        }
    };
    format!(
        "it is there and has answered nothing so far. That may be another unit number (unit={unit} was asked), or \
         {other}; `encoring probe` on such an address tells whether it answers"
    )
}
