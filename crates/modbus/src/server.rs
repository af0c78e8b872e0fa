//! Takes connections and requests, within limits.
//!
//! A connection's requests are answered one after the other in the order in which they came; a client may send the
//! next before it has the last answer. What a client does ends at most its own connection.

use std::io;
use std::pin::pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use encoring_bus::SharedImage;
use futures_util::{SinkExt, StreamExt};
use tokio::io::{AsyncRead, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use tokio_util::bytes::BytesMut;
use tokio_util::codec::{Encoder, Framed};

use crate::counters::{Open, ServerCounts};
use crate::frame::{Codec, Frame, FrameError};
use crate::gateway_fault::GatewayMisdeed;
use crate::misdeeds::GatewayFaults;
use crate::pdu::{Pdu, respond};
use crate::place::WordOrder;
use crate::registers::RegisterMap;

/// After an accept error, so that a lasting one (no file descriptor left) does not take the processor with it.
const ACCEPT_BACK_OFF: Duration = Duration::from_millis(10);

/// Bytes of an answer that comes in two segments in the first, in the middle of its header.
const FIRST_SEGMENT: usize = 5;
/// The time between the two.
const BETWEEN_SEGMENTS: Duration = Duration::from_millis(5);

/// What a server may be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Which register holds what.
    pub layout: RegisterMap,
    /// Which half of a word comes first.
    pub word_order: WordOrder,
    /// How many connections may be open; a further one is accepted and closed at once.
    pub connections: usize,
    /// How long after its last whole request a connection is closed. An answer that a client does not take for as
    /// long ends the connection too.
    pub idle: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            layout: RegisterMap::default(),
            word_order: WordOrder::default(),
            connections: 32,
            idle: Duration::from_secs(60),
        }
    }
}

/// Serves the image until `stop` resolves, then closes every connection and returns.
///
/// Each request locks the image once: what it reads or writes, it reads or writes in one piece.
pub async fn serve(
    listener: TcpListener,
    image: SharedImage,
    options: Options,
    counters: Arc<ServerCounts>,
    stop: impl Future<Output = ()>,
) {
    serve_faulty(listener, image, options, counters, GatewayFaults::default(), stop).await;
}

/// The same with the faults of a gateway.
pub async fn serve_faulty(
    listener: TcpListener,
    image: SharedImage,
    options: Options,
    counters: Arc<ServerCounts>,
    faults: GatewayFaults,
    stop: impl Future<Output = ()>,
) {
    let accept = |context: &mut Context<'_>| listener.poll_accept(context).map_ok(|(socket, _)| socket);
    serve_from(accept, image, options, counters, faults, stop).await;
}

async fn serve_from(
    mut accept: impl FnMut(&mut Context<'_>) -> Poll<io::Result<TcpStream>>,
    image: SharedImage,
    options: Options,
    counters: Arc<ServerCounts>,
    faults: GatewayFaults,
    stop: impl Future<Output = ()>,
) {
    let mut stop = pin!(stop);
    let mut connections = JoinSet::new();
    // Numbers of clients, counted from 1.
    let mut client = 0_u32;
    loop {
        let accepted = tokio::select! {
            // Connections that have ended make room before the next one is looked at.
            biased;
            () = &mut stop => break,
            Some(_) = connections.join_next() => continue,
            accepted = std::future::poll_fn(&mut accept) => accepted,
        };
        match accepted {
            // It hears that nobody is there.
            Ok(socket) if faults.is_dead() => drop(socket),
            Ok(socket) if connections.len() < options.connections => {
                // Only a matter of speed, so a socket that refuses is served all the same.
                let _ = socket.set_nodelay(true);
                let open = Open::new(Arc::clone(&counters));
                client = client.wrapping_add(1);
                let (image, counters, faults) = (image.clone(), Arc::clone(&counters), faults.clone());
                connections.spawn(async move {
                    converse(socket, &image, options, &counters, &faults, client).await;
                    drop(open);
                });
            }
            Ok(_) => counters.refused_connections.add_one(),
            Err(_) => {
                counters.accept_errors.add_one();
                tokio::select! {
                    () = &mut stop => break,
                    () = sleep(ACCEPT_BACK_OFF) => {}
                }
            }
        }
    }
    connections.shutdown().await;
}

/// Answers one client, whose connection has this number, until it leaves, falls silent or sends what is not Modbus.
async fn converse(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    image: &SharedImage,
    options: Options,
    counters: &ServerCounts,
    faults: &GatewayFaults,
    client: u32,
) {
    let mut stream = Framed::new(stream, Codec);
    loop {
        // The time runs from the last whole request: single bytes do not keep a connection open.
        let Ok(came) = timeout(options.idle, stream.next()).await else {
            return counters.closed_idle.add_one();
        };
        let Frame { transaction, unit, pdu } = match came {
            Some(Ok(request)) => request,
            Some(Err(FrameError::Protocol { .. } | FrameError::Length { .. })) => {
                return counters.closed_bad_frames.add_one();
            }
            Some(Err(FrameError::Line(_))) | None => return,
        };
        let misdeeds = faults.request();
        if faults.is_dead() {
            return;
        }
        if misdeeds.has(GatewayMisdeed::Silent) {
            continue;
        }
        let asked = misdeeds.through(pdu.as_bytes());
        let (pdu, service) = answered(client, &asked, misdeeds.exception(&asked), image, options);
        counters.requests.add_one();
        if pdu.is_exception() {
            counters.exceptions.add_one();
        }
        if misdeeds.has(GatewayMisdeed::Dead) && service == ServiceBit::Set {
            return faults.die();
        }
        if misdeeds.has(GatewayMisdeed::Drop) {
            continue;
        }
        if misdeeds.late() > Duration::ZERO {
            sleep(misdeeds.late()).await;
        }
        let transaction = transaction.wrapping_add(u16::from(misdeeds.has(GatewayMisdeed::Transaction)));
        let unit = misdeeds.unit().unwrap_or(unit);
        let answer = Frame { transaction, unit, pdu: Pdu::of(misdeeds.back(pdu.as_bytes())) };
        let sent = async {
            if misdeeds.has(GatewayMisdeed::Split) {
                in_two(stream.get_mut(), answer).await
            } else {
                stream.send(answer).await
            }
        };
        match timeout(options.idle, sent).await {
            Ok(Ok(())) if misdeeds.has(GatewayMisdeed::Close) => return,
            Ok(Ok(())) => {}
            Ok(Err(_)) => return,
            Err(_) => return counters.closed_idle.add_one(),
        }
    }
}

/// What became of the service bits of OUT.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ServiceBit {
    /// A request has set one that was not set.
    Set,
    AsBefore,
}

/// The answer to a request; `exception` is one that the gateway gives in place of it.
fn answered(
    client: u32,
    asked: &[u8],
    exception: Option<u8>,
    image: &SharedImage,
    options: Options,
) -> (Pdu, ServiceBit) {
    let Options { layout, word_order, .. } = options;
    if let Some(code) = exception {
        return (Pdu::of([asked.first().copied().unwrap_or_default() | 0x80, code]), ServiceBit::AsBefore);
    }
    image.with_client(client, |image, wrote| {
        let before: Vec<bool> = image.out().iter().map(|out| out.service_bit()).collect();
        let pdu = respond(asked, image, layout, word_order, wrote);
        let set = image.out().iter().zip(before).any(|(out, before)| out.service_bit() && !before);
        (pdu, if set { ServiceBit::Set } else { ServiceBit::AsBefore })
    })
}

/// Sends an answer in two segments.
async fn in_two(stream: &mut (impl AsyncWrite + Unpin), answer: Frame) -> Result<(), FrameError> {
    let mut bytes = BytesMut::new();
    Codec.encode(answer, &mut bytes)?;
    let (head, tail) = bytes.split_at_checked(FIRST_SEGMENT).unwrap_or((&bytes, &[]));
    stream.write_all(head).await?;
    stream.flush().await?;
    sleep(BETWEEN_SEGMENTS).await;
    stream.write_all(tail).await?;
    Ok(stream.flush().await?)
}

#[cfg(test)]
mod tests;
