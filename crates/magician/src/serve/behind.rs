//! Buffered writing by a thread, so that a slow disk does not delay the arm.

use std::io::{self, Write};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::{self, JoinHandle};

// Large enough that the thread is woken rarely, small enough that little is lost with a killed
// process.
const BLOCK: usize = 64 * 1024;
/// Blocks that may wait for the disk: 16 MB, or minutes of an arm at normal speed. Choice.
const BLOCKS: usize = 256;

/// Behaviour if the buffer is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Full {
    /// The writer waits. At full speed a delay of the arm's clock is harmless.
    Wait,
    /// Writing fails.
    Fail,
}

/// Writer that passes its data to a thread. Flushing passes the current block on;
/// [`finish`](Self::finish) waits until everything is written.
pub(super) struct WriteBehind {
    block: Vec<u8>,
    full: Full,
    blocks: Option<SyncSender<Vec<u8>>>,
    thread: Option<JoinHandle<io::Result<()>>>,
}

impl WriteBehind {
    pub(super) fn new(out: impl Write + Send + 'static, full: Full) -> io::Result<Self> {
        let (blocks, waiting) = sync_channel(BLOCKS);
        let thread = thread::Builder::new().name("recording".to_owned());
        Ok(Self {
            block: Vec::with_capacity(BLOCK),
            full,
            blocks: Some(blocks),
            thread: Some(thread.spawn(|| write_all(out, waiting))?),
        })
    }

    /// Waits until all data is in the file.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.flush()?;
        self.end()
    }

    fn hand_over(&mut self) -> io::Result<()> {
        if self.block.is_empty() {
            return Ok(());
        }
        let Some(blocks) = &self.blocks else {
            return Err(io::ErrorKind::BrokenPipe.into());
        };
        // A new block, because the thread still writes from the old one.
        let block = std::mem::replace(&mut self.block, Vec::with_capacity(BLOCK));
        let sent = match self.full {
            Full::Wait => blocks.send(block).map_err(|_| ()),
            Full::Fail => match blocks.try_send(block) {
                Err(TrySendError::Full(_)) => return Err(self.give_up()),
                sent => sent.map_err(|_| ()),
            },
        };
        // The thread only ends early after a failed write, whose error it returns.
        sent.or_else(|()| {
            self.end()?;
            Err(io::ErrorKind::BrokenPipe.into())
        })
    }

    /// Abandons a thread that is stuck in a write.
    fn give_up(&mut self) -> io::Error {
        (self.blocks, self.thread) = (None, None);
        let megabytes = BLOCK * BLOCKS / 1_000_000;
        io::Error::other(format!("the disk is {megabytes} MB behind"))
    }

    fn end(&mut self) -> io::Result<()> {
        self.blocks = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(written)) => written,
            Some(Err(_)) => Err(io::Error::other("the thread that writes has panicked")),
            None => Ok(()),
        }
    }
}

fn write_all(mut out: impl Write, blocks: Receiver<Vec<u8>>) -> io::Result<()> {
    for block in blocks {
        out.write_all(&block)?;
        out.flush()?;
    }
    Ok(())
}

impl Write for WriteBehind {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = bytes.len().min(BLOCK - self.block.len());
        self.block.extend_from_slice(&bytes[..count]);
        if self.block.len() >= BLOCK {
            self.hand_over()?;
        }
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.hand_over()
    }
}

impl Drop for WriteBehind {
    fn drop(&mut self) {
        // An owner interested in the error has called `finish`.
        let _ = self.hand_over();
        let _ = self.end();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Sender, channel};

    use super::*;

    /// Writer that blocks until released, then reports the bytes.
    struct Slow {
        told: Receiver<()>,
        written: Sender<Vec<u8>>,
    }

    impl Write for Slow {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.told.recv().is_err() {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let _ = self.written.send(bytes.to_vec());
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    fn slow() -> (Slow, Sender<()>, Receiver<Vec<u8>>) {
        let ((tell, told), (written, all)) = (channel(), channel());
        (Slow { told, written }, tell, all)
    }

    #[test]
    fn all_is_written_in_order_and_the_end_waits_for_it() {
        let (out, tell, all) = slow();
        let mut behind = WriteBehind::new(out, Full::Wait).unwrap();
        let bytes: Vec<u8> = (0..BLOCK * 2 + 7).map(|at| (at % 251) as u8).collect();
        behind.write_all(&bytes).unwrap();
        for _ in 0..3 {
            tell.send(()).unwrap();
        }
        behind.finish().unwrap();
        assert_eq!(all.iter().flatten().collect::<Vec<u8>>(), bytes);
    }

    #[test]
    fn a_disk_that_hangs_fails_in_time_and_holds_nobody_up() {
        let (out, tell, _all) = slow();
        let mut behind = WriteBehind::new(out, Full::Fail).unwrap();
        let most = BLOCK * (BLOCKS + 3);
        let error = behind.write_all(&vec![0; most]).unwrap_err();
        assert_eq!(error.to_string(), "the disk is 16 MB behind");
        assert!(behind.write_all(&vec![0; BLOCK]).is_err());
        drop(behind);
        drop(tell);
    }

    #[test]
    fn what_the_disk_says_is_passed_on() {
        let (out, tell, _all) = slow();
        drop(tell);
        let mut behind = WriteBehind::new(out, Full::Wait).unwrap();
        behind.write_all(b"lost").unwrap();
        let error = behind.finish().unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
