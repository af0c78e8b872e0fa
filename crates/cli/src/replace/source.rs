//! What is known of the old unit.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use encoring_files::open;
use encoring_host::scaling::Ratio;
use encoring_trace::Input;
use encoring_words::model::{ROD_UM_MAX, ROD_UM_MIN, SensorKind};
use encoring_words::number::{Bare, word};
use encoring_words::{InWord, Model, Parameter};
use encoring_workshop::reconstruct::Reconstruction;
use encoring_workshop::reconstruct::positions::{KnownPosition, Line, MeasuredWay, WrapBetween};
use encoring_workshop::reconstruct::words::WordFindings;
use encoring_workshop::values::parameters_of;
use encoring_workshop::{KeptEncoder, MachineMark, ParameterFile, Reference, ReferenceUnit};

use super::{Arguments, missing};
use crate::arguments::tell_doubts;
use crate::dialog::Dialog;
use crate::output::{Answer, Failure, bad_input};

/// The largest recording that is looked through.
const RECORDING_BYTES_MAX: u64 = 1 << 36;

/// What is known of the old unit, and from where.
pub(super) struct Source {
    /// `backup`, `words`, `recording` or `positions`.
    pub(super) kind: &'static str,
    pub(super) kept: KeptEncoder,
    pub(super) known: Vec<String>,
    pub(super) assumed: Vec<String>,
    pub(super) unknown: Vec<String>,
    sound: bool,
    /// So many steps a position may be off; only of known positions.
    pub(super) off_at_most: u128,
    /// Other numbers of steps fit the known positions as well.
    pub(super) is_guess: bool,
}

impl Source {
    /// By the options, else by asking.
    pub(super) fn of(arguments: &Arguments, dialog: &Dialog) -> Result<Self, Failure> {
        if let Some(path) = &arguments.from {
            return Self::backup(arguments, path);
        }
        if !arguments.words.is_empty() {
            let model = model(arguments, dialog)?;
            return words(model, &arguments.words, arguments.table.bare()).map_err(bad_input);
        }
        if let Some(path) = &arguments.recording {
            return recording(arguments, model(arguments, dialog)?, path);
        }
        if !arguments.known.is_empty() {
            let model = model(arguments, dialog)?;
            return positions(arguments, model, &arguments.known, length(arguments, model)?);
        }
        if dialog.is_silent() {
            return Err(missing(
                "--from FILE.toml, --word WORD, --recording FILE.csv or --known STEPS=PLACE",
            ));
        }
        Self::asked(arguments, dialog)
    }

    fn asked(arguments: &Arguments, dialog: &Dialog) -> Result<Self, Failure> {
        loop {
            let answer = dialog.ask(
                "What is there of the old unit?\n  1  a backup file\n  2  words in the PLC program (C2.., C3.., C9..)\n  3  a \
                 recording in which it was read or programmed\n  4  positions that it showed at known places\nType the \
                 number: ",
            )?;
            let found = match answer.as_str() {
                "1" => Self::backup(arguments, Path::new(&dialog.ask("Name of the file: ")?)),
                "2" => {
                    let model = model(arguments, dialog)?;
                    let list =
                        lines(dialog, "The words, one a line in any spelling; an empty line ends them:")?;
                    words(model, &list, arguments.table.bare()).map_err(bad_input)
                }
                "3" => {
                    let model = model(arguments, dialog)?;
                    recording(arguments, model, &PathBuf::from(dialog.ask("Name of the file: ")?))
                }
                "4" => {
                    let model = model(arguments, dialog)?;
                    asked_positions(arguments, dialog, model)
                }
                _ => Err(bad_input(format!("{answer:?}: answer 1, 2, 3 or 4"))),
            };
            match found {
                Err(Failure::BadInput(why)) => dialog.tell(&why),
                found => return found,
            }
        }
    }

    fn backup(arguments: &Arguments, path: &Path) -> Result<Self, Failure> {
        let name = path.display();
        let file = ParameterFile::read(path).map_err(bad_input)?;
        let kept = file
            .at(arguments.how.encoder.at)
            .map_err(|problem| bad_input(format!("{name}: {problem}")))?
            .clone();
        if let Some(model) = arguments.how.encoder.label.model.filter(|model| *model != kept.model) {
            return Err(bad_input(format!(
                "--model {model}: {name} is of a {}; leave --model out, or name the backup of this encoder",
                kept.model
            )));
        }
        let taken = kept.taken.as_ref().map_or_else(
            || "a file without [taken]: no encoder was read for it".to_owned(),
            |taken| format!("read at {} over {}, position {}", taken.at, taken.bus, taken.position),
        );
        let unknown = parameters_of(kept.model).filter(|parameter| kept.value(*parameter).is_none());
        let unknown = unknown.map(|parameter| {
            format!("{}: not in the file, so it stays as the new unit has it", parameter.key())
        });
        Ok(Self {
            kind: "backup",
            known: vec![format!("{name}: {taken}")],
            assumed: Vec::new(),
            unknown: unknown.collect(),
            sound: true,
            off_at_most: 0,
            is_guess: false,
            kept,
        })
    }

    fn reconstructed(kind: &'static str, found: Reconstruction) -> Self {
        let Reconstruction { kept, known, assumed, unknown, sound, off_at_most, is_guess } = found;
        Self { kind, kept, known, assumed, unknown, sound, off_at_most, is_guess }
    }

    /// Whether there is something to program, and nothing contradicts.
    pub(super) fn can_be_programmed(&self) -> bool {
        self.sound && !self.kept.values.is_empty()
    }

    /// How `replace` ends where it only tells.
    pub(super) fn answer(&self) -> Answer {
        let whole = parameters_of(self.kept.model).all(|parameter| self.kept.value(parameter).is_some());
        if self.can_be_programmed() && whole && !self.is_guess { Answer::Yes } else { Answer::Unknown }
    }

    /// Keeps it in a file.
    pub(super) fn save(&self, path: &Path) -> Result<(), Failure> {
        let mut kept = self.kept.clone();
        kept.remarks.extend(self.assumed.iter().chain(&self.unknown).cloned());
        ParameterFile::from(kept).write_new(path).map_err(bad_input)
    }
}

fn model(arguments: &Arguments, dialog: &Dialog) -> Result<Model, Failure> {
    if let Some(model) = arguments.how.encoder.label.model {
        return Ok(model);
    }
    if dialog.is_silent() {
        return Err(missing("--model MODEL"));
    }
    loop {
        let answer = dialog.ask("Model on the type label of the old unit (la-66, ce-100-m or ce-65-m): ")?;
        match crate::arguments::model_name(&answer) {
            Ok(model) => return Ok(model),
            Err(wrong) => dialog.tell(&format!("{answer:?}: {wrong}")),
        }
    }
}

/// Lines up to an empty one.
fn lines(dialog: &Dialog, what: &str) -> Result<Vec<String>, Failure> {
    let mut lines = Vec::new();
    dialog.tell(&format!("\n{what}"));
    loop {
        match dialog.ask("> ")? {
            line if line.is_empty() => return Ok(lines),
            line => lines.push(line),
        }
    }
}

fn words(model: Model, list: &[String], bare: Bare) -> Result<Source, String> {
    let read = list.iter().map(|text| {
        let read = word([text.as_str()], bare).map_err(|wrong| format!("{text:?}: {wrong}"))?;
        Ok((read.bits, format!("word {text}")))
    });
    let read = read.collect::<Result<Vec<_>, String>>()?;
    let findings = WordFindings::noted(model, read);
    Ok(of_words("words", model, &findings))
}

fn of_words(kind: &'static str, model: Model, findings: &WordFindings) -> Source {
    let mut source = Source::reconstructed(kind, Reconstruction::from_words(model, findings));
    let largest = source.kept.largest_position();
    let (fit, beyond): (Vec<_>, Vec<_>) =
        findings.presets().into_iter().partition(|preset| preset.value <= largest);
    source.unknown.extend(beyond.into_iter().map(|preset| {
        format!(
            "the place where {} is preset ({}): it is above the measuring length {largest}, so the encoder refuses it",
            preset.value, preset.place
        )
    }));
    source.kept.marks = fit
        .into_iter()
        .map(|preset| MachineMark {
            name: format!("the place where {} is preset", preset.value),
            shown: preset.value,
            reference: None,
        })
        .collect();
    source
}

fn recording(arguments: &Arguments, model: Model, path: &Path) -> Result<Source, Failure> {
    let name = path.display().to_string();
    let at = arguments.how.encoder.at;
    let file = open(path, RECORDING_BYTES_MAX).map_err(|cause| bad_input(format!("{name}: {cause}")))?;
    let mut reader = arguments.table.reader(&name, file)?;
    let (mut several, mut failed, mut seen) = (None, None, false);
    let (mut of_it, mut positions) = (false, BTreeSet::new());
    let rows = reader.by_ref().map_while(|row| match row {
        Ok(row) => Some(row),
        Err(error) => {
            failed = Some(error);
            None
        }
    });
    let mut first = None;
    let rows = rows.filter_map(|row| {
        let here = row.position.map(usize::from);
        if at.is_none() && *first.get_or_insert(here) != here {
            several = here;
        }
        let word = match row.input {
            Some(Input::Word(word)) => Some(InWord(word)),
            _ => None,
        };
        seen |= word.is_some();
        let meant = at.is_none() || here.is_none() || here == at;
        of_it |= meant;
        positions.extend(here);
        meant.then(|| (word, format!("{name} line {}", row.line)))
    });
    let findings = WordFindings::recorded(model, rows);
    if let Some(error) = failed {
        return Err(bad_input(error));
    }
    if several.is_some() {
        return Err(bad_input(format!("{name} is of several encoders; --at POSITION tells which")));
    }
    if let Some(at) = at.filter(|_| !of_it && !positions.is_empty()) {
        let positions: Vec<_> = positions.iter().map(ToString::to_string).collect();
        return Err(bad_input(format!(
            "position {at} is not in {name}; it has the positions {}",
            positions.join(", ")
        )));
    }
    tell_doubts(&reader, &name);
    let mut source = of_words("recording", model, &findings);
    if !seen {
        source.unknown.push(format!(
            "what the encoder took: no row of {name} has an IN word. What the PLC wrote can be given as words: --word"
        ));
    }
    Ok(source)
}

fn asked_positions(arguments: &Arguments, dialog: &Dialog, model: Model) -> Result<Source, Failure> {
    let list = lines(
        dialog,
        "Positions and places, one a line, as \"1000=12.5 mm\" or \"1000=90 deg\" (degrees of the shaft);\nthree that are far \
         apart are best. An empty line ends them:",
    )?;
    let known = list.iter().map(|line| KnownPosition::from_str(line));
    let known = known.collect::<Result<Vec<_>, _>>().map_err(bad_input)?;
    let rod = model.sensor_kind() == SensorKind::Linear;
    let in_degrees = known.iter().all(|known| known.reference.scale == ReferenceUnit::Degrees);
    let length = match length(arguments, model)? {
        None if in_degrees && !rod => None,
        None if rod => Some(asked_ratio(dialog, "Length of the rod on the type label, in mm: ")?),
        None => Some(asked_ratio(
            dialog,
            "How far does the machine move in one turn of the encoder's shaft, in mm: ",
        )?),
        given => given,
    };
    positions(arguments, model, &known, length)
}

/// What a turn or the rod is in mm; the option of the one is none of the other.
fn length(arguments: &Arguments, model: Model) -> Result<Option<Ratio>, Failure> {
    let (own, other, told) = match model.sensor_kind() {
        SensorKind::Linear => (
            arguments.length_mm,
            arguments.mm_per_turn,
            "--mm-per-turn: a rod has no turns; give --length-mm",
        ),
        SensorKind::Rotary => (
            arguments.mm_per_turn,
            arguments.length_mm,
            "--length-mm: a shaft has no length; give --mm-per-turn",
        ),
    };
    match other {
        Some(_) => Err(bad_input(format!("{told} for a {model}"))),
        None => Ok(own),
    }
}

/// No two places of a rod are farther apart than it is long.
fn within_rod((numerator, denominator): (u128, u128), known: &[KnownPosition]) -> Result<(), Failure> {
    let place = |known: &&KnownPosition| known.reference.millionths;
    let (Some(first), Some(last)) = (known.iter().min_by_key(place), known.iter().max_by_key(place)) else {
        return Ok(());
    };
    let inexact = u64::from(first.reference.digit / 2) + u64::from(last.reference.digit / 2);
    let apart = place(&last).abs_diff(place(&first)).saturating_sub(inexact);
    if u128::from(apart).saturating_mul(denominator) > numerator.saturating_mul(1_000_000) {
        return Err(bad_input(format!(
            "--known: {} and {} are farther apart than the rod is long; correct them, or --length-mm",
            first.reference, last.reference
        )));
    }
    Ok(())
}

#[expect(clippy::disallowed_methods, reason = "a length with decimals, which `host::scaling` reads")]
fn asked_ratio(dialog: &Dialog, question: &str) -> Result<Ratio, Failure> {
    dialog.ask(question)?.parse().map_err(bad_input)
}

fn positions(
    arguments: &Arguments,
    model: Model,
    known: &[KnownPosition],
    length: Option<Ratio>,
) -> Result<Source, Failure> {
    let way = way(arguments, model, known, length)?;
    let known = &within(arguments, known)?;
    let wrap = if arguments.no_wrap { WrapBetween::Excluded } else { WrapBetween::Possible };
    let told = |known: &KnownPosition| MachineMark {
        name: format!("place {}", known.reference),
        shown: known.shown,
        reference: Some(known.reference),
    };
    let marks: Vec<_> = known.iter().map(told).collect();
    let line = match Line::of(known, way, wrap) {
        Ok(line) => line,
        Err(unsettled) => {
            return Ok(Source {
                kind: "positions",
                kept: KeptEncoder { marks, ..KeptEncoder::new(model) },
                known: Vec::new(),
                assumed: Vec::new(),
                unknown: vec![unsettled.to_string()],
                sound: false,
                off_at_most: 0,
                is_guess: false,
            });
        }
    };
    let found = Reconstruction::from_positions(model, &line, arguments.turns).ok_or_else(|| {
        bad_input(
            "no measuring length gives these positions over so many turns; leave --turns out, or correct it",
        )
    })?;
    let mut source = Source::reconstructed("positions", found);
    source.kept.marks = marks;
    let missing = |parameter: &Parameter| source.kept.value(*parameter).is_none();
    let missing: Vec<_> = parameters_of(model).filter(missing).collect();
    for parameter in missing {
        source.unknown.push(format!("{}: it stays as the new unit has it", parameter.key()));
    }
    Ok(source)
}

/// The known positions, with their places as exact as somebody says.
fn within(arguments: &Arguments, known: &[KnownPosition]) -> Result<Vec<KnownPosition>, Failure> {
    let Some(within) = arguments.within else { return Ok(known.to_vec()) };
    let off = || {
        bad_input(format!("--within {within}: give how far off a place may be, as \"0.1 mm\", up to 1000"))
    };
    let digit =
        u32::try_from(within.millionths.saturating_mul(2)).ok().filter(|digit| *digit <= 2_000_000_000);
    let digit = digit.ok_or_else(off)?;
    let exact = |known: &KnownPosition| {
        if known.reference.scale != within.scale {
            return Err(bad_input(format!("--within {within}: {} is in another unit", known.reference)));
        }
        Ok(KnownPosition { reference: Reference { digit, ..known.reference }, ..*known })
    };
    known.iter().map(exact).collect()
}

/// What a turn or the rod is on the machine's scale.
fn way(
    arguments: &Arguments,
    model: Model,
    known: &[KnownPosition],
    length: Option<Ratio>,
) -> Result<MeasuredWay, Failure> {
    let rod = model.sensor_kind() == SensorKind::Linear;
    let unit = known.first().map_or(ReferenceUnit::Millimetres, |known| known.reference.scale);
    let native = arguments.how.encoder.label.native;
    let steps = model.steps_per_turn();
    let (fewest, most) = match (rod, native) {
        // A rod counts in micrometres at the coarsest.
        (true, _) => (1, encoring_words::word::DATA_MAX),
        (false, Some(native)) => (native, native),
        (false, None) => (steps.first().copied().unwrap_or(1), steps.last().copied().unwrap_or(1)),
    };
    let length = match (unit, rod, length) {
        (ReferenceUnit::Degrees, true, _) => {
            return Err(bad_input(format!("a {model} is a rod: give its places in mm, not in degrees")));
        }
        (ReferenceUnit::Degrees, false, _) => (360, 1),
        (ReferenceUnit::Millimetres, true, None) => {
            return Err(bad_input("--length-mm MM is missing: the length of the rod on its type label"));
        }
        (ReferenceUnit::Millimetres, false, None) => {
            return Err(bad_input(
                "--mm-per-turn is missing: how far the machine moves in one turn of the shaft; or give degrees of the shaft",
            ));
        }
        (ReferenceUnit::Millimetres, _, Some(length)) => (length.numerator(), length.denominator()),
    };
    let fewest = if rod { rod_grain(length)? } else { fewest };
    if rod {
        within_rod(length, known)?;
    }
    Ok(MeasuredWay { length, unit, fewest_steps: fewest, most_steps: most })
}

/// Micrometres of a rod, rounded down.
fn rod_grain((numerator, denominator): (u128, u128)) -> Result<u32, Failure> {
    let um = numerator.saturating_mul(1_000) / denominator.max(1);
    let of_a_rod = u32::try_from(um).ok().filter(|um| (ROD_UM_MIN..=ROD_UM_MAX).contains(um));
    of_a_rod.ok_or_else(|| {
        bad_input(
            "the length of the rod: a rod has 0.01 mm to 167772.15 mm on its type label; correct --length-mm",
        )
    })
}
