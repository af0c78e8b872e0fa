//! What can be asked of the page's server.

use std::convert::Infallible;
use std::sync::Arc;

use axum::body::{Body, to_bytes};
use axum::extract::rejection::QueryRejection;
use axum::extract::{Query, State};
use axum::http::{StatusCode, header};
use axum::middleware;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};
use axum::{Extension, Router};
use encoring_station::answer::LineFate;
use encoring_station::shown::AboutRing;
use encoring_station::{ChangesSince, Permission, RingEvent, RingStopped};
use encoring_words::Model;
use encoring_words::model::MODELS;
use futures_util::stream::{self, Stream};
use serde::{Deserialize, Serialize};
use tokio::sync::watch;
use tokio::task::spawn_blocking;
use tokio::time::{Instant, timeout};

use crate::frames::Frame;
use crate::in_json::{given, in_json, refused, stopped, wrong_query};
use crate::shared::{BODY_BYTES_MAX, Ends, Shared};
use crate::{assets, diagnose, guard, metrics, refusals, sheet, units};

/// The most changes in one answer; the next ones are asked for then.
const CHANGES_MAX: usize = 2_000;

/// A way in that is no file.
struct Way {
    path: &'static str,
    #[cfg_attr(not(test), expect(dead_code, reason = "compared with the description"))]
    method: &'static str,
    handler: fn() -> MethodRouter<Shared>,
}

const WAYS: [Way; 12] = [
    Way { path: "/healthz", method: "get", handler: || get(healthz) },
    Way { path: "/metrics", method: "get", handler: || get(metrics::metrics) },
    Way { path: "/api/state", method: "get", handler: || get(state) },
    Way { path: "/api/about", method: "get", handler: || get(about) },
    Way { path: "/api/units", method: "get", handler: || get(units_of) },
    Way { path: "/api/sheet", method: "get", handler: || get(sheet::sheet) },
    Way { path: "/api/history", method: "get", handler: || get(history) },
    Way { path: "/api/happened", method: "get", handler: || get(happened) },
    Way { path: "/api/events", method: "get", handler: || get(events) },
    Way { path: "/api/command", method: "post", handler: || post(command) },
    Way { path: "/api/diagnose", method: "post", handler: || post(diagnose::diagnose) },
    Way { path: "/api/login", method: "post", handler: || post(login) },
];

/// What is served, without a socket.
pub(crate) fn app(shared: Shared) -> Router {
    let files = assets::paths().fold(Router::new(), |router, path| router.route(path, get(assets::file)));
    let ways = WAYS.iter().fold(files, |router, way| router.route(way.path, (way.handler)()));
    ways.fallback(|| async { (StatusCode::NOT_FOUND, "there is no such page\n") })
        .layer(middleware::from_fn_with_state(shared.clone(), guard::guard))
        .with_state(shared)
}

async fn healthz(State(shared): State<Shared>) -> Response {
    match shared.ring.happened(u64::MAX) {
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
    in_json(StatusCode::OK, units::in_json(shared.ring.units()))
}

/// Which ring it is, and what may be done.
#[derive(Serialize)]
struct About {
    #[serde(flatten)]
    ring: AboutRing,
    /// Whether verbs that change something are taken.
    may_change: bool,
    /// The names of all models.
    models: Vec<&'static str>,
}

async fn about(State(shared): State<Shared>) -> Response {
    let may_change = shared.permission == Permission::Change;
    let models = MODELS.map(Model::name).to_vec();
    given(&About { ring: shared.ring.about(), may_change, models })
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
        Err(wrong) => return wrong_query(&wrong),
    };
    let since: Option<ChangesSince> = shared.ring.history().since(position, from, CHANGES_MAX);
    match since {
        Some(since) => given(&since),
        None => {
            let last = shared.ring.units().last().map_or(0, |unit| unit.position);
            refused(StatusCode::NOT_FOUND, &refusals::no_position(position, last))
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
        Err(wrong) => return wrong_query(&wrong),
    };
    let kept: Result<Vec<RingEvent>, RingStopped> = shared.ring.happened(from);
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

/// The body of a request, as text, if it comes whole and in time.
async fn text_of(body: Body, shared: &Shared) -> Result<String, Response> {
    let bytes = match timeout(shared.slow, to_bytes(body, BODY_BYTES_MAX)).await {
        Ok(Ok(bytes)) => bytes,
        Ok(Err(_)) => {
            return Err(refused(StatusCode::PAYLOAD_TOO_LARGE, &refusals::body_too_long(BODY_BYTES_MAX)));
        }
        Err(_) => return Err(refused(StatusCode::REQUEST_TIMEOUT, &refusals::body_too_slow())),
    };
    let text = String::from_utf8(bytes.into());
    text.map_err(|_| refused(StatusCode::BAD_REQUEST, &refusals::no_text()))
}

/// One of the verbs of the control port, as one object of JSON.
async fn command(State(shared): State<Shared>, body: Body) -> Response {
    let text = match text_of(body, &shared).await {
        Ok(text) => text,
        Err(refused) => return refused,
    };
    let (ring, permission) = (Arc::clone(&shared.ring), shared.permission);
    match spawn_blocking(move || ring.told(&text, permission)).await {
        Ok(told) => {
            let status = match told.fate {
                LineFate::Done => StatusCode::OK,
                LineFate::Refused => StatusCode::BAD_REQUEST,
                LineFate::Forbidden => StatusCode::FORBIDDEN,
            };
            in_json(status, told.line)
        }
        Err(_) => stopped(RingStopped),
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Login {
    token: String,
}

/// The token, as it was entered in the page: what is right is kept as a cookie that no script can read.
async fn login(State(shared): State<Shared>, Extension(ends): Extension<Ends>, body: Body) -> Response {
    let text = match text_of(body, &shared).await {
        Ok(text) => text,
        Err(refused) => return refused,
    };
    let Ok(Login { token }) = serde_json::from_str(&text) else {
        return refused(StatusCode::BAD_REQUEST, &refusals::no_login());
    };
    match shared.access.enter(&token, ends.peer, Instant::now()) {
        Ok(cookie) => {
            let mut response = in_json(StatusCode::OK, r#"{"ok":true}"#.to_owned());
            response.headers_mut().extend(cookie.map(|cookie| (header::SET_COOKIE, cookie)));
            response
        }
        Err(entry) => guard::not_let_in(&shared.access, entry),
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
