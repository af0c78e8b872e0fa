//! Rings of several encoders, each with a generated program of its own, before the referees of the ring.
#![allow(
    clippy::indexing_slicing,
    dead_code,
    reason = "a test may panic, and does not use all of the generator"
)]

use encoring_bus::Referees;
use encoring_host::referee::{Observed, Vantage};
use encoring_words::model::MODELS;

#[path = "../../host/tests/referee/mistake.rs"]
mod mistake;
#[path = "../../host/tests/referee/plant.rs"]
mod plant;

use mistake::{MISTAKES, Mistake};
use plant::{Chance, Plant};

/// What was seen at which position, in order.
type Seen = Vec<(u8, Observed)>;

/// A ring of encoders, each with a program and what that does wrong.
fn ring(seed: u64) -> (Seen, Vec<(Mistake, Plant)>) {
    let mut chance = Chance::of(seed);
    let cycle_us = plant::cycle_us(&mut chance);
    let mut programs = Vec::new();
    let mut seen = Vec::new();
    for position in 0..chance.between(2, 8) as u8 {
        let model = MODELS[chance.below(MODELS.len() as u64) as usize];
        let (mistake, ..) = MISTAKES[chance.below(MISTAKES.len() as u64) as usize];
        let mut plant = Plant::on(cycle_us, &mut chance, model);
        plant.program(&mut chance, mistake);
        seen.extend(plant.seen.iter().map(|seen| (position, *seen)));
        programs.push((mistake, plant));
    }
    seen.sort_by_key(|(_, seen)| match seen {
        Observed::Cycle { at, .. } | Observed::Write { at, .. } => *at,
    });
    (seen, programs)
}

/// What is found of each program, from there.
fn judge(vantage: Vantage, seen: &[(u8, Observed)], programs: &[(Mistake, Plant)]) -> Referees {
    let mut referees = Referees::new(vantage, None);
    for (position, (_, plant)) in (0..).zip(programs) {
        referees.place(position, plant.model);
    }
    for (position, seen) in seen {
        if vantage == Vantage::Writes || matches!(seen, Observed::Cycle { .. }) {
            referees.observe(*position, *seen);
        }
    }
    referees.finish();
    referees
}

// [R30, R33, R38, R39, R40]
#[test]
fn each_program_of_a_ring_has_the_findings_of_its_own_mistake_and_no_others() {
    for seed in 0..200 {
        let (seen, programs) = ring(seed);
        for vantage in [Vantage::Writes, Vantage::Cycles] {
            let referees = judge(vantage, &seen, &programs);
            for (position, (mistake, plant)) in (0..).zip(&programs) {
                let found = referees.findings().filter(|(at, _)| *at == position);
                let found: Vec<_> = found.map(|(_, finding)| plant::name(finding)).collect();
                // Cycles show no halves.
                if (*mistake, vantage) != (Mistake::Torn, Vantage::Cycles) {
                    let wanted = mistake.breaks(plant.model);
                    assert_eq!(found, wanted, "seed {seed}, position {position}, {mistake:?}, {vantage:?}");
                }
            }
        }
    }
}
