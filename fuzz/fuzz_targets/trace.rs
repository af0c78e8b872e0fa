//! Any bytes as a trace: what can be read can be written, and then reads the same.
#![no_main]

use encoring_sim::device_line::{from_device, to_device};
use encoring_trace::{DeviceLine, Reader, Row, Writer};
use libfuzzer_sys::fuzz_target;

/// The devices and the rows before the first error; `None` if not even the header can be read.
fn read(bytes: &[u8]) -> Option<(Option<Vec<DeviceLine>>, Vec<Row>)> {
    let mut reader = match Reader::new("fuzz.csv", bytes) {
        Ok(reader) => reader,
        Err(refused) => {
            assert!(refused.line >= 1, "{refused}");
            return None;
        }
    };
    let devices = reader.recording().map(|recording| recording.devices.clone());
    let mut rows = Vec::new();
    for row in &mut reader {
        match row {
            Ok(row) => rows.push(row),
            Err(refused) => assert!(refused.to_string().starts_with("fuzz.csv"), "{refused}"),
        }
    }
    assert!(reader.next().is_none(), "nothing follows the end");
    Some((devices, rows))
}

fn written(devices: Option<&[DeviceLine]>, rows: &[Row]) -> Vec<u8> {
    let mut writer = match devices {
        Some(devices) => Writer::recording(Vec::new(), devices),
        None => Writer::new(Vec::new()),
    }
    .expect("devices that were read can be written");
    for row in rows {
        writer.write(row).expect("rows that were read can be written");
    }
    writer.into_inner()
}

fuzz_target!(|bytes: &[u8]| {
    let Some((devices, rows)) = read(bytes) else { return };
    let file = written(devices.as_deref(), &rows);
    let (devices_again, rows_again) = read(&file).expect("what was written can be read");

    // Lines may differ, the trace of one encoder is written without its position, and no trace has what a log adds.
    let plain = |row: &Row| Row {
        line: 0,
        position: row.position.filter(|_| devices.is_some()),
        value: None,
        cycle: None,
        status: None,
        parameter: None,
        ..*row
    };
    assert!(rows.iter().map(plain).eq(rows_again.iter().map(plain)), "{rows:?}\n{rows_again:?}");
    let named = |devices: &[DeviceLine]| -> Vec<DeviceLine> {
        devices.iter().map(|device| DeviceLine { line: 0, ..device.clone() }).collect()
    };
    assert_eq!(devices.as_deref().map(named), devices_again.as_deref().map(named));
    assert_eq!(written(devices_again.as_deref(), &rows_again), file, "written twice is written the same");

    for device in devices.iter().flatten() {
        if let Ok((unit, memory)) = from_device(device) {
            let again = from_device(&to_device(device.position, &unit, &memory));
            assert_eq!(again, Ok((unit, memory)), "{device}");
        }
    }
});
