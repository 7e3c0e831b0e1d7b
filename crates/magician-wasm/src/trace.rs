//! What passed between the driver and its arms lately, as a trace file that `magician decode` and `replay` read.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Packets are kept up to so many bytes of the file: at rest some five minutes of a page that shows one arm.
pub const ROOM: usize = 2 << 20;
/// The type of a block of pcapng that is a packet. The others say what the packets are of: they are kept.
const PACKET: [u8; 4] = 6_u32.to_le_bytes();

/// A trace file whose oldest packets make room for new ones. Clones are of the same file.
#[derive(Clone, Debug, Default)]
pub(crate) struct TraceRing(Arc<Mutex<Blocks>>);

#[derive(Debug, Default)]
struct Blocks {
    heads: Vec<u8>,
    packets: VecDeque<Box<[u8]>>,
    size: usize,
}

impl TraceRing {
    fn blocks(&self) -> MutexGuard<'_, Blocks> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The file as it is now.
    pub(crate) fn file(&self) -> Vec<u8> {
        let blocks = self.blocks();
        let mut file = Vec::with_capacity(blocks.heads.len() + blocks.size);
        file.extend(&blocks.heads);
        blocks.packets.iter().for_each(|packet| file.extend(packet));
        file
    }
}

impl Write for TraceRing {
    /// A writer of traces hands each block over whole.
    fn write(&mut self, block: &[u8]) -> io::Result<usize> {
        let mut blocks = self.blocks();
        if block.starts_with(&PACKET) {
            blocks.packets.push_back(block.into());
            blocks.size += block.len();
            while blocks.size > ROOM {
                let Some(oldest) = blocks.packets.pop_front() else {
                    break;
                };
                blocks.size -= oldest.len();
            }
        } else {
            blocks.heads.extend(block);
        }
        Ok(block.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
