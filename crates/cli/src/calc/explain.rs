//! `encoring calc explain`: what values of services 02, 03 and 09 make of a shaft or a rod.

use std::fmt;

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use encoring_host::scaling::{
    DecimalError, Fraction, LinearScaling, Ratio, RotaryScaling, Turns, preset_adjustment, rotary,
};
use encoring_words::explain::DirectionMeaning;
use encoring_words::parameter::{CountingDirection, Direction, OutOfRange};
use encoring_words::word::{Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, Model, OutWord, Service};
use serde::Serialize;

use super::text;
use super::view::{ValueView, ZeroView, number};
use crate::arguments::range::{self, refusal};
use crate::arguments::{TypeLabel, value};
use crate::calculation::{Asked, Note};
use crate::output::ratio::show;
use crate::output::{Failure, bad_input};

/// Explain programmed values: steps per turn, range, zero, words, and the place of a position
///
/// Use it for values that were read from an encoder or stand in a PLC program. It undoes `calc rotary` and `calc linear`.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  the encoder takes these values
  1  the encoder would refuse them (2^14)
  2  wrong input

Examples:
  encoring calc explain --length 9999 --numerator 10 --denominator 1
  encoring calc explain --length 9999 --numerator 10 --mm-per-turn 5 --mm 12.5
  encoring calc explain --length 270Fh --numerator 0Ah --direction falling --position 2500
  encoring calc explain --length 50000 --rod-mm 500 --mm 125")]
pub(super) struct Arguments {
    /// S, the measuring length in steps (service 02): the largest position
    #[arg(long, value_name = "S", value_parser = value)]
    length: u32,

    /// N, the revolutions numerator (service 03)
    #[arg(long, value_name = "N", value_parser = value, required_unless_present = "rod_mm")]
    numerator: Option<u32>,

    /// D, the revolutions denominator (service 09)
    #[arg(long, value_name = "D", value_parser = value, default_value = "1")]
    denominator: u32,

    /// Of a rod, in place of the numerator: its length on the type label, in mm
    #[arg(long, value_name = "MM", value_parser = range::number, conflicts_with_all = ["numerator", "mm_per_turn"])]
    rod_mm: Option<Ratio>,

    /// The counting direction (service 01)
    #[arg(long, value_name = "rising|falling", default_value = "rising", value_parser = direction())]
    direction: Direction,

    /// Travel of the machine in one turn of the shaft, in mm
    #[arg(long, value_name = "MM", value_parser = range::number)]
    mm_per_turn: Option<Ratio>,

    /// Show where this position is, in turns, degrees and mm
    #[arg(long, value_name = "P", value_parser = value, conflicts_with_all = ["mm", "degrees"])]
    position: Option<u32>,

    /// Show the position at this distance from position 0, in mm, and the preset adjustment to it
    #[arg(long, value_name = "MM", value_parser = place, allow_hyphen_values = true, conflicts_with = "degrees")]
    mm: Option<Ratio>,

    /// The same for an angle from position 0, in degrees; more than 360 are several turns
    #[arg(long, value_name = "DEG", value_parser = place, allow_hyphen_values = true, conflicts_with = "rod_mm")]
    degrees: Option<Ratio>,

    #[command(flatten)]
    label: TypeLabel,
}

fn direction() -> impl TypedValueParser<Value = Direction> {
    PossibleValuesParser::new(["rising", "falling"])
        .map(|name| if name == "falling" { Direction::Falling } else { Direction::Rising })
}

/// A distance from position 0.
fn place(text: &str) -> Result<Ratio, String> {
    let allowed = "like 0, 12 or 0.01";
    Ratio::from_zero(text).map_err(|error| match error {
        DecimalError::NotPositive => format!("below 0; allowed is a number {allowed}"),
        error => refusal(text, error, |pointed| Ratio::from_zero(pointed).err(), allowed),
    })
}

/// What values mean.
#[derive(Serialize)]
pub(super) struct ExplainView {
    /// `rotary` or `linear`.
    encoder: &'static str,
    models: Vec<&'static str>,
    native: Option<u32>,
    usable: bool,
    measuring_length: ValueView,
    numerator: Option<ValueView>,
    denominator: Option<ValueView>,
    last_position: u32,
    turns: Option<f64>,
    steps_per_turn: Option<f64>,
    degrees_per_step: Option<f64>,
    mm_per_step: Option<f64>,
    range_mm: Option<f64>,
    zero: Option<ZeroView>,
    notes: Vec<Note>,
    words: Vec<WordView>,
    places: Vec<PlaceView>,
    /// The words of the preset adjustment to the position asked for.
    preset: Vec<WordView>,
}

/// A word in every form that a PLC monitor shows.
#[derive(Serialize)]
struct WordView {
    service: u8,
    name: &'static str,
    word: String,
    high: String,
    low: String,
    signed: i32,
    unsigned: u32,
    high_signed: i16,
    low_signed: i16,
}

/// A position with its place.
#[derive(Serialize)]
struct PlaceView {
    position: u32,
    hex: String,
    turns: Option<f64>,
    degrees: Option<f64>,
    mm: Option<f64>,
    /// The same for people.
    #[serde(skip)]
    text: [String; 3],
}

impl WordView {
    fn new(service: Service, word: OutWord) -> Self {
        Self {
            service: service.number(),
            name: service.name(),
            word: word.to_string(),
            high: format!("{:04X}", word.high()),
            low: format!("{:04X}", word.low()),
            signed: word.0.cast_signed(),
            unsigned: word.0,
            high_signed: word.high().cast_signed(),
            low_signed: word.low().cast_signed(),
        }
    }

    fn write(service: Service, data: u32) -> Self {
        let fields = ServiceFields {
            access: Access::Write,
            error: false,
            reserve: false,
            service: ServiceNumber::Known(service),
            data,
        };
        Self::new(service, OutWord::from(Out::Request(fields)))
    }

    fn preset(position: u32) -> Vec<Self> {
        let steps = preset_adjustment(position).into_iter();
        steps.map(|step| Self::new(Service::PresetAdjustment, step.out)).collect()
    }
}

impl ExplainView {
    pub(super) fn usable(&self) -> bool {
        self.usable
    }
}

pub(super) fn view(arguments: &Arguments) -> Result<ExplainView, Failure> {
    match (arguments.rod_mm, arguments.numerator) {
        (Some(rod_mm), _) => linear(arguments, rod_mm),
        (None, Some(numerator)) => shaft(arguments, numerator),
        (None, None) => Err(bad_input("--numerator is missing; of a rod, --rod-mm")),
    }
}

/// A value that its service does not take.
fn outside(option: &str, refused: OutOfRange) -> Failure {
    let OutOfRange { value, low, high } = refused;
    bad_input(format!("{option} {value} ({value:X}h) is outside {low}..{high} ({low:X}h..{high:X}h)"))
}

fn whole_degrees() -> Ratio {
    Ratio::from(360)
}

/// What a turn of the shaft is worth.
struct ShaftPlaces {
    scaling: RotaryScaling,
    mm_per_turn: Option<Ratio>,
    direction: Direction,
}

impl ShaftPlaces {
    fn at(&self, position: u32) -> PlaceView {
        let turns = self.scaling.turns_at(position);
        let degrees = turns.times(whole_degrees());
        let mm = self.mm_per_turn.and_then(|mm| turns.times(mm));
        let sense = match self.direction {
            Direction::Rising => "clockwise",
            Direction::Falling => "counter-clockwise",
        };
        PlaceView::new(position, [Some(turns), degrees, mm], sense)
    }

    /// The position that was asked for by one of the three options.
    fn asked(&self, arguments: &Arguments) -> Result<Option<(u32, Option<Note>)>, Failure> {
        let (option, unit, per_turn, place) = match (arguments.position, arguments.mm, arguments.degrees) {
            (Some(position), ..) => return last(position, self.scaling.measuring_length()).map(Some),
            (None, Some(mm), _) => {
                let needed = || bad_input("--mm needs --mm-per-turn, or --rod-mm of a rod");
                ("--mm", "mm", self.mm_per_turn.ok_or_else(needed)?, mm)
            }
            (None, None, Some(degrees)) => ("--degrees", "degrees", whole_degrees(), degrees),
            (None, None, None) => return Ok(None),
        };
        let position = place.over(per_turn).and_then(|turns| self.scaling.position_at(turns));
        let Some(position) = position else {
            let range = self.scaling.fraction.turns().times(per_turn).map(show).unwrap_or_default();
            let last = self.scaling.measuring_length();
            return Err(bad_input(format!(
                "{option} {} is beyond the last position, {last}: at {range} {unit} the position is 0 again",
                show(place)
            )));
        };
        let there = self.scaling.turns_at(position).times(per_turn);
        Ok(Some((position, rounding(place, there, unit))))
    }
}

/// A position that must exist.
fn last(position: u32, last: u32) -> Result<(u32, Option<Note>), Failure> {
    if position > last {
        return Err(bad_input(format!("--position {position} is beyond the last position, {last}")));
    }
    Ok((position, None))
}

/// That a place lies between two positions.
fn rounding(asked: Ratio, there: Option<Ratio>, unit: &str) -> Option<Note> {
    let there = there.filter(|there| *there != asked)?;
    let text = format!(
        "{} {unit} lies between two positions; the nearest is at {} {unit}",
        show(asked),
        show(there)
    );
    Some(Note::remark("rounded", text))
}

fn shaft(arguments: &Arguments, numerator: u32) -> Result<ExplainView, Failure> {
    let TypeLabel { model, .. } = arguments.label;
    let shaft = super::shaft_of(arguments.label)?;
    Fraction::new(numerator, 1, shaft).map_err(|refused| outside("--numerator", refused))?;
    let fraction = Fraction::new(numerator, arguments.denominator, shaft)
        .map_err(|refused| outside("--denominator", refused))?;
    let scaling = RotaryScaling::new(arguments.length, fraction, shaft)
        .map_err(|refused| outside("--length", refused))?;
    let steps_per_turn = scaling.steps_per_turn();
    let found = rotary(steps_per_turn, Turns::from(fraction), shaft)
        .map_err(|error| bad_input(format!("these values cannot be programmed: {error}")))?;
    let asked =
        Asked { steps_per_turn, mm_per_turn: arguments.mm_per_turn, shaft, model, found, advice: None };
    let models = asked.models();
    let places = ShaftPlaces { scaling, mm_per_turn: arguments.mm_per_turn, direction: arguments.direction };
    let wanted = places.asked(arguments)?;
    let mut notes = asked.meaning();
    let turns = fraction.turns();
    let range_mm = arguments.mm_per_turn.and_then(|mm| turns.times(mm));
    let degrees_per_step = whole_degrees().over(steps_per_turn);
    notes.push(Note::remark("reach", reach(turns.times(whole_degrees()), degrees_per_step, range_mm)));
    notes.extend(models.first().map(|model| Note::remark("counting", counting(arguments.direction, *model))));
    notes.extend(wanted.as_ref().and_then(|(_, note)| note.clone()));
    let position = wanted.map(|(position, _)| position);
    Ok(ExplainView {
        encoder: "rotary",
        models: models.into_iter().map(Model::name).collect(),
        native: Some(shaft.steps_per_turn()),
        usable: scaling.too_large(shaft).is_none(),
        measuring_length: ValueView::new(Service::MeasuringLength, arguments.length),
        numerator: Some(ValueView::new(Service::Numerator, numerator)),
        denominator: Some(ValueView::new(Service::Denominator, arguments.denominator)),
        last_position: arguments.length,
        turns: Some(number(turns)),
        steps_per_turn: Some(number(steps_per_turn)),
        degrees_per_step: degrees_per_step.map(number),
        mm_per_step: asked.resolution_mm().map(number),
        range_mm: range_mm.map(number),
        zero: Some(ZeroView::of(scaling.zero_risk())),
        notes,
        words: vec![
            direction_word(arguments.direction),
            WordView::write(Service::MeasuringLength, arguments.length),
            WordView::write(Service::Numerator, numerator),
            WordView::write(Service::Denominator, arguments.denominator),
        ],
        places: shown(position, arguments.length).map(|position| places.at(position)).collect(),
        preset: position.map(WordView::preset).unwrap_or_default(),
    })
}

fn linear(arguments: &Arguments, rod_mm: Ratio) -> Result<ExplainView, Failure> {
    let model = super::rod()?;
    let scaling =
        LinearScaling::new(arguments.length, model).map_err(|refused| outside("--length", refused))?;
    let resolution = scaling.resolution(rod_mm);
    let at = |position: u32| resolution.times(Ratio::from(position));
    let wanted = match (arguments.position, arguments.mm) {
        (Some(position), _) => Some(last(position, arguments.length)?),
        (None, Some(mm)) => {
            let position = scaling.position_at(mm, rod_mm).ok_or_else(|| {
                bad_input(format!("--mm {} is beyond the end of the rod, {} mm", show(mm), show(rod_mm)))
            })?;
            Some((position, rounding(mm, at(position), "mm")))
        }
        (None, None) => None,
    };
    let range =
        format!("positions 0..{} over {} mm, {} mm a step", arguments.length, show(rod_mm), show(resolution));
    let mut notes =
        vec![Note::remark("range", range), Note::remark("counting", counting(arguments.direction, model))];
    notes.extend(wanted.as_ref().and_then(|(_, note)| note.clone()));
    let position = wanted.map(|(position, _)| position);
    Ok(ExplainView {
        encoder: "linear",
        models: vec![model.name()],
        native: None,
        usable: true,
        measuring_length: ValueView::new(Service::MeasuringLength, arguments.length),
        numerator: None,
        denominator: None,
        last_position: arguments.length,
        turns: None,
        steps_per_turn: None,
        degrees_per_step: None,
        mm_per_step: Some(number(resolution)),
        range_mm: Some(number(rod_mm)),
        zero: None,
        notes,
        words: vec![
            direction_word(arguments.direction),
            WordView::write(Service::MeasuringLength, arguments.length),
        ],
        places: shown(position, arguments.length)
            .map(|position| PlaceView::new(position, [None, None, at(position)], ""))
            .collect(),
        preset: position.map(WordView::preset).unwrap_or_default(),
    })
}

/// The position that was asked for, or both ends.
fn shown(asked: Option<u32>, last: u32) -> impl Iterator<Item = u32> {
    let ends = if asked.is_none() { vec![0, last] } else { Vec::new() };
    asked.into_iter().chain(ends)
}

fn reach(degrees: Option<Ratio>, degrees_per_step: Option<Ratio>, range_mm: Option<Ratio>) -> String {
    let said = |ratio: Option<Ratio>| ratio.map(show).unwrap_or_default();
    let mm = range_mm.map(|mm| format!(", {} mm", show(mm))).unwrap_or_default();
    format!(
        "{} degrees{mm} until the position is 0 again; a step is {} degrees",
        said(degrees),
        said(degrees_per_step)
    )
}

/// The word of service 01.
fn direction_word(direction: Direction) -> WordView {
    let counting = CountingDirection { direction, ..CountingDirection::default() };
    WordView::write(Service::CountingDirection, counting.data())
}

/// What the counting direction means.
fn counting(direction: Direction, model: Model) -> String {
    format!("{:#}", DirectionMeaning { direction, model })
}

impl PlaceView {
    fn new(position: u32, place: [Option<Ratio>; 3], sense: &str) -> Self {
        let [turns, degrees, mm] = place;
        let said = |ratio: Option<Ratio>, unit: &str| {
            ratio.map(|ratio| format!("{} {unit}", show(ratio)).trim_end().to_owned()).unwrap_or_default()
        };
        Self {
            position,
            hex: format!("{position:06X}"),
            turns: turns.map(number),
            degrees: degrees.map(number),
            mm: mm.map(number),
            text: [said(turns, "turns"), said(degrees, &format!("degrees {sense}")), said(mm, "mm")],
        }
    }
}

fn words(f: &mut fmt::Formatter<'_>, heading: &str, words: &[WordView]) -> fmt::Result {
    writeln!(f, "\n{heading:<29}  word       high low    signed       unsigned    high    low")?;
    words.iter().try_for_each(|of| {
        let WordView { service, name, word, high, low, signed, unsigned, high_signed, low_signed } = of;
        let label = format!("{service:02X}  {name}");
        writeln!(
            f,
            "{label:<29}  {word}   {high} {low}  {signed:>11}  {unsigned:>10}  {high_signed:>6}  {low_signed:>6}"
        )
    })
}

impl fmt::Display for ExplainView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let values = [Some(&self.measuring_length), self.numerator.as_ref(), self.denominator.as_ref()];
        text::head(f, &self.models, self.native, values.into_iter().flatten())?;
        self.notes.iter().try_for_each(|note| note.fmt(f))?;
        words(f, "write", &self.words)?;
        writeln!(f)?;
        for place in &self.places {
            let parts: Vec<&str> =
                place.text.iter().map(String::as_str).filter(|part| !part.is_empty()).collect();
            writeln!(f, "position {} ({}h) is at {}", place.position, place.hex, parts.join(", "))?;
        }
        if self.preset.is_empty() { Ok(()) } else { words(f, "to make it the position here", &self.preset) }
    }
}
