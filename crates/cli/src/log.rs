//! `encoring log`: what encoders show, into files, for days.

use std::fmt;
use std::io;
use std::path::PathBuf;
use std::time::{Duration as Real, Instant as Clock, SystemTime};

use clap::Args;
use encoring_bus::watch::{Plan, Poll, Sight, Subject, Watch};
use encoring_bus::{BusError, Judgement};
use encoring_ring::diagnostics::Diagnosis;
use encoring_station::SharedWorld;
use encoring_station::causes::{Caused, Causes};
use encoring_trace::log::{Log, LogError, LogProblem, LogRow, MasterColumns, Rotation};
use encoring_words::{Duration, Instant};
use serde::Serialize;

use crate::acknowledging::Acknowledging;
use crate::arguments::{Lasting, Output, Pace, span, whole};
use crate::bus::{AnyBus, Opened};
use crate::interrupt::awaiting_reader;
use crate::news::{Calendar, News, TurnedRound, news};
use crate::output::printer::Printer;
use crate::output::progress::Progress;
use crate::output::time::seconds;
use crate::output::{Answer, Failure, Format, bad_input, page};
use crate::subjects::SubjectArguments;
use crate::told::{FaultSeen, Faults, looked};

/// A power cut loses at most what came in this time.
const FLUSH_EVERY: Real = Real::from_secs(1);
/// The bar of a log whose end is known, and of one without.
const BAR: &str = "{bar:30} {percent:>3} %  {msg}, {eta} left";
const SPINNER: &str = "{spinner} {msg}; Ctrl-C ends";
/// How often the progress is shown.
const SHOW_EVERY: Real = Real::from_millis(200);

/// Log the encoders of a ring to a CSV file, for hours or days
///
/// It only reads and never writes an OUT word, so the PLC can go on working. It writes a row for each encoder every --every
/// and at each new verdict: time, words, verdict, position. A jump stays marked until the position is back, or until SIGUSR1
/// acknowledges it.
///
/// FILE.csv is always the file that is written. A full file becomes FILE.1.csv, that one FILE.2.csv, and so on. If FILE.csv
/// exists at the start and is a log, it becomes FILE.1.csv as soon as a word was seen; any other file is refused. Rows are
/// on the disk after 1 s.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  ended by Ctrl-C, SIGTERM or --for
  1  with --exit-on-fault: a fault was seen
  2  wrong usage, or FILE.csv exists and is not a log
  3  no poll brought a word, or the log cannot be written; with --exit-on-fault: no fault was seen,
     but an encoder could not be judged at some time

Examples:
  encoring log axis.csv --bus modbus-tcp://192.168.1.10 --at 0-2 --model la-66,ce-100-m,ce-65-m
  encoring log axis.csv --bus modbus-tcp://192.168.1.10 --at 2 --parameters axis-2.toml --changes
  encoring log day.csv --bus sim --for 1d --speed max")]
pub(crate) struct Arguments {
    /// The file to write; full files become FILE.1.csv, FILE.2.csv, ...
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    #[command(flatten)]
    subjects: SubjectArguments,
    /// Time from row to row; a new verdict makes a row at once. 0: as fast as the bus answers
    #[arg(long, value_name = "TIME", default_value = "100ms", value_parser = every)]
    every: Duration,
    /// Time from poll to poll; a poll waits for the answer to the one before. 0: as fast as the bus answers
    #[arg(long, value_name = "TIME", default_value = "10ms", value_parser = every)]
    poll: Duration,
    /// End at the first fault: error bit, implausible position, stopped ring
    #[arg(long)]
    exit_on_fault: bool,
    /// Write a row only if a word or the verdict has changed
    #[arg(long)]
    changes: bool,
    /// Size of a full file in millions of bytes, 1 to 1000000
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole::<u32>(1..=1_000_000))]
    rotate_mb: u32,
    /// Age of a full file, such as 1d, even if it is smaller than --rotate-mb [default: no limit]
    #[arg(long, value_name = "TIME", value_parser = span)]
    rotate_every: Option<Duration>,
    /// Number of full files to keep, 1 to 9999; the oldest one beyond that is deleted
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = whole::<u32>(1..=9_999))]
    keep: u32,
    #[command(flatten)]
    lasting: Lasting,
    #[command(flatten)]
    pace: Pace,
    #[command(flatten)]
    output: Output,
}

fn every(text: &str) -> Result<Duration, String> {
    if text == "0" { Ok(Duration::ZERO) } else { span(text) }
}

/// What was logged.
#[derive(Serialize)]
struct Summary {
    file: String,
    rows: u64,
    polls: u64,
    time_ns: u64,
    /// Files begun.
    files: u64,
    verdicts: Vec<Count>,
    /// What ended it, with `--exit-on-fault`.
    fault: Option<FaultSeen>,
}

#[derive(Serialize)]
struct Count {
    verdict: &'static str,
    polls: u64,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let files = if self.files == 1 { "1 file".to_owned() } else { format!("{} files", self.files) };
        let time = seconds(self.time_ns);
        write!(f, "{} rows of {} polls in {time} s, {files}", self.rows, self.polls)?;
        let mut before = ": ";
        for Count { verdict, polls } in &self.verdicts {
            write!(f, "{before}{verdict} {polls}")?;
            before = ", ";
        }
        self.fault.as_ref().map_or(Ok(()), |fault| write!(f, "\nended by a fault: {fault}"))
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Self {
        let message = error.to_string();
        match error.problem {
            LogProblem::Foreign | LogProblem::InUse => Self::BadInput(message),
            LogProblem::System { cause, .. } if cause.kind() == io::ErrorKind::BrokenPipe => {
                Self::Output(cause)
            }
            LogProblem::System { .. } => Self::NoAnswer(message),
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let mut opened = arguments.subjects.ring.open(arguments.pace.or_real())?;
    if arguments.pace.speed.is_some() && !opened.is_simulated() {
        return Err(bad_input("--speed works on a simulated ring only; leave it out"));
    }
    let subjects = arguments.subjects.subjects(&opened)?;
    let rotation = Rotation {
        bytes: u64::from(arguments.rotate_mb) * 1_000_000,
        time_ns: arguments.rotate_every.map(Duration::as_nanos),
        keep: arguments.keep,
    };
    opened.only_looks();
    // A pipe may have no reader yet.
    let remarks = remarks(&opened, &subjects);
    let columns = MasterColumns {
        status: opened.diagnosis.status.is_some(),
        parameter: opened.diagnosis.parameter.is_some(),
    };
    let log = awaiting_reader(|| Log::create(&arguments.file, &remarks, columns, rotation))?;
    let plan = Plan { every: arguments.poll.min(arguments.every), lasting: arguments.lasting.lasting };
    let (stop, quit) = (opened.stop(), opened.stop());
    let (untold, place) = (opened.untold_ring(), opened.place());
    let watch = Watch::new(&mut *opened.bus, subjects, plan, stop);
    // Standard output may be the log.
    let special = log.is_special();
    let mut logging = Logging::new(log, arguments, Calendar::at(watch.now()), place)?;
    logging.begin(untold);
    let (summary, answer, mut notes) = logging.run(watch, opened.world.as_ref())?;
    let format = arguments.output.format;
    if special {
        let _ = notes.print(page(Format::Text, &summary)?);
    } else {
        let mut out = Printer::start(io::stdout(), format)?;
        out.print(page(format, &summary)?)?;
        out.close().wait(&quit)?;
    }
    // Whoever closed standard error does not want to know.
    let _ = notes.close().wait(&quit);
    opened.close()?;
    Ok(answer)
}

/// What stands at the head of every file.
#[expect(clippy::disallowed_methods, reason = "a log says when it was begun")]
fn remarks(opened: &Opened, subjects: &[Subject]) -> Vec<String> {
    let now = humantime::format_rfc3339_seconds(SystemTime::now());
    let mut remarks = vec![format!("started {now}"), format!("bus {}", opened.address)];
    remarks.extend(opened.untold_ring().map(|untold| format!("ring_untold: {untold}")));
    for Subject { position, judge } in subjects {
        let mut remark = format!("encoder {position} {}", judge.model());
        if let Some(length) = judge.measuring_length() {
            remark += &format!(" measuring_length={length}");
        }
        // A simulation shows its parameters with the first poll only.
        let blind: Vec<_> = judge.blind().iter().map(|blind| blind.name()).collect();
        if !blind.is_empty() && !opened.is_simulated() {
            remark += &format!(" cannot_judge={}", blind.join("+"));
        }
        remarks.push(remark);
    }
    remarks
}

/// A log under way.
struct Logging<'a> {
    log: Log,
    arguments: &'a Arguments,
    calendar: Calendar,
    acknowledging: Acknowledging,
    /// When the next row of every encoder is due.
    due: Instant,
    /// Of each encoder what the last row was made of.
    before: Vec<(u64, Option<u32>, Option<u32>, &'static str)>,
    verdicts: [u64; Judgement::WORDS.len()],
    faults: Faults,
    causes: Causes,
    turned_round: TurnedRound,
    polls: u64,
    flushed: Clock,
    shown: Clock,
    progress: Progress,
    notes: Printer,
    /// Host and port, or the device.
    place: String,
    /// Why nothing could be read, as it was told last.
    unread: Option<String>,
}

impl<'a> Logging<'a> {
    #[expect(clippy::disallowed_methods, reason = "rows are brought onto the disk in real time")]
    fn new(log: Log, arguments: &'a Arguments, calendar: Calendar, place: String) -> io::Result<Self> {
        let acknowledging = Acknowledging::by_signal()?;
        let now = Clock::now();
        let verdicts = [0; Judgement::WORDS.len()];
        let lasting = arguments.lasting.lasting;
        let progress = Progress::start(lasting, if lasting.is_some() { BAR } else { SPINNER })?;
        let notes = Printer::start(progress.beside(), Format::Text)?;
        let before = Vec::new();
        let (flushed, shown) = (now, now);
        let due = Instant::ZERO;
        Ok(Self {
            log,
            arguments,
            calendar,
            acknowledging,
            due,
            faults: Faults::default(),
            causes: Causes::default(),
            turned_round: TurnedRound::default(),
            before,
            verdicts,
            polls: 0,
            flushed,
            shown,
            progress,
            notes,
            place,
            unread: None,
        })
    }

    /// Says what the user must know beforehand.
    fn begin(&mut self, untold: Option<&str>) {
        let oldest = self.log.doomed().map(|oldest| {
            let (keep, oldest) = (self.arguments.keep, oldest.display());
            format!("--keep {keep}: what {oldest} holds now is deleted when the next file takes its turn")
        });
        for text in oldest.as_deref().into_iter().chain(untold) {
            // Whoever closed standard error does not want to know.
            let _ = self.notes.print(format!("note: {text}\n"));
        }
    }

    #[expect(clippy::disallowed_methods, reason = "rows are brought onto the disk in real time")]
    fn run(
        mut self,
        mut watch: Watch<'_, AnyBus>,
        world: Option<&SharedWorld>,
    ) -> Result<(Summary, Answer, Printer), LogError> {
        let began = watch.now();
        loop {
            if self.acknowledging.take() {
                watch.acknowledge();
            }
            if watch.poll_with(|position| world?.insight(position)).is_none() {
                break;
            }
            let poll = watch.latest();
            self.poll(poll)?;
            self.faults.take(poll);
            let caused = self.causes.take(poll, watch.subjects());
            self.causes(caused, poll.at)?;
            for event in self.turned_round.take(&watch, &self.calendar) {
                self.event(&event)?;
            }
            let now = Clock::now();
            if now.duration_since(self.flushed) >= FLUSH_EVERY {
                self.flushed = now;
                self.flush()?;
            }
            if now.duration_since(self.shown) >= SHOW_EVERY {
                self.shown = now;
                self.show(poll.at.since(began));
            }
            if self.arguments.exit_on_fault && self.faults.first().is_some() {
                break;
            }
        }
        let rest = self.causes.rest(watch.subjects());
        self.causes(rest, watch.now())?;
        self.history(watch.end())?;
        self.flush()?;
        let verdicts = Judgement::WORDS.into_iter().zip(self.verdicts).filter(|(_, polls)| *polls > 0);
        let summary = Summary {
            file: self.arguments.file.display().to_string(),
            rows: self.log.rows(),
            polls: self.polls,
            time_ns: watch.now().since(began).as_nanos(),
            files: self.log.files(),
            verdicts: verdicts.map(|(verdict, polls)| Count { verdict, polls }).collect(),
            fault: self.faults.first().filter(|_| self.arguments.exit_on_fault).cloned(),
        };
        let answer = looked(&watch, self.arguments.exit_on_fault.then_some(&self.faults));
        Ok((summary, answer, self.notes))
    }

    fn poll(&mut self, poll: &Poll) -> Result<(), LogError> {
        self.polls += 1;
        self.history(poll)?;
        let regular = poll.due >= self.due;
        if regular {
            self.due = poll.due + self.arguments.every;
        }
        for (k, sight) in poll.sights.iter().enumerate() {
            if let Some(count) = self.verdicts.get_mut(sight.verdict.number()) {
                *count += 1;
            }
            let changed = self.before.get(k).is_none_or(|(.., verdict)| *verdict != sight.verdict.word());
            if regular || changed {
                self.row(k, sight, poll.diagnosis)?;
            }
        }
        Ok(())
    }

    /// What happened to the link and the ring, into the log and beside it. Of an encoder its rows say
    /// what happened; only a jump is for somebody to know.
    fn history(&mut self, poll: &Poll) -> Result<(), LogError> {
        for event in news(poll, &self.calendar, &self.acknowledging).iter().filter(|event| event.lasting) {
            self.event(event)?;
        }
        self.unread(poll)
    }

    /// Why positions jumped.
    fn causes(&mut self, caused: Vec<Caused>, at: Instant) -> Result<(), LogError> {
        for caused in caused {
            let event = News::of_cause(caused, at, &self.calendar);
            self.event(&event)?;
        }
        Ok(())
    }

    fn event(&mut self, event: &News) -> Result<(), LogError> {
        let text = event.to_string();
        let line = format!("event {}: {}", event.event, text.trim_start());
        self.written(|log| log.remark(&line))?;
        self.note(event.advised().trim_start());
        Ok(())
    }

    /// Why nothing can be read, where the end of a connection does not tell it; each reason once.
    fn unread(&mut self, poll: &Poll) -> Result<(), LogError> {
        let why = poll.sights.iter().find_map(|sight| match &sight.verdict {
            Judgement::NoAnswer(BusError::NoConnection(cause)) => {
                Some((cause.settled().to_string(), sight.at))
            }
            Judgement::NoAnswer(BusError::NoAnswer { .. }) => None,
            Judgement::NoAnswer(error) => Some((error.to_string(), sight.at)),
            _ => None,
        });
        let Some((why, at)) = why.filter(|(why, _)| self.unread.as_ref() != Some(why)) else {
            return Ok(());
        };
        let news = News::of_ring("not_read", at, &self.calendar, &why);
        self.unread = Some(why);
        self.event(&news)
    }

    fn note(&mut self, text: &str) {
        // Whoever closed standard error does not want to know.
        let _ = self.notes.print(format!("note: {}: {text}\n", self.place));
    }

    fn row(&mut self, k: usize, sight: &Sight, diagnosis: Diagnosis) -> Result<(), LogError> {
        let row = LogRow {
            time_ns: sight.at.as_nanos(),
            position: sight.position,
            out: sight.out.map(|out| out.0),
            input: sight.input.map(|input| input.0),
            verdict: sight.verdict.word(),
            value: sight.verdict.value(),
            status: diagnosis.status,
            parameter: diagnosis.parameter,
        };
        // Every file begins with all encoders.
        let now = (self.log.files().max(1), row.out, row.input, row.verdict);
        match self.before.get_mut(k) {
            Some(before) if *before == now && self.arguments.changes => return Ok(()),
            Some(before) => *before = now,
            None => self.before.push(now),
        }
        self.written(|log| log.write(&row))
    }

    fn flush(&mut self) -> Result<(), LogError> {
        self.written(Log::flush)
    }

    /// A pipe has a reader that may take nothing, a file has none.
    fn written(&mut self, write: impl FnOnce(&mut Log) -> Result<(), LogError>) -> Result<(), LogError> {
        if self.log.is_special() { awaiting_reader(|| write(&mut self.log)) } else { write(&mut self.log) }
    }

    fn show(&self, passed: Duration) {
        let (rows, files) = (self.log.rows(), self.log.files());
        self.progress.show(passed, || format!("{rows} rows, {} s, file {files}", seconds(passed.as_nanos())));
    }
}
