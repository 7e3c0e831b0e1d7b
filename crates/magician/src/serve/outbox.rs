//! Output buffer of a slow client.

use std::io;
use std::task::Poll;

use magician_protocol::FrameBuf;

/// Output to a client that reads slowly: at most one frame. A frame without space is dropped
/// completely, so that a client never receives part of one.
#[derive(Default)]
pub(super) struct Outbox {
    frame: Option<FrameBuf>,
    sent: usize,
}

impl Outbox {
    /// Sends a frame, or drops it. `write` must not block; if it is pending, it has registered the
    /// task to be woken.
    pub(super) fn send(
        &mut self,
        frame: FrameBuf,
        mut write: impl FnMut(&[u8]) -> Poll<io::Result<usize>>,
    ) -> io::Result<()> {
        self.flush(&mut write)?;
        if self.frame.is_none() {
            (self.frame, self.sent) = (Some(frame), 0);
            self.flush(write)?;
            // A frame without a single byte written may be dropped; one partly written has to be
            // completed.
            if self.sent == 0 {
                self.frame = None;
            }
        }
        Ok(())
    }

    /// Sends the rest of a frame, as far as there is space.
    pub(super) fn flush(
        &mut self,
        mut write: impl FnMut(&[u8]) -> Poll<io::Result<usize>>,
    ) -> io::Result<()> {
        while let Some(frame) = &self.frame {
            let left = frame.bytes().get(self.sent..).unwrap_or_default();
            if left.is_empty() {
                self.frame = None;
                break;
            }
            match write(left) {
                Poll::Ready(Ok(0)) => return Err(io::ErrorKind::WriteZero.into()),
                Poll::Ready(Ok(count)) => self.sent += count,
                Poll::Ready(Err(error)) => return Err(error),
                Poll::Pending => break,
            }
        }
        Ok(())
    }

    /// Drops the frame of a client that is gone.
    #[cfg(unix)]
    pub(super) fn clear(&mut self) {
        self.frame = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use magician_protocol::Ctrl;

    #[test]
    fn a_reader_with_little_space_gets_whole_frames_or_none() {
        let frame = |id| FrameBuf::new(id, Ctrl::GET, &[id; 20]).unwrap();
        let mut outbox = Outbox::default();
        let mut received = Vec::new();
        let mut space = 0;
        for id in 0..200u8 {
            space += 11;
            let write = |bytes: &[u8]| {
                let count = bytes.len().min(space);
                received.extend_from_slice(&bytes[..count]);
                space -= count;
                match count {
                    0 => Poll::Pending,
                    _ => Poll::Ready(Ok(count)),
                }
            };
            outbox.send(frame(id), write).unwrap();
        }
        let mut frames = received.chunks_exact(26);
        let ids: Vec<u8> = frames.by_ref().map(|bytes| bytes[3]).collect();
        for (bytes, id) in received.chunks_exact(26).zip(&ids) {
            assert_eq!(bytes, frame(*id).bytes());
        }
        assert!(
            ids.is_sorted() && ids.len() > 60 && ids.len() < 100,
            "{ids:?}"
        );
    }
}
