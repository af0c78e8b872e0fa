//! One connection to a gateway: a request goes out, and the answer to it comes back or an error does.
//!
//! The client library makes the frames and takes them apart. It takes a late answer for the next request's, and its
//! convenient calls assert what a peer has in its hand. So:
//!
//! - only its lowest call is used, and kind, length and echo of every answer are compared with the request here;
//! - what comes without being asked for is thrown away before each request;
//! - after anything but an answer or an exception a wire is not used again: [`Wire::usable`] says so;
//! - a serial line has no numbers on its frames, and what is still on its way outlives a closed port. There a request
//!   that no other can be confused with goes first: see [`Wire::rtu`].

use std::borrow::Cow;
use std::io;
use std::time::Duration as Span;

use encoring_bus::{BusError, Cause};
use encoring_words::Duration;
use tokio::time::{Instant, sleep, timeout_at};
use tokio_modbus::client::{Client as _, Context, rtu, tcp};
use tokio_modbus::{Error, ExceptionResponse, ProtocolError, Request, Response, Slave};

use super::difference::{self, Framing};
use super::line::{Line, Stream};
use crate::address::Accept;
use crate::error::{Garbled, ModbusError};
use crate::place::{RegisterPlace, Table};

const READ_HOLDING: u8 = 3;
const READ_INPUT: u8 = 4;
const WRITE_SEVERAL: u8 = 16;

/// Bytes of an exception on a network: header, function, code.
const EXCEPTION: usize = 9;

/// When a call ends, whatever happens, and how long that was from its beginning.
#[derive(Clone, Copy)]
pub(super) struct Deadline {
    pub(super) at: Instant,
    pub(super) within: Duration,
}

/// A connection that may be asked.
pub(super) struct Wire {
    context: Context,
    line: Line,
    framing: Framing,
    /// How long a line is to be silent between two frames.
    silence: Span,
    accept: Accept,
    /// How many answers of use came.
    answers: u32,
}

/// What a request asks for, as errors name it.
#[derive(Clone, Copy)]
struct Asked {
    function: u8,
    register: u16,
}

impl Asked {
    const fn garbled(self, got: Garbled) -> ModbusError {
        ModbusError::Garbled { function: self.function, register: self.register, got }
    }
}

/// What became of the connection, as the operating system says.
pub(super) const fn lost(kind: io::ErrorKind) -> ModbusError {
    ModbusError::Bus(BusError::NoConnection(Cause::System(kind)))
}

/// The function that reads a table.
pub(crate) const fn reading(table: Table) -> u8 {
    match table {
        Table::Holding => READ_HOLDING,
        Table::Input => READ_INPUT,
    }
}

impl Wire {
    pub(super) fn tcp(stream: impl Stream + 'static, unit: u8, accept: Accept) -> Self {
        let line = Line::new(stream);
        let context = tcp::attach_slave(line.clone(), Slave(unit));
        Self { context, line, framing: Framing::Tcp, silence: Span::ZERO, accept, answers: 0 }
    }

    /// A serial line, on which answers to earlier requests may still be on their way.
    ///
    /// They look like answers to later ones. So the first request is for one single register, which no call of a bus
    /// asks for. A unit answers in the order in which it was asked, so when that answer is there, none to an earlier
    /// request can follow. A unit that answers out of order cannot be guarded against: its frames say nothing of what
    /// they answer.
    pub(super) async fn rtu(
        stream: impl Stream + 'static,
        unit: u8,
        silence: Span,
        marker: RegisterPlace,
        deadline: Deadline,
    ) -> Result<Self, ModbusError> {
        let line = Line::new(stream);
        let context = rtu::attach_slave(line.clone(), Slave(unit));
        // There is no transaction number, and the unit is all that tells one answer from another's.
        let accept = Accept::default();
        let mut wire = Self { context, line, framing: Framing::Rtu, silence, accept, answers: 0 };
        match wire.read(marker, 1, deadline).await {
            // A unit that does not like the question has answered it all the same.
            Ok(_) | Err(ModbusError::Refused { .. }) => Ok(wire),
            Err(error) => Err(error),
        }
    }

    /// Whether anything of use ever came over this connection.
    pub(super) const fn answered(&self) -> bool {
        self.answers > 0
    }

    /// How many answers of use came.
    pub(super) const fn answers(&self) -> u32 {
        self.answers
    }

    /// `true` if the peer has closed the connection behind an earlier answer, and nothing of the last one came.
    pub(super) fn closed_unheard(&self) -> bool {
        self.answered() && self.line.received() == 0 && self.line.lost().is_some()
    }

    /// `false` if a wire that met this error must be dropped, lest a late answer be taken for the next.
    pub(super) const fn usable(after: &ModbusError) -> bool {
        match after {
            // A whole answer came, or there was nothing to ask.
            ModbusError::Refused { .. }
            | ModbusError::Bus(
                BusError::NoEncoder { .. } | BusError::NotShown { .. } | BusError::NotAnEncoder { .. },
            ) => true,
            ModbusError::Bus(_) | ModbusError::Garbled { .. } => false,
        }
    }

    /// Throws away what came without being asked for; an error if nothing can come any more.
    pub(super) async fn clear(&self) -> Result<(), ModbusError> {
        self.line.clear().await.map_err(lost)
    }

    /// Reads registers.
    pub(super) async fn read(
        &mut self,
        place: RegisterPlace,
        count: u16,
        deadline: Deadline,
    ) -> Result<Vec<u16>, ModbusError> {
        let asked = Asked { function: reading(place.table), register: place.first };
        let request = match place.table {
            Table::Holding => Request::ReadHoldingRegisters(place.first, count),
            Table::Input => Request::ReadInputRegisters(place.first, count),
        };
        let answer = (place.table, self.ask(request, asked, deadline).await?);
        let ((Table::Holding, Response::ReadHoldingRegisters(registers))
        | (Table::Input, Response::ReadInputRegisters(registers))) = answer
        else {
            return Err(self.garbled(asked));
        };
        let (got, wanted) = (registers.len(), usize::from(count));
        if got != wanted {
            return Err(asked.garbled(Garbled::Registers { got, wanted }));
        }
        self.answers = self.answers.saturating_add(1);
        Ok(registers)
    }

    /// Writes holding registers, all with one request.
    pub(super) async fn write(
        &mut self,
        first: u16,
        values: &[u16],
        deadline: Deadline,
    ) -> Result<(), ModbusError> {
        let asked = Asked { function: WRITE_SEVERAL, register: first };
        let request = Request::WriteMultipleRegisters(first, Cow::Borrowed(values));
        match self.ask(request, asked, deadline).await? {
            Response::WriteMultipleRegisters(register, count)
                if register == first && usize::from(count) == values.len() =>
            {
                self.answers = self.answers.saturating_add(1);
                Ok(())
            }
            _ => Err(self.garbled(asked)),
        }
    }

    async fn ask(
        &mut self,
        request: Request<'_>,
        asked: Asked,
        deadline: Deadline,
    ) -> Result<Response, ModbusError> {
        let exchange = async {
            sleep(self.silence).await;
            self.clear().await?;
            Ok(self.context.call(request).await)
        };
        match timeout_at(deadline.at, exchange).await {
            Ok(Ok(Ok(Ok(response)))) => Ok(response),
            Ok(Ok(Ok(Err(exception)))) => self.refused(asked, exception.into()),
            Ok(Ok(Err(Error::Protocol(ProtocolError::HeaderMismatch { result, .. }))))
                if self.accepted(asked) =>
            {
                match result {
                    Ok(response) => Ok(response),
                    Err(ExceptionResponse { exception, .. }) => self.refused(asked, exception.into()),
                }
            }
            Ok(Ok(Err(_))) => Err(match self.line.lost() {
                Some(kind) => lost(kind),
                None => self.garbled(asked),
            }),
            Ok(Err(lost)) => Err(lost),
            Err(_) => Err(match self.line.received() {
                0 => BusError::NoAnswer { within: deadline.within }.into(),
                bytes => match self.difference() {
                    serial @ Garbled::SerialFrame => asked.garbled(serial),
                    _ => asked.garbled(Garbled::Unfinished { bytes }),
                },
            }),
        }
    }

    fn refused(&mut self, asked: Asked, exception: u8) -> Result<Response, ModbusError> {
        // The library does not look at what follows the exception in its frame.
        if self.framing == Framing::Tcp && self.line.received() != EXCEPTION {
            return Err(asked.garbled(Garbled::Length { got: self.line.received(), wanted: EXCEPTION }));
        }
        self.answers = self.answers.saturating_add(1);
        let Asked { function, register } = asked;
        Err(ModbusError::Refused { function, register, exception })
    }

    /// What about the answer is not as the request wants it.
    fn difference(&self) -> Garbled {
        let (sent, got) = self.line.exchange();
        difference::between(self.framing, &sent, &got)
    }

    fn garbled(&self, asked: Asked) -> ModbusError {
        asked.garbled(self.difference())
    }

    /// Whether the answer differs only in what may differ.
    fn accepted(&self, asked: Asked) -> bool {
        let (sent, mut got) = self.line.exchange();
        difference::adopt(&sent, &mut got, self.accept);
        got.get(7).is_some_and(|function| function & 0x7F == asked.function)
            && difference::same_header(&sent, &got)
    }
}

#[cfg(test)]
mod tests;
