//! Interrupted runs: which of them can continue, and which never do.

use std::time::Duration;

use magician::commands::{Pose, WaitCmd};
use magician::protocol::{FrameBuf, PtpMode};
use magician::sim::LinkId;
use magician::{Arm, Ctrl, ErrorKind, Options, RunOptions, Set, build, commands};
use tokio::time::{Instant, sleep, timeout};

use crate::desk::{Desk, acquainted, only_reads};

const WAIT: u8 = 110;
const ALARMS: u8 = 20;
const STOP_EXEC: u8 = 241;

fn waits(count: usize, ms: u64) -> Vec<Set> {
    vec![build::wait(Duration::from_millis(ms)); count]
}

/// Waits until the arm has this many commands in a stopped queue.
async fn loaded(desk: &Desk, count: u32) {
    let ready = || desk.with(|arm| arm.state().queue.waiting as u32 >= count);
    while !ready() {
        sleep(Duration::from_micros(500)).await;
    }
    assert!(!desk.with(|arm| arm.state().queue.started));
}

#[tokio::test(start_paused = true)]
async fn one_that_nobody_waited_for_does_not_go_on_in_its_middle() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let mut run = arm.start(waits(300, 100));
    let cut = timeout(Duration::from_secs(3), run.wait(|_| {})).await;
    assert!(cut.is_err());
    assert!(!run.is_interrupted());
    sleep(Duration::from_secs(5)).await;
    desk.heard();
    let error = run.wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    assert!(only_reads(&desk.heard()));
    // Another run begins at once.
    arm.start(waits(3, 10)).wait(|_| {}).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_load_that_was_given_up_is_not_the_next_ones_to_start() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    for window in 0..3 {
        let other = arm.clone();
        let running = tokio::spawn(async move { other.start(waits(20, 10)).wait(|_| {}).await });
        loaded(&desk, 5 + window).await;
        running.abort();
        let _ = running.await;
        sleep(Duration::from_millis(100)).await;
        let left = arm.queue().left_space().await.unwrap();
        assert!(left < 32);
        desk.heard();
        let error = arm.start(waits(20, 10)).wait(|_| {}).await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
        assert!(only_reads(&desk.heard()));
        arm.stop().await.unwrap();
        arm.start(waits(20, 10)).wait(|_| {}).await.unwrap();
        arm.stop_gentle().await.unwrap();
    }
}

#[tokio::test(start_paused = true)]
async fn a_stop_while_the_line_is_lost_ends_it_for_good() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let mut run = arm.start(waits(30, 300));
    let pulled = async {
        sleep(Duration::from_secs(2)).await;
        desk.unplug();
    };
    let (ended, ()) = tokio::join!(run.wait(|_| {}), pulled);
    assert_eq!(ended.unwrap_err().kind(), ErrorKind::Port);
    assert!(run.is_interrupted());
    // The arm has finished everything, so its indices do not show the stop.
    sleep(Duration::from_secs(10)).await;
    arm.stopper().request_stop().unwrap();
    sleep(Duration::from_millis(50)).await;
    desk.plug();
    arm.reconnected().await.unwrap();
    sleep(Duration::from_millis(100)).await;
    assert!(!run.is_interrupted());
    desk.heard();
    let error = run.wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    assert!(only_reads(&desk.heard()));
}

#[tokio::test(start_paused = true)]
async fn its_start_does_not_follow_a_gentle_stop() {
    for before in 1..12 {
        let desk = Desk::new();
        let arm = acquainted(&desk).await;
        let other = arm.clone();
        let running = tokio::spawn(async move { other.start(waits(12, 1000)).wait(|_| {}).await });
        loaded(&desk, before % 2 + 1).await;
        sleep(Duration::from_micros(u64::from(before) * 400)).await;
        desk.heard();
        arm.stop_gentle().await.unwrap();
        let error = running.await.unwrap().unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
        sleep(Duration::from_secs(1)).await;
        assert!(!desk.with(|arm| arm.state().queue.started));
        let acts: Vec<_> = (desk
            .heard()
            .into_iter()
            .skip_while(|(id, _)| *id != STOP_EXEC))
        .filter(|(id, acts)| *acts && *id != STOP_EXEC)
        .collect();
        assert_eq!(acts, []);
    }
}

#[tokio::test(start_paused = true)]
async fn it_does_not_go_on_behind_what_was_cleared() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let other = arm.clone();
    let running = tokio::spawn(async move { other.start(waits(300, 200)).wait(|_| {}).await });
    sleep(Duration::from_secs(3)).await;
    arm.queue().clear().await.unwrap();
    desk.heard();
    let error = running.await.unwrap().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    sleep(Duration::from_secs(1)).await;
    assert_eq!(desk.count(WAIT), 0);
}

#[tokio::test(start_paused = true)]
async fn a_jog_and_a_run_keep_out_of_each_others_way() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let turn = build::Axis::J1.plus();
    let moves: Vec<_> = [60.0, -60.0, 60.0, -60.0]
        .map(|y| build::move_to(200.0, y, 30.0, 0.0))
        .into();
    let jog = arm.jog(turn).await.unwrap();
    let error = arm.start(moves.clone()).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
    drop(jog);
    let other = arm.clone();
    let running = tokio::spawn(async move { other.start(moves).wait(|_| {}).await });
    sleep(Duration::from_secs(2)).await;
    desk.heard();
    let error = arm.jog(turn).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
    assert_eq!(desk.count(73), 0);
    running.await.unwrap().unwrap();
    let pose: Pose = arm.get().await.unwrap();
    assert_eq!((pose.x, pose.y), (200.0, -60.0));
}

fn unreachable() -> commands::PtpCmd {
    commands::PtpCmd {
        ptp_mode: PtpMode::MovjXyz,
        x: 900.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
    }
}

#[tokio::test(start_paused = true)]
async fn an_alarm_that_holds_a_full_queue_of_others_is_told() {
    let desk = Desk::new();
    desk.with(|arm| {
        let far = FrameBuf::encode(84, Ctrl::QUEUED, &unreachable()).unwrap();
        arm.receive(LinkId(7), far.bytes());
        let wait = FrameBuf::encode(WAIT, Ctrl::QUEUED, &WaitCmd { timeout: 10 }).unwrap();
        for _ in 0..31 {
            arm.receive(LinkId(7), wait.bytes());
        }
        let start = FrameBuf::new(240, Ctrl::SET, &[]).unwrap();
        arm.receive(LinkId(7), start.bytes());
        for _ in 0..3 {
            arm.receive(LinkId(7), wait.bytes());
        }
    });
    let arm = acquainted(&desk).await;
    let arm = arm.allowing_laser();
    let mut run = arm.start_with(waits(3, 10), RunOptions::default().keep(true));
    let error = timeout(Duration::from_secs(60), run.wait(|_| {}))
        .await
        .expect("an end");
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Alarm);
}

#[tokio::test(start_paused = true)]
async fn a_line_that_breaks_under_a_look_leaves_it_to_go_on() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let mut run = arm.start(waits(30, 300));
    let pulled = async {
        sleep(Duration::from_secs(2)).await;
        desk.swallow(&[ALARMS]);
        sleep(Duration::from_millis(1500)).await;
        desk.unplug();
        desk.swallow(&[]);
    };
    let (ended, ()) = tokio::join!(run.wait(|_| {}), pulled);
    let error = ended.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    assert!(run.is_interrupted());
    let reached = run.ran();
    assert!(reached.commands > 5);
    // Without a line nothing can be found out, and nothing is forgotten.
    let error = run.wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    assert!(run.is_interrupted());
    assert_eq!(run.ran(), reached);
    desk.plug();
    arm.reconnected().await.unwrap();
    let mut least = reached.commands;
    let ran = run
        .wait(|progress| {
            assert!(progress.sent >= least, "{progress:?}");
            least = progress.sent;
        })
        .await
        .unwrap();
    assert_eq!((ran.commands, ran.last.unwrap().0), (30, 31));
}

#[tokio::test(start_paused = true)]
async fn what_was_under_way_when_it_broke_is_not_counted_for_ever() {
    for late in 0..8 {
        let desk = Desk::new();
        let arm = acquainted(&desk).await;
        let mut run = arm.start(waits(30, 300));
        let pulled = async {
            sleep(Duration::from_secs(2)).await;
            desk.swallow(&[WAIT]);
            sleep(Duration::from_millis(350 + 70 * late)).await;
            desk.unplug();
            desk.swallow(&[]);
            sleep(Duration::from_millis(10)).await;
            desk.plug();
        };
        let (ended, ()) = tokio::join!(run.wait(|_| {}), pulled);
        assert_eq!(ended.unwrap_err().kind(), ErrorKind::Port);
        assert!(run.is_interrupted());
        arm.reconnected().await.unwrap();
        let ran = run.wait(|_| {}).await.unwrap();
        assert_eq!((ran.commands, ran.last.unwrap().0), (30, 31), "{late}");
        assert!(!arm.moving(), "{late}");
    }
}

#[tokio::test(start_paused = true)]
async fn one_that_goes_on_hears_of_an_alarm_that_holds_the_queue() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    let mut program = waits(30, 300);
    program[10] = unreachable().into();
    let mut run = arm.start(program);
    let pulled = async {
        sleep(Duration::from_secs(2)).await;
        desk.unplug();
    };
    let (ended, ()) = tokio::join!(run.wait(|_| {}), pulled);
    assert_eq!(ended.unwrap_err().kind(), ErrorKind::Port);
    sleep(Duration::from_secs(5)).await;
    desk.plug();
    arm.reconnected().await.unwrap();
    let begun = Instant::now();
    let ended = timeout(Duration::from_secs(600), run.wait(|_| {})).await;
    let error = ended.expect("it ends").unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Alarm, "{error}");
    assert!(begun.elapsed() < Duration::from_secs(5));
}

#[tokio::test(start_paused = true)]
async fn what_a_stop_has_dropped_is_not_taken_for_what_others_queued() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    for _ in 0..5 {
        arm.enqueue(&WaitCmd { timeout: 100 }).await.unwrap();
    }
    arm.stopper().request_stop().unwrap();
    sleep(Duration::from_millis(500)).await;
    desk.with(|arm| {
        let wait = FrameBuf::encode(WAIT, Ctrl::QUEUED, &WaitCmd { timeout: 10 }).unwrap();
        for _ in 0..3 {
            arm.receive(LinkId(7), wait.bytes());
        }
    });
    let error = arm.start(waits(2, 10)).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput, "{error}");
}

/// Starts a motion over another handle, and stops the arm during it. With `given_up` the call of
/// the motion is cancelled as well.
async fn stopped_in_motion(desk: &Desk, after: u64, given_up: bool) -> Arm {
    let arm = acquainted(desk).await;
    arm.run(&[build::move_to(220.0, -60.0, 20.0, 0.0)])
        .await
        .unwrap();
    let other = arm.clone();
    let far = [
        build::move_to(220.0, 60.0, 20.0, 0.0),
        build::move_to(220.0, 80.0, 20.0, 0.0),
    ];
    let running = tokio::spawn(async move { other.run(&far).await });
    sleep(Duration::from_millis(after)).await;
    arm.stopper().request_stop().unwrap();
    if given_up {
        running.abort();
    } else {
        drop(running);
    }
    arm
}

#[tokio::test(start_paused = true)]
async fn motion_after_a_requested_stop_waits_until_the_arm_stands() {
    let moves: [fn() -> Set; 3] = [
        || build::move_to(220.0, -20.0, 20.0, 0.0),
        || build::line_to(220.0, -20.0, 20.0, 0.0),
        || build::path_to(220.0, -20.0, 20.0),
    ];
    for after in [1, 20, 100, 300, 600, 900] {
        for given_up in [true, false] {
            for to in moves {
                let desk = Desk::new();
                let arm = stopped_in_motion(&desk, after, given_up).await;
                let ran = arm.run(&[to()]).await;
                ran.unwrap_or_else(|error| panic!("{error}, {after} ms, given up: {given_up}"));
                let Pose { x, y, z, .. } = arm.get().await.unwrap();
                assert_eq!([x, y, z].map(f32::round), [220.0, -20.0, 20.0]);
            }
        }
    }
}

#[tokio::test(start_paused = true)]
async fn pose_known_after_a_requested_stop_is_where_the_arm_stands() {
    for after in [100, 300, 600] {
        let desk = Desk::new();
        let arm = stopped_in_motion(&desk, after, true).await;
        let known = arm.front_end().known_pose().await.unwrap();
        sleep(Duration::from_secs(2)).await;
        assert_eq!(known, arm.get::<Pose>().await.unwrap(), "{after} ms");
        arm.lift(5.0).await.unwrap();
    }
}

#[tokio::test(start_paused = true)]
async fn motion_after_a_forced_stop_sent_as_a_command_waits_until_the_arm_stands() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    arm.enqueue_set(&build::move_to(220.0, 60.0, 20.0, 0.0))
        .await
        .unwrap();
    sleep(Duration::from_millis(300)).await;
    arm.set(&commands::QueuedCmdForceStopExec {}).await.unwrap();
    arm.queue().clear().await.unwrap();
    assert!(desk.moves(), "it brakes");
    desk.heard();
    arm.run(&[build::line_to(220.0, -20.0, 20.0, 0.0)])
        .await
        .unwrap();
    let moves = desk.frames(84);
    assert!(matches!(moves[..], [(_, false)]), "{moves:?}");
}

#[tokio::test(start_paused = true)]
async fn a_stop_does_not_wait_for_a_line_to_settle() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    arm.queue().start().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
    desk.unplug();
    sleep(Duration::from_millis(10)).await;
    // Clock and queue do not answer, so the line does not settle.
    desk.swallow(&[4, 246, 247]);
    desk.plug();
    while !desk.heard().iter().any(|(id, _)| *id == 4) {
        sleep(Duration::from_millis(1)).await;
    }
    arm.stopper().request_stop().unwrap();
    sleep(Duration::from_millis(20)).await;
    assert!(!desk.with(|arm| arm.state().queue.started));
}

#[tokio::test(start_paused = true)]
async fn a_start_that_was_not_answered_is_stopped_when_the_last_handle_goes() {
    let desk = Desk::new();
    let arm = acquainted(&desk).await;
    desk.swallow(&[240]);
    let error = arm.start(waits(3, 60_000)).wait(|_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    assert!(desk.with(|arm| arm.state().queue.started));
    assert!(arm.moving());
    arm.close().await;
    assert!(!desk.with(|arm| arm.state().queue.started));
}

#[tokio::test(start_paused = true)]
async fn any_number_of_commands() {
    for window in [1, 4] {
        for count in [0, 1, 2, 3, 31, 32, 33, 34, 64, 65, 104, 105, 106, 1000] {
            let desk = Desk::new();
            let arm = desk.connect(Options::default().window(window)).await;
            let places = |at: usize| build::path_to(200.0 + (at % 40) as f32, 5.0, 20.0);
            let mut sent = 0;
            let ran = arm
                .start((0..count).map(places))
                .wait(|progress| {
                    assert!(progress.sent >= sent && progress.sent <= count as u64);
                    sent = progress.sent;
                })
                .await
                .unwrap();
            assert_eq!(ran.commands, count as u64);
            assert_eq!(
                desk.with(|arm| arm.state().queue.current_index),
                if count == 0 { 0 } else { count as u64 + 1 }
            );
        }
    }
}
