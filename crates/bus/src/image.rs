//! The process image, shared between the thread that cycles the ring and everyone who reads or writes it.

use std::sync::{Arc, Mutex, PoisonError};

use encoring_ring::ProcessImage;
use encoring_words::{OutWord, Written};

/// How many writes are kept for whoever looks on, from one cycle to the next.
pub const WRITES_KEPT: usize = 4096;

/// The client that is none: whoever cycles the ring wrote this itself.
pub const RING_ITSELF: u32 = 0;

/// A handle on the process image; clones lead to the same one.
#[derive(Clone, Debug)]
pub struct SharedImage(Arc<Mutex<Held>>);

#[derive(Debug)]
struct Held {
    image: ProcessImage,
    writes: Option<KeptWrites>,
}

/// A write of an OUT word by a client.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientWrite {
    /// Who, by the number of its connection, or [`RING_ITSELF`].
    pub client: u32,
    /// The ring position.
    pub position: usize,
    /// What.
    pub written: Written,
}

/// What clients wrote since they were looked at last, in order.
#[derive(Debug)]
pub struct KeptWrites {
    list: Vec<ClientWrite>,
    lost: u64,
}

impl KeptWrites {
    fn note(&mut self, write: ClientWrite) {
        if self.list.len() < WRITES_KEPT {
            self.list.push(write);
        } else {
            self.lost = self.lost.saturating_add(1);
        }
    }

    /// Notes what whoever cycles the ring has written itself: every word that is another one now.
    pub fn note_changes(&mut self, before: &[OutWord], after: &[OutWord]) {
        for (position, (before, after)) in before.iter().zip(after).enumerate() {
            if before != after {
                self.note(ClientWrite { client: RING_ITSELF, position, written: Written::Both(*after) });
            }
        }
    }

    /// Gives what was kept in exchange for an empty list that is used again, and how many writes were lost after it.
    pub fn take(&mut self, list: &mut Vec<ClientWrite>) -> u64 {
        list.clear();
        std::mem::swap(&mut self.list, list);
        std::mem::take(&mut self.lost)
    }
}

impl SharedImage {
    /// Shares `image`.
    #[must_use]
    pub fn new(image: ProcessImage) -> Self {
        Self(Arc::new(Mutex::new(Held { image, writes: None })))
    }

    fn held<R>(&self, access: impl FnOnce(&mut Held) -> R) -> R {
        access(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Looks at the image or changes it in one piece: no cycle of the ring runs meanwhile, so words that are
    /// written together are seen together.
    pub fn with<R>(&self, access: impl FnOnce(&mut ProcessImage) -> R) -> R {
        self.held(|held| access(&mut held.image))
    }

    /// The same for a client, who says what it wrote: the position, and what. If nobody looks on, that is forgotten.
    pub fn with_client<R>(
        &self,
        client: u32,
        access: impl FnOnce(&mut ProcessImage, &mut dyn FnMut(usize, Written)) -> R,
    ) -> R {
        self.held(|Held { image, writes }| {
            access(image, &mut |position, written| {
                if let Some(writes) = writes {
                    writes.note(ClientWrite { client, position, written });
                }
            })
        })
    }

    /// The same for whoever cycles the ring and writes between two cycles.
    pub fn with_own<R>(&self, access: impl FnOnce(&mut ProcessImage) -> R) -> R {
        self.held(|Held { image, writes }| {
            let Some(writes) = writes else { return access(image) };
            let before = image.out().to_vec();
            let result = access(image);
            writes.note_changes(&before, image.out());
            result
        })
    }

    /// From now on what clients write is kept, at most [`WRITES_KEPT`] until it is looked at.
    pub fn keep_writes(&self) {
        let new = || KeptWrites { list: Vec::with_capacity(WRITES_KEPT), lost: 0 };
        self.held(|held| {
            held.writes.get_or_insert_with(new);
        });
    }

    /// Looks at the image in one piece with what clients wrote, if that is kept.
    pub fn with_writes<R>(&self, access: impl FnOnce(&mut ProcessImage, Option<&mut KeptWrites>) -> R) -> R {
        self.held(|held| access(&mut held.image, held.writes.as_mut()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_clients_write_is_kept_in_order_and_what_is_too_much_is_counted() {
        let image = SharedImage::new(ProcessImage::new(2).unwrap());
        let write = |client, value: u16| {
            image.with_client(client, |_, wrote| wrote(1, Written::Low(value)));
        };
        write(1, 0);
        image.keep_writes();
        for value in 0..=WRITES_KEPT {
            write(7, value as u16);
        }
        let mut list = Vec::new();
        let mut take = || {
            let lost = image.with_writes(|_, writes| writes.unwrap().take(&mut list));
            (list.len(), list.first().copied(), lost)
        };
        let first = ClientWrite { client: 7, position: 1, written: Written::Low(0) };
        assert_eq!(take(), (WRITES_KEPT, Some(first), 1));
        assert_eq!(take(), (0, None, 0));
        image.with_client(8, |_, wrote| wrote(0, Written::Both(OutWord(5))));
        let written = Written::Both(OutWord(5));
        assert_eq!(take(), (1, Some(ClientWrite { client: 8, position: 0, written }), 0));
        image.with_own(|image| image.out_mut()[1] = OutWord(5));
        assert_eq!(take(), (1, Some(ClientWrite { client: RING_ITSELF, position: 1, written }), 0));
    }
}
