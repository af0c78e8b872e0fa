//! The live view on a terminal: a thread polls, this one draws and listens to the keys.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{SyncSender, TryRecvError, sync_channel};
use std::thread;
use std::time::{Duration as Real, Instant as Clock};

use encoring_words::Duration;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::screen::{Screen, Update, Way};
use super::{About, Watched};
use crate::interrupt::awaiting_reader;
use crate::output::Answer;
use crate::told::looked;

/// How long a key waits at most.
const LISTEN: Real = Real::from_millis(40);
/// Polls that wait to be drawn.
const WAITING: usize = 4;

/// Runs until the user quits or the watch ends. The terminal is as it was afterwards, whatever happens.
pub(super) fn run(mut watched: Watched<'_>, about: About, stop: &Arc<AtomicBool>) -> io::Result<Answer> {
    let acknowledged = Arc::clone(&watched.acknowledged);
    let (updates, drawn) = sync_channel(WAITING);
    let polled = &mut watched;
    thread::scope(|scope| {
        // It also sets a hook that restores the terminal before a panic's message.
        let terminal = awaiting_reader(ratatui::try_init)?;
        let restored = Restored;
        let polling = thread::Builder::new().name("polls".to_owned());
        polling.spawn_scoped(scope, move || polls(polled, &updates))?;
        let ended = draw(terminal, Screen::new(about), (stop, &acknowledged), || drawn.try_recv());
        // Before the wait for the last poll, which may take a time-out.
        drop(restored);
        stop.store(true, Ordering::Relaxed);
        drop(drawn);
        ended
    })?;
    Ok(looked(&watched.watch, watched.faults.as_ref()))
}

struct Restored;

impl Drop for Restored {
    fn drop(&mut self) {
        awaiting_reader(ratatui::restore);
    }
}

fn polls(watched: &mut Watched<'_>, updates: &SyncSender<Update>) {
    while let Some(update) = watched.poll() {
        if updates.send(update).is_err() {
            return;
        }
    }
}

#[expect(clippy::disallowed_methods, reason = "the view says how long ago the last poll was")]
fn draw(
    mut terminal: DefaultTerminal,
    mut screen: Screen,
    (stop, acknowledged): (&AtomicBool, &AtomicBool),
    mut next: impl FnMut() -> Result<Update, TryRecvError>,
) -> io::Result<()> {
    let mut last = Clock::now();
    loop {
        loop {
            match next() {
                Ok(update) => {
                    screen.take(update);
                    last = Clock::now();
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
        }
        let ago = u64::try_from(last.elapsed().as_nanos()).unwrap_or(u64::MAX);
        awaiting_reader(|| terminal.draw(|frame| screen.draw(frame, Duration::from_nanos(ago))).map(drop))?;
        if stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        // All keys that wait, so that a held key cannot get ahead of the drawing.
        let mut patience = LISTEN;
        while event::poll(patience)? {
            if let Event::Key(key) = event::read()? {
                match pressed(&mut screen, key) {
                    Next::Quit => return Ok(()),
                    Next::Acknowledge => acknowledged.store(true, Ordering::Relaxed),
                    Next::Stay => {}
                }
            }
            patience = Real::ZERO;
        }
    }
}

#[derive(PartialEq, Eq)]
enum Next {
    Stay,
    Acknowledge,
    Quit,
}

fn pressed(screen: &mut Screen, key: KeyEvent) -> Next {
    if key.kind == KeyEventKind::Release {
        return Next::Stay;
    }
    match key.code {
        KeyCode::Char('q' | 'Q') | KeyCode::Esc => return Next::Quit,
        KeyCode::Char('c') if key.modifiers.contains(KeyModifiers::CONTROL) => return Next::Quit,
        KeyCode::Char('a') => return Next::Acknowledge,
        KeyCode::Char('l') => screen.change_view(),
        KeyCode::Up => screen.scroll(Way::Up),
        KeyCode::Down => screen.scroll(Way::Down),
        KeyCode::PageUp => screen.scroll(Way::PageUp),
        KeyCode::PageDown | KeyCode::Char(' ') => screen.scroll(Way::PageDown),
        KeyCode::Home => screen.scroll(Way::Begin),
        KeyCode::End => screen.scroll(Way::End),
        _ => {}
    }
    Next::Stay
}
