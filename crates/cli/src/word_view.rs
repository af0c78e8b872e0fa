//! What `decode` shows of a word: plain data for programs, and the same as text for people.

mod text;

use encoring_words::explain::{
    self, Answer, ByteField, ByteMeaning, Deed, DirectionMeaning, Foreign, Legal, effect, refusal,
};
use encoring_words::parameter::CountingDirection;
use encoring_words::word::{self, FIELDS, In, Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, ErrorStatus, InWord, Model, OutWord, Service, gray};
use serde::Serialize;

use crate::told::BitView;

/// A word with its meaning in one direction or in both.
#[derive(Serialize)]
pub(crate) struct WordView {
    word: String,
    high: String,
    low: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    out: Option<OutView>,
    #[serde(rename = "in", skip_serializing_if = "Option::is_none")]
    input: Option<InView>,
}

/// The bits of a word, as both directions lay them out.
#[derive(Serialize)]
struct Bits {
    service_bit: u32,
    read_write_bit: u32,
    error_bit: u32,
    reserve: u32,
    service: u32,
    /// In service mode, if any encoder has the service.
    service_name: Option<&'static str>,
    data: u32,
    data_hex: String,
    /// A note on each of [`FIELDS`], for people.
    #[serde(skip)]
    notes: [String; FIELDS.len()],
}

#[derive(Serialize)]
struct OutView {
    meaning: String,
    #[serde(flatten)]
    bits: Bits,
    models: Vec<OutModel>,
    remarks: Vec<String>,
}

#[derive(Serialize)]
struct InView {
    meaning: String,
    #[serde(flatten)]
    bits: Bits,
    position: Option<Position>,
    status: Option<StatusView>,
    /// No encoder, or not the one asked for, sends the word.
    foreign: bool,
    models: Vec<InModel>,
    remarks: Vec<String>,
}

#[derive(Serialize)]
struct Position {
    value: u32,
    hex: String,
    /// The position, if the encoder is programmed to Gray; none if it cannot be.
    from_gray: Option<u32>,
    from_gray_hex: Option<String>,
    /// The models that can be.
    #[serde(skip)]
    gray_models: Vec<Model>,
}

#[derive(Serialize)]
struct StatusView {
    hex: String,
    bits: Vec<BitView>,
}

/// What a model makes of the service and its data.
#[derive(Serialize)]
struct DataView {
    model: &'static str,
    knows_service: bool,
    range: Option<RangeView>,
    bytes: Vec<ByteView>,
    text: Vec<String>,
}

#[derive(Serialize)]
struct OutModel {
    #[serde(flatten)]
    data: DataView,
    answer: &'static str,
    status: Option<StatusView>,
}

#[derive(Serialize)]
struct InModel {
    #[serde(flatten)]
    data: DataView,
    /// Why the model does not send the word.
    foreign: Option<String>,
}

#[derive(Serialize)]
struct RangeView {
    low: u32,
    high: u32,
    /// The measuring length in force ends the range before `high`.
    up_to_measuring_length: bool,
}

#[derive(Serialize)]
struct ByteView {
    byte: u8,
    name: Option<&'static str>,
    value: u8,
    low: u8,
    high: u8,
    meaning: String,
}

/// The meanings to show.
#[derive(Clone, Copy)]
pub(crate) struct Shown<'a> {
    pub(crate) out: bool,
    pub(crate) input: bool,
    pub(crate) models: &'a [Model],
}

impl WordView {
    pub(crate) fn new(word: u32, shown: Shown<'_>) -> Self {
        let halves = OutWord(word);
        Self {
            word: halves.to_string(),
            high: format!("{:04X}", halves.high()),
            low: format!("{:04X}", halves.low()),
            out: shown.out.then(|| OutView::new(halves, shown.models)),
            input: shown.input.then(|| InView::new(InWord(word), shown.models)),
        }
    }
}

impl Bits {
    /// `notes` from the read-write bit on; the service bit explains itself.
    fn new(word: u32, notes: [String; FIELDS.len() - 1]) -> Self {
        let service_bit = word::SERVICE_BIT.of(word);
        let [read_write, error, reserve, service, data] = notes;
        let mode = if service_bit == 1 { "service mode" } else { "normal mode" }.to_owned();
        let name = match OutWord(word).decode() {
            Out::Request(ServiceFields { service: ServiceNumber::Known(service), .. }) => {
                Some(service.name())
            }
            _ => None,
        };
        Self {
            service_bit,
            read_write_bit: word::READ_WRITE_BIT.of(word),
            error_bit: word::ERROR_BIT.of(word),
            reserve: word::RESERVE_BIT.of(word),
            service: word::SERVICE.of(word),
            service_name: name,
            data: word::DATA.of(word),
            data_hex: format!("{:06X}", word::DATA.of(word)),
            notes: [mode, read_write, error, reserve, service, data],
        }
    }
}

/// `text` if the bit is set.
fn if_set(bit: bool, text: &str) -> String {
    if bit { text.to_owned() } else { String::new() }
}

fn service_note(service: ServiceNumber) -> String {
    match service {
        ServiceNumber::Known(service) => service.name(),
        ServiceNumber::Unknown(_) => "no encoder has this service",
    }
    .to_owned()
}

impl OutView {
    fn new(word: OutWord, models: &[Model]) -> Self {
        let no_effect = || "no effect".to_owned();
        match word.decode() {
            Out::Normal(bits) => {
                let data = format!("{}, no effect", word::DATA.of(bits));
                let notes = [no_effect(), no_effect(), no_effect(), no_effect(), data];
                let prepared = OutWord(bits | word::SERVICE_BIT.mask());
                let remarks = match prepared.decode() {
                    Out::Request(request @ ServiceFields { service: ServiceNumber::Known(_), .. }) => {
                        vec![format!("with the service bit 1 it is {prepared}: {}", Deed::asked(request))]
                    }
                    _ => Vec::new(),
                };
                let meaning = "normal mode, no service is requested".to_owned();
                Self { meaning, bits: Bits::new(word.0, notes), models: Vec::new(), remarks }
            }
            Out::Request(request) => {
                let data = match request.access {
                    Access::Read => format!("{}, without meaning", request.data),
                    Access::Write => request.data.to_string(),
                };
                let notes = [
                    explain::access(request.access).to_owned(),
                    if_set(request.error, "the encoder ignores it"),
                    if_set(request.reserve, "should be 0; the encoder ignores it"),
                    service_note(request.service),
                    data,
                ];
                Self {
                    meaning: format!("request: {}", Deed::asked(request)),
                    bits: Bits::new(word.0, notes),
                    models: models.iter().map(|model| OutModel::new(request, *model)).collect(),
                    remarks: Vec::new(),
                }
            }
        }
    }
}

/// Whether a word carries a value of its service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Carries {
    Value,
    Nothing,
}

impl OutModel {
    fn new(request: ServiceFields, model: Model) -> Self {
        let answer = Answer::to(request, model);
        let mut data = DataView::new(
            request,
            model,
            match request.access {
                Access::Write => Carries::Value,
                Access::Read => Carries::Nothing,
            },
        );
        let (name, status) = match answer {
            Answer::Done => ("done", None),
            Answer::RefusedAboveLength { status } => ("refused_above_measuring_length", Some(status)),
            Answer::CheckedAgainstLength { status } => ("checked_against_measuring_length", Some(status)),
            Answer::Invalid { status } => ("invalid", Some(status)),
            Answer::Refused { status } => ("refused", Some(status)),
        };
        data.text.extend(outcome(request, model, answer));
        Self { data, answer: name, status: status.map(StatusView::new) }
    }
}

/// What a model does with a request, in a few lines.
fn outcome(request: ServiceFields, model: Model, answer: Answer) -> Vec<String> {
    let shown = |status: ErrorStatus| match powers(status) {
        bits if bits.is_empty() => "error bit, but no status bit".to_owned(),
        bits => format!("error bit, status {bits}"),
    };
    let mut lines: Vec<String> = match answer {
        Answer::Invalid { .. } => Vec::new(),
        Answer::Refused { .. } => vec![refusal(request, model).to_owned()],
        _ => effect(request, model).iter().map(|line| (*line).to_owned()).collect(),
    };
    match answer {
        Answer::Done => {}
        Answer::RefusedAboveLength { status } => {
            lines.push(format!("above the measuring length refused: {}", shown(status)));
        }
        Answer::CheckedAgainstLength { status } => {
            lines.push(format!("above the measuring length the data check finds status {}", powers(status)));
        }
        Answer::Invalid { status } => {
            lines.push(format!("stored, but {}", shown(status)));
            lines.extend(status.explain().map(|bit| format!("remedy: {}", bit.remedy)));
        }
        Answer::Refused { status } => lines.push(format!("refused: {}", shown(status))),
    }
    lines
}

impl InView {
    fn new(word: InWord, models: &[Model]) -> Self {
        let judged: Vec<_> = models.iter().map(|model| Foreign::judge(word, *model).err()).collect();
        let foreign = judged.iter().all(Option::is_some);
        let pending = |error| if error { "an error is pending" } else { "no error is pending" }.to_owned();
        let mut remarks = Vec::new();
        let mut told = false;
        if foreign {
            let (remark, all_told) = no_sender(&judged, models);
            told = all_told;
            remarks.push(remark);
        }
        if word.error_bit() {
            remarks.extend(error_advice(word).map(str::to_owned));
        }
        let reply = match word.decode() {
            In::Position { .. } | In::Foreign(_) => {
                let value = word::DATA.of(word.0);
                let zero = |field: word::Field| if_set(field.of(word.0) != 0, "always 0 in normal mode");
                let notes = [
                    zero(word::READ_WRITE_BIT),
                    pending(word.error_bit()),
                    zero(word::RESERVE_BIT),
                    zero(word::SERVICE),
                    value.to_string(),
                ];
                let position = (!foreign).then(|| Position::new(value, models));
                let meaning = if foreign { "not a position".to_owned() } else { format!("position {value}") };
                let bits = Bits::new(word.0, notes);
                return Self { meaning, bits, position, status: None, foreign, models: Vec::new(), remarks };
            }
            In::Reply(reply) => reply,
        };
        let notes = [
            explain::access(reply.access).to_owned(),
            pending(reply.error),
            if_set(reply.reserve, "always 0"),
            service_note(reply.service),
            reply.data.to_string(),
        ];
        let is_status =
            reply.service == ServiceNumber::Known(Service::DataCheck) && reply.access == Access::Read;
        let status = is_status.then(|| StatusView::new(ErrorStatus::from_bits_retain(reply.data as u16)));
        Self {
            meaning: format!("reply: {}", Deed::answered(reply)),
            bits: Bits::new(word.0, notes),
            position: None,
            status,
            foreign,
            models: models
                .iter()
                .zip(judged)
                .map(|(model, why)| InModel::new(reply, *model, why))
                .map(|model| if told { model } else { model.with_reason() })
                .collect(),
            remarks,
        }
    }
}

/// That nobody sends a word, and whether with that the reasons of all models are told: if they are one.
fn no_sender(judged: &[Option<Foreign>], models: &[Model]) -> (String, bool) {
    let sender = match models {
        [model] => model.name(),
        _ => "encoder",
    };
    let mut reasons = judged.iter().flatten().map(Foreign::to_string);
    let first = reasons.next().unwrap_or_default();
    // Reasons that differ stand with their models.
    let told = reasons.all(|reason| reason == first);
    (format!("no {sender} sends this{}", if_set(told, &format!(": {first}"))), told)
}

/// What to do about an error bit.
fn error_advice(word: InWord) -> [&'static str; 2] {
    let next = match word.decode() {
        In::Reply(ServiceFields {
            service: ServiceNumber::Known(Service::DataCheck),
            access: Access::Read,
            ..
        }) => "the error remains: correct it, then repeat the data check (88000000)",
        _ => "a data check (88000000) tells the error and clears the error bit",
    };
    ["error bit 1: make the machine safe first, e.g. stop the axis", next]
}

impl InModel {
    fn new(reply: ServiceFields, model: Model, foreign: Option<Foreign>) -> Self {
        // Only what was carried out is a value of the service; a refused read says nothing.
        let refused = reply.access == Access::Read && Answer::to(reply, model).sets_error_bit();
        let carries = if refused { Carries::Nothing } else { Carries::Value };
        let mut data = DataView::new(reply, model, carries);
        if !data.knows_service {
            data.text.push("does not have this service".to_owned());
        }
        Self { data, foreign: foreign.map(|foreign| foreign.to_string()) }
    }

    /// With the reason why it is not from this model, which does not stand with the word.
    fn with_reason(mut self) -> Self {
        self.data.text.extend(self.foreign.iter().map(|reason| format!("does not send this: {reason}")));
        self
    }
}

impl Position {
    fn new(value: u32, models: &[Model]) -> Self {
        let gray_models: Vec<Model> =
            models.iter().copied().filter(|model| model.position_may_be_gray()).collect();
        let gray = (!gray_models.is_empty()).then(|| gray::decode(value));
        Self {
            gray_models,
            value,
            hex: format!("{value:06X}"),
            from_gray: gray,
            from_gray_hex: gray.map(|value| format!("{value:06X}")),
        }
    }
}

impl StatusView {
    fn new(status: ErrorStatus) -> Self {
        Self { hex: format!("{:04X}", status.bits()), bits: BitView::of(status) }
    }
}

/// `2^2, 2^7`
fn powers(status: ErrorStatus) -> String {
    status.explain().map(|entry| format!("2^{}", entry.bit)).collect::<Vec<_>>().join(", ")
}

impl DataView {
    fn new(fields: ServiceFields, model: Model, carries: Carries) -> Self {
        let has_data = carries == Carries::Value;
        let ServiceNumber::Known(service) = fields.service else {
            return Self {
                model: model.name(),
                knows_service: false,
                range: None,
                bytes: Vec::new(),
                text: Vec::new(),
            };
        };
        let mut view = Self {
            model: model.name(),
            knows_service: service.known_to(model),
            range: None,
            bytes: Vec::new(),
            text: Vec::new(),
        };
        let Some(legal) = Legal::of(service, model) else { return view };
        match legal {
            Legal::Whole { low, high } => {
                view.range = Some(RangeView { low, high, up_to_measuring_length: false });
                view.text.push(format!("range {legal}"));
                if has_data && service == Service::CountingDirection && fields.data <= high {
                    let direction = CountingDirection::from_data(fields.data).direction;
                    view.text.push(format!("{}: {:#}", fields.data, DirectionMeaning { direction, model }));
                }
            }
            Legal::UpToMeasuringLength => {
                view.range = Some(RangeView { low: 0, high: word::DATA_MAX, up_to_measuring_length: true });
                view.text.push(format!("range {legal}"));
            }
            Legal::Bytes(bytes) => {
                for byte in bytes {
                    let ByteField { byte: number, name, low, high } = byte;
                    let value = byte.of(fields.data);
                    let meaning = if has_data {
                        ByteMeaning { service, byte, data: fields.data, model }.to_string()
                    } else {
                        String::new()
                    };
                    let line = match name {
                        None => "without meaning".to_owned(),
                        Some(name) if has_data => format!("{name} ({low:X}h..{high:X}h): {meaning}"),
                        Some(name) => format!("{name} ({low:X}h..{high:X}h)"),
                    };
                    let value_hex = if has_data { format!("  {value:02X}h") } else { String::new() };
                    view.text.push(format!("byte {number}{value_hex}  {line}"));
                    view.bytes.push(ByteView { byte: number, name, value, low, high, meaning });
                }
            }
        }
        view
    }
}
