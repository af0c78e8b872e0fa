//! Keeps the memories of a running ring in files.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use encoring_encoder::Unit;
use encoring_encoder::records::EEPROM_BYTES;
use encoring_sim::Eeprom;
use encoring_sim::state::{self, StateError};

use crate::station::Handle;

/// How often the memories are looked at: a change is in its file at most a second later.
const LOOK_EVERY: Duration = Duration::from_millis(500);

/// A thread that writes each memory to its file when it has changed.
#[derive(Debug)]
pub struct Keeper {
    stop: Sender<()>,
    thread: JoinHandle<Result<(), StateError>>,
    folder: PathBuf,
    units: Vec<Unit>,
}

impl Keeper {
    /// Writes every memory once, and then those that change.
    ///
    /// # Errors
    /// [`StateError`] if a file cannot be written.
    pub fn start(ring: Handle, folder: PathBuf, units: Vec<Unit>) -> Result<Self, StateError> {
        let mut kept = vec![None; units.len()];
        keep(&ring, &folder, &units, &mut kept)?;
        let (stop, stopped) = channel();
        let (for_thread, units_for_thread) = (folder.clone(), units.clone());
        let thread = thread::spawn(move || run(&ring, &for_thread, &units_for_thread, &mut kept, &stopped));
        Ok(Self { stop, thread, folder, units })
    }

    /// Stops and writes the memories that the ring left when it was switched off.
    ///
    /// # Errors
    /// [`StateError`] of this or an earlier write.
    pub fn finish(self, memories: &[Eeprom]) -> Result<(), StateError> {
        drop(self.stop);
        // A thread cannot panic here; if it did, the last images are written all the same.
        let earlier = self.thread.join().unwrap_or(Ok(()));
        for (position, (unit, memory)) in self.units.iter().zip(memories).enumerate() {
            state::write(&self.folder, position, unit, memory)?;
        }
        earlier
    }
}

type Kept = Option<[u8; EEPROM_BYTES]>;

fn run(
    ring: &Handle,
    folder: &std::path::Path,
    units: &[Unit],
    kept: &mut [Kept],
    stopped: &Receiver<()>,
) -> Result<(), StateError> {
    let mut result = Ok(());
    while stopped.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
        // A full disk may be emptied: the next look tries again, the last failure is told at the end.
        result = keep(ring, folder, units, kept);
    }
    result
}

fn keep(
    ring: &Handle,
    folder: &std::path::Path,
    units: &[Unit],
    kept: &mut [Kept],
) -> Result<(), StateError> {
    let Ok(memories) = ring.memories() else { return Ok(()) };
    for (position, ((unit, memory), kept)) in units.iter().zip(memories).zip(kept).enumerate() {
        if kept.as_ref() != Some(memory.now.image()) {
            state::write(folder, position, unit, &memory.at_power_off)?;
            *kept = Some(*memory.now.image());
        }
    }
    Ok(())
}
