//! Any text as a state file: it is refused, or its memory comes back and an encoder starts with it.
#![no_main]

use encoring_encoder::Unit;
use encoring_sim::state::parse;
use encoring_sim::{Node, Surroundings};
use encoring_words::model::Sensor;
use encoring_words::{Instant, Model, OutWord};
use libfuzzer_sys::fuzz_target;

const UNITS: [(Model, Sensor, &str); 4] = [
    (Model::La66, Sensor::Linear { rod_um: 500_000 }, "rod_um = 500000"),
    (Model::Ce100M, Sensor::Rotary { steps_per_turn: 4096 }, "native = 4096"),
    (Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 }, "native = 4096"),
    (Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }, "native = 8192"),
];

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = str::from_utf8(bytes) else { return };
    let mut taken = 0;
    for (position, (model, sensor, size)) in UNITS.into_iter().enumerate() {
        let unit = Unit::new(model, sensor).expect("a sensor of its model");
        let memory = match parse(text, position, &unit) {
            Ok(kept) => kept.memory,
            Err(problem) => {
                assert!(!problem.is_empty());
                continue;
            }
        };
        taken += 1;
        let hex: String = memory.image().iter().map(|byte| format!("{byte:02X}")).collect();
        let plain = format!("version = 1\nmodel = \"{model}\"\n{size}\nmemory = \"{hex}\"\n");
        assert_eq!(parse(&plain, position, &unit).map(|kept| kept.memory), Ok(memory.clone()), "{plain}");

        let mut node = Node::with_memory(unit, memory);
        for (at, out) in (0..).zip([0, 0x8200_0000, 0, 0x8800_0000, 0x8800_0000]) {
            let now = Instant(at * 100_000_000);
            let word = node.step(now, OutWord(out), &Surroundings::default()).expect("it has its supply");
            assert!(word.service_bit() || word.0 & 0xDF00_0000 == 0, "{word}");
        }
    }
    assert!(taken <= 1, "the state of one encoder is taken by {taken}");
});
