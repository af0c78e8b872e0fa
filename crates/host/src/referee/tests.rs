//! Each rule with a trace that keeps it and one that breaks it.
extern crate std;

use std::vec::Vec;

mod log;

use super::*;

/// A program at its controller: what it writes, and what the ring shows.
struct Bench {
    referee: Referee,
    at_us: u64,
    out: u32,
    input: u32,
    line: LineSeen,
}

impl Bench {
    fn new(vantage: Vantage, model: Model) -> Self {
        let mut bench = Self {
            referee: Referee::new(vantage, Some(model)),
            at_us: 0,
            out: 0,
            input: 0x64,
            line: LineSeen::Good,
        };
        bench.run(5);
        bench
    }

    fn seen(vantage: Vantage) -> Self {
        Self::new(vantage, Model::Ce65M)
    }

    /// So many cycles of a millisecond.
    fn run(&mut self, cycles: u64) -> &mut Self {
        for _ in 0..cycles {
            self.at_us += 1_000;
            self.referee.observe(Observed::Cycle {
                at: Instant(self.at_us * 1_000),
                out: OutWord(self.out),
                input: Some(InWord(self.input)),
                line: self.line,
            });
        }
        self
    }

    /// A write, and a cycle if the client may take so long.
    fn put(&mut self, written: Written) -> &mut Self {
        let out = OutWord(self.out);
        self.out = match written {
            Written::Both(word) => word.0,
            Written::High(high) => OutWord::from_halves(high, out.low()).0,
            Written::Low(low) => OutWord::from_halves(out.high(), low).0,
        };
        if self.referee.vantage() == Vantage::Writes {
            self.at_us += 10;
            let at = Instant(self.at_us * 1_000);
            self.referee.observe(Observed::Write { at, client: 1, written });
        }
        self
    }

    fn write(&mut self, word: u32) -> &mut Self {
        self.put(Written::Both(OutWord(word))).run(3)
    }

    fn shows(&mut self, word: u32) -> &mut Self {
        self.input = word;
        self.run(3)
    }

    /// A service as it should be.
    fn serve(&mut self, word: u32, reply: u32) -> &mut Self {
        let back = if reply & 1 << 29 != 0 { 0x2000_0064 } else { 0x64 };
        self.write(word & 0x7FFF_FFFF).write(word).shows(reply).write(word & 0x7FFF_FFFF).shows(back)
    }

    /// The names of what was found, with the verdicts.
    fn found(&mut self) -> Vec<(HandshakeRule, Ruling)> {
        self.referee.finish();
        self.referee.findings().map(|finding| (finding.rule, finding.verdict)).collect()
    }
}

const ALL: [Vantage; 4] = [Vantage::Writes, Vantage::Cycles, Vantage::Exchanges, Vantage::Log];

/// What a rule gives from each vantage, if it is all that a trace breaks.
fn breaks(rule: HandshakeRule, trace: impl Fn(&mut Bench)) {
    for vantage in ALL {
        let mut bench = Bench::seen(vantage);
        trace(&mut bench);
        let wanted: Vec<_> = match (rule.certainty(vantage), rule.severity()) {
            (RuleCertainty::NotJudged, _) => std::vec![],
            (_, Severity::Note) => std::vec![(rule, Ruling::Note)],
            (RuleCertainty::Certain, _) => std::vec![(rule, Ruling::Broken)],
            (RuleCertainty::Suspected, _) => std::vec![(rule, Ruling::Suspected)],
        };
        assert_eq!(bench.found(), wanted, "{vantage:?}");
    }
}

fn keeps(trace: impl Fn(&mut Bench)) {
    for vantage in ALL {
        let mut bench = Bench::seen(vantage);
        trace(&mut bench);
        assert_eq!(bench.found(), [], "{vantage:?}");
    }
}

// [R33, R40]
#[test]
fn a_program_that_keeps_the_order_has_no_finding() {
    keeps(|bench| {
        bench.serve(0xC200_270F, 0xC200_270F).serve(0x8800_0000, 0x8800_0000).serve(0x8200_0000, 0x8200_270F);
        bench.serve(0xC600_0005, 0xC600_0005);
    });
}

// [R33]
#[test]
fn number_or_data_that_change_with_the_service_bit_are_named() {
    breaks(HandshakeRule::DataWithServiceBit, |bench| {
        bench.write(0x8200_0000).shows(0x8200_270F).write(0).shows(0x64);
    });
    breaks(HandshakeRule::DataWithServiceBit, |bench| {
        bench.write(0x4600_0004).write(0xC600_0005).shows(0xC600_0005).write(0).shows(0x64);
    });
}

// [R35]
#[test]
fn the_data_of_a_read_may_change_at_any_time() {
    keeps(|bench| {
        bench.write(0x0200_0001).write(0x8200_0002).write(0x8200_0003).shows(0x8200_270F);
        bench.write(0).shows(0x64);
    });
}

// [R34]
#[test]
fn halves_of_a_word_with_the_service_bit_first_are_torn() {
    for between in [0, 3] {
        for vantage in ALL {
            let mut bench = Bench::seen(vantage);
            bench.put(Written::High(0xC600)).run(between);
            bench.put(Written::Low(5)).run(3).shows(0xC600_0005).write(0).shows(0x64);
            let found = bench.found();
            if vantage == Vantage::Writes {
                assert_eq!(found, [(HandshakeRule::TornWords, Ruling::Broken)]);
            } else {
                assert!(found.iter().all(|(rule, _)| *rule != HandshakeRule::TornWords), "{found:?}");
                assert!(bench.referee.not_judged().any(|rule| rule == HandshakeRule::TornWords));
            }
        }
    }
    keeps(|bench| {
        bench.put(Written::High(0x4600)).run(1).put(Written::Low(5)).run(3);
        bench.put(Written::High(0xC600)).run(3).shows(0xC600_0005);
        bench.put(Written::Low(0)).put(Written::High(0)).run(3).shows(0x64);
    });
}

// [R34, R41]
#[test]
fn data_that_change_before_the_reply_are_named_and_behind_it_not() {
    breaks(HandshakeRule::DataChangedInService, |bench| {
        bench.write(0x4600_0005).write(0xC600_0005).write(0xC600_0006).shows(0xC600_0005);
        bench.write(0).shows(0x64);
    });
    keeps(|bench| {
        bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0005).write(0xC600_0006);
        bench.write(0).shows(0x64);
    });
}

// [R38, C42]
#[test]
fn a_drop_without_a_reply_is_a_break_before_a_second_and_a_note_after_it() {
    breaks(HandshakeRule::DroppedBeforeAcknowledgement, |bench| {
        bench.write(0x4600_0005).write(0xC600_0005).run(990).write(0x4600_0005).run(20);
    });
    breaks(HandshakeRule::Withdrawn, |bench| {
        bench.write(0x4600_0005).write(0xC600_0005).run(1_000).write(0x4600_0005).run(20);
    });
    let mut reset = Bench::seen(Vantage::Exchanges);
    reset.write(0x4600_0005).write(0xC600_0005).write(0).run(20);
    assert_eq!(reset.found(), [(HandshakeRule::DroppedBeforeAcknowledgement, Ruling::Suspected)]);
}

// [R38]
#[test]
fn a_bit_that_stays_behind_the_reply_is_named_after_ten_seconds_or_at_the_end() {
    for cycles in [1_000, 10_100] {
        breaks(HandshakeRule::NeverDropped, |bench| {
            bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0005).run(cycles);
        });
    }
    keeps(|bench| {
        bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0005).run(9_900).write(0).shows(0x64);
    });
    keeps(|bench| {
        bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0005).run(900);
    });
}

// [R39]
#[test]
fn the_next_request_waits_for_the_end_of_the_last() {
    breaks(HandshakeRule::NextBeforeEnd, |bench| {
        bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0005).write(0x0200_0000).write(0x8200_0000);
        // In exchanges and in a log the next reply is there before anyone could look.
        bench.shows(0x8200_270F).write(0).shows(0x64);
    });
}

// [R26]
#[test]
fn a_drop_after_the_reply_to_something_else_is_named() {
    breaks(HandshakeRule::ForeignReply, |bench| {
        bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0004).write(0x4600_0005).shows(0x64);
    });
    keeps(|bench| {
        bench.write(0x4600_0005).write(0xC600_0005).shows(0xC600_0004).shows(0xC600_0005);
        bench.write(0x4600_0005).shows(0x64);
    });
}

// [R36]
#[test]
fn a_request_that_nobody_answers_is_told() {
    for cycles in [1_000, 10_100] {
        breaks(HandshakeRule::NeverAcknowledged, |bench| {
            bench.write(0x4600_0005).write(0xC600_0005).run(cycles);
        });
    }
}

// [R79, R80]
#[test]
fn programmed_values_are_checked_within_ten_seconds_and_before_a_preset() {
    breaks(HandshakeRule::NoDataCheck, |bench| {
        bench.serve(0xC200_270F, 0xC200_270F).run(10_000);
    });
    breaks(HandshakeRule::NoDataCheck, |bench| {
        bench.serve(0xC200_270F, 0xC200_270F).serve(0xC600_0005, 0xC600_0005);
    });
    keeps(|bench| {
        bench.serve(0xC200_270F, 0xC200_270F).run(9_900).serve(0x8800_0000, 0x8800_0000).run(10_000);
    });
    let mut rod = Bench::new(Vantage::Cycles, Model::La66);
    rod.serve(0xC200_270F, 0xC200_270F).run(11_000);
    assert_eq!(rod.found(), []);
}

// [R82, R83]
#[test]
fn an_error_is_asked_for_within_a_second() {
    keeps(|bench| {
        bench.serve(0xC200_270F, 0xE200_270F).run(900).serve(0x8800_0000, 0x8800_0002);
    });
    for vantage in ALL {
        let mut bench = Bench::seen(vantage);
        bench.serve(0x8200_0000, 0xA200_270F).run(1_100);
        let names: Vec<_> = bench.found().iter().map(|(rule, _)| rule.name()).collect();
        assert_eq!(names, ["status_not_read", "error_ignored"], "{vantage:?}");
    }
}

// [R143]
#[test]
fn an_error_bit_in_normal_mode_is_answered_with_the_error_status() {
    breaks(HandshakeRule::ErrorIgnored, |bench| {
        bench.shows(0x2000_0064).run(1_000);
    });
    keeps(|bench| {
        bench.shows(0x2000_0064).run(900).serve(0x8800_0000, 0x8800_0000);
    });
    for vantage in ALL {
        let mut bench = Bench::seen(vantage);
        bench.shows(0x2000_0064).run(300).serve(0x8200_0000, 0xA200_270F).serve(0x8800_0000, 0x8800_0000);
        let names: Vec<_> = bench.found().iter().map(|(rule, _)| rule.name()).collect();
        assert_eq!(names, ["error_ignored"], "{vantage:?}");
    }
}

// [R57, R75, R87, R88, R89, R115]
#[test]
fn what_the_model_refuses_is_named() {
    let refused = |rule, word: u32| {
        breaks(rule, |bench| {
            bench.serve(word, word | 1 << 29).serve(0x8800_0000, 0x8800_0080);
        });
    };
    for word in [0xC200_000F, 0xC300_0000, 0xC301_0000, 0xC900_0064, 0xCD00_0021] {
        refused(HandshakeRule::OutOfRange, word);
    }
    for word in [0xC400_0000, 0x8500_0000, 0x8F00_0000] {
        refused(HandshakeRule::UnknownService, word);
    }
    refused(HandshakeRule::WrongDirection, 0x8600_0000);
    refused(HandshakeRule::WrongDirection, 0xC800_0000);
    breaks(HandshakeRule::OutOfRange, |bench| {
        bench.serve(0xC200_270F, 0xC200_270F).serve(0x8800_0000, 0x8800_0000);
        bench.serve(0xC600_2710, 0xE600_2710).serve(0x8800_0000, 0x8800_0002);
    });
}

// [R97]
#[test]
fn ten_writes_of_one_parameter_are_a_row() {
    let writes = |count: u32, step: u32| {
        move |bench: &mut Bench| {
            for k in 0..count {
                let word = 0xC200_2000 + k * step;
                bench.serve(word, word).serve(0x8800_0000, 0x8800_0000);
            }
        }
    };
    let names = |trace: &dyn Fn(&mut Bench)| {
        let mut bench = Bench::seen(Vantage::Writes);
        trace(&mut bench);
        bench.found()
    };
    assert_eq!(names(&writes(9, 1)), []);
    assert_eq!(
        names(&writes(10, 1)),
        [(HandshakeRule::MemoryWear, Ruling::Broken), (HandshakeRule::Polled, Ruling::Note)]
    );
    assert_eq!(
        names(&writes(11, 0)),
        [(HandshakeRule::EqualWrites, Ruling::Note), (HandshakeRule::Polled, Ruling::Note)]
    );
    breaks(HandshakeRule::Polled, |bench| {
        for _ in 0..10 {
            bench.serve(0x8200_0000, 0x8200_270F);
        }
    });
}

#[test]
fn days_to_wear_follow_from_the_pauses() {
    let finding = Finding {
        rule: HandshakeRule::MemoryWear,
        verdict: Ruling::Broken,
        first: Instant(0),
        last: Instant(9_000_000_000),
        count: 10,
        out: OutWord(0),
        input: None,
    };
    // 100,000 writes of a second each.
    assert_eq!(finding.days_to_wear(), Some(1));
    assert_eq!(Finding { rule: HandshakeRule::Polled, ..finding }.days_to_wear(), None);
}

// [R73]
#[test]
fn a_preset_is_not_repeated_and_not_made_in_movement() {
    breaks(HandshakeRule::PresetRepeated, |bench| {
        bench.serve(0xC600_0005, 0xC600_0005).serve(0xC600_0005, 0xC600_0005);
    });
    keeps(|bench| {
        bench.serve(0xC600_0005, 0xC600_0005).serve(0xC600_0006, 0xC600_0006);
    });
    breaks(HandshakeRule::PresetWhileMoving, |bench| {
        for position in 200..230 {
            bench.shows(position);
        }
        bench.serve(0xC600_0005, 0xC600_0005);
    });
    keeps(|bench| {
        for position in 200..230 {
            bench.shows(position);
        }
        bench.run(100).serve(0xC600_0005, 0xC600_0005);
        // At rest at the end of the range.
        for _ in 0..30 {
            bench.shows(0).shows(9_999);
        }
        bench.serve(0xC600_0006, 0xC600_0006);
    });
}

// [D1]
#[test]
fn a_service_bit_that_stands_through_a_stop_of_the_ring_is_named() {
    let stopped = |cycles: u64, bench: &mut Bench| {
        bench.write(0x4600_0005).write(0xC600_0005);
        bench.line = LineSeen::Silent;
        bench.run(cycles);
    };
    breaks(HandshakeRule::StaleServiceBit, |bench| {
        stopped(30, bench);
        bench.line = LineSeen::Good;
        bench.run(500).write(0x4600_0005).run(10);
    });
    keeps(|bench| {
        stopped(30, bench);
        bench.write(0x4600_0005);
        bench.line = LineSeen::Good;
        bench.run(500);
    });
    keeps(|bench| {
        stopped(20, bench);
        bench.line = LineSeen::Good;
        bench.shows(0xC600_0005).write(0x4600_0005).shows(0x64);
    });
}

#[test]
fn what_runs_backwards_has_gaps_or_was_not_written_is_counted_and_not_judged() {
    let mut bench = Bench::seen(Vantage::Writes);
    bench.write(0x4600_0005).run(20).write(0xC600_0005);
    bench.at_us += 500_000;
    bench.out = 0;
    bench.run(5);
    bench.at_us -= 2_000;
    bench.run(1);
    bench.at_us += 10_000;
    bench.out = 0xC600_0005;
    bench.run(5);
    bench.out = 0;
    bench.run(5);
    assert_eq!(bench.found(), []);
    let flaws = bench.referee.flaws();
    assert_eq!((flaws.gaps, flaws.backwards, flaws.unseen_writes, flaws.lone_halves), (1, 1, 2, 0));
    let mut referee = Referee::new(Vantage::Writes, Some(Model::Ce65M));
    referee.observe(Observed::Write { at: Instant(1), client: 1, written: Written::High(0xC600) });
    assert_eq!((referee.flaws().lone_halves, referee.services()), (1, 0));
}

/// What is found of words so many microseconds after the first, and how many gaps.
fn shown(cycles: &[(u64, u32, u32)]) -> (Vec<HandshakeRule>, u64) {
    let mut referee = Referee::new(Vantage::Exchanges, Some(Model::Ce65M));
    for (at_us, out, input) in cycles {
        let (at, out, input) = (Instant(at_us * 1_000), OutWord(*out), Some(InWord(*input)));
        referee.observe(Observed::Cycle { at, out, input, line: LineSeen::Good });
    }
    referee.finish();
    (referee.findings().map(|finding| finding.rule).collect(), referee.flaws().gaps.into())
}

#[test]
fn a_pause_in_a_short_trace_is_a_gap_and_the_wait_for_a_reply_is_none() {
    let risen = [(0, 0, 5), (1_000, 0x4200_270F, 5), (2_000, 0xC200_270F, 5)];
    let reply = |at_us| (at_us, 0xC200_270F, 0xC200_270F);
    for pause_us in [800_000, 20_000_000, 584 * 365 * 24 * 3_600 * 1_000_000] {
        let later = 2_000 + pause_us;
        let dropped = [(later, 0x4200_270F, 5), (later + 1_000, 0, 5)];
        assert_eq!(shown(&[&risen[..], &dropped].concat()), (Vec::new(), 1), "{pause_us} us");
        let ended = [reply(3_000), (4_000, 0x4200_270F, 5), (later + 4_000, 0, 5)];
        assert_eq!(shown(&[&risen[..], &ended].concat()).1, 1, "{pause_us} us");
    }
    let waited = [reply(90_000), (91_000, 0x4200_270F, 5), (92_000, 0, 5)];
    assert_eq!(shown(&[&risen[..], &waited].concat()).1, 0);
    let slow =
        [(0, 0, 5), (1_000_000, 0x4200_270F, 5), (2_000_000, 0xC200_270F, 5), (9_000_000, 0x4200_270F, 5)];
    assert_eq!(shown(&slow).1, 0);
    let early = [(0, 0, 5), (100_000, 0x4200_270F, 5), (200_000, 0xC200_270F, 5), (700_000, 0x4200_270F, 5)];
    assert_eq!(shown(&early), ([HandshakeRule::DroppedBeforeAcknowledgement].to_vec(), 0));
}

#[test]
fn without_a_model_only_what_holds_for_every_one_is_certain() {
    let mut referee = Referee::new(Vantage::Cycles, None);
    let mut at = 0;
    let mut show = |out: u32, input: u32, cycles: u64| {
        for _ in 0..cycles {
            at += 1_000_000;
            let (out, input) = (OutWord(out), Some(InWord(input)));
            referee.observe(Observed::Cycle { at: Instant(at), out, input, line: LineSeen::Untold });
        }
    };
    for word in [0xC200_0008_u32, 0xC400_0001, 0xCD00_0018] {
        show(word & 0x7FFF_FFFF, 0x64, 3);
        show(word, 0x64, 3);
        show(word, word, 3);
        show(word & 0x7FFF_FFFF, word, 1);
        show(word & 0x7FFF_FFFF, 0x64, 3);
    }
    show(0x0700_0000, 0x64, 3);
    show(0x8700_0000, 0x64, 3);
    show(0x8700_0000, 0x8700_0000, 3);
    show(0, 0x64, 10_100);
    referee.finish();
    let found: Vec<_> = referee.findings().map(|finding| (finding.rule, finding.verdict)).collect();
    assert_eq!(
        found,
        [(HandshakeRule::NoDataCheck, Ruling::Broken), (HandshakeRule::UnknownService, Ruling::Broken)]
    );
    assert!(referee.not_judged().any(|rule| rule == HandshakeRule::StaleServiceBit));
}

#[test]
fn anything_in_any_order_is_taken() {
    let mut chance = 0x1234_5678_9ABC_DEF0_u64;
    let mut draw = || {
        chance ^= chance << 13;
        chance ^= chance >> 7;
        chance ^= chance << 17;
        chance
    };
    for vantage in ALL {
        let mut referee = Referee::new(vantage, None);
        let mut now = 0_u64;
        for _ in 0..20_000 {
            now += draw() >> 30 >> (draw() % 30);
            // Some lie before the one before.
            let (at, word) = (Instant(now - (now / 2) * u64::from(draw() % 9 == 0)), draw() as u32);
            referee.observe(match draw() % 5 {
                0 => Observed::Write { at, client: 1, written: Written::High(word as u16) },
                1 => Observed::Write { at, client: 1, written: Written::Low(word as u16) },
                2 => Observed::Write { at, client: 2, written: Written::Both(OutWord(word)) },
                _ => {
                    let line = [LineSeen::Good, LineSeen::Bad, LineSeen::Silent][draw() as usize % 3];
                    let input = (draw() % 7 != 0).then_some(InWord(draw() as u32));
                    Observed::Cycle { at, out: OutWord(word), input, line }
                }
            });
        }
        referee.finish();
        assert!(referee.findings().all(|finding| finding.first <= finding.last), "{vantage:?}");
        assert!(referee.findings().count() > 3 && referee.services() > 100, "{vantage:?}");
    }
}
