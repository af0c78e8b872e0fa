//! Who is answered at all, and what a browser is told beside every answer.
//!
//! A page of another site can make a browser send requests here, and a name of that site can be made to lead to this
//! machine. So a request must name a host that this page is known by, and whatever a browser says of where it comes
//! from must be this page.

use std::net::IpAddr;

use axum::Extension;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use encoring_texts::Said;
use tokio::time::Instant;

use crate::access::{Access, Entry};
use crate::assets;
use crate::in_json::refused;
use crate::refusals;
use crate::shared::{Ends, Shared};

/// No script and no style but the page's own files, and nothing from elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Where a recording is sent.
const RECORDING: &str = "/api/diagnose";

const TOLD: [(header::HeaderName, &str); 6] = [
    (header::CONTENT_SECURITY_POLICY, POLICY),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    (header::X_FRAME_OPTIONS, "DENY"),
    (header::REFERRER_POLICY, "no-referrer"),
    (header::CACHE_CONTROL, "no-store"),
    (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Why a request was not looked at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.said())]
pub(crate) enum Turned {
    /// The page is not known under that name.
    Host,
    /// From another page.
    Origin,
    /// As a form of any page can send it.
    Kind,
    /// It names no token.
    NoToken,
    /// It names a wrong one.
    WrongToken,
    /// There were too many wrong ones.
    TooMany,
}

impl Turned {
    fn said(self) -> Said {
        match self {
            Self::Host => refusals::other_host(),
            Self::Origin => refusals::other_page(),
            Self::Kind => refusals::other_kind(),
            Self::NoToken => refusals::no_token(),
            Self::WrongToken => refusals::wrong_token(),
            Self::TooMany => refusals::too_many(),
        }
    }

    const fn status(self) -> StatusCode {
        match self {
            Self::Host => StatusCode::MISDIRECTED_REQUEST,
            Self::Origin => StatusCode::FORBIDDEN,
            Self::Kind => StatusCode::UNSUPPORTED_MEDIA_TYPE,
            Self::NoToken | Self::WrongToken => StatusCode::UNAUTHORIZED,
            Self::TooMany => StatusCode::TOO_MANY_REQUESTS,
        }
    }
}

/// The one value of a header; `Err` if there are several or it is no text.
fn one(headers: &HeaderMap, name: impl header::AsHeaderName) -> Result<Option<&str>, ()> {
    let mut values = headers.get_all(name).iter();
    let Some(value) = values.next() else { return Ok(None) };
    if values.next().is_some() {
        return Err(());
    }
    value.to_str().map(Some).map_err(|_| ())
}

/// A host without its port, in lower case.
fn name(authority: &str) -> String {
    let name = match authority.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((address, _)) => address,
        None => authority.split(':').next().unwrap_or_default(),
    };
    name.to_ascii_lowercase()
}

/// Whether a request that came to the address `here` may be looked at.
pub(crate) fn judge(
    method: &Method,
    uri: &Uri,
    headers: &HeaderMap,
    hosts: &[String],
    here: IpAddr,
) -> Result<(), Turned> {
    let host = one(headers, header::HOST).ok().flatten().ok_or(Turned::Host)?;
    let named = uri.authority().is_none_or(|authority| authority.as_str().eq_ignore_ascii_case(host));
    let host_name = name(host);
    // No name leads elsewhere that is an address.
    if !named || !hosts.contains(&host_name) && host_name != here.to_string() {
        return Err(Turned::Host);
    }
    let origin = one(headers, header::ORIGIN).map_err(|()| Turned::Origin)?;
    if origin.is_some_and(|origin| {
        origin.strip_prefix("http://").is_none_or(|origin| !origin.eq_ignore_ascii_case(host))
    }) {
        return Err(Turned::Origin);
    }
    let site = one(headers, "sec-fetch-site").map_err(|()| Turned::Origin)?;
    let from_here = site.is_none_or(|site| matches!(site, "same-origin" | "none"));
    // A link on another page may lead to this one.
    let followed = method == Method::GET && uri.path() == "/";
    if !from_here && !followed {
        return Err(Turned::Origin);
    }
    if method == Method::POST {
        let kind = one(headers, header::CONTENT_TYPE).ok().flatten().unwrap_or_default();
        let kind = kind.split(';').next().unwrap_or_default().trim();
        // Neither is a kind that a page of another site may send without asking.
        let wanted = if uri.path() == RECORDING { "application/octet-stream" } else { "application/json" };
        if !kind.eq_ignore_ascii_case(wanted) {
            return Err(Turned::Kind);
        }
    }
    Ok(())
}

/// What is sent without a token: the files of the page, which hold nothing of the ring, the form's answer, and whether
/// all is well.
fn is_open(path: &str) -> bool {
    matches!(path, "/healthz" | "/api/login") || assets::paths().any(|asset| asset == path)
}

/// An answer to a request that was turned away, which tells the browser to forget its cookie if it is of no use.
fn turned_away(turned: Turned, access: &Access, entry: Entry) -> Response {
    let mut response = refused(turned.status(), &turned.said());
    let headers = response.headers_mut();
    match entry {
        Entry::TooMany { again_after } => {
            headers.insert(header::RETRY_AFTER, HeaderValue::from(again_after.as_secs().max(1)));
        }
        _ => {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
    }
    if entry == (Entry::WrongToken { forget: true })
        && let Some(cookie) = access.forget()
    {
        headers.insert(header::SET_COOKIE, cookie);
    }
    response
}

/// The answer to whoever is not let in.
pub(crate) fn not_let_in(access: &Access, entry: Entry) -> Response {
    let turned = match entry {
        Entry::TooMany { .. } => Turned::TooMany,
        Entry::WrongToken { .. } => Turned::WrongToken,
        Entry::NoToken | Entry::Open => Turned::NoToken,
    };
    turned_away(turned, access, entry)
}

async fn let_in(shared: &Shared, ends: Ends, request: Request, next: Next) -> Response {
    let judged = judge(request.method(), request.uri(), request.headers(), &shared.hosts, ends.here);
    if let Err(turned) = judged {
        return (turned.status(), format!("{turned}\n")).into_response();
    }
    if !is_open(request.uri().path()) {
        let entry = shared.access.judge(request.headers(), ends.peer, Instant::now());
        if entry != Entry::Open {
            return not_let_in(&shared.access, entry);
        }
    }
    next.run(request).await
}

/// Lets only those through that [`judge`] lets through and that name the token, and tells every browser what it may do.
pub(crate) async fn guard(
    State(shared): State<Shared>,
    Extension(ends): Extension<Ends>,
    request: Request,
    next: Next,
) -> Response {
    let mut response = let_in(&shared, ends, request, next).await;
    for (name, value) in TOLD {
        response.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    response
}
