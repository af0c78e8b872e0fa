//! What is answered, in JSON.

use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use encoring_station::{RingStopped, answer};
use serde::Serialize;

/// An answer in JSON.
pub(crate) fn in_json(status: StatusCode, text: String) -> Response {
    (status, [(header::CONTENT_TYPE, "application/json")], text).into_response()
}

/// What is asked for, in JSON.
pub(crate) fn given(value: &impl Serialize) -> Response {
    // Plain data with names for keys has no reason to fail.
    in_json(StatusCode::OK, serde_json::to_string(value).unwrap_or_default())
}

/// A refusal in JSON.
pub(crate) fn refused(status: StatusCode, why: &str) -> Response {
    in_json(status, answer::refusal(why))
}

/// That nothing is there any more to be looked at.
pub(crate) fn stopped(stopped: RingStopped) -> Response {
    refused(StatusCode::SERVICE_UNAVAILABLE, &stopped.to_string())
}
