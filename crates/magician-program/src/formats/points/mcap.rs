//! Recordings as MCAP: the messages of `/pose` (<https://mcap.dev/spec>, foxglove.PoseInFrame as JSON).

use serde::Deserialize;

use super::recording::{self, Seen};
use crate::{NoteCode, Origin, Plan, Problem, Reading};

/// What such a file begins with.
pub(super) use mcap::MAGIC;

const NANOS: f64 = 1e9;
const MILLIMETRES: f64 = 1000.0;

/// What is taken of a foxglove.PoseInFrame, m.
#[derive(Deserialize)]
struct PoseInFrame {
    pose: Pose,
}

#[derive(Deserialize)]
struct Pose {
    position: Position,
    orientation: Orientation,
}

#[derive(Deserialize)]
struct Position {
    x: f64,
    y: f64,
    z: f64,
}

/// About the vertical.
#[derive(Deserialize)]
struct Orientation {
    z: f64,
    w: f64,
}

pub(super) fn read(bytes: &[u8]) -> Result<Reading<Plan>, Problem> {
    let wrong =
        |error: mcap::McapError| Problem::of_file(format!("this is no whole MCAP file: {error}"));
    let messages =
        mcap::MessageStream::new_with_options(bytes, mcap::read::Options::IgnoreEndMagic.into());
    let mut seen = Vec::new();
    let (mut first, mut cut_off) = (None, None);
    for message in messages.map_err(wrong)? {
        let message = match message {
            Ok(message) => message,
            // A recording that was cut off is followed as far as it goes.
            Err(error) if !seen.is_empty() => {
                cut_off = Some(error);
                break;
            }
            Err(error) => return Err(wrong(error)),
        };
        if message.channel.topic != "/pose" {
            continue;
        }
        if message.channel.message_encoding != "json" {
            let what = format!(
                "the messages of /pose are {}, and only JSON is read",
                message.channel.message_encoding
            );
            return Err(Problem::of_file(what));
        }
        let PoseInFrame { pose } = serde_json::from_slice(&message.data).map_err(|error| {
            Problem::of_file(format!(
                "a message of /pose is no foxglove.PoseInFrame: {error}"
            ))
        })?;
        let begun = *first.get_or_insert(message.log_time);
        let Position { x, y, z } = pose.position;
        let r = 2.0 * pose.orientation.z.atan2(pose.orientation.w).to_degrees();
        let pose = [x * MILLIMETRES, y * MILLIMETRES, z * MILLIMETRES, r];
        if pose.iter().any(|value| !value.is_finite()) {
            continue;
        }
        seen.push(Seen {
            t: message.log_time.saturating_sub(begun) as f64 / NANOS,
            pose,
            j4: None,
            origin: Origin::NONE,
        });
    }
    if seen.is_empty() {
        return Err(Problem::of_file(
            "there is no /pose in it: no way of the tool was recorded",
        ));
    }
    let mut reading = recording::plan(&seen)?;
    if let Some(error) = cut_off {
        let what = format!("the recording is cut off: {error}");
        let note = Problem::of_file(what).coded(NoteCode::LeftOut);
        reading.notes.push(note);
    }
    Ok(reading)
}
