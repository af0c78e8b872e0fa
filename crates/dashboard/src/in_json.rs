//! What is answered, in JSON.

use axum::extract::rejection::QueryRejection;
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use encoring_station::{RingStopped, answer};
use encoring_texts::{Said, own};
use serde::Serialize;

use crate::refusals;

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
pub(crate) fn refused(status: StatusCode, why: &Said) -> Response {
    in_json(status, answer::refusal_said(why))
}

/// That a query is not what it should be, in the words of its reader.
pub(crate) fn wrong_query(wrong: &QueryRejection) -> Response {
    refused(StatusCode::BAD_REQUEST, &own(&wrong.body_text()))
}

/// That nothing is there any more to be looked at.
pub(crate) fn stopped(_: RingStopped) -> Response {
    refused(StatusCode::SERVICE_UNAVAILABLE, &refusals::stopped())
}
