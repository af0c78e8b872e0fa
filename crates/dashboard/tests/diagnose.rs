//! A recording that is dropped on the page.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::time::Duration;

use common::{Page, described, description, free};
use encoring_dashboard::WebOptions;
use encoring_diagnosis::{Detector, Diagnosed, DiagnosisReport, Options, RecordedSamples, Unreadable};

/// A log in which one bit is wrong in one row.
fn log() -> String {
    let rows = (0..400_u32).map(|k| {
        let value = if k == 200 { (1_000 + 10 * k) ^ 1 << 20 } else { 1_000 + 10 * k };
        format!("{},{value:08X}\n", k * 1_000)
    });
    format!("time_us,in\n{}", rows.collect::<String>())
}

fn headers(page: &Page) -> String {
    format!("Host: {}\r\nContent-Type: application/octet-stream\r\n", page.address)
}

#[test]
fn the_report_is_that_of_the_library_which_the_command_prints() {
    let page = Page::start();
    let answer = page.send("POST /api/diagnose?name=axis.csv&model=ce-65-m", &headers(&page), &log());
    assert_eq!(answer.status, 200, "{}", answer.body);
    let whole = description();
    let schema =
        &whole["paths"]["/api/diagnose"]["post"]["responses"]["200"]["content"]["application/json"]["schema"];
    let found = answer.json();
    described(&found, schema, &whole, "/api/diagnose");
    assert_eq!(
        (&found["report"]["events"][0]["cause"], &found["report"]["events"][0]["line"]),
        (&"single_bit".into(), &202.into())
    );
    assert!(found["picture"].as_str().unwrap().starts_with("<svg"), "{}", found["picture"]);
    let log = log();
    let mut recorded = RecordedSamples::open("axis.csv", log.as_bytes(), None).unwrap();
    let model = Some(encoring_words::Model::Ce65M);
    let detector = |_: &RecordedSamples<&[u8]>| {
        Ok::<_, Unreadable>(Detector::new(Options { model, ..Options::default() }))
    };
    let diagnosed = Diagnosed::read(&mut recorded, None, detector, || true).unwrap();
    assert_eq!(found["report"], serde_json::to_value(DiagnosisReport::new(&[diagnosed])).unwrap());
}

#[test]
fn a_log_says_itself_which_encoder_it_is_of_and_a_table_what_its_columns_are() {
    let page = Page::start();
    let send =
        |query: &str, body: &str| page.send(&format!("POST /api/diagnose?{query}"), &headers(&page), body);
    let head = "# encoring-log 2 started 2026-11-28T01:22:00Z\n# encoder 2 ce-65-m measuring_length=9999\n";
    let rows = (0..300_u32).map(|k| format!("{},2,00000000,{:08X},valid,\n", k * 1_000, k * 40 % 10_000));
    let log = format!("{head}time_us,position,out,in,verdict,value\n{}", rows.collect::<String>());
    let found = send("name=axis.csv", &log);
    assert_eq!(found.status, 200, "{}", found.body);
    assert!(found.body.contains("position 2: 10000 positions, as given"), "{}", found.body);
    assert_eq!(found.json()["left_out"], serde_json::Value::Null);
    let cut = send("name=axis.csv", &format!("{log}300000,2,00000000,000003E8,valid,100")).json();
    assert_eq!((&cut["rows"], &cut["left_out"]), (&300.into(), &304.into()));
    let other = send("name=axis.csv&model=la-66", &log);
    assert_eq!(other.status, 400);
    assert!(other.body.contains("encoder 2 is a ce-65-m, not a la-66"), "{}", other.body);
    let table = "Zeit;Istwert\n0;20001000\n1;20001018\n2;20001029\n3;20001037\n";
    assert_eq!(send("name=plc.csv", table).status, 400);
    let found = send("name=plc.csv&columns=time_ms%3DZeit,in%3DIstwert", table).json();
    assert_eq!((&found["rows"], &found["may_be_decimal"]), (&4.into(), &true.into()));
    let found = send("name=plc.csv&columns=time_ms%3DZeit,in%3DIstwert&decimal=true", table).json();
    assert_eq!(found["may_be_decimal"], false);
    let wrong = send("columns=Zeit", table);
    assert_eq!(wrong.status, 400, "{}", wrong.body);
}

#[test]
fn what_is_no_recording_is_refused_with_its_place() {
    let page = Page::start();
    let send = |path: &str, body: &str| page.send(&format!("POST {path}"), &headers(&page), body);
    let wrong = send("/api/diagnose?name=axis.csv", "time_us,in\n0,00000001\n1,XYZ\n");
    assert_eq!(wrong.status, 400);
    assert!(wrong.body.contains("axis.csv line 3"), "{}", wrong.body);
    assert_eq!(send("/api/diagnose", "").status, 400);
    assert_eq!(send("/api/diagnose", "\u{0}\u{1}\u{2}").status, 400);
    assert_eq!(send("/api/diagnose?model=ce-66", &log()).status, 400);
    assert_eq!(send("/api/diagnose?other=1", &log()).status, 400);
    // As a form of another site can send it.
    let form = format!("Host: {}\r\nContent-Type: text/plain\r\n", page.address);
    assert_eq!(page.send("POST /api/diagnose", &form, &log()).status, 415);
    assert_eq!(page.send("POST /api/command", &headers(&page), r#"{"verb":"help"}"#).status, 415);
    assert_eq!(page.get("/healthz").status, 200);
}

#[test]
fn a_recording_that_is_too_long_ends_at_the_limit_and_one_that_stops_ends_in_time() {
    let page = Page::with(&WebOptions { slow: Duration::from_millis(100), ..free() });
    let mut stream = TcpStream::connect(page.address).unwrap();
    let head =
        format!("POST /api/diagnose HTTP/1.1\r\n{}Content-Length: 900\r\n\r\ntime_us,in\n", headers(&page));
    stream.write_all(head.as_bytes()).unwrap();
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).unwrap();
    assert!(line.starts_with("HTTP/1.1 408"), "{line}");
    let page = Page::start();
    let mut stream = TcpStream::connect(page.address).unwrap();
    let head = format!("POST /api/diagnose HTTP/1.1\r\n{}Content-Length: 200000000\r\n\r\n", headers(&page));
    stream.write_all(head.as_bytes()).unwrap();
    // Comments, which cost nothing to read; the server closes behind the limit.
    let piece = format!("#{}\n", "x".repeat(998)).repeat(1_000);
    while stream.write_all(piece.as_bytes()).is_ok() {}
    assert_eq!(page.get("/healthz").status, 200);
}

#[test]
fn one_recording_is_read_at_a_time() {
    let page = Page::start();
    let mut first = TcpStream::connect(page.address).unwrap();
    let head =
        format!("POST /api/diagnose HTTP/1.1\r\n{}Content-Length: 900\r\n\r\ntime_us,in\n", headers(&page));
    first.write_all(head.as_bytes()).unwrap();
    let second = || page.send("POST /api/diagnose", &headers(&page), &log()).status;
    // Until the first has arrived, and from then on until it is gone.
    while second() != 503 {}
    drop(first);
    while second() != 200 {}
}
