//! The connection of a client: made when it is needed, given up when nothing good can come over it any more, and told of.

use std::io;
use std::mem::discriminant;
use std::time::Duration as Span;

use encoring_bus::{BusError, Cause, Link, LinkEvent};
use encoring_words::{Duration, Instant};
use tokio::net::TcpStream;
use tokio::time::{sleep, timeout_at};
use tokio_serial::SerialPortBuilderExt;

use super::wire::{Deadline, Wire, lost};
use super::{Core, Heard};
use crate::address::{Address, Layout, Parity, StopBits, Way};
use crate::error::ModbusError;

/// After so many connections that were closed behind their first answer every request gets one of its own.
const CLOSED_ENOUGH: u32 = 2;
/// Link events that nobody has asked for; the oldest go first.
pub(super) const EVENTS_MAX: usize = 64;

impl Core {
    pub(super) fn wire(&mut self) -> Result<&mut Wire, ModbusError> {
        self.wire.as_mut().ok_or(lost(io::ErrorKind::NotConnected))
    }

    /// A gateway that closes behind each answer is spared the race: its connection is not used again.
    pub(super) fn answer_came(&mut self, asked: Instant) {
        self.pace.answered(self.now().since(asked));
        self.useful();
        if self.closed_behind >= CLOSED_ENOUGH {
            self.wire = None;
        }
    }

    /// The gateway has closed the connection between two requests. That is no trouble if the next one is made.
    pub(super) fn closed(&mut self, cause: ModbusError) {
        let Some(wire) = self.wire.take() else { return };
        match wire.answers() {
            0 => {
                self.wire = Some(wire);
                return self.down(cause);
            }
            1 => self.closed_behind = self.closed_behind.saturating_add(1),
            _ => self.closed_behind = 0,
        }
        self.gone = Some(cause);
    }

    /// Sees to it that there is a connection.
    pub(super) async fn connect(&mut self, deadline: Deadline) -> Result<(), ModbusError> {
        if let Some(wire) = &self.wire {
            // Nothing was asked yet: a peer that has closed in the meantime costs a new connection and no error.
            match wire.clear().await {
                Ok(()) => return Ok(()),
                Err(lost) => self.closed(lost),
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
                self.up();
                Ok(())
            }
            Err(error) => {
                if matches!(error, ModbusError::Bus(BusError::NoAnswer { .. })) {
                    self.unanswered();
                }
                if let Some(cause) = self.gone.take() {
                    self.told_down(cause);
                }
                let next = self.failed(&error);
                self.event(Link::Failed { cause: self.last, next });
                Err(error)
            }
        }
    }

    /// There is a connection: worth a word unless the last one was there and of no use.
    fn up(&mut self) {
        if self.useless.is_none() {
            self.told_up();
        }
    }

    /// Something was answered on this connection.
    fn useful(&mut self) {
        if self.useless.take().is_some() {
            self.told_up();
        }
    }

    /// Unless the gateway had only closed the last one.
    fn told_up(&mut self) {
        if self.up && self.since.is_some() {
            self.gone = None;
            return;
        }
        let now = self.now();
        let down_for = self.since.map_or(Duration::ZERO, |since| now.since(since));
        (self.since, self.up) = (Some(now), true);
        self.event(Link::Up { down_for });
    }

    async fn open(&self, deadline: Deadline) -> Result<Wire, ModbusError> {
        let Address { unit, accept, .. } = self.address;
        let (Layout::Plain { input: marker, .. } | Layout::Inline { data: marker }) = self.address.layout;
        match &self.address.way {
            Way::Tcp { host, port } => Ok(Wire::tcp(socket(host, *port, deadline).await?, unit, accept)),
            Way::RtuTcp { host, port } => {
                let socket = socket(host, *port, deadline).await?;
                Wire::rtu(socket, unit, Span::ZERO, marker, deadline).await
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
                    .map_err(|error| lost(serial(io::Error::from(error).kind())))?;
                Wire::rtu(port, unit, silence(*baud), marker, deadline).await
            }
        }
    }

    /// Drops the connection if a result leaves open what may still be on its way.
    pub(super) fn checked<T>(&mut self, result: Result<T, ModbusError>) -> Result<T, ModbusError> {
        match &result {
            Err(ModbusError::Bus(BusError::NoAnswer { .. })) => {
                self.unanswered();
                self.pace.ran_out(self.address.timeout);
            }
            Ok(_) | Err(ModbusError::Refused { .. } | ModbusError::Garbled { .. }) => {
                self.heard = Heard::Something;
            }
            Err(ModbusError::Bus(_)) => {}
        }
        match &result {
            Err(error) if !Wire::usable(error) => self.down(error.clone()),
            _ if self.wire.as_ref().is_some_and(Wire::answered) => {
                self.reconnect.worked();
                self.useful();
            }
            _ => {}
        }
        result
    }

    fn unanswered(&mut self) {
        if self.heard == Heard::NotAsked {
            self.heard = Heard::Silence;
        }
    }

    fn down(&mut self, cause: ModbusError) {
        let Some(wire) = self.wire.take() else { return };
        if wire.answered() {
            self.useful();
        } else {
            // It was there, but of no use.
            self.failed(&cause);
            let before = self.useless.replace(cause.clone());
            if before.is_some_and(|before| is_same_trouble(&before, &cause)) {
                self.forget_ring();
                return;
            }
        }
        self.told_down(cause);
    }

    /// Another gateway may answer next.
    fn forget_ring(&mut self) {
        (self.directory, self.encoders, self.up) = (None, None, false);
    }

    fn told_down(&mut self, cause: ModbusError) {
        self.forget_ring();
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

/// Whether two connections were of no use for the same reason; the numbers in an answer are others each time.
fn is_same_trouble(before: &ModbusError, now: &ModbusError) -> bool {
    match (before, now) {
        (ModbusError::Garbled { got: before, .. }, ModbusError::Garbled { got: now, .. }) => {
            discriminant(before) == discriminant(now)
        }
        _ => before == now,
    }
}

async fn socket(host: &str, port: u16, deadline: Deadline) -> Result<TcpStream, ModbusError> {
    let socket = match timeout_at(deadline.at, TcpStream::connect((host, port))).await {
        Ok(socket) => socket.map_err(|error| lost(error.kind()))?,
        Err(_) => return Err(lost(io::ErrorKind::TimedOut)),
    };
    // Only a matter of speed, so a socket that refuses is used all the same.
    let _ = socket.set_nodelay(true);
    Ok(socket)
}

/// Three and a half characters of 11 bits, but not less than the 1.75 ms of the standard.
fn silence(baud: u32) -> Span {
    Span::from_nanos(3_500_000_000 * 11 / u64::from(baud.max(1))).max(Span::from_micros(1_750))
}

/// What could not be opened as a serial line is none.
const fn serial(kind: io::ErrorKind) -> io::ErrorKind {
    match kind {
        io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied | io::ErrorKind::InvalidInput => kind,
        _ => io::ErrorKind::Unsupported,
    }
}
