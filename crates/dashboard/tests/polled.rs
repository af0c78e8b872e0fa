//! The page of a ring behind a bus.
#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use common::{Asked, described, description, free};
use encoring_bus::watch::{Plan, Subject};
use encoring_bus::{Bus, Insight, Judge, LeftBit, Tolerance};
use encoring_dashboard::{WebOptions, start};
use encoring_sim::{Scenario, World};
use encoring_station::known::KnownFile;
use encoring_station::polled::{Onlooker, PollOptions, Polled};
use encoring_station::view::LampsView;
use encoring_station::{Permission, RingEvent, Simulated, Speed};
use encoring_words::{Duration, Model, OutWord, Parameter};
use serde_json::{Value, json};

/// Looks until it is told to end.
struct Until(Arc<AtomicBool>);

impl Onlooker for Until {
    fn insight(&self, _position: usize) -> Option<Insight> {
        None
    }

    fn lamps(&self, _position: usize) -> Option<LampsView> {
        None
    }

    fn is_over(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    fn serving(&self, _position: usize, _left: LeftBit) {}

    fn happened(&mut self, _events: &[RingEvent]) -> io::Result<()> {
        Ok(())
    }
}

/// What a backup says of position 2.
fn file() -> KnownFile {
    KnownFile {
        position: 2,
        name: "axis-2.toml".to_owned(),
        taken: Some("2026-11-27T18:54:48Z".to_owned()),
        serial: None,
        label: None,
        values: vec![(Parameter::MeasuringLength, 9_999)],
    }
}

/// The page of positions 1 and 2 of the built-in ring, while `ask` has it; what stands on OUT afterwards.
fn page(options: &WebOptions, ask: impl FnOnce(&Asked)) -> [OutWord; 2] {
    let mut bus = Simulated::new(World::new(&Scenario::built_in().unwrap()).unwrap(), Speed::Max);
    let tolerance = Tolerance::of_sheet(Duration::from_millis(100));
    let subject =
        |(position, model)| Subject { position, judge: Judge::new(model, None, &[], tolerance).unwrap() };
    let polled = Polled::new(PollOptions {
        bus: "modbus-tcp://a-gateway".to_owned(),
        simulated: false,
        subjects: [(1, Model::Ce100M), (2, Model::Ce65M)].map(subject).into(),
        files: vec![file()],
        plan: Plan { every: Duration::from_millis(10), lasting: None },
        patience: Duration::from_secs(2),
    });
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let asked = Asked { address: listener.local_addr().unwrap() };
    let served = start(listener, Arc::new(polled.ring().clone()), options).unwrap();
    let over = Arc::<AtomicBool>::default();
    let mut onlooker = Until(Arc::clone(&over));
    let looking = thread::spawn(move || {
        polled.run(&mut bus, &Arc::default(), &mut onlooker).unwrap();
        bus
    });
    while asked.get("/api/state").json()["ring"]["polls"] == 0 {}
    ask(&asked);
    over.store(true, Ordering::Relaxed);
    let mut bus = looking.join().unwrap();
    assert_eq!(asked.get("/healthz").status, 503, "nobody looks any more");
    drop(served);
    [1, 2].map(|position| bus.out(position).unwrap())
}

#[test]
fn every_answer_of_a_polled_ring_is_as_the_description_says() {
    page(&free(), |page| {
        let service = page.command(&json!({ "verb": "service", "position": 1, "service": 2, "value": 9999 }));
        assert_eq!(
            (service.status, service.json()["reply"]["data"].clone()),
            (200, json!(9999)),
            "{}",
            service.body
        );
        let whole = description();
        for path in ["/api/state", "/api/units", "/api/about", "/api/history?position=1", "/api/happened"] {
            let plain = path.split('?').next().unwrap();
            let schema =
                &whole["paths"][plain]["get"]["responses"]["200"]["content"]["application/json"]["schema"];
            described(&page.get(path).json(), schema, &whole, path);
        }
        let state = page.get("/api/state").json();
        assert_eq!(state["ring"]["devices"]["2"]["model"], "ce-65-m");
        assert!(state["ring"]["devices"]["0"].is_null());
        let about = page.get("/api/about").json();
        assert_eq!((about["simulated"].clone(), about["poll_ns"].clone()), (json!(false), json!(10_000_000)));
        let steps: Vec<Value> =
            page.get("/api/history?position=1").json()["changes"].as_array().unwrap().clone();
        assert!(steps.iter().any(|change| change["in_step"] == 3), "{steps:?}");
        for line in page.get("/metrics").body.lines().filter(|line| !line.starts_with('#')) {
            assert!(!line.contains("cycles"), "nobody has counted cycles: {line}");
        }
        assert!(page.get("/metrics").body.contains("\nencoring_polls_total "));
    });
}

#[test]
fn a_page_that_only_shows_leaves_a_real_ring_as_it_is() {
    let options = WebOptions { permission: Permission::Look, ..free() };
    let out = page(&options, |page| {
        assert_eq!(page.get("/api/about").json()["may_change"], false);
        for verb in [
            json!({ "verb": "out", "position": 1, "word": "C200270F" }),
            json!({ "verb": "service", "position": 2, "service": 2, "value": 9999 }),
        ] {
            assert_eq!(page.command(&verb).status, 403, "{verb}");
        }
        assert_eq!(
            page.command(&json!({ "verb": "set", "position": 1, "set": { "supply_v": 0 } })).status,
            400
        );
        assert_eq!(
            page.command(&json!({ "verb": "acknowledge", "position": 1 })).status,
            200,
            "it writes nothing"
        );
    });
    assert_eq!(out, [OutWord(0); 2]);
}

#[test]
fn a_word_is_written_whole_and_seen_by_the_next_poll() {
    let out = page(&free(), |page| {
        let done = page.command(&json!({ "verb": "out", "position": 2, "word": "4200270F" }));
        assert_eq!(done.body, r#"{"ok":true}"#);
        while page.get("/api/state").json()["ring"]["devices"]["2"]["out"] != "4200270F" {}
        let change = &page.get("/api/history?position=2").json()["changes"][0];
        assert_eq!((change["out_step"].clone(), change["unseen"].clone()), (json!(1), json!([])));
    });
    assert_eq!(out, [OutWord(0), OutWord(0x4200_270F)]);
}

#[test]
fn what_is_known_of_parameters_is_shown_with_how_it_is_known_and_nothing_else() {
    // [R79, C7]
    page(&free(), |page| {
        assert_eq!(page.get("/api/units").json()[1]["file"]["name"], "axis-2.toml");
        let shown = || page.get("/api/state").json()["ring"]["devices"]["2"].clone();
        let length = |device: &Value| device["parameters"][1].clone();
        let before = shown();
        let said = json!({ "value": 9_999, "from": "file", "time_ns": null });
        assert_eq!(
            length(&before),
            json!({ "service": 2, "programmed": null, "accepted": null, "active": said })
        );
        assert_eq!(before["data_check"], Value::Null);
        let serve = |service: u8| {
            page.command(&json!({ "verb": "service", "position": 2, "service": service })).json()["reply"]["data"]
                .clone()
        };
        let read: Vec<Value> = [1, 2, 3, 9, 13].into_iter().map(serve).collect();
        while shown()["data_check"] != "0000" {}
        let known = shown();
        let programmed: Vec<&Value> = known["parameters"]
            .as_array()
            .unwrap()
            .iter()
            .map(|known| &known["programmed"]["value"])
            .collect();
        assert_eq!(programmed, read.iter().collect::<Vec<_>>());
        assert_eq!(length(&known)["active"], said, "a read says nothing of what is active");
        assert_eq!(serve(8), 0);
        while length(&shown())["accepted"]["from"] != "check" {}
        assert_eq!(length(&shown())["active"]["value"], read[1]);
    });
}
