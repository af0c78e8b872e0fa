//! `encoring sheet`: what the manuals state of an encoder.

mod table;
mod view;

use std::io::{self, Write};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use encoring_words::Model;
use encoring_words::model::MODELS;
use encoring_words::sheet::{SECTIONS, Section};

use crate::arguments;
use crate::output::{Answer, Failure};
use view::SheetView;

/// Print the data sheet of an encoder
///
/// It has everything that the manual states: pins, lamps, services, error status, faults, limits. "not stated" means that
/// the manual does not say it.
#[derive(Args, Debug)]
#[command(after_help = "\
Exit codes:
  0  printed
  2  wrong usage

Examples:
  encoring sheet ce-65-m pins
  encoring sheet ce-100-m services
  encoring sheet ce-65-m faults                   # causes of step changes
  encoring sheet all levels                       # all three models
  encoring sheet all --format markdown > sheets.md")]
pub(crate) struct Arguments {
    /// The model, or all
    #[arg(value_name = "MODEL", value_parser = models)]
    models: Models,

    /// Print only this section
    #[arg(value_parser = section())]
    section: Option<Section>,

    /// Print text for people, JSON for programs (one object for each model, docs/json.md), or Markdown
    #[arg(long, default_value = "text")]
    format: Format,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    Text,
    Json,
    Markdown,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Models {
    All,
    One(Model),
}

fn models(text: &str) -> Result<Models, String> {
    match text {
        "all" => Ok(Models::All),
        name => arguments::model_name(name).map(Models::One).map_err(|unknown| format!("{unknown}; or all")),
    }
}

fn section() -> impl TypedValueParser<Value = Section> {
    PossibleValuesParser::new(SECTIONS.map(Section::name)).try_map(|name| {
        SECTIONS.into_iter().find(|section| section.name() == name).ok_or("no section of this name")
    })
}

pub(crate) fn run(arguments: &Arguments) -> Result<Answer, Failure> {
    let models = match &arguments.models {
        Models::All => MODELS.as_slice(),
        Models::One(model) => std::slice::from_ref(model),
    };
    let sections = match &arguments.section {
        None => SECTIONS.as_slice(),
        Some(section) => std::slice::from_ref(section),
    };
    let mut page = String::new();
    for (at, model) in models.iter().enumerate() {
        let view = SheetView::new(*model, sections);
        if at > 0 && arguments.format != Format::Json {
            page.push('\n');
        }
        match arguments.format {
            Format::Text => page.push_str(&view.to_string()),
            Format::Markdown => page.push_str(&view.markdown()),
            Format::Json => {
                page.push_str(&serde_json::to_string(&view)?);
                page.push('\n');
            }
        }
    }
    let mut out = io::stdout().lock();
    out.write_all(page.as_bytes())?;
    out.flush()?;
    Ok(Answer::Yes)
}
