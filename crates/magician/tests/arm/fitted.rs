//! Connections with injected faults and traces.

use magician::commands::{DeviceTime, Pose};
use magician::faults::Faults;
use magician::{Arm, ErrorKind, Event, Options, VirtualArm, build};

use crate::desk::Desk;

fn with(faults: &str) -> Options {
    Options::default().faults(faults.parse::<Faults>().unwrap())
}

#[tokio::test(start_paused = true)]
async fn faults_are_put_on_the_line_of_an_arm() {
    let silent = with("drop=1,only=replies");
    let error = Arm::simulated(VirtualArm::default(), silent).await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Timeout);
    let silent = with("drop=1,only=replies");
    let error = Arm::connect_with("sim", silent).await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::Timeout);
}

#[tokio::test(start_paused = true)]
async fn each_of_many_steps_is_made_once_on_a_lossy_line() {
    let arm = VirtualArm::default();
    let driver = Arm::simulated(arm.clone(), with("drop-chunk=0.1,flip=1e-3,seed=11"));
    let driver = driver.await.unwrap();
    driver.clear_alarms().await.unwrap();
    let before = driver.get::<Pose>().await.unwrap().z;
    for _ in 0..30 {
        driver
            .run(&[build::move_by(0.0, 0.0, 1.0, 0.0)])
            .await
            .unwrap();
    }
    let after = driver.get::<Pose>().await.unwrap().z;
    assert!((after - before - 30.0).abs() < 0.01, "{before} {after}");
}

#[tokio::test(start_paused = true)]
async fn a_pulled_plug_is_found_again_also_in_this_process() {
    let arm = VirtualArm::default();
    let options = with("unplug=0.05,unplug-ms=100,seed=2");
    let driver = Arm::simulated(arm, options).await.unwrap();
    let mut events = driver.events();
    let mut lost = 0;
    for _ in 0..100 {
        if driver.get::<DeviceTime>().await.is_err() {
            lost += 1;
            while !matches!(events.next().await, Some(Event::LinkFound { .. })) {}
        }
    }
    assert!(lost > 0);
}

#[tokio::test(start_paused = true)]
async fn faults_that_cannot_be_done_are_refused() {
    let mut wrong = Options::default();
    wrong.faults.drop = f64::NAN;
    let error = Arm::simulated(VirtualArm::default(), wrong).await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::InvalidInput);
    // A stream of the caller takes no faults.
    let error = Arm::over_with(Desk::new().opener(), with("drop=0.1")).await;
    assert_eq!(error.unwrap_err().kind(), ErrorKind::InvalidInput);
}

#[cfg(feature = "trace")]
#[tokio::test(start_paused = true)]
async fn what_an_arm_says_and_hears_is_written_down() {
    use std::io::Write;
    use std::sync::{Arc, Mutex};

    use magician::Tracer;
    use magician::protocol::Direction;
    use magician_record::trace::read_trace;

    #[derive(Clone, Default)]
    struct Memory(Arc<Mutex<Vec<u8>>>);

    impl Write for Memory {
        fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
            self.0.lock().unwrap().write(bytes)
        }
        fn flush(&mut self) -> std::io::Result<()> {
            Ok(())
        }
    }

    for is_stream in [false, true] {
        let file = Memory::default();
        let options = Options::default().trace(Tracer::new(file.clone()).unwrap());
        let arm = if is_stream {
            Arm::over_with(Desk::new().opener(), options).await
        } else {
            Arm::simulated(VirtualArm::default(), options).await
        };
        let arm = arm.unwrap();
        arm.get::<Pose>().await.unwrap();
        arm.close().await;
        let file = file.0.lock().unwrap().clone();
        let packets: Vec<_> = read_trace(&file).map(Result::unwrap).collect();
        let poses = packets
            .iter()
            .filter(|packet| packet.bytes.get(3) == Some(&10));
        let sides: Vec<_> = poses.map(|packet| packet.direction.unwrap()).collect();
        assert_eq!(sides, [Direction::Request, Direction::Reply]);
    }
}
