//! A ring behind a Modbus gateway as a [`Bus`].
//!
//! A [`Client`] connects when it is first asked for something, and again after every error that leaves open what may
//! still be on its way. It writes nothing that it is not told to write. The page for users is `docs/bus.md`.

use std::collections::VecDeque;
use std::io;
use std::time::Duration as Span;

use encoring_bus::misread::Misread;
use encoring_bus::{Bus, BusError, Cycle, LinkEvent, Settling};
use encoring_ring::diagnostics::Diagnosis;
use encoring_words::{Duration, InWord, Instant, OutWord};
use tokio::runtime::{Builder, Runtime};
use tokio::time::sleep;

use crate::address::{Address, Layout};
use crate::error::ModbusError;
use crate::inline::{Directory, MODULES_MAX};
use crate::place::{MODULES, REGISTERS_PER_ENCODER, RegisterPlace, Table};
use crate::reconnect::Reconnect;

mod advice;
mod diagnosis;
mod difference;
mod line;
mod link;
mod pace;
mod wire;

use pace::Pace;
pub(crate) use wire::reading;
use wire::{Deadline, Wire, lost};

/// A ring behind a Modbus gateway.
///
/// Every call ends within the address's time-out, whatever it has to do: wait for the next attempt to connect (for at
/// most half of that time), connect, and all its requests. Calls block their thread, so none may be made from within
/// an asynchronous task: tokio panics there.
pub struct Client {
    /// `None` only while it is dropped.
    runtime: Option<Runtime>,
    core: Core,
}

/// All of a client but the runtime that it blocks on.
struct Core {
    address: Address,
    origin: tokio::time::Instant,
    wire: Option<Wire>,
    /// Of an Inline coupler, as of this connection or the last write.
    directory: Option<Directory>,
    /// Registers of one request: as many as the gateway gives, and no half word among them.
    piece: usize,
    /// How many encoders a gateway without a directory shows, once it was asked for more.
    encoders: Option<usize>,
    /// Connections in a row that the gateway closed behind their first answer.
    closed_behind: u32,
    reconnect: Reconnect,
    /// What the last attempt met.
    last: io::ErrorKind,
    /// Since when the link is as it is; `None` before the first connection.
    since: Option<Instant>,
    /// It is there, as far as was told.
    up: bool,
    heard: Heard,
    /// How fast it answers.
    pace: Pace,
    /// Why the last connection was of no use, though it was made: the next is worth a word when something was answered.
    useless: Option<ModbusError>,
    /// Why the gateway's last connection is gone, if that was not told.
    gone: Option<ModbusError>,
    events: VecDeque<LinkEvent>,
}

/// What ever came from the peer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Heard {
    NotAsked,
    /// It was there, and nothing came.
    Silence,
    /// An answer, or what was none.
    Something,
}

impl Client {
    /// A client that has not connected yet.
    ///
    /// # Errors
    /// If the operating system has no means left to wait for a connection.
    pub fn new(address: Address) -> io::Result<Self> {
        let runtime = Builder::new_current_thread().enable_io().enable_time().build()?;
        Ok(Self { runtime: Some(runtime), core: Core::new(address) })
    }

    /// The same with another reconnect policy.
    #[must_use]
    pub fn reconnecting(mut self, reconnect: Reconnect) -> Self {
        self.core.reconnect = reconnect;
        self
    }

    /// Where it connects to.
    #[must_use]
    pub fn address(&self) -> &Address {
        &self.core.address
    }

    /// Reads registers of any table, as they stand. [`Bus::cycle`] reads words; this is for whoever looks around.
    ///
    /// # Errors
    /// [`ModbusError`].
    pub fn registers(&mut self, place: RegisterPlace, count: u16) -> Result<Vec<u16>, ModbusError> {
        self.block(async |core, deadline| {
            // In one piece, so that a refusal is told as one.
            let registers = core.read_piece(place, count, deadline).await;
            core.checked(registers)
        })
    }

    /// What an Inline coupler says of the modules on its ring: length code in the high byte and ident code in the low
    /// byte of each, and where their data lie. `None` if the address has another layout, where nobody can tell.
    ///
    /// # Errors
    /// [`ModbusError`].
    pub fn modules(&mut self) -> Result<Option<(Vec<u16>, Directory)>, ModbusError> {
        let Layout::Inline { data: RegisterPlace { table, .. } } = self.core.address.layout else {
            return Ok(None);
        };
        self.block(async |core, deadline| {
            let described = core.described(table, deadline).await;
            let described = core.checked(described)?;
            let directory = Directory::parse(&described, reading(table))?;
            Ok(Some((described, directory)))
        })
    }

    fn block<T>(
        &mut self,
        work: impl AsyncFnOnce(&mut Core, Deadline) -> Result<T, ModbusError>,
    ) -> Result<T, ModbusError> {
        let Some(runtime) = &self.runtime else {
            return Err(lost(io::ErrorKind::NotConnected));
        };
        let core = &mut self.core;
        runtime.block_on(async move {
            core.pace.begin();
            let deadline = core.deadline();
            work(core, deadline).await
        })
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // A name that is still being looked up is not waited for.
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}

impl Bus for Client {
    fn now(&self) -> Instant {
        self.core.now()
    }

    fn out(&mut self, position: usize) -> Result<OutWord, BusError> {
        Ok(self.block(async |core, deadline| core.out(position, deadline).await)?)
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        Ok(self.block(async |core, deadline| core.cycle(write, first, input, deadline).await)?)
    }

    fn wait(&mut self, span: Duration) {
        if let Some(runtime) = &self.runtime {
            runtime.block_on(async { sleep(Span::from_nanos(span.as_nanos())).await });
        }
    }

    fn settling(&self) -> Settling {
        // The first cycle after a write may have read what stood there before.
        Settling { cycles: 2, time: self.core.address.settle }
    }

    fn cure(&self, misread: Misread) -> Option<String> {
        Some(advice::turned(misread, advice::halves(&self.core.address)))
    }

    fn cure_of_writes(&self, misread: Misread) -> Option<String> {
        Some(advice::turned(misread, advice::written_halves(&self.core.address)))
    }

    fn diagnosis(&mut self) -> Result<Diagnosis, BusError> {
        Ok(self.block(async |core, deadline| core.diagnosis(deadline).await)?)
    }

    fn advice(&self) -> Option<String> {
        let Core { heard, pace, address, .. } = &self.core;
        match (heard, pace.too_slow()) {
            (Heard::Silence, _) => Some(advice::silence(address)),
            (_, Some(after)) => Some(advice::slow(after, address.timeout)),
            _ => None,
        }
    }

    fn link_event(&mut self) -> Option<LinkEvent> {
        self.core.events.pop_front()
    }
}

impl Core {
    fn new(address: Address) -> Self {
        Self {
            piece: whole_words(address.max_registers.into()),
            encoders: None,
            closed_behind: 0,
            reconnect: Reconnect::within(address.timeout),
            address,
            origin: tokio::time::Instant::now(),
            wire: None,
            directory: None,
            last: io::ErrorKind::NotConnected,
            since: None,
            up: false,
            heard: Heard::NotAsked,
            pace: Pace::default(),
            useless: None,
            gone: None,
            events: VecDeque::new(),
        }
    }

    fn now(&self) -> Instant {
        Instant(u64::try_from(self.origin.elapsed().as_nanos()).unwrap_or(u64::MAX))
    }

    fn deadline(&self) -> Deadline {
        let within = self.address.timeout;
        Deadline { at: tokio::time::Instant::now() + Span::from_nanos(within.as_nanos()), within }
    }

    async fn out(&mut self, position: usize, deadline: Deadline) -> Result<OutWord, ModbusError> {
        let result = self.read_out(position, deadline).await;
        let result = self.checked(result);
        self.counted(result, deadline).await
    }

    async fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
        deadline: Deadline,
    ) -> Result<Cycle, ModbusError> {
        let result = self.write_and_read(write, first, input, deadline).await;
        let result = self.checked(result);
        self.counted(result, deadline).await
    }

    async fn read_out(&mut self, position: usize, deadline: Deadline) -> Result<OutWord, ModbusError> {
        let place = self.out_place(position, deadline).await?;
        let registers = self.read(place, REGISTERS_PER_ENCODER, deadline).await?;
        let word = registers.first_chunk().map(|halves| self.address.order_out.word(*halves));
        Ok(OutWord(word.unwrap_or_default()))
    }

    async fn write_and_read(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
        deadline: Deadline,
    ) -> Result<Cycle, ModbusError> {
        if write.is_some() {
            // The ring behind a coupler may have been changed, and what is written must not reach another module.
            self.directory = None;
        }
        // Every encoder is looked for before anything is written.
        let runs = self.runs(first, input.len(), deadline).await?;
        if let Some((position, word)) = write {
            let place = self.out_place(position, deadline).await?;
            let registers = self.address.order_out.registers(word.0);
            self.connect(deadline).await?;
            let asked = self.now();
            self.wire()?.write(place.first, &registers, deadline).await?;
            self.answer_came(asked);
        }
        let begun = self.now();
        let mut words = input.iter_mut();
        for (place, count) in runs {
            let registers = self.read(place, count, deadline).await?;
            // The registers first, so that the end of a run takes no word with it.
            for (halves, word) in registers.as_chunks().0.iter().zip(words.by_ref()) {
                *word = InWord(self.address.order_in.word(*halves));
            }
        }
        let at = self.now();
        Ok(Cycle { at, age: at.since(begun) + self.address.settle })
    }

    /// Where the OUT word of an encoder stands.
    async fn out_place(&mut self, position: usize, deadline: Deadline) -> Result<RegisterPlace, ModbusError> {
        match self.address.layout {
            Layout::Plain { out, .. } => {
                Ok(plain(RegisterPlace { table: Table::Holding, first: out }, position)?)
            }
            Layout::Inline { data } => {
                let out = self.directory(deadline).await?.offsets(position)?.out;
                let holding = RegisterPlace { table: Table::Holding, ..data };
                Ok(at_offset(holding, out).ok_or(BusError::NoEncoder { position, encoders: 0 })?)
            }
        }
    }

    /// Which registers hold the IN words of some encoders, in as few pieces as there are.
    async fn runs(
        &mut self,
        first: usize,
        count: usize,
        deadline: Deadline,
    ) -> Result<Vec<(RegisterPlace, usize)>, ModbusError> {
        let Some(last) = count.checked_sub(1) else { return Ok(Vec::new()) };
        let last = first.saturating_add(last);
        match self.address.layout {
            Layout::Plain { input, .. } => {
                plain(input, last)?;
                Ok(vec![(plain(input, first)?, count * REGISTERS_PER_ENCODER)])
            }
            Layout::Inline { data } => {
                let directory = self.directory(deadline).await?;
                let mut runs: Vec<(RegisterPlace, usize)> = Vec::new();
                for position in first..=last {
                    let offset = directory.offsets(position)?.input;
                    let place = at_offset(data, offset)
                        .ok_or(BusError::NoEncoder { position, encoders: position })?;
                    match runs.last_mut() {
                        Some((begin, length))
                            if usize::from(begin.first) + *length == usize::from(place.first) =>
                        {
                            *length += REGISTERS_PER_ENCODER;
                        }
                        _ => runs.push((place, REGISTERS_PER_ENCODER)),
                    }
                }
                Ok(runs)
            }
        }
    }

    /// What an Inline coupler says of its ring, asked once a connection and before every write.
    async fn directory(&mut self, deadline: Deadline) -> Result<&Directory, ModbusError> {
        if self.directory.is_none() {
            let Layout::Inline { data: RegisterPlace { table, .. } } = self.address.layout else {
                return Err(BusError::NoEncoder { position: 0, encoders: 0 }.into());
            };
            let registers = self.described(table, deadline).await?;
            self.directory = Some(Directory::parse(&registers, reading(table))?);
        }
        Ok(self.directory.as_ref().ok_or(BusError::NoEncoder { position: 0, encoders: 0 })?)
    }

    /// The registers with which an Inline coupler describes its modules.
    async fn described(&mut self, table: Table, deadline: Deadline) -> Result<Vec<u16>, ModbusError> {
        // The first module with it: a single register is asked for by the marker of a serial line alone.
        let count = self.read(RegisterPlace { table, first: MODULES }, 2, deadline).await?;
        let count = count.first().copied().unwrap_or_default().min(MODULES_MAX);
        self.read(RegisterPlace { table, first: MODULES + 1 }, count.into(), deadline).await
    }

    /// Reads any number of registers, a request for as many as the gateway gives in one. How many those are it tells
    /// by refusing more.
    async fn read(
        &mut self,
        place: RegisterPlace,
        count: usize,
        deadline: Deadline,
    ) -> Result<Vec<u16>, ModbusError> {
        let mut piece = self.piece;
        let mut registers = Vec::with_capacity(count);
        while registers.len() < count {
            let wanted = (count - registers.len()).min(piece);
            let Some(from) = at_offset(place, registers.len()) else { break };
            match self.read_piece(from, wanted as u16, deadline).await {
                Ok(read) => registers.extend(read),
                // Too many, or one of them is not there: the last piece of one word tells.
                Err(ModbusError::Refused { exception: 2 | 3, .. }) if wanted > REGISTERS_PER_ENCODER => {
                    piece = whole_words(wanted / 2);
                }
                Err(error) => return Err(error),
            }
        }
        self.piece = piece;
        Ok(registers)
    }

    /// Reads registers with one request. If the gateway closes the connection without a word it is asked once more:
    /// some close behind each answer.
    async fn read_piece(
        &mut self,
        place: RegisterPlace,
        count: u16,
        deadline: Deadline,
    ) -> Result<Vec<u16>, ModbusError> {
        self.connect(deadline).await?;
        let mut asked = self.now();
        let wire = self.wire()?;
        let mut result = wire.read(place, count, deadline).await;
        if let Err(closed @ ModbusError::Bus(BusError::NoConnection(_))) = &result
            && wire.closed_unheard()
        {
            let closed = closed.clone();
            self.closed(closed);
            self.connect(deadline).await?;
            asked = self.now();
            result = self.wire()?.read(place, count, deadline).await;
        }
        if result.is_ok() {
            self.answer_came(asked);
        }
        result
    }

    /// Says of a register that is not there how many encoders the gateway shows: the position is behind the last.
    async fn counted<T>(
        &mut self,
        result: Result<T, ModbusError>,
        deadline: Deadline,
    ) -> Result<T, ModbusError> {
        let Err(ModbusError::Refused { function, register, exception: 2 }) = result else { return result };
        let Layout::Plain { out, input } = self.address.layout else { return result };
        let base = match function {
            function if function == reading(input.table) && register >= input.first => input,
            function if function == reading(Table::Holding) => {
                RegisterPlace { table: Table::Holding, first: out }
            }
            _ => return result,
        };
        let Some(offset) = register.checked_sub(base.first) else { return result };
        let position = usize::from(offset) / REGISTERS_PER_ENCODER;
        let encoders = match self.encoders {
            Some(encoders) => Some(encoders),
            None => self.count(base, position, deadline).await,
        };
        match encoders {
            Some(encoders) if encoders > 0 && encoders <= position => {
                self.encoders = Some(encoders);
                Err(BusError::NotShown { position, encoders }.into())
            }
            _ => result,
        }
    }

    /// How many encoders have registers from `base` on, of which that at `missing` has none; `None` if it cannot be
    /// told in time.
    async fn count(&mut self, base: RegisterPlace, missing: usize, deadline: Deadline) -> Option<usize> {
        let (mut there, mut not) = (0, missing);
        while there < not {
            let middle = there + (not - there) / 2;
            let place = plain(base, middle).ok()?;
            let result = self.read_piece(place, REGISTERS_PER_ENCODER as u16, deadline).await;
            match self.checked(result) {
                Ok(_) => there = middle + 1,
                Err(ModbusError::Refused { exception: 2, .. }) => not = middle,
                Err(_) => return None,
            }
        }
        Some(there)
    }
}

/// The registers of the encoder at a position, two for each from `base` on.
fn plain(base: RegisterPlace, position: usize) -> Result<RegisterPlace, BusError> {
    let there = position.checked_mul(REGISTERS_PER_ENCODER).and_then(|offset| at_offset(base, offset));
    let encoders = (usize::from(u16::MAX - base.first) + 1) / REGISTERS_PER_ENCODER;
    there.filter(|place| place.first < u16::MAX).ok_or(BusError::NoEncoder { position, encoders })
}

fn at_offset(base: RegisterPlace, offset: usize) -> Option<RegisterPlace> {
    let first = u16::try_from(offset).ok().and_then(|offset| base.first.checked_add(offset))?;
    Some(RegisterPlace { first, ..base })
}

/// The largest number of registers without half a word, but one word at least.
fn whole_words(registers: usize) -> usize {
    (registers / REGISTERS_PER_ENCODER).max(1) * REGISTERS_PER_ENCODER
}

#[cfg(test)]
mod tests;
