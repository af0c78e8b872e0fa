//! A ring that runs in its thread: how it starts and ends, what others see and change, what it leaves behind.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Duration as Real;

use encoring_encoder::handshake::Handshake;
use encoring_encoder::{Magnet, Unit};
use encoring_ring::Verdict;
use encoring_sim::device_line::to_device;
use encoring_sim::motion::Motion;
use encoring_sim::scenario::{Change, NewMotion};
use encoring_sim::state::{NotSaved, StateFolder};
use encoring_sim::{Fault, Scenario, Shown, Waveform, World, state};
use encoring_station::Recorder;
use encoring_station::{Handle, Happened, Keeper, Options, RingStopped, Speed, Station, View, WordChange};
use encoring_trace::wave::{self, Format};
use encoring_trace::{Reader, Row, Writer};
use encoring_words::{Duration, InWord, OutWord, Written};

const SERVICE_BIT: u32 = 1 << 31;

/// An LA-66, a CE-100 and a CE-65 that stand still; service times 0.
const STANDING: &str = r#"
version = 1
[[device]]
position = 0
model = "la-66"
service_times = "zero"
motion = { kind = "hold", raw = 10_000 }
[[device]]
position = 1
model = "ce-100-m"
service_times = "zero"
motion = { kind = "hold", raw = 2_000 }
[[device]]
position = 2
model = "ce-65-m"
service_times = "zero"
motion = { kind = "hold", raw = 3_000 }
"#;

const CYCLE_NS: u64 = 677_000;

fn scenario(text: &str) -> Scenario {
    Scenario::parse("test", text, Path::new("")).unwrap()
}

fn world() -> World {
    World::new(&scenario(STANDING)).unwrap()
}

fn at(speed: Speed) -> Options {
    Options { speed, ..Options::default() }
}

/// Longer than anything takes that is waited for.
const A_MINUTE: Real = Real::from_secs(60);

/// Waits until something holds; a minute is longer than any test takes that passes.
fn wait_for(what: &str, mut holds: impl FnMut() -> bool) {
    for _ in 0..60_000 {
        if holds() {
            return;
        }
        thread::park_timeout(Real::from_millis(1));
    }
    panic!("waited in vain for {what}");
}

fn input(handle: &Handle, position: usize) -> u32 {
    handle.image().with(|image| image.input()[position].0)
}

fn set_out(handle: &Handle, position: usize, word: u32) {
    handle.image().with(|image| image.out_mut()[position] = OutWord(word));
}

/// A request, its reply, and the end of the request.
fn service(handle: &Handle, position: usize, request: u32) -> u32 {
    set_out(handle, position, request);
    wait_for("a reply", || input(handle, position) & SERVICE_BIT != 0);
    let reply = input(handle, position);
    set_out(handle, position, request & !SERVICE_BIT);
    wait_for("normal mode", || input(handle, position) & SERVICE_BIT == 0);
    reply
}

/// A file in memory that others can look into, and that is full at some point.
#[derive(Clone, Default)]
struct Sink {
    bytes: Arc<Mutex<Vec<u8>>>,
    full_after: Option<usize>,
    flush_fails: bool,
}

impl Sink {
    fn record(&self, world: &World) -> Recorder {
        let devices: Vec<_> = world
            .places()
            .iter()
            .zip(0..)
            .map(|(place, position)| to_device(position, place.node().unit(), place.node().memory()))
            .collect();
        let sink: Box<dyn Write + Send> = Box::new(self.clone());
        Recorder::Exchanges(Writer::recording(sink, &devices).unwrap())
    }

    fn rows(&self) -> Vec<Row> {
        let bytes = self.bytes.lock().unwrap();
        // A row is written with one call, so what stands there is whole.
        Reader::new("recording.csv", bytes.as_slice()).unwrap().map(Result::unwrap).collect()
    }
}

impl Write for Sink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut file = self.bytes.lock().unwrap();
        if self.full_after.is_some_and(|limit| file.len() + bytes.len() > limit) {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        file.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        if self.flush_fails { Err(io::Error::from(io::ErrorKind::BrokenPipe)) } else { Ok(()) }
    }
}

impl Seek for Sink {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        Ok(self.bytes.lock().unwrap().len() as u64)
    }
}

#[test]
fn a_station_ends_by_itself_after_the_cycles_that_fill_its_time() {
    for (until, cycles) in [
        (Duration::from_secs(1), 1_478),
        (Duration(10 * CYCLE_NS), 10),
        (Duration(10 * CYCLE_NS + 1), 11),
        (Duration(64 * CYCLE_NS), 64),
    ] {
        let options = Options { until: Some(until), ..at(Speed::Max) };
        let station = Station::start(world(), options).unwrap();
        wait_for("the end", || station.is_finished());
        let outcome = station.stop().unwrap();
        assert_eq!(outcome.view.counters.cycles, cycles);
        assert_eq!(outcome.view.time_ns, cycles * CYCLE_NS);
        assert_eq!((outcome.view.counters.faulty_cycles, outcome.view.counters.dropped_cycles), (0, 0));
        assert_eq!(outcome.view.cycle_ns, CYCLE_NS);
        assert!(outcome.recorded.iter().all(Result::is_ok));
        assert_eq!(outcome.memories.len(), 3);
    }
}

#[test]
fn the_image_shows_the_positions_as_soon_as_the_station_has_started() {
    let station = Station::start(world(), at(Speed::Millionths(1_000))).unwrap();
    let shown = station.handle().image().with(|image| image.input().to_vec());
    assert_eq!(shown, [InWord(1_000), InWord(2_000), InWord(3_000)]);
    station.stop().unwrap();
}

#[test]
fn a_service_goes_over_the_image_and_comes_back() {
    let station = Station::start(world(), at(Speed::REAL)).unwrap();
    let handle = station.handle();
    assert_eq!(service(handle, 1, 0xC200_270F), 0xC200_270F);
    assert_eq!(service(handle, 1, 0x8200_0000), 0x8200_270F);
    assert_eq!(service(handle, 2, 0x8200_0000), 0x82FF_FFFF);
    let view = handle.view().unwrap();
    let value = |service, programmed| {
        let parameter = view.devices[1].parameters.iter().find(|p| p.service == service).unwrap();
        if programmed { parameter.programmed } else { parameter.active }
    };
    assert_eq!((value(2, true), value(2, false)), (0x270F, 0xFF_FFFF));
    station.stop().unwrap();
}

#[test]
fn both_halves_written_in_one_piece_are_never_torn() {
    let (world, sink) = (world(), Sink::default());
    let records = vec![sink.record(&world)];
    let station = Station::start(world, Options { records, ..at(Speed::Max) }).unwrap();
    let handle = station.handle();
    let mut last = 0;
    for value in 0..20_000_u16 {
        let value = value & 0x7FFF;
        handle.image().with(|image| {
            image.write_out(1, Written::High(value));
            image.write_out(1, Written::Low(value));
        });
        if value % 200 == 0 {
            wait_for("another cycle", || {
                let cycles = handle.view().unwrap().counters.cycles;
                std::mem::replace(&mut last, cycles) != cycles
            });
        }
    }
    let outcome = station.stop().unwrap();
    assert!(outcome.recorded.iter().all(Result::is_ok));
    let words: Vec<u32> =
        sink.rows().iter().filter(|row| row.position == Some(1)).map(|row| row.out.unwrap()).collect();
    assert!(words.windows(2).filter(|pair| pair[0] != pair[1]).count() > 20);
    for word in words {
        assert_eq!(word >> 16, word & 0xFFFF, "torn: {word:08X}");
    }
}

#[test]
fn halves_written_one_after_the_other_are_torn_if_a_cycle_comes_between() {
    let (world, sink) = (world(), Sink::default());
    let records = vec![sink.record(&world)];
    let station = Station::start(world, Options { records, ..at(Speed::REAL) }).unwrap();
    let handle = station.handle();
    let next_cycle = || {
        let before = handle.view().unwrap().counters.cycles;
        wait_for("a cycle", || handle.view().unwrap().counters.cycles > before);
    };
    handle.image().with(|image| image.write_out(1, Written::High(0x1234)));
    next_cycle();
    handle.image().with(|image| image.write_out(1, Written::Low(0x1234)));
    next_cycle();
    station.stop().unwrap();
    let mut words: Vec<u32> =
        sink.rows().iter().filter(|row| row.position == Some(1)).map(|row| row.out.unwrap()).collect();
    words.dedup();
    assert_eq!(words, [0, 0x1234_0000, 0x1234_1234]);
}

#[test]
fn a_change_is_seen_in_the_next_view() {
    let station = Station::start(world(), at(Speed::REAL)).unwrap();
    let handle = station.handle();
    for round in 0..50_i64 {
        let raw = 1_000 + round;
        let motion = Change::Motion(NewMotion::Motion(Motion::Hold { raw }));
        handle
            .change(1, vec![motion, Change::Preset { input: 1, millivolts: 9_000 + round as u32 }])
            .unwrap();
        let view = handle.view().unwrap();
        assert_eq!(view.devices[1].raw, raw);
        assert_eq!(view.devices[1].preset_mv, [0, 9_000 + round as u32]);
    }
    handle.change(1, vec![Change::Supply(28_351)]).unwrap();
    let view = handle.view().unwrap();
    assert_eq!(
        (view.devices[1].supply_mv, view.devices[1].overvoltage, view.devices[1].on),
        (28_351, true, true)
    );
    handle.change(1, vec![Change::Supply(10_449)]).unwrap();
    let view = handle.view().unwrap();
    assert_eq!(
        (view.devices[1].supply_mv, view.devices[1].overvoltage, view.devices[1].on),
        (10_449, false, false)
    );
    assert_eq!((view.devices[1].handshake, view.devices[1].value), (None, None));
    let silent = handle.wait_event(0, A_MINUTE).unwrap().remove(0);
    assert_eq!(silent.what, Happened::LineSilent { segment: 1 });
    handle.change(1, vec![Change::Supply(24_000)]).unwrap();
    wait_for("a good cycle", || handle.view().unwrap().line == Verdict::Good);
    let later = handle.wait_event(silent.number + 1, A_MINUTE).unwrap();
    assert_eq!(later.last().unwrap().what, Happened::LineGood, "{later:?}");
    handle.change(0, vec![Change::Magnet(Magnet::Missing)]).unwrap();
    wait_for("the error bit", || handle.view().unwrap().devices[0].error);
    assert_eq!(handle.view().unwrap().devices[0].latched_status.bits(), 0x0020);
    station.stop().unwrap();
}

#[test]
fn a_trouble_is_counted_until_it_is_ended() {
    let station = Station::start(world(), at(Speed::REAL)).unwrap();
    let handle = station.handle();
    assert_eq!(handle.view().unwrap().counters.faulty_cycles, 0);
    handle.trouble(2, Some((Fault::Bad, Duration(u64::MAX)))).unwrap();
    wait_for("bad cycles", || handle.view().unwrap().diagnosis.segment_faults[2] >= 3);
    let view = handle.view().unwrap();
    assert_eq!([0, 1, 3].map(|segment| view.diagnosis.segment_faults[segment]), [0; 3]);
    assert!(view.counters.faulty_cycles >= 3);
    handle.trouble(2, None).unwrap();
    wait_for("a good cycle", || handle.view().unwrap().line == Verdict::Good);
    let View { counters, diagnosis, .. } = handle.view().unwrap();
    wait_for("ten more cycles", || handle.view().unwrap().counters.cycles >= counters.cycles + 10);
    assert_eq!(handle.view().unwrap().counters.faulty_cycles, counters.faulty_cycles);
    let seen = handle.image().with(|image| (image.status(), image.parameter(), image.faults().to_vec()));
    assert_eq!(seen, (0x00E0, 0, diagnosis.segment_faults));
    station.stop().unwrap();
}

#[test]
fn the_view_says_how_a_handshake_stands() {
    let slow = STANDING.replace("service_times = \"zero\"", "service_times = { read_ms = 60_000 }");
    let station = Station::start(World::new(&scenario(&slow)).unwrap(), at(Speed::REAL)).unwrap();
    let handle = station.handle();
    assert_eq!(handle.view().unwrap().devices[2].handshake, Some(Handshake::Normal));
    set_out(handle, 2, 0x8200_0000);
    wait_for("the request", || {
        matches!(handle.view().unwrap().devices[2].handshake, Some(Handshake::Busy { .. }))
    });
    assert_eq!(handle.view().unwrap().devices[2].out, OutWord(0x8200_0000));
    handle.change(2, vec![Change::Supply(0)]).unwrap();
    handle.change(2, vec![Change::Supply(24_000)]).unwrap();
    wait_for("power-up", || handle.view().unwrap().devices[2].handshake == Some(Handshake::Ignoring));
    station.stop().unwrap();
}

fn units() -> Vec<Unit> {
    scenario(STANDING).devices.iter().map(|device| device.unit).collect()
}

#[test]
fn the_keeper_writes_what_changes_and_at_the_end_the_turn_count() {
    let folder = tempfile::tempdir().unwrap();
    let units = units();
    let image = |position: usize| {
        state::read(folder.path(), position, &units[position]).unwrap().map(|kept| *kept.memory.image())
    };
    let mut world = world();
    let memories = StateFolder::open(folder.path(), &mut world).unwrap();
    let station = Station::start(world, at(Speed::REAL)).unwrap();
    let handle = station.handle();
    let keeper = Keeper::start(handle.clone(), memories, units.clone());
    wait_for("the first files", || image(2).is_some());
    let first: Vec<_> = (0..3).map(|position| image(position).unwrap()).collect();
    assert_eq!(service(handle, 1, 0xC200_270F), 0xC200_270F);
    wait_for("the new memory in its file", || image(1).unwrap() != first[1]);
    assert_eq!(image(2).unwrap(), first[2]);

    // More turns than the sensor knows: only the turn count can tell them.
    let far = 5_000 * 4_096 + 17;
    handle.change(2, vec![Change::Motion(NewMotion::Motion(Motion::Hold { raw: far }))]).unwrap();
    wait_for("the new place", || input(handle, 2) == far as u32 & 0xFF_FFFF);
    let outcome = station.stop().unwrap();
    keeper.finish(&outcome.memories).unwrap();
    for position in 0..3 {
        assert_eq!(image(position).unwrap(), *outcome.memories[position].image());
    }

    let mut world = self::world();
    StateFolder::open(folder.path(), &mut world).unwrap();
    let motion = Change::Motion(NewMotion::Motion(Motion::Hold { raw: far }));
    world.change(2, &[motion]);
    let station = Station::start(world, at(Speed::REAL)).unwrap();
    let handle = station.handle();
    assert_eq!(service(handle, 1, 0x8200_0000), 0x8200_270F);
    // Three turns of 4096 steps: 5000 turns are two of them, the 904 that the sensor knows are one.
    assert_eq!(service(handle, 2, 0xC200_2FFF), 0xC200_2FFF);
    assert_eq!(service(handle, 2, 0xC300_0003), 0xC300_0003);
    assert_eq!(service(handle, 2, 0x8800_0000), 0x8800_0000);
    wait_for("the position", || input(handle, 2) == 2 * 4_096 + 17);
    station.stop().unwrap();
}

#[test]
fn a_memory_that_cannot_be_written_is_told_at_once_and_so_is_its_end_and_the_others_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = |position| state::file(folder.path(), position);
    let mut world = world();
    let memories = StateFolder::open(folder.path(), &mut world).unwrap();
    // No file can take the place of a folder.
    std::fs::create_dir(file(0)).unwrap();
    let station = Station::start(world, at(Speed::REAL)).unwrap();
    let handle = station.handle();
    let keeper = Keeper::start(handle.clone(), memories, units());
    wait_for("the event", || !handle.events(0).unwrap().is_empty());
    let [event] = &handle.events(0).unwrap()[..] else { panic!("one event") };
    let Happened::MemoryNotSaved { position: 0, problem } = &event.what else { panic!("{event:?}") };
    assert!(problem.contains("encoder-0.toml: ") && event.what.is_trouble(), "{problem}");
    wait_for("the others", || file(1).is_file() && file(2).is_file());
    std::fs::remove_dir(file(0)).unwrap();
    wait_for("the end", || handle.events(1).unwrap().len() == 1);
    assert_eq!(handle.events(1).unwrap()[0].what, Happened::MemorySaved { position: 0 });

    std::fs::remove_file(file(1)).unwrap();
    std::fs::create_dir(file(1)).unwrap();
    let outcome = station.stop().unwrap();
    let NotSaved(errors) = keeper.finish(&outcome.memories).unwrap_err();
    assert_eq!(errors.iter().map(|error| &error.file).collect::<Vec<_>>(), [&file(1)]);
    let last = state::read(folder.path(), 2, &units()[2]).unwrap().unwrap();
    assert_eq!(last.memory.image(), outcome.memories[2].image());
}

/// Waits for the event that the recording has broken off, and sees the ring go on.
fn broken_off(station: &Station) {
    let handle = station.handle();
    let events = handle.wait_event(0, A_MINUTE).unwrap();
    let problem = io::Error::from(io::ErrorKind::StorageFull).to_string();
    assert_eq!(events[0].what, Happened::RecordingEnded { problem });
    assert!(events[0].what.is_trouble());
    let cycles = handle.view().unwrap().counters.cycles;
    wait_for("more cycles", || handle.view().unwrap().counters.cycles > cycles + 5);
}

#[test]
fn a_recording_that_breaks_off_is_told_at_once_and_the_ring_goes_on() {
    let world = world();
    let sink = Sink { full_after: Some(6_000), ..Sink::default() };
    let records = vec![sink.record(&world)];
    let station = Station::start(world, Options { records, ..at(Speed::Max) }).unwrap();
    broken_off(&station);
    let outcome = station.stop().unwrap();
    assert_eq!(outcome.recorded[0].as_ref().unwrap_err().kind(), io::ErrorKind::StorageFull);
    assert_eq!(outcome.memories.len(), 3, "the memories are whole all the same");
    let rows = sink.rows();
    assert!(rows.len() > 10 && rows.len() < 100, "{} rows in 6000 bytes", rows.len());
}

#[test]
fn a_recording_that_breaks_off_in_the_first_cycles_is_told_too() {
    let world = world();
    let head = Sink::default();
    drop(head.record(&world));
    let header = head.bytes.lock().unwrap().len();
    let sink = Sink { full_after: Some(header), ..Sink::default() };
    let records = vec![sink.record(&world)];
    let station = Station::start(world, Options { records, ..at(Speed::REAL) }).unwrap();
    broken_off(&station);
    assert_eq!(station.stop().unwrap().recorded[0].as_ref().unwrap_err().kind(), io::ErrorKind::StorageFull);
}

#[test]
fn a_waveform_that_breaks_off_is_told_at_once_and_the_ring_goes_on() {
    let scenario = Scenario::parse("lines", STANDING, Path::new("")).unwrap();
    for format in [Format::Vcd, Format::Fst] {
        let mut world = World::new(&scenario).unwrap();
        let sink = Sink { full_after: Some(6_000), ..Sink::default() };
        let file: Box<dyn wave::Sink + Send> = Box::new(sink.clone());
        let waveform = Waveform::new(format, file, "tests", &mut world, Shown::Lines).unwrap();
        let records = vec![Recorder::Waveform(Box::new(waveform))];
        let station = Station::start(world, Options { records, ..at(Speed::Max) }).unwrap();
        broken_off(&station);
        let outcome = station.stop().unwrap();
        assert_eq!(
            outcome.recorded[0].as_ref().unwrap_err().kind(),
            io::ErrorKind::StorageFull,
            "{format:?}"
        );
        assert_eq!(outcome.memories.len(), 3, "the memories are whole all the same");
    }
}

#[test]
fn a_recording_that_cannot_be_flushed_is_told() {
    let world = world();
    let sink = Sink { flush_fails: true, ..Sink::default() };
    let records = vec![sink.record(&world)];
    let until = Some(Duration::from_millis(20));
    let station = Station::start(world, Options { records, until, ..at(Speed::Max) }).unwrap();
    wait_for("the end", || station.is_finished());
    assert_eq!(station.stop().unwrap().recorded[0].as_ref().unwrap_err().kind(), io::ErrorKind::BrokenPipe);
}

#[test]
fn a_recording_holds_every_exchange_from_power_up_on() {
    let world = world();
    let sink = Sink::default();
    let records = vec![sink.record(&world)];
    let until = Some(Duration(100 * CYCLE_NS));
    let station = Station::start(world, Options { records, until, ..at(Speed::Max) }).unwrap();
    wait_for("the end", || station.is_finished());
    assert!(station.stop().unwrap().recorded[0].is_ok());
    let rows = sink.rows();
    let times: Vec<u64> = rows.iter().filter(|row| row.position == Some(2)).map(|row| row.time_ns).collect();
    assert_eq!(times, (1..=100).map(|k| k * CYCLE_NS).collect::<Vec<_>>());
    assert_eq!(rows.len(), 300);
}

#[test]
fn a_station_stops_at_every_speed() {
    for speed in ["1", "0.001", "1000", "max"] {
        let station = Station::start(world(), at(speed.parse().unwrap())).unwrap();
        let handle = station.handle().clone();
        assert!(!station.is_finished());
        assert!(handle.view().unwrap().counters.cycles >= 2);
        let outcome = station.stop().unwrap();
        assert!(outcome.view.counters.cycles >= 2, "speed {speed}");
        assert_eq!(outcome.memories.len(), 3);
    }
}

#[test]
fn after_the_stop_every_request_is_answered_with_stopped() {
    for until in [None, Some(Duration(3 * CYCLE_NS))] {
        let station = Station::start(world(), Options { until, ..at(Speed::Max) }).unwrap();
        let handle = station.handle().clone();
        if until.is_some() {
            wait_for("the end", || station.is_finished());
            assert_eq!(handle.view().map(|_| ()), Err(RingStopped));
        }
        let outcome = station.stop().unwrap();
        assert_eq!(handle.view().map(|_| ()), Err(RingStopped));
        assert_eq!(handle.memories().map(|_| ()), Err(RingStopped));
        assert_eq!(handle.change(0, vec![Change::Supply(0)]), Err(RingStopped));
        assert_eq!(handle.trouble(0, None), Err(RingStopped));
        let last = handle.image().with(|image| image.input()[1]);
        assert_eq!(last, outcome.view.devices[1].input, "the image stays as it was");
    }
}

#[test]
fn many_who_ask_at_once_are_all_answered() {
    let station = Station::start(world(), at(Speed::Max)).unwrap();
    let asking: Vec<_> = (0..16_u32)
        .map(|who| {
            let handle = station.handle().clone();
            thread::spawn(move || {
                for round in 0..50 {
                    let position = (who % 3) as usize;
                    handle.change(position, vec![Change::Preset { input: 0, millivolts: round }]).unwrap();
                    assert_eq!(handle.view().unwrap().devices.len(), 3);
                }
            })
        })
        .collect();
    for asking in asking {
        asking.join().unwrap();
    }
    station.stop().unwrap();
}

#[test]
fn a_burst_of_1000_services_leaves_5000_steps_in_the_history() {
    // [R31..R40]
    let station = Station::start(world(), at(Speed::Max)).unwrap();
    let handle = station.handle();
    for k in 0..1_000 {
        let request = 0xC200_0010 + k;
        set_out(handle, 1, request & !SERVICE_BIT);
        let data_stood = |change: &WordChange| change.out.0 == request & !SERVICE_BIT;
        wait_for("the data on OUT", || {
            let newest = handle.history().counts()[1].saturating_sub(1);
            let last = handle.history().since(1, newest, 1).unwrap();
            last.changes.iter().any(data_stood)
        });
        assert_eq!(service(handle, 1, request), request);
    }
    let seen = handle.history().since(1, 0, usize::MAX).unwrap();
    assert_eq!(seen.missed, 0);
    let steps = seen.changes.iter().flat_map(|change| [change.out_step, change.in_step]).flatten();
    let steps: Vec<u8> = steps.map(encoring_station::ServiceStep::number).collect();
    assert_eq!(steps.len(), 5_000);
    assert!(steps.chunks(5).all(|service| service == [1, 2, 3, 4, 5]));
    assert!(seen.changes.windows(2).all(|pair| pair[0].time_ns <= pair[1].time_ns));
    assert_eq!(handle.history().counts()[0], 0, "nobody wrote to the others");
    station.stop().unwrap();
}
