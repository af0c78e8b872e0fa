//! The journal as commands use it: what is being programmed is noted before the first write, and told to whoever comes
//! after a command that was killed.

use std::fmt;
use std::path::PathBuf;
use std::time::SystemTime;

use clap::Args;
use encoring_bus::master::MasterError;
use encoring_host::program::{Prepared, Report};
use encoring_words::Parameter;
use encoring_workshop::journal::{EncoderPlace, Found, Intent, Journal, Page};
use etcetera::BaseStrategy;
use serde::Serialize;

use crate::bus::Opened;
use crate::output::{Failure, bad_input, note};

/// Where is noted what is being programmed.
#[derive(Args, Debug, Clone)]
pub(crate) struct JournalFolder {
    /// Folder for notes of what is being programmed [default: encoring/journal in the user's state folder]
    #[arg(long, value_name = "DIR", global = true)]
    journal: Option<PathBuf>,
}

/// The journal's page of one encoder; `None` if the user has no folder for it.
pub(crate) struct Noted(Option<Page>);

/// A command that was begun on an encoder and is not known to have ended.
#[derive(Clone)]
pub(crate) struct Earlier {
    intent: Intent,
    pub(crate) found: Found,
    text: Vec<String>,
}

/// The same as it is printed.
#[derive(Serialize)]
pub(crate) struct EarlierView {
    command: String,
    begun: String,
    /// `untouched`, `part_written`, `all_written`, `other_unit` or `unknown`.
    state: &'static str,
    backups: Vec<String>,
    text: Vec<String>,
}

impl JournalFolder {
    /// The page of the encoder at a position; none for a simulated ring that forgets.
    pub(crate) fn of(&self, opened: &Opened, position: usize) -> Option<Noted> {
        let bus = opened.identity()?;
        let folder = self.journal.clone().or_else(users_folder);
        Some(Noted(
            folder.map(|folder| Page::new(Journal::in_folder(folder), EncoderPlace { bus, position })),
        ))
    }
}

fn users_folder() -> Option<PathBuf> {
    let folders = etcetera::choose_base_strategy().ok()?;
    Some(folders.state_dir().unwrap_or_else(|| folders.data_dir()).join("encoring").join("journal"))
}

impl Noted {
    /// What was begun here and is not known to have ended. `read` gives what a parameter holds now.
    pub(crate) fn earlier(&self, read: impl Fn(Parameter) -> Option<u32>) -> Option<Earlier> {
        match self.0.as_ref()?.pending() {
            Ok(intent) => {
                let intent = intent?;
                let found = intent.found(&read);
                let text = intent.told(found, read);
                Some(Earlier { intent, found, text })
            }
            Err(error) => {
                note(&format!("note: the journal is not believed: {error}"));
                None
            }
        }
    }

    /// Whether something was begun here and is not known to have ended.
    pub(crate) fn is_open(&self) -> bool {
        self.0.as_ref().is_some_and(|page| page.pending().is_ok_and(|pending| pending.is_some()))
    }

    /// A data check has made these values count; if they are those of before or those that were wanted, what was begun has
    /// ended.
    pub(crate) fn checked(&self, read: impl Fn(Parameter) -> Option<u32>) {
        let found = self.earlier(read).map(|earlier| earlier.found);
        if matches!(found, Some(Found::AllWritten | Found::Untouched)) {
            self.settle(None, None);
        }
    }

    /// Notes what will be written; when this returns it is on the disk.
    #[expect(clippy::disallowed_methods, reason = "the journal says when something was begun")]
    pub(crate) fn begin(
        &self,
        prepared: &Prepared<MasterError>,
        command: &str,
        backup: Option<&str>,
        earlier: Option<&Earlier>,
    ) -> Result<(), Failure> {
        let begun = humantime::format_rfc3339_seconds(SystemTime::now()).to_string();
        let backup = backup.map(|backup| match std::path::absolute(backup) {
            Ok(path) => path.display().to_string(),
            Err(_) => backup.to_owned(),
        });
        let problem = match &self.0 {
            Some(page) => match page.begin(prepared, command, begun, backup, believed(earlier)) {
                Ok(()) => return Ok(()),
                Err(error) => error.to_string(),
            },
            None => "this user has no folder for it".to_owned(),
        };
        Err(bad_input(format!(
            "what is being programmed cannot be noted, so nothing was written: {problem}; --journal DIR names a folder"
        )))
    }

    /// What was begun has ended so; `None` if nothing was begun.
    pub(crate) fn settle(&self, report: Option<&Report<MasterError>>, earlier: Option<&Earlier>) {
        let Some(page) = &self.0 else { return };
        let settled = match report {
            Some(report) => page.settle(report, believed(earlier)),
            None => page.take_back(believed(earlier)),
        };
        if let Err(error) = settled {
            note(&format!(
                "note: the journal's note is not as it should be, though the command has ended: {error}"
            ));
        }
    }
}

/// What is believed of a command that was begun earlier.
fn believed(earlier: Option<&Earlier>) -> Option<&Intent> {
    earlier.filter(|earlier| earlier.found.is_believed()).map(|earlier| &earlier.intent)
}

impl Earlier {
    pub(crate) fn view(&self) -> EarlierView {
        EarlierView {
            command: self.intent.command.clone(),
            begun: self.intent.begun.clone(),
            state: self.found.name(),
            backups: self.intent.backups.clone(),
            text: self.text.clone(),
        }
    }
}

impl fmt::Display for EarlierView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text.join("\n"))
    }
}
