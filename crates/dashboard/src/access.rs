//! Who may look: whoever names the token, if there is one. How often a wrong one may be named is limited.

use std::collections::BTreeMap;
use std::fmt;
use std::net::{IpAddr, Ipv6Addr};
use std::str::FromStr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use axum::http::{HeaderMap, HeaderValue, header};
use subtle::ConstantTimeEq;
use tokio::time::{Duration, Instant};

/// The fewest characters of a token: as many as nobody finds by trying.
const TOKEN_CHARS_MIN: usize = 16;

/// The most.
const TOKEN_CHARS_MAX: usize = 256;

/// Wrong tokens that may come from one address one after the other.
const TRIES: u32 = 10;

/// After this time one more may.
const AGAIN_AFTER: Duration = Duration::from_secs(6);

/// Addresses of which wrong tokens are remembered; while there are so many, no other may try.
const ADDRESSES_MAX: usize = 1_024;

/// What whoever reaches the page must name.
#[derive(Clone)]
pub struct WebToken(Vec<u8>);

/// It never shows itself.
impl fmt::Debug for WebToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("WebToken")
    }
}

/// A text that is no token.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotAToken {
    /// Too short or too long.
    #[error("{chars} characters; a token has {TOKEN_CHARS_MIN} to {TOKEN_CHARS_MAX}")]
    Length {
        /// How many it has.
        chars: usize,
    },
    /// A character that a cookie cannot hold.
    #[error("character {at} is none of A to Z, a to z, 0 to 9, - . _ ~ + / =")]
    Character {
        /// The number of the first one, from 1.
        at: usize,
    },
}

impl FromStr for WebToken {
    type Err = NotAToken;

    fn from_str(text: &str) -> Result<Self, NotAToken> {
        let chars = text.chars().count();
        if !(TOKEN_CHARS_MIN..=TOKEN_CHARS_MAX).contains(&chars) {
            return Err(NotAToken::Length { chars });
        }
        let allowed = |sign: char| sign.is_ascii_alphanumeric() || "-._~+/=".contains(sign);
        match text.chars().position(|sign| !allowed(sign)) {
            Some(at) => Err(NotAToken::Character { at: at + 1 }),
            None => Ok(Self(text.as_bytes().to_vec())),
        }
    }
}

impl WebToken {
    /// Whether this is it. How long that takes does not say how much of it is right.
    fn is(&self, named: &[u8]) -> bool {
        self.0.ct_eq(named).into()
    }
}

/// What a request names to be let in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Named<'a> {
    Nothing,
    Bearer(&'a [u8]),
    Cookie(&'a [u8]),
}

/// What becomes of a request that needs the token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Entry {
    /// It is let in.
    Open,
    /// It names none.
    NoToken,
    /// It names a wrong one, in its cookie or otherwise.
    WrongToken {
        /// The browser is to forget its cookie.
        forget: bool,
    },
    /// There were too many wrong ones from there.
    TooMany {
        /// When the next one is looked at.
        again_after: Duration,
    },
}

/// Who may look.
#[derive(Debug)]
pub(crate) struct Access {
    token: Option<WebToken>,
    cookie: String,
    tries: Tries,
}

impl Access {
    /// That of a page on this port: cookies are shared by all ports of a machine.
    pub(crate) fn new(token: Option<WebToken>, port: u16) -> Self {
        Self { token, cookie: format!("encoring-{port}"), tries: Tries::default() }
    }

    /// Whether a request from there may pass.
    pub(crate) fn judge(&self, headers: &HeaderMap, from: IpAddr, now: Instant) -> Entry {
        let Some(token) = &self.token else { return Entry::Open };
        let (named, forget) = match named(headers, &self.cookie) {
            Named::Nothing => return Entry::NoToken,
            Named::Bearer(named) => (named, false),
            Named::Cookie(named) => (named, true),
        };
        self.tries.judge(from, now, || token.is(named), forget)
    }

    /// Whether this text, entered there, is the token; then with the cookie that keeps it.
    pub(crate) fn enter(&self, text: &str, from: IpAddr, now: Instant) -> Result<Option<HeaderValue>, Entry> {
        let Some(token) = &self.token else { return Ok(None) };
        match self.tries.judge(from, now, || token.is(text.as_bytes()), false) {
            // What a token is made of can stand in a cookie.
            Entry::Open => Ok(HeaderValue::from_str(&self.cookie(text, "")).ok()),
            refused => Err(refused),
        }
    }

    /// What makes a browser forget its cookie.
    pub(crate) fn forget(&self) -> Option<HeaderValue> {
        HeaderValue::from_str(&self.cookie("", "; Max-Age=0")).ok()
    }

    fn cookie(&self, token: &str, more: &str) -> String {
        format!("{}={token}; Path=/; HttpOnly; SameSite=Strict{more}", self.cookie)
    }
}

fn named<'a>(headers: &'a HeaderMap, cookie: &str) -> Named<'a> {
    if let Some(value) = headers.get(header::AUTHORIZATION) {
        let (kind, token) = value.as_bytes().split_at_checked(7).unwrap_or_default();
        return Named::Bearer(if kind.eq_ignore_ascii_case(b"bearer ") { token } else { b"" });
    }
    let cookies =
        headers.get_all(header::COOKIE).iter().flat_map(|value| value.as_bytes().split(|byte| *byte == b';'));
    let mut values = cookies.filter_map(|pair| {
        let pair = pair.trim_ascii();
        let at = pair.iter().position(|byte| *byte == b'=')?;
        let (name, value) = pair.split_at_checked(at)?;
        (name == cookie.as_bytes()).then(|| value.get(1..).unwrap_or_default())
    });
    values.next().map_or(Named::Nothing, Named::Cookie)
}

/// The wrong tokens that came from each address: the time at which it may make all its tries again.
#[derive(Debug, Default)]
struct Tries(Mutex<BTreeMap<IpAddr, Instant>>);

/// One network has many addresses of the sixth version.
fn network(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
        address => address,
    }
}

impl Tries {
    fn wrong(&self) -> MutexGuard<'_, BTreeMap<IpAddr, Instant>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks at a token, if one more may come from there.
    fn judge(&self, from: IpAddr, now: Instant, is_right: impl FnOnce() -> bool, forget: bool) -> Entry {
        let from = network(from);
        let mut wrong = self.wrong();
        wrong.retain(|_, free_at| *free_at > now);
        let known = wrong.get(&from).copied();
        if known.is_none() && wrong.len() >= ADDRESSES_MAX {
            return Entry::TooMany { again_after: AGAIN_AFTER };
        }
        let free_at = known.unwrap_or(now) + AGAIN_AFTER;
        let over = (free_at - now).saturating_sub(AGAIN_AFTER * TRIES);
        if !over.is_zero() {
            return Entry::TooMany { again_after: over };
        }
        if is_right() {
            return Entry::Open;
        }
        wrong.insert(from, free_at);
        Entry::WrongToken { forget }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TOKEN: &str = "correct-horse-battery";

    fn access() -> Access {
        Access::new(Some(TOKEN.parse().unwrap()), 8051)
    }

    fn headers(name: header::HeaderName, value: &str) -> HeaderMap {
        HeaderMap::from_iter([(name, HeaderValue::from_str(value).unwrap())])
    }

    fn address(last: u8) -> IpAddr {
        IpAddr::from([192, 168, 1, last])
    }

    #[test]
    fn a_token_is_long_and_can_stand_in_a_cookie() {
        assert!(TOKEN.parse::<WebToken>().is_ok());
        assert_eq!("short".parse::<WebToken>().unwrap_err(), NotAToken::Length { chars: 5 });
        assert_eq!("x".repeat(257).parse::<WebToken>().unwrap_err(), NotAToken::Length { chars: 257 });
        for wrong in
            ["correct;horse;battery", "correct horse battery", "correct\"horse\"bat", "größer-größer-größer"]
        {
            assert!(matches!(wrong.parse::<WebToken>(), Err(NotAToken::Character { .. })), "{wrong}");
        }
        assert_eq!(format!("{:?}", TOKEN.parse::<WebToken>()), "Ok(WebToken)");
    }

    #[test]
    fn a_bearer_and_a_cookie_are_let_in_and_nothing_else_is() {
        let (access, now) = (access(), Instant::now());
        let judge = |headers: &HeaderMap| access.judge(headers, address(1), now);
        assert_eq!(judge(&HeaderMap::new()), Entry::NoToken);
        for (name, value) in [
            (header::AUTHORIZATION, format!("Bearer {TOKEN}")),
            (header::AUTHORIZATION, format!("bearer {TOKEN}")),
            (header::COOKIE, format!("other=1; encoring-8051={TOKEN}")),
        ] {
            assert_eq!(judge(&headers(name, &value)), Entry::Open, "{value}");
        }
        for (name, value, forget) in [
            (header::AUTHORIZATION, format!("Basic {TOKEN}"), false),
            (header::AUTHORIZATION, format!("Bearer {TOKEN}x"), false),
            (header::AUTHORIZATION, "Bearer".to_owned(), false),
            (header::COOKIE, "encoring-8051=".to_owned(), true),
        ] {
            assert_eq!(judge(&headers(name, &value)), Entry::WrongToken { forget }, "{value}");
        }
        assert_eq!(judge(&headers(header::COOKIE, &format!("encoring-8052={TOKEN}"))), Entry::NoToken);
        assert_eq!(Access::new(None, 1).judge(&HeaderMap::new(), address(1), now), Entry::Open);
    }

    #[test]
    fn after_ten_wrong_tokens_an_address_waits_also_with_the_right_one() {
        let (access, mut now) = (access(), Instant::now());
        for _ in 0..TRIES {
            let refused = access.enter("wrong", address(1), now).unwrap_err();
            assert_eq!(refused, Entry::WrongToken { forget: false });
        }
        for text in ["wrong", TOKEN] {
            let refused = access.enter(text, address(1), now).unwrap_err();
            assert_eq!(refused, Entry::TooMany { again_after: AGAIN_AFTER });
        }
        assert!(access.enter(TOKEN, address(2), now).is_ok(), "another address");
        now += AGAIN_AFTER;
        let cookie = access.enter(TOKEN, address(1), now).unwrap().unwrap();
        assert_eq!(cookie, format!("encoring-8051={TOKEN}; Path=/; HttpOnly; SameSite=Strict"));
        assert!(access.enter("wrong", address(1), now).is_err());
        assert!(matches!(access.enter(TOKEN, address(1), now), Err(Entry::TooMany { .. })));
    }

    #[test]
    fn many_addresses_are_no_way_round_and_cost_no_more_memory() {
        let (access, now) = (access(), Instant::now());
        let from = |k: u16| IpAddr::from([0x2001, k, 0, 0, 0, 0, 0, 1]);
        for k in 0..2_000 {
            assert!(access.enter("wrong", from(k), now).is_err());
        }
        assert_eq!(access.tries.wrong().len(), ADDRESSES_MAX);
        assert!(matches!(access.enter(TOKEN, from(3_000), now), Err(Entry::TooMany { .. })));
        assert!(access.enter(TOKEN, from(1), now).is_ok());
        assert!(access.enter(TOKEN, from(3_000), now + AGAIN_AFTER).is_ok(), "they are forgotten");
        // A network of the sixth version counts as one.
        let one = Tries::default();
        for k in 0..u16::try_from(TRIES).unwrap() {
            one.judge(IpAddr::from([1, 2, 3, 4, k, k, k, k]), now, || false, false);
        }
        let next = one.judge(IpAddr::from([1, 2, 3, 4, 9, 9, 9, 9]), now, || true, false);
        assert!(matches!(next, Entry::TooMany { .. }), "{next:?}");
    }
}
