//! Lines with faults, and traced lines.

use magician::faults::Faults;
use magician::sim::Event;
use magician::{ErrorKind, LineOptions, RawLine, VirtualArm};

use crate::replug::answers;

fn with(faults: &str) -> LineOptions {
    LineOptions::default().faults(faults.parse::<Faults>().unwrap())
}

/// Returns everything received for a number of requests with enough noise.
async fn heard(faults: &str) -> Vec<u8> {
    let arm = VirtualArm::default();
    let mut line = RawLine::simulated(arm, with(faults)).await.unwrap();
    let mut heard = Vec::new();
    for id in [10, 20, 246, 0, 2, 83] {
        for _ in 0..20 {
            let sum = 0u8.wrapping_sub(id);
            line.send(&[0xAA, 0xAA, 2, id, 0, sum]).await.unwrap();
            let mut bytes = [0; 300];
            // The clock of the test stands, so bytes that have not arrived by now never will.
            while let Ok(came) = tokio::time::timeout(PATIENCE, line.receive(&mut bytes)).await {
                heard.extend(&bytes[..came.unwrap()]);
            }
        }
    }
    heard
}

const PATIENCE: std::time::Duration = std::time::Duration::from_millis(500);

#[tokio::test(start_paused = true)]
async fn the_same_seed_gives_the_same_line() {
    let faults = "replace=1e-3,flip=1e-3,drop=1e-3,insert=1e-3,duplicate=1e-3,swap=1e-3,drop-chunk=0.02,\
                  duplicate-chunk=0.02,swap-chunk=0.05,stall=0.02,rechunk=0.1";
    let once = heard(&format!("{faults},seed=7")).await;
    assert_eq!(heard(&format!("{faults},seed=7")).await, once);
    assert_ne!(heard(&format!("{faults},seed=8")).await, once);
    assert_ne!(heard("seed=7").await, once);
}

#[tokio::test(start_paused = true)]
async fn a_pulled_plug_comes_back_and_the_arm_is_the_same() {
    let arm = VirtualArm::default();
    let faults = with("unplug=0.2,unplug-ms=300,seed=3");
    let mut line = RawLine::simulated(arm, faults).await.unwrap();
    let mut pulled = 0;
    for _ in 0..50 {
        line.send(&[0xAA, 0xAA, 2, 10, 0, 0xF6]).await.unwrap();
        let mut bytes = [0; 64];
        match line.receive(&mut bytes).await {
            Ok(count) => assert_eq!(count, 38),
            Err(error) => {
                pulled += 1;
                assert!(error.to_string().contains("broke off"), "{error}");
                let out = line.reopen().await.unwrap_err();
                assert_eq!(out.kind(), ErrorKind::Port);
                tokio::time::advance(std::time::Duration::from_millis(300)).await;
                line.reopen().await.unwrap();
            }
        }
    }
    assert!((3..20).contains(&pulled), "{pulled}");
}

#[tokio::test]
async fn a_restart_strikes_a_virtual_arm() {
    let arm = VirtualArm::default();
    let faults = with("reset=1,only=requests");
    let mut line = RawLine::simulated(arm.clone(), faults).await.unwrap();
    line.send(&[0xAA, 0xAA, 2, 10, 0, 0xF6]).await.unwrap();
    let events = arm.with(|arm| std::iter::from_fn(|| arm.poll_event()).collect::<Vec<_>>());
    let reset = |event: &Event| matches!(event, Event::Reset);
    assert!(events.iter().any(reset), "{events:?}");
}

#[tokio::test]
async fn what_cannot_be_restarted_is_refused() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let target = format!("tcp:{}", listener.local_addr().unwrap());
    let target = target.parse().unwrap();
    let error = RawLine::open_with(&target, with("reset=0.1")).await;
    let error = error.err().unwrap();
    assert_eq!(error.kind(), ErrorKind::InvalidInput);
    assert!(error.to_string().contains("only a virtual arm"), "{error}");
}

#[tokio::test]
async fn rates_that_are_none_are_refused() {
    let faults = Faults {
        flip: f64::NAN,
        ..Faults::default()
    };
    let options = LineOptions::default().faults(faults);
    let error = RawLine::simulated(VirtualArm::default(), options).await;
    assert_eq!(error.err().unwrap().kind(), ErrorKind::InvalidInput);
}

#[tokio::test]
async fn without_faults_nothing_is_different() {
    let mut line = RawLine::simulated(VirtualArm::default(), with("seed=9"))
        .await
        .unwrap();
    assert!(answers(&mut line).await);
}

#[cfg(feature = "trace")]
mod traced {
    use std::io::Write;
    use std::sync::{Arc, Mutex};

    use magician::protocol::Direction;
    use magician::{LineOptions, RawLine, Tracer, VirtualArm};
    use magician_record::trace::read_trace;

    use crate::replug::answers;

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

    #[tokio::test]
    async fn what_passes_is_in_the_file_one_packet_a_frame() {
        let file = Memory::default();
        let options = LineOptions::default().trace(Tracer::new(file.clone()).unwrap());
        let mut line = RawLine::simulated(VirtualArm::default(), options)
            .await
            .unwrap();
        assert!(answers(&mut line).await);
        line.reopen().await.unwrap();
        assert!(answers(&mut line).await);
        line.send(&[0xAA, 0xAA]).await.unwrap();
        drop(line);
        let file = file.0.lock().unwrap().clone();
        let packets: Vec<_> = read_trace(&file).map(Result::unwrap).collect();
        let seen: Vec<_> = packets
            .iter()
            .map(|packet| {
                (
                    packet.direction.unwrap(),
                    packet.bytes.len(),
                    &*packet.link_name,
                )
            })
            .collect();
        let (request, reply) = (Direction::Request, Direction::Reply);
        assert_eq!(
            seen,
            [
                (request, 6, "sim"),
                (reply, 38, "sim"),
                (request, 6, "sim"),
                (reply, 38, "sim"),
                (request, 2, "sim")
            ]
        );
        assert!(packets.windows(2).all(|pair| pair[0].time <= pair[1].time));
    }
}
