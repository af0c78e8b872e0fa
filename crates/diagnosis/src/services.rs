//! What the recording itself tells: requests and replies of services.

use encoring_texts::Said;
use encoring_words::parameter::{CountingDirection, Direction};
use encoring_words::word::{Out, ServiceFields, ServiceNumber};
use encoring_words::{Access, InWord, OutWord, ParameterSet, Service};

use crate::evidence;
use crate::options::Counted;
use crate::row::{ReadAs, Row};

/// Marks that are kept.
const MARKS: usize = 64;
/// Marks further apart belong to different sessions.
const PAUSE_NS: i64 = 1_000_000_000;
/// Values of replies that are kept.
const VALUES: usize = 64;

/// Measuring lengths that are kept.
const LENGTHS: usize = 8;

/// Something that a service did, at a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mark {
    pub(crate) line: u64,
    pub(crate) time_ns: i64,
    pub(crate) done: Done,
}

/// What can make a position jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Done {
    /// Service 06, to this value.
    Preset(u32),
    /// Services 02, 03, 09 were written.
    Scaling,
    /// Service 01 was written.
    Direction,
    /// A data check made active what was written.
    Check,
}

/// Marks close to each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Session {
    pub(crate) done: Done,
    /// The lines of the first and the last mark.
    pub(crate) lines: (u64, u64),
}

/// What was seen of services.
#[derive(Clone, Debug, Default)]
pub(crate) struct Services {
    counted: Counted,
    marks: Vec<Mark>,
    /// Those of which no session was made yet.
    untold: Vec<Mark>,
    /// Data of requests and replies, the newest last.
    values: Vec<u32>,
    /// Measuring lengths that were written or read.
    lengths: Vec<u32>,
    /// The counting direction that is active, if it is known, and one that was written since the last data check.
    direction: Option<Direction>,
    direction_written: Option<Direction>,
    /// A scaling was written, and no data check has followed yet.
    is_scaling_written: bool,
    /// The line of the first data check that made another scaling active.
    rescaled: Option<u64>,
    /// Rows with an OUT word, and without.
    outs: (u64, u64),
    requested: bool,
    last_reply: Option<InWord>,
    last_out: Option<u32>,
    /// The high half of the last position.
    high: i64,
}

impl Services {
    /// Of rows whose numbers count this, and of an encoder with these active values.
    pub(crate) fn new(counted: Counted, active: Option<&ParameterSet>) -> Self {
        let direction = active.map(|active| active.counting_direction().direction);
        Self { counted, direction, ..Self::default() }
    }

    /// A row, as it is told.
    pub(crate) fn place(&self, line: u64) -> Said {
        match self.counted {
            Counted::Lines => evidence::line(line),
            Counted::Polls => evidence::poll(line),
        }
    }

    /// Takes the next row.
    pub(crate) fn row(&mut self, row: &Row) {
        match row.out {
            Some(out) => {
                self.outs.0 += 1;
                self.last_out = Some(out);
                self.out(row, out);
            }
            None => self.outs.1 += 1,
        }
        if let Some(position) = row.position(ReadAs::Plain) {
            self.high = position >> 16;
        }
        let reply = row.reply().filter(|reply| !self.is_exchanged(*reply));
        // Where OUT stands beside it, the request is told by that.
        if reply != self.last_reply
            && row.out.is_none()
            && let Some(reply) = reply
            && let encoring_words::word::In::Reply(fields) = reply.decode()
        {
            self.done(row, fields);
        }
        self.last_reply = reply;
    }

    /// A position with its halves exchanged can have bit 31.
    fn is_exchanged(&self, reply: InWord) -> bool {
        i64::from(reply.low()) == self.high && reply.low() != 0
            || self.last_out.is_none() && reply.low() >> 8 == 0 && reply.high() & 0xFF != 0
    }

    fn out(&mut self, row: &Row, out: u32) {
        let Out::Request(fields) = OutWord(out).decode() else {
            self.requested = false;
            return;
        };
        if !self.requested {
            self.requested = true;
            self.done(row, fields);
        }
    }

    fn done(&mut self, row: &Row, fields: ServiceFields) {
        if !self.values.contains(&fields.data) {
            if self.values.len() >= VALUES {
                self.values.remove(0);
            }
            self.values.push(fields.data);
        }
        let ServiceNumber::Known(service) = fields.service else { return };
        let is_length = service == Service::MeasuringLength && fields.data != 0;
        if is_length && !self.lengths.contains(&fields.data) && self.lengths.len() < LENGTHS {
            self.lengths.push(fields.data);
        }
        let done = match (service, fields.access) {
            (Service::PresetAdjustment, Access::Write) => Done::Preset(fields.data),
            (Service::MeasuringLength | Service::Numerator | Service::Denominator, Access::Write) => {
                Done::Scaling
            }
            // The code may be another; the direction is the same.
            (Service::CountingDirection, Access::Write) => {
                let written = CountingDirection::from_data(fields.data).direction;
                self.direction_written = Some(written);
                if self.direction == Some(written) {
                    return;
                }
                Done::Direction
            }
            (Service::DataCheck, Access::Read) => Done::Check,
            _ => return,
        };
        if done == Done::Check {
            self.direction = self.direction_written.take().or(self.direction);
            self.rescaled = self.rescaled.or(self.is_scaling_written.then_some(row.line));
        }
        self.is_scaling_written |= done == Done::Scaling;
        if self.marks.len() >= MARKS {
            self.marks.remove(0);
        }
        let mark = Mark { line: row.line, time_ns: row.time_ns, done };
        self.marks.push(mark);
        if self.untold.len() < MARKS {
            self.untold.push(mark);
        }
    }

    /// What was done by marks up to a time that nothing followed for a second, each cause once; it is told then.
    pub(crate) fn sessions(&mut self, until_ns: i64) -> Vec<Session> {
        let mut sessions: Vec<Session> = Vec::new();
        let ended = |marks: &[Mark]| {
            let (Some(_), Some(last)) = (marks.first(), marks.last()) else { return false };
            last.time_ns.saturating_add(PAUSE_NS) <= until_ns
        };
        let open = self.untold.chunk_by(|a, b| b.time_ns - a.time_ns <= PAUSE_NS);
        let mut told = 0;
        for marks in open.take_while(|marks| ended(marks)) {
            told += marks.len();
            let mut open: Option<Session> = None;
            for Mark { line, done, .. } in marks.iter().copied() {
                match &mut open {
                    // The check takes over what was written before it.
                    Some(session) if done == Done::Check || session.done == done => session.lines.1 = line,
                    _ if done == Done::Check => {}
                    _ => sessions.extend(open.replace(Session { done, lines: (line, line) })),
                }
            }
            sessions.extend(open);
        }
        self.untold.drain(..told);
        sessions
    }

    /// The line from which on another scaling than at first may be active, as it was written and checked.
    pub(crate) const fn rescaled(&self) -> Option<u64> {
        self.rescaled
    }

    /// The line of the first thing done of which no session was made yet.
    pub(crate) fn waiting_since(&self) -> Option<u64> {
        self.untold.first().map(|mark| mark.line)
    }

    /// Whether something was done that no session was made of yet.
    pub(crate) const fn is_waiting(&self) -> bool {
        !self.untold.is_empty()
    }

    /// Measuring lengths that were written or read.
    pub(crate) fn lengths(&self) -> &[u32] {
        &self.lengths
    }

    /// Whether these are data of a request or a reply that was seen.
    pub(crate) fn has_said(&self, data: i64) -> bool {
        u32::try_from(data).is_ok_and(|data| self.values.contains(&data))
    }

    /// Whether OUT stands in the rows, so that no service can have been missed for long.
    pub(crate) const fn shows_out(&self) -> bool {
        self.outs.0 > 0 && self.outs.1 == 0
    }

    /// What services did from one time to another, the newest first.
    pub(crate) fn between(&self, from_ns: i64, to_ns: i64) -> impl Iterator<Item = Mark> + '_ {
        self.marks.iter().rev().copied().filter(move |mark| (from_ns..=to_ns).contains(&mark.time_ns))
    }
}
