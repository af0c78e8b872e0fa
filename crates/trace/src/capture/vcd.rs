//! Value change dumps, IEEE 1364.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader, Read};
use std::ops::ControlFlow;

use super::{CHANNELS_MAX, CaptureChange, CaptureEnd, CapturePlace, CaptureProblem, Told, Wrong, wrong_line};

/// The longest word that is looked at; a longer one is none of ours.
const TOKEN_MAX: usize = 4_096;

/// The longest name of a channel, scopes included, in bytes.
const NAME_MAX: usize = 4_096;

/// What the head says.
pub(super) struct Head {
    /// A unit of time in femtoseconds.
    unit_fs: u64,
    /// Of each channel the code of its changes.
    codes: Vec<Vec<u8>>,
}

const FS_OF_NS: u64 = 1_000_000;

impl Head {
    pub(super) const fn resolution_ns(&self) -> u64 {
        if self.unit_fs < FS_OF_NS { 1 } else { self.unit_fs / FS_OF_NS }
    }

    fn time_ns(&self, time: u64) -> Option<u64> {
        u64::try_from(u128::from(time) * u128::from(self.unit_fs) / u128::from(FS_OF_NS)).ok()
    }
}

/// The words of a file, which blanks and line ends part.
struct Tokens<R> {
    source: BufReader<R>,
    line: u64,
    token: Vec<u8>,
    /// The last token was ended by something.
    is_ended: bool,
    /// Line ends that belong behind the token.
    behind: u64,
}

impl<R: Read> Tokens<R> {
    fn new(source: R) -> Self {
        let source = BufReader::with_capacity(64 * 1024, source);
        Self { source, line: 1, token: Vec::new(), is_ended: true, behind: 0 }
    }

    /// Goes to the next word; `false` at the end of the file.
    fn advance(&mut self) -> Result<bool, Wrong> {
        self.token.clear();
        self.line += std::mem::take(&mut self.behind);
        loop {
            let line = self.line;
            let buffer = match self.source.fill_buf() {
                Ok(buffer) => buffer,
                Err(cause) if cause.kind() == std::io::ErrorKind::Interrupted => continue,
                Err(cause) => return Err((CapturePlace::Line(line), cause.into())),
            };
            if buffer.is_empty() {
                self.is_ended = false;
                return Ok(!self.token.is_empty());
            }
            let mut used = 0;
            let mut ended = false;
            for byte in buffer {
                used += 1;
                if !byte.is_ascii_whitespace() {
                    if self.token.len() < TOKEN_MAX {
                        self.token.push(*byte);
                    }
                    continue;
                }
                let lines = u64::from(*byte == b'\n');
                if self.token.is_empty() {
                    self.line += lines;
                } else {
                    self.behind = lines;
                    ended = true;
                    break;
                }
            }
            self.source.consume(used);
            if ended {
                self.is_ended = true;
                return Ok(true);
            }
        }
    }

    /// The words up to `$end`, a few of them at most.
    fn section(&mut self) -> Result<Vec<String>, Wrong> {
        let begun = self.line;
        let mut words = Vec::new();
        while self.advance()? {
            if self.token == b"$end" {
                return Ok(words);
            }
            if words.len() < 16 {
                words.push(String::from_utf8_lossy(&self.token).into_owned());
            }
        }
        Err(wrong_line(begun, "the file ends before the $end of what begins here: it was cut"))
    }

    fn text(&self) -> String {
        crate::error::excerpt(&self.token)
    }
}

/// Femtoseconds of `1 ns`, `10us` and the like.
fn timescale(words: &[String]) -> Option<u64> {
    let text: String = words.concat();
    let at = text.find(|sign: char| !sign.is_ascii_digit())?;
    let number = match text.get(..at)? {
        "1" => 1,
        "10" => 10,
        "100" => 100,
        _ => return None,
    };
    let unit: u64 = match text.get(at..)? {
        "s" => 1_000_000_000_000_000,
        "ms" => 1_000_000_000_000,
        "us" => 1_000_000_000,
        "ns" => 1_000_000,
        "ps" => 1_000,
        "fs" => 1,
        _ => return None,
    };
    Some(number * unit)
}

/// The name of a signal of one bit; `None` for another one. `scopes` stand before it.
fn channel(words: &[String], scopes: &[String]) -> Option<(Vec<u8>, String)> {
    let [_, width, code, name, range @ ..] = words else { return None };
    if width != "1" {
        return None;
    }
    let range = range.first().filter(|range| range.starts_with('[')).map_or("", String::as_str);
    let parts = scopes.iter().map(String::as_str).chain([name.as_str()]);
    let name = parts.collect::<Vec<_>>().join(".") + range;
    Some((code.clone().into_bytes(), name))
}

/// Reads up to `$enddefinitions`.
pub(super) fn head<R: Read>(source: R) -> Result<(Head, Vec<String>), Wrong> {
    let mut tokens = Tokens::new(source);
    let (mut unit_fs, mut codes, mut names) = (None, Vec::new(), Vec::new());
    let mut known = BTreeSet::new();
    let mut scopes: Vec<String> = Vec::new();
    while tokens.advance()? {
        let line = tokens.line;
        match tokens.token.as_slice() {
            b"$timescale" => {
                let words = tokens.section()?;
                let unit = timescale(&words).ok_or_else(|| {
                    let found = words.join(" ");
                    wrong_line(
                        line,
                        format!("timescale {found:?}: it is 1, 10 or 100 and s, ms, us, ns, ps or fs"),
                    )
                })?;
                unit_fs = Some(unit);
            }
            b"$scope" => {
                let words = tokens.section()?;
                scopes.push(words.get(1).cloned().unwrap_or_default());
                if scopes.len() > 64 {
                    return Err(wrong_line(line, "more than 64 scopes within one another"));
                }
            }
            b"$upscope" => {
                tokens.section()?;
                scopes.pop();
            }
            b"$var" => {
                let words = tokens.section()?;
                // A simulator names a wire in every scope that it passes; it is one line, by its first name.
                if let Some((code, name)) = channel(&words, &scopes)
                    && known.insert(code.clone())
                {
                    if names.len() == CHANNELS_MAX {
                        return Err(wrong_line(line, format!("more than {CHANNELS_MAX} single bits")));
                    }
                    if name.len() > NAME_MAX {
                        let problem =
                            format!("a name of {} bytes with its scopes, at most {NAME_MAX}", name.len());
                        return Err(wrong_line(line, problem));
                    }
                    codes.push(code);
                    names.push(name);
                }
            }
            b"$enddefinitions" => {
                tokens.section()?;
                let missing =
                    || wrong_line(line, "no $timescale before it, so no time in the file means anything");
                return Ok((Head { unit_fs: unit_fs.ok_or_else(missing)?, codes }, names));
            }
            [b'$', ..] => drop(tokens.section()?),
            _ => {
                let problem = format!("{:?} before $enddefinitions", tokens.text());
                return Err(wrong_line(line, problem));
            }
        }
    }
    Err(wrong_line(tokens.line, "the file ends before $enddefinitions: it was cut"))
}

/// What a change of one bit shows.
const fn level(sign: u8) -> Option<(bool, bool)> {
    match sign {
        b'0' => Some((false, true)),
        b'1' => Some((true, true)),
        b'x' | b'X' | b'z' | b'Z' => Some((false, false)),
        _ => None,
    }
}

/// The changes of the selected channels under way.
struct Levels<'a> {
    bits: BTreeMap<&'a [u8], u64>,
    /// Most files use few codes of one sign: these without a search.
    short: Box<[u64; 256]>,
    high: u64,
    known: u64,
}

impl<'a> Levels<'a> {
    fn new(head: &'a Head, selected: &[usize]) -> Self {
        let mut bits: BTreeMap<&[u8], u64> = BTreeMap::new();
        let mut short = Box::new([0; 256]);
        for (channel, bit) in selected.iter().zip(0..) {
            let Some(code) = head.codes.get(*channel) else { continue };
            *bits.entry(code).or_default() |= 1 << bit;
            if let [sign] = code[..]
                && let Some(place) = short.get_mut(usize::from(sign))
            {
                *place |= 1 << bit;
            }
        }
        Self { bits, short, high: 0, known: 0 }
    }

    fn set(&mut self, code: &[u8], (high, known): (bool, bool)) {
        let bits = match code {
            [sign] => self.short.get(usize::from(*sign)).copied().unwrap_or_default(),
            code => self.bits.get(code).copied().unwrap_or_default(),
        };
        self.high = if high { self.high | bits } else { self.high & !bits };
        self.known = if known { self.known | bits } else { self.known & !bits };
    }
}

/// A word of the body.
enum Body<'a> {
    Time(u64),
    Bit(&'a [u8], (bool, bool)),
    /// A vector, a real or a text: its code comes next.
    Wide,
    Section,
    Block,
}

#[expect(clippy::disallowed_methods, reason = "the time stamps of a VCD are 64 bits of decimal digits")]
fn body(token: &[u8]) -> Option<Body<'_>> {
    match token {
        [b'#', digits @ ..] => {
            let text = str::from_utf8(digits).ok().filter(|text| !text.starts_with('+'))?;
            text.parse().ok().map(Body::Time)
        }
        [b'b' | b'B' | b'r' | b'R' | b's' | b'S', _, ..] => Some(Body::Wide),
        b"$dumpvars" | b"$dumpall" | b"$dumpon" | b"$dumpoff" | b"$end" => Some(Body::Block),
        [b'$', ..] => Some(Body::Section),
        [sign, code @ ..] if !code.is_empty() => level(*sign).map(|level| Body::Bit(code, level)),
        _ => None,
    }
}

/// Reads the whole file.
pub(super) fn changes<R: Read, F: FnMut(CaptureChange) -> ControlFlow<()>>(
    source: R,
    head: &Head,
    selected: &[usize],
    told: &mut Told<F>,
) -> Result<CaptureEnd, Wrong> {
    let mut tokens = Tokens::new(source);
    while tokens.advance()? && tokens.token != b"$enddefinitions" {}
    tokens.section()?;
    let mut levels = Levels::new(head, selected);
    let (mut time, mut time_ns) = (0, 0);
    while tokens.advance()? {
        let line = tokens.line;
        // Where the file breaks off, what stands last may be a piece.
        let cut = Ok(CaptureEnd { time_ns, cut_in_line: Some(line) });
        match body(&tokens.token) {
            Some(Body::Time(next)) if next >= time => {
                if next > time && told.tell(time_ns, levels.high, levels.known).is_break() {
                    return Ok(CaptureEnd { time_ns, cut_in_line: None });
                }
                let in_ns = head.time_ns(next);
                time_ns = in_ns.ok_or_else(|| wrong_line(line, format!("time {next} is too far away")))?;
                time = next;
            }
            Some(Body::Time(_)) | None if !tokens.is_ended => return cut,
            Some(Body::Time(next)) => {
                return Err(wrong_line(line, format!("time {next} is before {time}, the time before it")));
            }
            Some(Body::Bit(code, level)) => levels.set(code, level),
            Some(Body::Block) => {}
            Some(Body::Wide) => {
                let _code = tokens.advance()?;
            }
            Some(Body::Section) => drop(tokens.section()?),
            None => {
                let problem = format!("{:?} is neither a time nor a change", tokens.text());
                return Err((CapturePlace::Line(line), CaptureProblem::Refused(problem)));
            }
        }
    }
    let _ = told.tell(time_ns, levels.high, levels.known);
    Ok(CaptureEnd { time_ns, cut_in_line: None })
}
