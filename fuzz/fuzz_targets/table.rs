//! Any bytes as a table of another program, with and without what a person says about it: rows or a refusal that names
//! the line, and times that never run backwards.
#![no_main]

use encoring_trace::{Reader, TableLayout};
use encoring_words::number::Bare;
use libfuzzer_sys::fuzz_target;

fn layouts() -> [TableLayout; 4] {
    let columns = |text: &str| Some(text.parse().expect("columns"));
    [
        TableLayout::default(),
        TableLayout { bare: Bare::Decimal, ..TableLayout::default() },
        TableLayout { columns: columns("time=1,out_high=2,out_low=3,in=4"), ..TableLayout::default() },
        TableLayout { columns: columns("in=b,value=a"), period_ns: Some(u64::MAX), ..TableLayout::default() },
    ]
}

fuzz_target!(|bytes: &[u8]| {
    for layout in layouts() {
        let mut reader = match Reader::with("fuzz.csv", bytes, &layout) {
            Ok(reader) => reader,
            Err(refused) => {
                assert!(refused.line >= 1, "{refused}");
                continue;
            }
        };
        let (mut time_ns, mut line) = (0, 0);
        for row in &mut reader {
            match row {
                Ok(row) => {
                    assert!(
                        row.time_ns >= time_ns && row.line > line,
                        "{row:?} after {time_ns} ns, line {line}"
                    );
                    (time_ns, line) = (row.time_ns, row.line);
                }
                Err(refused) => assert!(refused.line > line, "{refused} after line {line}"),
            }
        }
        assert!(reader.next().is_none(), "nothing follows the end");
    }
});
