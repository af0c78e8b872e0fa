//! Each verb with right and wrong lines, over a ring that runs.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "a test may panic")]

mod common;

use common::Ring;
use encoring_words::OutWord;
use serde_json::{Value, json};

fn device(view: &Value, position: usize) -> &Value {
    &view["devices"][position]
}

#[test]
fn an_encoder_without_supply_is_off_and_comes_back_with_it() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":1,"set":{"supply_v":5.0}}"#);
    let view = ring.view();
    assert_eq!(device(&view, 1)["on"], false);
    assert_eq!(device(&view, 1)["supply_mv"], 5000);
    // Nobody answers on the segment that leads into it.
    ring.until(|view| view["line"] == "silent" && view["diagnosis"]["parameter"] == "0180");
    ring.done(r#"{"verb":"set","position":1,"set":{"supply_v":24}}"#);
    ring.until(|view| device(view, 1)["on"] == true && view["line"] == "good");
}

#[test]
fn the_ring_notes_an_overvoltage() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":2,"set":{"supply_v":28.351}}"#);
    let view = ring.until(|view| device(view, 2)["overvoltage"] == true);
    assert_eq!(device(&view, 2)["on"], true);
}

#[test]
fn the_ring_notes_an_overvoltage_on_a_preset_input() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":1,"set":{"preset2_v":30.001}}"#);
    ring.until(|view| device(view, 1)["preset_overvoltage"] == true);
    ring.done(r#"{"verb":"set","position":1,"set":{"preset2_v":30}}"#);
    let view = ring.until(|view| device(view, 1)["preset_overvoltage"] == false);
    assert_eq!(device(&view, 1)["overvoltage"], false, "the supply is another matter");
}

#[test]
fn a_preset_input_sets_the_position() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":1,"set":{"raw":123456,"preset1_v":0.0}}"#);
    let before = ring.until(|view| device(view, 1)["value"] == 123_456);
    assert_eq!(device(&before, 1)["preset_mv"], json!([0, 0]));
    ring.done(r#"{"verb":"set","position":1,"set":{"preset1_v":24.0}}"#);
    // Preset 1 of the factory is 0.
    let after = ring.until(|view| device(view, 1)["value"] == 0);
    assert_eq!(device(&after, 1)["preset_mv"], json!([24_000, 0]));
    assert_eq!(device(&after, 1)["raw"], 123_456);
}

#[test]
fn an_input_that_the_model_has_not_is_refused() {
    let ring = Ring::start();
    assert_eq!(
        ring.refused(r#"{"verb":"set","position":0,"set":{"preset2_v":24}}"#),
        "position 0, a la-66: preset2_v: preset inputs of a la-66: 1"
    );
    assert_eq!(
        ring.refused(r#"{"verb":"set","position":2,"set":{"magnet":false}}"#),
        "position 2, a ce-65-m: magnet: a ce-65-m has none"
    );
}

#[test]
fn a_missing_magnet_is_an_error_of_the_la_66() {
    let ring = Ring::start();
    assert_eq!(device(&ring.view(), 0)["error"], false);
    ring.done(r#"{"verb":"set","position":0,"set":{"magnet":false}}"#);
    let view = ring.until(|view| device(view, 0)["error"] == true);
    assert_eq!(device(&view, 1)["error"], false);
    ring.done(r#"{"verb":"set","position":0,"set":{"magnet":true}}"#);
}

#[test]
fn a_shaft_goes_where_it_is_put_and_moves_on_from_there() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":2,"set":{"raw":-5}}"#);
    assert_eq!(device(&ring.view(), 2)["raw"], -5);
    ring.done(r#"{"verb":"set","position":2,"set":{"motion":{"kind":"speed","per_s":1e6}}}"#);
    ring.until(|view| device(view, 2)["raw"].as_i64() > Some(1_000));
    ring.done(r#"{"verb":"set","position":2,"set":{"motion":{"kind":"hold"}}}"#);
    let held = device(&ring.view(), 2)["raw"].clone();
    assert!(held.as_i64() > Some(1_000));
    assert_eq!(device(&ring.view(), 2)["raw"], held);
    ring.done(
        r#"{"verb":"set","position":2,"set":{"motion":{"kind":"moves","moves":[{"to":100,"in_s":0.01}]}}}"#,
    );
    ring.until(|view| device(view, 2)["raw"] == 100);
}

#[test]
fn a_memory_that_cannot_be_read_is_an_error_after_power_on() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":1,"set":{"eeprom":{"fault":"read"},"supply_v":0}}"#);
    ring.done(r#"{"verb":"set","position":1,"set":{"supply_v":24}}"#);
    let view = ring.until(|view| device(view, 1)["error"] == true);
    assert_ne!(device(&view, 1)["latched_status"], "0000");
    let records = ["programmed", "offset", "accepted", "turn_count"];
    assert_eq!(device(&view, 1)["memory_lost"], serde_json::json!(records));
    ring.done(r#"{"verb":"set","position":1,"set":{"eeprom":{"fault":"none"},"supply_v":0}}"#);
    ring.done(r#"{"verb":"set","position":1,"set":{"supply_v":24}}"#);
    let view = ring.until(|view| device(view, 1)["on"] == true && device(view, 1)["error"] == false);
    assert_eq!(device(&view, 1)["memory_lost"], serde_json::json!([]));
}

#[test]
fn the_power_goes_in_the_middle_of_a_write() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":2,"set":{"eeprom":{"fault":"cut","after_bytes":1}}}"#);
    let write = |word| {
        ring.station.handle().image().with(|image| image.out_mut()[2] = OutWord(word));
    };
    write(0xC200_270F);
    ring.until(|view| device(view, 2)["on"] == false && device(view, 2)["supply_mv"] == 0);
    write(0);
    ring.done(r#"{"verb":"set","position":2,"set":{"supply_v":24}}"#);
    ring.until(|view| device(view, 2)["on"] == true);
}

#[test]
fn a_segment_is_troubled_for_a_time_or_until_told() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"line","segment":1,"fault":"silent"}"#);
    let view = ring.until(|view| view["line"] == "silent" && view["diagnosis"]["parameter"] == "0180");
    assert_eq!(view["trouble"], json!({ "segment": 1, "fault": "silent" }));
    ring.done(r#"{"verb":"line","fault":"none"}"#);
    let view = ring.until(|view| view["line"] == "good");
    assert_eq!(view["trouble"], Value::Null);
    assert_eq!(view["segment"], Value::Null);
    let before = view["counters"]["faulty_cycles"].as_u64();
    ring.done(r#"{"verb":"line","segment":3,"fault":"bad","for_s":0.1}"#);
    ring.until(|view| view["line"] == "good" && view["counters"]["faulty_cycles"].as_u64() > before);
}

#[test]
fn a_segment_can_suffer_every_fault_of_a_line() {
    let ring = Ring::start();
    for fault in
        ["bad", "silent", "low", "high", "flips=1000000", "bursts=1000000", "jitter=200000", "lost=1000000"]
    {
        ring.done(&format!(r#"{{"verb":"line","segment":2,"fault":"{fault}"}}"#));
        ring.until(|view| view["line"] != "good");
        ring.done(r#"{"verb":"line","fault":"none"}"#);
        ring.until(|view| view["line"] == "good");
    }
}

#[test]
fn help_gives_lines_that_work() {
    let ring = Ring::start();
    let help = ring.ask(r#"{"verb":"help"}"#);
    let verbs = help["verbs"].as_array().unwrap();
    let names: Vec<&Value> = verbs.iter().map(|verb| &verb["verb"]).collect();
    assert_eq!(names, ["set", "out", "service", "line", "gateway", "view", "help"]);
    let mut examples = 0;
    for verb in verbs {
        for example in verb["examples"].as_array().unwrap() {
            assert_eq!(example["verb"], verb["verb"]);
            assert_eq!(ring.ask(&example.to_string())["ok"], true, "{example}");
            examples += 1;
        }
    }
    assert_eq!(examples, 18);
}

#[test]
fn an_id_is_echoed_as_it_was_written() {
    let ring = Ring::start();
    for id in ["7", "1.50", "\"a\\u0041\"", "null", "true", "123456789012345678901234567890"] {
        let line = format!(r#"{{"id":{id},"verb":"line","fault":"none"}}"#);
        let answer = encoring_station::answer::answer(&line, &ring.controlled);
        assert_eq!(answer, format!(r#"{{"ok":true,"id":{id}}}"#));
    }
    assert_eq!(ring.ask(r#"{"id":4,"verb":"sett"}"#)["id"], 4);
    for (id, bytes) in [("[1]", 3), ("{}", 2), (&format!("\"{}\"", "x".repeat(63)), 65)] {
        assert_eq!(
            ring.refused(&format!(r#"{{"id":{id},"verb":"view"}}"#)),
            format!("id of {bytes} bytes; an id is a string, a number, true, false or null of at most 64")
        );
    }
}

#[test]
fn a_refusal_names_place_value_and_limit() {
    let ring = Ring::start();
    let keys = "expected one of `preset1_v`, `preset2_v`, `supply_v`, `magnet`, `raw`, `motion`, `eeprom`, \
                `chip_held`, `jumper`, `ident`, `ssi`, `ssi_fault`";
    for (line, error) in [
        ("", "not a JSON object; a line looks like {\"verb\":\"help\"}"),
        ("[1]", "not a JSON object; a line looks like {\"verb\":\"help\"}"),
        ("{", "column 1: EOF while parsing an object"),
        (r#"{"verb":"view"} {}"#, "column 17: trailing characters"),
        (r#"{"verb":"view","verb":"help"}"#, "column 21: duplicate field `verb`"),
        ("{}", "verb is missing; the verbs are set, out, service, line, gateway, view, help"),
        (r#"{"verb":"sett"}"#, "verb \"sett\"; the verbs are set, out, service, line, gateway, view, help"),
        (r#"{"verb":7}"#, "verb 7; the verbs are set, out, service, line, gateway, view, help"),
        (r#"{"verb":"view","x":1}"#, "column 18: unknown field `x`, expected `verb` or `id`"),
        (r#"{"verb":"set","set":{"raw":1}}"#, "column 30: missing field `position`"),
        (r#"{"verb":"set","position":3,"set":{"raw":1}}"#, "position 3; the encoders are at 0 to 2"),
        (r#"{"verb":"set","position":-1,"set":{"raw":1}}"#, "position -1; the encoders are at 0 to 2"),
        (
            r#"{"verb":"set","position":1.5,"set":{"raw":1}}"#,
            "column 28: invalid type: floating point `1.5`, expected i64",
        ),
        (
            r#"{"verb":"set","position":1,"set":{"suply_v":1}}"#,
            &format!("column 43: unknown field `suply_v`, {keys}"),
        ),
        (r#"{"verb":"set","position":1,"set":{"raw":1,"raw":2}}"#, "column 47: duplicate field `raw`"),
        (r#"{"verb":"set","position":1,"set":[1]}"#, "column 33: invalid type: sequence, expected an object"),
        (r#"{"verb":"set","position":1,"set":{}}"#, "position 1, a ce-100-m: nothing is set"),
        (
            r#"{"verb":"set","position":1,"set":{"supply_v":1000.5}}"#,
            "position 1, a ce-100-m: supply_v 1000.5; the limits are 0 and 1000",
        ),
        (
            r#"{"verb":"set","position":1,"set":{"eeprom":{"fault":"read","cell":512}}}"#,
            "position 1, a ce-100-m: cell 512; the limits are 0 and 511",
        ),
        (
            r#"{"verb":"set","position":0,"set":{"motion":{"kind":"csv","file":"/etc/passwd"}}}"#,
            "position 0: motion kind \"csv\" opens a file, which a peer cannot ask for; use moves",
        ),
        (r#"{"verb":"line","fault":"bad"}"#, "segment is missing; the segments are 0 to 3"),
        (r#"{"verb":"line","segment":4,"fault":"bad"}"#, "segment 4; the segments are 0 to 3"),
        (
            r#"{"verb":"line","segment":0,"fault":"bad","for_s":-1}"#,
            "for_s -1; the limits are 0 and 1000000000",
        ),
        (
            r#"{"verb":"line","segment":0,"fault":"none"}"#,
            "segment with fault \"none\", which ends every fault of the line and takes no other key",
        ),
        (
            r#"{"verb":"line","for_s":1,"fault":"none"}"#,
            "for_s with fault \"none\", which ends every fault of the line and takes no other key",
        ),
        (
            r#"{"verb":"line","segment":0,"fault":"worse"}"#,
            "column 43: kind \"worse\"; the kinds are bad, silent, low, high, flips=N, bursts=N, jitter=N, lost=N, \
             supply, chip, jumper, ident=HHHH, ssi_lost=N, ssi_added=N, ssi_flips=N, ssi_skew=N, ssi_delay=N, ssi_low, \
             ssi_high",
        ),
        (
            r#"{"verb":"line","segment":0,"fault":"supply"}"#,
            "column 44: supply is no fault of a line; those are bad, silent, low, high, flips=N, bursts=N, jitter=N, \
             lost=N",
        ),
        (
            r#"{"verb":"line","segment":0,"fault":"flips=0"}"#,
            "column 45: value \"0\" for flips; write flips=N with N from 1 to 1000000, bits of a million",
        ),
    ] {
        assert_eq!(ring.refused(line), error, "{line}");
    }
}

#[test]
fn a_line_with_one_wrong_value_changes_nothing() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"set","position":1,"set":{"raw":77}}"#);
    ring.refused(r#"{"verb":"set","position":1,"set":{"supply_v":0,"raw":1,"preset1_v":-1}}"#);
    let view = ring.view();
    assert_eq!(device(&view, 1)["on"], true);
    assert_eq!(device(&view, 1)["raw"], 77);
}

#[test]
fn a_ring_that_has_stopped_is_told_so() {
    let Ring { station, controlled } = Ring::start();
    station.stop().unwrap();
    for line in [
        r#"{"verb":"view"}"#,
        r#"{"verb":"line","fault":"none"}"#,
        r#"{"verb":"set","position":1,"set":{"raw":1}}"#,
    ] {
        assert_eq!(
            encoring_station::answer::answer(line, &controlled),
            r#"{"ok":false,"error":"the ring has stopped"}"#
        );
    }
    assert!(encoring_station::answer::answer(r#"{"verb":"help"}"#, &controlled).starts_with(r#"{"ok":true"#));
}

#[test]
fn faults_of_the_gateway_are_passed_on_as_text_listed_and_ended() {
    let mut ring = Ring::start();
    let listed = |ring: &Ring| ring.ask(r#"{"verb":"gateway"}"#)["faults"].clone();
    assert_eq!(listed(&ring), serde_json::json!([]));
    for fault in ["late=5", "close", "busy"] {
        ring.done(&format!(r#"{{"verb":"gateway","fault":"{fault}"}}"#));
    }
    assert_eq!(listed(&ring), serde_json::json!(["late=5", "close", "busy"]));
    ring.done(r#"{"verb":"gateway","end":"close"}"#);
    assert_eq!(listed(&ring), serde_json::json!(["late=5", "busy"]));
    // What is refused changes nothing, and the gateway says why.
    for (line, problem) in [
        (r#"{"verb":"gateway","fault":"7"}"#, "gateway fault \"7\""),
        (r#"{"verb":"gateway","end":"close"}"#, "gateway fault close is not there"),
        (
            r#"{"verb":"gateway","fault":"close","end":"busy"}"#,
            "fault and end in one line; fault begins one, end ends one",
        ),
        (
            r#"{"verb":"gateway","for_s":1}"#,
            "column 25: unknown field `for_s`, expected one of `verb`, `id`, `fault`, `end`",
        ),
    ] {
        assert_eq!(ring.refused(line), problem);
    }
    assert_eq!(listed(&ring), serde_json::json!(["late=5", "busy"]));
    ring.done(r#"{"verb":"gateway","end":"all"}"#);
    assert_eq!(listed(&ring), serde_json::json!([]));
    ring.controlled.gateway = None;
    for line in [r#"{"verb":"gateway"}"#, r#"{"verb":"gateway","fault":"close"}"#] {
        assert_eq!(ring.refused(line), "there is no Modbus server whose answers could be spoilt");
    }
}

#[test]
fn an_out_word_written_step_by_step_is_a_service() {
    // [R31..R40]
    let ring = Ring::start();
    ring.done(r#"{"verb":"out","position":1,"word":"4200 270F"}"#);
    ring.until(|view| device(view, 1)["out"] == "4200270F" && device(view, 1)["handshake"] == "normal");
    ring.done(r#"{"verb":"out","position":1,"word":"16#C200270F"}"#);
    ring.until(|view| device(view, 1)["in"] == "C200270F");
    ring.done(r#"{"verb":"out","position":1,"word":"0x4200270F"}"#);
    ring.until(|view| device(view, 1)["handshake"] == "normal");
    let history = ring.controlled.ring.history().since(1, 0, 100).unwrap();
    let steps = history.changes.iter().flat_map(|change| [change.out_step, change.in_step]).flatten();
    assert_eq!(steps.map(encoring_station::ServiceStep::number).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
    for (word, problem) in [("18", "word: "), ("torn", "word: "), ("", "word: ")] {
        let line = json!({ "verb": "out", "position": 1, "word": word }).to_string();
        assert!(ring.refused(&line).starts_with(problem), "{}", ring.refused(&line));
    }
    let last = ring.refused(r#"{"verb":"out","position":3,"word":"C200270F"}"#);
    assert_eq!(last, "position 3; the encoders are at 0 to 2");
}

#[test]
fn a_service_in_one_go_gives_the_reply_and_leaves_five_steps() {
    // [R31..R40]
    let ring = Ring::start();
    let serve = |line: &str| ring.ask(line)["reply"].clone();
    let good = |data: u32| json!({ "data": data, "error": false, "error_before": false });
    assert_eq!(serve(r#"{"verb":"service","position":1,"service":2,"value":9999}"#), good(9_999));
    assert_eq!(serve(r#"{"verb":"service","position":1,"service":2}"#), good(9_999));
    assert_eq!(serve(r#"{"verb":"service","position":1,"service":8}"#), good(0));
    assert_eq!(serve(r#"{"verb":"service","position":1,"service":6,"value":17}"#), good(17));
    let history = ring.controlled.ring.history().since(1, 0, 100).unwrap();
    let steps = history.changes.iter().flat_map(|change| [change.out_step, change.in_step]).flatten();
    let steps: Vec<u8> = steps.map(encoring_station::ServiceStep::number).collect();
    assert_eq!(steps, [1, 2, 3, 4, 5].repeat(4));
    for (line, refusal) in [
        (r#"{"verb":"service","position":1,"service":7}"#, "service 7; the services are 1 to 6, 8, 9 and 13"),
        (
            r#"{"verb":"service","position":2,"service":4}"#,
            "position 2: a ce-65-m has no service 04 (preset value 1)",
        ),
        (
            r#"{"verb":"service","position":1,"service":9,"value":100}"#,
            "position 1: revolutions denominator: 100 is outside 1..99",
        ),
        (
            r#"{"verb":"service","position":1,"service":6}"#,
            "service 6, the preset adjustment, cannot be read; value is missing",
        ),
        (
            r#"{"verb":"service","position":1,"service":8,"value":0}"#,
            "value with service 8, the data check, which is only read",
        ),
        (
            r#"{"verb":"service","position":1,"service":2,"value":-1}"#,
            "value -1; the limits are 0 and 16777215",
        ),
    ] {
        assert_eq!(ring.refused(line), refusal, "{line}");
    }
    assert_eq!(ring.controlled.ring.history().counts()[1], 20, "what is refused sends nothing");
}

#[test]
fn a_service_of_another_master_or_of_an_encoder_that_is_off_is_told() {
    let ring = Ring::start();
    ring.done(r#"{"verb":"out","position":1,"word":"88000000"}"#);
    assert_eq!(
        ring.refused(r#"{"verb":"service","position":1,"service":2}"#),
        "position 1: OUT holds 88000000: a service is under way, or was left there; this one was not begun"
    );
    ring.done(r#"{"verb":"set","position":2,"set":{"supply_v":0}}"#);
    ring.until(|view| device(view, 2)["on"] == false);
    let late = ring.refused(r#"{"verb":"service","position":2,"service":8}"#);
    assert!(late.starts_with("position 2: waited 1 s for"), "{late}");
}
