//! The ring's counters, as Prometheus reads them.

use std::fmt::{self, Write};

use axum::extract::State;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::Value;

use crate::frames::Frame;
use crate::shared::Shared;

pub(crate) async fn metrics(State(shared): State<Shared>) -> Response {
    let Ok(frame) = shared.frames.fresh().await else {
        return (StatusCode::SERVICE_UNAVAILABLE, "the ring has stopped\n").into_response();
    };
    match written(&frame, shared.frames.streams()) {
        Ok(text) => ([(header::CONTENT_TYPE, "text/plain; version=0.0.4")], text).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

/// A metric: its name, its kind and what it counts.
struct Metric(&'static str, &'static str, &'static str);

impl Metric {
    fn head(&self, text: &mut String) -> fmt::Result {
        let Self(name, kind, help) = self;
        write!(text, "# HELP {name} {help}\n# TYPE {name} {kind}\n")
    }
}

fn written(frame: &Frame, streams: usize) -> Result<String, fmt::Error> {
    let state = frame.state();
    let mut text = String::new();
    for (metric, pointer) in [
        (Metric("encoring_cycles_total", "counter", "Cycles of the ring."), "/ring/counters/cycles"),
        (
            Metric("encoring_faulty_cycles_total", "counter", "Cycles that were not good throughout."),
            "/ring/counters/faulty_cycles",
        ),
        (
            Metric("encoring_dropped_cycles_total", "counter", "Cycles that the machine was too slow for."),
            "/ring/counters/dropped_cycles",
        ),
        (Metric("encoring_cycle_nanoseconds", "gauge", "Time of one cycle."), "/ring/cycle_ns"),
        (Metric("encoring_polls_total", "counter", "Polls of a ring behind a bus."), "/ring/polls"),
    ] {
        // What nobody has counted is no 0.
        if let Some(count) = state.pointer(pointer).and_then(Value::as_u64) {
            metric.head(&mut text)?;
            writeln!(text, "{} {count}", metric.0)?;
        }
    }
    if let Some(up) = state.pointer("/ring/link/up").and_then(Value::as_bool) {
        Metric("encoring_link_up", "gauge", "Whether there is a connection to the bus.").head(&mut text)?;
        writeln!(text, "encoring_link_up {}", u8::from(up))?;
    }
    let none = Vec::new();
    let faults = state.pointer("/ring/diagnosis/segment_faults").and_then(Value::as_array).unwrap_or(&none);
    if !faults.is_empty() {
        Metric("encoring_segment_faults_total", "counter", "Faulty cycles located on a segment.")
            .head(&mut text)?;
    }
    for (segment, count) in faults.iter().enumerate() {
        writeln!(text, "encoring_segment_faults_total{{segment=\"{segment}\"}} {count}")?;
    }
    if state.pointer("/ring/cycle_ns").is_some() {
        Metric("encoring_encoder_on", "gauge", "Whether an encoder has its supply.").head(&mut text)?;
    }
    for (position, device) in devices(state) {
        let Some(on) = device.get("on").and_then(Value::as_bool) else { continue };
        let model = device.get("model").and_then(Value::as_str).unwrap_or_default();
        writeln!(text, "encoring_encoder_on{{position=\"{position}\",model=\"{model}\"}} {}", u8::from(on))?;
    }
    Metric("encoring_encoder_position", "gauge", "The position in steps.").head(&mut text)?;
    for (position, device) in devices(state) {
        if let Some(value) = device.get("value").and_then(Value::as_u64) {
            writeln!(text, "encoring_encoder_position{{position=\"{position}\"}} {value}")?;
        }
    }
    let changes = state.pointer("/changes").and_then(Value::as_array).unwrap_or(&none);
    Metric("encoring_word_changes_total", "counter", "Changes of OUT or of the upper byte of IN.")
        .head(&mut text)?;
    for (position, count) in changes.iter().enumerate() {
        writeln!(text, "encoring_word_changes_total{{position=\"{position}\"}} {count}")?;
    }
    Metric("encoring_page_streams", "gauge", "Pages that are open.").head(&mut text)?;
    writeln!(text, "encoring_page_streams {streams}")?;
    Ok(text)
}

/// The encoders by position.
fn devices(state: &Value) -> impl Iterator<Item = (&String, &Value)> {
    state.pointer("/ring/devices").and_then(Value::as_object).into_iter().flatten()
}
