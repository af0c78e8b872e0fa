//! Recordings of worlds: the same world writes the same bytes, and every recording replays.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

mod common;

use std::collections::BTreeMap;

use common::SERVICE_BIT;
use encoring_encoder::{Magnet, ServiceTimes, StaleService, Unit, ZeroLoss};
use encoring_host::ssi_receiver::TakenAt;
use encoring_ring::profile::{BIT_2M, BIT_500K};
use encoring_ring::{CycleTime, Verdict};
use encoring_sim::device_line::{from_device, to_device};
use encoring_sim::motion::Motion;
use encoring_sim::replay::{compare, play};
use encoring_sim::scenario::{Change, Device, Event, Happening, NewMotion};
use encoring_sim::ssi::SsiSettings;
use encoring_sim::{Fault, Node, Scenario, World};
use encoring_trace::{Input, Reader, Writer};
use encoring_words::model::Sensor;
use encoring_words::{Duration, InWord, Instant, Model, OutWord};
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const MS: u64 = 1_000_000;

fn one_of<T: Copy>(chance: &mut impl Rng, choices: &[T]) -> T {
    choices[chance.random_range(0..choices.len())]
}

fn any_unit(chance: &mut impl Rng) -> Unit {
    let (model, sensor) = match chance.random_range(0..4) {
        0 => (Model::La66, Sensor::Linear { rod_um: one_of(chance, &[10_000, 500_000, 3_000_000]) }),
        1 => (Model::Ce100M, Sensor::Rotary { steps_per_turn: 4096 }),
        2 => (Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }),
        _ => (Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }),
    };
    let mut unit = Unit::new(model, sensor).unwrap();
    if chance.random_bool(0.5) {
        unit.service_times = ServiceTimes::ZERO;
    }
    if chance.random_bool(0.3) {
        unit.zero_loss = ZeroLoss::WorstAllowed;
    }
    if chance.random_bool(0.3) {
        unit.stale_service = StaleService::Executed;
    }
    unit
}

fn any_motion(chance: &mut impl Rng) -> Motion {
    match chance.random_range(0..4) {
        0 => Motion::Hold { raw: chance.random_range(-1_000_000..1_000_000) },
        1 => Motion::Speed {
            start: chance.random_range(-100_000..100_000),
            micro_per_s: chance.random_range(-1_000_000_000_000_000..1_000_000_000_000_000),
        },
        2 => Motion::Sine {
            center: chance.random_range(0..500_000),
            amplitude: chance.random_range(0..600_000),
            period: Duration::from_millis(chance.random_range(1..2_000)),
        },
        _ => Motion::Path {
            points: vec![(Instant(0), 0), (Instant(50 * MS), chance.random_range(-20_000_000..20_000_000))],
            repeat: chance.random_bool(0.5),
        },
    }
}

fn any_change(chance: &mut impl Rng) -> Change {
    match chance.random_range(0..6) {
        0 | 1 => Change::Supply(one_of(chance, &[0, 10_449, 10_450, 24_000, 24_000, 24_000, 28_351])),
        2 => Change::Preset {
            input: chance.random_range(0..2),
            millivolts: one_of(chance, &[0, 7_999, 9_500, 11_000, 11_001, 24_000]),
        },
        3 => Change::Magnet(one_of(chance, &[Magnet::Present, Magnet::Present, Magnet::Missing])),
        4 => Change::Motion(NewMotion::Onward(chance.random_range(-1_000_000_000_000..1_000_000_000_000))),
        _ => Change::Motion(one_of(chance, &[NewMotion::Stop, NewMotion::Onward(0)].each_ref()).clone()),
    }
}

fn any_request(chance: &mut impl Rng) -> u32 {
    let head = match chance.random_range(0..10) {
        0..=1 => 0x8800_0000,
        2..=4 => 0xC600_0000,
        _ => SERVICE_BIT | chance.random_range(0..0x80_u32) << 24,
    };
    let data = one_of(chance, &[0, 1, 2, 3, 0x10, 0x18, 0x1F, 0x63, 0x101, 0xFFF, 0x1000, 0x270F, 0xFF_FFFF]);
    head | if chance.random_bool(0.1) { chance.random_range(0..1 << 24) } else { data }
}

fn any_device(chance: &mut impl Rng) -> Device {
    let (unit, motion) = (any_unit(chance), any_motion(chance));
    let reads = unit.model().has_ssi_output() && chance.random_bool(0.7);
    let ssi = reads.then(|| {
        let every = Duration(chance.random_range(400_000..5 * MS));
        SsiSettings::new(chance.random_range(80_000..1_000_000), 26, every, TakenAt::Falling).unwrap()
    });
    Device { unit, motion, ssi }
}

/// A ring with everything that can happen to it within so many milliseconds.
fn any_scenario(seed: u64, lasting_ms: u64) -> Scenario {
    let mut chance = Pcg64Mcg::seed_from_u64(seed);
    let encoders = 1 + (seed % 5) as usize;
    let devices = (0..encoders).map(|_| any_device(&mut chance)).collect();
    let mut events: Vec<Event> = (0..chance.random_range(0..20))
        .map(|_| {
            let at = Instant(chance.random_range(0..lasting_ms * MS));
            let what = if chance.random_bool(0.25) {
                Happening::Line {
                    segment: chance.random_range(0..=encoders),
                    fault: one_of(&mut chance, &[Fault::Bad, Fault::Silent]),
                    lasting: Duration(chance.random_range(0..60 * MS)),
                }
            } else {
                let position = chance.random_range(0..encoders);
                let changes = (0..chance.random_range(1..3)).map(|_| any_change(&mut chance)).collect();
                Happening::Device { position, changes }
            };
            Event { at, what }
        })
        .collect();
    events.sort_by_key(|event| event.at);
    Scenario {
        gateway_faults: Vec::new(),
        notes: Vec::new(),
        seed,
        cycle_time: CycleTime {
            bit: one_of(&mut chance, &[BIT_500K, BIT_2M]),
            software: one_of(
                &mut chance,
                &[Duration::ZERO, Duration::from_micros(200), Duration::from_millis(13)],
            ),
            cable_m: one_of(&mut chance, &[0, 12_800]),
        },
        faulty_per_million: one_of(&mut chance, &[0, 0, 10_000, 300_000]),
        devices,
        events,
    }
}

/// What a run did.
#[derive(Default)]
struct Tally {
    rows: usize,
    replies: usize,
    offs: usize,
    errors: usize,
    bad: usize,
    silent: usize,
}

impl Tally {
    fn add(&mut self, other: &Self) {
        self.rows += other.rows;
        self.replies += other.replies;
        self.offs += other.offs;
        self.errors += other.errors;
        self.bad += other.bad;
        self.silent += other.silent;
    }
}

/// Runs a world with random OUT words and changes by hand, and gives its recording.
fn recorded(scenario: &Scenario, out_seed: u64, lasting_ms: u64) -> Result<(Vec<u8>, Tally), std::io::Error> {
    let mut chance = Pcg64Mcg::seed_from_u64(out_seed ^ 0xA5A5);
    let mut world = World::new(scenario).unwrap();
    let devices: Vec<_> = world
        .places()
        .iter()
        .zip(0..)
        .map(|(place, position)| to_device(position, place.node().unit(), place.node().memory()))
        .collect();
    let mut writer = Writer::recording(Vec::new(), &devices)?;
    world.record();
    let encoders = devices.len();
    let mut out = vec![OutWord(0); encoders];
    let mut input = vec![InWord(0); encoders];
    let mut tally = Tally::default();
    while world.now().as_nanos() < lasting_ms * MS {
        if chance.random_bool(0.1) {
            let word = &mut out[chance.random_range(0..encoders)];
            word.0 = match chance.random_range(0..5) {
                0..=2 if word.0 & SERVICE_BIT == 0 => any_request(&mut chance),
                0..=3 => word.0 & !SERVICE_BIT,
                _ => chance.random_range(0..=u32::MAX),
            };
        }
        if chance.random_bool(0.005) {
            let position = chance.random_range(0..encoders);
            world.change(position, &[any_change(&mut chance)]);
        }
        match world.cycle(&out, &mut input).verdict {
            Verdict::Good => {}
            Verdict::Bad { .. } => tally.bad += 1,
            Verdict::Silent { .. } => tally.silent += 1,
        }
        for row in world.take_recorded() {
            writer.write(&row)?;
            tally.rows += 1;
            match row.input {
                Some(Input::Word(word)) => {
                    tally.replies += usize::from(word & SERVICE_BIT != 0);
                    tally.errors += usize::from(word & common::ERROR_BIT != 0);
                }
                _ => tally.offs += 1,
            }
        }
    }
    Ok((writer.into_inner(), tally))
}

/// Plays a recording into new devices with its memories, and gives how many rows there were and what differs.
fn replayed(file: &[u8]) -> (usize, Vec<String>) {
    let reader = Reader::new("recording.csv", file).unwrap();
    let mut nodes: BTreeMap<u8, Node> = reader
        .recording()
        .unwrap()
        .devices
        .iter()
        .map(|device| {
            let (unit, memory) = from_device(device).unwrap();
            (device.position, Node::with_memory(unit, memory))
        })
        .collect();
    let mut rows = 0;
    let mut differences = Vec::new();
    for row in reader {
        let row = row.unwrap();
        rows += 1;
        let got = play(nodes.get_mut(&row.position.unwrap()).unwrap(), &row);
        differences.extend(compare(&row, got).map(|difference| difference.to_string()));
    }
    (rows, differences)
}

fn every_recording_replays(seeds: std::ops::Range<u64>, lasting_ms: u64) -> Tally {
    let mut all = Tally::default();
    let mut broken = Vec::new();
    for seed in seeds {
        let scenario = any_scenario(seed, lasting_ms);
        match recorded(&scenario, seed, lasting_ms) {
            Err(refused) => broken.push(format!("seed {seed}: {refused}")),
            Ok((file, tally)) => {
                let (rows, differences) = replayed(&file);
                assert_eq!(rows, tally.rows, "seed {seed}");
                if let Some(first) = differences.first() {
                    broken.push(format!("seed {seed}: {} differences, the first {first}", differences.len()));
                }
                all.add(&tally);
            }
        }
    }
    assert_eq!(broken, Vec::<String>::new());
    all
}

#[test]
fn every_recording_of_a_troubled_ring_replays_without_a_difference() {
    let all = every_recording_replays(0..400, 150);
    // It all happened.
    for (what, times) in [
        ("replies", all.replies),
        ("offs", all.offs),
        ("errors", all.errors),
        ("bad cycles", all.bad),
        ("silent cycles", all.silent),
    ] {
        assert!(times > 300, "only {times} {what} in {} rows", all.rows);
    }
}

#[test]
fn every_recording_long_enough_for_preset_inputs_replays_without_a_difference() {
    every_recording_replays(1_000..1_020, 2_500);
}

/// An encoder whose shaft turns and which the SSI clock switches on, long before the bus would.
fn switched_on_by_its_ssi() -> Scenario {
    let device = common::device(
        0,
        "ce-65-m",
        "motion = { kind = \"speed\", per_s = 4000000.0 }\nssi = { khz = 500, clocks = 25, every_ms = 0.1 }",
    );
    let supply = [common::set(20.0, 0, "supply_v = 0.0"), common::set(30.01, 0, "supply_v = 24.0")].concat();
    common::scenario(&format!("version = 1\n{device}{supply}"))
}

#[test]
fn the_edge_that_switched_an_encoder_on_stands_in_a_comment_of_the_recording_and_replays() {
    let (file, tally) = recorded(&switched_on_by_its_ssi(), 1, 60).unwrap();
    let text = String::from_utf8(file).unwrap();
    let edges: Vec<&str> = text.lines().filter(|line| line.starts_with("# ssi ")).collect();
    let [first, edge] = edges[..] else { panic!("{edges:?}") };
    assert_eq!(first, "# ssi 100,0,400,24.0", "a new one is switched on like that, too");
    let cells: Vec<&str> = edge.trim_start_matches("# ssi ").split(',').collect();
    let [time_us, "0", raw, "24.0"] = cells[..] else { panic!("{edge}") };
    let (time_us, raw): (f64, f64) = (time_us.parse().unwrap(), raw.parse().unwrap());
    assert!((30_010.0..30_120.0).contains(&time_us), "{edge}");
    assert!((raw - time_us * 4.0).abs() <= 1.0, "{edge}: 4 steps a microsecond");
    assert_eq!(replayed(text.as_bytes()), (tally.rows, vec![]));
    // Without it the encoder would take its samples at other times.
    let without = text.replace(&format!("{edge}\n"), "");
    let (rows, differences) = replayed(without.as_bytes());
    assert_eq!(rows, tally.rows - 1);
    assert!(!differences.is_empty());
}

#[test]
fn a_recording_that_was_changed_does_not_replay() {
    let scenario = Scenario::built_in().unwrap();
    let (file, tally) = recorded(&scenario, 1, 100).unwrap();
    assert_eq!(replayed(&file), (tally.rows, vec![]));
    let text = String::from_utf8(file).unwrap();
    // The last exchange of the CE-100 is said to have shown another position.
    let row = text.lines().rev().find(|line| line.split(',').nth(1) == Some("1")).unwrap();
    let (cells, input) = row.rsplit_once(',').unwrap();
    let other = u32::from_str_radix(input, 16).unwrap() ^ 1;
    let changed = text.replace(row, &format!("{cells},{other:08X}"));
    assert_eq!(replayed(changed.as_bytes()).1.len(), 1);
}

#[test]
fn the_same_world_writes_the_same_bytes() {
    for seed in 0..40 {
        let scenario = any_scenario(seed, 100);
        let first =
            recorded(&scenario, seed, 100).map(|(file, _)| file).map_err(|refused| refused.to_string());
        let again =
            recorded(&scenario, seed, 100).map(|(file, _)| file).map_err(|refused| refused.to_string());
        assert_eq!(first, again, "seed {seed}");
    }
}

#[test]
fn another_seed_writes_other_bytes() {
    let mut scenario = Scenario::built_in().unwrap();
    scenario.faulty_per_million = 100_000;
    let (one, _) = recorded(&scenario, 1, 200).unwrap();
    scenario.seed += 1;
    let (other, _) = recorded(&scenario, 1, 200).unwrap();
    assert_ne!(one, other);
}

#[test]
fn chance_of_0_leaves_the_bytes_of_a_recording_alone_whatever_the_seed() {
    let mut scenario = Scenario::built_in().unwrap();
    let (one, _) = recorded(&scenario, 1, 200).unwrap();
    scenario.seed = 99;
    let (other, _) = recorded(&scenario, 1, 200).unwrap();
    assert_eq!(one, other);
}

#[test]
fn a_ring_in_which_every_cycle_fails_shows_the_master_nothing() {
    let mut scenario = Scenario::built_in().unwrap();
    scenario.faulty_per_million = 1_000_000;
    let mut world = World::new(&scenario).unwrap();
    let mut input = [InWord(0x1234_5678); 3];
    for _ in 0..500 {
        world.cycle(&[OutWord(0); 3], &mut input);
    }
    assert_eq!(input, [InWord(0x1234_5678); 3]);
}

#[test]
fn rows_taken_late_are_in_order_of_time_too() {
    let scenario = any_scenario(3, 100);
    let mut world = World::new(&scenario).unwrap();
    world.record();
    let out = vec![OutWord(0); scenario.devices.len()];
    let mut input = vec![InWord(0); out.len()];
    world.change(0, &[Change::Supply(24_000)]);
    world.trouble(1, Fault::Silent, Duration::from_millis(30));
    while world.now().as_nanos() < 100 * MS {
        world.cycle(&out, &mut input);
    }
    let rows: Vec<_> = world.take_recorded().collect();
    assert!(rows.len() > 50);
    assert!(rows.is_sorted_by_key(|row| row.time_ns));
    assert_eq!(world.take_recorded().count(), 0, "what was taken is gone");
}
