//! How fast a gateway answers, and whether its time-out leaves it the time.

use encoring_words::Duration;

/// What the answers of one call took, and what that came to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Pace {
    /// Answers of the present call.
    answers: u32,
    /// The longest that one of them took.
    longest: Duration,
    /// As much as that, when a call ran out of time for the next.
    too_slow: Option<Duration>,
}

impl Pace {
    /// A call begins.
    pub(super) const fn begin(&mut self) {
        (self.answers, self.longest) = (0, Duration::ZERO);
    }

    /// An answer came, after so long.
    pub(super) fn answered(&mut self, after: Duration) {
        self.answers = self.answers.saturating_add(1);
        self.longest = self.longest.max(after);
    }

    /// The call ends without the answer to its last request. Where the answers before took so long that one more has no
    /// room in it, that tells nothing of the gateway but how slow it is.
    pub(super) fn ran_out(&mut self, within: Duration) {
        let needed = self.longest.as_nanos().saturating_mul(u64::from(self.answers).saturating_add(1));
        if self.answers > 0 && needed >= within.as_nanos() {
            self.too_slow = Some(self.longest);
        }
    }

    /// How long its answers take, if that is too long for all requests of a call.
    pub(super) const fn too_slow(&self) -> Option<Duration> {
        self.too_slow
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WITHIN: Duration = Duration::from_millis(500);

    /// A call that ran out of time behind so many answers of so many milliseconds each.
    fn ran_out(pace: &mut Pace, answers: u32, millis: u64) -> Option<Duration> {
        pace.begin();
        (0..answers).for_each(|_| pace.answered(Duration::from_millis(millis)));
        pace.ran_out(WITHIN);
        pace.too_slow()
    }

    #[test]
    fn a_gateway_is_too_slow_if_its_answers_leave_no_room_for_the_next() {
        assert_eq!(ran_out(&mut Pace::default(), 1, 250), Some(Duration::from_millis(250)));
        assert_eq!(ran_out(&mut Pace::default(), 3, 130), Some(Duration::from_millis(130)));
        assert_eq!(ran_out(&mut Pace::default(), 1, 240), None, "the next one was lost");
        assert_eq!(ran_out(&mut Pace::default(), 0, 0), None, "nothing was answered");
    }

    #[test]
    fn a_call_is_judged_by_its_own_answers() {
        let mut pace = Pace::default();
        assert_eq!(ran_out(&mut pace, 2, 240), Some(Duration::from_millis(240)));
        assert_eq!(ran_out(&mut Pace { too_slow: None, ..pace }, 0, 0), None);
    }
}
