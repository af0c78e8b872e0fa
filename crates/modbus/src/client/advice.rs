//! What to change in an address when what comes back shows that something in it is wrong.

use crate::address::{Address, Layout, Way};
use crate::place::{RegisterPlace, WordOrder};

/// What cures words with their halves exchanged. Words that are read from one register beside look the same.
pub(super) fn halves(address: &Address) -> String {
    let order = match address.order_in {
        WordOrder::HighFirst => WordOrder::LowFirst,
        WordOrder::LowFirst => WordOrder::HighFirst,
    };
    let Layout::Plain { input, .. } = address.layout else { return format!("order={order} in the address") };
    let beside = [input.first.checked_sub(1), input.first.checked_add(1)]
        .map(|first| first.map(|first| format!("in={}", RegisterPlace { first, ..input })));
    let beside: Vec<_> = beside.into_iter().flatten().collect();
    format!(
        "order={order} in the address, or {} if the registers are off by one; `encoring probe` tells which",
        beside.join(" or ")
    )
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
