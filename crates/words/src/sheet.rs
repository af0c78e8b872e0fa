//! The data sheets: what the manuals state of pins, lamps, supply, lines and mechanics, and nothing where a manual
//! is silent [R12].

use crate::ssi_frame::{CLOCK_HZ, CLOCK_HZ_LIMIT};
use crate::time::Duration;

/// What a manual states about its device. `None` where it says nothing; a sibling's figure is never filled in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DataSheet {
    /// Number and date of the manual.
    pub document: &'static str,
    /// Ident code on the ring [R2].
    pub ident_code: u8,
    /// Words in each direction [R3].
    pub words: u8,
    /// Refresh of the position [R8, R9].
    pub refresh: Option<Duration>,
    /// Transfer rate in kBaud, gross and net [R7].
    pub kilobaud: Option<(u16, u16)>,
    /// What the interface is electrically [R10].
    pub interface: Option<&'static str>,
    /// Supply, the ripple and the current it draws [R121, R122].
    pub supply: Option<Supply>,
    /// Thresholds of the preset inputs [R71].
    pub preset_input: Option<PresetInputLevels>,
    /// The SSI output [R103..R105].
    pub ssi: Option<SsiSheet>,
    /// Levels of its signals, whether a pin has them or not [R129, C27].
    pub signals: &'static [SignalLevels],
    /// Temperatures in degrees Celsius [R123].
    pub temperature: Option<Temperatures>,
    /// Mechanical limits [R124..R128].
    pub mechanics: Option<Mechanics>,
    /// Connectors with their pins [R131..R136].
    pub connectors: &'static [Connector],
    /// The two pins that a plug must join so that the next device is found [R137, C33].
    pub next_device_jumper: Option<(&'static str, u8, u8)>,
    /// Lamps: name, colour, meaning [R139, C34].
    pub lamps: &'static [(&'static str, &'static str, &'static str)],
}

/// The supply of an encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Supply {
    /// Lowest and highest voltage in millivolts.
    pub millivolts: (u32, u32),
    /// Residual ripple in per cent, both ways.
    pub ripple_percent: u8,
    /// Largest current in milliamperes at the lowest and at the highest voltage.
    pub milliamperes: Option<(u16, u16)>,
}

/// What counts as 0 and as 1 on a preset input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PresetInputLevels {
    /// Below this many millivolts: 0.
    pub low_below_mv: u32,
    /// Above this many millivolts: 1.
    pub high_above_mv: u32,
    /// Not to be exceeded, in millivolts.
    pub max_mv: u32,
}

/// The SSI output's figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SsiSheet {
    /// Clock rate in hertz, guaranteed from..to.
    pub clock_hz: (u32, u32),
    /// Clock rate in hertz, physically possible from..to, approximately [R111, R112].
    pub clock_hz_limit: (u32, u32),
    /// Clock input.
    pub clock_input: &'static str,
    /// Data output.
    pub data_output: &'static str,
}

/// The levels of a kind of signal, as the manual lists them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignalLevels {
    /// Its name, as the pins use it.
    pub name: &'static str,
    /// Below this many millivolts: 0.
    pub low_below_mv: Option<u32>,
    /// Above this many millivolts: 1.
    pub high_above_mv: Option<u32>,
    /// Not to be exceeded in either direction, in millivolts.
    pub max_mv: Option<u32>,
    /// Its resistance in ohms.
    pub ohms: Option<u32>,
    /// The largest current of an output in milliamperes.
    pub milliamperes: Option<u16>,
    /// What else is said of it.
    pub remark: &'static str,
}

/// Temperatures in degrees Celsius.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Temperatures {
    /// Operating from..to.
    pub operating: (i8, i8),
    /// Storage from..to.
    pub storage: (i8, i8),
}

/// Mechanical limits of a rotary encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mechanics {
    /// Permissible speed in revolutions per minute.
    pub speed_rpm: u32,
    /// Largest angular acceleration in rad/s^2.
    pub acceleration_rad_s2: u32,
    /// Shaft load in newtons, axial and radial, at the end of the shaft.
    pub shaft_load_n: (u16, u16),
    /// Least bearing life in revolutions, at 3000 rpm, 20 N axial, 30 N radial, 60 degrees.
    pub bearing_life_revolutions: u64,
    /// Moment of inertia in 10^-9 kg m^2.
    pub inertia_e9_kg_m2: u32,
    /// Starting torque at 20 degrees, in newton centimetres.
    pub starting_torque_ncm: u8,
    /// Vibration from 50 to 2000 Hz, in m/s^2.
    pub vibration_m_s2: u16,
    /// Shock of 11 ms, in m/s^2.
    pub shock_m_s2: u16,
}

/// A connector and its pins, counted from 1; an empty name is a free pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Connector {
    /// Name and kind.
    pub name: &'static str,
    /// Signals by pin.
    pub pins: &'static [&'static str],
}

pub(crate) static LA_66: DataSheet = DataSheet {
    document: "TR-ELA-TI-GB-0001-02, 04/04/2016",
    ident_code: 51,
    words: 2,
    refresh: None,
    kilobaud: None,
    interface: None,
    supply: None,
    preset_input: None,
    ssi: None,
    signals: &[],
    temperature: None,
    mechanics: None,
    connectors: &[],
    next_device_jumper: None,
    lamps: &[],
};

/// The levels of the CE-100 [R71], which are assumed of every other preset input too: the LA-66's manual gives none.
pub const PRESET_INPUT: PresetInputLevels =
    PresetInputLevels { low_below_mv: 8_000, high_above_mv: 11_000, max_mv: 30_000 };

const RS422: &str = "two-wire remote bus, RS422, galvanically isolated";

pub(crate) static CE_100_M: DataSheet = DataSheet {
    document: "TR-ECE-TI-D-0001-03, 14.05.1996",
    ident_code: 51,
    words: 2,
    refresh: Some(Duration::from_millis(1)),
    kilobaud: Some((500, 300)),
    interface: Some(RS422),
    supply: Some(Supply { millivolts: (11_000, 27_000), ripple_percent: 5, milliamperes: None }),
    preset_input: Some(PRESET_INPUT),
    ssi: None,
    signals: &[],
    temperature: None,
    mechanics: None,
    connectors: &[
        Connector {
            name: "REMOTE IN, 9-pin SUB-D plug",
            pins: &[
                "DO1",
                "DI1",
                "ground 1",
                "screen",
                "5 V, for tests",
                "DO1 inverted",
                "DI1 inverted",
                "",
                "",
            ],
        },
        Connector {
            name: "REMOTE OUT, 9-pin SUB-D socket",
            pins: &[
                "DO2",
                "DI2",
                "ground 2",
                "screen",
                "5 V, for tests",
                "DO2 inverted",
                "DI2 inverted",
                "",
                "RBST (a further participant follows)",
            ],
        },
        Connector {
            name: "supply and switching inputs, 15-pin SUB-D plug",
            pins: &[
                "",
                "",
                "",
                "",
                "preset 1",
                "preset 2",
                "",
                "",
                "",
                "",
                "",
                "screen",
                "",
                "US supply",
                "0 V",
            ],
        },
    ],
    // The manual names no jumper; the bridge is the convention of other vendors' plugs [C33].
    next_device_jumper: Some(("REMOTE OUT", 5, 9)),
    lamps: &[],
};

pub(crate) static CE_65_M: DataSheet = DataSheet {
    document: "TR-ECE-BA-GB-0007-03, 04/04/2016",
    ident_code: 51,
    words: 2,
    refresh: Some(Duration::from_micros(500)),
    kilobaud: Some((500, 300)),
    interface: Some(RS422),
    supply: Some(Supply { millivolts: (11_000, 27_000), ripple_percent: 5, milliamperes: Some((350, 150)) }),
    preset_input: None,
    ssi: Some(SsiSheet {
        clock_hz: CLOCK_HZ,
        clock_hz_limit: CLOCK_HZ_LIMIT,
        clock_input: "optocoupler",
        data_output: "RS422, two-wire",
    }),
    signals: &[
        SignalLevels {
            name: "US input",
            low_below_mv: Some(2_000),
            high_above_mv: Some(8_000),
            max_mv: Some(35_000),
            ohms: Some(5_000),
            milliamperes: None,
            remark: "",
        },
        SignalLevels {
            name: "TTL input",
            low_below_mv: Some(800),
            high_above_mv: Some(2_000),
            max_mv: Some(35_000),
            ohms: Some(5_000),
            milliamperes: None,
            remark: "",
        },
        SignalLevels {
            name: "TTL output",
            low_below_mv: Some(800),
            high_above_mv: Some(2_000),
            max_mv: None,
            ohms: None,
            milliamperes: Some(40),
            remark: "",
        },
        SignalLevels {
            name: "opto input",
            low_below_mv: None,
            high_above_mv: None,
            max_mv: None,
            ohms: None,
            milliamperes: None,
            remark: "optocoupler for a cable transmitter or a differential TTL signal",
        },
    ],
    temperature: Some(Temperatures { operating: (0, 60), storage: (-30, 80) }),
    mechanics: Some(Mechanics {
        speed_rpm: 6000,
        acceleration_rad_s2: 10_000,
        shaft_load_n: (40, 60),
        bearing_life_revolutions: 39_000_000_000,
        inertia_e9_kg_m2: 2_500,
        starting_torque_ncm: 2,
        vibration_m_s2: 100,
        shock_m_s2: 1_000,
    }),
    connectors: &[
        Connector {
            name: "X1, MINI-COMBICON 6-pin, REMOTE IN",
            pins: &[
                "DO inverted",
                "DO",
                "DI inverted",
                "DI",
                "GNDI (predecessor)",
                "opto input, negative SSI clock",
            ],
        },
        Connector {
            name: "X2, MINI-COMBICON 5-pin",
            pins: &[
                "opto input, positive SSI clock",
                "TTL output, negative SSI data",
                "TTL output, positive SSI data",
                "0 V",
                "US supply",
            ],
        },
        Connector {
            name: "X3, MINI-COMBICON 6-pin, REMOTE OUT",
            pins: &["DO inverted", "DO", "DI inverted", "DI", "GND (successor)", "RBST inverted"],
        },
    ],
    next_device_jumper: Some(("X3", 5, 6)),
    lamps: &[
        ("RD", "red", "the following bus interface is disconnected"),
        ("RC", "green", "remote bus check: the incoming bus is connected and not in reset"),
        ("U", "green", "supply voltage"),
        ("BA", "green", "bus active: data cycles arrive"),
    ],
};
