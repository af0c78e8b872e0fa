//! What a person says about a table: which column is which, how far rows are apart, what bare numbers are.

use std::str::FromStr;

use encoring_words::number::Bare;

use super::names::Meaning;

/// What is said about a table. The default is to say nothing: then the header must.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TableLayout {
    /// Which column is which; `None` to go by the header.
    pub columns: Option<Columns>,
    /// Nanoseconds from row to row of a table without times; `None` for a millisecond, as something assumed.
    pub period_ns: Option<u64>,
    /// What words without sign and base mark are.
    pub bare: Bare,
    /// The header of a column that says what is wrong with a row: where its cell is not empty,
    /// [`Row::cycle`](crate::Row::cycle) is bad. `None` if there is no such column.
    pub faults: Option<String>,
}

/// Which column of a table is which: `time_s=Time [s],in=DB10.ENC`. A name that holds `,` or `=` stands in double
/// quotes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Columns(pub(super) Vec<(Meaning, String)>);

impl FromStr for Columns {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut columns: Vec<(Meaning, String)> = Vec::new();
        for pair in pairs(text)? {
            let (key, name) = pair;
            let key = key.trim();
            let names = || Meaning::all().map(|(name, _)| name).collect::<Vec<_>>().join(", ");
            let Some(name) = name else {
                return Err(format!(
                    "{key:?} has no = and no column behind it; a name that holds a comma stands in quotes, \
                     as 'in=\"Enc, IN\"'"
                ));
            };
            let meaning =
                Meaning::named(key).ok_or_else(|| format!("{key:?} is no column; they are {}", names()))?;
            if name.trim().is_empty() {
                return Err(format!("{key}= has no name of a column behind it"));
            }
            if columns.iter().any(|(known, _)| *known == meaning || known.is_time() && meaning.is_time()) {
                return Err(format!("{key} is said twice"));
            }
            let name = name.trim();
            if let Some((other, _)) = columns.iter().find(|(_, known)| known.eq_ignore_ascii_case(name)) {
                return Err(format!(
                    "{name:?} is said to be both {} and {key}; it is one of them",
                    other.name()
                ));
            }
            columns.push((meaning, name.to_owned()));
        }
        Ok(Self(columns))
    }
}

/// The text before and behind the first `=` of each part between commas; quotes are taken off.
fn pairs(text: &str) -> Result<Vec<(String, Option<String>)>, String> {
    let mut pairs = vec![(String::new(), None)];
    let mut quoted = false;
    for letter in text.chars() {
        let Some((key, name)) = pairs.last_mut() else { break };
        match letter {
            '"' => quoted = !quoted,
            ',' if !quoted => pairs.push((String::new(), None)),
            // In a pair that is quoted as a whole the key is quoted too.
            '=' if name.is_none() => *name = Some(String::new()),
            _ => name.as_mut().unwrap_or(key).push(letter),
        }
    }
    if quoted { Err("a double quote is not closed".to_owned()) } else { Ok(pairs) }
}

/// A name as it is typed into `--columns`, where quotes within a name are left out.
pub(super) fn typed(name: &str) -> String {
    let name = name.replace('"', "");
    if name.contains([',', '=']) { format!("\"{name}\"") } else { name }
}
