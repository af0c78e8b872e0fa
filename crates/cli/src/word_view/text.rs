//! The text of `decode`, for people.

use std::fmt;

use encoring_words::model::Series;
use encoring_words::word::FIELDS;

use super::{Bits, DataView, InView, OutView, WordView};

/// The widest label: three models.
const LABEL: usize = 24;

fn lines(f: &mut fmt::Formatter<'_>, label: &str, lines: &[String]) -> fmt::Result {
    for (at, line) in lines.iter().enumerate() {
        writeln!(f, "  {:<LABEL$}  {line}", if at == 0 { label } else { "" })?;
    }
    Ok(())
}

/// The lines of each model, once for models that agree.
fn models<'a>(f: &mut fmt::Formatter<'_>, models: impl Iterator<Item = &'a DataView>) -> fmt::Result {
    let mut groups: Vec<(String, &[String])> = Vec::new();
    for view in models {
        match groups.iter_mut().find(|(_, text)| *text == view.text.as_slice()) {
            Some((names, _)) => {
                names.push_str(", ");
                names.push_str(view.model);
            }
            None => groups.push((view.model.to_owned(), &view.text)),
        }
    }
    groups.iter().try_for_each(|(names, text)| lines(f, names, text))
}

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values = [
            self.service_bit.to_string(),
            self.read_write_bit.to_string(),
            self.error_bit.to_string(),
            self.reserve.to_string(),
            format!("{:02X}", self.service),
            format!("{}h", self.data_hex),
        ];
        for ((field, value), note) in FIELDS.iter().zip(values).zip(&self.notes) {
            let bits = match (field.high, field.low) {
                (high, low) if high == low => format!("2^{high}"),
                (high, low) => format!("2^{high}..2^{low}"),
            };
            let line = format!("  {bits:<11} {:<14}  {value:<7}  {note}", field.name);
            writeln!(f, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

impl fmt::Display for OutView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "OUT, master to encoder: {}", self.meaning)?;
        self.bits.fmt(f)?;
        self.remarks.iter().try_for_each(|remark| writeln!(f, "  {remark}"))?;
        models(f, self.models.iter().map(|model| &model.data))
    }
}

impl fmt::Display for InView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "IN, encoder to master: {}", self.meaning)?;
        self.bits.fmt(f)?;
        self.remarks.iter().try_for_each(|remark| writeln!(f, "  {remark}"))?;
        if let Some(position) = &self.position {
            lines(f, "position", &[format!("{} ({:X}h)", position.value, position.value)])?;
            if let Some(value) = position.from_gray {
                let models = Series(&position.gray_models, "or");
                let from_gray = format!("{value} ({value:X}h), if a {models} is programmed to Gray");
                lines(f, "position from Gray", &[from_gray])?;
            }
        }
        if let Some(status) = &self.status {
            let named = if status.bits.is_empty() { "no error" } else { "" };
            lines(f, "error status", &[format!("{}  {named}", status.hex).trim_end().to_owned()])?;
            for bit in &status.bits {
                let text = [bit.meaning.to_owned(), format!("remedy: {}", bit.remedy)];
                lines(f, &format!("  2^{}", bit.bit), &text)?;
            }
        }
        models(f, self.models.iter().map(|model| &model.data))
    }
}

impl fmt::Display for WordView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}  (high word {}, low word {})", self.word, self.high, self.low)?;
        if let Some(out) = &self.out {
            write!(f, "\n{out}")?;
        }
        if let Some(input) = &self.input {
            write!(f, "\n{input}")?;
        }
        Ok(())
    }
}
