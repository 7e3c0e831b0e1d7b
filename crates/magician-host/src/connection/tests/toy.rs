use std::collections::VecDeque;

use magician_protocol::commands::{
    DeviceTime, QueuedCmdClear, QueuedCmdCurrentIndex, QueuedCmdLeftSpace,
};
use magician_protocol::{FrameBuf, Readable, Writable};

use crate::connection::Micros;

/// Time of a tick: everything happens at multiples of it.
pub(super) const TICK: Micros = 10_000;

/// Minimal controller that follows the index law.
#[derive(Clone, Debug)]
pub(super) struct Toy {
    pub(super) places: usize,
    /// Duration of a command, ticks.
    pub(super) takes: u64,
    pub(super) next: u64,
    pub(super) current: u64,
    /// Indices of the commands in the queue, the running one first.
    pub(super) queue: VecDeque<u64>,
    pub(super) begun: u64,
    pub(super) booted: u64,
    /// Commands accepted over all resets, each with its index.
    pub(super) accepted: Vec<(u32, u64)>,
}

impl Toy {
    pub(super) fn pass(&mut self, tick: u64) {
        while self.begun + self.takes <= tick {
            let Some(index) = self.queue.pop_front() else {
                return;
            };
            self.current = index;
            self.begun += self.takes;
        }
    }

    pub(super) fn reset(&mut self, tick: u64) {
        self.queue.clear();
        (self.next, self.current, self.booted) = (1, 0, tick);
    }

    pub(super) fn answer(&mut self, request: &FrameBuf, tick: u64) -> FrameBuf {
        let view = request.frame();
        let reply = |params: &[u8]| FrameBuf::new(view.id(), view.ctrl(), params).unwrap();
        match view.id() {
            id if view.ctrl().queued() => {
                if self.queue.len() >= self.places {
                    let refused = view.ctrl().with_error();
                    return FrameBuf::new(id, refused, &[0; 8]).unwrap();
                }
                if self.queue.is_empty() {
                    // An idle controller begins a command when it arrives.
                    self.begun = tick;
                }
                let number = u32::from_le_bytes(view.params().try_into().unwrap());
                let index = self.next;
                self.next += 1;
                self.queue.push_back(index);
                self.accepted.push((number, index));
                reply(&index.to_le_bytes())
            }
            id if id == QueuedCmdCurrentIndex::ROW.id => reply(&self.current.to_le_bytes()),
            id if id == QueuedCmdLeftSpace::ROW.id => {
                let left = (self.places - self.queue.len()) as u32;
                reply(&left.to_le_bytes())
            }
            id if id == DeviceTime::ROW.id => {
                let ms = 5_000 + (tick - self.booted) * TICK / 1000;
                reply(&(ms as u32).to_le_bytes())
            }
            id if id == QueuedCmdClear::ROW.id => {
                // The running command is not dropped.
                self.queue.truncate(1);
                reply(&[])
            }
            _ => reply(&[]),
        }
    }
}
