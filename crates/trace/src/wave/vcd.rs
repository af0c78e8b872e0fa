//! The text format.

use std::io::{self, Write};

use super::{BITS_MAX, Id, Signals, UNIT_NS, Value};

/// The characters of which codes are made.
const FIRST: u8 = b'!';
const CODES: u32 = (b'~' - b'!' + 1) as u32;

pub(super) struct Body<W> {
    sink: W,
    line: Vec<u8>,
    /// Wider signals are left out.
    widest: u32,
}

impl<W: Write> Body<W> {
    pub(super) fn new(mut sink: W, writer: &str, signals: &Signals) -> io::Result<Self> {
        let mut head = Vec::new();
        writeln!(head, "$version {writer} $end")?;
        for note in &signals.notes {
            writeln!(head, "$comment {note} $end")?;
        }
        writeln!(head, "$timescale {UNIT_NS} ns $end")?;
        writeln!(head, "$scope module {} $end", signals.top)?;
        let mut ids = (0..).map(Id);
        for (name, inside) in &signals.scopes {
            writeln!(head, "$scope module {name} $end")?;
            for (signal, id) in inside.iter().zip(&mut ids) {
                write!(head, "$var wire {} ", signal.width)?;
                code(id, &mut head);
                writeln!(head, " {}{} $end", signal.name, signal.range())?;
            }
            writeln!(head, "$upscope $end")?;
        }
        writeln!(head, "$upscope $end\n$enddefinitions $end")?;
        sink.write_all(&head)?;
        Ok(Self { sink, line: Vec::new(), widest: BITS_MAX })
    }

    /// Only what has one bit, in one scope.
    pub(super) fn levels(mut sink: W, writer: &str, signals: &Signals) -> io::Result<Self> {
        let mut head = Vec::new();
        writeln!(head, "$version {writer} $end")?;
        writeln!(head, "$timescale {UNIT_NS} ns $end")?;
        writeln!(head, "$scope module {} $end", signals.top)?;
        let mut ids = (0..).map(Id);
        for (scope, inside) in &signals.scopes {
            for (signal, id) in inside.iter().zip(&mut ids).filter(|(signal, _)| signal.width == 1) {
                write!(head, "$var wire 1 ")?;
                code(id, &mut head);
                writeln!(head, " {scope}_{} $end", signal.name)?;
            }
        }
        writeln!(head, "$upscope $end\n$enddefinitions $end")?;
        sink.write_all(&head)?;
        Ok(Self { sink, line: Vec::new(), widest: 1 })
    }

    /// What the signals show at time 0.
    pub(super) fn first(&mut self, signals: &[(u32, Value)]) -> io::Result<()> {
        let mut all = b"#0\n$dumpvars\n".to_vec();
        let shown = signals.iter().zip((0..).map(Id)).filter(|((width, _), _)| *width <= self.widest);
        for ((width, value), id) in shown {
            change(id, *width, *value, &mut all);
        }
        all.extend(b"$end\n");
        self.sink.write_all(&all)
    }

    pub(super) fn advance(&mut self, at: u64) -> io::Result<()> {
        writeln!(self.sink, "#{at}")
    }

    pub(super) fn change(&mut self, id: Id, width: u32, value: Value) -> io::Result<()> {
        if width > self.widest {
            return Ok(());
        }
        self.line.clear();
        change(id, width, value, &mut self.line);
        self.sink.write_all(&self.line)
    }

    pub(super) fn finish(mut self) -> io::Result<W> {
        self.sink.flush()?;
        Ok(self.sink)
    }
}

fn change(id: Id, width: u32, value: Value, line: &mut Vec<u8>) {
    if width > 1 {
        line.push(b'b');
    }
    line.extend(value.characters(width));
    if width > 1 {
        line.push(b' ');
    }
    code(id, line);
    line.push(b'\n');
}

/// What a signal is called in the changes.
fn code(id: Id, line: &mut Vec<u8>) {
    let mut rest = id.0;
    loop {
        line.push(FIRST + (rest % CODES) as u8);
        rest /= CODES;
        if rest == 0 {
            return;
        }
        // So that no code is the beginning of a longer one with zeros behind.
        rest -= 1;
    }
}
