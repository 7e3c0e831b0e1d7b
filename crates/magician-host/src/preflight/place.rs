//! Errors of reach as positions in millimetres, as the caller gave the target.
//!
//! The planner reports a joint beyond its limit, which says little to a person who gave x, y and z.
//! These errors name the first position that is out of reach and the nearest one in reach.

use magician_model::PtpMove;
use magician_motion::{Geometry, Limits};
use magician_protocol::{CpMode, Set};

use super::Preflight;
use crate::message;
use crate::{Error, ErrorCode};

/// Step of the search towards and away from the base, mm.
const SEARCH_STEP: f64 = 10.0;
/// Number of steps in either direction: 600 mm in all, farther than any tool reaches.
const SEARCH_STEPS: u32 = 60;
/// Number of bisections of a step, to less than 0.1 mm.
const BISECTIONS: u32 = 8;
/// Reciprocal of the resolution of reported positions, 0.1 mm.
const STEPS_PER_MM: f64 = 10.0;

impl Preflight {
    /// Restates an error by the first position of the command that is out of reach and the nearest
    /// one in reach.
    ///
    /// Errors of other kinds, and of joint angles given as such, are unchanged.
    pub(super) fn restate_by_position(&self, command: &Set, error: Error) -> Error {
        // Only reach is a matter of position.
        if error.code() != ErrorCode::OutOfReach {
            return error;
        }
        let (geometry, limits) = (self.geometry(), &self.model.limits);
        let places = self.places_of(command);
        let mut beyond = places.into_iter().flatten();
        let beyond = beyond.find(|place| !geometry.reaches(*place, limits));
        let Some(place) = beyond else {
            return match error
                .progress()
                .filter(|_| places.iter().any(Option::is_some))
            {
                Some(percent) => error.in_place(message!(
                    "the way there leaves the reach of the arm after {percent:.0} % of it",
                    percent
                )),
                None => error,
            };
        };
        let [x, y, _] = place;
        let at = format_position(place);
        let Some(nearest) = nearest(&geometry, limits, place) else {
            return error.in_place(message!(
                "{at} is out of reach at any distance from the base",
                at
            ));
        };
        let is_too_near = libm::hypot(nearest[0], nearest[1]) > libm::hypot(x, y);
        let nearest = format_position(nearest);
        error.in_place(if is_too_near {
            message!(
                "{at} is too close to the base of the arm; the nearest place in reach is {nearest}",
                at,
                nearest
            )
        } else {
            message!(
                "{at} is out of reach; the nearest place in reach is {nearest}",
                at,
                nearest
            )
        })
    }

    /// Positions named by a command.
    fn places_of(&self, command: &Set) -> [Option<[f64; 3]>; 2] {
        // An increment names a position only if its start is known.
        let from = self.at.map(|at| [at.pose.x, at.pose.y, at.pose.z]);
        let by = |way: [f64; 3]| from.map(|from| [0, 1, 2].map(|axis| from[axis] + way[axis]));
        let point = |[x, y, z, _]: [f32; 4]| [x, y, z].map(f64::from);
        if let Some(ptp) = PtpMove::from_command(command) {
            let numbers = point(ptp.numbers);
            return [
                match ptp.mode {
                    mode if mode.is_absolute_pose() => Some(numbers),
                    mode if mode.is_pose() => by(numbers),
                    _ => None,
                },
                None,
            ];
        }
        let segment = |mode: CpMode, to: [f32; 3]| {
            let to = to.map(f64::from);
            match mode {
                CpMode::Relative => by(to),
                _ => Some(to),
            }
        };
        match command {
            Set::CpCmd(cp) => [segment(cp.cp_mode, [cp.x, cp.y, cp.z]), None],
            Set::CpLeCmd(cp) => [segment(cp.cp_mode, [cp.x, cp.y, cp.z]), None],
            Set::ArcCmd(arc) => [arc.cir_point, arc.to_point].map(|at| Some(point(at))),
            Set::CircleCmd(circle) => [circle.cir_point, circle.to_point].map(|at| Some(point(at))),
            Set::HomeParams(home) => [Some(point([home.x, home.y, home.z, 0.0])), None],
            _ => [None, None],
        }
    }
}

/// Nearest position in reach at the same height and heading, or at the nearest heading that the
/// base can turn to. `None` if that height is out of reach.
fn nearest(geometry: &Geometry, limits: &Limits, [x, y, z]: [f64; 3]) -> Option<[f64; 3]> {
    let heading = libm::atan2(y, x).to_degrees();
    // Behind the arm no position is in reach at the exact heading.
    let heading = heading.clamp(limits.j1.min, limits.j1.max).to_radians();
    let (sin, cos) = libm::sincos(heading);
    let place = |radius: f64| [radius * cos, radius * sin, z];
    let is_reached = |radius: f64| radius > 0.0 && geometry.reaches(place(radius), limits);
    // Distance from the base axis along that heading. Bounded, so that the search from a distant
    // target still meets the reach.
    let radius = (x * cos + y * sin)
        .max(0.0)
        .min(SEARCH_STEP * f64::from(SEARCH_STEPS));
    let (way, first) = (0..=SEARCH_STEPS).find_map(|nth| {
        let by = SEARCH_STEP * f64::from(nth);
        let mut ways = [1.0, -1.0].into_iter();
        let way = ways.find(|way| is_reached(radius + way * by))?;
        Some((way, radius + way * by))
    })?;
    // The boundary lies in the last step, of which one end is in reach.
    let (mut within, mut beyond) = (first, first - way * SEARCH_STEP);
    for _ in 0..BISECTIONS {
        let middle = f64::midpoint(within, beyond);
        if is_reached(middle) {
            within = middle;
        } else {
            beyond = middle;
        }
    }
    // The position must be in reach as reported, so move inwards until its rounded value is.
    let tenths = |at: [f64; 3]| at.map(|value| (value * STEPS_PER_MM).round() / STEPS_PER_MM);
    let mut inwards = (0..=3).map(|nth| place(within + way * f64::from(nth) / STEPS_PER_MM));
    let found = inwards.find(|at| geometry.reaches(tenths(*at), limits));
    Some(found.unwrap_or_else(|| place(within)))
}

/// Formats a position as `x 400, y 0, z 12.5`.
fn format_position(place: [f64; 3]) -> String {
    // Adding 0.0 turns -0 into 0.
    let [x, y, z] = place.map(|value| (value * STEPS_PER_MM).round() / STEPS_PER_MM + 0.0);
    format!("x {x}, y {y}, z {z}")
}

#[cfg(test)]
mod tests {
    use magician_motion::{JointAngles, ToolBias};

    use super::*;
    use crate::build;

    fn refused(command: &Set) -> Error {
        let mut check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
        check.check(command).unwrap_err()
    }

    #[test]
    fn unreachable_place_is_told_in_millimetres_with_the_nearest_one_in_reach() {
        for (at, why) in [
            ([0.0, 0.0, 0.0], "too close to the base of the arm"),
            ([20.0, 40.0, 50.0], "too close to the base of the arm"),
            ([400.0, 0.0, 0.0], "out of reach"),
            ([0.0, 300.0, 140.0], "out of reach"),
        ] {
            let [x, y, z] = at;
            let error = refused(&build::line_to(x, y, z, 0.0));
            let said = error.to_string();
            let begin = format!("x {x}, y {y}, z {z} is {why}; the nearest place in reach is ");
            let numbers = said.strip_prefix(&begin);
            let numbers = numbers.unwrap_or_else(|| panic!("{said}"));
            let numbers: Vec<f64> = { numbers.split(", ") }
                .map(|number| number[2..].parse().expect("a number"))
                .collect();
            let check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
            let nearest = [numbers[0], numbers[1], numbers[2]];
            assert!(
                check.geometry().reaches(nearest, &check.model.limits),
                "{said}"
            );
            assert!(error.detail().is_some() && error.value().is_some());
            assert_eq!(error.command(), Some("SetPTPCmd"));
        }
    }

    #[test]
    fn way_that_leaves_the_reach_is_told_without_joints() {
        let mut check = Preflight::at(JointAngles::HOME, ToolBias::SUCTION);
        check
            .check(&build::move_joints(80.0, 0.0, 45.0, 0.0))
            .unwrap();
        let [x, y, z] = check
            .arm()
            .map(|at| [at.pose.x, at.pose.y, at.pose.z])
            .unwrap();
        let error = check
            .check(&build::line_to(x as f32, -y as f32, z as f32, 0.0))
            .unwrap_err();
        let said = error.to_string();
        assert!(
            said.starts_with("the way there leaves the reach of the arm after "),
            "{said}"
        );
        assert!(
            error
                .detail()
                .is_some_and(|detail| detail.contains("% of the way there: "))
        );
    }

    #[test]
    fn joints_that_were_given_are_told_as_joints() {
        let error = refused(&build::move_joints(0.0, 95.0, 45.0, 0.0));
        assert_eq!(
            error.to_string(),
            "joint 2 would be at 95.0 deg, limit 90.0 deg"
        );
    }
}
