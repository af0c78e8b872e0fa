//! The referees of a ring: one for each encoder, all with the same vantage.

use std::collections::BTreeMap;

use encoring_host::referee::{Finding, HandshakeRule, Observed, RULES, Referee, Vantage, WITHDRAWAL};
use encoring_words::{Duration, Model};

/// A referee for each ring position of which something was seen.
#[derive(Clone, Debug)]
pub struct Referees {
    vantage: Vantage,
    /// The model where none is known of a position.
    model: Option<Model>,
    models: BTreeMap<u8, Model>,
    withdrawal: Duration,
    each: BTreeMap<u8, Referee>,
}

impl Referees {
    /// Referees that have seen nothing. Where no model is known of a position it is `model`.
    #[must_use]
    pub const fn new(vantage: Vantage, model: Option<Model>) -> Self {
        Self { vantage, model, models: BTreeMap::new(), withdrawal: WITHDRAWAL, each: BTreeMap::new() }
    }

    /// Says which model is at a position, before anything was seen of it.
    pub fn place(&mut self, position: u8, model: Model) {
        self.models.insert(position, model);
    }

    /// After so long a request without a reply may be dropped, if nothing was seen yet.
    pub const fn allow_withdrawal(&mut self, after: Duration) {
        self.withdrawal = after;
    }

    /// They look from there, if nothing was seen yet.
    pub const fn look_from(&mut self, vantage: Vantage) {
        self.vantage = vantage;
    }

    /// Takes what was seen at a position. Where a write is seen, all are.
    pub fn observe(&mut self, position: u8, seen: Observed) {
        if matches!(seen, Observed::Write { .. }) && self.vantage != Vantage::Writes {
            self.vantage = Vantage::Writes;
            self.each.values_mut().for_each(Referee::sees_writes);
        }
        let (vantage, model) = (self.vantage, self.models.get(&position).copied().or(self.model));
        let new = || Referee::new(vantage, model).with_withdrawal(self.withdrawal);
        self.each.entry(position).or_insert_with(new).observe(seen);
    }

    /// Nothing more comes.
    pub fn finish(&mut self) {
        self.each.values_mut().for_each(Referee::finish);
    }

    /// From where they look.
    #[must_use]
    pub const fn vantage(&self) -> Vantage {
        self.vantage
    }

    /// The referees, by position.
    pub fn each(&self) -> impl Iterator<Item = (u8, &Referee)> {
        self.each.iter().map(|(position, referee)| (*position, referee))
    }

    /// What was found, by position and in the order of the rules.
    pub fn findings(&self) -> impl Iterator<Item = (u8, &Finding)> {
        self.each().flat_map(|(position, referee)| referee.findings().map(move |finding| (position, finding)))
    }

    /// What was found first, or has become certain, since the last call.
    pub fn take_news(&mut self) -> impl Iterator<Item = (u8, Finding)> {
        self.each.iter_mut().flat_map(|(position, referee)| {
            let position = *position;
            referee.take_news().map(move |finding| (position, finding))
        })
    }

    /// Requests that were seen.
    #[must_use]
    pub fn services(&self) -> u64 {
        self.each.values().map(Referee::services).sum()
    }

    /// `true` if a rule of severity error was certainly broken.
    #[must_use]
    pub fn is_broken(&self) -> bool {
        self.each.values().any(Referee::is_broken)
    }

    /// The rules that were not judged for some encoder, each name once; all if nothing was seen.
    #[must_use]
    pub fn not_judged(&self) -> Vec<HandshakeRule> {
        let nobody = self.each.is_empty().then_some(RULES).into_iter().flatten();
        let mut rules: Vec<_> = self.each.values().flat_map(Referee::not_judged).chain(nobody).collect();
        rules.sort_unstable();
        rules.dedup_by_key(|rule| rule.name());
        rules
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use encoring_host::referee::LineSeen;
    use encoring_words::{InWord, Instant, OutWord, Written};

    #[test]
    fn each_finding_is_news_once_and_belongs_to_its_position() {
        let mut referees = Referees::new(Vantage::Cycles, None);
        referees.place(2, Model::Ce65M);
        let mut names = RULES.map(HandshakeRule::name).to_vec();
        names.dedup();
        assert_eq!(referees.not_judged().len(), names.len(), "all");
        let mut at = Instant(0);
        for (out, input) in
            [(0, 100), (0x0700_0000, 100), (0x8700_0000, 100), (0x8700_0000, 0xA700_0000), (0, 100)]
        {
            at = Instant(at.0 + 1_000_000);
            for position in [0, 2] {
                let out = if position == 2 { out } else { 0 };
                let cycle = Observed::Cycle {
                    at,
                    out: OutWord(out),
                    input: Some(InWord(input)),
                    line: LineSeen::Good,
                };
                referees.observe(position, cycle);
            }
        }
        let news: Vec<_> = referees.take_news().map(|(position, found)| (position, found.rule)).collect();
        assert_eq!(news, [(2, HandshakeRule::UnknownService)]);
        assert_eq!(referees.take_news().count(), 0);
        assert!(referees.is_broken() && referees.findings().count() == 1 && referees.services() == 1);
        assert_eq!(referees.not_judged(), [HandshakeRule::TornWords]);
        referees.observe(2, Observed::Write { at, client: 1, written: Written::Low(0) });
        assert_eq!((referees.vantage(), referees.not_judged()), (Vantage::Writes, vec![]));
    }
}
