//! What can be asked of the page's server.

use std::convert::Infallible;
use std::sync::Arc;

use axum::Router;
use axum::body::{Body, to_bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::{StatusCode, header};
use axum::middleware;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use encoring_station::answer::{self, answer};
use encoring_station::{ChangesSince, RingEvent, RingStopped};
use futures_util::stream::{self, Stream};
use serde::{Deserialize, Serialize};
use tokio::sync::watch;
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use crate::frames::Frame;
use crate::shared::{BODY_BYTES_MAX, Shared};
use crate::{assets, guard, metrics, units};

/// The most changes in one answer; the next ones are asked for then.
const CHANGES_MAX: usize = 2_000;

/// A way in that is no file.
struct Way {
    path: &'static str,
    #[cfg_attr(not(test), expect(dead_code, reason = "compared with the description"))]
    method: &'static str,
    handler: fn() -> MethodRouter<Shared>,
}

const WAYS: [Way; 8] = [
    Way { path: "/healthz", method: "get", handler: || get(healthz) },
    Way { path: "/metrics", method: "get", handler: || get(metrics::metrics) },
    Way { path: "/api/state", method: "get", handler: || get(state) },
    Way { path: "/api/units", method: "get", handler: || get(units_of) },
    Way { path: "/api/history", method: "get", handler: || get(history) },
    Way { path: "/api/happened", method: "get", handler: || get(happened) },
    Way { path: "/api/events", method: "get", handler: || get(events) },
    Way { path: "/api/command", method: "post", handler: || post(command) },
];

/// What is served, without a socket.
pub(crate) fn app(shared: Shared) -> Router {
    let files = assets::paths().fold(Router::new(), |router, path| router.route(path, get(assets::file)));
    let ways = WAYS.iter().fold(files, |router, way| router.route(way.path, (way.handler)()));
    ways.fallback(|| async { (StatusCode::NOT_FOUND, "there is no such page\n") })
        .layer(middleware::from_fn_with_state(shared.clone(), guard::guard))
        .with_state(shared)
}

/// An answer in JSON.
pub(crate) fn in_json(status: StatusCode, text: String) -> Response {
    (status, [(header::CONTENT_TYPE, "application/json")], text).into_response()
}

fn given(value: &impl Serialize) -> Response {
    // Plain data with names for keys has no reason to fail.
    in_json(StatusCode::OK, serde_json::to_string(value).unwrap_or_default())
}

fn refused(status: StatusCode, why: &str) -> Response {
    in_json(status, answer::refusal(why))
}

fn stopped(stopped: RingStopped) -> Response {
    refused(StatusCode::SERVICE_UNAVAILABLE, &stopped.to_string())
}

async fn healthz(State(shared): State<Shared>) -> Response {
    match shared.controlled.ring.events(u64::MAX) {
        Ok(_) => "ok\n".into_response(),
        Err(error) => stopped(error),
    }
}

async fn state(State(shared): State<Shared>) -> Response {
    match shared.frames.fresh().await {
        Ok(frame) => in_json(StatusCode::OK, frame.whole.clone()),
        Err(error) => stopped(error),
    }
}

async fn units_of(State(shared): State<Shared>) -> Response {
    in_json(StatusCode::OK, units::in_json(&shared.controlled.units))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HistoryQuery {
    position: usize,
    #[serde(default)]
    from: u64,
}

async fn history(
    State(shared): State<Shared>,
    query: Result<Query<HistoryQuery>, QueryRejection>,
) -> Response {
    let Query(HistoryQuery { position, from }) = match query {
        Ok(query) => query,
        Err(wrong) => return refused(StatusCode::BAD_REQUEST, &wrong.body_text()),
    };
    let since: Option<ChangesSince> = shared.controlled.ring.history().since(position, from, CHANGES_MAX);
    match since {
        Some(since) => given(&since),
        None => {
            let last = shared.controlled.units.len().saturating_sub(1);
            let why = format!("position {position}; the encoders are at 0 to {last}");
            refused(StatusCode::NOT_FOUND, &why)
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct HappenedQuery {
    #[serde(default)]
    from: u64,
}

async fn happened(
    State(shared): State<Shared>,
    query: Result<Query<HappenedQuery>, QueryRejection>,
) -> Response {
    let Query(HappenedQuery { from }) = match query {
        Ok(query) => query,
        Err(wrong) => return refused(StatusCode::BAD_REQUEST, &wrong.body_text()),
    };
    let kept: Result<Vec<RingEvent>, RingStopped> = shared.controlled.ring.events(from);
    match kept {
        Ok(events) => given(&events),
        Err(error) => stopped(error),
    }
}

/// Every frame from now on: the first one whole, the others as what has changed; whole again for whoever missed one.
async fn events(State(shared): State<Shared>) -> Sse<impl Stream<Item = Result<Event, Infallible>>> {
    let mut frames = shared.frames.subscribe();
    // The newest frame may be old; what is told first is whole, whichever it is.
    frames.mark_unchanged();
    let told = stream::unfold((frames, 0), |(mut frames, last)| async move {
        frames.changed().await.ok()?;
        let frame = Arc::clone(&frames.borrow_and_update());
        Some((Ok(told(&frame, last)), (frames, frame.number)))
    });
    Sse::new(until_stopped(told, shared.stopped.clone())).keep_alive(KeepAlive::default())
}

fn told(frame: &Frame, last: u64) -> Event {
    if last > 0 && last + 1 == frame.number {
        Event::default().event("patch").data(&frame.patch)
    } else {
        Event::default().event("state").data(&frame.whole)
    }
}

/// A stream that ends with the server.
fn until_stopped<T>(told: impl Stream<Item = T>, mut stopped: watch::Receiver<()>) -> impl Stream<Item = T> {
    use futures_util::StreamExt;
    told.take_until(async move { while stopped.changed().await.is_ok() {} })
}

/// One of the verbs of the control port, as one object of JSON.
async fn command(State(shared): State<Shared>, body: Body) -> Response {
    let read = timeout(shared.slow, to_bytes(body, BODY_BYTES_MAX)).await;
    let bytes = match read {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(_)) => {
            let why = format!("the body is broken off, or longer than {BODY_BYTES_MAX} bytes");
            return refused(StatusCode::PAYLOAD_TOO_LARGE, &why);
        }
        Err(_) => {
            return refused(StatusCode::REQUEST_TIMEOUT, "the body did not come in time");
        }
    };
    let Ok(text) = String::from_utf8(bytes.into()) else {
        return refused(StatusCode::BAD_REQUEST, "the body is not UTF-8");
    };
    let controlled = shared.controlled.clone();
    let answered = spawn_blocking(move || answer(&text, &controlled)).await;
    match answered {
        Ok(answered) => {
            let status = match answered.starts_with(r#"{"ok":true"#) {
                true => StatusCode::OK,
                false => StatusCode::BAD_REQUEST,
            };
            in_json(status, answered)
        }
        Err(_) => stopped(RingStopped),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use serde_json::Value;

    use super::*;

    #[test]
    fn the_description_has_every_way_in_and_no_other() {
        let text = include_str!("../assets/openapi.json");
        let description: Value = serde_json::from_str(text).unwrap();
        let described: BTreeSet<(String, String)> = description["paths"]
            .as_object()
            .unwrap()
            .iter()
            .flat_map(|(path, ways)| ways.as_object().unwrap().keys().map(|way| (path.clone(), way.clone())))
            .collect();
        let served = WAYS.iter().map(|way| (way.path.to_owned(), way.method.to_owned())).collect();
        assert_eq!(described, served);
    }
}
