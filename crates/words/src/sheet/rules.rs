//! The rules of the CE-65-M's manual, the only one that has any.

use super::{Rule, StepChange};

/// The first part of the disturbances table [R150..R153]; the second part is in [`crate::status::STATUS_BITS`].
pub(super) const CE_65_STEP_CHANGES: &[StepChange] = &[
    StepChange {
        cause: "loose contacts in the wiring",
        remedy: "check all cables and wires that lead to the encoder",
    },
    StepChange {
        cause: "severe vibration",
        remedy: "cushion vibration, shocks and jolts, as on presses, with shock modules; if the fault stays, replace \
                 the encoder",
    },
    StepChange {
        cause: "electrical disturbance",
        remedy: "use insulating flanges and couplings, and twisted pairs for data and supply; ground the screens at \
                 both ends, or only in the switching cabinet if the machine ground is the noisier one",
    },
    StepChange {
        cause: "excessive axial or radial load on the shaft, or a sampling defect",
        remedy: "use plastic couplings, which keep the load off the shaft; if the fault stays, replace the encoder",
    },
];

const fn rule(chapter: &'static str, about: &'static str, text: &'static str) -> Rule {
    Rule { chapter, about, text }
}

/// [R145..R149]
pub(super) const CE_65_CHECK_LIST: &[Rule] = &[
    // [R145]
    rule(
        "1.2.1",
        "wire breakage",
        "a broken cable or wire leads to no undefined state, by hardware and software",
    ),
    rule("1.2.1", "operator inputs", "equipment and its inputs are protected against operation by mistake"),
    // [R146]
    rule(
        "1.2.1",
        "24 V supply",
        "safe electrical isolation; only mains units to IEC 364-4-41, HD 384.04.41 (VDE 0100 part 410)",
    ),
    rule("1.2.1", "mains", "the set voltage is the local one and stays within the tolerances"),
    rule(
        "1.2.1",
        "mains switch",
        "a fixed connection has a mains switch or a fuse, and the equipment a protective earth",
    ),
    rule(
        "1.2.1",
        "EMERGENCY STOP",
        "to EN 60204, IEC 204 (VDE 0113): effective in every operating mode, and no restart when it is unlocked",
    ),
    rule("1.2.1", "regulations", "the safety and accident prevention rules of the application are kept"),
    // [R147]
    rule("1.2.1.2", "data cables", "screened, for RS422 in twisted pairs, at least 0.22 mm^2"),
    rule(
        "1.2.1.2",
        "ground cable",
        "at least 10 mm^2, its resistance much lower than the screen's, so that the screen carries no equalising \
         current",
    ),
    rule("1.2.1.2", "screen", "continuous, a large area in contact with screen terminals, well earthed"),
    rule(
        "1.2.1.2",
        "routing",
        "far from or separate from power lines, no inductive or capacitive interference; cables cross at right angles",
    ),
    // [R148]
    rule("1.3", "wiring", "the system is without voltage while connections are wired, opened or closed"),
    rule("1.3", "connections", "every electrical connection is checked before switching on"),
    rule("1.3", "changes", "nothing mechanical or electrical is changed on the encoder"),
    rule(
        "1.3",
        "vibration",
        "excessive vibration, shocks and jolts are kept away, on presses with shock modules",
    ),
    rule(
        "1.3, 2.3",
        "coupling",
        "elastic, so that no offset between encoder and drive shaft loads the bearings",
    ),
    rule("1.4", "personnel", "only qualified personnel commission it"),
    rule("1.5", "welding", "nobody welds while the encoder is wired up or on"),
    rule("1.5", "supply", "11 to 27 V DC, residual ripple 5 % either way"),
    rule("1.5", "surroundings", "no aggressive media, such as acid"),
    // [R149]
    rule(
        "2.1",
        "transport",
        "not dropped or jolted, it has an optical system with glass; in the original packing",
    ),
    rule("2.3", "mounting", "collar of fit f7; three screws in the flange, or two clamping brackets"),
];

/// [R140..R144]
pub(super) const CE_65_SAFETY: &[Rule] = &[
    rule("1.1", "component", "the encoder does not stand alone and has no protective device of its own"),
    rule(
        "1.1",
        "error bit",
        "tells an error in internal data transfer or an illegal value of a parameter, and must be acknowledged; it \
         belongs into your own safety concept, in the program of the PLC",
    ),
    rule(
        "1.1",
        "no diagnostics",
        "too high a speed, track errors and transfer errors are not diagnosed: check the received data for validity \
         yourself",
    ),
    rule(
        "1.2.1",
        "voltage dips",
        "after a dip or failure an interrupted program restarts in order; no dangerous state, even briefly; if need \
         be force an EMERGENCY STOP",
    ),
    rule(
        "1.6",
        "bit 2^29",
        "as soon as it is set, prevent injury and damage, e.g. stop the axis; if need be force an EMERGENCY STOP",
    ),
];
