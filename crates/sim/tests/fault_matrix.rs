//! What each kind of fault does, at each place of rings of each length: one table, `fault_matrix.txt` beside this file.
//!
//! A change of behaviour is a change of the table, to be looked at as a difference. The test writes what it found to
//! the folder of temporary files of the build when it differs, and names it.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use std::fmt::Write;
use std::path::Path;

use encoring_ring::ident::{ENCODER, Ident};
use encoring_ring::master::{Ended, State};
use encoring_ring::profile::BIT_500K;
use encoring_ring::slave::{Condition, Jumper};
use encoring_ring::telegram::Bits;
use encoring_ring::{BitRing, CycleTime, Lines, Slave, Sound};
use encoring_sim::Fault;
use encoring_sim::injector::Segments;
use encoring_words::{InWord, Instant, OutWord};

const TABLE: &str = include_str!("fault_matrix.txt");

#[derive(Clone, Copy, Debug)]
enum Kind {
    /// One bit of the first data telegram of every frame.
    Flip,
    /// One cycle with a burst all over its check word.
    OneBurst,
    /// What can be written.
    Fault(Fault),
}

const KINDS: [(&str, Kind); 12] = [
    ("one burst", Kind::OneBurst),
    ("a flip a cycle", Kind::Flip),
    ("flips 2 %", Kind::Fault(Fault::Flips(20_000))),
    ("jitter 20 %", Kind::Fault(Fault::Jitter(200_000))),
    ("lost telegrams", Kind::Fault(Fault::Lost(20_000))),
    ("stuck at 0", Kind::Fault(Fault::Low)),
    ("stuck at 1", Kind::Fault(Fault::High)),
    ("break", Kind::Fault(Fault::Silent)),
    ("supply off", Kind::Fault(Fault::Supply)),
    ("chip held", Kind::Fault(Fault::Chip)),
    ("no jumper", Kind::Fault(Fault::Jumper)),
    ("other ident", Kind::Fault(Fault::Ident(Ident::new(0x03, 0x02)))),
];

impl Kind {
    const fn is_of_line(self) -> bool {
        match self {
            Self::Flip | Self::OneBurst => true,
            Self::Fault(fault) => fault.is_of_line(),
        }
    }
}

struct Trouble {
    segments: Segments,
    /// A pattern over every frame of a segment: the segment, the first bit, and what turns over.
    pattern: Option<(usize, u64, u64)>,
    slot_began: u64,
}

impl Lines for Trouble {
    fn pass(&mut self, segment: usize, at: u64, line: Bits) -> Bits {
        let mut line = self.segments.pass(segment, at, line);
        if let Some((hit, from, flips)) = self.pattern
            && hit == segment
            && at == self.slot_began + from
        {
            line.bits ^= flips;
        }
        line
    }
}

struct Bench {
    ring: BitRing<Vec<Slave>>,
    slot: u64,
    cycle: u64,
    trouble: Trouble,
    input: Vec<InWord>,
}

impl Bench {
    fn of(encoders: usize) -> Self {
        let slaves = (0..encoders).map(|_| Slave::new(ENCODER, BIT_500K)).collect();
        let mut ring = BitRing::new(slaves, BIT_500K);
        ring.bring_up(&mut Sound, 10_000).unwrap();
        ring.begin_time();
        let cycle = CycleTime::default().of_encoders(encoders as u32).as_nanos();
        let trouble = Trouble { segments: Segments::new(encoders, 1), pattern: None, slot_began: 0 };
        Self { ring, slot: 0, cycle, trouble, input: vec![InWord(0); encoders] }
    }

    fn slot(&mut self) -> Ended {
        self.slot += 1;
        let encoders = self.input.len();
        let out: Vec<OutWord> = (0..encoders).map(|k| OutWord(0xC200_0000 + k as u32)).collect();
        let answers: Vec<_> = (0..encoders).map(|k| Some(InWord(0x0012_3400 + k as u32))).collect();
        self.trouble.slot_began = self.ring.sent();
        let now = Instant(self.slot * self.cycle);
        self.ring.cycle(now, &out, &mut self.input, &answers, &mut self.trouble).ended
    }

    fn begin(&mut self, kind: Kind, at: usize) {
        let slaves = self.ring.slaves_mut();
        match kind {
            Kind::Flip => self.trouble.pattern = Some((at, 2 * 13, 1 << 5)),
            // The frame is as long for every segment; its third telegram has 13 bits to hit.
            Kind::OneBurst => self.trouble.pattern = Some((at, 2 * 13, 0x1A5B)),
            Kind::Fault(Fault::Supply) => slaves[at].set_condition(Condition::Off),
            Kind::Fault(Fault::Chip) => slaves[at].set_condition(Condition::Held),
            Kind::Fault(Fault::Jumper) => slaves[at].set_jumper(Jumper::Open),
            Kind::Fault(Fault::Ident(ident)) => {
                slaves[at].set_condition(Condition::Off);
                slaves[at].set_ident(ident);
            }
            Kind::Fault(fault) => self.trouble.segments.get_mut(at).unwrap().set(fault, 0, u64::MAX),
        }
    }

    fn end(&mut self, kind: Kind, at: usize) {
        self.trouble.pattern = None;
        self.trouble.segments.clear();
        if let Some(slave) = self.ring.slaves_mut().get_mut(at)
            && !kind.is_of_line()
        {
            slave.set_condition(Condition::Running);
            slave.set_jumper(Jumper::Closed);
            slave.set_ident(ENCODER);
        }
    }

    fn lamps(&self, position: usize) -> String {
        let lamps = self.ring.lamps(position).unwrap();
        [(lamps.u, "U"), (lamps.ba, "BA"), (lamps.rc, "RC"), (lamps.rd, "RD")]
            .into_iter()
            .filter_map(|(on, name)| on.then_some(name))
            .collect::<Vec<_>>()
            .join("+")
    }
}

/// One row: the fault begins before a slot, lasts for some, and ends.
fn row(table: &mut String, name: &str, kind: Kind, encoders: usize, at: usize) {
    let mut bench = Bench::of(encoders);
    for _ in 0..5 {
        assert_eq!(bench.slot(), Ended::Good);
    }
    bench.begin(kind, at);
    let lasting = if matches!(kind, Kind::OneBurst) { 1 } else { 60 + 2 * encoders as u64 + 80 };
    let (mut noticed, mut stopped, mut zeros) = (None, None, None);
    for slot in 1..=lasting {
        let ended = bench.slot();
        if matches!(kind, Kind::Fault(Fault::Ident(_))) && slot == 10 {
            bench.ring.slaves_mut()[at].set_condition(Condition::Running);
        }
        noticed = noticed.or((ended != Ended::Good).then_some(slot));
        stopped = stopped.or((bench.ring.master().state() != State::Run).then_some(slot));
        let all_zero = (0..encoders).all(|position| bench.ring.out_word(position) == OutWord(0));
        zeros = zeros.or(all_zero.then_some(slot));
    }
    let (status, parameter) = (bench.ring.master().status(), bench.ring.master().parameter());
    let before = if at == 0 { "-".to_owned() } else { bench.lamps(at - 1) };
    let behind = if at == encoders { "-".to_owned() } else { bench.lamps(at) };
    bench.end(kind, at);
    let recovered = (1..=2_000_u64).find(|_| bench.slot() == Ended::Good);
    // Nobody had to do anything: it runs on, with the words of the present.
    for _ in 0..3 {
        assert_eq!(bench.slot(), Ended::Good, "{name} {encoders} {at}");
    }
    assert_eq!(bench.ring.master().status() & 0x00FF, 0x00E0, "{name} {encoders} {at}");
    for position in 0..encoders {
        assert_eq!(bench.ring.out_word(position), OutWord(0xC200_0000 + position as u32));
        assert_eq!(bench.input[position], InWord(0x0012_3400 + position as u32));
    }
    let number = |slots: Option<u64>| slots.map_or("-".to_owned(), |slots| slots.to_string());
    writeln!(
        table,
        "{name:<15} {encoders:>4} {at:>4} {:>7} {:>6} {:>6}   {status:04X}  {parameter:04X}  {before:<11} {behind:<11} {:>8}",
        number(noticed),
        number(stopped),
        number(zeros),
        number(recovered)
    )
    .unwrap();
}

// [R139]
#[test]
fn what_every_fault_does_at_every_place_is_in_the_table() {
    let mut table = String::from(
        "# fault          ring   at noticed stopped zeros status param. lamps before lamps behind recovers\n",
    );
    for (name, kind) in KINDS {
        for encoders in [1, 3, 16, 128] {
            let mut places = vec![0, encoders / 2, encoders - 1, encoders];
            places.dedup();
            places.retain(|at| kind.is_of_line() || *at < encoders);
            // Without a next device nobody misses the jumper.
            places.retain(|at| !matches!(kind, Kind::Fault(Fault::Jumper)) || *at + 1 < encoders);
            if encoders == 128 {
                places.retain(|at| *at == 64);
            }
            for at in places {
                row(&mut table, name, kind, encoders, at);
            }
        }
    }
    if table != TABLE {
        let found = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fault_matrix.txt");
        std::fs::write(&found, &table).unwrap();
        panic!("the table differs from {}", found.display());
    }
}
