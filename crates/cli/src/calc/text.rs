//! The text of `calc`, for people with a PLC monitor in front of them.

use std::fmt;

use super::view::{CalcView, ProposalView, StepView, ValueView};

impl CalcView {
    /// What stands below the words.
    fn legend(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let first_bytes = |pick: fn(&StepView) -> Option<&String>| {
            let bytes: Vec<&str> =
                self.sequence.iter().filter_map(pick).filter_map(|word| word.get(..2)).collect();
            bytes.join(", ")
        };
        let good = first_bytes(|step| step.input.as_ref());
        let with_error = first_bytes(|step| step.in_with_error.as_ref());
        write!(
            f,
            "\
position   IN is 00xxxxxx, in normal mode; 20xxxxxx if an error is pending
error bit  IN begins with {with_error}, A8 instead of {good},
           or the reply to 88000000 does not end in 0000

With the error bit: write the end line of the service, then do service 08 again.
`encoring decode --direction in WORD` explains its reply. An error from before
shows there once; the next service 08 then answers 88000000.
"
        )
    }
}

/// Of which models the values are, and the values.
pub(super) fn head<'a>(
    f: &mut fmt::Formatter<'_>,
    models: &[&str],
    native: Option<u32>,
    values: impl Iterator<Item = &'a ValueView>,
) -> fmt::Result {
    let models = models.join(", ");
    match native {
        Some(native) => writeln!(f, "{models}, {native} steps per turn on the rating plate\n")?,
        None => writeln!(f, "{models}\n")?,
    }
    writeln!(f, "service  value                         decimal      hex")?;
    ["S", "N", "D"].into_iter().zip(values).try_for_each(|(letter, of)| value(f, letter, of))?;
    writeln!(f)
}

fn value(f: &mut fmt::Formatter<'_>, letter: &str, value: &ValueView) -> fmt::Result {
    let Some(service) = value.service else { return Ok(()) };
    let name = format!("{letter}, {}", service.name());
    writeln!(f, "{:02X}       {name:<28} {:>8}  {}h", service.number(), value.value, value.hex)
}

/// What each number of turns gains and loses; the one that is taken has a mark.
fn proposals(f: &mut fmt::Formatter<'_>, proposals: &[ProposalView]) -> fmt::Result {
    writeln!(f, "\n  turns        range mm    reserve mm  step mm      zero")?;
    for proposal in proposals {
        let [turns, range, reserve, step, zero] = &proposal.cells;
        let (mark, purpose) = (if proposal.taken { '*' } else { ' ' }, proposal.purpose);
        writeln!(f, "{mark} {turns:<11}  {range:<10}  {reserve:<10}  {step:<11}  {zero:<11}  {purpose}")?;
    }
    f.write_str(
        "\
travel   the travel alone: its end is next to the wrap
reserve  the fewest whole turns with the reserve
safe     the fewest turns with the reserve that keep the zero
*        what the values above are of; others: --turns in place of --travel-mm
",
    )
}

fn step(f: &mut fmt::Formatter<'_>, step: &StepView) -> fmt::Result {
    let label = match step.phase {
        "prepare" => format!("{:02X}  {}", step.service, step.service_name),
        _ => String::new(),
    };
    let StepView { out, out_high, out_low, .. } = step;
    write!(f, "{label:<29}  {out}   {out_high} {out_low}    ")?;
    match (&step.input, &step.in_high, &step.in_low) {
        (Some(word), Some(high), Some(low)) => writeln!(f, "{word}   {high} {low}"),
        _ => writeln!(f, "position"),
    }
}

impl fmt::Display for CalcView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        head(f, &self.models, self.native, self.values())?;
        self.notes.iter().try_for_each(|note| note.fmt(f))?;
        if let Some(axis) = &self.axis {
            proposals(f, &axis.proposals)?;
        }
        if self.sequence.is_empty() {
            return Ok(());
        }
        writeln!(f, "\nWrite OUT line by line, wait for IN, and one PLC cycle before the next line.\n")?;
        writeln!(f, "{:<29}  OUT        high low     wait for IN  high low", "service")?;
        self.sequence.iter().try_for_each(|of| step(f, of))?;
        writeln!(f)?;
        self.legend(f)
    }
}
