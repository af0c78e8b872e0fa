//! Any bytes as what was seen on a bus: what can be read can be written, and then reads the same; referees take it all.
#![no_main]

use encoring_bus::Referees;
use encoring_host::referee::Vantage;
use encoring_station::refereeing::observed;
use encoring_trace::DeviceLine;
use encoring_trace::bus::{BusReader, BusRow, BusWriter};
use libfuzzer_sys::fuzz_target;

/// The devices and the rows before the first error; `None` if not even the header can be read.
fn read(bytes: &[u8]) -> Option<(Vec<DeviceLine>, Vec<BusRow>)> {
    let mut reader = match BusReader::new("fuzz.csv", bytes) {
        Ok(reader) => reader,
        Err(refused) => {
            assert!(refused.to_string().starts_with("fuzz.csv"), "{refused}");
            return None;
        }
    };
    let devices = reader.devices().to_vec();
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

/// Without its place in the file.
fn content(rows: &[BusRow]) -> Vec<BusRow> {
    rows.iter().map(|row| BusRow { line: 0, ..*row }).collect()
}

fuzz_target!(|bytes: &[u8]| {
    let Some((devices, rows)) = read(bytes) else { return };
    let mut file = Vec::new();
    let mut writer = BusWriter::new(&mut file, &devices).expect("memory takes everything");
    for row in &rows {
        writer.write(row).expect("rows that were read can be written");
    }
    let (again, same) = read(&file).expect("what was written can be read");
    assert_eq!(content(&same), content(&rows));
    let shown = |devices: &[DeviceLine]| devices.iter().map(ToString::to_string).collect::<Vec<_>>();
    assert_eq!(shown(&again), shown(&devices));
    let mut referees = Referees::new(Vantage::Cycles, None);
    for row in &rows {
        referees.observe(row.position, observed(row));
    }
    referees.finish();
    assert!(referees.findings().all(|(_, finding)| finding.first <= finding.last && finding.count > 0));
});
