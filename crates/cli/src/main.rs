//! The `encoring` command.
fn main() {}
