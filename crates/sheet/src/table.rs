//! A table of a data sheet.

use encoring_texts::Said;

/// Rows under named columns.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetTable {
    /// The names of the columns.
    pub columns: &'static [&'static str],
    /// As many cells in each as there are columns.
    pub rows: Vec<Vec<SheetCell>>,
}

/// What stands in a row under a column.
#[derive(Clone, Debug, PartialEq)]
pub enum SheetCell {
    /// What a manual says, or we say of it.
    Said(Said),
    /// What is the same in every language: words, numbers of services, bits and chapters, names.
    Same(String),
    /// A number.
    Number(f64),
    /// The manual does not say it.
    NotStated,
    /// There is nothing to say.
    Empty,
}

impl From<&str> for SheetCell {
    fn from(text: &str) -> Self {
        Self::from(text.to_owned())
    }
}

impl From<String> for SheetCell {
    fn from(text: String) -> Self {
        if text.is_empty() { Self::Same(text) } else { Self::Said(Said::stated(text)) }
    }
}

impl From<u32> for SheetCell {
    fn from(number: u32) -> Self {
        Self::Number(number.into())
    }
}

impl From<f64> for SheetCell {
    fn from(number: f64) -> Self {
        Self::Number(number)
    }
}

impl SheetCell {
    /// What is the same in every language.
    pub(crate) fn same(text: impl Into<String>) -> Self {
        Self::Same(text.into())
    }

    /// What a manual may leave out.
    pub(crate) fn stated<T: Into<Self>>(said: Option<T>) -> Self {
        said.map_or(Self::NotStated, Into::into)
    }

    /// What need not be.
    pub(crate) fn any<T: Into<Self>>(said: Option<T>) -> Self {
        said.map_or(Self::Empty, Into::into)
    }
}

impl SheetTable {
    pub(crate) const fn new(columns: &'static [&'static str], rows: Vec<Vec<SheetCell>>) -> Self {
        Self { columns, rows }
    }

    /// Two columns.
    pub(crate) fn facts(rows: Vec<(&str, SheetCell)>) -> Self {
        let rows = rows.into_iter().map(|(quantity, value)| vec![quantity.into(), value]).collect();
        Self::new(&["quantity", "value"], rows)
    }
}
