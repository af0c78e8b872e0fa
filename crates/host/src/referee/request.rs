//! One request, from the rise of its service bit to its fall.

use super::preparation::Prepared;
use super::{
    Access, By, DATA, ERROR_BIT, ERROR_SEEN, ErrorSeen, HandshakeRule, InWord, Instant, Out, OutWord,
    RESERVE_BIT, Referee, RuleCertainty, Service, ServiceFields, ServiceNumber, Standing, Vantage,
};
use encoring_words::ErrorStatus;

/// Bits 30 and 27..24.
const NUMBER: u32 = 0x4F00_0000;

/// The bits of a request that say something: of a read no data [R35].
const fn meant(word: OutWord) -> u32 {
    match word.0 & 0x4000_0000 {
        0 => NUMBER,
        _ => NUMBER | DATA.mask(),
    }
}

/// Whether a reply is that of the request [R25, R26].
fn answers(request: OutWord, input: InWord) -> bool {
    let differs = (input.0 & !ERROR_BIT.mask()) ^ (request.0 & !(ERROR_BIT.mask() | RESERVE_BIT.mask()));
    differs & (1 << 31 | meant(request) | RESERVE_BIT.mask()) == 0
}

fn fields(word: OutWord) -> Option<ServiceFields> {
    match word.decode() {
        Out::Request(fields) => Some(fields),
        Out::Normal(_) => None,
    }
}

fn is_data_check(word: OutWord) -> bool {
    fields(word).is_some_and(|fields| {
        fields.access == Access::Read && fields.service == ServiceNumber::Known(Service::DataCheck)
    })
}

fn is_preset(word: OutWord) -> bool {
    fields(word).is_some_and(|fields| {
        fields.access == Access::Write && fields.service == ServiceNumber::Known(Service::PresetAdjustment)
    })
}

impl Standing {
    const fn new(word: OutWord, rose: Instant, by: By, together: bool) -> Self {
        Self {
            word,
            rose,
            by,
            together,
            own: None,
            foreign: None,
            spoiled: false,
            stopped: false,
            settled: false,
            told: false,
        }
    }

    /// One whose rise was not seen.
    pub(super) const fn unseen(word: OutWord, at: Instant) -> Self {
        Self { spoiled: true, settled: true, ..Self::new(word, at, By::Cycle, false) }
    }

    /// Since when it waits for what, if nothing was told of it yet.
    pub(super) fn since(&self) -> Option<(HandshakeRule, Instant)> {
        let waits = match self.own {
            Some(own) => (HandshakeRule::NeverDropped, own),
            None if self.spoiled => return None,
            None => (HandshakeRule::NeverAcknowledged, self.rose),
        };
        (!self.told && !self.stopped).then_some(waits)
    }
}

impl Referee {
    pub(super) fn rises(&mut self, at: Instant, before: OutWord, after: OutWord, by: By) {
        self.services = self.services.saturating_add(1);
        let together = self.is_unprepared(at, before, after);
        let mut standing = Standing::new(after, at, by, together);
        if self.ending && HandshakeRule::NextBeforeEnd.certainty(self.vantage) != RuleCertainty::NotJudged {
            standing.spoiled = true;
            self.found(HandshakeRule::NextBeforeEnd, at, after);
        }
        self.standing = Some(standing);
        self.begins(at);
        if is_data_check(after) {
            self.status_due = None;
            if let Some(error) = &mut self.error {
                error.over = true;
            }
            self.habits.checked();
            return;
        }
        if is_preset(after) {
            self.check_missed(at, after);
        }
        let seen = |error: &ErrorSeen| {
            !error.over && error.normal.is_some_and(|since| error.replied || at.since(since) >= ERROR_SEEN)
        };
        if self.error.as_ref().is_some_and(seen) {
            self.error_ignored(at, after);
        }
    }

    /// Whether number or data come with the service bit, as far as rows of a log can tell.
    fn is_unprepared(&mut self, at: Instant, before: OutWord, after: OutWord) -> bool {
        let together = (before.0 ^ after.0) & meant(after) != 0;
        if self.vantage != Vantage::Log {
            return together;
        }
        let prepared = self.preparations.rises(after, together, self.before, at);
        if self.preparations.is_complete() {
            self.take_back(HandshakeRule::DataWithServiceBit);
        }
        prepared == Prepared::Missing
    }

    /// The service bit is 0.
    pub(super) fn rests(&mut self, at: Instant, before: OutWord, after: OutWord) {
        if self.vantage == Vantage::Log && (before.0 ^ after.0) & meant(after) != 0 {
            self.preparations.begins(at);
        }
    }

    pub(super) fn changes(&mut self, at: Instant, before: OutWord, after: OutWord, by: By) {
        let Some(standing) = &mut self.standing else { return };
        let differs = (before.0 ^ after.0) & (meant(before) | meant(after));
        if standing.own.is_some() || standing.spoiled || differs == 0 {
            return;
        }
        standing.spoiled = true;
        let rule = match (standing.by, by) {
            (By::High(first), By::Low(second)) if first == second => {
                // Whatever changed with the bit is half of what is torn.
                standing.together = false;
                HandshakeRule::TornWords
            }
            _ => HandshakeRule::DataChangedInService,
        };
        self.found(rule, at, after);
    }

    pub(super) fn falls(&mut self, at: Instant, after: OutWord) {
        self.settle();
        let Some(standing) = self.standing.take() else { return };
        self.ending = self.input.is_some_and(InWord::service_bit);
        let stopped = standing.stopped || self.silent_since.is_some();
        if standing.own.is_some() || standing.spoiled || stopped || self.input.is_none() {
            return;
        }
        let withdrawal = self.withdrawal;
        let within = |since: Instant| at.since(since) < withdrawal;
        let word = standing.word;
        if standing.foreign.is_some_and(within) {
            self.found(HandshakeRule::ForeignReply, at, word);
        } else if self.vantage == Vantage::Log && standing.rose == self.before {
            // One row has shown the bit, so between two the rest of the service may have been.
            self.reply_overlooked = true;
        } else if within(standing.rose) {
            let reset = self.vantage == Vantage::Exchanges && after == OutWord(0);
            let sure = if reset { RuleCertainty::Suspected } else { RuleCertainty::Certain };
            self.found_as(HandshakeRule::DroppedBeforeAcknowledgement, sure, at, word);
        } else {
            self.found(HandshakeRule::Withdrawn, at, word);
        }
    }

    /// IN shows this.
    pub(super) fn input_is(&mut self, at: Instant, input: InWord) {
        if self.input == Some(input) && !input.service_bit() {
            return;
        }
        self.input_seen = true;
        self.input = Some(input);
        if input.service_bit() {
            self.reply(at, input);
        } else {
            self.ending = false;
            self.position(at, input);
        }
    }

    #[inline(never)]
    fn reply(&mut self, at: Instant, input: InWord) {
        self.movement.interrupted();
        let Some(standing) = &mut self.standing else { return };
        if !standing.spoiled && !answers(standing.word, input) {
            standing.foreign.get_or_insert(at);
            return;
        }
        if standing.own.replace(standing.own.unwrap_or(at)).is_some() {
            return;
        }
        let (word, spoiled) = (standing.word, standing.spoiled);
        self.begins(at);
        self.settle();
        if spoiled {
            return;
        }
        if let Some(fields) = fields(word) {
            self.habits.done(at, fields, input);
            self.wear(at, word);
        }
        if input.error_bit() && !is_data_check(word) {
            self.status_due.get_or_insert(at);
            let error = ErrorSeen { normal: None, replied: true, over: false };
            self.error.get_or_insert(error).replied = true;
        }
    }

    fn position(&mut self, at: Instant, input: InWord) {
        self.movement.position(at, DATA.of(input.0));
        if !input.error_bit() {
            self.error = None;
            return;
        }
        let error = ErrorSeen { normal: None, replied: false, over: false };
        let normal = &mut self.error.get_or_insert(error).normal;
        if normal.is_none() {
            *normal = Some(at);
            self.begins(at);
        }
    }

    /// Judges what the standing request asks for, once: when its word has come to rest.
    pub(super) fn settle(&mut self) {
        let Some(standing) = &mut self.standing else { return };
        if mark_settled(standing) {
            return;
        }
        let Standing { word, rose, together, spoiled, .. } = *standing;
        if together {
            self.found(HandshakeRule::DataWithServiceBit, rose, word);
        }
        if spoiled {
            return;
        }
        if let Some(fields) = fields(word) {
            self.content(rose, word, fields);
        }
        if is_preset(word) {
            if self.movement.moved_since(rose) {
                self.found(HandshakeRule::PresetWhileMoving, rose, word);
            }
            if self.habits.preset_again(rose, DATA.of(word.0)) {
                self.found(HandshakeRule::PresetRepeated, rose, word);
            }
        }
    }

    fn content(&mut self, rose: Instant, word: OutWord, fields: ServiceFields) {
        let ServiceFields { service, access, data, .. } = fields;
        let length = self.habits.active_length();
        let mut known = false;
        let mut right = false;
        let mut takes = false;
        for model in self.models() {
            let refused = match model.admits(service, access) {
                Err(status) => {
                    known |= status != ErrorStatus::UNKNOWN_COMMAND;
                    continue;
                }
                Ok(listed) => {
                    let above = length.is_some_and(|length| data > listed.takes.largest(length));
                    access == Access::Write
                        && (above
                            || listed.takes.normalise(data).is_err()
                            || !listed.takes.invalid(data).is_empty())
                }
            };
            (known, right) = (true, true);
            takes |= !refused;
        }
        let rule = match (known, right, takes) {
            (false, ..) => HandshakeRule::UnknownService,
            (_, false, _) => HandshakeRule::WrongDirection,
            (_, _, false) => HandshakeRule::OutOfRange,
            _ => return,
        };
        self.found(rule, rose, word);
    }

    /// Rows of writes and reads that have become long.
    fn wear(&mut self, at: Instant, word: OutWord) {
        for (rule, row) in self.habits.long_rows(at) {
            self.found(rule, row.first, word);
            if let Some(Some(finding)) = self.findings.get_mut(rule as usize) {
                (finding.last, finding.count) = (row.last, finding.count.max(row.count));
            }
        }
    }
}

/// Marks a request as judged; `true` if it was already.
fn mark_settled(standing: &mut Standing) -> bool {
    core::mem::replace(&mut standing.settled, true)
}
