//! Who is let in, and what may be done: the token, the cookie, and a page that only shows.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use common::{Page, described, description, free};
use encoring_dashboard::WebOptions;
use encoring_station::Permission;
use serde_json::json;

const TOKEN: &str = "a-token-of-a-test-1234";

fn with_token() -> Page {
    Page::with(&WebOptions { token: Some(TOKEN.parse().unwrap()), ..free() })
}

fn host(page: &Page) -> String {
    format!("Host: {}\r\n", page.address)
}

/// What the form of the page sends.
fn login(page: &Page, token: &str) -> common::Answer {
    let headers = format!("{}Content-Type: application/json\r\n", host(page));
    page.send("POST /api/login", &headers, &json!({ "token": token }).to_string())
}

#[test]
fn without_the_token_only_the_files_of_the_page_are_sent() {
    let page = with_token();
    for path in ["/", "/js/main.js", "/texts/de.json", "/api/openapi.json", "/healthz"] {
        assert_eq!(page.get(path).status, 200, "{path}");
    }
    let refusal = &description()["components"]["schemas"]["Refusal"];
    for path in [
        "/api/state",
        "/api/units",
        "/api/about",
        "/api/history?position=0",
        "/api/happened",
        "/api/events",
        "/metrics",
    ] {
        let answer = page.get(path);
        assert_eq!(answer.status, 401, "{path}");
        assert!(answer.head.contains("www-authenticate: bearer"), "{}", answer.head);
        described(&answer.json(), refusal, &description(), path);
    }
    assert_eq!(page.command(&json!({ "verb": "out", "position": 1, "word": "4200270F" })).status, 401);
    assert_eq!(page.controlled.ring.history().counts(), [0, 0, 0]);
}

#[test]
fn the_form_gives_a_cookie_that_no_script_reads_and_no_other_site_sends() {
    let page = with_token();
    let wrong = login(&page, "another-token-of-a-test");
    assert_eq!((wrong.status, wrong.head.contains("set-cookie")), (401, false));
    let right = login(&page, TOKEN);
    assert_eq!((right.status, right.body.as_str()), (200, r#"{"ok":true}"#));
    let cookie = right.head.lines().find_map(|line| line.strip_prefix("set-cookie: ")).unwrap();
    assert!(cookie.ends_with("; path=/; httponly; samesite=strict"), "{cookie}");
    let pair = format!("encoring-{}={TOKEN}", page.address.port());
    assert!(cookie.starts_with(&pair), "{cookie}");
    let state = page.send("GET /api/state", &format!("{}Cookie: {pair}\r\n", host(&page)), "");
    assert_eq!(state.status, 200);
    let stale = format!("{}Cookie: {pair}x\r\n", host(&page));
    let refused = page.send("GET /api/state", &stale, "");
    assert_eq!(refused.status, 401);
    assert!(refused.head.contains("max-age=0"), "{}", refused.head);
}

#[test]
fn a_script_names_a_bearer_and_a_token_in_an_address_is_none() {
    let page = with_token();
    let bearer = format!("{}Authorization: Bearer {TOKEN}\r\n", host(&page));
    assert_eq!(page.send("GET /metrics", &bearer, "").status, 200);
    let json = format!("{bearer}Content-Type: application/json\r\n");
    let help = page.send("POST /api/command", &json, r#"{"verb":"help"}"#);
    assert_eq!(help.status, 200);
    for path in [format!("/api/about?token={TOKEN}"), format!("/api/about?access_token={TOKEN}")] {
        assert_eq!(page.get(&path).status, 401, "{path}");
    }
    // The token makes nothing good of what comes from elsewhere.
    let foreign = format!("Host: evil.example\r\nAuthorization: Bearer {TOKEN}\r\n");
    assert_eq!(page.send("GET /api/state", &foreign, "").status, 421);
    let foreign = format!("{json}Origin: http://evil.example\r\n");
    assert_eq!(page.send("POST /api/command", &foreign, r#"{"verb":"help"}"#).status, 403);
}

#[test]
fn wrong_tokens_are_answered_more_and_more_rarely() {
    let page = with_token();
    let first: Vec<u16> = (0..10).map(|k| login(&page, &format!("wrong-token-number-{k}")).status).collect();
    assert_eq!(first, [401; 10]);
    // Every 6 s one more is looked at; nobody is so slow for ever. The right one waits too.
    let next = (0..1_000)
        .map(|_| login(&page, "wrong-token-once-more"))
        .find(|answer| answer.status == 429)
        .unwrap();
    assert!(next.head.contains("retry-after: "), "{}", next.head);
}

#[test]
fn a_login_that_is_none_is_refused_and_a_page_without_a_token_takes_any() {
    let page = with_token();
    let headers = format!("{}Content-Type: application/json\r\n", host(&page));
    for body in ["", "null", "{}", r#"{"token":1}"#, r#"{"token":"x","more":1}"#] {
        assert_eq!(page.send("POST /api/login", &headers, body).status, 400, "{body}");
    }
    assert_eq!(page.send("POST /api/login", &host(&page), "token=x").status, 415, "a form of another page");
    let free = Page::start();
    let answer = login(&free, "anything");
    assert_eq!((answer.status, answer.head.contains("set-cookie")), (200, false));
}

#[test]
fn a_page_that_only_shows_refuses_what_changes_something() {
    let page = Page::with(&WebOptions { permission: Permission::Look, ..free() });
    assert_eq!(page.get("/api/about").json()["may_change"], false);
    for verb in [
        json!({ "verb": "set", "position": 1, "set": { "supply_v": 0 } }),
        json!({ "verb": "out", "position": 1, "word": "C200270F" }),
        json!({ "verb": "service", "position": 1, "service": 2 }),
        json!({ "verb": "line", "segment": 0, "fault": "silent" }),
        json!({ "verb": "line", "fault": "none" }),
        json!({ "verb": "gateway", "fault": "silent" }),
    ] {
        let refused = page.command(&verb);
        assert_eq!(refused.status, 403, "{verb}: {}", refused.body);
        assert!(refused.body.contains("--allow-control"), "{}", refused.body);
    }
    for verb in ["view", "help"] {
        assert_eq!(page.command(&json!({ "verb": verb })).status, 200, "{verb}");
    }
    assert_eq!(page.controlled.ring.history().counts(), [0, 0, 0]);
    assert!(page.controlled.ring.view().unwrap().devices[1].on);
}
