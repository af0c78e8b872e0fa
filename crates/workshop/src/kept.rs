//! What is kept of one encoder: its parameters, what its type label says, when they were taken, and marks on the machine.

use encoring_files::toml_text::Wrong;
use encoring_words::change::ParameterChange;
use encoring_words::model::Sensor;
use encoring_words::{Model, Parameter, word};
use serde::Deserialize;

use crate::mark::{MachineMark, Reference, ReferenceUnit};
use crate::values::{legal_change, parameters_of, written};

/// What is kept of one encoder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KeptEncoder {
    /// Which encoder.
    pub model: Model,
    /// What its label says.
    pub label: UnitLabel,
    /// When and where its values were read; none in a file that somebody wrote by hand.
    pub taken: Option<TakenFrom>,
    /// Marks on the machine, and what the encoder showed there.
    pub marks: Vec<MachineMark>,
    /// What else whoever reads the file should know: each a comment line of its own.
    pub remarks: Vec<String>,
    /// The values, in the order of the services.
    pub values: Vec<(Parameter, u32)>,
    /// Parameters of which a file that somebody wrote names parts alone; no backup has them.
    pub parts: Vec<(Parameter, ParameterChange)>,
}

/// What stands on an encoder, as far as somebody has read it there.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct UnitLabel {
    /// Steps per turn on the rating plate.
    pub native: Option<u32>,
    /// Serial number.
    pub serial: Option<String>,
    /// Week and year of the firmware, as `41/1997`.
    pub firmware: Option<String>,
    /// Any other words, as where it is mounted.
    pub label: Option<String>,
}

/// When and where values were read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TakenFrom {
    /// When, as RFC 3339.
    pub at: String,
    /// Address of the bus, as it was named.
    pub bus: String,
    /// Ring position.
    pub position: usize,
    /// Parameters that the model has and that could not be read.
    pub unreadable: Vec<Parameter>,
}

impl UnitLabel {
    /// What two labels of one unit cannot differ in: a sentence each.
    fn other_unit(&self, new: &Self) -> Vec<String> {
        let number = |steps: Option<u32>| steps.map(|steps| steps.to_string());
        [
            ("native", number(self.native), number(new.native)),
            ("serial", self.serial.clone(), new.serial.clone()),
            ("firmware", self.firmware.clone(), new.firmware.clone()),
        ]
        .into_iter()
        .filter_map(|(key, there, new)| match (there, new) {
            (Some(there), Some(new)) if there != new => Some(format!(
                "{key}: {there} in the file, not {new}: another unit belongs into a file of its own"
            )),
            _ => None,
        })
        .collect()
    }
}

/// An encoder as it stands in a file.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct EncoderTable {
    pub(crate) model: Option<String>,
    /// How many values follow, so that a file that was cut off between two lines is seen.
    pub(crate) values: Option<usize>,
    #[serde(default)]
    pub(crate) unit: UnitTable,
    pub(crate) taken: Option<TakenTable>,
    #[serde(default)]
    pub(crate) mark: Vec<MarkTable>,
    pub(crate) parameters: Option<toml::Table>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct UnitTable {
    pub(crate) native: Option<u32>,
    serial: Option<String>,
    firmware: Option<String>,
    label: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TakenTable {
    at: toml::Value,
    bus: String,
    position: usize,
    #[serde(default)]
    unreadable: Vec<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MarkTable {
    name: String,
    shown: i64,
    reference_mm: Option<toml::Value>,
    reference_deg: Option<toml::Value>,
}

impl KeptEncoder {
    /// What is kept of an encoder before anything is known of it.
    #[must_use]
    pub fn new(model: Model) -> Self {
        Self {
            model,
            label: UnitLabel::default(),
            taken: None,
            marks: Vec::new(),
            remarks: Vec::new(),
            values: Vec::new(),
            parts: Vec::new(),
        }
    }

    /// The value of a parameter, if it is kept.
    #[must_use]
    pub fn value(&self, parameter: Parameter) -> Option<u32> {
        self.values.iter().find(|(kept, _)| *kept == parameter).map(|(_, value)| *value)
    }

    /// Parameters that the model has and that could not be read.
    #[must_use]
    pub fn unreadable(&self) -> &[Parameter] {
        self.taken.as_ref().map_or(&[], |taken| &taken.unreadable)
    }

    /// The mark of a name.
    #[must_use]
    pub fn mark(&self, name: &str) -> Option<&MachineMark> {
        self.marks.iter().find(|mark| mark.name == name)
    }

    /// Ring position of the encoder when it was read.
    #[must_use]
    pub fn position(&self) -> Option<usize> {
        self.taken.as_ref().map(|taken| taken.position)
    }

    /// The same with what a new reading adds: values that could not be read before, and what its label says. Remarks stay
    /// as they are, beside the time of the first reading.
    ///
    /// # Errors
    /// The values that differ, a sentence each: then it is not the same encoder, or it was programmed since.
    pub fn updated(mut self, new: Self) -> Result<Self, Vec<String>> {
        let differs = |(parameter, now): &(Parameter, u32)| {
            let kept = self.value(*parameter).filter(|kept| kept != now)?;
            Some(format!("{}: {kept} in the file, {now} in the encoder", parameter.key()))
        };
        let mut differences: Vec<_> = new.values.iter().filter_map(differs).collect();
        if new.model != self.model {
            differences.push(format!("model: {} in the file, not {}", self.model, new.model));
        }
        differences.extend(self.label.other_unit(&new.label));
        if !differences.is_empty() {
            return Err(differences);
        }
        for (parameter, value) in new.values {
            if self.value(parameter).is_none() {
                self.values.push((parameter, value));
            }
        }
        self.values.sort_by_key(|(parameter, _)| *parameter);
        let known: Vec<_> = self.values.iter().map(|(parameter, _)| *parameter).collect();
        match &mut self.taken {
            Some(taken) => {
                taken.unreadable.retain(|parameter| !known.contains(parameter));
                if self.remarks.is_empty() {
                    self.remarks = new.remarks;
                }
            }
            None => {
                self.taken = new.taken;
                self.remarks.extend(new.remarks);
            }
        }
        self.label = new.label;
        Ok(self)
    }

    /// Adds a mark.
    ///
    /// # Errors
    /// If it is there with another position.
    pub fn note(&mut self, mark: MachineMark) -> Result<(), String> {
        match self.mark(&mark.name) {
            Some(there) if *there == mark => Ok(()),
            Some(there) => Err(format!(
                "{there} is in the file with {}, and {} is shown now; give it another name",
                there.shown, mark.shown
            )),
            None => {
                self.marks.push(mark);
                Ok(())
            }
        }
    }

    /// Whether everything that `other` keeps of the encoder is kept here too, whenever it was read.
    #[must_use]
    pub fn holds(&self, other: &Self) -> bool {
        fn within<T: PartialEq>(there: &Option<T>, other: &Option<T>) -> bool {
            other.is_none() || there == other
        }
        (self.model, &self.values) == (other.model, &other.values)
            && other.marks.iter().all(|mark| self.marks.contains(mark))
            && within(&self.label.native, &other.label.native)
            && within(&self.label.serial, &other.label.serial)
            && within(&self.label.firmware, &other.label.firmware)
            && within(&self.label.label, &other.label.label)
    }

    #[expect(clippy::disallowed_methods, reason = "a model, which `words::model` reads")]
    pub(crate) fn of(table: &EncoderTable) -> Result<Self, Wrong> {
        let Some(name) = &table.model else { return Err(Wrong::new("the key model is missing")) };
        let model: Model =
            name.parse().map_err(|cause| Wrong::at("model", format!("model {name:?}: {cause}")))?;
        let label = table.unit.label(model).map_err(|wrong| wrong.inside("unit"))?;
        let there = table.parameters.as_ref().map_or(0, toml::Table::len);
        if let Some(values) = table.values.filter(|values| *values != there) {
            let problem = format!(
                "values = {values}, and {there} are in [parameters]: the file was cut off or changed; take this line out if \
                 only these are meant"
            );
            return Err(Wrong::at("values", problem));
        }
        let values = table.parameters.iter().flatten().map(|(name, value)| {
            legal_change(model, name, value).map_err(|problem| Wrong::at(name, problem).inside("parameters"))
        });
        let mut given = values.collect::<Result<Vec<_>, _>>()?;
        given.sort_by_key(|(parameter, _)| *parameter);
        let (whole, parts): (Vec<_>, Vec<_>) = given.into_iter().partition(|(_, change)| change.is_whole());
        let values = whole.into_iter().map(|(parameter, change)| (parameter, change.of(0).number)).collect();
        let taken = table.taken.as_ref().map(|taken| taken.taken(model));
        let taken = taken.transpose().map_err(|wrong| wrong.inside("taken"))?;
        let marks = table
            .mark
            .iter()
            .enumerate()
            .map(|(k, mark)| mark.mark().map_err(|wrong: Wrong| wrong.inside_item(k).inside("mark")));
        let marks = marks.collect::<Result<_, _>>()?;
        let kept = Self { model, label, taken, marks, remarks: Vec::new(), values, parts };
        kept.whole()?;
        kept.marks_fit()?;
        Ok(kept)
    }

    /// The largest position that its values allow; none of a file without a measuring length can be told.
    #[must_use]
    pub fn largest_position(&self) -> u32 {
        let length = self.value(Parameter::MeasuringLength).unwrap_or(word::DATA_MAX);
        self.model.largest_position(length)
    }

    /// Each mark is a position that the values allow, and each name means one place.
    fn marks_fit(&self) -> Result<(), Wrong> {
        let largest = self.largest_position();
        for (k, mark) in self.marks.iter().enumerate() {
            let at = |key: &str, problem: String| Wrong::at(key, problem).inside_item(k).inside("mark");
            if mark.shown > largest {
                let problem = format!(
                    "shown = {}, and measuring_length = {largest}: the encoder cannot show it; correct one of them, or take \
                     the mark out",
                    mark.shown
                );
                return Err(at("shown", problem));
            }
            let earlier = self.marks.iter().take(k).enumerate().find(|(_, other)| other.name == mark.name);
            if let Some((first, other)) = earlier {
                let problem = format!(
                    "{:?} is the name of two marks: number {} with shown = {}, and number {} with shown = {}; give one of \
                     them another name",
                    mark.name,
                    first + 1,
                    other.shown,
                    k + 1,
                    mark.shown
                );
                return Err(at("name", problem));
            }
        }
        Ok(())
    }

    /// What was read from an encoder holds every parameter of it, or says that it could not be read.
    fn whole(&self) -> Result<(), Wrong> {
        let Some(taken) = &self.taken else { return Ok(()) };
        for parameter in parameters_of(self.model) {
            let key = parameter.key();
            match (self.value(parameter).is_some(), taken.unreadable.contains(&parameter)) {
                (false, false) => {
                    return Err(Wrong::at(
                        "taken",
                        format!(
                            "{key} is neither in [parameters] nor in unreadable: the file was cut off or changed; take \
                             [taken] out if only these values are meant"
                        ),
                    ));
                }
                (true, true) => {
                    let problem = format!("{key} is in [parameters] and in unreadable");
                    return Err(Wrong::at("unreadable", problem).inside("taken"));
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Appends it as TOML; the names of its tables begin with `prefix`.
    pub(crate) fn write(&self, text: &mut String, prefix: &str) {
        let quoted = |words: &str| toml::Value::String(words.to_owned()).to_string();
        *text += &format!("model = \"{}\"\n", self.model);
        // What was read from an encoder has every parameter or names it as unreadable; of anything else the number is kept.
        if self.taken.is_none() {
            *text += &format!("values = {}\n", self.values.len());
        }
        let UnitLabel { native, serial, firmware, label } = &self.label;
        let words = [("serial", serial), ("firmware", firmware), ("label", label)];
        let words: Vec<_> = words.iter().filter_map(|(key, words)| Some((key, words.as_ref()?))).collect();
        if native.is_some() || !words.is_empty() {
            *text += &format!("\n[{prefix}unit]\n");
            *text += &native.map(|native| format!("native = {native}\n")).unwrap_or_default();
            for (key, words) in words {
                *text += &format!("{key} = {}\n", quoted(words));
            }
        }
        if let Some(TakenFrom { at, bus, position, unreadable }) = &self.taken {
            let unreadable: Vec<_> = unreadable.iter().map(|parameter| quoted(parameter.key())).collect();
            *text += &format!(
                "\n[{prefix}taken]\nat = {}\nbus = {}\nposition = {position}\nunreadable = [{}]\n",
                quoted(at),
                quoted(bus),
                unreadable.join(", ")
            );
        }
        for MachineMark { name, shown, reference } in &self.marks {
            *text += &format!("\n[[{prefix}mark]]\nname = {}\nshown = {shown}\n", quoted(name));
            if let Some(reference) = reference {
                *text += &format!("{} = {}\n", reference.scale.key(), reference.number());
            }
        }
        // Last, so that a file that was cut off lacks some of them, which is seen.
        *text += &format!("\n[{prefix}parameters]\n");
        for (parameter, value) in &self.values {
            let (key, number) = (parameter.key(), parameter.service().number());
            *text +=
                &format!("{key} = {}    # service {number:02X}\n", written(self.model, *parameter, *value));
        }
    }

    /// Appends its remarks as comments.
    pub(crate) fn write_remarks(&self, text: &mut String) {
        for remark in &self.remarks {
            // A line break in a remark would begin something else.
            *text += &format!("# {}\n", remark.replace(['\n', '\r'], " "));
        }
    }
}

/// Refuses steps per turn that the model is never built with.
pub(crate) fn rated(model: Model, native: u32) -> Result<(), Wrong> {
    let sensor = model.built_with(Sensor::Rotary { steps_per_turn: native });
    sensor.map(|_| ()).map_err(|wrong| Wrong::at("native", format!("native: {wrong}")))
}

impl UnitTable {
    fn label(&self, model: Model) -> Result<UnitLabel, Wrong> {
        if let Some(native) = self.native {
            rated(model, native)?;
        }
        let Self { native, serial, firmware, label } = self;
        Ok(UnitLabel {
            native: *native,
            serial: serial.clone(),
            firmware: firmware.clone(),
            label: label.clone(),
        })
    }
}

impl TakenTable {
    fn taken(&self, model: Model) -> Result<TakenFrom, Wrong> {
        let at = match &self.at {
            toml::Value::String(at) => at.clone(),
            toml::Value::Datetime(at) => at.to_string(),
            other => return Err(Wrong::at("at", format!("at = {other}; it must be a time"))),
        };
        let unreadable = self.unreadable.iter().map(|name| {
            parameters_of(model)
                .find(|parameter| parameter.key() == name)
                .ok_or_else(|| Wrong::at("unreadable", format!("{name:?} is no parameter of a {model}")))
        });
        let unreadable = unreadable.collect::<Result<_, _>>()?;
        Ok(TakenFrom { at, bus: self.bus.clone(), position: self.position, unreadable })
    }
}

impl MarkTable {
    fn mark(&self) -> Result<MachineMark, Wrong> {
        let limit = i64::from(word::DATA_MAX);
        let shown = u32::try_from(self.shown).ok().filter(|shown| *shown <= word::DATA_MAX);
        let shown = shown.ok_or_else(|| {
            Wrong::at("shown", format!("shown = {}; it must be a position from 0 to {limit}", self.shown))
        })?;
        let read = |value: &toml::Value, scale: ReferenceUnit| {
            let number = match value {
                toml::Value::Integer(_) | toml::Value::Float(_) => value.to_string(),
                other => {
                    return Err(Wrong::at(scale.key(), format!("{} = {other} is no number", scale.key())));
                }
            };
            Reference::read(&number, scale).map_err(|problem| Wrong::at(scale.key(), problem))
        };
        let reference = match (&self.reference_mm, &self.reference_deg) {
            (None, None) => None,
            (Some(mm), None) => Some(read(mm, ReferenceUnit::Millimetres)?),
            (None, Some(degrees)) => Some(read(degrees, ReferenceUnit::Degrees)?),
            (Some(_), Some(_)) => {
                return Err(Wrong::at("reference_deg", "a mark has reference_mm or reference_deg, not both"));
            }
        };
        Ok(MachineMark { name: self.name.clone(), shown, reference })
    }
}
