//! What a request rests on, as far as it shows when it is taken up. What shows only later says so where it is decided.
//!
//! Every row has its line here: a new one that has none does not compile.

use magician_motion::Ceilings;
use magician_protocol::commands::*;
use magician_protocol::{Ctrl, Get, JogCommand, PtpMode, Readable, Request, Set};

use super::{Bases, Basis};
use crate::core::Core;
use crate::dispatch::Turn;
use crate::flash::Flash;
use crate::motion::Purpose;
use crate::queue::Busy;

/// The pins of laser, valve and pump.
const TOOL_PINS: [u8; 4] = [2, 4, 16, 17];

impl Core {
    /// Whether a frame is taken for what it asks.
    pub(crate) fn may_take_frame(&mut self, id: u8, ctrl: Ctrl, request: &Request) -> bool {
        let mut bases = Bases::default();
        let elsewhere = ctrl.destination() != 0 || ctrl.slave() != 0;
        bases.add_if(elsewhere, Basis::DestinationBits);
        match request {
            Request::Get(_) => bases.add_if(ctrl.write(), Basis::GetOnlyWritten),
            Request::Set(_) => bases.add_if(ctrl.queued(), Basis::SteeringQueued),
            Request::Queue(_) => bases.add_if(!ctrl.write(), Basis::QueuedBitAlone),
            Request::Nothing => bases.add(Basis::SetOnlyRead),
        }
        self.may_rest_on_all(id, bases)
    }

    /// Whether a value is reported.
    pub(crate) fn may_report(&mut self, id: u8, get: &Get) -> bool {
        let bases = self.bases_of_get(get);
        self.may_rest_on_all(id, bases)
    }

    /// Whether a command is carried out.
    pub(crate) fn may_apply(&mut self, set: &Set, turn: Turn) -> bool {
        let bases = self.bases_of_set(set, turn);
        self.may_rest_on_all(set.row().id, bases)
    }

    /// Whether a command of the queue is given an index.
    pub(crate) fn number_rests(&mut self) {
        self.rests_on(Basis::Indices);
        if self.hosts().is_unused() {
            self.rests_on(Basis::FirstIndex);
        }
    }

    fn bases_of_get(&mut self, get: &Get) -> Bases {
        let mut bases = Bases::default();
        bases.add(self.basis_of_value(get));
        match get {
            Get::Pose(_) => {
                bases.add_if(!self.homed, Basis::BaseUnknown);
                bases.add_if(!self.homed, Basis::PowerUpPose);
                let EndEffectorParams {
                    x_bias,
                    y_bias,
                    z_bias,
                } = self.settings.bias;
                bases.add_if([x_bias, y_bias, z_bias] != [0.0; 3], Basis::ToolBias);
                let told = self
                    .settings
                    .told
                    .contains(<EndEffectorParams as Readable>::ROW.id);
                bases.add_if(!told, Basis::PowerUpTool);
            }
            Get::HhtTrigOutput(_) => bases.add_if(self.has_new_point(), Basis::PointCleared),
            Get::IoDi(GetIoDi { address }) | Get::IoAdc(GetIoAdc { address }) => {
                bases.add_if(address.is_none(), Basis::LastPin);
                let open = address.is_some_and(|address| self.is_open(address));
                bases.add_if(open, Basis::OpenInput);
            }
            Get::IoMultiplexing(GetIoMultiplexing { address })
            | Get::IoDo(GetIoDo { address })
            | Get::IoPwm(GetIoPwm { address }) => bases.add_if(address.is_none(), Basis::LastPin),
            Get::IrSwitch(GetIrSwitch { port }) => {
                bases.add_if(port.is_none(), Basis::InfraredPort);
            }
            Get::QueuedCmdCurrentIndex(_) => {
                let hosts = self.hosts();
                let unused = hosts.current == 0 && hosts.running.is_none();
                bases.add_if(unused, Basis::CurrentAtFirst);
            }
            Get::QueuedCmdLeftSpace(_) => {
                bases.add_if(self.hosts().running.is_some(), Basis::RunningPlace);
            }
            _ => {}
        }
        bases
    }

    /// What the value of a row rests on, whatever else.
    fn basis_of_value(&self, get: &Get) -> Basis {
        use Get::*;
        match get {
            DeviceSn(_) | DeviceName(_) => Basis::Identity,
            DeviceVersion(_) => Basis::Version,
            DeviceWithL(_) => Basis::RailSwitch,
            DeviceTime(_) => Basis::Clock,
            DeviceId(_) => Basis::DeviceIdWords,
            Pose(_) => Basis::CommandedPose,
            PoseL(_) => Basis::RailPose,
            AlarmsState(_) => Basis::AlarmBits,
            HomeParams(_) if self.settings.home.is_none() => Basis::HomeUnset,
            HomeParams(_) => Basis::HomeUnchecked,
            HhtTrigMode(_) | HhtTrigOutputEnabled(_) | HhtTrigOutput(_) => Basis::TeachSettings,
            EndEffectorParams(_) => Basis::ToolBias,
            EndEffectorLaser(_) | EndEffectorSuctionCup(_) | EndEffectorGripper(_) => Basis::Tools,
            JogLParams(_) | PtpLParams(_) if !self.settings.told.contains(get.row().id) => {
                Basis::RailDefaults
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
            | ArcParams(_) => Basis::Parameters,
            ArcCommonParams(_) => Basis::ArcRatio,
            IoMultiplexing(_) => Basis::IoFunctions,
            IoDo(_) | IoPwm(_) => Basis::IoOutputs,
            IoDi(_) | IoAdc(_) => Basis::IoInputs,
            ColorSensor(_) | IrSwitch(_) => Basis::Sensors,
            WifiSsid(_) if self.flash.wifi_ssid == self.new_flash().wifi_ssid => {
                Basis::WifiDefaults
            }
            WifiPassword(_) if self.flash.wifi_password == self.new_flash().wifi_password => {
                Basis::WifiDefaults
            }
            WifiIpAddress(_) if self.flash.wifi_address == self.new_flash().wifi_address => {
                Basis::WifiDefaults
            }
            WifiNetmask(_) if self.flash.wifi_netmask == self.new_flash().wifi_netmask => {
                Basis::WifiDefaults
            }
            WifiGateway(_) if self.flash.wifi_gateway == self.new_flash().wifi_gateway => {
                Basis::WifiDefaults
            }
            WifiDns(_) if self.flash.wifi_dns == self.new_flash().wifi_dns => Basis::WifiDefaults,
            WifiConfigMode(_) | WifiSsid(_) | WifiPassword(_) | WifiIpAddress(_)
            | WifiNetmask(_) | WifiGateway(_) | WifiDns(_) => Basis::WifiSettings,
            WifiConnectStatus(_) => Basis::WifiStatus,
            Kinematics(_)
            | DeviceInfo(_)
            | UserParams(_)
            | Uart4PeripheralsModel(_)
            | ZdfCalibStatus(_) => Basis::Zeros,
            AutoLeveling(_)
            | ArmOrientation(_)
            | CpRHeadHoldEnable(_)
            | CpCommonParams(_)
            | AngleSensorStaticError(_)
            | AngleSensorCoef(_)
            | BaseDecoderStaticError(_) => Basis::StoredWithoutEffect,
            FirmwareMode(_) | Uart4PeripheralsEnabled(_) | PulseMode(_) => {
                Basis::OutsideTheDocument
            }
            PtpTime(_) => Basis::PtpTime,
            QueuedCmdCurrentIndex(_) => Basis::CurrentIndex,
            QueuedCmdLeftSpace(_) => Basis::QueueDepth,
            QueuedCmdMotionFinish(_) => Basis::MotionFinish,
        }
    }

    /// The flash before anything was set.
    fn new_flash(&self) -> Flash {
        Flash::new(&self.profile)
    }

    /// Whether nothing is connected to a pin.
    fn is_open(&self, address: u8) -> bool {
        let (world, now) = (&self.world, self.now);
        world.digital(now, address).is_none() && world.analog(now, address).is_none()
    }

    fn bases_of_set(&self, set: &Set, turn: Turn) -> Bases {
        let mut bases = Bases::default();
        bases.add(basis_of_order(set));
        match set {
            Set::HomeCmd(_) => self.homing_bases(turn, &mut bases),
            Set::JogCmd(jog) => self.jog_bases(jog, turn, &mut bases),
            Set::PtpCmd(_) | Set::PtpWithLCmd(_) | Set::PtpPoCmd(_) | Set::PtpPoWithLCmd(_) => {
                self.ptp_bases(set, &mut bases);
                self.motion_bases(turn, &mut bases);
            }
            Set::CpCmd(CpCmd { x, y, z, .. }) | Set::CpLeCmd(CpLeCmd { x, y, z, .. }) => {
                finite(&[*x, *y, *z], &mut bases);
                for basis in [Basis::CpRotation, Basis::CpTimes, Basis::CpFollows] {
                    bases.add(basis);
                }
                self.motion_bases(turn, &mut bases);
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
                finite(cir_point, &mut bases);
                finite(to_point, &mut bases);
                bases.add(Basis::ArcSpeeds);
                self.motion_bases(turn, &mut bases);
            }
            Set::WaitCmd(_) | Set::TrigCmd(_) => {
                bases.add_if(turn == Turn::Immediate, Basis::ImmediateWait);
            }
            Set::IoDo(IoDo { address, .. })
            | Set::IoPwm(IoPwm { address, .. })
            | Set::IoMultiplexing(IoMultiplexing { address, .. }) => {
                bases.add_if(TOOL_PINS.contains(address), Basis::ToolPins);
            }
            Set::EMotorS(_) => bases.add(Basis::StepperDistance),
            Set::SetEndEffectorSuctionCup(_) => bases.add(Basis::VacuumDelay),
            Set::SetEndEffectorGripper(_) => bases.add(Basis::GripperDelay),
            Set::QueuedCmdStartExec(_) => {
                let again = self.hosts().started;
                bases.add(if again {
                    Basis::StartAgain
                } else {
                    Basis::QueueStopped
                });
            }
            Set::QueuedCmdStopExec(_) => self.stop_bases(&mut bases),
            Set::QueuedCmdForceStopExec(_) => {
                self.stop_bases(&mut bases);
                bases.add(Basis::ForceStopStops);
            }
            Set::QueuedCmdClear(_) => self.clear_bases(&mut bases),
            _ => bases.add_if(beyond(set, &self.model.ceilings), Basis::BeyondCeilings),
        }
        bases
    }

    /// Of a motion that is not homing or a jog.
    fn motion_bases(&self, turn: Turn, bases: &mut Bases) {
        bases.add(Basis::PlannedAtStart);
        if turn == Turn::Immediate {
            bases.add_if(self.is_held(), Basis::ImmediateWhileHeld);
            self.replacing_bases(bases);
        }
    }

    /// Of what moves the arm at once, whatever else is going on.
    fn replacing_bases(&self, bases: &mut Bases) {
        bases.add_if(self.teaching.held(), Basis::MotionWhileUnlocked);
        bases.add_if(self.motion.is_moving(), Basis::ReplacedMotion);
        let moves = self.queue.running.map(|running| running.busy) == Some(Busy::Moving);
        let waits = self.queue.started && self.queue.waiting() > 0;
        bases.add_if((moves || waits) && !self.is_held(), Basis::QueueMeanwhile);
    }

    fn homing_bases(&self, turn: Turn, bases: &mut Bases) {
        bases.add(Basis::HomePoint);
        bases.add_if(self.has_rail(), Basis::RailHome);
        bases.add(Basis::HomingFigures);
        bases.add_if(self.is_held(), Basis::HomeWhileHeld);
        if turn == Turn::Immediate {
            self.replacing_bases(bases);
        }
    }

    fn jog_bases(&self, jog: &JogCmd, turn: Turn, bases: &mut Bases) {
        bases.add_if(turn == Turn::Queued, Basis::QueuedJog);
        bases.add_if(self.is_held(), Basis::JogWhileHeld);
        let rail = matches!(jog.cmd, JogCommand::RailPlus | JogCommand::RailMinus);
        if rail {
            bases.add(match self.has_rail() {
                true => Basis::RailRamps,
                false => Basis::RailIgnored,
            });
        }
        match jog.cmd {
            JogCommand::Stop => {}
            JogCommand::Unknown(_) => bases.add(Basis::UnknownJog),
            _ if rail && !self.has_rail() => {}
            _ if self.motion.is_jogging() => {
                let other = self.jogs_another(jog.is_joint.is_on(), jog.cmd);
                bases.add_if(other, Basis::JogAxisChange);
            }
            _ if turn == Turn::Immediate => self.replacing_bases(bases),
            _ => {}
        }
    }

    fn ptp_bases(&self, set: &Set, bases: &mut Bases) {
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
        bases.add_if(outputs, Basis::OutputShare);
        finite(&numbers, bases);
        match mode {
            PtpMode::Unknown(_) => bases.add(Basis::UnknownMode),
            PtpMode::MovlXyzInc => bases.add(Basis::ModeSeven),
            PtpMode::JumpMovlXyz => bases.add(Basis::ModeNine),
            _ => {}
        }
        if matches!(
            mode,
            PtpMode::JumpXyz | PtpMode::JumpAngle | PtpMode::JumpMovlXyz
        ) {
            self.jump_bases(mode, numbers, bases);
        }
        if let Some(rail) = rail {
            self.rail_bases(mode, rail, bases);
        }
    }

    fn jump_bases(&self, mode: PtpMode, numbers: [f32; 4], bases: &mut Bases) {
        let heights = self.jump_heights();
        bases.add(Basis::JumpPath);
        bases.add_if(heights.start != heights.end, Basis::UnequalJump);
        let numbers = numbers.map(f64::from);
        let target = match mode {
            PtpMode::JumpAngle => self.geometry().forward(&numbers.into()).z,
            _ => numbers[2],
        };
        let above = self.arm().pose.z.max(target) > heights.z_limit;
        bases.add_if(above, Basis::JumpAboveLimit);
    }

    fn rail_bases(&self, mode: PtpMode, rail: f32, bases: &mut Bases) {
        if !self.has_rail() {
            bases.add(Basis::RailIgnored);
            return;
        }
        bases.add(Basis::RailWithArm);
        bases.add(Basis::RailRamps);
        let from = match mode {
            PtpMode::MovjAngleInc | PtpMode::MovlXyzInc | PtpMode::MovjXyzInc => self.rail(),
            _ => 0.0,
        };
        let place = from + f64::from(rail);
        let length = self.profile.rail.length;
        bases.add_if(!(0.0..=length).contains(&place), Basis::RailEnds);
    }

    fn stop_bases(&self, bases: &mut Bases) {
        let busy = self.queue.running.map(|running| running.busy);
        let waits = busy.is_some_and(|busy| busy != Busy::Moving);
        bases.add_if(waits, Basis::StopCutsWait);
        bases.add_if(self.follows_path(), Basis::CpStops);
    }

    fn clear_bases(&self, bases: &mut Bases) {
        bases.add(Basis::IndexAfterClear);
        let moves = self.queue.running.map(|running| running.busy) == Some(Busy::Moving);
        bases.add_if(moves, Basis::ClearWhileMoving);
        bases.add_if(self.follows_path(), Basis::CpStops);
    }

    /// Whether a segment of a continuous path is under way.
    fn follows_path(&self) -> bool {
        let purpose = self.motion.under_way().map(|motion| motion.purpose);
        matches!(purpose, Some(Purpose::Segment(_)))
    }
}

/// What an order of a row rests on, whatever else.
fn basis_of_order(set: &Set) -> Basis {
    use Set::*;
    match set {
        DeviceSn(_) | DeviceName(_) => Basis::Identity,
        SetDeviceWithL(_) => Basis::RailSwitch,
        ResetPose(_) => Basis::ResetPose,
        ClearAlarmsState(_) => Basis::ClearAlarms,
        ClearAllAlarmsState(_) => Basis::ClearBy21,
        HomeParams(_) => Basis::HomeUnchecked,
        HomeCmd(_) => Basis::HomingSequence,
        HhtTrigMode(_) | HhtTrigOutputEnabled(_) => Basis::TeachSettings,
        EndEffectorParams(_) => Basis::ToolBias,
        SetEndEffectorLaser(_) | SetEndEffectorSuctionCup(_) | SetEndEffectorGripper(_) => {
            Basis::Tools
        }
        PtpJumpParams(_) => Basis::JumpSetsBoth,
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
        | ArcParams(_) => Basis::Parameters,
        JogCmd(_) => Basis::Jog,
        PtpCmd(_) | PtpWithLCmd(_) | PtpPoCmd(_) | PtpPoWithLCmd(_) => Basis::PtpLaw,
        CpCmd(_) => Basis::CpLaw,
        CpLeCmd(_) => Basis::CpLaser,
        ArcCmd(_) => Basis::ArcPath,
        CircleCmd(_) => Basis::CircleTurns,
        ArcCommonParams(_) => Basis::ArcRatio,
        WaitCmd(_) => Basis::Wait,
        TrigCmd(_) => Basis::Trigger,
        IoMultiplexing(_) => Basis::IoFunctions,
        IoDo(_) | IoPwm(_) => Basis::IoOutputs,
        EMotor(_) | EMotorS(_) => Basis::Steppers,
        SetColorSensor(_) | SetIrSwitch(_) => Basis::Sensors,
        WifiConfigMode(_) | WifiSsid(_) | WifiPassword(_) | WifiIpAddress(_) | WifiNetmask(_)
        | WifiGateway(_) | WifiDns(_) => Basis::WifiSettings,
        LostStepParams(_) | LostStepCmd(_) => Basis::LostSteps,
        SetAutoLeveling(_)
        | ArmOrientation(_)
        | CpRHeadHoldEnable(_)
        | CpCommonParams(_)
        | AngleSensorStaticError(_)
        | AngleSensorCoef(_)
        | BaseDecoderStaticError(_) => Basis::StoredWithoutEffect,
        FirmwareSwitch(_)
        | FirmwareMode(_)
        | Uart4PeripheralsEnabled(_)
        | PulseMode(_)
        | ZdfCalibRequest(_) => Basis::OutsideTheDocument,
        QueuedCmdStartExec(_) => Basis::Start,
        QueuedCmdStopExec(_) => Basis::StopFinishes,
        QueuedCmdForceStopExec(_) => Basis::ForceStop,
        QueuedCmdStartDownload(_) | QueuedCmdStopDownload(_) => Basis::OfflineProgram,
        QueuedCmdClear(_) => Basis::Clear,
    }
}

fn finite(numbers: &[f32], bases: &mut Bases) {
    let good = numbers.iter().all(|number| number.is_finite());
    bases.add_if(!good, Basis::NotFinite);
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
