//! Parameters from words: those noted in a PLC program, or those of a recording.

use encoring_host::Request;
use encoring_words::word::{In, Out, SERVICE_BIT, ServiceFields, ServiceNumber};
use encoring_words::{Access, InWord, Model, OutWord, Parameter, Service};

use crate::values::parameters_of;

/// What words tell of the parameters of an encoder.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct WordFindings {
    model: Model,
    /// Every value that a word has, in the order of the words.
    found: Vec<FoundValue>,
    /// Values of presets, in the order of the words.
    presets: Vec<FoundPreset>,
    /// Words that tell nothing, and why.
    pub notes: Vec<String>,
    /// The last data check of a recording refused the values together: its reply, and where.
    pub refused: Option<String>,
}

/// A value that a word has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundValue {
    /// Of which parameter.
    pub parameter: Parameter,
    /// The value, as the encoder stores it.
    pub value: u32,
    /// Where the word stood.
    pub place: String,
}

/// A preset that a word asks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundPreset {
    /// The position that it makes.
    pub value: u32,
    /// Where the word stood.
    pub place: String,
}

/// What is known of a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WordEvidence<'a> {
    /// Every word says the same; the first of them.
    Known(&'a FoundValue),
    /// Words contradict each other: one for each value.
    Contradicted(Vec<&'a FoundValue>),
    /// No word has it.
    Missing,
}

impl WordFindings {
    const fn new(model: Model) -> Self {
        Self { model, found: Vec::new(), presets: Vec::new(), notes: Vec::new(), refused: None }
    }

    /// From words that somebody noted, each with where it stood: requests or replies, the service bit set or not.
    pub fn noted(model: Model, words: impl IntoIterator<Item = (u32, String)>) -> Self {
        let mut findings = Self::new(model);
        for (word, place) in words {
            // The word of the first step has the data, and the service bit is still to come [R33].
            let request = OutWord(word | SERVICE_BIT.mask());
            let Out::Request(fields) = request.decode() else { continue };
            // The request of a read; its reply has the value.
            if fields.access == Access::Read && fields.data == 0 && word != 0 {
                continue;
            }
            findings.take(word, fields, &place);
        }
        findings
    }

    /// From a recording: what the encoder acknowledged or replied without an error. The last word of a parameter counts,
    /// as it is what the encoder held in the end.
    pub fn recorded(model: Model, rows: impl IntoIterator<Item = (Option<InWord>, String)>) -> Self {
        let (mut findings, mut last) = (Self::new(model), None);
        for (input, place) in rows {
            if input == last {
                continue;
            }
            last = input;
            let Some(In::Reply(fields)) = input.map(InWord::decode) else { continue };
            if fields.service == ServiceNumber::Known(Service::DataCheck) {
                let word = input.map_or(0, |word| word.0);
                findings.refused = fields.error.then(|| format!("{place}: {word:08X}"));
            }
            // With an error a write was refused, and a 0 that was read may be a record that cannot be.
            if fields.error {
                continue;
            }
            let (before, word) = (findings.found.len(), input.map_or(0, |word| word.0));
            findings.take(word, fields, &place);
            if let Some(new) = findings.found.get(before).cloned() {
                findings.found.retain(|found| found.parameter != new.parameter);
                findings.found.push(new);
            }
        }
        findings
    }

    fn take(&mut self, word: u32, fields: ServiceFields, place: &str) {
        if let Err(why) = self.fields(word, fields, place) {
            let model = self.model;
            self.notes.push(format!("{place}: {word:08X} {}", why.replace("{model}", model.name())));
        }
    }

    fn fields(&mut self, word: u32, fields: ServiceFields, place: &str) -> Result<(), String> {
        let ServiceFields { access, error, reserve, service, data } = fields;
        if word == data {
            return Err("has no service number: it is a position or a plain number".to_owned());
        }
        if reserve {
            return Err("has the reserve bit set, so it is no word of an encoder".to_owned());
        }
        if error {
            return Err("has the error bit set: the encoder refused it, or an error was pending".to_owned());
        }
        let ServiceNumber::Known(service) = service else {
            return Err(format!("has service {:02X}, which no encoder has", service.number()));
        };
        if !service.known_to(self.model) {
            return Err(format!(
                "has service {:02X}, which a {{model}} lacks: is the model right?",
                service.number()
            ));
        }
        let place = place.to_owned();
        match (Parameter::from_service(service), access) {
            (None, Access::Write) if service == Service::PresetAdjustment => {
                self.presets.push(FoundPreset { value: data, place });
                Ok(())
            }
            (None, _) => Ok(()),
            (Some(parameter), _) => match parameter.normalise(self.model, data) {
                // What no request writes the encoder never took.
                Ok(value) if Request::write(self.model, parameter, value).is_err() => {
                    Err(format!("has {} = {data}, which a {{model}} refuses", parameter.key()))
                }
                Ok(value) => {
                    self.found.push(FoundValue { parameter, value, place });
                    Ok(())
                }
                Err(refused) => Err(format!(
                    "has {} = {data}, and a {{model}} takes {} to {}",
                    parameter.key(),
                    refused.low,
                    refused.high
                )),
            },
        }
    }

    /// What is known of a parameter.
    #[must_use]
    pub fn of(&self, parameter: Parameter) -> WordEvidence<'_> {
        let mut different: Vec<&FoundValue> = Vec::new();
        for found in self.found.iter().filter(|found| found.parameter == parameter) {
            if different.iter().all(|other| other.value != found.value) {
                different.push(found);
            }
        }
        match different.as_slice() {
            [] => WordEvidence::Missing,
            [only] => WordEvidence::Known(only),
            _ => WordEvidence::Contradicted(different),
        }
    }

    /// Each parameter of the model with what is known of it.
    pub fn all(&self) -> impl Iterator<Item = (Parameter, WordEvidence<'_>)> {
        parameters_of(self.model).map(|parameter| (parameter, self.of(parameter)))
    }

    /// The values that every word agrees on.
    #[must_use]
    pub fn values(&self) -> Vec<(Parameter, u32)> {
        let known = |(parameter, evidence)| match evidence {
            WordEvidence::Known(found) => Some((parameter, found.value)),
            _ => None,
        };
        self.all().filter_map(known).collect()
    }

    /// The presets that words ask for, each value once.
    #[must_use]
    pub fn presets(&self) -> Vec<&FoundPreset> {
        let mut presets: Vec<&FoundPreset> = Vec::new();
        for preset in &self.presets {
            if presets.iter().all(|other| other.value != preset.value) {
                presets.push(preset);
            }
        }
        presets
    }
}
