//! The folder that holds the memories of simulated encoders.

use encoring_sim::World;
use encoring_sim::state::{NotSaved, Overruled, StateFolder};

use crate::arguments::State;
use crate::output::{Failure, bad_input, note};

impl State {
    /// Puts the memories of earlier runs into the encoders, and keeps other runs away from the folder.
    pub(crate) fn open(&self, world: &mut World) -> Result<Option<StateFolder>, Failure> {
        let Some(folder) = &self.state else { return Ok(None) };
        let folder =
            StateFolder::open(folder, world).map_err(|error| bad_input(format!("--state {error}")))?;
        if folder.is_read_only() {
            note(&format!(
                "note: --state {} cannot be written: it is read without a lock, and stays as it is",
                folder.path().display()
            ));
        }
        for Overruled { position, file, encoder } in folder.overruled() {
            note(&format!(
                "position {position}: its state file has stale_service = \"{file}\", the scenario \"{encoder}\"; \
                 the scenario counts"
            ));
        }
        Ok(Some(folder))
    }
}

/// Refuses a folder that cannot remember what changes.
pub(crate) fn can_be_written(folder: &StateFolder) -> Result<(), Failure> {
    if folder.is_read_only() {
        let folder = folder.path().display();
        return Err(bad_input(format!(
            "--state {folder}: what changes cannot be kept there; nothing was done"
        )));
    }
    Ok(())
}

/// What an encoder remembers is lost.
pub(crate) fn not_saved(error: &NotSaved) -> Failure {
    Failure::NoAnswer(format!("--state {error}"))
}
