//! Chunks of the switched laser, and segments too long for the laser's horizon.

use magician_protocol::commands::CpLeCmd;
use magician_protocol::{CpMode, Set};

use super::Stream;
use super::item::{Entry, Item, laser_off, path_power, switched_laser_state};
use crate::build;

/// Chunks: groups put in whole, so that no queue lights the laser without switching it off.
impl Stream {
    /// True if a command may be put in only together with the command that switches the laser off
    /// after it.
    pub(super) fn is_held(&self, entry: &Entry) -> bool {
        // If the firmware is not trusted to switch a path's laser off at rest, a dark segment must
        // follow.
        let path = !self.settings.dark_at_rest && path_power(&entry.item.command) != 0.0;
        entry.lit || path
    }

    /// Number of commands from this position that are put in together. `None`: undecided until more
    /// are offered, unless `gathered`. Splits a run that is too long for one chunk.
    pub(super) fn chunk(&mut self, from: usize, gathered: bool) -> Option<usize> {
        let (places, horizon) = (self.credit(), self.horizon(true));
        let (mut count, mut time, mut moves) = (0_usize, 0_u64, false);
        for entry in self.entries.iter().skip(from) {
            if !self.is_held(entry) {
                // This command switches the laser off, or needs it no more: it closes the chunk.
                return Some(count + 1);
            }
            // One place is reserved for the command that switches the laser off.
            let full = count + 1 >= places && count >= 2;
            if full || moves && time.saturating_add(entry.item.time) > horizon {
                return Some(count + self.split(from, count));
            }
            time = time.saturating_add(entry.item.time);
            // A chunk without motion would light the laser in one place for nothing.
            moves |= entry.item.time > 0;
            count += 1;
        }
        // End of the stream: a path gets its dark end, and a switched laser stays as the caller
        // left it.
        if self.ended {
            return Some(count + self.seal(from, count));
        }
        ((gathered || self.room() == 0) && moves).then(|| count + self.split(from, count))
    }

    /// Switches the laser off after `count` commands and on again for later ones. Returns
    /// how many commands were added to the chunk. A laser that the stream did not see switched on
    /// cannot be relit and is left as it is.
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
            .find(|entry| switched_laser_state(&entry.item.command) == Some(true));
        let Some(light) = lights.map(|entry| entry.item.command) else {
            return 0;
        };
        let end = last.item.end;
        self.entries
            .insert(at, Entry::inserted(laser_off(), end, false));
        self.entries
            .insert(at + 1, Entry::inserted(light, end, true));
        1
    }

    /// Cuts the next command if it is a segment that burns for longer than the laser's horizon.
    ///
    /// Its first piece is sent separately, so that the arm never has more than the current piece
    /// and the next one. A segment with unknown start or time stays whole.
    pub(super) fn cut(&mut self, next: usize) {
        let Some(entry) = self.entries.get(next) else {
            return;
        };
        let (time, most) = (entry.item.time, self.settings.laser_horizon.max(1));
        let Set::CpLeCmd(whole) = entry.item.command else {
            return;
        };
        // Stretches of the switched laser are split by `chunk`; an unknown time cannot be divided.
        if entry.lit || path_power(&entry.item.command) == 0.0 || time <= most || time == u64::MAX {
            return;
        }
        let start = match next
            .checked_sub(1)
            .and_then(|before| self.entries.get(before))
        {
            Some(before) => before.item.end,
            None => self.last_pose,
        };
        let pieces = time.div_ceil(most);
        let share = 1.0 / pieces as f64;
        let Some((piece, rest)) = split(whole, start, share) else {
            return;
        };
        let time = time / pieces;
        let end = start.map(|start| on_the_way(start, whole, share));
        let first = Item {
            command: Set::CpLeCmd(piece),
            time,
            end,
            laser: true,
        };
        self.entries.change(next..next + 1, |entry| {
            entry.item.command = Set::CpLeCmd(rest);
            entry.item.time = entry.item.time.saturating_sub(time);
        });
        let first = Entry {
            inserted: true,
            ..Entry::new(first, false)
        };
        self.entries.insert(next, first);
        if let Some(group) = &mut self.group {
            // The piece belongs to the group that is being loaded.
            *group += 1;
        }
    }

    /// Relights the laser when the stream resumes within a stretch of the switched laser, which was
    /// switched off while the line was lost.
    pub(super) fn relight(&mut self) {
        let Some(next) = self.next() else { return };
        let Some(entry) = self.entries.get(next).copied() else {
            return;
        };
        if entry.lit && switched_laser_state(&entry.item.command).is_none() {
            let light = build::laser(true);
            self.entries
                .insert(next, Entry::inserted(light, self.last_pose, true));
        }
    }

    /// Ends a path with a segment without power to the same end. Returns how many commands were
    /// added.
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

/// Splits a segment into its first share and the rest. `None` if it is absolute and its start is
/// unknown.
fn split(whole: CpLeCmd, start: Option<[f64; 4]>, share: f64) -> Option<(CpLeCmd, CpLeCmd)> {
    let numbers = [whole.x, whole.y, whole.z];
    if whole.cp_mode == CpMode::Relative {
        let [x, y, z] = numbers.map(|number| (f64::from(number) * share) as f32);
        let piece = CpLeCmd { x, y, z, ..whole };
        let rest = CpLeCmd {
            x: whole.x - x,
            y: whole.y - y,
            z: whole.z - z,
            ..whole
        };
        return Some((piece, rest));
    }
    let [x, y, z, _] = on_the_way(start?, whole, share).map(|number| number as f32);
    // Absolute: the rest still leads to the same end.
    Some((CpLeCmd { x, y, z, ..whole }, whole))
}

/// Pose of the tool after a share of a segment. Its rotation follows the base (model section 8).
fn on_the_way(start: [f64; 4], whole: CpLeCmd, share: f64) -> [f64; 4] {
    let [x0, y0, z0, r0] = start;
    let way = match whole.cp_mode {
        CpMode::Relative => [whole.x, whole.y, whole.z].map(f64::from),
        _ => [
            f64::from(whole.x) - x0,
            f64::from(whole.y) - y0,
            f64::from(whole.z) - z0,
        ],
    };
    let [x, y, z] = [
        x0 + way[0] * share,
        y0 + way[1] * share,
        z0 + way[2] * share,
    ];
    [
        x,
        y,
        z,
        r0 + (libm::atan2(y, x) - libm::atan2(y0, x0)).to_degrees(),
    ]
}
