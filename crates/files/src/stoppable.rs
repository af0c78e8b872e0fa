//! Sources that may give nothing for long, such as pipes, and end when somebody says so.

use std::io::{self, BufRead, Read};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::thread;
use std::time::Duration;

/// How often is looked whether it is to end.
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Bytes that are read at once.
const BLOCK: usize = 1 << 16;

/// Blocks that are read ahead.
const AHEAD: usize = 4;

/// A source that is read by a thread of its own. It ends where the source does, or soon after a mark was set, behind a line
/// that is whole.
#[derive(Debug)]
pub struct Stoppable {
    blocks: Receiver<io::Result<Vec<u8>>>,
    stop: Arc<AtomicBool>,
    block: Vec<u8>,
    used: usize,
}

impl Stoppable {
    /// Begins to read. It ends when `stop` is set; the thread ends with the source or with the program.
    ///
    /// # Errors
    /// Those of the system, which may have no thread left.
    pub fn new(source: impl Read + Send + 'static, stop: Arc<AtomicBool>) -> io::Result<Self> {
        let (sender, blocks) = mpsc::sync_channel(AHEAD);
        thread::Builder::new().name("reads".to_owned()).spawn(move || read(source, &sender))?;
        Ok(Self { blocks, stop, block: Vec::new(), used: 0 })
    }
}

/// Hands over what comes, in whole lines as far as a block can hold one.
fn read(mut source: impl Read, blocks: &SyncSender<io::Result<Vec<u8>>>) {
    let (mut begun, mut buffer) = (Vec::new(), vec![0; BLOCK]);
    loop {
        let read = match source.read(&mut buffer) {
            Ok(read) => buffer.get(..read).unwrap_or_default(),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => {
                let _ = blocks.send(Err(error));
                return;
            }
        };
        begun.extend_from_slice(read);
        let whole = begun.iter().rposition(|byte| *byte == b'\n').map_or(0, |end| end + 1);
        let is_all = read.is_empty() || begun.len() - whole >= BLOCK;
        let rest = begun.split_off(if is_all { begun.len() } else { whole });
        let block = std::mem::replace(&mut begun, rest);
        let is_over = read.is_empty();
        if !block.is_empty() && blocks.send(Ok(block)).is_err() || is_over {
            return;
        }
    }
}

impl BufRead for Stoppable {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.used == self.block.len() {
            if self.stop.load(Ordering::Relaxed) {
                return Ok(&[]);
            }
            match self.blocks.recv_timeout(LOOK_EVERY) {
                Ok(block) => (self.block, self.used) = (block?, 0),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(&[]),
            }
        }
        Ok(self.block.get(self.used..).unwrap_or_default())
    }

    fn consume(&mut self, amount: usize) {
        self.used = self.block.len().min(self.used.saturating_add(amount));
    }
}

impl Read for Stoppable {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn mark() -> Arc<AtomicBool> {
        Arc::new(AtomicBool::new(false))
    }

    #[test]
    fn all_of_a_source_comes_in_order() {
        let text: String = (0..50_000).map(|line| format!("line {line}\n")).collect();
        for text in [text.clone(), text + "half", "x".repeat(3 * BLOCK + 1), String::new()] {
            let mut all = String::new();
            let source = io::Cursor::new(text.clone().into_bytes());
            Stoppable::new(source, mark()).unwrap().read_to_string(&mut all).unwrap();
            assert!(all == text, "{} of {} bytes", all.len(), text.len());
        }
    }

    #[test]
    fn a_pipe_that_gives_nothing_ends_when_told_behind_a_whole_line() {
        let (reader, mut writer) = io::pipe().unwrap();
        writer.write_all(b"one\ntwo\nhal").unwrap();
        let stop = mark();
        let mut source = Stoppable::new(reader, Arc::clone(&stop)).unwrap();
        let mut line = String::new();
        source.read_line(&mut line).unwrap();
        source.read_line(&mut line).unwrap();
        assert_eq!(line, "one\ntwo\n");
        stop.store(true, Ordering::Relaxed);
        assert_eq!(source.read_line(&mut line).unwrap(), 0);
        drop(writer);
    }

    #[test]
    fn an_error_of_the_source_is_handed_on() {
        struct Broken;
        impl Read for Broken {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::ErrorKind::BrokenPipe.into())
            }
        }
        let mut source = Stoppable::new(Broken, mark()).unwrap();
        assert_eq!(source.fill_buf().unwrap_err().kind(), io::ErrorKind::BrokenPipe);
    }
}
