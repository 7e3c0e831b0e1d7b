//! Motion modes that have a picture.

use std::time::Duration;

use magician_protocol::commands::*;
use magician_protocol::{CpMode, Flag, JogCommand, PtpMode, Set};

/// Picture of one mode.
pub(super) struct Mode {
    /// File name.
    pub(super) name: &'static str,
    pub(super) title: &'static str,
    /// Description of the commands.
    pub(super) description: &'static str,
    /// Commands that are queued before the picture begins.
    pub(super) before: fn() -> Vec<Set>,
    /// Steps that the picture shows.
    pub(super) steps: fn() -> Vec<Step>,
}

/// Step of a run.
pub(super) enum Step {
    Queue(Set),
    Now(Set),
    Pass(Duration),
}

const SECOND: Duration = Duration::from_secs(1);

pub(super) const MODES: &[Mode] = &[
    Mode {
        name: "movj",
        title: "MOVJ_XYZ: joints together",
        description: "PTP mode 1 to (120, 180, 60) and on to (230, -90, -20) at ratio 100.",
        before: full_ratio,
        steps: || {
            points(
                PtpMode::MovjXyz,
                &[[120.0, 180.0, 60.0, 0.0], [230.0, -90.0, -20.0, 0.0]],
            )
        },
    },
    Mode {
        name: "movl",
        title: "MOVL_XYZ: a straight line",
        description: "PTP mode 2 through the same two points: straight in space, crooked in the joints.",
        before: full_ratio,
        steps: || {
            points(
                PtpMode::MovlXyz,
                &[[120.0, 180.0, 60.0, 0.0], [230.0, -90.0, -20.0, 0.0]],
            )
        },
    },
    Mode {
        name: "jump",
        title: "JUMP_XYZ: up, across by the joints, down",
        description: "PTP mode 0 from (200, 120, -40) to (220, -110, -20), jump height 60 mm, limit 100 mm.",
        before: || jump_from([200.0, 120.0, -40.0, 0.0]),
        steps: || points(PtpMode::JumpXyz, &[[220.0, -110.0, -20.0, 0.0]]),
    },
    Mode {
        name: "jump-uneven",
        title: "JUMP_XYZ with unequal heights",
        description: "PTPJump2Params 80 mm at the start and 30 mm at the end: the transfer descends on its way.",
        before: || {
            let heights = Set::PtpJump2Params(PtpJump2Params {
                start_jump_height: 80.0,
                end_jump_height: 30.0,
                z_limit: 100.0,
            });
            [jump_from([200.0, 120.0, -40.0, 0.0]), vec![heights]].concat()
        },
        steps: || points(PtpMode::JumpXyz, &[[220.0, -110.0, -20.0, 0.0]]),
    },
    Mode {
        name: "jump-angle",
        title: "JUMP_ANGLE: a jump to joint angles",
        description: "PTP mode 3 to (-30, 40, 50, 20) deg.",
        before: || jump_from([200.0, 120.0, -40.0, 0.0]),
        steps: || points(PtpMode::JumpAngle, &[[-30.0, 40.0, 50.0, 20.0]]),
    },
    Mode {
        name: "jump-movl",
        title: "JUMP_MOVL_XYZ: up, straight across, down",
        description: "PTP mode 9 between the same points.",
        before: || jump_from([200.0, 120.0, -40.0, 0.0]),
        steps: || points(PtpMode::JumpMovlXyz, &[[220.0, -110.0, -20.0, 0.0]]),
    },
    Mode {
        name: "movj-angle",
        title: "MOVJ_ANGLE: joints to angles",
        description: "PTP mode 4 to (60, 20, 30, -40) and (-45, 60, 50, 30) deg: a law for each joint, all end together.",
        before: full_ratio,
        steps: || {
            points(
                PtpMode::MovjAngle,
                &[[60.0, 20.0, 30.0, -40.0], [-45.0, 60.0, 50.0, 30.0]],
            )
        },
    },
    Mode {
        name: "movl-angle",
        title: "MOVL_ANGLE: a straight line to joint angles",
        description: "PTP mode 5 to (40, 30, 30, 0) deg.",
        before: full_ratio,
        steps: || points(PtpMode::MovlAngle, &[[40.0, 30.0, 30.0, 0.0]]),
    },
    Mode {
        name: "movj-inc",
        title: "MOVJ_INC: increments of the joints",
        description: "PTP mode 6 by (60, -20, -10, 45) deg, and by (-90, 10, 20, 0).",
        before: full_ratio,
        steps: || {
            points(
                PtpMode::MovjAngleInc,
                &[[60.0, -20.0, -10.0, 45.0], [-90.0, 10.0, 20.0, 0.0]],
            )
        },
    },
    Mode {
        name: "movj-xyz-inc",
        title: "MOVJ_XYZ_INC: increments along the axes, by the joints",
        description: "PTP mode 8 by (30, 100, 60, 0) and by (-40, -180, -60, 0).",
        before: full_ratio,
        steps: || {
            points(
                PtpMode::MovjXyzInc,
                &[[30.0, 100.0, 60.0, 0.0], [-40.0, -180.0, -60.0, 0.0]],
            )
        },
    },
    Mode {
        name: "rail",
        title: "MOVL_XYZ with the rail",
        description: "PTPWithLCmd to (230, -60, 20) and 120 mm along the rail: both begin and end together, the slower one sets the time. The base of the pictures travels with the arm.",
        before: || {
            let rail = Set::SetDeviceWithL(SetDeviceWithL {
                with_l: Flag::ON,
                version: None,
            });
            [full_ratio(), vec![rail]].concat()
        },
        steps: || {
            vec![Step::Queue(Set::PtpWithLCmd(PtpWithLCmd {
                ptp_mode: PtpMode::MovlXyz,
                x: 230.0,
                y: -60.0,
                z: 20.0,
                r: 0.0,
                l: 120.0,
            }))]
        },
    },
    Mode {
        name: "movl-inc",
        title: "MOVL_XYZ_INC: increments along the axes",
        description: "PTP mode 7 four times: a square of 80 mm, each side counted from where the one before ended.",
        before: full_ratio,
        steps: || {
            let sides = [[0.0, 80.0], [60.0, 0.0], [0.0, -80.0], [-60.0, 0.0]];
            points(PtpMode::MovlXyzInc, &sides.map(|[x, y]| [x, y, 0.0, 0.0]))
        },
    },
    Mode {
        name: "limit",
        title: "MOVL_XYZ into a limit",
        description: "PTP mode 2 from (60, 170, -90) to (60, -170, -90): both ends can be reached, the middle cannot. The arm stops there and raises an alarm.",
        before: || {
            [
                full_ratio(),
                vec![ptp(PtpMode::MovjXyz, [60.0, 170.0, -90.0, 0.0])],
            ]
            .concat()
        },
        steps: || points(PtpMode::MovlXyz, &[[60.0, -170.0, -90.0, 0.0]]),
    },
    Mode {
        name: "force-stop",
        title: "ForceStop in a MOVJ",
        description: "A long MOVJ, stopped after 0.6 s: the joints brake together at twice the acceleration.",
        before: full_ratio,
        steps: || {
            let stop = Set::QueuedCmdForceStopExec(QueuedCmdForceStopExec {});
            vec![
                Step::Queue(ptp(PtpMode::MovjAngle, [100.0, 20.0, 10.0, 0.0])),
                Step::Pass(6 * SECOND / 10),
                Step::Now(stop),
            ]
        },
    },
    Mode {
        name: "arc",
        title: "ARC: through one point to another",
        description: "ARCCmd from (200, -100, 0) through (260, 0, 40) to (200, 100, 0): round in a tilted plane.",
        before: || {
            [
                full_ratio(),
                vec![ptp(PtpMode::MovjXyz, [200.0, -100.0, 0.0, 0.0])],
            ]
            .concat()
        },
        steps: || {
            vec![Step::Queue(Set::ArcCmd(ArcCmd {
                cir_point: [260.0, 0.0, 40.0, 0.0],
                to_point: [200.0, 100.0, 0.0, 0.0],
            }))]
        },
    },
    Mode {
        name: "circle",
        title: "CIRCLE: a full turn",
        description: "CircleCmd through (240, 40, 0) and (200, 80, 0), one turn, back to where it began.",
        before: || {
            [
                full_ratio(),
                vec![ptp(PtpMode::MovjXyz, [200.0, 0.0, 0.0, 0.0])],
            ]
            .concat()
        },
        steps: || {
            vec![Step::Queue(Set::CircleCmd(CircleCmd {
                cir_point: [240.0, 40.0, 0.0, 0.0],
                to_point: [200.0, 80.0, 0.0, 0.0],
                count: 1,
            }))]
        },
    },
    Mode {
        name: "cp",
        title: "CP: a continuous path",
        description: "CPCmd, 30 segments round a rosette at planAcc 400, junctionVel 100: it slows where the path turns and never stops on the way.",
        before: || {
            let cp = Set::CpParams(CpParams {
                plan_acc: 400.0,
                junction_vel: 100.0,
                acc_or_period: 400.0,
                real_time_track: Flag::OFF,
            });
            [
                full_ratio(),
                vec![cp, ptp(PtpMode::MovjXyz, [250.0, 0.0, -30.0, 0.0])],
            ]
            .concat()
        },
        steps: rosette,
    },
    Mode {
        name: "cp-corner",
        title: "CP: corners",
        description: "CPCmd round a square, seven segments a side: full speed along a side, nearly none at a corner.",
        before: || {
            let cp = Set::CpParams(CpParams {
                plan_acc: 400.0,
                junction_vel: 100.0,
                acc_or_period: 400.0,
                real_time_track: Flag::OFF,
            });
            [
                full_ratio(),
                vec![cp, ptp(PtpMode::MovjXyz, [200.0, -40.0, -30.0, 0.0])],
            ]
            .concat()
        },
        steps: square,
    },
    Mode {
        name: "cp-real-time",
        title: "CP in real time",
        description: "The same square with realTimeTrack and a period of 100 ms: a segment of 8.6 mm a period, without regard to corners.",
        before: || {
            let cp = Set::CpParams(CpParams {
                plan_acc: 400.0,
                junction_vel: 100.0,
                acc_or_period: 100.0,
                real_time_track: Flag::ON,
            });
            [
                full_ratio(),
                vec![cp, ptp(PtpMode::MovjXyz, [200.0, -40.0, -30.0, 0.0])],
            ]
            .concat()
        },
        steps: square,
    },
    Mode {
        name: "jog-change",
        title: "JOG of another axis",
        description: "JOGCmd Z+ for 1 s, then X+ for 1 s: the second takes over the speed of the first, with its sign, as a [recorded arm](../reference/MODEL.md#section-7) does.",
        before: jog_ratio,
        steps: || {
            vec![
                Step::Now(jog(false, JogCommand::Axis3Plus)),
                Step::Pass(SECOND),
                Step::Now(jog(false, JogCommand::Axis1Plus)),
                Step::Pass(SECOND),
                Step::Now(jog(false, JogCommand::Stop)),
            ]
        },
    },
    Mode {
        name: "jog-limit",
        title: "JOG into a limit",
        description: "JOGCmd J2+ until J2 or its coupling with J3 stands at a limit: the jog ends there with an alarm.",
        before: jog_ratio,
        steps: || vec![Step::Now(jog(true, JogCommand::Axis2Plus))],
    },
    Mode {
        name: "jog-joint",
        title: "JOG of a joint, there and back",
        description: "JOGCmd J1+ for 1.5 s, then J1-, which passes through zero, then stop; ratio 100.",
        before: jog_ratio,
        steps: || {
            vec![
                Step::Now(jog(true, JogCommand::Axis1Plus)),
                Step::Pass(3 * SECOND / 2),
                Step::Now(jog(true, JogCommand::Axis1Minus)),
                Step::Pass(2 * SECOND),
                Step::Now(jog(true, JogCommand::Stop)),
            ]
        },
    },
    Mode {
        name: "jog-line",
        title: "JOG along Y",
        description: "JOGCmd Y+ for 2 s, then stop: the tool goes straight and keeps r, so J4 turns against J1.",
        before: jog_ratio,
        steps: || {
            vec![
                Step::Now(jog(false, JogCommand::Axis2Plus)),
                Step::Pass(2 * SECOND),
                Step::Now(jog(false, JogCommand::Stop)),
            ]
        },
    },
    Mode {
        name: "home",
        title: "HOME: the search for the switch, then the home point",
        description: "HOMECmd: J1 goes negative to its switch, backs off, creeps on, is set; then all joints go home.",
        before: Vec::new,
        steps: || vec![Step::Queue(Set::HomeCmd(HomeCmd { reserved: 0 }))],
    },
];

fn ptp(ptp_mode: PtpMode, [x, y, z, r]: [f32; 4]) -> Set {
    Set::PtpCmd(PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    })
}

fn points(mode: PtpMode, points: &[[f32; 4]]) -> Vec<Step> {
    points
        .iter()
        .map(|point| Step::Queue(ptp(mode, *point)))
        .collect()
}

fn full_ratio() -> Vec<Set> {
    vec![Set::PtpCommonParams(PtpCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    })]
}

fn jog_ratio() -> Vec<Set> {
    vec![Set::JogCommonParams(JogCommonParams {
        velocity_ratio: 100.0,
        acceleration_ratio: 100.0,
    })]
}

fn jump_from(start: [f32; 4]) -> Vec<Set> {
    let heights = Set::PtpJumpParams(PtpJumpParams {
        jump_height: 60.0,
        z_limit: 100.0,
    });
    [full_ratio(), vec![heights, ptp(PtpMode::MovjXyz, start)]].concat()
}

fn jog(is_joint: bool, cmd: JogCommand) -> Set {
    Set::JogCmd(JogCmd {
        is_joint: Flag::from(is_joint),
        cmd,
    })
}

fn segment(x: f64, y: f64) -> Step {
    Step::Queue(Set::CpCmd(CpCmd {
        cp_mode: CpMode::Absolute,
        x: x as f32,
        y: y as f32,
        z: -30.0,
        velocity_or_power: 0.0,
    }))
}

fn rosette() -> Vec<Step> {
    (1..=30)
        .map(|step| {
            let turn = f64::from(step) / 30.0 * std::f64::consts::TAU;
            let radius = 40.0 + 10.0 * (3.0 * turn).cos();
            segment(200.0 + radius * turn.cos(), radius * turn.sin())
        })
        .collect()
}

fn square() -> Vec<Step> {
    let corners = [
        (200.0, -40.0),
        (260.0, -40.0),
        (260.0, 20.0),
        (200.0, 20.0),
        (200.0, -40.0),
    ];
    let sides = corners.windows(2).flat_map(|side| match side {
        [(x0, y0), (x1, y1)] => (1..=7)
            .map(|step| {
                let share = f64::from(step) / 7.0;
                segment(x0 + (x1 - x0) * share, y0 + (y1 - y0) * share)
            })
            .collect::<Vec<_>>(),
        _ => Vec::new(),
    });
    sides.collect()
}
