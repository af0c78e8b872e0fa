//! One trace as many programs write it, read alike; and what is refused, with what to type.

#![allow(clippy::unwrap_used, clippy::disallowed_methods, reason = "tests")]

use encoring_trace::{CycleSeen, Error, Input, Reader, Row, TableLayout};
use encoring_words::number::Bare;

/// Every table of the folder, what `--columns` says, and further options.
const TABLES: [(&str, &str, &str); 42] = [
    ("base.csv", "", ""),
    ("bom.csv", "", ""),
    ("crlf.csv", "", ""),
    ("extra.csv", "", ""),
    ("german.csv", "", ""),
    ("semicolon.csv", "", ""),
    ("seconds.csv", "", ""),
    ("plc.csv", "time_ms=Zeitstempel,out=QD 256,in=ID 256", ""),
    ("step7-dates.csv", "time=Date_and_time,out=QD 256,in=ID 256", ""),
    ("step7-dt.csv", "time=T,out=Q,in=I", ""),
    ("halves-step7.csv", "time_ms=Zeit,out_high=AW 256,out_low=AW 258,in_high=EW 256,in_low=EW 258", ""),
    ("kh.csv", "", ""),
    ("codesys.csv", "", ""),
    ("scope.csv", "", ""),
    ("units-below.csv", "", ""),
    ("halves.csv", "", ""),
    ("halves-decimal.csv", "", "decimal"),
    ("signed.csv", "", "decimal"),
    ("utf-16.txt", "", ""),
    ("utf-16-without-mark.txt", "", ""),
    ("windows-1252.csv", "time=Zeit [µs],out=Ausgänge,in=IN", ""),
    ("trailing.csv", "", ""),
    ("blank-lines.csv", "", ""),
    ("cr-only.csv", "", ""),
    ("excel-sep.csv", "", ""),
    ("columns-before.csv", "", ""),
    ("iso-zone.csv", "", ""),
    ("day-first.csv", "", ""),
    ("midnight.csv", "", ""),
    ("since-1970.csv", "", ""),
    ("no-header.csv", "time_s=1,out=2,in=3", ""),
    ("no-time.csv", "", "period"),
    ("thousands.csv", "", ""),
    ("unit-behind.csv", "", ""),
    ("iec-spans.csv", "", ""),
    ("pandas-spans.csv", "", "decimal"),
    ("zone-apart.csv", "", ""),
    ("time-by-unit.csv", "", ""),
    ("time-by-date.csv", "", ""),
    ("quoted-variables.csv", "time=Timestamp,out=DB10.OUT,in=DB10.IN", ""),
    ("twincat.csv", "time_ms=1,out=2,in=4", "decimal"),
    ("quoted-names.csv", "time_s=\"Time, s\",out=\"a=b\",in=IN", ""),
];

fn layout(columns: &str, further: &str) -> TableLayout {
    TableLayout {
        columns: (!columns.is_empty()).then(|| columns.parse().unwrap()),
        period_ns: (further == "period").then_some(1_000_000),
        bare: if further == "decimal" { Bare::Decimal } else { Bare::Hexadecimal },
        faults: None,
    }
}

fn rows(file: &[u8], layout: &TableLayout) -> Result<Vec<Row>, Error> {
    Reader::with("a.csv", file, layout)?.collect()
}

fn folder() -> String {
    format!("{}/tests/tables", env!("CARGO_MANIFEST_DIR"))
}

/// What is exchanged; lines and what is assumed apart.
fn exchanged(rows: &[Row]) -> Vec<(u64, Option<u32>, Option<Input>)> {
    rows.iter().map(|row| (row.time_ns, row.out, row.input)).collect()
}

#[test]
fn one_trace_in_many_spellings_reads_alike() {
    let base = std::fs::read(format!("{}/base.csv", folder())).unwrap();
    let base = exchanged(&rows(&base, &TableLayout::default()).unwrap());
    assert_eq!(base.len(), 7);
    for (name, columns, further) in TABLES {
        let file = std::fs::read(format!("{}/{name}", folder())).unwrap();
        let found = rows(&file, &layout(columns, further)).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(exchanged(&found), base, "{name}");
    }
    let mut there: Vec<_> = std::fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| name != "README.md")
        .collect();
    there.sort();
    let mut named = TABLES.map(|(name, ..)| name);
    named.sort_unstable();
    assert_eq!(there, named, "every table is read");
}

#[test]
fn what_was_assumed_is_one_line() {
    for (file, columns, expected) in [
        ("time_us,out,in\n", "", None),
        (
            "Time [s];IN;Motor\n0,5;00000000;x\n",
            "",
            Some("`;` separates the cells; time in s from \"Time [s]\"; in from \"IN\"; not read: \"Motor\""),
        ),
        (
            "00000000\t7\n",
            "in=1,value=2",
            Some("a tab separates the cells; in from 1; value from 2; rows are 1 ms apart, see --period"),
        ),
        (
            "Time,IN\n2026-11-27 10:00:00,00000000\n",
            "",
            Some("`,` separates the cells; time from \"Time\" counts from the first row; in from \"IN\""),
        ),
    ] {
        let reader = Reader::with("a.csv", file.as_bytes(), &layout(columns, "")).unwrap();
        assert_eq!(reader.assumed(), expected, "{file}");
    }
}

#[test]
fn a_refused_table_says_where_why_and_what_to_type() {
    for (file, columns, expected) in [
        (
            "Time,OUT,IN\n0.001,00000000,00000000\n",
            "",
            "line 1, column \"Time\": no unit, and \"0.001\" is no date; type --columns \
             \"time_ms=Time,out=OUT,in=IN\", or with time_s, time_us or time_ns",
        ),
        (
            "Zeitstempel;QD 256;ID 256\n0,000;DW#16#00000000;DW#16#00000000\n",
            "",
            "line 1: none of the columns \"Zeitstempel\", \"QD 256\", \"ID 256\" is in, out or value by its name; \
             say which, as --columns \"time_ms=Zeitstempel,out=QD 256,in=ID 256\"",
        ),
        (
            "time_ms;OUT (hex);IN (hex)\n0;00000000;00000000\n",
            "",
            "line 1, column \"OUT (hex)\": looks like out; if it is, type --columns \
             \"time_ms=time_ms,out=OUT (hex),in=IN (hex)\"; if not, type --columns \"time_ms=time_ms\"",
        ),
        (
            "time_ms;OUT;IN;IN\n0;00000000;00000000;00000000\n",
            "",
            "line 1: \"IN\" and \"IN\" are both in; say which is read, as --columns \"time_ms=1,out=2,in=3\"",
        ),
        (
            "time;time_ms;IN\n0;0;00000000\n",
            "",
            "line 1: \"time\" and \"time_ms\" are both the time; say which is read, as --columns \"time_ms=time_ms,in=IN\"",
        ),
        (
            "Zeit;IN\n31.02.2026 10:00:00;00000000\n",
            "",
            "line 2, column \"Zeit\": \"31.02.2026 10:00:00\" is no time that is read, such as \
             2026-11-27T10:00:00.001Z, 27.11.2026 10:00:00.001 or T#1s200ms; rewrite them, or leave the column out \
             and say how far rows are apart, as --columns \"in=IN\" --period 10ms",
        ),
        (
            "time_s,word\n0.001,00000000\n",
            "",
            "line 1: none of the columns \"time_s\", \"word\" is in, out or value by its name; \
             say which, as --columns \"time_s=time_s,in=word\"",
        ),
        (
            "0.000,00000000,00000000\n",
            "",
            "line 1: no header: say which column is which by its number, as --columns \"time_ms=1,out=2,in=3\"",
        ),
        (
            "0.000,00000000,00000000\n",
            "time_s=T,in=IN",
            "line 1: no header, so --columns takes numbers from 1, as --columns \"time_ms=1,out=2,in=3\"",
        ),
        (
            "Time [s],OUT,IN word\n0.001,00000000,00000000\n",
            "",
            "line 1, column \"IN word\": looks like in; if it is, type --columns \
             \"time_s=Time [s],out=OUT,in=IN word\"; if not, type --columns \"time_s=Time [s],out=OUT\"",
        ),
        (
            "Time [s],IN,Inn\n0.001,00000000,3\n",
            "",
            "line 1, column \"Inn\": looks like in, which is there too; to read the others and leave it, type \
             --columns \"time_s=Time [s],in=IN\"",
        ),
        (
            "t [s];in;IN\n0,001;00000000;00000000\n",
            "",
            "line 1: \"in\" and \"IN\" are both in; say which is read, as --columns \"time_s=t [s],in=in\"",
        ),
        (
            "time_us;in\n0;270F\n",
            "",
            "line 2, column \"in\": 270F: a word has 8 digits; zeros may be lost. Write 0000270F or 0x270F",
        ),
        (
            "time_us;in\n5;00000000\n3;00000000\n",
            "",
            "line 3, column \"time_us\": \"3\" is 2 us before the row before it; sort the rows by time, or leave the \
             column out and give --period",
        ),
        (
            "time_us;out;in\n5;00000000;00000000\n6;0000",
            "",
            "line 3: 2 cells, the header has 3; the file ends within this line: delete it, or bring the rest",
        ),
        ("t [s];in\n\n1;00000000;9\n", "", "line 3: 3 cells, the header has 2"),
        (
            "t [s];in\n\"1;00000000\n2;00000000\n",
            "",
            "line 2: a double quote in this row is not closed, so the next one is read with it",
        ),
        (
            "\"t [s]\",in\n\"0,001\",00000000\n",
            "",
            "line 2, column \"t [s]\": \"0,001\" is not a time in s; where a comma separates the cells, decimals \
             stand behind a point",
        ),
        (
            "supply_v,out,in\n\"24,0\",00000000,00000000\n",
            "",
            "line 2, column supply_v: \"24,0\" is not a voltage from 0 to 1000 with at most three decimals; where a \
             comma separates the cells, decimals stand behind a point",
        ),
        (
            "Supply_V,OUT\n\"24,0\",00000000\n",
            "",
            "line 2, column \"Supply_V\": \"24,0\" is not a voltage from 0 to 1000 with at most three decimals; where \
             a comma separates the cells, decimals stand behind a point",
        ),
        (
            "Time [s],IN\n(ms),(V)\n1,00000000\n",
            "",
            "line 1, column \"Time [s]\": a time in s, and the row of units below says ms; correct one of them",
        ),
        (
            "Time,IN\n(min),()\n1,00000000\n",
            "",
            "line 1, column \"Time\": no unit, and \"1\" is no date; type --columns \"time_ms=Time,in=IN\", or with \
             time_s, time_us or time_ns",
        ),
        (
            "time_us;in\n0;00000000\n1.000;00000000\n",
            "",
            "line 3, column \"time_us\": 1.000: decimals, or 1000 with a mark between its thousands, as whole times \
             stand above; write all times with decimals, or none with a mark",
        ),
        (
            "time_us;in\n0;00000000\n1'00;00000000\n",
            "",
            "line 3, column \"time_us\": \"1'00\" is not a time in us",
        ),
        (
            "Time (UTC);IN\n5;00000000\n",
            "",
            "line 1, column \"Time (UTC)\": no unit, and \"5\" is no date; type --columns \"time_ms=Time (UTC),in=IN\", \
             or with time_s, time_us or time_ns",
        ),
        (
            "time,IN\n11/27/2026 10:00:00,00000000\n",
            "",
            "line 2, column \"time\": \"11/27/2026 10:00:00\" is no time that is read, such as \
             2026-11-27T10:00:00.001Z, 27.11.2026 10:00:00.001 or T#1s200ms; rewrite them, or leave the column out \
             and say how far rows are apart, as --columns \"in=IN\" --period 10ms",
        ),
        (
            "Takt [ms];Dauer [ms];IN\n1;2;00000000\n",
            "",
            "line 1: \"Takt [ms]\" and \"Dauer [ms]\" may both be the time; say which is, as --columns \
             \"time_ms=Takt [ms],in=IN\", or give --period",
        ),
        (
            "Time ms;IN\n1;00000000\n",
            "",
            "line 1, column \"Time ms\": looks like time_ms; if it is, type --columns \"time_ms=Time ms,in=IN\"; if \
             not, type --columns \"in=IN\"",
        ),
        (
            "Time [s],\"IN \"\"a\"\"\"\n1,00000000\n",
            "",
            "line 1, column \"IN \\\"a\\\"\": looks like in; if it is, type --columns \"time_s=Time [s],in=IN a\"; if \
             not, type --columns \"time_s=Time [s]\"",
        ),
        (
            "time_us|out|in\n0|00000000|00000000\n",
            "",
            "line 1: \"time_us|out|in\" is one cell: cells are separated by `,`, `;` or a tab; write one of them",
        ),
        ("t [s];in_high\n1;0000\n", "", "line 1: in_high and in_low: only one of the halves is there"),
        (
            "in_high;in_low\n0000;\n",
            "",
            "line 2, column \"in_high\": one half of a word is there and the other is not",
        ),
        (
            "t [s];in;Position\n1;00000000;4711\n",
            "",
            "line 2, column \"Position\": \"4711\" is not a whole number from 0 to 127; a position in steps is the \
             column value",
        ),
        (
            "t [s];IN\n1;0\n",
            "in=X",
            "line 1: --columns: no column is called \"X\"; the columns are \"t [s]\", \"IN\"",
        ),
        (
            "# encoring-trace 1\nposition,in\n",
            "in=in",
            "line 2: a recording says itself what its columns and words are; leave --columns, --decimal and \
             --period out",
        ),
    ] {
        let error = rows(file.as_bytes(), &layout(columns, "")).unwrap_err();
        assert_eq!(error.to_string(), format!("a.csv {expected}"), "{file}");
    }
}

#[test]
fn a_mark_in_a_time_is_one_of_decimals_once_a_time_has_had_decimals() {
    for first in ["0,000", "0.5", "1,000"] {
        let table = format!("time_ms;in\n{first};00000000\n12,500;00000000\n");
        let rows = rows(table.as_bytes(), &TableLayout::default()).unwrap();
        assert_eq!(rows.last().unwrap().time_ns, 12_500_000, "{first}");
    }
    let tall = rows(b"time_ms,in\n0,00000000\n1.000,00000000\n", &TableLayout::default()).unwrap();
    assert_eq!(tall.last().unwrap().time_ns, 1_000_000, "a comma separates the cells");
}

#[test]
fn a_temperature_is_no_time() {
    let table = "time_us;T [°C];IN\n5;21,5;00000000\n";
    let rows = rows(table.as_bytes(), &TableLayout::default()).unwrap();
    assert_eq!(rows.last().map(|row| row.time_ns), Some(5_000));
}

#[test]
fn text_of_four_bytes_a_letter_is_refused_by_name() {
    for file in [&b"\xFF\xFE\0\0t\0\0\0"[..], b"\0\0\xFE\xFF\0\0\0t"] {
        let error = rows(file, &TableLayout::default()).unwrap_err().to_string();
        assert_eq!(error, "a.csv line 1: cannot read: the text is UTF-32; save it as UTF-8");
    }
}

#[test]
fn a_row_of_units_may_stand_below_a_header_of_ours_too() {
    let trace = "time_us,out,in\n0,00000000,000003E8\n1000,00000000,000003E9\n";
    let rows = |text: &str| {
        let reader = Reader::new("t.csv", text.as_bytes()).unwrap();
        let assumed = reader.assumed().map(str::to_owned);
        (
            reader
                .map(|row| {
                    let row = row.unwrap();
                    (row.time_ns, row.out, row.input)
                })
                .collect::<Vec<_>>(),
            assumed,
        )
    };
    let (expected, ours) = rows(trace);
    assert_eq!(ours, None, "a header as we write it is assumed nothing of");
    for units in ["us,,", "(us),(),()", "[\u{b5}s],,", "# a remark\n\n(us),,"] {
        let (found, assumed) = rows(&trace.replacen('\n', &format!("\n{units}\n"), 1));
        assert_eq!(found, expected, "{units}");
        let assumed = assumed.unwrap();
        assert!(
            assumed.contains("time in us") && assumed.contains("the row below the names has units"),
            "{assumed}"
        );
    }
    let other = trace.replacen('\n', "\n(ms),,\n", 1);
    assert_eq!(
        Reader::new("t.csv", other.as_bytes()).unwrap_err().to_string(),
        "t.csv line 1, column \"time_us\": a time in us, and the row of units below says ms; correct one of them"
    );
}

#[test]
fn a_head_is_found_behind_many_lines_and_each_is_looked_at_once() {
    // As many lines as may stand before a header, of the kind that may be one.
    let mut table = "out of order,a,b\nIN,OUT\n".repeat(100);
    table += "Time,IN\n(ms),()\n0,000003E8\n";
    let mut reader = Reader::new("t.csv", table.as_bytes()).unwrap();
    let row = reader.next().unwrap().unwrap();
    assert_eq!((row.line, row.time_ns), (203, 0));
    let long = format!("{}\n", "IN,".repeat(300)).repeat(300);
    let refused = Reader::new("t.csv", long.as_bytes()).unwrap_err().to_string();
    assert_eq!(
        refused,
        "t.csv line 203: no header with in, out or value in the first 200 lines; delete those before it"
    );
}

#[test]
fn a_row_beside_which_a_fault_stands_is_a_bad_cycle() {
    let layout = TableLayout { faults: Some("fault".to_owned()), ..layout("value=position", "") };
    let read = rows(b"position,fault\n1,\n2,parity\n3, \n", &layout).unwrap();
    let seen: Vec<_> = read.iter().map(|row| (row.value, row.cycle)).collect();
    assert_eq!(seen, [(Some(1), None), (Some(2), Some(CycleSeen::Bad)), (Some(3), None)]);
}
