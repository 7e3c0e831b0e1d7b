//! The ground seen from above.

/// Orientation of a page or a screen that shows the ground from above: the arm's directions that
/// point right and up.
///
/// Every view from above uses one of these, and so do its keys: the key "up" moves the arm up on
/// the screen.
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
    /// X to the right and Y up, as in a coordinate system on paper: previews, and pictures of what
    /// was drawn.
    pub const PAPER: Self = Self { quarters: 0 };
    /// X up and Y to the left, as seen from behind the base: the orientation of jog keys.
    pub const BEHIND: Self = Self { quarters: 1 };

    /// Returns the view after one step to the right around the arm: the ground turns right by 90
    /// degrees.
    #[must_use]
    pub const fn turned(self) -> Self {
        Self {
            quarters: (self.quarters + 3) % 4,
        }
    }

    /// Maps a position or a direction x, y to right and up on the screen.
    #[must_use]
    pub fn project(self, [x, y]: [f64; 2]) -> [f64; 2] {
        match self.quarters {
            0 => [x, y],
            1 => [-y, x],
            2 => [-x, -y],
            _ => [y, -x],
        }
    }

    /// Maps right and up on the screen to x, y: the inverse of [`project`](Self::project).
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
        // Behind the arm, then at its right, in front of it, at its left.
        assert_eq!(ahead, [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]);
    }
}
