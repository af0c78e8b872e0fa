//! The page's server over real sockets: what it serves, what it refuses, and what it costs the ring.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use common::{Page, described, description, free};
use encoring_dashboard::WebOptions;
use serde_json::{Value, json};

#[test]
fn every_answer_is_as_the_description_says() {
    let page = Page::start();
    let whole = description();
    page.command(&json!({ "verb": "set", "position": 2, "set": { "ssi": { "khz": 500, "clocks": 25, "every_ms": 10 } } }));
    page.command(&json!({ "verb": "line", "segment": 1, "fault": "bad" }));
    page.command(&json!({ "verb": "service", "position": 1, "service": 2 }));
    // Data and service bit at once, which no program may do.
    page.command(&json!({ "verb": "out", "position": 2, "word": "C200270F" }));
    while page.get("/api/state").json()["ring"]["referee"]["findings"][0].is_null() {}
    for path in ["/api/state", "/api/units", "/api/about", "/api/history?position=1", "/api/happened?from=0"]
    {
        let answer = page.get(path);
        assert_eq!(answer.status, 200, "{path}: {}", answer.body);
        let plain = path.split('?').next().unwrap();
        let schema =
            &whole["paths"][plain]["get"]["responses"]["200"]["content"]["application/json"]["schema"];
        described(&answer.json(), schema, &whole, path);
    }
    let refusal = &whole["components"]["schemas"]["Refusal"];
    for path in
        ["/api/history?position=3", "/api/history", "/api/happened?from=x", "/api/history?position=0&to=1"]
    {
        let answer = page.get(path);
        assert!(matches!(answer.status, 400 | 404), "{path}: {}", answer.body);
        described(&answer.json(), refusal, &whole, path);
    }
    let verbs = &whole["paths"]["/api/command"]["post"]["requestBody"]["content"]["application/json"]["schema"]
        ["properties"]["verb"]["enum"];
    let help = page.command(&json!({ "verb": "help" })).json();
    let mut names: Vec<&Value> = help["verbs"].as_array().unwrap().iter().map(|verb| &verb["verb"]).collect();
    // That of a ring behind a bus.
    let acknowledge = json!("acknowledge");
    names.insert(names.len() - 2, &acknowledge);
    assert_eq!(&json!(names), verbs);
}

#[test]
fn the_verbs_are_those_of_the_control_port() {
    let page = Page::start();
    let done = page.command(&json!({ "verb": "set", "position": 1, "set": { "raw": 1234 }, "id": 7 }));
    assert_eq!((done.status, done.body.as_str()), (200, r#"{"ok":true,"id":7}"#));
    while page.get("/api/state").json()["ring"]["devices"]["1"]["value"] != 1234 {}
    let refused = page.command(&json!({ "verb": "set", "position": 3, "set": {} }));
    assert_eq!((refused.status, refused.json()["ok"].clone()), (400, json!(false)));
    assert_eq!(refused.json()["error"], "position 3; the encoders are at 0 to 2");
}

#[test]
fn a_burst_of_1000_services_leaves_5000_steps_in_the_pages_history() {
    // [R31..R40]
    let page = Page::start();
    for k in 0..1_000 {
        let verb = json!({ "verb": "service", "position": 1, "service": 2, "value": 1_000 + k }).to_string();
        let answer = encoring_station::answer::answer(&verb, &page.controlled);
        assert!(answer.starts_with(r#"{"ok":true"#), "{answer}");
    }
    let (mut from, mut steps) = (0, Vec::new());
    loop {
        let part = page.get(&format!("/api/history?position=1&from={from}")).json();
        assert_eq!(part["missed"], 0);
        let changes = part["changes"].as_array().unwrap();
        let both = changes.iter().flat_map(|change| [&change["out_step"], &change["in_step"]]);
        steps.extend(both.filter_map(Value::as_u64));
        if changes.is_empty() {
            break;
        }
        from = part["next"].as_u64().unwrap();
    }
    assert_eq!(steps.len(), 5_000);
    assert!(steps.chunks(5).all(|service| service == [1, 2, 3, 4, 5]));
}

#[test]
fn the_page_comes_whole_with_a_policy_and_names_no_other_place() {
    let page = Page::start();
    for path in ["/", "/style.css", "/js/main.js", "/texts/en.json", "/texts/de.json", "/api/openapi.json"] {
        let answer = page.get(path);
        assert_eq!(answer.status, 200, "{path}");
        assert!(
            answer.head.contains("content-security-policy: default-src 'none'; script-src 'self'"),
            "{path}"
        );
        assert!(answer.head.contains("x-content-type-options: nosniff"), "{path}");
        assert!(!answer.head.contains("unsafe-inline") && !answer.head.contains("access-control"), "{path}");
        let foreign = answer.body.replace("http://www.w3.org/2000/svg", "");
        assert!(!foreign.contains("http://") && !foreign.contains("https://"), "{path}");
    }
    let missing = page.get("/nothing");
    assert_eq!(missing.status, 404);
    assert!(missing.head.contains("content-security-policy"));
}

#[test]
fn what_comes_from_elsewhere_is_refused_and_changes_nothing() {
    let page = Page::start();
    let here = page.address;
    let verb = r#"{"verb":"out","position":1,"word":"C200270F"}"#;
    let json = "Content-Type: application/json\r\n";
    for (headers, status) in [
        // A name of another site that leads here.
        (format!("Host: evil.example\r\n{json}"), 421),
        (format!("Host: evil.example:{}\r\nOrigin: http://evil.example:{0}\r\n{json}", here.port()), 421),
        (format!("Host: 127.0.0.1.evil.example\r\n{json}"), 421),
        (format!("Host: {here}\r\nHost: evil.example\r\n{json}"), 421),
        (json.to_owned(), 421),
        // A page of another site.
        (format!("Host: {here}\r\nOrigin: http://evil.example\r\n{json}"), 403),
        (format!("Host: {here}\r\nOrigin: null\r\n{json}"), 403),
        (format!("Host: {here}\r\nOrigin: https://{here}\r\n{json}"), 403),
        (format!("Host: {here}\r\nOrigin: http://127.0.0.1:1\r\n{json}"), 403),
        (format!("Host: {here}\r\nSec-Fetch-Site: cross-site\r\n{json}"), 403),
        (format!("Host: {here}\r\nSec-Fetch-Site: same-site\r\n{json}"), 403),
        // A form.
        (format!("Host: {here}\r\nContent-Type: text/plain\r\n"), 415),
        (format!("Host: {here}\r\n"), 415),
    ] {
        assert_eq!(page.send("POST /api/command", &headers, verb).status, status, "{headers}");
    }
    let host = format!("Host: {here}\r\n{json}");
    assert_eq!(page.send("POST http://evil.example/api/command", &host, verb).status, 421);
    for (method, status) in [("GET", 405), ("PUT", 405), ("DELETE", 405), ("OPTIONS", 405), ("TRACE", 405)] {
        assert_eq!(page.send(&format!("{method} /api/command"), &host, verb).status, status, "{method}");
    }
    for path in ["/api/state", "/metrics", "/js/main.js"] {
        let foreign = format!("Host: {here}\r\nSec-Fetch-Site: cross-site\r\n");
        assert_eq!(page.send(&format!("GET {path}"), &foreign, "").status, 403, "{path}");
    }
    let followed = format!("Host: {here}\r\nSec-Fetch-Site: cross-site\r\n");
    assert_eq!(page.send("GET /", &followed, "").status, 200, "a link leads here");
    assert_eq!(page.controlled.ring.history().counts(), [0, 0, 0]);
    for name in ["localhost", "127.0.0.1", "[::1]", "LOCALHOST"] {
        let named = format!("Host: {name}:{}\r\n", here.port());
        assert_eq!(page.send("GET /healthz", &named, "").status, 200, "{name}");
    }
}

#[test]
fn what_is_too_long_or_no_request_is_refused_and_the_page_goes_on() {
    let page = Page::start();
    let host = format!("Host: {}\r\nContent-Type: application/json\r\n", page.address);
    let long = "x".repeat(70_000);
    assert_eq!(page.send("POST /api/command", &host, &long).status, 413);
    for body in
        ["", "null", "[]", "{", "{\"verb\":\"out\"}", "\u{0}", "{\"verb\":\"out\",\"position\":1e999}"]
    {
        assert_eq!(page.send("POST /api/command", &host, body).status, 400, "{body:?}");
    }
    let utf8 = [
        format!("POST /api/command HTTP/1.1\r\n{host}Content-Length: 2\r\nConnection: close\r\n\r\n")
            .into_bytes(),
        vec![0xFF, 0xFE],
    ]
    .concat();
    assert!(page.raw(&utf8).starts_with("HTTP/1.1 400"));
    for bytes in [
        format!("GET /{long} HTTP/1.1\r\n{host}\r\n").into_bytes(),
        format!("GET / HTTP/1.1\r\n{host}X: {long}\r\n\r\n").into_bytes(),
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc".to_vec(),
        b"GET / HTTP/9.9\r\n\r\n".to_vec(),
        b"\r\n\r\n\r\n\r\nGET\r\n\r\n".to_vec(),
        format!("POST /api/command HTTP/1.1\r\n{host}Content-Length: -1\r\n\r\n").into_bytes(),
        format!("POST /api/command HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n\r\nzz\r\n").into_bytes(),
    ] {
        let said = page.raw(&bytes);
        assert!(said.is_empty() || said.starts_with("HTTP/1.1 4"), "{said}");
    }
    assert_eq!(page.controlled.ring.history().counts(), [0, 0, 0]);
    assert_eq!(page.get("/healthz").body, "ok\n");
}

#[test]
fn who_is_slow_is_closed() {
    let options = WebOptions { slow: Duration::from_millis(100), ..free() };
    let page = Page::with(&options);
    // It ends only when the other side closes.
    let head = page.raw(b"GET / HTTP/1.1\r\nHost: 127");
    assert!(head.is_empty() || head.starts_with("HTTP/1.1 408"), "{head}");
    let json = format!("Host: {}\r\nContent-Type: application/json\r\n", page.address);
    let body = page.raw(
        format!("POST /api/command HTTP/1.1\r\n{json}Content-Length: 9\r\nConnection: close\r\n\r\n{{")
            .as_bytes(),
    );
    assert!(body.starts_with("HTTP/1.1 408"), "{body}");
}

/// The next event of a stream: its name and its data.
fn event(lines: &mut impl BufRead) -> (String, Value) {
    let mut name = String::new();
    loop {
        let mut line = String::new();
        assert_ne!(lines.read_line(&mut line).unwrap(), 0, "the stream has ended");
        if let Some(event) = line.strip_prefix("event: ") {
            name = event.trim().to_owned();
        }
        if let Some(data) = line.strip_prefix("data: ") {
            return (name, serde_json::from_str(data.trim()).unwrap());
        }
    }
}

#[test]
fn a_stream_begins_whole_and_goes_on_with_what_changes() {
    let page = Page::start();
    let mut stream = TcpStream::connect(page.address).unwrap();
    stream
        .write_all(format!("GET /api/events HTTP/1.1\r\nHost: {}\r\n\r\n", page.address).as_bytes())
        .unwrap();
    let mut lines = BufReader::new(stream);
    let (name, state) = event(&mut lines);
    assert_eq!(name, "state");
    assert_eq!(state["ring"]["devices"]["0"]["model"], "la-66");
    let before = state["ring"]["counters"]["cycles"].as_u64().unwrap();
    let (name, patch) = loop {
        // Whoever missed a frame on a loaded machine gets it whole.
        let next = event(&mut lines);
        if next.0 == "patch" {
            break next;
        }
    };
    assert_eq!(name, "patch");
    assert!(patch["ring"]["counters"]["cycles"].as_u64().unwrap() > before);
    assert_eq!(patch["ring"]["devices"]["0"]["model"], Value::Null, "what stays is not sent again");
}

#[test]
fn two_hundred_streams_that_nobody_reads_hold_nothing_up() {
    let page = Page::start();
    let request = format!("GET /api/events HTTP/1.1\r\nHost: {}\r\n\r\n", page.address);
    let streams: Vec<TcpStream> = (0..200)
        .map(|_| {
            let mut stream = TcpStream::connect(page.address).unwrap();
            stream.write_all(request.as_bytes()).unwrap();
            stream
        })
        .collect();
    let open = |page: &Page| page.get("/metrics").body.contains("\nencoring_page_streams 200\n");
    while !open(&page) {}
    let cycles = || page.controlled.ring.view().unwrap().counters.cycles;
    let before = cycles();
    while cycles() < before + 10_000 {}
    assert_eq!(page.get("/healthz").body, "ok\n");
    drop(page.served);
    drop(streams);
}

#[test]
fn the_metrics_are_those_of_the_ring() {
    let page = Page::start();
    let text = page.get("/metrics").body;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (name, value) = line.rsplit_once(' ').unwrap();
        assert!(name.starts_with("encoring_") && value.parse::<u64>().is_ok(), "{line}");
    }
    assert!(text.contains("# TYPE encoring_cycles_total counter\n"), "{text}");
    assert!(text.contains("encoring_encoder_on{position=\"2\",model=\"ce-65-m\"} 1\n"), "{text}");
}

#[test]
fn a_connection_too_many_is_closed_and_the_others_stay() {
    let page = Page::with(&WebOptions { connections: 1, ..WebOptions::default() });
    let mut held = TcpStream::connect(page.address).unwrap();
    held.write_all(format!("GET /healthz HTTP/1.1\r\nHost: {}\r\n\r\n", page.address).as_bytes()).unwrap();
    let mut one = [0; 12];
    held.read_exact(&mut one).unwrap();
    assert_eq!(&one, b"HTTP/1.1 200");
    assert_eq!(page.raw(b"GET / HTTP/1.1\r\n\r\n"), "");
    held.write_all(format!("GET /healthz HTTP/1.1\r\nHost: {}\r\n\r\n", page.address).as_bytes()).unwrap();
    held.read_exact(&mut one).unwrap();
}
