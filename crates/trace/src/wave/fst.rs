//! The packed format.

use std::io;

use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType,
    FstVarDirection, FstVarType, FstWriteError,
};

use super::{Id, Signals, Sink, Value};

/// A unit of time as a power of ten, in seconds.
const UNIT_EXPONENT: i8 = -7;

/// How much is held before it is packed and written.
const SECTION_BYTES: usize = 1 << 20;

pub(super) struct Body<W: Sink> {
    out: FstBodyWriter<W>,
    ids: Vec<FstSignalId>,
    value: Vec<u8>,
}

impl<W: Sink> Body<W> {
    pub(super) fn new(sink: W, writer: &str, signals: &Signals) -> io::Result<Self> {
        let info = FstInfo {
            start_time: 0,
            timescale_exponent: UNIT_EXPONENT,
            version: writer.to_owned(),
            // The same run gives the same file.
            date: String::new(),
            file_type: FstFileType::Verilog,
        };
        let mut head = FstHeaderWriter::new(sink, &info).map_err(cause)?;
        let mut ids = Vec::new();
        head.scope(&signals.top, "", FstScopeType::Module).map_err(cause)?;
        for (name, inside) in &signals.scopes {
            head.scope(name, "", FstScopeType::Module).map_err(cause)?;
            for signal in inside {
                let name = format!("{}{}", signal.name, signal.range());
                let kind = FstSignalType::bit_vec(signal.width);
                let id = head.var(name, kind, FstVarType::Wire, FstVarDirection::Implicit, None);
                ids.push(id.map_err(cause)?);
            }
            head.up_scope().map_err(cause)?;
        }
        head.up_scope().map_err(cause)?;
        Ok(Self { out: head.finish().map_err(cause)?, ids, value: Vec::new() })
    }

    /// What the signals show at time 0.
    pub(super) fn first(&mut self, signals: &[(u32, Value)]) -> io::Result<()> {
        let mut signals = signals.iter().zip((0..).map(Id));
        signals.try_for_each(|((width, value), id)| self.change(id, *width, *value))
    }

    pub(super) fn advance(&mut self, at: u64) -> io::Result<()> {
        // A section can only end right before a new time.
        if self.out.size() >= SECTION_BYTES {
            self.out.flush().map_err(cause)?;
        }
        self.out.time_change(at).map_err(cause)
    }

    pub(super) fn change(&mut self, id: Id, width: u32, value: Value) -> io::Result<()> {
        let Some(id) = self.ids.get(id.0 as usize) else { return Ok(()) };
        self.value.clear();
        self.value.extend(value.characters(width));
        self.out.signal_change(*id, &self.value).map_err(cause)
    }

    pub(super) fn finish(self) -> io::Result<W> {
        let mut sink = self.out.finish().map_err(cause)?;
        sink.flush()?;
        Ok(sink)
    }
}

/// What the sink said, if it was the sink.
fn cause(error: FstWriteError) -> io::Error {
    match error {
        FstWriteError::Io(cause) => cause,
        other => io::Error::other(other),
    }
}
