//! What happens while encoders are looked at, as it is told on a screen, in lines, in a log and to programs.

use std::fmt;
use std::time::{Duration as Real, SystemTime};

use encoring_bus::misread::Misread;
use encoring_bus::watch::{Poll, Watch};
use encoring_bus::{Bus, Cure, Link, RingNews};
use encoring_diagnosis::FoundView;
use encoring_host::referee::Vantage;
use encoring_host::validity::Stop;
use encoring_ring::diagnostics::{Diagnosis, DiagnosticParameter, names};
use encoring_station::FindingView;
use encoring_station::causes::Caused;
use encoring_words::Instant;
use serde::Serialize;

use crate::acknowledging::Acknowledging;
use crate::output::time::{seconds, span};

/// Which date a time on the bus's clock is.
#[derive(Clone, Copy)]
pub(crate) struct Calendar {
    began: SystemTime,
    origin: Instant,
}

impl Calendar {
    /// It is `now` on the bus's clock.
    #[expect(clippy::disallowed_methods, reason = "what happened is told with its date")]
    pub(crate) fn at(now: Instant) -> Self {
        Self { began: SystemTime::now(), origin: now }
    }

    /// In UTC.
    pub(crate) fn date(&self, at: Instant) -> String {
        let since = Real::from_nanos(at.since(self.origin).as_nanos());
        let date = self.began.checked_add(since).unwrap_or(self.began);
        humantime::format_rfc3339_seconds(date).to_string()
    }
}

/// Something that happened.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct News {
    pub(crate) event: &'static str,
    pub(crate) time_ns: u64,
    pub(crate) date: String,
    /// `null`: the link or the ring.
    pub(crate) position: Option<usize>,
    pub(crate) text: String,
    /// What the ring's master said with it.
    pub(crate) diagnosis: Option<DiagnosisView>,
    /// Of the cause of a jump.
    #[serde(flatten)]
    pub(crate) found: Option<FoundView>,
    /// Part of the history of a ring: no attempt among many, and nothing that the words show.
    #[serde(skip)]
    pub(crate) lasting: bool,
    /// What somebody who looks on can do now.
    #[serde(skip)]
    pub(crate) advice: Option<String>,
}

/// The encoders whose words a gateway turns round, each told once.
#[derive(Debug, Default)]
pub(crate) struct TurnedRound(Vec<(usize, Misread)>);

impl TurnedRound {
    /// What the last poll has brought to light.
    pub(crate) fn take<B: Bus + ?Sized>(&mut self, watch: &Watch<'_, B>, calendar: &Calendar) -> Vec<News> {
        let at = watch.latest().at;
        let ways = watch.subjects().iter().filter_map(|subject| {
            let position = subject.position;
            watch.misread(position).map(|way| (position, way))
        });
        let new: Vec<_> = ways.filter(|known| !self.0.contains(known)).collect();
        self.0.extend(&new);
        let told = |(position, way)| News::of_turned_round(position, &watch.cure(way), at, calendar);
        new.into_iter().map(told).collect()
    }
}

/// What a ring's master says.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct DiagnosisView {
    ring_runs: Option<bool>,
    status_hex: Option<String>,
    status: Vec<&'static str>,
    parameter_hex: Option<String>,
    parameter: Option<String>,
    device_number: Option<String>,
    segment: Option<usize>,
}

impl DiagnosisView {
    fn new(diagnosis: Diagnosis) -> Self {
        let Diagnosis { status, parameter } = diagnosis;
        let hex = |register: u16| format!("{register:04X}");
        Self {
            ring_runs: diagnosis.reaches(0),
            status_hex: status.map(hex),
            status: names(status.unwrap_or_default()).collect(),
            parameter_hex: parameter.map(hex),
            parameter: parameter.map(|parameter| DiagnosticParameter(parameter).to_string()),
            device_number: diagnosis.device().map(|(device, place)| format!("{device}.{place}")),
            segment: diagnosis.segment(),
        }
    }
}

/// What happened with a poll.
pub(crate) fn news(poll: &Poll, calendar: &Calendar, acknowledging: &Acknowledging) -> Vec<News> {
    let told = |event, at: Instant, position, text| News {
        event,
        time_ns: at.as_nanos(),
        date: calendar.date(at),
        position,
        text,
        diagnosis: None,
        found: None,
        lasting: false,
        advice: None,
    };
    let mut news: Vec<News> = Vec::new();
    for event in &poll.link {
        let lasting = event.what.is_trouble() && !matches!(event.what, Link::Failed { .. });
        news.push(News { lasting, ..told(link(&event.what), event.at, None, event.what.to_string()) });
    }
    if let Some(event) = &poll.ring {
        let diagnosis = event.diagnosis().map(DiagnosisView::new);
        news.push(News { diagnosis, lasting: true, ..told(ring(event), poll.at, None, event.to_string()) });
    }
    for position in &poll.acknowledged {
        let text = "the jump was acknowledged: the next position is taken as it comes".to_owned();
        news.push(News { lasting: true, ..told("acknowledged", poll.at, Some(*position), text) });
    }
    for (position, finding) in &poll.findings {
        let finding = FindingView::new(*position, finding, Vantage::Log);
        let text = finding.told();
        let event = told("finding", poll.at, Some((*position).into()), text);
        news.push(News { lasting: true, ..event });
    }
    for sight in &poll.sights {
        let (event, text) = match sight.stop {
            None => continue,
            Some(Stop::Error(_)) => ("error", "the error bit is set".to_owned()),
            Some(Stop::Implausible(why)) => ("implausible", why.to_string()),
            Some(Stop::Stale { age }) => ("stale", format!("no new word for {}", span(age))),
        };
        // It stays until somebody ends it, so somebody has to know.
        let jumped = matches!(sight.stop, Some(Stop::Implausible(why)) if why.is_step());
        let advice = jumped.then(|| acknowledging.how.clone());
        news.push(News { lasting: jumped, advice, ..told(event, sight.at, Some(sight.position), text) });
    }
    news
}

const fn link(what: &Link) -> &'static str {
    match what {
        Link::Up { .. } => "link_up",
        Link::Down { .. } => "link_down",
        Link::Failed { .. } => "link_failed",
    }
}

const fn ring(event: &RingNews) -> &'static str {
    match event {
        RingNews::Stopped(_) => "ring_stopped",
        RingNews::Runs { .. } => "ring_runs",
        RingNews::Says(_) => "diagnosis",
        RingNews::FaultyCycle(_) => "faulty_cycle",
        RingNews::Unread(_) => "diagnosis_unread",
    }
}

impl News {
    /// Of the ring, without a word of its master.
    pub(crate) fn of_ring(event: &'static str, at: Instant, calendar: &Calendar, text: &str) -> Self {
        let (date, text) = (calendar.date(at), text.to_owned());
        let time_ns = at.as_nanos();
        Self {
            event,
            time_ns,
            date,
            position: None,
            text,
            diagnosis: None,
            found: None,
            lasting: true,
            advice: None,
        }
    }

    /// Of a jump, why it was.
    pub(crate) fn of_cause(caused: Caused, at: Instant, calendar: &Calendar) -> Self {
        let Caused { position, found } = caused;
        let text = found.to_string();
        Self { position: Some(position), found: Some(found), ..Self::of_ring("cause", at, calendar, &text) }
    }

    /// Of words that no encoder sends, and that are one's if they are read in another way.
    fn of_turned_round(position: usize, cure: &Cure, at: Instant, calendar: &Calendar) -> Self {
        let text = format!("IN is nobody's as it comes{cure}");
        Self { position: Some(position), ..Self::of_ring("misread", at, calendar, &text) }
    }

    /// What happened, and to whom.
    pub(crate) fn told(&self) -> String {
        match self.position {
            Some(position) => format!("position {position}: {}", self.text),
            None => self.text.clone(),
        }
    }

    /// The same with what can be done now, for somebody who looks on.
    pub(crate) fn advised(&self) -> String {
        match &self.advice {
            Some(advice) => format!("{self}; {advice}"),
            None => self.to_string(),
        }
    }
}

impl fmt::Display for News {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>10} s  {}  {}", seconds(self.time_ns), self.date, self.told())
    }
}
