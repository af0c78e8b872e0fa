//! The files that `encoring sim` records into.

use std::fs;
use std::io;
use std::path::Path;

use encoring_files::{Existing, folder};
use encoring_sim::{Shown, World};
use encoring_station::{Recorded, Recorder, RecordingFile};
use encoring_trace::wave::Format as WaveFormat;

use super::Arguments;
use crate::output::{Failure, bad_input, note};

/// A file that shall be recorded into.
pub(super) struct Recording<'a> {
    /// The option that names it.
    option: &'static str,
    file: &'a Path,
    recorded: Recorded,
}

impl Arguments {
    /// The files that shall be recorded into.
    pub(super) fn recordings(&self) -> Vec<Recording<'_>> {
        let exchanges = self.record.as_deref().map(|file| {
            let shown = if self.lines { Shown::Lines } else { Shown::Words };
            let with_words = |format: WaveFormat| if self.words { format.with_words() } else { format };
            let recorded = WaveFormat::of(file)
                .map_or(Recorded::Exchanges, |format| Recorded::Waveform(with_words(format), shown));
            Recording { option: "--record", file, recorded }
        });
        let bus = self.record_bus.as_deref();
        let bus = bus.map(|file| Recording { option: "--record-bus", file, recorded: Recorded::Bus });
        exchanges.into_iter().chain(bus).collect()
    }

    /// Begins the recordings that there shall be.
    pub(super) fn record(&self, world: &mut World) -> Result<Vec<(RecordingFile, Recorder)>, Failure> {
        let existing = if self.overwrite { Existing::Replaced } else { Existing::Kept };
        self.recordings().into_iter().map(|recording| recording.begin(existing, world)).collect()
    }

    /// Refuses recordings that could not be finished, or whose end would cost something else.
    pub(super) fn recordable(&self) -> Result<(), Failure> {
        let recordings = self.recordings();
        if self.overwrite && recordings.is_empty() {
            return Err(bad_input(
                "--overwrite: there is nothing to record; name a file with --record or --record-bus",
            ));
        }
        for (k, recording) in recordings.iter().enumerate() {
            self.can_hold(recording)?;
            let earlier = recordings.iter().take(k);
            if let Some(other) = earlier.into_iter().find(|other| other.is_same(recording)) {
                return Err(recording.refused(&format!("{} names the same file", other.option)));
            }
        }
        Ok(())
    }

    fn can_hold(&self, recording: &Recording<'_>) -> Result<(), Failure> {
        let Recording { file, recorded, .. } = recording;
        if self.lines && *recorded == Recorded::Exchanges {
            return Err(recording.refused("a trace has no lines; with --lines name a .vcd or .fst"));
        }
        if self.words && *recorded == Recorded::Exchanges {
            return Err(recording.refused("a trace always has its words; with --words name a .vcd or .fst"));
        }
        let folder = folder(file);
        if !folder.is_dir() {
            return Err(recording.refused(&format!("there is no folder {}; make it first", folder.display())));
        }
        if self.scenario.as_ref().is_some_and(|scenario| same(file, scenario)) {
            return Err(recording.refused("this is the scenario"));
        }
        if self.memories.state.as_ref().is_some_and(|state| same(folder, state)) {
            return Err(recording.refused("this folder holds the memories; name another one"));
        }
        match fs::symlink_metadata(file) {
            Ok(found) if !found.is_file() => Err(recording.refused("not an ordinary file; name a new one")),
            Ok(_) if !self.overwrite => {
                Err(recording.refused("it is there already; name a new one, or give --overwrite"))
            }
            _ => Ok(()),
        }
    }
}

impl Recording<'_> {
    fn begin(&self, existing: Existing, world: &mut World) -> Result<(RecordingFile, Recorder), Failure> {
        let begun = RecordingFile::begin(self.file, existing, world, self.recorded)
            .map_err(|cause| self.refused(&cause.to_string()))?;
        if let Some(remains) = begun.0.remains() {
            note(&format!(
                "note: {} {}: what a run that was killed had recorded is kept as {}",
                self.option,
                self.file.display(),
                remains.display()
            ));
        }
        Ok(begun)
    }

    fn is_same(&self, other: &Self) -> bool {
        self.file.file_name() == other.file.file_name() && same(folder(self.file), folder(other.file))
    }

    fn refused(&self, why: &str) -> Failure {
        bad_input(format!("{} {}: {why}", self.option, self.file.display()))
    }

    /// Gives the recording its name, or says where it is instead.
    pub(super) fn finish(&self, file: RecordingFile, recorded: io::Result<()>) -> Result<(), String> {
        let partial = file.partial().display().to_string();
        let finished = recorded.and_then(|()| file.finish());
        finished.map_err(|cause| {
            format!("{} {}: {cause}; what was written is in {partial}", self.option, self.file.display())
        })
    }
}

fn same(one: &Path, other: &Path) -> bool {
    fs::canonicalize(one).is_ok_and(|one| fs::canonicalize(other).is_ok_and(|other| one == other))
}
