//! Lines for a reader that may be slow, or gone: whoever prints never waits for it.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use serde::Serialize;

use super::Format;

/// How many texts wait for their reader; beyond that they are counted instead.
const TEXTS_WAITING: usize = 1_024;

/// How long the last lines wait for their reader after a signal.
pub(crate) const READER_PATIENCE: Duration = Duration::from_secs(1);

/// How often is looked whether they were read.
const LOOK_EVERY: Duration = Duration::from_millis(10);

/// Prints in a thread of its own.
pub(crate) struct Printer {
    texts: SyncSender<String>,
    thread: Option<JoinHandle<io::Result<()>>>,
    format: Format,
    lost: u64,
}

impl Printer {
    /// Prints to `sink`. As soon as there is room again, a line says how many were not printed.
    pub(crate) fn start(sink: impl Write + Send + 'static, format: Format) -> io::Result<Self> {
        let (texts, waiting) = sync_channel(TEXTS_WAITING);
        let thread =
            thread::Builder::new().name("printer".to_owned()).spawn(move || print(sink, &waiting))?;
        Ok(Self { texts, thread: Some(thread), format, lost: 0 })
    }

    /// Prints a text of whole lines, or counts it if too many wait already.
    ///
    /// # Errors
    /// Why nothing can be printed any more: that of an earlier text.
    pub(crate) fn print(&mut self, text: String) -> io::Result<()> {
        if self.lost > 0 && self.send(lost(self.format, self.lost))? {
            self.lost = 0;
        }
        if self.lost > 0 || !self.send(text)? {
            self.lost += 1;
        }
        Ok(())
    }

    /// # Errors
    /// Why nothing can be printed any more.
    pub(crate) fn check(&mut self) -> io::Result<()> {
        let works = self.thread.as_ref().is_some_and(|thread| !thread.is_finished());
        if works { Ok(()) } else { Err(self.ended()) }
    }

    /// `false` if there is no room.
    fn send(&mut self, text: String) -> io::Result<bool> {
        match self.texts.try_send(text) {
            Ok(()) => Ok(true),
            Err(TrySendError::Full(_)) => Ok(false),
            Err(TrySendError::Disconnected(_)) => Err(self.ended()),
        }
    }

    fn ended(&mut self) -> io::Error {
        let ended = self.thread.take().map(JoinHandle::join);
        match ended {
            Some(Ok(Err(cause))) => cause,
            _ => io::ErrorKind::BrokenPipe.into(),
        }
    }

    /// No more texts come. What waits is printed before the last call of [`Closing::is_done`] says so.
    pub(crate) fn close(mut self) -> Closing {
        if self.lost > 0 {
            let _ = self.send(lost(self.format, self.lost));
        }
        Closing(self.thread)
    }
}

/// Lines that nobody read in time, for programs.
#[derive(Serialize)]
struct LinesLost {
    event: &'static str,
    lines: u64,
}

fn lost(format: Format, lines: u64) -> String {
    match format {
        Format::Text => format!("{lines} lines were not printed: nobody read them\n"),
        Format::Json => {
            serde_json::to_string(&LinesLost { event: "lines_lost", lines }).unwrap_or_default() + "\n"
        }
    }
}

/// The last texts on their way to the reader.
pub(crate) struct Closing(Option<JoinHandle<io::Result<()>>>);

impl Closing {
    /// `true` once everything is printed, or cannot be.
    pub(crate) fn is_done(&self) -> bool {
        self.0.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits for the reader: as long as it takes, or a second more once `quit` is set.
    pub(crate) fn wait(self, quit: &AtomicBool) -> io::Result<()> {
        let mut patience = READER_PATIENCE;
        while !self.is_done() && !patience.is_zero() {
            thread::park_timeout(LOOK_EVERY);
            if quit.load(Ordering::Relaxed) {
                patience = patience.saturating_sub(LOOK_EVERY);
            }
        }
        self.end()
    }

    /// How it ended; what nobody has read until now is left.
    pub(crate) fn end(self) -> io::Result<()> {
        match self.0 {
            Some(thread) if thread.is_finished() => thread.join().unwrap_or(Ok(())),
            _ => Ok(()),
        }
    }
}

fn print(mut sink: impl Write, texts: &Receiver<String>) -> io::Result<()> {
    for text in texts {
        sink.write_all(text.as_bytes())?;
        sink.flush()?;
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use std::sync::mpsc::channel;
    use std::sync::{Arc, Mutex};

    /// A reader that takes a text each time it is told to.
    struct Slow(Receiver<()>, Arc<Mutex<Vec<u8>>>);

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.recv().map_err(|_| io::ErrorKind::BrokenPipe)?;
            self.1.lock().unwrap().write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn what_nobody_reads_is_counted_and_told_once_there_is_room() {
        let (read, reads) = channel();
        let seen = Arc::new(Mutex::new(Vec::new()));
        let mut printer = Printer::start(Slow(reads, Arc::clone(&seen)), Format::Text).unwrap();
        // The thread may hold one more.
        for k in 0..TEXTS_WAITING + 10 {
            printer.print(format!("{k}\n")).unwrap();
        }
        let lost = printer.lost;
        assert!((9..=10).contains(&lost), "{lost}");
        for _ in 0..TEXTS_WAITING {
            read.send(()).unwrap();
        }
        while seen.lock().unwrap().iter().filter(|byte| **byte == b'\n').count() < TEXTS_WAITING {
            thread::yield_now();
        }
        printer.print("last\n".to_owned()).unwrap();
        let closing = printer.close();
        for _ in 0..3 {
            let _ = read.send(());
        }
        while !closing.is_done() {
            thread::yield_now();
        }
        closing.end().unwrap();
        let text = String::from_utf8(seen.lock().unwrap().clone()).unwrap();
        assert!(
            text.ends_with(&format!("{lost} lines were not printed: nobody read them\nlast\n")),
            "{text:?}"
        );
    }

    #[test]
    fn a_reader_that_is_gone_is_an_error_of_the_next_text() {
        let (read, reads) = channel();
        drop(read);
        let mut printer = Printer::start(Slow(reads, Arc::default()), Format::Text).unwrap();
        let cause = loop {
            if let Err(cause) = printer.print("a\n".to_owned()) {
                break cause;
            }
        };
        assert_eq!(cause.kind(), io::ErrorKind::BrokenPipe);
    }
}
