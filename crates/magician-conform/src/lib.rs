//! Conformance cases for the controller of a Dobot Magician, to be run on virtual and real arms.
//!
//! # Cases
//!
//! A case is a TOML table in the file of its chapter (`cases/*.toml`):
//!
//! ```toml
//! [[case]]
//! id = "ptp.movl-100-mm"                  # chapter, dot, a name
//! title = "100 mm straight take 2 s at half speed"
//! source = "model 7"                      # section of docs/reference/MODEL.md
//! confidence = "VL"                       # confidence in the source, see Confidence
//! moves = true                            # the arm moves
//! steps = '''
//! set QueuedCmdStartExec
//! queue PTPCmd ptp_mode=1 x=200 y=0 z=0 r=0
//! done
//! queue PTPCmd ptp_mode=7 x=0 y=100 z=0 r=0
//! done after 2 s
//! get Pose -> x=200+-0.01 y=100+-0.01
//! '''
//! ```
//!
//! Further keys of a case:
//!
//! * `begin = "power-up"`: the initial state (see [`Begin`]).
//! * `exact = true`: the case examines states that a free-running clock blurs.
//! * `hurts = "..."` and `sim_only = "..."`: why it is not for a real arm.
//! * `world = "..."`: the world of the virtual arm, a [scenario](magician_sim::scenario).
//! * `assumes = ["PtpLaw"]`: the [assumptions](magician_sim::fidelity) without which it fails.
//! * `alarm = { code, arises, goes }`: the row about an alarm in the documentation that this case
//!   proves.
//! * `each = [{ mode = 1, x = 200 }, ..]`: makes one case per table of the list, with its values in
//!   place of `{mode}` and `{x}` in all texts.
//!
//! # Steps
//!
//! One per line. `#` starts a comment, `32x` before a step repeats it, `"` keeps words together.
//!
//! | step | what it does |
//! |---|---|
//! | `get NAME [key=value ..] [-> field=value ..]` | reads, and expects exactly one answer with the same id and Ctrl and these values |
//! | `set NAME [key=value ..]` | sets immediately, and expects an empty answer |
//! | `queue NAME [key=value ..] [-> full]` | queues, and expects the next index; `full`: a refusal |
//! | `frame COMMAND CTRL [BYTES ..]` | sends a frame with a correct checksum; Ctrl and parameters in hex |
//! | `send BYTES ..` | sends bytes unchanged, for example damaged frames |
//! | `answered [-> field=value ..]` | expects the answer to the last frame, as `get`, `set` and `queue` do |
//! | `reply BYTES ..` | expects the next frame from the arm, byte for byte; `..` is any byte |
//! | `silence` | expects nothing from the arm |
//! | `wait 1.5 s`, `at 1.5 s` | lets time pass: for this time, or until this time has elapsed since the last set or queued command |
//! | `done [after 2 s [+- 10 ms]]` | lets time pass until the last queued command has finished; with `after`, expects that this much time has elapsed since the last set or queued command |
//! | `rest` | lets time pass until the arm is at rest |
//! | `finished last`, `last-1`, `nothing` | expects this queued command to have finished last |
//! | `alarms none`, `0x11 ..`, `with ..`, `without ..` | expects these active alarms |
//! | `happens ..` | external event of a virtual arm: `key short`, `key long`, `unlock press`, `unlock release`, `guide J1 J2 J3 J4`, `slip JOINT DEGREES`, `alarm CODE`, `reset` |
//! | `sees laser=30 ..` | expects these outputs of a virtual arm: `laser` percent, `suction`, `gripper`, `holding` 0 or 1, `pulses0`, `pulses1` |
//! | `link 1` | continues as another host, on a separate link; 0 is the first |
//!
//! A field is compared with `=`, `!=`, `<`, `<=`, `>`, `>=`. `x=200+-0.01` has a tolerance; without
//! one the number must be the nearest that the wire can represent. Arrays are written `0,45,_,0`,
//! where `_` matches anything.
//!
//! # Arms
//!
//! A [`Target`] is an arm with a clock: [`SimTarget`] is a virtual arm whose clock is stepped,
//! [`LineTarget`] an arm at the end of a line that follows the wall clock. [`Runner`] runs the
//! cases on it.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]

mod case;
mod expect;
mod report;
mod runner;
mod session;
mod step;
mod suite;
mod target;
mod words;

pub use case::{AlarmCase, Begin, Case, Confidence};
pub use report::{Mismatch, Outcome, hex, in_words};
pub use runner::Runner;
pub use step::Observable;
pub use suite::{Suite, SuiteError};
pub use target::{LINE_LOOK, LineTarget, SimTarget, Target};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
