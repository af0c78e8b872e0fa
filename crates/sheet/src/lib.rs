//! The data sheet of each encoder: what its manual states, section by section.
//!
//! ```
//! use encoring_sheet::Sheet;
//! use encoring_words::Model;
//! use encoring_words::sheet::Section;
//!
//! let sheet = Sheet::new(Model::Ce65M, &[Section::Lamps]);
//! assert_eq!(sheet.sections[0].rows.columns, ["lamp", "colour", "manual", "lit"]);
//! ```

mod limits;
mod sections;
mod sentences;
mod table;

use encoring_texts::{Said, SaidTemplate};
use encoring_words::Model;
use encoring_words::sheet::Section;
use sections::Content;

pub use table::{SheetCell, SheetTable};

/// The data sheet of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Sheet {
    /// Whose.
    pub model: Model,
    /// The sections that were asked for.
    pub sections: Vec<SheetSection>,
}

/// A section of it.
#[derive(Clone, Debug, PartialEq)]
pub struct SheetSection {
    /// Which.
    pub section: Section,
    /// The chapters of the manual that state it; `None`: the manual says nothing of this, and nothing stands here.
    pub chapters: Option<&'static str>,
    /// Its table.
    pub rows: SheetTable,
    /// What is said below it.
    pub notes: Vec<Said>,
}

impl Sheet {
    /// These sections of a model's data sheet.
    #[must_use]
    pub fn new(model: Model, sections: &[Section]) -> Self {
        Self { model, sections: sections.iter().map(|section| SheetSection::new(model, *section)).collect() }
    }
}

impl SheetSection {
    fn new(model: Model, section: Section) -> Self {
        let sheet = model.data_sheet();
        let chapters = sheet.chapters(section);
        let none = || (SheetTable::new(&[], Vec::new()), Vec::new());
        let (rows, notes): Content = match section {
            _ if chapters.is_none() => none(),
            Section::Data => sections::data(model, sheet),
            Section::Pins => sections::pins(sheet),
            Section::Lamps => sections::lamps(sheet),
            Section::Services => sections::services(model),
            Section::Status => sections::status(model),
            Section::Faults => sections::faults(model),
            Section::Checklist => sections::rules(sheet.check_list),
            Section::Safety => sections::rules(sheet.safety),
            Section::Limits => limits::limits(model, sheet),
            Section::Levels => limits::levels(sheet),
            Section::Ssi => sheet.ssi.map_or_else(none, |ssi| limits::ssi_output(model, ssi)),
        };
        Self { section, chapters, rows, notes }
    }
}

/// The sentences of data sheets that hold values; all others are their own codes.
pub fn sentences() -> impl Iterator<Item = &'static SaidTemplate> {
    sentences::TEXTS.iter()
}
