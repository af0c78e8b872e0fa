//! The data sheet of a model, as `encoring sheet` prints it: its sentences as codes and values.

use axum::extract::Query;
use axum::extract::rejection::QueryRejection;
use axum::http::StatusCode;
use axum::response::Response;
use encoring_sheet::{Sheet, SheetCell, SheetSection};
use encoring_texts::Said;
use encoring_words::Model;
use encoring_words::sheet::SECTIONS;
use serde::{Deserialize, Serialize, Serializer};

use crate::in_json::{given, refused, wrong_query};
use crate::refusals;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct SheetQuery {
    model: String,
}

#[derive(Serialize)]
struct ShownSheet {
    model: &'static str,
    title: &'static str,
    document: &'static str,
    sections: Vec<ShownSection>,
}

#[derive(Serialize)]
struct ShownSection {
    section: &'static str,
    /// `None`: the manual says nothing of this.
    chapters: Option<&'static str>,
    columns: &'static [&'static str],
    rows: Vec<Vec<ShownCell>>,
    notes: Vec<Said>,
}

struct ShownCell(SheetCell);

/// A sentence, a number, a text that is the same in every language, `false` for what is not stated, or nothing.
impl Serialize for ShownCell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            SheetCell::Said(said) => said.serialize(serializer),
            SheetCell::Same(text) => serializer.serialize_str(text),
            SheetCell::Number(number) => serializer.serialize_f64(*number),
            SheetCell::NotStated => serializer.serialize_bool(false),
            SheetCell::Empty => serializer.serialize_none(),
        }
    }
}

impl From<SheetSection> for ShownSection {
    fn from(section: SheetSection) -> Self {
        let SheetSection { section, chapters, rows, notes } = section;
        let cells = |row: Vec<SheetCell>| row.into_iter().map(ShownCell).collect();
        Self {
            section: section.name(),
            chapters,
            columns: rows.columns,
            rows: rows.rows.into_iter().map(cells).collect(),
            notes,
        }
    }
}

/// What the manual of a model states.
pub(crate) async fn sheet(query: Result<Query<SheetQuery>, QueryRejection>) -> Response {
    let model = match query {
        Ok(Query(SheetQuery { model })) => model,
        Err(wrong) => return wrong_query(&wrong),
    };
    let model: Model = match model.parse() {
        Ok(model) => model,
        Err(_) => return refused(StatusCode::NOT_FOUND, &refusals::unknown_model(&model)),
    };
    given(&ShownSheet {
        model: model.name(),
        title: model.title(),
        document: model.data_sheet().document,
        sections: Sheet::new(model, &SECTIONS).sections.into_iter().map(ShownSection::from).collect(),
    })
}
