//! What the page is made of, all of it in the program.

use std::collections::BTreeMap;

use axum::http::{StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use encoring_texts::SaidTemplate;

/// A file of the page.
struct Asset {
    path: &'static str,
    kind: &'static str,
    content: Content,
}

enum Content {
    Kept(&'static [u8]),
    /// Made of what the program itself says.
    Made(fn() -> String),
}

macro_rules! asset {
    ($path:literal, $file:literal, $kind:literal) => {
        Asset {
            path: $path,
            kind: $kind,
            content: Content::Kept(include_bytes!(concat!("../assets/", $file))),
        }
    };
}

const ASSETS: &[Asset] = &[
    asset!("/", "index.html", "text/html; charset=utf-8"),
    asset!("/style.css", "style.css", "text/css; charset=utf-8"),
    asset!("/icon.svg", "icon.svg", "image/svg+xml"),
    asset!("/api/openapi.json", "openapi.json", "application/json"),
    asset!("/texts/en.json", "texts/en.json", "application/json"),
    asset!("/texts/de.json", "texts/de.json", "application/json"),
    asset!("/texts/de/sheet.json", "texts/de/sheet.json", "application/json"),
    Asset {
        path: "/texts/en/sheet.json",
        kind: "application/json",
        content: Content::Made(|| said_in_english(encoring_sheet::sentences())),
    },
    asset!("/texts/de/refusals.json", "texts/de/refusals.json", "application/json"),
    Asset {
        path: "/texts/en/refusals.json",
        kind: "application/json",
        content: Content::Made(|| said_in_english(crate::refusals::refusals())),
    },
    asset!("/texts/de/diagnosis.json", "texts/de/diagnosis.json", "application/json"),
    Asset {
        path: "/texts/en/diagnosis.json",
        kind: "application/json",
        content: Content::Made(|| said_in_english(encoring_diagnosis::sentences())),
    },
    asset!("/js/main.js", "js/main.js", "text/javascript; charset=utf-8"),
    asset!("/js/ask.js", "js/ask.js", "text/javascript; charset=utf-8"),
    asset!("/js/diagnosis.js", "js/diagnosis.js", "text/javascript; charset=utf-8"),
    asset!("/js/connectors.js", "js/connectors.js", "text/javascript; charset=utf-8"),
    asset!("/js/sheet.js", "js/sheet.js", "text/javascript; charset=utf-8"),
    asset!("/js/login.js", "js/login.js", "text/javascript; charset=utf-8"),
    asset!("/js/clock.js", "js/clock.js", "text/javascript; charset=utf-8"),
    asset!("/js/part.js", "js/part.js", "text/javascript; charset=utf-8"),
    asset!("/js/polled.js", "js/polled.js", "text/javascript; charset=utf-8"),
    asset!("/js/api.js", "js/api.js", "text/javascript; charset=utf-8"),
    asset!("/js/dom.js", "js/dom.js", "text/javascript; charset=utf-8"),
    asset!("/js/texts.js", "js/texts.js", "text/javascript; charset=utf-8"),
    asset!("/js/words.js", "js/words.js", "text/javascript; charset=utf-8"),
    asset!("/js/ring.js", "js/ring.js", "text/javascript; charset=utf-8"),
    asset!("/js/encoder.js", "js/encoder.js", "text/javascript; charset=utf-8"),
    asset!("/js/handshake.js", "js/handshake.js", "text/javascript; charset=utf-8"),
    asset!("/js/figure.js", "js/figure.js", "text/javascript; charset=utf-8"),
    asset!("/js/lessons.js", "js/lessons.js", "text/javascript; charset=utf-8"),
    asset!("/js/trend.js", "js/trend.js", "text/javascript; charset=utf-8"),
];

/// The English sentences of the program, in the form of the page's own texts.
fn said_in_english(sentences: impl Iterator<Item = &'static SaidTemplate>) -> String {
    // What another library says comes in its words.
    let own = sentences.filter(|said| !said.english.is_empty());
    // Doubled braces stand for themselves.
    let plain = |english: &str| english.replace("{{", "{").replace("}}", "}");
    let texts: BTreeMap<&str, String> = own.map(|said| (said.code, plain(said.english))).collect();
    // Texts with names for keys have no reason to fail.
    serde_json::to_string(&texts).unwrap_or_default()
}

/// The paths of the page.
pub(crate) fn paths() -> impl Iterator<Item = &'static str> {
    ASSETS.iter().map(|asset| asset.path)
}

/// The file at this path, or that there is none.
pub(crate) async fn file(uri: Uri) -> Response {
    match ASSETS.iter().find(|asset| asset.path == uri.path()) {
        Some(Asset { kind, content: Content::Kept(content), .. }) => {
            ([(header::CONTENT_TYPE, *kind)], *content).into_response()
        }
        Some(Asset { kind, content: Content::Made(made), .. }) => {
            ([(header::CONTENT_TYPE, *kind)], made()).into_response()
        }
        None => (StatusCode::NOT_FOUND, "there is no such page\n").into_response(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::{Path, PathBuf};

    use super::*;

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
    }

    #[test]
    fn every_file_of_the_page_is_served_and_the_first_view_is_below_300_kb() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        let there: BTreeSet<String> = files(&folder)
            .iter()
            .map(|file| format!("/{}", file.strip_prefix(&folder).unwrap().display()))
            .map(|path| path.replace("/index.html", "/").replace("/openapi", "/api/openapi"))
            .collect();
        let kept = ASSETS.iter().filter_map(|asset| match asset.content {
            Content::Kept(content) => Some((asset.path, content)),
            Content::Made(_) => None,
        });
        assert_eq!(there, kept.clone().map(|(path, _)| path.to_owned()).collect());
        // A view that needs more texts asks for them, and nobody asks for the description.
        let is_later = |path: &str| path.starts_with("/texts/de/") || path == "/api/openapi.json";
        let first = kept.filter(|(path, _)| !is_later(path));
        let bytes: usize = first.map(|(_, content)| content.len()).sum();
        assert!(bytes < 300 * 1024, "{bytes} bytes");
    }
}
