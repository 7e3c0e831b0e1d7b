//! Calibration from touched points: the pose of the paper, and the position of the tool's tip.
//!
//! The user leads the tip to a few points and takes the pose at each. [`FittedSurface`] fits a
//! plane to touches of the work surface (least squares), [`Sheet::touched`] finds corner, rotation,
//! tilt and size of a sheet from three of its corners, and [`Tip`] finds the tool's bias from one
//! point that was touched in two orientations.
//!
//! Touches carry an error of some tenths of a millimetre, so each function refuses points whose
//! geometry would magnify that error into a wrong angle: points too close together, nearly in line,
//! or orientations too similar. Where the constants below draw that line is a choice.

use magician_host::{ToolBias, message};

use crate::artwork::Sheet;
use crate::{Diagnostic, Surface};

/// Smallest distance between touched points, mm. With an error of 0.5 mm per touch the direction
/// found from points this far apart is about 1 deg off.
const MIN_POINT_DISTANCE: f64 = 30.0;
/// Smallest height of the triangle of touched points, mm. Below it the points are nearly in line,
/// and the error of one touch would appear as a slope.
const MIN_TRIANGLE_HEIGHT: f64 = 15.0;
/// Largest deviation of a touched corner from a right angle, deg. Beyond it one of the points was
/// not a corner of the sheet.
const MAX_SKEW: f64 = 5.0;
/// Largest tilt of a surface, deg. A steeper result means that a touch missed the surface.
const MAX_TILT: f64 = 15.0;
/// Smallest turn of J4 between the two touches of a tip, deg. Closer orientations determine the tip
/// poorly.
const MIN_J4_TURN: f64 = 30.0;
/// Largest distance between the tip found and that of the tool in force, mm. A choice: no usual
/// tool sticks out that far, so a larger result means that two different points were touched.
const MAX_TIP_CORRECTION: f64 = 200.0;

/// Plane fitted to points where the tool touched a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct FittedSurface {
    /// The plane. Level for fewer than three touches.
    pub surface: Surface,
    /// Largest vertical distance of a touch from the plane, mm.
    pub residual: f64,
}

impl FittedSurface {
    /// Fits a plane to the touches, each the x, y, z of the tip in mm. The plane is level at their
    /// mean height for one or two touches, and that of least squares from three on.
    ///
    /// # Errors
    /// A [`Diagnostic`] if there are no touches, a coordinate is not finite, three or more touches
    /// lie within 30 mm or nearly in line, or the plane is steeper than 15 deg.
    pub fn touched(touches: &[[f64; 3]]) -> Result<Self, Diagnostic> {
        if touches.is_empty() || touches.iter().flatten().any(|number| !number.is_finite()) {
            return Err(not_finite());
        }
        let share = 1.0 / touches.len() as f64;
        let mean = [0, 1, 2].map(|axis| touches.iter().map(|at| at[axis]).sum::<f64>() * share);
        let slope = if touches.len() < 3 {
            [0.0, 0.0]
        } else {
            check_spread(touches)?;
            slope_about(mean, touches)
        };
        let surface = Surface {
            height: mean[2] - slope[0] * mean[0] - slope[1] * mean[1],
            slope,
        };
        check_tilt(surface)?;
        let off = touches
            .iter()
            .map(|&[x, y, z]| (z - surface.at([x, y])).abs());
        Ok(Self {
            surface,
            residual: off.fold(0.0, f64::max),
        })
    }
}

/// Returns the slope of the plane of least squares. That plane passes through the mean of the
/// points.
fn slope_about(mean: [f64; 3], points: &[[f64; 3]]) -> [f64; 2] {
    let sum = |one: usize, other: usize| -> f64 {
        let product = |at: &[f64; 3]| (at[one] - mean[one]) * (at[other] - mean[other]);
        points.iter().map(product).sum()
    };
    let [xx, xy, yy, xz, yz] = [sum(0, 0), sum(0, 1), sum(1, 1), sum(0, 2), sum(1, 2)];
    let det = xx * yy - xy * xy;
    [(xz * yy - yz * xy) / det, (yz * xx - xz * xy) / det]
}

/// Refuses points that determine a slope poorly: their longest side is too short, or the point
/// farthest from that side is too close to it.
fn check_spread(points: &[[f64; 3]]) -> Result<(), Diagnostic> {
    let (mut ends, mut longest) = ([[0.0; 3]; 2], 0.0);
    for (nth, &one) in points.iter().enumerate() {
        for &other in &points[nth + 1..] {
            let length = libm::hypot(other[0] - one[0], other[1] - one[1]);
            if length > longest {
                (ends, longest) = ([one, other], length);
            }
        }
    }
    let help = message!("touch three places far apart, as at the corners of a triangle");
    if longest < MIN_POINT_DISTANCE {
        let message = message!(
            "the touched points lie within {longest:.1} mm, at least {least} mm are needed to find \
                a slope",
            longest,
            least = MIN_POINT_DISTANCE
        );
        return Err(Diagnostic::of_file(message).help(help));
    }
    let along = difference(ends[1], ends[0]);
    let beside = |&at: &[f64; 3]| {
        let to = difference(at, ends[0]);
        (along[0] * to[1] - along[1] * to[0]).abs() / longest
    };
    let widest = points.iter().map(beside).fold(0.0, f64::max);
    if widest < MIN_TRIANGLE_HEIGHT {
        let message = message!(
            "the touched points are nearly in line, {widest:.1} mm beside it at most: at least \
                {least} mm are needed",
            widest,
            least = MIN_TRIANGLE_HEIGHT
        );
        return Err(Diagnostic::of_file(message).help(help));
    }
    Ok(())
}

fn check_tilt(surface: Surface) -> Result<(), Diagnostic> {
    let tilt = libm::atan(libm::hypot(surface.slope[0], surface.slope[1])).to_degrees();
    if tilt > MAX_TILT {
        let message = message!(
            "the surface is tilted by {tilt:.1} deg, limit {limit} deg",
            tilt,
            limit = MAX_TILT
        );
        return Err(Diagnostic::of_file(message)
            .help(message!("touch the paper each time, not the air above it")));
    }
    Ok(())
}

fn not_finite() -> Diagnostic {
    Diagnostic::of_file(message!("the touched points are not finite numbers"))
}

/// Corner of a sheet, as seen by a reader with the sheet before them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SheetCorner {
    /// The corner at the origin of the drawing's page.
    LowerLeft,
    /// The other end of the lower edge.
    LowerRight,
    /// The other end of the left edge.
    UpperLeft,
}

impl SheetCorner {
    /// All corners, in the order of [`Sheet::touched`].
    pub const ALL: [Self; 3] = [Self::LowerLeft, Self::LowerRight, Self::UpperLeft];

    /// Name, as in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::LowerLeft => "lower-left",
            Self::LowerRight => "lower-right",
            Self::UpperLeft => "upper-left",
        }
    }
}

/// Corners of a sheet that is being measured. They may be touched in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TouchedCorners([Option<[f64; 3]>; 3]);

impl TouchedCorners {
    /// Returns the x, y, z of the tip at a corner, mm; `None` if it was not touched yet.
    #[must_use]
    pub fn at(&self, corner: SheetCorner) -> Option<[f64; 3]> {
        self.0[corner as usize]
    }

    /// Returns the corners with this one touched at x, y, z of the tip, mm.
    ///
    /// # Errors
    /// A [`Diagnostic`] if a number is not finite or another corner was touched within 30 mm.
    pub fn with(self, corner: SheetCorner, at: [f64; 3]) -> Result<Self, Diagnostic> {
        if at.iter().any(|number| !number.is_finite()) {
            return Err(not_finite());
        }
        for other in SheetCorner::ALL {
            let Some(to) = self.at(other).filter(|_| other != corner) else {
                continue;
            };
            let length = libm::hypot(to[0] - at[0], to[1] - at[1]);
            if length < MIN_POINT_DISTANCE {
                let message = message!(
                    "this corner is {length:.1} mm from the one that was touched before, at least \
                        {least} mm are needed",
                    length,
                    least = MIN_POINT_DISTANCE
                );
                return Err(Diagnostic::of_file(message).help(message!(
                    "bring the tip to the corner that the sketch shows, then take it"
                )));
            }
        }
        let mut next = self;
        next.0[corner as usize] = Some(at);
        Ok(next)
    }

    /// Returns the sheet, or `None` while a corner is missing.
    ///
    /// # Errors
    /// Same as [`Sheet::touched`].
    pub fn sheet(&self) -> Result<Option<Sheet>, Diagnostic> {
        match self.0 {
            [Some(origin), Some(right), Some(up)] => Sheet::touched([origin, right, up]).map(Some),
            _ => Ok(None),
        }
    }
}

impl Sheet {
    /// Computes a sheet from its touched corners.
    ///
    /// The corners are lower left, lower right and upper left, each as x, y, z of the tip, mm. They
    /// give the height and tilt of the surface, the rotation of the sheet, and its size.
    ///
    /// # Errors
    /// A [`Diagnostic`] that says what to touch again if a number is not finite, two points lie
    /// within 30 mm, the corner deviates from a right angle by more than 5 deg, or the surface is
    /// steeper than 15 deg.
    pub fn touched(corners: [[f64; 3]; 3]) -> Result<Self, Diagnostic> {
        if corners.iter().flatten().any(|number| !number.is_finite()) {
            return Err(not_finite());
        }
        let [origin, right, up] = corners;
        let along = [right[0] - origin[0], right[1] - origin[1]];
        let across = [up[0] - origin[0], up[1] - origin[1]];
        let sides = [
            (along, message!("lower edge")),
            (across, message!("left edge")),
        ];
        for (side, name) in sides {
            let length = libm::hypot(side[0], side[1]);
            if length < MIN_POINT_DISTANCE {
                let message = message!(
                    "the {name} is {length:.1} mm long by the touched points, at least {least} mm \
                        are needed to find its direction",
                    name,
                    length,
                    least = MIN_POINT_DISTANCE
                );
                return Err(Diagnostic::of_file(message)
                    .help(message!("touch corners that are farther apart")));
            }
        }
        let rotation = libm::atan2(along[1], along[0]).to_degrees();
        let angle = normalized_angle(libm::atan2(across[1], across[0]).to_degrees() - rotation);
        if (angle - 90.0).abs() > MAX_SKEW {
            let message = message!(
                "the corner at the first point has {angle:.1} deg, that of a sheet has 90",
                angle
            );
            let help = message!(
                "touch lower left, lower right and upper left, in this order, as seen with the arm's X to the right"
            );
            return Err(Diagnostic::of_file(message).help(help));
        }
        let surface = plane(corners);
        check_tilt(surface)?;
        let height = libm::hypot(across[0], across[1]) * libm::sin(angle.to_radians());
        Ok(Self {
            corner: [origin[0], origin[1]],
            rotation,
            surface,
            size: Some([libm::hypot(along[0], along[1]), height]),
        })
    }

    /// Rounds to the precision of a touch, for files that people read.
    #[must_use]
    pub fn rounded(&self) -> Self {
        Self {
            corner: self.corner.map(|part| round(part, 1e3)),
            rotation: round(self.rotation, 1e4),
            surface: rounded_surface(self.surface),
            size: self.size.map(|size| size.map(|side| round(side, 1e2))),
        }
    }
}

/// Rounds the height of a level surface to the precision of a touch, mm.
#[must_use]
pub fn rounded_height(height: f64) -> f64 {
    round(height, 1e3)
}

/// Rounds a surface to the precision of a touch, for files that people read.
#[must_use]
pub fn rounded_surface(surface: Surface) -> Surface {
    Surface {
        height: round(surface.height, 1e4),
        slope: surface.slope.map(|part| round(part, 1e7)),
    }
}

/// Rounds to multiples of `1 / parts`.
fn round(value: f64, parts: f64) -> f64 {
    // Adding 0.0 turns -0.0 into 0.0, so that files do not show "-0".
    libm::round(value * parts) / parts + 0.0
}

/// Returns the plane through three non-collinear points.
fn plane([p, q, s]: [[f64; 3]; 3]) -> Surface {
    let (u, v) = (difference(q, p), difference(s, p));
    let det = u[0] * v[1] - u[1] * v[0];
    let slope = [
        (u[2] * v[1] - u[1] * v[2]) / det,
        (u[0] * v[2] - u[2] * v[0]) / det,
    ];
    Surface {
        height: p[2] - slope[0] * p[0] - slope[1] * p[1],
        slope,
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Normalises an angle to -180 to 180 deg.
fn normalized_angle(degrees: f64) -> f64 {
    let turned = degrees.rem_euclid(360.0);
    if turned > 180.0 {
        turned - 360.0
    } else {
        turned
    }
}

/// Position of a tool's tip, found from one point that it touched in two orientations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tip {
    /// Offset of the tip from where the current bias expects it, with J4 = 0: x ahead, y to the
    /// left, mm. It turns with the tool.
    pub offset: [f64; 2],
    /// Bias to set for this tool: the bias in force plus the offset.
    pub bias: ToolBias,
}

impl Tip {
    /// Computes the tip from two touches of the same point, with the tool turned by J4 in between.
    ///
    /// Each touch is x, y and r of the pose, mm and deg; `bias` is the bias in force. Half a turn
    /// gives the best accuracy.
    ///
    /// # Errors
    /// A [`Diagnostic`] if a number is not finite, the tool was turned by less than 30 deg, or the
    /// tip would be more than 200 mm off.
    pub fn touched(touches: [[f64; 3]; 2], bias: ToolBias) -> Result<Self, Diagnostic> {
        if touches.iter().flatten().any(|number| !number.is_finite()) {
            return Err(not_finite());
        }
        let [[x1, y1, r1], [x2, y2, r2]] = touches;
        let turned = normalized_angle(r2 - r1).abs();
        if turned < MIN_J4_TURN {
            let message = message!(
                "the tool was turned by {turned:.1} deg between the touches, at least {least} deg \
                    are needed",
                turned,
                least = MIN_J4_TURN
            );
            return Err(Diagnostic::of_file(message).help(message!(
                "turn it by half a turn and touch the same point again"
            )));
        }
        // Each pose plus the offset, turned by r, is the same point:
        // (R(r1) - R(r2)) offset = p2 - p1.
        let [(sin1, cos1), (sin2, cos2)] = [r1, r2].map(|r: f64| libm::sincos(r.to_radians()));
        let (c, s) = (cos1 - cos2, sin1 - sin2);
        let (dx, dy) = (x2 - x1, y2 - y1);
        let det = c * c + s * s;
        let offset = [(c * dx + s * dy) / det, (c * dy - s * dx) / det];
        let off = libm::hypot(offset[0], offset[1]);
        if off > MAX_TIP_CORRECTION {
            let message = message!(
                "the tip would be {off:.0} mm from that of the current tool, limit {limit} mm",
                off,
                limit = MAX_TIP_CORRECTION
            );
            return Err(Diagnostic::of_file(message)
                .help(message!("touch the same point with the tip both times")));
        }
        Ok(Self {
            offset,
            bias: ToolBias::new(bias.x + offset[0], bias.y + offset[1], bias.z),
        })
    }

    /// Returns the bias to set (x, y, z, mm), rounded to the precision of a touch.
    #[must_use]
    pub fn rounded_bias(&self) -> [f64; 3] {
        [self.bias.x, self.bias.y, self.bias.z].map(|part| round(part, 1e3))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotated_and_tilted_sheet_is_found() {
        let (corner, rotation, size) = ([180.0, -60.0], 12.0_f64, [120.0, 90.0]);
        let surface = Surface {
            height: -61.0,
            slope: [0.01, -0.02],
        };
        let (sin, cos) = libm::sincos(rotation.to_radians());
        let at = |u: f64, v: f64| {
            let [x, y] = [corner[0] + u * cos - v * sin, corner[1] + u * sin + v * cos];
            [x, y, surface.at([x, y])]
        };
        let sheet = Sheet::touched([at(0.0, 0.0), at(size[0], 0.0), at(0.0, size[1])]).unwrap();
        assert!((sheet.rotation - rotation).abs() < 1e-9);
        assert_eq!(sheet.corner, corner);
        let found = sheet.size.unwrap();
        assert!((found[0] - size[0]).abs() < 1e-9 && (found[1] - size[1]).abs() < 1e-9);
        assert!((sheet.surface.height - surface.height).abs() < 1e-9);
        for axis in 0..2 {
            assert!((sheet.surface.slope[axis] - surface.slope[axis]).abs() < 1e-12);
        }
    }

    #[test]
    fn impossible_sheet_is_refused() {
        let flat = |x: f64, y: f64| [x, y, -60.0];
        let near = Sheet::touched([flat(200.0, 0.0), flat(229.0, 0.0), flat(200.0, 80.0)]);
        assert!(near.unwrap_err().message.contains("29.0 mm"));
        let skew = Sheet::touched([flat(200.0, 0.0), flat(280.0, 0.0), flat(240.0, 80.0)]);
        assert!(skew.unwrap_err().message.contains("63.4 deg"));
        let swapped = Sheet::touched([flat(200.0, 0.0), flat(200.0, 80.0), flat(280.0, 0.0)]);
        assert!(swapped.unwrap_err().message.contains("-90.0 deg"));
        let steep = Sheet::touched([flat(200.0, 0.0), [280.0, 0.0, -20.0], flat(200.0, 80.0)]);
        assert!(steep.unwrap_err().message.contains("26.6 deg"));
        let line = Sheet::touched([flat(200.0, 0.0), flat(280.0, 0.0), flat(300.0, 0.0)]);
        assert!(line.is_err());
        assert!(Sheet::touched([[f64::NAN; 3]; 3]).is_err());
    }

    #[test]
    fn sheet_is_upright_for_a_reader_in_front_of_the_arm() {
        // The reader stands at +x and has +y to the right: the lower edge is the far one from the
        // base.
        let [left, right, top] = [
            [290.0, -100.0, -60.0],
            [290.0, 100.0, -60.0],
            [150.0, -100.0, -60.0],
        ];
        let corners = TouchedCorners::default();
        let corners = corners.with(SheetCorner::UpperLeft, top).unwrap();
        let corners = corners.with(SheetCorner::LowerLeft, left).unwrap();
        assert_eq!(corners.sheet().unwrap(), None);
        assert!(corners.with(SheetCorner::LowerRight, left).is_err());
        let corners = corners.with(SheetCorner::LowerRight, right).unwrap();
        let sheet = corners.sheet().unwrap().expect("three corners");
        assert!((sheet.rotation - 90.0).abs() < 1e-9);
        assert_eq!(sheet.corner, [290.0, -100.0]);
        let size = sheet.size.unwrap();
        assert!((size[0] - 200.0).abs() < 1e-9 && (size[1] - 140.0).abs() < 1e-9);
    }

    #[test]
    fn touches_give_a_level_plane_then_a_tilted_one_with_its_residual() {
        let level = FittedSurface::touched(&[[220.0, 10.0, -61.0]]).unwrap();
        assert_eq!(level.surface, Surface::level(-61.0));
        let two = FittedSurface::touched(&[[220.0, 10.0, -61.0], [260.0, 10.0, -60.0]]).unwrap();
        assert_eq!(two.surface, Surface::level(-60.5));
        assert!((two.residual - 0.5).abs() < 1e-12);
        let tilted = Surface {
            height: -63.0,
            slope: [0.01, -0.02],
        };
        let at = |x: f64, y: f64| [x, y, tilted.at([x, y])];
        let three = [at(200.0, -80.0), at(200.0, 80.0), at(280.0, 0.0)];
        let plane = FittedSurface::touched(&three).unwrap();
        assert!(
            (plane.surface.height - tilted.height).abs() < 1e-9,
            "{plane:?}"
        );
        assert!(plane.residual < 1e-9);
        let [x, y, z] = at(240.0, 0.0);
        let four = [three[0], three[1], three[2], [x, y, z + 0.4]];
        let plane = FittedSurface::touched(&four).unwrap();
        assert!(plane.residual > 0.1 && plane.residual < 0.4, "{plane:?}");
    }

    #[test]
    fn touches_that_do_not_determine_a_slope_are_refused() {
        let flat = |x: f64, y: f64| [x, y, -60.0];
        let refused = |points: &[[f64; 3]]| FittedSurface::touched(points).unwrap_err().message;
        let near = refused(&[flat(200.0, 0.0), flat(220.0, 0.0), flat(200.0, 20.0)]);
        assert!(near.contains("within 28.3 mm"), "{near}");
        let line = refused(&[flat(200.0, 0.0), flat(240.0, 5.0), flat(280.0, 0.0)]);
        assert!(line.contains("nearly in line"), "{line}");
        let steep = refused(&[flat(200.0, 0.0), flat(200.0, 80.0), [280.0, 0.0, -20.0]]);
        assert!(steep.contains("26.6 deg"), "{steep}");
        assert!(FittedSurface::touched(&[]).is_err());
    }

    #[test]
    fn a_tip_beside_the_axis_is_found() {
        let (point, offset) = ([230.0, 40.0], [3.0, -1.5]);
        let touch = |r: f64| {
            let (sin, cos) = libm::sincos(r.to_radians());
            let [x, y] = [
                offset[0] * cos - offset[1] * sin,
                offset[0] * sin + offset[1] * cos,
            ];
            [point[0] - x, point[1] - y, r]
        };
        for (from, to) in [(-80.0, 100.0), (10.0, 55.0), (0.0, 180.0)] {
            let tip = Tip::touched([touch(from), touch(to)], ToolBias::SUCTION).unwrap();
            assert!((tip.offset[0] - offset[0]).abs() < 1e-9, "{tip:?}");
            assert!((tip.offset[1] - offset[1]).abs() < 1e-9, "{tip:?}");
            assert!((tip.bias.x - (ToolBias::SUCTION.x + 3.0)).abs() < 1e-9);
        }
        assert!(Tip::touched([touch(0.0), touch(20.0)], ToolBias::NONE).is_err());
        assert!(Tip::touched([touch(0.0), touch(360.0)], ToolBias::NONE).is_err());
        let elsewhere = [[200.0, 10.0, 20.0], [-300.0, 20.0, 90.0]];
        let far = Tip::touched(elsewhere, ToolBias::NONE).unwrap_err();
        assert!(far.message.contains("436 mm"), "{}", far.message);
    }
}
