//! Links only if no panic path is left in `words`, `encoder`, `ring`, `device` and `host::validity`.
//!
//! Every entry of them is called with values that the compiler cannot know. The panic handler calls a
//! function that exists nowhere: if any path to a panic survives the optimiser, the linker names it. Formatting
//! (`Display`, `Debug`) is left out; it is for people and never part of a machine.
#![no_std]
#![no_main]

use core::hint::black_box;
use core::num::NonZeroU32;

use encoring_device::{BusDevice, Surroundings};
use encoring_encoder::records::{self, EEPROM_BYTES, Record};
use encoring_encoder::{Encoder, Magnet, Ram, ServiceTimes, StaleService, Terminals, Unit, ZeroLoss};
use encoring_host::Seen;
use encoring_host::validity::{Expectation, Limits, Validity};
use encoring_ring::frame::{self, Control, EndWord, Outgoing};
use encoring_ring::image::Half;
use encoring_ring::master::WhenBroken;
use encoring_ring::slave::{Condition, Jumper};
use encoring_ring::telegram::{Bits, Decoder};
use encoring_ring::{
    BitRing, CycleTime, EveryBit, Ident, Lines, ProcessImage, Slave, Taken,
};
use encoring_words::model::{MODELS, Sensor};
use encoring_words::parameter::{PARAMETERS, SsiValues};
use encoring_words::service::SERVICES;
use encoring_words::ssi_frame::{Level, SsiFormat, SsiFrame};
use encoring_words::word::{FIELDS, In, Out, ServiceNumber};
use encoring_words::{Duration, ErrorStatus, InWord, Instant, Model, OutWord, ParameterSet, Week, Written, gray};

unsafe extern "C" {
    /// Defined nowhere.
    fn a_panic_path_is_left() -> !;
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    // SAFETY: never linked.
    unsafe { a_panic_path_is_left() }
}

/// Named by the compiler's own division of 128 bits, which was built to unwind; nothing here does.
#[unsafe(no_mangle)]
pub extern "C" fn rust_eh_personality() {}

/// A value that the compiler knows nothing about.
fn any<T: Default>() -> T {
    black_box(T::default())
}

fn model() -> Model {
    match any::<u8>() {
        0 => Model::La66,
        1 => Model::Ce100M,
        _ => Model::Ce65M,
    }
}

fn level() -> Level {
    Level::from_bit(any())
}

fn words() {
    let out = OutWord(any());
    black_box((out.service_bit(), out.high(), out.low(), OutWord::from_halves(any(), any())));
    let decoded = black_box(out.decode());
    black_box(OutWord::from(decoded));
    if let Out::Request(fields) = decoded {
        black_box(InWord::from(In::Reply(fields)));
    }
    let input = InWord(any());
    black_box(InWord::from(black_box(input.decode())));
    black_box((input.error_bit(), InWord::position(any(), any())));
    for field in FIELDS {
        black_box((field.mask(), field.of(any())));
    }
    black_box(ServiceNumber::new(any()).number());
    black_box(gray::decode(gray::encode(any())));
    let sensor =
        if any() { Sensor::Rotary { steps_per_turn: any() } } else { Sensor::Linear { rod_um: any() } };
    let mut set = ParameterSet::factory(model(), sensor);
    for parameter in PARAMETERS {
        black_box(parameter.normalise(model(), any()).ok());
        set.set(parameter, any());
        black_box((set.value(parameter), parameter.range(model())));
    }
    black_box((set.validity(model(), sensor), set.counting_direction(), set.ssi_values()));
    for service in SERVICES {
        black_box((service.known_to(model()), service.number(), service.name()));
    }
    for model in MODELS {
        black_box((model.data_sheet(), model.status_mask(), model.refresh(), model.preset_inputs()));
    }
    let name: &str = black_box("ce-65-m");
    black_box(name.parse::<Model>().ok());
    for row in ErrorStatus::from_bits_retain(any()).explain() {
        black_box(row);
    }
    let firmware = Week::new(any(), any()).unwrap_or(Week::AK40);
    let format = SsiFormat::new(SsiValues::from_data(any()), firmware);
    black_box((format.position(any()), format.holds_parity(any())));
    let frame = SsiFrame::new(any(), format);
    black_box((frame.level(any()), frame.after(any()), frame.collect(any())));
    black_box(Instant(any()) + Duration::from_secs(any()));
    black_box(Instant(any()).since(Instant(any())));
}

fn unit() -> Option<Unit> {
    let sensor =
        if any() { Sensor::Rotary { steps_per_turn: any() } } else { Sensor::Linear { rod_um: any() } };
    let mut unit = Unit::new(model(), sensor).ok()?;
    let week: &str = black_box("41/1997");
    if let (Ok(week), Ok(other)) = (week.parse::<Week>(), Week::new(any(), any())) {
        unit.firmware = if any() { week } else { other };
    }
    unit.service_times = ServiceTimes {
        read: Duration(any()),
        write: Duration(any()),
        data_check: Duration(any()),
        preset_adjustment: Duration(any()),
    };
    unit.zero_loss = if any() { ZeroLoss::Nearest } else { ZeroLoss::WorstAllowed };
    unit.stale_service = if any() { StaleService::Ignored } else { StaleService::Executed };
    Some(unit)
}

fn encoder() {
    let Some(unit) = unit() else { return };
    let mut memory = black_box(Ram::from_image([0; EEPROM_BYTES]));
    black_box(records::format(&unit, &mut memory).is_ok());
    for record in Record::of(model()) {
        black_box(records::write_count(&mut memory, record));
    }
    let magnet = if any() { Magnet::Present } else { Magnet::Missing };
    let terminals = Terminals { raw: any(), magnet, preset_mv: [any(), any()] };
    let mut encoder = Encoder::power_up(&unit, Instant(any()), &terminals, &mut memory);
    while any() {
        let terminals = Terminals { raw: any(), magnet, preset_mv: [any(), any()] };
        black_box(encoder.exchange(Instant(any()), OutWord(any()), &terminals, &mut memory));
        black_box(encoder.ssi_clock(Instant(any()), level(), &terminals));
        black_box(encoder.ssi_level(Instant(any())));
        black_box((encoder.refreshed_at(Instant(any())), encoder.position(), encoder.latched_status()));
        black_box((
            encoder.error_pending(),
            encoder.handshake(),
            encoder.active(),
            encoder.parameters().validity(),
        ));
    }
    encoder.power_off(&mut memory);
    black_box(memory.image());
}

fn device() {
    let Some(unit) = unit() else { return };
    let mut memory = black_box(Ram::from_image([0; EEPROM_BYTES]));
    let mut device = BusDevice::new(unit);
    while any() {
        let magnet = if any() { Magnet::Present } else { Magnet::Missing };
        let terminals = Terminals { raw: any(), magnet, preset_mv: [any(), any()] };
        let around = Surroundings { terminals, supply_mv: any() };
        let word = if any() { Some(OutWord(any())) } else { None };
        let taken = Taken { word, resets: any() };
        black_box((device.exchanges_after_cycle(taken), device.due_without_cycles(Instant(any()))));
        black_box(device.looks_at(Instant(any())));
        let out = device.hears(taken);
        black_box(device.exchange(Instant(any()), out, &around, &mut memory));
        black_box(device.ssi_clock(Instant(any()), level(), &around, &mut memory));
        black_box((device.overvoltage(), device.encoder().is_some(), device.unit().model()));
        black_box(around.preset_overvoltage(model()));
        device.supply(Instant(any()), any(), &mut memory);
        if any() {
            device.cut();
        }
    }
    black_box(memory.image());
}

fn ring() {
    let Ok(mut image) = ProcessImage::new(any()) else { return };
    let half = if any() { Half::High } else { Half::Low };
    black_box((image.out_half(any(), half), image.input_half(any(), half)));
    black_box(image.write_out(any(), Written::High(any())));
    black_box(image.write_out(any(), Written::Low(any())));
    black_box(image.write_out(any(), Written::Both(OutWord(any()))));
    image.diagnose(any(), any(), black_box([0_u32; 200]));
    black_box((image.status(), image.parameter(), image.faults()));
    let time = CycleTime { bit: Duration(any()), software: Duration(any()), cable_m: any() };
    black_box((time.of(any(), any()), time.of_encoders(any())));
}

fn validity() {
    let sensor = if any() {
        Sensor::Rotary { steps_per_turn: any() }
    } else {
        Sensor::Linear { rod_um: any() }
    };
    let mut set = ParameterSet::factory(model(), sensor);
    for parameter in PARAMETERS {
        set.set(parameter, any());
    }
    let Ok(expectation) = Expectation::new(model(), sensor, &set) else { return };
    let limits = Limits {
        speed_rpm: NonZeroU32::new(any()),
        acceleration_rad_s2: NonZeroU32::new(any()),
        speed_mm_s: NonZeroU32::new(any()),
        acceleration_mm_s2: NonZeroU32::new(any()),
        refresh: Duration(any()),
        stale_after: Duration(any()),
        ..Limits::of(model(), Duration(any()))
    };
    let mut validity = Validity::new(expectation, limits);
    while any() {
        let seen = Seen { input: InWord(any()), age: Duration(any()) };
        let seen = if any() { Some(seen) } else { None };
        let position = validity.judge(Instant(any()), seen, &mut |stop| {
            black_box(stop);
        });
        black_box((position, position.valid()));
        if any() {
            validity.rebase();
        }
        if let Ok(expectation) = Expectation::new(model(), sensor, &set) {
            validity.expect(expectation);
        }
    }
}

/// Segments that do anything and promise anything.
struct Quiet;

impl Lines for Quiet {
    fn pass(&mut self, _: usize, _: u64, line: Bits) -> Bits {
        Bits { bits: any(), count: line.count }
    }

    fn quiet(&self, _: u64, _: u64) -> bool {
        any()
    }
}

fn bits() {
    let ident = Ident(any());
    black_box((ident.kind(), ident.length(), ident.bytes(), ident.messages(), ident.identity()));
    black_box((EndWord::decode(any()), frame::bad(any()), frame::frame_bits(any())));
    let control = Control::new(any(), if any() { Outgoing::On } else { Outgoing::Off });
    black_box((control.position(), control.outgoing(), control.resets()));
    let mut decoder = Decoder::default();
    while any() {
        black_box(decoder.clock(any()));
        black_box((decoder.is_bad(), decoder.is_whole(), decoder.is_framed()));
    }
    let mut slave = Slave::new(ident, Duration(any()));
    while any() {
        black_box(slave.clock(any()));
        black_box(slave.regenerate(Bits { bits: any(), count: any::<u32>() & 0x3F }));
        slave.load(black_box(&[0; 80]));
        slave.set_ident(Ident(any()));
        slave.set_jumper(if any() { Jumper::Open } else { Jumper::Closed });
        slave.set_condition(if any() { Condition::Off } else { Condition::Running });
        black_box((slave.latched().len(), slave.lamps(), slave.position(), slave.taken()));
    }
    let slaves = [slave.clone(), slave.clone(), slave];
    let mut ring = BitRing::new(slaves, Duration(any()));
    let other = ring.clone();
    let mut lines = |_: usize, _: u64, line: Bits| Bits { bits: any(), count: line.count };
    black_box(ring.bring_up(&mut lines, any()).is_ok());
    while any() {
        let out = black_box([OutWord(0); 4]);
        let mut input = black_box([InWord(0); 4]);
        let answers = black_box([Some(InWord(0)); 4]);
        let out = out.get(..any::<usize>()).unwrap_or_default();
        black_box(ring.cycle(Instant(any()), out, &mut input, &answers, &mut lines));
        // Sound slots as a whole, of a ring about which nothing is known.
        black_box(ring.cycle(Instant(any()), out, &mut input, &answers, &mut Quiet));
        black_box(ring.run(Instant(any()), &mut EveryBit(&mut Quiet)));
        black_box((ring.out_word(any()), ring.lamps(any()), ring.shortest()));
        black_box((ring.taken_at(any(), Instant(any())), ring == other));
        let master = ring.master_mut();
        black_box((master.status(), master.parameter(), master.input(any()).len(), master.found(any())));
        black_box((master.counts().segment(any()), master.out_mut(any()).len()));
        match any::<u8>() {
            0 => master.activate(),
            1 => master.alarm_stop(),
            2 => black_box(master.start().is_ok()).then_some(()).unwrap_or_default(),
            3 => black_box(master.stop().is_ok()).then_some(()).unwrap_or_default(),
            4 => master.set_when_broken(WhenBroken::RunOn),
            _ => black_box(master.configure(&[Ident(any()); 3]).is_ok()).then_some(()).unwrap_or_default(),
        }
    }
}

/// The entry; the program is linked, never run.
#[unsafe(no_mangle)]
pub extern "C" fn _start() -> ! {
    words();
    encoder();
    device();
    ring();
    validity();
    bits();
    loop {}
}
