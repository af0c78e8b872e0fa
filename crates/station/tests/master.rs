//! The master's side against encoders on a ring that is troubled at every moment: done and verified, or told exactly
//! what is in the encoder.
#![allow(missing_docs, clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests")]

mod common;

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use common::{assert_blameless, judged};
use encoring_bus::{Bus, EncoderMaster, MasterError};
use encoring_encoder::records::{Record, write_count};
use encoring_host::Services;
use encoring_host::preset::{Done, Preset, PresetReport};
use encoring_host::program::{Back, Program, Report, Stopped};
use encoring_host::service::{Check, Failure, ReadValue, check, read};
use encoring_host::session::{Fate, WaitedFor};
use encoring_sim::memory::CellFault;
use encoring_sim::scenario::Change;
use encoring_sim::{Eeprom, Scenario, World};
use encoring_station::{Simulated, Speed};
use encoring_words::parameter::PARAMETERS;
use encoring_words::{Duration, ErrorStatus, InWord, Model, OutWord, Parameter, ParameterSet};
use proptest::prelude::*;

const PATIENCE: Duration = Duration::from_millis(1_000);

/// Long enough for what an encoder with the usual service times has begun.
const A_SHORT_TIME: Duration = Duration::from_millis(100);

/// Long enough for the slowest services here.
const A_LONG_TIME: Duration = Duration::from_millis(4_100);

/// A ring, and a referee who looks on.
fn bus(text: &str) -> Simulated {
    let scenario = Scenario::parse("test", text, Path::new("")).unwrap();
    let mut bus = Simulated::new(World::new(&scenario).unwrap(), Speed::Max);
    bus.look_on();
    bus
}

/// One of each model, standing, with what else the file is to hold.
fn three(more: &str) -> String {
    let device = |position: usize, model: &str, raw: i64| {
        format!(
            "[[device]]\nposition = {position}\nmodel = \"{model}\"\nmotion = {{ kind = \"hold\", raw = {raw} }}\n"
        )
    };
    let devices = [device(0, "la-66", 250_000), device(1, "ce-100-m", 5_000), device(2, "ce-65-m", 5_000)];
    format!("version = 1\n{}{more}", devices.concat())
}

fn master(bus: &mut Simulated, position: usize) -> EncoderMaster<'_, Simulated> {
    EncoderMaster::new(bus, position, PATIENCE, Arc::new(AtomicBool::new(false))).unwrap()
}

// [R33]
#[test]
#[cfg(debug_assertions)]
#[should_panic(expected = "breaks the handshake: Some(FindingView { rule: \"data_with_service_bit\"")]
fn a_master_that_breaks_the_order_is_caught_by_a_strict_onlooker() {
    let mut bus = bus(&three(""));
    bus.look_on_strictly();
    for word in [0, 0x8200_0000, 0] {
        bus.cycle(Some((1, OutWord(word))), 1, &mut [InWord(0)]).unwrap();
        bus.wait(A_SHORT_TIME);
    }
}

const MODELS: [Model; 3] = [Model::La66, Model::Ce100M, Model::Ce65M];

/// Another value for everything that the model at `position` has.
fn program(position: usize) -> Program {
    let model = MODELS[position];
    let mut program = Program::new(model, Some(4096));
    for (parameter, value) in [
        (Parameter::CountingDirection, 1),
        (Parameter::MeasuringLength, 9_999),
        (Parameter::Numerator, 10),
        (Parameter::PresetValue1, 111),
        (Parameter::PresetValue2, 222),
        (Parameter::Denominator, 3),
        (Parameter::SsiValues, 0x01_00_19),
    ] {
        if parameter.service().known_to(model) {
            program.set(parameter, value).unwrap();
        }
    }
    program
}

/// What the encoder really holds: programmed and active.
fn truth(bus: &Simulated, position: usize) -> Option<(ParameterSet, ParameterSet)> {
    bus.world().with(|world| {
        let encoder = world.places()[position].node().encoder()?;
        Some((*encoder.parameters().programmed(), *encoder.active()))
    })
}

/// What a new encoder holds.
fn factory(bus: &Simulated, position: usize) -> ParameterSet {
    let unit = bus.world().with(|world| *world.places()[position].node().unit());
    ParameterSet::factory(unit.model(), unit.sensor())
}

/// A copy of a memory, to count in.
fn memory(bus: &Simulated, position: usize) -> Eeprom {
    bus.world().with(|world| world.places()[position].node().memory().clone())
}

/// Ends every trouble of the ring and switches the encoder on.
fn mend(bus: &Simulated, position: usize) {
    bus.world().with(|world| {
        world.end_trouble();
        world.change(position, &[Change::Supply(24_000)]);
    });
}

/// Whether the report says what is so.
fn told<E: std::fmt::Debug>(
    bus: &Simulated,
    position: usize,
    before: &ParameterSet,
    report: &Report<E>,
) -> Result<(), String> {
    let (programmed, active) = truth(bus, position).ok_or("the encoder is off")?;
    for row in report.rows.iter().flatten() {
        let holds = programmed.value(row.parameter);
        if row.now.is_some_and(|now| now != holds) {
            return Err(format!("{:?}: {row:?}, but it holds {holds}", report.result));
        }
        if row.wanted.is_none() && holds != before.value(row.parameter) {
            return Err(format!("{row:?} was not to be touched, but holds {holds}"));
        }
    }
    let wanted = report.rows.iter().flatten().all(|row| {
        row.wanted.is_none_or(|wanted| {
            programmed.value(row.parameter) == wanted && active.value(row.parameter) == wanted
        })
    });
    let as_before = programmed == *before && active == *before;
    match (&report.result, report.back) {
        (Ok(()), Back::NotNeeded) if wanted => Ok(()),
        (Err(_), Back::NothingWritten | Back::Restored) if as_before => Ok(()),
        // What is not known is said not to be.
        (Err(_), Back::Failed) => Ok(()),
        (result, back) => Err(format!(
            "{result:?}, {back:?}; programmed {programmed:?}, active {active:?}, before {before:?}"
        )),
    }
}

/// Programs while whatever is in the scenario happens, and compares what is told with what is so.
fn programmed(text: &str, position: usize) -> (Simulated, Report<MasterError>) {
    let mut bus = bus(text);
    let before = factory(&bus, position);
    let report = program(position).run(&mut master(&mut bus, position));
    // Whatever is switched off comes back, and what the encoder began it ends.
    mend(&bus, position);
    bus.wait(if text.contains("service_times") { A_LONG_TIME } else { A_SHORT_TIME });
    if truth(&bus, position).is_none() {
        // A dip that came after the programming.
        bus.wait(A_LONG_TIME);
    }
    let kept = judged(&mut bus).map(|judged| {
        let found = &judged.findings;
        assert!(text != three("") || judged.services > 0 && found.is_empty(), "without faults: {judged:#?}");
    });
    if let Err(problem) = told(&bus, position, &before, &report).and(kept) {
        panic!("{problem}\n{report:#?}\n{text}");
    }
    (bus, report)
}

fn moment(ms: f64) -> String {
    format!("{:.6}", ms / 1000.0)
}

fn event(at_ms: f64, position: usize, set: &str) -> String {
    format!("[[event]]\nat_s = {}\nposition = {position}\nset = {{ {set} }}\n", moment(at_ms))
}

fn line(at_ms: f64, segment: usize, fault: &str, for_ms: f64) -> String {
    let (at, lasting) = (moment(at_ms), moment(for_ms));
    format!("[[event]]\nat_s = {at}\nsegment = {segment}\nline = \"{fault}\"\nfor_s = {lasting}\n")
}

#[test]
fn every_model_is_programmed_and_verified() {
    for position in 0..3 {
        let (bus, report) = programmed(&three(""), position);
        assert_eq!((report.result, report.back), (Ok(()), Back::NotNeeded), "{position}");
        assert_eq!(report.earlier, ErrorStatus::empty());
        let (programmed, _) = truth(&bus, position).unwrap();
        // Repetition makes the number of SSI bits 24, and the report knows.
        let wanted =
            |parameter| program(position).wanted(parameter, None).unwrap_or(programmed.value(parameter));
        for parameter in PARAMETERS {
            assert_eq!(programmed.value(parameter), wanted(parameter));
        }
    }
}

#[test]
fn what_is_already_there_is_not_written_again() {
    let (mut bus, _) = programmed(&three(""), 2);
    let writes = |bus: &Simulated| {
        let mut memory = memory(bus, 2);
        PARAMETERS.map(|parameter| write_count(&mut memory, Record::Programmed(parameter)))
    };
    let before = writes(&bus);
    let report = program(2).run(&mut master(&mut bus, 2));
    assert_eq!(report.result, Ok(()));
    assert_eq!(writes(&bus), before);
    assert_blameless(&mut bus);
}

#[test]
fn what_the_data_check_would_refuse_is_not_begun() {
    let mut bus = bus(&three(""));
    let mut program = Program::new(Model::Ce65M, Some(4096));
    program.set(Parameter::Numerator, 10).unwrap();
    let report = program.run(&mut master(&mut bus, 2));
    assert_eq!(report.result, Err(Stopped::WouldBeRefused(ErrorStatus::LENGTH_TOO_LARGE)));
    assert_eq!(report.back, Back::NothingWritten);
}

#[test]
fn more_steps_than_the_rating_plate_has_are_refused_by_the_encoder_and_taken_back() {
    let mut bus = bus(&three(""));
    let before = factory(&bus, 2);
    // Believed to be one with 8192 steps.
    let mut program = Program::new(Model::Ce65M, Some(8192));
    program.set(Parameter::Numerator, 2048).unwrap();
    let report = program.run(&mut master(&mut bus, 2));
    let refused = Check { status: ErrorStatus::LENGTH_TOO_LARGE, remains: true };
    assert_eq!((&report.result, report.back), (&Err(Stopped::NotAccepted(refused)), Back::Restored));
    told(&bus, 2, &before, &report).unwrap();
    judged(&mut bus).unwrap();
}

#[test]
fn an_error_of_before_is_told_and_does_not_hinder() {
    let mut bus = bus(&three(""));
    // Service 07 is unknown.
    let at_2 = |bus: &mut Simulated, out| bus.cycle(Some((2, OutWord(out))), 2, &mut [InWord(0)]).unwrap();
    at_2(&mut bus, 0x8700_0000);
    bus.wait(Duration::from_millis(50));
    at_2(&mut bus, 0);
    bus.wait(Duration::from_millis(50));
    // What was done up to here was not our master.
    bus.look_on();
    let report = program(2).run(&mut master(&mut bus, 2));
    assert_eq!((report.result, report.earlier), (Ok(()), ErrorStatus::UNKNOWN_COMMAND));
    // It reads before it asks for the error: a data check would make values count that were not accepted.
    let found = judged(&mut bus).unwrap().findings;
    assert_eq!(found.iter().map(|found| found.rule).collect::<Vec<_>>(), ["error_ignored"]);
}

#[test]
fn a_late_acknowledgement_of_a_real_encoder_never_answers_the_next_request() {
    // Reading takes longer than the master waits: the replies come 2.5 s after their requests.
    let slow =
        "service_times = { read_ms = 2500, write_ms = 10, data_check_ms = 20, preset_adjustment_ms = 10 }";
    let mut bus = bus(&format!("version = 1\n[[device]]\nposition = 0\nmodel = \"ce-65-m\"\n{slow}\n"));
    let mut master = master(&mut bus, 0);
    let first = read(&mut master, Model::Ce65M, Parameter::MeasuringLength);
    let Err(Failure::TimedOut { timed_out, .. }) = first else { panic!("{first:?}") };
    assert_eq!((timed_out.waited_for, timed_out.fate), (WaitedFor::Acknowledgement, Fate::Unknown));
    for _ in 0..4 {
        // The same request again, so that its words cannot tell.
        let next = read(&mut master, Model::Ce65M, Parameter::MeasuringLength);
        assert!(matches!(next, Err(Failure::TimedOut { .. })), "{next:?}");
    }
    drop(master);
    judged(&mut bus).unwrap();
}

#[test]
fn supply_lost_at_every_moment_leaves_no_doubt() {
    let mut seen = [0; 3];
    for position in 0..3 {
        for k in 0..70 {
            let at = 1.0 + f64::from(k) * 2.7;
            for lasting in [0.1, 30.0, 3_000.0] {
                let dip =
                    event(at, position, "supply_v = 0.0") + &event(at + lasting, position, "supply_v = 24.0");
                let (_, report) = programmed(&three(&dip), position);
                seen[match (report.result, report.back) {
                    (Ok(()), _) => 0,
                    (Err(_), Back::Failed) => 2,
                    (Err(_), _) => 1,
                }] += 1;
            }
        }
    }
    assert!(seen.iter().all(|seen| *seen > 0), "done, restored, failed: {seen:?}");
}

#[test]
fn a_ring_that_is_silent_or_faulty_at_every_moment_leaves_no_doubt() {
    for position in 0..3 {
        for k in 0..36 {
            let at = 1.0 + f64::from(k) * 5.3;
            for (fault, lasting) in
                [("silent", 5.0), ("silent", 60.0), ("silent", 2_500.0), ("bad", 40.0), ("bad", 2_500.0)]
            {
                for segment in [position, 3] {
                    programmed(&three(&line(at, segment, fault, lasting)), position);
                }
            }
        }
    }
}

#[test]
fn a_ring_on_which_many_cycles_fail_is_only_slower_and_one_on_which_most_do_leaves_no_doubt() {
    for per_million in [1_000, 10_000, 100_000, 300_000, 800_000] {
        for seed in 0..20 {
            let text = three("").replacen(
                "version = 1\n",
                &format!("version = 1\nseed = {seed}\n[ring]\nfaulty_per_million = {per_million}\n"),
                1,
            );
            let (_, report) = programmed(&text, 1);
            if per_million <= 100_000 {
                assert_eq!(report.result, Ok(()), "{per_million}, seed {seed}");
            }
        }
    }
}

#[test]
fn slow_services_are_waited_for_or_told() {
    for (ms, done) in [(0, true), (200, true), (900, true), (1_500, false), (4_000, false)] {
        let times = format!(
            "service_times = {{ read_ms = {ms}, write_ms = {ms}, data_check_ms = {ms}, preset_adjustment_ms = {ms} }}"
        );
        let text = three("").replace("model = \"ce-65-m\"\n", &format!("model = \"ce-65-m\"\n{times}\n"));
        let (_, report) = programmed(&text, 2);
        assert_eq!(report.result.is_ok(), done, "{ms} ms: {report:?}");
    }
    // Only the data check is too slow: it is carried out, but nobody can say so.
    let times =
        "service_times = { read_ms = 0, write_ms = 10, data_check_ms = 1500, preset_adjustment_ms = 10 }";
    let text = three("").replace("model = \"ce-65-m\"\n", &format!("model = \"ce-65-m\"\n{times}\n"));
    let (_, report) = programmed(&text, 2);
    assert!(matches!(report.result, Err(Stopped::Service(Failure::TimedOut { .. }))), "{report:?}");
}

// [R154]
#[test]
fn memory_faults_at_every_moment_leave_no_doubt() {
    for position in 0..3 {
        for k in 0..60 {
            let at = 1.0 + f64::from(k) * 3.1;
            for fault in ["write", "read"] {
                let broken = event(at, position, &format!("eeprom = {{ fault = \"{fault}\" }}"));
                let mut bus = bus(&three(&broken));
                let before = factory(&bus, position);
                let report = program(position).run(&mut master(&mut bus, position));
                bus.wait(A_SHORT_TIME);
                told(&bus, position, &before, &report).unwrap();
                judged(&mut bus).unwrap();
                if let Err(Stopped::Service(Failure::Refused(refusal))) = report.result
                    && position > 0
                {
                    let eeprom = ErrorStatus::READING_DATA | ErrorStatus::WRITING_DATA;
                    assert!(refusal.repeated, "an EEPROM fault is worth one more try");
                    match refusal.check {
                        Some(check) => assert!(check.status.intersects(eeprom), "{refusal:?}"),
                        // A read before anything was written: only reads are sent.
                        None => assert_eq!(report.back, Back::NothingWritten),
                    }
                }
            }
        }
    }
}

// [R154]
#[test]
fn a_sound_memory_again_lets_a_refused_write_pass_at_the_second_try() {
    let mut bus = bus(&three(""));
    bus.world().with(|world| world.change(2, &[Change::MemoryFault(CellFault::Write, None)]));
    let mut program = Program::new(Model::Ce65M, Some(4096));
    program.set(Parameter::CountingDirection, 1).unwrap();
    let report = program.run(&mut master(&mut bus, 2));
    let Err(Stopped::Service(Failure::Refused(refusal))) = report.result else { panic!("{report:?}") };
    assert!(refusal.repeated && refusal.check.unwrap().status.contains(ErrorStatus::WRITING_DATA));
    bus.world().with(|world| world.change(2, &[Change::MemoryRepair]));
    assert_eq!(program.run(&mut master(&mut bus, 2)).result, Ok(()));
    judged(&mut bus).unwrap();
}

#[test]
fn interrupted_at_every_poll_the_old_values_are_back() {
    for at in 0..150 {
        let mut bus = bus(&three(""));
        let before = factory(&bus, 2);
        let stop = Arc::new(AtomicBool::new(false));
        let mut polls = 0;
        let mut master = EncoderMaster::new(&mut bus, 2, PATIENCE, Arc::clone(&stop)).unwrap();
        master.observe(|_| {
            if polls == at {
                stop.store(true, Ordering::Relaxed);
            }
            polls += 1;
        });
        let report = program(2).run(&mut master);
        drop(master);
        assert_ne!(report.back, Back::Failed, "poll {at}: {report:?}");
        bus.wait(A_SHORT_TIME);
        told(&bus, 2, &before, &report).unwrap();
        // Whoever is interrupted takes the bit back at once.
        if report.result.is_ok() {
            assert_blameless(&mut bus);
        }
        assert!(!bus.out(2).unwrap().service_bit());
        assert_eq!(report.result.is_err(), at < polls, "{at}");
    }
}

#[test]
fn interrupted_before_the_first_write_nothing_is_written_and_nothing_unchecked_counts() {
    for checked in [false, true] {
        let mut bus = bus(&three(""));
        let halve = encoring_host::Request::write(Model::Ce65M, Parameter::Numerator, 8_192).unwrap();
        master(&mut bus, 2).serve(halve).unwrap();
        let mut program = Program::new(Model::Ce65M, Some(4096));
        program.set(Parameter::Numerator, if checked { 8_192 } else { 8_191 }).unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let mut master = EncoderMaster::new(&mut bus, 2, PATIENCE, Arc::clone(&stop)).unwrap();
        let prepared = program.prepare(&mut master);
        assert_eq!((prepared.stopped(), prepared.changes()), (None, !checked));
        // While the question stands.
        stop.store(true, Ordering::Relaxed);
        let report = if checked { prepared.run_checked(&mut master) } else { prepared.run(&mut master) };
        assert_eq!(report.result, Err(Stopped::Service(Failure::Bus(MasterError::Interrupted))));
        assert_eq!(report.back, Back::NothingWritten);
        drop(master);
        let (_, active) = truth(&bus, 2).unwrap();
        assert_eq!(active.value(Parameter::Numerator), 4_096);
    }
}

#[test]
fn another_masters_service_bit_keeps_this_one_away() {
    let mut bus = bus(&three(""));
    bus.cycle(Some((1, OutWord(0x8200_0000))), 1, &mut [InWord(0)]).unwrap();
    let stop = Arc::new(AtomicBool::new(false));
    let refused = EncoderMaster::new(&mut bus, 1, PATIENCE, Arc::clone(&stop)).map(|_| ());
    assert_eq!(refused, Err(MasterError::OtherMaster { out: OutWord(0x8200_0000) }));
    bus.cycle(Some((1, OutWord(0))), 1, &mut [InWord(0)]).unwrap();
    bus.wait(Duration::from_millis(10));

    let mut master = EncoderMaster::new(&mut bus, 1, PATIENCE, stop).unwrap();
    read(&mut master, Model::Ce100M, Parameter::Numerator).unwrap();
    master.bus().cycle(Some((1, OutWord(0xC600_0001))), 1, &mut [InWord(0)]).unwrap();
    let refused = read(&mut master, Model::Ce100M, Parameter::Numerator);
    let other = MasterError::Overwritten { out: OutWord(0xC600_0001), ours: OutWord(0x0300_0000) };
    assert_eq!(refused, Err(Failure::Bus(other)));
}

// [R33], [R38]
#[test]
fn a_master_that_breaks_a_rule_is_told_by_who_looks_on() {
    let mut bus = bus(&three(""));
    bus.wait(Duration::from_millis(10));
    // The number comes with the service bit, and the bit falls before the encoder has looked at it.
    for out in [0x8200_0000, 0] {
        bus.cycle(Some((2, OutWord(out))), 2, &mut [InWord(0)]).unwrap();
    }
    let told = bus.judged().unwrap();
    let rules: Vec<_> =
        told.findings.iter().map(|found| (found.rule, found.verdict, found.position)).collect();
    assert_eq!(
        rules,
        [("data_with_service_bit", "broken", 2), ("dropped_before_acknowledgement", "broken", 2)]
    );
    assert_eq!(bus.judged(), None, "nobody looks on any more");
    bus.look_on();
    bus.wait(Duration::from_millis(10));
    for out in [0x0200_0000, 0x8200_0000, 0] {
        bus.cycle(Some((2, OutWord(out))), 2, &mut [InWord(0)]).unwrap();
    }
    judged(&mut bus).unwrap_err();
}

#[test]
fn an_encoder_past_the_end_of_the_ring_is_named() {
    let mut bus = bus(&three(""));
    let refused = EncoderMaster::new(&mut bus, 3, PATIENCE, Arc::new(AtomicBool::new(false))).map(|_| ());
    assert_eq!(refused.unwrap_err().to_string(), "no encoder at position 3: the ring has 3, counted from 0");
}

#[test]
fn a_ring_that_has_stopped_shows_no_position() {
    let mut bus = bus(&three(&line(1.0, 0, "silent", 1e9)));
    bus.wait(Duration::from_secs(2));
    let refused = master(&mut bus, 1).look();
    assert!(matches!(refused, Err(MasterError::Stale { .. })), "{refused:?}");
}

/// Sets the zero of a turning shaft while whatever is in the scenario happens.
fn preset(text: &str, position: usize, value: u32) -> (Simulated, Option<PresetReport<MasterError>>) {
    let mut bus = bus(text);
    let mut master = master(&mut bus, position);
    let report =
        Preset::prepare(&mut master, MODELS[position], value).ok().map(|preset| preset.adjust(&mut master));
    drop(master);
    mend(&bus, position);
    bus.wait(A_SHORT_TIME);
    let judged = judged(&mut bus).unwrap();
    assert!(text != three("") || judged.findings.is_empty(), "without faults: {judged:#?}");
    (bus, report)
}

#[test]
fn a_preset_lands_on_the_value() {
    for position in 0..3 {
        let (_, report) = preset(&three(""), position, 1_234);
        let report = report.unwrap();
        assert_eq!((report.result, report.after), (Ok(Done::Confirmed), Some(1_234)), "{position}");
        assert_ne!(report.before, Some(1_234));
    }
    let mut bus = bus(&three(""));
    check(&mut master(&mut bus, 2)).unwrap();
    let mut program = Program::new(Model::Ce65M, Some(4096));
    program.set(Parameter::MeasuringLength, 9_999).unwrap();
    program.set(Parameter::CountingDirection, 0x0100).unwrap();
    assert_eq!(program.run(&mut master(&mut bus, 2)).result, Ok(()));
    let too_far = Preset::prepare(&mut master(&mut bus, 2), Model::Ce65M, 10_000);
    assert!(matches!(too_far, Err(Failure::Request(_))), "{too_far:?}");
    let preset = Preset::prepare(&mut master(&mut bus, 2), Model::Ce65M, 1_234).unwrap();
    let report = preset.adjust(&mut master(&mut bus, 2));
    assert_eq!((report.result, report.after), (Ok(Done::Confirmed), Some(1_234)), "in Gray code");
    assert_blameless(&mut bus);
}

/// How often the offset was stored since the encoder was new.
fn offsets(bus: &Simulated, position: usize) -> u32 {
    let fresh = self::bus(&three(""));
    let count = |bus: &Simulated| write_count(&mut memory(bus, position), Record::Offset);
    count(bus) - count(&fresh)
}

#[test]
fn while_an_error_is_pending_no_preset_adjustment_is_sent() {
    for (position, model) in MODELS.into_iter().enumerate() {
        let mut bus = bus(&three(""));
        let prepared = Preset::prepare(&mut master(&mut bus, position), model, 1_234).unwrap();
        // Service 07 is unknown.
        bus.cycle(Some((position, OutWord(0x8700_0000))), position, &mut [InWord(0)]).unwrap();
        bus.wait(Duration::from_millis(50));
        bus.cycle(Some((position, OutWord(0))), position, &mut [InWord(0)]).unwrap();
        bus.wait(Duration::from_millis(50));
        let late = prepared.adjust(&mut master(&mut bus, position));
        assert!(matches!(late.result, Err(Failure::ErrorPending { .. })), "{late:?}");
        let refused = Preset::prepare(&mut master(&mut bus, position), model, 1_234);
        assert!(matches!(refused, Err(Failure::ErrorPending { .. })), "{refused:?}");
        assert_eq!(offsets(&bus, position), 0);
    }
}

#[test]
fn a_preset_adjustment_that_is_refused_is_not_done_and_checks_nothing() {
    let mut bus = bus(&three(""));
    // Programmed and not accepted: a data check would make the position another one.
    let mut master = master(&mut bus, 2);
    let halve = encoring_host::Request::write(Model::Ce65M, Parameter::Numerator, 8_192).unwrap();
    master.serve(halve).unwrap();
    let prepared = Preset::prepare(&mut master, Model::Ce65M, 1_234).unwrap();
    drop(master);
    bus.world().with(|world| world.change(2, &[Change::MemoryFault(CellFault::Write, None)]));
    let report = prepared.adjust(&mut self::master(&mut bus, 2));
    let Err(Failure::Refused(refusal)) = report.result else { panic!("{report:?}") };
    assert_eq!((refusal.check, refusal.repeated), (None, false));
    assert_eq!((report.before, report.after), (Some(5_000), Some(5_000)));
    assert!(report.shown.unwrap().error_bit());
    judged(&mut bus).unwrap();
}

#[test]
fn a_preset_adjustment_that_the_position_does_not_show_is_not_confirmed() {
    let mut unconfirmed = 0;
    for k in 0..60 {
        let jumps = event(200.0 + f64::from(k) * 0.4, 2, "raw = 900_000");
        let (bus, report) = preset(&three(&jumps), 2, 1_234);
        let report = report.unwrap();
        match report.result {
            // It stands, wherever it stands.
            Ok(Done::Confirmed) => assert_eq!(report.after, Some(1_234), "{k}"),
            Ok(Done::Acknowledged) => unconfirmed += 1,
            Err(_) => panic!("{report:?}"),
        }
        assert_eq!(offsets(&bus, 2), 1);
    }
    assert!(unconfirmed > 0, "no jump came between the acknowledgement and the look");
}

#[test]
fn reading_and_preparing_make_nothing_count_that_was_not_checked() {
    for broken in [false, true] {
        let mut bus = bus(&three(""));
        let halve = encoring_host::Request::write(Model::Ce65M, Parameter::Numerator, 8_192).unwrap();
        master(&mut bus, 2).serve(halve).unwrap();
        if broken {
            bus.world().with(|world| world.change(2, &[Change::MemoryFault(CellFault::Read, None)]));
        }
        let mut master = master(&mut bus, 2);
        for parameter in [Parameter::Numerator, Parameter::MeasuringLength] {
            let value = read(&mut master, Model::Ce65M, parameter).ok().and_then(ReadValue::sure);
            assert_eq!(value.is_none(), broken);
        }
        let mut program = Program::new(Model::Ce65M, Some(4096));
        program.set(Parameter::Numerator, 8_192).unwrap();
        let prepared = program.prepare(&mut master);
        assert_eq!(prepared.is_programmed(), !broken);
        let report = prepared.run(&mut master);
        assert_eq!((report.result.is_ok(), report.checked), (!broken, false), "{report:?}");
        drop(master);
        let (_, active) = truth(&bus, 2).unwrap();
        assert_eq!(active.value(Parameter::Numerator), 4_096);
        judged(&mut bus).unwrap();
    }
}

#[test]
fn a_preset_adjustment_is_never_carried_out_twice() {
    let mut ends = [0; 3];
    for position in 0..3 {
        let turning = format!("motion = {{ kind = \"speed\", per_s = 3000.0, start = {} }}", 5_000);
        let text = three("").replace("motion = { kind = \"hold\", raw = 5000 }", &turning);
        for k in 0..40 {
            // The shaft is watched for 100 ms twice before.
            let at = 203.0 + f64::from(k) * 0.7;
            let off = event(at, position, "supply_v = 0.0") + &event(at + 30.0, position, "supply_v = 24.0");
            for trouble in [
                off,
                line(at, position, "silent", 5.0),
                line(at, position, "silent", 2_500.0),
                line(at, 3, "bad", 2_500.0),
                line(at, 0, "bad", 20.0),
            ] {
                let (bus, report) = preset(&format!("{text}{trouble}"), position, 1_234);
                let done = offsets(&bus, position);
                assert!(done <= 1, "{done} times");
                match report.map(|report| report.result) {
                    Some(Ok(_)) => assert_eq!(done, 1),
                    Some(Err(Failure::TimedOut { timed_out, .. })) => match timed_out.fate {
                        Fate::NotSent => assert_eq!(done, 0),
                        Fate::CarriedOut(_) => assert_eq!(done, 1),
                        Fate::Unknown => ends[usize::try_from(done).unwrap()] += 1,
                    },
                    Some(Err(Failure::Bus(_) | Failure::Request(_))) | None => assert_eq!(done, 0),
                    other => panic!("{other:?}"),
                }
            }
        }
    }
    assert!(ends[0] > 0 && ends[1] > 0, "both ends of what nobody knows were met: {ends:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Any troubles, one after the other and at once.
    #[test]
    fn any_trouble_leaves_no_doubt(
        position in 0_usize..3,
        seed: u64,
        per_million in prop_oneof![Just(0_u32), 0..500_000_u32],
        write_ms in prop_oneof![Just(10), 0..1_400],
        troubles in prop::collection::vec((0_u8..4, 1.0..400.0_f64, 0.05..1_500.0_f64, 0_usize..4), 0..5),
    ) {
        let mut text = format!(
            "version = 1\nseed = {}\n[ring]\nfaulty_per_million = {per_million}\n",
            seed >> 1
        );
        text += &three("").replacen("version = 1\n", "", 1);
        let times = format!(
            "service_times = {{ read_ms = 1, write_ms = {write_ms}, data_check_ms = 20, preset_adjustment_ms = 10 }}\nmotion"
        );
        text = text.replace("motion", &times);
        for (kind, at, lasting, segment) in troubles {
            text += &match kind {
                0 => line(at, segment, "silent", lasting),
                1 => line(at, segment, "bad", lasting),
                _ => event(at, segment % 3, "supply_v = 0.0")
                    + &event(at + lasting, segment % 3, "supply_v = 24.0"),
            };
        }
        programmed(&text, position);
    }
}
