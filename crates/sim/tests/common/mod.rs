//! What the tests of worlds share: a ring on a bench, with its two images and everything that was exchanged.
#![allow(
    dead_code,
    unreachable_pub,
    missing_docs,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::panic,
    reason = "tests; no file uses all of it"
)]

use std::path::Path;

use encoring_ring::Verdict;
use encoring_sim::memory::CellFault;
use encoring_sim::scenario::Change;
use encoring_sim::{Cycled, Scenario, World};
use encoring_trace::Row;
use encoring_words::{InWord, OutWord};

pub const MS: u64 = 1_000_000;
pub const SECOND: u64 = 1_000_000_000;

pub const SERVICE_BIT: u32 = 1 << 31;
pub const ERROR_BIT: u32 = 1 << 29;
pub const DATA_CHECK: u32 = 0x8800_0000;

/// A ring, what its master writes and sees, and every exchange since the last look.
pub struct Ring {
    pub world: World,
    pub out: Vec<u32>,
    pub input: Vec<u32>,
    pub rows: Vec<Row>,
    /// How the last cycle went.
    pub last: Verdict,
}

pub fn scenario(text: &str) -> Scenario {
    Scenario::parse("test", text, Path::new("")).unwrap()
}

/// A device table; `more` has further keys, one a line.
pub fn device(position: usize, model: &str, more: &str) -> String {
    format!("[[device]]\nposition = {position}\nmodel = \"{model}\"\nservice_times = \"zero\"\n{more}\n")
}

/// One of each model that stand at these places, service times 0.
pub fn three(raws: [i64; 3]) -> String {
    let hold = |raw: i64| format!("motion = {{ kind = \"hold\", raw = {raw} }}");
    let [rod, ce100, ce65] = raws.map(hold);
    let devices =
        [device(0, "la-66", &rod), device(1, "ce-100-m", &ce100), device(2, "ce-65-m", &ce65)].concat();
    format!("version = 1\n{devices}")
}

/// An event of a device.
pub fn set(at_ms: f64, position: usize, what: &str) -> String {
    format!("[[event]]\nat_s = {}\nposition = {position}\nset = {{ {what} }}\n", at_ms / 1000.0)
}

/// An event of the line.
pub fn line(at_ms: f64, segment: usize, fault: &str, for_ms: f64) -> String {
    let (at_s, for_s) = (at_ms / 1000.0, for_ms / 1000.0);
    format!("[[event]]\nat_s = {at_s}\nsegment = {segment}\nline = \"{fault}\"\nfor_s = {for_s}\n")
}

impl Ring {
    pub fn new(text: &str) -> Self {
        Self::of(&scenario(text))
    }

    pub fn of(scenario: &Scenario) -> Self {
        let mut world = World::new(scenario).unwrap();
        world.record();
        let encoders = scenario.devices.len();
        Self {
            world,
            out: vec![0; encoders],
            input: vec![0; encoders],
            rows: Vec::new(),
            last: Verdict::Good,
        }
    }

    pub fn cycle(&mut self) -> Cycled {
        let out: Vec<OutWord> = self.out.iter().copied().map(OutWord).collect();
        let mut input: Vec<InWord> = self.input.iter().copied().map(InWord).collect();
        let cycled = self.world.cycle(&out, &mut input);
        self.input = input.into_iter().map(|word| word.0).collect();
        self.rows.extend(self.world.take_recorded());
        self.last = cycled.verdict;
        cycled
    }

    pub fn cycles(&mut self, count: usize) {
        for _ in 0..count {
            self.cycle();
        }
    }

    /// Runs until the first end of a cycle that is not before this time.
    pub fn run_to_ms(&mut self, ms: f64) {
        while (self.world.now().as_nanos() as f64) < ms * 1e6 {
            self.cycle();
        }
    }

    /// A request, its reply and the end of the request.
    pub fn service(&mut self, position: usize, request: u32) -> u32 {
        self.out[position] = request;
        let reply = self.until(position, |input| input & SERVICE_BIT != 0);
        self.out[position] = request & !SERVICE_BIT;
        self.until(position, |input| input & SERVICE_BIT == 0);
        reply
    }

    /// Cycles until the IN word is as wanted, and gives it.
    pub fn until(&mut self, position: usize, wanted: impl Fn(u32) -> bool) -> u32 {
        for _ in 0..200 {
            self.cycle();
            if wanted(self.input[position]) {
                return self.input[position];
            }
        }
        panic!("IN {:08X} of position {position} does not change", self.input[position]);
    }

    /// What the master sees when it has read anew.
    pub fn position(&mut self, position: usize) -> u32 {
        self.out[position] = 0;
        self.cycles(2);
        self.input[position]
    }

    pub fn supply(&mut self, position: usize, millivolts: u32) {
        self.world.change(position, &[Change::Supply(millivolts)]);
    }

    pub fn is_on(&self, position: usize) -> bool {
        self.world.places()[position].node().encoder().is_some()
    }

    /// The exchanges of one encoder so far.
    pub fn rows_of(&self, position: u8) -> Vec<Row> {
        self.rows.iter().copied().filter(|row| row.position == Some(position)).collect()
    }

    pub fn memory_fault(&mut self, position: usize, fault: CellFault, cell: Option<usize>) {
        self.world.change(position, &[Change::MemoryFault(fault, cell)]);
    }
}
