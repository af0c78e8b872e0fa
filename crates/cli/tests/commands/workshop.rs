//! Backups, and what becomes of them.

use std::fs;
use std::path::Path;

use super::{Run, encoring_in};

/// Every model at rest; a CE-100-M and a CE-65-M at 5000 steps of the shaft.
const RING: &str = "version = 1\n\
    [[device]]\nposition = 0\nmodel = \"la-66\"\nmotion = { kind = \"hold\", raw = 250_000 }\n\
    [[device]]\nposition = 1\nmodel = \"ce-100-m\"\nmotion = { kind = \"hold\", raw = 5_000 }\n\
    [[device]]\nposition = 2\nmodel = \"ce-65-m\"\nmotion = { kind = \"hold\", raw = 5_000 }\n";

/// A text, and the same on one line: sentences are broken for a terminal.
fn with_long_lines(text: &str) -> String {
    format!("{text}\n{}", text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The arguments of a command; words in quotes are one.
fn quoted(command: &str) -> Vec<String> {
    let mut arguments = Vec::new();
    for (k, part) in command.split('\'').enumerate() {
        match k % 2 {
            0 => arguments.extend(part.split_whitespace().map(str::to_owned)),
            _ => arguments.push(part.to_owned()),
        }
    }
    arguments
}

/// A folder with a ring that remembers.
pub(super) struct Bench(tempfile::TempDir);

impl Bench {
    pub(super) fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("ring.toml"), RING).unwrap();
        Self(folder)
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    /// Runs a command on the ring.
    pub(super) fn run(&self, command: &str) -> Run {
        self.answered(command, "")
    }

    /// Runs a command in its folder.
    pub(super) fn alone(&self, command: &str) -> Run {
        encoring_in(self.path(), &command.split(' ').collect::<Vec<_>>(), b"")
    }

    /// The same with words in quotes.
    fn answered_alone(&self, command: &str) -> Run {
        encoring_in(self.path(), &quoted(command), b"")
    }

    /// Runs a command that asks, with these answers through a pipe.
    fn answered(&self, command: &str, answers: &str) -> Run {
        let mut arguments = quoted(command);
        let ring = ["--bus", "sim:ring.toml", "--state", "memories", "--journal", "journal"];
        let journal = ["read", "write", "program", "restore", "replace"].contains(&arguments[0].as_str());
        arguments.extend(ring[..if journal { 6 } else { 4 }].iter().map(|word| (*word).to_owned()));
        encoring_in(self.path(), &arguments, answers.as_bytes())
    }

    /// Runs it, and gives its text if it ends with this code.
    fn out(&self, command: &str, code: i32) -> String {
        let Run { code: ended, out, err } = self.run(command);
        assert_eq!(ended, Some(code), "{command}\n{out}{err}");
        with_long_lines(&(out + &err))
    }

    fn file(&self, name: &str) -> String {
        fs::read_to_string(self.path().join(name)).unwrap()
    }
}

#[test]
fn a_backup_says_what_is_in_the_encoder_and_is_restored_to_a_new_one() {
    let bench = Bench::new();
    bench.out("program --at 2 --yes rotary --steps-per-turn 1000 --turns 10", 0);
    bench.out("backup axis.toml --at 2 --serial 4711 --firmware 41/1997 --mark 'stop left=0 mm'", 0);
    let text = bench.file("axis.toml");
    for line in [
        "model = \"ce-65-m\"",
        "native = 4096",
        "serial = \"4711\"",
        "firmware = \"41/1997\"",
        "position = 2",
        "unreadable = []",
        "name = \"stop left\"",
        "shown = 1220",
        "reference_mm = 0",
        "measuring_length = 9999    # service 02",
    ] {
        assert!(text.lines().any(|there| there == line), "{line}\n{text}");
    }
    assert!(bench.out("restore axis.toml --dry-run", 0).contains("everything is programmed already"));
    // A new unit.
    fs::remove_dir_all(bench.path().join("memories")).unwrap();
    let differs = bench.out("restore axis.toml --dry-run", 1);
    assert!(differs.contains("measuring_length    16777215      9999  16777215"), "{differs}");
    let done = bench.out("restore axis.toml --yes", 0);
    assert!(done.contains("done and verified: written, checked, read back"), "{done}");
    let way = "at \"stop left\" (0 mm): encoring preset 1220 --bus sim:ring.toml --at 2";
    assert!(done.contains(way), "{done}");
    assert!(done.contains("at other places it is equal or one step lower"), "{done}");
    bench.out("restore axis.toml --dry-run", 0);
    assert_eq!(fs::read_dir(bench.path().join("journal")).unwrap().count(), 0);
}

#[test]
fn marks_are_added_to_a_backup_as_long_as_the_encoder_holds_its_values() {
    let bench = Bench::new();
    bench.out("backup axis.toml --at 1", 0);
    let first = bench.file("axis.toml");
    bench.out("backup axis.toml --at 1", 0);
    assert_eq!(bench.file("axis.toml"), first);
    let refused = bench.out("backup axis.toml --at 1 --mark top", 2);
    assert!(refused.contains("it is there already and was left as it is; --update adds marks"), "{refused}");
    let nowhere = bench.out("backup no/folder.toml --at 1", 2);
    assert!(nowhere.contains("no/folder.toml: ") && !nowhere.contains("--update"), "{nowhere}");
    bench.out("backup axis.toml --update --mark top --mark 'zero=-12.5 deg' --label 'axis 3'", 0);
    let text = bench.file("axis.toml");
    assert!(text.contains("reference_deg = -12.5") && text.contains("label = \"axis 3\""), "{text}");
    bench.out("preset 7 --at 1 --yes", 0);
    let other = bench.out("backup axis.toml --update --mark top", 1);
    assert!(other.contains("\"top\" is in the file with 5000, and 7 is shown now"), "{other}");
    bench.out("write numerator 100 --at 1 --yes", 1);
    bench.out("write measuring-length 999 --at 1 --yes", 0);
    let differs = bench.out("backup axis.toml --update --mark more", 1);
    assert!(differs.contains("measuring_length: 16777215 in the file, 999 in the encoder"), "{differs}");
    assert_eq!(bench.file("axis.toml"), text);
    let nowhere = bench.out("backup axis.toml --update --at 2", 2);
    assert!(nowhere.contains("axis.toml: position 2 is not in the file"), "{nowhere}");
}

#[test]
fn a_ring_is_kept_in_one_file_from_which_each_encoder_can_be_restored() {
    let bench = Bench::new();
    bench.out("backup ring-backup.toml", 0);
    let which = bench.out("restore ring-backup.toml --yes", 2);
    assert!(which.contains("which one? --at POSITION tells; it holds the encoders at 0, 1, 2"), "{which}");
    let same = bench.out("restore ring-backup.toml --dry-run", 0);
    assert_eq!(same.lines().filter(|line| *line == "everything is programmed already").count(), 3, "{same}");
    bench.out("write measuring-length 999 --at 0 --yes", 0);
    let one = bench.out("restore ring-backup.toml --dry-run", 1);
    assert_eq!(one.lines().filter(|line| *line == "everything is programmed already").count(), 2, "{one}");
    let Run { code, out, err } = bench.run("restore ring-backup.toml --dry-run --format json");
    let view: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(code, Some(1), "{out}{err}");
    let positions: Vec<_> =
        view["encoders"].as_array().unwrap().iter().map(|one| one["position"].as_u64()).collect();
    assert_eq!((positions, &view["file"]), (vec![Some(0), Some(1), Some(2)], &"ring-backup.toml".into()));
    // One that is not there hides no other, and what is not known is no yes.
    let longer = bench.file("ring-backup.toml").replace("position = 2\n", "position = 7\n");
    fs::write(bench.path().join("longer.toml"), longer).unwrap();
    let longer = bench.out("restore longer.toml --dry-run", 1);
    assert!(longer.contains("position 7: not compared: --at 7: "), "{longer}");
    bench.out("restore ring-backup.toml --at 0 --yes", 0);
    bench.out("restore longer.toml --dry-run", 3);
    bench.out("write measuring-length 999 --at 0 --yes", 0);
    bench.out("restore ring-backup.toml --at 0 --dry-run", 1);
    bench.out("restore ring-backup.toml --at 0 --yes", 0);
    for at in 0..3 {
        bench.out(&format!("restore ring-backup.toml --at {at} --dry-run"), 0);
    }
    bench.out("backup again.toml --like ring-backup.toml", 0);
    let one = bench.out("backup third.toml --like ring-backup.toml --mark here", 2);
    assert!(one.contains("--mark is of one encoder, and 3 are meant"), "{one}");
}

#[test]
fn another_model_is_refused_unless_it_is_named_and_what_it_lacks_is_listed() {
    let bench = Bench::new();
    bench.out("backup axis.toml --at 2", 0);
    let other = bench.out("restore axis.toml --at 1 --yes", 1);
    assert!(other.contains("axis.toml is of a ce-65-m, the encoder at position 1 is a ce-100-m"), "{other}");
    assert!(
        other.contains("nothing was written. --as ce-100-m carries its values over, but not:"),
        "{other}"
    );
    let carried = bench.out("restore axis.toml --at 1 --as ce-100-m --yes", 0);
    assert!(carried.contains("not carried over: ssi_values = 24: a ce-100-m has no service 0D"), "{carried}");
    let rod = bench.out("restore axis.toml --at 0 --as la-66 --yes", 1);
    assert!(rod.contains("its values make no sense there; nothing was written"), "{rod}");
    let not_it = bench.out("restore axis.toml --at 2 --as ce-100-m --yes", 1);
    assert!(not_it.contains("--as ce-100-m: the encoder at position 2 is a ce-65-m"), "{not_it}");
    let typed = bench.out("restore axis.toml --at 2 --model ce-100-m --yes", 2);
    assert!(typed.contains("the model is that of the file, ce-65-m"), "{typed}");
    bench.out("restore axis.toml --at 2 --model ce-65-m --yes --no-backup", 0);
}

#[test]
fn files_that_are_no_backups_write_nothing() {
    let bench = Bench::new();
    bench.out("backup axis.toml --at 2", 0);
    let whole = bench.file("axis.toml");
    for (name, text, says) in [
        ("cut.toml", whole[..whole.len() / 2].to_owned(), "cut.toml"),
        ("foreign.toml", "[package]\nname = \"x\"\n".to_owned(), "foreign.toml line 1: unknown field"),
        ("later.toml", whole.replace("version = 1", "version = 2"), "this program reads version 1"),
        (
            "edited.toml",
            whole.replace("denominator = 1 ", "denominator = 0 "),
            "edited.toml line 20: denominator = 0; allowed are 1 to 99",
        ),
        ("empty.toml", String::new(), "missing field `version`"),
    ] {
        fs::write(bench.path().join(name), text).unwrap();
        let refused = bench.out(&format!("restore {name} --at 2 --yes"), 2);
        assert!(refused.contains(says), "{name}: {refused}");
    }
    bench.out("restore axis.toml --dry-run", 0);
    assert!(bench.out("restore missing.toml --at 2 --yes", 2).contains("missing.toml: "));
    // Legal one by one, and not together.
    let together = whole.replace("numerator = 4096 ", "numerator = 1 ");
    fs::write(bench.path().join("together.toml"), together).unwrap();
    let refused = bench.out("restore together.toml --yes", 1);
    assert!(refused.contains("the data check would refuse these values together"), "{refused}");
}

#[test]
fn a_restore_asks_and_guides_to_the_zero() {
    let way = "encoring preset 5000 --bus sim:ring.toml --at 2";
    // Without an answer nothing is written.
    let bench = replaced();
    let Run { code, out, err } = bench.answered("restore axis.toml", "");
    assert_eq!(code, Some(2), "{out}{err}");
    assert!(err.contains("measuring_length 16777215 -> 9999") && err.contains("pass --yes"), "{err}");
    let Run { code, err, .. } = bench.answered("restore axis.toml", "n\n");
    assert_eq!(code, Some(1), "{err}");
    bench.out("restore axis.toml --dry-run", 1);
    // Who answers no more has a unit that is programmed, and reads what is left to do.
    let Run { code, out, err } = bench.answered("restore axis.toml", "y\n");
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("The zero was not made: the input has ended.") && out.contains(way), "{out}{err}");
    let Run { code, out, err } = bench.answered("restore axis.toml", "y\n1\nn\n");
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("The zero was not made: the answer was no.") && out.contains(way), "{out}{err}");
    // Nothing differs any more, so a data check, the place and its preset are the questions.
    let Run { code, out, err } = bench.answered("restore axis.toml", "y\n1\ny\n");
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("zero at mark \"stop left\" (0 mm)"), "{out}{err}");
    assert!(out.contains("position now:    5000") && !out.contains(way), "{out}{err}");
    assert!(with_long_lines(&err).contains("note the mark where the position has just become"), "{err}");
}

#[test]
fn a_pending_error_is_no_consent_to_a_data_check() {
    let bench = replaced();
    bench.out("write numerator 100 --at 2 --yes", 1);
    let fault = "[[event]]\nat_s = 0\nposition = 2\nset = { eeprom = { fault = \"read\" } }\n";
    fs::write(bench.path().join("ring.toml"), format!("{RING}{fault}")).unwrap();
    for (command, answers) in [("restore axis.toml", "n\n"), ("replace --at 2", "1\naxis.toml\n\nn\n")] {
        let Run { code, out, err } = bench.answered(command, answers);
        assert_eq!(code, Some(1), "{command}: {out}{err}");
        assert!(with_long_lines(&err).contains("It comes first: an error is pending."), "{command}: {err}");
    }
}

/// An old unit with its backup, and a new one in its place.
fn replaced() -> Bench {
    let bench = Bench::new();
    bench.out("program --at 2 --yes rotary --steps-per-turn 1000 --turns 10", 0);
    bench.out("preset 5000 --at 2 --yes", 0);
    bench.out("backup axis.toml --at 2 --mark 'stop left=0 mm'", 0);
    fs::remove_dir_all(bench.path().join("memories")).unwrap();
    bench
}

#[test]
fn a_broken_encoder_is_replaced_by_options() {
    let bench = replaced();
    let differs = bench.out("replace --from axis.toml --yes --dry-run", 1);
    assert!(differs.contains("measuring_length    16777215      9999  16777215"), "{differs}");
    let done = bench.out("replace --from axis.toml --yes --set-at 'stop left'", 0);
    for line in [
        "02  measuring_length        9999  C200270F = W#16#C200 W#16#270F",
        "done and verified: written, checked, read back",
        "zero at mark \"stop left\" (0 mm)",
        "position now:    5000",
    ] {
        assert!(done.contains(line), "{line}\n{done}");
    }
    let compared = bench.out("replace --from axis.toml --yes --compare-at 'stop left'", 0);
    assert!(compared.contains("equal: the old unit showed the same here"), "{compared}");
    bench.out("preset 4000 --at 2 --yes", 0);
    let other = bench.out("replace --from axis.toml --yes --compare-at 'stop left'", 1);
    assert!(other.contains("-1000 against the old unit"), "{other}");
    let none = bench.out("replace --from axis.toml --yes --set-at nowhere", 2);
    assert!(none.contains("\"nowhere\" is no mark of the old unit; there are: \"stop left\""), "{none}");
    // A comparison leaves nothing undone.
    assert!(!compared.contains("left undone"), "{compared}");
}

#[test]
fn a_zero_that_the_values_do_not_allow_is_refused_before_anything_is_written() {
    let bench = replaced();
    let text = bench.file("axis.toml");
    for place in ["10000", "nowhere"] {
        let command = format!("replace --from axis.toml --yes --set-at {place}");
        assert_eq!(bench.run(&command).code, Some(2), "{command}");
    }
    let told = bench.out("replace --from axis.toml --yes --set-at 10000", 2);
    assert!(told.contains("10000 is above the measuring length 9999; nothing was written"), "{told}");
    fs::write(bench.path().join("axis.toml"), text.replace("shown = 5000", "shown = 21700")).unwrap();
    for command in [
        "replace --from axis.toml --yes --set-at 'stop left'",
        "restore axis.toml --yes",
        "restore axis.toml --dry-run",
    ] {
        let refused = bench.out(command, 2);
        assert!(refused.contains("shown = 21700, and measuring_length = 9999"), "{command}: {refused}");
    }
    let words = "--model ce-65-m --word C200270F --word C300000A --word C9000001 --word C6002710";
    let words =
        bench.out(&format!("replace {words} --at 2 --yes --set-at 'the place where 10000 is preset'"), 2);
    assert!(words.contains("is no mark of the old unit; there are: none"), "{words}");
    // The measuring length of the new unit counts if the file has none.
    let partial = "version = 1\nmodel = \"ce-65-m\"\n[parameters]\nssi_values = 25\n";
    fs::write(bench.path().join("partial.toml"), partial).unwrap();
    bench.out("program --at 2 --yes rotary --steps-per-turn 1000 --turns 5", 0);
    let partial = bench.out("replace --from partial.toml --at 2 --yes --set-at 5000", 2);
    assert!(partial.contains("5000 is above the measuring length 4999; nothing was written"), "{partial}");
    assert!(bench.out("read ssi-values --at 2", 0).contains("24"));
}

#[test]
fn the_length_of_a_rod_and_the_way_of_a_turn_are_not_taken_for_one_another() {
    let bench = Bench::new();
    let known = |more: &str| {
        format!("replace {more} --yes --known '0=0 mm' --known '5000=300 mm' --known '10000=600 mm'")
    };
    let run = |more: &str| {
        let Run { code, err, .. } = bench.answered_alone(&known(more));
        assert_eq!(code, Some(2), "{more}: {err}");
        with_long_lines(&err)
    };
    assert!(
        run("--model la-66 --mm-per-turn 5").contains("--mm-per-turn: a rod has no turns; give --length-mm")
    );
    assert!(
        run("--model ce-100-m --length-mm 500")
            .contains("--length-mm: a shaft has no length; give --mm-per-turn")
    );
    let far = run("--model la-66 --length-mm 500");
    assert!(far.contains("0 mm and 600 mm are farther apart than the rod is long"), "{far}");
    assert_ne!(bench.answered_alone(&known("--model la-66 --length-mm 600")).code, Some(2));
    for length in ["0.000001", "0.009", "167772.151"] {
        let refused = run(&format!("--model la-66 --length-mm {length}"));
        assert!(
            refused.contains("a rod has 0.01 mm to 167772.15 mm on its type label"),
            "{length}: {refused}"
        );
    }
}

#[test]
fn an_update_keeps_one_unit_in_a_file_and_its_marks_are_told() {
    let bench = Bench::new();
    bench.out("backup a.toml --at 2 --serial 111 --mark A", 0);
    let again = bench.out("backup a.toml --at 2", 0);
    assert!(again.contains("holds the same") && !again.contains("no mark is kept"), "{again}");
    let text = bench.file("a.toml");
    let other = bench.out("backup a.toml --update --serial 999", 1);
    assert!(other.contains("serial: 111 in the file, not 999"), "{other}");
    let model = bench.out("backup a.toml --update --at 2 --mark 'B=1 mm' --mark 'C=2 mm'", 2);
    assert!(model.contains("the machine cannot stand at 1 mm and at 2 mm"), "{model}");
    let ring = RING.replace("ce-65-m", "ce-100-m");
    fs::write(bench.path().join("ring.toml"), ring).unwrap();
    fs::remove_dir_all(bench.path().join("memories")).unwrap();
    let model = bench.out("backup a.toml --update --mark B", 1);
    assert!(model.contains("the encoder at position 2 is a ce-100-m; nothing was read"), "{model}");
    assert_eq!(bench.file("a.toml"), text);
}

#[test]
fn a_broken_encoder_is_replaced_by_answers_through_a_pipe() {
    let bench = replaced();
    let mark = "[[mark]]\nname = \"same\"\nshown = 5010\n\n[parameters]";
    fs::write(bench.path().join("axis.toml"), bench.file("axis.toml").replace("[parameters]", mark)).unwrap();
    // A backup, its name, connected, yes, a position that there is not, the first mark, yes, the other mark to compare.
    let Run { code, out, err } = bench.answered("replace --at 2", "1\naxis.toml\n\ny\n=10000\n1\ny\n1\n");
    assert_eq!(code, Some(1), "{out}{err}");
    assert!(err.contains("10000 is above the measuring length 9999"), "{err}");
    assert!(out.contains("compared: mark \"same\": 5010, now 5000: "), "{out}{err}");
    assert_eq!(err.matches("[y/N]").count(), 2, "{err}");
    // Whoever says no has changed nothing.
    let bench = replaced();
    let Run { code, out, err } = bench.answered("replace --at 2", "1\naxis.toml\n\nn\n");
    assert_eq!(code, Some(1), "{out}{err}");
    assert!(
        out.contains("left undone: the values were not programmed or checked: the answer was no"),
        "{out}"
    );
    bench.out("restore axis.toml --dry-run", 1);
    // Wrong answers are asked again; the end of the input ends it.
    let Run { code, err, .. } = bench.answered("replace --at 2", "9\n1\nmissing.toml\n1\naxis.toml\n");
    assert_eq!(code, Some(3), "{err}");
    assert!(err.contains("\"9\": answer 1, 2, 3 or 4") && err.contains("missing.toml: "), "{err}");
    assert!(err.contains("the input has ended before all was answered"), "{err}");
}

#[test]
fn the_guide_takes_the_words_of_a_plc_program_and_a_place_that_its_position_names() {
    let bench = Bench::new();
    // A wrong model and a wrong word are asked for again, from the first question on.
    let wrong = "2\nce-64\nce-65-m\nC2\n\n";
    let words = "2\nce-65-m\nW#16#C200 W#16#270F\nC300000A\n16#C9000001\n\n";
    // Connected, yes, the machine stands where 4321 was, yes, no second place.
    let Run { code, out, err } =
        bench.answered("replace --at 2", &format!("{wrong}{words}\ny\n=4321\ny\n\n"));
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(err.contains("\"ce-64\": ") && err.contains("\"C2\": "), "{err}");
    assert!(out.contains("done and verified: written, checked, read back"), "{out}{err}");
    assert!(out.contains("position now:    4321"), "{out}");
    assert!(out.contains("left undone: no second place was compared"), "{out}");
    let read = bench.out("read all --at 2", 0);
    assert!(read.contains("02 measuring_length 9999") && read.contains("03 numerator 10"), "{read}");
}

#[test]
fn the_guide_takes_a_recording_and_so_do_foreign_tables_and_logs() {
    let bench = Bench::new();
    // A table of a spreadsheet: halves of words, `;`, a column that is none of ours.
    let rows =
        "Time [ms];in_high;in_low;Remark\n0;0000;0001;\n1;8200;270F;read\n2;0000;0001;\n3;8300;000A;read\n";
    fs::write(bench.path().join("plc.csv"), rows).unwrap();
    let by_header = bench.answered("replace --at 2", "3\nce-65-m\nplc.csv\n\ny\n=100\ny\n=101\n");
    let Run { code, out, err } = by_header;
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(err.contains("note: plc.csv: `;` separates the cells"), "{err}");
    assert!(with_long_lines(&out).contains("known measuring_length = 9999: plc.csv line 3"), "{out}");
    assert!(out.contains("compared: mark \"position 101\": 101, now 100: -1"), "{out}");
    // By names that only a person can tell, and in decimal.
    let rows = "Zeit,ID 256\n0,1\n1,2181048079\n2,1\n3,2197815306\n";
    fs::write(bench.path().join("decimal.csv"), rows).unwrap();
    let options = "--model ce-65-m --yes --recording decimal.csv --columns 'time_ms=Zeit,in=ID 256'";
    let told = bench.out(&format!("replace {options} --decimal --at 2 --dry-run"), 0);
    assert!(told.contains("measuring_length = 9999: decimal.csv line 3"), "{told}");
    assert!(bench.out(&format!("replace {options} --at 2 --dry-run"), 2).contains("decimal.csv line 2"));
    let log = "# encoring-log 2\ntime,position,out,in,verdict\n";
    let row = |second: u32, input: &str| format!("2026-11-27T10:00:0{second}.000Z,2,,{input},valid\n");
    let log = format!("{log}{}{}", row(1, "0x8200270F"), row(2, "0x8300000A"));
    fs::write(bench.path().join("log.csv"), log).unwrap();
    let told = bench.out("replace --model ce-65-m --yes --recording log.csv --at 2 --dry-run", 0);
    assert!(told.contains("numerator = 10: log.csv line 4"), "{told}");
    // Who only noted what was written has not seen what was taken.
    fs::write(bench.path().join("out.csv"), "time_ms,out\n0,C200270F\n1,4200270F\n").unwrap();
    let none = bench.alone("replace --model ce-65-m --yes --recording out.csv");
    assert_eq!(none.code, Some(3), "{}", none.err);
    assert!(with_long_lines(&none.out).contains("no row of out.csv has an IN word"), "{}", none.out);
}

#[test]
fn the_guide_takes_known_positions_in_millimetres_and_in_degrees() {
    let bench = Bench::new();
    let mm = "4\nce-100-m\n0=0 mm\n5000=25 mm\n9000=45 mm\n\n5\n";
    // Connected, yes, the second place, yes, the first place to compare, although the machine has not moved there.
    let Run { code, out, err } =
        bench.answered("replace --at 1 --within '0.01 mm'", &format!("{mm}\ny\n2\ny\n1\n"));
    assert_eq!(code, Some(1), "{out}{err}");
    assert!(err.contains("How far does the machine move in one turn of the encoder's shaft"), "{err}");
    assert!(out.contains("position now:    5000"), "{out}");
    let other = "0.00 mm): 0, now 5000: +5000 against the old unit";
    assert!(with_long_lines(&out).contains(other), "{out}");
    let degrees = "4\nce-100-m\n0=0 deg\n250=90 deg\n750=270 deg\n\n";
    let Run { code, out, err } = bench.answered("replace --at 1 --no-wrap", &format!("{degrees}\ny\n\n"));
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(!err.contains("in one turn of the encoder's shaft, in mm"), "{err}");
    assert!(out.contains("left undone: the zero was not made"), "{out}");
    let rod = "4\nla-66\n1000=10 mm\n20000=200 mm\n45000=450 mm\n\n500\n";
    let Run { code, out, err } = bench.answered("replace --at 0", &format!("{rod}\ny\n1\ny\n\n"));
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(err.contains("Length of the rod on the type label"), "{err}");
    assert!(out.contains("position now:    1000"), "{out}");
}

#[test]
fn what_the_old_unit_held_is_told_without_any_encoder() {
    let bench = Bench::new();
    let out = |command: &str, code: i32| {
        let arguments: Vec<_> = command.split('|').collect();
        let Run { code: ended, out, err } = encoring_in(bench.path(), &arguments, b"");
        assert_eq!(ended, Some(code), "{command}\n{out}{err}");
        with_long_lines(&(out + &err))
    };
    let words = "replace|--model|ce-100-m|--yes|--word|W#16#C200 W#16#270F|--word|C300000A|--word|16#C9000001|--word|C1000001";
    let told = out(&format!("{words}|--word|C4000000|--word|C5000000|--save|found.toml"), 0);
    assert!(told.contains("known measuring_length = 9999: word W#16#C200 W#16#270F"), "{told}");
    assert!(
        bench.file("found.toml").contains("counting_direction = { direction = \"falling\" }"),
        "{}",
        bench.file("found.toml")
    );
    let missing = out(words, 3);
    assert!(missing.contains("preset_value_1: in no word, so it stays as the new unit has it"), "{missing}");
    let both = out(&format!("{words}|--word|C300000B"), 3);
    assert!(both.contains("numerator: the words contradict each other: 10 (word C300000A), 11"), "{both}");
    let known =
        "replace|--model|ce-100-m|--yes|--mm-per-turn|5|--within|0.01 mm|--known|0=0 mm|--known|5000=25 mm";
    let open = out(known, 3);
    assert!(open.contains("leave open whether the position begins again at 0 between them"), "{open}");
    let known = out(&format!("{known}|--known|9000=45 mm"), 3);
    assert!(known.contains("1000 steps per turn: the only round number that fits"), "{known}");
    assert!(
        known.contains("the range, positions 0 to 4095999 over 4096 turns: positions never tell it"),
        "{known}"
    );
    let rod = "replace|--model|la-66|--yes|--length-mm|500|--known|1000=10 mm|--known|20000=200 mm|--known|45000=450 mm";
    assert!(out(rod, 3).contains("50000 steps over the rod"), "{}", out(rod, 3));
    let bad = out("replace|--model|la-66|--yes|--word|C2", 2);
    assert!(bad.contains("\"C2\""), "{bad}");
}

#[test]
fn a_recording_tells_what_was_programmed_and_read() {
    let bench = Bench::new();
    let rows = "time_us,out,in\n0,4200270F,00000001\n1000,C200270F,C200270F\n2000,4200270F,00000001\n\
                3000,83000000,8300000A\n4000,03000000,00000001\n5000,C9000000,E9000000\n6000,00000000,20000001\n\
                7000,C2000FFF,C2000FFF\n";
    fs::write(bench.path().join("old.csv"), rows).unwrap();
    let told = encoring_in(
        bench.path(),
        &["replace", "--model", "ce-65-m", "--yes", "--recording", "old.csv", "--format", "json"],
        b"",
    );
    assert_eq!(told.code, Some(3), "{}", told.err);
    let view: serde_json::Value = serde_json::from_str(&told.out).unwrap();
    let values = view["old"]["values"].as_array().unwrap();
    let values: Vec<_> =
        values.iter().map(|value| (value["service"].as_str(), value["value"].as_u64())).collect();
    // What was refused does not count, and of two writes the later one does.
    assert_eq!(values, [(Some("02"), Some(4095)), (Some("03"), Some(10))]);
}

#[test]
fn what_could_not_be_read_is_in_the_backup_by_name_and_is_no_success() {
    let bench = Bench::new();
    let fault = "[[event]]\nat_s = 0\nposition = 2\nset = { eeprom = { fault = \"read\" } }\n";
    fs::write(bench.path().join("ring.toml"), format!("{RING}{fault}")).unwrap();
    let told = bench.out("backup axis.toml --at 2", 3);
    assert!(told.contains("02       measuring_length           ?"), "{told}");
    let text = bench.file("axis.toml");
    let names = "unreadable = [\"counting_direction\", \"measuring_length\", \"numerator\", \"denominator\", \"ssi_values\"]";
    assert!(text.contains(names), "{text}");
    assert!(bench.out("restore axis.toml --yes", 2).contains("nothing to restore"));
    // The others of the ring are kept all the same, and the exit code says that something is missing.
    bench.out("backup all.toml", 3);
    assert_eq!(bench.file("all.toml").matches("[[encoder]]").count(), 3);
}

#[test]
fn a_limit_is_told_with_what_it_comes_from_in_the_base_that_was_typed() {
    let bench = Bench::new();
    bench.out("write 02 3499 --at 1 --yes", 0);
    for (typed, told) in [
        ("write preset-value-1 4000 --at 1 --yes", "preset_value_1 4000 is above the measuring length 3499"),
        (
            "write preset-value-2 0FA0h --at 1 --dry-run",
            "preset_value_2 FA0h is above the measuring length DABh",
        ),
    ] {
        let out = bench.out(typed, 1);
        assert!(out.lines().any(|line| line == told), "{out}");
        assert!(out.contains("remedy: program preset"), "{out}");
    }
    bench.out("write 04 3000 --at 1 --yes", 0);
    // What stays is above a limit that becomes lower.
    let out = bench.out("write 02 2000 --at 1 --yes", 1);
    assert!(out.contains("preset_value_1 3000 is above the measuring length 2000"), "{out}");
    let out = bench.out("preset FA0h --at 1 --yes", 2);
    assert!(out.contains("error: preset adjustment: FA0h is above the measuring length DABh\n"), "{out}");
}

#[test]
fn a_restore_takes_no_parts_and_says_so() {
    let bench = Bench::new();
    let file =
        "version = 1\nmodel = \"ce-65-m\"\n[parameters]\nnumerator = 8192\nssi_values = { bits = 25 }\n";
    fs::write(bench.path().join("part.toml"), file).unwrap();
    let told = "error: part.toml: ssi_values names some of its parts alone, and a restore takes whole values; \
                `encoring program --file part.toml` takes parts\n";
    let refused = bench.out("restore part.toml --at 2 --yes", 2);
    assert!(refused.contains(told), "{refused}");
    let read = bench.out("program --file part.toml --at 2 --yes", 0);
    assert!(read.contains("25 bits, binary"), "{read}");
}

#[test]
fn a_guessed_scaling_is_told_and_ends_with_3_until_a_second_mark_was_compared() {
    let bench = Bench::new();
    let known = "replace --model ce-100-m --mm-per-turn 5 --known '0=0 mm' --known '5000=25 MM' --known '9000=45 mm' --at 1 --yes";
    let guessed = bench.answered(known, "");
    assert_eq!(guessed.code, Some(3), "{}", guessed.out);
    assert!(
        with_long_lines(&guessed.out)
            .contains("the scaling is one of several that fit, and was not compared")
    );
    // At 5000 steps of the shaft, on 1000 steps a turn.
    let shown = 5_000 * 1_000 / 4_096;
    let compared = known.replace("0=0 mm", &format!("{shown}=6.1 mm")) + " --compare-at 'place 6.1 mm'";
    let compared = bench.answered(&compared, "");
    assert_eq!(compared.code, Some(0), "{} {}", compared.out, compared.err);
    let exact = "replace --model ce-100-m --known '0=0.000 deg' --known '1000=360.0 deg' --known '100000=36000.0 deg' --at 1 --yes";
    assert_eq!(bench.answered(exact, "").code, Some(0));
}

#[test]
fn a_saved_file_that_was_cut_between_two_lines_is_refused() {
    let bench = Bench::new();
    let words =
        "replace --model ce-65-m --word C200270F --word C300000A --word C9000001 --yes --save found.toml";
    assert_eq!(bench.answered_alone(words).code, Some(3));
    let text = bench.file("found.toml");
    let (whole, _) = text.split_once("denominator").unwrap();
    fs::write(bench.path().join("cut.toml"), whole).unwrap();
    let refused = bench.alone("replace --from cut.toml --yes");
    assert_eq!(refused.code, Some(2), "{}", refused.out);
    assert!(
        with_long_lines(&refused.err).contains("values = 3, and 2 are in [parameters]: the file was cut off")
    );
    assert_eq!(bench.alone("replace --from found.toml --yes").code, Some(3));
}

#[test]
fn words_that_no_encoder_takes_together_are_not_programmed() {
    let bench = Bench::new();
    let run = |length: &str| {
        let Run { code, out, .. } = bench
            .alone(&format!("replace --model ce-65-m --word {length} --word C3000001 --word C9000001 --yes"));
        (code, with_long_lines(&out))
    };
    let (code, out) = run("C2003FFF");
    assert_eq!(code, Some(3));
    assert!(out.contains("16384 positions in 1/1 turns are more than any ce-65-m has"), "{out}");
    let (_, out) = run("C2001000");
    assert!(out.contains("so there are 4097: is 4095 meant, which makes 4096?"), "{out}");
    let (_, out) = run("C2000FFF");
    assert!(!out.contains("more than any") && !out.contains("is 4095 meant"), "{out}");
}

#[test]
fn an_update_keeps_the_comments_of_a_file() {
    let bench = Bench::new();
    bench.out("backup a.toml --at 2", 0);
    let text = bench.file("a.toml").replace("numerator", "# checked on site\nnumerator") + "# the end\n";
    fs::write(bench.path().join("a.toml"), &text).unwrap();
    bench.out("backup a.toml --update --at 2 --serial 7", 0);
    let updated = bench.file("a.toml");
    for comment in ["# checked on site\n", "# the end\n", "# IN showed "] {
        assert_eq!(updated.matches(comment).count(), 1, "{comment}: {updated}");
    }
    assert!(updated.contains("serial = \"7\"") && updated.contains("denominator = 1    # service 09"));
}
