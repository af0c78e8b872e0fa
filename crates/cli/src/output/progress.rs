//! A bar on the terminal of standard error. A thread of its own draws it: who moves it never waits for the terminal.

use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;
use std::time::Duration as Real;

use encoring_words::Duration;
use indicatif::{ProgressBar, ProgressStyle};

/// How long the terminal has to take the bar away.
const PATIENCE: Real = Real::from_millis(200);

/// What a bar over the time of a ring shows.
pub(crate) const RING_TIME: &str = "{bar:40} {percent:>3} % of the time on the ring, {eta} left";

/// A bar, or nothing where standard error is no terminal.
pub(crate) struct Progress(Option<Drawn>);

struct Drawn {
    shown: SyncSender<Shown>,
    /// Nothing comes; it closes when the bar is gone.
    gone: Receiver<()>,
    bar: ProgressBar,
}

/// What the bar shows.
struct Shown {
    passed: Duration,
    message: String,
}

impl Progress {
    /// A bar over so much time; without it a sign that something goes on.
    pub(crate) fn start(lasting: Option<Duration>, template: &str) -> io::Result<Self> {
        if !io::stderr().is_terminal() {
            return Ok(Self(None));
        }
        let bar =
            lasting.map_or_else(ProgressBar::new_spinner, |lasting| ProgressBar::new(milliseconds(lasting)));
        let style = ProgressStyle::with_template(template);
        let bar = bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let (shown, next) = sync_channel(1);
        let (here, gone) = sync_channel(0);
        let drawn = bar.clone();
        thread::Builder::new().name("progress".to_owned()).spawn(move || {
            draw(&drawn, &next);
            drop(here);
        })?;
        Ok(Self(Some(Drawn { shown, gone, bar })))
    }

    /// Shows how much has passed, unless the terminal is behind.
    pub(crate) fn show(&self, passed: Duration, message: impl FnOnce() -> String) {
        if let Some(Drawn { shown, .. }) = &self.0 {
            let _ = shown.try_send(Shown { passed, message: message() });
        }
    }

    /// Standard error, for lines that stand above the bar.
    pub(crate) fn beside(&self) -> impl Write + Send + 'static {
        Beside(self.0.as_ref().map(|drawn| drawn.bar.clone()))
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(Drawn { shown, gone, .. }) = self.0.take() {
            drop(shown);
            let _ = gone.recv_timeout(PATIENCE);
        }
    }
}

fn draw(bar: &ProgressBar, next: &Receiver<Shown>) {
    for Shown { passed, message } in next {
        bar.set_message(message);
        bar.set_position(milliseconds(passed));
        bar.tick();
    }
    bar.finish_and_clear();
}

const fn milliseconds(time: Duration) -> u64 {
    time.as_nanos() / 1_000_000
}

struct Beside(Option<ProgressBar>);

impl Write for Beside {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &self.0 {
            Some(bar) => bar.suspend(|| io::stderr().write(bytes)),
            None => io::stderr().write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        io::stderr().flush()
    }
}
