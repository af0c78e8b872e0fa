//! What all pages see: one snapshot of the ring a frame, made when somebody looks.

use std::sync::Arc;

use encoring_station::{RingStopped, ShownRing};
use serde_json::{Map, Value, json};
use tokio::sync::{Mutex, watch};
use tokio::task::spawn_blocking;
use tokio::time::{Duration, Instant, MissedTickBehavior, interval};

use crate::patch::difference;

/// From one frame to the next on a ring of a few encoders.
const FRAME: Duration = Duration::from_millis(50);

/// With so many more encoders a frame takes once as long again: a long ring costs a page no more than a short one.
const ENCODERS_OF_A_FRAME: usize = 32;

/// The ring at one moment, ready to be sent.
#[derive(Debug, Default)]
pub(crate) struct Frame {
    /// Counted from 1; 0 is none.
    pub(crate) number: u64,
    /// All of it, as JSON.
    pub(crate) whole: String,
    /// What makes it of the frame before.
    pub(crate) patch: String,
    state: Value,
    made: Option<Instant>,
}

impl Frame {
    /// What was seen.
    pub(crate) const fn state(&self) -> &Value {
        &self.state
    }
}

/// The frames of a ring.
pub(crate) struct Frames {
    ring: Arc<dyn ShownRing>,
    latest: watch::Sender<Arc<Frame>>,
    /// Held by whoever makes the next one.
    making: Mutex<()>,
    every: Duration,
}

impl Frames {
    pub(crate) fn new(ring: Arc<dyn ShownRing>) -> Self {
        let frames = 1 + ring.units().len() / ENCODERS_OF_A_FRAME;
        let every = FRAME * u32::try_from(frames).unwrap_or(1);
        Self { ring, latest: watch::Sender::default(), making: Mutex::default(), every }
    }

    /// A frame that is at most one frame old.
    pub(crate) async fn fresh(&self) -> Result<Arc<Frame>, RingStopped> {
        self.of_age(self.every).await
    }

    /// A frame that is younger than this.
    async fn of_age(&self, age: Duration) -> Result<Arc<Frame>, RingStopped> {
        let _making = self.making.lock().await;
        let latest = Arc::clone(&self.latest.borrow());
        if latest.made.is_some_and(|made| made.elapsed() < age) {
            return Ok(latest);
        }
        let ring = Arc::clone(&self.ring);
        // Its thread is lost only with the runtime, and the ring goes with that.
        let looked = spawn_blocking(move || next(&*ring, &latest)).await;
        let frame = Arc::new(looked.map_err(|_| RingStopped)??);
        self.latest.send_replace(Arc::clone(&frame));
        Ok(frame)
    }

    /// What tells of each frame from now on.
    pub(crate) fn subscribe(&self) -> watch::Receiver<Arc<Frame>> {
        self.latest.subscribe()
    }

    /// How many look.
    pub(crate) fn streams(&self) -> usize {
        self.latest.receiver_count()
    }

    /// Makes frames for as long as somebody looks; ends with the ring.
    pub(crate) async fn run(&self) {
        let mut tick = interval(self.every);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        loop {
            tick.tick().await;
            // The one of the tick before is a little younger than a frame, since it took time to be made.
            if self.streams() > 0 && self.of_age(self.every / 2).await.is_err() {
                return;
            }
        }
    }
}

/// The frame after `before`.
fn next(shown: &dyn ShownRing, before: &Frame) -> Result<Frame, RingStopped> {
    let mut ring = shown.seen()?;
    let changes = shown.history().counts();
    if let Some(devices) = ring.get_mut("devices").and_then(Value::as_array_mut).map(std::mem::take) {
        let position = |device: &Value| device.get("position").and_then(Value::as_u64).unwrap_or_default();
        let named = devices.into_iter().map(|device| (position(&device).to_string(), device));
        // By position, so that a patch can name one.
        let named = Value::Object(named.collect::<Map<_, _>>());
        if let Some(ring) = ring.as_object_mut() {
            ring.insert("devices".to_owned(), named);
        }
    }
    let state = json!({ "ring": ring, "changes": changes });
    let patch = difference(&before.state, &state).unwrap_or_else(|| json!({}));
    Ok(Frame {
        number: before.number + 1,
        whole: state.to_string(),
        patch: patch.to_string(),
        state,
        made: Some(Instant::now()),
    })
}
