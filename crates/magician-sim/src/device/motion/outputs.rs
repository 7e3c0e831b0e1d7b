//! Outputs that a move switches on its way (document 1.10.9, model section 7).

use magician_motion::Trajectory;
use magician_protocol::{PoCmd, PoList};

use super::RailPath;
use crate::Micros;

/// Paths of arm and carriage in one motion.
type Trajectories<'a> = (&'a Trajectory, &'a RailPath);

/// Outputs of one move, and which of them have been switched.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outputs {
    list: PoList,
    /// Bit set of entries.
    switched: u64,
    /// Next entry and its time from the start of the move.
    next: Option<(Micros, usize)>,
}

// `switched` has a bit for each entry.
const _: () = assert!(PoList::CAPACITY <= u64::BITS as usize);

impl Outputs {
    /// Creates the outputs of a move. Each is due when its share of the path is done.
    ///
    /// An output beyond a limit that ends the move is never switched. If only the carriage moves,
    /// its path counts.
    pub(crate) fn new(list: PoList, way: Trajectories<'_>) -> Self {
        let mut outputs = Self {
            list,
            switched: 0,
            next: None,
        };
        outputs.look_ahead(way);
        outputs
    }

    /// Time of the next output, from the start of the move.
    pub(crate) fn next_due(&self) -> Option<Micros> {
        self.next.map(|(at, _)| at)
    }

    /// Returns the next output that is due, and marks it as switched.
    pub(crate) fn take_due(&mut self, elapsed: Micros, way: Trajectories<'_>) -> Option<PoCmd> {
        let (_, entry) = self.next.filter(|(at, _)| *at <= elapsed)?;
        self.switched |= 1 << entry;
        self.look_ahead(way);
        self.list.as_slice().get(entry).copied()
    }

    fn look_ahead(&mut self, (arm, rail): Trajectories<'_>) {
        let entries = self.list.as_slice().iter().enumerate();
        self.next = entries
            .filter(|(entry, _)| self.switched & (1 << entry) == 0)
            .filter_map(|(entry, output)| {
                // A ratio above 100 is clamped to the end of the path by `time_at_progress`.
                let share = f64::from(output.ratio) / 100.0;
                let due = if arm.duration_us() == 0 && rail.duration() > 0 {
                    rail.time_at_progress(share)
                } else {
                    arm.time_at_progress(share)
                };
                Some((due?, entry))
            })
            .min();
    }
}
