//! Laser power of a plan: in proportion to speed (M4 of G-code), and scaled to the user's range.
//!
//! Under M4 the power of a burn follows the actual speed, so that corners, where the arm is slow,
//! do not burn deeper. The arm has one power per segment, so segments on which the speed changes
//! are cut into pieces with a power each. Cutting changes the velocity profile (each piece takes
//! whole periods of the controller), so the cut is repeated on the new profile, a few times at
//! most.

use magician_host::message;
use magician_host::preflight::PathProfiles;
use magician_host::{Set, Setting, SettingValue, VelocityProfile};
use magician_motion::ArmModel;

use super::{Action, Plan, Step};
use crate::{Diagnostic, DiagnosticCode, Parsed, Power};

/// Largest deviation of a piece's speed from its mean, as a share of the feed: a tenth, minus a
/// margin for rounding.
const MAX_SPEED_DEVIATION: f64 = 0.099;
/// Largest number of additional pieces per line. A choice between accuracy and the length of the
/// queue.
const MAX_EXTRA_PIECES: usize = 20;
/// Smallest length of a piece, mm. The beam is 0.2 mm wide, so shorter pieces make no visible
/// difference.
const MIN_PIECE_LENGTH: f64 = 0.005;
/// Largest number of cutting rounds. Cutting may slow down the new pieces, which then need cutting
/// themselves.
const MAX_CUTTING_ROUNDS: usize = 3;
/// Share of the feed from which it counts as reached. A choice that covers rounding and differences
/// too small to be seen.
const REACHED_SHARE: f64 = 0.99;

impl Plan {
    /// Sets the power of every burn that has a [feed](Step::feed) in proportion to the arm's actual
    /// speed: the nominal power times mean speed by feed, and never more than the nominal power.
    ///
    /// Lines on which the speed changes are cut into at most 20 more pieces. The power of each
    /// piece is then right within a tenth, or within half of the change over three periods of the
    /// arm: a shorter piece would slow the arm down. A note reports strokes that never reach their
    /// feed.
    ///
    /// Call it after placing and scaling, because the arm goes faster on longer lines.
    #[must_use]
    pub fn powered_by_speed(mut self) -> Parsed<Self> {
        let follows = |step: &Step| step.feed.is_some();
        if !self.steps.iter().any(follows) {
            return Parsed {
                content: self,
                notes: Vec::new(),
            };
        }
        // Remaining number of pieces into which each step may be cut.
        let mut room = vec![MAX_EXTRA_PIECES; self.steps.len()];
        let mut profiles = self.path_laws();
        for _ in 0..MAX_CUTTING_ROUNDS {
            let before = self.steps.len();
            (self.steps, room) = cut(&self.steps, &room, &profiles);
            if self.steps.len() == before {
                break;
            }
            profiles = self.path_laws();
        }
        let notes = unreached(&self.steps, &profiles).into_iter().collect();
        for (step, profile) in self.steps.iter_mut().zip(&profiles) {
            if let (Some(feed), Action::Burn { power, .. }) = (step.feed.take(), &mut step.action) {
                // A zero-length segment burns nothing.
                let speed = profile.map_or(0.0, |profile| profile.length() / profile.duration());
                *power = (f64::from(*power) * (speed / f64::from(feed)).min(1.0)) as f32;
                step.follows_speed = true;
            }
        }
        Parsed {
            content: self,
            notes,
        }
    }

    fn path_laws(&self) -> Vec<Option<VelocityProfile>> {
        let steps = self.steps.iter().map(|step| step.action.command());
        let commands: Vec<Set> = steps.clone().flatten().collect();
        let mut profiles = PathProfiles::of(&commands).into_iter();
        // Steps that send nothing have no profile.
        steps
            .map(|step| step.and_then(|_| profiles.next()).flatten())
            .collect()
    }

    /// Maps all laser powers into the user's range.
    ///
    /// # Errors
    /// A [`Diagnostic`] if a step switches the laser on, which is always full power.
    pub fn at_power(mut self, power: &Power) -> Result<Self, Diagnostic> {
        let of = |percent: f32| power.of(percent.into()) as f32;
        let names = self.names.clone();
        for (at, step) in self.steps.iter_mut().enumerate() {
            let lit = match &mut step.action {
                Action::Burn { power, .. } => {
                    *power = of(*power);
                    false
                }
                Action::Laser(on) => *on,
                Action::Command(command) => match &mut **command {
                    Set::CpLeCmd(segment) => {
                        segment.velocity_or_power = of(segment.velocity_or_power);
                        false
                    }
                    Set::SetEndEffectorLaser(laser) => {
                        laser.enable_ctrl.is_on() && laser.on.is_on()
                    }
                    _ => false,
                },
                _ => false,
            };
            if lit && power.range() != Power::FULL.range() {
                let message = message!(
                    "step {at} switches the laser on at full power: it cannot burn with {power} %",
                    at = at + 1,
                    power = power.to_string()
                );
                let diagnostic = Diagnostic::new(step.origin, message).remedy(
                    (Setting::Power, SettingValue::Number(100.0)),
                    "runs it as it is",
                );
                let name = step.origin.name_index().and_then(|at| names.get(at));
                return Err(match name {
                    Some(name) => diagnostic.named(name),
                    None => diagnostic,
                });
            }
        }
        Ok(self)
    }
}

/// Cuts the steps with a feed where their speed changes. Returns the steps and the number of pieces
/// that each may still become.
fn cut(
    steps: &[Step],
    room: &[usize],
    profiles: &[Option<VelocityProfile>],
) -> (Vec<Step>, Vec<usize>) {
    let mut pieces = Vec::with_capacity(steps.len());
    let mut left = Vec::with_capacity(steps.len());
    let mut from = None;
    for ((step, room), profile) in steps.iter().zip(room).zip(profiles) {
        let lit = matches!(step.action, Action::Burn { power, .. } if power > 0.0);
        let ways = match (profile, step.feed.filter(|_| lit)) {
            (Some(profile), Some(feed)) => cuts(profile, feed.into()),
            // Dark segments and those without a feed have nothing to adjust.
            _ => Vec::new(),
        };
        let fits = !ways.is_empty() && ways.len() <= *room;
        if let (true, Some(profile), Some(from), Some(to)) =
            (fits, profile, from, step.action.target())
        {
            // The pieces share the remaining cuts.
            let each = (room - ways.len()) / (ways.len() + 1);
            for way in &ways {
                let mut piece = step.clone();
                if let Action::Burn { to: end, .. } = &mut piece.action {
                    *end = between(from, to, way / profile.length());
                }
                pieces.push(piece);
                left.push(each);
            }
            left.push(each);
        } else {
            left.push(*room);
        }
        pieces.push(step.clone());
        if let Some(to) = step.action.target() {
            from = Some(to);
        }
    }
    (pieces, left)
}

fn between(from: [f32; 3], to: [f32; 3], share: f64) -> [f32; 3] {
    let at = |(from, to): (f32, f32)| {
        let (from, to) = (f64::from(from), f64::from(to));
        (from + (to - from) * share) as f32
    };
    let [x, y, z] = from;
    let [to_x, to_y, to_z] = to;
    [at((x, to_x)), at((y, to_y)), at((z, to_z))]
}

/// Smallest duration of a piece, in periods of the arm. The arm rounds a segment to a whole number
/// of periods, so one shorter than two may be faster by up to a half.
const MIN_PIECE_PERIODS: f64 = 2.0;
/// Share of the smallest duration from which a piece counts as long enough, for rounding errors.
const LONG_ENOUGH_SHARE: f64 = 1.0 - 1e-6;

/// Returns the distances, mm, at which a segment is to be cut so that no piece deviates from its
/// mean speed by more than a tenth of the feed. Speeds above the feed count as the feed.
fn cuts(profile: &VelocityProfile, feed: f64) -> Vec<f64> {
    let [ramp_in, cruise, ..] = profile.corners();
    let end = profile.duration();
    let speed = |time: f64| profile.velocity(time).min(feed);
    let mut times = Vec::new();
    let period = f64::from(ArmModel::MAGICIAN.law.period_us()) / 1e6;
    let least = MIN_PIECE_PERIODS * period;
    // Cut at whole periods from that end of the segment at which the ramp begins or ends. The
    // segment takes a whole number of periods, so the rest in its middle does too. A segment that
    // was slowed down to whole periods may be slowest in its middle.
    let mut ramp = |outer: f64, inner: f64| {
        let change = (speed(inner) - speed(outer)).abs();
        if change > MAX_SPEED_DEVIATION * feed {
            let ramp = time_at_speed(profile, speed(inner), outer, inner) - outer;
            let allowed = 2.0 * MAX_SPEED_DEVIATION * feed / change * ramp.abs() / period;
            let piece = allowed.floor().max(MIN_PIECE_PERIODS) * period;
            let count = (ramp.abs() / piece).ceil();
            let cuts = (1..=count as u32).map(f64::from);
            times.extend(cuts.map(|nth| outer + nth * piece.copysign(ramp)));
        }
    };
    ramp(0.0, ramp_in);
    ramp(end, cruise);
    times.sort_by(f64::total_cmp);
    let mut last = 0.0;
    times.retain(|time| {
        let fits =
            time - last >= LONG_ENOUGH_SHARE * least && end - time >= LONG_ENOUGH_SHARE * least;
        if fits {
            last = *time;
        }
        fits
    });
    let ways = times.into_iter().map(|time| profile.position(time));
    let mut ways: Vec<f64> = ways.collect();
    let mut last = 0.0;
    ways.retain(|way| {
        let fits = way - last >= MIN_PIECE_LENGTH && profile.length() - way >= MIN_PIECE_LENGTH;
        if fits {
            last = *way;
        }
        fits
    });
    ways
}

/// Time at which a ramp between two times reaches a speed. For a falling ramp its end.
fn time_at_speed(profile: &VelocityProfile, speed: f64, from: f64, to: f64) -> f64 {
    let (slow, fast) = (profile.velocity(from), profile.velocity(to));
    if fast > slow {
        from + (to - from) * ((speed - slow) / (fast - slow)).clamp(0.0, 1.0)
    } else {
        to
    }
}

/// Returns a note about strokes that never reach their feed.
fn unreached(steps: &[Step], profiles: &[Option<VelocityProfile>]) -> Option<Diagnostic> {
    let (mut strokes, mut weak) = (0_u32, 0_u32);
    // The first such stroke, its feed, and the best speed of all of them.
    let mut told: Option<(usize, f64, f64)> = None;
    // The current stroke: its first step, and the feed and speed of the step that comes closest to
    // its feed.
    let mut stroke: Option<(usize, f64, f64)> = None;
    let end = std::iter::once((steps.len(), None));
    let each = steps.iter().zip(profiles).enumerate();
    let each = each.map(|(at, (step, profile))| {
        let lit = matches!(step.action, Action::Burn { power, .. } if power > 0.0);
        (at, step.feed.filter(|_| lit).zip(*profile))
    });
    for (at, lit) in each.chain(end) {
        if let Some((feed, profile)) = lit {
            let feed = f64::from(feed);
            let [peak, ..] = profile.corners();
            let speed = profile.velocity(peak).max(profile.velocity(0.0));
            let best = stroke.get_or_insert((at, feed, speed));
            if speed / feed > best.2 / best.1 {
                (best.1, best.2) = (feed, speed);
            }
        } else if let Some((first, feed, speed)) = stroke.take() {
            strokes += 1;
            if speed < REACHED_SHARE * feed {
                weak += 1;
                let told = told.get_or_insert((first, feed, speed));
                if speed / feed > told.2 / told.1 {
                    (told.1, told.2) = (feed, speed);
                }
            }
        }
    }
    let (first, feed, speed) = told?;
    let which = match (weak, strokes) {
        (weak, strokes) if weak == strokes => message!("the arm"),
        _ => message!("in {weak} of {strokes} strokes the arm", weak, strokes),
    };
    let message = message!(
        "M4: {which} never reaches F{feed:.0} ({feed_2:.1} mm/s), only {speed:.1} mm/s: it burns weaker \
            throughout, with at most {feed_3:.0} % of S",
        which,
        feed = feed * 60.0,
        feed_2 = feed,
        speed,
        feed_3 = 100.0 * speed / feed
    );
    let origin = steps.get(first).map(|step| step.origin).unwrap_or_default();
    let note = Diagnostic::new(origin, message).coded(DiagnosticCode::Power);
    Some(note.help(message!(
        "M3 burns with the power of S at any speed; a lower F in the program is reached on \
            shorter lines"
    )))
}

#[cfg(test)]
mod tests {
    use magician_host::build;

    use super::*;
    use crate::Origin;

    /// Lines with 60 % power through these points, at a speed given as a share of the feed.
    fn plan(points: &[[f32; 2]], speed: f32, feed: f32) -> Plan {
        let mut plan = Plan::new("M4");
        plan.push(build::path_speed(speed, 100.0), Origin::NONE);
        let mut points = points.iter().map(|[x, y]| [*x, *y, 0.0]);
        let [x, y, z] = points.next().expect("a point");
        plan.push(build::line_to(x, y, z, 0.0), Origin::NONE);
        for to in points {
            plan.push(Action::Burn { to, power: 60.0 }, Origin::NONE);
        }
        plan.steps
            .iter_mut()
            .skip(2)
            .for_each(|step| step.feed = Some(feed));
        plan.push(Action::Laser(false), Origin::NONE);
        plan
    }

    /// Asserts that every piece has the power of its mean speed and is right within a tenth, or
    /// within the limit of the periods.
    ///
    /// The shortest piece after a cut has two periods, or three if an odd number was left; a line
    /// of the plan may have one. For a duration up to n + 1/2 periods at the acceleration of
    /// [`plan`] the arm takes n periods: the mean speed is higher by that share, and the slow end
    /// is half of the change below it.
    fn is_right(reading: &Parsed<Plan>, feed: f64) {
        let period = f64::from(ArmModel::MAGICIAN.law.period_us()) / 1e6;
        let plan = &reading.content;
        let profiles = plan.path_laws();
        for (step, profile) in plan.steps.iter().zip(&profiles) {
            assert!(step.feed.is_none());
            let lit = matches!(step.action, Action::Burn { power, .. } if power > 0.0);
            assert!(step.follows_speed || !lit);
            let (Action::Burn { power, .. }, Some(profile)) = (&step.action, profile) else {
                continue;
            };
            let mean = (profile.length() / profile.duration()).min(feed);
            assert!((f64::from(*power) - 60.0 * mean / feed).abs() < 1e-3);
            if profile.length() < 4.0 * MIN_PIECE_LENGTH {
                continue;
            }
            let [start, end] = [0.0, profile.duration()].map(|time| profile.velocity(time));
            let slowest = start.min(end).min(feed);
            let lasts = (profile.duration() / period).round();
            let share = (lasts + 0.5) / lasts;
            let half_change = 0.5 * 100.0 * (lasts + 0.5) * period;
            let hastened = if lasts <= MIN_PIECE_PERIODS + 1.0 {
                (share - 1.0) * slowest + share * half_change
            } else {
                0.0
            };
            let within = 60.0 * f64::max(0.1, hastened / feed);
            // Not at its end: a piece slowed down to whole periods leaves its end to the next one.
            for nth in 0..20 {
                let speed = profile.velocity(profile.duration() * (f64::from(nth) + 0.5) / 20.0);
                let exact = 60.0 * speed.min(feed) / feed;
                let off = (f64::from(*power) - exact).abs();
                assert!(
                    off <= within,
                    "{power} for {exact} on {:.3} mm",
                    profile.length()
                );
            }
        }
    }

    #[test]
    fn power_of_each_piece_is_within_a_tenth() {
        let zigzag: Vec<[f32; 2]> = (0..12_u8)
            .map(|nth| [200.0 + f32::from(nth), 40.0 * f32::from(nth % 2)])
            .collect();
        let curve: Vec<[f32; 2]> = (0..=200_u8)
            .map(|nth| libm::sincosf(f32::from(nth) / 20.0))
            .map(|(sin, cos)| [230.0 + 15.0 * cos, 15.0 * sin])
            .collect();
        for (points, lines) in [
            (&[[200.0, 0.0], [240.0, 0.0]][..], 1),
            (&[[200.0, 0.0], [240.0, 0.0], [240.0, 40.0]], 2),
            (&zigzag, 11),
            (&curve, 200),
        ] {
            for (speed, feed) in [
                (20.0, 20.0),
                (60.0, 60.0),
                (5.0, 5.0),
                (40.0, 20.0),
                (10.0, 30.0),
            ] {
                let made = plan(points, speed, feed).powered_by_speed();
                is_right(&made, feed.into());
                let steps = made.content.steps.len() - 3;
                assert!(steps > lines || lines == 200, "{steps}");
                assert!(
                    steps <= lines * (1 + MAX_EXTRA_PIECES),
                    "{steps} of {lines}"
                );
                let profiles = made.content.path_laws();
                // A segment between two segments at the feed may be slowed down to whole periods.
                let speeds = profiles.iter().flatten().map(|profile| {
                    let [peak, ..] = profile.corners();
                    profile.velocity(peak).max(profile.velocity(0.0))
                });
                let reached = speeds.fold(0.0, f64::max) > 0.99 * f64::from(feed);
                assert_eq!(made.notes.is_empty(), reached, "{:?}", made.notes);
                assert!(reached || lines == 200 || speed < feed);
            }
        }
    }

    #[test]
    fn line_gets_at_most_twenty_extra_pieces_and_keeps_its_end() {
        for feed in [5.0, 20.0, 100.0] {
            let made = plan(&[[180.0, -100.0], [260.0, 100.0]], feed, feed).powered_by_speed();
            let steps = &made.content.steps;
            assert!(
                (2 + 1 + 1..=2 + 21 + 1).contains(&steps.len()),
                "{}",
                steps.len()
            );
            assert_eq!(
                steps[steps.len() - 2].action.target(),
                Some([260.0, 100.0, 0.0])
            );
            is_right(&made, feed.into());
        }
    }

    #[test]
    fn unreached_feed_is_noted() {
        // 4 mm at 100 mm/s2 allow 20 mm/s and back to rest.
        let made = plan(&[[200.0, 0.0], [204.0, 0.0]], 100.0, 100.0).powered_by_speed();
        let [note] = &made.notes[..] else {
            panic!("{:?}", made.notes)
        };
        assert!(
            note.message
                .contains("never reaches F6000 (100.0 mm/s), only 20.0 mm/s"),
            "{note}"
        );
        let most = made
            .content
            .steps
            .iter()
            .filter_map(|step| match step.action {
                Action::Burn { power, .. } => Some(power),
                _ => None,
            });
        assert!(most.fold(0.0, f32::max) < 13.0);
    }

    #[test]
    fn power_option_scales_the_burns() {
        let mut plan = plan(&[[200.0, 0.0], [204.0, 0.0], [208.0, 0.0]], 20.0, 20.0);
        plan.steps.iter_mut().for_each(|step| step.feed = None);
        if let Action::Burn { power, .. } = &mut plan.steps[3].action {
            *power = 0.0;
        }
        let half = plan.clone().at_power(&"10..50".parse().unwrap()).unwrap();
        let powers: Vec<f32> = half
            .steps
            .iter()
            .filter_map(|step| match step.action {
                Action::Burn { power, .. } => Some(power),
                _ => None,
            })
            .collect();
        assert_eq!(powers, [34.0, 0.0]);
        plan.push(Action::Laser(true), Origin::NONE);
        assert!(plan.clone().at_power(&Power::FULL).is_ok());
        let refused = plan
            .at_power(&"50".parse().unwrap())
            .expect_err("it is full power");
        assert!(refused.message.contains("full power"), "{refused}");
    }
}
