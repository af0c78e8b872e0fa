//! A recording as a file, and its truth as JSON.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::corpus::Case;
use crate::plan::Plan;
use crate::scene::Column;

/// The recording as a table; header, then a line for each row.
pub(crate) fn table(case: &Case) -> String {
    let plan = &case.plan;
    let cell = if plan.column == Column::Decimal { "value" } else { "in" };
    let mut text = String::from("time_us");
    text.push_str(if plan.neighbour { ",position" } else { "" });
    text.push_str(if plan.out_logged { ",out," } else { "," });
    text.push_str(cell);
    text.push('\n');
    for row in &case.rows {
        let _ = write!(text, "{}", row.time_us);
        if plan.neighbour {
            let _ = write!(text, ",{}", row.position);
        }
        if let Some(out) = row.out {
            let _ = write!(text, ",{out:08X}");
        }
        let _ = match plan.column {
            Column::Decimal => writeln!(text, ",{}", row.word),
            _ => writeln!(text, ",{:08X}", row.word),
        };
    }
    text
}

/// What is told beside the recording, and what happened in it.
pub(crate) fn truth(case: &Case) -> Value {
    let names =
        |causes: &[crate::cause::Cause]| -> Vec<&str> { causes.iter().map(|cause| cause.name()).collect() };
    let jumps: Vec<Value> = case
        .jumps
        .iter()
        .map(|jump| {
            json!({
                "cause": jump.cause.name(),
                "line": Case::line(jump.from),
                "to_line": Case::line(jump.to),
                "decidable": jump.rivals.is_empty(),
                "rivals": names(&jump.rivals),
                "rivals_within_the_data_sheet": names(&jump.rivals_of_sheet),
            })
        })
        .collect();
    let known: Vec<Value> =
        case.known.iter().map(|(us, value)| json!({"time_us": us, "steps": value})).collect();
    let Plan { device, scaling, period, column, .. } = &case.plan;
    json!({
        "seed": case.seed,
        "encoder": {"model": device.model, "native": device.native, "length": scaling.length,
            "numerator": scaling.numerator, "denominator": scaling.denominator, "falling": scaling.falling},
        "told": {"model": case.plan.model_told, "parameters": case.plan.scaling_told, "known": known},
        "period_ms": period * 1_000.0,
        "column": format!("{column:?}"),
        "jumps": jumps,
    })
}
