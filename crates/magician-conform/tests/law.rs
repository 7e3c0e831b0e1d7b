//! Expected numbers of cases, derived here from the 20 ms law by summing periods (model sections 7,
//! 8 and 10). Nothing here uses the virtual arm, so a number copied from a wrong arm is found out.

use std::collections::BTreeMap;

/// Period of the controller, s.
const T: f64 = 0.02;
/// Tolerance, so that a rounding error costs no period.
const ROUNDING: f64 = 1e-7;
/// Distance of the tool from the first joint of an arm at home, mm.
const HOME_X: f64 = 199.4041;
const HOME_Z: f64 = -8.4853;

/// Returns the number of whole periods that have ended at a time.
fn ended(seconds: f64) -> u32 {
    (seconds / T + ROUNDING) as u32
}

/// Rounds a time up to whole periods.
fn whole(seconds: f64) -> f64 {
    (seconds / T - ROUNDING).ceil() * T
}

/// Returns the time of a path segment: the nearest whole number of periods, at least one. A tie
/// rounds up, with a tolerance because the segment's ends were rounded to binary32.
fn nearest(seconds: f64) -> f64 {
    (seconds / T + 0.5 + ROUNDING).floor().max(1.0) * T
}

/// Motion from rest to rest: length, highest speed, acceleration.
#[derive(Clone, Copy)]
struct Motion(f64, f64, f64);

impl Motion {
    /// Returns the duration in continuous time.
    fn seconds(self) -> f64 {
        let Self(length, v, a) = self;
        if length > v * v / a {
            length / v + v / a
        } else {
            2.0 * (length / a).sqrt()
        }
    }

    fn duration(self) -> f64 {
        whole(self.seconds())
    }

    /// Returns the position at a time: the sum of the distances in the periods that have ended,
    /// each the speed at its end times its length. After the last period this is the target.
    fn position(self, at: f64) -> f64 {
        let Self(length, v, a) = self;
        if ended(at) >= ended(self.duration()) {
            return length;
        }
        let peak = v.min((length * a).sqrt());
        let speed = |nth: u32| {
            let t = f64::from(nth) * T;
            peak.min(a * t).min(a * (self.seconds() - t))
        };
        (1..=ended(at)).map(speed).sum::<f64>() * T
    }
}

/// Returns the distance that a jog covers in a time while `speed` changes to `target`.
fn jog(mut speed: f64, target: f64, a: f64, at: f64) -> f64 {
    let mut position = 0.0;
    for _ in 0..ended(at) {
        speed += (target - speed).clamp(-a * T, a * T);
        position += speed * T;
    }
    position
}

/// Returns the speeds at the ends and junctions of path segments of these lengths: 0 at both ends,
/// and at most `corner` at a junction. The path has 100 mm/s2 and at most 100 mm/s.
fn junction_speeds(lengths: &[f64], corner: f64) -> Vec<f64> {
    let count = lengths.len();
    let mut squares = vec![(corner * corner).min(100.0 * 100.0); count + 1];
    (squares[0], squares[count]) = (0.0, 0.0);
    for at in 1..count {
        // No segment is faster than its length per period.
        squares[at] = squares[at].min((lengths[at - 1].min(lengths[at]) / T).powi(2));
    }
    for at in 1..=count {
        squares[at] = squares[at].min(squares[at - 1] + 200.0 * lengths[at - 1]);
    }
    for at in (0..count).rev() {
        squares[at] = squares[at].min(squares[at + 1] + 200.0 * lengths[at]);
    }
    squares.into_iter().map(f64::sqrt).collect()
}

/// Path segment between two speeds at 100 mm/s2 and at most 100 mm/s.
#[derive(Clone, Copy)]
struct Segment {
    length: f64,
    entry: f64,
    exit: f64,
}

impl Segment {
    fn seconds(self) -> f64 {
        let Self {
            length,
            entry,
            exit,
        } = self;
        // No segment is faster than its length per period.
        let most = 100.0_f64.min(length / T);
        let highest = (100.0 * length + 0.5 * (entry * entry + exit * exit)).sqrt();
        let peak = highest.min(most);
        let ramps = (2.0 * peak - entry - exit) / 100.0;
        let ramped = (2.0 * peak * peak - entry * entry - exit * exit) / 200.0;
        ramps + (length - ramped).max(0.0) / peak
    }

    /// Returns the durations of its ramps in and out in continuous time, s.
    fn ramps(self) -> (f64, f64) {
        let Self {
            length,
            entry,
            exit,
        } = self;
        let highest = (100.0 * length + 0.5 * (entry * entry + exit * exit)).sqrt();
        let peak = highest.min(100.0_f64.min(length / T));
        ((peak - entry).abs() / 100.0, (peak - exit).abs() / 100.0)
    }

    /// Returns the position at a time, with the segment's duration rounded to whole periods.
    ///
    /// If that shortens the segment, all its parts are shortened by the same factor. If it
    /// lengthens the segment, the peak speed is lower; a peak between the speeds at the ends is a
    /// plateau within the only ramp. If neither is possible, the speed is constant.
    fn position(self, at: f64) -> f64 {
        let Self {
            length,
            entry,
            exit,
        } = self;
        let duration = nearest(self.seconds());
        let share = duration / self.seconds();
        if share < 1.0 {
            let (up, down) = self.ramps();
            let (up, down) = (share * up, share * down);
            let peak = (length - 0.5 * (entry * up + exit * down)) / (duration - 0.5 * (up + down));
            let left = duration - at;
            return if at < up {
                at * (entry + 0.5 * (peak - entry) * at / up)
            } else if left < down {
                length - left * (exit + 0.5 * (peak - exit) * left / down)
            } else {
                0.5 * (entry + peak) * up + peak * (at - up)
            };
        }
        let rise = 0.5 * (100.0 * duration + entry + exit);
        let under = rise * rise - 100.0 * length - 0.5 * (entry * entry + exit * exit);
        let mut peak = rise - under.max(0.0).sqrt();
        let (high, low) = (entry.max(exit), entry.min(exit));
        if peak < high {
            let ramp = (high - low) / 100.0;
            if ramp < duration {
                peak = (length - 0.5 * (high + low) * ramp) / (duration - ramp);
            }
            if ramp >= duration || peak < low {
                return length * at / duration;
            }
        }
        let (up, down) = ((peak - entry).abs() / 100.0, (peak - exit).abs() / 100.0);
        let slope = |from: f64, to: f64| (to - from).signum() * 100.0;
        let left = duration - at;
        if at < up {
            at * (entry + 0.5 * slope(entry, peak) * at)
        } else if left < down {
            length - left * (exit + 0.5 * slope(exit, peak) * left)
        } else {
            0.5 * (entry + peak) * up + peak * (at - up)
        }
    }
}

/// Returns the segments of a path.
fn path(lengths: &[f64], corner: f64) -> Vec<Segment> {
    let speeds = junction_speeds(lengths, corner);
    let pairs = speeds.windows(2).zip(lengths);
    pairs
        .map(|(speeds, length)| Segment {
            length: *length,
            entry: speeds[0],
            exit: speeds[1],
        })
        .collect()
}

fn path_duration(segments: &[Segment]) -> f64 {
    segments
        .iter()
        .map(|segment| nearest(segment.seconds()))
        .sum()
}

fn path_position(segments: &[Segment], at: f64) -> f64 {
    let mut at = f64::from(ended(at)) * T;
    let mut position = 0.0;
    for segment in segments {
        let duration = nearest(segment.seconds());
        if at < duration - 1e-9 {
            return position + segment.position(at);
        }
        (at, position) = (at - duration, position + segment.length);
    }
    position
}

/// Steps of each case, from its file.
struct Cases(BTreeMap<String, String>);

impl Cases {
    fn read() -> Self {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/cases");
        let mut cases = BTreeMap::new();
        for file in std::fs::read_dir(folder).expect("the cases") {
            let path = file.expect("a file").path();
            if path.extension().is_none_or(|end| end != "toml") {
                continue;
            }
            let text = std::fs::read_to_string(path).expect("read");
            let file: toml::Table = text.parse().expect("TOML");
            for case in file["case"].as_array().expect("cases") {
                let [id, steps] = ["id", "steps"].map(|key| case[key].as_str().expect("text"));
                let rows = case.get("each").and_then(toml::Value::as_array);
                for row in rows.map_or(vec![None], |rows| rows.iter().map(Some).collect()) {
                    let [mut id, mut steps] = [id, steps].map(str::to_owned);
                    for (key, value) in row.and_then(toml::Value::as_table).into_iter().flatten() {
                        let value = value
                            .as_str()
                            .map_or_else(|| value.to_string(), str::to_owned);
                        let key = format!("{{{key}}}");
                        id = id.replace(&key, &value);
                        steps = steps.replace(&key, &value);
                    }
                    cases.insert(id, steps);
                }
            }
        }
        Self(cases)
    }

    /// Returns the steps of a case that start with `begin`, without that prefix.
    fn steps(&self, id: &str, begin: &str) -> Vec<&str> {
        let steps = self.0.get(id).unwrap_or_else(|| panic!("no case {id}"));
        steps
            .lines()
            .filter_map(|line| line.strip_prefix(begin))
            .collect()
    }

    /// Compares the duration of the `nth` motion of a case.
    fn check_duration(&self, id: &str, nth: usize, seconds: f64) {
        let steps = self.steps(id, "done after ");
        let stated = steps[nth].split_once(" s").expect("seconds").0;
        let stated: f64 = stated.parse().expect("a number");
        assert!(
            (stated - seconds).abs() < 1e-6,
            "{id}: {stated} and not {seconds} s"
        );
    }

    /// Compares values of the `nth` pose in a case. `j1` to `j4` name elements of `joint_angle`.
    fn pose(&self, id: &str, nth: usize, values: &[(&str, f64)]) {
        let step = self.steps(id, "get Pose -> ")[nth];
        for (name, value) in values {
            let (field, joint) = match name.strip_prefix('j') {
                Some(joint) => ("joint_angle", joint.parse::<usize>().expect("a joint") - 1),
                None => (*name, 0),
            };
            let stated = step
                .split(' ')
                .find_map(|word| word.strip_prefix(field)?.strip_prefix('='));
            let stated = stated.unwrap_or_else(|| panic!("{id}: no {name} in {step}"));
            let stated = stated
                .split("+-")
                .next()
                .and_then(|stated| stated.split(',').nth(joint));
            let stated: f64 = stated.expect("a value").parse().expect("a number");
            assert!(
                (stated - value).abs() < 1e-3,
                "{id}, pose {nth}: {name}={stated} and not {value:.4}"
            );
        }
    }
}

#[test]
fn point_to_point_follows_from_the_law() {
    let cases = Cases::read();
    // Power-up: 200 mm/s and 200 mm/s2, 200 deg/s and 200 deg/s2, at ratios of 50.
    let line = |length| Motion(length, 100.0, 100.0);
    let turn = |degrees| Motion(degrees, 100.0, 100.0);
    let full = |length| Motion(length, 200.0, 200.0);
    cases.check_duration("ptp.movl-100-mm-full-speed", 0, full(100.0).duration());
    cases.check_duration("ptp.movj-90-deg", 0, turn(90.0).duration());
    cases.check_duration("ptp.movj-90-deg-full-speed", 0, full(90.0).duration());
    for (nth, at) in [0.5, 1.0, 1.5].into_iter().enumerate() {
        let y = -50.0 + line(100.0).position(at);
        cases.pose("ptp.movl-on-the-way", nth, &[("y", y)]);
    }
    for (nth, at) in [1.0, 1.25, 1.5, 2.0].into_iter().enumerate() {
        let y = -75.0 + line(150.0).position(at);
        cases.pose("ptp.movl-cruises", nth, &[("y", y)]);
    }
    // J1 at 40 deg/s2, whose duration the other joints share.
    let midway = Motion(90.0, 100.0, 40.0);
    let share = midway.position(1.5) / 90.0;
    let joints = [
        ("j1", 90.0 * share),
        ("j2", 45.0 - 10.0 * share),
        ("j3", 45.0 + 10.0 * share),
        ("j4", 45.0 * share),
    ];
    cases.pose("ptp.movj-midway", 0, &joints);
    for (nth, at) in [0.5, 1.0].into_iter().enumerate() {
        let way = line(100.0).position(at);
        let position = [("x", 180.0 + 0.6 * way), ("y", -60.0 + 0.8 * way)];
        cases.pose("ptp.movl-is-straight", nth, &position);
    }
    let j1 = (-45.0 + turn(90.0).position(0.948)).to_radians();
    let position = [("x", HOME_X * j1.cos()), ("y", HOME_X * j1.sin())];
    cases.pose("ptp.movj-is-not-straight", 0, &position);
    cases.check_duration("ptp.no-blending", 0, 2.0 * line(50.0).duration());
    cases.check_duration("ptp.ratio-above-100", 0, full(100.0).duration());
    cases.check_duration("ptp.speed-set-in-time", 0, full(90.0).duration());
    // Remainder after 500 ms.
    cases.check_duration("ptp.speed-set-too-late", 0, turn(90.0).duration() - 0.5);
    let chord = 2.0 * HOME_X * 30.0_f64.to_radians().sin();
    let y = -0.5 * chord + line(chord).position(1.497);
    let x = HOME_X * 30.0_f64.to_radians().cos();
    cases.pose("ptp.mode-5-is-straight", 0, &[("x", x), ("y", y)]);
    // 2 sqrt(90/300) s: the speed of 320 deg/s is not reached.
    cases.check_duration(
        "ptp.joint-ceilings",
        0,
        Motion(90.0, 320.0, 300.0).duration(),
    );
    for (name, v, a) in [("slow-ramps", 200.0, 50.0), ("slow-speed", 50.0, 200.0)] {
        let id = format!("ptp.ratios-apart-{name}");
        cases.check_duration(&id, 0, Motion(90.0, v, a).duration());
        cases.check_duration(&id, 1, Motion(100.0, v, a).duration());
    }
    let id = "queue.parameters-between-moves";
    cases.check_duration(id, 0, turn(90.0).duration() + full(90.0).duration());
    cases.check_duration("wait.behind-a-move", 0, turn(90.0).duration() + 0.5);
    let after = turn(90.0).position(0.6);
    cases.pose("queue.force-stop-brakes-twice-as-hard", 0, &[("j1", after)]);
    let stands = after + jog(60.0, 0.0, 200.0, 0.3);
    cases.pose(
        "queue.force-stop-brakes-twice-as-hard",
        1,
        &[("j1", stands)],
    );
    // J1 turns 90 degrees in the 4 s that the rail takes. Its speed profile is a triangle, with an
    // acceleration of 4 * angle / duration^2.
    let along = Motion(90.0, 200.0, 4.0 * 90.0 / (4.0 * 4.0)).position(2.0);
    cases.pose("rail.on-the-way", 0, &[("j1", along)]);
    let rail = cases.steps("rail.on-the-way", "get PoseL -> pose_l=")[0];
    let rail: f64 = rail
        .split("+-")
        .next()
        .and_then(|stated| stated.parse().ok())
        .expect("a place");
    assert!((rail - line(300.0).position(2.0)).abs() < 1e-3, "{rail}");
}

#[test]
fn jumps_follow_from_the_law() {
    let cases = Cases::read();
    let leg = |length| Motion(length, 100.0, 100.0);
    let (lift, across) = (leg(20.0), leg(50.0));
    cases.pose("ptp.jump-lifts", 0, &[("z", lift.position(0.447))]);
    cases.pose("ptp.jump-lifts", 1, &[("z", lift.position(0.894))]);
    for (nth, at) in [(2, 1.602), (3, 2.309)] {
        let y = across.position(at - lift.duration());
        cases.pose("ptp.jump-lifts", nth, &[("y", y)]);
    }
    cases.check_duration(
        "ptp.jump-duration",
        0,
        2.0 * lift.duration() + across.duration(),
    );
    let low = 2.0 * leg(10.0).duration() + across.duration();
    cases.check_duration("ptp.jump-z-limit", 0, low);
    cases.check_duration("ptp.jump-from-above-the-z-limit", 0, across.duration());
    cases.pose(
        "ptp.jump-higher-end",
        0,
        &[("z", leg(50.0).position(1.415))],
    );
    // 30 degrees at 50 deg/s and 50 deg/s2 take longer than 50 mm.
    let r = Motion(30.0, 50.0, 50.0).position(2.444 - lift.duration());
    cases.pose("ptp.jump-turns-on-the-transfer", 1, &[("r", r)]);
    let slope = 50.0_f64.hypot(20.0);
    let legs = leg(10.0).duration() + leg(slope).duration() + leg(30.0).duration();
    cases.check_duration("ptp.jump2-heights", 0, legs);
    let id = "ptp.jump-transfer-straight";
    let y = -60.0 + leg(120.0).position(1.994 - lift.duration());
    cases.pose(id, 0, &[("y", y)]);
    cases.check_duration(id, 0, 2.0 * lift.duration() + leg(120.0).duration());
    // J1 turns from one end to the other at the same radius.
    let turn = 2.0 * (60.0_f64 / 200.0).atan().to_degrees();
    let j1 = -0.5 * turn + leg(turn).position(1.472 - lift.duration());
    let (sin, cos) = j1.to_radians().sin_cos();
    let radius = 200.0_f64.hypot(60.0);
    let position = [("x", radius * cos), ("y", radius * sin)];
    cases.pose("ptp.jump-transfer-in-joints", 0, &position);
}

#[test]
fn arcs_follow_from_the_law() {
    let cases = Cases::read();
    // Point-to-point speeds at power-up are 200 mm/s and 200 mm/s2; most cases set their ratio to
    // 100. The circle has a radius of 50 mm around x = 200.
    let turn = |share: f64| Motion(share * std::f64::consts::TAU * 50.0, 200.0, 200.0);
    let at = |way: Motion, seconds: f64| (way.position(seconds) / 50.0).sin_cos();
    let (half, full) = (turn(0.5), turn(1.0));
    let (sin, cos) = at(half, 0.886);
    for (id, axis, side) in [
        ("arc.goes-through-its-point", "y", 1.0),
        ("arc.other-sense", "y", -1.0),
        ("arc.upright", "z", 1.0),
    ] {
        let position = [("x", 200.0 + 50.0 * cos), (axis, side * 50.0 * sin)];
        cases.pose(id, 0, &position);
    }
    let (sin, cos) = at(turn(0.75), 1.089);
    let position = [("x", 200.0 + 50.0 * cos), ("y", 50.0 * sin)];
    cases.pose("arc.more-than-half", 0, &position);
    // A ratio of 50.
    let slower = Motion(half.0, 100.0, 100.0);
    for id in [
        "arc.duration",
        "arc.not-the-arc-parameters",
        "arc.own-ratio",
        "arc.after-a-cleared-alarm",
    ] {
        cases.check_duration(id, 0, slower.duration());
    }
    for (name, v, a) in [("slow-ramps", 200.0, 50.0), ("slow-speed", 50.0, 200.0)] {
        let id = format!("arc.ratios-apart-{name}");
        cases.check_duration(&id, 0, Motion(half.0, v, a).duration());
    }
    let r = 60.0 * half.position(0.886) / half.0;
    cases.pose("arc.rotation", 0, &[("r", r)]);
    cases.check_duration("arc.circle", 0, full.duration());
    cases.check_duration("arc.circle-without-count", 0, full.duration());
    cases.check_duration("arc.circle-twice", 0, turn(2.0).duration());
    let (sin, cos) = at(full, 1.285);
    let position = [("x", 200.0 + 50.0 * cos), ("y", 50.0 * sin)];
    cases.pose("arc.circle-halfway", 0, &position);
    let times = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.7];
    for (nth, seconds) in times.into_iter().enumerate() {
        let (sin, cos) = at(half, seconds);
        let position = [("x", 200.0 + 50.0 * cos), ("y", 50.0 * sin)];
        cases.pose("arc.round-on-the-way", nth, &position);
    }
}

#[test]
fn jogs_follow_from_the_law() {
    let cases = Cases::read();
    // Joints at power-up: 15 deg/s (J4: 30) at a ratio of 50, and 50 deg/s2; Cartesian 60 mm/s and
    // 60 mm/s2.
    let joint = |at: f64| jog(0.0, 7.5, 50.0, at);
    let space = jog(0.0, 30.0, 60.0, 1.0);
    let stop = jog(30.0, 0.0, 60.0, 1.0);
    let j4 = jog(0.0, 15.0, 50.0, 1.0);
    let stopped = joint(1.0) + jog(7.5, 0.0, 50.0, 1.0);
    for (nth, at) in [0.15, 1.0].into_iter().enumerate() {
        cases.pose("jog.joint-plus", nth, &[("j1", joint(at))]);
    }
    let id = "jog.every-joint";
    cases.pose(id, 0, &[("j2", 45.0 + joint(1.0))]);
    cases.pose(id, 1, &[("j2", 45.0 + stopped), ("j3", 45.0 - joint(1.0))]);
    cases.pose(id, 2, &[("j3", 45.0 - stopped), ("j4", -j4)]);
    cases.pose("jog.x", 0, &[("x", HOME_X + space)]);
    cases.pose("jog.x", 1, &[("x", HOME_X + space + stop)]);
    cases.pose("jog.y-keeps-r", 0, &[("y", space)]);
    cases.pose("jog.z-golden", 0, &[("z", HOME_Z + space)]);
    cases.pose("jog.z-golden", 1, &[("z", HOME_Z + stop)]);
    let turned = [("j4", space), ("r", space)];
    cases.pose("jog.r-turns-j4-alone", 0, &turned);
    for (nth, at) in [0.15, 0.3, 1.0].into_iter().enumerate() {
        let j1 = joint(1.0) + jog(7.5, -7.5, 50.0, at);
        cases.pose("jog.reversal", nth, &[("j1", j1)]);
    }
    for (nth, at) in [0.15, 1.15].into_iter().enumerate() {
        let joints = [("j1", -joint(1.0)), ("j2", 45.0 + jog(-7.5, 7.5, 50.0, at))];
        cases.pose("jog.change-of-axis", nth, &joints);
    }
    let fast = jog(0.0, 15.0, 50.0, 1.0);
    cases.pose("jog.speed-ratio", 0, &[("j1", fast)]);
    for (nth, at) in [0.5, 1.106667].into_iter().enumerate() {
        let j1 = -130.0 + jog(0.0, 320.0, 300.0, at);
        cases.pose("jog.joint-ceilings", nth, &[("j1", j1)]);
    }
}

#[test]
fn continuous_paths_follow_from_the_law() {
    let cases = Cases::read();
    let straight = |count: usize, length: f64| path(&vec![length; count], f64::INFINITY);
    // Speed at a right-angled corner: 0.5 planAcc period / sin(45 degrees).
    let right_angle = 0.5 * 100.0 * T / 45.0_f64.to_radians().sin();
    cases.check_duration("cp.blends-collinear", 0, path_duration(&straight(10, 10.0)));
    cases.check_duration(
        "cp.indices-on-the-way",
        0,
        path_duration(&straight(2, 50.0)),
    );
    let y = -50.0 + path_position(&straight(2, 50.0), 1.01);
    cases.pose("cp.indices-on-the-way", 0, &[("y", y)]);
    let corner = path(&[50.0, 50.0], right_angle);
    cases.check_duration("cp.corner", 0, path_duration(&corner));
    let alone = path_duration(&straight(1, 50.0));
    cases.check_duration("cp.runs-dry", 0, alone);
    cases.check_duration("cp.runs-dry", 1, alone);
    let many = straight(20, 5.0);
    let times = [0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75];
    for (nth, at) in times.into_iter().enumerate() {
        let y = -50.0 + path_position(&many, at);
        cases.pose("cp.on-the-way", nth, &[("y", y)]);
    }
    cases.check_duration("cp.on-the-way", 0, path_duration(&many));
    for (nth, at) in [0.5, 1.4].into_iter().enumerate() {
        let y = -50.0 + path_position(&corner, at);
        cases.pose("cp.corner-on-the-way", nth, &[("y", y)]);
    }
    let x = 200.0 + path_position(&corner, 2.3) - 50.0;
    cases.pose("cp.corner-on-the-way", 2, &[("x", x)]);
    cases.check_duration(
        "cp.after-a-cleared-alarm",
        0,
        path_duration(&straight(4, 25.0)),
    );
    // A ramp of 4.5 mm up to 30 mm/s at 100 mm/s2, 30 segments at that speed, and a ramp of 4.5 mm
    // to rest.
    for (nth, length) in [1.0, 1.4].into_iter().enumerate() {
        let duration = 2.0 * nearest(0.3) + 30.0 * nearest(length / 30.0);
        cases.check_duration("cp.whole-periods", nth, duration);
    }
}
