//! Tables of the binary frame, close codes and optional features.

/// Part of the binary frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FramePart {
    /// Offset of its first byte.
    pub offset: usize,
    /// `u8`, `u16`, `u32` or `f64`, little endian.
    pub kind: &'static str,
    /// Name.
    pub name: &'static str,
    /// Unit. Empty without a unit.
    pub unit: &'static str,
    /// Meaning.
    pub about: &'static str,
}

const fn part(
    offset: usize,
    kind: &'static str,
    name: &'static str,
    unit: &'static str,
    about: &'static str,
) -> FramePart {
    FramePart {
        offset,
        kind,
        name,
        unit,
        about,
    }
}

/// Layout of the frame for subscriptions with `frame: "binary"`.
pub const FRAME_PARTS: [FramePart; 17] = [
    part(0, "u8", "mark", "", "0x4D"),
    part(1, "u8", "version", "", "1"),
    part(2, "u16", "subscription", "", "id of the subscription"),
    part(
        4,
        "u32",
        "sequence",
        "",
        "number of the state, from 0, wraps after 4294967295; numbers of dropped states are missing",
    ),
    part(8, "f64", "t", "Unix seconds", "time of the reading"),
    part(16, "f64", "x", "mm", "position of the tool tip"),
    part(24, "f64", "y", "mm", "position of the tool tip"),
    part(32, "f64", "z", "mm", "position of the tool tip"),
    part(40, "f64", "r", "deg", "rotation of the tool"),
    part(48, "f64", "j1", "deg", "joint 1"),
    part(56, "f64", "j2", "deg", "joint 2"),
    part(64, "f64", "j3", "deg", "joint 3"),
    part(72, "f64", "j4", "deg", "joint 4"),
    part(
        80,
        "f64",
        "rail",
        "mm",
        "position on the rail; NaN without a rail",
    ),
    part(
        88,
        "f64",
        "current_index",
        "",
        "queue index of the last finished command",
    ),
    part(
        96,
        "f64",
        "left_space",
        "commands",
        "free places in the arm's queue",
    ),
    part(104, "f64", "flags", "", "sum of the flags that are set"),
];

/// Flags of a frame: bit, name, meaning. Other bits are reserved.
pub const FRAME_FLAGS: [(u32, &str, &str); 7] = [
    (1, "link", "the line to the arm is up"),
    (2, "moving", "the arm moves, or may move"),
    (4, "alarm", "an alarm holds the queue"),
    (8, "laser", "the laser may burn"),
    (16, "jog", "a jog is in progress"),
    (32, "job", "a job runs"),
    (64, "lease", "the lease is taken"),
];

/// Codes with which the station closes a socket.
pub const CLOSE_CODES: &[(u16, &str)] = &[
    (1001, "the station ends"),
    (1003, "a binary message"),
    (1007, "not UTF-8"),
    (1009, "a message of more than 1 MiB"),
    (1013, "tokens cannot be checked now"),
    (4400, "the first message was not a valid hello"),
    (4401, "missing or invalid token"),
    (4403, "the token was revoked"),
    (
        4408,
        "no hello within 5 s (2 s from another machine), or displaced by a newer socket before hello",
    ),
    (4409, "the session continues on another socket"),
    (4413, "reads too slowly: more than 256 KiB are pending"),
    (4429, "too many messages over five seconds"),
    (
        4503,
        "the station has its largest number of sessions or viewers: try again later",
    ),
];

/// Optional feature of a station.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeatureRow {
    /// Name, as in `server.info`.
    pub name: &'static str,
    /// Methods and parameters that it adds.
    pub about: &'static str,
}

macro_rules! features {
    ($($feature:ident = $name:literal, $about:literal;)*) => {
        /// Optional feature of a station.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Feature {
            $(#[doc = $about] $feature,)*
        }

        /// All features, in documentation order.
        pub static FEATURES: &[FeatureRow] = &[$(FeatureRow { name: $name, about: $about },)*];

        impl Feature {
            /// All features.
            pub const ALL: &'static [Self] = &[$(Self::$feature,)*];

            /// Returns the name, as in `server.info`.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$feature => $name,)*
                }
            }
        }
    };
}

features! {
    BinaryFrames = "binary-frames", "`arm.subscribe` takes `\"frame\": \"binary\"`.";
    Events = "events", "`arm.event` and `events.since`.";
    JobQueue = "job-queue", "`job.start` takes `\"queue\": true`.";
    Library = "library", "Library of programs: `program.*`, and `program` of `job.start`.";
    Presets = "presets", "`preset.*`, and `preset` of `setup`.";
    Recording = "recording", "`record.*`, and GET of recordings.";
    Classes = "class", "`class.*`, `turn.*`, `schedule.*`, and `pupil` of `session.hello`.";
    Worlds = "world", "A virtual arm in the station: `world.*`.";
    Control = "control", "Roles above viewer exist: arms can be moved.";
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{FRAME_FIELDS, FRAME_SIZE};
    use crate::station::CloseCode;

    #[test]
    fn frame_parts_are_contiguous_and_fill_the_frame() {
        let mut at = 0;
        for part in FRAME_PARTS {
            assert_eq!(part.offset, at, "{}", part.name);
            at += match part.kind {
                "u8" => 1,
                "u16" => 2,
                "u32" => 4,
                _ => 8,
            };
        }
        assert_eq!(at, FRAME_SIZE);
        let values: Vec<_> = { FRAME_PARTS.iter() }
            .filter(|part| part.kind == "f64")
            .map(|part| part.name)
            .collect();
        assert_eq!(values, FRAME_FIELDS);
    }

    #[test]
    fn every_close_code_is_documented() {
        let own = [
            CloseCode::BAD_HELLO,
            CloseCode::BAD_TOKEN,
            CloseCode::REVOKED,
            CloseCode::HELLO_TIMEOUT,
            CloseCode::TAKEN_OVER,
            CloseCode::SLOW,
            CloseCode::TOO_MANY,
            CloseCode::FULL,
        ];
        for code in own {
            assert!(CLOSE_CODES.iter().any(|(known, _)| *known == code.0));
        }
    }
}
