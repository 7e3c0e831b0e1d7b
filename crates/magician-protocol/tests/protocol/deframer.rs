//! Events of the deframer for foreign, damaged and unfinished bytes.

use magician_protocol::{Deframer, Event, MAX_FRAME, Rejection};

const GET_POSE: [u8; 6] = [0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF6];

/// An event with its own bytes.
#[derive(Debug, PartialEq)]
enum Seen {
    Frame(u64, Vec<u8>),
    Rejected(u64, Vec<u8>, Rejection),
    Noise(u64, Vec<u8>),
}

fn seen(event: Event<'_>) -> Seen {
    match event {
        Event::Frame { offset, frame } => Seen::Frame(offset, frame.bytes().to_vec()),
        Event::Rejected {
            offset,
            bytes,
            reason,
        } => Seen::Rejected(offset, bytes.to_vec(), reason),
        Event::Noise { offset, bytes } => Seen::Noise(offset, bytes.to_vec()),
    }
}

fn drain(deframer: &mut Deframer, mut input: &[u8]) -> Vec<Seen> {
    let mut all = Vec::new();
    while let Some(event) = deframer.next(&mut input) {
        all.push(seen(event));
    }
    assert!(input.is_empty());
    all
}

fn whole(input: &[u8]) -> Vec<Seen> {
    let mut deframer = Deframer::new();
    let mut all = drain(&mut deframer, input);
    deframer.expire();
    all.extend(drain(&mut deframer, &[]));
    assert!(!deframer.pending());
    assert_eq!(deframer.offset(), input.len() as u64);
    all
}

#[test]
fn foreign_text_is_one_run_of_noise() {
    let input = [b"M10\r\n", &GET_POSE[..], b"ok", &GET_POSE].concat();
    assert_eq!(
        whole(&input),
        [
            Seen::Noise(0, b"M10\r\n".to_vec()),
            Seen::Frame(5, GET_POSE.to_vec()),
            Seen::Noise(11, b"ok".to_vec()),
            Seen::Frame(13, GET_POSE.to_vec()),
        ]
    );
}

#[test]
fn single_header_bytes_are_noise_with_their_neighbours() {
    let input = [0x01, 0xAA, 0x02, 0xAA, 0x03];
    assert_eq!(whole(&input), [Seen::Noise(0, input.to_vec())]);
    assert_eq!(
        whole(&[0x01, 0xAA]),
        [Seen::Noise(0, vec![1]), Seen::Noise(1, vec![0xAA])]
    );
}

#[test]
fn a_rejected_candidate_is_reported_once_and_not_again_as_noise() {
    let mut bad = GET_POSE;
    bad[5] = 0xF4;
    let reason = Rejection::Checksum {
        expected: 0xF6,
        found: 0xF4,
    };
    let input = [&bad[..], b"x", &GET_POSE].concat();
    assert_eq!(
        whole(&input),
        [
            Seen::Rejected(0, bad.to_vec(), reason),
            Seen::Noise(6, b"x".to_vec()),
            Seen::Frame(7, GET_POSE.to_vec()),
        ]
    );
}

#[test]
fn a_frame_inside_a_rejected_candidate_is_found() {
    let input = [&[0xAA, 0xAA, 9, 1, 0][..], &GET_POSE, &[1, 2]].concat();
    let all = whole(&input);
    assert!(
        matches!(&all[0], Seen::Rejected(0, bytes, Rejection::Checksum { .. }) if bytes.len() == 13)
    );
    assert_eq!(all[1..], [Seen::Frame(5, GET_POSE.to_vec())]);
}

#[test]
fn impossible_lengths_are_rejected_at_once() {
    for len in [0, 1, 251, 255] {
        let mut deframer = Deframer::new();
        let input = [&[0xAA, 0xAA, len][..], &GET_POSE].concat();
        assert_eq!(
            drain(&mut deframer, &input),
            [
                Seen::Rejected(0, vec![0xAA, 0xAA, len], Rejection::Length(len)),
                Seen::Frame(3, GET_POSE.to_vec()),
            ]
        );
    }
}

#[test]
fn the_longest_frame_passes() {
    let frame =
        magician_protocol::FrameBuf::new(1, magician_protocol::Ctrl::SET, &[7; 248]).unwrap();
    assert_eq!(frame.bytes().len(), MAX_FRAME);
    for size in 1..=MAX_FRAME {
        let mut deframer = Deframer::new();
        let mut all = Vec::new();
        let stream = [frame.bytes(), frame.bytes(), frame.bytes()].concat();
        for piece in stream.chunks(size) {
            all.extend(drain(&mut deframer, piece));
        }
        assert_eq!(all.len(), 3, "pieces of {size}");
        assert!(
            all.iter()
                .all(|s| matches!(s, Seen::Frame(_, b) if b == frame.bytes()))
        );
    }
}

#[test]
fn expire_rejects_candidate_and_finds_frame_inside() {
    let mut deframer = Deframer::new();
    let input = [&[0xAA][..], &GET_POSE].concat();
    assert_eq!(drain(&mut deframer, &input), []);
    assert!(deframer.pending());
    deframer.expire();
    assert_eq!(
        drain(&mut deframer, &[]),
        [
            Seen::Rejected(0, input.clone(), Rejection::Truncated),
            Seen::Frame(1, GET_POSE.to_vec()),
        ]
    );
    assert!(!deframer.pending());
}

#[test]
fn silence_ends_before_the_next_bytes() {
    let mut deframer = Deframer::new();
    assert_eq!(drain(&mut deframer, &GET_POSE[..3]), []);
    deframer.expire();
    assert_eq!(
        drain(&mut deframer, &GET_POSE),
        [
            Seen::Rejected(0, GET_POSE[..3].to_vec(), Rejection::Truncated),
            Seen::Frame(3, GET_POSE.to_vec()),
        ]
    );
    // Without a silence, a frame split over two writes waits for its rest.
    assert_eq!(drain(&mut deframer, &GET_POSE[..3]), []);
    assert_eq!(
        drain(&mut deframer, &GET_POSE[3..]),
        [Seen::Frame(9, GET_POSE.to_vec())]
    );
    deframer.expire();
    assert_eq!(drain(&mut deframer, &[]), []);
}

#[test]
fn every_byte_is_reported_and_noise_only_once() {
    let mut seed = 1u32;
    for _ in 0..300 {
        let mut stream = Vec::new();
        while stream.len() < 700 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match seed >> 30 {
                0 => stream.extend(GET_POSE),
                1 => stream.extend([0xAA; 3].iter().take((seed >> 20) as usize % 4)),
                2 => stream.extend([0xAA, 0xAA, (seed >> 16) as u8]),
                _ => stream.push((seed >> 16) as u8),
            }
        }
        tiles(&stream, seed as usize % 97 + 1);
    }
}

fn tiles(stream: &[u8], piece: usize) {
    let mut deframer = Deframer::new();
    let mut all = Vec::new();
    for piece in stream.chunks(piece) {
        all.extend(drain(&mut deframer, piece));
    }
    deframer.expire();
    all.extend(drain(&mut deframer, &[]));
    let (mut covered, mut framed) = (0, 0);
    for event in all {
        let (offset, bytes, new) = match &event {
            Seen::Frame(offset, bytes) => (*offset, bytes, framed),
            Seen::Noise(offset, bytes) => (*offset, bytes, covered),
            Seen::Rejected(offset, bytes, _) => (*offset, bytes, framed),
        };
        let (from, to) = (offset as usize, offset as usize + bytes.len());
        assert!(from >= new && from <= covered, "{event:?}");
        assert_eq!(stream[from..to], bytes[..]);
        covered = covered.max(to);
        if !matches!(event, Seen::Rejected(..)) {
            framed = to;
        }
    }
    assert_eq!(covered, stream.len());
}

#[test]
fn the_worst_input_costs_bounded_work() {
    // Each checksum computed ends in a frame or a checksum rejection, so events count the work.
    let worst: [&[u8]; 3] = [&[0xAA], &[0xAA, 0xAA, 0xFA], &[0xAA, 0xAA, 0xAA, 0xFA]];
    for pattern in worst {
        let stream: Vec<u8> = pattern.iter().copied().cycle().take(20_000).collect();
        for size in [1, 7, 254, 20_000] {
            let mut deframer = Deframer::new();
            let mut added = 0;
            for piece in stream.chunks(size) {
                for event in drain(&mut deframer, piece) {
                    match event {
                        Seen::Frame(_, bytes) => added += bytes.len() - 4,
                        Seen::Rejected(_, bytes, Rejection::Checksum { .. }) => {
                            added += bytes.len() - 4;
                        }
                        _ => {}
                    }
                }
            }
            assert!(
                added > 50 * stream.len(),
                "{added} additions: not the worst"
            );
            assert!(added <= 256 * stream.len(), "{added} additions");
        }
    }
}

#[test]
fn state_is_small() {
    assert!(size_of::<Deframer>() <= 512, "{}", size_of::<Deframer>());
}

#[test]
fn damaged_len_with_matching_checksum_is_rejected() {
    // The Len of the first frame was 3; damaged to 10, the checksum matches by chance.
    let first = [0xAA, 0xAA, 0x0A, 0x04, 0x00, 0x00, 0xFC];
    let second = [0xAA, 0xAA, 0x02, 0xF2, 0x01, 0x0D];
    let input = [&first[..], &second, &GET_POSE].concat();
    let candidate = &input[..14];
    assert!(magician_protocol::Frame::new(candidate).is_some());
    assert_eq!(
        whole(&input),
        [
            Seen::Rejected(0, candidate.to_vec(), Rejection::Length(10)),
            Seen::Frame(7, second.to_vec()),
            Seen::Frame(13, GET_POSE.to_vec()),
        ]
    );
}

#[test]
fn frame_inside_valid_parameters_is_not_split() {
    let frame = |id, params: &[u8]| {
        magician_protocol::FrameBuf::new(id, magician_protocol::Ctrl(0), params).unwrap()
    };
    let pose = [&GET_POSE[..], &[0; 26]].concat();
    let outputs = [&[0; 19][..], &GET_POSE].concat();
    for good in [
        frame(10, &pose),
        frame(88, &outputs),
        frame(20, &pose[..16]),
    ] {
        assert_eq!(whole(good.bytes()), [Seen::Frame(0, good.bytes().to_vec())]);
    }
    // No layout of this command is that long: the Len is damaged.
    let false_one = frame(13, &pose);
    assert!(whole(false_one.bytes()).contains(&Seen::Frame(5, GET_POSE.to_vec())));
}

/// A header with a length below 2 begins no frame, whatever checksum follows, so none is swallowed.
#[test]
fn a_header_of_an_impossible_length_inside_a_good_frame_is_its_content() {
    for inner in [
        // Length 0, and the checksum of nothing.
        [0xAA, 0xAA, 0x00, 0x00, 0x00, 0x00],
        // Length 1: an id without Ctrl, and its checksum.
        [0xAA, 0xAA, 0x01, 0x0A, 0xF6, 0x00],
    ] {
        // A get with surplus bytes: not a usual length.
        let params = [&inner[..], &inner[..]].concat();
        let frame =
            magician_protocol::FrameBuf::new(10, magician_protocol::Ctrl(0), &params).unwrap();
        let bytes = frame.bytes();
        assert_eq!(whole(bytes), [Seen::Frame(0, bytes.to_vec())]);
    }
}
