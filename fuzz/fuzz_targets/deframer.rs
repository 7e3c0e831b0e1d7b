#![no_main]
//! Arbitrary bytes in any split: no panic, only real frames, and events that cover the stream
//! without gaps.

use libfuzzer_sys::fuzz_target;
use magician_protocol::{Deframer, Event, Frame};

/// Part of the stream that events have covered.
#[derive(Default)]
struct Cover {
    /// End of the reported part.
    reported: usize,
    /// End of the part that has been assigned to a frame or to noise.
    settled: usize,
}

impl Cover {
    fn take(&mut self, stream: &[u8], event: Event<'_>) {
        let (offset, bytes, settles) = match event {
            Event::Frame { offset, frame } => {
                assert!(Frame::new(frame.bytes()).is_some());
                (offset, frame.bytes(), true)
            }
            Event::Noise { offset, bytes } => {
                assert_eq!(offset, self.reported as u64, "noise is reported once");
                (offset, bytes, true)
            }
            Event::Rejected { offset, bytes, .. } => (offset, bytes, false),
        };
        let from = offset as usize;
        let to = from + bytes.len();
        assert!(!bytes.is_empty() && stream[from..to] == *bytes);
        assert!(
            from >= self.settled && from <= self.reported,
            "a gap or an overlap"
        );
        self.reported = self.reported.max(to);
        if settles {
            self.settled = to;
        }
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((size, stream)) = data.split_first() else {
        return;
    };
    let mut deframer = Deframer::new();
    let mut cover = Cover::default();
    for mut piece in stream.chunks(usize::from(*size).max(1)) {
        while let Some(event) = deframer.next(&mut piece) {
            cover.take(stream, event);
        }
        assert!(piece.is_empty());
    }
    deframer.expire();
    while let Some(event) = deframer.next(&mut &[][..]) {
        cover.take(stream, event);
    }
    assert!(!deframer.pending());
    assert_eq!(cover.reported, stream.len());
    assert_eq!(deframer.offset(), stream.len() as u64);
});
