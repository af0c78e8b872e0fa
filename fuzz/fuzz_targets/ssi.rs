//! Any levels at any times on an SSI: whoever listens takes them, and the next sound transfer is received.
#![no_main]

use encoring_host::ssi_guess::{SsiGuess, SsiWord, SsiWords};
use encoring_host::ssi_lines::SsiLines;
use encoring_host::ssi_receiver::{SsiReceiver, SsiTransfer, TakenAt};
use encoring_host::ssi_timings::SsiTimings;
use encoring_words::parameter::{Code, SsiValues};
use encoring_words::ssi_frame::{Level, MONO_PERIOD, SsiFormat, SsiFrame};
use encoring_words::{Duration, Instant, Week};
use libfuzzer_sys::fuzz_target;

/// Clocks of the words whose format is guessed.
const GUESSED_CLOCKS: u32 = 25;

/// The format, and the receiver, from two bytes.
fn receiver(bits: u8, options: u8) -> (SsiFormat, SsiReceiver) {
    let is = |place: u8| options >> place & 1 == 1;
    let code = if is(0) { Code::Gray } else { Code::Binary };
    let week = if is(1) { Week::AK40 } else { Week::new(40, 1997).expect("a week") };
    let format = SsiFormat::new(SsiValues { repetition: is(2), code, bits: bits % 64 }, week);
    let taken_at = if is(3) { TakenAt::Rising } else { TakenAt::Falling };
    (format, SsiReceiver::new(format, taken_at))
}

/// Levels from a time on: bit 0 is the clock, bit 1 the data.
fn changes(steps: &[u8]) -> Vec<(Instant, Level, Level)> {
    let mut now = Instant(0);
    let (steps, _) = steps.as_chunks::<2>();
    let change = |[time, levels]: &[u8; 2]| {
        // Up to 63 ns, 1 us, 16 us or 258 us.
        now = now + Duration(u64::from(time & 0x3F) << (4 * (time >> 6)));
        (now, Level::from_bit(u32::from(*levels)), Level::from_bit(u32::from(levels >> 1)))
    };
    steps.iter().map(change).collect()
}

fn check(transfer: &SsiTransfer, format: SsiFormat) {
    assert!(transfer.began <= transfer.ended, "{transfer:?}");
    assert!(
        transfer.received <= format.bits() && u32::from(transfer.received) <= transfer.clocks,
        "{transfer:?}"
    );
    let says = transfer.position();
    assert!(transfer.fault.is_none() || says.is_none(), "{transfer:?}");
    assert!(says.is_none_or(|position| format.field(position) == transfer.field), "{transfer:?}");
}

/// A transfer of the encoder at 500 kHz; gives what was received.
fn sound(receiver: &mut SsiReceiver, format: SsiFormat, from: Instant, position: u32) -> Option<SsiTransfer> {
    let frame = SsiFrame::new(position, format);
    let mut at = from;
    for pulse in 1..=u32::from(format.bits()) + 1 {
        receiver.levels(at, Level::Low, frame.level(pulse - 1));
        receiver.levels(at + Duration(1_000), Level::High, frame.level(pulse));
        at = at + Duration(2_000);
    }
    receiver.levels(at + MONO_PERIOD, Level::High, Level::High)
}

fuzz_target!(|bytes: &[u8]| {
    let [bits, options, steps @ ..] = bytes else { return };
    let (format, mut coarse) = receiver(*bits, *options);
    let (mut fine, mut last) = (coarse, Instant(0));
    let (mut lines, mut timings) = (SsiLines::new(2), SsiTimings::default());
    let (mut words, mut guess) = (SsiWords::default(), SsiGuess::new(GUESSED_CLOCKS));
    let mut word = |word: Option<SsiWord>| word.into_iter().for_each(|word| guess.word(word));
    for (now, clock, data) in changes(steps) {
        // Whether somebody looks at the time in between changes nothing.
        let halfway = Instant(last.as_nanos().midpoint(now.as_nanos()));
        let between = fine.time(halfway);
        let ended = coarse.levels(now, clock, data);
        assert_eq!(between.or(fine.levels(now, clock, data)), ended);
        if let Some(transfer) = &ended {
            check(transfer, format);
            timings.transfer(transfer);
        }
        lines.levels(now, u64::from(clock.bit() | data.bit() << 1));
        timings.levels(now, clock, data);
        word(words.levels(now, clock, data));
        last = now;
    }
    let rest = last + MONO_PERIOD + MONO_PERIOD;
    coarse.levels(last, Level::High, Level::High);
    if let Some(transfer) = coarse.time(rest) {
        check(&transfer, format);
    }
    let position = 0x2D_270F & u32::MAX >> (u32::BITS - u32::from(format.bits()).min(22));
    let received = sound(&mut coarse, format, rest, position).expect("a transfer");
    assert_eq!(received.position(), Some(position), "{received:?}");
    word(words.time(rest));
    let _ = (lines.found(), timings.clock_hz(), guess.fits().count());
});
