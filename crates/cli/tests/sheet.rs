//! `encoring sheet`, run as a user runs it, beside what the manuals state.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, reason = "a test may panic")]

use std::process::Command;

use serde_json::Value;

/// Exit code, standard output and standard error of `encoring sheet` with these words.
fn sheet(arguments: &str) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_encoring"))
        .arg("sheet")
        .args(arguments.split(' '))
        .output()
        .expect("it runs");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// What is printed, in one line: row after row, of pins with their connector named once.
fn printed(arguments: &str) -> String {
    let format = if arguments.ends_with("pins") { "text" } else { "markdown" };
    let (code, out, err) = sheet(&format!("{arguments} --format {format}"));
    assert_eq!((code, err.as_str()), (Some(0), ""), "{arguments}");
    out.replace('|', " ").split_whitespace().collect::<Vec<_>>().join(" ")
}

const CE_100: &str = "ce-100-m";
const CE_65: &str = "ce-65-m";

/// A statement, the model and the section that it stands in, and what is printed there, in this order.
type Line = (u32, &'static str, &'static str, &'static [&'static str]);

/// R121..R130, R139 and R150..R161.
const FIGURES: &[Line] = &[
    (121, CE_100, "limits", &["supply voltage 11 27 V DC residual ripple 5 %"]),
    (121, CE_65, "limits", &["supply voltage 11 27 V DC residual ripple 5 %"]),
    (122, CE_65, "limits", &["current at 11 V 350 mA below", "current at 27 V 150 mA below"]),
    (
        123,
        CE_65,
        "limits",
        &["operating temperature 0 60 deg C", "storage temperature -30 80 deg C in a cool place"],
    ),
    (124, CE_65, "limits", &["permissible speed 6000 rpm"]),
    (
        125,
        CE_65,
        "limits",
        &["axial load on the shaft 40 N at the end", "radial load on the shaft 60 N at the end"],
    ),
    (
        126,
        CE_65,
        "limits",
        &["bearing life 3.9e10 revolutions at 3000 rpm, 20 N axial, 30 N radial, 60 deg C"],
    ),
    (
        127,
        CE_65,
        "limits",
        &[
            "angular acceleration 10000 rad/s^2",
            "moment of inertia 2.5 10^-6 kg m^2",
            "starting torque 2 Ncm at 20 deg C",
        ],
    ),
    (128, CE_65, "limits", &["vibration 100 m/s^2 50 to 2000 Hz", "shock 1000 m/s^2 11 ms"]),
    (
        129,
        CE_65,
        "levels",
        &[
            "US input 2 8 35 5000",
            "TTL input 0.8 2 35 5000",
            "TTL output 0.8 2 40",
            "opto input not stated",
            "cable",
        ],
    ),
    (130, CE_65, "pins", &["MINI-COMBICON, 8 A, 125 V, grid of 3.5 mm"]),
    (130, CE_65, "data", &["compact, 65 mm in diameter"]),
    (139, CE_65, "lamps", &["RD red", "disconnected", "RC green Remote-Control", "U green SUP1", "BA green"]),
    (150, CE_65, "faults", &["step changes loose contacts in the wiring", "check all cables and wires"]),
    (151, CE_65, "faults", &["severe vibration", "shock modules", "if the fault stays, replace the encoder"]),
    (
        152,
        CE_65,
        "faults",
        &[
            "electrical disturbance",
            "insulating flanges and couplings",
            "twisted pairs",
            "both ends",
            "noisier one",
        ],
    ),
    (
        153,
        CE_65,
        "faults",
        &["load", "sampling defect", "plastic couplings", "if the fault stays, replace the encoder"],
    ),
    (
        154,
        CE_65,
        "faults",
        &["2^0", "if the error comes again, replace the encoder", "2^1", "replace the encoder"],
    ),
    (
        155,
        CE_65,
        "faults",
        &["2^2", "set bit 2^30 (read-write bit) to 0", "2^3", "set bit 2^30 (read-write bit) to 1"],
    ),
    (156, CE_65, "faults", &["2^7 unknown command", "check the service number"]),
    (157, CE_65, "faults", &["2^13 revolutions numerator = 0", "1..FFFFh"]),
    (158, CE_65, "faults", &["2^14 measuring length", "rating plate", "raise numerator/denominator"]),
    (
        159,
        CE_100,
        "data",
        &[
            "18.11.1994",
            "software version is left empty",
            "index 03, 14.05.1996: baud rate",
            "RS485",
            "bit 2^13",
        ],
    ),
    (
        160,
        "la-66",
        "data",
        &["index 00, 01/22/01: first release", "index 02, 04/04/16: general modifications"],
    ),
    (
        161,
        CE_65,
        "data",
        &[
            "index 00, 07/31/96",
            "index 01, 02/24/97",
            "LEDs",
            "index 02, 10/10/97",
            "AK-40",
            "index 03, 04/04/16",
        ],
    ),
];

/// R131..R138.
const PINS: &[Line] = &[
    (
        131,
        CE_100,
        "pins",
        &[
            "REMOTE IN, 9-pin SUB-D plug 1 DO1 2 DI1 3 ground 1 4 screen 5 5 V, for tests 6 DO1 inverted 7 DI1 inverted 8 free 9 free",
        ],
    ),
    (
        132,
        CE_100,
        "pins",
        &[
            "REMOTE OUT, 9-pin SUB-D socket 1 DO2 2 DI2 3 ground 2 4 screen 5 5 V, for tests 6 DO2 inverted 7 DI2 inverted 8 free 9 RBST",
        ],
    ),
    (
        133,
        CE_100,
        "pins",
        &["5 preset 1 6 preset 2 7 free", "12 screen 13 free 14 US supply 15 0 V", "on request"],
    ),
    (
        134,
        CE_65,
        "pins",
        &[
            "X1, MINI-COMBICON 6-pin, REMOTE IN 1 DO inverted 2 DO 3 DI inverted 4 DI 5 GNDI (predecessor) 6 opto input, negative SSI clock",
        ],
    ),
    (
        135,
        CE_65,
        "pins",
        &[
            "X2, MINI-COMBICON 5-pin 1 opto input, positive SSI clock 2 TTL output, negative SSI data 3 TTL output, positive SSI data 4 0 V 5 US supply",
        ],
    ),
    (
        136,
        CE_65,
        "pins",
        &[
            "X3, MINI-COMBICON 6-pin, REMOTE OUT 1 DO inverted 2 DO 3 DI inverted 4 DI 5 GND (successor) 6 RBST inverted",
        ],
    ),
    (137, CE_65, "pins", &["X3 is not wired", "wire X3 too", "X3, pin 5 joined to pin 6"]),
    (138, CE_65, "pins", &["GNDI and GND are data reference potentials, isolated from each other"]),
];

/// R140..R149.
const RULES: &[Line] = &[
    (140, CE_65, "safety", &["does not stand alone and has no protective device of its own"]),
    (
        141,
        CE_65,
        "safety",
        &[
            "an error in internal data transfer or an illegal value",
            "acknowledged",
            "your own safety concept",
        ],
    ),
    (
        142,
        CE_65,
        "safety",
        &["speed, track errors and transfer errors are not diagnosed", "validity yourself"],
    ),
    (143, CE_65, "safety", &["bit 2^29", "stop the axis; if need be force an EMERGENCY STOP"]),
    (144, CE_65, "safety", &["after a dip or failure", "restarts in order; no dangerous state"]),
    (145, CE_65, "checklist", &["broken cable or wire leads to no undefined state", "operation by mistake"]),
    (
        146,
        CE_65,
        "checklist",
        &[
            "24 V supply safe electrical isolation",
            "IEC 364-4-41, HD 384.04.41 (VDE 0100 part 410)",
            "mains",
            "within the tolerances",
            "EMERGENCY STOP to EN 60204, IEC 204 (VDE 0113)",
        ],
    ),
    (
        147,
        CE_65,
        "checklist",
        &[
            "twisted pairs, at least 0.22 mm^2",
            "at least 10 mm^2",
            "much lower than the screen's",
            "a large area",
            "separate from power lines",
            "right angles",
        ],
    ),
    (
        148,
        CE_65,
        "checklist",
        &[
            "without voltage",
            "checked before switching on",
            "is changed on the encoder",
            "shock modules",
            "elastic",
            "qualified personnel",
            "welds",
            "aggressive media",
        ],
    ),
    (
        149,
        CE_65,
        "checklist",
        &[
            "not dropped",
            "glass",
            "original packing",
            "collar of fit f7; three screws",
            "two clamping brackets",
        ],
    ),
];

// [R150, R151, R152, R153]
#[test]
fn every_statement_from_r121_to_r161_stands_in_the_sheet() {
    let lines = || [FIGURES, PINS, RULES].into_iter().flatten();
    for (statement, model, section, said) in lines() {
        let page = printed(&format!("{model} {section}"));
        let mut rest = page.as_str();
        for part in *said {
            let Some((_, after)) = rest.split_once(part) else {
                panic!("R{statement}: {part:?} is not in: {rest}");
            };
            rest = after;
        }
    }
    let mut listed: Vec<u32> = lines().map(|line| line.0).collect();
    listed.sort_unstable();
    listed.dedup();
    assert_eq!(listed, (121..=161).collect::<Vec<_>>());
}

#[test]
fn what_a_manual_leaves_out_is_not_stated() {
    for section in ["pins", "lamps", "faults", "checklist", "safety", "limits", "levels", "ssi"] {
        let page = printed(&format!("la-66 {section}"));
        assert!(page.contains("not stated in its manual. Another encoder's manual states it:"), "{page}");
    }
    for section in ["lamps", "faults", "checklist", "safety", "ssi"] {
        assert!(printed(&format!("ce-100-m {section}")).contains("not stated in its manual"), "{section}");
    }
    let limits = printed("ce-100-m limits");
    assert!(limits.contains("operating temperature not stated"), "{limits}");
    let data = printed("la-66 data");
    for quantity in ["interface", "transfer rate", "data refresh", "capacity", "output code"] {
        assert!(data.contains(&format!("{quantity} not stated")), "{quantity}: {data}");
    }
}

#[test]
fn the_services_stand_with_ranges_and_words() {
    let services = printed("ce-65-m services");
    for row in [
        "02 measuring length in steps 82000000 C2000010..C2FFFFFF 10h..FFFFFFh (16..16777215)",
        "03 revolutions numerator 83000000 C3000001..C300FFFF 1h..FFFFh (1..65535)",
        "06 preset adjustment C6000000 + value 0..measuring length in steps",
        "08 data check 88000000 checks the programmed values",
        "09 revolutions denominator 89000000 C9000001..C9000063 1h..63h (1..99)",
        "0D SSI characteristic values 8D000000 CD000000 + value byte 2, repetition: 0 without",
    ] {
        assert!(services.contains(row), "{row}: {services}");
    }
    assert!(!services.contains("preset value"));
    assert!(printed("la-66 services").contains("C4000000..C4FFFFFF"));
}

#[test]
fn the_page_of_data_sheets_is_what_the_program_prints() {
    let page = include_str!("../../../docs/data-sheets.md");
    let (code, out, _) = sheet("all --format markdown");
    assert_eq!(code, Some(0));
    assert!(out == page, "write it anew: encoring sheet all --format markdown > docs/data-sheets.md");
}

#[test]
fn a_sheet_for_programs_is_one_object_a_model() {
    let (code, out, err) = sheet("all limits --format json");
    assert_eq!((code, err.as_str(), out.lines().count()), (Some(0), "", 3));
    let sheets: Vec<Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let speed = |sheet: &Value| {
        let rows = sheet["sections"][0]["rows"].as_array().unwrap().clone();
        rows.into_iter().find(|row| row["quantity"] == "permissible speed").map(|row| row["most"].clone())
    };
    assert_eq!(sheets.iter().map(speed).collect::<Vec<_>>(), [None, Some(Value::Null), Some(6000.into())]);
}

#[test]
fn a_section_or_a_model_that_is_none_is_refused_with_those_there_are() {
    for (arguments, named) in [
        (
            "ce-65-m legs",
            "data, pins, lamps, services, status, faults, checklist, safety, limits, levels, ssi",
        ),
        ("ce-99", "the models are la-66, ce-100-m and ce-65-m; or all"),
    ] {
        let (code, out, err) = sheet(arguments);
        assert_eq!((code, out.as_str()), (Some(2), ""), "{arguments}");
        assert!(err.contains(named), "{err}");
    }
}

#[test]
fn no_line_for_people_is_wider_than_100_columns() {
    let (_, out, _) = sheet("all");
    assert_eq!(out.lines().find(|line| line.len() > 100), None);
}
