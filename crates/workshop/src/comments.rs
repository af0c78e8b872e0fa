//! The comments of a parameter file, so that they are there again when it is written anew.

use toml_parser::Source;
use toml_parser::lexer::TokenKind;

/// The comments that stand at each encoder of a file, without their sign; those above an `[[encoder]]` are of that one. Of
/// one behind a value the value goes with it. Comments that a backup has at each value are left out.
pub(crate) fn of_encoders(text: &str) -> Vec<Vec<String>> {
    let mut found: Vec<Vec<String>> = vec![Vec::new()];
    let (mut above, mut begun) = (Vec::new(), false);
    for line in lines(text) {
        let Line { code, comment } = line;
        if code == "[[encoder]]" && std::mem::replace(&mut begun, true) {
            found.push(Vec::new());
        }
        if !code.is_empty()
            && let Some(last) = found.last_mut()
        {
            last.append(&mut above);
        }
        let Some(comment) = comment else { continue };
        if !code.is_empty() && is_of_a_value(comment) {
            continue;
        }
        let told = if code.is_empty() { comment.to_owned() } else { format!("{code}: {comment}") };
        above.push(told);
    }
    if let Some(last) = found.last_mut() {
        last.append(&mut above);
    }
    found
}

/// `service 02`, as [`super::kept`] writes it.
fn is_of_a_value(comment: &str) -> bool {
    let number = comment.strip_prefix("service ").unwrap_or_default();
    number.len() == 2 && number.bytes().all(|digit| digit.is_ascii_hexdigit())
}

/// A line of a text: what stands before its comment, and the comment without its sign.
struct Line<'a> {
    code: &'a str,
    comment: Option<&'a str>,
}

fn lines(text: &str) -> Vec<Line<'_>> {
    let (mut lines, mut begin) = (Vec::new(), 0);
    let mut comment = None;
    for token in Source::new(text).lex() {
        let span = token.span();
        match token.kind() {
            TokenKind::Comment => comment = Some((span.start(), span.end())),
            TokenKind::Newline | TokenKind::Eof => {
                let (end, from, to) = match comment.take() {
                    Some((from, to)) => (from, from, to),
                    None => (span.start(), span.start(), span.start()),
                };
                let code = text.get(begin..end).unwrap_or_default().trim();
                let comment = text.get(from..to).and_then(|text| text.strip_prefix('#')).map(str::trim);
                lines.push(Line { code, comment });
                begin = span.end();
            }
            _ => {}
        }
    }
    lines
}
