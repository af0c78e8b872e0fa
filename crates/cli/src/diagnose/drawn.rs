//! The picture and the page of what was found.

use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};

use clap::Args;
use encoring_diagnosis::{Diagnosed, PagePart, Picture, page};
use encoring_figure::Chart;
use encoring_files::Existing;

use crate::output::Failure;
use crate::output::new_file::{check_new_file, write_new_file};

/// Files that show what was found.
#[derive(Args, Debug)]
pub(super) struct DrawnArguments {
    /// Draw position and speed over time, with a close-up of each jump, as SVG
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Write everything as one page, picture included
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
    /// Replace the files of --plot and --report if they are there
    #[arg(long)]
    overwrite: bool,
}

impl DrawnArguments {
    const fn existing(&self) -> Existing {
        if self.overwrite { Existing::Replaced } else { Existing::Kept }
    }

    fn files(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let files = [("--plot", self.plot.as_deref()), ("--report", self.report.as_deref())];
        files.into_iter().filter_map(|(option, file)| Some((option, file?)))
    }

    /// Refuses names that cannot become files, before a long recording is read.
    pub(super) fn check(&self) -> Result<(), Failure> {
        self.files().try_for_each(|(option, file)| check_new_file(option, file, self.existing()))
    }

    /// What gathers the picture, if somebody wants to see it.
    pub(super) fn picture(&self) -> Option<Picture> {
        (self.files().next().is_some() || io::stdout().is_terminal()).then(Picture::default)
    }

    /// Writes the files.
    pub(super) fn write(&self, diagnosed: &[Diagnosed], charts: &[Vec<Chart>]) -> Result<(), Failure> {
        let names: Vec<&str> = diagnosed.iter().map(|file| file.name.as_str()).collect();
        let title = format!("Why the position jumped: {}", names.join(", "));
        for (option, file) in self.files() {
            let text = match option {
                "--plot" => Chart::sheet(&title, &charts.concat()),
                _ => page(&title, &parts(diagnosed, charts)),
            };
            write_new_file(option, file, self.existing(), |new| Ok(new.write_all(text.as_bytes())?))?;
        }
        Ok(())
    }
}

/// The charts of each file; episodes are numbered through all files.
pub(super) fn charts(diagnosed: &mut [Diagnosed]) -> Vec<Vec<Chart>> {
    let mut first = 1;
    let mut charts = Vec::new();
    for file in diagnosed {
        let episodes = &file.conclusion.episodes;
        let picture = file.picture.take().unwrap_or_default();
        charts.push(picture.charts(&file.name, first, episodes));
        first += episodes.len();
    }
    charts
}

fn parts<'a>(diagnosed: &'a [Diagnosed], charts: &'a [Vec<Chart>]) -> Vec<PagePart<'a>> {
    let mut first = 1;
    let part = |(file, charts): (&'a Diagnosed, &'a Vec<Chart>)| {
        let conclusion = &file.conclusion;
        let part = PagePart { name: &file.name, conclusion, first, charts };
        first += conclusion.episodes.len();
        part
    };
    diagnosed.iter().zip(charts).map(part).collect()
}

/// The small pictures for a terminal, of what has something to see.
pub(super) fn small(diagnosed: &[Diagnosed], charts: &[Vec<Chart>]) -> String {
    let jumped = diagnosed.iter().zip(charts).filter(|(file, _)| !file.conclusion.episodes.is_empty());
    jumped.flat_map(|(_, charts)| charts).map(|chart| format!("{}\n", chart.text())).collect()
}
