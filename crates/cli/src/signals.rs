//! What asks a program to end: Ctrl-C, SIGTERM and SIGHUP; on Windows Ctrl-C, Ctrl-Break, the window that is closed, the
//! user who logs off and the machine that shuts down.

use std::io;

/// A file that becomes longer than this user's files may be is an error of writing, as a full disk is; without this the
/// system ends the program at once.
pub(crate) fn tell_files_too_long() {
    #[cfg(unix)]
    // Where it cannot be had the program runs as it does without.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

/// Calls `came` at each of them, in a thread of its own.
///
/// # Errors
/// Those of the operating system, and a second call.
#[cfg(unix)]
pub(crate) fn on_each(came: impl FnMut() + Send + 'static) -> io::Result<()> {
    ctrlc::set_handler(came).map_err(io::Error::other)
}

/// Calls `came` at each of them, in a thread of its own.
///
/// Windows ends a program at once when its handler of a closed window returns. Tokio's does not return, so the program
/// has the five seconds that Windows gives it to save what it has.
///
/// # Errors
/// Those of the operating system.
#[cfg(windows)]
pub(crate) fn on_each(mut came: impl FnMut() + Send + 'static) -> io::Result<()> {
    use tokio::signal::windows;

    let runtime = tokio::runtime::Builder::new_current_thread().build()?;
    let (mut c, mut pause) = (windows::ctrl_c()?, windows::ctrl_break()?);
    let (mut close, mut logoff, mut shutdown) =
        (windows::ctrl_close()?, windows::ctrl_logoff()?, windows::ctrl_shutdown()?);
    std::thread::Builder::new().name("signals".to_owned()).spawn(move || {
        runtime.block_on(async {
            loop {
                tokio::select! {
                    _ = c.recv() => {}
                    _ = pause.recv() => {}
                    _ = close.recv() => {}
                    _ = logoff.recv() => {}
                    _ = shutdown.recv() => {}
                }
                came();
            }
        });
    })?;
    Ok(())
}
