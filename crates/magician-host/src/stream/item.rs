//! Commands of a stream: what the caller offers, and what the stream knows of each.

use magician_protocol::commands::{PtpCmd, PtpWithLCmd, SetEndEffectorLaser};
use magician_protocol::{CpMode, Flag, Set};

use crate::connection::{Micros, Ticket};

/// A command for the queue, with what is known of it in advance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// Command to queue.
    pub command: Set,
    /// Time that the arm takes for it, us. [`u64::MAX`] if unknown.
    pub time: Micros,
    /// Pose of the arm after it: x, y, z in mm and r in degrees. `None` if unknown.
    pub end: Option<[f64; 4]>,
    /// True if the laser may be lit during or after it.
    pub laser: bool,
}

/// Speed of an arm relative to the times of a check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArmPace {
    /// No motion was observed from beginning to end yet.
    #[default]
    Unknown,
    /// Same as checked: reading before the calculated end shows nothing new.
    OnTime,
    /// Faster than checked: a virtual arm.
    Faster,
}

/// Time at which the next command is offered to a stream that has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NextOffer {
    /// At once: the caller is about to offer it.
    #[default]
    AtOnce,
    /// When the arm has finished another command: the caller limits how many are on their way.
    AfterOne,
    /// Later: the caller reported that none is ready yet.
    Later,
}

/// Settings of a [`Stream`](super::Stream).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamSettings {
    /// Largest total time of the commands in the queue, us.
    pub horizon: Micros,
    /// Largest total time of the commands in the queue while the laser may be lit, us.
    pub laser_horizon: Micros,
    /// Largest number of segments of a path in flight, within the connection's window. 1: each
    /// waits for the reply to the previous one.
    pub window: usize,
    /// True if the stream starts the queue. Otherwise the queue is left as it is, and only its
    /// places limit what is put in.
    pub start: bool,
    /// True if the queue runs already and no other program stops it; it is then not started again.
    pub running: bool,
    /// Speed of the arm relative to the known times of its commands.
    pub pace: ArmPace,
    /// Longest time for an answer, us. The stream then ends with the failure of the request.
    pub patience: Micros,
    /// True if the laser of a path (`CPLECmd`) is trusted to go out when the path comes to rest
    /// (model section 8, from the sibling arm's code).
    ///
    /// Otherwise such segments go in chunks too, each ended by a segment without power to the same
    /// position.
    pub dark_at_rest: bool,
    /// True to resume although the arm's expected pose is unknown.
    pub trust_pose: bool,
}

impl Default for StreamSettings {
    fn default() -> Self {
        Self {
            // Choices: two seconds of motion bridge a hold-up of the host, and a laser may burn on
            // for only half of that if the host dies.
            horizon: 2_000_000,
            laser_horizon: 1_000_000,
            window: 1,
            start: true,
            running: false,
            pace: ArmPace::Unknown,
            patience: 5_000_000,
            dark_at_rest: true,
            trust_pose: false,
        }
    }
}

/// Fate of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// Not sent, or known to have had no effect.
    Waiting,
    InFlight(Ticket),
    Accepted(u64),
    /// The controller may or may not have taken it.
    Doubtful,
}

/// A command of the stream.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) item: Item,
    pub(super) fate: Fate,
    /// True if it is absolute and has the same result when repeated.
    pub(super) repeatable: bool,
    /// True if the stream inserted it: a command that switches the laser off or on, the dark end of
    /// a path, a piece of a cut segment, or the copy of a duplicated command.
    pub(super) inserted: bool,
    /// True if the switched laser stays lit after it, whatever the arm does.
    pub(super) lit: bool,
}

impl Entry {
    pub(super) fn new(item: Item, lit: bool) -> Self {
        Self {
            item,
            fate: Fate::Waiting,
            repeatable: is_repeatable(&item.command),
            inserted: false,
            lit,
        }
    }

    /// Creates an inserted command, which takes no time and does not move the arm.
    pub(super) fn inserted(command: Set, end: Option<[f64; 4]>, lit: bool) -> Self {
        let item = Item {
            command,
            time: 0,
            end,
            laser: lit,
        };
        Self {
            inserted: true,
            ..Self::new(item, lit)
        }
    }

    pub(super) fn index(&self) -> Option<u64> {
        match self.fate {
            Fate::Accepted(index) => Some(index),
            _ => None,
        }
    }

    pub(super) fn is_waiting(&self) -> bool {
        self.fate == Fate::Waiting
    }

    pub(super) fn is_in_flight(&self) -> bool {
        matches!(self.fate, Fate::InFlight(_))
    }

    /// True if a second copy, made by the line, changes nothing.
    pub(super) fn tolerates_duplicate(&self) -> bool {
        tolerates_duplicate(&self.item.command) && !self.burns()
    }

    /// Target of a dark segment of a path. The arm goes there in a straight line, so the segment
    /// may be in flight beside others of the same line. `None` for all other commands.
    pub(super) fn vertex(&self) -> Option<[f64; 3]> {
        vertex(&self.item.command)
    }

    /// Position of the arm after it, x, y, z in mm. `None` if unknown.
    pub(super) fn place(&self) -> Option<[f64; 3]> {
        let end = || self.item.end.map(|[x, y, z, _]| [x, y, z]);
        self.vertex().or_else(end)
    }

    /// True if the laser may be lit by it or during it.
    pub(super) fn burns(&self) -> bool {
        self.item.laser || self.lit || path_power(&self.item.command) != 0.0
    }

    /// True if a stop of the queue cuts it short instead of letting it end (model section 14).
    pub(super) fn is_cut_by_stop(&self) -> bool {
        matches!(self.item.command, Set::WaitCmd(_) | Set::TrigCmd(_))
    }
}

/// Laser power of a segment, percent; 0 for all other commands.
pub(super) fn path_power(command: &Set) -> f32 {
    match command {
        Set::CpLeCmd(segment) => segment.velocity_or_power,
        _ => 0.0,
    }
}

/// New state of the switched laser, which burns whether the arm moves or not. `None` if the command
/// does not switch it.
pub(super) fn switched_laser_state(command: &Set) -> Option<bool> {
    match command {
        Set::SetEndEffectorLaser(SetEndEffectorLaser { enable_ctrl, on }) => {
            Some(enable_ctrl.is_on() && on.is_on())
        }
        _ => None,
    }
}

/// Command that switches the switched laser off.
pub(super) fn laser_off() -> Set {
    Set::SetEndEffectorLaser(SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::OFF,
    })
}

/// Target of an absolute segment without laser power. `None` for all other commands.
fn vertex(command: &Set) -> Option<[f64; 3]> {
    let place = match command {
        Set::CpCmd(to) if to.cp_mode == CpMode::Absolute => [to.x, to.y, to.z],
        Set::CpLeCmd(to) if to.cp_mode == CpMode::Absolute && to.velocity_or_power == 0.0 => {
            [to.x, to.y, to.z]
        }
        _ => return None,
    };
    Some(place.map(f64::from))
}

/// True if repeating the command, from its start or its end, leads to the same end and has no other
/// effect: absolute segments without laser power and absolute point-to-point moves.
fn is_repeatable(command: &Set) -> bool {
    match command {
        Set::CpCmd(_) | Set::CpLeCmd(_) => vertex(command).is_some(),
        Set::PtpCmd(PtpCmd { ptp_mode, .. }) | Set::PtpWithLCmd(PtpWithLCmd { ptp_mode, .. }) => {
            ptp_mode.is_absolute()
        }
        _ => false,
    }
}

/// True if an immediate second copy changes nothing: repeatable commands, and idempotent commands
/// that cannot burn.
fn tolerates_duplicate(command: &Set) -> bool {
    let row = command.row();
    let sets = row.is_idempotent() && !row.may_burn;
    sets || is_repeatable(command)
}
