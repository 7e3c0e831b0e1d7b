//! Recordings: the actions of an arm on its own clock, in a file that other programs can open.
//!
//! A recording is an MCAP file (<https://mcap.dev/spec>) of JSON messages, with the JSON Schema of
//! each topic. Foxglove opens it. The `Recorder` of a virtual arm (feature `sim`) is an `Observer`,
//! so recording does not change the arm's behaviour.
//!
//! | topic | schema | written |
//! |---|---|---|
//! | `/pose` | `foxglove.PoseInFrame` | 50 times a second |
//! | `/joints` | `foxglove.JointStates` | 50 times a second |
//! | `/tf` | `foxglove.FrameTransform` | for each link that has turned, with every tenth sample |
//! | `/scene` | `foxglove.SceneUpdate` | new strokes every second, everything every 5 seconds |
//! | `/queue` | `magician.Queue.v1` | on change, and every second |
//! | `/io` | `magician.Io.v1` | on change, and every second |
//! | `/alarms` | `magician.Alarms.v1` | on change, and every second |
//! | `/status` | `magician.Status.v1` | on change, and every second |
//! | `/frames` | `magician.Frame.v1` | every frame of every link in both directions, and bytes outside of frames |
//! | `/events` | `foxglove.Log` | every event, as text |
//!
//! **Time.** All times are on the arm's clock, at whatever speed it runs. `log_time` and
//! `publish_time` are the epoch passed to the recorder plus the arm's clock, in nanoseconds. The
//! epoch and the number of samples per second are in the metadata record `magician` of the file. A
//! sample is taken exactly at every multiple of 20 ms of the arm's clock, moving or not. A request
//! and its reply have the instant at which the arm handled the request.
//!
//! **3D.** `/tf` has the frames `base` (that of `/pose`), `turret`, `rear_arm`, `elbow`, `forearm`,
//! `wrist`, `bracket` and `tip`, each in the one before it
//! ([`ArmModel::links`](magician_motion::ArmModel::links)); with a rail also `rail`, in which
//! `base` slides. `/scene` has an entity for each link (`arm/forearm`) in its frame, and `strokes`
//! with a list of lines for the pen and one for the laser. Later lines are entities of their own
//! (`strokes 1`) until `strokes` is written again: every 5 seconds at first, and more rarely as the
//! drawing grows, so that it takes 24 bytes per sample. A line in progress is written when it is
//! finished. A viewer that jumps to an instant shows the arm and earlier strokes within that time.
//!
//! **Hosts.** A host without the virtual arm writes its [`Readings`] to the same topics: `/pose`,
//! `/joints`, `/tf`, `/scene`, `/queue` (without running command and state), `/alarms`, and
//! `/events` with what it noticed. It cannot see ink: strokes connect readings whose tip was at the
//! given [`Plane`], and without one there are no strokes. `clock` in the metadata is then `host`.
//!
//! **Units.** The two Foxglove schemas of poses use metres and radians.
//! [`Pose`](magician_motion::Pose) in mm is `position` times 1000; r is the angle of `orientation`
//! about z and keeps its turns (-360 to 360 deg). Joints are those of GetPose, plus `L` for the
//! rail if there is one. The tool bias is in mm. `params` of a frame are in the units of the
//! protocol.
//!
//! **Size.** Nothing is compressed. An hour of the arm's clock takes about 110 MB at rest and 140
//! MB in constant motion, 27 % of it for `/tf` and `/scene`. About a megabyte stays in memory: the
//! index written at the end.
//!
//! **Incomplete files.** A finished recording has a summary and an index. That of a killed program
//! is complete up to the last second of the arm's clock, and any reader that reads sequentially
//! gets that far.

mod file;
mod frames;
mod message;
mod readings;
#[cfg(feature = "sim")]
mod recorder;
mod scene;
mod trace;

pub use readings::{Plane, Readings};
#[cfg(feature = "sim")]
pub use recorder::Recorder;
pub use trace::{FramesError, is_recording, trace_of};

/// An instant or a span on the clock of a recording, microseconds.
type Micros = u64;

const SECOND: Micros = 1_000_000;
