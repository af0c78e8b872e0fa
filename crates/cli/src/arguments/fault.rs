//! A fault in a few signs: `KIND[=VALUE][:PLACE][@TIME][+TIME]`, an event of a scenario without a file.

use std::str::FromStr;

use clap::Args;
use encoring_ring::Ident;
use encoring_ring::ident::ENCODER;
use encoring_ring::slave::Jumper;
use encoring_sim::fault::PER_MILLION;
use encoring_sim::scenario::{Change, Chip, Event, Happening, LineFault};
use encoring_sim::{Level, Scenario};
use encoring_words::{Duration, Instant};

use super::span;
use crate::output::{Failure, bad_input};

const KINDS: &str =
    "bad, silent, low, high, flips=N, bursts=N, jitter=N, lost=N, supply, chip, jumper, ident=HHHH";

/// The supply when it is back.
const SUPPLY_MV: u32 = 24_000;

/// Faults beside those of the scenario.
#[derive(Args, Debug, Clone)]
pub(crate) struct Faults {
    /// On a simulated ring, a fault beside what the scenario has; may be repeated. `encoring sim --help` has the kinds
    #[arg(long = "fault", value_name = "FAULT")]
    pub(crate) faults: Vec<FaultArgument>,
}

/// A fault as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FaultArgument {
    text: String,
    kind: Kind,
    place: usize,
    at: Duration,
    lasting: Option<Duration>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Line(LineFault),
    Supply,
    Chip,
    Jumper,
    Ident(Ident),
}

impl Kind {
    /// What the word level would not show as it was asked for.
    const fn needs_bits(self) -> bool {
        !matches!(
            self,
            Self::Line(LineFault::Bad | LineFault::Silent) | Self::Supply | Self::Chip | Self::Jumper
        )
    }

    /// What begins it at a device, and what ends it.
    const fn changes(self) -> Option<(Change, Change)> {
        Some(match self {
            Self::Line(_) => return None,
            Self::Supply => (Change::Supply(0), Change::Supply(SUPPLY_MV)),
            Self::Chip => (Change::Chip(Chip::Held), Change::Chip(Chip::Running)),
            Self::Jumper => (Change::Jumper(Jumper::Open), Change::Jumper(Jumper::Closed)),
            Self::Ident(ident) => (Change::Ident(ident), Change::Ident(ENCODER)),
        })
    }
}

impl FromStr for FaultArgument {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // From behind: each part ends where the next one begins.
        let (rest, lasting) = cut(text, '+');
        let (rest, at) = cut(rest, '@');
        let (rest, place) = cut(rest, ':');
        let (name, value) = cut(rest, '=');
        let kind = kind(name, value)?;
        let place = match place {
            None => 0,
            Some(place) => digits(place)
                .ok_or_else(|| format!("place \"{place}\" behind the colon; a whole number from 0"))?,
        };
        let at = match at {
            None | Some("0") => Duration::ZERO,
            Some(at) => span(at).map_err(|problem| format!("time \"{at}\" behind @: {problem}"))?,
        };
        let time =
            |lasting| span(lasting).map_err(|problem| format!("time \"{lasting}\" behind +: {problem}"));
        Ok(Self { text: text.to_owned(), kind, place, at, lasting: lasting.map(time).transpose()? })
    }
}

/// What stands before and behind a sign.
fn cut(text: &str, sign: char) -> (&str, Option<&str>) {
    match text.rsplit_once(sign) {
        Some((before, behind)) => (before, Some(behind)),
        None => (text, None),
    }
}

fn digits<N: FromStr>(text: &str) -> Option<N> {
    let all = !text.is_empty() && text.bytes().all(|digit| digit.is_ascii_digit());
    if all { text.parse().ok() } else { None }
}

fn kind(name: &str, value: Option<&str>) -> Result<Kind, String> {
    let rate = |fault: fn(u32) -> LineFault| {
        let rate = value.and_then(digits).filter(|rate| (1..=PER_MILLION).contains(rate));
        let wrong = || {
            let given = value.map_or_else(|| "no value".to_owned(), |value| format!("value \"{value}\""));
            format!("{given} for {name}; write {name}=N with N from 1 to {PER_MILLION}, bits of a million")
        };
        rate.map(|rate| Kind::Line(fault(rate))).ok_or_else(wrong)
    };
    let kind = match name {
        "flips" => return rate(LineFault::Flips),
        "bursts" => return rate(LineFault::Bursts),
        "jitter" => return rate(LineFault::Jitter),
        "lost" => return rate(LineFault::Lost),
        "ident" => {
            let word = value.filter(|word| word.len() == 4 && word.bytes().all(|c| c.is_ascii_hexdigit()));
            let ident = word.and_then(|word| u16::from_str_radix(word, 16).ok());
            let wrong = || "ident takes an identification word of 4 hex digits, as ident=0303".to_owned();
            return ident.map(|ident| Kind::Ident(Ident(ident))).ok_or_else(wrong);
        }
        "bad" => Kind::Line(LineFault::Bad),
        "silent" => Kind::Line(LineFault::Silent),
        "low" => Kind::Line(LineFault::Low),
        "high" => Kind::Line(LineFault::High),
        "supply" => Kind::Supply,
        "chip" => Kind::Chip,
        "jumper" => Kind::Jumper,
        _ => return Err(format!("kind \"{name}\"; the kinds are {KINDS}")),
    };
    match value {
        Some(value) => Err(format!("value \"{value}\" for {name}, which takes none")),
        None => Ok(kind),
    }
}

impl FaultArgument {
    fn ends(&self) -> Option<Instant> {
        let lasting = self.lasting?;
        Some(Instant::ZERO + Duration(self.at.as_nanos().saturating_add(lasting.as_nanos())))
    }

    fn events(&self, scenario: &Scenario) -> Result<Vec<Event>, String> {
        let at = Instant::ZERO + self.at;
        let encoders = scenario.devices.len();
        if self.kind.needs_bits() && scenario.level == Level::Word {
            return Err("the word level does not have it; give --level bit".to_owned());
        }
        let Some((begin, end)) = self.kind.changes() else {
            let Kind::Line(fault) = self.kind else { return Ok(Vec::new()) };
            if self.place > encoders {
                return Err(format!("segment {}; the segments are 0 to {encoders}", self.place));
            }
            let lasting = self.lasting.unwrap_or(Duration(u64::MAX));
            return Ok(vec![Event { at, what: Happening::Line { segment: self.place, fault, lasting } }]);
        };
        if self.place >= encoders {
            let last = encoders.saturating_sub(1);
            return Err(format!("position {}; the positions are 0 to {last}", self.place));
        }
        let device = |at, change| Event {
            at,
            what: Happening::Device { position: self.place, changes: vec![change] },
        };
        let mut events = vec![device(at, begin)];
        events.extend(self.ends().map(|ends| device(ends, end)));
        Ok(events)
    }
}

/// Adds faults to a scenario, in their order of time and behind what it has at the same time.
pub(crate) fn add(faults: &Faults, scenario: &mut Scenario) -> Result<(), Failure> {
    let problem =
        |fault: &FaultArgument, problem: String| bad_input(format!("--fault {}: {problem}", fault.text));
    for fault in &faults.faults {
        let events = fault.events(scenario).map_err(|why| problem(fault, why))?;
        // A ring has one troubled segment at a time; a second one would quietly end the first.
        let of_line = |event: &Event| match event.what {
            Happening::Line { segment, lasting, .. } => {
                Some((segment, event.at, Instant(event.at.as_nanos().saturating_add(lasting.as_nanos()))))
            }
            Happening::Device { .. } => None,
        };
        for (_, from, to) in events.iter().filter_map(of_line) {
            let other = scenario.events.iter().filter_map(of_line).find(|(_, f, t)| *f < to && from < *t);
            if let Some((segment, ..)) = other {
                let why =
                    format!("segment {segment} is troubled at that time; a ring has one such at a time");
                return Err(problem(fault, why));
            }
        }
        scenario.events.extend(events);
    }
    scenario.events.sort_by_key(|event| event.at);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(text: &str) -> String {
        text.parse::<FaultArgument>().unwrap_err()
    }

    #[test]
    fn a_fault_is_a_kind_and_where_when_and_for_how_long() {
        let fault: FaultArgument = "flips=20:1@2s+100ms".parse().unwrap();
        assert_eq!(fault.kind, Kind::Line(LineFault::Flips(20)));
        assert_eq!((fault.place, fault.at), (1, Duration::from_millis(2_000)));
        assert_eq!(fault.lasting, Some(Duration::from_millis(100)));
        let fault: FaultArgument = "supply".parse().unwrap();
        assert_eq!((fault.place, fault.at, fault.lasting), (0, Duration::ZERO, None));
        assert_eq!("ident=0303:2@0".parse::<FaultArgument>().unwrap().kind, Kind::Ident(Ident(0x0303)));
    }

    #[test]
    fn what_is_no_fault_is_told_with_what_is_allowed() {
        assert_eq!(refused("flip:1"), format!("kind \"flip\"; the kinds are {KINDS}"));
        assert_eq!(refused(""), format!("kind \"\"; the kinds are {KINDS}"));
        assert_eq!(refused("bad:x"), "place \"x\" behind the colon; a whole number from 0");
        assert_eq!(refused("bad:-1"), "place \"-1\" behind the colon; a whole number from 0");
        assert_eq!(refused("bad=3"), "value \"3\" for bad, which takes none");
        assert_eq!(
            refused("flips=0:1"),
            "value \"0\" for flips; write flips=N with N from 1 to 1000000, bits of a million"
        );
        assert_eq!(
            refused("lost"),
            "no value for lost; write lost=N with N from 1 to 1000000, bits of a million"
        );
        assert_eq!(refused("ident=33"), "ident takes an identification word of 4 hex digits, as ident=0303");
        assert_eq!(refused("bad+0"), "time \"0\" behind +: no time at all");
        assert!(refused("bad@soon").starts_with("time \"soon\" behind @: "));
    }

    #[test]
    fn what_a_device_suffers_ends_with_its_time() {
        let mut scenario = Scenario::built_in().unwrap();
        let before = scenario.events.len();
        add(&Faults { faults: vec!["supply:1@1+2".parse().unwrap()] }, &mut scenario).unwrap();
        let added: Vec<_> = scenario.events.iter().skip(before).map(|event| event.at.as_nanos()).collect();
        assert_eq!(added, [1_000_000_000, 3_000_000_000]);
    }
}
