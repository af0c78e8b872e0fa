#![allow(clippy::unwrap_used, clippy::indexing_slicing, clippy::panic, reason = "a test may panic")]

use std::collections::BTreeMap;
use std::io::Cursor;

use super::*;

const FORMATS: [Format; 2] = [Format::Vcd, Format::Fst];

fn two() -> (Signals, Id, Id) {
    let mut signals = Signals::new("top");
    signals.note("a note");
    signals.scope("first");
    let bit = signals.add("bit", 1, Value::Bits(1));
    signals.scope("second");
    let word = signals.add("word", 5, Value::Unknown);
    (signals, bit, word)
}

/// Writes these changes and ends at `end`.
fn written(format: Format, changes: &[(u64, Id, Value)], end: u64) -> Vec<u8> {
    let mut writer = WaveWriter::new(format, Cursor::new(Vec::new()), "tests", &two().0).unwrap();
    for (at, id, value) in changes {
        writer.change(*at, *id, *value).unwrap();
    }
    writer.finish(end).unwrap().into_inner()
}

/// What a foreign reader finds: each signal's changes, by its full name.
fn read(file: Vec<u8>) -> BTreeMap<String, Vec<(u64, String)>> {
    let mut wave = wellen::simple::read_from_reader(Cursor::new(file)).unwrap();
    let hierarchy = wave.hierarchy();
    let timescale = hierarchy.timescale().unwrap();
    assert_eq!((timescale.factor, timescale.unit.to_exponent()), (100, Some(-9)));
    let vars: Vec<_> = hierarchy
        .all_vars()
        .map(|var| (hierarchy[var].full_name(hierarchy), hierarchy[var].signal_ref()))
        .collect();
    let ids: Vec<_> = vars.iter().map(|(_, id)| *id).collect();
    wave.load_signals(&ids);
    let changes = |id| {
        let signal = wave.get_signal(id).unwrap();
        let at = |index| wave.time_table()[index as usize];
        signal.iter_changes().map(|(index, value)| (at(index), value.to_bit_string().unwrap())).collect()
    };
    vars.iter().map(|(name, id)| (name.clone(), changes(*id))).collect()
}

#[test]
fn a_value_change_dump_is_this_text() {
    let (_, bit, word) = two();
    let changes = [
        (0, bit, Value::Bits(0)),
        (7, word, Value::Bits(0b1_0110)),
        (7, bit, Value::Bits(1)),
        (9, word, Value::Unknown),
    ];
    assert_eq!(
        String::from_utf8(written(Format::Vcd, &changes, 12)).unwrap(),
        "$version tests $end\n$comment a note $end\n$timescale 100 ns $end\n$scope module top $end\n\
         $scope module first $end\n$var wire 1 ! bit $end\n$upscope $end\n\
         $scope module second $end\n$var wire 5 \" word [4:0] $end\n$upscope $end\n\
         $upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n0!\nbxxxxx \"\n$end\n#7\nb10110 \"\n1!\n#9\nbxxxxx \"\n#12\n"
    );
}

#[test]
fn levels_are_the_signals_of_one_bit_with_names_of_their_own() {
    let (_, bit, word) = two();
    let changes = [(7, word, Value::Bits(0b1_0110)), (8, bit, Value::Bits(0)), (9, word, Value::Unknown)];
    let text = String::from_utf8(written(Format::Levels, &changes, 12)).unwrap();
    assert!(text.contains("$scope module top $end\n$var wire 1 ! first_bit $end\n$upscope $end\n"), "{text}");
    assert!(text.ends_with("#0\n$dumpvars\n1!\n$end\n#7\n#8\n0!\n#9\n#12\n"), "{text}");
}

#[test]
fn both_formats_read_back_the_same_elsewhere() {
    let (_, bit, word) = two();
    let mut changes = Vec::new();
    // More than is held of an FST at a time, with steps of every size and the largest times.
    let mut at = 0;
    for k in 1..=100_000_u32 {
        at += u64::from(k % 50 * k % 1000 + 1);
        changes.extend([(at, word, Value::Bits(k)), (at, bit, Value::from(k % 3 == 0))]);
    }
    changes.push((1 << 50, word, Value::Unknown));
    let [vcd, fst] = FORMATS.map(|format| written(format, &changes, 0));
    assert!(fst.len() < vcd.len());
    let found = read(vcd);
    assert_eq!(found, read(fst));
    assert_eq!(found.keys().collect::<Vec<_>>(), ["top.first.bit", "top.second.word"]);
    let words = &found["top.second.word"];
    assert_eq!(words.len(), 100_002);
    assert_eq!(words[0], (0, "xxxxx".to_owned()));
    assert_eq!(words[100_001], (1 << 50, "xxxxx".to_owned()));
}

#[test]
fn a_waveform_in_which_nothing_happens_can_be_read() {
    for format in FORMATS {
        let found = read(written(format, &[], 500));
        assert_eq!(found["top.first.bit"], [(0, "1".to_owned())], "{format:?}");
    }
}

#[test]
fn what_a_signal_shows_already_is_not_written_again() {
    let (_, bit, word) = two();
    let changes = [(5, bit, Value::Bits(1)), (6, bit, Value::Bits(0b10)), (7, word, Value::Bits(0x7F))];
    for format in FORMATS {
        let found = read(written(format, &changes, 9));
        assert_eq!(found["top.first.bit"], [(0, "1".to_owned()), (6, "0".to_owned())]);
        assert_eq!(found["top.second.word"], [(0, "xxxxx".to_owned()), (7, "11111".to_owned())]);
    }
}

#[test]
fn every_one_of_many_signals_has_a_code_of_its_own() {
    let mut signals = Signals::new("top");
    let ids: Vec<Id> = (0..9_000).map(|k| signals.add(format!("s{k}"), 32, Value::Bits(k))).collect();
    for format in FORMATS {
        let mut writer = WaveWriter::new(format, Cursor::new(Vec::new()), "tests", &signals).unwrap();
        for (id, k) in ids.iter().zip(0..) {
            writer.change(1, *id, Value::Bits(!k)).unwrap();
        }
        let found = read(writer.finish(2).unwrap().into_inner());
        for k in 0..9_000_u32 {
            let shown = [(0, format!("{k:032b}")), (1, format!("{:032b}", !k))];
            assert_eq!(found[&format!("top.signals.s{k}")], shown);
        }
    }
}

#[test]
fn what_would_not_read_back_is_refused() {
    let refused = |signals: &Signals| {
        let begun = WaveWriter::new(Format::Vcd, Cursor::new(Vec::new()), "tests", signals);
        begun.err().map(|error| (error.kind(), error.to_string()))
    };
    for name in ["", "two words", "line\n", "\u{fc}"] {
        let mut signals = Signals::new("top");
        signals.add(name, 1, Value::Unknown);
        assert_eq!(refused(&signals).unwrap().0, io::ErrorKind::InvalidInput, "{name:?}");
        assert!(refused(&Signals::new(name)).is_some(), "{name:?}");
    }
    let mut signals = two().0;
    signals.note("the $end of it");
    assert_eq!(refused(&signals).unwrap().1, "\"the $end of it\" holds $end");

    let (signals, bit, _) = two();
    let mut writer = WaveWriter::new(Format::Fst, Cursor::new(Vec::new()), "tests", &signals).unwrap();
    writer.change(5, bit, Value::Bits(0)).unwrap();
    let message = writer.change(4, bit, Value::Bits(1)).unwrap_err().to_string();
    assert_eq!(message, "4 is before 5, the time of the previous change");
    assert_eq!(writer.change(6, Id(2), Value::Unknown).unwrap_err().to_string(), "there is no signal 2");
}

#[test]
fn the_ending_of_a_name_chooses_the_format() {
    for (name, format) in [
        ("ring.vcd", Some(Format::Levels)),
        ("a.b.FST", Some(Format::Fst)),
        ("ring.csv", None),
        ("vcd", None),
        ("ring.vcd.gz", None),
    ] {
        assert_eq!(Format::of(Path::new(name)), format, "{name}");
    }
}

/// A disk with so much room.
struct Disk {
    file: Cursor<Vec<u8>>,
    room: usize,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.file.position() as usize + bytes.len() > self.room {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[test]
fn a_full_disk_is_told_as_what_it_is() {
    let (signals, bit, _) = two();
    for format in FORMATS {
        let run = |room| {
            let disk = Disk { file: Cursor::new(Vec::new()), room };
            let mut writer = WaveWriter::new(format, disk, "tests", &signals)?;
            (1..1_000_u64).try_for_each(|at| writer.change(at, bit, Value::Bits(at as u32)))?;
            writer.finish(1_000)
        };
        let whole = run(usize::MAX).map(|disk| disk.file.into_inner().len()).unwrap();
        for room in (0..whole).step_by(11) {
            assert_eq!(run(room).err().map(|error| error.kind()), Some(io::ErrorKind::StorageFull));
        }
    }
}
