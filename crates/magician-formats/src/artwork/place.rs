//! How a drawing lies before the arm.

use magician_host::message;
use magician_host::{Act, Given, Setting};
use serde::{Deserialize, Serialize};

use super::{Artwork, FilledArea, Marking, Stroke};
use crate::fill::Area;
use crate::reach::{bisect, hull};
use crate::{Diagnostic, Fit, Origin, Reach, SheetTransform, Surface};

/// Room kept free at the edges by what is made to fit, as a share of its size: coordinates are rounded to 32 bits on their way to
/// the arm.
const MARGIN: f64 = 1e-4;

/// What is larger than its room by no more than this has it: coordinates in files are rounded, mm.
const ROUNDING: f64 = 1e-3;

/// So often the room for the largest size is halved where the place was said, and where one was found that has room for all ways.
const HALVINGS: usize = 16;
const GROWING: usize = 10;

/// A sheet of paper before the arm, as it was measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Where its lower left corner lies, in the arm's x and y, mm.
    pub corner: [f64; 2],
    /// How its lower edge runs, degrees from the arm's X towards its Y.
    pub rotation: f64,
    /// Its surface.
    pub surface: Surface,
    /// Its width and height, where they are known, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size: Option<[f64; 2]>,
}

/// How a drawing is to lie before the arm. Sheet x runs along the arm's X and sheet y along its Y, unless it is rotated.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The sheet that its page lies on, corner on corner. Without one it lies wherever there is room for it.
    pub sheet: Option<Sheet>,
    /// The surface, that of the sheet or any other.
    pub surface: Surface,
    /// Its size, 1 being the true one.
    pub scale: f64,
    /// Degrees by which it is turned to the left.
    pub rotate: f64,
    /// Where the middle of its lines goes, in the arm's x and y, mm; wherever its page would then lie.
    pub at: Option<[f64; 2]>,
    /// True if the middle of its page goes there instead.
    pub keeps_page: bool,
    /// The width and height, mm, turned with the sheet, that it keeps within if it is made to fit.
    pub room: Option<[f64; 2]>,
    /// Whether it is made smaller until it fits.
    pub fit: bool,
    /// True if the caller turns it by another 90 degrees where it is larger so: what is said of its largest size counts on
    /// that, unless a place was given.
    pub turn: bool,
    /// Whether it is mirrored, left to right, before it is turned.
    pub mirror: bool,
}

impl Layout {
    /// In true size, wherever there is room for it on a surface.
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

    /// In true size on a sheet.
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
    /// Its lines, x and y as the arm has them, mm. It has no page any more.
    pub artwork: Artwork,
    /// The surface that they lie on.
    pub surface: Surface,
    /// Its size, 1 being the true one: what was asked for, or less if it was made to fit.
    pub scale: f64,
    /// The middle of its lines, mm.
    pub middle: [f64; 2],
}

impl PlacedArtwork {
    /// Artwork whose lines are in the coordinates of the arm already.
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
    /// Lays the drawing before an arm that marks it in this way; every point of it can be reached then.
    ///
    /// # Errors
    /// A [`Diagnostic`] if there is nothing in it, a number of the layout is not finite, or it does not fit: with its size, the size
    /// that would fit, and what to do.
    pub fn placed(&self, layout: &Layout, marking: &Marking) -> Result<PlacedArtwork, Diagnostic> {
        match self.laid(layout, marking)? {
            (placed, None) => Ok(placed),
            (_, Some(misfit)) => Err(misfit.diagnostic),
        }
    }

    /// Largest scale that fits, at most that of the layout. `None` if none does.
    #[must_use]
    pub fn largest(&self, layout: &Layout, marking: &Marking) -> Option<f64> {
        layout.check().ok()?;
        let reach = marking.reach(layout.surface);
        reach.ahead()?;
        let placer = Placer::new(self, self.bounds()?, layout, &reach);
        placer.largest().map(|(scale, _)| scale)
    }

    /// Lays it as [`placed`](Self::placed) does. What does not fit is laid where it would go, with the
    /// reason.
    ///
    /// # Errors
    /// Those of [`placed`](Self::placed), but for artwork that does not fit.
    pub fn laid(
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
                Ok((placer.put(scale, at), None))
            }
            _ => {
                let middle = [f64::midpoint(near, far), 0.0];
                let at = placer.middle(layout.scale);
                let at = at.or(largest.map(|(_, at)| at)).unwrap_or(middle);
                let most = largest.map(|(scale, _)| placer.in_room(scale));
                let misfit = placer.misfit(most, [near, far]);
                Ok((placer.put(layout.scale, at), Some(misfit)))
            }
        }
    }
}

/// Why something does not fit where it is to lie.
#[derive(Clone, Debug)]
pub struct FitFailure {
    /// What is told of it.
    pub diagnostic: Diagnostic,
    /// In which size and turn it would fit.
    pub would_fit: Option<WouldFit>,
}

/// The size and the turn in which something would fit where it lies: the largest there is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WouldFit {
    /// Its size, 1 being the true one.
    pub scale: f64,
    /// By how many degrees it is turned counter-clockwise.
    pub rotate: f64,
}

impl FitFailure {
    /// Multiplies the scales that are told.
    #[must_use]
    pub fn scaled(mut self, by: f64) -> Self {
        let times = |scale: f64| WouldFit::new(scale * by, 0.0).scale;
        for remedy in &mut self.diagnostic.remedies {
            if let Act::Give(Setting::Scale, Given::Number(scale)) = &mut remedy.act {
                *scale = times(*scale);
            }
        }
        if let Some(would_fit) = &mut self.would_fit {
            would_fit.scale = times(would_fit.scale);
        }
        self
    }
}

impl WouldFit {
    /// Rounds the scale down to a thousandth, so that it fits and can be given again.
    #[must_use]
    pub fn new(scale: f64, rotate: f64) -> Self {
        // As it can be said again, and not above what fits.
        let scale = (scale * 1000.0).floor() / 1000.0;
        Self { scale, rotate }
    }

    /// True if there is a size in which it would fit.
    #[must_use]
    pub fn is_any(&self) -> bool {
        self.scale > 0.0
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

/// One drawing, and how it is to lie.
struct Placer<'a> {
    artwork: &'a Artwork,
    layout: &'a Layout,
    reach: &'a Reach,
    /// Its lines, then the edges of its areas, mirrored and turned in true size, their middle at the origin.
    turned: Vec<Vec<[f64; 2]>>,
    /// The corners of their outside.
    hull: Vec<[f64; 2]>,
    /// Its width and height, turned.
    size: [f64; 2],
    /// From the lower left corner of its page to the middle of its lines, turned with the sheet.
    inset: [f64; 2],
    /// From the middle of its page to the middle of its lines, turned with the sheet.
    offset: [f64; 2],
    /// Width and height of the page.
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
        // A page that is not known is what the lines take, from the origin on.
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

    /// The size that was asked for, or the largest that its room has where it is made to fit.
    fn wanted(&self) -> f64 {
        if self.layout.fit {
            self.in_room(self.layout.scale)
        } else {
            self.layout.scale
        }
    }

    /// The largest size up to this one in which it keeps within its room.
    fn in_room(&self, scale: f64) -> f64 {
        let room = self.layout.room.iter().flatten().zip(self.size);
        room.fold(scale, |scale, (room, side)| {
            if scale * side > *room + ROUNDING {
                room / side
            } else {
                scale
            }
        })
    }

    /// The largest size that fits, but not above the one asked for, and where the middle of its lines goes then.
    fn largest(&self) -> Option<(f64, [f64; 2])> {
        let wanted = self.wanted();
        if (self.layout.at, self.layout.sheet) == (None, None) {
            let corners = self.hull.iter();
            let corners: Vec<_> = corners.map(|corner| corner.map(|at| wanted * at)).collect();
            let SheetTransform { scale, offset } =
                self.reach.best_place(&corners, Fit::Shrink).ok()?;
            // That has every way from one of its points to another within reach: its lines alone allow for more.
            return Some((self.grown(scale * wanted, offset), offset));
        }
        if let Some(at) = self.place(wanted) {
            return Some((wanted, at));
        }
        let fits = |scale| self.place(scale * (1.0 + MARGIN)).is_some();
        let scale = bisect(0.0, wanted, HALVINGS, fits);
        self.middle(scale)
            .filter(|_| scale > 0.0)
            .map(|at| (scale, at))
    }

    /// The largest size up to the one that is asked for in which its lines are within reach with their middle there, if it fits in
    /// one already.
    fn grown(&self, fits: f64, at: [f64; 2]) -> f64 {
        let wanted = self.wanted();
        if fits >= wanted || self.is_within(at, wanted) {
            return wanted.max(fits);
        }
        let is_within = |scale| self.is_within(at, scale * (1.0 + MARGIN));
        bisect(fits, wanted, GROWING, is_within)
    }

    /// Where the middle of its lines is to go in this size, if that was said.
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

    /// The same, if all of it is reached there.
    fn place(&self, scale: f64) -> Option<[f64; 2]> {
        let at = self.middle(scale)?;
        let on_sheet = match (self.layout.at, self.layout.sheet) {
            (None, Some(sheet)) => self.is_on(&sheet, scale),
            _ => true,
        };
        (on_sheet && self.is_within(at, scale)).then_some(at)
    }

    /// Whether all of it is reached with its middle there.
    fn is_within(&self, at: [f64; 2], scale: f64) -> bool {
        let put = |point: &[f64; 2]| [0, 1].map(|axis| at[axis] + scale * point[axis]);
        // Where its outside is reached, all of it is.
        let outside = self.hull.iter().chain(self.hull.first());
        let mut lines = self.turned.iter();
        self.reach.has_line(outside.map(put))
            || lines.all(|line| self.reach.has_line(line.iter().map(put)))
    }

    /// Whether its page is no larger than the sheet; a millimetre more is nothing.
    fn is_on(&self, sheet: &Sheet, scale: f64) -> bool {
        let [width, height] = self.page.map(|side| scale * side - 1.0);
        (sheet.size).is_none_or(|size| width <= size[0] && height <= size[1])
    }

    fn put(&self, scale: f64, at: [f64; 2]) -> PlacedArtwork {
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

    /// Why it does not fit, and what would.
    fn misfit(&self, most: Option<f64>, [near, far]: [f64; 2]) -> FitFailure {
        let turned = self.turned_by_90();
        let elsewhere = self.elsewhere();
        let at = |[x, y]: [f64; 2]| (Setting::At, Given::Point(x, y));
        let size = |scale: f64| {
            let [width, height] = self.size.map(|side| scale * side);
            message!("{width:.0} by {height:.0} mm", width, height)
        };
        let own = size(self.layout.scale);
        let Some(most) = most else {
            let message = match (self.layout.at, self.layout.sheet) {
                (Some([x, y]), _) => {
                    message!(
                        "nothing can be drawn around x = {x:.1}, y = {y:.1}; straight ahead x = {near:.0} to {far:.0} mm is reachable",
                        x,
                        y,
                        near,
                        far
                    )
                }
                (None, Some(_)) => message!(
                    "the corner of the sheet cannot be reached; straight ahead x = {near:.0} to {far:.0} mm is reachable",
                    near,
                    far
                ),
                (None, None) => message!(
                    "the drawing is {own}; straight ahead x = {near:.0} to {far:.0} mm is reachable",
                    own,
                    near,
                    far
                ),
            };
            let would_fit = turned.map(|scale| WouldFit::new(scale, self.layout.rotate + 90.0));
            let diagnostic = Diagnostic::of_file(message);
            return FitFailure {
                diagnostic: match elsewhere {
                    Some(place) => diagnostic.remedy(at(place), "fits there"),
                    None => {
                        diagnostic.remedy((Setting::At, Given::Any("X,Y")), "places it elsewhere")
                    }
                },
                would_fit: would_fit.filter(WouldFit::is_any),
            };
        };
        let other = turned.filter(|other| *other > most * 1.001);
        let free = (self.layout.at, self.layout.sheet) == (None, None);
        // What may be turned has its largest size so.
        let turns = free && self.layout.turn;
        let most = other.filter(|_| turns).unwrap_or(most);
        let limit = size(most);
        let message = match (self.layout.at, self.layout.sheet) {
            _ if self.layout.room.is_some() => message!(
                "the drawing is {own}, at most {limit} of that shape fits the page inside its margin and is reachable there",
                own,
                limit
            ),
            (Some(_), _) => message!(
                "the drawing is {own}, at most {limit} of that shape is reachable there",
                own,
                limit
            ),
            (None, Some(_)) => message!(
                "the drawing is {own}, at most {limit} of that shape fits the sheet and is reachable",
                own,
                limit
            ),
            (None, None) => message!(
                "the drawing is {own}, at most {limit} of that shape is reachable",
                own,
                limit
            ),
        };
        let mut would_fit = WouldFit::new(most, self.layout.rotate);
        let scale = (Setting::Scale, Given::Number(would_fit.scale));
        let mut diagnostic = Diagnostic::new(self.worst(), message)
            .remedy((Setting::Fit, Given::On), "shrinks it")
            .remedy(scale, "fits there");
        if let Some(place) = elsewhere {
            diagnostic = diagnostic.remedy(at(place), "fits at this size");
        }
        if let Some(other) = other {
            let rotate = self.layout.rotate + 90.0;
            would_fit = WouldFit::new(other, rotate);
            if !turns {
                let turn = (Setting::Rotate, Given::Number(rotate));
                diagnostic = diagnostic.remedy(turn, "leaves it more room");
            }
        }
        FitFailure {
            diagnostic,
            would_fit: Some(would_fit).filter(WouldFit::is_any),
        }
    }

    /// Another place where it would fit in this size and turn; where none was said every place was tried.
    fn elsewhere(&self) -> Option<[f64; 2]> {
        if (self.layout.at, self.layout.sheet) == (None, None) {
            return None;
        }
        let wanted = self.layout.scale;
        let corners = self.hull.iter();
        let corners: Vec<_> = corners.map(|corner| corner.map(|at| wanted * at)).collect();
        let place = self.reach.best_place(&corners, Fit::TrueSize).ok()?;
        let at = place.offset.map(rounded);
        self.is_within(at, wanted).then_some(at)
    }

    /// The largest size that would fit if it were turned.
    fn turned_by_90(&self) -> Option<f64> {
        let rotate = self.layout.rotate + 90.0;
        let layout = Layout {
            rotate,
            ..self.layout.clone()
        };
        let placer = Placer::new(self.artwork, self.artwork.bounds()?, &layout, self.reach);
        placer.largest().map(|(scale, _)| placer.in_room(scale))
    }

    /// The first line that is out of reach where the drawing was to go.
    fn worst(&self) -> Origin {
        let Some(at) = self.middle(self.layout.scale) else {
            return Origin::NONE;
        };
        let put = |point: &[f64; 2]| [0, 1].map(|axis| at[axis] + self.layout.scale * point[axis]);
        let mut lines = self.turned.iter().zip(&self.artwork.strokes);
        let beyond = |points: &Vec<[f64; 2]>| points.iter().any(|at| !self.reach.has(put(at)));
        let first = lines.find(|(points, _)| beyond(points));
        first.map_or(Origin::NONE, |(_, stroke)| stroke.origin)
    }
}

/// Coordinate, mm, rounded as messages tell it, so that it can be given again.
#[must_use]
pub fn rounded(at: f64) -> f64 {
    // Without a minus before a zero.
    (at * 10.0).round() / 10.0 + 0.0
}

/// Point turned counter-clockwise about the origin.
#[must_use]
pub fn rotated([x, y]: [f64; 2], degrees: f64) -> [f64; 2] {
    // Quarters are exact: a sheet that lies straight has straight lines.
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
