//! Long lines for a terminal of 80 columns.

/// The longest line.
const WIDTH: usize = 79;

/// The text with its long lines broken between words; what follows begins as far in as the line did, and `hanging` further.
pub(crate) fn wrapped(text: &str, hanging: usize) -> String {
    let mut out = String::new();
    for line in text.split_inclusive('\n') {
        let (line, end) = line.strip_suffix('\n').map_or((line, ""), |line| (line, "\n"));
        broken(line, hanging, &mut out);
        out.push_str(end);
    }
    out
}

fn broken(line: &str, hanging: usize, out: &mut String) {
    let indent = line.len() - line.trim_start_matches(' ').len() + hanging;
    let mut rest = line;
    let mut width = WIDTH;
    while rest.chars().count() > width {
        let fits = rest.char_indices().nth(width + 1).map_or(rest.len(), |(at, _)| at);
        let start = rest.len() - rest.trim_start_matches(' ').len();
        let space = rest.get(start..fits).and_then(|part| part.rfind(' ')).map(|at| at + start);
        let Some((head, tail)) = space.and_then(|at| Some((rest.get(..at)?, rest.get(at..)?))) else { break };
        out.push_str(head.trim_end());
        out.push('\n');
        out.push_str(&" ".repeat(indent));
        rest = tail.trim_start_matches(' ');
        width = WIDTH.saturating_sub(indent).max(20);
    }
    out.push_str(rest);
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
        assert!(lines[1].starts_with("           word"), "{wrapped}");
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&wrapped), words(&text));
        assert_eq!(super::wrapped("a\n\n  b", 2), "a\n\n  b");
    }
}
