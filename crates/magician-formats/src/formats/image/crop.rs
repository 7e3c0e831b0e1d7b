//! Cropping of images, in pixels of the file.

use ::image::metadata::Orientation;
use magician_host::{Message, message};

/// A window of an image in the orientation of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) x: u32,
    pub(super) y: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

/// True if the orientation swaps width and height.
pub(super) fn swaps_sides(orientation: Orientation) -> bool {
    matches!(
        orientation,
        Orientation::Rotate90
            | Orientation::Rotate270
            | Orientation::Rotate90FlipH
            | Orientation::Rotate270FlipH
    )
}

impl Window {
    /// Converts a crop of the upright image to the orientation of the file; the whole image without
    /// a crop.
    pub(super) fn new(
        [width, height]: [u32; 2],
        orientation: Orientation,
        crop: Option<[u32; 4]>,
    ) -> Result<Self, Message> {
        let Some([x, y, across, down]) = crop else {
            return Ok(Self {
                x: 0,
                y: 0,
                width,
                height,
            });
        };
        let seen = if swaps_sides(orientation) {
            [height, width]
        } else {
            [width, height]
        };
        let beyond =
            |from: u32, side: u32, all: u32| from.checked_add(side).is_none_or(|to| to > all);
        if across == 0 || down == 0 || beyond(x, across, seen[0]) || beyond(y, down, seen[1]) {
            return Err(message!(
                "the crop {x},{y},{across},{down} is not within the image of {width} by {height} pixels",
                x,
                y,
                across,
                down,
                width = seen[0],
                height = seen[1]
            ));
        }
        // Distances from the right and the bottom edge.
        let [right, below] = [seen[0] - x - across, seen[1] - y - down];
        let [x, y] = match orientation {
            Orientation::NoTransforms => [x, y],
            Orientation::Rotate90 => [y, right],
            Orientation::Rotate180 => [right, below],
            Orientation::Rotate270 => [below, x],
            Orientation::FlipHorizontal => [right, y],
            Orientation::FlipVertical => [x, below],
            Orientation::Rotate90FlipH => [y, x],
            Orientation::Rotate270FlipH => [below, right],
        };
        let [width, height] = if swaps_sides(orientation) {
            [down, across]
        } else {
            [across, down]
        };
        Ok(Self {
            x,
            y,
            width,
            height,
        })
    }
}
