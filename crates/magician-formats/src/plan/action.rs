//! Actions of a plan and their translation to and from commands of the protocol.

use magician_host::build;
use magician_protocol::{MAX_PARAMS, PtpMode, Set, Writer};

use super::{Part, Pause};

/// Path shape of a point-to-point move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Travel {
    /// All joints move together; the tool follows a curve (MOVJ).
    #[default]
    Joints,
    /// The tool follows a straight line (MOVL).
    Line,
    /// Up, across, down (JUMP).
    Jump,
}

impl Travel {
    /// Returns the next variant, wrapping round. For controls that cycle through them.
    #[must_use]
    pub const fn next(self) -> Self {
        match self {
            Self::Joints => Self::Line,
            Self::Line => Self::Jump,
            Self::Jump => Self::Joints,
        }
    }

    /// Returns the command that moves to a pose x, y, z, r.
    #[must_use]
    pub fn to_pose(self, to: [f32; 4]) -> Set {
        ptp(self, [build::move_to, build::line_to, build::jump_to], to)
    }

    /// Returns the command that moves to joint angles J1 to J4.
    #[must_use]
    pub fn to_joints(self, to: [f32; 4]) -> Set {
        let builders = [build::move_joints, build::line_joints, build::jump_joints];
        ptp(self, builders, to)
    }
}

/// State of a gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Grip {
    /// Pump off.
    Off,
    /// Open.
    Open,
    /// Closed.
    Close,
}

/// Action of one step: one command of the protocol, or none.
///
/// [`Part`](Self::Part) and [`Pause`](Self::Pause) send nothing. Frequent commands have variants of
/// their own; all others are an [`Action::Command`]. `Action::from(command)` maps each command to
/// exactly one action, which returns the command bit for bit.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(not(magician_workspace), non_exhaustive)]
pub enum Action {
    /// Move to a pose x, y, z, r.
    Move {
        /// Target.
        to: [f32; 4],
        /// Path shape.
        by: Travel,
    },
    /// Move to joint angles J1 to J4.
    Joints {
        /// Target.
        to: [f32; 4],
        /// Path shape.
        by: Travel,
    },
    /// Move relative to the current position by x, y, z, r. The protocol has no relative jump.
    Shift {
        /// Distance.
        by: [f32; 4],
        /// True for a straight line, false for all joints together.
        line: bool,
    },
    /// Move along an arc of a circle through one pose to another.
    Arc {
        /// A pose on the arc.
        via: [f32; 4],
        /// End of the arc.
        to: [f32; 4],
    },
    /// Segment of a continuous path, straight to x, y, z.
    Path {
        /// End.
        to: [f32; 3],
    },
    /// Segment of a continuous path with laser power.
    Burn {
        /// End.
        to: [f32; 3],
        /// Power, percent, 0 to 100.
        power: f32,
    },
    /// Suction cup on or off.
    Suction(bool),
    /// Gripper state.
    Gripper(Grip),
    /// Laser on or off.
    Laser(bool),
    /// Wait, ms.
    Wait(u32),
    /// Home: find the reference, then move to the home point.
    Home,
    /// Any other command that can be queued: speeds, pins, sensors, the rail, motors.
    Command(Box<Set>),
    /// Start of a part of the work. Nothing is sent.
    Part(Box<Part>),
    /// Pause until a person continues the job. Nothing is sent.
    Pause(Box<Pause>),
}

impl Action {
    /// Names of the kinds, in the order in which users see them.
    pub const NAMES: [&'static str; 14] = [
        "move", "joints", "shift", "arc", "path", "burn", "suction", "gripper", "laser", "wait",
        "home", "command", "part", "pause",
    ];

    /// Name of the kind, which is also its key in a plan file: one of [`NAMES`](Self::NAMES).
    #[must_use]
    pub fn name(&self) -> &'static str {
        Self::NAMES.get(self.kind()).copied().unwrap_or("command")
    }

    /// Index of the kind in [`NAMES`](Self::NAMES).
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

    /// Returns the command of the action, or `None` if nothing is sent.
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

    /// True if nothing is sent.
    #[must_use]
    pub fn is_silent(&self) -> bool {
        matches!(self, Self::Part(_) | Self::Pause(_))
    }

    /// True if it draws or burns a line: a path segment, a burn, an arc.
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

    /// True if it may light the laser or burns with it.
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

    /// Returns the position x, y, z that it names explicitly. `None` for all other actions,
    /// including relative moves and moves to joint angles.
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

/// Builder of a command from x, y, z, r or from four joint angles.
type CommandBuilder = fn(f32, f32, f32, f32) -> Set;

fn ptp(by: Travel, builders: [CommandBuilder; 3], to: [f32; 4]) -> Set {
    let [joints, line, jump] = builders;
    match by {
        Travel::Joints => each(joints, to),
        Travel::Line => each(line, to),
        Travel::Jump => each(jump, to),
    }
}

fn each(builder: CommandBuilder, [a, b, c, d]: [f32; 4]) -> Set {
    builder(a, b, c, d)
}

impl From<Set> for Action {
    fn from(command: Set) -> Self {
        let action = named(&command);
        // If the variant does not reproduce the command exactly (unused fields set, -0), keep the
        // command.
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

/// True if two commands are equal and have the same bytes. -0 differs from 0, and NaN equals
/// nothing.
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
                // Joint increments and jumps with a straight line have no action of their own.
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
        // All other commands keep their own form.
        _ => return None,
    })
}
