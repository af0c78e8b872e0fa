#![allow(clippy::unwrap_used, clippy::indexing_slicing, reason = "tests")]

use std::io::{Cursor, Write};
use std::ops::ControlFlow;

use super::{Capture, CaptureEnd, CaptureFormat, CaptureTimes, CaptureWriter};

type Changes = Vec<(u64, u64, u64)>;

/// The names of the channels, every change of them, and the end; or what was refused.
fn read(file: &[u8]) -> Result<(Vec<String>, Changes, CaptureEnd), String> {
    let mut capture = Capture::new("a", Cursor::new(file), None).map_err(|error| error.to_string())?;
    let selected: Vec<usize> = (0..capture.channels().len()).collect();
    let mut changes = Vec::new();
    let end = capture.changes(&selected, |change| {
        changes.push((change.time_ns, change.high, change.known));
        ControlFlow::Continue(())
    });
    let end = end.map_err(|error| error.to_string())?;
    Ok((capture.channels().to_vec(), changes, end))
}

fn refused(file: &str, message: &str) {
    assert_eq!(read(file.as_bytes()).unwrap_err(), message, "{file}");
}

const HEAD: &str = "$timescale 10 ns $end $scope module a $end $var wire 1 ! clock $end $var wire 1 \" data $end\n\
                    $var reg 8 # word [7:0] $end $upscope $end $enddefinitions $end\n";

#[test]
fn a_value_change_dump_tells_its_single_bits() {
    let body = "#0 1! x\" b0 #\n$dumpvars 1\" $end #5 0!\n#7\n1!\nb101 #\n0\"\n$comment #1 1! $end #100\n";
    let (names, changes, end) = read((HEAD.to_owned() + body).as_bytes()).unwrap();
    assert_eq!(names, ["a.clock", "a.data"]);
    assert_eq!(changes, [(0, 0b11, 0b11), (50, 0b10, 0b11), (70, 0b01, 0b11)]);
    assert_eq!(end, CaptureEnd { time_ns: 1_000, cut_in_line: None });
}

#[test]
fn units_of_time_are_counted_exactly() {
    for (scale, time, ns) in
        [("1 fs", 1_999_999, 1), ("100 ps", 25, 2), ("1us", 3, 3_000), ("1 s", 2, 2_000_000_000)]
    {
        let file =
            format!("$timescale {scale} $end $var wire 1 ! c $end $enddefinitions $end #0 1! #{time} 0!\n");
        assert_eq!(read(file.as_bytes()).unwrap().1, [(0, 1, 1), (ns, 0, 1)], "{scale}");
    }
}

#[test]
fn a_name_that_scopes_make_long_is_refused() {
    let head = |scopes: usize| {
        let scope = format!("$scope module {} $end\n", "m".repeat(1_000));
        format!("$timescale 1 ns $end\n{}$var wire 1 ! c $end\n", scope.repeat(scopes))
    };
    assert!(read((head(4) + "$enddefinitions $end #0 1! #1 0!").as_bytes()).is_ok());
    refused(&head(5), "a line 7: a name of 5006 bytes with its scopes, at most 4096");
}

#[test]
fn what_is_wrong_with_a_dump_is_told_with_its_line() {
    let refused_body = |body: &str, message: &str| refused(&(HEAD.to_owned() + body), message);
    refused_body("#0 1!\n#9 0!\n#8 1!\n", "a line 5: time 8 is before 9, the time before it");
    refused_body("#0 1!\n2!\n#9\n", "a line 4: \"2!\" is neither a time nor a change");
    refused_body(
        "#99999999999999999999\n",
        "a line 3: \"#99999999999999999999\" is neither a time nor a change",
    );
    refused_body("#18446744073709551615\n", "a line 3: time 18446744073709551615 is too far away");
    refused_body("$comment\n\n", "a line 3: the file ends before the $end of what begins here: it was cut");
    for scale in ["3 ns", "1000 ns", "1 min", "ns", ""] {
        let file = format!(
            "$comment a\n$end\n$timescale {scale} $end $var wire 1 ! c $end $enddefinitions $end #0\n"
        );
        let words = scale.to_owned();
        let message =
            format!("a line 3: timescale {words:?}: it is 1, 10 or 100 and s, ms, us, ns, ps or fs");
        refused(&file, &message);
    }
    refused(
        "$var wire 1 ! c $end\n$enddefinitions $end #0 1!\n",
        "a line 2: no $timescale before it, so no time in the file means anything",
    );
    refused(
        "$timescale 1 ns $end\n$var wire 1 ! c $end",
        "a line 2: the file ends before $enddefinitions: it was cut",
    );
    refused("$timescale 1 ns $end\n$enddefinitions $end", "a: no channel: there is no line of a single bit");
}

#[test]
fn a_dump_that_breaks_off_is_read_up_to_there() {
    let whole = HEAD.to_owned() + "#0 1! 1\"\n#500 0!\n#1000 1!";
    assert_eq!(read(whole.as_bytes()).unwrap().2, CaptureEnd { time_ns: 10_000, cut_in_line: None });
    let cut = |file: &str| read(file.as_bytes()).unwrap().2;
    assert_eq!(
        cut(&(HEAD.to_owned() + "#0 1!\n#500 0!\n#6")),
        CaptureEnd { time_ns: 5_000, cut_in_line: Some(5) }
    );
    assert_eq!(
        cut(&(HEAD.to_owned() + "#0 1!\n#500 0")),
        CaptureEnd { time_ns: 5_000, cut_in_line: Some(4) }
    );
}

#[test]
fn a_table_of_changes_is_read_with_its_times() {
    let logic = "Time [s],Channel 0,Channel 1\n-0.000001000,1,1\n0.000000000,0,1\n1.5e-06,1,0\n";
    let mut capture = Capture::new("a", Cursor::new(logic.as_bytes()), None).unwrap();
    assert_eq!((capture.origin_ns(), capture.sample_ns()), (-1_000, None));
    assert_eq!(capture.channels(), ["Channel 0", "Channel 1"]);
    let mut times = Vec::new();
    let end = capture.changes(&[1], |change| {
        times.push((change.time_ns, change.high));
        ControlFlow::Continue(())
    });
    assert_eq!((times, end.unwrap().time_ns), (vec![(0, 1), (2_500, 0)], 2_500));
    let german = "Zeit;Time (ms);clock;data\n0;0,5;1;1\n0;0,75;0;1\n";
    let (names, changes, _) = read(german.replace("Zeit;", "extra;").as_bytes()).unwrap();
    assert_eq!(names, ["extra", "clock", "data"]);
    assert_eq!(changes, [(500_000, 0b110, 0b111), (750_000, 0b100, 0b111)]);
}

#[test]
fn a_table_of_samples_is_read_with_the_rate_in_its_comment() {
    let sigrok = "; CSV generated by libsigrok 0.5.2\n; Channels (2/2): clock, data\n; Samplerate: 24 MHz\nlogic,logic\n\
                  1,1\n0,1\n0,1\n1,0\n";
    let (names, changes, end) = read(sigrok.as_bytes()).unwrap();
    assert_eq!(names, ["clock", "data"]);
    assert_eq!(changes, [(0, 0b11, 0b11), (41, 0b10, 0b11), (125, 0b01, 0b11)]);
    assert_eq!(end, CaptureEnd { time_ns: 125, cut_in_line: None });
    let timed =
        "; Channels (2/2): clock, data\n; Samplerate: 1 MHz\nnanoseconds,logic,logic\n1000,1,1\n2000,0,1\n";
    assert_eq!(read(timed.as_bytes()).unwrap().1, [(1_000, 0b11, 0b11), (2_000, 0b10, 0b11)]);
    let bare = "1,1\n0,1\n";
    let told = Capture::new("a", Cursor::new(bare), Some(1_000_000)).unwrap();
    assert_eq!(
        (told.channels().to_vec(), told.sample_ns()),
        (vec!["1".to_owned(), "2".to_owned()], Some(1_000))
    );
}

#[test]
fn dates_in_a_table_count_from_its_first_row() {
    for (header, first, second, ns) in [
        (
            "Time [s],clock",
            "2026-11-28T10:00:00.000000001+00:00",
            "2026-11-28T11:00:01.5+01:00",
            1_499_999_999,
        ),
        ("Time,clock", "2026-11-28 23:59:59.999", "2026-11-29 00:00:00", 1_000_000),
        ("Timestamp;clock", "28.11.2026 10:00:00,5", "28.11.2026 10:00:00,500001", 1_000),
        ("t,clock", "-009998-01-02T00:00:00Z", "-009998-01-02T00:00:01Z", 1_000_000_000),
    ] {
        let separator = header.chars().find(|sign| ";,".contains(*sign)).unwrap();
        let text = format!("{header}\n{first}{separator}1\n{second}{separator}0\n");
        assert_eq!(read(text.as_bytes()).unwrap().1, [(0, 1, 1), (ns, 0, 1)], "{text}");
    }
    let table = |rows: &str| format!("Time [s],clock\n2026-11-28T10:00:00Z,1\n{rows}\n");
    refused(
        &table("2026-11-28T09:59:59Z,0"),
        "a line 3, column 1: 2026-11-28T09:59:59Z is before the time of the row before",
    );
    refused(&table("9999-12-30T00:00:00Z,0"), "a line 3, column 1: \"9999-12-30T00:00:00Z\" is too far away");
    refused(&table("0.001,0"), "a line 3, column 1: \"0.001\" is no time");
}

#[test]
fn a_capture_says_where_its_times_come_from() {
    let times = |text: &str, given| Capture::new("a", Cursor::new(text.to_owned()), given).unwrap().times();
    assert_eq!(times("Time [s],a\n0,1\n", Some(5)), CaptureTimes::Stamped);
    assert_eq!(times("; Samplerate: 1 MHz\na\n1\n", Some(5)), CaptureTimes::Sampled(1_000_000));
    assert_eq!(times("a\n1\n", Some(5)), CaptureTimes::SampledAsGiven(5));
    assert_eq!(times(HEAD, None), CaptureTimes::Stamped);
}

#[test]
fn what_is_wrong_with_a_table_is_told_with_its_line_and_column() {
    let no_time = "a line 1: neither a column of times as `Time [s]` nor a comment `; Samplerate: 1 MHz` before it, so no \
                   row has a time; --samplerate tells it";
    refused("clock,data\n1,1\n", no_time);
    refused(
        "Time,clock\n0,1\n",
        "a line 1: the column of times has no unit; call it Time [s], [ms], [us] or [ns]",
    );
    refused("Time [s],clock\n0,1\n1,2\n", "a line 3, column 2: \"2\" is neither 0 nor 1");
    refused("Time [s],clock\n0,1\nx,1\n", "a line 3, column 1: \"x\" is no time");
    refused("Time [s],clock\n1,1\n0,0\n", "a line 3, column 1: 0 is before the time of the row before");
    refused("Time [s],clock\n1,1\n2,0,0\n", "a line 3: 3 cells, the first row has 2");
    refused("; Samplerate: fast\nlogic\n1\n", "a line 1: samplerate \"fast\" is no rate");
    refused("Time [s]\n1\n", "a: no channel: there is no line of a single bit");
    refused("", "a: the file is empty");
    let cut = read(b"Time [s],clock,data\n0,1,1\n0.5,0,1\n0.75,1").unwrap().2;
    assert_eq!(cut, CaptureEnd { time_ns: 500_000_000, cut_in_line: Some(4) });
}

/// A capture of two lines that a fixed rule gives.
fn example() -> Vec<(u64, u8)> {
    let mut state = 1_u64;
    let mut time = 0;
    let mut changes = vec![(0, 3)];
    for _ in 0..5_000 {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        time += 100 + (state >> 50);
        changes.push((time, (state >> 40) as u8 & 3));
    }
    changes.dedup_by_key(|(_, shown)| *shown);
    changes
}

fn written(format: CaptureFormat, samplerate: Option<u64>, changes: &[(u64, u8)], end: u64) -> Vec<u8> {
    let sink = Cursor::new(Vec::new());
    let first = changes[0].1;
    let mut writer = CaptureWriter::new(format, sink, &["clock", "data"], first, samplerate).unwrap();
    for (time, shown) in changes {
        writer.change(*time, *shown).unwrap();
    }
    writer.finish(end).unwrap().into_inner()
}

#[test]
fn what_was_written_is_read_again_whatever_the_format() {
    let changes = example();
    let end = changes.last().unwrap().0 + 12_345;
    let expected: Changes = changes.iter().map(|(time, shown)| (*time, u64::from(*shown), 3)).collect();
    for format in [CaptureFormat::Vcd, CaptureFormat::Csv] {
        let (names, read_again, last) = read(&written(format, None, &changes, end)).unwrap();
        assert!(names.iter().all(|name| name.ends_with("clock") || name.ends_with("data")), "{names:?}");
        assert_eq!(read_again, expected, "{format:?}");
        assert_eq!(last, CaptureEnd { time_ns: end, cut_in_line: None });
    }
    // With samples every 10 ns nothing is lost, and each time is that of the sample at or after it.
    let up = |time: u64| time.div_ceil(10) * 10;
    let sampled: Changes = expected.iter().map(|(time, high, known)| (up(*time), *high, *known)).collect();
    for format in [CaptureFormat::Vcd, CaptureFormat::Csv, CaptureFormat::Sigrok] {
        let (_, read_again, last) = read(&written(format, Some(100_000_000), &changes, end)).unwrap();
        assert_eq!(read_again, sampled, "{format:?}");
        assert_eq!(last, CaptureEnd { time_ns: up(end), cut_in_line: None }, "{format:?}");
    }
}

#[test]
fn a_session_of_several_parts_and_odd_rates_keeps_every_change() {
    let changes: Vec<(u64, u8)> =
        (0..40).map(|k| (k * 10_000_000 + u64::from(k > 0) * 7, (k % 4) as u8)).collect();
    let file = written(CaptureFormat::Sigrok, Some(24_000_000), &changes, 400_000_000);
    assert!(file.len() < 100_000, "{} bytes for 9.6 million samples", file.len());
    let (_, read_again, last) = read(&file).unwrap();
    let levels: Vec<u64> = read_again.iter().map(|(_, high, _)| *high).collect();
    assert_eq!(levels, changes.iter().map(|(_, shown)| u64::from(*shown)).collect::<Vec<_>>());
    for ((time, ..), (wanted, _)) in read_again.iter().zip(&changes) {
        assert!((*wanted..wanted + 42).contains(time), "{time} for {wanted}");
    }
    assert_eq!(last.time_ns, 400_000_000);
}

/// A session with these parts.
fn session(parts: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in parts {
        archive.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

#[test]
fn samples_of_several_bytes_and_names_of_channels_come_from_the_metadata() {
    let metadata = b"[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\ntotal probes=2\nsamplerate=1 MHz\n\
                     probe1=a\nprobe10=b\nunitsize=2\n";
    let samples: Vec<u8> =
        [0_u16, 1, 0x200, 0x201, 0x201].iter().flat_map(|word| word.to_le_bytes()).collect();
    let (names, changes, end) = read(&session(&[("metadata", metadata), ("logic-1", &samples)])).unwrap();
    assert_eq!(names, ["a", "b"]);
    assert_eq!(changes, [(0, 0, 3), (1_000, 1, 3), (2_000, 2, 3), (3_000, 3, 3)]);
    assert_eq!(end.time_ns, 4_000);
}

#[test]
fn what_is_wrong_with_a_session_is_told_with_its_part() {
    let metadata = |more: &str| format!("[device 1]\nprobe1=a\n{more}").into_bytes();
    let good = metadata("samplerate=1 MHz\nunitsize=1\ncapturefile=logic-1\n");
    let told = |parts: &[(&str, &[u8])]| read(&session(parts)).unwrap_err();
    let logic = ("logic-1", &[0_u8][..]);
    for (metadata, message) in [
        (
            metadata("unitsize=1\ncapturefile=logic-1\n"),
            "there is no samplerate, so no time in the file means anything",
        ),
        (metadata("samplerate=0\nunitsize=1\n"), "samplerate \"0\" is no rate"),
        (metadata("samplerate=1 MHz\ncapturefile=logic-1\n"), "there is no unitsize"),
        (metadata("samplerate=1 MHz\nunitsize=0\n"), "unitsize \"0\": 1 to 512 bytes"),
        (metadata("probe9=b\nsamplerate=1 MHz\nunitsize=1\n"), "probe9 \"b\" is beyond a sample of 1 bytes"),
        (b"[global]\n".to_vec(), "there is no [device 1]"),
    ] {
        assert_eq!(told(&[("metadata", &metadata), logic]), format!("a, in it metadata: {message}"));
    }
    assert_eq!(told(&[("metadata", &good)]), "a, in it logic-1: there are no samples");
    let gap = [("metadata", &good[..]), ("logic-1-1", &[0]), ("logic-1-3", &[0])];
    assert_eq!(told(&gap), "a, in it logic-1-2: this part of the samples is missing");
    let whole = session(&[("metadata", &good), logic]);
    let cut = read(&whole[..whole.len() - 30]).unwrap_err();
    assert!(cut.starts_with("a: no whole session of sigrok: the end of the archive is missing"), "{cut}");
    let two = String::from_utf8(good).unwrap().replace("unitsize=1", "unitsize=2");
    let odd = told(&[("metadata", two.as_bytes()), ("logic-1", &[0, 0, 0])]);
    assert_eq!(odd, "a, in it logic-1: the samples end within one of 2 bytes");
}

#[test]
fn every_piece_of_a_file_and_every_changed_byte_is_read_or_refused() {
    let changes = &example()[..20];
    for (format, samplerate) in
        [(CaptureFormat::Vcd, None), (CaptureFormat::Csv, None), (CaptureFormat::Sigrok, Some(10_000_000))]
    {
        let file = written(format, samplerate, changes, 400_000);
        for end in 0..file.len() {
            let _ = read(&file[..end]);
        }
        for place in 0..file.len() {
            for byte in [0, b' ', b'\n', b'#', b'9', 0xFF] {
                let mut changed = file.clone();
                changed[place] = byte;
                let _ = read(&changed);
            }
        }
    }
}

#[test]
fn a_table_may_begin_with_a_byte_order_mark() {
    let (names, changes, _) =
        read("\u{FEFF}Time[s], Clock, Data\n0.0, 1, 1\n0.001, 0, 1\n".as_bytes()).unwrap();
    assert_eq!(names, ["Clock", "Data"]);
    assert_eq!(changes.len(), 2);
}

#[test]
fn a_wire_that_a_simulator_names_in_two_scopes_is_one_line() {
    let head = "$timescale 1 ns $end $scope module tb $end $var wire 1 ! clk $end $var wire 1 # data $end\n\
                $scope module dut $end $var wire 1 ! clk $end $upscope $end $upscope $end $enddefinitions $end\n";
    let (names, changes, _) = read(format!("{head}#0 1! 1#\n#5 0!\n").as_bytes()).unwrap();
    assert_eq!(names, ["tb.clk", "tb.data"]);
    assert_eq!(changes, [(0, 0b11, 0b11), (5, 0b10, 0b11)]);
}
