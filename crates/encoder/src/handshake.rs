//! The handshake of the service bit, seen from the encoder [R30..R41, C16, C41, C42].
//!
//! [`Handshake`] only follows bit 31 and the time; what a service does is decided elsewhere.

use encoring_words::{Duration, InWord, Instant, OutWord};

use crate::unit::StaleService;

/// Where a service stands. One value an exchange; every transition is in [`Handshake::request`] and
/// [`Handshake::complete`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handshake {
    /// Normal mode, but bit 31 is 1 without being a request: it was so at power-up, or rose again while a
    /// withdrawn service was not yet finished. A 0 ends this.
    Ignoring,
    /// Normal mode, waiting for bit 31 to rise.
    Normal,
    /// A request was taken and is being worked on.
    Busy {
        /// The OUT word as it was when bit 31 rose.
        request: OutWord,
        /// The first moment at which it can be completed.
        due: Instant,
        /// What to do after completion.
        ending: Ending,
    },
    /// The reply is shown.
    Acknowledged {
        /// The IN word.
        reply: InWord,
        /// How long it is shown.
        ending: Ending,
    },
}

/// When a reply is taken back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// As soon as the master takes bit 31 back.
    Released,
    /// After one exchange, because the master had withdrawn the request before it was completed [C42].
    Withdrawn {
        /// Bit 31 is 1 again, which is no new request.
        risen_again: bool,
    },
}

impl Handshake {
    /// The state after power-up: a bit 31 that is already 1 is stale, and must not move a zero [D1].
    #[must_use]
    pub const fn power_up(stale_service: StaleService) -> Self {
        match stale_service {
            StaleService::Ignored => Self::Ignoring,
            StaleService::Executed => Self::Normal,
        }
    }

    /// Takes the OUT word of this exchange. `time` is the service time of a request made by it.
    pub fn request(&mut self, now: Instant, out: OutWord, time: impl FnOnce(OutWord) -> Duration) {
        let bit = out.service_bit();
        if let Self::Acknowledged { ending: Ending::Withdrawn { risen_again }, .. } = *self {
            *self = if risen_again { Self::Ignoring } else { Self::Normal };
        }
        match self {
            Self::Normal if bit => {
                *self = Self::Busy { request: out, due: now + time(out), ending: Ending::Released };
            }
            Self::Ignoring | Self::Acknowledged { .. } if !bit => *self = Self::Normal,
            Self::Busy { ending, .. } if !bit => *ending = Ending::Withdrawn { risen_again: false },
            Self::Busy { ending: Ending::Withdrawn { risen_again }, .. } => *risen_again = bit,
            _ => {}
        }
    }

    /// The request that is to be completed in this exchange, if its time has come.
    #[must_use]
    pub fn due(&self, now: Instant) -> Option<OutWord> {
        match *self {
            Self::Busy { request, due, .. } if now >= due => Some(request),
            _ => None,
        }
    }

    /// Shows the reply to the request that was due.
    pub fn complete(&mut self, reply: InWord) {
        if let Self::Busy { ending, .. } = *self {
            *self = Self::Acknowledged { reply, ending };
        }
    }

    /// The reply shown in this exchange.
    #[must_use]
    pub const fn reply(&self) -> Option<InWord> {
        match self {
            Self::Acknowledged { reply, .. } => Some(*reply),
            _ => None,
        }
    }

    /// Service mode: from the request to the last exchange that shows the reply.
    #[must_use]
    pub const fn is_service_mode(&self) -> bool {
        matches!(self, Self::Busy { .. } | Self::Acknowledged { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REQUEST: OutWord = OutWord(0xC200_270F);
    const REPLY: InWord = InWord(0xC200_270F);

    /// Plays bit 31, one exchange a millisecond, with a service time in milliseconds; in the answer `p` is the
    /// position and `R` the reply.
    fn play(bits: &str, service_ms: u64, shown: &str) {
        let mut handshake = Handshake::power_up(StaleService::Ignored);
        for (k, (bit, expected)) in bits.bytes().zip(shown.bytes()).enumerate() {
            let now = Instant(k as u64 * 1_000_000);
            let out = if bit == b'1' { REQUEST } else { OutWord(REQUEST.0 & 0x7FFF_FFFF) };
            handshake.request(now, out, |_| Duration::from_millis(service_ms));
            if let Some(request) = handshake.due(now) {
                assert_eq!(request, REQUEST);
                handshake.complete(REPLY);
            }
            let seen = if handshake.reply().is_some() { b'R' } else { b'p' };
            assert_eq!(seen, expected, "exchange {k} of {bits}");
        }
    }

    #[test]
    fn a_reply_stays_until_the_bit_is_taken_back() {
        play("0111001100", 0, "pRRRppRRpp");
        play("0111110010", 3, "ppppRRpppp");
    }

    #[test]
    fn a_stale_service_bit_at_power_up_is_no_request_until_it_has_been_0() {
        play("1111011", 0, "pppppRR");
        play("1101", 0, "pppR");
    }

    #[test]
    fn a_unit_that_executes_a_stale_service_bit_takes_it_for_a_request_at_power_up() {
        let mut handshake = Handshake::power_up(StaleService::Executed);
        handshake.request(Instant(0), REQUEST, |_| Duration::ZERO);
        assert_eq!(handshake.due(Instant(0)), Some(REQUEST));
    }

    #[test]
    fn a_withdrawn_service_is_completed_and_shown_once() {
        play("0100000", 3, "ppppRpp");
        play("0111000", 3, "ppppRpp");
    }

    #[test]
    fn a_bit_that_rises_before_the_withdrawn_service_is_done_is_no_request() {
        play("0101111011111", 3, "ppppRppppppRR");
        play("0101111101", 0, "pRpRRRRRpR");
        // Risen in the completing exchange itself.
        play("010011101", 3, "ppppRpppp");
        // 0 in the completing exchange, so the next 1 is a request.
        play("01010100011", 3, "ppppRpppRpp");
    }

    #[test]
    fn the_request_is_the_word_of_the_rising_bit() {
        let mut handshake = Handshake::Normal;
        handshake.request(Instant(0), REQUEST, |_| Duration::from_nanos(1));
        handshake.request(Instant(1), OutWord(0x8100_0000), |_| Duration::ZERO);
        assert_eq!(handshake.due(Instant(1)), Some(REQUEST));
    }
}
