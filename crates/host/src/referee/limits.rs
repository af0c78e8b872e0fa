//! What has stood for too long.

use super::rule::{STANDS_LONG, STATUS_WITHIN};
use super::{Duration, Effect, ErrorSeen, HandshakeRule, Instant, OutWord, Referee, RuleCertainty, Standing};

/// No time that is ever reached.
pub(super) const NEVER: Instant = Instant(u64::MAX);

impl Referee {
    /// Something begins that may stand for too long; all that can begin may stand for this long at least.
    pub(super) fn begins(&mut self, at: Instant) {
        self.due = self.due.min(at + STATUS_WITHIN.min(self.withdrawal));
    }

    /// When something will have stood for too long.
    fn next_due(&self) -> Instant {
        let standing = self.standing.as_ref();
        let error = self.error.as_ref().filter(|error| !error.over);
        let limits = [
            standing.filter(|standing| !standing.settled).map(|standing| standing.rose + self.withdrawal),
            standing.and_then(Standing::since).map(|(_, since)| since + STANDS_LONG),
            self.habits.check_due(),
            self.status_due.map(|since| since + STATUS_WITHIN),
            error.and_then(|error| error.normal).map(|since| since + STATUS_WITHIN),
        ];
        limits.into_iter().flatten().min().unwrap_or(NEVER)
    }

    /// Looks at all that stands, whether it has stood for too long.
    #[cold]
    pub(super) fn stands_too_long(&mut self, at: Instant) {
        self.stands_long(at, STANDS_LONG);
        if self.standing.is_some_and(|standing| at.since(standing.rose) >= self.withdrawal) {
            self.settle();
        }
        let out = self.out.unwrap_or_default();
        if self.habits.check_due().is_some_and(|due| at >= due) {
            self.check_missed(at, out);
        }
        if self.status_due.is_some_and(|since| at.since(since) >= STATUS_WITHIN) {
            self.status_due = None;
            self.found(HandshakeRule::StatusNotRead, at, out);
        }
        let ignored = |error: &ErrorSeen| {
            !error.over && error.normal.is_some_and(|since| at.since(since) >= STATUS_WITHIN)
        };
        if self.error.as_ref().is_some_and(ignored) {
            self.error_ignored(at, out);
        }
        self.due = self.next_due();
    }

    pub(super) fn error_ignored(&mut self, at: Instant, out: OutWord) {
        if let Some(error) = &mut self.error {
            error.over = true;
        }
        self.found(HandshakeRule::ErrorIgnored, at, out);
    }

    pub(super) fn stands_long(&mut self, at: Instant, long: Duration) {
        let Some(standing) = &mut self.standing else { return };
        let Some((rule, since)) = standing.since() else { return };
        let unseen = rule == HandshakeRule::NeverAcknowledged && !self.input_seen;
        if !unseen && at.since(since) >= long {
            standing.told = true;
            let word = standing.word;
            self.found(rule, at, word);
        }
    }

    /// The programmed values were not checked.
    pub(super) fn check_missed(&mut self, at: Instant, out: OutWord) {
        let Some(service) = self.habits.take_unchecked() else { return };
        let (mut needed, mut needless) = (false, false);
        for model in self.models().filter(|model| model.lists(service).is_some()) {
            needed |= model.effect() == Effect::AtDataCheck;
            needless |= model.effect() == Effect::AtOnce;
        }
        if needed {
            let sure = if needless { RuleCertainty::Suspected } else { RuleCertainty::Certain };
            self.found_as(HandshakeRule::NoDataCheck, sure, at, out);
        }
    }
}
