//! A fault in a world: the cable behind the first encoder breaks for 200 ms, in virtual time.
//!
//! `cargo run -p encoring-sim --example fault`

use std::path::Path;

use encoring_ring::Verdict;
use encoring_sim::{Scenario, World};
use encoring_words::{InWord, Instant, OutWord};

const RING: &str = r#"
version = 1
[[device]]
position = 0
model = "la-66"
[[device]]
position = 1
model = "ce-65-m"
[[event]]
at_s = 0.1
segment = 1
line = "silent"
for_s = 0.2
"#;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut world = World::new(&Scenario::parse("example", RING, Path::new(""))?)?;
    let mut input = [InWord(0); 2];
    let mut good = true;
    while world.now() < Instant(500_000_000) {
        let cycled = world.cycle(&[OutWord(0); 2], &mut input);
        if good != (cycled.verdict == Verdict::Good) {
            good = !good;
            println!("{:?} us: {:?}", cycled.at.as_nanos() / 1_000, cycled.verdict);
        }
    }
    Ok(())
}
