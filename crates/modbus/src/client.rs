//! A ring behind a Modbus gateway as a [`Bus`].
//!
//! A [`Client`] connects when it is first asked for something, and again after every error that leaves open what may
//! still be on its way. It writes nothing that it is not told to write. The page for users is `docs/bus.md`.

use std::collections::VecDeque;
use std::io;
use std::time::Duration as Span;

use encoring_bus::{Bus, BusError, Cause, Cycle, Link, LinkEvent, Settling};
use encoring_words::{Duration, InWord, Instant, OutWord};
use tokio::net::TcpStream;
use tokio::runtime::{Builder, Runtime};
use tokio::time::{sleep, timeout_at};
use tokio_serial::SerialPortBuilderExt;

use crate::address::{Address, Layout, Parity, StopBits, Way};
use crate::error::ModbusError;
use crate::inline::{Directory, MODULES_MAX};
use crate::pdu::READ_MAX;
use crate::place::{MODULES, REGISTERS_PER_ENCODER, RegisterPlace, Table};
use crate::reconnect::Reconnect;

mod line;
mod wire;

pub(crate) use wire::reading;
use wire::{Deadline, Wire, lost};

/// Registers of one request: as many as there may be, and no half word among them.
const CHUNK: usize = READ_MAX as usize / REGISTERS_PER_ENCODER * REGISTERS_PER_ENCODER;
/// Link events that nobody has asked for; the oldest go first.
const EVENTS_MAX: usize = 64;

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
    reconnect: Reconnect,
    /// What the last attempt met.
    last: io::ErrorKind,
    /// Since when the link is as it is; `None` before the first connection.
    since: Option<Instant>,
    events: VecDeque<LinkEvent>,
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
            core.connect(deadline).await?;
            let registers = core.read(place, count.into(), deadline).await;
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
            core.connect(deadline).await?;
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

    fn link_event(&mut self) -> Option<LinkEvent> {
        self.core.events.pop_front()
    }
}

impl Core {
    fn new(address: Address) -> Self {
        Self {
            address,
            origin: tokio::time::Instant::now(),
            wire: None,
            directory: None,
            reconnect: Reconnect::default(),
            last: io::ErrorKind::NotConnected,
            since: None,
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
        self.connect(deadline).await?;
        let result = self.read_out(position, deadline).await;
        self.checked(result)
    }

    async fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        first: usize,
        input: &mut [InWord],
        deadline: Deadline,
    ) -> Result<Cycle, ModbusError> {
        self.connect(deadline).await?;
        let result = self.write_and_read(write, first, input, deadline).await;
        self.checked(result)
    }

    async fn read_out(&mut self, position: usize, deadline: Deadline) -> Result<OutWord, ModbusError> {
        let place = self.out_place(position, deadline).await?;
        let registers = self.read(place, REGISTERS_PER_ENCODER, deadline).await?;
        let word = registers.first_chunk().map(|halves| self.address.order.word(*halves));
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
            let registers = self.address.order.registers(word.0);
            self.wire()?.write(place.first, &registers, deadline).await?;
        }
        let begun = self.now();
        let mut words = input.iter_mut();
        for (place, count) in runs {
            let registers = self.read(place, count, deadline).await?;
            // The registers first, so that the end of a run takes no word with it.
            for (halves, word) in registers.as_chunks().0.iter().zip(words.by_ref()) {
                *word = InWord(self.address.order.word(*halves));
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

    /// Reads any number of registers, a request for as many as one may have.
    async fn read(
        &mut self,
        place: RegisterPlace,
        count: usize,
        deadline: Deadline,
    ) -> Result<Vec<u16>, ModbusError> {
        let wire = self.wire()?;
        let mut registers = Vec::with_capacity(count);
        while registers.len() < count {
            let piece = (count - registers.len()).min(CHUNK);
            let Some(from) = at_offset(place, registers.len()) else { break };
            registers.extend(wire.read(from, piece as u16, deadline).await?);
        }
        Ok(registers)
    }

    fn wire(&mut self) -> Result<&mut Wire, ModbusError> {
        self.wire.as_mut().ok_or(lost(io::ErrorKind::NotConnected))
    }

    /// Sees to it that there is a connection.
    async fn connect(&mut self, deadline: Deadline) -> Result<(), ModbusError> {
        if let Some(wire) = &self.wire {
            // Nothing was asked yet: a peer that has closed in the meantime costs a new connection and no error.
            match wire.clear().await {
                Ok(()) => return Ok(()),
                Err(lost) => self.down(lost),
            }
        }
        if let Some(pause) = self.reconnect.pause(self.now()) {
            let patience = Duration(self.address.timeout.as_nanos() / 2);
            sleep(Span::from_nanos(pause.min(patience).as_nanos())).await;
            if let Some(next) = self.reconnect.pause(self.now()) {
                return Err(BusError::NoConnection(Cause::Waiting { last: self.last, next }).into());
            }
        }
        match self.open(deadline).await {
            Ok(wire) => {
                if wire.answered() {
                    self.reconnect.worked();
                }
                self.wire = Some(wire);
                let now = self.now();
                let down_for = self.since.map_or(Duration::ZERO, |since| now.since(since));
                self.since = Some(now);
                self.event(Link::Up { down_for });
                Ok(())
            }
            Err(error) => {
                let next = self.failed(&error);
                self.event(Link::Failed { cause: self.last, next });
                Err(error)
            }
        }
    }

    async fn open(&self, deadline: Deadline) -> Result<Wire, ModbusError> {
        match &self.address.way {
            Way::Tcp { host, port } => {
                let connecting = TcpStream::connect((host.as_str(), *port));
                let socket = match timeout_at(deadline.at, connecting).await {
                    Ok(socket) => socket.map_err(|error| lost(error.kind()))?,
                    Err(_) => return Err(lost(io::ErrorKind::TimedOut)),
                };
                // Only a matter of speed, so a socket that refuses is used all the same.
                let _ = socket.set_nodelay(true);
                Ok(Wire::tcp(socket, self.address.unit))
            }
            Way::Rtu { device, baud, parity, stop } => {
                let port = tokio_serial::new(device.as_str(), *baud)
                    .parity(match parity {
                        Parity::None => tokio_serial::Parity::None,
                        Parity::Even => tokio_serial::Parity::Even,
                        Parity::Odd => tokio_serial::Parity::Odd,
                    })
                    .stop_bits(match stop {
                        StopBits::One => tokio_serial::StopBits::One,
                        StopBits::Two => tokio_serial::StopBits::Two,
                    })
                    .open_native_async()
                    .map_err(|error| lost(io::Error::from(error).kind()))?;
                let (Layout::Plain { input: marker, .. } | Layout::Inline { data: marker }) =
                    self.address.layout;
                Wire::rtu(port, self.address.unit, silence(*baud), marker, deadline).await
            }
        }
    }

    /// Drops the connection if a result leaves open what may still be on its way.
    fn checked<T>(&mut self, result: Result<T, ModbusError>) -> Result<T, ModbusError> {
        match &result {
            Err(error) if !Wire::usable(error) => self.down(error.clone()),
            _ if self.wire.as_ref().is_some_and(Wire::answered) => self.reconnect.worked(),
            _ => {}
        }
        result
    }

    fn down(&mut self, cause: ModbusError) {
        let Some(wire) = self.wire.take() else { return };
        self.directory = None;
        if !wire.answered() {
            // It was there, but of no use.
            self.failed(&cause);
        }
        let now = self.now();
        let up_for = self.since.map_or(Duration::ZERO, |since| now.since(since));
        self.since = Some(now);
        self.event(Link::Down { up_for, cause: cause.into() });
    }

    fn failed(&mut self, cause: &ModbusError) -> Duration {
        self.last = match cause {
            ModbusError::Bus(BusError::NoConnection(Cause::System(kind))) => *kind,
            ModbusError::Bus(BusError::NoAnswer { .. }) => io::ErrorKind::TimedOut,
            _ => io::ErrorKind::InvalidData,
        };
        self.reconnect.failed(self.now())
    }

    fn event(&mut self, what: Link) {
        if self.events.len() >= EVENTS_MAX {
            self.events.pop_front();
        }
        self.events.push_back(LinkEvent { at: self.now(), what });
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

/// Three and a half characters of 11 bits, but not less than the 1.75 ms of the standard.
fn silence(baud: u32) -> Span {
    Span::from_nanos(3_500_000_000 * 11 / u64::from(baud.max(1))).max(Span::from_micros(1_750))
}

#[cfg(test)]
mod tests;
