//! What a program does again and again, and what it leaves undone.

use super::rule::{AGAIN, CHECK_WITHIN, PRESET_AGAIN, READ_PAUSE, WRITE_PAUSE};
use super::{Access, Duration, HandshakeRule, InWord, Instant, Service, ServiceFields, ServiceNumber};
use encoring_words::word::DATA;

/// Services of the same kind, one after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Row {
    pub(super) first: Instant,
    pub(super) last: Instant,
    pub(super) count: u32,
}

impl Row {
    const NONE: Self = Self { first: Instant::ZERO, last: Instant::ZERO, count: 0 };

    fn another(&mut self, at: Instant, pause: Duration) {
        if self.count == 0 || at.since(self.last) > pause {
            *self = Self { first: at, last: at, count: 0 };
        }
        self.last = at;
        self.count = self.count.saturating_add(1);
    }
}

#[derive(Clone, Copy, Debug)]
struct Kept {
    reads: Row,
    changes: Row,
    equals: Row,
    value: Option<u32>,
}

/// What is known of the services that were carried out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Habits {
    kept: [Kept; 16],
    /// The service that was carried out last.
    latest: usize,
    /// The last write that was not checked yet, and when.
    unchecked: Option<(Service, Instant)>,
    programmed_length: Option<u32>,
    active_length: Option<u32>,
    preset: Option<(u32, Instant)>,
}

impl Habits {
    pub(super) const NEW: Self = Self {
        kept: [Kept { reads: Row::NONE, changes: Row::NONE, equals: Row::NONE, value: None }; 16],
        latest: 0,
        unchecked: None,
        programmed_length: None,
        active_length: None,
        preset: None,
    };

    /// Something may have happened that was not seen.
    pub(super) fn forget(&mut self) {
        (self.unchecked, self.preset) = (None, None);
        (self.programmed_length, self.active_length) = (None, None);
    }

    /// A service was replied to.
    pub(super) fn done(&mut self, at: Instant, fields: ServiceFields, reply: InWord) {
        let ServiceFields { service, access, data, .. } = fields;
        self.latest = usize::from(service.number());
        let ServiceNumber::Known(service) = service else { return };
        self.note_length(service, access, reply);
        let preset = service == Service::PresetAdjustment;
        let Some(kept) = self.kept.get_mut(self.latest) else { return };
        match access {
            Access::Read => kept.reads.another(at, READ_PAUSE),
            Access::Write if preset || service == Service::DataCheck => {}
            Access::Write => {
                self.unchecked = Some((service, at));
                match kept.value.replace(data) {
                    Some(before) if before == data => kept.equals.another(at, WRITE_PAUSE),
                    _ => kept.changes.another(at, WRITE_PAUSE),
                }
            }
        }
    }

    fn note_length(&mut self, service: Service, access: Access, reply: InWord) {
        let data = DATA.of(reply.0);
        match (service, access) {
            (Service::MeasuringLength, Access::Read) => self.programmed_length = Some(data),
            (Service::MeasuringLength, Access::Write) => {
                (self.programmed_length, self.active_length) = ((!reply.error_bit()).then_some(data), None);
            }
            (Service::DataCheck, Access::Read) if !reply.error_bit() => {
                self.active_length = self.programmed_length;
            }
            _ => {}
        }
    }

    /// The measuring length that is in force, if it was seen to become so.
    pub(super) const fn active_length(&self) -> Option<u32> {
        self.active_length
    }

    /// The rows of the last service that are long by now.
    pub(super) fn long_rows(&self, at: Instant) -> impl Iterator<Item = (HandshakeRule, Row)> + use<> {
        let kept = self.kept.get(self.latest).copied();
        kept.into_iter().flat_map(move |Kept { reads, changes, equals, .. }| {
            [
                (HandshakeRule::Polled, reads),
                (HandshakeRule::MemoryWear, changes),
                (HandshakeRule::EqualWrites, equals),
            ]
            .into_iter()
            .filter(move |(_, row)| row.count >= AGAIN && row.last == at)
        })
    }

    /// 08 was requested.
    pub(super) fn checked(&mut self) {
        self.unchecked = None;
    }

    /// When the check of the last write is late, if it waits for one.
    pub(super) fn check_due(&self) -> Option<Instant> {
        self.unchecked.map(|(_, since)| since + CHECK_WITHIN)
    }

    /// The service of the write that was not checked; from now on nothing is unchecked.
    pub(super) fn take_unchecked(&mut self) -> Option<Service> {
        self.unchecked.take().map(|(service, _)| service)
    }

    /// Notes a preset adjustment; `true` if it repeats the one before.
    pub(super) fn preset_again(&mut self, at: Instant, value: u32) -> bool {
        let before = self.preset.replace((value, at));
        before.is_some_and(|(same, then)| same == value && at.since(then) < PRESET_AGAIN)
    }
}
