//! Ring buffer of the recent traffic between driver and arms, as a trace file for `magician decode`
//! and `replay`.

use std::collections::VecDeque;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Total size of the packets kept, bytes: about five minutes of a page that shows one arm at rest.
pub const CAPACITY: usize = 2 << 20;
/// Block type of packets in pcapng. Other blocks describe the interfaces and are always kept.
const PACKET_BLOCK: [u8; 4] = 6_u32.to_le_bytes();

/// A trace file that drops its oldest packets to make room. Clones share it.
#[derive(Clone, Debug, Default)]
pub(crate) struct TraceRing(Arc<Mutex<Blocks>>);

#[derive(Debug, Default)]
struct Blocks {
    interface_blocks: Vec<u8>,
    packets: VecDeque<Box<[u8]>>,
    size: usize,
}

impl TraceRing {
    fn blocks(&self) -> MutexGuard<'_, Blocks> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the current file.
    pub(crate) fn file(&self) -> Vec<u8> {
        let blocks = self.blocks();
        let mut file = Vec::with_capacity(blocks.interface_blocks.len() + blocks.size);
        file.extend(&blocks.interface_blocks);
        blocks.packets.iter().for_each(|packet| file.extend(packet));
        file
    }
}

impl Write for TraceRing {
    /// Appends a block. The trace writer passes each block in one call.
    fn write(&mut self, block: &[u8]) -> io::Result<usize> {
        let mut blocks = self.blocks();
        if block.starts_with(&PACKET_BLOCK) {
            blocks.packets.push_back(block.into());
            blocks.size += block.len();
            while blocks.size > CAPACITY {
                let Some(oldest) = blocks.packets.pop_front() else {
                    break;
                };
                blocks.size -= oldest.len();
            }
        } else {
            blocks.interface_blocks.extend(block);
        }
        Ok(block.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
