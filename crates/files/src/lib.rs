//! Files as the other crates need them, and nothing of what stands in them.
//!
//! - [`Replacement`]: a file that is there whole or not at all, whatever ends the program.
//! - [`Growing`]: the same for a file that grows for hours, and can be looked at meanwhile.
//! - [`LineFile`]: lines that are there whole or not at all, also on a full disk.
//! - [`Lock`]: one program at a time.
//! - [`open`] and [`read_text`]: reading that ends, whatever the name leads to.
//! - [`Stoppable`]: the same of a pipe, which may give nothing for long.
//! - [`toml_text`] and [`line_at`]: the line of what is wrong.
//!
//! ```
//! use std::io::Write;
//!
//! use encoring_files::{Replacement, read_text};
//!
//! let folder = std::env::temp_dir().join(format!("encoring-files-{}", std::process::id()));
//! std::fs::create_dir_all(&folder)?;
//! let path = folder.join("axis.toml");
//! let mut new = Replacement::begin(&path)?;
//! new.write_all(b"version = 1\n")?;
//! // Until here a reader finds the old file or none, afterwards the whole new one.
//! assert!(!path.exists());
//! new.replace()?;
//! assert_eq!(read_text(&path, 1_000)?, "version = 1\n");
//! std::fs::remove_dir_all(&folder)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod growing;
mod lines;
mod lock;
mod read;
mod replace;
mod stoppable;
pub mod toml_text;

pub use growing::{Existing, Growing};
pub use lines::LineFile;
pub use lock::{Held, Lock, is_in_use, sole_writer};
pub use read::{Bounded, TextError, line_at, open, read_text};
pub use replace::{Replacement, folder, not_made, sync_folder};
pub use stoppable::Stoppable;
