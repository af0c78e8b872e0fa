//! An encoder on a bench: its EEPROM is in RAM, the time is what we say, and an OUT word brings an IN word.
//!
//! `cargo run -p encoring-encoder --example bench`

use encoring_encoder::{Encoder, Magnet, Ram, Terminals, Unit, records};
use encoring_words::model::Sensor;
use encoring_words::{Instant, Model, OutWord};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let unit = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 4096 })?;
    let mut memory = Ram::blank();
    records::format(&unit, &mut memory).map_err(|_| "the memory takes nothing")?;
    let mut terminals = Terminals { raw: 9999, magnet: Magnet::Present, preset_mv: [0, 0] };
    let mut encoder = Encoder::power_up(&unit, Instant(0), &terminals, &mut memory);
    // Number and data, then the service bit too, until the encoder has acknowledged it; then back again.
    for (ms, out) in [(1, 0), (2, 0x4200_270F), (3, 0xC200_270F), (23, 0xC200_270F), (24, 0x4200_270F)] {
        terminals.raw += 1;
        let input = encoder.exchange(Instant(ms * 1_000_000), OutWord(out), &terminals, &mut memory);
        println!("{ms:2} ms  OUT {out:08X}  IN {input}");
    }
    encoder.power_off(&mut memory);
    Ok(())
}
