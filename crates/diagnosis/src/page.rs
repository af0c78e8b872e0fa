//! The report as one page in HTML: no script, nothing from outside, every text escaped.

use std::fmt::Write;

use encoring_figure::{Chart, Escaped};
use encoring_texts::Said;
use encoring_words::Duration;

use crate::cause::JumpCause;
use crate::episode::{Conclusion, Episode};
use crate::manual::step_changes;
use crate::said::printed;

/// What a page says of a recording.
#[derive(Clone, Copy, Debug)]
pub struct PagePart<'a> {
    /// The file.
    pub name: &'a str,
    /// What was found in it.
    pub conclusion: &'a Conclusion,
    /// The number of its first episode.
    pub first: usize,
    /// Its picture.
    pub charts: &'a [Chart],
}

const STYLE: &str = "body{font:15px/1.4 sans-serif;margin:2em auto;max-width:70em;padding:0 1em;color:#000;background:#fff}\
 table{border-collapse:collapse;width:100%}th,td{border:1px solid #999;padding:.3em .5em;text-align:left;vertical-align:top}\
 figure{margin:1em 0}svg{max-width:100%;height:auto}ul{margin:.2em 0;padding-left:1.2em}\
 @media print{tr,figure{break-inside:avoid}}";

/// The page.
#[must_use]
pub fn page(title: &str, parts: &[PagePart<'_>]) -> String {
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" \
         content=\"width=device-width\">\n<title>{0}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{0}</h1>\n",
        Escaped(title)
    );
    for part in parts {
        put(&mut page, format_args!("<h2>{}</h2>\n", Escaped(part.name)));
        list(&mut page, &part.conclusion.limits);
        if !part.conclusion.episodes.is_empty() {
            table(&mut page, part);
        } else if part.conclusion.is_judged {
            page.push_str("<p>No step change.</p>\n");
        }
        for chart in part.charts {
            put(&mut page, format_args!("<figure>\n{}</figure>\n", chart.svg()));
        }
        if !part.conclusion.judged.is_empty() {
            page.push_str("<p>Judged:</p>\n");
            list(&mut page, &part.conclusion.judged);
        }
    }
    let of_the_manual =
        |part: &PagePart<'_>| part.conclusion.episodes.iter().any(|episode| episode.cause.is_of_the_manual());
    if parts.iter().any(of_the_manual) {
        remedies(&mut page);
    }
    page.push_str("</body>\n</html>\n");
    page
}

fn table(page: &mut String, part: &PagePart<'_>) {
    page.push_str("<table>\n<tr><th>No.<th>Place<th>Cause<th>Certainty<th>Evidence<th>Alternatives<th>What tells them apart</tr>\n");
    for (number, episode) in (part.first..).zip(&part.conclusion.episodes) {
        let (cause, certainty) = (episode.cause.title(), episode.certainty);
        let or: Vec<&str> = episode.alternatives.iter().map(|cause| JumpCause::title(*cause)).collect();
        put(
            page,
            format_args!(
                "<tr><td>{number}<td>{}<td>{}<td>{certainty}<td>",
                Escaped(&place(episode)),
                Escaped(cause)
            ),
        );
        list(page, &episode.evidence);
        put(
            page,
            format_args!(
                "<td>{}<td>{}</tr>\n",
                Escaped(&or.join("; ")),
                Escaped(&printed(&episode.apart).join("; "))
            ),
        );
    }
    page.push_str("</table>\n");
}

fn place(episode: &Episode) -> String {
    let at = Duration(episode.time_ns);
    let lines = if episode.to_line == episode.line {
        format!("line {}", episode.line)
    } else {
        format!("lines {} to {}", episode.line, episode.to_line)
    };
    format!("{lines}, {at}, position {}", episode.position)
}

/// What the manual has to say of step changes [R150..R153].
fn remedies(page: &mut String) {
    page.push_str("<h2>Step changes, as the manual has them</h2>\n<table>\n<tr><th>cause<th>remedy</tr>\n");
    for row in step_changes() {
        put(page, format_args!("<tr><td>{}<td>{}</tr>\n", Escaped(row.cause), Escaped(row.remedy)));
    }
    page.push_str("</table>\n");
}

fn list(page: &mut String, sentences: &[Said]) {
    if sentences.is_empty() {
        return;
    }
    page.push_str("<ul>\n");
    sentences.iter().for_each(|sentence| put(page, format_args!("<li>{}</li>\n", Escaped(sentence.text()))));
    page.push_str("</ul>\n");
}

fn put(page: &mut String, text: std::fmt::Arguments<'_>) {
    // A string takes everything.
    let _ = page.write_fmt(text);
}
