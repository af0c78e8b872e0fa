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
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};
use tokio_util::codec::Framed;

use crate::counters::{Open, ServerCounts};
use crate::frame::{Codec, Frame, FrameError};
use crate::pdu::respond;
use crate::place::WordOrder;
use crate::registers::RegisterMap;

/// After an accept error, so that a lasting one (no file descriptor left) does not take the processor with it.
const ACCEPT_BACK_OFF: Duration = Duration::from_millis(10);

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
    let accept = |context: &mut Context<'_>| listener.poll_accept(context).map_ok(|(socket, _)| socket);
    serve_from(accept, image, options, counters, stop).await;
}

async fn serve_from(
    mut accept: impl FnMut(&mut Context<'_>) -> Poll<io::Result<TcpStream>>,
    image: SharedImage,
    options: Options,
    counters: Arc<ServerCounts>,
    stop: impl Future<Output = ()>,
) {
    let mut stop = pin!(stop);
    let mut connections = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            // Connections that have ended make room before the next one is looked at.
            biased;
            () = &mut stop => break,
            Some(_) = connections.join_next() => continue,
            accepted = std::future::poll_fn(&mut accept) => accepted,
        };
        match accepted {
            Ok(socket) if connections.len() < options.connections => {
                // Only a matter of speed, so a socket that refuses is served all the same.
                let _ = socket.set_nodelay(true);
                let open = Open::new(Arc::clone(&counters));
                let (image, counters) = (image.clone(), Arc::clone(&counters));
                connections.spawn(async move {
                    converse(socket, &image, options, &counters).await;
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

/// Answers one client until it leaves, falls silent or sends what is not Modbus.
async fn converse(
    stream: impl AsyncRead + AsyncWrite + Unpin,
    image: &SharedImage,
    options: Options,
    counters: &ServerCounts,
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
        let Options { layout, word_order, .. } = options;
        let pdu = image.with(|image| respond(pdu.as_bytes(), image, layout, word_order));
        counters.requests.add_one();
        if pdu.is_exception() {
            counters.exceptions.add_one();
        }
        match timeout(options.idle, stream.send(Frame { transaction, unit, pdu })).await {
            Ok(Ok(())) => {}
            Ok(Err(_)) => return,
            Err(_) => return counters.closed_idle.add_one(),
        }
    }
}

#[cfg(test)]
mod tests;
