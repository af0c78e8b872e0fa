//! The live view on a terminal: a thread polls, this one draws and listens to the keys.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration as Real, Instant as Clock};

use encoring_words::Duration;
use ratatui::DefaultTerminal;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::screen::{Screen, Way};
use super::{About, Watched};
use crate::interrupt::awaiting_reader;
use crate::output::{Answer, note};
use crate::told::looked;

/// How long a key or a change of a verdict waits at most.
const LISTEN: Real = Real::from_millis(40);

/// What is shown, and when the last poll was. It is locked to be changed and to be drawn into memory; the terminal may
/// be as slow as it likes, and no poll waits for it.
struct Shown(Mutex<(Screen, Clock)>);

impl Shown {
    #[expect(clippy::disallowed_methods, reason = "the view says how long ago the last poll was")]
    fn new(screen: Screen) -> Self {
        Self(Mutex::new((screen, Clock::now())))
    }

    fn lock(&self) -> MutexGuard<'_, (Screen, Clock)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Runs until the user quits or the watch ends. The terminal is as it was afterwards, whatever happens.
pub(super) fn run(mut watched: Watched<'_>, about: About, stop: &Arc<AtomicBool>) -> io::Result<Answer> {
    let acknowledged = watched.acknowledging.mark();
    let every = Real::from_nanos(about.every.as_nanos());
    let (polled, shown) = (&mut watched, &Shown::new(Screen::new(about)));
    thread::scope(|scope| {
        // First, since a terminal that is stopped cannot even be made ready.
        let polling = thread::Builder::new().name("polls".to_owned());
        let polling = polling.spawn_scoped(scope, move || polls(polled, shown))?;
        // It also sets a hook that restores the terminal before a panic's message.
        let ended = awaiting_reader(ratatui::try_init).and_then(|terminal| {
            // Before the wait for the last poll, which may take a time-out.
            let _restored = Restored;
            View { terminal, shown, every, stop, acknowledged: &acknowledged }.run(|| polling.is_finished())
        });
        stop.store(true, Ordering::Relaxed);
        ended
    })?;
    // The view is gone by now.
    watched.end().iter().for_each(|event| note(&format!("note: {event}")));
    Ok(looked(&watched.watch, watched.faults.as_ref()))
}

struct Restored;

impl Drop for Restored {
    fn drop(&mut self) {
        awaiting_reader(ratatui::restore);
    }
}

#[expect(clippy::disallowed_methods, reason = "the view says how long ago the last poll was")]
fn polls(watched: &mut Watched<'_>, shown: &Shown) {
    while let Some(update) = watched.poll() {
        let mut shown = shown.lock();
        shown.0.take(update);
        shown.1 = Clock::now();
    }
}

/// Draws, and listens to the keys.
struct View<'a> {
    terminal: DefaultTerminal,
    shown: &'a Shown,
    /// How often what has moved is drawn.
    every: Real,
    stop: &'a AtomicBool,
    acknowledged: &'a AtomicBool,
}

impl View<'_> {
    #[expect(clippy::disallowed_methods, reason = "a person looks at it in real time")]
    fn run(mut self, is_over: impl Fn() -> bool) -> io::Result<()> {
        let mut due = Clock::now();
        loop {
            // Asked before the drawing, which then shows the last poll.
            let over = is_over() || self.stop.load(Ordering::Relaxed);
            if over || Clock::now() >= due || self.shown.lock().0.is_urgent() {
                self.draw()?;
                due = Clock::now() + self.every;
            }
            if over {
                return Ok(());
            }
            match self.listen(LISTEN.min(due.saturating_duration_since(Clock::now())))? {
                Heard::Nothing => {}
                Heard::Something => due = Clock::now(),
                Heard::Quit => return Ok(()),
            }
        }
    }

    fn draw(&mut self) -> io::Result<()> {
        let (terminal, shown) = (&mut self.terminal, self.shown);
        let drawn = |frame: &mut ratatui::Frame<'_>| {
            let (screen, last) = &mut *shown.lock();
            let ago = u64::try_from(last.elapsed().as_nanos()).unwrap_or(u64::MAX);
            screen.draw(frame, Duration::from_nanos(ago));
        };
        awaiting_reader(|| terminal.draw(drawn).map(drop))
    }

    /// Takes all keys that wait, so that a held key cannot get ahead of the drawing.
    fn listen(&self, mut patience: Real) -> io::Result<Heard> {
        let mut heard = Heard::Nothing;
        while event::poll(patience)? {
            heard = Heard::Something;
            if let Event::Key(key) = event::read()? {
                match pressed(&mut self.shown.lock().0, key) {
                    Next::Quit => return Ok(Heard::Quit),
                    Next::Acknowledge => self.acknowledged.store(true, Ordering::Relaxed),
                    Next::Stay => {}
                }
            }
            patience = Real::ZERO;
        }
        Ok(heard)
    }
}

enum Heard {
    Nothing,
    /// A key, or another size of the terminal.
    Something,
    Quit,
}

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
