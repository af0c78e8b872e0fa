use super::*;
use encoring_encoder::ServiceTimes;
use encoring_encoder::{StaleService, ZeroLoss};
use encoring_ring::profile::BIT_2M;
use encoring_words::Model;
use encoring_words::model::Sensor;

fn parse(text: &str) -> Result<Scenario, String> {
    Scenario::parse("s.toml", text, Path::new("")).map_err(|error| error.to_string())
}

const ONE: &str = "version = 1\n[[device]]\nposition = 0\nmodel = \"ce-100-m\"\n";

#[test]
fn the_built_in_ring_has_one_of_each_and_all_move() {
    let scenario = Scenario::built_in().unwrap();
    let models: Vec<Model> = scenario.devices.iter().map(|device| device.unit.model()).collect();
    assert_eq!(models, [Model::La66, Model::Ce100M, Model::Ce65M]);
    for device in &scenario.devices {
        assert_ne!(device.motion.at(Duration::from_millis(100)), device.motion.at(Duration::from_secs(1)));
    }
}

#[test]
fn every_key_of_the_format_is_read() {
    let scenario = parse(
        r#"
version = 1
seed = 9
[ring]
kbit_s = 2000
software_us = 0
cable_m = 100
faulty_per_million = 20
[[device]]
position = 1
model = "ce-65-m"
native = 8192
firmware = "40/1997"
service_times = { read_ms = 0.5, data_check_ms = 3 }
zero_loss = "worst"
stale_service = "executed"
motion = { kind = "speed", start = 7, rpm = 60 }
[[device]]
position = 0
model = "la-66"
rod_mm = 1000
service_times = "zero"
motion = { kind = "hold", raw = 5 }
[[event]]
at_s = 2.5
position = 0
set = { preset1_v = 24.0, supply_v = 10.45, magnet = false, raw = 3, eeprom = { fault = "stuck", cell = 511, value = 255 } }
[[event]]
at_s = 1
segment = 2
line = "silent"
for_s = 0.5
"#,
    )
    .unwrap();
    assert_eq!(scenario.seed, 9);
    assert_eq!(scenario.cycle_time, CycleTime { bit: BIT_2M, software: Duration::ZERO, cable_m: 100 });
    assert_eq!(scenario.faulty_per_million, 20);
    let [rod, shaft] = &scenario.devices[..] else { panic!("two devices") };
    assert_eq!(rod.unit.sensor(), Sensor::Linear { rod_um: 1_000_000 });
    assert_eq!(rod.unit.service_times, ServiceTimes::ZERO);
    assert_eq!(shaft.unit.firmware, "40/1997".parse().unwrap());
    assert_eq!(shaft.unit.service_times.read, Duration::from_micros(500));
    assert_eq!(shaft.unit.service_times.write, Duration::from_millis(10));
    assert_eq!(shaft.unit.service_times.data_check, Duration::from_millis(3));
    assert_eq!(shaft.unit.zero_loss, ZeroLoss::WorstAllowed);
    assert_eq!(shaft.unit.stale_service, StaleService::Executed);
    assert_eq!(rod.unit.stale_service, StaleService::Ignored);
    assert_eq!(shaft.motion, Motion::Speed { start: 7, micro_per_s: 8_192_000_000 });
    assert_eq!(
        scenario.events,
        [
            Event {
                at: Instant(1_000_000_000),
                what: Happening::Line {
                    segment: 2,
                    fault: Fault::Silent,
                    lasting: Duration::from_millis(500)
                },
            },
            Event {
                at: Instant(2_500_000_000),
                what: Happening::Device {
                    position: 0,
                    changes: vec![
                        Change::Supply(10_450),
                        Change::MemoryFault(CellFault::Stuck(255), Some(511)),
                        Change::Magnet(Magnet::Missing),
                        Change::Motion(NewMotion::Motion(Motion::Hold { raw: 3 })),
                        Change::Preset { input: 0, millivolts: 24_000 },
                    ],
                },
            },
        ]
    );
}

#[test]
fn a_fault_of_a_line_is_a_name_a_table_or_its_text_form() {
    let fault = |line: &str| {
        let read = parse(&format!("{ONE}[[event]]\nat_s = 1\nsegment = 1\nline = {line}\n"))?;
        match read.events[0].what {
            Happening::Line { fault, .. } => Ok(fault),
            Happening::Device { .. } => Err("of a device".to_owned()),
        }
    };
    for (line, expected) in [
        ("\"bad\"", Fault::Bad),
        ("\"high\"", Fault::High),
        ("{ flips = 20 }", Fault::Flips(20)),
        ("{ lost = 0 }", Fault::Lost(0)),
        ("\"jitter=1000000\"", Fault::Jitter(1_000_000)),
    ] {
        assert_eq!(fault(line), Ok(expected), "{line}");
    }
    for (line, part) in [
        ("\"worse\"", "kind \"worse\"; the kinds are bad, silent, low, high, flips=N, "),
        (
            "\"supply\"",
            "supply is no fault of a line; those are bad, silent, low, high, flips=N, bursts=N, jitter=N, lost=N",
        ),
        ("{ flips = 1000001 }", "bits in a million 1000001; the limits are 0 and 1000000"),
        ("{ flips = -1 }", "invalid value: integer `-1`, expected u32"),
        ("{ bad = 1 }", "bad takes no number; write \"bad\""),
        ("{ flips = 1, lost = 1 }", "lost beside flips; a line has one fault"),
        ("{ }", "invalid length 0, expected a kind of fault, as \"silent\" or { flips = 20 }"),
        ("7", "invalid type: integer `7`, expected a kind of fault"),
    ] {
        let message = fault(line).unwrap_err();
        assert!(message.contains(part), "{message:?} does not say {part:?}");
        assert_eq!(message.lines().count(), 1, "{message:?}");
    }
}

#[test]
fn a_rod_is_read_to_a_hundredth_of_a_millimetre() {
    let rod = |rod_mm: &str| {
        let text = format!("version = 1\n[[device]]\nposition = 0\nmodel = \"la-66\"\nrod_mm = {rod_mm}\n");
        parse(&text).map(|scenario| scenario.devices[0].unit.sensor())
    };
    for (rod_mm, rod_um) in
        [("500", 500_000), ("0.01", 10), ("1.1", 1_100), ("500.07", 500_070), ("167772.15", 167_772_150)]
    {
        assert_eq!(rod(rod_mm), Ok(Sensor::Linear { rod_um }), "{rod_mm}");
    }
    for (wrong, part) in [
        ("0.009", "rod_mm 0.009; the limits are 0.01 and 167772.15"),
        ("167772.16", "rod_mm 167772.16; the limits are 0.01 and 167772.15"),
        ("nan", "rod_mm NaN; the limits are 0.01 and 167772.15"),
        ("7.125", "line 5: device at position 0: rod_mm 7.125; a rod is told to 0.01 mm, two decimals"),
        ("500.0700001", "rod_mm 500.0700001; a rod is told to 0.01 mm"),
    ] {
        let message = rod(wrong).unwrap_err();
        assert!(message.contains(part), "{message:?} does not say {part:?}");
    }
}

#[test]
fn a_wrong_scenario_is_refused_with_place_value_and_limit() {
    let wrong = |text: &str| parse(text).unwrap_err();
    let one = |more: &str| wrong(&format!("{ONE}{more}"));
    for (message, part) in [
        (
            wrong("version = 2\n[[device]]\nposition = 0\nmodel = \"la-66\"\n"),
            "s.toml line 1: version 2; this program reads version 1",
        ),
        (wrong("version = 1\n"), "s.toml: no [[device]]; a ring holds at least one encoder"),
        (one("rodd_mm = 3\n"), "s.toml line 5: unknown field `rodd_mm`"),
        (
            one("rod_mm = 3\n"),
            "s.toml line 5: device at position 0: a ce-100-m has steps per turn, no rod length",
        ),
        (one("native = 8192\n"), "device at position 0: 8192 steps per turn; a ce-100-m has 4096"),
        (
            one("stale_service = \"worst\"\n"),
            "line 5: device at position 0: stale_service \"worst\": a stale service bit is ignored or executed",
        ),
        (one("firmware = \"41/97\"\n"), "firmware \"41/97\": a firmware week is written WW/YYYY"),
        (one("[[device]]\nposition = 0\nmodel = \"la-66\"\n"), "s.toml line 6: position 0 is taken twice"),
        (one("[[device]]\nposition = 2\nmodel = \"la-66\"\n"), "line 6: position 2; the limits are 0 and 1"),
        (
            one("[[device]]\nposition = 1\nmodel = \"ce-66\"\n"),
            "model \"ce-66\"; the models are la-66, ce-100-m and ce-65-m",
        ),
        (
            one("[[device]]\nposition = 1\nmodel = \"la-66\"\nrod_mm = 0\n"),
            "line 8: device at position 1: rod_mm 0; the limits are 0.01 and 167772.15",
        ),
        (
            one("[[event]]\nat_s = -1\nposition = 0\nset = { raw = 1 }\n"),
            "line 6: at_s -1; the limits are 0 and 1000000000",
        ),
        (
            one("[[event]]\nat_s = 1\nposition = 1\nset = { raw = 1 }\n"),
            "line 7: position 1; the limits are 0 and 0",
        ),
        (one("[[event]]\nat_s = 1\nposition = 0\nset = { magnet = true }\n"), "magnet: a ce-100-m has none"),
        (one("[[event]]\nat_s = 1\nposition = 0\nset = { }\n"), "nothing is set"),
        (
            one("[[event]]\nat_s = 1\nposition = 0\nset = { supply_v = 1001 }\n"),
            "supply_v 1001; the limits are 0 and 1000",
        ),
        (
            one("[[event]]\nat_s = 1\nposition = 0\nset = { supply_v = nan }\n"),
            "supply_v NaN; the limits are 0 and 1000",
        ),
        (one("[[event]]\nat_s = 1\nposition = 0\n"), "an event has position and set, or segment and line"),
        (one("[[event]]\nat_s = 1\nsegment = 2\nline = \"bad\"\n"), "segment 2; the limits are 0 and 1"),
        (
            one("motion = { kind = \"sine\", center = 0, amplitude = 1, period_s = 0 }\n"),
            "period_s 0; a swing takes time",
        ),
        (one("motion = { kind = \"speed\" }\n"), "speed takes either per_s or rpm"),
        (one("motion = { kind = \"speed\", rpm = 1e9 }\n"), "the limits are -1000000000 and 1000000000"),
        (one("motion = { kind = \"csv\", file = \"no-such-file.csv\" }\n"), "no-such-file.csv: "),
        (
            one("[[event]]\nat_s = 1\nposition = 0\nset = { eeprom = { fault = \"none\", cell = 7 } }\n"),
            "unknown field `cell`",
        ),
        (one("[ring]\nkbit_s = 1000\n"), "kbit_s 1000; the bus has 500 or 2000"),
    ] {
        assert!(message.contains(part), "{message:?} does not say {part:?}");
        assert_eq!(message.lines().count(), 1, "{message:?}");
    }
}

#[test]
fn a_ring_holds_128_encoders_and_no_more() {
    let ring = |encoders: usize| {
        let devices = (0..encoders).map(|k| format!("[[device]]\nposition = {k}\nmodel = \"ce-65-m\"\n"));
        parse(&format!("version = 1\n{}", devices.collect::<String>()))
    };
    assert_eq!(ring(128).unwrap().devices.len(), 128);
    assert_eq!(ring(129).unwrap_err(), "s.toml line 386: 129 encoders; the limit is 128");
}

#[test]
fn a_wrong_value_is_told_with_its_own_line() {
    let event = "[[event]]\nat_s = 1\nposition = 0\n";
    for (more, line, part) in [
        (
            "motion = { kind = \"moves\", moves = [\n{ to = 1, in_s = 1 },\n{ to = 2, in_s = -1 },\n] }\n",
            7,
            "in_s -1",
        ),
        ("[device.motion]\nkind = \"speed\"\nrpm = 1e9\n", 7, "speed in steps"),
        ("[device.motion]\nkind = \"speed\"\n", 5, "speed takes"),
        ("[device.service_times]\nread_ms = 1\nwrite_ms = -1\n", 7, "write_ms -1"),
        (&format!("{event}set.supply_v = 20\nset.preset1_v = 9999\n"), 9, "preset1_v 9999"),
        (&format!("{event}[event.set.eeprom]\nfault = \"read\"\ncell = 512\n"), 10, "cell 512"),
        (&format!("{event}set.raw = 1\n{event}set.raw = 2\nset.magnet = true\n"), 13, "magnet"),
        ("[[event]]\nat_s = 1\nsegment = 0\nline = { flips = 1000001 }\n", 8, "bits in a million 1000001"),
        (&format!("motion = {}1{}\n", "[".repeat(500), "]".repeat(500)), 5, "recurs"),
        (&format!("a{} = 1\n", ".a".repeat(500)), 5, "recurs"),
    ] {
        let message = parse(&format!("{ONE}{more}")).unwrap_err();
        assert!(message.starts_with(&format!("s.toml line {line}: ")) && message.contains(part), "{message}");
    }
}

#[test]
fn a_motion_file_that_is_named_often_is_read_and_held_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.csv"), "raw\n1\n2\n").unwrap();
    let event =
        "[[event]]\nat_s = 1\nposition = 0\nset = { motion = { kind = \"csv\", file = \"m.csv\" } }\n";
    let text = format!("{ONE}motion = {{ kind = \"csv\", file = \"m.csv\" }}\n{}", event.repeat(2));
    let scenario = Scenario::parse("s.toml", &text, folder.path()).unwrap();
    let Motion::Recorded { points } = &scenario.devices[0].motion else { panic!("a recorded motion") };
    assert_eq!(points[..], [(Instant(0), 1), (Instant(1_000_000), 2)]);
    assert_eq!(scenario.notes, Vec::<String>::new(), "the header is ours");
    assert_eq!(std::sync::Arc::strong_count(points), 3, "one for the device, one for each event");
}

#[test]
fn what_was_assumed_of_a_motion_file_is_told_once() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("m.csv"), "Time [s];Raw\n0,5;1\n").unwrap();
    let event =
        "[[event]]\nat_s = 1\nposition = 0\nset = { motion = { kind = \"csv\", file = \"m.csv\" } }\n";
    let text = format!("{ONE}motion = {{ kind = \"csv\", file = \"m.csv\" }}\n{event}");
    let scenario = Scenario::parse("s.toml", &text, folder.path()).unwrap();
    let file = folder.path().join("m.csv").display().to_string();
    let assumed = "`;` separates the cells; time in s from \"Time [s]\"; raw from \"Raw\"";
    assert_eq!(scenario.notes, [format!("{file}: {assumed}")]);
    let Motion::Recorded { points } = &scenario.devices[0].motion else { panic!("a recorded motion") };
    assert_eq!(points[..], [(Instant(500_000_000), 1)]);
}

#[test]
fn all_motion_files_together_have_a_limit() {
    let folder = tempfile::tempdir().unwrap();
    let rows = MOTION_ROWS_MAX / 2 + 1;
    std::fs::write(folder.path().join("a.csv"), format!("raw\n{}", "7\n".repeat(rows))).unwrap();
    std::fs::copy(folder.path().join("a.csv"), folder.path().join("b.csv")).unwrap();
    let device = |position: usize, file: &str| {
        format!(
            "[[device]]\nposition = {position}\nmodel = \"ce-65-m\"\nmotion = {{ kind = \"csv\", file = \"{file}\" }}\n"
        )
    };
    let parse = |second: &str| {
        let text = format!("version = 1\n{}{}", device(0, "a.csv"), device(1, second));
        Scenario::parse("s.toml", &text, folder.path()).map_err(|error| error.to_string())
    };
    assert!(parse("a.csv").is_ok());
    let message = parse("b.csv").unwrap_err();
    assert!(message.starts_with("s.toml line 9: device at position 1: "), "{message}");
    let limit = format!("b.csv line {rows}: all recorded motions have more than {MOTION_ROWS_MAX} rows");
    assert!(message.ends_with(&limit), "{message}");
}

#[cfg(unix)]
#[test]
fn a_motion_file_that_never_ends_is_refused() {
    let text = format!("{ONE}motion = {{ kind = \"csv\", file = \"/dev/zero\" }}\n");
    assert!(parse(&text).unwrap_err().ends_with("/dev/zero: a pipe or a device, no ordinary file"));
}
