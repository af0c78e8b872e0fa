//! What `encoring sim` prints.

use std::fmt::Write;
use std::io;

use encoring_modbus::{RegisterMap, Snapshot};
use encoring_station::{RefereeView, RingEvent, View};
use encoring_words::Duration;
use serde::Serialize;

use crate::output::Format;
use crate::output::printer::{Closing, Printer};

/// What is printed, and how far it is.
pub(super) struct Report {
    format: Format,
    layout: RegisterMap,
    out: Printer,
    /// For what is lost outside the ring.
    err: Printer,
    /// Number of the first event not yet told.
    next_event: u64,
    counters: Option<Duration>,
    next_counters_ns: u64,
}

/// Where the servers listen.
pub(super) struct Addresses {
    pub(super) modbus: Option<String>,
    pub(super) control: Option<String>,
    pub(super) web: Option<String>,
}

/// The first line for programs.
#[derive(Serialize)]
struct Listening<'a> {
    event: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    modbus: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    control: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    web: Option<&'a str>,
}

/// A line of counters for programs, and the last of all.
#[derive(Serialize)]
struct CountersLine<'a> {
    event: &'static str,
    time_ns: u64,
    #[serde(flatten)]
    counters: encoring_station::view::Counters,
    segment_faults: &'a [u16],
}

impl<'a> CountersLine<'a> {
    fn new(event: &'static str, view: &'a View) -> Self {
        let segment_faults = view.diagnosis.segment_faults.as_slice();
        Self { event, time_ns: view.time_ns, counters: view.counters, segment_faults }
    }
}

/// What the Modbus server has seen, the line before the last.
#[derive(Serialize)]
struct Served {
    event: &'static str,
    requests: u64,
    exceptions: u64,
    closed: Closed,
    accept_errors: u64,
}

/// Connections that the server closed, and why.
#[derive(Serialize)]
struct Closed {
    bad_frames: u64,
    idle: u64,
    too_many: u64,
}

impl From<Snapshot> for Served {
    fn from(seen: Snapshot) -> Self {
        Self {
            event: "served",
            requests: seen.requests,
            exceptions: seen.exceptions,
            closed: Closed {
                bad_frames: seen.closed_bad_frames,
                idle: seen.closed_idle,
                too_many: seen.refused_connections,
            },
            accept_errors: seen.accept_errors,
        }
    }
}

impl Served {
    /// For people: only what there was.
    fn text(&self) -> String {
        let Self { requests, exceptions, closed: Closed { bad_frames, idle, too_many }, .. } = self;
        let mut text = String::new();
        if *requests > 0 {
            text +=
                &format!("modbus: {requests} requests, {exceptions} of them answered with an exception\n");
        }
        if bad_frames + idle + too_many > 0 {
            text += &format!(
                "modbus: connections closed: {bad_frames} sent no Modbus, {idle} were idle, {too_many} were too many\n"
            );
        }
        if self.accept_errors > 0 {
            text +=
                &format!("modbus: {} connections that the system could not hand over\n", self.accept_errors);
        }
        text
    }
}

/// What the referees have found in all, before that.
#[derive(Serialize)]
struct Judged<'a> {
    event: &'static str,
    #[serde(flatten)]
    referee: &'a RefereeView,
}

/// For people: nothing if nobody asked for a service.
fn judged(RefereeView { services, findings, .. }: &RefereeView) -> String {
    let services = match services {
        0 if findings.is_empty() => return String::new(),
        1 => "1 service".to_owned(),
        services => format!("{services} services"),
    };
    if findings.is_empty() {
        return format!("referee: {services}, no rule of the handshake was broken\n");
    }
    let told: String = findings.iter().map(ToString::to_string).collect();
    format!("referee: {services}\n{told}")
}

fn json(line: &impl Serialize) -> io::Result<String> {
    Ok(serde_json::to_string(line)? + "\n")
}

impl Report {
    pub(super) fn new(format: Format, layout: RegisterMap, counters: Option<Duration>) -> io::Result<Self> {
        Ok(Self {
            format,
            layout,
            out: Printer::start(io::stdout(), format)?,
            err: Printer::start(io::stderr(), Format::Text)?,
            next_event: 0,
            counters,
            next_counters_ns: counters.map_or(0, Duration::as_nanos),
        })
    }

    pub(super) fn start(&mut self, view: &View, addresses: &Addresses) -> io::Result<()> {
        let Addresses { modbus, control, web } = addresses;
        let (modbus, control, web) = (modbus.as_deref(), control.as_deref(), web.as_deref());
        let text = match self.format {
            Format::Json => json(&Listening { event: "listening", modbus, control, web })?,
            Format::Text => {
                let mut text = self.table(view).map_err(io::Error::other)?;
                for (name, address) in [("modbus", modbus), ("control", control), ("web", web)] {
                    if let Some(address) = address {
                        text += &format!("{name} {address}\n");
                    }
                }
                text
            }
        };
        self.out.print(text)
    }

    /// The encoders and their registers.
    fn table(&self, view: &View) -> Result<String, std::fmt::Error> {
        let mut out = String::new();
        let encoders = match view.devices.len() {
            1 => "1 encoder".to_owned(),
            several => format!("{several} encoders"),
        };
        writeln!(
            out,
            "{encoders} on a simulated ring, a cycle every {}",
            Duration::from_nanos(view.cycle_ns)
        )?;
        let places = |position| self.layout.places(position, view.devices.len());
        let [out_head, in_head] = places(0).map(|(table, _)| table);
        // Registers of the Inline layout have four digits.
        let wide = if self.layout == RegisterMap::Inline { 10 } else { 8 };
        let in_head = format!("IN {in_head}");
        writeln!(out, "position  device  model     OUT {out_head}  {in_head:<wide$}  position now")?;
        for device in &view.devices {
            let [out_registers, in_registers] =
                places(device.position).map(|(_, first)| format!("{first}, {}", first + 1));
            writeln!(
                out,
                "{:>8}  {:<6}  {:<8}  {out_registers:<11}  {in_registers:<wide$}  {}",
                device.position,
                device.device_number,
                device.model.name(),
                device.value.map_or_else(|| "off".to_owned(), |value| value.to_string()),
            )?;
        }
        Ok(out)
    }

    /// Tells the events that were not told yet: trouble on standard error too, where people look for it.
    pub(super) fn events(&mut self, events: &[RingEvent]) -> io::Result<()> {
        self.out.check()?;
        for event in events {
            if event.number < self.next_event {
                continue;
            }
            self.next_event = event.number + 1;
            if event.what.is_trouble() {
                // Whoever closed standard error does not want to know.
                let _ = self.err.print(format!("note: {event}\n"));
            }
            match self.format {
                Format::Json => self.out.print(json(event)?)?,
                Format::Text if !event.what.is_trouble() => self.out.print(format!("{event}\n"))?,
                Format::Text => {}
            }
        }
        Ok(())
    }

    /// Number of the first event not yet told.
    pub(super) const fn next_event(&self) -> u64 {
        self.next_event
    }

    /// Whether counters are told at all.
    pub(super) const fn tells_counters(&self) -> bool {
        self.counters.is_some()
    }

    pub(super) fn counters(&mut self, view: &View) -> io::Result<()> {
        let (Some(every), true) = (self.counters, view.time_ns >= self.next_counters_ns) else {
            return Ok(());
        };
        let passed = view.time_ns.checked_div(every.as_nanos()).unwrap_or_default();
        self.next_counters_ns = every.as_nanos().saturating_mul(passed.saturating_add(1));
        let text = match self.format {
            Format::Json => json(&CountersLine::new("counters", view))?,
            Format::Text => {
                let counters = view.counters;
                let at = Duration::from_nanos(view.time_ns);
                format!(
                    "{at}: {} cycles, {} faulty, {} dropped\n",
                    counters.cycles, counters.faulty_cycles, counters.dropped_cycles
                )
            }
        };
        self.out.print(text)
    }

    /// Tells what the referees have found in all.
    pub(super) fn judged(&mut self, referee: &RefereeView) -> io::Result<()> {
        let text = match self.format {
            Format::Json => json(&Judged { event: "judged", referee })?,
            Format::Text => judged(referee),
        };
        self.out.print(text)
    }

    /// Tells what the Modbus server has seen.
    pub(super) fn served(&mut self, seen: Snapshot) -> io::Result<()> {
        let served = Served::from(seen);
        let text = match self.format {
            Format::Json => json(&served)?,
            Format::Text => served.text(),
        };
        self.out.print(text)
    }

    /// Tells the last counters.
    pub(super) fn stopped(&mut self, view: &View) -> io::Result<()> {
        let counters = view.counters;
        let text = match self.format {
            Format::Json => json(&CountersLine::new("stopped", view))?,
            Format::Text => {
                let mut text = format!(
                    "stopped after {} on the ring: {} cycles, {} faulty, {} dropped\n",
                    Duration::from_nanos(view.time_ns),
                    counters.cycles,
                    counters.faulty_cycles,
                    counters.dropped_cycles
                );
                let segments = view.diagnosis.segment_faults.iter().enumerate();
                for (segment, faults) in segments.filter(|(_, faults)| **faults > 0) {
                    text += &format!("faulty cycles on segment {segment}: {faults}\n");
                }
                text
            }
        };
        self.out.print(text)
    }

    /// Nothing more comes.
    pub(super) fn close(self) -> Closing {
        // Nobody waits for standard error.
        drop(self.err.close());
        self.out.close()
    }
}
