use std::io::{self, Read};

use proptest::prelude::*;

use crate::{CycleSeen, DeviceLine, Error, Input, Reader, Recording, Row, Writer};

const HEADER: &str = "time_us,out,raw,preset1_v,preset2_v,supply_v,magnet,in\n";
const RECORDING: &str = "# encoring-trace 1\n\
    # device 3 CE-65-M native=8192 firmware=41/1997 memory=00FF1A\n\
    # device 0 LA-66 memory=\n\
    time_us,position,out,raw,preset1_v,preset2_v,supply_v,magnet,in\n\
    0,0,00000000,0,0.0,0.0,24.0,1,00000000\n\
    0,3,C200270F,-4096,10.45,0.001,9.0,0,off\n\
    265.75,0,00000000,0,0.0,0.0,24.0,1,\n";

fn rows(file: impl AsRef<[u8]>) -> Result<Vec<Row>, Error> {
    Reader::new("trace.csv", file.as_ref())?.collect()
}

fn message(file: impl AsRef<[u8]>) -> String {
    rows(file).unwrap_err().to_string()
}

fn written(rows: &[Row]) -> io::Result<String> {
    let mut writer = Writer::new(Vec::new())?;
    rows.iter().try_for_each(|row| writer.write(row))?;
    Ok(String::from_utf8(writer.into_inner()).unwrap())
}

fn rewritten(file: &[u8]) -> Result<Vec<u8>, Error> {
    let mut reader = Reader::new("trace.csv", file)?;
    let mut writer = match reader.recording() {
        Some(recording) => Writer::recording(Vec::new(), &recording.devices).unwrap(),
        None => Writer::new(Vec::new()).unwrap(),
    };
    reader.try_for_each(|row| row.map(|row| writer.write(&row).unwrap()))?;
    Ok(writer.into_inner())
}

#[test]
fn the_golden_traces_are_written_as_they_are_read() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../vectors");
    let mut traces = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "csv") {
            let file = std::fs::read(&path).unwrap();
            assert!(rewritten(&file).unwrap() == file, "{}", path.display());
            traces += 1;
        }
    }
    assert!(traces >= 6);
}

#[test]
fn a_missing_column_has_its_default() {
    let default = Row { line: 2, ..Row::default() };
    assert_eq!((default.supply_mv, default.magnet, default.input), (24_000, true, None));
    let changed = [
        ("time_us\n2.5", Row { time_ns: 2500, ..default }),
        ("position\n127", Row { position: Some(127), ..default }),
        ("out\nc200270F", Row { out: Some(0xC200_270F), ..default }),
        ("raw\n-4611686018427387904", Row { raw: -1 << 62, ..default }),
        ("preset1_v\n10.45", Row { preset_mv: [10_450, 0], ..default }),
        ("preset2_v\n1000", Row { preset_mv: [0, 1_000_000], ..default }),
        ("supply_v\n9.00100", Row { supply_mv: 9001, ..default }),
        ("magnet\n0", Row { magnet: false, ..default }),
        ("in\noff", Row { input: Some(Input::Off), ..default }),
        ("in\n0000abcd", Row { input: Some(Input::Word(0xABCD)), ..default }),
        ("in\n\"\"", default),
    ];
    for (file, row) in changed {
        assert_eq!(rows(file).unwrap(), [row], "{file}");
    }
}

#[test]
fn a_log_of_both_versions_reads_as_a_trace() {
    let row = Row {
        line: 3,
        position: Some(2),
        time_ns: 1500,
        out: Some(0xC200_270F),
        input: Some(Input::Word(0x0000_270F)),
        value: Some(9999),
        ..Row::default()
    };
    let unseen = Row { line: 4, time_ns: 2000, out: None, input: None, value: None, ..row };
    let one = "# encoring-log 1 started today\ntime_us,position,out,in,verdict,value\n\
               1.5,2,C200270F,0000270F,valid,9999\n2,2,,,no_answer,\n";
    assert_eq!(rows(one).unwrap(), [row, unseen]);
    let two = "# encoring-log 2 started today\ntime_us,position,out,in,verdict,value,status,parameter\n\
               1.5,2,0xC200270F,0x0000270F,valid,9999,0x0040,7\n2,2,,,no_answer,,,\n";
    assert_eq!(rows(two).unwrap(), [Row { status: Some(0x40), parameter: Some(7), ..row }, unseen]);
    let seen = rows("in,line\n00000000,good\n00000000,BAD\n,silent\n,\n").unwrap();
    let seen: Vec<_> = seen.iter().map(|row| row.cycle).collect();
    assert_eq!(seen, [Some(CycleSeen::Good), Some(CycleSeen::Bad), Some(CycleSeen::Silent), None]);
}

#[test]
fn without_times_rows_are_1_ms_apart() {
    let times: Vec<_> = rows("raw\n1\n2\n\n3\n").unwrap().iter().map(|row| (row.line, row.time_ns)).collect();
    assert_eq!(times, [(2, 0), (3, 1_000_000), (5, 2_000_000)]);
}

#[test]
fn columns_come_in_any_order_and_lines_end_in_any_way() {
    let file = b"\xEF\xBB\xBF# note\r\n\r\nin,\"raw\",time_us\r\n \r\noff,1,7\r\n# note \xB5\n,\"-2\",7";
    let first = Row { line: 5, time_ns: 7000, raw: 1, input: Some(Input::Off), ..Row::default() };
    assert_eq!(rows(file).unwrap(), [first, Row { line: 7, raw: -2, input: None, ..first }]);
}

#[test]
fn the_last_row_of_a_log_without_its_line_end_is_left_out_and_told() {
    let log = "# encoring-log 2 started today\ntime_us,position,in,verdict,value\n0,0,0x00000001,valid,1\n\
               5,0,0x0000066B,valid,1643";
    for end in [log.len() - 3, log.len()] {
        let mut reader = Reader::new("log.csv", &log.as_bytes()[..end]).unwrap();
        let read: Vec<_> = reader.by_ref().map(Result::unwrap).collect();
        assert_eq!((read.len(), reader.piece()), (1, Some(4)), "{end}");
    }
    assert_eq!(rows(format!("{log}\n").as_bytes()).unwrap().len(), 2);
    // What does not read as a row is a half line.
    let half = rows(&log.as_bytes()[..log.len() - 15]).unwrap_err();
    assert!(half.is_half, "{half}");
    // A table of others may leave the line end out.
    assert_eq!(rows(log.replace("# encoring-log 2", "# a log").as_bytes()).unwrap().len(), 2);
}

#[test]
fn an_exponent_of_any_length_is_read_or_refused() {
    let read = |cell: &str| rows(format!("t [s];in\n0;00000000\n{cell};00000000\n").as_bytes());
    for (cell, time_ns) in [("5e-3", 5_000_000), ("5e+000", 5_000_000_000), ("5e-999", 0)] {
        assert_eq!(read(cell).unwrap()[1].time_ns, time_ns, "{cell}");
    }
    for cell in ["5e", "5e-", "5e999", "5e1000", "5e37860184273879", "5e-37860184273879"] {
        let refused = read(cell).unwrap_err().to_string();
        assert!(refused.contains(cell), "{refused}");
    }
}

#[test]
fn times_as_far_apart_as_numbers_go_are_refused() {
    let days = i128::MAX / 86_400_000_000_000;
    let (early, late) = ("-1.7e29".to_owned(), "1.7e29".to_owned());
    for (unit, first, second, problem) in [
        (" [s]", early.clone(), late.clone(), "too large a time"),
        (" [s]", late, early.clone(), "is 18446744073709551.615 us before the row before it"),
        (" [s]", "18e9".to_owned(), early, "is 18446744073709551.615 us before the row before it"),
        ("", "0 days 00:00:00".to_owned(), format!("{days} days 23:59:59"), "is not a span of time"),
    ] {
        let text = format!("time{unit};in\n{first};00000000\n{second};00000000\n");
        let refused = rows(text.as_bytes()).unwrap_err().to_string();
        assert!(refused.contains(problem), "{first} {second}: {refused}");
    }
}

#[test]
fn a_refused_file_says_where_and_why() {
    let columns = "time_us, position, out, raw, preset1_v, preset2_v, supply_v, magnet, in, verdict, value, \
                   line, status, parameter";
    let raw = "is not a whole number from -4611686018427387904 to 4611686018427387904";
    let volts = "is not a voltage from 0 to 1000 with at most three decimals";
    let time = "is not a time from 0 to 18446744073709551.615 with at most three decimals";
    let position = "is not a whole number from 0 to 127";
    let cases: [(&[u8], String); 32] = [
        (b"", format!("1: no header, the columns are {columns}")),
        (b"# note\n\n", format!("3: no header, the columns are {columns}")),
        (b"out,raw\n00000000\n", "2: 1 cell, the header has 2; a remark must begin with #".into()),
        (b"out\n#\n00000000,0\n", "3: 2 cells, the header has 1".into()),
        (b"raw\n1e9\n", format!("2, column raw: \"1e9\" {raw}")),
        (b"raw\n1\xFF\n", format!("2, column raw: \"1\u{FF}\" {raw}")),
        (b"raw\n-\n", format!("2, column raw: \"-\" {raw}")),
        (b"raw\n+1\n", format!("2, column raw: \"+1\" {raw}")),
        (b"raw\n4611686018427387905\n", format!("2, column raw: \"4611686018427387905\" {raw}")),
        (b"raw\n99999999999999999999\n", format!("2, column raw: \"99999999999999999999\" {raw}")),
        (b"out\nC20027\n", "2, column out: C20027: a word has 8 digits; zeros may be lost. Write 00C20027 or 0xC20027".into()),
        (b"out\n+C200270\n", "2, column out: +C200270: not a word; a word is eight hexadecimal digits, as C200270F, 0xC200270F or \
             DW#16#C200270F, two halves as C200 \
             270F, four bytes as C2 00 27 0F, or signed as -1040177393".into()),
        (b"magnet\n2\n", "2, column magnet: \"2\" is not 0 or 1".into()),
        (b"magnet\n\"\n", "2, column magnet: \"\\\"\" is not 0 or 1".into()),
        (b"position\n128\n", format!("2, column position: \"128\" {position}")),
        (b"supply_v\n24.0005\n", format!("2, column supply_v: \"24.0005\" {volts}")),
        (b"supply_v\n24.\n", format!("2, column supply_v: \"24.\" {volts}")),
        (b"supply_v\n.0\n", format!("2, column supply_v: \".0\" {volts}")),
        (b"supply_v\n1.0.0\n", format!("2, column supply_v: \"1.0.0\" {volts}")),
        (b"preset1_v\n-0.1\n", format!("2, column preset1_v: \"-0.1\" {volts}")),
        (b"preset2_v\n1000.001\n", format!("2, column preset2_v: \"1000.001\" {volts}")),
        (b"time_us\n1e3\n", format!("2, column time_us: \"1e3\" {time}")),
        (b"time_us\n18446744073709551.616\n", format!("2, column time_us: \"18446744073709551.616\" {time}")),
        (
            b"time_us\n10.5\n10.25\n",
            "3, column time_us: 10.25 is before 10.5, the time of the previous row".into(),
        ),
        (
            b"magnet\n0123456789012345678901234567890123456789+\n",
            "2, column magnet: \"0123456789012345678901234567890123456789...\" is not 0 or 1".into(),
        ),
        (b"# encoring-trace 1\nraw\n", "2: a recording needs the column position".into()),
        (b"# encoring-trace 1\ntime_us;in\n0;00000000\n", "2: a recording needs the column position".into()),
        (b"# encoring-trace 2\nraw\n", "1: version 2, this program reads 1".into()),
        (
            b"# encoring-trace 1\n# device 128 M memory=\n",
            "2: \"128\" is not the position of a device, 0 to 127".into(),
        ),
        (
            b"# encoring-trace 1\n# device 7 M memory=\n# device 7 M memory=\n",
            "3: device 7 is there twice".into(),
        ),
        (b"# encoring-trace 1\n# device 7 M a=1 a=2 memory=\n", "2: setting a is there twice".into()),
        (
            b"# encoring-trace 1\n# device 7 M memory=0F1\n",
            "2: \"0F1\" is not a memory image, two hex digits a byte".into(),
        ),
    ];
    for (file, expected) in cases {
        assert_eq!(message(file), format!("trace.csv line {expected}"));
    }
}

#[test]
fn a_malformed_device_line_is_refused() {
    let settings: String = (0..65).map(|n| format!(" k{n}=v")).collect();
    for words in [
        "",
        " ",
        " +1 M memory=",
        " 1",
        " 1 memory=",
        " 1 M",
        " 1 M a=b",
        " 1 M a memory=",
        " 1 M =a memory=",
        " 1 M memory=0g",
        " 1 M memory=00 a=b",
        &format!(" 1 M{settings} memory="),
        " 1 M memory=\u{B5}\u{B5}",
    ] {
        let error = rows(format!("# encoring-trace 1\n# note\n# device{words}\nposition\n")).unwrap_err();
        assert_eq!((error.line, &error.column), (3, &None), "{words}: {error}");
    }
    for comment in ["# devices", "#device 1", "# Device"] {
        let file = format!("# encoring-trace 1\n{comment}\nposition\n");
        assert_eq!(Reader::new("", file.as_bytes()).unwrap().recording(), Some(&Recording::default()));
    }
}

#[test]
fn only_the_first_line_makes_a_recording() {
    for file in ["raw\n", "# note\n# encoring-trace 1\nraw\n", "# encoring-trace\n# device\nraw\n"] {
        assert_eq!(Reader::new("", file.as_bytes()).unwrap().recording(), None, "{file}");
    }
}

#[test]
fn a_recording_is_written_as_it_is_read() {
    let reader = Reader::new("trace.csv", RECORDING.as_bytes()).unwrap();
    let device = &reader.recording().unwrap().devices[0];
    assert_eq!((device.line, device.position, device.model.as_str()), (2, 3, "CE-65-M"));
    let settings =
        [("native", "8192"), ("firmware", "41/1997")].map(|(key, value)| (key.into(), value.into()));
    assert_eq!((device.settings.as_slice(), device.memory.as_slice()), (&settings[..], &[0, 0xFF, 0x1A][..]));
    assert_eq!(String::from_utf8(rewritten(RECORDING.as_bytes()).unwrap()).unwrap(), RECORDING);
}

#[test]
fn a_line_is_bounded() {
    let padded = |length: usize| format!("\u{FEFF}#{}\r\nraw\r\n", " ".repeat(length - 1));
    assert!(rows(padded(65536)).is_ok());
    assert_eq!(message(padded(65537)), "trace.csv line 1: longer than 65536 bytes");
    assert_eq!(message(padded(65538)), "trace.csv line 1: longer than 65536 bytes");
    assert_eq!(message(format!("raw\n{}", "1".repeat(70_000))), "trace.csv line 2: longer than 65536 bytes");

    let mut endless = Reader::new("trace.csv", "raw\n1\n".as_bytes().chain(io::repeat(b'1'))).unwrap();
    assert!(endless.next().unwrap().is_ok());
    assert!(endless.next().unwrap().is_err() && endless.next().is_none());

    let device = |bytes| DeviceLine {
        line: 2,
        position: 1,
        model: "M".into(),
        settings: vec![],
        memory: vec![0; bytes],
    };
    let longest = (64 * 1024 - "# device 1 M memory=".len()) / 2;
    let file = Writer::recording(Vec::new(), &[device(longest)]).unwrap().into_inner();
    assert_eq!(Reader::new("", file.as_slice()).unwrap().recording().unwrap().devices, [device(longest)]);
    assert!(Writer::recording(Vec::new(), &[device(longest + 1)]).is_err());
    let longer = String::from_utf8(file).unwrap().replace("memory=", "memory=00");
    assert_eq!(message(longer), "trace.csv line 2: longer than 65536 bytes");
}

#[test]
fn a_failing_source_is_named_and_ends_the_rows() {
    struct Failing;
    impl Read for Failing {
        fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
            Err(io::Error::other("unplugged"))
        }
    }
    let mut reader = Reader::new("trace.csv", "raw\n1\n".as_bytes().chain(Failing)).unwrap();
    assert_eq!(reader.next().unwrap().unwrap().raw, 1);
    assert_eq!(reader.next().unwrap().unwrap_err().to_string(), "trace.csv line 3: cannot read: unplugged");
    assert!(reader.next().is_none() && reader.next().is_none());
}

#[test]
fn what_would_not_read_back_is_not_written() {
    let row = Row::default();
    assert_eq!(written(&[row]).unwrap(), format!("{HEADER}0,,0,0.0,0.0,24.0,1,\n"));
    let refused = [
        (Row { raw: i64::MIN, ..row }, "column raw: -9223372036854775808 is not a whole number from"),
        (
            Row { preset_mv: [1_000_001, 0], ..row },
            "column preset1_v: 1000.001 is not a voltage from 0 to 1000",
        ),
        (Row { preset_mv: [0, u32::MAX], ..row }, "column preset2_v: 4294967.295 is not a voltage"),
        (Row { supply_mv: 2_000_000, ..row }, "column supply_v: 2000.0 is not a voltage"),
    ];
    for (row, expected) in refused {
        let error = written(&[row]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
        assert!(error.to_string().starts_with(expected), "{error}");
    }
    let error = written(&[Row { time_ns: 1500, ..row }, row]).unwrap_err();
    assert_eq!(error.to_string(), "0 is before 1.5, the time of the previous row");

    let mut writer = Writer::recording(Vec::new(), &[]).unwrap();
    assert!(writer.write(&row).is_err() && writer.write(&Row { position: Some(128), ..row }).is_err());
    writer.flush().unwrap();
    assert!(writer.into_inner().ends_with(b",in\n"));

    let device = DeviceLine { line: 0, position: 0, model: "M".into(), settings: vec![], memory: vec![] };
    let pair = |key: &str, value: &str| vec![(key.to_owned(), value.to_owned())];
    assert!(Writer::recording(Vec::new(), &[device.clone(), device.clone()]).is_err());
    for model in ["", "A B", "A=B", "A\n", "A\r"] {
        assert!(
            Writer::recording(Vec::new(), &[DeviceLine { model: model.into(), ..device.clone() }]).is_err()
        );
    }
    for settings in
        [pair("", "v"), pair("k", "v w=x"), pair("k=", "v"), pair("memory", "00"), pair("k", "v\n")]
    {
        assert!(Writer::recording(Vec::new(), &[DeviceLine { settings, ..device.clone() }]).is_err());
    }
}

#[test]
fn any_damage_to_a_file_is_read_or_refused() {
    let judge = |file: &[u8]| match rewritten(file) {
        Ok(again) => assert_eq!(rewritten(&again).unwrap(), again),
        Err(error) => assert!(error.line >= 1 && error.to_string().starts_with("trace.csv line ")),
    };
    let file = RECORDING.as_bytes();
    for index in 0..file.len() {
        judge(&file[..index]);
        judge(&file[index..]);
        let mut changed = file.to_vec();
        // What means something in a table; the fuzz target takes every byte.
        for byte in *b"\0\t\n\r \"#,-.07;=Aft\x80\xFF" {
            changed[index] = byte;
            judge(&changed);
        }
    }
}

#[test]
fn other_programs_read_and_write_the_same_rows() {
    let file = std::fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vectors/la-66.csv")).unwrap();
    let mut quoted = csv::WriterBuilder::new().quote_style(csv::QuoteStyle::Always).from_writer(Vec::new());
    let mut foreign = csv::ReaderBuilder::new().has_headers(false).from_reader(file.as_slice());
    for record in foreign.byte_records() {
        quoted.write_byte_record(&record.unwrap()).unwrap();
    }
    assert_eq!(rows(quoted.into_inner().unwrap()).unwrap(), rows(file).unwrap());
}

prop_compose! {
    fn any_row()(
        time_ns in 0u64..1 << 40,
        out: u32,
        raw in -1i64 << 62..=1 << 62,
        preset_mv in [0u32..=1_000_000, 0u32..=1_000_000],
        supply_mv in 0u32..=1_000_000,
        magnet: bool,
        input in prop_oneof![
            Just(None),
            Just(Some(Input::Off)),
            any::<u32>().prop_map(|word| Some(Input::Word(word))),
        ],
    ) -> Row {
        Row { time_ns, out: Some(out), raw, preset_mv, supply_mv, magnet, input, ..Row::default() }
    }
}

proptest! {
    #[test]
    fn what_is_written_reads_back(mut many in prop::collection::vec(any_row(), 0..20)) {
        many.sort_by_key(|row| row.time_ns);
        for (row, line) in many.iter_mut().zip(2..) {
            row.line = line;
        }
        prop_assert_eq!(rows(written(&many).unwrap()).unwrap(), many);
    }

    #[test]
    fn any_bytes_are_read_or_refused(file: Vec<u8>) {
        let _ = rows(file);
    }
}
