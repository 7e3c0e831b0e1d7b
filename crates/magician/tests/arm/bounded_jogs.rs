//! Bounded jogs: the arm never has more motion queued than it may complete without further frames.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use magician::build::{self, Axis};
use magician::commands::{
    CpParams, JogCmd, PtpCommonParams, PtpJointParams, SetDeviceWithL, SetEndEffectorLaser,
};
use magician::protocol::{Flag, Frame, JogCommand, RailVersion};
use magician::sim::{Controller, ExternalEvent, LinkId};
use magician::{Arm, Ctrl, ErrorCode, ErrorKind, Fence, Jog, JogOptions, Options, Set};
use tokio::time::{Instant, sleep};

use crate::desk::Desk;

const JOG: u8 = 73;
const PATH: u8 = 91;
const KEEP: Duration = Duration::from_millis(250);

fn bounded() -> Options {
    Options::default().bounded_jogs(true)
}

/// Returns how long the arm still moves without further frames, s.
fn moves_for(arm: &Controller) -> f64 {
    let mut alone = arm.clone();
    let begun = alone.now();
    while alone.busy() {
        alone.advance(alone.now() + Duration::from_millis(1));
        assert!(
            alone.now() - begun < Duration::from_secs(20),
            "it never rests"
        );
    }
    (alone.now() - begun).as_secs_f64()
}

/// Longest remaining motion of a desk's arm, and the number of pieces.
#[derive(Clone, Default)]
struct Seen(Arc<Mutex<(f64, usize)>>);

impl Seen {
    fn of(desk: &Desk) -> Self {
        let seen = Self::default();
        let notes = seen.clone();
        desk.probed_by(move |request, arm| {
            let frame: Frame<'_> = request.frame();
            let jogs = frame.id() == JOG && frame.params().get(1) != Some(&0);
            let moves = moves_for(arm);
            let mut notes = notes.0.lock().unwrap();
            notes.0 = notes.0.max(moves);
            notes.1 += usize::from(jogs);
        });
        seen
    }

    fn longest(&self) -> f64 {
        self.0.lock().unwrap().0
    }

    fn jogs(&self) -> usize {
        self.0.lock().unwrap().1
    }
}

async fn hold(jog: &Jog, keep: Duration, time: Duration) {
    let begun = Instant::now();
    while begun.elapsed() < time {
        jog.keep().unwrap();
        sleep(keep / 4).await;
    }
}

/// Waits for the end of a jog: reading a setting waits for it.
async fn over(arm: &Arm) {
    arm.get::<CpParams>().await.unwrap();
}

async fn on_rail(arm: &Arm) {
    let rail = SetDeviceWithL {
        with_l: Flag::ON,
        version: Some(RailVersion::V2),
    };
    arm.set(&rail).await.unwrap();
    // In the middle of its range.
    arm.run(&[build::rail_by(300.0)]).await.unwrap();
}

fn place(arm: &Controller, axis: Axis) -> f64 {
    let state = arm.state();
    match axis {
        Axis::X => state.pose.x,
        Axis::Y => state.pose.y,
        Axis::Z => state.pose.z,
        Axis::J1 => state.joints.j1,
        Axis::J2 => state.joints.j2,
        Axis::J3 => state.joints.j3,
        Axis::R | Axis::J4 => state.joints.j4,
        Axis::L => state.rail.unwrap(),
    }
}

#[tokio::test(start_paused = true)]
async fn at_every_instant_the_arm_would_stand_in_time() {
    for axis in Axis::ALL {
        for (percent, keep, turnaround) in [
            (10.0, 250, 2),
            (50.0, 250, 16),
            (100.0, 250, 2),
            (100.0, 100, 2),
            (100.0, 100, 30),
            (100.0, 1000, 2),
        ] {
            let desk = Desk::new();
            let arm = desk.connect(bounded()).await;
            if axis == Axis::L {
                on_rail(&arm).await;
            }
            desk.answers_after(Duration::from_millis(turnaround));
            let keep = Duration::from_millis(keep);
            let seen = Seen::of(&desk);
            let options = JogOptions::default().ratio(percent).keep(keep);
            let from = desk.with(|arm| place(arm, axis));
            let jog = arm.jog_with(axis.minus(), options).await.unwrap();
            hold(&jog, keep, Duration::from_millis(1500)).await;
            let way = from - desk.with(|arm| place(arm, axis));
            jog.stop().await.unwrap();
            assert!(!desk.moves());
            let most = (keep + Duration::from_millis(50)).as_secs_f64();
            let longest = seen.longest();
            let what = format!("{} {percent} % {keep:?} {turnaround} ms", axis.name());
            println!("{what}: {way:.2} in 1.5 s, alone {longest:.3} s");
            assert!(longest <= most, "{what}: {longest}");
            assert!(longest > most / 3.0, "{what}: {longest} is no use");
            assert!(way > 0.2, "{what}: {way}");
            assert_eq!(seen.jogs(), 0, "{what}");
        }
    }
}

/// Fastest jog along a line with a hold time of 250 ms, mm/s. The arm has pieces for 40 ms more; of
/// those 290 ms one period is for rounding, and 60 ms are for reads and the next piece. The rest
/// holds one and a half ramps at its 400 mm/s2.
const FASTEST: f64 = 400.0 * (0.29 - 0.02 - 0.06) / 1.5;

/// Lowest share of its speed in any period: pieces are sent as f32, which is 1e-5 mm of the 0.12 mm
/// of a period at 6 mm/s.
const EVEN: f64 = 0.999;

/// Returns the lowest and the mean speed in the middle of a held jog, mm/s or deg/s.
async fn speeds(options: Options, axis: Axis, percent: f32, turnaround: u64) -> (f64, f64) {
    let desk = Desk::new();
    let arm = desk.connect(options).await;
    desk.answers_after(Duration::from_millis(turnaround));
    let options = JogOptions::default().ratio(percent).keep(KEEP);
    let jog = arm.jog_with(axis.minus(), options).await.unwrap();
    // The arm's own jog accelerates for a second.
    hold(&jog, KEEP, Duration::from_millis(1050)).await;
    // The pose changes every 20 ms.
    let step = Duration::from_millis(20);
    let (mut least, mut whole) = (f64::INFINITY, 0.0);
    for nth in 0..25 {
        let before = desk.with(|arm| place(arm, axis));
        sleep(step).await;
        let way = before - desk.with(|arm| place(arm, axis));
        least = least.min(way / step.as_secs_f64());
        whole += way;
        if nth % 2 == 0 {
            jog.keep().unwrap();
        }
    }
    jog.stop().await.unwrap();
    (least, whole / 0.5)
}

#[tokio::test(start_paused = true)]
async fn along_a_line_it_is_as_even_as_the_arms_own_jog() {
    for (axis, percent) in [
        (Axis::X, 50.0),
        (Axis::Y, 50.0),
        (Axis::Z, 10.0),
        (Axis::Z, 50.0),
        (Axis::Z, 100.0),
        (Axis::J1, 50.0),
        (Axis::J1, 100.0),
        (Axis::R, 50.0),
    ] {
        let own = speeds(Options::default(), axis, percent, 2).await;
        for turnaround in [2, 10, 20, 40] {
            let pieces = speeds(bounded(), axis, percent, turnaround).await;
            let (least, mean) = (pieces.0 / own.0, pieces.1 / own.1);
            println!(
                "{} {percent} % {turnaround} ms: least {least:.2}, mean {mean:.2} of JOGCmd's {:.1}",
                axis.name(),
                own.1
            );
            let line = matches!(axis, Axis::X | Axis::Y | Axis::Z);
            assert!(mean <= 1.001, "never faster");
            // At that speed the ramp to rest takes 140 ms. A piece of 40 ms fits when 270 - 140 -
            // 40 = 90 ms of motion are left, and the arm starts to brake at half a ramp, 70 ms. The
            // age of a pose takes up to 20 ms of the difference.
            let at_most = if own.1 > FASTEST { 2 } else { 10 };
            if line && turnaround <= at_most {
                // Pieces are whole periods at that speed, so that none is slowed down to fit.
                assert!(
                    least > EVEN * (FASTEST / own.1).min(1.0),
                    "{} {percent} % {turnaround} ms: {least}",
                    axis.name()
                );
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn the_arm_gets_its_settings_back_however_it_ends() {
    let settings = async |arm: &Arm| {
        let path = arm.get::<CpParams>().await.unwrap();
        let joints = arm.get::<PtpJointParams>().await.unwrap();
        (path, joints, arm.get::<PtpCommonParams>().await.unwrap())
    };
    for axis in [Axis::Z, Axis::J2] {
        let desk = Desk::new();
        let arm = desk.connect(bounded()).await;
        let before = settings(&arm).await;
        let jog = arm.jog(axis.plus()).await.unwrap();
        assert_ne!(settings(&arm).await, before);
        drop(jog);
        over(&arm).await;
        assert!(!desk.moves() && !arm.moving());
        assert_eq!(settings(&arm).await, before, "released");
        let jog = arm.jog(axis.minus()).await.unwrap();
        let next = arm.jog(axis.plus()).await.unwrap();
        assert_eq!(jog.keep().unwrap_err().kind(), ErrorKind::Closed);
        arm.stop().await.unwrap();
        assert_eq!(next.keep().unwrap_err().code(), ErrorCode::Stopped);
        over(&arm).await;
        assert_eq!(settings(&arm).await, before, "replaced, stopped");
        let jog = arm.jog(axis.minus()).await.unwrap();
        desk.unplug();
        sleep(Duration::from_millis(400)).await;
        assert!(!desk.moves());
        assert_eq!(jog.keep().unwrap_err().kind(), ErrorKind::Port);
        desk.plug();
        arm.reconnected().await.unwrap();
        assert_eq!(settings(&arm).await, before, "the line was lost");
    }
}

#[tokio::test(start_paused = true)]
async fn setting_behind_a_released_jog_stays() {
    let speed = CpParams {
        plan_acc: 77.0,
        junction_vel: 33.0,
        acc_or_period: 77.0,
        real_time_track: Flag::OFF,
    };
    let desk = Desk::new();
    let arm = desk.connect(bounded()).await;
    let jog = arm.jog(Axis::Z.plus()).await.unwrap();
    hold(&jog, KEEP, Duration::from_millis(500)).await;
    drop(jog);
    assert!(desk.moves());
    arm.set(&speed).await.unwrap();
    assert!(!desk.moves(), "it waits for the end of the jog");
    assert_eq!(arm.get::<CpParams>().await.unwrap(), speed);
    // Setting something during a jog does not wait, nor does a stop.
    let jog = arm.jog(Axis::Z.minus()).await.unwrap();
    arm.set(&speed).await.unwrap();
    assert!(desk.moves());
    let began = Instant::now();
    arm.stop().await.unwrap();
    assert!(began.elapsed() < Duration::from_millis(300));
    drop(jog);
}

#[tokio::test(start_paused = true)]
async fn settings_owed_over_a_broken_line_keep_no_connection() {
    let desk = Desk::new();
    let arm = desk.connect(bounded()).await;
    let jog = arm.jog(Axis::Z.plus()).await.unwrap();
    desk.unplug();
    sleep(Duration::from_millis(400)).await;
    assert_eq!(jog.keep().unwrap_err().kind(), ErrorKind::Port);
    drop((jog, arm));
    sleep(Duration::from_secs(1)).await;
    desk.heard();
    desk.plug();
    sleep(Duration::from_secs(10)).await;
    assert_eq!(desk.heard(), [], "the connection has ended");
}

#[tokio::test(start_paused = true)]
async fn one_that_is_not_kept_stops_at_once() {
    let desk = Desk::new();
    let arm = desk.connect(bounded()).await;
    let jog = arm
        .jog_with(Axis::Z.plus(), JogOptions::default().keep(KEEP))
        .await
        .unwrap();
    hold(&jog, KEEP, Duration::from_secs(1)).await;
    let kept = Instant::now();
    jog.keep().unwrap();
    while desk.moves() {
        sleep(Duration::from_millis(1)).await;
    }
    let took = kept.elapsed();
    assert!(took > KEEP - Duration::from_millis(5), "{took:?}");
    assert!(took < KEEP + Duration::from_millis(100), "{took:?}");
    assert_eq!(jog.keep().unwrap_err().code(), ErrorCode::NotKept);
    // A cancelled call leaves no jog behind.
    over(&arm).await;
    let given_up = tokio::time::timeout(Duration::from_millis(120), arm.jog(Axis::Z.minus()));
    let _ = given_up.await;
    over(&arm).await;
    assert!(!desk.moves());
    let heard = desk.heard();
    sleep(Duration::from_secs(1)).await;
    assert!(
        !heard.is_empty() && desk.heard().is_empty(),
        "then it is quiet"
    );
}

#[tokio::test(start_paused = true)]
async fn it_ends_before_a_limit_and_before_the_fence() {
    for axis in [Axis::X, Axis::Z, Axis::J3, Axis::R] {
        for (fence, forward) in [(false, true), (false, false), (true, false)] {
            if fence && axis != Axis::Z {
                continue;
            }
            let desk = Desk::new();
            let fence = fence.then(|| Fence::default().with_floor(-20.0).unwrap());
            let arm = desk.connect(bounded().fence(fence)).await;
            let direction = build::JogDirection { axis, forward };
            let options = JogOptions::default().ratio(100.0);
            let jog = arm.jog_with(direction, options).await.unwrap();
            let error = loop {
                sleep(Duration::from_millis(50)).await;
                if let Err(error) = jog.keep() {
                    break error;
                }
            };
            let what = format!("{} {forward}: {error}", axis.name());
            assert_eq!(error.code(), ErrorCode::OutOfReach, "{what}");
            over(&arm).await;
            let state = desk.with(|arm| arm.state());
            assert!(!state.moving && !state.alarms.blocking(), "{what}");
            if fence.is_some() {
                assert!(
                    (-20.0..-19.8).contains(&state.pose.z),
                    "{what}: {}",
                    state.pose.z
                );
            }
            // A jog does not begin towards the limit, but away from it.
            let error = arm.jog_with(direction, options).await.unwrap_err();
            assert_eq!(error.kind(), ErrorKind::Unreachable, "{what}: {error}");
            let back = build::JogDirection {
                forward: !forward,
                axis,
            };
            let jog = arm.jog_with(back, options).await.unwrap();
            jog.stop().await.unwrap();
        }
    }
}

#[tokio::test(start_paused = true)]
async fn an_alarm_and_a_lost_answer_end_it_and_nothing_waits_then() {
    let desk = Desk::new();
    let arm = desk.connect(bounded()).await;
    arm.clear_alarms().await.unwrap();
    for lost in [false, true] {
        let jog = arm.jog(Axis::X.minus()).await.unwrap();
        hold(&jog, KEEP, Duration::from_millis(500)).await;
        desk.heard();
        if lost {
            // Neither the answer nor the index shows what became of the piece.
            desk.swallow(&[PATH, 246, 247]);
        } else {
            desk.with(|arm| arm.inject(ExternalEvent::Alarm(0x20)));
        }
        let begun = Instant::now();
        let error = loop {
            sleep(Duration::from_millis(20)).await;
            if let Err(error) = jog.keep() {
                break error;
            }
            assert!(begun.elapsed() < Duration::from_secs(5), "it goes on");
        };
        if lost {
            assert_eq!(error.code(), ErrorCode::NoAnswer, "{error}");
            assert_eq!(
                desk.count(PATH),
                1,
                "a piece that may have been taken is not said again"
            );
        } else {
            assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
        }
        desk.swallow(&[]);
        over(&arm).await;
        let state = desk.with(|arm| arm.state());
        assert!(!state.moving && state.queue.waiting == 0 && state.queue.running.is_none());
        arm.clear_alarms().await.unwrap();
        sleep(Duration::from_secs(1)).await;
        assert!(!desk.moves(), "nothing was left behind");
    }
}

#[tokio::test(start_paused = true)]
async fn what_does_not_begin_sends_no_piece() {
    let desk = Desk::new();
    let arm = desk.connect(bounded().allow_laser(true)).await;
    let refused = async |code: ErrorCode| {
        desk.heard();
        let error = arm.jog(Axis::Z.plus()).await.unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        assert_eq!(desk.count(PATH), 0);
        assert!(!desk.moves());
    };
    let jog = JogCmd {
        is_joint: Flag::OFF,
        cmd: JogCommand::Axis1Plus,
    };
    let error = arm.set(&jog).await.unwrap_err();
    assert_eq!(error.code(), ErrorCode::Guarded, "{error}");
    assert_eq!(desk.count(JOG), 0, "nothing would stop it");
    let lit = SetEndEffectorLaser {
        enable_ctrl: Flag::ON,
        on: Flag::ON,
    };
    arm.set(&lit).await.unwrap();
    refused(ErrorCode::LaserOn).await;
    arm.laser().switch_off().await.unwrap();
    // Commands of another program in the queue would run first.
    let foreign: Set = build::move_to(220.0, 0.0, 0.0, 0.0);
    let frame = magician::protocol::FrameBuf::set(&foreign, Ctrl::QUEUED).unwrap();
    desk.with(|arm| arm.receive(LinkId(5), frame.bytes()));
    refused(ErrorCode::ForeignCommands).await;
    arm.stop().await.unwrap();
    desk.with(|arm| arm.inject(ExternalEvent::Alarm(0x20)));
    refused(ErrorCode::Alarm).await;
}
