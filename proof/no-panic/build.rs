//! The program has its own entry, so the C start files stay out; memory is copied with the C library's functions.
fn main() {
    for argument in ["-nostartfiles", "-lc"] {
        println!("cargo::rustc-link-arg-bins={argument}");
    }
}
