use magician_host::build;
use magician_protocol::{MAX_PARAMS, PtpMode, Set, Writer};

use super::{Part, Pause};

/// Which way a point-to-point move goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Travel {
    /// All joints together; the tool's way is a curve (MOVJ).
    #[default]
    Joints,
    /// On a straight line (MOVL).
    Line,
    /// Up, across, down (JUMP).
    Jump,
}

impl Travel {
    /// The one after it, and the first after the last: what a control goes through that chooses one.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Joints => Self::Line,
            Self::Line => Self::Jump,
            Self::Jump => Self::Joints,
        }
    }

    /// The command that goes to a pose in this way: x, y, z, r.
    #[must_use]
    pub fn to_pose(self, to: [f32; 4]) -> Set {
        ptp(self, [build::move_to, build::line_to, build::jump_to], to)
    }

    /// The command that goes to joint angles in this way: J1 to J4.
    #[must_use]
    pub fn to_joints(self, to: [f32; 4]) -> Set {
        let words = [build::move_joints, build::line_joints, build::jump_joints];
        ptp(self, words, to)
    }
}

/// What a gripper does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Grip {
    /// Its pump is off.
    Off,
    /// It lets go.
    Open,
    /// It holds.
    Close,
}

/// What is done in one step. An action is one command of the protocol, or none: a [`Part`](Self::Part) and a [`Pause`](Self::Pause) send
/// nothing. Commands that people say often have names of their own, all others are an [`Action::Command`]. A command has one action,
/// `Action::from(command)`, which gives it back to the last bit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Action {
    /// Goes to a pose: x, y, z, r.
    Move {
        /// Where.
        to: [f32; 4],
        /// Which way.
        by: Travel,
    },
    /// Goes to joint angles J1 to J4.
    Joints {
        /// Where.
        to: [f32; 4],
        /// Which way.
        by: Travel,
    },
    /// Goes by so much in x, y, z, r from where the arm then is. A jump cannot: it goes by its joints.
    Shift {
        /// How far.
        by: [f32; 4],
        /// On a straight line; with all joints together if not.
        line: bool,
    },
    /// Goes through one pose to another on an arc of a circle.
    Arc {
        /// A pose on the way.
        via: [f32; 4],
        /// Where it ends.
        to: [f32; 4],
    },
    /// A segment of a continuous path, straight to x, y, z.
    Path {
        /// Where it ends.
        to: [f32; 3],
    },
    /// A segment of a continuous path with the laser at a power.
    Burn {
        /// Where it ends.
        to: [f32; 3],
        /// Percent, 0 to 100.
        power: f32,
    },
    /// Switches the suction cup.
    Suction(bool),
    /// Has the gripper do something.
    Gripper(Grip),
    /// Switches the laser.
    Laser(bool),
    /// Waits so many ms.
    Wait(u32),
    /// Finds the reference and goes to the home point.
    Home,
    /// Anything else that can be queued: speeds, pins, sensors, the rail, motors.
    Command(Box<Set>),
    /// A part of the work begins; nothing is sent.
    Part(Box<Part>),
    /// The job waits for a person; nothing is sent.
    Pause(Box<Pause>),
}

impl Action {
    /// What each kind is called, in the order in which people are told.
    pub const NAMES: [&'static str; 14] = [
        "move", "joints", "shift", "arc", "path", "burn", "suction", "gripper", "laser", "wait",
        "home", "command", "part", "pause",
    ];

    /// What its kind is called: one of [`NAMES`](Self::NAMES), and its key in a plan file.
    #[must_use]
    pub fn name(&self) -> &'static str {
        Self::NAMES.get(self.kind()).copied().unwrap_or("command")
    }

    /// Index of its name in [`NAMES`](Self::NAMES).
    #[must_use]
    pub fn kind(&self) -> usize {
        match self {
            Self::Move { .. } => 0,
            Self::Joints { .. } => 1,
            Self::Shift { .. } => 2,
            Self::Arc { .. } => 3,
            Self::Path { .. } => 4,
            Self::Burn { .. } => 5,
            Self::Suction(_) => 6,
            Self::Gripper(_) => 7,
            Self::Laser(_) => 8,
            Self::Wait(_) => 9,
            Self::Home => 10,
            Self::Command(_) => 11,
            Self::Part(_) => 12,
            Self::Pause(_) => 13,
        }
    }

    /// The command that does it; none where nothing is sent.
    #[must_use]
    pub fn command(&self) -> Option<Set> {
        Some(match *self {
            Self::Move { to, by } => by.to_pose(to),
            Self::Joints { to, by } => by.to_joints(to),
            Self::Shift { by, line: false } => each(build::move_by, by),
            Self::Shift { by, line: true } => each(build::line_by, by),
            Self::Arc { via, to } => build::arc_to(via, to),
            Self::Path { to: [x, y, z] } => build::path_to(x, y, z),
            Self::Burn {
                to: [x, y, z],
                power,
            } => build::engrave_to(x, y, z, power),
            Self::Suction(on) => build::suction(on),
            Self::Gripper(Grip::Off) => build::pump_off(),
            Self::Gripper(Grip::Open) => build::release(),
            Self::Gripper(Grip::Close) => build::grip(),
            Self::Laser(on) => build::laser(on),
            Self::Wait(milliseconds) => {
                build::wait(std::time::Duration::from_millis(milliseconds.into()))
            }
            Self::Home => build::home(),
            Self::Command(ref command) => **command,
            Self::Part(_) | Self::Pause(_) => return None,
        })
    }

    /// Whether nothing is sent for it.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Part(_) | Self::Pause(_))
    }

    /// Whether it draws or burns a line: a segment of a path, a burn, an arc.
    #[must_use]
    pub fn marks(&self) -> bool {
        matches!(
            self,
            Self::Path { .. } | Self::Burn { .. } | Self::Arc { .. }
        )
    }

    /// True if it switches a laser or sets its power.
    #[must_use]
    pub fn is_of_a_laser(&self) -> bool {
        match self {
            Self::Burn { .. } | Self::Laser(_) => true,
            Self::Command(command) => {
                matches!(**command, Set::SetEndEffectorLaser(_) | Set::CpLeCmd(_))
            }
            _ => false,
        }
    }

    /// Whether it may light the laser, or burns with it.
    pub(crate) fn burns(&self) -> bool {
        match self {
            Self::Burn { power, .. } => *power > 0.0,
            Self::Laser(on) => *on,
            Self::Command(command) => match &**command {
                Set::SetEndEffectorLaser(laser) => laser.on.is_on(),
                Set::CpLeCmd(segment) => segment.velocity_or_power > 0.0,
                _ => false,
            },
            _ => false,
        }
    }

    /// Where it leads the tool, when it says so itself: x, y, z.
    #[must_use]
    pub fn target(&self) -> Option<[f32; 3]> {
        match *self {
            Self::Move {
                to: [x, y, z, _], ..
            }
            | Self::Arc {
                to: [x, y, z, _], ..
            } => Some([x, y, z]),
            Self::Path { to } | Self::Burn { to, .. } => Some(to),
            _ => None,
        }
    }
}

/// A word that takes x, y, z, r or four joint angles.
type Word = fn(f32, f32, f32, f32) -> Set;

fn ptp(by: Travel, words: [Word; 3], to: [f32; 4]) -> Set {
    let [joints, line, jump] = words;
    match by {
        Travel::Joints => each(joints, to),
        Travel::Line => each(line, to),
        Travel::Jump => each(jump, to),
    }
}

fn each(word: Word, [a, b, c, d]: [f32; 4]) -> Set {
    word(a, b, c, d)
}

impl From<Set> for Action {
    fn from(command: Set) -> Self {
        let action = named(&command);
        // What a name does not say in full stays a command.
        match action {
            Some(action)
                if action
                    .command()
                    .is_some_and(|named| is_same(&named, &command)) =>
            {
                action
            }
            _ => Self::Command(Box::new(command)),
        }
    }
}

/// Whether two commands are equal and look the same on the wire, where -0 is not 0. NaN equals nothing.
fn is_same(one: &Set, other: &Set) -> bool {
    let bytes = |command: &Set| {
        let mut room = [0; MAX_PARAMS];
        let mut writer = Writer::new(&mut room);
        command.encode(&mut writer);
        writer.finish().map(|count| (count, room))
    };
    one == other && bytes(one) == bytes(other)
}

fn named(command: &Set) -> Option<Action> {
    Some(match command {
        Set::PtpCmd(ptp) => {
            let (to, line) = ([ptp.x, ptp.y, ptp.z, ptp.r], Travel::Line);
            match ptp.ptp_mode {
                PtpMode::MovjXyz => Action::Move {
                    to,
                    by: Travel::Joints,
                },
                PtpMode::MovlXyz => Action::Move { to, by: line },
                PtpMode::JumpXyz => Action::Move {
                    to,
                    by: Travel::Jump,
                },
                PtpMode::MovjAngle => Action::Joints {
                    to,
                    by: Travel::Joints,
                },
                PtpMode::MovlAngle => Action::Joints { to, by: line },
                PtpMode::JumpAngle => Action::Joints {
                    to,
                    by: Travel::Jump,
                },
                PtpMode::MovjXyzInc => Action::Shift {
                    by: to,
                    line: false,
                },
                PtpMode::MovlXyzInc => Action::Shift { by: to, line: true },
                _ => return None,
            }
        }
        Set::ArcCmd(arc) => Action::Arc {
            via: arc.cir_point,
            to: arc.to_point,
        },
        Set::CpCmd(cp) => Action::Path {
            to: [cp.x, cp.y, cp.z],
        },
        Set::CpLeCmd(cp) => Action::Burn {
            to: [cp.x, cp.y, cp.z],
            power: cp.velocity_or_power,
        },
        Set::SetEndEffectorSuctionCup(cup) => Action::Suction(cup.suck.is_on()),
        Set::SetEndEffectorGripper(gripper) => {
            Action::Gripper(match (gripper.enable_ctrl.is_on(), gripper.grip.is_on()) {
                (false, _) => Grip::Off,
                (true, false) => Grip::Open,
                (true, true) => Grip::Close,
            })
        }
        Set::SetEndEffectorLaser(laser) => Action::Laser(laser.on.is_on()),
        Set::WaitCmd(wait) => Action::Wait(wait.timeout),
        Set::HomeCmd(_) => Action::Home,
        _ => return None,
    })
}
