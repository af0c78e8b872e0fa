//! A world as a waveform: words, verdicts, lamps and the master once a cycle, or also what an oscilloscope with a channel
//! on every segment and every chip would have drawn.
//!
//! With the lines a recording holds every line bit of every segment, as it arrives behind whatever troubles the segment,
//! and what every chip does with it. What the signals are is in `docs/waveforms.md`.
//!
//! The ring moves all delay to the master's end of the line. Here every device delays by the bits of [A4], so that
//! each segment and chip is drawn when it would be seen. Time with the lines is that of the line: a cycle ends with the
//! last telegram that began in it, up to four bits later than the cycle time says.

use std::io;

use encoring_ring::diagnostics::status;
use encoring_ring::master::State;
use encoring_ring::{Master, Verdict};
use encoring_trace::wave::{Format, Id, Signals, Sink, UNIT_NS, Value, WaveWriter};
use encoring_words::InWord;

use crate::tap::{Change, Tap, out_values, service_bit};
use crate::world::{Cycled, World};

/// The codes of the signals that have some.
const NOTES: [&str; 3] = [
    "state of an encoder's chip: 0 off, 1 held, 2 reset, 3 lost, 4 pause, 5 identification, 6 data, 7 check word, 8 end word",
    "state of the master: 0 READY, 1 ACTIVE, 2 RUN",
    "verdict of a cycle: 0 good, 1 bad, 2 silent; segment: the first one at fault",
];

const fn state_code(state: State) -> u32 {
    match state {
        State::Ready => 0,
        State::Active => 1,
        State::Run => 2,
    }
}

/// A verdict, and the segment that is at fault.
fn verdict_codes(verdict: Verdict) -> (Value, Value) {
    let (code, segment) = match verdict {
        Verdict::Good => (0, Value::Unknown),
        Verdict::Bad { segment } => (1, Value::Bits(segment as u32)),
        Verdict::Silent { segment } => (2, Value::Bits(segment as u32)),
    };
    (Value::Bits(code), segment)
}

/// What a waveform shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Words, verdicts, lamps and the master, once a cycle.
    Words,
    /// Also every bit of every segment and what every chip does with it. Every bit has to run for it.
    Lines,
}

/// A waveform of a world, under way.
pub struct Waveform<W: Sink> {
    writer: WaveWriter<W>,
    verdict: Id,
    segment: Id,
    master: MasterSignals,
    shown: Shown,
    encoders: Vec<EncoderSignals>,
    /// In order of time, up to what is written.
    waiting: Vec<Change>,
    ended: u64,
}

#[derive(Clone, Copy, Debug)]
struct MasterSignals {
    state: Id,
    search: Id,
    devices: Id,
    status: Id,
    parameter: Id,
}

/// What is known of an encoder at the end of a cycle.
#[derive(Clone, Copy, Debug)]
struct EncoderSignals {
    input: Id,
    in_service: Id,
    /// With the lines they come from the chip, at the bit at which they change.
    chip: Option<ChipSignals>,
    /// Clock+ and Data+, where it has an SSI.
    ssi: Option<[Id; 2]>,
}

#[derive(Clone, Copy, Debug)]
struct ChipSignals {
    out: Id,
    out_service: Id,
    /// U, BA, RC, RD.
    lamps: [Id; 4],
}

/// What an IN word shows, and its service bit.
fn in_values(answer: Option<InWord>) -> [Value; 2] {
    match answer {
        Some(InWord(word)) => [Value::Bits(word), service_bit(word)],
        None => [Value::Unknown; 2],
    }
}

fn add_chip(signals: &mut Signals, world: &World, position: usize) -> ChipSignals {
    let [out, out_service] = out_values(world.ring().out_word(position));
    ChipSignals {
        out: signals.add("out", 32, out),
        out_service: signals.add("out_service", 1, out_service),
        lamps: lamps(world, position, |name, lit| signals.add(name, 1, lit)),
    }
}

/// Something for each lamp of the encoder at a position.
fn lamps<T>(world: &World, position: usize, mut each: impl FnMut(&'static str, Value) -> T) -> [T; 4] {
    let lit = world.lamps(position);
    [
        each("lamp_u", lit.is_some_and(|lamps| lamps.u).into()),
        each("lamp_ba", lit.is_some_and(|lamps| lamps.ba).into()),
        each("lamp_rc", lit.is_some_and(|lamps| lamps.rc).into()),
        each("lamp_rd", lit.is_some_and(|lamps| lamps.rd).into()),
    ]
}

/// Clock and data of its SSI, as a reader drives and sees them.
fn add_ssi(signals: &mut Signals, world: &World, position: usize) -> Option<[Id; 2]> {
    let has_ssi = world.places().get(position)?.node().unit().model().has_ssi_output();
    has_ssi.then(|| ["ssi_clock", "ssi_data"].map(|name| signals.add(name, 1, Value::Bits(1))))
}

fn add_master(signals: &mut Signals, master: &Master) -> MasterSignals {
    signals.scope("master");
    let now = master_values(master);
    let mut add = |name: &str, width, at: usize| {
        signals.add(name, width, now.get(at).copied().unwrap_or(Value::Unknown))
    };
    MasterSignals {
        state: add("state", 2, 0),
        search: add("search", 1, 1),
        devices: add("devices", 10, 2),
        status: add("status", 16, 3),
        parameter: add("parameter", 16, 4),
    }
}

fn master_values(master: &Master) -> [Value; 5] {
    let registers = master.status();
    [
        Value::Bits(state_code(master.state())),
        Value::from(registers & status::DETECT != 0),
        Value::Bits(master.devices() as u32),
        Value::Bits(registers.into()),
        Value::Bits(master.parameter().into()),
    ]
}

impl<W: Sink> Waveform<W> {
    /// Begins a waveform of a world that has not cycled yet. `writer` is who writes it.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn new(format: Format, sink: W, writer: &str, world: &mut World, shown: Shown) -> io::Result<Self> {
        let mut signals = Signals::new("encoring");
        NOTES.into_iter().for_each(|note| signals.note(note));
        signals.scope("cycle");
        let verdict = signals.add("verdict", 2, Value::Bits(0));
        let segment = signals.add("segment", 8, Value::Unknown);
        let master = add_master(&mut signals, world.ring().master());
        let mut tap = match shown {
            Shown::Words => None,
            Shown::Lines => Some(Tap::new(world.line_bit())),
        };
        if let Some(tap) = &mut tap {
            tap.add_lines(&mut signals, world.places().len());
        }
        let mut encoders = Vec::new();
        for position in 0..world.places().len() {
            signals.scope(format!("encoder_{position}"));
            let [input, in_service] = in_values(world.answer(position));
            let chip = match (&mut tap, world.ring().slaves().get(position)) {
                (Some(tap), Some(slave)) => {
                    tap.add_chip(&mut signals, slave);
                    None
                }
                _ => Some(add_chip(&mut signals, world, position)),
            };
            encoders.push(EncoderSignals {
                input: signals.add("in", 32, input),
                in_service: signals.add("in_service", 1, in_service),
                chip,
                ssi: add_ssi(&mut signals, world, position),
            });
        }
        let writer = WaveWriter::new(format, sink, writer, &signals)?;
        if let Some(tap) = tap {
            world.set_tap(tap);
        }
        world.keep_ssi();
        Ok(Self { writer, verdict, segment, master, shown, encoders, waiting: Vec::new(), ended: 0 })
    }

    /// Takes a cycle that has just run.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn cycled(&mut self, world: &mut World, cycled: &Cycled) -> io::Result<()> {
        let at = match self.shown {
            Shown::Words => cycled.at,
            Shown::Lines => world.line_time(),
        };
        let at = at.as_nanos() / UNIT_NS;
        let mut show = |id, value| self.waiting.push(Change { at, id, value });
        let (verdict, segment) = verdict_codes(cycled.verdict);
        show(self.verdict, verdict);
        show(self.segment, segment);
        let MasterSignals { state, search, devices, status, parameter } = self.master;
        let ids = [state, search, devices, status, parameter];
        ids.into_iter().zip(master_values(world.ring().master())).for_each(|(id, value)| show(id, value));
        for (position, encoder) in self.encoders.iter().enumerate() {
            let [input, in_service] = in_values(world.answer(position));
            show(encoder.input, input);
            show(encoder.in_service, in_service);
            let Some(chip) = encoder.chip else { continue };
            let [out, out_service] = out_values(world.ring().out_word(position));
            show(chip.out, out);
            show(chip.out_service, out_service);
            let mut ids = chip.lamps.into_iter();
            lamps(world, position, |_, lit| ids.next().map(|id| show(id, lit)));
        }
        if let Some(tap) = world.tap_mut() {
            self.waiting.append(tap.changes_mut());
        }
        self.take_ssi(world);
        self.ended = at;
        // What comes later is behind a device that delays it, or of the line, which may be ahead of the SSI; other changes
        // may come before it.
        self.write_until(at.min(cycled.at.as_nanos() / UNIT_NS))
    }

    fn take_ssi(&mut self, world: &mut World) {
        for (position, encoder) in self.encoders.iter().enumerate() {
            let Some([clock, data]) = encoder.ssi else { continue };
            for seen in world.take_ssi(position) {
                let at = seen.at.as_nanos() / UNIT_NS;
                let levels = [(clock, seen.clock), (data, seen.data)];
                self.waiting.extend(levels.map(|(id, level)| Change {
                    at,
                    id,
                    value: Value::Bits(level.bit()),
                }));
            }
        }
    }

    fn write_until(&mut self, end: u64) -> io::Result<()> {
        self.waiting.sort_by_key(|change| change.at);
        let due = self.waiting.partition_point(|change| change.at <= end);
        let writer = &mut self.writer;
        self.waiting.drain(..due).try_for_each(|Change { at, id, value }| writer.change(at, id, value))
    }

    /// Ends the waveform with the last cycle that it took, and what of it is still under way on the line.
    ///
    /// # Errors
    /// Those of the sink.
    pub fn finish(mut self) -> io::Result<W> {
        self.write_until(u64::MAX)?;
        self.writer.finish(self.ended)
    }
}
