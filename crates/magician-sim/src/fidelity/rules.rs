//! What a request rests on, as far as it shows when it is taken up. What shows only later says so where it is decided.
//!
//! Every row has its line here: a new one that has none does not compile.

use magician_motion::Ceilings;
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Get, JogCommand, PtpMode, Readable, Request, Set};

use super::{Assumption, AssumptionSet};
use crate::device::context::Context;
use crate::device::effect::ExecMode;
use crate::device::queue::Busy;
use crate::device::store::flash::Flash;

/// The pins of laser, valve and pump.
const TOOL_PINS: [u8; 4] = [2, 4, 16, 17];

impl Context<'_> {
    /// Whether a frame is taken for what it asks.
    pub(crate) fn allows_frame(&mut self, id: u8, ctrl: Ctrl, request: &Request) -> bool {
        let mut assumptions = AssumptionSet::default();
        let elsewhere = ctrl.destination() != 0 || ctrl.slave() != 0;
        assumptions.add_if(elsewhere, Assumption::DestinationBits);
        match request {
            Request::Get(_) => assumptions.add_if(ctrl.write(), Assumption::GetOnlyWritten),
            Request::Set(_) => assumptions.add_if(ctrl.queued(), Assumption::SteeringQueued),
            Request::Queue(_) => assumptions.add_if(!ctrl.write(), Assumption::QueuedBitAlone),
            Request::Nothing => assumptions.add(Assumption::SetOnlyRead),
        }
        self.record.allows_all(id, assumptions)
    }

    /// Whether a value is reported.
    pub(crate) fn allows_report(&mut self, id: u8, get: &Get) -> bool {
        let assumptions = self.assumptions_of_get(get);
        self.record.allows_all(id, assumptions)
    }

    /// Whether a command is carried out.
    pub(crate) fn allows_apply(&mut self, set: &Set, mode: ExecMode) -> bool {
        let assumptions = self.assumptions_of_set(set, mode);
        self.record.allows_all(set.row().id, assumptions)
    }

    /// Whether a command of the queue is given an index.
    pub(crate) fn count_index_assumptions(&mut self) {
        self.record.assume(Assumption::Indices);
        if self.hosts().is_unused() {
            self.record.assume(Assumption::FirstIndex);
        }
    }

    fn assumptions_of_get(&mut self, get: &Get) -> AssumptionSet {
        let mut assumptions = AssumptionSet::default();
        assumptions.add(self.assumption_of_value(get));
        match get {
            Get::Pose(_) => {
                assumptions.add_if(!self.motion.is_homed(), Assumption::BaseUnknown);
                assumptions.add_if(!self.motion.is_homed(), Assumption::PowerUpPose);
                let EndEffectorParams {
                    x_bias,
                    y_bias,
                    z_bias,
                } = self.store.settings.bias;
                assumptions.add_if([x_bias, y_bias, z_bias] != [0.0; 3], Assumption::ToolBias);
                assumptions.add_if(self.has_tool_of_power_up(), Assumption::PowerUpTool);
            }
            Get::EndEffectorParams(_) => {
                assumptions.add_if(self.has_tool_of_power_up(), Assumption::PowerUpTool);
            }
            Get::HomeParams(_) => {
                let unset = self.store.settings.home.is_none();
                assumptions.add_if(
                    unset && self.has_tool_of_power_up(),
                    Assumption::PowerUpTool,
                );
            }
            Get::HhtTrigOutput(_) => {
                assumptions.add_if(self.has_new_point(), Assumption::PointCleared)
            }
            Get::IoDi(GetIoDi { address }) | Get::IoAdc(GetIoAdc { address }) => {
                assumptions.add_if(address.is_none(), Assumption::LastPin);
                let open = address.is_some_and(|address| self.is_open(address));
                assumptions.add_if(open, Assumption::OpenInput);
            }
            Get::IoMultiplexing(GetIoMultiplexing { address })
            | Get::IoDo(GetIoDo { address })
            | Get::IoPwm(GetIoPwm { address }) => {
                assumptions.add_if(address.is_none(), Assumption::LastPin)
            }
            Get::IrSwitch(GetIrSwitch { port }) => {
                assumptions.add_if(port.is_none(), Assumption::InfraredPort);
            }
            Get::QueuedCmdCurrentIndex(_) => {
                let hosts = self.hosts();
                let unused = hosts.current() == 0 && hosts.running().is_none();
                assumptions.add_if(unused, Assumption::CurrentAtFirst);
            }
            Get::QueuedCmdLeftSpace(_) => {
                assumptions.add_if(self.hosts().running().is_some(), Assumption::RunningPlace);
            }
            _ => {}
        }
        assumptions
    }

    /// What the value of a row rests on, whatever else.
    fn assumption_of_value(&self, get: &Get) -> Assumption {
        use Get::*;
        match get {
            DeviceSn(_) | DeviceName(_) => Assumption::Identity,
            DeviceVersion(_) => Assumption::Version,
            DeviceWithL(_) => Assumption::RailSwitch,
            DeviceTime(_) => Assumption::Clock,
            DeviceId(_) => Assumption::DeviceIdWords,
            Pose(_) => Assumption::CommandedPose,
            PoseL(_) => Assumption::RailPose,
            AlarmsState(_) => Assumption::AlarmBits,
            HomeParams(_) if self.store.settings.home.is_none() => Assumption::HomeUnset,
            HomeParams(_) => Assumption::HomeUnchecked,
            HhtTrigMode(_) | HhtTrigOutputEnabled(_) | HhtTrigOutput(_) => {
                Assumption::TeachSettings
            }
            EndEffectorParams(_) => Assumption::ToolBias,
            EndEffectorLaser(_) | EndEffectorSuctionCup(_) | EndEffectorGripper(_) => {
                Assumption::Tools
            }
            JogLParams(_) | PtpLParams(_) if !self.store.settings.told.contains(get.row().id) => {
                Assumption::RailDefaults
            }
            JogJointParams(_)
            | JogCoordinateParams(_)
            | JogCommonParams(_)
            | JogLParams(_)
            | PtpJointParams(_)
            | PtpCoordinateParams(_)
            | PtpJumpParams(_)
            | PtpCommonParams(_)
            | PtpLParams(_)
            | PtpJump2Params(_)
            | CpParams(_)
            | ArcParams(_) => Assumption::Parameters,
            ArcCommonParams(_) => Assumption::ArcRatio,
            IoMultiplexing(_) => Assumption::IoFunctions,
            IoDo(_) | IoPwm(_) => Assumption::IoOutputs,
            IoDi(_) | IoAdc(_) => Assumption::IoInputs,
            ColorSensor(_) | IrSwitch(_) => Assumption::Sensors,
            WifiSsid(_) if self.store.flash().wifi_ssid == self.new_flash().wifi_ssid => {
                Assumption::WifiDefaults
            }
            WifiPassword(_)
                if self.store.flash().wifi_password == self.new_flash().wifi_password =>
            {
                Assumption::WifiDefaults
            }
            WifiIpAddress(_)
                if self.store.flash().wifi_address == self.new_flash().wifi_address =>
            {
                Assumption::WifiDefaults
            }
            WifiNetmask(_) if self.store.flash().wifi_netmask == self.new_flash().wifi_netmask => {
                Assumption::WifiDefaults
            }
            WifiGateway(_) if self.store.flash().wifi_gateway == self.new_flash().wifi_gateway => {
                Assumption::WifiDefaults
            }
            WifiDns(_) if self.store.flash().wifi_dns == self.new_flash().wifi_dns => {
                Assumption::WifiDefaults
            }
            WifiConfigMode(_) | WifiSsid(_) | WifiPassword(_) | WifiIpAddress(_)
            | WifiNetmask(_) | WifiGateway(_) | WifiDns(_) => Assumption::WifiSettings,
            WifiConnectStatus(_) => Assumption::WifiStatus,
            Kinematics(_)
            | DeviceInfo(_)
            | UserParams(_)
            | Uart4PeripheralsModel(_)
            | ZdfCalibStatus(_) => Assumption::Zeros,
            AutoLeveling(_)
            | ArmOrientation(_)
            | CpRHeadHoldEnable(_)
            | CpCommonParams(_)
            | AngleSensorStaticError(_)
            | AngleSensorCoef(_)
            | BaseDecoderStaticError(_) => Assumption::StoredWithoutEffect,
            FirmwareMode(_) | Uart4PeripheralsEnabled(_) | PulseMode(_) => {
                Assumption::OutsideTheDocument
            }
            PtpTime(_) => Assumption::PtpTime,
            QueuedCmdCurrentIndex(_) => Assumption::CurrentIndex,
            QueuedCmdLeftSpace(_) => Assumption::QueueDepth,
            QueuedCmdMotionFinish(_) => Assumption::MotionFinish,
        }
    }

    /// Whether nobody has set a tool since power-up.
    fn has_tool_of_power_up(&self) -> bool {
        let id = <EndEffectorParams as Readable>::ROW.id;
        !self.store.settings.told.contains(id)
    }

    /// The flash before anything was set.
    fn new_flash(&self) -> Flash {
        Flash::new(&self.firmware.profile)
    }

    /// Whether nothing is connected to a pin.
    fn is_open(&self, address: u8) -> bool {
        let (world, now) = (&self.world, self.now);
        world.digital(now, address).is_none() && world.analog(now, address).is_none()
    }

    fn assumptions_of_set(&self, set: &Set, mode: ExecMode) -> AssumptionSet {
        let mut assumptions = AssumptionSet::default();
        assumptions.add(assumption_of_order(set));
        match set {
            Set::HomeCmd(_) => self.homing_assumptions(mode, &mut assumptions),
            Set::JogCmd(jog) => self.jog_assumptions(jog, mode, &mut assumptions),
            Set::PtpCmd(_) | Set::PtpWithLCmd(_) | Set::PtpPoCmd(_) | Set::PtpPoWithLCmd(_) => {
                self.ptp_assumptions(set, &mut assumptions);
                self.motion_assumptions(mode, &mut assumptions);
            }
            Set::CpCmd(CpCmd { x, y, z, .. }) | Set::CpLeCmd(CpLeCmd { x, y, z, .. }) => {
                finite(&[*x, *y, *z], &mut assumptions);
                for assumption in [
                    Assumption::CpRotation,
                    Assumption::CpTimes,
                    Assumption::CpFollows,
                ] {
                    assumptions.add(assumption);
                }
                self.motion_assumptions(mode, &mut assumptions);
            }
            Set::ArcCmd(ArcCmd {
                cir_point,
                to_point,
            })
            | Set::CircleCmd(CircleCmd {
                cir_point,
                to_point,
                ..
            }) => {
                finite(cir_point, &mut assumptions);
                finite(to_point, &mut assumptions);
                assumptions.add(Assumption::ArcSpeeds);
                self.motion_assumptions(mode, &mut assumptions);
            }
            Set::WaitCmd(_) | Set::TrigCmd(_) => {
                assumptions.add_if(mode == ExecMode::Immediate, Assumption::ImmediateWait);
            }
            Set::IoDo(IoDo { address, .. })
            | Set::IoPwm(IoPwm { address, .. })
            | Set::IoMultiplexing(IoMultiplexing { address, .. }) => {
                assumptions.add_if(TOOL_PINS.contains(address), Assumption::ToolPins);
            }
            Set::EMotorS(_) => assumptions.add(Assumption::StepperDistance),
            Set::SetEndEffectorSuctionCup(_) => assumptions.add(Assumption::VacuumDelay),
            Set::SetEndEffectorGripper(_) => assumptions.add(Assumption::GripperDelay),
            Set::QueuedCmdStartExec(_) => {
                let again = self.hosts().is_started();
                assumptions.add(if again {
                    Assumption::StartAgain
                } else {
                    Assumption::QueueStopped
                });
            }
            Set::QueuedCmdStopExec(_) => self.stop_assumptions(&mut assumptions),
            Set::QueuedCmdForceStopExec(_) => {
                self.stop_assumptions(&mut assumptions);
                assumptions.add(Assumption::ForceStopStops);
            }
            Set::QueuedCmdClear(_) => self.clear_assumptions(&mut assumptions),
            _ => assumptions.add_if(
                beyond(set, &self.firmware.model.ceilings),
                Assumption::BeyondCeilings,
            ),
        }
        assumptions
    }

    /// Of a motion that is not homing or a jog.
    fn motion_assumptions(&self, mode: ExecMode, assumptions: &mut AssumptionSet) {
        assumptions.add(Assumption::PlannedAtStart);
        if mode == ExecMode::Immediate {
            assumptions.add_if(self.alarms.hold_queue(), Assumption::ImmediateWhileHeld);
            self.replacing_assumptions(assumptions);
        }
    }

    /// Of what moves the arm at once, whatever else is going on.
    fn replacing_assumptions(&self, assumptions: &mut AssumptionSet) {
        assumptions.add_if(self.teaching.held(), Assumption::MotionWhileUnlocked);
        assumptions.add_if(self.motion.is_moving(), Assumption::ReplacedMotion);
        let moves = self.queues.active().busy() == Some(Busy::Moving);
        let waits = self.queues.active().is_started() && self.queues.active().waiting() > 0;
        assumptions.add_if(
            (moves || waits) && !self.alarms.hold_queue(),
            Assumption::QueueMeanwhile,
        );
    }

    fn homing_assumptions(&self, mode: ExecMode, assumptions: &mut AssumptionSet) {
        assumptions.add(Assumption::HomePoint);
        assumptions.add_if(self.has_rail(), Assumption::RailHome);
        assumptions.add(Assumption::HomingFigures);
        assumptions.add_if(self.alarms.hold_queue(), Assumption::HomeWhileHeld);
        if mode == ExecMode::Immediate {
            self.replacing_assumptions(assumptions);
        }
    }

    fn jog_assumptions(&self, jog: &JogCmd, mode: ExecMode, assumptions: &mut AssumptionSet) {
        assumptions.add_if(mode == ExecMode::Queued, Assumption::QueuedJog);
        assumptions.add_if(self.alarms.hold_queue(), Assumption::JogWhileHeld);
        let rail = matches!(jog.cmd, JogCommand::RailPlus | JogCommand::RailMinus);
        if rail {
            assumptions.add(match self.has_rail() {
                true => Assumption::RailRamps,
                false => Assumption::RailIgnored,
            });
        }
        match jog.cmd {
            JogCommand::Stop => {}
            JogCommand::Unknown(_) => assumptions.add(Assumption::UnknownJog),
            _ if rail && !self.has_rail() => {}
            _ if self.motion.is_jogging() => {
                let other = self.view().jogs_another(jog.is_joint.is_on(), jog.cmd);
                assumptions.add_if(other, Assumption::JogAxisChange);
            }
            _ if mode == ExecMode::Immediate => self.replacing_assumptions(assumptions),
            _ => {}
        }
    }

    fn ptp_assumptions(&self, set: &Set, assumptions: &mut AssumptionSet) {
        let (mode, numbers, rail) = match *set {
            Set::PtpCmd(PtpCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
            })
            | Set::PtpPoCmd(PtpPoCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
                ..
            }) => (ptp_mode, [x, y, z, r], None),
            Set::PtpWithLCmd(PtpWithLCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
                l,
            })
            | Set::PtpPoWithLCmd(PtpPoWithLCmd {
                ptp_mode,
                x,
                y,
                z,
                r,
                l,
                ..
            }) => (ptp_mode, [x, y, z, r], Some(l)),
            _ => return,
        };
        let outputs = matches!(set, Set::PtpPoCmd(_) | Set::PtpPoWithLCmd(_));
        assumptions.add_if(outputs, Assumption::OutputShare);
        finite(&numbers, assumptions);
        match mode {
            PtpMode::Unknown(_) => assumptions.add(Assumption::UnknownMode),
            PtpMode::MovlXyzInc => assumptions.add(Assumption::ModeSeven),
            PtpMode::JumpMovlXyz => assumptions.add(Assumption::ModeNine),
            _ => {}
        }
        if matches!(
            mode,
            PtpMode::JumpXyz | PtpMode::JumpAngle | PtpMode::JumpMovlXyz
        ) {
            self.jump_assumptions(mode, numbers, assumptions);
        }
        if let Some(rail) = rail {
            self.rail_assumptions(mode, rail, assumptions);
        }
    }

    fn jump_assumptions(&self, mode: PtpMode, numbers: [f32; 4], assumptions: &mut AssumptionSet) {
        let heights = self.store.settings.jump_heights();
        assumptions.add(Assumption::JumpPath);
        assumptions.add_if(heights.start != heights.end, Assumption::UnequalJump);
        let numbers = numbers.map(f64::from);
        let target = match mode {
            PtpMode::JumpAngle => self.geometry().forward(&numbers.into()).z,
            _ => numbers[2],
        };
        let above = self.arm().pose.z.max(target) > heights.z_limit;
        assumptions.add_if(above, Assumption::JumpAboveLimit);
    }

    fn rail_assumptions(&self, mode: PtpMode, rail: f32, assumptions: &mut AssumptionSet) {
        if !self.has_rail() {
            assumptions.add(Assumption::RailIgnored);
            return;
        }
        assumptions.add(Assumption::RailWithArm);
        assumptions.add(Assumption::RailRamps);
        let from = match mode {
            PtpMode::MovjAngleInc | PtpMode::MovlXyzInc | PtpMode::MovjXyzInc => self.rail(),
            _ => 0.0,
        };
        let place = from + f64::from(rail);
        let length = self.firmware.profile.rail.length;
        assumptions.add_if(!(0.0..=length).contains(&place), Assumption::RailEnds);
    }

    fn stop_assumptions(&self, assumptions: &mut AssumptionSet) {
        let busy = self.queues.active().busy();
        let waits = busy.is_some_and(|busy| busy != Busy::Moving);
        assumptions.add_if(waits, Assumption::StopCutsWait);
        assumptions.add_if(self.motion.follows_path(), Assumption::CpStops);
    }

    fn clear_assumptions(&self, assumptions: &mut AssumptionSet) {
        assumptions.add(Assumption::IndexAfterClear);
        let moves = self.queues.active().busy() == Some(Busy::Moving);
        assumptions.add_if(moves, Assumption::ClearWhileMoving);
        assumptions.add_if(self.motion.follows_path(), Assumption::CpStops);
    }
}

/// What an order of a row rests on, whatever else.
fn assumption_of_order(set: &Set) -> Assumption {
    use Set::*;
    match set {
        DeviceSn(_) | DeviceName(_) => Assumption::Identity,
        SetDeviceWithL(_) => Assumption::RailSwitch,
        ResetPose(_) => Assumption::ResetPose,
        ClearAlarmsState(_) => Assumption::ClearAlarms,
        ClearAllAlarmsState(_) => Assumption::ClearBy21,
        HomeParams(_) => Assumption::HomeUnchecked,
        HomeCmd(_) => Assumption::HomingSequence,
        HhtTrigMode(_) | HhtTrigOutputEnabled(_) => Assumption::TeachSettings,
        EndEffectorParams(_) => Assumption::ToolBias,
        SetEndEffectorLaser(_) | SetEndEffectorSuctionCup(_) | SetEndEffectorGripper(_) => {
            Assumption::Tools
        }
        PtpJumpParams(_) => Assumption::JumpSetsBoth,
        JogJointParams(_)
        | JogCoordinateParams(_)
        | JogCommonParams(_)
        | JogLParams(_)
        | PtpJointParams(_)
        | PtpCoordinateParams(_)
        | PtpCommonParams(_)
        | PtpLParams(_)
        | PtpJump2Params(_)
        | CpParams(_)
        | ArcParams(_) => Assumption::Parameters,
        JogCmd(_) => Assumption::Jog,
        PtpCmd(_) | PtpWithLCmd(_) | PtpPoCmd(_) | PtpPoWithLCmd(_) => Assumption::PtpLaw,
        CpCmd(_) => Assumption::CpLaw,
        CpLeCmd(_) => Assumption::CpLaser,
        ArcCmd(_) => Assumption::ArcPath,
        CircleCmd(_) => Assumption::CircleTurns,
        ArcCommonParams(_) => Assumption::ArcRatio,
        WaitCmd(_) => Assumption::Wait,
        TrigCmd(_) => Assumption::Trigger,
        IoMultiplexing(_) => Assumption::IoFunctions,
        IoDo(_) | IoPwm(_) => Assumption::IoOutputs,
        EMotor(_) | EMotorS(_) => Assumption::Steppers,
        SetColorSensor(_) | SetIrSwitch(_) => Assumption::Sensors,
        WifiConfigMode(_) | WifiSsid(_) | WifiPassword(_) | WifiIpAddress(_) | WifiNetmask(_)
        | WifiGateway(_) | WifiDns(_) => Assumption::WifiSettings,
        LostStepParams(_) | LostStepCmd(_) => Assumption::LostSteps,
        SetAutoLeveling(_)
        | ArmOrientation(_)
        | CpRHeadHoldEnable(_)
        | CpCommonParams(_)
        | AngleSensorStaticError(_)
        | AngleSensorCoef(_)
        | BaseDecoderStaticError(_) => Assumption::StoredWithoutEffect,
        FirmwareSwitch(_)
        | FirmwareMode(_)
        | Uart4PeripheralsEnabled(_)
        | PulseMode(_)
        | ZdfCalibRequest(_) => Assumption::OutsideTheDocument,
        QueuedCmdStartExec(_) => Assumption::Start,
        QueuedCmdStopExec(_) => Assumption::StopFinishes,
        QueuedCmdForceStopExec(_) => Assumption::ForceStop,
        QueuedCmdStartDownload(_) | QueuedCmdStopDownload(_) => Assumption::OfflineProgram,
        QueuedCmdClear(_) => Assumption::Clear,
    }
}

fn finite(numbers: &[f32], assumptions: &mut AssumptionSet) {
    let good = numbers.iter().all(|number| number.is_finite());
    assumptions.add_if(!good, Assumption::NotFinite);
}

/// Whether a parameter is beyond what motions are planned with.
fn beyond(set: &Set, most: &Ceilings) -> bool {
    let above = |values: &[f32], ceiling: f64| values.iter().any(|v| f64::from(*v) > ceiling);
    let any_above = |values: &[f32; 4], ceilings: [f64; 4]| {
        let mut pairs = values.iter().zip(ceilings);
        pairs.any(|(value, ceiling)| f64::from(*value) > ceiling)
    };
    let joints = |velocity: &[f32; 4], acceleration: &[f32; 4]| {
        any_above(velocity, most.joint_velocity) || any_above(acceleration, most.joint_acceleration)
    };
    let space = |velocity: f32, acceleration: f32| {
        above(&[velocity], most.linear_velocity) || above(&[acceleration], most.linear_acceleration)
    };
    let turn = |velocity: f32, acceleration: f32| {
        above(&[velocity], most.rotation_velocity)
            || above(&[acceleration], most.rotation_acceleration)
    };
    match set {
        Set::PtpJointParams(set) => joints(&set.velocity, &set.acceleration),
        Set::JogJointParams(set) => joints(&set.velocity, &set.acceleration),
        Set::JogCoordinateParams(JogCoordinateParams {
            velocity: [x, y, z, r],
            acceleration: [ax, ay, az, ar],
        }) => space(x.max(*y).max(*z), ax.max(*ay).max(*az)) || turn(*r, *ar),
        Set::PtpCoordinateParams(set) => {
            space(set.xyz_velocity, set.xyz_acceleration)
                || turn(set.r_velocity, set.r_acceleration)
        }
        Set::ArcParams(set) => {
            space(set.xyz_velocity, set.xyz_acceleration)
                || turn(set.r_velocity, set.r_acceleration)
        }
        Set::CpParams(set) => space(set.junction_vel, set.plan_acc),
        Set::PtpCommonParams(set) => above(&[set.velocity_ratio, set.acceleration_ratio], 100.0),
        Set::JogCommonParams(set) => above(&[set.velocity_ratio], 100.0),
        _ => false,
    }
}
