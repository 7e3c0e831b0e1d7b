//! Engraving of images.

use magician_host::message;
use magician_host::{Setting, SettingValue};
use magician_motion::ArmModel;

use super::scan::{Scan, ScanSpeeds};
use super::tone::{Powers, levels};
use super::{Grid, Raster, Tone, resample};
use crate::{Artwork, Diagnostic, Origin, Plan, Stroke, Surface, Tool};

/// Options for engraving an image line by line, with laser power following the grey levels.
///
/// The tool crosses the image at constant [`speed`](Self::speed): it accelerates before a line and
/// brakes after it, with the laser off (overscan). The arm plans at most 32 commands ahead, and
/// plans to stop after the last one. Above [`steady_speed`](Self::steady_speed) it may therefore
/// not hold the speed where every pixel differs from the next.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Engrave {
    /// Distance between lines, and resolution of the power along a line, mm.
    pub spacing: f64,
    /// Smallest and largest power, percent: for the lightest grey below white, and for black.
    pub power: [f64; 2],
    /// Conversion of grey levels to power.
    pub tone: Tone,
    /// Exponent applied to the darkness (0 to 1); 1 is linear, above 1 burns light areas less.
    pub gamma: f64,
    /// True to burn white instead of black. Transparent pixels are never burnt.
    pub invert: bool,
    /// True to burn every other line on the way back. False is slower, and free of gear backlash.
    pub both_directions: bool,
    /// Overscan at each end of a line, mm; `None` computes it from speed and acceleration.
    pub overscan: Option<f64>,
    /// Speed along a line, mm/s.
    pub speed: f64,
    /// Acceleration to that speed, mm/s2.
    pub acceleration: f64,
    /// Travel speed over long gaps, mm/s. The arm multiplies it by its speed ratio, which is 50 %
    /// at power-up.
    pub travel: f64,
    /// True to skip white lines and the white ends of lines, and to cross wide gaps at travel
    /// speed.
    pub white_skip: bool,
    /// Height above the surface at start and end, mm.
    pub lift: f64,
}

impl Default for Engrave {
    fn default() -> Self {
        Self {
            spacing: 0.2,
            power: [0.0, 100.0],
            tone: Tone::default(),
            gamma: 1.0,
            invert: false,
            both_directions: true,
            overscan: None,
            speed: 20.0,
            acceleration: 100.0,
            travel: 200.0,
            white_skip: true,
            lift: 10.0,
        }
    }
}

impl Engrave {
    /// Largest number of cells in an image. Bounds memory and the duration of the job.
    pub const MAX_CELLS: usize = 16_000_000;
    /// Bisection steps when an image is scaled down to fit with its overscan.
    const BISECTION_STEPS: usize = 14;
    /// Segments that the arm knows after the current one (model section 14).
    const LOOKAHEAD_SEGMENTS: f64 = 31.0;

    /// Overscan at each end of a line, mm: as set, else the distance needed to reach the speed.
    #[must_use]
    pub fn run_up(&self) -> f64 {
        let needed = self.speed * self.speed / (2.0 * self.acceleration);
        self.overscan.unwrap_or(needed)
    }

    /// Largest speed that the arm holds over an image in which all neighbouring pixels differ, mm/s
    /// (model sections 8 and 14: the arm plans to stop at the end of the last segment it knows, and
    /// a segment takes a whole number of periods).
    ///
    /// The arm crosses each pixel in a whole number of periods. It therefore reduces a speed below
    /// the steady speed to the next lower one at which a pixel takes a whole number of periods.
    #[must_use]
    pub fn steady_speed(&self) -> f64 {
        let known = (2.0 * self.acceleration * Self::LOOKAHEAD_SEGMENTS * self.spacing).sqrt();
        let period = f64::from(ArmModel::MAGICIAN.law.period_us()) / 1e6;
        known.min(self.spacing / period)
    }

    /// Returns the frames of an image of this size (mm): its outline, and the area that the tool
    /// crosses, which is wider by the overscan.
    ///
    /// The frames are placed like a drawing; [`Grid::of_frame`] returns the resulting position of
    /// the image. Their page has the image's size, so that the image, without its overscan, is
    /// aligned with the corners of a sheet.
    ///
    /// The overscan does not shrink with an image that is scaled to fit; [`placed`](Self::placed)
    /// accounts for that.
    #[must_use]
    pub fn frame(&self, size: [f64; 2]) -> Artwork {
        let frame = |beyond: f64| {
            let [left, right] = [-beyond, size[0] + beyond];
            let corners = [[left, size[1]], [right, size[1]], [right, 0.0], [left, 0.0]];
            Stroke::new([&corners[..], &corners[..1]].concat(), Origin::NONE)
        };
        Artwork {
            page: Some(size),
            strokes: vec![frame(0.0), frame(self.run_up())],
            ..Artwork::default()
        }
    }

    /// Places an image of this size (mm). `place` positions its [frame](Self::frame) for the arm,
    /// scaled down if it must fit, and returns the result with its scale (1 is the true size).
    ///
    /// ```
    /// use magician_program::raster::{Engrave, Grid};
    /// use magician_program::{Artwork, Diagnostic};
    ///
    /// // A `place` that limits the width to 30 mm.
    /// let narrow = |frame: &Artwork| {
    ///     let [least, most] = frame.bounds().expect("a frame has lines");
    ///     let scale = (30.0 / (most[0] - least[0])).min(1.0);
    ///     let mut placed = frame.clone();
    ///     for point in placed.strokes.iter_mut().flat_map(|stroke| &mut stroke.points) {
    ///         *point = point.map(|value| value * scale);
    ///     }
    ///     Ok::<_, Diagnostic>((placed, scale))
    /// };
    /// let grid = Engrave::default().placed([52.0, 26.0], narrow)?;
    /// let [width, height] = grid.size();
    /// // 2 mm on either side are overscan.
    /// assert!((width - 26.0).abs() < 0.01 && (height - 13.0).abs() < 0.01);
    /// # Ok::<(), Diagnostic>(())
    /// ```
    ///
    /// # Errors
    /// The error of `place`, or an invalid option.
    pub fn placed(
        &self,
        size: [f64; 2],
        mut place: impl FnMut(&Artwork) -> Result<(Artwork, f64), Diagnostic>,
    ) -> Result<Grid, Diagnostic> {
        self.validate()?;
        // The overscan does not shrink with the image, so the scale that `place` returns does not
        // give the largest size that fits: bisect.
        let mut fits = |share: f64| {
            let (placed, scale) = place(&self.frame(size.map(|side| side * share)))?;
            Ok::<_, Diagnostic>((scale >= 1.0).then_some(placed))
        };
        let mut best = fits(1.0)?;
        let (mut least, mut most) = (0.0, 1.0);
        let tries = if best.is_some() {
            0
        } else {
            Self::BISECTION_STEPS
        };
        for _ in 0..tries {
            let share = f64::midpoint(least, most);
            match fits(share)? {
                Some(placed) => (best, least) = (Some(placed), share),
                None => most = share,
            }
        }
        best.as_ref().and_then(Grid::of_frame).ok_or_else(|| {
            Diagnostic::of_file(message!("not enough room for the run-up to the image"))
                .remedy(
                    (Setting::Speed, SettingValue::Any("MM/S")),
                    "engraves it slower",
                )
                .remedy(
                    (Setting::Overscan, SettingValue::Any("MM")),
                    "sets the run-up",
                )
        })
    }

    fn validate(&self) -> Result<(), Diagnostic> {
        let above = |name: &str, value: f64, unit: &str| {
            if value > 0.0 && value.is_finite() {
                return Ok(());
            }
            let why = message!(
                "{name} is {value} {unit}, it must be above 0",
                name,
                value,
                unit
            );
            Err(Diagnostic::of_file(why))
        };
        above("the line spacing", self.spacing, "mm")?;
        above("the speed", self.speed, "mm/s")?;
        above("the acceleration", self.acceleration, "mm/s2")?;
        above("the speed of travels", self.travel, "mm/s")?;
        above("gamma", self.gamma, "")?;
        for (name, value) in [("the overscan", self.run_up()), ("the lift", self.lift)] {
            if !(value >= 0.0 && value.is_finite()) {
                let why = message!("{name} is {value} mm, it must be 0 or more", name, value);
                return Err(Diagnostic::of_file(why));
            }
        }
        let [least, most] = self.power;
        if !(0.0 <= least && least <= most && 0.0 < most && most <= 100.0) {
            return Err(Diagnostic::of_file(message!(
                "power goes from {least} % to {most} %, it must rise within 0 to 100 %",
                least,
                most
            )));
        }
        Ok(())
    }

    /// Plan that engraves an image at `grid`, on this surface. The origin of a step has the row of
    /// the image as its line, and no column.
    ///
    /// # Errors
    /// Values out of range or NaN, an image of more than [`Self::MAX_CELLS`], and an image without
    /// anything to burn.
    pub fn plan(&self, image: &Raster, grid: &Grid, surface: Surface) -> Result<Plan, Diagnostic> {
        image.validate()?;
        self.validate()?;
        let [columns, rows] = cells(grid, self.spacing)?;
        let mut cells = resample::resample(image, columns, rows);
        let opacity = resample::resample_opacity(image, columns, rows);
        levels(&mut cells, &opacity, columns, self);
        if cells.iter().all(|level| *level == 0) {
            if !opacity.is_empty() && opacity.iter().all(|opacity| *opacity == 0) {
                let message = message!("nothing to burn: all of it is transparent");
                return Err(Diagnostic::of_file(message));
            }
            let inverted = if opacity.is_empty() {
                "burns the white parts"
            } else {
                "burns the white parts, and nothing where it is transparent"
            };
            return Err(
                Diagnostic::of_file(message!("nothing to burn: all of it is white"))
                    .remedy((Setting::Invert, SettingValue::On), inverted)
                    .remedy(
                        (Setting::Threshold, SettingValue::Any("N")),
                        "sets what counts as dark",
                    ),
            );
        }

        let mut plan = Plan::new(&image.title);
        plan.tool = Some(Tool::Laser);
        plan.surface = Some(surface);
        let powers = Powers::new(self);
        let mut scan = Scan::new(plan, *grid, surface, self, ScanSpeeds::new(self));
        for (nth, line) in cells.chunks_exact(columns).enumerate() {
            let row = (2 * nth + 1).saturating_mul(image.height) / (2 * rows);
            scan.add_line(line, (nth as f64 + 0.5) / rows as f64, row, &powers);
        }
        Ok(scan.end())
    }
}

/// Number of columns and rows of cells that are as close to squares of `spacing` as possible.
fn cells(grid: &Grid, spacing: f64) -> Result<[usize; 2], Diagnostic> {
    let corners = grid.corners();
    let finite = corners.as_flattened().iter().all(|value| value.is_finite());
    let [width, height] = super::check_positive(grid.size())?;
    if !finite {
        return Err(Diagnostic::of_file(message!(
            "the position of the image is not a number"
        )));
    }
    let counts = [width, height].map(|side| ((side / spacing).round() as usize).max(1));
    let [columns, rows] = counts;
    let most = Engrave::MAX_CELLS;
    if columns.checked_mul(rows).is_none_or(|count| count > most) {
        return Err(Diagnostic::of_file(message!(
            "{columns} by {rows} cells of {spacing} mm for {width:.1} mm by {height:.1} mm are \
                too many, limit {most}",
            columns,
            rows,
            spacing,
            width,
            height,
            most
        ))
        .remedy(
            (Setting::Width, SettingValue::Any("MM")),
            "makes it smaller",
        )
        .remedy(
            (Setting::Spacing, SettingValue::Any("MM")),
            "increases the distance between its lines",
        ));
    }
    Ok(counts)
}
