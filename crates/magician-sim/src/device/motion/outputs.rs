//! Outputs that a move switches on its way (document 1.10.9, model section 7).

use magician_motion::Trajectory;
use magician_protocol::{PoCmd, PoList};

use super::RailPath;
use crate::Micros;

/// The ways of arm and carriage that make one motion.
type Trajectories<'a> = (&'a Trajectory, &'a RailPath);

/// The outputs of one move, and which of them have been switched.
#[derive(Clone, Debug, Default)]
pub(crate) struct Outputs {
    list: PoList,
    /// A bit for each entry.
    switched: u64,
    /// The next entry and when it is due, from the start of the move.
    next: Option<(Micros, usize)>,
}

const _: () = assert!(PoList::CAPACITY <= u64::BITS as usize);

impl Outputs {
    /// The outputs of a move, each due when its share of the path is done. One that the move never
    /// gets to, because a limit ends it before, is never switched. Where the arm rests the path is
    /// the carriage's.
    pub(crate) fn new(list: PoList, way: Trajectories<'_>) -> Self {
        let mut outputs = Self {
            list,
            switched: 0,
            next: None,
        };
        outputs.look_ahead(way);
        outputs
    }

    /// When the next one is due, from the start of the move.
    pub(crate) fn next_due(&self) -> Option<Micros> {
        self.next.map(|(at, _)| at)
    }

    /// The next one that is due by then; it counts as switched.
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
