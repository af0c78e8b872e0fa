//! The lamps of a ring, as a view shows them.
#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, missing_docs, reason = "tests")]

use std::path::Path;

use encoring_ring::{ProcessImage, Verdict};
use encoring_sim::scenario::Change;
use encoring_sim::{Fault, Scenario, World};
use encoring_station::View;
use encoring_station::view::Counters;
use encoring_words::{Duration, InWord, OutWord};

const FOREVER: Duration = Duration(u64::MAX);

struct Ring {
    world: World,
    last: Verdict,
}

impl Ring {
    fn new() -> Self {
        let devices: String =
            (0..3).map(|k| format!("[[device]]\nposition = {k}\nmodel = \"ce-65-m\"\n")).collect();
        let scenario = Scenario::parse("test", &format!("version = 1\n{devices}"), Path::new("")).unwrap();
        Self { world: World::new(&scenario).unwrap(), last: Verdict::Good }
    }

    fn run_for_ms(&mut self, ms: u64) {
        let end = self.world.now() + Duration::from_millis(ms);
        while self.world.now() < end {
            self.last = self.world.cycle(&[OutWord(0); 3], &mut [InWord(0); 3]).verdict;
        }
    }

    /// The lamps that are lit at each encoder, by their names.
    fn lit(&self) -> Vec<String> {
        let image = ProcessImage::new(3).unwrap();
        let view = View::of(&self.world, &image, self.last, Counters::default());
        let lit = view.devices.iter().map(|device| {
            let lamps = device.lamps;
            let each = [("U", lamps.u), ("BA", lamps.ba), ("RC", lamps.rc), ("RD", lamps.rd)];
            each.iter().filter(|(_, on)| *on).map(|(name, _)| *name).collect::<Vec<_>>().join(" ")
        });
        lit.collect()
    }
}

// [R139]
#[test]
fn while_cycles_run_only_the_last_encoder_has_its_outgoing_bus_switched_off() {
    let mut ring = Ring::new();
    ring.run_for_ms(10);
    assert_eq!(ring.lit(), ["U BA RC", "U BA RC", "U BA RC RD"]);
}

// [R139]
#[test]
fn the_lamp_ba_goes_off_640_ms_after_the_last_data_cycle() {
    let mut ring = Ring::new();
    ring.run_for_ms(10);
    ring.world.trouble(1, Fault::Bad, FOREVER);
    let ba = |ring: &Ring| ring.lit().iter().map(|lit| lit.contains("BA")).collect::<Vec<_>>();
    ring.run_for_ms(635);
    assert_eq!(ba(&ring), [true; 3]);
    ring.run_for_ms(10);
    // The master stops, searches and begins again; then the first one takes its word.
    assert_eq!(ba(&ring), [true, false, false]);
    ring.world.end_trouble();
    ring.run_for_ms(50);
    assert_eq!(ring.lit(), ["U BA RC", "U BA RC", "U BA RC RD"]);
}

// [R139]
#[test]
fn the_lamp_rc_goes_off_behind_a_break_after_25_ms() {
    let mut ring = Ring::new();
    ring.run_for_ms(10);
    ring.world.trouble(1, Fault::Silent, FOREVER);
    let rc = |ring: &Ring| ring.lit().iter().map(|lit| lit.contains("RC")).collect::<Vec<_>>();
    ring.run_for_ms(20);
    assert_eq!(rc(&ring), [true, true, true]);
    ring.run_for_ms(10);
    assert_eq!(rc(&ring), [true, false, false]);
    ring.world.end_trouble();
    ring.run_for_ms(1);
    assert_eq!(rc(&ring), [true, true, true]);
}

#[test]
fn an_encoder_in_reset_has_its_outgoing_bus_switched_off() {
    let mut ring = Ring::new();
    ring.run_for_ms(10);
    ring.world.trouble(1, Fault::Silent, FOREVER);
    ring.run_for_ms(30);
    let rd: Vec<bool> = ring.lit().iter().map(|lit| lit.contains("RD")).collect();
    assert_eq!(rd, [false, true, true]);
}

#[test]
fn without_supply_no_lamp_is_lit() {
    let mut ring = Ring::new();
    ring.run_for_ms(10);
    ring.world.change(1, &[Change::Supply(10_449)]);
    ring.run_for_ms(10);
    assert_eq!(ring.lit()[1], "");
}

#[test]
fn the_lamp_u_shows_the_supply_though_no_good_cycle_comes() {
    let mut ring = Ring::new();
    ring.run_for_ms(10);
    ring.world.trouble(0, Fault::Bad, FOREVER);
    ring.world.change(1, &[Change::Supply(0)]);
    ring.run_for_ms(10);
    ring.world.change(1, &[Change::Supply(24_000)]);
    ring.run_for_ms(10);
    let lit = ring.lit();
    assert!(lit[1].contains('U'), "lit: {lit:?}");
}
