#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use super::*;
use crate::bus::{Cycle, Settling};
use crate::misread::Misread;

const PATIENCE: Duration = Duration::from_millis(100);
const CHECK: OutWord = OutWord(0x8800_0000);

/// A gateway that reads as `reads` says, and writes as `writes` says of each write from 1 on, before an encoder that never
/// answers.
struct Gateway {
    now: Instant,
    /// What stood on OUT, and since when.
    stood: Vec<(Instant, OutWord)>,
    /// How old what is read of OUT is.
    late: Duration,
    written: Vec<OutWord>,
    writes: fn(usize, OutWord) -> Result<OutWord, BusError>,
    reads: fn(u32) -> u32,
}

impl Gateway {
    fn writing(writes: fn(usize, OutWord) -> Result<OutWord, BusError>) -> Self {
        let stood = vec![(Instant::ZERO, OutWord(0))];
        Self {
            now: Instant::ZERO,
            stood,
            late: Duration::ZERO,
            written: Vec::new(),
            writes,
            reads: |word| word,
        }
    }

    /// What a data check comes to, and what is behind it.
    fn check(&mut self) -> (Result<Outcome, MasterError>, Option<Behind>) {
        let stop = Arc::new(AtomicBool::new(false));
        let mut master = EncoderMaster::new(self, 0, PATIENCE, stop).unwrap();
        let outcome = master.serve(Request::data_check());
        (outcome, master.behind())
    }

    /// Why it refuses a data check; nothing with the service bit was written.
    fn refusal(&mut self) -> MasterError {
        let error = self.check().0.unwrap_err();
        assert!(self.written.iter().all(|out| !out.service_bit()), "{:?}", self.written);
        error
    }

    /// A data check is sent, and nobody answers.
    fn sends(&mut self) {
        let (outcome, behind) = self.check();
        assert!(matches!(outcome, Ok(Outcome::TimedOut(_))), "{outcome:?}");
        assert_eq!(behind, None);
        assert!(self.written.contains(&CHECK), "{:?}", self.written);
    }
}

impl Bus for Gateway {
    fn now(&self) -> Instant {
        self.now
    }

    fn out(&mut self, _position: usize) -> Result<OutWord, BusError> {
        let stood = self.stood.iter().rev().find(|(since, _)| self.now.since(*since) >= self.late);
        Ok(OutWord((self.reads)(stood.map_or(0, |(_, out)| out.0))))
    }

    fn cycle(
        &mut self,
        write: Option<(usize, OutWord)>,
        _first: usize,
        input: &mut [InWord],
    ) -> Result<Cycle, BusError> {
        self.now = self.now + Duration::from_millis(1);
        if let Some((_, out)) = write {
            self.written.push(out);
            self.stood.push((self.now, (self.writes)(self.written.len(), out)?));
        }
        input.fill(InWord((self.reads)(5)));
        Ok(Cycle { at: self.now, age: Duration::from_millis(1) })
    }

    fn wait(&mut self, span: Duration) {
        self.now = self.now + span;
    }

    fn settling(&self) -> Settling {
        Settling { cycles: 1, time: Duration::from_millis(2) }
    }

    fn cure_of_writes(&self, misread: Misread) -> Option<String> {
        Some(format!("what cures {misread:?}"))
    }
}

#[test]
fn before_a_gateway_that_turns_written_words_round_nothing_is_sent_and_the_cure_is_told() {
    let refusal = Gateway::writing(|_, OutWord(word)| Ok(OutWord(word.rotate_left(16)))).refusal();
    let told = refusal.to_string();
    assert!(
        told.starts_with("this request was not sent: OUT holds 00000800 instead of the 08000000"),
        "{told}"
    );
    assert!(told.ends_with("with its halves exchanged. What cures it: what cures Halves"), "{told}");
}

#[test]
fn before_a_gateway_that_does_not_write_what_it_acknowledges_nothing_is_sent() {
    let mut gateway = Gateway::writing(|_, _| Ok(OutWord(0)));
    let refusal = gateway.refusal();
    let (word, out, ours) = (OutWord(0x0800_0000), OutWord(0), OutWord(0x0800_0000));
    assert_eq!(refusal, MasterError::NotPrepared { word, behind: Behind::NotThere { out, ours } });
    assert!(gateway.written.len() < 10, "{:?}", gateway.written);
}

#[test]
fn what_stood_on_out_before_may_be_written_by_a_plc_again_and_again_and_is_not_written_over() {
    let mut gateway = Gateway::writing(|_, _| Ok(OutWord(0x0200_1388)));
    gateway.stood = vec![(Instant::ZERO, OutWord(0x0200_1388))];
    let refusal = gateway.refusal();
    let (out, ours) = (OutWord(0x0200_1388), OutWord(0x0800_0000));
    assert_eq!(refusal, MasterError::Overwritten { out, ours });
    assert_eq!(gateway.written.len(), 1);
    assert!(refusal.to_string().contains("or the gateway does not let it be written"), "{refusal}");
}

#[test]
fn a_word_that_another_master_writes_meanwhile_is_told_as_that_and_not_written_over() {
    let mut gateway = Gateway::writing(|_, _| Ok(OutWord(0x0300_0001)));
    let refusal = gateway.refusal();
    let (out, ours) = (OutWord(0x0300_0001), OutWord(0x0800_0000));
    assert_eq!(refusal, MasterError::Overwritten { out, ours });
    assert_eq!(gateway.written.len(), 1);
}

#[test]
fn what_asks_for_a_service_is_another_masters_even_if_it_is_a_word_of_ours_turned_round() {
    assert_eq!(turned(OutWord(0x0200_00C2), OutWord(0xC200_0002)), None);
    assert_eq!(turned(OutWord(0x0200_0093), OutWord(0x9300_0002)), Some(Misread::HalvesAndBytes));
}

#[test]
fn a_gateway_that_shows_out_late_is_waited_for() {
    let late = Duration::from_millis(60);
    Gateway { late, ..Gateway::writing(|_, out| Ok(out)) }.sends();
}

#[test]
fn a_write_that_was_spoilt_or_lost_is_written_again_before_anything_is_sent() {
    Gateway::writing(|number, out| {
        Ok(match number {
            1 => OutWord(out.0.rotate_left(16)),
            2 => OutWord(0),
            _ => out,
        })
    })
    .sends();
}

#[test]
fn a_gateway_that_confirms_other_writes_is_not_written_to_again_and_again() {
    let mut gateway = Gateway::writing(|_, _| {
        Err(BusError::client(Answered::Misdirected, std::io::Error::other("it confirms another")))
    });
    let told = gateway.refusal().to_string();
    assert_eq!(gateway.written.len(), 3, "{:?}", gateway.written);
    assert!(
        told.starts_with("this request was not sent: it confirms another. 08000000 was written"),
        "{told}"
    );
}

#[test]
fn words_that_no_encoder_sends_are_no_other_master() {
    let mut gateway = Gateway { reads: |_| u32::MAX, ..Gateway::writing(|_, out| Ok(out)) };
    let stop = Arc::new(AtomicBool::new(false));
    let refused = EncoderMaster::new(&mut gateway, 0, Duration::from_millis(100), stop).err().unwrap();
    assert!(matches!(refused, MasterError::Misread { input: InWord(u32::MAX), .. }), "{refused}");
}
