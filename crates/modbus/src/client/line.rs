//! A byte stream that the client library and we both hold, so that what nobody asked for can be thrown away before a
//! request, and what went wrong can be told afterwards.

use std::fmt;
use std::future::poll_fn;
use std::io;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::task::yield_now;

/// A peer that sends more than this without being asked is given up.
const UNASKED_MAX: usize = 64 * 1024;

/// As much of a request and of its answer is kept as tells them apart: more than the longest frame.
const KEPT: usize = 300;

/// What a connection is made of: a socket, a serial port, or half of a pipe in tests.
pub(super) trait Stream: AsyncRead + AsyncWrite + Unpin + Send {}
impl<S: AsyncRead + AsyncWrite + Unpin + Send> Stream for S {}

/// One of two handles to a stream.
#[derive(Clone)]
pub(super) struct Line(Arc<Mutex<Inner>>);

struct Inner {
    stream: Box<dyn Stream>,
    /// Bytes since the last request.
    received: usize,
    /// The first of those that were written and read since the line was last cleared.
    sent: Vec<u8>,
    got: Vec<u8>,
    /// Why nothing will come any more. The client library does not tell this apart from bytes that make no frame.
    lost: Option<io::ErrorKind>,
}

impl Line {
    pub(super) fn new(stream: impl Stream + 'static) -> Self {
        Self(Arc::new(Mutex::new(Inner {
            stream: Box::new(stream),
            received: 0,
            sent: Vec::new(),
            got: Vec::new(),
            lost: None,
        })))
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // Nothing that is done under the lock leaves it half done.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// How many bytes have come since the line was last cleared.
    pub(super) fn received(&self) -> usize {
        self.inner().received
    }

    /// The request since the line was last cleared, and what came back, both up to a length.
    pub(super) fn exchange(&self) -> (Vec<u8>, Vec<u8>) {
        let inner = self.inner();
        (inner.sent.clone(), inner.got.clone())
    }

    /// Why the line is lost, if it is.
    pub(super) fn lost(&self) -> Option<io::ErrorKind> {
        self.inner().lost
    }

    /// Throws away what has come without being asked for.
    pub(super) async fn clear(&self) -> Result<(), io::ErrorKind> {
        // What came while nobody waited is known to the runtime only after it has asked the system once.
        yield_now().await;
        poll_fn(|context| {
            let mut inner = self.inner();
            let mut unasked = 0;
            loop {
                let mut scratch = [0; 256];
                let mut scratch = ReadBuf::new(&mut scratch);
                match inner.poll_read(context, &mut scratch) {
                    Poll::Pending => break,
                    Poll::Ready(Err(error)) => return Poll::Ready(Err(error.kind())),
                    Poll::Ready(Ok(())) => unasked += scratch.filled().len(),
                }
                if unasked > UNASKED_MAX {
                    return Poll::Ready(Err(io::ErrorKind::InvalidData));
                }
            }
            inner.received = 0;
            inner.sent.clear();
            inner.got.clear();
            Poll::Ready(Ok(()))
        })
        .await
    }
}

impl Inner {
    /// Reads; the end of the stream is an error, as a peer has no reason to end it.
    fn poll_read(&mut self, context: &mut Context<'_>, buffer: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let result = match ready!(Pin::new(&mut self.stream).poll_read(context, buffer)) {
            Ok(()) if buffer.filled().len() == before => Err(io::ErrorKind::ConnectionAborted.into()),
            result => result,
        };
        let new = buffer.filled().get(before..).unwrap_or_default();
        self.received = self.received.saturating_add(new.len());
        self.got.extend(new.iter().take(KEPT.saturating_sub(self.got.len())));
        Poll::Ready(self.noted(result))
    }

    fn noted<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        if let Err(error) = &result {
            self.lost = Some(error.kind());
        }
        result
    }
}

impl AsyncRead for Line {
    fn poll_read(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        self.inner().poll_read(context, buffer)
    }
}

impl AsyncWrite for Line {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let mut inner = self.inner();
        let result = ready!(Pin::new(&mut inner.stream).poll_write(context, bytes));
        let written = result.as_ref().ok().and_then(|written| bytes.get(..*written)).unwrap_or_default();
        let room = KEPT.saturating_sub(inner.sent.len());
        inner.sent.extend(written.iter().take(room));
        Poll::Ready(inner.noted(result))
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let mut inner = self.inner();
        let result = ready!(Pin::new(&mut inner.stream).poll_flush(context));
        Poll::Ready(inner.noted(result))
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner().stream).poll_shutdown(context)
    }
}

impl fmt::Debug for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Line").finish_non_exhaustive()
    }
}
