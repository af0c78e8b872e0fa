//! What a program does wrong, and what is to be said of it from where.

use encoring_words::{Model, OutWord, Written};

use crate::plant::{Chance, Plant};

macro_rules! mistakes {
    ($($mistake:ident $wanted:expr, $certain:literal;)*) => {
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Mistake { $($mistake,)* }

        /// Each with the rules that it breaks, and the places (w, c, x, p) from which all of them are certain.
        pub(crate) const MISTAKES: &[(Mistake, &[&str], &str)] = &[$((Mistake::$mistake, $wanted, $certain),)*];
    };
}

mistakes! {
    None &[], "wcxp";
    Torn &["torn_words"], "w";
    Together &["data_with_service_bit"], "w";
    Changed &["data_changed_in_service"], "wcx";
    Dropped &["dropped_before_acknowledgement"], "wcx";
    GaveUp &["withdrawn"], "wcx";
    Kept &["never_dropped"], "wcx";
    Hasty &["next_before_end"], "wc";
    Foreign &["foreign_reply"], "wc";
    Unanswered &["never_acknowledged"], "wcx";
    NoCheck &["no_data_check"], "wcx";
    NotAsked &["status_not_read", "error_ignored"], "wcx";
    Ignored &["error_ignored"], "wcx";
    OutOfRange &["out_of_range"], "wcx";
    Refused &["unknown_service"], "wcx";
    Backwards &["wrong_direction"], "wcx";
    Worn &["memory_wear"], "wcx";
    Equal &["memory_wear, a note"], "wcx";
    TornByTwo &["data_changed_in_service"], "wc";
    Polled &["polled"], "wcx";
    Again &["preset_repeated"], "wcx";
    Moving &["preset_while_moving"], "wcx";
    Stale &["stale_service_bit"], "wc";
}

impl Mistake {
    /// The rules that it breaks.
    pub(crate) fn breaks(self, model: Model) -> &'static [&'static str] {
        // A rod takes every value over at once, so nothing is left undone.
        let needless = self == Self::NoCheck && model == Model::La66;
        MISTAKES.iter().find(|(mistake, ..)| *mistake == self && !needless).map_or(&[], |(_, rules, _)| rules)
    }
}

const CHECK: u32 = 0x8800_0000;

impl Plant {
    /// A program that does some services right, and then makes the mistake.
    pub(crate) fn program(&mut self, chance: &mut Chance, mistake: Mistake) {
        self.wait(chance.between(20_000, 500_000));
        for _ in 0..chance.between(1, 3) {
            self.serve(0x8200_0000);
            self.serve(0xC200_8000 | chance.between(1, 0xFFF) as u32);
            self.serve(CHECK);
        }
        self.err(chance, mistake);
        self.wait(250_000);
    }

    fn err(&mut self, chance: &mut Chance, mistake: Mistake) {
        let value = 0x100 + chance.below(0x2000) as u32;
        let word = 0xC600_0000 | value;
        let rest = word & 0x7FFF_FFFF;
        match mistake {
            Mistake::None => {}
            Mistake::Torn => {
                self.write(Written::High((word >> 16) as u16));
                self.wait(chance.below(self.cycle_us / 2));
                self.write(Written::Low(word as u16 ^ 1));
                self.end(word);
            }
            Mistake::Together => {
                self.put(rest ^ 3);
                self.scan();
                self.put_whole(word);
                self.end(word);
            }
            Mistake::Changed => {
                self.device.slow_us = 200_000;
                self.request(word);
                self.wait(2 * self.cycle_us);
                self.put_whole(word ^ 4);
                self.end(word);
            }
            Mistake::Dropped => {
                self.device.slow_us = 5_000_000;
                self.request(word);
                self.wait(chance.between(40_000, 900_000));
                self.put(rest);
            }
            Mistake::GaveUp => {
                self.device.slow_us = 5_000_000;
                self.request(word);
                self.wait(chance.between(1_050_000, 3_000_000));
                self.put(rest);
            }
            Mistake::Kept => {
                self.request(word);
                self.until(1);
                self.wait(chance.between(11_000_000, 15_000_000));
                self.put(rest);
                self.until(0);
            }
            Mistake::Hasty => self.hasty(word),
            Mistake::Foreign => {
                self.device.foreign = true;
                self.serve(word);
                self.device.foreign = false;
            }
            Mistake::Unanswered => {
                self.device.slow_us = u64::MAX / 4;
                self.request(word);
                self.wait(chance.between(10_500_000, 14_000_000));
            }
            Mistake::NoCheck => {
                self.serve(0xC200_4000 | value);
                self.wait(chance.between(10_500_000, 12_000_000));
            }
            Mistake::NotAsked => {
                self.device.error = true;
                self.serve(0x8200_0000);
                self.wait(chance.between(1_500_000, 3_000_000));
            }
            Mistake::Ignored => {
                self.device.error = true;
                self.wait(chance.between(1_200_000, 3_000_000));
                self.serve(CHECK);
            }
            Mistake::OutOfRange => {
                self.serve(0xC200_0000);
                self.serve(CHECK);
            }
            Mistake::Refused => {
                self.serve(0x8700_0000);
                self.serve(CHECK);
            }
            Mistake::Backwards => {
                self.serve(0x8600_0000);
                self.serve(CHECK);
            }
            Mistake::Worn => {
                for step in 0..10 {
                    self.serve(0xC200_4000 + value + step);
                }
                self.serve(CHECK);
            }
            Mistake::Equal => {
                (0..11).for_each(|_| self.serve(0xC200_4000 | value));
                self.serve(CHECK);
            }
            Mistake::TornByTwo => {
                self.device.slow_us = 200_000;
                self.request(word);
                self.wait(2 * self.cycle_us);
                self.write_as(2, Written::Low(word as u16 ^ 2));
                self.end(word);
            }
            Mistake::Polled => (0..10).for_each(|_| self.serve(0x8200_0000)),
            Mistake::Again => {
                self.serve(word);
                self.serve(word);
            }
            Mistake::Moving => {
                self.device.turns = 1;
                self.wait(100 * self.cycle_us.max(5_000));
                self.serve(word);
            }
            Mistake::Stale => {
                self.device.slow_us = 5_000_000;
                self.request(word);
                self.silent = true;
                self.wait(chance.between(150_000, 400_000));
                self.silent = false;
                self.wait(chance.between(150_000, 400_000));
                self.put(rest);
            }
        }
    }

    fn hasty(&mut self, word: u32) {
        self.request(word);
        self.until(1);
        // The next number stands there already: the bit falls and rises before the end is seen.
        self.put_whole(0x0200_0000);
        self.past_next_cycle();
        self.put_whole(0x8200_0000);
        self.until(1);
        self.write(Written::Both(OutWord(0)));
        self.until(0);
    }
}
