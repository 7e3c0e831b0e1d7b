//! Lines as pixels.

/// As many pixels has a picture.
const MOST_PIXELS: f64 = 16e6;
/// A line is followed in steps of this share of a pixel.
const STEP: f64 = 0.25;
/// A side is never longer, mm: what is farther off is left out.
const LONGEST: f64 = 5000.0;

/// Which part of a plane a picture shows, and how finely.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelGrid {
    low: [f64; 2],
    size: [usize; 2],
    pixels_per_mm: f64,
}

impl PixelGrid {
    /// The frame that shows all of these points with a margin, mm, at so many pixels to the millimetre; fewer if it would
    /// have more than 16 million. Points that are no numbers are left out.
    #[must_use]
    pub fn around(
        points: impl IntoIterator<Item = [f64; 2]>,
        margin: f64,
        pixels_per_mm: f64,
    ) -> Self {
        let near = |point: &[f64; 2]| point.iter().all(|value| value.abs() < LONGEST / 2.0);
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
        let most = (MOST_PIXELS / (size[0] * size[1]).max(1.0)).sqrt();
        let pixels_per_mm = pixels_per_mm.min(most);
        // A conversion of a float saturates.
        let size = size.map(|side| (side * pixels_per_mm).ceil().max(1.0) as usize);
        Self {
            low,
            size,
            pixels_per_mm,
        }
    }

    /// How many pixels there are to the millimetre.
    #[must_use]
    pub fn pixels_per_mm(&self) -> f64 {
        self.pixels_per_mm
    }

    /// How many pixels there are across and down.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// In which pixel a point is, with fractions.
    fn place(&self, point: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| (point[axis] - self.low[axis]) * self.pixels_per_mm)
    }
}

/// Lines as pixels: those that the lines run through.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    frame: PixelGrid,
    /// Row by row, the lowest first.
    inked: Vec<bool>,
}

impl Picture {
    /// Of lines, each by its corners; one of a single corner is a dot. What is outside the frame is left out.
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

    /// Of the lines of an SVG, parsed and followed without the reader that makes plans of it. `place` tells where a point of
    /// its sheet (mm, x to the right, y up, from the lower left corner) lies.
    ///
    /// # Errors
    /// As [`svg_lines`](super::svg_lines).
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

    /// What it shows, and how finely.
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
        // Not a number is not below anything.
        let near = length < LONGEST * self.frame.pixels_per_mm;
        if !near {
            return;
        }
        let steps = (length / STEP).ceil().max(1.0);
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
