//! What `sheet` shows of a model.

use std::fmt;

use encoring_sheet::{Sheet, SheetSection};
use encoring_words::Model;
use encoring_words::model::{MODELS, Series};
use encoring_words::sheet::Section;
use serde::Serialize;

use super::table::{NOT_STATED, Table, paragraph};

/// The data sheet of a model.
#[derive(Serialize)]
pub(super) struct SheetView {
    model: &'static str,
    title: &'static str,
    document: &'static str,
    sections: Vec<SectionView>,
}

#[derive(Serialize)]
struct SectionView {
    section: &'static str,
    title: &'static str,
    /// Of the manual; `None`: it says nothing of this.
    chapters: Option<&'static str>,
    rows: Table,
    notes: Vec<String>,
}

impl SheetView {
    pub(super) fn new(model: Model, sections: &[Section]) -> Self {
        Self {
            model: model.name(),
            title: model.title(),
            document: model.data_sheet().document,
            sections: Sheet::new(model, sections).sections.into_iter().map(SectionView::new).collect(),
        }
    }

    pub(super) fn markdown(&self) -> String {
        let mut text = format!("# {}\n\nManual: {}.\n", self.title, self.document);
        for section in &self.sections {
            text.push_str(&format!("\n## {} of the {}\n\n", section.title, self.title));
            text.push_str(&section.source());
            text.push('\n');
            if !section.rows.is_empty() {
                text.push_str(&format!("\n{}", section.rows.markdown()));
            }
            for note in &section.notes {
                text.push_str(&format!("\n{note}\n"));
            }
        }
        text
    }
}

impl fmt::Display for SheetView {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}, manual {}", self.title, self.document)?;
        for section in &self.sections {
            writeln!(f, "\n{}", section.title.to_uppercase())?;
            paragraph(f, &section.source())?;
            if !section.rows.is_empty() {
                write!(f, "\n{}", section.rows)?;
            }
            if !section.notes.is_empty() {
                writeln!(f)?;
                section.notes.iter().try_for_each(|note| paragraph(f, note))?;
            }
        }
        Ok(())
    }
}

impl SectionView {
    fn new(section: SheetSection) -> Self {
        let SheetSection { section, chapters, rows, notes } = section;
        let notes = match chapters {
            Some(_) => notes.iter().map(ToString::to_string).collect(),
            None => vec![elsewhere(section)],
        };
        Self { section: section.name(), title: section.title(), chapters, rows: Table(rows), notes }
    }

    /// Where the manual says so, or that it does not.
    fn source(&self) -> String {
        match self.chapters {
            Some(chapters) => format!("In the manual: {chapters}."),
            None => format!("{NOT_STATED} in its manual."),
        }
    }
}

/// Which manuals do state a section.
fn elsewhere(section: Section) -> String {
    let stating: Vec<Model> =
        MODELS.into_iter().filter(|model| model.data_sheet().chapters(section).is_some()).collect();
    let commands: Vec<String> =
        stating.iter().map(|model| format!("`encoring sheet {model} {}`", section.name())).collect();
    format!("Another encoder's manual states it: {}.", Series(&commands, "and"))
}
