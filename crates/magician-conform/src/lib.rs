//! What a Dobot Magician's controller does, as cases that an arm can be held against: virtual or real.
//!
//! # Cases
//!
//! A case is a table in a file of its chapter (`cases/*.toml`), made to be read:
//!
//! ```toml
//! [[case]]
//! id = "ptp.movl-100-mm"                  # chapter, dot, a name
//! title = "100 mm straight take 2 s at half speed"
//! source = "model 7"                      # the source
//! confidence = "VL"                       # how sure that is, see Confidence
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
//! Besides these a case may have `begin = "power-up"` (see [`Begin`]), `exact = true` (it looks at what a clock that
//! runs by itself blurs), `hurts = "..."` and `sim_only = "..."` (why it is not for a real arm), `world = "..."` (what lies around a
//! virtual arm, a [scenario](magician_sim::scenario)), `assumes = ["PtpLaw"]` (the [assumptions](magician_sim::fidelity) without which it
//! fails), and `alarm = { code, arises, goes }` (a row of the page of alarms that it holds). `each = [{ mode = 1, x = 200 }, ..]` makes a case
//! of each of these, with its values for `{mode}` and `{x}` in all texts.
//!
//! # Steps
//!
//! One a line. `#` begins a remark, `32x` before a step does it so often, `"` keeps words together.
//!
//! | step | what it does |
//! |---|---|
//! | `get NAME [key=value ..] [-> field=value ..]` | asks, and wants exactly one answer that echoes id and Ctrl and carries this |
//! | `set NAME [key=value ..]` | sets at once, and wants an empty answer |
//! | `queue NAME [key=value ..] [-> full]` | queues, and wants an index one above the one before; `full`: refused |
//! | `frame COMMAND CTRL [BYTES ..]` | sends a frame with a right checksum, Ctrl and parameters in hex |
//! | `send BYTES ..` | sends bytes as they are, damaged frames for one |
//! | `answered [-> field=value ..]` | the answer to the frame sent last, as `get`, `set` and `queue` want it |
//! | `reply BYTES ..` | the next frame from the arm, byte for byte; `..` is any byte |
//! | `silence` | nothing comes from the arm |
//! | `wait 1.5 s`, `at 1.5 s` | lets time pass: so much, or until so long after the last set or queued command |
//! | `done [after 2 s [+- 10 ms]]` | lets time pass until the command queued last has finished, and wants that to be then |
//! | `rest` | lets time pass until the arm stands |
//! | `finished last`, `last-1`, `nothing` | which queued command finished last |
//! | `alarms none`, `0x11 ..`, `with ..`, `without ..` | which alarms stand |
//! | `happens ..` | something happens to a virtual arm: `key short`, `key long`, `unlock press`, `unlock release`, `guide J1 J2 J3 J4`, `slip JOINT DEGREES`, `alarm CODE`, `reset` |
//! | `sees laser=30 ..` | what an observer of a virtual arm sees: `laser` percent, `suction`, `gripper`, `holding` 0 or
//! 1, `pulses0`, `pulses1` |
//! | `link 1` | from here on another host asks, on a link of its own; 0 is the first |
//!
//! A field is compared with `=`, `!=`, `<`, `<=`, `>`, `>=`; `x=200+-0.01` has a tolerance, without one the number must be
//! the nearest that the wire has; arrays are `0,45,_,0` with `_` for anything.
//!
//! # Arms
//!
//! A [`Target`] is an arm with a clock: [`SimTarget`] a virtual arm whose clock it steps, [`LineTarget`] an arm at the end of a line, for
//! which the clock on the wall runs. [`Runner`] runs the cases on it.
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
