//! `encoring replace`: from a broken encoder to a new one that shows the same positions.

mod source;
mod view;

use std::path::PathBuf;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::Services;
use encoring_host::preset::{code, position};
use encoring_host::scaling::Ratio;
use encoring_workshop::reconstruct::positions::KnownPosition;
use encoring_workshop::{MachineMark, Reference};

use crate::arguments;
use crate::arguments::bus::{Source as SaidBy, Target};
use crate::arguments::range::{Wanted, number};
use crate::arguments::{TableArguments, TypeLabel};
use crate::bus::{Opened, simulated_ring};
use crate::calculation::Note;
use crate::dialog::{Dialog, Undone, steps};
use crate::output::{Answer, Failure, bad_input, note};
use crate::presetting::{Presetting, zero_place};
use crate::programming::How;
use crate::told::Failed;
use source::Source;
use view::{ComparisonView, ReplaceView};

/// Replace a broken encoder: find its values, program the new unit, make its zero, compare
///
/// It leads step by step and asks before each step; the answers come from the terminal or from a pipe. With --yes it asks
/// nothing, and the options say how far it goes. You can run it again: what is done already is not done twice. Without --bus
/// it only shows what is known of the old unit.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  done, and compared as far as asked
  1  refused, not confirmed, another model, or another position than before
  2  wrong input or wrong usage
  3  no answer, or a value that is needed is not known; with --yes also: guessed and not compared

Examples:
  encoring replace --bus modbus-tcp://192.168.1.10 --at 2
  encoring replace --from axis-3.toml --bus modbus-tcp://192.168.1.10 --at 2 --yes
  encoring replace --model ce-65-m --yes \\
    --word 'W#16#C200 W#16#270F' --word C300000A --word C9000001
  encoring replace --model ce-100-m --mm-per-turn 5 --yes \\
    --known '0=0 mm' --known '5000=25 mm' --known '9000=45 mm'")]
pub(crate) struct Arguments {
    /// Backup of the old unit
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["words", "recording", "known"])]
    from: Option<PathBuf>,
    /// Word of the PLC program for this encoder, written as for `decode` (repeatable)
    #[arg(long = "word", value_name = "WORD", allow_hyphen_values = true, conflicts_with_all = ["recording", "known"])]
    words: Vec<String>,
    /// Recording, log or table in which the old unit answered services
    #[arg(long, value_name = "FILE.csv", conflicts_with = "known")]
    recording: Option<PathBuf>,
    /// Position in steps that the old unit showed at a known place (repeatable)
    #[arg(long, value_name = "STEPS=NUMBER mm|deg", allow_hyphen_values = true)]
    known: Vec<KnownPosition>,
    /// For --known in mm on a shaft: travel of the machine in one turn, in mm
    #[arg(long, value_name = "MM", value_parser = number, allow_hyphen_values = true)]
    mm_per_turn: Option<Ratio>,
    /// For --known on a rod: its length on the type label, in mm
    #[arg(long, value_name = "MM", value_parser = number, conflicts_with = "mm_per_turn")]
    length_mm: Option<Ratio>,
    /// Uncertainty of the places of --known [default: half of the last digit of each]
    #[arg(long, value_name = "NUMBER mm|deg")]
    within: Option<Reference>,
    /// For --known: turns after which the position starts again at 0, 1 to 65535, if they are known
    #[arg(long, value_name = "TURNS", value_parser = arguments::whole::<u32>(1..=65_535))]
    turns: Option<u32>,
    /// For --known: the position does not start again at 0 between the places
    #[arg(long)]
    no_wrap: bool,
    /// Save what was found of the old unit to this file
    #[arg(long, value_name = "FILE.toml")]
    save: Option<PathBuf>,
    /// Make the zero here: the machine stands at this mark, or must show this position
    #[arg(long, value_name = "MARK|STEPS")]
    set_at: Option<String>,
    /// Compare here: the machine stands at this mark
    #[arg(long, value_name = "MARK", conflicts_with = "set_at")]
    compare_at: Option<String>,
    #[command(flatten)]
    how: How,
    #[command(flatten)]
    table: TableArguments,
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let how = &arguments.how;
    let dialog = Dialog::guiding(how.consent);
    let source = Source::of(arguments, &dialog)?;
    let places = Places::of(arguments, &source)?;
    let mut view = ReplaceView::new(&source);
    if let Some(path) = &arguments.save {
        source.save(path)?;
    }
    if !how.encoder.ring.place.is_given() || !source.can_be_programmed() {
        how.output.print(&view)?;
        return Ok(source.answer());
    }
    if !how.dry_run {
        dialog.tell(&view.source_text());
        dialog.pause(
            "Switch the machine off, mount and connect the new encoder at the same place, switch on.\nThe PLC must not write \
             the OUT word of this encoder meanwhile. Enter when that is done: ",
        )?;
    }
    let (mut opened, target) = open(arguments, &source)?;
    let replacing = Replacing { arguments, dialog: &dialog, source: &source, places, target };
    let told = match replacing.go(&mut opened, &mut view) {
        // What was programmed is reported, however it goes on.
        Err(failure) if view.has_programmed() => view.failed(failure),
        told => told,
    };
    if source.is_guess && dialog.is_silent() {
        view.guessed_unseen();
    }
    let told = told.map(|()| view);
    opened.report(how.output, told, |view| view.answer(how.dry_run))
}

/// Opens the ring on which the new unit is.
fn open(arguments: &Arguments, source: &Source) -> Result<(Opened, Target), Failure> {
    let mut how = arguments.how.clone();
    how.encoder.at = how.encoder.at.or(source.kept.position());
    let simulated = simulated_ring(how.encoder.ring.place.get()?)?.is_some();
    let native = how.encoder.label.native.or(source.kept.label.native);
    how.encoder.label =
        TypeLabel { model: (!simulated).then_some(source.kept.model), native: native.filter(|_| !simulated) };
    let (opened, target) = how.open("replace")?;
    if target.model != source.kept.model {
        return Err(Failure::Refused(format!(
            "the old unit is a {}, the encoder at position {} is a {}; nothing was written. `encoring restore --as` carries \
             the values of a backup over",
            source.kept.model, target.position, target.model
        )));
    }
    Ok((opened, target))
}

/// The places that options name, found before anything is done.
struct Places {
    zero: Option<MachineMark>,
    compare: Option<MachineMark>,
}

impl Places {
    fn of(arguments: &Arguments, source: &Source) -> Result<Self, Failure> {
        let zero = arguments.set_at.as_deref().map(|text| named_or_steps(source, text));
        let compare = arguments.compare_at.as_deref().map(|name| named(source, name));
        Ok(Self { zero: zero.transpose()?, compare: compare.transpose()? })
    }
}

/// The new unit, and what it is to become.
struct Replacing<'a> {
    arguments: &'a Arguments,
    dialog: &'a Dialog,
    source: &'a Source,
    places: Places,
    target: Target,
}

impl Replacing<'_> {
    fn go(&self, opened: &mut Opened, view: &mut ReplaceView) -> Result<(), Failure> {
        view.found(self.target);
        if !self.program(opened, view)? {
            return Ok(());
        }
        if let Some(mark) = &self.places.compare {
            return self.compare(opened, view, mark);
        }
        let Some(zero) = self.set_zero(opened, view)? else { return Ok(()) };
        if view.preset_answer() != Some(Answer::Yes) {
            return Ok(());
        }
        // The place of the zero shows it in any case.
        let others: Vec<_> = self.source.kept.marks.iter().filter(|mark| **mark != zero).cloned().collect();
        match self.dialog.place(
            "Move the machine to another mark and stop it there, to compare.",
            &others,
            self.source.kept.largest_position(),
        )? {
            Some(mark) if mark.shown != zero.shown => self.compare(opened, view, &mark),
            _ => {
                view.left("no second place was compared");
                Ok(())
            }
        }
    }

    /// Programs the values; `true` if the new unit holds them.
    fn program(&self, opened: &mut Opened, view: &mut ReplaceView) -> Result<bool, Failure> {
        let how = &self.arguments.how;
        let zero = self.places.zero.is_some() || self.places.compare.is_none() && !self.dialog.is_silent();
        let how = if zero { &how.before_zero(self.target.model) } else { how };
        let values = self.source.kept.values.iter().map(|(parameter, value)| (*parameter, (*value).into()));
        let wanted = Wanted {
            values: values.collect(),
            warnings: self.warnings(),
            zero: self.places.zero.as_ref().map(|mark| mark.shown),
        };
        let program = match how.work("replace", opened, self.target, &wanted, self.dialog) {
            Ok(program) => program,
            Err(Undone::Declined) => {
                view.left("the values were not programmed or checked: the answer was no");
                return Ok(false);
            }
            Err(undone) => return Err(undone.into()),
        };
        let in_order = program.is_in_order() && !how.dry_run;
        if !how.dry_run {
            self.dialog.tell(&program.to_string());
        }
        view.programmed(program);
        Ok(in_order)
    }

    /// What is not known.
    fn warnings(&self) -> Vec<Note> {
        match self.target.source {
            SaidBy::Ring => Vec::new(),
            SaidBy::User => vec![Note::warning(
                "model",
                format!("no word tells it: the type label of the new unit must say {}", self.target.model),
            )],
        }
    }

    /// Makes the zero at a mark; gives the mark if it was tried.
    fn set_zero(&self, opened: &mut Opened, view: &mut ReplaceView) -> Result<Option<MachineMark>, Failure> {
        let mark = match &self.places.zero {
            Some(mark) => Some(mark.clone()),
            None => zero_place(self.dialog, &self.source.kept, self.target)?,
        };
        let Some(mark) = mark else {
            view.left("the zero was not made: the positions are not those of the old unit yet");
            return Ok(None);
        };
        let presetting = Presetting { value: mark.shown.into(), mark: Some(&mark), dialog: self.dialog };
        match presetting.adjust(opened, self.target) {
            Ok(preset) => {
                self.dialog.tell(&preset.to_string());
                view.preset(&mark, preset);
                Ok(Some(mark))
            }
            Err(Undone::Declined) => {
                view.left("the zero was not made: the answer was no");
                Ok(None)
            }
            Err(undone) => Err(undone.into()),
        }
    }

    /// Compares the position at a further mark with what the old unit showed there.
    fn compare(
        &self,
        opened: &mut Opened,
        view: &mut ReplaceView,
        mark: &MachineMark,
    ) -> Result<(), Failure> {
        let model = self.target.model;
        let shown = opened.serve(self.target, |master| {
            let code = code(master, model)?;
            let word = master.look().map_err(|error: MasterError| Failed::Bus(error))?;
            Ok((word, position(word, code)))
        })?;
        let comparison = ComparisonView::new(mark, shown, self.source, self.target);
        self.dialog.tell(&comparison.to_string());
        view.compared(comparison);
        Ok(())
    }
}

fn named(source: &Source, name: &str) -> Result<MachineMark, Failure> {
    let kept = &source.kept;
    kept.mark(name).cloned().ok_or_else(|| {
        let names: Vec<_> = kept.marks.iter().map(|mark| format!("{:?}", mark.name)).collect();
        let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
        bad_input(format!("{name:?} is no mark of the old unit; there are: {names}"))
    })
}

fn named_or_steps(source: &Source, text: &str) -> Result<MachineMark, Failure> {
    match arguments::value(text) {
        Ok(shown) if source.kept.mark(text).is_none() => Ok(steps(shown)),
        _ => named(source, text),
    }
}

/// What a prompt could not be asked for.
fn missing(option: &str) -> Failure {
    note("note: --yes is given, so nothing is asked");
    bad_input(format!("{option} is missing"))
}
