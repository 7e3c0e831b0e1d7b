//! Pictures of what a Dobot Magician arm does: SVG, and PNG behind a feature.
//!
//! | what | shows |
//! |---|---|
//! | [`Preview`] | what a plan would draw, burn or carry, and where |
//! | [`Snapshot`] | an arm as it stands, and the world around a virtual one, or a run and what it moved |
//! | [`drawing_svg`] | what pen and laser left |
//! | [`Conversion`] | a plan as another kind of file, pictures among them |
//! | [`svg`] | the writer of all of them |
//!
//! The feature `png` adds pictures as pixels and `compare`, which tells how well two of them match.
//!
//! Lengths are mm, angles degrees.
#![forbid(unsafe_code)]
#![cfg_attr(docsrs, feature(doc_cfg))]
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

#[cfg(feature = "png")]
pub mod compare;
mod convert;
mod drawing;
mod fence;
mod ground;
mod layers;
mod legend;
mod panel;
#[cfg(feature = "png")]
mod png;
mod preview;
mod section;
mod snapshot;
pub mod svg;
mod symbols;

pub use convert::{Conversion, ConversionError};
#[cfg(feature = "png")]
pub use drawing::drawing_png;
pub use drawing::{DrawingOptions, drawing_svg};
#[cfg(feature = "png")]
pub use png::{PictureError, fitting, to_png};
pub use preview::{Preview, PreviewOptions};
pub use snapshot::{ArmView, MovedObject, RunReading, RunView, Snapshot};
#[cfg(feature = "png")]
pub use snapshot::{View, pixels};

/// Compiles the README's program with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
