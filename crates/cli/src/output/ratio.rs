//! Ratios for people.

use encoring_host::scaling::{Ratio, Rounded, Rounding};

/// Decimal places that give about six digits.
fn places(ratio: Ratio) -> usize {
    let thousandth = Ratio::new(1, 1_000).is_some_and(|thousandth| ratio < thousandth);
    if thousandth {
        9
    } else if ratio >= Ratio::from(1_000) {
        3
    } else {
        6
    }
}

/// A number for an option of the command line, cut to one side.
pub(crate) fn cut(ratio: Ratio, rounding: Rounding) -> Rounded {
    ratio.rounded(places(ratio), rounding)
}

/// A number for people; exact if it can be shown with the decimals that a number may be typed with.
pub(crate) fn show(ratio: Ratio) -> String {
    let exact = ratio.rounded(15, Rounding::Nearest);
    if exact.is_exact() {
        return exact.to_string();
    }
    format!("about {}", cut(ratio, Rounding::Nearest))
}
