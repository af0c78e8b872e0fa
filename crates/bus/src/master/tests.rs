#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use super::*;
use crate::bus::{Cycle, Settling};

/// A gateway that reads as `reads` says, and writes as `writes` says, before an encoder that never answers.
struct Gateway {
    now: Instant,
    out: OutWord,
    writes: fn(OutWord) -> OutWord,
    reads: fn(u32) -> u32,
}

impl Gateway {
    fn writing(writes: fn(OutWord) -> OutWord) -> Self {
        Self { now: Instant::ZERO, out: OutWord(0), writes, reads: |word| word }
    }

    /// What is behind the time-out of a data check.
    fn behind(&mut self) -> Option<Behind> {
        let stop = Arc::new(AtomicBool::new(false));
        let mut master = EncoderMaster::new(self, 0, Duration::from_millis(100), stop).unwrap();
        let outcome = master.serve(Request::data_check()).unwrap();
        assert!(matches!(outcome, Outcome::TimedOut(_)), "{outcome:?}");
        master.behind()
    }
}

impl Bus for Gateway {
    fn now(&self) -> Instant {
        self.now
    }

    fn out(&mut self, _position: usize) -> Result<OutWord, BusError> {
        Ok(OutWord((self.reads)(self.out.0)))
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        _first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        self.now = self.now + Duration::from_millis(1);
        if let Some((_, out)) = write {
            self.out = (self.writes)(out);
        }
        input.fill(InWord((self.reads)(5)));
        Ok(Cycle { at: self.now, age: Duration::from_millis(1) })
    }

    fn wait(&mut self, span: Duration) {
        self.now = self.now + span;
    }

    fn settling(&self) -> Settling {
        Settling { cycles: 1, time: Duration::ZERO }
    }
}

#[test]
fn a_gateway_that_turns_written_words_round_is_named_and_no_encoder_is_blamed() {
    let behind = Gateway::writing(|OutWord(word)| OutWord(word.rotate_left(16))).behind().unwrap();
    let Behind::Turned { way, .. } = &behind else { panic!("{behind:?}") };
    assert_eq!(*way, Misread::Halves);
    let told = behind.to_string();
    assert!(told.contains("instead of the 88000000") || told.contains("instead of the 08000000"), "{told}");
    assert!(told.contains("`order_out`") && told.contains("`encoring probe`"), "{told}");
}

#[test]
fn a_gateway_that_does_not_write_what_it_acknowledges_is_named() {
    let behind = Gateway::writing(|_| OutWord(0)).behind().unwrap();
    assert!(matches!(behind, Behind::NotThere { out: OutWord(0), .. }), "{behind:?}");
}

#[test]
fn an_encoder_that_does_not_answer_has_nothing_behind_it() {
    assert_eq!(Gateway::writing(|out| out).behind(), None);
}

#[test]
fn words_that_no_encoder_sends_are_no_other_master() {
    let mut gateway = Gateway { reads: |_| u32::MAX, ..Gateway::writing(|out| out) };
    let stop = Arc::new(AtomicBool::new(false));
    let refused = EncoderMaster::new(&mut gateway, 0, Duration::from_millis(100), stop).err().unwrap();
    assert!(matches!(refused, MasterError::Misread { input: InWord(u32::MAX), .. }), "{refused}");
}
