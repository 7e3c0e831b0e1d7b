//! Positions of boxes: frames that can be chained, and footprints.

/// Position of the middle of an object's underside in the frame of the arm's base, and its yaw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectPose {
    /// Forward, mm.
    pub x: f64,
    /// To the arm's left, mm.
    pub y: f64,
    /// Height of the underside, mm, as a z that the arm reports (model section 1).
    pub z: f64,
    /// Counter-clockwise seen from above, deg.
    pub yaw: f64,
}

impl ObjectPose {
    /// Composes two poses. `inner` is relative to this pose; the result is relative to the frame in
    /// which this pose is given.
    pub(crate) fn then(&self, inner: &Self) -> Self {
        let [x, y] = rotate([inner.x, inner.y], self.yaw);
        Self {
            x: self.x + x,
            y: self.y + y,
            z: self.z + inner.z,
            yaw: self.yaw + inner.yaw,
        }
    }

    /// Pose of `outer` relative to this pose: the inverse of [`then`](Self::then).
    pub(crate) fn to(&self, outer: &Self) -> Self {
        let [x, y] = rotate([outer.x - self.x, outer.y - self.y], -self.yaw);
        Self {
            x,
            y,
            z: outer.z - self.z,
            yaw: outer.yaw - self.yaw,
        }
    }

    /// Converts a point to coordinates relative to this pose.
    pub(crate) fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        rotate([x - self.x, y - self.y], -self.yaw)
    }

    pub(crate) fn xy(&self) -> [f64; 2] {
        [self.x, self.y]
    }
}

/// Rotates a vector by an angle in degrees; quarter turns are exact.
pub(crate) fn rotate([x, y]: [f64; 2], degrees: f64) -> [f64; 2] {
    let (sin, cos) = sin_cos(degrees);
    [x * cos - y * sin, x * sin + y * cos]
}

fn sin_cos(degrees: f64) -> (f64, f64) {
    // Split off quarter turns: boxes at 90 degrees must not overlap by a rounding error.
    let quarters = libm::round(degrees / 90.0);
    let rest = (degrees - quarters * 90.0).to_radians();
    let (sin, cos) = (libm::sin(rest), libm::cos(rest));
    match quarters.rem_euclid(4.0) {
        1.0 => (cos, -sin),
        2.0 => (-sin, -cos),
        3.0 => (-cos, sin),
        _ => (sin, cos),
    }
}

/// A rectangle in the plane, seen from above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Footprint {
    /// Middle and yaw; the height is not used.
    pub(crate) place: ObjectPose,
    /// Half of its length and width.
    pub(crate) half: [f64; 2],
}

impl Footprint {
    pub(crate) fn contains(&self, point: [f64; 2]) -> bool {
        let [x, y] = self.place.local(point);
        let [half_x, half_y] = self.half;
        x.abs() <= half_x && y.abs() <= half_y
    }

    /// Distance from its middle to its outermost point along a direction, mm.
    pub(crate) fn reach(&self, degrees: f64) -> f64 {
        let [x, y] = rotate([1.0, 0.0], degrees - self.place.yaw);
        x.abs() * self.half[0] + y.abs() * self.half[1]
    }

    /// True if two rectangles overlap; touching edges do not count.
    ///
    /// Separating-axis test: two convex shapes are disjoint if and only if their projections onto
    /// the normal of some side are disjoint.
    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        let between = [other.place.x - self.place.x, other.place.y - self.place.y];
        [self.place.yaw, other.place.yaw]
            .into_iter()
            .flat_map(|yaw| [yaw, yaw + 90.0])
            .all(|normal| {
                let [apart, _] = rotate(between, -normal);
                apart.abs() < self.reach(normal) + other.reach(normal)
            })
    }
}
