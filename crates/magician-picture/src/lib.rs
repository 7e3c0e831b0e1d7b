//! Pictures of what a Dobot Magician arm does, as SVG, and as PNG behind a feature.
//!
//! | item | content |
//! |---|---|
//! | [`Preview`] | what a plan will draw, burn or carry, and where |
//! | [`Snapshot`] | an arm in its pose, the world around a virtual one, or a run and what it moved |
//! | [`drawing_svg`] | what pen and laser left |
//! | [`Conversion`] | a plan as another kind of file, including pictures |
//! | [`svg`] | the SVG writer behind all of them |
//!
//! The feature `png` adds PNG output and `compare`, which measures how well two pictures match.
//!
//! Lengths are in mm, angles in degrees.
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

/// Compiles the example of the README with the tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
