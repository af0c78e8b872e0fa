//! Who is answered at all, and what a browser is told beside every answer.
//!
//! A page of another site can make a browser send requests here, and a name of that site can be made to lead to this
//! machine. So a request must name a host that this page is known by, and whatever a browser says of where it comes
//! from must be this page.

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::shared::Shared;

/// No script and no style but the page's own files, and nothing from elsewhere.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; \
     connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

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
pub(crate) enum Turned {
    /// The page is not known under that name.
    #[error("the page is not served under this Host; --web-host NAME adds a name")]
    Host,
    /// From another page.
    #[error("requests from other pages are refused")]
    Origin,
    /// As a form of any page can send it.
    #[error("the body must be application/json")]
    Kind,
}

impl Turned {
    const fn status(self) -> StatusCode {
        match self {
            Self::Host => StatusCode::MISDIRECTED_REQUEST,
            Self::Origin => StatusCode::FORBIDDEN,
            Self::Kind => StatusCode::UNSUPPORTED_MEDIA_TYPE,
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

/// Whether a request may be looked at.
pub(crate) fn judge(method: &Method, uri: &Uri, headers: &HeaderMap, hosts: &[String]) -> Result<(), Turned> {
    let host = one(headers, header::HOST).ok().flatten().ok_or(Turned::Host)?;
    let named = uri.authority().is_none_or(|authority| authority.as_str().eq_ignore_ascii_case(host));
    if !named || !hosts.contains(&name(host)) {
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
        if !kind.eq_ignore_ascii_case("application/json") {
            return Err(Turned::Kind);
        }
    }
    Ok(())
}

/// Lets only those through that [`judge`] lets through, and tells every browser what it may do.
pub(crate) async fn guard(State(shared): State<Shared>, request: Request, next: Next) -> Response {
    let judged = judge(request.method(), request.uri(), request.headers(), &shared.hosts);
    let mut response = match judged {
        Ok(()) => next.run(request).await,
        Err(turned) => (turned.status(), format!("{turned}\n")).into_response(),
    };
    for (name, value) in TOLD {
        response.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    response
}
