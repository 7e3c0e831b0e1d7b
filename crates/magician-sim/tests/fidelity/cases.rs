//! What to do to an arm so that it rests on each basis. One table with a case for each, and so a long file.

use magician_protocol::commands::*;
use magician_protocol::{
    CpMode, Ctrl, Flag, FrameBuf, IoFunction, JogCommand, NoArgs, PoCmd, PoList, Port, PtpMode,
    Readable, Stepper, TeachTrigger, TriggerCondition, TriggerMode, Writable,
};
use magician_sim::fidelity::Basis;
use magician_sim::world::{Happening, Press};

use crate::arm::{self, Bench, SECOND, home, joints_to, ptp, wait};

/// Sends at once, whatever the answer.
pub(crate) fn now<T: Writable>(bench: &mut Bench, value: &T) -> Vec<FrameBuf> {
    let frame = FrameBuf::encode(T::ROW.id, Ctrl::SET, value).expect("fits");
    bench.send(frame.bytes())
}

/// Queues, whatever the answer.
pub(crate) fn queue<T: Writable>(bench: &mut Bench, value: &T) -> Vec<FrameBuf> {
    let frame = FrameBuf::encode(T::ROW.id, Ctrl::QUEUED, value).expect("fits");
    bench.send(frame.bytes())
}

/// Asks, whatever the answer.
pub(crate) fn ask<T: Readable<Query = NoArgs>>(bench: &mut Bench) -> Vec<FrameBuf> {
    ask_with::<T>(bench, &NoArgs)
}

pub(crate) fn ask_with<T: Readable>(bench: &mut Bench, query: &T::Query) -> Vec<FrameBuf> {
    let frame = FrameBuf::encode(T::ROW.id, Ctrl::GET, query).expect("fits");
    bench.send(frame.bytes())
}

pub(crate) fn raw(bench: &mut Bench, id: u8, ctrl: u8, params: &[u8]) -> Vec<FrameBuf> {
    let frame = FrameBuf::new(id, Ctrl(ctrl), params).expect("fits");
    bench.send(frame.bytes())
}

pub(crate) fn start(bench: &mut Bench) {
    now(bench, &QueuedCmdStartExec {});
}

/// Runs into the upper limit of J1, which holds the queue.
fn to_the_limit(bench: &mut Bench) {
    start(bench);
    queue(bench, &joints_to([170.0, 45.0, 45.0, 0.0]));
    bench.rest();
}

/// The queue is held by an alarm that nothing here depends on.
fn hold(bench: &mut Bench) {
    bench.arm.inject(Happening::Alarm(0x30));
}

fn jog(cmd: JogCommand) -> JogCmd {
    let is_joint = Flag::ON;
    JogCmd { is_joint, cmd }
}

fn segment(x: f32) -> CpCmd {
    CpCmd {
        cp_mode: CpMode::Relative,
        x,
        y: 0.0,
        z: 0.0,
        velocity_or_power: 0.0,
    }
}

fn with_rail(l: f32) -> PtpWithLCmd {
    PtpWithLCmd {
        ptp_mode: PtpMode::MovjXyz,
        x: 200.0,
        y: 30.0,
        z: 0.0,
        r: 0.0,
        l,
    }
}

fn rail(bench: &mut Bench) {
    let with_l = Flag::ON;
    now(
        bench,
        &SetDeviceWithL {
            with_l,
            version: None,
        },
    );
}

fn arc(to_point: [f32; 4]) -> ArcCmd {
    ArcCmd {
        cir_point: [210.0, 20.0, 0.0, 0.0],
        to_point,
    }
}

fn slip(bench: &mut Bench, joint: u8) {
    bench.arm.inject(Happening::Slip {
        joint,
        degrees: 6.0,
    });
    now(bench, &LostStepCmd {});
}

fn teach(bench: &mut Bench, mode: TeachTrigger) {
    now(bench, &HhtTrigMode { mode });
    let is_enabled = Flag::ON;
    now(bench, &HhtTrigOutputEnabled { is_enabled });
    bench.arm.inject(Happening::Unlock(true));
    bench.pass(SECOND);
}

fn download(bench: &mut Bench, announced: u32) {
    let total_loop = 1;
    let line_per_loop = announced;
    now(
        bench,
        &QueuedCmdStartDownload {
            total_loop,
            line_per_loop,
        },
    );
    queue(bench, &wait(5000));
    now(bench, &QueuedCmdStopDownload {});
}

fn speeds(velocity: f32) -> PtpJointParams {
    PtpJointParams {
        velocity: [velocity; 4],
        acceleration: [100.0; 4],
    }
}

fn heights(jump: (f32, f32), z_limit: f32) -> PtpJump2Params {
    PtpJump2Params {
        start_jump_height: jump.0,
        end_jump_height: jump.1,
        z_limit,
    }
}

pub(crate) type Case = (Basis, fn(&mut Bench));

/// What to do to an arm with cleared alarms so that it rests on each basis, and on no other choice that is refused.
pub(crate) const CASES: &[Case] = &[
    (Basis::CommandedPose, |b| _ = ask::<Pose>(b)),
    (Basis::BaseUnknown, |b| _ = ask::<Pose>(b)),
    (Basis::PowerUpPose, |b| _ = ask::<Pose>(b)),
    (Basis::PowerUpTool, |b| _ = ask::<Pose>(b)),
    (Basis::ToolBias, |b| {
        now(
            b,
            &EndEffectorParams {
                x_bias: 59.7,
                y_bias: 0.0,
                z_bias: 0.0,
            },
        );
        ask::<Pose>(b);
    }),
    (Basis::Zeros, |b| _ = ask::<Kinematics>(b)),
    (Basis::ResetPose, |b| _ = now(b, &reset_pose(40.0))),
    (Basis::UntimelyResetPose, |b| {
        _ = now(b, &reset_pose(4000.0))
    }),
    (Basis::Identity, |b| _ = ask::<DeviceName>(b)),
    (Basis::Version, |b| _ = ask::<DeviceVersion>(b)),
    (Basis::Clock, |b| _ = ask::<DeviceTime>(b)),
    (Basis::DeviceIdWords, |b| _ = ask::<DeviceId>(b)),
    (Basis::FlashKeeps, |b| b.arm.inject(Happening::Reset)),
    (Basis::ResetAlarm, |b| b.arm.inject(Happening::Reset)),
    (Basis::Parameters, |b| _ = ask::<PtpJointParams>(b)),
    (Basis::BeyondCeilings, |b| _ = now(b, &speeds(1000.0))),
    (Basis::RailDefaults, |b| _ = ask::<PtpLParams>(b)),
    (Basis::JumpSetsBoth, |b| {
        now(
            b,
            &PtpJumpParams {
                jump_height: 10.0,
                z_limit: 90.0,
            },
        );
    }),
    (Basis::StoredWithoutEffect, |b| {
        _ = ask::<AngleSensorCoef>(b)
    }),
    (Basis::OutsideTheDocument, |b| _ = ask::<PulseMode>(b)),
    (Basis::PtpTime, |b| {
        ask_with::<PtpTime>(
            b,
            &GetPtpTime {
                ptp_mode: PtpMode::MovjXyz,
                x: 200.0,
                y: 0.0,
                z: 0.0,
                r: 0.0,
            },
        );
    }),
    (Basis::MotionFinish, |b| _ = ask::<QueuedCmdMotionFinish>(b)),
    (Basis::WifiSettings, |b| {
        now(
            b,
            &WifiNetmask {
                addr: [255, 255, 0, 0],
            },
        );
        ask::<WifiNetmask>(b);
    }),
    (Basis::WifiDefaults, |b| _ = ask::<WifiNetmask>(b)),
    (Basis::WifiStatus, |b| _ = ask::<WifiConnectStatus>(b)),
    (Basis::ForeignBytes, |b| _ = b.send(b"M10\r\nAA")),
    (Basis::DamagedFrame, |b| {
        b.send(&[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0x01, 0, 0, 0, 0, 0, 0]);
    }),
    (Basis::UnknownId, |b| _ = raw(b, 99, 0, &[])),
    (Basis::WrongCount, |b| _ = raw(b, 84, 1, &[1, 2, 3])),
    (Basis::QueuedBitAlone, |b| _ = raw(b, 110, 2, &[0; 4])),
    (Basis::SteeringQueued, |b| _ = raw(b, 241, 3, &[])),
    (Basis::SetOnlyRead, |b| _ = raw(b, 240, 0, &[])),
    (Basis::GetOnlyWritten, |b| _ = raw(b, 247, 1, &[])),
    (Basis::DestinationBits, |b| _ = raw(b, 10, 0x10, &[])),
    (Basis::AlarmBits, |b| _ = ask::<AlarmsState>(b)),
    (Basis::ClearAlarms, |b| _ = now(b, &ClearAlarmsState {})),
    (Basis::ClearBy21, |b| _ = now(b, &ClearAllAlarmsState {})),
    (Basis::AlarmHold, to_the_limit),
    (Basis::QuietAlarms, |b| b.arm.inject(Happening::Alarm(0x04))),
    (Basis::LatchedHold, jog_back),
    (Basis::LimitDrops, jog_back),
    (Basis::ImmediateWhileHeld, |b| {
        hold(b);
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
    }),
    (Basis::JogWhileHeld, jog_back),
    (Basis::HomeWhileHeld, |b| {
        hold(b);
        now(b, &home());
    }),
    (Basis::TargetChecked, |b| {
        start(b);
        queue(b, &ptp(1, [900.0, 0.0, 0.0, 0.0]));
    }),
    (Basis::PathChecked, |b| {
        start(b);
        queue(b, &ptp(1, [30.0, 180.0, 0.0, 0.0]));
        queue(b, &ptp(2, [30.0, -180.0, 0.0, 0.0]));
        b.rest();
    }),
    (Basis::JointTargets, to_the_limit),
    (Basis::SoftLimits, to_the_limit),
    (Basis::RefusedFinishes, to_the_limit),
    (Basis::NotFinite, |b| {
        _ = now(b, &ptp(1, [f32::NAN, 0.0, 0.0, 0.0]))
    }),
    (Basis::NoSpeed, |b| {
        now(b, &speeds(0.0));
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
    }),
    (Basis::LostSteps, |b| slip(b, 2)),
    (Basis::LostBase, |b| slip(b, 1)),
    (Basis::HomingSequence, |b| _ = now(b, &home())),
    (Basis::HomingFigures, |b| _ = now(b, &home())),
    (Basis::HomePoint, |b| _ = now(b, &home())),
    (Basis::HomeOutOfReach, |b| {
        now(
            b,
            &HomeParams {
                x: 200.0,
                y: 200.0,
                z: 200.0,
                r: 200.0,
            },
        );
        now(b, &home());
        b.rest();
    }),
    (Basis::HomeUnset, |b| _ = ask::<HomeParams>(b)),
    (Basis::HomeUnchecked, |b| {
        now(
            b,
            &HomeParams {
                x: 900.0,
                y: 0.0,
                z: 0.0,
                r: 0.0,
            },
        );
        ask::<HomeParams>(b);
    }),
    (Basis::TeachKey, |b| b.arm.inject(Happening::Unlock(true))),
    (Basis::TeachSettings, |b| _ = ask::<HhtTrigMode>(b)),
    (Basis::PointCleared, |b| {
        teach(b, TeachTrigger::OnRelease);
        b.arm.inject(Happening::Unlock(false));
        ask::<HhtTrigOutput>(b);
    }),
    (Basis::TeachPeriod, |b| {
        teach(b, TeachTrigger::Periodic);
        b.arm.inject(Happening::Unlock(false));
    }),
    (Basis::MotionWhileUnlocked, |b| {
        b.arm.inject(Happening::Unlock(true));
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
    }),
    (Basis::BaseKey, |b| {
        b.arm.inject(Happening::Key(Press::Short))
    }),
    (Basis::BaseKeyHeld, |b| {
        b.arm.inject(Happening::Key(Press::Long))
    }),
    (Basis::OfflineProgram, |b| download(b, 1)),
    (Basis::OfflineMismatch, |b| download(b, 2)),
    (Basis::OfflineBusy, |b| {
        download(b, 1);
        b.arm.inject(Happening::Key(Press::Short));
        now(
            b,
            &QueuedCmdStartDownload {
                total_loop: 1,
                line_per_loop: 1,
            },
        );
    }),
    (Basis::StoredLineIndex, |b| download(b, 1)),
    (Basis::PtpLaw, |b| {
        _ = now(b, &joints_to([30.0, 45.0, 45.0, 0.0]))
    }),
    (Basis::PlannedAtStart, |b| {
        _ = now(b, &joints_to([30.0, 45.0, 45.0, 0.0]))
    }),
    (Basis::ReplacedMotion, |b| {
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
        now(b, &joints_to([20.0, 45.0, 45.0, 0.0]));
    }),
    (Basis::QueueMeanwhile, |b| {
        start(b);
        queue(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
        now(b, &joints_to([20.0, 45.0, 45.0, 0.0]));
    }),
    (Basis::UnknownMode, |b| {
        _ = now(b, &ptp(10, [200.0, 0.0, 0.0, 0.0]))
    }),
    (Basis::ModeSeven, |b| {
        _ = now(b, &ptp(7, [10.0, 0.0, 0.0, 0.0]))
    }),
    (Basis::ModeNine, |b| {
        _ = now(b, &ptp(9, [200.0, 30.0, 0.0, 0.0]))
    }),
    (Basis::JumpPath, |b| {
        _ = now(b, &ptp(0, [200.0, 30.0, 0.0, 0.0]))
    }),
    (Basis::JumpAboveLimit, |b| {
        now(b, &heights((20.0, 20.0), -50.0));
        now(b, &ptp(0, [200.0, 30.0, 0.0, 0.0]));
    }),
    (Basis::UnequalJump, |b| {
        now(b, &heights((20.0, 30.0), 100.0));
        now(b, &ptp(0, [200.0, 30.0, 0.0, 0.0]));
    }),
    (Basis::ShortMove, |b| {
        _ = now(b, &joints_to([0.0, 45.0, 45.0, 0.0]))
    }),
    (Basis::OutputShare, |b| {
        let po = PoList::new(&[PoCmd {
            ratio: 50,
            address: 2,
            level: 1,
        }])
        .expect("one");
        now(
            b,
            &PtpPoCmd {
                ptp_mode: PtpMode::MovjXyz,
                x: 200.0,
                y: 30.0,
                z: 0.0,
                r: 0.0,
                po,
            },
        );
    }),
    (Basis::RailSwitch, |b| _ = ask::<DeviceWithL>(b)),
    (Basis::RailIgnored, |b| _ = now(b, &with_rail(100.0))),
    (Basis::RailPose, |b| _ = ask::<PoseL>(b)),
    (Basis::RailWithArm, |b| {
        rail(b);
        now(b, &with_rail(100.0));
    }),
    (Basis::RailRamps, |b| {
        rail(b);
        now(b, &with_rail(100.0));
    }),
    (Basis::RailEnds, |b| {
        rail(b);
        now(b, &with_rail(1100.0));
    }),
    (Basis::CpLaw, |b| _ = now(b, &segment(10.0))),
    (Basis::CpRotation, |b| _ = now(b, &segment(10.0))),
    (Basis::CpTimes, |b| _ = now(b, &segment(10.0))),
    (Basis::CpFollows, |b| _ = now(b, &segment(10.0))),
    (Basis::CpLaser, |b| {
        now(
            b,
            &CpLeCmd {
                cp_mode: CpMode::Relative,
                x: 10.0,
                y: 0.0,
                z: 0.0,
                velocity_or_power: 50.0,
            },
        );
    }),
    (Basis::CpStops, |b| {
        start(b);
        queue(b, &segment(10.0));
        now(b, &QueuedCmdStopExec {});
    }),
    (Basis::ArcPath, |b| {
        _ = now(b, &arc([200.0, 40.0, 0.0, 0.0]))
    }),
    (Basis::ArcSpeeds, |b| {
        _ = now(b, &arc([200.0, 40.0, 0.0, 0.0]))
    }),
    (Basis::ArcPoints, |b| {
        _ = now(b, &arc([210.0, 20.0, 0.0, 0.0]))
    }),
    (Basis::ArcRatio, |b| _ = ask::<ArcCommonParams>(b)),
    (Basis::CircleTurns, |b| {
        now(
            b,
            &CircleCmd {
                cir_point: [210.0, 20.0, 0.0, 0.0],
                to_point: [200.0, 40.0, 0.0, 0.0],
                count: 1,
            },
        );
    }),
    (Basis::Jog, |b| _ = now(b, &jog(JogCommand::Axis1Plus))),
    (Basis::JogAxisChange, |b| {
        now(b, &jog(JogCommand::Axis1Plus));
        b.pass(SECOND / 10);
        now(b, &jog(JogCommand::Axis2Plus));
    }),
    (Basis::UnknownJog, |b| {
        _ = now(b, &jog(JogCommand::from(11)))
    }),
    (Basis::QueuedJog, |b| {
        start(b);
        queue(b, &jog(JogCommand::Axis1Plus));
    }),
    (Basis::Wait, |b| {
        start(b);
        queue(b, &wait(10));
    }),
    (Basis::Trigger, |b| {
        start(b);
        queue(b, &trigger());
    }),
    (Basis::MeaninglessTrigger, |b| {
        start(b);
        queue(
            b,
            &TrigCmd {
                address: 99,
                ..trigger()
            },
        );
    }),
    (Basis::StepperDistance, |b| {
        start(b);
        queue(
            b,
            &EMotorS {
                index: Stepper::Stepper1,
                is_enabled: Flag::ON,
                speed: 1000,
                distance: 10,
            },
        );
    }),
    (Basis::ToolPins, |b| {
        _ = now(
            b,
            &IoDo {
                address: 17,
                level: Flag::ON,
            },
        )
    }),
    (Basis::RailHome, |b| {
        rail(b);
        now(b, &home());
    }),
    (Basis::ImmediateWait, |b| _ = now(b, &wait(10))),
    (Basis::IoFunctions, |b| {
        _ = now(b, &multiplex(IoFunction::DigitalOutput))
    }),
    (Basis::PinTable, |b| {
        _ = now(b, &multiplex(IoFunction::DigitalOutput))
    }),
    (Basis::LackingFunction, |b| {
        _ = now(b, &multiplex(IoFunction::AnalogInput))
    }),
    (Basis::IoOutputs, |b| {
        _ = now(
            b,
            &IoDo {
                address: 2,
                level: Flag::ON,
            },
        )
    }),
    (Basis::IoInputs, |b| {
        _ = ask_with::<IoDi>(b, &GetIoDi { address: Some(5) })
    }),
    (Basis::OpenInput, |b| {
        _ = ask_with::<IoDi>(b, &GetIoDi { address: Some(5) })
    }),
    (Basis::LastPin, |b| {
        _ = ask_with::<IoDi>(b, &GetIoDi { address: None })
    }),
    (Basis::Steppers, |b| {
        now(
            b,
            &EMotor {
                index: Stepper::Stepper1,
                is_enabled: Flag::ON,
                speed: 1000,
            },
        );
    }),
    (Basis::Sensors, |b| {
        _ = ask_with::<IrSwitch>(
            b,
            &GetIrSwitch {
                port: Some(Port::Gp1),
            },
        )
    }),
    (Basis::InfraredPort, |b| {
        _ = ask_with::<IrSwitch>(b, &GetIrSwitch { port: None })
    }),
    (Basis::Tools, |b| _ = ask::<EndEffectorGripper>(b)),
    (Basis::VacuumDelay, |b| _ = now(b, &arm::suck(true))),
    (Basis::GripperDelay, |b| {
        now(
            b,
            &SetEndEffectorGripper {
                enable_ctrl: Flag::ON,
                grip: Flag::ON,
            },
        );
    }),
    (Basis::Indices, |b| _ = queue(b, &wait(0))),
    (Basis::FirstIndex, |b| _ = queue(b, &wait(0))),
    (Basis::CurrentIndex, |b| {
        start(b);
        queue(b, &wait(0));
        ask::<QueuedCmdCurrentIndex>(b);
    }),
    (Basis::CurrentAtFirst, |b| {
        _ = ask::<QueuedCmdCurrentIndex>(b)
    }),
    (Basis::IndexAfterClear, |b| _ = now(b, &QueuedCmdClear {})),
    (Basis::QueueDepth, |b| _ = ask::<QueuedCmdLeftSpace>(b)),
    (Basis::RunningPlace, |b| {
        start(b);
        queue(b, &wait(100));
        ask::<QueuedCmdLeftSpace>(b);
    }),
    (Basis::FullQueue, |b| {
        (0..33).for_each(|_| _ = queue(b, &wait(0)))
    }),
    (Basis::Start, start),
    (Basis::QueueStopped, start),
    (Basis::StartAgain, |b| {
        start(b);
        start(b);
    }),
    (Basis::StopFinishes, |b| _ = now(b, &QueuedCmdStopExec {})),
    (Basis::StopCutsWait, |b| {
        start(b);
        queue(b, &wait(100));
        now(b, &QueuedCmdStopExec {});
    }),
    (Basis::ForceStop, |b| _ = now(b, &QueuedCmdForceStopExec {})),
    (Basis::ForceStopStops, |b| {
        _ = now(b, &QueuedCmdForceStopExec {})
    }),
    (Basis::Clear, |b| _ = now(b, &QueuedCmdClear {})),
    (Basis::ClearWhileMoving, |b| {
        start(b);
        queue(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
        now(b, &QueuedCmdClear {});
    }),
];

fn reset_pose(rear_arm_angle: f32) -> ResetPose {
    ResetPose {
        manual: Flag::ON,
        rear_arm_angle,
        front_arm_angle: 40.0,
    }
}

fn jog_back(bench: &mut Bench) {
    to_the_limit(bench);
    now(bench, &jog(JogCommand::Axis1Minus));
    bench.pass(SECOND);
}

fn multiplex(multiplex: IoFunction) -> IoMultiplexing {
    IoMultiplexing {
        address: 2,
        multiplex,
    }
}

fn trigger() -> TrigCmd {
    TrigCmd {
        address: 5,
        mode: TriggerMode::Level,
        condition: TriggerCondition::from(1),
        threshold: 0,
    }
}
