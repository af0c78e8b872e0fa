//! The few shapes that a figure is made of.

use std::fmt::{self, Write};

/// How wide a character of the figure's fixed-width letters is, in tenths of a pixel.
const LETTER: i64 = 72;

/// A coordinate in tenths of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Tenths(pub(crate) i64);

impl Tenths {
    pub(crate) const fn pixels(pixels: i64) -> Self {
        Self(pixels * 10)
    }

    pub(crate) const fn plus(self, pixels: i64) -> Self {
        Self(self.0 + pixels * 10)
    }

    /// How wide a text is.
    pub(crate) fn of_text(text: &str) -> Self {
        Self(text.chars().count() as i64 * LETTER)
    }
}

impl fmt::Display for Tenths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let (whole, tenth) = (self.0.unsigned_abs() / 10, self.0.unsigned_abs() % 10);
        if tenth == 0 { write!(f, "{sign}{whole}") } else { write!(f, "{sign}{whole}.{tenth}") }
    }
}

/// Where a text stands beside its point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stroke {
    Signal,
    Thin,
    Dashed,
    /// One of several lines in a plot, told apart by its dashes.
    Series(usize),
}

impl Stroke {
    const DASHES: [&str; 4] = ["", "6 3", "2 2", "8 2 2 2"];

    fn attributes(self) -> (&'static str, &'static str) {
        match self {
            Self::Signal => ("1.5", ""),
            Self::Thin => ("0.5", ""),
            Self::Dashed => ("0.5", "3 3"),
            Self::Series(number) => ("1.2", Self::DASHES.get(number % 4).copied().unwrap_or_default()),
        }
    }
}

/// A picture under way.
pub(crate) struct Svg(String);

impl Svg {
    /// A white picture of so many pixels. `title` is what a reader without eyes is told.
    pub(crate) fn new(width: i64, height: i64, title: &str) -> Self {
        let mut svg = Self(String::new());
        svg.put(format_args!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\" font-family=\"monospace\" font-size=\"12\">\n<title>{}</title>\n<rect width=\"{width}\" \
             height=\"{height}\" fill=\"white\"/>\n",
            Escaped(title)
        ));
        svg
    }

    pub(crate) fn text(&mut self, x: Tenths, y: Tenths, anchor: Anchor, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        self.put(format_args!("<text x=\"{x}\" y=\"{y}\"{anchor}>{}</text>\n", Escaped(text)));
    }

    /// A line through points; fewer than two are none.
    pub(crate) fn line(&mut self, points: &[(Tenths, Tenths)], stroke: Stroke) {
        let Some((first, rest)) = points.split_first().filter(|(_, rest)| !rest.is_empty()) else { return };
        let (width, dashes) = stroke.attributes();
        self.put(format_args!("<path d=\"M{} {}", first.0, first.1));
        for (x, y) in rest {
            self.put(format_args!("L{x} {y}"));
        }
        self.put(format_args!("\" fill=\"none\" stroke=\"black\" stroke-width=\"{width}\""));
        if !dashes.is_empty() {
            self.put(format_args!(" stroke-dasharray=\"{dashes}\""));
        }
        self.0.push_str("/>\n");
    }

    /// A grey box without an edge.
    pub(crate) fn shade(&mut self, from: (Tenths, Tenths), to: (Tenths, Tenths)) {
        let (width, height) = (Tenths(to.0.0 - from.0.0), Tenths(to.1.0 - from.1.0));
        let (x, y) = from;
        self.put(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" fill=\"#dddddd\"/>\n"
        ));
    }

    /// A small dot.
    pub(crate) fn dot(&mut self, x: Tenths, y: Tenths) {
        self.put(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"1.8\"/>\n"));
    }

    /// A number in a circle.
    pub(crate) fn number(&mut self, x: Tenths, y: Tenths, number: usize) {
        self.put(format_args!(
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"9\" fill=\"white\" stroke=\"black\" stroke-width=\"1\"/>\n"
        ));
        self.text(x, y.plus(4), Anchor::Middle, &number.to_string());
    }

    pub(crate) fn finish(mut self) -> String {
        self.0.push_str("</svg>\n");
        self.0
    }

    fn put(&mut self, text: fmt::Arguments<'_>) {
        // A string takes everything.
        let _ = self.0.write_fmt(text);
    }
}

/// A text as it may stand in XML and HTML, between marks and in quotes: nothing in it is read as a mark, and what no XML may
/// hold is left out.
#[derive(Clone, Copy, Debug)]
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for sign in self.0.chars() {
            match sign {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\t' | '\n' | '\r' => f.write_char(' ')?,
                '\0'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => f.write_char('\u{fffd}')?,
                _ => f.write_char(sign)?,
            }
        }
        Ok(())
    }
}
