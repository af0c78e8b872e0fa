//! Keeps the memories of a running ring in files.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use encoring_encoder::Unit;
use encoring_encoder::records::EEPROM_BYTES;
use encoring_sim::Eeprom;
use encoring_sim::state::{self, NotSaved, StateFolder};

use crate::events::Happened;
use crate::station::Handle;

/// How often the memories are looked at. A change is in its file at most a second later, also on a disk that needs
/// some hundred milliseconds until a file is safe.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// A thread that writes each memory to its file when it has changed. One that cannot be written is tried again with
/// every look, and told as an event of the ring: once when it begins, and once when it is over.
#[derive(Debug)]
pub struct Keeper {
    stop: Sender<()>,
    thread: JoinHandle<()>,
    folder: Arc<StateFolder>,
    units: Vec<Unit>,
}

impl Keeper {
    /// Keeps memories in a folder, from the first look on all of them.
    #[must_use]
    pub fn start(ring: Handle, folder: StateFolder, units: Vec<Unit>) -> Self {
        let (stop, stopped) = channel();
        let kept = units.iter().map(|unit| Kept { unit: *unit, image: None, failed: false }).collect();
        let folder = Arc::new(folder);
        let keeping = Keeping { ring, folder: Arc::clone(&folder), kept };
        Self { stop, thread: thread::spawn(move || keeping.run(&stopped)), folder, units }
    }

    /// Stops and writes the memories that the ring left when it was switched off.
    ///
    /// # Errors
    /// [`NotSaved`]; every one is tried.
    pub fn finish(self, memories: &[Eeprom]) -> Result<(), NotSaved> {
        drop(self.stop);
        // The thread cannot panic; if it did, the last images are written all the same.
        let _ = self.thread.join();
        self.folder.save_all(self.units.into_iter().zip(memories.iter().cloned()))
    }
}

struct Keeping {
    ring: Handle,
    folder: Arc<StateFolder>,
    kept: Vec<Kept>,
}

/// What is known of the file of one memory.
struct Kept {
    unit: Unit,
    /// What the memory held when it was written.
    image: Option<[u8; EEPROM_BYTES]>,
    failed: bool,
}

impl Keeping {
    fn run(mut self, stopped: &Receiver<()>) {
        self.look();
        while stopped.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
            self.look();
        }
    }

    fn look(&mut self) {
        let Ok(memories) = self.ring.memories() else { return };
        for (position, (memory, kept)) in memories.iter().zip(&mut self.kept).enumerate() {
            if kept.image.as_ref() == Some(memory.now.image()) {
                continue;
            }
            let written = state::write(self.folder.path(), position, &kept.unit, &memory.at_power_off);
            let failed = written.is_err();
            match written {
                Ok(()) => kept.image = Some(*memory.now.image()),
                Err(error) if !kept.failed => {
                    self.ring.tell(Happened::MemoryNotSaved { position, problem: error.to_string() });
                }
                Err(_) => {}
            }
            if kept.failed && !failed {
                self.ring.tell(Happened::MemorySaved { position });
            }
            kept.failed = failed;
        }
    }
}
