//! Files as the other crates need them, and nothing of what stands in them.
//!
//! - [`Replacement`]: a file that is there whole or not at all, whatever ends the program.
//! - [`Lock`]: one program at a time.
//! - [`open`] and [`read_text`]: reading that ends, whatever the name leads to.
//! - [`toml_text`] and [`line_at`]: the line of what is wrong.

mod lock;
mod read;
mod replace;
pub mod toml_text;

pub use lock::{Held, Lock};
pub use read::{Bounded, TextError, line_at, open, read_text};
pub use replace::{Replacement, sync_folder};
