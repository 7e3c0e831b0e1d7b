//! Thinning of dark areas to lines one pixel wide.

use super::Raster;

/// Dark pixels, with a white border.
pub(super) struct Mask {
    pub(super) dark: Vec<bool>,
    /// Pixels in a row, border included.
    pub(super) stride: usize,
}

impl Mask {
    pub(super) fn new(image: &Raster, level: u8) -> Self {
        let stride = image.width + 2;
        let mut dark = vec![false; stride * (image.height + 2)];
        for (row, pixels) in image.grey.chunks_exact(image.width).enumerate() {
            for (column, grey) in pixels.iter().enumerate() {
                dark[(row + 1) * stride + column + 1] = *grey < level;
            }
        }
        Self { dark, stride }
    }

    /// Neighbours of a pixel, clockwise from the top.
    pub(super) fn neighbours(&self, at: usize) -> [usize; 8] {
        let (above, below) = (at - self.stride, at + self.stride);
        [
            above,
            above + 1,
            at + 1,
            below + 1,
            below,
            below - 1,
            at - 1,
            above - 1,
        ]
    }

    fn dark_neighbours(&self, at: usize) -> [bool; 8] {
        self.neighbours(at).map(|near| self.dark[near])
    }

    /// Distance of each pixel from white, in pixels (chamfer distance 3-4).
    pub(super) fn thickness(&self) -> Vec<u16> {
        const STRAIGHT: u16 = 3;
        const DIAGONAL: u16 = 4;
        let mut far: Vec<u16> = { self.dark.iter() }
            .map(|dark| if *dark { u16::MAX } else { 0 })
            .collect();
        let stride = self.stride;
        for at in stride + 1..far.len().saturating_sub(stride + 1) {
            if far[at] > 0 {
                let near = [
                    (at - 1, STRAIGHT),
                    (at - stride, STRAIGHT),
                    (at - stride - 1, DIAGONAL),
                    (at - stride + 1, DIAGONAL),
                ];
                let nearest = near.map(|(near, way)| far[near].saturating_add(way));
                far[at] = nearest.into_iter().fold(far[at], u16::min);
            }
        }
        for at in (stride + 1..far.len().saturating_sub(stride + 1)).rev() {
            if far[at] > 0 {
                let near = [
                    (at + 1, STRAIGHT),
                    (at + stride, STRAIGHT),
                    (at + stride + 1, DIAGONAL),
                    (at + stride - 1, DIAGONAL),
                ];
                let nearest = near.map(|(near, way)| far[near].saturating_add(way));
                far[at] = nearest.into_iter().fold(far[at], u16::min);
            }
        }
        far.iter_mut().for_each(|far| *far /= STRAIGHT);
        far
    }

    /// Thins the mask after Zhang and Suen (1984), with the change by Lü and Wang (1986) that keeps
    /// diagonals: the outermost pixels are removed from two sides in turn until only lines are
    /// left.
    pub(super) fn thinned(mut self) -> Self {
        let dark = |at: &usize| self.dark[*at];
        let mut edge: Vec<usize> = (0..self.dark.len())
            .filter(dark)
            .filter(|at| self.dark_neighbours(*at).contains(&false))
            .collect();
        // A work list of border pixels: scanning the whole mask each round would be quadratic.
        let mut queued = vec![false; self.dark.len()];
        while !edge.is_empty() {
            let mut next = Vec::new();
            for side in [0, 1] {
                let off: Vec<usize> = { edge.iter().copied() }
                    .filter(|at| self.dark[*at] && is_outermost(self.dark_neighbours(*at), side))
                    .filter(|at| !self.begins_block(*at))
                    .collect();
                off.iter().for_each(|at| self.dark[*at] = false);
                // Only neighbours of removed pixels can become removable.
                for near in off.iter().flat_map(|at| self.neighbours(*at)) {
                    if self.dark[near] && !queued[near] {
                        queued[near] = true;
                        next.push(near);
                    }
                }
            }
            next.iter().for_each(|at| queued[*at] = false);
            next.retain(|at| self.dark[*at]);
            edge = next;
        }
        self.remove_steps();
        self
    }

    /// True if a pixel is the upper left one of an isolated 2 by 2 block: all four would be removed
    /// at once.
    fn begins_block(&self, at: usize) -> bool {
        const RIGHT_AND_DOWN: [bool; 8] = [false, false, true, true, true, false, false, false];
        let count = |at: usize| {
            self.dark_neighbours(at)
                .iter()
                .filter(|dark| **dark)
                .count()
        };
        let others = [at + 1, at + self.stride, at + self.stride + 1];
        self.dark_neighbours(at) == RIGHT_AND_DOWN && others.iter().all(|at| count(*at) == 3)
    }

    /// Removes corner pixels of steps, without which a line is still connected.
    fn remove_steps(&mut self) {
        for at in 0..self.dark.len() {
            if !self.dark[at] {
                continue;
            }
            let shown = self.dark_neighbours(at);
            let corner = (0..4).any(|quarter| shown[2 * quarter] && shown[(2 * quarter + 2) % 8]);
            if corner && groups(shown) == 1 {
                self.dark[at] = false;
            }
        }
    }
}

/// Number of changes from white to dark around a pixel.
fn changes(shown: [bool; 8]) -> usize {
    (0..8)
        .filter(|nth| !shown[*nth] && shown[(nth + 1) % 8])
        .count()
}

/// Number of connected groups among a pixel's dark neighbours; side neighbours connect corner
/// neighbours.
fn groups(mut shown: [bool; 8]) -> usize {
    // Two sides next to a corner are connected through it.
    for corner in [1, 3, 5, 7] {
        shown[corner] |= shown[corner - 1] && shown[(corner + 1) % 8];
    }
    match shown {
        [true, true, true, true, true, true, true, true] => 1,
        shown => changes(shown),
    }
}

fn is_outermost(shown: [bool; 8], side: usize) -> bool {
    let count = shown.iter().filter(|dark| **dark).count();
    let [up, _, right, _, down, _, left, _] = shown;
    let open = match side {
        0 => !(right && down && (up || left)),
        _ => !(up && left && (right || down)),
    };
    (3..=6).contains(&count) && changes(shown) == 1 && open
}
