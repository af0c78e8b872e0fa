//! A fault in a few signs, `KIND[=VALUE][:PLACE][@TIME][+TIME]`: events of a scenario without a file.

use std::fmt;
use std::str::FromStr;

use encoring_device::Surroundings;
use encoring_ring::ident::ENCODER;
use encoring_ring::slave::Jumper;
use encoring_words::{Duration, Instant};

use super::{Change, Chip, Event, Happening, Scenario};
use crate::fault::{Fault, digits};
use crate::span;

/// A fault with its place and its time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occurrence {
    /// What happens.
    pub fault: Fault,
    /// A segment or a ring position, as the fault is of a line or of a device.
    pub place: usize,
    /// When it begins.
    pub at: Instant,
    /// For how long; [`Occurrence::FOR_GOOD`] has no end.
    pub lasting: Duration,
}

impl Occurrence {
    /// What does not end.
    pub const FOR_GOOD: Duration = Duration(u64::MAX);

    /// What it is in a scenario: it begins, and at a device it ends with an event of its own.
    fn events(&self) -> Vec<Event> {
        let Self { fault, place, at, lasting } = *self;
        let Some((begins, ends)) = changes(fault) else {
            return vec![Event { at, what: Happening::Line { segment: place, fault, lasting } }];
        };
        let device =
            |at, change| Event { at, what: Happening::Device { position: place, changes: vec![change] } };
        let mut events = vec![device(at, begins)];
        if lasting != Self::FOR_GOOD {
            events.push(device(at + lasting, ends));
        }
        events
    }
}

/// What begins a fault at a device, and what ends it; `None` if it is one of a line.
fn changes(fault: Fault) -> Option<(Change, Change)> {
    Some(match fault {
        Fault::Supply => (Change::Supply(0), Change::Supply(Surroundings::default().supply_mv)),
        Fault::Chip => (Change::Chip(Chip::Held), Change::Chip(Chip::Running)),
        Fault::Jumper => (Change::Jumper(Jumper::Open), Change::Jumper(Jumper::Closed)),
        Fault::Ident(ident) => (Change::Ident(ident), Change::Ident(ENCODER)),
        Fault::Ssi(trouble) => (Change::SsiTrouble(Some(trouble)), Change::SsiTrouble(None)),
        _ => return None,
    })
}

impl Scenario {
    /// Adds a fault, behind what happens at the same time.
    ///
    /// # Errors
    /// What is wrong, with value and limit; then nothing is added.
    pub fn add(&mut self, occurrence: &Occurrence) -> Result<(), String> {
        let Occurrence { fault, place, .. } = *occurrence;
        let encoders = self.devices.len();
        if fault.is_of_line() && place > encoders {
            return Err(format!("segment {place}; the segments are 0 to {encoders}"));
        }
        if !fault.is_of_line() && place >= encoders {
            return Err(format!("position {place}; the positions are 0 to {}", encoders.saturating_sub(1)));
        }
        if fault.on_ssi().is_some() {
            self.has_ssi(place)?;
        }
        let events = occurrence.events();
        // A ring has one troubled segment at a time; a second one would quietly end the first.
        for (_, from, to) in events.iter().filter_map(troubled) {
            let other = self.events.iter().filter_map(troubled).find(|(_, f, t)| *f < to && from < *t);
            if let Some((segment, ..)) = other {
                return Err(format!(
                    "segment {segment} is troubled at that time; a ring has one such at a time"
                ));
            }
        }
        self.events.extend(events);
        self.events.sort_by_key(|event| event.at);
        Ok(())
    }
}

/// Which segment an event troubles, from when to when.
fn troubled(event: &Event) -> Option<(usize, Instant, Instant)> {
    match event.what {
        Happening::Line { segment, lasting, .. } => Some((segment, event.at, event.at + lasting)),
        Happening::Device { .. } => None,
    }
}

impl fmt::Display for Occurrence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.fault, self.place)?;
        if self.at > Instant::ZERO {
            write!(f, "@{}", span::written(self.at.since(Instant::ZERO)))?;
        }
        if self.lasting != Self::FOR_GOOD {
            write!(f, "+{}", span::written(self.lasting))?;
        }
        Ok(())
    }
}

impl FromStr for Occurrence {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // From behind: each part ends where the next one begins.
        let (rest, lasting) = cut(text, '+');
        let (rest, at) = cut(rest, '@');
        let (rest, place) = cut(rest, ':');
        let fault = rest.parse()?;
        let place = match place {
            None => 0,
            Some(place) => digits(place)
                .ok_or_else(|| format!("place \"{place}\" behind the colon; a whole number from 0"))?,
        };
        let time = |sign, text| {
            span::read(text).map_err(|problem| format!("time \"{text}\" behind {sign}: {problem}"))
        };
        let at = match at {
            None | Some("0") => Instant::ZERO,
            Some(at) => Instant::ZERO + time('@', at)?,
        };
        let lasting = lasting.map(|lasting| time('+', lasting)).transpose()?;
        Ok(Self { fault, place, at, lasting: lasting.unwrap_or(Self::FOR_GOOD) })
    }
}

/// What stands before and behind a sign.
fn cut(text: &str, sign: char) -> (&str, Option<&str>) {
    match text.rsplit_once(sign) {
        Some((before, behind)) => (before, Some(behind)),
        None => (text, None),
    }
}

#[cfg(test)]
mod tests {
    use encoring_ring::Ident;
    use proptest::prelude::*;

    use super::*;

    fn refused(text: &str) -> String {
        text.parse::<Occurrence>().unwrap_err()
    }

    #[test]
    fn a_fault_is_a_kind_and_where_when_and_for_how_long() {
        let occurrence: Occurrence = "flips=20:1@2s+100ms".parse().unwrap();
        let (at, lasting) = (Instant(2_000_000_000), Duration::from_millis(100));
        assert_eq!(occurrence, Occurrence { fault: Fault::Flips(20), place: 1, at, lasting });
        let occurrence: Occurrence = "supply".parse().unwrap();
        let (at, lasting) = (Instant::ZERO, Occurrence::FOR_GOOD);
        assert_eq!(occurrence, Occurrence { fault: Fault::Supply, place: 0, at, lasting });
        assert_eq!("ident=0303:2@0".parse::<Occurrence>().unwrap().fault, Fault::Ident(Ident(0x0303)));
    }

    #[test]
    fn what_is_no_fault_is_told_with_what_is_allowed() {
        assert!(refused("flip:1").starts_with("kind \"flip\"; the kinds are bad, silent, "));
        assert_eq!(refused("bad:x"), "place \"x\" behind the colon; a whole number from 0");
        assert_eq!(refused("bad:-1"), "place \"-1\" behind the colon; a whole number from 0");
        assert_eq!(
            refused("flips=0:1"),
            "value \"0\" for flips; write flips=N with N from 1 to 1000000, bits of a million"
        );
        assert_eq!(refused("bad+0"), "time \"0\" behind +: a time is longer than 0");
        assert!(refused("bad@soon").starts_with("time \"soon\" behind @: "));
    }

    #[test]
    fn what_a_device_suffers_ends_with_its_time() {
        let mut scenario = Scenario::built_in().unwrap();
        let before = scenario.events.len();
        scenario.add(&"supply:1@1+2".parse().unwrap()).unwrap();
        let added: Vec<_> = scenario.events.iter().skip(before).map(|event| event.at.as_nanos()).collect();
        assert_eq!(added, [1_000_000_000, 3_000_000_000]);
    }

    #[test]
    fn what_is_of_a_device_and_nothing_else_has_changes() {
        for (fault, form, _) in Fault::kinds() {
            assert_eq!(changes(fault).is_none(), fault.is_of_line(), "{form}");
        }
    }

    proptest! {
        #[test]
        fn what_is_written_reads_as_the_same_occurrence(
            kind in 0..Fault::kinds().count(),
            value in 1..=1_000_000_u32,
            place in 0..1_000_usize,
            at in any::<u64>(),
            lasting in 1..=u64::MAX,
        ) {
            let (sample, form, _) = Fault::kinds().nth(kind).unwrap();
            let name = form.split('=').next().unwrap();
            let fault = match form.split_once('=') {
                None => sample,
                Some((_, "N")) => format!("{name}={value}").parse().unwrap(),
                Some(_) => Fault::Ident(Ident(value as u16)),
            };
            let occurrence = Occurrence { fault, place, at: Instant(at), lasting: Duration(lasting) };
            prop_assert_eq!(occurrence.to_string().parse(), Ok(occurrence));
        }
    }
}
