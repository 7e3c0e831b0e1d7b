//! The fence of an arm, by every way to send a command.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::build::{self, Axis, JogDirection};
use magician::commands::{
    ArcCmd, ArcParams, CircleCmd, CpParams, EndEffectorParams, JogCommonParams, PtpCmd,
    PtpCoordinateParams, PtpJointParams, QueuedCmdStartDownload, QueuedCmdStartExec,
};
use magician::preflight::Guards;
use magician::protocol::{Flag, FrameBuf, PtpMode};
use magician::sim::{ArmInstant, ControllerState};
use magician::{
    Act, Action, Arm, Ctrl, Cuboid, ErrorKind, Fence, FencePart, Options, RunOptions, Set,
    VirtualArm,
};
use tokio::time::sleep;

use crate::desk::{Desk, only_reads};

/// Tolerance beyond a fence, mm: see `Fence`.
const TOLERANCE: f64 = 0.011;

fn floor() -> Fence {
    Fence::default().with_floor(-60.0).unwrap()
}

async fn fenced(desk: &Desk, fence: Fence) -> Arm {
    desk.connect(Options::default().fence(fence)).await
}

fn line(x: f32, y: f32, z: f32) -> PtpCmd {
    let (ptp_mode, r) = (PtpMode::MovlXyz, 0.0);
    PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    }
}

#[tokio::test(start_paused = true)]
async fn no_door_lets_a_motion_through() {
    let desk = Desk::new();
    let arm = fenced(&desk, floor()).await;
    let command = Set::from(line(220.0, 0.0, -71.2));
    let frame = FrameBuf::set(&command, Ctrl::SET).unwrap();
    let (id, params) = (frame.frame().id(), frame.frame().params());
    let outcomes = [
        arm.set_any(&command).await.err(),
        arm.enqueue_set(&command).await.err(),
        arm.enqueue_form(id, params).await.err(),
        arm.raw(id, Ctrl::SET, params).await.err(),
        arm.raw(id, Ctrl::QUEUED, params).await.err(),
        arm.run(&[command]).await.err(),
        arm.run_with(
            &[command],
            RunOptions::default().guards(Guards::NONE),
            |_| {},
        )
        .await
        .err(),
        arm.start([command]).wait(|_| {}).await.err(),
    ];
    for (door, error) in outcomes.into_iter().enumerate() {
        let error = error.unwrap_or_else(|| panic!("door {door}"));
        assert_eq!(error.kind(), ErrorKind::Unreachable, "door {door}: {error}");
        let breach = error.breach().expect("data");
        assert_eq!((breach.part, breach.limit), (FencePart::Floor, -60.0));
        let message = error.to_string();
        let said = "the tool tip would be at z -71.2 mm, the fence's floor is -60.0 mm";
        assert!(message.contains(said), "door {door}: {message}");
    }
    assert!(only_reads(&desk.heard()));
    // Inside the fence commands pass, one by one, and relative to the end of the queue.
    arm.enqueue(&line(220.0, 0.0, -50.0)).await.unwrap();
    let down = build::line_by(0.0, 0.0, -11.0, 0.0);
    assert!(arm.enqueue_set(&down).await.is_err());
    let down = build::line_by(0.0, 0.0, -10.0, 0.0);
    let last = arm.enqueue_set(&down).await.unwrap();
    arm.queue().start().await.unwrap();
    arm.wait(last).await.unwrap();
    let z = desk.with(|arm| arm.state().pose.z);
    assert!((z + 60.0).abs() < 1e-3, "{z}");
}

#[tokio::test(start_paused = true)]
async fn what_cannot_be_checked_says_what_to_do() {
    let desk = Desk::new();
    let arm = desk
        .connect(Options::default().fence(floor()).allow_laser(true))
        .await;
    let free = desk.connect(Options::default()).await;
    let jog = Set::from(build::Axis::J1.plus());
    let error = arm.set_any(&jog).await.unwrap_err();
    assert_eq!(error.remedies()[0].act, Act::Do(Action::Jog), "{error}");
    let store = QueuedCmdStartDownload {
        total_loop: 1,
        line_per_loop: 1,
    };
    assert!(arm.set(&store).await.is_err());
    assert!(
        arm.raw(200, Ctrl::SET, &[]).await.is_err(),
        "an id that nobody knows"
    );
    assert!(only_reads(&desk.heard()));
    // Commands of another program wait.
    free.enqueue(&line(220.0, 0.0, -80.0)).await.unwrap();
    desk.heard();
    let refused = [
        arm.enqueue(&line(220.0, 0.0, 0.0)).await.err(),
        arm.set(&QueuedCmdStartExec {}).await.err(),
        arm.set(&line(220.0, 0.0, 0.0)).await.err(),
        arm.start_with(
            [Set::from(line(220.0, 0.0, 0.0))],
            RunOptions::default().keep(true),
        )
        .wait(|_| {})
        .await
        .err(),
    ];
    for error in refused {
        let error = error.expect("it would run what nobody checked");
        assert_eq!(error.guard(), Some("fence"), "{error}");
        assert_eq!(error.remedies()[0].act, Act::Do(Action::Stop), "{error}");
    }
    assert!(only_reads(&desk.heard()));
    arm.stop().await.unwrap();
    arm.set(&line(220.0, 0.0, 0.0)).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn settings_do_not_change_under_what_was_checked_with_others() {
    let desk = Desk::new();
    let fence = Fence::default().with_top_speed(120.0).unwrap();
    let arm = fenced(&desk, fence).await;
    arm.enqueue(&line(220.0, 0.0, 0.0)).await.unwrap();
    let fast = PtpCoordinateParams {
        xyz_velocity: 400.0,
        r_velocity: 100.0,
        xyz_acceleration: 400.0,
        r_acceleration: 100.0,
    };
    assert!(arm.set(&fast).await.is_err(), "while a command waits");
    arm.enqueue(&fast).await.unwrap();
    let error = arm.enqueue(&line(220.0, 150.0, 0.0)).await.unwrap_err();
    assert_eq!(
        error.breach().map(|breach| breach.part),
        Some(FencePart::TopSpeed)
    );
    assert_eq!(error.unit(), Some("mm/s"));
}

#[tokio::test(start_paused = true)]
async fn a_queue_does_not_go_on_from_where_it_was_not_checked() {
    let desk = Desk::new();
    let arm = fenced(&desk, floor()).await;
    arm.enqueue(&line(220.0, 0.0, 20.0)).await.unwrap();
    arm.enqueue_set(&build::line_by(0.0, 0.0, -70.0, 0.0))
        .await
        .unwrap();
    arm.queue().start().await.unwrap();
    sleep(Duration::from_millis(300)).await;
    arm.set(&magician::commands::QueuedCmdForceStopExec {})
        .await
        .unwrap();
    arm.wait_still().await.unwrap();
    let error = arm.queue().start().await.unwrap_err();
    assert_eq!(error.guard(), Some("fence"), "{error}");
    arm.stop().await.unwrap();
    arm.enqueue(&line(220.0, 0.0, 20.0)).await.unwrap();
    arm.queue().start().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn without_a_fence_no_frame_is_added() {
    let frames = async |options: Options| {
        let desk = Desk::new();
        let arm = desk.connect(options).await;
        desk.heard();
        arm.enqueue(&line(220.0, 0.0, 0.0)).await.unwrap();
        arm.queue().start().await.unwrap();
        desk.heard().len()
    };
    assert_eq!(
        frames(Options::default()).await,
        frames(Options::default().fence(Fence::default())).await
    );
    assert!(frames(Options::default().fence(floor())).await > frames(Options::default()).await);
}

#[tokio::test(start_paused = true)]
async fn a_jog_stops_before_the_fence() {
    for (direction, joint) in [(Axis::Z.minus(), false), (Axis::J3.plus(), true)] {
        let desk = Desk::new();
        let low = if joint { -40.0 } else { -60.0 };
        let fence = Fence::default().with_floor(low).unwrap();
        let arm = fenced(&desk, fence).await;
        let lowest = Arc::new(Mutex::new(f64::INFINITY));
        let seen = Arc::clone(&lowest);
        desk.watched_by(move |state| {
            let mut lowest = seen.lock().unwrap();
            *lowest = lowest.min(state.pose.z);
        });
        let mut ends = 0;
        for _ in 0..12 {
            let jog = match arm.jog(direction).await {
                Ok(jog) => jog,
                Err(error) => {
                    let breach = error.breach().copied();
                    assert_eq!(
                        breach.map(|breach| breach.part),
                        Some(FencePart::Floor),
                        "{error}"
                    );
                    break;
                }
            };
            let mut error = None;
            for _ in 0..100 {
                sleep(Duration::from_millis(100)).await;
                error = jog.keep().err();
                if error.is_some() {
                    break;
                }
            }
            let error = error.expect("the fence");
            assert_eq!(error.kind(), ErrorKind::Unreachable, "{error}");
            jog.stop().await.ok();
            ends += 1;
        }
        let lowest = *lowest.lock().unwrap();
        assert!((low..low + 5.0).contains(&lowest), "{lowest} after {ends}");
        assert!(ends >= 1);
        // Away from the fence the jog is not limited.
        let up = build::Axis::Z.plus();
        let jog = arm.jog(up).await.unwrap();
        sleep(Duration::from_millis(200)).await;
        jog.keep().unwrap();
        jog.stop().await.unwrap();
    }
}

/// Random numbers from a seed.
struct Dice(u64);

impl Dice {
    fn unit(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    fn one_of(&mut self, count: u32) -> u32 {
        ((self.unit() * count as f32) as u32).min(count - 1)
    }

    fn point(&mut self) -> [f32; 4] {
        let (turn, far) = (self.within(-1.4, 1.4), self.within(180.0, 300.0));
        [
            far * turn.cos(),
            far * turn.sin(),
            self.within(-70.0, 90.0),
            self.within(-60.0, 60.0),
        ]
    }

    fn fence(&mut self) -> Fence {
        let mut fence = Fence::default();
        if self.one_of(4) > 0 {
            fence = fence.with_floor(self.within(-50.0, -25.0).into()).unwrap();
        }
        if self.one_of(3) == 0 {
            let within = Cuboid {
                min: [-350.0, -300.0, -80.0],
                max: [
                    self.within(265.0, 310.0).into(),
                    self.within(100.0, 250.0).into(),
                    120.0,
                ],
            };
            fence = fence.with_box(within).unwrap();
        }
        for _ in 0..self.one_of(4) {
            let [x, y, z, _] = self.point();
            let size = self.within(5.0, 70.0);
            // At power-up the arm is at x 259, y 0.
            let y = if y < 0.0 { y - size - 5.0 } else { y + 5.0 };
            let min = [x, y, z].map(f64::from);
            let max = min.map(|at| at + f64::from(size));
            fence = fence.with_keep_out(Cuboid { min, max }).unwrap();
        }
        if self.one_of(4) == 0 {
            fence = fence
                .with_top_speed(self.within(60.0, 200.0).into())
                .unwrap();
        }
        fence
    }

    fn command(&mut self) -> Set {
        let [x, y, z, r] = self.point();
        let mode = |mode, [x, y, z, r]: [f32; 4]| {
            Set::from(PtpCmd {
                ptp_mode: mode,
                x,
                y,
                z,
                r,
            })
        };
        match self.one_of(22) {
            0 | 1 => mode(PtpMode::MovjXyz, [x, y, z, r]),
            2 | 3 => mode(PtpMode::MovlXyz, [x, y, z, r]),
            4 | 5 => mode(PtpMode::JumpXyz, [x, y, z, r]),
            6 => mode(PtpMode::JumpMovlXyz, [x, y, z, r]),
            7 => {
                let joints = [
                    self.within(-80.0, 80.0),
                    self.within(10.0, 70.0),
                    self.within(10.0, 70.0),
                    0.0,
                ];
                let modes = [PtpMode::MovjAngle, PtpMode::MovlAngle, PtpMode::JumpAngle];
                mode(modes[self.one_of(3) as usize], joints)
            }
            8 => mode(
                PtpMode::MovjAngleInc,
                [0.0; 4].map(|_: f32| self.within(-15.0, 15.0)),
            ),
            9 => mode(
                PtpMode::MovlXyzInc,
                [0.0; 4].map(|_: f32| self.within(-40.0, 40.0)),
            ),
            10 => mode(
                PtpMode::MovjXyzInc,
                [0.0; 4].map(|_: f32| self.within(-40.0, 40.0)),
            ),
            11 => ArcCmd {
                cir_point: self.point(),
                to_point: [x, y, z, r],
            }
            .into(),
            12 => CircleCmd {
                cir_point: self.point(),
                to_point: [x, y, z, r],
                count: 1 + self.one_of(2),
            }
            .into(),
            13..=15 => build::path_to(x, y, z),
            16 => build::path_by(
                self.within(-30.0, 30.0),
                self.within(-30.0, 30.0),
                self.within(-20.0, 20.0),
            ),
            17 => EndEffectorParams {
                x_bias: self.within(0.0, 70.0),
                y_bias: 0.0,
                z_bias: self.within(-20.0, 20.0),
            }
            .into(),
            18 => build::speed(self.within(20.0, 100.0), self.within(20.0, 100.0)),
            19 => match self.one_of(3) {
                0 => PtpJointParams {
                    velocity: [self.within(40.0, 300.0); 4],
                    acceleration: [200.0; 4],
                }
                .into(),
                1 => ArcParams {
                    xyz_velocity: self.within(20.0, 200.0),
                    r_velocity: 100.0,
                    xyz_acceleration: 150.0,
                    r_acceleration: 100.0,
                }
                .into(),
                _ => CpParams {
                    plan_acc: 100.0,
                    junction_vel: self.within(20.0, 150.0),
                    acc_or_period: 100.0,
                    real_time_track: Flag::OFF,
                }
                .into(),
            },
            20 => build::jump_height(self.within(5.0, 50.0), self.within(50.0, 120.0)),
            _ => build::home(),
        }
    }

    fn jog(&mut self) -> JogDirection {
        let (joints, space) = ([Axis::J1, Axis::J2, Axis::J3], [Axis::X, Axis::Y, Axis::Z]);
        let way = self.one_of(6) as usize;
        let axes = if self.one_of(2) == 0 { joints } else { space };
        match way % 2 {
            0 => axes[way / 2].plus(),
            _ => axes[way / 2].minus(),
        }
    }
}

/// Returns how far a tip is beyond a fence by the fence's definition, mm.
fn beyond(fence: &Fence, [x, y, z]: [f64; 3]) -> f64 {
    let mut worst = fence.floor().map_or(f64::NEG_INFINITY, |floor| floor - z);
    let sides = |cuboid: &Cuboid| {
        let [a, b, c] = cuboid.min;
        let [d, e, f] = cuboid.max;
        [x - a, d - x, y - b, e - y, z - c, f - z]
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    };
    if let Some(within) = fence.within() {
        worst = worst.max(-sides(&within));
    }
    fence.keep_outs().iter().map(sides).fold(worst, f64::max)
}

/// Worst values observed on an arm.
#[derive(Default)]
struct Seen {
    beyond: f64,
    speed: f64,
    homing: bool,
    before: Option<(ArmInstant, [f64; 3], f64)>,
    ways: f64,
}

impl Seen {
    fn look(&mut self, fence: &Fence, state: &ControllerState) {
        let tip = [state.pose.x, state.pose.y, state.pose.z];
        self.beyond = self.beyond.max(beyond(fence, tip));
        let tool = state.tool.x + 1000.0 * state.tool.z;
        if let Some((at, from, with)) = self.before
            && with == tool
            && state.now > at
        {
            let way: f64 = from
                .iter()
                .zip(tip)
                .map(|(a, b)| (a - b) * (a - b))
                .sum::<f64>()
                .sqrt();
            self.ways += way;
            // A change of tool and the search of homing are no speeds of the program.
            if !self.homing {
                // The pose changes at the end of each period of 20 ms, and is constant in between.
                let ended = |at: ArmInstant| at.as_micros() / 20_000;
                let periods = (ended(state.now) - ended(at)).max(1);
                self.speed = self.speed.max(way / (0.02 * periods as f64));
            }
        }
        self.before = Some((state.now, tip, tool));
    }
}

/// Sends a program by one way; returns how many commands passed, and how many were refused.
async fn through(door: u32, arm: &Arm, program: &[Set]) -> [u64; 2] {
    let mut told = [0, 0];
    let mut count = |passed: bool| told[usize::from(!passed)] += 1;
    match door {
        0 | 1 => {
            for few in program.chunks(2) {
                let ran = match door {
                    0 => arm.run(few).await,
                    _ => arm.start(few.iter().copied()).wait(|_| {}).await,
                };
                count(ran.is_ok());
            }
        }
        2 | 3 => {
            for command in program {
                let passed = match door {
                    2 => arm.enqueue_set(command).await.is_ok(),
                    _ => {
                        let frame = FrameBuf::set(command, Ctrl::QUEUED).unwrap();
                        arm.raw(frame.frame().id(), Ctrl::QUEUED, frame.frame().params())
                            .await
                            .is_ok()
                    }
                };
                count(passed);
            }
            arm.queue().start().await.ok();
            sleep(Duration::from_secs(40)).await;
            arm.wait_still().await.ok();
        }
        4 => {
            for command in program {
                count(arm.set_any(command).await.is_ok());
            }
        }
        5 => {
            // Two handles at once.
            let other = arm.clone();
            let (first, second) = program.split_at(program.len() / 2);
            let work = async |arm: &Arm, commands: &[Set]| {
                let mut told = [0, 0];
                for command in commands {
                    let passed = arm.enqueue_set(command).await.is_ok();
                    told[usize::from(!passed)] += 1;
                    arm.queue().start().await.ok();
                }
                told
            };
            let (a, b) = tokio::join!(work(arm, first), work(&other, second));
            sleep(Duration::from_secs(40)).await;
            told = [a[0] + b[0], a[1] + b[1]];
        }
        _ => unreachable!("doors are 0 to 5"),
    }
    told
}

async fn jogs(arm: &Arm, dice: &mut Dice) -> [u64; 2] {
    let mut told = [0, 0];
    for _ in 0..8 {
        let faster = JogCommonParams {
            velocity_ratio: dice.within(20.0, 100.0),
            acceleration_ratio: 100.0,
        };
        arm.set(&faster).await.ok();
        match arm.jog(dice.jog()).await {
            Ok(jog) => {
                told[0] += 1;
                for _ in 0..dice.one_of(40) {
                    sleep(Duration::from_millis(50)).await;
                    if let Err(error) = jog.keep() {
                        told[1] += u64::from(error.kind() == ErrorKind::Unreachable);
                        break;
                    }
                }
                jog.stop().await.ok();
            }
            Err(_) => told[1] += 1,
        }
        // A jog that ended at a limit leaves an alarm.
        arm.clear_alarms().await.ok();
    }
    told
}

/// Random programs and jogs; `MAGICIAN_FENCE_PROGRAMS` sets their number.
#[tokio::test(start_paused = true)]
async fn no_tip_crosses_the_fence_through_any_door() {
    let count = std::env::var("MAGICIAN_FENCE_PROGRAMS");
    let count: u64 = count
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(140);
    let (mut told, mut ways) = ([[0_u64; 2]; 7], 0.0);
    for nth in 0..count {
        let mut dice = Dice(0x9e37_79b9_7f4a_7c15 ^ (nth + 1).wrapping_mul(0x2545_f491_4f6c_dd1d));
        let fence = dice.fence();
        let desk = Desk::new();
        let seen = Arc::new(Mutex::new(Seen::default()));
        let witness = Arc::clone(&seen);
        desk.watched_by(move |state| witness.lock().unwrap().look(&fence, state));
        let arm = fenced(&desk, fence).await;
        arm.clear_alarms().await.unwrap();
        let door = nth % 7;
        let program: Vec<Set> = (0..3 + dice.one_of(8)).map(|_| dice.command()).collect();
        seen.lock().unwrap().homing = program
            .iter()
            .any(|command| matches!(command, Set::HomeCmd(_)));
        let [passed, refused] = match door {
            6 => jogs(&arm, &mut dice).await,
            door => through(door as u32, &arm, &program).await,
        };
        desk.with(|_| ());
        let seen = seen.lock().unwrap();
        assert!(
            seen.beyond <= TOLERANCE,
            "program {nth} through door {door}: {} mm beyond {fence:?}\n{program:#?}",
            seen.beyond
        );
        if let Some(top) = fence.top_speed() {
            assert!(
                seen.speed <= top * 1.01 + 0.5,
                "program {nth} through door {door}: {} mm/s beyond {top}\n{program:#?}",
                seen.speed
            );
        }
        ways += seen.ways;
        told[door as usize][0] += passed;
        told[door as usize][1] += refused;
    }
    println!(
        "passed and refused by door: {told:?}, {:.1} m of way",
        ways / 1000.0
    );
    if count >= 100 {
        for (door, [passed, refused]) in told.iter().enumerate() {
            assert!(*passed > 0 && *refused > 0, "door {door}: {told:?}");
        }
    }
}

#[tokio::test(start_paused = true)]
async fn a_virtual_arm_in_this_process_is_held_as_well() {
    let options = Options::default().fence(floor());
    let arm = Arm::simulated(VirtualArm::default(), options)
        .await
        .unwrap();
    assert!(
        arm.run(&[build::line_to(220.0, 0.0, -70.0, 0.0)])
            .await
            .is_err()
    );
    arm.run(&[build::line_to(220.0, 0.0, -60.0, 0.0)])
        .await
        .unwrap();
    arm.home().await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_fence_that_is_set_later_holds_at_once_and_ends_what_was_checked_without_it() {
    let desk = Desk::new();
    let arm = desk.connect(Options::default()).await;
    arm.set(&line(220.0, 0.0, 50.0)).await.unwrap();
    arm.wait_still().await.unwrap();
    arm.set(&line(220.0, 0.0, -80.0)).await.unwrap();
    sleep(Duration::from_millis(200)).await;
    assert!(desk.with(|arm| arm.state().moving));
    let clone = arm.clone();
    let holds = clone.set_fence(Some(floor()));
    // In effect before the future is awaited.
    assert_eq!(arm.fence(), Some(floor()));
    holds.await.unwrap();
    let low = || desk.with(|arm| arm.state().pose.z) < -60.011;
    assert!(!low() && !arm.moving());
    sleep(Duration::from_secs(3)).await;
    assert!(!low());
    let error = arm
        .run(&[Set::from(line(220.0, 0.0, -80.0))])
        .await
        .unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unreachable, "{error}");
    // The same fence again stops nothing, nor does no fence.
    arm.enqueue(&line(220.0, 0.0, 20.0)).await.unwrap();
    let stops = arm.stops();
    arm.set_fence(Some(floor())).await.unwrap();
    arm.set_fence(None).await.unwrap();
    assert_eq!((arm.stops(), arm.fence()), (stops, None));
    arm.stop().await.unwrap();
    arm.run(&[Set::from(line(220.0, 0.0, -70.0))])
        .await
        .unwrap();
    assert!(low());
}
