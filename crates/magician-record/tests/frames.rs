//! Frames in a host's recording, from the bytes on its line, and their extraction as a trace.

mod recording;

use magician_protocol::Direction::{Reply, Request};
use magician_record::mcap::{FramesError, Readings, Recorder, is_recording, trace_of};
use magician_record::trace::read_trace;
use magician_sim::{ArmInstant, Controller, LinkId, Observer};
use recording::{EPOCH, of, read};

const GET_POSE: [u8; 6] = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];
const LEFT_SPACE: [u8; 10] = [0xAA, 0xAA, 0x06, 0xF7, 0x00, 0x20, 0x00, 0x00, 0x00, 0xE9];

#[test]
fn split_frames_are_joined_and_bytes_outside_frames_are_recorded() {
    let mut readings = Readings::new(Vec::new(), EPOCH, 50.0).unwrap();
    let mut pass =
        |t, direction, bytes: &[u8]| readings.passed(t, "usb", direction, bytes).unwrap();
    pass(0.0, Request, &GET_POSE[..2]);
    pass(0.001, Reply, &LEFT_SPACE);
    pass(0.002, Request, &GET_POSE[2..]);
    pass(0.003, Reply, &[0x00, 0x13]);
    pass(0.004, Reply, &LEFT_SPACE);
    // A frame that is never completed: silence or the end of the file ends it.
    pass(0.5, Request, &GET_POSE[..3]);
    pass(0.6, Request, &GET_POSE);
    pass(0.7, Request, &GET_POSE[..4]);
    let file = readings.into_file().unwrap();
    let (all, _) = read(&file);
    let recorded: Vec<_> = { of(&all, "/frames").into_iter() }
        .map(|frame| {
            let value = &frame.value;
            let text = |name: &str| value[name].as_str().unwrap_or_default().to_owned();
            (frame.at, text("direction"), text("hex"), text("command"))
        })
        .collect();
    let frame = |at, direction: &str, hex: &str, command: &str| {
        (at, direction.to_owned(), hex.to_owned(), command.to_owned())
    };
    let space = "AAAA06F70020000000E9";
    assert_eq!(
        recorded[..2],
        [
            frame(1000, "reply", space, "GetQueuedCmdLeftSpace"),
            frame(2000, "request", "AAAA020A00F6", "GetPose"),
        ]
    );
    assert!(
        recorded.contains(&frame(3000, "reply", "0013", "")),
        "{recorded:?}"
    );
    assert!(
        recorded.contains(&frame(600_000, "request", "AAAA020A00F6", "GetPose")),
        "{recorded:?}"
    );
    // All bytes are present, in order.
    let sent: String = recorded
        .iter()
        .filter(|one| one.1 == "request")
        .map(|one| &*one.2)
        .collect();
    assert_eq!(sent, "AAAA020A00F6AAAA02AAAA020A00F6AAAA020A");
}

#[test]
fn the_frames_of_a_recording_are_a_trace() {
    let mut arm = Controller::default();
    let mut recorder = Recorder::new(Vec::new(), EPOCH).unwrap();
    recorder.name(LinkId(0), "usb");
    for ms in [100, 200, 300] {
        arm.advance_observed(ArmInstant::from_micros(ms * 1000), &mut recorder);
        recorder.request_bytes(arm.now(), LinkId(0), &GET_POSE);
        for reply in arm.exchange(LinkId(0), &GET_POSE) {
            recorder.reply(arm.now(), LinkId(0), &reply);
        }
    }
    let file = recorder.finish().unwrap();
    assert!(is_recording(&file) && !is_recording(&GET_POSE));
    let trace = trace_of(&file).unwrap();
    let packets: Vec<_> = read_trace(&trace).map(Result::unwrap).collect();
    let epoch = EPOCH / 1000;
    let recorded: Vec<_> = packets
        .iter()
        .map(|one| (one.time - epoch, one.direction))
        .collect();
    assert_eq!(
        recorded,
        [
            (100_000, Some(Request)),
            (100_000, Some(Reply)),
            (200_000, Some(Request)),
            (200_000, Some(Reply)),
            (300_000, Some(Request)),
            (300_000, Some(Reply)),
        ]
    );
    assert!(packets.iter().all(|one| one.link_name == "usb"));
    assert_eq!(packets[0].bytes, GET_POSE);
    // A file truncated at any byte gives at most these packets, or the error `Empty` or
    // `Unreadable`.
    for end in (8..file.len()).step_by(101) {
        match trace_of(&file[..end]) {
            Ok(part) => assert!(read_trace(&part).count() <= 6),
            Err(FramesError::Empty | FramesError::Unreadable(_)) => {}
            Err(error) => panic!("{error}"),
        }
    }
}
