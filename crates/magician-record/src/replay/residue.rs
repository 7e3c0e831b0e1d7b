//! Distance of a recorded pose from the virtual arm.

use magician_protocol::{FrameBuf, Layout, Readable, commands};

/// x, y, z in mm; r and J1 to J4 in deg.
pub(crate) type Values = [f64; 8];

/// Comparison of the poses of a session.
#[derive(Clone, Debug, Default)]
pub(super) struct PoseComparison {
    /// The previous recorded pose.
    last: Option<Values>,
}

impl PoseComparison {
    /// Returns the distance, mm and deg, of a recorded pose from the nearest pose that the virtual
    /// arm answers at consecutive instants, and whether the recorded pose differs from the previous
    /// recorded one. `None` if the recorded answer is not a pose.
    ///
    /// In continuous time the poses between two instants count as well.
    pub(super) fn residue(
        &mut self,
        recorded: &FrameBuf,
        answers: [&Option<FrameBuf>; 3],
        is_continuous: bool,
    ) -> Option<([f64; 2], bool)> {
        let recorded = pose_in(recorded)?;
        let moved = self.last.is_some_and(|last| last != recorded);
        self.last = Some(recorded);
        let places = answers.into_iter().flatten().filter_map(pose_in);
        let places: Vec<Values> = places.collect();
        let between = places.windows(2).filter(|_| is_continuous);
        let between = between.map(|two| nearest(&recorded, &two[0], &two[1]));
        let all = places.iter().copied().chain(between);
        let off = all.map(|place| distance(&recorded, &place));
        let off = off.min_by(|a, b| a[0].max(a[1]).total_cmp(&b[0].max(b[1])))?;
        Some((off, moved))
    }
}

/// Values of a pose; `None` if one of them is not finite.
fn pose_in(answer: &FrameBuf) -> Option<Values> {
    let frame = answer.frame();
    if frame.id() != <commands::Pose as Readable>::ROW.id {
        return None;
    }
    let values = values_of(&commands::Pose::decode(frame.params()).ok()?);
    values
        .iter()
        .all(|value| value.is_finite())
        .then_some(values)
}

/// Values of a pose.
pub(crate) fn values_of(pose: &commands::Pose) -> Values {
    let [j1, j2, j3, j4] = pose.joint_angle;
    [pose.x, pose.y, pose.z, pose.r, j1, j2, j3, j4].map(f64::from)
}

/// Largest difference of x, y and z, mm, and of r and the joints, deg.
fn distance(one: &Values, other: &Values) -> [f64; 2] {
    let farthest = |range: std::ops::Range<usize>| {
        let off = range.map(|nth| (one[nth] - other[nth]).abs());
        off.fold(0.0, f64::max)
    };
    [farthest(0..3), farthest(3..8)]
}

/// Point closest to a pose on the line between two others.
fn nearest(pose: &Values, from: &Values, to: &Values) -> Values {
    let (mut along, mut square) = (0.0, 0.0);
    for nth in 0..8 {
        let step = to[nth] - from[nth];
        along += (pose[nth] - from[nth]) * step;
        square += step * step;
    }
    let fraction = if square > 0.0 {
        (along / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    std::array::from_fn(|nth| from[nth] + fraction * (to[nth] - from[nth]))
}
