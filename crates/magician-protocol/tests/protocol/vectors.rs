//! Frames recorded from real arms, real hosts and independent implementations.

use crate::material;
use crate::material::{check, hex, vectors};
use magician_protocol::{Deframer, Event, Rejection};

#[test]
fn valid_frames_read_as_recorded_and_write_back() {
    let vectors: Vec<_> = vectors().into_iter().filter(|v| v.valid()).collect();
    assert_eq!(vectors.len(), 90);
    for vector in &vectors {
        check(vector);
        let frame = vector.frame();
        assert_eq!(u8::from(frame.ctrl().write()), vector.number("rw"));
        assert_eq!(u8::from(frame.ctrl().queued()), vector.number("is_queued"));
        assert_eq!(frame.bytes()[2], vector.number("len_byte"));
        assert_eq!(frame.bytes().last(), Some(&vector.number("checksum")));
        let params = hex(vector.fields["params_hex"].as_str().unwrap());
        assert_eq!(frame.params(), params);
    }
}

#[test]
fn invalid_frames_are_rejected_for_the_reason_on_record() {
    let vectors: Vec<_> = vectors().into_iter().filter(|v| !v.valid()).collect();
    assert_eq!(vectors.len(), 5);
    for vector in &vectors {
        let mut deframer = Deframer::new();
        let mut input = &vector.bytes[..];
        let why = vector.fields["why_invalid"].as_str().unwrap();
        if why.starts_with("5 bytes") {
            assert_eq!(deframer.next(&mut input), None, "{}", vector.id);
            deframer.expire();
        }
        let Some(Event::Rejected {
            offset,
            bytes,
            reason,
        }) = deframer.next(&mut input)
        else {
            panic!("{}: not rejected", vector.id);
        };
        assert_eq!((offset, bytes), (0, &vector.bytes[..]), "{}", vector.id);
        let message = match reason {
            Rejection::Checksum { expected, found } => {
                format!("checksum {found:02X}, expected {expected:02X}")
            }
            Rejection::Truncated => "5 bytes: the ID was forgotten in GetHHTTrigOutput".to_owned(),
            Rejection::Length(len) => format!("length {len}"),
        };
        assert_eq!(message, why, "{}", vector.id);
        while let Some(event) = deframer.next(&mut input) {
            assert!(!matches!(event, Event::Frame { .. }), "{}", vector.id);
        }
    }
}

/// Frames found when the bytes arrive in these pieces.
fn deframe(pieces: &[&[u8]]) -> Vec<Vec<u8>> {
    let mut deframer = Deframer::new();
    let mut frames = Vec::new();
    for piece in pieces {
        let mut input = *piece;
        collect(&mut deframer, &mut input, &mut frames);
    }
    deframer.expire();
    collect(&mut deframer, &mut &[][..], &mut frames);
    assert!(!deframer.pending());
    frames
}

fn collect(deframer: &mut Deframer, input: &mut &[u8], frames: &mut Vec<Vec<u8>>) {
    while let Some(event) = deframer.next(input) {
        if let Event::Frame { frame, .. } = event {
            frames.push(frame.bytes().to_vec());
        }
    }
}

#[test]
fn stream_yields_its_frames_for_every_split() {
    let table: toml::Table = toml::from_str(material::VECTORS).unwrap();
    let streams = table["stream"].as_array().unwrap();
    assert_eq!(streams.len(), 6);
    for stream in streams {
        let bytes = hex(stream["hex"].as_str().unwrap());
        let frames = stream["expect_frames"].as_array().unwrap();
        let expected: Vec<_> = frames.iter().map(|f| hex(f.as_str().unwrap())).collect();
        let id = &stream["id"];

        assert_eq!(deframe(&[&bytes]), expected, "{id} whole");
        let single: Vec<&[u8]> = bytes.chunks(1).collect();
        assert_eq!(deframe(&single), expected, "{id} byte by byte");
        for at in 0..=bytes.len() {
            let (one, two) = bytes.split_at(at);
            assert_eq!(deframe(&[one, two]), expected, "{id} cut at {at}");
        }
    }
}

#[test]
fn incomplete_frame_is_completed_by_later_bytes() {
    let mut deframer = Deframer::new();
    assert_eq!(deframer.next(&mut &hex("AA AA 02 0A")[..]), None);
    assert!(deframer.pending());
    let rest = hex("00 F6");
    let mut input = &rest[..];
    let event = deframer.next(&mut input);
    assert!(matches!(event, Some(Event::Frame { offset: 0, .. })));
}
