//! The ground as it is seen from above.

/// Which of the arm's directions are right and up on a page or a screen that shows the ground from above.
///
/// Every view from above goes through one of these, and so do the keys beside it: what is up on the screen is where the
/// key upwards leads.
///
/// ```
/// use magician_motion::TopView;
///
/// assert_eq!(TopView::PAPER.project([200.0, 30.0]), [200.0, 30.0]);
/// // Seen from behind the arm, x is ahead and y on the left.
/// assert_eq!(TopView::BEHIND.project([200.0, 30.0]), [-30.0, 200.0]);
/// assert_eq!(TopView::BEHIND.unproject([0.0, 1.0]), [1.0, 0.0]);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TopView {
    /// Quarter turns of the ground to the left, 0 to 3.
    quarters: u8,
}

impl TopView {
    /// X to the right and Y up, as in a coordinate system on paper: previews, and pictures of what was drawn.
    pub const PAPER: Self = Self { quarters: 0 };
    /// X up and Y to the left, as one sees the arm from behind its base: where keys move it.
    pub const BEHIND: Self = Self { quarters: 1 };

    /// The view after one step to the right around the arm: the ground turns to the right by 90 degrees.
    #[must_use]
    pub const fn turned(self) -> Self {
        Self {
            quarters: (self.quarters + 3) % 4,
        }
    }

    /// What is to the right of the origin, and above it, of a place or a direction x, y.
    #[must_use]
    pub fn project(self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.quarters {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        }
    }

    /// The place or direction x, y of what is so far to the right and up: undoes [`project`](Self::project).
    #[must_use]
    pub fn unproject(self, [right, up]: [f64; 2]) -> [f64; 2] {
        let back = Self {
            quarters: (4 - self.quarters) % 4,
        };
        back.project([right, up])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_lead_where_the_view_shows_it() {
        let mut view = TopView::BEHIND;
        let mut ahead = [[0.0; 2]; 4];
        for up in &mut ahead {
            *up = view.unproject([0.0, 1.0]).map(|part| part + 0.0);
            for arrow in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                assert_eq!(view.project(view.unproject(arrow)), arrow);
            }
            view = view.turned();
        }
        assert_eq!(view, TopView::BEHIND);
        // Behind the arm, then on its right side, before it, on its left side.
        assert_eq!(ahead, [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]);
    }
}
