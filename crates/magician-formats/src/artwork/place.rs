//! Placing of artwork in front of the arm, and the largest size that fits.
//!
//! [`Placer`] mirrors, rotates and scales the artwork and finds the position of its middle: where
//! the layout says, on the sheet, or wherever there is room within the arm's reach. If the wanted
//! size does not fit, the largest size that fits is found by bisection, and a [`FitFailure`] tells
//! the user which size, place or rotation would fit.

mod misfit;

use magician_host::message;
use serde::{Deserialize, Serialize};

pub use self::misfit::{FitFailure, WouldFit};

use super::{Artwork, FilledArea, Marking, Stroke};
use crate::fill::Area;
use crate::reach::{bisect, hull};
use crate::{Diagnostic, Fit, Reach, SheetTransform, Surface};

/// Share of the size kept free at the edges of fitted artwork, because coordinates are rounded to
/// 32 bits on their way to the arm.
const MARGIN_SHARE: f64 = 1e-4;

/// Tolerance for fitting into a room, mm. It absorbs the rounding of coordinates in files.
const SIZE_TOLERANCE: f64 = 1e-3;

/// Bisection steps when fitting at a given position: they resolve 1/65,536 of the size.
const BISECTION_STEPS: usize = 16;
/// Bisection steps when growing artwork at a position found by [`Reach::best_place`]. Growing
/// starts from a good size, so fewer steps are enough.
const GROWTH_STEPS: usize = 10;

/// A sheet of paper in front of the arm, as measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Position of its lower left corner in the arm's x and y, mm.
    pub corner: [f64; 2],
    /// Direction of its lower edge, degrees from the arm's X towards its Y.
    pub rotation: f64,
    /// Surface.
    pub surface: Surface,
    /// Width and height, mm; `None` if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
}

/// Wanted placing of a drawing. Sheet x runs along the arm's X and sheet y along its Y, unless
/// rotated.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// Sheet that the page lies on, corner on corner. If `None`, the drawing goes wherever there is
    /// room.
    pub sheet: Option<Sheet>,
    /// Surface to draw on, which is the sheet's if there is one.
    pub surface: Surface,
    /// Scale, 1 being the true size.
    pub scale: f64,
    /// Rotation counter-clockwise, degrees.
    pub rotate: f64,
    /// Position for the middle of the strokes, in the arm's x and y, mm, regardless of the page.
    pub at: Option<[f64; 2]>,
    /// True if `at` is the middle of the page instead.
    pub keeps_page: bool,
    /// Width and height, mm, aligned with the sheet, that fitted artwork must not exceed.
    pub room: Option<[f64; 2]>,
    /// True to shrink the drawing until it fits.
    pub fit: bool,
    /// True if the caller rotates the drawing by another 90 degrees where that allows a larger
    /// size. The largest size in messages assumes it, unless a place was given.
    pub turn: bool,
    /// True to mirror left to right, before the rotation.
    pub mirror: bool,
}

impl Layout {
    /// Returns a layout in true size, wherever there is room on a surface.
    #[must_use]
    pub fn on(surface: Surface) -> Self {
        Self {
            sheet: None,
            surface,
            scale: 1.0,
            rotate: 0.0,
            at: None,
            keeps_page: false,
            room: None,
            fit: false,
            turn: false,
            mirror: false,
        }
    }

    /// Returns a layout in true size on a sheet.
    #[must_use]
    pub fn on_sheet(sheet: Sheet) -> Self {
        Self {
            sheet: Some(sheet),
            ..Self::on(sheet.surface)
        }
    }
}

/// A drawing in the arm's coordinates.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PlacedArtwork {
    /// Strokes and areas with x and y of the arm, mm. It no longer has a page.
    pub artwork: Artwork,
    /// Surface that they lie on.
    pub surface: Surface,
    /// Scale, 1 being the true size: the wanted one, or less if the drawing was shrunk to fit.
    pub scale: f64,
    /// Middle of the strokes, mm.
    pub middle: [f64; 2],
}

impl PlacedArtwork {
    /// Wraps artwork that already is in the arm's coordinates.
    #[must_use]
    pub fn at(artwork: Artwork, surface: Surface) -> Self {
        let [least, most] = artwork.bounds().unwrap_or_default();
        Self {
            middle: [0, 1].map(|axis| f64::midpoint(least[axis], most[axis])),
            artwork,
            surface,
            scale: 1.0,
        }
    }
}

impl Artwork {
    /// Places the drawing for an arm that marks it as given. Every point is then within reach.
    ///
    /// # Errors
    /// A [`Diagnostic`] if the drawing is empty, a number of the layout is not finite, or the
    /// drawing does not fit; the last one has its size, the size that would fit, and remedies.
    pub fn placed(&self, layout: &Layout, marking: &Marking) -> Result<PlacedArtwork, Diagnostic> {
        match self.placed_with_misfit(layout, marking)? {
            (placed, None) => Ok(placed),
            (_, Some(misfit)) => Err(misfit.diagnostic),
        }
    }

    /// Returns the largest scale that fits, at most that of the layout. `None` if none fits.
    #[must_use]
    pub fn largest(&self, layout: &Layout, marking: &Marking) -> Option<f64> {
        layout.check().ok()?;
        let reach = marking.reach(layout.surface);
        reach.ahead()?;
        let placer = Placer::new(self, self.bounds()?, layout, &reach);
        placer.largest().map(|(scale, _)| scale)
    }

    /// Places the drawing as [`placed`](Self::placed) does. A drawing that does not fit is placed
    /// anyway, and the reason is returned.
    ///
    /// # Errors
    /// Same as [`placed`](Self::placed), except for artwork that does not fit.
    pub fn placed_with_misfit(
        &self,
        layout: &Layout,
        marking: &Marking,
    ) -> Result<(PlacedArtwork, Option<FitFailure>), Diagnostic> {
        layout.check()?;
        let Some(bounds) = self.bounds() else {
            return Err(Diagnostic::of_file(message!("nothing to draw")));
        };
        let reach = marking.reach(layout.surface);
        let Some([near, far]) = reach.ahead() else {
            let z = layout.surface.height;
            let message = message!(
                "a surface at z = {z:.1} cannot be reached with this tool",
                z
            );
            return Err(Diagnostic::of_file(message));
        };
        let placer = Placer::new(self, bounds, layout, &reach);
        let largest = placer.largest();
        match largest {
            Some((scale, at)) if layout.fit || scale == layout.scale => {
                Ok((placer.placed_at(scale, at), None))
            }
            // Place it anyway, as large as wanted, so that the caller can show what does not fit.
            _ => {
                let middle = [f64::midpoint(near, far), 0.0];
                let at = placer.middle(layout.scale);
                let at = at.or(largest.map(|(_, at)| at)).unwrap_or(middle);
                let most = largest.map(|(scale, _)| placer.scale_in_room(scale));
                let misfit = placer.misfit(most, [near, far]);
                Ok((placer.placed_at(layout.scale, at), Some(misfit)))
            }
        }
    }
}

impl Layout {
    fn check(&self) -> Result<(), Diagnostic> {
        let surface = [&[self.surface.height][..], &self.surface.slope].concat();
        let sheet = self.sheet.map_or(vec![], |sheet| {
            let size = sheet.size.unwrap_or_default();
            [&[sheet.rotation][..], &sheet.corner, &size].concat()
        });
        let at = self.at.unwrap_or_default();
        let room = self.room.unwrap_or_default();
        let numbers = [&surface[..], &sheet, &at, &room, &[self.scale, self.rotate]].concat();
        if numbers.iter().any(|number| !number.is_finite()) {
            let message = message!("a drawing needs finite numbers to be placed");
            return Err(Diagnostic::of_file(message));
        }
        if self.scale <= 0.0 {
            let message = message!(
                "the scale is {scale}, it must be above 0",
                scale = self.scale
            );
            return Err(Diagnostic::of_file(message));
        }
        Ok(())
    }
}

/// A drawing and its layout, prepared for trying sizes and positions.
struct Placer<'a> {
    artwork: &'a Artwork,
    layout: &'a Layout,
    reach: &'a Reach,
    /// Strokes, then the rings of areas, mirrored and rotated in true size, with their middle at
    /// the origin.
    turned: Vec<Vec<[f64; 2]>>,
    /// Corners of their convex hull.
    hull: Vec<[f64; 2]>,
    /// Width and height after the rotation, mm.
    size: [f64; 2],
    /// Vector from the lower left corner of the page to the middle of the strokes, rotated with the
    /// sheet.
    inset: [f64; 2],
    /// Vector from the middle of the page to the middle of the strokes, rotated with the sheet.
    offset: [f64; 2],
    /// Width and height of the page, mm.
    page: [f64; 2],
}

impl<'a> Placer<'a> {
    fn new(
        artwork: &'a Artwork,
        bounds: [[f64; 2]; 2],
        layout: &'a Layout,
        reach: &'a Reach,
    ) -> Self {
        let own = |point: [f64; 2]| {
            let [x, y] = point;
            rotated([if layout.mirror { -x } else { x }, y], layout.rotate)
        };
        let sheet = layout.sheet.map_or(0.0, |sheet| sheet.rotation);
        let edges = artwork.areas.iter().flat_map(|filled| &filled.area.rings);
        let lines = { artwork.strokes.iter() }.map(|stroke| &stroke.points);
        let lines = lines.chain(edges);
        let turned: Vec<Vec<_>> = lines
            .map(|points| points.iter().map(|point| own(*point)).collect())
            .collect();
        let [least, most] = bounds_of(turned.iter().flatten().copied()).unwrap_or(bounds);
        // Without a page, assume one from the origin that contains all strokes.
        let page = match artwork.page {
            Some(page) => [[0.0; 2], page],
            None => [
                bounds[0].map(|low| low.min(0.0)),
                bounds[1].map(|high| high.max(0.0)),
            ],
        };
        let [[left, low], [right, high]] = page;
        let corners = [[left, low], [right, low], [left, high], [right, high]].map(own);
        let [page_least, page_most] = bounds_of(corners.into_iter()).unwrap_or(page);
        let middle = [0, 1].map(|axis| f64::midpoint(least[axis], most[axis]));
        let around = |point: [f64; 2]| [point[0] - middle[0], point[1] - middle[1]];
        let turned: Vec<Vec<_>> = turned
            .into_iter()
            .map(|points| {
                points
                    .into_iter()
                    .map(|at| rotated(around(at), sheet))
                    .collect()
            })
            .collect();
        let hull = hull(&turned.concat());
        Self {
            artwork,
            layout,
            reach,
            turned,
            hull,
            size: [0, 1].map(|axis| most[axis] - least[axis]),
            inset: rotated([0, 1].map(|axis| middle[axis] - page_least[axis]), sheet),
            offset: rotated(
                [0, 1].map(|axis| middle[axis] - f64::midpoint(page_least[axis], page_most[axis])),
                sheet,
            ),
            page: [0, 1].map(|axis| page_most[axis] - page_least[axis]),
        }
    }

    /// Returns the wanted scale, limited by the room if the drawing is to fit.
    fn requested_scale(&self) -> f64 {
        if self.layout.fit {
            self.scale_in_room(self.layout.scale)
        } else {
            self.layout.scale
        }
    }

    /// Returns the largest scale, at most the given one, that stays within the room.
    fn scale_in_room(&self, scale: f64) -> f64 {
        let room = self.layout.room.iter().flatten().zip(self.size);
        room.fold(scale, |scale, (room, side)| {
            if scale * side > *room + SIZE_TOLERANCE {
                room / side
            } else {
                scale
            }
        })
    }

    /// Returns the largest scale that fits, at most the wanted one, and the position of the middle.
    fn largest(&self) -> Option<(f64, [f64; 2])> {
        let wanted = self.requested_scale();
        if (self.layout.at, self.layout.sheet) == (None, None) {
            let corners = self.hull.iter();
            let corners: Vec<_> = corners.map(|corner| corner.map(|at| wanted * at)).collect();
            let SheetTransform { scale, offset } =
                self.reach.best_place(&corners, Fit::Shrink).ok()?;
            // `best_place` keeps every straight way between two points within reach. The strokes
            // alone need less, so the drawing may grow.
            return Some((self.grown_scale(scale * wanted, offset), offset));
        }
        if let Some(at) = self.place(wanted) {
            return Some((wanted, at));
        }
        let fits = |scale| self.place(scale * (1.0 + MARGIN_SHARE)).is_some();
        let scale = bisect(0.0, wanted, BISECTION_STEPS, fits);
        self.middle(scale)
            .filter(|_| scale > 0.0)
            .map(|at| (scale, at))
    }

    /// Returns the largest scale up to the wanted one at which the strokes are within reach at this
    /// position. `fits` is a scale known to fit.
    fn grown_scale(&self, fits: f64, at: [f64; 2]) -> f64 {
        let wanted = self.requested_scale();
        if fits >= wanted || self.is_within(at, wanted) {
            return wanted.max(fits);
        }
        let is_within = |scale| self.is_within(at, scale * (1.0 + MARGIN_SHARE));
        bisect(fits, wanted, GROWTH_STEPS, is_within)
    }

    /// Returns the position of the middle at a scale, if the layout determines it.
    fn middle(&self, scale: f64) -> Option<[f64; 2]> {
        let on_sheet =
            |sheet: Sheet| [0, 1].map(|axis| sheet.corner[axis] + scale * self.inset[axis]);
        let at = self.layout.at.map(|at| {
            if self.layout.keeps_page {
                [0, 1].map(|axis| at[axis] + scale * self.offset[axis])
            } else {
                at
            }
        });
        at.or(self.layout.sheet.map(on_sheet))
    }

    /// Returns that position if the whole drawing is within reach there.
    fn place(&self, scale: f64) -> Option<[f64; 2]> {
        let at = self.middle(scale)?;
        let on_sheet = match (self.layout.at, self.layout.sheet) {
            (None, Some(sheet)) => self.fits_sheet(&sheet, scale),
            _ => true,
        };
        (on_sheet && self.is_within(at, scale)).then_some(at)
    }

    /// True if the whole drawing is within reach at this position and scale.
    fn is_within(&self, at: [f64; 2], scale: f64) -> bool {
        let put = |point: &[f64; 2]| [0, 1].map(|axis| at[axis] + scale * point[axis]);
        // If the hull is within reach, all of the drawing is. This is cheaper than testing every
        // stroke.
        let outside = self.hull.iter().chain(self.hull.first());
        let mut lines = self.turned.iter();
        self.reach.has_line(outside.map(put))
            || lines.all(|line| self.reach.has_line(line.iter().map(put)))
    }

    /// True if the page fits the sheet. One millimetre is tolerated, because sheets are measured by
    /// hand.
    fn fits_sheet(&self, sheet: &Sheet, scale: f64) -> bool {
        let [width, height] = self.page.map(|side| scale * side - 1.0);
        (sheet.size).is_none_or(|size| width <= size[0] && height <= size[1])
    }

    fn placed_at(&self, scale: f64, at: [f64; 2]) -> PlacedArtwork {
        let put = |point: &[f64; 2]| [0, 1].map(|axis| at[axis] + scale * point[axis]);
        let put = |points: &Vec<[f64; 2]>| points.iter().map(put).collect();
        let mut lines = self.turned.iter();
        let strokes = self.artwork.strokes.iter().zip(lines.by_ref());
        let strokes = strokes.map(|(stroke, points)| Stroke {
            points: put(points),
            origin: stroke.origin,
            style: stroke.style,
        });
        let strokes: Vec<_> = strokes.collect();
        let areas = self.artwork.areas.iter().map(|filled| FilledArea {
            area: Area {
                rings: { filled.area.rings.iter().zip(lines.by_ref()) }
                    .map(|(_, points)| put(points))
                    .collect(),
                ..filled.area
            },
            origin: filled.origin,
            style: filled.style,
        });
        PlacedArtwork {
            artwork: Artwork {
                title: self.artwork.title.clone(),
                areas: areas.collect(),
                strokes,
                names: self.artwork.names.clone(),
                colors: self.artwork.colors.clone(),
                parts: self.artwork.parts.clone(),
                in_order: self.artwork.in_order,
                ..Artwork::default()
            },
            surface: self.layout.surface,
            scale,
            middle: at,
        }
    }
}

/// Rounds a coordinate, mm, as in messages, so that the user can type it.
#[must_use]
pub fn rounded(at: f64) -> f64 {
    // Adding 0.0 turns -0.0 into 0.0.
    (at * 10.0).round() / 10.0 + 0.0
}

/// Rotates a point counter-clockwise about the origin.
#[must_use]
pub fn rotated([x, y]: [f64; 2], degrees: f64) -> [f64; 2] {
    // Quarter turns are exact, so that straight lines on a straight sheet stay axis-aligned.
    let (sin, cos) = match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        other => libm::sincos(other.to_radians()),
    };
    [x * cos - y * sin, x * sin + y * cos]
}

fn bounds_of(mut points: impl Iterator<Item = [f64; 2]>) -> Option<[[f64; 2]; 2]> {
    let first = points.next()?;
    Some(points.fold([first, first], |[least, most], [x, y]| {
        [
            [least[0].min(x), least[1].min(y)],
            [most[0].max(x), most[1].max(y)],
        ]
    }))
}
