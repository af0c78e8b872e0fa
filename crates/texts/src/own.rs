//! What nobody has a sentence for in another language.

mod sentences {
    crate::texts! {
        "own";
        fn text(text: String) = "{text}";
    }
}

use crate::said::{Said, SaidTemplate};

/// A message of the program itself, in its words: of a parser, of the system, of a foreign library.
#[must_use]
pub fn own(text: &(impl ToString + ?Sized)) -> Said {
    sentences::text(text.to_string())
}

/// The template of [`own`].
pub const OWN: &[SaidTemplate] = sentences::TEXTS;
