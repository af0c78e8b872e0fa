//! The live view, drawn from plain data.

use std::collections::VecDeque;

use encoring_bus::{Blind, Judgement};
use encoring_station::view::LampsView;
use encoring_words::word::{DATA, ERROR_BIT, READ_WRITE_BIT, RESERVE_BIT, SERVICE, SERVICE_BIT};
use encoring_words::{Duration, Service};
use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::{Block, BorderType, Paragraph};

use super::About;
use super::seen::Seen;
use crate::news::News;
use crate::output::time::{seconds, span};
use crate::output::wrap;

/// The last events that are kept.
const NEWS_KEPT: usize = 50;
/// More encoders than this begin as a list.
const BLOCKS_MAX: usize = 8;

/// What is on the screen.
pub(crate) struct Screen {
    about: About,
    shown: Vec<Shown>,
    news: VecDeque<News>,
    polls: u64,
    /// Something has come that is to be seen at once: a verdict that has changed, or an event.
    urgent: bool,
    /// The last event of the link.
    link: Option<&'static str>,
    /// The first encoder that is shown.
    pub(crate) first: usize,
    /// `None`: as there are few or many.
    list: Option<bool>,
    /// How many encoders were seen whole when it was last drawn.
    page: usize,
}

struct Shown {
    seen: Seen,
    /// The last position, and when it was.
    last: Option<(u32, u64)>,
}

/// What a poll brought.
pub(crate) struct Update {
    pub(crate) polls: u64,
    pub(crate) seen: Vec<Seen>,
    pub(crate) news: Vec<News>,
}

impl Screen {
    pub(crate) fn new(about: About) -> Self {
        Self {
            about,
            shown: Vec::new(),
            news: VecDeque::new(),
            polls: 0,
            urgent: true,
            link: None,
            first: 0,
            list: None,
            page: 1,
        }
    }

    pub(crate) fn take(&mut self, update: Update) {
        self.polls = update.polls;
        self.urgent |= !update.news.is_empty();
        for seen in update.seen {
            let old = self.shown.iter_mut().find(|shown| shown.seen.position == seen.position);
            let before = old.as_ref().and_then(|old| old.last);
            let last = seen.value.map(|value| (value, seen.time_ns)).or(before);
            self.urgent |= old.as_ref().is_none_or(|old| old.seen.verdict != seen.verdict);
            match old {
                Some(old) => *old = Shown { seen, last },
                None => self.shown.push(Shown { seen, last }),
            }
        }
        for news in update.news {
            if news.event.starts_with("link") {
                self.link = Some(news.event);
            }
            // One attempt after the other would drive out what was before.
            if news.event == "link_failed" && self.news.back().is_some_and(|last| last.event == "link_failed")
            {
                self.news.pop_back();
            }
            if self.news.len() == NEWS_KEPT {
                self.news.pop_front();
            }
            self.news.push_back(news);
        }
    }

    /// Whether what came since it was last drawn is to be seen at once.
    pub(crate) const fn is_urgent(&self) -> bool {
        self.urgent
    }

    fn is_list(&self) -> bool {
        self.list.unwrap_or(self.shown.len() > BLOCKS_MAX)
    }

    pub(crate) fn change_view(&mut self) {
        self.list = Some(!self.is_list());
        self.first = 0;
    }

    pub(crate) fn scroll(&mut self, way: Way) {
        let end = self.shown.len().saturating_sub(1);
        self.first = match way {
            Way::Up => self.first.saturating_sub(1),
            Way::Down => self.first + 1,
            Way::PageUp => self.first.saturating_sub(self.page),
            Way::PageDown => self.first + self.page,
            Way::Begin => 0,
            Way::End => end,
        }
        .min(end);
    }

    /// Draws everything; the last poll was `ago`.
    pub(crate) fn draw(&mut self, frame: &mut Frame<'_>, ago: Duration) {
        self.urgent = false;
        let area = frame.area();
        let events = match area.height {
            0..20 => 0,
            20..34 => self.news.len().min(2),
            _ => self.news.len().min(5),
        };
        let told: Vec<_> = self.told(events, usize::from(area.width)).into_iter().map(Line::raw).collect();
        let [head, body, news, foot] = Layout::vertical([
            Constraint::Length(1),
            Constraint::Min(0),
            Constraint::Length(told.len() as u16),
            Constraint::Length(1),
        ])
        .areas(area);
        let whole = if self.is_list() { self.list(frame, body) } else { self.blocks(frame, body) };
        self.page = whole.max(1);
        self.head(frame, head, ago);
        frame.render_widget(Paragraph::new(told).style(Style::new().fg(Color::Yellow)), news);
        self.foot(frame, foot, whole);
    }

    /// The newest events, at most so many and in twice as many lines; the last one whole before an older one begins.
    fn told(&self, events: usize, width: usize) -> Vec<String> {
        let mut told = VecDeque::new();
        for news in self.news.iter().rev().take(events) {
            let lines = behind_a_space(&format!("{}  {}", news.date, news.told()), width);
            if !told.is_empty() && told.len() + lines.len() > 2 * events {
                break;
            }
            lines.into_iter().rev().for_each(|line| told.push_front(line));
        }
        told.into()
    }

    fn head(&self, frame: &mut Frame<'_>, area: Rect, ago: Duration) {
        let state = match self.link {
            _ if self.about.simulated => "a simulation",
            Some("link_up") => "connected",
            Some(_) => "NOT CONNECTED",
            None => "",
        };
        let right = format!("every {}, last {} ago ", self.about.every, span(ago));
        // Of an address that is too long the end goes, and not what is said behind it.
        let width = usize::from(area.width);
        let room = width.saturating_sub(state.chars().count() + 3);
        let address = shortened(&self.about.address, room);
        let left = format!(" {address}  {state}");
        frame.render_widget(ends(&left, &right, area.width).style(Modifier::REVERSED), area);
    }

    fn foot(&self, frame: &mut Frame<'_>, area: Rect, whole: usize) {
        let last = (self.first + whole).min(self.shown.len());
        let which = match self.shown.len() {
            0 => "waiting for the first poll ".to_owned(),
            all if whole < all => format!("{}-{last} of {all} encoders ", self.first + 1),
            _ => format!("poll {} ", self.polls),
        };
        let keys = " q quit  a acknowledge  arrows scroll  l list or blocks";
        frame.render_widget(ends(keys, &which, area.width).style(Modifier::REVERSED), area);
    }

    /// Draws blocks, and says how many encoders were seen whole.
    fn blocks(&mut self, frame: &mut Frame<'_>, area: Rect) -> usize {
        let width = usize::from(area.width.saturating_sub(2));
        let small: usize = self.shown.iter().map(|shown| lines(shown, width, Size::Small).len() + 2).sum();
        let height = usize::from(area.height);
        let size = if small + 2 * self.shown.len() <= height { Size::Big } else { Size::Small };
        let blocks: Vec<_> = self.shown.iter().map(|shown| lines(shown, width, size)).collect();
        // Not further than that the last one is at the bottom.
        let mut room = height;
        let fitting = blocks.iter().rev().take_while(|lines| {
            let fits = room >= lines.len() + 2;
            room = room.saturating_sub(lines.len() + 2);
            fits
        });
        self.first = self.first.min(blocks.len().saturating_sub(fitting.count().max(1)));
        let (mut y, mut whole) = (area.y, 0);
        for (shown, lines) in self.shown.iter().zip(blocks).skip(self.first) {
            let wanted = lines.len() as u16 + 2;
            let room = area.bottom().saturating_sub(y);
            if room < 3 {
                break;
            }
            let place = Rect { y, height: wanted.min(room), ..area };
            whole += usize::from(wanted <= room);
            y += place.height;
            let style = mood(&shown.seen.sight.verdict);
            let seen = &shown.seen;
            let title =
                format!(" position {}  device {}  {} ", seen.position, seen.device_number, seen.model);
            let block = Block::bordered()
                .border_type(BorderType::Plain)
                .border_style(style)
                .title_top(Line::styled(title, Modifier::BOLD))
                .title_top(Line::styled(format!(" {} ", seen.verdict), style.bold()).right_aligned());
            frame.render_widget(Paragraph::new(lines).block(block), place);
        }
        whole
    }

    /// Draws a line for each encoder, and says for how many.
    fn list(&mut self, frame: &mut Frame<'_>, area: Rect) -> usize {
        let rows = usize::from(area.height.saturating_sub(1));
        self.first = self.first.min(self.shown.len().saturating_sub(rows.max(1)));
        let head = " at  model     position  verdict               OUT       IN        handshake";
        let mut page = vec![Line::styled(head, Modifier::BOLD)];
        for Shown { seen, .. } in self.shown.iter().skip(self.first).take(rows) {
            let word = |word: &Option<String>| word.clone().unwrap_or_else(|| "-".to_owned());
            let value = seen.value.map_or_else(|| "-".to_owned(), |value| value.to_string());
            let left = format!("{:>3}  {:<8}  {value:>8}  ", seen.position, seen.model);
            let right =
                format!("  {:<8}  {:<8}  {}", word(&seen.out), word(&seen.input), seen.phase.unwrap_or("-"));
            let verdict = format!("{:<20}", seen.verdict);
            let used = left.len() + verdict.len() + right.len() + 2;
            let mut line =
                vec![Span::raw(left), Span::styled(verdict, mood(&seen.sight.verdict)), Span::raw(right)];
            let room = usize::from(area.width).saturating_sub(used);
            if room >= 8 && seen.text.is_empty() {
                line.push(Span::raw(format!("  {}", bar(seen, room))));
            } else if let Some(text) = seen.text.first().filter(|_| room >= 8) {
                line.push(Span::raw(format!("  {text}")));
            }
            page.push(Line::from(line));
        }
        let shown = page.len() - 1;
        frame.render_widget(Paragraph::new(page), area);
        shown
    }
}

/// A way to scroll.
#[derive(Clone, Copy)]
pub(crate) enum Way {
    Up,
    Down,
    PageUp,
    PageDown,
    Begin,
    End,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Size {
    Small,
    Big,
}

const fn mood(verdict: &Judgement) -> Style {
    let color = match verdict {
        Judgement::Valid(_) => Color::Green,
        Judgement::Unchecked(_) => Color::Cyan,
        Judgement::InService => Color::Blue,
        Judgement::Stale { .. } | Judgement::RingStopped(_) | Judgement::NoAnswer(_) => Color::Yellow,
        Judgement::Faulty(_) | Judgement::Implausible(_) => Color::Red,
    };
    Style::new().fg(color)
}

/// As much of a text as there is room for.
fn shortened(text: &str, room: usize) -> String {
    if text.chars().count() <= room {
        return text.to_owned();
    }
    text.chars().take(room.saturating_sub(1)).chain(['…']).collect()
}

/// A line with something at both ends; the right one goes if there is no room.
fn ends(left: &str, right: &str, width: u16) -> Line<'static> {
    let (used, width) = (left.chars().count() + right.chars().count(), usize::from(width));
    if used < width {
        Line::raw(format!("{left}{}{right}", " ".repeat(width - used)))
    } else {
        Line::raw(format!("{left:<width$}"))
    }
}

/// What stands in the block of an encoder.
fn lines(shown: &Shown, width: usize, size: Size) -> Vec<Line<'static>> {
    let seen = &shown.seen;
    let mut lines = position(shown, width, size);
    lines.push(word("OUT", seen.sight.out.map(|out| out.0), width));
    lines.push(word("IN", seen.sight.input.map(|input| input.0), width));
    let age = seen.sight.age.map_or_else(|| "no word".to_owned(), |age| format!("word {} old", span(age)));
    let phase = seen.sight.phase();
    let phase = phase.map_or_else(
        || "handshake not seen".to_owned(),
        |phase| format!("step {} of 5: {}", phase.step(), phase.name()),
    );
    let mut state = vec![Span::raw(format!(" {phase:<26} "))];
    state.extend(lamps(seen.lamps));
    state.push(Span::raw(format!("  {age}")));
    lines.push(Line::from(state));
    let style = mood(&seen.sight.verdict);
    for text in &seen.text {
        lines.extend(behind_a_space(text, width).into_iter().map(|text| Line::styled(text, style)));
    }
    if let Judgement::Implausible(why) = seen.sight.verdict
        && why.is_step()
    {
        let text = "if you know why and the position is right now: key a acknowledges the jump";
        lines.extend(behind_a_space(text, width).into_iter().map(|text| Line::styled(text, style)));
    }
    for cause in &seen.causes {
        lines.extend(behind_a_space(&cause.to_string(), width).into_iter().map(Line::raw));
    }
    for text in blindness(&seen.blind) {
        lines.extend(behind_a_space(&text, width).into_iter().map(|text| Line::styled(text, Modifier::DIM)));
    }
    lines
}

/// What cannot be judged, and why.
fn blindness(blind: &[Blind]) -> Vec<String> {
    let mut told = Vec::new();
    let unknown = |blind: &&Blind| matches!(blind, Blind::Code | Blind::Range | Blind::Motion);
    let unknown: Vec<_> = blind.iter().filter(unknown).map(|blind| blind.name()).collect();
    if !unknown.is_empty() {
        let why = match blind.contains(&Blind::Changed) {
            true => "parameters were written since",
            false => "parameters not known",
        };
        told.push(format!("cannot judge: {} ({why})", unknown.join(", ")));
    }
    if blind.contains(&Blind::Slow) {
        told.push("cannot judge: jumps (half of the range can be travelled between two polls)".to_owned());
    }
    if blind.contains(&Blind::Ring) {
        told.push("cannot judge: whether the ring runs (the master's diagnosis was not read)".to_owned());
    }
    told
}

fn position(shown: &Shown, width: usize, size: Size) -> Vec<Line<'static>> {
    let seen = &shown.seen;
    let style = mood(&seen.sight.verdict).bold();
    let number = seen.value.map_or_else(|| "-".to_owned(), |value| value.to_string());
    let beside = |room: usize| match (seen.value, shown.last, seen.measuring_length) {
        (Some(_), _, Some(length)) => {
            let of = format!(" of {length}  ");
            let room = room.saturating_sub(of.len() + 1);
            format!("{of}{}", bar(seen, room))
        }
        (Some(_), _, None) => " steps; the measuring length is not known".to_owned(),
        (None, Some((last, time_ns)), _) => {
            format!(" no position; the last was {last}, at {} s", seconds(time_ns))
        }
        (None, None, _) => " no position yet".to_owned(),
    };
    if size == Size::Small {
        let number = format!("{number:>9}");
        let rest = beside(width.saturating_sub(number.len()));
        return vec![Line::from(vec![Span::styled(number, style), Span::raw(rest)])];
    }
    let rows = digits(&number);
    let taken = rows.iter().map(|row| row.chars().count()).max().unwrap_or(0);
    rows.into_iter()
        .enumerate()
        .map(|(k, row)| {
            let rest = if k == 2 { beside(width.saturating_sub(taken)) } else { String::new() };
            Line::from(vec![Span::styled(row, style), Span::raw(rest)])
        })
        .collect()
}

/// The position within the measuring length.
fn bar(seen: &Seen, width: usize) -> String {
    let (Some(value), Some(length)) = (seen.value, seen.measuring_length) else { return String::new() };
    let per_mille = u64::from(value) * 1_000 / u64::from(length.max(1));
    let percent = format!(" {:>3}.{} %", per_mille / 10, per_mille % 10);
    let width = width.saturating_sub(percent.len());
    let full = usize::try_from(per_mille).unwrap_or(width).min(1_000) * width / 1_000;
    format!("{}{}{percent}", "█".repeat(full), "░".repeat(width - full))
}

/// A word with its six fields.
fn word(name: &str, word: Option<u32>, width: usize) -> Line<'static> {
    let Some(word) = word else { return Line::raw(format!(" {name:<3} not seen")) };
    let service = SERVICE.of(word);
    let mut text = format!(
        " {name:<3} {word:08X}  service {}  write {}  error {}  reserve {}  number {service:02X} data {:06X}h",
        SERVICE_BIT.of(word),
        READ_WRITE_BIT.of(word),
        ERROR_BIT.of(word),
        RESERVE_BIT.of(word),
        DATA.of(word)
    );
    let more = match Service::from_number(service as u8) {
        Some(service) if SERVICE_BIT.of(word) == 1 => format!(" = {}, {}", DATA.of(word), service.name()),
        _ => format!(" = {}", DATA.of(word)),
    };
    if text.len() + more.len() <= width {
        text += &more;
    }
    Line::raw(text)
}

fn lamps(lamps: Option<LampsView>) -> Vec<Span<'static>> {
    let Some(LampsView { u, ba, rc, rd }) = lamps else {
        return vec![Span::raw("lamps cannot be seen from here")];
    };
    let lamp = |name: &'static str, on: bool| match on {
        true => Span::styled(format!("{name} on  "), Style::new().fg(Color::Green).bold()),
        false => Span::styled(format!("{name} off "), Modifier::DIM),
    };
    vec![lamp("U", u), lamp("BA", ba), lamp("RC", rc), lamp("RD", rd)]
}

/// A text in lines of a width, behind a space.
fn behind_a_space(text: &str, width: usize) -> Vec<String> {
    wrap::lines(text, width.saturating_sub(1)).into_iter().map(|line| format!(" {line}")).collect()
}

/// A number in digits of three rows.
fn digits(number: &str) -> [String; 3] {
    const DIGITS: [[&str; 3]; 10] = [
        [" _ ", "| |", "|_|"],
        ["   ", "  |", "  |"],
        [" _ ", " _|", "|_ "],
        [" _ ", " _|", " _|"],
        ["   ", "|_|", "  |"],
        [" _ ", "|_ ", " _|"],
        [" _ ", "|_ ", "|_|"],
        [" _ ", "  |", "  |"],
        [" _ ", "|_|", "|_|"],
        [" _ ", "|_|", " _|"],
    ];
    let mut rows = [const { String::new() }; 3];
    for _ in number.len()..8 {
        rows.iter_mut().for_each(|row| row.push_str("    "));
    }
    for digit in number.chars() {
        let digit = digit.to_digit(10).and_then(|digit| DIGITS.get(digit as usize));
        for (row, part) in rows.iter_mut().zip(digit.unwrap_or(&["   ", " _ ", "   "])) {
            row.push(' ');
            row.push_str(part);
        }
    }
    rows
}
