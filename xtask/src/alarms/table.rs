//! What is claimed of each alarm of the Magician. [`trial`](super::trial) holds the virtual arm to it.

use magician_protocol::commands::*;
use magician_protocol::{Alarm, Flag, JogCommand, PtpMode, Set};
use magician_sim::world::ExternalEvent;

/// What is claimed of an alarm.
pub(super) struct Claim {
    pub(super) code: u8,
    pub(super) arises: Arises,
    /// Whether what is queued behind it waits for a clear.
    pub(super) holds: bool,
    pub(super) goes: Goes,
}

/// How an alarm comes about.
pub(super) enum Arises {
    /// After this it stands, and no other.
    When { says: String, acts: Vec<Act> },
    /// What causes it is not simulated: it has to be injected.
    Injected(&'static str),
    /// Nothing here causes it; not after any of what comes nearest, either.
    Never {
        says: &'static str,
        tried: Vec<Vec<Act>>,
    },
}

/// How an alarm goes that has arisen so.
pub(super) enum Goes {
    /// With the first clear.
    Cleared,
    /// No clear drops it before the joint has come back inside; then it drops by itself, and a clear frees the queue.
    Inside { says: String, back: Vec<Act> },
    /// A clear drops it, and the next look raises it again, until homing has removed the cause.
    UntilHomed { look: Vec<Act> },
}

/// What is done to the arm.
pub(super) enum Act {
    Now(Set),
    Queue(Set),
    Bytes(&'static [u8]),
    Happen(ExternalEvent),
    /// Half a second passes.
    Pass,
    /// Until nothing moves and nothing is due.
    Rest,
}

/// Every alarm of the Magician, and those of its siblings that are raised here all the same, by code.
pub(super) fn claims() -> Vec<Claim> {
    let mut claims = common();
    claims.extend(plan());
    claims.extend(on_the_way());
    claims.extend(overspeed());
    claims.extend(limits());
    claims.extend(lost_steps());
    claims
}

fn when(code: u8, says: impl Into<String>, acts: Vec<Act>) -> Claim {
    let says = says.into();
    claim(code, Arises::When { says, acts })
}

fn claim(code: u8, arises: Arises) -> Claim {
    Claim {
        code,
        arises,
        holds: code > 7,
        goes: Goes::Cleared,
    }
}

fn common() -> Vec<Claim> {
    const HARDWARE: &str = "a fault of the controller's own parts, which are not simulated";
    vec![
        when(
            Alarm::ResetOccurred,
            "the controller is switched on, or resets",
            vec![Act::Happen(ExternalEvent::Reset)],
        ),
        when(
            Alarm::UndefinedInstruction,
            "a frame with an id that is none of the Magician's; a PTPCmd with a mode above 9 as well",
            vec![Act::Bytes(&[0xAA, 0xAA, 0x02, 0x63, 0x00, 0x9D])],
        ),
        claim(Alarm::FileSystemError, Arises::Injected(HARDWARE)),
        claim(Alarm::McuFpgaCommError, Arises::Injected(HARDWARE)),
        claim(
            Alarm::AngleSensorError,
            Arises::Injected("the sensors of J2 and J3 here never fail"),
        ),
    ]
}

fn plan() -> Vec<Claim> {
    let queued = |set| vec![Act::Queue(set), Act::Rest];
    let arc = |via, to| queued(arc_through(via, to));
    vec![
        claim(
            Alarm::PlanInvSingularity,
            Arises::Never {
                says: "elbow straight and folded lie outside the limit of J2 - J3, and a target on the base axis \
                    raises 0x11 or 0x12, or is reached where the tool bias allows",
                tried: vec![
                    queued(ptp(PtpMode::MovjXyz, [0.0; 4])),
                    on_the_axis(),
                    queued(ptp(PtpMode::MovjXyz, [282.0, 0.0, 0.0, 0.0])),
                    queued(ptp(PtpMode::MovjXyz, [12.0, 0.0, 0.0, 0.0])),
                ],
            },
        ),
        when(
            Alarm::PlanInvCalc,
            "PTPCmd MOVJ_XYZ to x = 900, out of reach",
            queued(ptp(PtpMode::MovjXyz, [900.0, 0.0, 0.0, 0.0])),
        ),
        when(
            Alarm::PlanInvLimit,
            "PTPCmd MOVJ_XYZ to x = -200, where J1 would be at 180 degrees",
            queued(ptp(PtpMode::MovjXyz, [-200.0, 0.0, 0.0, 180.0])),
        ),
        when(
            Alarm::PlanPushDataRepeat,
            "ARCCmd whose two points are the same",
            arc([220.0, 20.0, 0.0, 0.0], [220.0, 20.0, 0.0, 0.0]),
        ),
        when(
            Alarm::PlanArcInputParam,
            "ARCCmd to two points on a line with the tool",
            {
                let mut acts = queued(ptp(PtpMode::MovjXyz, [200.0, 0.0, 0.0, 0.0]));
                acts.extend(arc([200.0, 20.0, 0.0, 0.0], [200.0, 40.0, 0.0, 0.0]));
                acts
            },
        ),
        claim(
            Alarm::PlanJumpParam,
            Arises::Never {
                says: "a jump that begins or ends above zLimit goes across at the higher of its two ends",
                tried: vec![vec![
                    Act::Now(Set::PtpJumpParams(PtpJumpParams {
                        jump_height: 20.0,
                        z_limit: -50.0,
                    })),
                    Act::Queue(ptp(PtpMode::JumpXyz, [200.0, 40.0, 0.0, 0.0])),
                    Act::Rest,
                ]],
            },
        ),
        when(
            Alarm::PlanSpeedInputParam,
            "PTPCmd after PTPJointParams with a velocity of 0 (an alarm of the sibling's list, for want of another)",
            vec![
                Act::Now(Set::PtpJointParams(PtpJointParams {
                    velocity: [0.0; 4],
                    acceleration: [100.0; 4],
                })),
                Act::Queue(ptp(PtpMode::MovjAngle, [10.0, 45.0, 45.0, 0.0])),
                Act::Rest,
            ],
        ),
    ]
}

fn on_the_way() -> Vec<Claim> {
    let from_to = |bias, from, to| {
        vec![
            Act::Now(bias),
            Act::Queue(ptp(PtpMode::MovjXyz, from)),
            Act::Queue(ptp(PtpMode::MovlXyz, to)),
            Act::Rest,
        ]
    };
    vec![
        claim(
            Alarm::MoveInvSingularity,
            Arises::Never {
                says: "a straight line to an elbow straight or folded meets the limit of J2 - J3 before, and one \
                    over the base axis raises 0x21 or 0x22",
                tried: vec![
                    from_to(
                        bias(-150.0, 0.0),
                        [10.0, -60.0, 0.0, 0.0],
                        [-10.0, 60.0, 0.0, 0.0],
                    ),
                    from_to(
                        bias(0.0, 0.0),
                        [30.0, 180.0, 0.0, 0.0],
                        [30.0, -180.0, 0.0, 0.0],
                    ),
                ],
            },
        ),
        when(
            Alarm::MoveInvCalc,
            "PTPCmd MOVL_XYZ past the base axis, nearer than a tool bias of 20 mm sideways allows",
            from_to(
                bias(-150.0, -20.0),
                [10.0, -60.0, 0.0, 0.0],
                [2.0, 60.0, 0.0, 0.0],
            ),
        ),
        when(
            Alarm::MoveInvLimit,
            "PTPCmd MOVL_XYZ from one side of the base to the other, too near to it on its way",
            from_to(
                bias(0.0, 0.0),
                [30.0, 180.0, 0.0, 0.0],
                [30.0, -180.0, 0.0, 0.0],
            ),
        ),
    ]
}

fn overspeed() -> Vec<Claim> {
    const CAPPED: &str = "speeds are capped when a motion is planned, and a virtual joint turns as fast as it is told";
    (Alarm::OverspeedAxis1..=Alarm::OverspeedAxis4)
        .map(|code| claim(code, Arises::Injected(CAPPED)))
        .collect()
}

fn limits() -> Vec<Claim> {
    use JogCommand::*;
    [
        (
            Alarm::LimitAxis1Pos,
            [170.0, 45.0, 45.0, 0.0],
            "J1-",
            Axis1Minus,
        ),
        (
            Alarm::LimitAxis1Neg,
            [-170.0, 45.0, 45.0, 0.0],
            "J1+",
            Axis1Plus,
        ),
        (
            Alarm::LimitAxis2Pos,
            [0.0, 99.0, 80.0, 0.0],
            "J2-",
            Axis2Minus,
        ),
        (
            Alarm::LimitAxis2Neg,
            [0.0, -60.0, 0.0, 0.0],
            "J2+",
            Axis2Plus,
        ),
        (
            Alarm::LimitAxis3Pos,
            [0.0, 45.0, 120.0, 0.0],
            "J3-",
            Axis3Minus,
        ),
        (
            Alarm::LimitAxis3Neg,
            [0.0, 0.0, -60.0, 0.0],
            "J3+",
            Axis3Plus,
        ),
        (
            Alarm::LimitAxis4Pos,
            [0.0, 45.0, 45.0, 170.0],
            "J4-",
            Axis4Minus,
        ),
        (
            Alarm::LimitAxis4Neg,
            [0.0, 45.0, 45.0, -170.0],
            "J4+",
            Axis4Plus,
        ),
        (
            Alarm::LimitAxis23Pos,
            [0.0, 80.0, 0.0, 0.0],
            "J2-",
            Axis2Minus,
        ),
        (
            Alarm::LimitAxis23Neg,
            [0.0, 0.0, 85.0, 0.0],
            "J3-",
            Axis3Minus,
        ),
    ]
    .into_iter()
    .map(|(code, joints, jog, command)| limit(code, joints, jog, command))
    .collect()
}

fn limit(code: u8, joints: [f32; 4], jog: &str, command: JogCommand) -> Claim {
    let [j1, j2, j3, j4] = joints;
    let jogs = |cmd| {
        Act::Now(Set::JogCmd(JogCmd {
            is_joint: Flag::ON,
            cmd,
        }))
    };
    Claim {
        goes: Goes::Inside {
            says: format!("JOGCmd {jog}"),
            back: vec![jogs(command), Act::Pass, jogs(JogCommand::Stop), Act::Rest],
        },
        ..when(
            code,
            format!("PTPCmd MOVJ_ANGLE to ({j1}, {j2}, {j3}, {j4})"),
            vec![Act::Queue(ptp(PtpMode::MovjAngle, joints)), Act::Rest],
        )
    }
}

fn lost_steps() -> Vec<Claim> {
    vec![
        lost_step(Alarm::LoseStepAxis1, 1),
        lost_step(Alarm::LoseStepAxis2, 2),
        lost_step(Alarm::LoseStepAxis3, 3),
        claim(
            Alarm::LoseStepAxis4,
            Arises::Never {
                says: "J4 has no sensor that could tell",
                tried: vec![slipped(4)],
            },
        ),
    ]
}

fn lost_step(code: u8, joint: u8) -> Claim {
    Claim {
        goes: Goes::UntilHomed { look: look() },
        ..when(
            code,
            format!("J{joint} slips by 6 degrees, and LostStepCmd looks"),
            slipped(joint),
        )
    }
}

fn slipped(joint: u8) -> Vec<Act> {
    let degrees = 6.0;
    let mut acts = vec![Act::Happen(ExternalEvent::Slip { joint, degrees })];
    acts.extend(look());
    acts
}

/// A look at whether steps are lost; at once, for an alarm would hold it in the queue.
fn look() -> Vec<Act> {
    vec![Act::Now(Set::LostStepCmd(LostStepCmd {}))]
}

fn on_the_axis() -> Vec<Act> {
    vec![
        Act::Now(bias(-150.0, 0.0)),
        Act::Queue(ptp(PtpMode::MovjXyz, [0.0; 4])),
        Act::Rest,
    ]
}

/// A point-to-point command.
pub(super) fn ptp(ptp_mode: PtpMode, [x, y, z, r]: [f32; 4]) -> Set {
    Set::PtpCmd(PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    })
}

fn arc_through(cir_point: [f32; 4], to_point: [f32; 4]) -> Set {
    Set::ArcCmd(ArcCmd {
        cir_point,
        to_point,
    })
}

fn bias(x_bias: f32, y_bias: f32) -> Set {
    Set::EndEffectorParams(EndEffectorParams {
        x_bias,
        y_bias,
        z_bias: 0.0,
    })
}
