//! Long lines, broken between words.

/// The longest line of a terminal.
const WIDTH: usize = 80;
/// What stands behind an indentation is never narrower.
const NARROWEST: usize = 20;

/// The text with its long lines broken; what follows begins as far in as the line did, and `hanging` further.
pub(crate) fn wrapped(text: &str, hanging: usize) -> String {
    let mut out = String::new();
    for line in text.split_inclusive('\n') {
        let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
        let words = line.trim_start_matches(' ');
        let (first, rest) = (line.len() - words.len(), line.len() - words.len() + hanging);
        let room = |indent: usize| WIDTH.saturating_sub(indent).max(NARROWEST);
        let lines = broken(words, room(first), room(rest));
        out.push_str(&" ".repeat(first));
        out.push_str(&lines.join(&format!("\n{:rest$}", "")));
        out.push_str(end);
    }
    out
}

/// The text in lines of at most `width` characters, but for a word that is longer.
pub(crate) fn lines(text: &str, width: usize) -> Vec<String> {
    broken(text, width, width)
}

fn broken(text: &str, first: usize, rest: usize) -> Vec<String> {
    let (mut lines, mut line, mut width) = (Vec::new(), String::new(), first);
    for word in text.split(' ') {
        if !line.is_empty() {
            if line.chars().count() + 1 + word.chars().count() > width {
                lines.push(line.trim_end().to_owned());
                line.clear();
                width = rest;
            } else {
                line.push(' ');
            }
        }
        line.push_str(word);
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_line_is_longer_than_a_terminal_and_no_word_is_lost() {
        let long = "word ".repeat(60);
        let text = format!("  known    {long}\nshort\n{}\n", "x".repeat(200));
        let wrapped = wrapped(&text, 9);
        let lines: Vec<_> = wrapped.lines().collect();
        assert!(lines.iter().all(|line| line.len() <= WIDTH || !line.trim().contains(' ')), "{wrapped}");
        assert!(lines[0].starts_with("  known    word"), "{wrapped}");
        assert!(lines[1].starts_with("           word"), "{wrapped}");
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&wrapped), words(&text));
        assert_eq!(super::wrapped("a\n\n  b", 2), "a\n\n  b");
    }

    #[test]
    fn a_width_counts_characters_and_a_longer_word_stays_whole() {
        assert_eq!(lines("°°° °°° °°°", 7), ["°°° °°°", "°°°"]);
        assert_eq!(lines("a bcdefgh i", 3), ["a", "bcdefgh", "i"]);
        assert_eq!(lines("", 3), [""]);
    }
}
