//! Any bytes as a capture: it is refused with a place, or its changes come in order of time, twice the same.
#![no_main]

use std::io::Cursor;
use std::ops::ControlFlow;

use encoring_trace::capture::{Capture, CaptureChange, CaptureEnd, SELECTED_MAX};
use libfuzzer_sys::fuzz_target;

/// More changes of one input say nothing new.
const CHANGES_MAX: usize = 100_000;

fn read(capture: &mut Capture<Cursor<&[u8]>>) -> (Vec<CaptureChange>, Option<CaptureEnd>) {
    let selected: Vec<usize> = (0..capture.channels().len().min(SELECTED_MAX)).collect();
    let mut changes = Vec::new();
    let end = capture.changes(&selected, |change| {
        changes.push(change);
        if changes.len() < CHANGES_MAX { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    });
    if let Err(refused) = &end {
        assert!(refused.to_string().starts_with("fuzz"), "{refused}");
    }
    (changes, end.ok())
}

fuzz_target!(|bytes: &[u8]| {
    for samplerate in [None, Some(24_000_000)] {
        let mut capture = match Capture::new("fuzz", Cursor::new(bytes), samplerate) {
            Ok(capture) => capture,
            Err(refused) => {
                assert!(refused.to_string().starts_with("fuzz"), "{refused}");
                continue;
            }
        };
        let (changes, end) = read(&mut capture);
        assert!(changes.is_sorted_by_key(|change| change.time_ns), "{changes:?}");
        assert!(changes.iter().all(|change| change.high & !change.known == 0), "what is not known is not High");
        if let (Some(end), Some(last)) = (end, changes.last()) {
            assert!(last.time_ns <= end.time_ns, "{last:?} after {end:?}");
        }
        assert_eq!(read(&mut capture), (changes, end), "read twice it is the same");
    }
});
