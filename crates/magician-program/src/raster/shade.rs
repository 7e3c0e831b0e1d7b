//! Darkness of an image around a place, for strokes that shade it.

use magician_host::{Message, message};
use magician_host::{Setting, SettingValue};

use super::resample::resample;
use super::{Raster, Trace};
use crate::artwork::distance;
use crate::{Diagnostic, Origin, Stroke};

/// Largest side in pixels that is processed.
const MAX_SIDE: usize = 2000;
/// Largest number of pixels across the pen's line: finer ones cannot show.
const MAX_PIXELS_PER_WIDTH: f64 = 4.0;

/// Darkness of an image, 0 to 1, on a page with y down, mm.
pub(super) struct Shade {
    /// Summed-area table of the darkness, 255 for a black pixel.
    sums: Vec<u64>,
    columns: usize,
    rows: usize,
    page: [f64; 2],
    /// Rows of the original image.
    height: usize,
}

impl Shade {
    pub(super) fn new(image: &Raster, page: [f64; 2], pen_width: f64) -> Self {
        let side = |pixels: usize, length: f64| {
            let fine = (length / pen_width * MAX_PIXELS_PER_WIDTH).ceil() as usize;
            pixels.min(fine).clamp(1, MAX_SIDE)
        };
        let (columns, rows) = (side(image.width, page[0]), side(image.height, page[1]));
        let grey = resample(image, columns, rows);
        let stride = columns + 1;
        let mut sums = vec![0; stride * (rows + 1)];
        for (row, pixels) in grey.chunks_exact(columns).enumerate() {
            let mut line = 0;
            for (column, grey) in pixels.iter().enumerate() {
                line += u64::from(255 - grey);
                let at = (row + 1) * stride + column + 1;
                sums[at] = sums[at - stride] + line;
            }
        }
        Self {
            sums,
            columns,
            rows,
            page,
            height: image.height,
        }
    }

    pub(super) fn page(&self) -> [f64; 2] {
        self.page
    }

    /// Mean darkness in a box of this size around a point, counting only the part on the page; 0 if
    /// no part is on it.
    pub(super) fn around(&self, middle: [f64; 2], size: [f64; 2]) -> f64 {
        let counts = [self.columns as f64, self.rows as f64];
        let edges = [0, 1].map(|axis| {
            let pixel = self.page[axis] / counts[axis];
            let edge = |side: f64| {
                let at = (middle[axis] + side * size[axis] / 2.0) / pixel;
                at.clamp(0.0, counts[axis])
            };
            [edge(-1.0), edge(1.0)]
        });
        let [[left, right], [above, below]] = edges;
        let area = (right - left) * (below - above);
        if area <= 1e-12 {
            return 0.0;
        }
        let sum = self.sum(right, below) - self.sum(left, below) - self.sum(right, above)
            + self.sum(left, above);
        (sum / area / 255.0).clamp(0.0, 1.0)
    }

    /// Summed darkness above and to the left of a position in pixels, interpolated within a pixel.
    fn sum(&self, x: f64, y: f64) -> f64 {
        let (column, row) = (
            (x as usize).min(self.columns - 1),
            (y as usize).min(self.rows - 1),
        );
        let at = |column: usize, row: usize| self.sums[row * (self.columns + 1) + column] as f64;
        let (right, down) = (x - column as f64, y - row as f64);
        let above = at(column, row) * (1.0 - right) + at(column + 1, row) * right;
        let below = at(column, row + 1) * (1.0 - right) + at(column + 1, row + 1) * right;
        above * (1.0 - down) + below * down
    }

    /// Stroke of points with y down; its origin is the image row where it begins.
    pub(super) fn stroke(&self, points: &[[f64; 2]]) -> Stroke {
        let [width, height] = self.page;
        let down = points.first().map_or(0.0, |[_, y]| y / height);
        let row = (down * self.height as f64) as u32;
        let on_sheet = |[x, y]: &[f64; 2]| [x.clamp(0.0, width), (height - y).clamp(0.0, height)];
        let mut points: Vec<[f64; 2]> = points.iter().map(on_sheet).collect();
        points.dedup();
        Stroke {
            points,
            origin: Origin {
                line: row.saturating_add(1).min(self.height as u32),
                ..Origin::NONE
            },
            style: crate::artwork::Style::default(),
        }
    }
}

/// Stretch of a straight line, between two distances along it, mm.
pub(super) fn stretch([from, to]: [[f64; 2]; 2], ends: [f64; 2]) -> [[f64; 2]; 2] {
    let length = distance(from, to).max(1e-9);
    ends.map(|along| [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * along / length))
}

/// Largest number of strokes of an image: more than a day of work.
const MAX_STROKES: f64 = 200_000.0;
/// Largest total length, mm: more than a day of work.
const MAX_LENGTH: f64 = 5e6;

/// Refuses more strokes or length than an arm can draw.
pub(super) fn check_bounds(what: Message, count: f64, length: f64) -> Result<(), Diagnostic> {
    if count <= MAX_STROKES && length <= MAX_LENGTH {
        return Ok(());
    }
    let message = message!(
        "too many {what} for an image of this size: {count:.0}, {length:.0} m",
        what,
        count,
        length = length / 1000.0
    );
    Err(Diagnostic::of_file(message)
        .remedy(
            (Setting::Width, SettingValue::Any("MM")),
            "makes it smaller",
        )
        .remedy(
            (Setting::Spacing, SettingValue::Any("MM")),
            "increases the distance between its lines",
        ))
}

/// Error for an image that leaves nothing to draw.
pub(super) fn nothing_to_draw(trace: &Trace, specks: usize) -> Diagnostic {
    if specks > 0 {
        let message = message!(
            "nothing to draw: all {specks} spots in the image are smaller than {despeckle} mm",
            specks,
            despeckle = trace.despeckle
        );
        return Diagnostic::of_file(message).remedy(
            (Setting::Despeckle, SettingValue::Number(0.0)),
            "draws them all",
        );
    }
    if trace.style.is_shaded() {
        let message = message!("nothing to draw: the image is too light");
        return Diagnostic::of_file(message)
            .remedy((Setting::Invert, SettingValue::On), "draws the white parts");
    }
    let why = message!(
        "nothing to draw: nothing in the image is darker than {level}",
        level = trace.level
    );
    Diagnostic::of_file(why).remedy(
        (Setting::Threshold, SettingValue::Any("N")),
        "traces more if it is higher",
    )
}
