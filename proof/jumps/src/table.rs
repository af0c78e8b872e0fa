//! The tables of what can be told at which period and speed, as Markdown.

use std::fmt::Write;

use crate::cause::{Cause, Trace};
use crate::decidable::rivals;
use crate::scene::{Column, Scene, of_rad, of_rpm};

/// From row to row, in units of 0.1 ms.
const PERIODS: [u32; 7] = [5, 10, 20, 100, 500, 1_000, 10_000];
/// Speeds that are tried, in revolutions a minute, up to the limit of the CE-65-M [R124].
const SPEEDS: [f64; 9] = [0.0, 3.0, 30.0, 100.0, 300.0, 1_000.0, 1_500.0, 3_000.0, 6_000.0];
/// Accelerations in rad/s^2: a usual axis, by assumption; the limit of the CE-65-M [R124].
const ACCELERATIONS: [f64; 2] = [100.0, 10_000.0];
/// Steps of a turn and positions, of the factory set.
const TURN: f64 = 4_096.0;
const POSITIONS: f64 = 16_777_216.0;
/// Rows that a stretch lasts, and rows of steady motion beside a jump.
const ROWS: f64 = 100.0;
/// A tenth of the positions.
const FAR: f64 = 1_677_722.0;

fn scene(period: u32, rpm: f64, rad_s2: f64) -> Scene {
    Scene {
        period: f64::from(period) / 10_000.0,
        jitter: 0.0,
        // [R9]
        refresh: 0.000_5,
        positions: POSITIONS,
        speed: of_rpm(rpm, TURN),
        top_speed: of_rpm(6_000.0, TURN),
        acceleration: of_rad(rad_s2, TURN),
        column: Column::Word,
        out_logged: false,
        parameters_told: true,
        no_preset_inputs: true,
        steady_rows: ROWS,
    }
}

/// What a row of the table tries at a place, and what is said behind the name of the cause.
type Tried = (&'static str, fn(Scene) -> (Scene, Trace));

fn travelled(scene: &Scene) -> f64 {
    scene.speed * scene.period * ROWS
}

/// Every cause, at a size that stands in its name.
const TRIED: [Tried; 29] = [
    (", whole words", |s| (s, Trace::Reply { jump: FAR, known: false })),
    (", 24 bits, data 0 or known", |s| {
        (Scene { column: Column::Low24, ..s }, Trace::Reply { jump: FAR, known: true })
    }),
    (", 24 bits, other data", |s| {
        (Scene { column: Column::Low24, ..s }, Trace::Reply { jump: FAR, known: false })
    }),
    (", one bit of the high half changes", |s| (s, Trace::Torn { bits: 1 })),
    (", several change", |s| (s, Trace::Torn { bits: 2 })),
    (", 100 rows, whole words", |s| {
        (s, Trace::Exchanged { rows: ROWS, travelled: travelled(&s), foreign: true })
    }),
    (", 100 rows, 24 bits", |s| {
        let trace = Trace::Exchanged { rows: ROWS, travelled: travelled(&s), foreign: true };
        (Scene { column: Column::Low24, ..s }, trace)
    }),
    (", 100 rows", |s| {
        (s, Trace::OtherCode { cause: Cause::GrayAsBinary, rows: ROWS, travelled: travelled(&s) })
    }),
    (", 100 rows", |s| {
        (s, Trace::OtherCode { cause: Cause::BinaryAsGray, rows: ROWS, travelled: travelled(&s) })
    }),
    (", S known, or seen twice", |s| (s, Trace::Wrap { times: 2 })),
    (" of 4096 positions, S unknown, once", |s| {
        (Scene { positions: TURN, parameters_told: false, ..s }, Trace::Wrap { times: 1 })
    }),
    (", its reply in the rows", |s| (s, Trace::Preset { jump: FAR, shown: true, round: false })),
    (" to 0", |s| (s, Trace::Preset { jump: FAR, shown: false, round: true })),
    (" to another value", |s| (s, Trace::Preset { jump: FAR, shown: false, round: false })),
    (" by 2", |s| (s, Trace::Rescaled { jump: FAR, ratio: 2.0, shown: false })),
    ("", |s| (s, Trace::Direction { jump: FAR, shown: false })),
    (", a known place after the gap", |s| (s, Trace::ZeroLost { known: true })),
    (", none", |s| (s, Trace::ZeroLost { known: false })),
    (", refresh 0.5 ms", |s| (s, Trace::Aliased)),
    (", refresh 1 ms", |s| (Scene { refresh: 0.001, ..s }, Trace::Aliased)),
    (" by a tenth, 10 rows", |s| {
        (Scene { speed: 1.1 * s.top_speed, ..s }, Trace::OverSpeed { excess: s.top_speed / 10.0, rows: 10.0 })
    }),
    (", 10^5 rad/s^2 for 5 ms", |s| {
        let acceleration = of_rad(100_000.0, TURN);
        (s, Trace::OverAcceleration { change: acceleration * 0.005, acceleration })
    }),
    (", bit 12", |s| (s, Trace::Bit { bit: 12, carry: false })),
    (", bit 20", |s| (s, Trace::Bit { bit: 20, carry: false })),
    (", bit 10, 100 rows", |s| {
        let changes = (travelled(&s) / 1_024.0) as u32;
        (s, Trace::Stuck { bit: 10, changes })
    }),
    (" of 100 steps, 100 rows", |s| (s, Trace::Noise { steps: 100.0, rows: ROWS })),
    (", 10 rows", |s| (s, Trace::Frozen { rows: 10.0, steady: true })),
    (", 100 rpm faster", |s| {
        let faster = of_rpm(100.0, TURN);
        (s, Trace::Other { jump: FAR, faster, stands: false, returns: false })
    }),
    (", OUT logged, no preset inputs", |s| (Scene { out_logged: true, ..s }, Trace::Slip { jump: FAR })),
];

/// The page's tables.
pub(crate) fn markdown() -> String {
    let mut page = String::new();
    for rad_s2 in ACCELERATIONS {
        let name = if rad_s2 < 1_000.0 { "100 rad/s^2" } else { "10^4 rad/s^2" };
        line(&mut page, &format!("### The axis accelerates with at most {name}"));
        line(&mut page, "");
        line(&mut page, &head("cause"));
        for (what, tried) in TRIED {
            let cells = PERIODS.map(|period| cell(period, rad_s2, tried));
            let (_, trace) = tried(scene(10, 0.0, rad_s2));
            line(&mut page, &format!("| {}{what} | {} |", trace.cause(), cells.join(" | ")));
        }
        line(&mut page, "");
    }
    line(&mut page, "### Sizes and chances");
    line(&mut page, "");
    line(&mut page, &head("what"));
    for rad_s2 in ACCELERATIONS {
        let name = if rad_s2 < 1_000.0 { "100 rad/s^2" } else { "10^4 rad/s^2" };
        let least = PERIODS.map(|period| least_bit(period, rad_s2));
        line(
            &mut page,
            &format!("| lowest bit that can be told, standing, {name} | {} |", least.join(" | ")),
        );
        let hidden = PERIODS.map(|period| format!("{:.0}", 3.0 * scene(period, 0.0, rad_s2).motion()));
        line(
            &mut page,
            &format!("| largest jump that motion explains, standing, {name} | {} |", hidden.join(" | ")),
        );
    }
    for rpm in [300.0, 1_500.0] {
        let chance = PERIODS.map(|period| digits(scene(period, rpm, 100.0).carries()));
        line(
            &mut page,
            &format!("| chance that a flip of bit 16 looks torn, {rpm:.0} rpm | {} |", chance.join(" | ")),
        );
    }
    let counted = PERIODS.map(|period| format!("{:.0}", (300_000.0 / f64::from(period)).min(6_000.0)));
    line(&mut page, &format!("| a wrap of one turn can be counted below, rpm | {} |", counted.join(" | ")));
    page
}

fn line(page: &mut String, text: &str) {
    let _ = writeln!(page, "{text}");
}

fn head(first: &str) -> String {
    let periods = PERIODS.map(|period| match period {
        5 => "0.5 ms".to_owned(),
        10_000 => "1 s".to_owned(),
        tenths => format!("{} ms", tenths / 10),
    });
    format!("| {first} | {} |\n|---|{}", periods.join(" | "), "---|".repeat(PERIODS.len()))
}

/// The speeds at which nothing else makes the same rows; else what does.
fn cell(period: u32, rad_s2: f64, tried: fn(Scene) -> (Scene, Trace)) -> String {
    let found = SPEEDS.map(|rpm| {
        let (scene, trace) = tried(scene(period, rpm, rad_s2));
        let shows = scene.speed > 0.0 || !trace.needs_motion();
        shows.then(|| rivals(&scene, &trace))
    });
    // Where the cause cannot show, the speed above is the lowest.
    let first = found.iter().position(Option::is_some).unwrap_or_default();
    let rivals = found.map(Option::unwrap_or_default);
    let free: Vec<bool> =
        rivals.iter().enumerate().map(|(at, rivals)| at >= first && rivals.is_empty()).collect();
    let mut parts: Vec<String> = Vec::new();
    let mut begun = None;
    for (index, free) in free.iter().copied().chain([false]).enumerate() {
        match (begun, free) {
            (None, true) => begun = Some(index),
            (Some(begins), false) => {
                parts.push(speeds(begins, index - 1, first));
                begun = None;
            }
            _ => {}
        }
    }
    if parts.is_empty() {
        let mut all: Vec<Cause> = rivals.into_iter().flatten().collect();
        all.sort_unstable();
        all.dedup();
        let names: Vec<_> = all.into_iter().map(Cause::name).collect();
        return names.join(", ");
    }
    parts.join(", ")
}

fn speeds(first: usize, last: usize, least: usize) -> String {
    let rpm = |index: usize| SPEEDS.get(index).map_or(String::new(), |rpm| format!("{rpm:.0}"));
    match (first, last) {
        (first, last) if first == least && last + 1 == SPEEDS.len() => "all".to_owned(),
        (first, last) if first == last => rpm(first),
        (first, last) => format!("{}..{}", rpm(first), rpm(last)),
    }
}

fn least_bit(period: u32, rad_s2: f64) -> String {
    let scene = scene(period, 0.0, rad_s2);
    let found = (0..24).find(|bit| rivals(&scene, &Trace::Bit { bit: *bit, carry: false }).is_empty());
    found.map_or("none".to_owned(), |bit| bit.to_string())
}

/// Two digits that count.
fn digits(chance: f64) -> String {
    if chance >= 0.1 {
        format!("{chance:.2}")
    } else if chance >= 0.01 {
        format!("{chance:.3}")
    } else {
        format!("{chance:.4}")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    #[test]
    fn the_page_has_the_tables_as_they_are_computed() {
        let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/diagnosis.md");
        let page = std::fs::read_to_string(page).unwrap();
        let (_, rest) = page.split_once("<!-- computed: jumps table -->\n").unwrap();
        let (tables, _) = rest.split_once("<!-- end -->").unwrap();
        let computed = super::markdown();
        assert!(computed.lines().count() > 60);
        assert_eq!(
            tables.trim(),
            computed.trim(),
            "write the output of `jumps table` into docs/diagnosis.md"
        );
    }
}
