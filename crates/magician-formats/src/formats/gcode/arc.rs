//! Arcs in the planes of G17, G18 and G19, with linear motion along the third axis (helices).

use std::f64::consts::{PI, TAU};

use magician_host::{Message, message};

use crate::artwork::distance;

/// Distance below which both ends of an arc coincide, mm: it is a full circle. It absorbs the
/// rounding of coordinates in the program.
const FULL_CIRCLE_TOLERANCE: f64 = 1e-4;
/// Largest relative difference of the radii at both ends. Programs round their coordinates.
const RADIUS_TOLERANCE: f64 = 1e-3;
/// Largest sweep of an arc of the arm, radians. The arm defines a circle by three points, which
/// determine it badly if two of them are close.
const MAX_SWEEP: f64 = PI * 5.0 / 3.0;
/// Largest number of chords. More means a damaged program.
const MAX_PIECES: f64 = 2000.0;

/// Plane of arcs: G17, G18 or G19.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Plane {
    #[default]
    Xy,
    Zx,
    Yz,
}

impl Plane {
    /// Returns its two axes and its normal. A rotation from the first to the second axis is
    /// counter-clockwise.
    pub(super) fn axes(self) -> [usize; 3] {
        match self {
            Self::Xy => [0, 1, 2],
            Self::Zx => [2, 0, 1],
            Self::Yz => [1, 2, 0],
        }
    }

    /// Words for an arc's centre in this plane.
    pub(super) fn centre_words(self) -> &'static str {
        match self {
            Self::Xy => "I, J",
            Self::Zx => "I, K",
            Self::Yz => "J, K",
        }
    }

    fn project(self, point: [f64; 3]) -> [f64; 3] {
        self.axes().map(|axis| point[axis])
    }

    fn unproject(self, point: [f64; 3]) -> [f64; 3] {
        let mut out = [0.0; 3];
        for (axis, value) in self.axes().into_iter().zip(point) {
            out[axis] = value;
        }
        out
    }
}

/// End points and direction of an arc.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub(super) plane: Plane,
    pub(super) from: [f64; 3],
    pub(super) to: [f64; 3],
    /// True if clockwise, seen from the positive end of the normal (G2).
    pub(super) clockwise: bool,
}

/// Definition of an arc's circle.
#[derive(Clone, Copy, Debug)]
pub(super) enum ArcForm {
    /// Centre, in the axes of the plane.
    Centre([f64; 2]),
    /// Radius; negative for the longer arc.
    Radius(f64),
}

/// An arc. If its radii at both ends differ by rounding, the radius changes linearly along it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arc {
    plane: Plane,
    from: [f64; 3],
    to: [f64; 3],
    centre: [f64; 2],
    start: f64,
    radii: [f64; 2],
    /// Sweep, radians, positive counter-clockwise.
    pub(super) sweep: f64,
}

impl Arc {
    /// Creates an arc between two points with `turns` additional full turns. `tolerance` is the
    /// allowed difference of both radii, mm.
    pub(super) fn new(
        ends: &Ends,
        round: ArcForm,
        turns: u32,
        tolerance: f64,
    ) -> Result<Self, Message> {
        let plane = ends.plane;
        let ends = &Ends {
            from: plane.project(ends.from),
            to: plane.project(ends.to),
            ..*ends
        };
        let [[ax, ay, _], [bx, by, _]] = [ends.from, ends.to];
        let chord = distance([ax, ay], [bx, by]);
        let centre = match round {
            ArcForm::Centre(centre) => centre,
            ArcForm::Radius(radius) => centre_of(ends, chord, radius, tolerance)?,
        };
        let radii = [distance(centre, [ax, ay]), distance(centre, [bx, by])];
        let [first, last] = radii;
        if first < FULL_CIRCLE_TOLERANCE {
            return Err(message!("the arc begins at its centre"));
        }
        if (first - last).abs() > tolerance.max(RADIUS_TOLERANCE * first) {
            return Err(message!(
                "the arc begins {first:.3} mm from its centre and ends {last:.3} mm from it",
                first,
                last
            ));
        }
        let start = libm::atan2(ay - centre[1], ax - centre[0]);
        let end = libm::atan2(by - centre[1], bx - centre[0]);
        let mut sweep = if chord < FULL_CIRCLE_TOLERANCE {
            TAU
        } else if ends.clockwise {
            (start - end).rem_euclid(TAU)
        } else {
            (end - start).rem_euclid(TAU)
        };
        sweep += TAU * f64::from(turns);
        Ok(Self {
            plane,
            from: ends.from,
            to: ends.to,
            centre,
            start,
            radii,
            sweep: if ends.clockwise { -sweep } else { sweep },
        })
    }

    /// Returns the point at a share of the arc.
    pub(super) fn at(&self, share: f64) -> [f64; 3] {
        if share >= 1.0 {
            return self.plane.unproject(self.to);
        }
        let [first, last] = self.radii;
        let radius = first + (last - first) * share;
        let (sin, cos) = libm::sincos(self.start + self.sweep * share);
        let [x, y] = self.centre;
        let z = self.from[2] + (self.to[2] - self.from[2]) * share;
        let point = [x + radius * cos, y + radius * sin, z];
        self.plane.unproject(point)
    }

    /// True if it stays at one height.
    pub(super) fn is_level(&self) -> bool {
        self.plane == Plane::Xy && (self.from[2] - self.to[2]).abs() < FULL_CIRCLE_TOLERANCE
    }

    /// Largest distance from its chord, mm.
    pub(super) fn height(&self) -> f64 {
        let radius = self.radii[0].max(self.radii[1]);
        if self.sweep.abs() >= PI {
            return radius;
        }
        radius * (1.0 - libm::cos(self.sweep / 2.0))
    }

    /// Iterates over arcs that the arm can execute, each as a point on the way and its end.
    pub(super) fn parts(&self) -> impl Iterator<Item = [[f64; 3]; 2]> + use<> {
        let count = (self.sweep.abs() / MAX_SWEEP).ceil().max(1.0);
        let arc = *self;
        (0..count as u32).map(move |nth| {
            let nth = f64::from(nth);
            let share = |part: f64| (nth + part) / count;
            [arc.at(share(0.5)), arc.at(share(1.0))]
        })
    }

    /// Iterates over the ends of chords within the tolerance.
    pub(super) fn corners(
        &self,
        tolerance: f64,
    ) -> Result<impl Iterator<Item = [f64; 3]> + use<>, Message> {
        let radius = self.radii[0].max(self.radii[1]);
        let widest = 2.0 * libm::acos((1.0 - tolerance / radius).clamp(-1.0, 1.0));
        // At most a quarter per chord, so that a small circle does not degenerate to a line.
        let count = (self.sweep.abs() / widest.min(PI / 2.0)).ceil().max(1.0);
        if count > MAX_PIECES {
            return Err(message!(
                "the arc has a radius of {radius:.0} mm and takes {count:.0} lines, limit {limit}",
                radius,
                count,
                limit = MAX_PIECES
            ));
        }
        let arc = *self;
        Ok((1..=count as u32).map(move |nth| arc.at(f64::from(nth) / count)))
    }
}

/// Computes the centre of an arc from its radius.
fn centre_of(ends: &Ends, chord: f64, radius: f64, tolerance: f64) -> Result<[f64; 2], Message> {
    let [[ax, ay, _], [bx, by, _]] = [ends.from, ends.to];
    if chord < FULL_CIRCLE_TOLERANCE {
        let words = ends.plane.centre_words().split_once(", ");
        let (first, second) = words.unwrap_or_default();
        return Err(message!(
            "an arc given by its radius must not end where it begins; a circle needs {first} and {second}",
            first,
            second
        ));
    }
    let (size, half) = (radius.abs(), chord / 2.0);
    if half - size > tolerance.max(RADIUS_TOLERANCE * half) {
        return Err(message!(
            "a radius of {size:.3} mm is too small for ends that are {chord:.3} mm apart, it must \
                be at least {half:.3} mm",
            size,
            chord,
            half
        ));
    }
    let off = (size * size - half * half).max(0.0).sqrt();
    // The centre of the shorter clockwise arc is to the right of the chord.
    let side = if ends.clockwise == (radius > 0.0) {
        1.0
    } else {
        -1.0
    };
    let right = [(by - ay) / chord, (ax - bx) / chord];
    Ok([
        f64::midpoint(ax, bx) + side * off * right[0],
        f64::midpoint(ay, by) + side * off * right[1],
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOCKWISE: bool = true;

    fn arc(from: [f64; 2], to: [f64; 2], clockwise: bool, round: ArcForm) -> Arc {
        let ends = Ends {
            plane: Plane::Xy,
            from: [from[0], from[1], 5.0],
            to: [to[0], to[1], 5.0],
            clockwise,
        };
        Arc::new(&ends, round, 0, 0.01).expect("an arc")
    }

    fn near(one: [f64; 3], other: [f64; 2]) {
        assert!(
            distance([one[0], one[1]], other) < 1e-9,
            "{one:?} {other:?}"
        );
    }

    #[test]
    fn arc_direction_is_as_seen_from_above() {
        let centre = ArcForm::Centre([10.0, 20.0]);
        let quarter = arc([15.0, 20.0], [10.0, 25.0], !CLOCKWISE, centre);
        let root = 5.0 / 2f64.sqrt();
        near(quarter.at(0.5), [10.0 + root, 20.0 + root]);
        let rest = arc([15.0, 20.0], [10.0, 25.0], CLOCKWISE, centre);
        near(rest.at(0.5), [10.0 - root, 20.0 - root]);
        assert!((quarter.sweep - rest.sweep - TAU).abs() < 1e-12);
        let circle = arc([15.0, 20.0], [15.0, 20.0], CLOCKWISE, centre);
        near(circle.at(0.25), [10.0, 15.0]);
        assert_eq!(circle.parts().count(), 2);
    }

    #[test]
    fn positive_radius_gives_the_shorter_arc_and_negative_the_longer() {
        let (from, to) = ([5.0, 0.0], [0.0, 5.0]);
        let middle = |clockwise, radius| arc(from, to, clockwise, ArcForm::Radius(radius)).at(0.5);
        let root = 5.0 / 2f64.sqrt();
        near(middle(!CLOCKWISE, 5.0), [root, root]);
        near(middle(CLOCKWISE, -5.0), [-root, -root]);
        near(middle(CLOCKWISE, 5.0), [5.0 - root, 5.0 - root]);
        near(middle(!CLOCKWISE, -5.0), [5.0 + root, 5.0 + root]);
        // A half circle whose radius was rounded down.
        near(
            arc([0.0, 0.0], [10.0, 0.0], CLOCKWISE, ArcForm::Radius(4.999)).at(0.5),
            [5.0, 5.0],
        );
    }

    #[test]
    fn arc_chords_are_within_tolerance() {
        let circle = arc(
            [30.0, 0.0],
            [30.0, 0.0],
            !CLOCKWISE,
            ArcForm::Centre([0.0, 0.0]),
        );
        for tolerance in [1.0, 0.05, 0.001] {
            let mut last = [30.0, 0.0];
            let mut worst = 0_f64;
            for [x, y, _] in circle.corners(tolerance).expect("few enough") {
                assert!((libm::hypot(x, y) - 30.0).abs() < 1e-9);
                let middle = [f64::midpoint(last[0], x), f64::midpoint(last[1], y)];
                worst = worst.max(30.0 - libm::hypot(middle[0], middle[1]));
                last = [x, y];
            }
            assert!(
                worst <= tolerance && worst > tolerance / 2.0,
                "{worst} {tolerance}"
            );
        }
    }

    #[test]
    fn invalid_arc_is_refused_with_both_values() {
        let ends = Ends {
            plane: Plane::Xy,
            from: [0.0, 0.0, 0.0],
            to: [10.0, 0.0, 0.0],
            clockwise: true,
        };
        let refused = |round| Arc::new(&ends, round, 0, 0.01).expect_err("no arc");
        assert_eq!(
            refused(ArcForm::Centre([4.0, 0.0])),
            "the arc begins 4.000 mm from its centre and ends 6.000 mm from it"
        );
        assert_eq!(
            refused(ArcForm::Radius(3.0)),
            "a radius of 3.000 mm is too small for ends that are 10.000 mm apart, it must be at least 5.000 mm"
        );
        let back = Ends {
            to: ends.from,
            ..ends
        };
        assert!(Arc::new(&back, ArcForm::Radius(3.0), 0, 0.01).is_err());
        assert!(Arc::new(&back, ArcForm::Centre([0.0, 0.0]), 0, 0.01).is_err());
    }
}
