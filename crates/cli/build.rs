//! Tells the program the commit that it is built from, and for which machine.

use std::path::Path;
use std::process::Command;

#[expect(clippy::disallowed_methods, reason = "what cargo tells a build stands in the environment")]
fn main() {
    println!("cargo::rerun-if-env-changed=ENCORING_COMMIT");
    let commit = std::env::var("ENCORING_COMMIT").ok().or_else(here).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=ENCORING_COMMIT={commit}");
    println!("cargo::rustc-env=ENCORING_TARGET={}", std::env::var("TARGET").unwrap_or_default());
}

/// The commit of this checkout. What was changed since is not looked for: only a release knows that nothing was.
fn here() -> Option<String> {
    let log = git(&["rev-parse", "--git-path", "logs/HEAD"])?;
    if Path::new(&log).exists() {
        println!("cargo::rerun-if-changed={log}");
    }
    Some(format!("{}, perhaps with changes", git(&["rev-parse", "--short=10", "HEAD"])?))
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_owned())
}
