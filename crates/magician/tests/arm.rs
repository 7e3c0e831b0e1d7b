//! The async handle over a virtual arm in this process, on a clock that jumps.

use std::time::Duration;

use magician::commands::{
    AlarmsState, DeviceName, EndEffectorParams, Pose, PtpCmd, PtpCommonParams, WaitCmd,
};
use magician::protocol::{CpMode, FrameBuf, JogCommand, Layout, Text};
use magician::sim::{Controller, Line, Profile, Runner, Speed};
use magician::{Arm, Ctrl, ErrorKind, Options, RunOptions, Set, Target, words};
use tokio::io::{AsyncReadExt, AsyncWriteExt, duplex};
use tokio::time::Instant;

fn runner(speed: Speed) -> Runner {
    let line = Line {
        baud: Some(115_200),
        turnaround: 2_000,
    };
    Runner::new(Controller::new(Profile::default()), speed, line)
}

/// An arm in real time, on a line as slow as the real one; the test's clock jumps.
async fn real_time() -> Arm {
    Arm::simulated(runner(Speed::Times(1.0)), Options::default())
        .await
        .unwrap()
}

async fn fast() -> Arm {
    Arm::connect(&"sim".parse().unwrap()).await.unwrap()
}

#[tokio::test(start_paused = true)]
async fn the_three_verbs() {
    let arm = fast().await;
    let name = DeviceName {
        device_name: Text::new("arm of the test").unwrap(),
    };
    arm.set(&name).await.unwrap();
    let read: DeviceName = arm.get().await.unwrap();
    assert_eq!(read.device_name.as_str(), Ok("arm of the test"));
    let first = arm.enqueue(&WaitCmd { timeout: 5 }).await.unwrap();
    let second = arm.enqueue(&WaitCmd { timeout: 5 }).await.unwrap();
    assert_eq!((first.0, second.0), (1, 2));
    let raw = arm.raw(10, Ctrl::GET, &[]).await.unwrap();
    assert!(Pose::decode(raw.frame().params()).is_ok());
    arm.detach();
}

#[tokio::test(start_paused = true)]
async fn moves_in_the_time_it_takes_and_arrives_exactly() {
    let arm = real_time().await;
    let begun = Instant::now();
    let ran = arm
        .perform(&[words::line_to(199.404, 100.0, -8.485, 0.0)])
        .await
        .unwrap();
    assert_eq!(ran.commands, 1);
    // 100 mm at the power-up speeds and half ratio take 2.000 s.
    let took = begun.elapsed();
    assert!(
        took >= Duration::from_secs(2) && took < Duration::from_millis(2200),
        "{took:?}"
    );
    let pose: Pose = arm.get().await.unwrap();
    assert_eq!((pose.x, pose.y, pose.z), (199.404, 100.0, -8.485));
}

#[tokio::test(start_paused = true)]
async fn homes_and_clears_the_reset_alarm() {
    let arm = real_time().await;
    assert!(arm.alarms().await.unwrap().contains(0));
    arm.home().await.unwrap();
    assert!(arm.alarms().await.unwrap().is_empty());
}

#[tokio::test(start_paused = true)]
async fn a_queue_longer_than_the_arms_flows_and_never_overruns() {
    for window in [1, 4] {
        let options = Options::default().window(window);
        let arm = Arm::simulated(runner(Speed::Times(1.0)), options)
            .await
            .unwrap();
        let wait = words::wait(Duration::from_millis(20));
        let mut seen = 0;
        let begun = Instant::now();
        let ran = arm
            .run(std::iter::repeat_n(wait, 200), |progress| {
                assert!(progress.current.0 >= seen);
                assert!(progress.sent - progress.current.0 <= 32);
                seen = progress.current.0;
                assert_eq!(progress.total, Some(200));
            })
            .await
            .unwrap();
        assert_eq!(
            (ran.commands, ran.first.unwrap().0, ran.last.unwrap().0),
            (200, 1, 200)
        );
        assert_eq!(seen, 200);
        // It never ran dry: the waits alone take four seconds.
        let took = begun.elapsed();
        assert!(
            took < Duration::from_millis(4600),
            "window {window}: {took:?}"
        );
    }
}

#[tokio::test(start_paused = true)]
async fn a_full_queue_that_does_not_run_is_an_error_of_its_own() {
    let arm = fast().await;
    for _ in 0..32 {
        arm.enqueue(&WaitCmd { timeout: 1 }).await.unwrap();
    }
    let error = arm.enqueue(&WaitCmd { timeout: 1 }).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::QueueFull);
    assert_eq!(error.command(), Some("SetWAITCmd"));
}

#[tokio::test(start_paused = true)]
async fn checks_before_a_byte_is_sent() {
    let arm = fast().await;
    let (before, _) = arm.stats().await.unwrap();
    let bad = [
        words::line_to(250.0, 0.0, 20.0, 0.0),
        words::move_to(500.0, 0.0, 0.0, 0.0),
    ];
    let error = arm.perform(&bad).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unreachable);
    assert_eq!(error.command(), Some("SetPTPCmd"));
    assert!(error.value() > error.limit() && error.unit() == Some("mm"));
    let nan = arm
        .perform(&[words::move_to(f32::NAN, 0.0, 0.0, 0.0)])
        .await
        .unwrap_err();
    assert_eq!(nan.kind(), ErrorKind::InvalidInput);
    let (after, _) = arm.stats().await.unwrap();
    assert_eq!(after.sent - before.sent, 6, "only reads");
    assert_eq!(arm.current_index().await.unwrap().0, 0);
}

#[tokio::test(start_paused = true)]
async fn fails_on_the_first_blocking_alarm_and_names_the_cure() {
    let arm = real_time().await;
    let far = PtpCmd {
        ptp_mode: magician::protocol::PtpMode::MovjXyz,
        x: 900.0,
        y: 0.0,
        z: 0.0,
        r: 0.0,
    };
    arm.start_queue().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 500 }).await.unwrap();
    arm.enqueue(&far).await.unwrap();
    let last = arm.enqueue(&WaitCmd { timeout: 500 }).await.unwrap();
    let error = arm.wait(last).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Alarm);
    assert!(error.alarms().unwrap().contains(0x11), "{error}");
    assert!(
        error.to_string().contains("magician alarms --clear"),
        "{error}"
    );
    arm.clear_alarms().await.unwrap();
    arm.wait(last).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_hold_without_an_alarm_is_found_out() {
    let arm = real_time().await;
    arm.start_queue().await.unwrap();
    // Into a limit, and out again without the queue: the bit drops, the hold stays.
    let Set::PtpCmd(out) = words::move_joints(0.0, 95.0, 45.0, 0.0) else {
        panic!()
    };
    arm.set(&out).await.unwrap();
    arm.wait_still().await.unwrap();
    assert!(arm.alarms().await.unwrap().contains(0x42));
    let Set::PtpCmd(back) = words::move_joints(0.0, 50.0, 45.0, 0.0) else {
        panic!()
    };
    arm.set(&back).await.unwrap();
    arm.wait_still().await.unwrap();
    assert!(!arm.alarms().await.unwrap().blocking());
    let Set::PtpCmd(back) = words::move_joints(0.0, 45.0, 45.0, 0.0) else {
        panic!()
    };
    let index = arm.enqueue(&back).await.unwrap();
    let error = arm.wait(index).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Alarm);
    assert!(error.alarms().unwrap().is_empty());
    assert!(
        error.to_string().contains("magician alarms --clear"),
        "{error}"
    );
    arm.clear_alarms().await.unwrap();
    arm.wait(index).await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_stop_from_another_task_ends_a_run() {
    let arm = std::sync::Arc::new(real_time().await);
    let running = {
        let arm = std::sync::Arc::clone(&arm);
        let moves = (0..100).map(|at| match at % 2 {
            0 => words::move_to(200.0, 100.0, 50.0, 0.0),
            _ => words::move_to(200.0, -100.0, 50.0, 0.0),
        });
        tokio::spawn(async move { arm.run(moves.collect::<Vec<_>>(), |_| {}).await })
    };
    tokio::time::sleep(Duration::from_secs(3)).await;
    arm.stop().await.unwrap();
    let before: Pose = arm.get().await.unwrap();
    tokio::time::sleep(Duration::from_secs(5)).await;
    let after: Pose = arm.get().await.unwrap();
    assert_eq!(before, after);
    assert_eq!(arm.left_space().await.unwrap(), 32);
    let outcome = tokio::time::timeout(Duration::from_secs(120), running).await;
    let outcome = outcome.expect("it ends").unwrap();
    assert_eq!(outcome.unwrap_err().kind(), ErrorKind::Closed);
    // And it works again.
    arm.run([words::move_to(200.0, 0.0, 50.0, 0.0)], |_| {})
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn will_not_start_what_others_left_behind() {
    let mut controller = Controller::new(Profile::default());
    let left = FrameBuf::encode(110, Ctrl::QUEUED, &WaitCmd { timeout: 10 }).unwrap();
    controller.receive(magician::sim::LinkId(7), left.bytes());
    let line = Line {
        baud: None,
        turnaround: 0,
    };
    let runner = Runner::new(controller, Speed::Max, line);
    let arm = Arm::simulated(runner, Options::default()).await.unwrap();
    let mine = [words::wait(Duration::from_millis(1))];
    let error = arm.run(mine, |_| {}).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    let message = error.to_string();
    assert!(
        message.contains("magician stop") && message.contains("--keep"),
        "{message}"
    );
    assert_eq!(arm.left_space().await.unwrap(), 31, "nothing was sent");
    arm.run_with(mine, RunOptions::default().keep(true), |_| {})
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_silent_port_is_said_to_be_silent() {
    let (near, mut far) = duplex(4096);
    let begun = Instant::now();
    let error = Arm::over(near, Options::default()).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    let message = error.to_string();
    assert!(
        message.contains("GetDeviceVersion") && message.contains("nothing came back"),
        "{message}"
    );
    let mut heard = Vec::new();
    far.read_to_end(&mut heard).await.unwrap();
    assert!(heard.starts_with(&[0xAA, 0xAA, 0x02, 0x02]));
}

#[tokio::test(start_paused = true)]
async fn a_port_that_talks_nonsense_is_said_to_do_so() {
    let (near, mut far) = duplex(1 << 16);
    let flood = tokio::spawn(async move {
        while far
            .write_all(b"GRBL 1.1\r\nok\r\n\xAA\xAA\xAA")
            .await
            .is_ok()
        {
            tokio::time::sleep(Duration::from_millis(1)).await;
        }
    });
    let begun = Instant::now();
    let error = Arm::over(near, Options::default()).await.unwrap_err();
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    assert!(error.to_string().contains("not this arm's"), "{error}");
    flood.abort();
}

#[tokio::test(start_paused = true)]
async fn a_line_that_breaks_ends_every_call() {
    let (near, far) = duplex(4096);
    let options = Options::default().probe(false);
    let arm = Arm::over(near, options).await.unwrap();
    drop(far);
    for _ in 0..3 {
        let error = arm.get::<Pose>().await.unwrap_err();
        assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    }
}

/// A stream to a virtual arm that the test can look into while the handle is gone.
struct Bench {
    far: tokio::io::DuplexStream,
    controller: Controller,
    laser: bool,
}

impl Bench {
    fn new() -> (tokio::io::DuplexStream, Self) {
        let (near, far) = duplex(1 << 16);
        let controller = Controller::new(Profile::default());
        (
            near,
            Self {
                far,
                controller,
                laser: false,
            },
        )
    }

    /// Answers until the other end is gone.
    async fn serve(mut self) -> Self {
        let begun = Instant::now();
        let mut bytes = [0; 256];
        while let Ok(count @ 1..) = self.far.read(&mut bytes).await {
            self.controller.advance(begun.elapsed().as_micros() as u64);
            self.controller
                .receive(magician::sim::LinkId(0), &bytes[..count]);
            self.laser |= self.controller.state().laser;
            while let Some(reply) = self.controller.poll_transmit(magician::sim::LinkId(0)) {
                let _ = self.far.write_all(reply.bytes()).await;
            }
        }
        self
    }
}

#[tokio::test(start_paused = true)]
async fn a_dropped_handle_stops_what_it_started_and_puts_the_laser_out() {
    let (near, bench) = Bench::new();
    let bench = tokio::spawn(bench.serve());
    let arm = Arm::over(near, Options::default()).await.unwrap();
    let Set::SetEndEffectorLaser(burn) = words::laser(true) else {
        panic!()
    };
    arm.set(&burn).await.unwrap();
    arm.start_queue().await.unwrap();
    for y in [100.0, -100.0, 100.0] {
        let Set::PtpCmd(go) = words::move_to(200.0, y, 50.0, 0.0) else {
            panic!()
        };
        arm.enqueue(&go).await.unwrap();
    }
    drop(arm);
    let bench = bench.await.unwrap();
    let state = bench.controller.state();
    assert!(bench.laser, "it did burn");
    assert!(
        !state.laser && !state.queue.started && state.queue.waiting == 0,
        "{state:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_detached_handle_and_one_that_is_done_leave_the_arm_alone() {
    for detach in [true, false] {
        let (near, bench) = Bench::new();
        let bench = tokio::spawn(bench.serve());
        let arm = Arm::over(near, Options::default()).await.unwrap();
        if detach {
            arm.start_queue().await.unwrap();
            arm.enqueue(&WaitCmd { timeout: 60_000 }).await.unwrap();
            arm.detach();
        } else {
            arm.run([words::wait(Duration::from_millis(1))], |_| {})
                .await
                .unwrap();
        }
        arm.close().await;
        assert!(
            bench.await.unwrap().controller.state().queue.started,
            "detach {detach}"
        );
    }
}

#[test]
fn a_runtime_that_goes_first_still_lets_the_stop_out() {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let (near, mut far) = duplex(1 << 16);
    runtime.block_on(async {
        let options = Options::default()
            .probe(false)
            .timeout(Duration::from_millis(1));
        let arm = Arm::over(near, options).await.unwrap();
        let Set::JogCmd(jog) = words::jog_joint(JogCommand::Axis1Plus) else {
            panic!()
        };
        let _ = arm.set(&jog).await;
    });
    drop(runtime);
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .unwrap();
    let mut heard = Vec::new();
    runtime.block_on(far.read_to_end(&mut heard)).unwrap();
    let stop = FrameBuf::new(242, Ctrl::SET, &[]).unwrap();
    let stopped = heard
        .windows(stop.bytes().len())
        .any(|bytes| bytes == stop.bytes());
    assert!(stopped, "{heard:02X?}");
}

#[tokio::test]
async fn the_blocking_handle_refuses_to_block_a_runtime() {
    let target: Target = "sim".parse().unwrap();
    let error = magician::blocking::Arm::connect(&target).unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    let made = tokio::task::spawn_blocking(move || {
        // A thread for blocking work still belongs to the runtime.
        std::thread::spawn(move || magician::blocking::Arm::connect(&target))
            .join()
            .unwrap()
    });
    let arm = made.await.unwrap().unwrap();
    let error = arm.get::<Pose>().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    drop(arm);
}

#[test]
fn the_blocking_handle_works_from_several_threads() {
    let arm = magician::blocking::Arm::connect(&"sim".parse().unwrap()).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..50 {
                    arm.get::<AlarmsState>().unwrap();
                }
            });
        }
    });
    let ratio = PtpCommonParams {
        velocity_ratio: 30.0,
        acceleration_ratio: 40.0,
    };
    arm.set(&ratio).unwrap();
    assert_eq!(arm.get::<PtpCommonParams>().unwrap(), ratio);
    arm.perform(&[words::move_to(210.0, 10.0, 30.0, 0.0)])
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_line_that_takes_no_more_bytes_holds_nobody_up() {
    let (near, _far) = duplex(4);
    let options = Options::default().probe(false);
    let arm = Arm::over(near, options).await.unwrap();
    let begun = Instant::now();
    let error = arm.get::<Pose>().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Timeout);
    assert!(begun.elapsed() <= Duration::from_millis(3010));
    let _ = arm
        .enqueue_set(&words::move_to(200.0, 0.0, 50.0, 0.0))
        .await;
    let begun = Instant::now();
    arm.close().await;
    assert!(begun.elapsed() <= Duration::from_millis(510));
}

#[tokio::test]
async fn bluetooth_is_not_spoken_yet() {
    let error = Arm::connect(&"ble:Dobot".parse().unwrap())
        .await
        .unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Unsupported);
}

#[test]
fn the_check_follows_the_arm() {
    use magician::{JointAngles, Limits, ToolBias, words::Preflight};

    let mut check = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    check.check(&words::line_by(0.0, 50.0, 0.0, 0.0)).unwrap();
    assert!((check.arm().unwrap().pose.y - 50.0).abs() < 1e-9);
    check.check(&words::tool(ToolBias::SUCTION)).unwrap();
    assert!(
        check.arm().unwrap().pose.x > 250.0,
        "the tool point is further out now"
    );
    // Both ends are reachable, the straight way between them leads through the base.
    check.check(&words::move_to(0.0, 200.0, 50.0, 0.0)).unwrap();
    let through = check
        .check(&words::line_to(0.0, -200.0, 50.0, 0.0))
        .unwrap_err();
    assert_eq!(through.kind(), ErrorKind::Unreachable);
    check
        .check(&words::move_to(0.0, -200.0, 50.0, 0.0))
        .unwrap();
    let relative = CpMode::Relative;
    let segment = magician::commands::CpCmd {
        cp_mode: relative,
        x: 0.0,
        y: -500.0,
        z: 0.0,
        velocity_or_power: 0.0,
    };
    assert!(check.check(&segment.into()).is_err());
    let strict = Preflight::at(JointAngles::HOME, ToolBias::NONE);
    let mut strict = strict.limits(Limits::GUARANTEED);
    let error = strict
        .check(&words::move_joints(100.0, 45.0, 45.0, 0.0))
        .unwrap_err();
    assert_eq!((error.value(), error.limit()), (Some(100.0), Some(90.0)));
    let slow = strict.check(&words::speed(0.0, 50.0)).unwrap_err();
    assert_eq!(slow.kind(), ErrorKind::InvalidInput);
    let tool = EndEffectorParams {
        x_bias: f32::INFINITY,
        y_bias: 0.0,
        z_bias: 0.0,
    };
    assert!(strict.check(&tool.into()).is_err());
}

fn pose_at(x: f32) -> Pose {
    Pose {
        x,
        y: 0.0,
        z: 0.0,
        r: 0.0,
        joint_angle: [0.0; 4],
    }
}

/// An arm at the end of a pipe that the test holds: it hears requests, and answers as told.
async fn next_request(far: &mut tokio::io::DuplexStream) -> FrameBuf {
    let mut head = [0; 3];
    far.read_exact(&mut head).await.unwrap();
    let mut rest = vec![0; usize::from(head[2]) + 1];
    far.read_exact(&mut rest).await.unwrap();
    FrameBuf::new(rest[0], Ctrl(rest[1]), &rest[2..rest.len() - 1]).unwrap()
}

#[test]
fn an_answer_that_came_between_two_blocking_calls_is_not_taken_for_the_next() {
    // Real time, as short as can be: what a blocking handle misses it misses while nothing runs.
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let target: Target = format!("udp:{}", socket.local_addr().unwrap())
        .parse()
        .unwrap();
    let answer = |request: &[u8], x: f32| {
        let pose = pose_at(x);
        let mut reply = FrameBuf::encode(10, Ctrl::GET, &pose).unwrap();
        if request[3] != 10 {
            reply = FrameBuf::new(request[3], Ctrl(request[4]), &[0; 12]).unwrap();
        }
        reply
    };
    let options = Options::default().probe(false);
    let arm = std::thread::spawn(move || {
        let arm = magician::blocking::Arm::connect_with(&target, options).unwrap();
        let first = arm.get::<Pose>().unwrap().x;
        (arm, first)
    });
    let mut bytes = [0; 64];
    let (_, host) = socket.recv_from(&mut bytes).unwrap();
    // The network doubles the answer, and the double comes when the call has ended.
    socket.send_to(answer(&bytes, 1.0).bytes(), host).unwrap();
    let (arm, first) = arm.join().unwrap();
    socket.send_to(answer(&bytes, 1.0).bytes(), host).unwrap();
    let second = std::thread::spawn(move || arm.get::<Pose>().unwrap().x);
    socket.recv_from(&mut bytes).unwrap();
    socket.send_to(answer(&bytes, 2.0).bytes(), host).unwrap();
    assert_eq!((first, second.join().unwrap()), (1.0, 2.0));
}

#[tokio::test(start_paused = true)]
async fn a_move_of_the_rail_alone_is_no_hold() {
    let (near, mut far) = duplex(1 << 16);
    let bench = tokio::spawn(async move {
        let begun = Instant::now();
        let mut controller = Controller::new(Profile::default());
        let mut started = false;
        loop {
            let request = next_request(&mut far).await;
            let now = begun.elapsed();
            // The rail takes eight seconds, and nothing else moves meanwhile.
            if now > Duration::from_secs(8) && !std::mem::replace(&mut started, true) {
                let start = FrameBuf::new(240, Ctrl::SET, &[]).unwrap();
                controller.receive(magician::sim::LinkId(1), start.bytes());
            }
            let reply = match request.frame().id() {
                240 => Some(FrameBuf::new(240, Ctrl::SET, &[]).unwrap()),
                13 => {
                    let l = now.as_secs_f32() * 100.0;
                    Some(FrameBuf::new(13, Ctrl::GET, &l.to_le_bytes()).unwrap())
                }
                _ => {
                    controller.advance(now.as_micros() as u64);
                    controller.receive(magician::sim::LinkId(0), request.bytes());
                    controller.poll_transmit(magician::sim::LinkId(0))
                }
            };
            let _ = far
                .write_all(reply.expect("every request is known").bytes())
                .await;
        }
    });
    let arm = Arm::over(near, Options::default()).await.unwrap();
    let here: Pose = arm.get().await.unwrap();
    let along = words::move_with_rail(here.x, here.y, here.z, here.r, 800.0);
    let begun = Instant::now();
    arm.run([along], |_| {}).await.unwrap();
    assert!(begun.elapsed() > Duration::from_secs(7));
    arm.close().await;
    bench.abort();
}

#[tokio::test(start_paused = true)]
async fn a_wait_of_another_program_before_ours_is_no_hold() {
    let mut controller = Controller::new(Profile::default());
    let left = FrameBuf::encode(110, Ctrl::QUEUED, &WaitCmd { timeout: 20_000 }).unwrap();
    controller.receive(magician::sim::LinkId(7), left.bytes());
    let line = Line {
        baud: None,
        turnaround: 0,
    };
    let runner = Runner::new(controller, Speed::Times(1.0), line);
    let arm = Arm::simulated(runner, Options::default()).await.unwrap();
    let options = RunOptions::default().keep(true);
    arm.run_with([words::move_to(200.0, 50.0, 20.0, 0.0)], options, |_| {})
        .await
        .unwrap();
}

#[tokio::test(start_paused = true)]
async fn an_index_that_was_cleared_will_not_come() {
    let arm = std::sync::Arc::new(real_time().await);
    arm.start_queue().await.unwrap();
    arm.enqueue(&WaitCmd { timeout: 1_000 }).await.unwrap();
    let dropped = arm.enqueue(&WaitCmd { timeout: 1_000 }).await.unwrap();
    arm.clear_queue().await.unwrap();
    let begun = Instant::now();
    let error = arm.wait(dropped).await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Closed, "{error}");
    assert!(error.to_string().contains("will not come"), "{error}");
    assert!(begun.elapsed() < Duration::from_secs(5));
}

#[tokio::test(start_paused = true)]
async fn an_arm_that_is_reset_ends_a_wait_and_says_what_is_gone() {
    let (near, mut far) = duplex(1 << 16);
    let bench = tokio::spawn(async move {
        let begun = Instant::now();
        let (mut controller, mut booted) = (Controller::new(Profile::default()), begun);
        let mut bytes = [0; 256];
        let mut off = false;
        while let Ok(count @ 1..) = far.read(&mut bytes).await {
            if !off && begun.elapsed() > Duration::from_secs(2) {
                (controller, booted, off) =
                    (Controller::new(Profile::default()), Instant::now(), true);
            }
            controller.advance(booted.elapsed().as_micros() as u64);
            controller.receive(magician::sim::LinkId(0), &bytes[..count]);
            while let Some(reply) = controller.poll_transmit(magician::sim::LinkId(0)) {
                let _ = far.write_all(reply.bytes()).await;
            }
        }
    });
    let arm = Arm::over(near, Options::default()).await.unwrap();
    let wait = words::wait(Duration::from_millis(500));
    let error = arm
        .run(std::iter::repeat_n(wait, 30), |_| {})
        .await
        .unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Uncertain, "{error}");
    assert!(error.to_string().contains("reset"), "{error}");
    assert!(
        error.from_index() > Some(1) && error.to_index() == Some(30),
        "{error}"
    );
    assert_eq!(
        arm.left_space().await.unwrap(),
        32,
        "nothing was sent again"
    );
    arm.run([wait], |_| {}).await.unwrap();
    arm.close().await;
    bench.await.unwrap();
}

#[tokio::test(start_paused = true)]
async fn a_call_that_is_given_up_is_withdrawn_and_leaves_no_wrong_count() {
    let (near, mut far) = duplex(1 << 16);
    let arm = Arm::over(near, Options::default().probe(false))
        .await
        .unwrap();
    // The first is out, the second waits behind it; nobody waits for either any more.
    let first = arm.get::<AlarmsState>();
    let second = arm.get::<DeviceName>();
    let both = async { tokio::join!(first, second) };
    assert!(
        tokio::time::timeout(Duration::from_millis(20), both)
            .await
            .is_err()
    );
    assert_eq!(next_request(&mut far).await.frame().id(), 20);
    let alarms = FrameBuf::new(20, Ctrl::GET, &[0; 16]).unwrap();
    far.write_all(alarms.bytes()).await.unwrap();
    let third = tokio::spawn(async move { arm.get::<Pose>().await.map(|_| arm) });
    assert_eq!(
        next_request(&mut far).await.frame().id(),
        10,
        "the second was withdrawn"
    );
    let pose = FrameBuf::encode(10, Ctrl::GET, &pose_at(0.0)).unwrap();
    far.write_all(pose.bytes()).await.unwrap();
    third.await.unwrap().unwrap().detach();
}

#[tokio::test(start_paused = true)]
async fn a_jog_on_a_line_that_broke_is_given_up_at_once() {
    let (near, far) = duplex(4096);
    let arm = Arm::over(near, Options::default().probe(false))
        .await
        .unwrap();
    drop(far);
    let begun = Instant::now();
    let error = arm.stop_jog().await.unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Port, "{error}");
    assert!(begun.elapsed() < Duration::from_millis(100));
}

#[tokio::test(start_paused = true)]
async fn any_timeout_can_be_asked_for() {
    let options = Options::default().timeout(Duration::MAX);
    let arm = Arm::simulated(runner(Speed::Max), options).await.unwrap();
    arm.run([words::wait(Duration::from_millis(1))], |_| {})
        .await
        .unwrap();
}
