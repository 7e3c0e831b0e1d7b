//! Images, and how they become laser power or lines.
//!
//! ```
//! use magician_program::raster::{Engrave, Grid, Size};
//! use magician_program::{Raster, Surface};
//!
//! let image = Raster { width: 2, height: 1, grey: vec![0, 255], ..Raster::default() };
//! let size = image.size(Size::Width(20.0))?;
//! assert_eq!(size, [20.0, 10.0]);
//! let grid = Grid::centred(size, [250.0, 0.0], 0.0, false);
//! let plan = Engrave::default().plan(&image, &grid, Surface::level(-60.0))?;
//! assert!(plan.steps.len() > 50);
//! # Ok::<(), magician_program::Diagnostic>(())
//! ```

mod centerline;
mod engrave;
mod grid;
mod halftone;
mod hatch;
mod outline;
mod resample;
mod scan;
mod shade;
mod specks;
mod squiggle;
#[cfg(all(test, feature = "readers"))]
mod tests;
mod tone;
mod trace;

pub use engrave::Engrave;
pub use grid::Grid;
pub use magician_formats::raster::{Adjust, Size};
pub use tone::Tone;
pub use trace::{ImageLines, ImageStyle, Trace};

use magician_formats::Raster;
use magician_formats::raster::check_positive;
