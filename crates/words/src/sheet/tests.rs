use super::DataSheet;
use crate::Model;

// [R12]
#[test]
fn the_la_66_sheet_is_empty_where_its_manual_is() {
    let sheet = Model::La66.data_sheet();
    // Every field stands here, so that a new one must be empty too.
    let silent = DataSheet {
        document: sheet.document,
        revisions: sheet.revisions,
        chapters: sheet.chapters,
        device: sheet.device,
        standard: None,
        chip: sheet.chip,
        resolution: sheet.resolution,
        range: sheet.range,
        capacity: None,
        code: None,
        memory: sheet.memory,
        ident_code: 51,
        words: 2,
        refresh: None,
        kilobaud: None,
        interface: None,
        supply: None,
        preset_input: None,
        ssi: None,
        signals: &[],
        temperature: None,
        mechanics: None,
        connectors: &[],
        next_device_jumper: None,
        wiring: &[],
        programming: sheet.programming,
        lamps: &[],
        step_changes: &[],
        check_list: &[],
        safety: &[],
    };
    assert_eq!(*sheet, silent);
}

// [R129]
#[test]
fn the_levels_of_the_ce_65_are_kept_and_tell_which_stand_on_no_pin() {
    let sheet = Model::Ce65M.data_sheet();
    let levels = sheet.signals.iter().map(|it| (it.name, it.low_below_mv, it.high_above_mv, it.max_mv));
    assert!(levels.eq([
        ("US input", Some(2_000), Some(8_000), Some(35_000)),
        ("TTL input", Some(800), Some(2_000), Some(35_000)),
        ("TTL output", Some(800), Some(2_000), None),
        ("opto input", None, None, None),
    ]));
    let has_pin = |name: &str| {
        let mut pins = sheet.connectors.iter().flat_map(|connector| connector.pins);
        pins.any(|pin| pin.contains(name))
    };
    let without_pin = sheet.signals.iter().map(|signal| signal.name).filter(|name| !has_pin(name));
    assert!(without_pin.eq(["US input", "TTL input"]));
    assert!(Model::Ce100M.data_sheet().signals.is_empty());
}

#[test]
fn the_pins_that_matter_stand_where_the_manuals_put_them() {
    let pin = |model: Model, connector: &str, pin: usize| {
        let connectors = model.data_sheet().connectors;
        let found = connectors.iter().find(|c| c.name.starts_with(connector)).unwrap();
        found.pins[pin - 1]
    };
    assert_eq!(pin(Model::Ce65M, "X1", 6), "opto input, negative SSI clock");
    assert_eq!(pin(Model::Ce65M, "X2", 1), "opto input, positive SSI clock");
    assert_eq!(pin(Model::Ce65M, "X3", 6), "RBST inverted");
    assert_eq!(pin(Model::Ce100M, "REMOTE OUT", 9), "RBST (a further participant follows)");
    assert_eq!(pin(Model::Ce100M, "supply", 5), "preset 1");
    assert_eq!(pin(Model::Ce100M, "supply", 14), "US supply");
}

#[test]
fn figures_that_follow_from_the_sheet() {
    let sheet = Model::Ce65M.data_sheet();
    let mechanics = sheet.mechanics.unwrap();
    // 6000 rpm at 4096 steps: 204.8 steps in one refresh of 0.5 ms [R124].
    let steps_per_s = u64::from(mechanics.speed_rpm) / 60 * 4096;
    assert_eq!(steps_per_s, 409_600);
    assert_eq!(steps_per_s * sheet.refresh.unwrap().as_nanos() / 100_000_000, 2_048);
    assert_eq!(mechanics.bearing_life_revolutions / (3_000 * 60), 216_666);
    let supply = sheet.supply.unwrap();
    let (low_ma, high_ma) = supply.milliamperes.unwrap();
    assert_eq!(supply.millivolts.0 * u32::from(low_ma), 3_850_000);
    assert_eq!(supply.millivolts.1 * u32::from(high_ma), 4_050_000);
}
