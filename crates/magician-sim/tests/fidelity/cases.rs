//! What to do to an arm so that it rests on each assumption. One table with a case for each, and so a long file.

use magician_protocol::commands::*;
use magician_protocol::{
    CpMode, Ctrl, Flag, FrameBuf, IoFunction, JogCommand, NoArgs, PoCmd, PoList, Port, PtpMode,
    Readable, Stepper, TeachTrigger, TriggerCondition, TriggerMode, Writable,
};
use magician_sim::fidelity::Assumption;
use magician_sim::world::{ExternalEvent, Press};

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
    bench.arm.inject(ExternalEvent::Alarm(0x30));
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
    bench.arm.inject(ExternalEvent::Slip {
        joint,
        degrees: 6.0,
    });
    now(bench, &LostStepCmd {});
}

fn teach(bench: &mut Bench, mode: TeachTrigger) {
    now(bench, &HhtTrigMode { mode });
    let is_enabled = Flag::ON;
    now(bench, &HhtTrigOutputEnabled { is_enabled });
    bench.arm.inject(ExternalEvent::Unlock(true));
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

pub(crate) type Case = (Assumption, fn(&mut Bench));

/// What to do to an arm with cleared alarms so that it rests on each assumption, and on no other choice that is refused.
pub(crate) const CASES: &[Case] = &[
    (Assumption::CommandedPose, |b| _ = ask::<Pose>(b)),
    (Assumption::BaseUnknown, |b| _ = ask::<Pose>(b)),
    (Assumption::PowerUpPose, |b| _ = ask::<Pose>(b)),
    (Assumption::PowerUpTool, |b| _ = ask::<Pose>(b)),
    (Assumption::ToolBias, |b| {
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
    (Assumption::Zeros, |b| _ = ask::<Kinematics>(b)),
    (Assumption::ResetPose, |b| _ = now(b, &reset_pose(40.0))),
    (Assumption::UntimelyResetPose, |b| {
        _ = now(b, &reset_pose(4000.0))
    }),
    (Assumption::Identity, |b| _ = ask::<DeviceName>(b)),
    (Assumption::Version, |b| _ = ask::<DeviceVersion>(b)),
    (Assumption::Clock, |b| _ = ask::<DeviceTime>(b)),
    (Assumption::DeviceIdWords, |b| _ = ask::<DeviceId>(b)),
    (Assumption::FlashKeeps, |b| {
        b.arm.inject(ExternalEvent::Reset)
    }),
    (Assumption::ResetAlarm, |b| {
        b.arm.inject(ExternalEvent::Reset)
    }),
    (Assumption::Parameters, |b| _ = ask::<PtpJointParams>(b)),
    (Assumption::BeyondCeilings, |b| _ = now(b, &speeds(1000.0))),
    (Assumption::RailDefaults, |b| _ = ask::<PtpLParams>(b)),
    (Assumption::JumpSetsBoth, |b| {
        now(
            b,
            &PtpJumpParams {
                jump_height: 10.0,
                z_limit: 90.0,
            },
        );
    }),
    (Assumption::StoredWithoutEffect, |b| {
        _ = ask::<AngleSensorCoef>(b)
    }),
    (Assumption::OutsideTheDocument, |b| _ = ask::<PulseMode>(b)),
    (Assumption::PtpTime, |b| {
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
    (Assumption::MotionFinish, |b| {
        _ = ask::<QueuedCmdMotionFinish>(b)
    }),
    (Assumption::WifiSettings, |b| {
        now(
            b,
            &WifiNetmask {
                addr: [255, 255, 0, 0],
            },
        );
        ask::<WifiNetmask>(b);
    }),
    (Assumption::WifiDefaults, |b| _ = ask::<WifiNetmask>(b)),
    (Assumption::WifiStatus, |b| _ = ask::<WifiConnectStatus>(b)),
    (Assumption::ForeignBytes, |b| _ = b.send(b"M10\r\nAA")),
    (Assumption::DamagedFrame, |b| {
        b.send(&[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0x01, 0, 0, 0, 0, 0, 0]);
    }),
    (Assumption::UnknownId, |b| _ = raw(b, 99, 0, &[])),
    (Assumption::WrongCount, |b| _ = raw(b, 84, 1, &[1, 2, 3])),
    (Assumption::QueuedBitAlone, |b| _ = raw(b, 110, 2, &[0; 4])),
    (Assumption::SteeringQueued, |b| _ = raw(b, 241, 3, &[])),
    (Assumption::SetOnlyRead, |b| _ = raw(b, 240, 0, &[])),
    (Assumption::GetOnlyWritten, |b| _ = raw(b, 247, 1, &[])),
    (Assumption::DestinationBits, |b| _ = raw(b, 10, 0x10, &[])),
    (Assumption::AlarmBits, |b| _ = ask::<AlarmsState>(b)),
    (Assumption::ClearAlarms, |b| {
        _ = now(b, &ClearAlarmsState {})
    }),
    (Assumption::ClearBy21, |b| {
        _ = now(b, &ClearAllAlarmsState {})
    }),
    (Assumption::AlarmHold, to_the_limit),
    (Assumption::QuietAlarms, |b| {
        b.arm.inject(ExternalEvent::Alarm(0x04))
    }),
    (Assumption::LatchedHold, jog_back),
    (Assumption::LimitDrops, jog_back),
    (Assumption::ImmediateWhileHeld, |b| {
        hold(b);
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
    }),
    (Assumption::JogWhileHeld, jog_back),
    (Assumption::HomeWhileHeld, |b| {
        hold(b);
        now(b, &home());
    }),
    (Assumption::TargetChecked, |b| {
        start(b);
        queue(b, &ptp(1, [900.0, 0.0, 0.0, 0.0]));
    }),
    (Assumption::PathChecked, |b| {
        start(b);
        queue(b, &ptp(1, [30.0, 180.0, 0.0, 0.0]));
        queue(b, &ptp(2, [30.0, -180.0, 0.0, 0.0]));
        b.rest();
    }),
    (Assumption::JointTargets, to_the_limit),
    (Assumption::SoftLimits, to_the_limit),
    (Assumption::RefusedFinishes, to_the_limit),
    (Assumption::NotFinite, |b| {
        _ = now(b, &ptp(1, [f32::NAN, 0.0, 0.0, 0.0]))
    }),
    (Assumption::NoSpeed, |b| {
        now(b, &speeds(0.0));
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
    }),
    (Assumption::LostSteps, |b| slip(b, 2)),
    (Assumption::LostBase, |b| slip(b, 1)),
    (Assumption::HomingSequence, |b| _ = now(b, &home())),
    (Assumption::HomingFigures, |b| _ = now(b, &home())),
    (Assumption::HomePoint, |b| _ = now(b, &home())),
    (Assumption::HomeOutOfReach, |b| {
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
    (Assumption::HomeUnset, |b| _ = ask::<HomeParams>(b)),
    (Assumption::HomeUnchecked, |b| {
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
    (Assumption::TeachKey, |b| {
        b.arm.inject(ExternalEvent::Unlock(true))
    }),
    (Assumption::TeachSettings, |b| _ = ask::<HhtTrigMode>(b)),
    (Assumption::PointCleared, |b| {
        teach(b, TeachTrigger::OnRelease);
        b.arm.inject(ExternalEvent::Unlock(false));
        ask::<HhtTrigOutput>(b);
    }),
    (Assumption::TeachPeriod, |b| {
        teach(b, TeachTrigger::Periodic);
        b.arm.inject(ExternalEvent::Unlock(false));
    }),
    (Assumption::MotionWhileUnlocked, |b| {
        b.arm.inject(ExternalEvent::Unlock(true));
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
    }),
    (Assumption::BaseKey, |b| {
        b.arm.inject(ExternalEvent::Key(Press::Short))
    }),
    (Assumption::BaseKeyHeld, |b| {
        b.arm.inject(ExternalEvent::Key(Press::Long))
    }),
    (Assumption::OfflineProgram, |b| download(b, 1)),
    (Assumption::OfflineMismatch, |b| download(b, 2)),
    (Assumption::OfflineBusy, |b| {
        download(b, 1);
        b.arm.inject(ExternalEvent::Key(Press::Short));
        now(
            b,
            &QueuedCmdStartDownload {
                total_loop: 1,
                line_per_loop: 1,
            },
        );
    }),
    (Assumption::StoredLineIndex, |b| download(b, 1)),
    (Assumption::PtpLaw, |b| {
        _ = now(b, &joints_to([30.0, 45.0, 45.0, 0.0]))
    }),
    (Assumption::PlannedAtStart, |b| {
        _ = now(b, &joints_to([30.0, 45.0, 45.0, 0.0]))
    }),
    (Assumption::ReplacedMotion, |b| {
        now(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
        now(b, &joints_to([20.0, 45.0, 45.0, 0.0]));
    }),
    (Assumption::QueueMeanwhile, |b| {
        start(b);
        queue(b, &joints_to([30.0, 45.0, 45.0, 0.0]));
        now(b, &joints_to([20.0, 45.0, 45.0, 0.0]));
    }),
    (Assumption::UnknownMode, |b| {
        _ = now(b, &ptp(10, [200.0, 0.0, 0.0, 0.0]))
    }),
    (Assumption::ModeSeven, |b| {
        _ = now(b, &ptp(7, [10.0, 0.0, 0.0, 0.0]))
    }),
    (Assumption::ModeNine, |b| {
        _ = now(b, &ptp(9, [200.0, 30.0, 0.0, 0.0]))
    }),
    (Assumption::JumpPath, |b| {
        _ = now(b, &ptp(0, [200.0, 30.0, 0.0, 0.0]))
    }),
    (Assumption::JumpAboveLimit, |b| {
        now(b, &heights((20.0, 20.0), -50.0));
        now(b, &ptp(0, [200.0, 30.0, 0.0, 0.0]));
    }),
    (Assumption::UnequalJump, |b| {
        now(b, &heights((20.0, 30.0), 100.0));
        now(b, &ptp(0, [200.0, 30.0, 0.0, 0.0]));
    }),
    (Assumption::ShortMove, |b| {
        _ = now(b, &joints_to([0.0, 45.0, 45.0, 0.0]))
    }),
    (Assumption::OutputShare, |b| {
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
    (Assumption::RailSwitch, |b| _ = ask::<DeviceWithL>(b)),
    (Assumption::RailIgnored, |b| _ = now(b, &with_rail(100.0))),
    (Assumption::RailPose, |b| _ = ask::<PoseL>(b)),
    (Assumption::RailWithArm, |b| {
        rail(b);
        now(b, &with_rail(100.0));
    }),
    (Assumption::RailRamps, |b| {
        rail(b);
        now(b, &with_rail(100.0));
    }),
    (Assumption::RailEnds, |b| {
        rail(b);
        now(b, &with_rail(1100.0));
    }),
    (Assumption::CpLaw, |b| _ = now(b, &segment(10.0))),
    (Assumption::CpRotation, |b| _ = now(b, &segment(10.0))),
    (Assumption::CpTimes, |b| _ = now(b, &segment(10.0))),
    (Assumption::CpFollows, |b| _ = now(b, &segment(10.0))),
    (Assumption::CpLaser, |b| {
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
    (Assumption::CpStops, |b| {
        start(b);
        queue(b, &segment(10.0));
        now(b, &QueuedCmdStopExec {});
    }),
    (Assumption::ArcPath, |b| {
        _ = now(b, &arc([200.0, 40.0, 0.0, 0.0]))
    }),
    (Assumption::ArcSpeeds, |b| {
        _ = now(b, &arc([200.0, 40.0, 0.0, 0.0]))
    }),
    (Assumption::ArcPoints, |b| {
        _ = now(b, &arc([210.0, 20.0, 0.0, 0.0]))
    }),
    (Assumption::ArcRatio, |b| _ = ask::<ArcCommonParams>(b)),
    (Assumption::CircleTurns, |b| {
        now(
            b,
            &CircleCmd {
                cir_point: [210.0, 20.0, 0.0, 0.0],
                to_point: [200.0, 40.0, 0.0, 0.0],
                count: 1,
            },
        );
    }),
    (Assumption::Jog, |b| _ = now(b, &jog(JogCommand::Axis1Plus))),
    (Assumption::JogAxisChange, |b| {
        now(b, &jog(JogCommand::Axis1Plus));
        b.pass(SECOND / 10);
        now(b, &jog(JogCommand::Axis2Plus));
    }),
    (Assumption::UnknownJog, |b| {
        _ = now(b, &jog(JogCommand::from(11)))
    }),
    (Assumption::QueuedJog, |b| {
        start(b);
        queue(b, &jog(JogCommand::Axis1Plus));
    }),
    (Assumption::Wait, |b| {
        start(b);
        queue(b, &wait(10));
    }),
    (Assumption::Trigger, |b| {
        start(b);
        queue(b, &trigger());
    }),
    (Assumption::MeaninglessTrigger, |b| {
        start(b);
        queue(
            b,
            &TrigCmd {
                address: 99,
                ..trigger()
            },
        );
    }),
    (Assumption::StepperDistance, |b| {
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
    (Assumption::ToolPins, |b| {
        _ = now(
            b,
            &IoDo {
                address: 17,
                level: Flag::ON,
            },
        )
    }),
    (Assumption::RailHome, |b| {
        rail(b);
        now(b, &home());
    }),
    (Assumption::ImmediateWait, |b| _ = now(b, &wait(10))),
    (Assumption::IoFunctions, |b| {
        _ = now(b, &multiplex(IoFunction::DigitalOutput))
    }),
    (Assumption::PinTable, |b| {
        _ = now(b, &multiplex(IoFunction::DigitalOutput))
    }),
    (Assumption::LackingFunction, |b| {
        _ = now(b, &multiplex(IoFunction::AnalogInput))
    }),
    (Assumption::IoOutputs, |b| {
        _ = now(
            b,
            &IoDo {
                address: 2,
                level: Flag::ON,
            },
        )
    }),
    (Assumption::IoInputs, |b| {
        _ = ask_with::<IoDi>(b, &GetIoDi { address: Some(5) })
    }),
    (Assumption::OpenInput, |b| {
        _ = ask_with::<IoDi>(b, &GetIoDi { address: Some(5) })
    }),
    (Assumption::LastPin, |b| {
        _ = ask_with::<IoDi>(b, &GetIoDi { address: None })
    }),
    (Assumption::Steppers, |b| {
        now(
            b,
            &EMotor {
                index: Stepper::Stepper1,
                is_enabled: Flag::ON,
                speed: 1000,
            },
        );
    }),
    (Assumption::Sensors, |b| {
        _ = ask_with::<IrSwitch>(
            b,
            &GetIrSwitch {
                port: Some(Port::Gp1),
            },
        )
    }),
    (Assumption::InfraredPort, |b| {
        _ = ask_with::<IrSwitch>(b, &GetIrSwitch { port: None })
    }),
    (Assumption::Tools, |b| _ = ask::<EndEffectorGripper>(b)),
    (Assumption::VacuumDelay, |b| _ = now(b, &arm::suck(true))),
    (Assumption::GripperDelay, |b| {
        now(
            b,
            &SetEndEffectorGripper {
                enable_ctrl: Flag::ON,
                grip: Flag::ON,
            },
        );
    }),
    (Assumption::Indices, |b| _ = queue(b, &wait(0))),
    (Assumption::FirstIndex, |b| _ = queue(b, &wait(0))),
    (Assumption::CurrentIndex, |b| {
        start(b);
        queue(b, &wait(0));
        ask::<QueuedCmdCurrentIndex>(b);
    }),
    (Assumption::CurrentAtFirst, |b| {
        _ = ask::<QueuedCmdCurrentIndex>(b)
    }),
    (Assumption::IndexAfterClear, |b| {
        _ = now(b, &QueuedCmdClear {})
    }),
    (Assumption::QueueDepth, |b| _ = ask::<QueuedCmdLeftSpace>(b)),
    (Assumption::RunningPlace, |b| {
        start(b);
        queue(b, &wait(100));
        ask::<QueuedCmdLeftSpace>(b);
    }),
    (Assumption::FullQueue, |b| {
        (0..33).for_each(|_| _ = queue(b, &wait(0)))
    }),
    (Assumption::Start, start),
    (Assumption::QueueStopped, start),
    (Assumption::StartAgain, |b| {
        start(b);
        start(b);
    }),
    (Assumption::StopFinishes, |b| {
        _ = now(b, &QueuedCmdStopExec {})
    }),
    (Assumption::StopCutsWait, |b| {
        start(b);
        queue(b, &wait(100));
        now(b, &QueuedCmdStopExec {});
    }),
    (Assumption::ForceStop, |b| {
        _ = now(b, &QueuedCmdForceStopExec {})
    }),
    (Assumption::ForceStopStops, |b| {
        _ = now(b, &QueuedCmdForceStopExec {})
    }),
    (Assumption::Clear, |b| _ = now(b, &QueuedCmdClear {})),
    (Assumption::ClearWhileMoving, |b| {
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
