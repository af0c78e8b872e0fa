//! Values within their limits.

use std::fmt::Display;

use encoring_files::toml_text::{Outside, Wrong};

/// A value of this key.
pub(super) fn within<T: Copy + PartialOrd + Display>(
    key: &str,
    value: T,
    low: T,
    high: T,
) -> Result<T, Wrong> {
    if (&low..=&high).contains(&&value) {
        return Ok(value);
    }
    let [value, low, high] = [value, low, high].map(|number| number.to_string());
    Err(Wrong::outside(Outside { key: key.to_owned(), value, low, high }))
}
