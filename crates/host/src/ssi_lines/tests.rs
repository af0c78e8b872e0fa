use super::*;

/// A train of so many pulses with the bits of `word` on line 1, each after a delay; line 0 is the clock.
fn train(lines: &mut SsiLines, at: &mut u64, word: u32, half: u64, delay: u64) {
    train_at(lines, 0, at, word, half, delay);
}

/// The same with the clock on another line, and the data on the next.
fn train_at(lines: &mut SsiLines, first: usize, at: &mut u64, word: u32, half: u64, delay: u64) {
    let mut edges = [(u64::MAX, 0, false); 100];
    let mut count = 0;
    let mut push = |edge| {
        edges[count] = edge;
        count += 1;
    };
    for pulse in 0..25_u64 {
        push((*at + 2 * half * pulse, 0, false));
        push((*at + 2 * half * pulse + half, 0, true));
        push((*at + 2 * half * pulse + half + delay, 1, pulse < 24 && word >> (23 - pulse) & 1 == 1));
    }
    push((*at + 48 * half + 20_001 + delay, 1, true));
    edges.sort_unstable();
    let mut high = 0b11_u64;
    lines.levels(Instant(*at - 1), high << first);
    for (time, line, level) in edges.into_iter().take_while(|(time, ..)| *time < u64::MAX) {
        high = if level { high | 1 << line } else { high & !(1 << line) };
        lines.levels(Instant(time), high << first);
    }
    *at += 50 * half + 50_000;
}

#[test]
fn clock_and_data_are_found_at_every_rate_and_with_every_delay_of_a_cable() {
    for half in [455, 500, 1_000, 6_250, 10_000] {
        for delay in [0, 30, 300, 700] {
            let mut lines = SsiLines::new(2);
            let mut at = 100_000;
            for word in [0x00_270F, 0x55_5555, 0x80_0001] {
                train(&mut lines, &mut at, word, half, delay);
            }
            assert_eq!(lines.found(), LinesFound::Pair { clock: 0, data: 1 }, "{half} {delay}");
        }
    }
}

#[test]
fn data_that_never_change_are_the_only_other_line() {
    for count in [2, 3] {
        let mut lines = SsiLines::new(count);
        for pulse in 0..40_u64 {
            lines.levels(Instant(pulse * 1_000), u64::MAX << (pulse % 2));
        }
        let found = if count == 2 {
            LinesFound::StuckData { clock: 0, data: 1 }
        } else {
            LinesFound::NoData { clock: 0 }
        };
        assert_eq!(lines.found(), found);
    }
}

#[test]
fn lines_at_rest_slow_lines_and_too_many_lines_are_no_clock() {
    let mut lines = SsiLines::new(2);
    assert_eq!(lines.found(), LinesFound::NoClock);
    for pulse in 0..100_u64 {
        lines.levels(Instant(pulse * 1_000_000), pulse % 2);
    }
    assert_eq!(lines.found(), LinesFound::NoClock);
    let mut lines = SsiLines::new(1_000);
    lines.levels(Instant(0), 0);
    lines.levels(Instant(1), u64::MAX);
    assert_eq!(lines.found(), LinesFound::NoClock);
}

#[test]
fn a_clock_that_rests_low_is_told() {
    let mut lines = SsiLines::new(2);
    for train in 0..5_u64 {
        for pulse in 0..50_u64 {
            lines.levels(Instant(train * 100_000 + pulse * 1_000), pulse % 2);
        }
        lines.levels(Instant(train * 100_000 + 50_000), 0);
    }
    assert_eq!(lines.found(), LinesFound::InvertedClock { clock: 0 });
}

#[test]
fn clock_and_data_are_found_among_all_lines_of_an_analyser() {
    for clock in [0, 7, SSI_LINES_MAX - 2] {
        let mut lines = SsiLines::new(SSI_LINES_MAX);
        let mut at = 100_000;
        for word in [0x00_270F, 0x55_5555, 0x80_0001] {
            train_at(&mut lines, clock, &mut at, word, 500, 30);
        }
        assert_eq!(lines.found(), LinesFound::Pair { clock, data: clock + 1 });
    }
}
