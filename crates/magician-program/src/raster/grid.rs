//! Where an image lies before the arm.

use crate::Artwork;

/// Where an image lies: the arm's coordinates of three of its corners, mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Its upper left corner.
    pub origin: [f64; 2],
    /// From there to the upper right corner.
    pub across: [f64; 2],
    /// From there to the lower left corner.
    pub down: [f64; 2],
}

impl Grid {
    /// An image of this size (mm) with its centre here, turned counter-clockwise by so many degrees, and mirrored left to right
    /// if wanted. Not turned, its right is the arm's +X and its top the arm's +Y.
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

    /// Where the image lies whose [frame](super::Engrave::frame) has been placed like this; nothing if it is no frame.
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

    /// The point at these shares of the width and the height, each 0 to 1 within the image.
    #[must_use]
    pub fn at(&self, [right, down]: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| self.origin[axis] + self.across[axis] * right + self.down[axis] * down)
    }

    /// Its width and height, mm.
    #[must_use]
    pub fn size(&self) -> [f64; 2] {
        [self.across, self.down].map(|[x, y]| libm::hypot(x, y))
    }

    /// Its corners, clockwise from the upper left one as the image has them.
    #[must_use]
    pub fn corners(&self) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|corner| self.at(corner))
    }
}
