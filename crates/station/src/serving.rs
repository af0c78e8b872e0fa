//! Services that the ring's thread carries out itself, as a master does: one look a cycle.

use std::sync::mpsc::SyncSender;

use encoring_host::{Outcome, Request, Seen, Session, Timing};
use encoring_ring::ProcessImage;
use encoring_words::{Duration, Instant, OutWord};

/// Why a service was not carried out here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotServed {
    /// There is no such encoder.
    #[error("no encoder at position {position}")]
    NoEncoder {
        /// The position that was asked for.
        position: usize,
    },
    /// Another service is under way.
    #[error("OUT holds {out}: a service is under way, or was left there; this one was not begun")]
    UnderWay {
        /// The OUT word that stands in the process image.
        out: OutWord,
    },
    /// Somebody else writes the OUT word.
    #[error("OUT holds {out} instead of the {ours} written here: another master writes it")]
    Overwritten {
        /// The OUT word that stands in the process image.
        out: OutWord,
        /// What was written last.
        ours: OutWord,
    },
}

/// What becomes of a service.
pub type Served = Result<Outcome, NotServed>;

/// A service under way.
#[derive(Debug)]
struct UnderWay {
    position: usize,
    session: Session,
    /// What was written last.
    ours: OutWord,
    done: SyncSender<Served>,
}

/// Those of a ring.
#[derive(Debug, Default)]
pub(crate) struct Serving {
    under_way: Vec<UnderWay>,
    /// The end of the last cycle that was good throughout.
    last_good: Instant,
}

impl Serving {
    /// Begins a service, or says at once why not.
    pub(crate) fn begin(
        &mut self,
        now: Instant,
        (position, request): (usize, Request),
        image: &mut ProcessImage,
        done: SyncSender<Served>,
    ) {
        // Whoever asked may have gone; then there is nobody to tell.
        let refuse = |why| {
            let _ = done.send(Err(why));
        };
        let Some(standing) = image.out_mut().get_mut(position) else {
            return refuse(NotServed::NoEncoder { position });
        };
        if standing.service_bit() || self.under_way.iter().any(|service| service.position == position) {
            return refuse(NotServed::UnderWay { out: *standing });
        }
        let mut session = Session::new(Timing::DIRECT, *standing);
        // None is under way in a session that is new.
        let ours = session.start(now, request).unwrap_or(request.rest());
        *standing = ours;
        self.under_way.push(UnderWay { position, session, ours, done });
    }

    /// Takes what a cycle has brought, and puts out what the next one carries.
    pub(crate) fn cycled(&mut self, now: Instant, good: bool, cycle: Duration, image: &mut ProcessImage) {
        if good {
            self.last_good = now;
        }
        // What a cycle brings was loaded when it began.
        let age = now.since(self.last_good) + cycle;
        self.under_way.retain_mut(|service| {
            let input = image.input().get(service.position).copied().unwrap_or_default();
            let Some(out) = image.out_mut().get_mut(service.position) else { return false };
            match service.look(now, Seen { input, age }, out) {
                None => true,
                Some(served) => {
                    let _ = service.done.send(served);
                    false
                }
            }
        });
    }
}

impl UnderWay {
    fn look(&mut self, now: Instant, seen: Seen, out: &mut OutWord) -> Option<Served> {
        if *out != self.ours {
            return Some(Err(NotServed::Overwritten { out: *out, ours: self.ours }));
        }
        let (next, outcome) = self.session.cycle(now, Some(seen));
        (*out, self.ours) = (next, next);
        outcome.map(Ok)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::sync_channel;

    use encoring_host::Reply;
    use encoring_words::InWord;

    use super::*;

    #[test]
    fn another_master_ends_a_service_and_a_second_one_is_not_begun() {
        let mut image = ProcessImage::new(1).unwrap();
        let mut serving = Serving::default();
        let (done, first) = sync_channel(1);
        serving.begin(Instant(0), (0, Request::data_check()), &mut image, done.clone());
        assert_eq!(image.out(), [OutWord(0x0800_0000)], "data and number first [R33]");
        let (refused, second) = sync_channel(1);
        serving.begin(Instant(1), (0, Request::data_check()), &mut image, refused);
        assert_eq!(second.recv(), Ok(Err(NotServed::UnderWay { out: OutWord(0x0800_0000) })));
        serving.begin(Instant(1), (1, Request::data_check()), &mut image, done);
        assert_eq!(first.recv(), Ok(Err(NotServed::NoEncoder { position: 1 })));
        image.out_mut()[0] = OutWord(7);
        serving.cycled(Instant(2), true, Duration::from_nanos(1), &mut image);
        let (out, ours) = (OutWord(7), OutWord(0x0800_0000));
        assert_eq!(first.recv(), Ok(Err(NotServed::Overwritten { out, ours })));
        assert_eq!(image.out(), [OutWord(7)]);
        assert!(serving.under_way.is_empty());
    }

    #[test]
    fn a_service_ends_when_the_encoder_shows_positions_again() {
        let mut image = ProcessImage::new(1).unwrap();
        let mut serving = Serving::default();
        let (done, served) = sync_channel(1);
        serving.begin(Instant(0), (0, Request::data_check()), &mut image, done);
        for k in 1..20 {
            // Like an encoder without service times.
            let replies = image.out()[0].service_bit();
            image.input_mut()[0] = if replies { InWord(0x8800_0000) } else { InWord(5) };
            serving.cycled(Instant(k), true, Duration::from_nanos(1), &mut image);
        }
        let reply = Reply { data: 0, error: false };
        assert_eq!(served.recv(), Ok(Ok(Outcome::Done { reply, error_before: false })));
        assert_eq!(image.out(), [OutWord(0x0800_0000)]);
    }
}
