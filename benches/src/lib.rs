//! Benchmarks only; see docs/performance.md.

/// A scenario of this many encoders, the three models in turn, all moving.
#[must_use]
pub fn scenario(encoders: usize) -> String {
    let device = |position: usize| {
        let (model, motion) = match position % 3 {
            0 => ("ce-65-m", "{ kind = \"speed\", start = 0, rpm = 3000 }"),
            1 => ("ce-100-m", "{ kind = \"speed\", start = 0, rpm = 3000 }"),
            _ => ("la-66", "{ kind = \"sine\", center = 250000, amplitude = 200000, period_s = 5.0 }"),
        };
        format!("[[device]]\nposition = {position}\nmodel = \"{model}\"\nmotion = {motion}\n")
    };
    std::iter::once("version = 1\n".to_owned()).chain((0..encoders).map(device)).collect()
}
