//! Recordings: what an arm did, on its own clock, in a file that other programs understand.
//!
//! A recording is an MCAP file (<https://mcap.dev/spec>) of JSON messages, each topic with its JSON Schema in the file;
//! Foxglove opens it. The `Recorder` of a virtual arm (feature `sim`) is an `Observer`: it looks on and changes
//! nothing.
//!
//! | topic | schema | when |
//! |---|---|---|
//! | `/pose` | `foxglove.PoseInFrame` | 50 times a second |
//! | `/joints` | `foxglove.JointStates` | 50 times a second |
//! | `/tf` | `foxglove.FrameTransform` | each link that has turned, with every tenth sample |
//! | `/scene` | `foxglove.SceneUpdate` | what was drawn, every second; with the arm every 5 seconds |
//! | `/queue` | `magician.Queue.v1` | when it changes, and every second |
//! | `/io` | `magician.Io.v1` | when it changes, and every second |
//! | `/alarms` | `magician.Alarms.v1` | when they change, and every second |
//! | `/status` | `magician.Status.v1` | when it changes, and every second |
//! | `/frames` | `magician.Frame.v1` | every frame of every link, both ways, and what is none |
//! | `/events` | `foxglove.Log` | every event, in words |
//!
//! **Time.** Everything happens on the arm's clock, whatever the speed at which it runs. `log_time` and `publish_time`
//! are the epoch that the recorder was given plus the arm's clock, in nanoseconds; the epoch and the number of samples a
//! second stand in the file's metadata record `magician`. A sample is taken at every multiple of 20 ms of the arm's clock
//! exactly, moving or not. A request and its reply have the instant at which the arm handled the request.
//!
//! **In 3D.** `/tf` has the frames `base` (that of `/pose`), `turret`, `rear_arm`, `elbow`, `forearm`, `wrist`, `bracket` and `tip`, each
//! in the one before it ([`ArmModel::links`](magician_motion::ArmModel::links)), and `rail`, in which `base` slides, if there is one.
//! `/scene` has an entity for each link (`arm/forearm`) in its frame, and `strokes`, a list of lines for the pen and one for the
//! laser; lines since then are entities of their own (`strokes 1`) until `strokes` is written again. That is done every 5 seconds while little
//! was drawn, and later more rarely, so that it takes 24 bytes a sample. The line under way is written when it is finished. A viewer
//! that leaps to an instant shows the arm, or strokes of before, within that time.
//!
//! A host without the virtual arm writes its [`Readings`] in the same topics: `/pose`, `/joints`, `/tf`, `/scene`, `/queue` (without what a
//! host is not told), `/alarms`, and in `/events` what it noticed. It sees no ink: strokes are between readings whose tip was at the
//! [`Plane`] that it was told of, and there are none without one. `clock` in the metadata is `host` then.
//!
//! **Units.** The two Foxglove schemas of the pose want metres and radians and have them; [`Pose`](magician_motion::Pose)
//! in mm is `position` times 1000, r is the angle of `orientation` about z and keeps its turns (-360 to 360 deg), and the
//! joints are those of GetPose, and `L` for the rail if there is one. The tool bias is in mm. `params` of a frame are in the units of the protocol.
//!
//! **Size.** Nothing is compressed. An arm takes about 110 MB an hour of its clock while it stands, and 140 MB while it never does, 27 %
//! of them for `/tf` and `/scene`; about a megabyte stays in
//! memory: the index that is written at the end.
//!
//! **Ends.** A recording that is finished has a summary and an index. One whose program was killed
//! is whole up to the last second of the arm's clock, and any reader that goes through a file from its beginning reads
//! that far.

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

/// A point or span of time on the clock of a recording, microseconds.
type Micros = u64;

const SECOND: Micros = 1_000_000;
