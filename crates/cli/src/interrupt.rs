//! Ctrl-C and SIGTERM: the first asks a command to end in order, the second ends it, whatever it waits for.

use std::io;
use std::process::exit;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::sleep;
use std::time::Duration;

use encoring_bus::LeftBit;
use encoring_words::OutWord;

use crate::output::{Failure, note};

/// What a command has after the second signal to end by itself.
const LAST_CHANCE: Duration = Duration::from_millis(1_500);

/// The exit code of a command that has no answer.
const NO_ANSWER: i32 = 3;

/// The mark that the first signal sets, and what is to be told if the second ends the command.
#[derive(Clone)]
pub(crate) struct Interrupt {
    stop: Arc<AtomicBool>,
    left: Arc<Mutex<Option<(usize, LeftBit)>>>,
}

impl Interrupt {
    /// Takes the signals of this process.
    pub(crate) fn new() -> Result<Self, Failure> {
        let interrupt = Self { stop: Arc::default(), left: Arc::default() };
        let (mine, signals) = (interrupt.clone(), AtomicU32::new(0));
        ctrlc::set_handler(move || mine.signalled(signals.fetch_add(1, Ordering::Relaxed) + 1))
            .map_err(|cause| Failure::Output(io::Error::other(cause)))?;
        Ok(interrupt)
    }

    /// The mark.
    pub(crate) fn stop(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.stop)
    }

    /// From now on a service may be under way at this position.
    pub(crate) fn serving(&self, position: usize, left: LeftBit) {
        *self.left.lock().unwrap_or_else(PoisonError::into_inner) = Some((position, left));
    }

    #[expect(clippy::disallowed_methods, reason = "nothing ends this wait but the end of the command")]
    fn signalled(&self, signals: u32) {
        self.stop.store(true, Ordering::Relaxed);
        if signals < 2 {
            return;
        }
        sleep(LAST_CHANCE);
        if let Some((position, left)) = &*self.left.lock().unwrap_or_else(PoisonError::into_inner)
            && let Some(left) = left.word()
        {
            note(&service_bit_left(*position, left));
        }
        note("error: interrupted twice");
        exit(NO_ANSWER);
    }
}

/// What must be told of a service bit that was not seen gone.
pub(crate) fn service_bit_left(position: usize, out: OutWord) -> String {
    format!(
        "note: OUT of position {position} may still hold {out}, with the service bit: no read of OUT has shown it gone. \
         Until it is, the encoder shows a reply or waits, and every command refuses. `encoring release --at {position}` \
         shows it and clears it"
    )
}
