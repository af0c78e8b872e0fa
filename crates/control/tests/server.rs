//! The port over real sockets.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use std::time::Duration as Real;

use common::Server;
use encoring_control::Options;
use encoring_control::unread::LINE_BYTES_MAX;
use serde_json::json;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufReader};

const VIEW: &str = r#"{"verb":"view"}"#;

#[tokio::test]
async fn answers_come_in_the_order_of_the_lines() {
    let server = Server::start(Options::default()).await;
    let lines: String =
        (0..500).map(|id| format!("{{\"id\":{id},\"verb\":\"line\",\"fault\":\"none\"}}\r\n")).collect();
    let answers = server.exchange(lines.as_bytes()).await;
    let expected: Vec<_> = (0..500).map(|id| json!({ "ok": true, "id": id })).collect();
    assert_eq!(answers, expected);
}

#[tokio::test]
async fn a_last_line_without_an_end_is_answered_too() {
    let server = Server::start(Options::default()).await;
    assert_eq!(server.exchange(VIEW.as_bytes()).await[0]["ok"], true);
}

#[tokio::test]
async fn a_line_in_pieces_is_one_line() {
    let server = Server::start(Options::default()).await;
    let mut peer = BufReader::new(server.connect().await);
    for byte in br#"{"verb":"set","position":1,"set":{"raw":5}}"# {
        peer.write_all(&[*byte]).await.unwrap();
        tokio::task::yield_now().await;
    }
    peer.write_all(b"\n").await.unwrap();
    let mut answer = String::new();
    peer.read_line(&mut answer).await.unwrap();
    assert_eq!(answer, "{\"ok\":true}\n");
}

#[tokio::test]
async fn the_longest_line_is_read_and_one_byte_more_ends_the_connection() {
    let server = Server::start(Options::default()).await;
    let filled = |bytes: usize| format!("{VIEW}{}\n{VIEW}\n", " ".repeat(bytes - VIEW.len()));
    let answers = server.exchange(filled(LINE_BYTES_MAX).as_bytes()).await;
    assert_eq!(answers.iter().map(|answer| &answer["ok"]).collect::<Vec<_>>(), [true, true]);
    let too_long =
        json!({ "ok": false, "error": "the line is longer than 65536 bytes; the connection is closed" });
    assert_eq!(server.exchange(filled(LINE_BYTES_MAX + 1).as_bytes()).await, std::slice::from_ref(&too_long));
    // Without an end it is noticed as well.
    assert_eq!(server.exchange(&vec![b'x'; 8 * LINE_BYTES_MAX]).await, [too_long]);
}

#[tokio::test]
async fn what_comes_after_the_last_answer_does_not_reset_the_connection_over_it() {
    let server = Server::start(Options::default()).await;
    let mut peer = server.connect().await;
    peer.write_all(b"GET / HTTP/1.1\n").await.unwrap();
    let mut answer = String::new();
    peer.read_to_string(&mut answer).await.unwrap();
    assert!(answer.ends_with("the connection is closed\"}\n"), "{answer}");
    for _ in 0..3 {
        peer.write_all(b"Host: 127.0.0.1\n").await.unwrap();
        tokio::task::yield_now().await;
    }
}

#[tokio::test]
async fn a_line_that_is_no_text_is_refused_and_the_next_one_answered() {
    let server = Server::start(Options::default()).await;
    let done = "{\"verb\":\"line\",\"fault\":\"none\"}\n".as_bytes();
    let answers = server.exchange(&[done, b"\xff\xfe\n", done, b"\x80"].concat()).await;
    let (refused, done) = (json!({ "ok": false, "error": "the line is not UTF-8" }), json!({ "ok": true }));
    assert_eq!(answers, [done.clone(), refused.clone(), done, refused]);
}

#[tokio::test]
async fn a_web_page_cannot_slip_a_line_in() {
    let server = Server::start(Options::default()).await;
    server.ring.done(r#"{"verb":"set","position":1,"set":{"raw":5}}"#);
    let post = "POST / HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: text/plain\r\n\r\n\
                {\"verb\":\"set\",\"position\":1,\"set\":{\"raw\":6}}\n";
    let error = "this is no HTTP server; the connection is closed";
    assert_eq!(server.exchange(post.as_bytes()).await, [json!({ "ok": false, "error": error })]);
    assert_eq!(server.ring.view()["devices"][1]["raw"], 5);
}

#[tokio::test]
async fn a_connection_whose_first_line_is_no_json_object_gets_one_answer_and_does_nothing() {
    let server = Server::start(Options::default()).await;
    server.ring.done(r#"{"verb":"set","position":1,"set":{"raw":5}}"#);
    // The head of a TLS record and of its hello; a page chooses the ticket in it.
    let hello = b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\xff ticket";
    for first in [
        &b"OPTIONS rtsp://127.0.0.1 RTSP/1.0"[..],
        hello,
        b"",
        b"help",
        b"[1]",
        b"\"{}\"",
        b"{\"verb\":",
        b"{} {}",
    ] {
        let sent = [first, b"\n{\"verb\":\"set\",\"position\":1,\"set\":{\"raw\":6}}\n"].concat();
        let answers = server.exchange(&sent).await;
        let error = r#"the first line is not a JSON object, which looks like {"verb":"help"}; the connection is closed"#;
        assert_eq!(answers, [json!({ "ok": false, "error": error })], "{}", String::from_utf8_lossy(first));
    }
    assert_eq!(server.ring.view()["devices"][1]["raw"], 5);
    // An object is one, whatever is in it.
    let answers = server.exchange(b" {\"verb\":\"hepl\"}\nhelp\n{\"verb\":\"help\"}\n").await;
    assert_eq!(answers.iter().map(|answer| &answer["ok"]).collect::<Vec<_>>(), [false, false, true]);
}

#[tokio::test]
async fn who_comes_on_top_of_the_limit_is_told_so_and_gets_in_when_another_has_left() {
    let server = Server::start(Options { connections: 2, ..Options::default() }).await;
    let (first, mut second) = (server.connect().await, BufReader::new(server.connect().await));
    // Once the second is answered, both are in.
    second.write_all(b"{\"verb\":\"help\"}\n").await.unwrap();
    second.read_line(&mut String::new()).await.unwrap();
    let error = "2 connections are open, which is the limit; the connection is closed";
    let full = [json!({ "ok": false, "error": error })];
    assert_eq!(server.exchange(VIEW.as_bytes()).await, full);
    drop(first);
    let mut answers = server.exchange(VIEW.as_bytes()).await;
    for _ in 0..1_000 {
        if answers != full {
            break;
        }
        answers = server.exchange(VIEW.as_bytes()).await;
    }
    assert_eq!(answers[0]["ok"], true);
}

#[tokio::test(start_paused = true)]
async fn a_silent_connection_is_closed_after_the_idle_time() {
    let idle = Real::from_secs(600);
    let server = Server::start(Options { idle, ..Options::default() }).await;
    let started = tokio::time::Instant::now();
    let mut peer = server.connect().await;
    // Half a line is silence too.
    peer.write_all(b"{\"verb\":").await.unwrap();
    let mut answers = Vec::new();
    peer.read_to_end(&mut answers).await.unwrap_or(0);
    assert_eq!(answers, b"");
    assert!(started.elapsed() >= idle);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn eight_peers_are_served_at_once() {
    let server = Server::start(Options::default()).await;
    let lines = format!("{VIEW}\n").repeat(20);
    let lines = lines.as_bytes();
    let all = tokio::join!(
        server.exchange(lines),
        server.exchange(lines),
        server.exchange(lines),
        server.exchange(lines),
        server.exchange(lines),
        server.exchange(lines),
        server.exchange(lines),
        server.exchange(lines)
    );
    for answers in [all.0, all.1, all.2, all.3, all.4, all.5, all.6, all.7] {
        assert_eq!(answers.len(), 20);
        let cycles: Vec<_> =
            answers.iter().map(|answer| answer["view"]["counters"]["cycles"].as_u64()).collect();
        assert!(cycles.is_sorted() && cycles[0].is_some());
    }
}

#[tokio::test]
async fn a_peer_that_takes_no_answers_holds_up_nobody() {
    let server = Server::start(Options::default()).await;
    let (_unread, mut greedy) = server.connect().await.into_split();
    let flood = tokio::spawn(async move {
        let lines = format!("{VIEW}\n").repeat(100);
        while greedy.write_all(lines.as_bytes()).await.is_ok() {}
    });
    for _ in 0..50 {
        assert_eq!(server.exchange(VIEW.as_bytes()).await[0]["ok"], true);
    }
    flood.abort();
}

#[tokio::test]
async fn a_server_that_is_stopped_closes_its_connections_and_leaves_the_ring_running() {
    let server = Server::start(Options::default()).await;
    let mut peer = server.connect().await;
    peer.write_all(b"{\"verb\":\"help\"}\n").await.unwrap();
    peer.read_u8().await.unwrap();
    let ring = server.stop().await;
    let mut rest = Vec::new();
    peer.read_to_end(&mut rest).await.unwrap();
    assert!(ring.cycles() > 0);
}

#[tokio::test]
async fn a_ring_that_has_stopped_leaves_the_port_answering() {
    let server = Server::start(Options::default()).await;
    let (address, ring) = (server.address, server.ring.station.handle().clone());
    let mut peer = BufReader::new(tokio::net::TcpStream::connect(address).await.unwrap());
    // The server outlives the ring: only its handle is left.
    let Server { ring: stopped, .. } = server;
    stopped.station.stop().unwrap();
    assert!(ring.view().is_err());
    for _ in 0..2 {
        let mut answer = String::new();
        peer.write_all(b"{\"verb\":\"view\"}\n").await.unwrap();
        peer.read_line(&mut answer).await.unwrap();
        assert_eq!(answer, "{\"ok\":false,\"error\":\"the ring has stopped\"}\n");
    }
}
