//! The page in the browser: a ring to be seen, turned and taught with.
//!
//! [`start`] serves it in a thread of its own, so that no page can hold up a master that is served elsewhere. What the
//! page is made of lies in the program, and nothing comes from another place. The server sends codes and numbers;
//! their texts, in two languages, are the page's.
//!
//! One snapshot of the ring serves all who look at the same time (`frames`). Whoever does not read what is sent gets
//! the newest next, and nothing is kept for them.

mod access;
mod api;
mod assets;
mod diagnose;
mod frames;
mod guard;
mod in_json;
mod metrics;
mod patch;
mod refusals;
mod server;
mod shared;
mod sheet;
mod units;

pub use access::{NotAToken, WebToken};
pub use refusals::refusals;
pub use server::{ServedPage, WebOptions, start};
