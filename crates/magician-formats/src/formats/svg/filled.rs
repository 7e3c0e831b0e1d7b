//! Filled areas of a drawing, as visible from above.

use crate::Origin;
use crate::artwork::{FilledArea, Style};
use crate::fill::Region as Shapes;

/// Visible filled areas.
#[derive(Default)]
pub(super) struct Areas(Vec<FilledShapes>);

struct FilledShapes {
    shapes: Shapes,
    origin: Origin,
    style: Style,
    /// Bounding box: smallest and largest corner.
    bounds: [[f64; 2]; 2],
}

impl Areas {
    pub(super) fn paint(&mut self, shapes: Shapes, origin: Origin, style: Style) {
        if let Some(bounds) = shapes.bounds() {
            self.0.push(FilledShapes {
                shapes,
                origin,
                style,
                bounds,
            });
        }
    }

    /// Removes what is hidden by these shapes.
    pub(super) fn hide(&mut self, hidden: &Shapes) {
        let Some([least, most]) = hidden.bounds() else {
            return;
        };
        for below in &mut self.0 {
            let [from, to] = below.bounds;
            if [0, 1]
                .iter()
                .all(|&side| from[side] < most[side] && least[side] < to[side])
            {
                below.shapes = below.shapes.except(hidden);
            }
        }
        self.0.retain(|area| !area.shapes.is_empty());
    }

    pub(super) fn into_filled(self) -> Vec<FilledArea> {
        let filled = self.0.into_iter().map(|area| FilledArea {
            area: area.shapes.area(),
            origin: area.origin,
            style: area.style,
        });
        filled.collect()
    }
}
