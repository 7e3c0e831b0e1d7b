//! Tool, suction cup, gripper and speed, from the commands that the arm has executed.

use std::fmt;

use magician_protocol::commands::{
    EndEffectorGripper, EndEffectorParams, EndEffectorSuctionCup, PtpCommonParams,
};
use magician_protocol::{Flag, Frame, Readable, Row, Set, Writable};

use crate::preflight::check_numbers;

/// Outputs as set last. A field is `None` if it is not known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ArmOutputs {
    /// Tool tip relative to the flange, mm.
    pub tool: Option<[f32; 3]>,
    /// True if the laser may burn, false if it is certainly off.
    pub laser: Option<bool>,
    /// True if the suction cup is on.
    pub suction: Option<bool>,
    /// State of the gripper.
    pub gripper: Option<GripperState>,
    /// True if suction cup and gripper are both switched on and it is unknown which of them has the
    /// pump.
    pub pump_is_contested: bool,
    /// Velocity ratio of point-to-point moves, percent.
    pub speed: Option<f32>,
}

/// State of the gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum GripperState {
    /// Open, with the pump running.
    Open,
    /// Closed.
    Closed,
    /// Pump off.
    Off,
}

impl GripperState {
    /// Name in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Closed => "closed",
            Self::Off => "off",
        }
    }
}

impl fmt::Display for GripperState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The two flags of a pneumatic tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct AirSwitch {
    enabled: bool,
    on: bool,
}

impl AirSwitch {
    fn new(enabled: Flag, on: Flag) -> Self {
        Self {
            enabled: enabled.is_on(),
            on: on.is_on(),
        }
    }

    fn grips(self) -> GripperState {
        match (self.enabled, self.on) {
            (false, _) => GripperState::Off,
            (true, false) => GripperState::Open,
            (true, true) => GripperState::Closed,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AirTool {
    Suction,
    Gripper,
}

/// Tracks the fields of [`ArmOutputs`].
#[derive(Clone, Debug, Default)]
pub(super) struct ToolPicture {
    bias: Option<[f32; 3]>,
    speed: Option<f32>,
    suction: Option<AirSwitch>,
    gripper: Option<AirSwitch>,
    /// Tool that has the pump: the one whose command came last (model section 13). The arm does not
    /// report it.
    air: Option<AirTool>,
}

impl ToolPicture {
    /// Notes that the arm has executed this command.
    pub(super) fn set(&mut self, row: &Row, request: &Frame<'_>) {
        let command = Set::decode(row.id, request.params());
        // The arm may clamp or refuse other numbers.
        match command.ok().filter(|set| check_numbers(set).is_ok()) {
            Some(Set::EndEffectorParams(bias)) => self.bias = Some(tip(&bias)),
            Some(Set::PtpCommonParams(speed)) => self.speed = Some(speed.velocity_ratio),
            Some(Set::SetEndEffectorSuctionCup(cup)) => {
                self.suction = Some(AirSwitch::new(cup.enable_ctrl, cup.suck));
                self.air = Some(AirTool::Suction);
            }
            Some(Set::SetEndEffectorGripper(gripper)) => {
                self.gripper = Some(AirSwitch::new(gripper.enable_ctrl, gripper.grip));
                self.air = Some(AirTool::Gripper);
            }
            Some(_) => {}
            // Malformed, or numbers that an arm may refuse: its effect is unknown.
            None => {
                self.doubt(row);
            }
        }
    }

    /// Processes the reply to a get.
    pub(super) fn read(&mut self, reply: &Frame<'_>) {
        match reply.id() {
            id if id == <EndEffectorParams as Readable>::ROW.id => {
                self.bias = reply.read().ok().map(|bias| tip(&bias));
            }
            id if id == <PtpCommonParams as Readable>::ROW.id => {
                let speed = reply.read::<PtpCommonParams>().ok();
                self.speed = speed.map(|speed| speed.velocity_ratio);
            }
            id if id == <EndEffectorSuctionCup as Readable>::ROW.id => {
                let cup = reply.read::<EndEffectorSuctionCup>().ok();
                let cup = cup.map(|cup| AirSwitch::new(cup.is_ctrl_enabled, cup.is_sucked));
                if self.suction.is_some() && self.suction != cup {
                    // Another program has switched the suction cup since, so it has the pump now.
                    self.air = Some(AirTool::Suction);
                }
                self.suction = cup;
            }
            id if id == <EndEffectorGripper as Readable>::ROW.id => {
                let gripper = reply.read::<EndEffectorGripper>().ok();
                let gripper = gripper
                    .map(|gripper| AirSwitch::new(gripper.is_ctrl_enabled, gripper.is_gripped));
                if self.gripper.is_some() && self.gripper != gripper {
                    self.air = Some(AirTool::Gripper);
                }
                self.gripper = gripper;
            }
            _ => {}
        }
    }

    /// Notes that a command of this row may or may not have been executed. True if something was
    /// known.
    pub(super) fn doubt(&mut self, row: &Row) -> bool {
        match row.id {
            id if id == <EndEffectorParams as Writable>::ROW.id => self.bias.take().is_some(),
            id if id == <PtpCommonParams as Writable>::ROW.id => self.speed.take().is_some(),
            id if id == <EndEffectorSuctionCup as Readable>::ROW.id
                || id == <EndEffectorGripper as Readable>::ROW.id =>
            {
                // One pump serves both, so a doubt about one is a doubt about both.
                let known = self.suction.is_some() || self.gripper.is_some();
                (self.suction, self.gripper, self.air) = (None, None, None);
                known
            }
            _ => false,
        }
    }

    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    pub(super) fn outputs(&self, laser: Option<bool>) -> ArmOutputs {
        ArmOutputs {
            tool: self.bias,
            laser,
            suction: self.is_sucking(),
            gripper: self.grips(),
            pump_is_contested: self.is_contested(),
            speed: self.speed,
        }
    }

    fn is_sucking(&self) -> Option<bool> {
        // The pump serves one tool at a time, so with the gripper's command last the cup does not
        // suck.
        if self.air == Some(AirTool::Gripper) {
            return Some(false);
        }
        let cup = self.suction?;
        let sucks = cup.enabled && cup.on;
        (!sucks || !self.is_contested()).then_some(sucks)
    }

    fn grips(&self) -> Option<GripperState> {
        if self.air == Some(AirTool::Suction) {
            return Some(GripperState::Off);
        }
        let gripper = self.gripper?;
        (!self.is_contested()).then(|| gripper.grips())
    }

    /// True if both are switched on and it is unknown which has the pump.
    fn is_contested(&self) -> bool {
        let is_enabled = |tool: Option<AirSwitch>| tool.is_some_and(|tool| tool.enabled);
        self.air.is_none() && is_enabled(self.suction) && is_enabled(self.gripper)
    }
}

fn tip(bias: &EndEffectorParams) -> [f32; 3] {
    [bias.x_bias, bias.y_bias, bias.z_bias]
}
