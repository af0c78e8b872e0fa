//! Programming that ends in the middle, and a replacement that goes through: on the simulated ring in this process.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    missing_docs,
    reason = "a test may panic"
)]

use std::fmt;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use encoring_bus::bus::{Cycle, Settling};
use encoring_bus::release::Release;
use encoring_bus::{Bus, BusError, Cause, EncoderMaster};
use encoring_host::Services;
use encoring_host::preset::{Preset, code, position};
use encoring_host::program::{Back, Program};
use encoring_sim::motion::Motion;
use encoring_sim::scenario::{Change, NewMotion};
use encoring_sim::{Scenario, World};
use encoring_station::{SharedWorld, Simulated, Speed};
use encoring_words::model::{MODELS, Sensor};
use encoring_words::{Duration, InWord, Instant, Model, OutWord, Parameter};
use encoring_workshop::backup::BackupOrigin;
use encoring_workshop::journal::{EncoderPlace, Found, Journal, Page};
use encoring_workshop::reading::Readings;
use encoring_workshop::values::parameters_of;
use encoring_workshop::zero::{ZeroRestored, set_of};
use encoring_workshop::{ParameterFile, UnitLabel};

const PATIENCE: Duration = Duration::from_millis(40);

/// A bus that is dead after so many calls, while the ring behind it goes on: whoever uses it has been killed.
struct Cut {
    ring: Simulated,
    calls: u32,
    left: u32,
}

impl Cut {
    fn call(&mut self) -> Result<(), BusError> {
        if self.left == 0 {
            // Time goes on.
            self.ring.wait(Duration::from_millis(1));
            return Err(BusError::NoConnection(Cause::System(std::io::ErrorKind::BrokenPipe)));
        }
        self.calls += 1;
        self.left -= 1;
        Ok(())
    }

    const fn is_dead(&self) -> bool {
        self.left == 0
    }
}

impl Bus for Cut {
    fn now(&self) -> Instant {
        self.ring.now()
    }

    fn out(&mut self, position: usize) -> Result<OutWord, BusError> {
        self.call()?;
        self.ring.out(position)
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        self.call()?;
        self.ring.cycle(write, first, input)
    }

    fn wait(&mut self, span: Duration) {
        self.ring.wait(span);
    }

    fn settling(&self) -> Settling {
        self.ring.settling()
    }
}

/// What stands on a type label.
#[derive(Clone, Copy)]
struct Label {
    model: Model,
    /// Steps per turn; `None` for a rod.
    native: Option<u32>,
}

impl Label {
    fn usual(model: Model) -> Self {
        let native = match model.usual_sensor() {
            Sensor::Rotary { steps_per_turn } => Some(steps_per_turn),
            Sensor::Linear { .. } => None,
        };
        Self { model, native }
    }

    /// Every model with every number of steps per turn that it is built with.
    fn all() -> impl Iterator<Item = Self> {
        MODELS.into_iter().flat_map(|model| match model.steps_per_turn() {
            [] => vec![Self { model, native: None }],
            several => several.iter().map(|native| Self { model, native: Some(*native) }).collect(),
        })
    }

    /// Where a shaft or a magnet can be, in steps of the sensor or micrometres.
    fn places(self) -> u64 {
        self.native.map_or(500_000, |native| u64::from(native) * 4096)
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { model, native } = self;
        match native {
            Some(native) => write!(f, "{model} of {native} steps per turn"),
            None => write!(f, "{model}"),
        }
    }
}

/// One encoder that stands still.
fn ring(label: Label, seed: u64) -> (Cut, SharedWorld) {
    let Label { model, native } = label;
    let native = native.map(|native| format!("native = {native}\n")).unwrap_or_default();
    let text = format!(
        "version = 1\nseed = {seed}\n[[device]]\nposition = 0\nmodel = \"{model}\"\n{native}motion = {{ kind = \
         \"hold\", raw = 100_000 }}\n"
    );
    let scenario = Scenario::parse("ring.toml", &text, Path::new(".")).unwrap();
    let mut ring = Simulated::new(World::new(&scenario).unwrap(), Speed::Max);
    ring.look_on_strictly();
    let world = ring.world().clone();
    (Cut { ring, calls: 0, left: u32::MAX }, world)
}

fn master(bus: &mut Cut) -> EncoderMaster<'_, Cut> {
    EncoderMaster::new(bus, 0, PATIENCE, Arc::new(AtomicBool::new(false))).unwrap()
}

/// What is programmed in the encoder, seen from within.
fn programmed(world: &SharedWorld) -> impl Fn(Parameter) -> u32 + use<> {
    let set = world.with(|world| *world.places()[0].node().encoder().unwrap().parameters().programmed());
    move |parameter| set.value(parameter)
}

fn active(world: &SharedWorld, parameter: Parameter) -> u32 {
    world.insight(0).unwrap().active.value(parameter)
}

/// Chance that can be repeated (SplitMix64).
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % limit
    }
}

/// A legal set of a model.
fn any_set(label: Label, chance: &mut Chance) -> Vec<(Parameter, u32)> {
    let model = label.model;
    loop {
        let values: Vec<_> = parameters_of(model)
            .map(|parameter| {
                let (low, high) = parameter.range(model).unwrap_or((0, 0));
                let value = match parameter {
                    Parameter::CountingDirection if model.position_may_be_gray() => {
                        (chance.below(2) << 8 | chance.below(2)) as u32
                    }
                    Parameter::SsiValues => 24 + chance.below(2) as u32,
                    Parameter::Numerator => 1 + chance.below(0xFFFF) as u32,
                    _ => low + chance.below(u64::from(high - low) + 1) as u32,
                };
                (parameter, value)
            })
            .collect();
        if program(label, &values).judge(set_of(model, &values)).is_empty() {
            return values;
        }
    }
}

fn program(label: Label, values: &[(Parameter, u32)]) -> Program {
    let mut program = Program::new(label.model, label.native);
    for (parameter, value) in values {
        program.set(*parameter, *value).unwrap();
    }
    program
}

/// Programs an encoder with a note in the journal, as a command does, and gives the calls of the bus; a bus that died
/// in the middle leaves the note.
fn noted(bus: &mut Cut, page: &Page, wanted: Program) -> u32 {
    let before = bus.calls;
    let Ok(mut master) = EncoderMaster::new(bus, 0, PATIENCE, Arc::new(AtomicBool::new(false))) else {
        return 0;
    };
    let prepared = wanted.prepare(&mut master);
    if prepared.stopped().is_some() {
        drop(master);
        return bus.calls - before;
    }
    page.begin(&prepared, "restore", "now".to_owned(), Some("old.toml".to_owned()), None).unwrap();
    let report = prepared.run_checked(&mut master);
    drop(master);
    if !bus.is_dead() {
        assert_eq!(report.result, Ok(()));
        page.settle(&report, None).unwrap();
    }
    bus.calls - before
}

/// Whoever comes next: takes back a service bit that was left, and reads everything.
fn next(bus: &mut Cut, model: Model) -> Readings<encoring_bus::master::MasterError> {
    bus.left = u32::MAX;
    // The one before was killed wherever it was.
    bus.ring.look_on_strictly();
    let stop = AtomicBool::new(false);
    let mut release = Release::new(bus, 0, PATIENCE, &stop);
    let standing = release.look().unwrap();
    if standing.out.service_bit() {
        release.clear(standing).unwrap();
    }
    Readings::of(&mut master(bus), model).unwrap()
}

// [R79, R81]
#[test]
fn a_command_that_is_killed_after_any_exchange_is_told_by_the_next_one_and_repaired() {
    let folder = tempfile::tempdir().unwrap();
    let place = EncoderPlace { bus: "here".to_owned(), position: 0 };
    let page = Page::new(Journal::in_folder(folder.path().to_owned()), place);
    for label in Label::all() {
        let model = label.model;
        let mut chance = Chance(7);
        let (old, wanted) = (any_set(label, &mut chance), any_set(label, &mut chance));
        let whole = {
            let (mut bus, _) = ring(label, 1);
            noted(&mut bus, &page, program(label, &old));
            noted(&mut bus, &page, program(label, &wanted))
        };
        let mut seen: Vec<(&str, u32)> = Vec::new();
        for cut in 0..=whole {
            let (mut bus, world) = ring(label, 1);
            noted(&mut bus, &page, program(label, &old));
            assert_eq!(page.pending(), Ok(None));
            bus.left = cut;
            noted(&mut bus, &page, program(label, &wanted));
            let readings = next(&mut bus, model);
            let truth = programmed(&world);
            let value = |parameter| readings.values().find(|(read, _)| *read == parameter)?.1;
            let Some(intent) = page.pending().unwrap() else {
                // It had not begun to write, or was through.
                let untouched = old.iter().all(|(parameter, old)| truth(*parameter) == *old);
                assert!(untouched || cut == whole, "{label} {cut}");
                continue;
            };
            // What is told is what is so.
            let found = intent.found(value);
            let changed: Vec<_> = old.iter().zip(&wanted).filter(|(old, wanted)| old != wanted).collect();
            let written =
                changed.iter().filter(|(_, (parameter, wanted))| truth(*parameter) == *wanted).count();
            let expected = match written {
                0 => Found::Untouched,
                all if all == changed.len() => Found::AllWritten,
                _ => Found::PartWritten,
            };
            assert_eq!(found, expected, "{label} {cut}");
            match seen.iter_mut().find(|(name, _)| *name == found.name()) {
                Some((_, times)) => *times += 1,
                None => seen.push((found.name(), 1)),
            }
            assert!(!intent.told(found, value).is_empty());
            // Restoring the new values, or the old ones of the backup, makes them count.
            let target = if cut % 2 == 0 { &wanted } else { &old };
            noted(&mut bus, &page, program(label, target));
            assert_eq!(page.pending(), Ok(None), "{label} {cut}");
            for (parameter, value) in target {
                assert_eq!(programmed(&world)(*parameter), *value, "{label} {cut}");
                assert_eq!(active(&world, *parameter), *value, "{label} {cut}");
            }
        }
        println!("{label}: killed after each of {whole} exchanges: {seen:?}");
        assert_eq!(seen.len(), 3, "{seen:?}");
    }
}

// [R80]
#[test]
fn a_half_programmed_set_works_after_a_power_cut_without_an_error_and_the_next_command_tells() {
    let folder = tempfile::tempdir().unwrap();
    let place = EncoderPlace { bus: "here".to_owned(), position: 0 };
    let page = Page::new(Journal::in_folder(folder.path().to_owned()), place);
    let label = Label::usual(Model::Ce65M);
    let wanted = [(Parameter::MeasuringLength, 9_999), (Parameter::Numerator, 4_095)];
    let part_written = (0..).find_map(|cut| {
        let (mut bus, world) = ring(label, 1);
        bus.left = cut;
        noted(&mut bus, &page, program(label, &wanted));
        next(&mut bus, label.model);
        let truth = programmed(&world);
        let half = truth(Parameter::MeasuringLength) == 9_999 && truth(Parameter::Numerator) == 4_096;
        half.then_some((bus, world))
    });
    let (mut bus, world) = part_written.unwrap();
    assert_eq!(active(&world, Parameter::MeasuringLength), 16_777_215);
    for supply in [0, 24_000] {
        world.with(|world| world.change(0, &[Change::Supply(supply)]));
        bus.wait(Duration::from_millis(3_000));
    }
    assert_eq!(
        [Parameter::MeasuringLength, Parameter::Numerator].map(|of| active(&world, of)),
        [9_999, 4_096]
    );
    assert!(!master(&mut bus).look().unwrap().error_bit(), "the encoder tells nothing");
    let readings = next(&mut bus, label.model);
    let value = |parameter| readings.values().find(|(read, _)| *read == parameter)?.1;
    assert_eq!(page.pending().unwrap().unwrap().found(value), Found::PartWritten);
}

#[test]
fn an_encoder_that_fails_in_the_middle_leaves_the_note_only_if_something_is_half_done() {
    let folder = tempfile::tempdir().unwrap();
    let place = EncoderPlace { bus: "here".to_owned(), position: 0 };
    let page = Page::new(Journal::in_folder(folder.path().to_owned()), place);
    let label = Label::usual(MODELS[2]);
    let mut chance = Chance(11);
    let (old, wanted) = (any_set(label, &mut chance), any_set(label, &mut chance));
    let mut failed = 0;
    for cell in 0..40 {
        let (mut bus, world) = ring(label, 1);
        noted(&mut bus, &page, program(label, &old));
        world.with(|world| {
            world.change(0, &[Change::MemoryFault(encoring_sim::CellFault::Write, Some(cell * 16))]);
        });
        let mut master = master(&mut bus);
        let prepared = program(label, &wanted).prepare(&mut master);
        page.begin(&prepared, "restore", "now".to_owned(), None, None).unwrap();
        let report = prepared.run_checked(&mut master);
        page.settle(&report, None).unwrap();
        let half_done = report.result.is_err() && report.back == Back::Failed;
        assert_eq!(page.pending().unwrap().is_some(), half_done, "{cell}: {report:?}");
        failed += u32::from(report.result.is_err());
        page.take_back(None).unwrap();
    }
    assert!(failed > 0);
}

/// What the encoder shows with the shaft or the magnet at these places.
fn shows(bus: &mut Cut, world: &SharedWorld, model: Model, places: &[i64]) -> Vec<u32> {
    let code = code(&mut master(bus), model).unwrap();
    places
        .iter()
        .map(|raw| {
            stand(bus, world, *raw);
            position(master(bus).look().unwrap(), code).unwrap()
        })
        .collect()
}

fn stand(bus: &mut Cut, world: &SharedWorld, raw: i64) {
    world.with(|world| world.change(0, &[Change::Motion(NewMotion::Motion(Motion::Hold { raw }))]));
    bus.wait(Duration::from_millis(3));
}

fn preset(bus: &mut Cut, model: Model, value: u32) {
    let mut master = master(bus);
    let preset = Preset::prepare(&mut master, model, value).unwrap();
    assert!(preset.adjust(&mut master).result.is_ok());
}

/// Backup, a new unit, the values, the zero at one mark: how far the positions are from those of the old unit.
fn replaced(label: Label, seed: u64, grid: i64) -> (ZeroRestored, Vec<i64>) {
    let Label { model, native } = label;
    let mut chance = Chance(seed);
    let values = any_set(label, &mut chance);
    let (mut old, old_world) = ring(label, 1);
    let report = program(label, &values).run(&mut master(&mut old));
    assert_eq!(report.result, Ok(()), "{seed}");
    let set = set_of(model, &values);
    let largest = u64::from(model.largest_position(set.measuring_length()));
    let most = label.places();
    stand(&mut old, &old_world, chance.below(most) as i64);
    preset(&mut old, model, chance.below(largest + 1) as u32);
    let places: Vec<i64> =
        (0..grid).map(|k| k * most as i64 / grid + chance.below(most / grid as u64) as i64).collect();
    let before = shows(&mut old, &old_world, model, &places);
    // The backup goes through its text.
    let readings = Readings::of(&mut master(&mut old), model).unwrap();
    let at = std::time::SystemTime::UNIX_EPOCH;
    let origin = BackupOrigin { at, bus: "here", position: 0, shown: None };
    let file = ParameterFile::from(origin.backup(model, UnitLabel::default(), readings.values()));
    let file = ParameterFile::parse("backup.toml", &file.text()).unwrap();
    let kept = file.at(Some(0)).unwrap();
    assert_eq!(kept.values, values, "{seed}");
    let (mut new, new_world) = ring(label, 2);
    assert_eq!(program(label, &kept.values).run(&mut master(&mut new)).result, Ok(()), "{seed}");
    let mark = chance.below(grid as u64) as usize;
    stand(&mut new, &new_world, places[mark]);
    preset(&mut new, model, before[mark]);
    let after = shows(&mut new, &new_world, model, &places);
    assert_eq!(after[mark], before[mark], "{seed}: equal at the mark");
    let period = largest as i64 + 1;
    let off = before.iter().zip(&after).map(|(before, after)| {
        let off = (i64::from(*after) - i64::from(*before)).rem_euclid(period);
        if off > period / 2 { off - period } else { off }
    });
    (ZeroRestored::of(model, &set, native), off.collect())
}

/// How so many random sets of each model fare, at so many angles each.
fn round_trips(cases: u64, grid: i64) {
    for label in Label::all() {
        let (mut equal, mut lower, mut exact) = (0_u64, 0_u64, 0_u64);
        for seed in 0..cases {
            let (restored, off) = replaced(label, seed, grid);
            let all_equal = off.iter().all(|off| *off == 0);
            match restored {
                ZeroRestored::Everywhere | ZeroRestored::OfARod => assert!(all_equal, "{label} seed {seed}"),
                _ => assert!(off.iter().all(|off| (-1..=0).contains(off)), "{label} seed {seed}: {off:?}"),
            }
            exact += u64::from(all_equal);
            equal += off.iter().filter(|off| **off == 0).count() as u64;
            lower += off.iter().filter(|off| **off == -1).count() as u64;
        }
        println!(
            "{label}: {cases} random sets, {grid} angles each: {equal} equal, {lower} one step lower; {exact} sets equal \
             everywhere"
        );
        assert!(equal > 0);
    }
}

// [R73, R76]
#[test]
fn after_a_replacement_the_positions_are_those_of_before_as_far_as_a_preset_can_restore_them() {
    round_trips(12, 150);
}

#[test]
#[ignore = "minutes; in .ci/long"]
fn two_hundred_random_encoders_of_each_model_are_replaced() {
    round_trips(200, 2_000);
}
