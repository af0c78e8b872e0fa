//! Ctrl-C and SIGTERM: the first asks a command to end in order, the second ends it, whatever it waits for.
//!
//! A command that only looks ends on the first signal also where it waits for whoever reads its output, and any command
//! while a question stands.

use std::process::exit;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, sleep};
use std::time::Duration;

use encoring_bus::LeftBit;
use encoring_words::OutWord;
use ratatui::crossterm::terminal::disable_raw_mode;

use crate::output::{Failure, note};
use crate::signals;

/// What a command has after the second signal to end by itself.
const LAST_CHANCE: Duration = Duration::from_millis(1_500);

/// How long a reader that takes nothing is waited for after the first signal.
const READER_PATIENCE: Duration = Duration::from_secs(1);

/// How often is looked whether the reader has taken something.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// How often the program has waited for its reader or gone on: odd while it waits.
static READER: AtomicU32 = AtomicU32::new(0);

/// Does what may wait for whoever reads the output. One thread does that at a time.
pub(crate) fn awaiting_reader<T>(write: impl FnOnce() -> T) -> T {
    READER.fetch_add(1, Ordering::Relaxed);
    let written = write();
    READER.fetch_add(1, Ordering::Relaxed);
    written
}

/// The exit code of a command that has no answer.
const NO_ANSWER: i32 = 3;

/// A question stands. No service is under way then, so the first signal ends the command.
static ASKING: AtomicBool = AtomicBool::new(false);

/// Waits for the answer to a question.
pub(crate) fn asking<T>(wait: impl FnOnce() -> T) -> T {
    ASKING.store(true, Ordering::Relaxed);
    let answer = wait();
    ASKING.store(false, Ordering::Relaxed);
    answer
}

/// The mark that the first signal sets, and what is to be told if the second ends the command.
#[derive(Clone)]
pub(crate) struct Interrupt {
    stop: Arc<AtomicBool>,
    left: Arc<Mutex<Option<(usize, LeftBit)>>>,
    only_looks: Arc<AtomicBool>,
    /// A signal has come; whoever acts on [`Interrupt::stop`] takes that mark back.
    came: Arc<AtomicBool>,
}

impl Interrupt {
    /// Takes the signals of this process.
    pub(crate) fn new() -> Result<Self, Failure> {
        let interrupt = Self {
            stop: Arc::default(),
            left: Arc::default(),
            only_looks: Arc::default(),
            came: Arc::default(),
        };
        let (mine, signals) = (interrupt.clone(), AtomicU32::new(0));
        signals::on_each(move || mine.signalled(signals.fetch_add(1, Ordering::Relaxed) + 1))?;
        Ok(interrupt)
    }

    /// The mark.
    pub(crate) fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// Whether a signal has come.
    pub(crate) fn is_interrupted(&self) -> bool {
        self.came.load(Ordering::Relaxed)
    }

    /// The command leaves nothing behind that must be put in order, so it may end while it waits for its reader.
    pub(crate) fn only_looks(&self) {
        self.only_looks.store(true, Ordering::SeqCst);
        // The first signal may have come before.
        if self.came.load(Ordering::SeqCst) {
            thread::spawn(end_if_unread);
        }
    }

    /// From now on a service may be under way at this position.
    pub(crate) fn serving(&self, position: usize, left: LeftBit) {
        *self.left.lock().unwrap_or_else(PoisonError::into_inner) = Some((position, left));
    }

    #[expect(clippy::disallowed_methods, reason = "nothing ends this wait but the end of the command")]
    fn signalled(&self, signals: u32) {
        self.came.store(true, Ordering::SeqCst);
        self.stop.store(true, Ordering::Relaxed);
        if ASKING.load(Ordering::Relaxed) {
            self.end(
                "\nerror: interrupted: the question was not answered, and what it asks for was not done",
            );
        }
        if signals < 2 {
            if self.only_looks.load(Ordering::SeqCst) {
                // Beside the handler, which the second signal needs.
                thread::spawn(end_if_unread);
            }
            return;
        }
        sleep(LAST_CHANCE);
        self.end("error: interrupted twice");
    }

    /// Ends the program, and tells of a service bit that was left.
    fn end(&self, why: &str) -> ! {
        if let Some((position, left)) = &*self.left.lock().unwrap_or_else(PoisonError::into_inner)
            && let Some(left) = left.word()
        {
            note(&service_bit_left(*position, left));
        }
        note(why);
        exit(NO_ANSWER);
    }
}

/// Ends the program when its reader takes nothing.
#[expect(clippy::disallowed_methods, reason = "nothing ends this wait but the end of the command")]
fn end_if_unread() {
    let (mut before, mut patience) = (READER.load(Ordering::Relaxed), READER_PATIENCE);
    while !patience.is_zero() {
        sleep(LOOK_EVERY);
        let now = READER.load(Ordering::Relaxed);
        patience = if now == before && now % 2 == 1 { patience - LOOK_EVERY } else { READER_PATIENCE };
        before = now;
    }
    // Drawing is not to be waited for either, so of the terminal only this is put back.
    let _ = disable_raw_mode();
    exit(0);
}

/// What must be told of a service bit that was not seen gone.
pub(crate) fn service_bit_left(position: usize, out: OutWord) -> String {
    format!(
        "note: OUT of position {position} may still hold {out}, with the service bit: no read of OUT has shown it gone. \
         Until it is, the encoder shows a reply or waits, and every command refuses. `encoring release --at {position}` \
         shows it and clears it"
    )
}
