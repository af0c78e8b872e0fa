//! `encoring serve` as its users run it: in front of a gateway, with faults and without, and what it refuses.
#![allow(clippy::disallowed_methods, reason = "a test reads what was printed")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    missing_docs,
    reason = "a test may panic"
)]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread;

use serde_json::{Value, json};

const PROGRAM: &str = env!("CARGO_BIN_EXE_encoring");
const TOKEN: &str = "a-token-of-a-test-1234";

/// A time-out is long for a loaded machine, and short for whoever waits for one.
const OPTIONS: &str = "timeout_ms=300&status=holding:900&parameter=holding:901";

/// A program that runs on until the test ends.
struct Running {
    program: Child,
    lines: BufReader<ChildStdout>,
    listening: Value,
}

impl Running {
    fn start(arguments: &[&str]) -> Self {
        let mut command = Command::new(PROGRAM);
        command.args(arguments).args(["--format", "json"]).stderr(Stdio::null());
        let (program, lines, listening) = common::listening(&mut command);
        Self { program, lines, listening }
    }

    /// A simulated ring behind a gateway.
    fn gateway() -> Self {
        Self::start(&["sim", "--web", "off", "--modbus", "0", "--control", "0"])
    }

    /// The page of that ring.
    fn page_of(gateway: &Self, more: &[&str]) -> Self {
        let address = gateway.listening["modbus"].as_str().unwrap();
        Self::page_over(&format!("modbus-tcp://{address}?{OPTIONS}"), more)
    }

    /// The same, reached as it is said.
    fn page_over(bus: &str, more: &[&str]) -> Self {
        let at = ["serve", "--web", "0", "--bus", bus, "--at", "0-2", "--model", "la-66,ce-100-m,ce-65-m"];
        Self::start(&[&at, more].concat())
    }

    fn ask(&self, line: &str, headers: &str, body: &str) -> (u16, Value) {
        let address = self.listening["web"].as_str().unwrap();
        let mut stream = TcpStream::connect(address).unwrap();
        let length = body.len();
        let request = format!(
            "{line} HTTP/1.1\r\nHost: {address}\r\nContent-Type: application/json\r\n{headers}Content-Length: {length}\r\n\
             Connection: close\r\n\r\n{body}"
        );
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        let status = head.split(' ').nth(1).unwrap().parse().unwrap();
        (status, serde_json::from_str(body).unwrap_or_default())
    }

    fn state(&self) -> Value {
        let (status, state) = self.ask("GET /api/state", "", "");
        assert_eq!(status, 200);
        state["ring"].clone()
    }

    /// The ring, as soon as it is so.
    fn once(&self, is: impl Fn(&Value) -> bool) -> Value {
        loop {
            let ring = self.state();
            if is(&ring) {
                return ring;
            }
        }
    }

    fn command(&self, verb: &Value) -> (u16, Value) {
        self.ask("POST /api/command", "", &verb.to_string())
    }

    /// What the control port of a gateway answers.
    fn tell(&self, verb: &Value) -> Value {
        let mut control = TcpStream::connect(self.listening["control"].as_str().unwrap()).unwrap();
        writeln!(control, "{verb}").unwrap();
        let mut answer = String::new();
        BufReader::new(control).read_line(&mut answer).unwrap();
        serde_json::from_str(&answer).unwrap()
    }

    /// The next event of that name.
    fn event(&mut self, name: &str) -> Value {
        loop {
            let mut line = String::new();
            assert_ne!(self.lines.read_line(&mut line).unwrap(), 0, "no event {name}");
            let event: Value = serde_json::from_str(&line).unwrap();
            if event["event"] == name {
                return event;
            }
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

/// What a refused call says; it ends with 2.
fn refused(arguments: &[&str]) -> String {
    let output = Command::new(PROGRAM).args(arguments).output().unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    assert_eq!(output.stdout, b"", "{arguments:?}");
    String::from_utf8(output.stderr).unwrap()
}

/// A file with the token, and the folder that it goes with.
fn token_file() -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("token");
    std::fs::write(&file, format!("{TOKEN}\n")).unwrap();
    let name = file.to_str().unwrap().to_owned();
    (folder, name)
}

#[test]
fn the_page_shows_what_the_gateway_shows_and_writes_nothing() {
    let gateway = Running::gateway();
    gateway.tell(&json!({ "verb": "set", "position": 2, "set": { "raw": 1234 } }));
    let page = Running::page_of(&gateway, &[]);
    assert_eq!(page.listening["may_change"], false);
    let ring = page.once(|ring| ring["devices"]["2"]["value"] == 1234);
    assert_eq!((ring["line"].clone(), ring["link"]["up"].clone()), (json!("good"), json!(true)));
    assert_eq!(ring["diagnosis"]["parameter"], "0000");
    for verb in [
        json!({ "verb": "out", "position": 1, "word": "C200270F" }),
        json!({ "verb": "service", "position": 1, "service": 2, "value": 9999 }),
    ] {
        assert_eq!(page.command(&verb).0, 403, "{verb}");
    }
    assert_eq!(page.command(&json!({ "verb": "line", "segment": 1, "fault": "silent" })).0, 400);
    let view = gateway.tell(&json!({ "verb": "view" }))["view"].clone();
    for device in view["devices"].as_array().unwrap() {
        assert_eq!(device["out"], "00000000");
    }
    assert_eq!(view["line"], "good");
}

#[test]
fn with_allow_control_a_service_goes_through_and_its_steps_are_in_the_history() {
    // [R31..R40]
    let gateway = Running::gateway();
    let page = Running::page_of(&gateway, &["--allow-control"]);
    assert_eq!(page.listening["may_change"], true);
    let (status, answer) =
        page.command(&json!({ "verb": "service", "position": 1, "service": 2, "value": 9999 }));
    assert_eq!((status, &answer["reply"]["data"]), (200, &json!(9999)), "{answer}");
    let view = gateway.tell(&json!({ "verb": "view" }))["view"].clone();
    let parameters = view["devices"][1]["parameters"].as_array().unwrap();
    let length = parameters.iter().find(|parameter| parameter["service"] == 2).unwrap();
    assert_eq!(length["programmed"], 9999);
    let (_, history) = page.ask("GET /api/history?position=1", "", "");
    let changes = history["changes"].as_array().unwrap();
    // What no poll has seen is told, so none of the steps is without a trace.
    for step in 2..=4 {
        let seen = |change: &Value| {
            change["out_step"] == step
                || change["in_step"] == step
                || change["unseen"].as_array().unwrap().contains(&json!(step))
        };
        assert!(changes.iter().any(seen), "{step}: {history}");
    }
}

#[test]
fn a_gateway_that_fails_is_told_as_such_and_the_page_goes_on_when_it_is_back() {
    let gateway = Running::gateway();
    let mut page = Running::page_of(&gateway, &[]);
    page.once(|ring| ring["devices"]["0"]["value"].is_u64());
    gateway.tell(&json!({ "verb": "gateway", "fault": "silent" }));
    let ring = page.once(|ring| ring["devices"]["0"]["verdict"].as_str().unwrap().starts_with("no_answer"));
    assert!(ring["devices"]["0"]["value"].is_null(), "an old position is none: {ring}");
    assert!(ring["devices"]["0"]["text"].is_string());
    gateway.tell(&json!({ "verb": "gateway", "end": "all" }));
    page.once(|ring| ring["devices"]["0"]["value"].is_u64() && ring["line"] == "good");
    // A ring that stands still is another thing than a gateway that is gone.
    gateway.tell(&json!({ "verb": "line", "segment": 0, "fault": "silent" }));
    page.event("ring_stands");
    page.once(|ring| ring["devices"]["2"]["verdict"] == "ring_stopped" && ring["line"] == "silent");
    drop(gateway);
    page.once(|ring| ring["link"]["up"] == false && ring["link"]["cause"] == "no_answer_no_connection");
    page.event("link_failed");
}

#[test]
fn a_gateway_that_exchanges_halves_is_told_as_such_and_nobody_is_blamed() {
    let gateway = Running::gateway();
    gateway.tell(&json!({ "verb": "set", "position": 2, "set": { "raw": 1234 } }));
    let address = gateway.listening["modbus"].as_str().unwrap();
    let page = Running::page_over(
        &format!("modbus-tcp://{address}?order=low-first&{OPTIONS}"),
        &["--allow-control"],
    );
    let ring = page.once(|ring| ring["devices"]["2"]["in"] == "04D20000");
    let device = &ring["devices"]["2"];
    assert_eq!((&device["verdict"], &device["misread"]), (&json!("implausible_bits"), &json!("halves")));
    assert!(device["value"].is_null());
    let (status, answer) = page.command(&json!({ "verb": "service", "position": 2, "service": 2 }));
    assert_eq!(status, 400);
    assert!(answer["error"].as_str().unwrap().contains("halves exchanged"), "{answer}");
    // A position whose lower half is an error bit, for longer than an ignored error is borne.
    gateway.tell(&json!({ "verb": "set", "position": 2, "set": { "raw": 0x2000 } }));
    let faulty = page.once(|ring| ring["devices"]["2"]["verdict"] == "faulty");
    assert_eq!(faulty["devices"]["2"]["misread"], "halves");
    let polls = faulty["polls"].as_u64().unwrap();
    let later = page.once(|ring| ring["polls"].as_u64() > Some(polls + 150));
    let blamed = |finding: &Value| finding["position"] == 2;
    assert!(!later["referee"]["findings"].as_array().unwrap().iter().any(blamed), "{later}");
    let known = later["devices"]["2"]["parameters"].as_array().unwrap();
    assert!(known.iter().all(|known| known["programmed"].is_null()), "{known:?}");
}

/// Passes Modbus RTU on a TCP connection on to a server of Modbus TCP, frame by frame.
fn rtu_before(server: String) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        for client in listener.incoming() {
            // Whoever has gone, on either side, is served no more.
            let Ok(server) = TcpStream::connect(&server) else { continue };
            let _ = passed_on(client.unwrap(), server);
        }
    });
    address
}

fn passed_on(mut client: TcpStream, mut server: TcpStream) -> std::io::Result<()> {
    loop {
        let mut frame = vec![0; 8];
        client.read_exact(&mut frame)?;
        if frame[1] == 16 {
            // What is written, and the two bytes of the check sum that the first eight had no room for.
            let more = usize::from(frame[6]) + 1;
            frame.resize(8 + more, 0);
            client.read_exact(&mut frame[8..])?;
        }
        frame.truncate(frame.len() - 2);
        let mut request = vec![0, 1, 0, 0, 0, frame.len() as u8];
        request.extend(frame);
        server.write_all(&request)?;
        let mut head = [0; 6];
        server.read_exact(&mut head)?;
        let mut answer = vec![0; usize::from(u16::from_be_bytes([head[4], head[5]]))];
        server.read_exact(&mut answer)?;
        let sum = answer.iter().fold(0xFFFF_u16, |sum, byte| {
            (0..8).fold(sum ^ u16::from(*byte), |sum, _| (sum >> 1) ^ if sum & 1 == 1 { 0xA001 } else { 0 })
        });
        answer.extend(sum.to_le_bytes());
        client.write_all(&answer)?;
    }
}

#[test]
fn a_ring_behind_modbus_rtu_over_tcp_is_shown_read_and_missed() {
    let gateway = Running::gateway();
    gateway.tell(&json!({ "verb": "set", "position": 2, "set": { "raw": 1234 } }));
    let rtu = rtu_before(gateway.listening["modbus"].as_str().unwrap().to_owned());
    let mut page = Running::page_over(&format!("modbus-rtu-tcp://{rtu}?{OPTIONS}"), &["--allow-control"]);
    let ring = page.once(|ring| ring["devices"]["2"]["value"] == 1234 && ring["line"] == "good");
    assert_eq!(ring["devices"]["2"]["misread"], Value::Null);
    let (status, answer) = page.command(&json!({ "verb": "service", "position": 1, "service": 2 }));
    assert_eq!((status, &answer["reply"]["error"]), (200, &json!(false)), "{answer}");
    let read = &answer["reply"]["data"];
    page.once(|ring| ring["devices"]["1"]["parameters"][1]["programmed"]["value"] == *read);
    drop(gateway);
    page.event("link_down");
    // The link is told as soon as it ends, the words with the next poll.
    page.once(|ring| ring["link"]["up"] == false && ring["devices"]["2"]["value"].is_null());
}

#[test]
fn what_others_could_reach_needs_a_token_and_a_token_stands_in_a_file() {
    let bus = ["serve", "--bus", "sim"];
    let call = |more: &[&'static str]| refused(&[&bus, more].concat());
    assert!(call(&["--web", "0.0.0.0:0"]).contains("--web-token-file FILE"));
    assert!(refused(&["sim", "--modbus", "off", "--web", "0.0.0.0:0"]).contains("--web-token-file FILE"));
    assert!(
        call(&["--web", "0", "--web-token-file", "no-such-file"]).contains("--web-token-file no-such-file: ")
    );
    assert!(call(&["--web", "off"]).contains("nothing to serve"));
    assert!(call(&["--web", "0", "--allow-control", "--read-only"]).contains("leave one out"));
    assert!(call(&["--web", "0", "--web-token", TOKEN]).contains("unexpected argument"));
    let taken = Running::start(&["serve", "--bus", "sim", "--web", "0"]);
    let address = taken.listening["web"].as_str().unwrap();
    let said = refused(&["serve", "--bus", "sim", "--web", address]);
    assert!(said.contains("the port is in use"), "{said}");
    let (folder, _) = token_file();
    let short = folder.path().join("short");
    std::fs::write(&short, "secret\n").unwrap();
    let said = refused(&["serve", "--bus", "sim", "--web", "0", "--web-token-file", short.to_str().unwrap()]);
    assert!(said.contains("6 characters; a token has 16 to 256") && !said.contains("secret"), "{said}");
}

#[test]
fn the_token_of_the_file_is_asked_for_by_both_commands() {
    let (_folder, file) = token_file();
    for arguments in [vec!["serve", "--bus", "sim"], vec!["sim", "--modbus", "off"]] {
        let page = Running::start(&[&arguments[..], &["--web", "0", "--web-token-file", &file]].concat());
        assert_eq!(page.ask("GET /api/about", "", "").0, 401, "{arguments:?}");
        let (status, about) = page.ask("GET /api/about", &format!("Authorization: Bearer {TOKEN}\r\n"), "");
        assert_eq!((status, &about["may_change"]), (200, &json!(true)), "{arguments:?}");
        assert_eq!(page.ask("GET /api/about", "Authorization: Bearer another-token-1234\r\n", "").0, 401);
        assert_eq!(page.ask("POST /api/login", "", &json!({ "token": TOKEN }).to_string()).0, 200);
    }
}

#[test]
fn on_an_address_of_the_network_a_simulation_only_shows_unless_control_is_allowed() {
    let (_folder, file) = token_file();
    let bearer = format!("Authorization: Bearer {TOKEN}\r\n");
    for (more, may_change) in [(vec![], false), (vec!["--allow-control"], true)] {
        let open = ["sim", "--modbus", "off", "--web", "0.0.0.0:0", "--web-token-file", &file];
        let mut page = Running::start(&[&open[..], &more].concat());
        // The Host is the address that the request came to.
        let port = page.listening["web"].as_str().unwrap().rsplit(':').next().unwrap().to_owned();
        page.listening["web"] = json!(format!("127.0.0.1:{port}"));
        let (_, about) = page.ask("GET /api/about", &bearer, "");
        assert_eq!(about["may_change"], may_change);
        let verb = json!({ "verb": "out", "position": 1, "word": "4200270F" }).to_string();
        let (status, _) = page.ask("POST /api/command", &bearer, &verb);
        assert_eq!(status, if may_change { 200 } else { 403 });
    }
}
