use magician_protocol::commands::CpLeCmd;
use magician_protocol::{CpMode, Set};

use super::Stream;
use super::item::{Entry, dark, path_power, switched};

/// Chunks: what is put in whole, so that no queue lights the laser and does not put it out.
impl Stream {
    /// Whether a command may only go in together with what puts the laser out after it.
    pub(super) fn is_held(&self, entry: &Entry) -> bool {
        let path = !self.settings.dark_at_rest && path_power(&entry.item.command) != 0.0;
        entry.lit || path
    }

    /// How many of the commands from this place on go in together; `None`: more have to be offered before it can be told,
    /// unless they are no longer waited for. Splits a run that is too long for one chunk.
    pub(super) fn chunk(&mut self, from: usize, gathered: bool) -> Option<usize> {
        let (places, horizon) = (self.credit(), self.horizon(true));
        let (mut count, mut time, mut moves) = (0_usize, 0_u64, false);
        for entry in self.entries.iter().skip(from) {
            if !self.is_held(entry) {
                return Some(count + 1);
            }
            let full = count + 1 >= places && count >= 2;
            if full || moves && time.saturating_add(entry.item.time) > horizon {
                return Some(count + self.split(from, count));
            }
            time = time.saturating_add(entry.item.time);
            moves |= entry.item.time > 0;
            count += 1;
        }
        if self.ended {
            return Some(count + self.seal(from, count));
        }
        ((gathered || self.room() == 0) && moves).then(|| count + self.split(from, count))
    }

    /// Puts the laser out after so many commands and lights it again for those that follow; returns how many commands
    /// were added to the chunk. A light that nobody here has switched cannot be lit again and stays as it is.
    fn split(&mut self, from: usize, count: usize) -> usize {
        let at = from + count;
        let Some(last) = at
            .checked_sub(1)
            .and_then(|last| self.entries.get(last))
            .copied()
        else {
            return 0;
        };
        if !last.lit {
            return self.seal(from, count);
        }
        let chunk = self.entries.range(from..at);
        let lights = chunk
            .rev()
            .find(|entry| switched(&entry.item.command) == Some(true));
        let Some(light) = lights.map(|entry| entry.item.command) else {
            return 0;
        };
        let end = last.item.end;
        self.entries.insert(at, Entry::inserted(dark(), end, false));
        self.entries
            .insert(at + 1, Entry::inserted(light, end, true));
        1
    }

    /// Ends a path with a segment of no power to where it ends anyway; returns how many commands were added.
    fn seal(&mut self, from: usize, count: usize) -> usize {
        let at = from + count;
        let last = at.checked_sub(1).and_then(|last| self.entries.get(last));
        let Some((Set::CpLeCmd(segment), end)) =
            last.map(|last| (last.item.command, last.item.end))
        else {
            return 0;
        };
        let CpLeCmd { x, y, z, .. } = match segment.cp_mode {
            CpMode::Relative => CpLeCmd {
                x: 0.0,
                y: 0.0,
                z: 0.0,
                ..segment
            },
            _ => segment,
        };
        let dark = CpLeCmd {
            x,
            y,
            z,
            velocity_or_power: 0.0,
            ..segment
        };
        self.entries
            .insert(at, Entry::inserted(Set::CpLeCmd(dark), end, false));
        1
    }
}
