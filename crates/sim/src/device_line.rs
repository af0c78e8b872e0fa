//! The `# device` line of a recording: an encoder and its memory as words of text, there and back.
//!
//! | setting | holds | without it |
//! |---|---|---|
//! | `native` | steps per turn, rotary models only | 4096 |
//! | `rod_um` | rod length in micrometres, LA-66 only | refused |
//! | `firmware` | week, like `41/1997` | `41/1997` |
//! | `service_times` | `READ/WRITE/CHECK/PRESET` in nanoseconds | the default service times |
//! | `zero_loss` | `nearest` or `worst` | `nearest` |
//! | `stale_service` | `ignored` or `executed` | `ignored` |
//!
//! [`to_device`] writes every setting that fits the model, but `stale_service` only where it is `executed`.

use encoring_encoder::records::EEPROM_BYTES;
use encoring_encoder::unit::NoStaleService;
use encoring_encoder::{ServiceTimes, StaleService, Unit, ZeroLoss};
use encoring_trace::DeviceLine;
use encoring_words::model::{Sensor, SensorError, SensorKind, UnknownModel};
use encoring_words::week::NotAWeek;
use encoring_words::{Duration, Model};

use crate::memory::Eeprom;

const NATIVE: &str = "native";
const ROD_UM: &str = "rod_um";
const FIRMWARE: &str = "firmware";
const SERVICE_TIMES: &str = "service_times";
const ZERO_LOSS: &str = "zero_loss";
const STALE_SERVICE: &str = "stale_service";

/// Why a device line describes no encoder.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The model is none of the three.
    #[error("model {model:?}: {reason}")]
    Model {
        /// What stands there.
        model: String,
        /// What is known.
        reason: UnknownModel,
    },
    /// A setting has no such value.
    #[error("setting {key}: {value:?} is not {allowed}")]
    Value {
        /// The setting.
        key: &'static str,
        /// What stands there.
        value: String,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The firmware is not given as a week.
    #[error("setting firmware: {value:?}: {reason}")]
    Firmware {
        /// What stands there.
        value: String,
        /// How a week is written.
        reason: NotAWeek,
    },
    /// There is no such setting.
    #[error(
        "unknown setting {key:?}, the settings are native, rod_um, firmware, service_times, zero_loss, stale_service"
    )]
    Unknown {
        /// What stands there.
        key: String,
    },
    /// A rod has no usual length.
    #[error("setting rod_um is missing, a {model} has no usual rod length")]
    NoRod {
        /// The model.
        model: Model,
    },
    /// The parts do not fit together.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// The memory image is not that of an encoder.
    #[error("the memory image has {found} bytes, an encoder has {EEPROM_BYTES}")]
    Memory {
        /// Its bytes.
        found: usize,
    },
}

/// The device line of an encoder at a ring position.
#[must_use]
pub fn to_device(position: u8, unit: &Unit, memory: &Eeprom) -> DeviceLine {
    let sensor = match unit.sensor() {
        Sensor::Rotary { steps_per_turn } => (NATIVE, steps_per_turn.to_string()),
        Sensor::Linear { rod_um } => (ROD_UM, rod_um.to_string()),
    };
    let ServiceTimes { read, write, data_check, preset_adjustment } = unit.service_times;
    let times = [read, write, data_check, preset_adjustment].map(|time| time.as_nanos().to_string());
    let settings = [
        sensor,
        (FIRMWARE, unit.firmware.to_string()),
        (SERVICE_TIMES, times.join("/")),
        (ZERO_LOSS, zero_loss_name(unit.zero_loss).to_owned()),
    ];
    let executed = (unit.stale_service == StaleService::Executed)
        .then(|| (STALE_SERVICE.to_owned(), unit.stale_service.to_string()));
    DeviceLine {
        line: 0,
        position,
        model: unit.model().name().to_owned(),
        settings: settings.map(|(key, value)| (key.to_owned(), value)).into_iter().chain(executed).collect(),
        memory: memory.image().to_vec(),
    }
}

/// The encoder and the memory of a device line.
///
/// # Errors
/// [`Error`] with what is wrong; the line itself is [`DeviceLine::line`].
pub fn from_device(device: &DeviceLine) -> Result<(Unit, Eeprom), Error> {
    let model: Model =
        device.model.parse().map_err(|reason| Error::Model { model: device.model.clone(), reason })?;
    let mut native = None;
    let mut rod_um = None;
    let mut firmware = None;
    let mut times = None;
    let mut zero_loss = None;
    let mut stale_service = None;
    for (key, value) in &device.settings {
        match key.as_str() {
            NATIVE => native = Some(number(NATIVE, value)?),
            ROD_UM => rod_um = Some(number(ROD_UM, value)?),
            FIRMWARE => {
                let week = value.parse().map_err(|reason| Error::Firmware { value: value.clone(), reason });
                firmware = Some(week?);
            }
            SERVICE_TIMES => times = Some(service_times(value)?),
            ZERO_LOSS => zero_loss = Some(zero_loss_named(value)?),
            STALE_SERVICE => stale_service = Some(stale_service_named(value)?),
            _ => return Err(Error::Unknown { key: key.clone() }),
        }
    }
    if model.sensor_kind() == SensorKind::Linear && (native, rod_um) == (None, None) {
        return Err(Error::NoRod { model });
    }
    let mut unit = Unit::new(model, model.sensor(native, rod_um)?)?;
    unit.firmware = firmware.unwrap_or(unit.firmware);
    unit.service_times = times.unwrap_or(unit.service_times);
    unit.zero_loss = zero_loss.unwrap_or(unit.zero_loss);
    unit.stale_service = stale_service.unwrap_or(unit.stale_service);
    let image = <[u8; EEPROM_BYTES]>::try_from(device.memory.as_slice());
    let image = image.map_err(|_| Error::Memory { found: device.memory.len() })?;
    Ok((unit, Eeprom::from_image(image)))
}

/// Digits and nothing else.
fn whole(text: &str) -> Option<u64> {
    if text.bytes().all(|byte| byte.is_ascii_digit()) { text.parse().ok() } else { None }
}

fn number(key: &'static str, value: &str) -> Result<u32, Error> {
    let number = whole(value).and_then(|number| u32::try_from(number).ok());
    number.ok_or_else(|| Error::Value {
        key,
        value: value.to_owned(),
        allowed: "a whole number below 4294967296",
    })
}

fn service_times(value: &str) -> Result<ServiceTimes, Error> {
    let mut times = value.split('/').map(|time| whole(time).map(Duration::from_nanos));
    let mut next = || times.next().flatten();
    if let (Some(read), Some(write), Some(data_check), Some(preset_adjustment)) =
        (next(), next(), next(), next())
        && times.next().is_none()
    {
        return Ok(ServiceTimes { read, write, data_check, preset_adjustment });
    }
    Err(Error::Value {
        key: SERVICE_TIMES,
        value: value.to_owned(),
        allowed: "READ/WRITE/CHECK/PRESET in nanoseconds, like 0/10000000/20000000/10000000",
    })
}

const fn zero_loss_name(zero_loss: ZeroLoss) -> &'static str {
    match zero_loss {
        ZeroLoss::Nearest => "nearest",
        ZeroLoss::WorstAllowed => "worst",
    }
}

fn zero_loss_named(value: &str) -> Result<ZeroLoss, Error> {
    let known = [ZeroLoss::Nearest, ZeroLoss::WorstAllowed];
    let found = known.into_iter().find(|zero_loss| zero_loss_name(*zero_loss) == value);
    found.ok_or_else(|| Error::Value { key: ZERO_LOSS, value: value.to_owned(), allowed: "nearest or worst" })
}

fn stale_service_named(value: &str) -> Result<StaleService, Error> {
    value.parse().map_err(|NoStaleService| Error::Value {
        key: STALE_SERVICE,
        value: value.to_owned(),
        allowed: "ignored or executed",
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use encoring_trace::{Reader, Writer};
    use encoring_words::Week;

    const Q4096: Sensor = Sensor::Rotary { steps_per_turn: 4096 };

    fn device(model: &str, settings: &[(&str, &str)]) -> DeviceLine {
        let own = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        DeviceLine {
            line: 2,
            position: 0,
            model: model.to_owned(),
            settings: settings.iter().map(own).collect(),
            memory: vec![0xFF; EEPROM_BYTES],
        }
    }

    fn refusal(model: &str, settings: &[(&str, &str)]) -> String {
        from_device(&device(model, settings)).unwrap_err().to_string()
    }

    #[test]
    fn every_kind_of_encoder_comes_back_from_a_file() {
        let mut old = Unit::new(Model::Ce65M, Sensor::Rotary { steps_per_turn: 8192 }).unwrap();
        old.firmware = Week::new(40, 1997).unwrap();
        old.service_times = ServiceTimes::ZERO;
        old.zero_loss = ZeroLoss::WorstAllowed;
        old.stale_service = StaleService::Executed;
        let units = [
            old,
            Unit::new(Model::Ce100M, Q4096).unwrap(),
            Unit::new(Model::La66, Sensor::Linear { rod_um: 500_000 }).unwrap(),
        ];
        let memory = Eeprom::from_image(std::array::from_fn(|byte| byte as u8));
        let devices: Vec<DeviceLine> =
            (0..).zip(&units).map(|(at, unit)| to_device(at, unit, &memory)).collect();
        let file = Writer::recording(Vec::new(), &devices).unwrap().into_inner();
        let reader = Reader::new("units.csv", file.as_slice()).unwrap();
        let read: Vec<_> = reader.recording().unwrap().devices.iter().map(from_device).collect();
        assert_eq!(read, units.map(|unit| Ok((unit, memory.clone()))));
    }

    #[test]
    fn the_line_is_as_documented() {
        let unit = Unit::new(Model::Ce100M, Q4096).unwrap();
        let line = to_device(3, &unit, &Eeprom::blank()).to_string();
        let (line, memory) = line.split_once(" memory=").unwrap();
        assert_eq!(
            line,
            "# device 3 ce-100-m native=4096 firmware=41/1997 \
             service_times=0/10000000/20000000/10000000 zero_loss=nearest"
        );
        assert_eq!(memory, "FF".repeat(EEPROM_BYTES));
        let mut executes = unit;
        executes.stale_service = StaleService::Executed;
        let line = to_device(3, &executes, &Eeprom::blank()).to_string();
        assert!(line.contains(" zero_loss=nearest stale_service=executed memory="), "{line}");
    }

    #[test]
    fn what_is_left_out_is_as_a_new_encoder_has_it() {
        let unit = Unit::new(Model::Ce65M, Q4096).unwrap();
        assert_eq!(from_device(&device("ce-65-m", &[])), Ok((unit, Eeprom::blank())));
    }

    #[test]
    fn what_describes_no_encoder_is_refused_with_its_value_and_the_limit() {
        assert_eq!(refusal("ce-58", &[]), "model \"ce-58\": the models are la-66, ce-100-m and ce-65-m");
        assert_eq!(refusal("la-66", &[]), "setting rod_um is missing, a la-66 has no usual rod length");
        assert_eq!(
            refusal("la-66", &[("rod_um", "5")]),
            "a rod of 5 um; the limits are 10 um and 167772150 um"
        );
        assert_eq!(refusal("la-66", &[("native", "4096")]), "a la-66 has a rod length, no steps per turn");
        assert_eq!(refusal("ce-65-m", &[("rod_um", "5000")]), "a ce-65-m has steps per turn, no rod length");
        assert_eq!(refusal("ce-100-m", &[("native", "8192")]), "8192 steps per turn; a ce-100-m has 4096");
        for wrong in ["", "+4096", "4096.0", "4294967296"] {
            assert_eq!(
                refusal("ce-65-m", &[("native", wrong)]),
                format!("setting native: {wrong:?} is not a whole number below 4294967296")
            );
        }
        assert_eq!(
            refusal("ce-65-m", &[("firmware", "41/97")]),
            "setting firmware: \"41/97\": a firmware week is written WW/YYYY, from 1/1990 to 53/2099, like 41/1997"
        );
        for wrong in ["", "0/0/0", "0/0/0/0/0", "0/0/0/x", "-1/0/0/0"] {
            assert_eq!(
                refusal("ce-65-m", &[("service_times", wrong)]),
                format!(
                    "setting service_times: {wrong:?} is not READ/WRITE/CHECK/PRESET in nanoseconds, like \
                     0/10000000/20000000/10000000"
                )
            );
        }
        assert_eq!(
            refusal("ce-65-m", &[("zero_loss", "best")]),
            "setting zero_loss: \"best\" is not nearest or worst"
        );
        assert_eq!(
            refusal("ce-65-m", &[("stale_service", "done")]),
            "setting stale_service: \"done\" is not ignored or executed"
        );
        assert!(refusal("ce-65-m", &[("colour", "red")]).starts_with("unknown setting \"colour\""));
        let mut short = device("ce-65-m", &[]);
        short.memory.pop();
        assert_eq!(
            from_device(&short).unwrap_err().to_string(),
            "the memory image has 511 bytes, an encoder has 512"
        );
    }
}
