//! Lines in, lines out.

use std::io;
use std::pin::pin;
use std::time::Duration as Real;

use encoring_station::answer::{answer, refusal};
use encoring_station::{Controlled, RingStopped};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::{JoinSet, spawn_blocking};
use tokio::time::{sleep, timeout};
use tokio_util::bytes::BytesMut;
use tokio_util::codec::{Decoder, LinesCodec, LinesCodecError};

use crate::unread::{LINE_BYTES_MAX, Unread, is_object};

/// How many who were refused may be told so at the same time; who comes on top is told nothing.
const FAREWELLS_MAX: usize = 8;

/// How long a peer has to take the last answer before the connection is closed.
const FAREWELL: Real = Real::from_secs(1);

/// How long to wait after the system gave no connection, which it does while it is short of something.
const AFTER_ACCEPT_ERROR: Real = Real::from_millis(50);

/// How much is read at once.
const READ_BYTES: usize = 4 * 1024;

/// What a server allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Connections at the same time.
    pub connections: usize,
    /// A connection is closed when no whole line came, or no answer was taken, for so long.
    pub idle: Real,
}

impl Default for Options {
    fn default() -> Self {
        Self { connections: 8, idle: Real::from_secs(600) }
    }
}

/// Answers everyone who connects, until `stop`; then every connection is closed. An error of one connection ends
/// that connection, never the server.
pub async fn serve(
    listener: TcpListener,
    controlled: Controlled,
    options: Options,
    stop: impl Future<Output = ()>,
) {
    let mut stop = pin!(stop);
    let mut served = JoinSet::new();
    let mut refused = JoinSet::new();
    loop {
        let accepted = tokio::select! {
            biased;
            () = &mut stop => break,
            Some(_) = served.join_next() => continue,
            Some(_) = refused.join_next() => continue,
            accepted = listener.accept() => accepted,
        };
        match accepted {
            Ok((stream, _)) if served.len() < options.connections => {
                let peer = Peer::new(stream, options.idle);
                served.spawn(peer.serve(controlled.clone()));
            }
            Ok((stream, _)) if refused.len() < FAREWELLS_MAX => {
                let full = Unread::Full { connections: options.connections };
                refused.spawn(Peer::new(stream, FAREWELL).farewell(full));
            }
            Ok(_) => {}
            Err(_) => tokio::select! {
                () = &mut stop => break,
                () = sleep(AFTER_ACCEPT_ERROR) => {}
            },
        }
    }
    served.shutdown().await;
    refused.shutdown().await;
}

/// One connection.
struct Peer {
    stream: TcpStream,
    codec: LinesCodec,
    /// Read, but not yet a line.
    held: BytesMut,
    /// The peer sends nothing more.
    ended: bool,
    idle: Real,
}

impl Peer {
    fn new(stream: TcpStream, idle: Real) -> Self {
        // Answers are short and waited for; without this they still arrive, later.
        let _ = stream.set_nodelay(true);
        let codec = LinesCodec::new_with_max_length(LINE_BYTES_MAX);
        Self { stream, codec, held: BytesMut::new(), ended: false, idle }
    }

    async fn serve(mut self, controlled: Controlled) {
        let mut first = true;
        while let Ok(Ok(Some(line))) = timeout(self.idle, self.line()).await {
            if std::mem::take(&mut first)
                && let Some(stranger) = stranger(&line)
            {
                return self.farewell(stranger).await;
            }
            let answer = match line {
                Ok(line) => {
                    let controlled = controlled.clone();
                    // Its thread is lost only with the runtime, and the ring goes with that.
                    spawn_blocking(move || answer(&line, &controlled))
                        .await
                        .unwrap_or_else(|_| refusal(&RingStopped.to_string()))
                }
                Err(LinesCodecError::Io(_)) => Unread::NotUtf8.answer(),
                Err(LinesCodecError::MaxLineLengthExceeded) => return self.farewell(Unread::TooLong).await,
            };
            if self.write(answer).await.is_err() {
                return;
            }
        }
    }

    /// The next line, a refusal of the codec, or `None` at the end. Reads on only when every line read is taken.
    async fn line(&mut self) -> io::Result<Option<Result<String, LinesCodecError>>> {
        loop {
            let decoded = match self.ended {
                false => self.codec.decode(&mut self.held),
                true => self.codec.decode_eof(&mut self.held),
            };
            if self.ended || !matches!(decoded, Ok(None)) {
                return Ok(decoded.transpose());
            }
            self.held.reserve(READ_BYTES);
            self.ended = self.stream.read_buf(&mut self.held).await? == 0;
        }
    }

    async fn write(&mut self, mut answer: String) -> io::Result<()> {
        answer.push('\n');
        timeout(self.idle, self.stream.write_all(answer.as_bytes())).await?
    }

    /// The last answer. What the peer still sends is read and dropped for a while: a connection closed over unread
    /// bytes is reset, and the answer lost.
    async fn farewell(mut self, refused: Unread) {
        let last = async {
            self.write(refused.answer()).await?;
            self.stream.shutdown().await?;
            let mut dropped = [0; READ_BYTES];
            while self.stream.read(&mut dropped).await? > 0 {}
            io::Result::Ok(())
        };
        // There is nobody left to tell.
        let _ = timeout(FAREWELL, last).await;
    }
}

/// What is told to a peer whose first line says that it did not mean this port. A browser can be made to send any text
/// to a port of its own machine, but only behind a first line of its protocol: a request like `POST / HTTP/1.1` or
/// `OPTIONS rtsp://a RTSP/1.0`, or the bytes of a TLS hello.
fn stranger(first: &Result<String, LinesCodecError>) -> Option<Unread> {
    match first {
        Ok(line) if is_object(line) => None,
        Ok(line) if line.contains(" HTTP/") => Some(Unread::Http),
        Ok(_) | Err(LinesCodecError::Io(_)) => Some(Unread::Stranger),
        Err(LinesCodecError::MaxLineLengthExceeded) => Some(Unread::TooLong),
    }
}
