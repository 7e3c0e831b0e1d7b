//! Rasterised lines.

/// Largest number of pixels of a picture. It bounds memory.
const MAX_PIXELS: f64 = 16e6;
/// Step along a line, pixels. Small enough that no pixel on the line is skipped.
const LINE_STEP: f64 = 0.25;
/// Largest side of a picture, mm. Points farther off are ignored.
const MAX_SIDE: f64 = 5000.0;

/// Part of a plane shown by a picture, and its resolution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    low: [f64; 2],
    size: [usize; 2],
    pixels_per_mm: f64,
}

impl PixelGrid {
    /// Creates the frame around these points with a margin, mm, at a resolution in pixels per mm.
    /// The resolution is reduced to keep within 16 million pixels. NaN and infinite points are
    /// ignored.
    #[must_use]
    pub fn around(
        points: impl IntoIterator<Item = [f64; 2]>,
        margin: f64,
        pixels_per_mm: f64,
    ) -> Self {
        let near = |point: &[f64; 2]| point.iter().all(|value| value.abs() < MAX_SIDE / 2.0);
        let mut points = points.into_iter().filter(near);
        let first = points.next().unwrap_or_default();
        let [low, high] = points.fold([first, first], |[low, high], [x, y]| {
            [
                [low[0].min(x), low[1].min(y)],
                [high[0].max(x), high[1].max(y)],
            ]
        });
        let low = low.map(|value| value - margin);
        let size = [0, 1].map(|axis| high[axis] + margin - low[axis]);
        let most = (MAX_PIXELS / (size[0] * size[1]).max(1.0)).sqrt();
        let pixels_per_mm = pixels_per_mm.min(most);
        // A cast from float saturates.
        let size = size.map(|side| (side * pixels_per_mm).ceil().max(1.0) as usize);
        Self {
            low,
            size,
            pixels_per_mm,
        }
    }

    /// Resolution, pixels per mm.
    #[must_use]
    pub fn pixels_per_mm(&self) -> f64 {
        self.pixels_per_mm
    }

    /// Width and height, pixels.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Returns the pixel of a point, with fractions.
    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (point[axis] - self.low[axis]) * self.pixels_per_mm)
    }
}

/// Pixels that lines run through.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    frame: PixelGrid,
    /// Rows from the bottom.
    inked: Vec<bool>,
}

impl Picture {
    /// Rasterises polylines; a single point is a dot. Parts outside the frame are ignored.
    #[must_use]
    pub fn of_lines<'a, L>(frame: PixelGrid, lines: impl IntoIterator<Item = &'a L>) -> Self
    where
        L: AsRef<[[f64; 2]]> + ?Sized + 'a,
    {
        let [width, height] = frame.size;
        let mut picture = Self {
            frame,
            inked: vec![false; width.saturating_mul(height)],
        };
        for line in lines {
            let places = line.as_ref().iter().map(|point| frame.place(*point));
            let mut last = None;
            for place in places {
                picture.line(last.unwrap_or(place), place);
                last = Some(place);
            }
        }
        picture
    }

    /// Rasterises the lines of an SVG.
    ///
    /// It is parsed without the reader that makes plans, as an independent check. `place` maps
    /// points of its sheet (mm, x to the right, y up, from the lower left corner) to coordinates of
    /// the frame.
    ///
    /// # Errors
    /// Same as [`svg_lines`](super::svg_lines).
    pub fn of_svg(
        frame: PixelGrid,
        svg: &[u8],
        place: impl Fn([f64; 2]) -> [f64; 2],
    ) -> Result<Self, magician_program::Diagnostic> {
        let mut lines = super::svg_lines(svg)?;
        for point in lines.iter_mut().flatten() {
            *point = place(*point);
        }
        Ok(Self::of_lines(frame, &lines))
    }

    /// Returns its frame.
    #[must_use]
    pub fn frame(&self) -> PixelGrid {
        self.frame
    }

    pub(super) fn inked(&self) -> &[bool] {
        &self.inked
    }

    fn line(&mut self, from: [f64; 2], to: [f64; 2]) {
        let way = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(way[0], way[1]);
        // NaN fails this comparison, too.
        let near = length < MAX_SIDE * self.frame.pixels_per_mm;
        if !near {
            return;
        }
        let steps = (length / LINE_STEP).ceil().max(1.0);
        for nth in 0..=steps as u64 {
            let share = nth as f64 / steps;
            self.ink([from[0] + share * way[0], from[1] + share * way[1]]);
        }
    }

    fn ink(&mut self, [x, y]: [f64; 2]) {
        let [width, height] = self.frame.size;
        if x < 0.0 || y < 0.0 {
            return;
        }
        let (column, row) = (x as usize, y as usize);
        if column < width
            && row < height
            && let Some(pixel) = self.inked.get_mut(row * width + column)
        {
            *pixel = true;
        }
    }
}
