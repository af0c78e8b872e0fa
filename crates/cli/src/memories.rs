//! The folder that holds the memories of simulated encoders.

use std::fs;
use std::io;
use std::path::Path;

use encoring_encoder::Unit;
use encoring_files::Lock;
use encoring_sim::World;
use encoring_sim::state::{self, Kept};

use crate::output::{Failure, bad_input, note};

/// Puts the memories of earlier runs into the encoders, and keeps other runs away from the folder.
pub(crate) fn remember(folder: &Path, units: &[Unit], world: &mut World) -> Result<Lock, Failure> {
    // First all are read, so that a folder with one foreign file is left as it is.
    let memories: Vec<_> = units
        .iter()
        .enumerate()
        .map(|(position, unit)| state::read(folder, position, unit))
        .collect::<Result<_, _>>()
        .map_err(bad_input)?;
    let problem = |cause: io::Error| bad_input(format!("--state {}: {cause}", folder.display()));
    fs::create_dir_all(folder).map_err(problem)?;
    let lock = Lock::on(&folder.join("lock")).map_err(problem)?;
    let used = || bad_input(format!("--state {}: another simulation uses this folder", folder.display()));
    let lock = lock.ok_or_else(used)?;
    for (position, (kept, unit)) in memories.into_iter().zip(units).enumerate() {
        let Some(Kept { memory, stale_service }) = kept else { continue };
        if stale_service != unit.stale_service {
            note(&format!(
                "position {position}: its state file has stale_service = \"{stale_service}\", the scenario \"{}\"; \
                 the scenario counts",
                unit.stale_service
            ));
        }
        world.insert_memory(position, memory);
    }
    Ok(lock)
}
