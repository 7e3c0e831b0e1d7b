//! How an image is engraved.

use magician_host::message;
use magician_host::{Given, Setting};
use magician_motion::ArmModel;

use super::scan::{Scan, ScanSpeeds};
use super::tone::{Powers, levels};
use super::{Grid, Raster, Tone, resample};
use crate::{Artwork, Diagnostic, Origin, Plan, Stroke, Surface, Tool};

/// How an image is engraved: line by line, the laser's power following the grey.
///
/// The tool passes the whole image at [`speed`](Self::speed): it runs up to it before a line and slows down behind it, dark. The
/// arm knows 32 commands ahead and slows down so that it could stop behind the last of them: faster than
/// [`steady_speed`](Self::steady_speed) it may not hold the speed where every pixel differs from the next.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Engrave {
    /// From one line to the next, and how finely power changes along a line, mm.
    pub spacing: f64,
    /// Least and most power, percent: for the lightest grey that is not white, and for black.
    pub power: [f64; 2],
    /// How grey levels become power.
    pub tone: Tone,
    /// Exponent of the darkness (0 to 1) before it becomes power; above 1 spares the light parts, 1 is linear.
    pub gamma: f64,
    /// White burns and black does not. What is transparent never does.
    pub invert: bool,
    /// Every other line is burnt on the way back. Without it all go the same way: slower, and free of play in the gears.
    pub both_directions: bool,
    /// Run-up and run-out of the tool at the ends of a line, mm; what speed and acceleration need if left open.
    pub overscan: Option<f64>,
    /// Along a line, mm/s.
    pub speed: f64,
    /// To get to that speed, mm/s2.
    pub acceleration: f64,
    /// Where nothing is burnt for long, mm/s; the arm takes its speed ratio of it, half at power-up.
    pub travel: f64,
    /// Leaves out white lines and the white ends of others, and goes over wide gaps as fast as the arm travels.
    pub white_skip: bool,
    /// How far above the surface it begins and ends, mm.
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
    /// As many cells, at most, are engraved.
    pub const MOST_CELLS: usize = 16_000_000;
    /// As often an image is made smaller until it fits with its run up.
    const MOST_TRIES: usize = 14;
    /// Segments that the arm knows behind the one under way (model section 14).
    const AHEAD: f64 = 31.0;

    /// How far the tool runs up and out, mm.
    #[must_use]
    pub fn run_up(&self) -> f64 {
        let needed = self.speed * self.speed / (2.0 * self.acceleration);
        self.overscan.unwrap_or(needed)
    }

    /// Up to which speed the arm holds it over an image of which no two neighbouring pixels are the same, mm/s (model sections 8
    /// and 14: the end of the last segment that it knows is at rest, and a segment takes a whole number of periods). Below it,
    /// a speed at which a pixel takes no whole number of periods is slowed down to the next one at which it does.
    #[must_use]
    pub fn steady_speed(&self) -> f64 {
        let known = (2.0 * self.acceleration * Self::AHEAD * self.spacing).sqrt();
        let period = f64::from(ArmModel::MAGICIAN.law.period_us()) / 1e6;
        known.min(self.spacing / period)
    }

    /// What an image of this size (mm) needs: its frame, and the frame that the tool passes, which is wider by what it runs up
    /// and out. To be placed as any drawing is; [`Grid::of_frame`] tells where the image then lies. A page of the image's size
    /// makes it lie on a sheet corner on corner.
    ///
    /// The way to run up does not shrink with an image that is made to fit: [`placed`](Self::placed) sees to that.
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

    /// Where an image of this size (mm) comes to lie. `place` lays its [frame](Self::frame) before the arm, in true size or smaller
    /// if it is to fit, and tells where it lies then and how large it is, 1 being the true size.
    ///
    /// ```
    /// use magician_program::raster::{Engrave, Grid};
    /// use magician_program::{Artwork, Diagnostic};
    ///
    /// // Wherever it lies: no more than 30 mm wide.
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
    /// // 2 mm of it on either side are for the run up.
    /// assert!((width - 26.0).abs() < 0.01 && (height - 13.0).abs() < 0.01);
    /// # Ok::<(), Diagnostic>(())
    /// ```
    ///
    /// # Errors
    /// What `place` refuses, and options that make no sense.
    pub fn placed(
        &self,
        size: [f64; 2],
        mut place: impl FnMut(&Artwork) -> Result<(Artwork, f64), Diagnostic>,
    ) -> Result<Grid, Diagnostic> {
        self.validate()?;
        // The way to run up does not become shorter, and so the size that fits does not follow from how much smaller one that is
        // too large must become.
        let mut fits = |share: f64| {
            let (placed, scale) = place(&self.frame(size.map(|side| side * share)))?;
            Ok::<_, Diagnostic>((scale >= 1.0).then_some(placed))
        };
        let mut best = fits(1.0)?;
        let (mut least, mut most) = (0.0, 1.0);
        let tries = if best.is_some() { 0 } else { Self::MOST_TRIES };
        for _ in 0..tries {
            let share = f64::midpoint(least, most);
            match fits(share)? {
                Some(placed) => (best, least) = (Some(placed), share),
                None => most = share,
            }
        }
        best.as_ref().and_then(Grid::of_frame).ok_or_else(|| {
            Diagnostic::of_file(message!("not enough room for the run-up to the image"))
                .remedy((Setting::Speed, Given::Any("MM/S")), "engraves it slower")
                .remedy((Setting::Overscan, Given::Any("MM")), "sets the run-up")
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

    /// Plan that engraves an image where `grid` says, on this surface. Steps say which row of the image they are of:
    /// their origin's line, with no column.
    ///
    /// # Errors
    /// Numbers that are none or out of their range, an image of more than [`Self::MOST_CELLS`], and one of which nothing
    /// would be burnt.
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
                    .remedy((Setting::Invert, Given::On), inverted)
                    .remedy(
                        (Setting::Threshold, Given::Any("N")),
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
            scan.line(line, (nth as f64 + 0.5) / rows as f64, row, &powers);
        }
        Ok(scan.end())
    }
}

/// Columns and rows of cells that are as near to squares of this side as fits.
fn cells(grid: &Grid, spacing: f64) -> Result<[usize; 2], Diagnostic> {
    let corners = grid.corners();
    let finite = corners.as_flattened().iter().all(|value| value.is_finite());
    let [width, height] = super::positive(grid.size())?;
    if !finite {
        return Err(Diagnostic::of_file(message!(
            "the position of the image is not a number"
        )));
    }
    let counts = [width, height].map(|side| ((side / spacing).round() as usize).max(1));
    let [columns, rows] = counts;
    let most = Engrave::MOST_CELLS;
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
        .remedy((Setting::Width, Given::Any("MM")), "makes it smaller")
        .remedy(
            (Setting::Spacing, Given::Any("MM")),
            "increases the distance between its lines",
        ));
    }
    Ok(counts)
}
