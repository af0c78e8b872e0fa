//! The blocks of a page that show commands.

/// What a comment before a block says of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    /// `<!-- not run: WHY -->`
    NotRun,
    /// `<!-- numbers differ: BEGINNING, ... -->`: lines with these beginnings have other numbers each time; without
    /// beginnings all lines have.
    NumbersDiffer(Vec<String>),
    Exact,
}

impl Mark {
    fn of(line: &str) -> Self {
        let said = line.strip_prefix("<!-- ").and_then(|rest| rest.strip_suffix(" -->"));
        match said.map(|said| said.split_once(": ").unwrap_or((said, ""))) {
            Some(("not run", why)) if !why.is_empty() => Self::NotRun,
            Some(("numbers differ", lines)) => {
                Self::NumbersDiffer(lines.split(", ").map(str::to_owned).collect())
            }
            _ => Self::Exact,
        }
    }

    /// The line as it is compared.
    fn seen(&self, line: &str) -> String {
        match self {
            Self::NumbersDiffer(lines) if lines.iter().any(|begin| line.trim_start().starts_with(begin)) => {
                without_numbers(line)
            }
            _ => line.trim_end().to_owned(),
        }
    }

    /// Whether `found` is what is printed; a line `...` stands for any lines.
    pub(crate) fn agrees(&self, printed: &[String], found: &[String]) -> bool {
        match (printed.split_first(), found.split_first()) {
            (None, None) => true,
            (Some((line, rest)), _) if line == "..." => {
                (0..=found.len()).any(|skipped| self.agrees(rest, &found[skipped..]))
            }
            (Some((line, printed)), Some((seen, found))) => {
                self.seen(line) == self.seen(seen) && self.agrees(printed, found)
            }
            _ => false,
        }
    }
}

/// The line with `#` for each number, and single blanks.
fn without_numbers(line: &str) -> String {
    let parts = line.split_inclusive(|sign: char| !sign.is_ascii_alphanumeric() && sign != '.');
    let told = parts.map(|part| {
        let word = part.trim_end_matches(|sign: char| !sign.is_ascii_alphanumeric());
        let is_word = word.len() == 8 && word.bytes().all(|byte| byte.is_ascii_hexdigit());
        let is_number = is_word || word.bytes().any(|byte| byte.is_ascii_digit());
        if is_number { part.replacen(word, "#", 1) } else { part.to_owned() }
    });
    told.collect::<String>().split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A command, and what the page says that it prints; nothing if the page does not say.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    pub(crate) line: usize,
    pub(crate) command: String,
    pub(crate) printed: Vec<String>,
}

/// A block of commands.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) mark: Mark,
    pub(crate) steps: Vec<Step>,
}

/// The blocks of a page that show commands, and the lines of those that are not marked as `console`.
pub(crate) fn blocks(text: &str) -> (Vec<Block>, Vec<usize>) {
    let (mut blocks, mut unmarked, mut before) = (Vec::new(), Vec::new(), "");
    let mut lines = (1..).zip(text.lines());
    while let Some((_, line)) = lines.next() {
        if let Some(kind) = line.strip_prefix("```") {
            let body: Vec<(usize, &str)> = lines.by_ref().take_while(|(_, line)| *line != "```").collect();
            let shows = |(_, line): &&(usize, &str)| line.starts_with("$ ");
            match (kind, body.iter().find(shows)) {
                ("console", _) => blocks.push(Block { mark: Mark::of(before), steps: steps(&body) }),
                (_, Some((at, _))) => unmarked.push(*at),
                _ => {}
            }
        }
        before = line;
    }
    (blocks, unmarked)
}

fn steps(body: &[(usize, &str)]) -> Vec<Step> {
    let mut steps: Vec<Step> = Vec::new();
    for (number, line) in body {
        match (line.strip_prefix("$ "), steps.last_mut()) {
            (Some(command), _) => {
                let command = command.split("  #").next().unwrap_or_default().trim_end().to_owned();
                steps.push(Step { line: *number, command, printed: Vec::new() });
            }
            (None, Some(step)) if step.printed.is_empty() && step.command.ends_with('\\') => {
                step.command.pop();
                step.command.push_str(line.trim_start());
            }
            (None, Some(step)) => step.printed.push((*line).to_owned()),
            (None, None) => panic!("line {number}: a block begins with `$ `"),
        }
    }
    steps
}
