use magician_protocol::commands::{PtpCmd, PtpWithLCmd, SetEndEffectorLaser};
use magician_protocol::{CpMode, Flag, Set};

use crate::connection::{Micros, Ticket};

/// A command for the queue, with what is known of it beforehand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Item {
    /// What goes into the queue.
    pub command: Set,
    /// How long the arm will be busy with it, us; [`u64::MAX`]: unknown.
    pub time: Micros,
    /// Where the arm stands when it has finished: x, y, z in mm and r in degrees, when that is known.
    pub end: Option<[f64; 4]>,
    /// The laser may be lit during it or when it has ended.
    pub laser: bool,
}

/// How fast an arm is beside the times that a check tells.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ArmPace {
    /// No motion was seen from its beginning to its end.
    #[default]
    Unknown,
    /// As the check says: there is nothing to be seen before the end.
    OnTime,
    /// Faster: a virtual arm.
    Faster,
}

/// When the next command is offered to a stream that has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NextOffer {
    /// At once: its caller is about to tell it.
    #[default]
    AtOnce,
    /// When the arm has finished one more: as many as its caller allows are on their way.
    AfterOne,
    /// Later: its caller has reported that nothing is ready yet.
    Later,
}

/// How a [`Stream`](super::Stream) behaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamSettings {
    /// Most motion in the queue, us.
    pub horizon: Micros,
    /// Most motion in the queue while the laser may be lit, us.
    pub laser_horizon: Micros,
    /// Most segments of a path in flight, as far as the connection's window allows; 1: each waits for the answer to the one
    /// before.
    pub window: usize,
    /// Starts the queue. Otherwise it is left as it is, and only its places limit what is put in.
    pub start: bool,
    /// The queue runs already, and no other program stops it: it is not started again.
    pub running: bool,
    /// How fast the arm is beside the times that are known of its commands.
    pub pace: ArmPace,
    /// How long an answer may take, us, until the stream ends with the request's failure.
    pub patience: Micros,
    /// The laser of a path (`CPLECmd`) is trusted to go out when the path comes to rest (model section 8, from the
    /// sibling arm's code). Otherwise such segments go in chunks too, each ended by a segment of no power to where it
    /// stands.
    pub dark_at_rest: bool,
    /// Resumes although the arm's expected position is unknown.
    pub trust_pose: bool,
}

impl Default for StreamSettings {
    fn default() -> Self {
        Self {
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

/// What became of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// It has not gone out, or is known to have gone nowhere.
    Waiting,
    Flying(Ticket),
    Accepted(u64),
    /// The controller may or may not have taken it.
    Doubtful,
}

/// A command in the stream's care.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    pub(super) item: Item,
    pub(super) fate: Fate,
    /// Absolute, and the same when it is done once more.
    pub(super) repeatable: bool,
    /// The stream put it in by itself, to put the laser out between two chunks and light it again.
    pub(super) inserted: bool,
    /// The laser stays lit after it whatever the arm does.
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

    /// A command of the stream's own: it takes no time and leaves the arm where it is.
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

    pub(super) fn is_flying(&self) -> bool {
        matches!(self.fate, Fate::Flying(_))
    }

    /// Whether it leaves nothing else behind when the line doubles it.
    pub(super) fn bears_doubling(&self) -> bool {
        bears_doubling(&self.item.command) && !self.burns()
    }

    /// Where a dark segment of a path leads: it goes there in a straight line, so it may travel beside others of the same
    /// line.
    pub(super) fn vertex(&self) -> Option<[f64; 3]> {
        vertex(&self.item.command)
    }

    /// Where the arm stands when it has finished, x, y, z.
    pub(super) fn place(&self) -> Option<[f64; 3]> {
        let end = || self.item.end.map(|[x, y, z, _]| [x, y, z]);
        self.vertex().or_else(end)
    }

    /// Whether the laser may be lit by it or during it.
    pub(super) fn burns(&self) -> bool {
        self.item.laser || self.lit || path_power(&self.item.command) != 0.0
    }

    /// Whether a stop of the queue would cut it short instead of letting it end (model section 14).
    pub(super) fn is_cut_by_stop(&self) -> bool {
        matches!(self.item.command, Set::WaitCmd(_) | Set::TrigCmd(_))
    }
}

/// The laser power of a segment, percent; 0 for everything else.
pub(super) fn path_power(command: &Set) -> f32 {
    match command {
        Set::CpLeCmd(segment) => segment.velocity_or_power,
        _ => 0.0,
    }
}

/// What a command makes of the laser that burns whether the arm moves or not.
pub(super) fn switched(command: &Set) -> Option<bool> {
    match command {
        Set::SetEndEffectorLaser(SetEndEffectorLaser { enable_ctrl, on }) => {
            Some(enable_ctrl.is_on() && on.is_on())
        }
        _ => None,
    }
}

/// The command that puts out the laser that burns whether the arm moves or not.
pub(super) fn dark() -> Set {
    Set::SetEndEffectorLaser(SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::OFF,
    })
}

/// Where an absolute segment without laser power leads.
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

/// Whether doing it once more from where it begins or ends leads to the same end and has no other effect: absolute
/// segments without laser power, and absolute point-to-point moves.
fn is_repeatable(command: &Set) -> bool {
    match command {
        Set::CpCmd(_) | Set::CpLeCmd(_) => vertex(command).is_some(),
        Set::PtpCmd(PtpCmd { ptp_mode, .. }) | Set::PtpWithLCmd(PtpWithLCmd { ptp_mode, .. }) => {
            ptp_mode.is_absolute()
        }
        _ => false,
    }
}

/// Whether a second copy right behind the first changes nothing: what is repeatable, and what sets something to a value.
fn bears_doubling(command: &Set) -> bool {
    let row = command.row();
    let sets = row.is_idempotent() && !row.may_burn;
    sets || is_repeatable(command)
}
