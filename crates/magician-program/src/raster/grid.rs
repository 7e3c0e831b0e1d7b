//! Position of an image in arm coordinates.

use crate::Artwork;

/// Position of an image, by three of its corners in arm coordinates, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Upper left corner.
    pub origin: [f64; 2],
    /// Vector from there to the upper right corner.
    pub across: [f64; 2],
    /// Vector from there to the lower left corner.
    pub down: [f64; 2],
}

impl Grid {
    /// Position of an image of this size (mm) around `centre`, turned counter-clockwise by `turn`
    /// degrees and mirrored left to right if wanted. Unturned, its right is the arm's +X and its
    /// top the arm's +Y.
    #[must_use]
    pub fn centred(size: [f64; 2], centre: [f64; 2], turn: f64, mirror: bool) -> Self {
        let (sin, cos) = libm::sincos(turn.to_radians());
        let [width, height] = [if mirror { -size[0] } else { size[0] }, size[1]];
        let across = [width * cos, width * sin];
        let down = [height * sin, -height * cos];
        let origin = [0, 1].map(|axis| centre[axis] - (across[axis] + down[axis]) / 2.0);
        Self {
            origin,
            across,
            down,
        }
    }

    /// Position of the image whose [frame](super::Engrave::frame) was placed like this; `None` if
    /// it is not a frame.
    #[must_use]
    pub fn of_frame(placed: &Artwork) -> Option<Self> {
        let frame = placed.strokes.first()?;
        let [origin, right, _, left, ..] = *frame.points.as_slice() else {
            return None;
        };
        let from_origin = |to: [f64; 2]| [to[0] - origin[0], to[1] - origin[1]];
        Some(Self {
            origin,
            across: from_origin(right),
            down: from_origin(left),
        })
    }

    /// Point at these shares of width and height, each 0 to 1 within the image.
    #[must_use]
    pub fn at(&self, [right, down]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.origin[axis] + self.across[axis] * right + self.down[axis] * down)
    }

    /// Width and height, mm.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        [self.across, self.down].map(|[x, y]| libm::hypot(x, y))
    }

    /// Corners, clockwise from the upper left one of the image.
    #[must_use]
    pub fn corners(&self) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|corner| self.at(corner))
    }
}
