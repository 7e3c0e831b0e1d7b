//! Picture of the public recording of a jog, with the same jog on two virtual arms: computed in
//! periods of 20 ms, and in continuous time.

use std::error::Error;
use std::fs;
use std::path::Path;

use magician_motion::{Geometry, Pose, ToolBias};
use magician_picture::svg::{Anchor, Svg, TextStyle, palette, path};
use magician_protocol::commands::JogCmd;
use magician_protocol::{Ctrl, Flag, FrameBuf, JogCommand};
use magician_sim::{ArmInstant, Controller, LinkId, Profile};

const RECORDING: &str =
    include_str!("../../crates/magician-sim/tests/virtual_arm/data/jog-recording.tsv");
const COMMANDS: &str =
    include_str!("../../crates/magician-sim/tests/virtual_arm/data/jog-commands.tsv");

/// Control period, µs (model section 7).
const PERIOD_US: u64 = 20_000;
/// Phase of the recording's start within a period, µs.
const PHASE_US: u64 = 10_000;
/// Range of the recording that is drawn, ms. The arm is at rest before it.
const FROM_MS: u64 = 5_400;
const TO_MS: u64 = 11_900;
const WIDTH: f64 = 760.0;
const LEFT: f64 = 50.0;
const TOP: f64 = 46.0;
/// Height of the diagram of one axis.
const ROW_HEIGHT: f64 = 150.0;

/// Time in ms, and x, y, z.
type Sample = (u64, [f64; 3]);

fn rows(text: &str) -> impl Iterator<Item = Vec<&str>> {
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split('\t').collect())
}

fn number(text: &str) -> f64 {
    text.parse().unwrap_or_default()
}

/// Returns the recorded poses with their times in ms.
fn recorded() -> Vec<Sample> {
    let poses = rows(RECORDING).filter_map(|row| match row[..] {
        [at, x, y, z] => Some((number(at) as u64, [x, y, z].map(number))),
        _ => None,
    });
    poses.collect()
}

/// Returns the poses of a virtual arm, every 5 ms.
fn simulated(mut profile: Profile, [x, y, z]: [f64; 3]) -> Result<Vec<Sample>, Box<dyn Error>> {
    profile.power_up.tool = ToolBias::SUCTION;
    let geometry = Geometry::magician(profile.power_up.tool);
    profile.power_up.joints = geometry.inverse(&Pose::new(x, y, z, 0.0))?.to_array();
    let mut arm = Controller::new(profile);
    let mut commands = rows(COMMANDS)
        .filter_map(|row| match row[..] {
            [period, axis, speed] => {
                let axis = ["x", "y", "z"].iter().position(|name| *name == axis)?;
                let cmd = match number(speed) {
                    0.0 => 0,
                    speed => 1 + 2 * axis as u8 + u8::from(speed < 0.0),
                };
                Some((PHASE_US + number(period) as u64 * PERIOD_US, cmd))
            }
            _ => None,
        })
        .peekable();
    let mut poses = Vec::new();
    for at_ms in (FROM_MS..=TO_MS).step_by(5) {
        let now = PHASE_US + at_ms * 1000;
        while let Some((at, cmd)) = commands.next_if(|(at, _)| *at <= now) {
            arm.advance(ArmInstant::from_micros(at));
            let jog = JogCmd {
                is_joint: Flag::OFF,
                cmd: JogCommand::from(cmd),
            };
            arm.receive(LinkId(0), FrameBuf::set(&jog.into(), Ctrl::SET)?.bytes());
        }
        arm.advance(ArmInstant::from_micros(now));
        let pose = arm.state().pose;
        poses.push((at_ms, [pose.x, pose.y, pose.z]));
    }
    Ok(poses)
}

fn max_deviation(recorded: &[Sample], simulated: &[Sample]) -> f64 {
    let nearest = |at: u64| simulated.iter().min_by_key(|(other, _)| other.abs_diff(at));
    let drawn = recorded
        .iter()
        .filter(|(at, _)| (FROM_MS..=TO_MS).contains(at));
    drawn
        .filter_map(|(at, position)| Some((position, nearest(*at)?.1)))
        .flat_map(|(position, other)| [0, 1, 2].map(|axis| (position[axis] - other[axis]).abs()))
        .fold(0.0, f64::max)
}

fn draw() -> Result<String, Box<dyn Error>> {
    let recorded = recorded();
    let (_, first) = recorded.first().ok_or("no recording")?;
    let periodic = simulated(Profile::default(), *first)?;
    let continuous = simulated(Profile::continuous(), *first)?;
    let height = TOP + 3.0 * ROW_HEIGHT + 40.0;
    let mut svg = Svg::page(
        [WIDTH, height],
        "",
        "A recorded jog and the same jog of two virtual arms",
    );
    let style = |size, colour, anchor| TextStyle {
        size,
        colour,
        anchor,
        rim: false,
    };
    let title = format!(
        "A real arm, jogged in space (dots). Periods of 20 ms: at most {:.2} mm off. Continuous, axes after a stop: {:.1} mm off.",
        max_deviation(&recorded, &periodic),
        max_deviation(&recorded, &continuous),
    );
    svg.text(
        [LEFT, 24.0],
        title,
        &style(13.0, palette::INK, Anchor::Start),
    );
    let x_at =
        |at: u64| LEFT + (at - FROM_MS) as f64 / (TO_MS - FROM_MS) as f64 * (WIDTH - LEFT - 20.0);
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let shown = recorded
            .iter()
            .filter(|(at, _)| (FROM_MS..=TO_MS).contains(at));
        let all = shown.clone().map(|(_, position)| position[axis]);
        let all = all.chain(
            continuous
                .iter()
                .chain(&periodic)
                .map(|(_, position)| position[axis]),
        );
        let (low, high) = all.fold((f64::MAX, f64::MIN), |(low, high), at| {
            (low.min(at), high.max(at))
        });
        let top = TOP + ROW_HEIGHT * axis as f64;
        let y_at =
            |value: f64| top + 10.0 + (high - value) / (high - low).max(1.0) * (ROW_HEIGHT - 26.0);
        for (value, end) in [(high, 4.0), (low, 4.0)] {
            svg.text(
                [LEFT - 6.0, y_at(value) + end],
                format!("{value:.0}"),
                &style(11.0, palette::FAINT, Anchor::End),
            );
        }
        svg.text(
            [12.0, top + ROW_HEIGHT / 2.0],
            format!("{name}, mm"),
            &style(12.0, palette::INK, Anchor::Start),
        );
        for (line, colour, width) in [
            (&continuous, palette::WRONG, "1"),
            (&periodic, palette::EMPTY, "1.5"),
        ] {
            let points = line
                .iter()
                .map(|(at, values)| [x_at(*at), y_at(values[axis])]);
            svg.path(
                &path(points, false),
                &[
                    ("fill", "none"),
                    ("stroke", colour),
                    ("stroke-width", width),
                ],
            );
        }
        for (at, values) in shown {
            svg.circle(
                [x_at(*at), y_at(values[axis])],
                2.2,
                &[("fill", palette::INK)],
            );
        }
    }
    for second in 6..=11_u64 {
        svg.text(
            [x_at(second * 1000), height - 24.0],
            format!("{second} s"),
            &style(11.0, palette::FAINT, Anchor::Middle),
        );
    }
    Ok(svg.finish())
}

/// Writes `docs/pictures/jog-recording.svg`.
pub(crate) fn write(docs: &Path) -> Result<(), Box<dyn Error>> {
    fs::write(docs.join("pictures/jog-recording.svg"), draw()?)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn picture_is_current_and_the_periodic_arm_fits_the_recording() {
        let picture =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/pictures/jog-recording.svg");
        let written = fs::read_to_string(picture).expect("docs/pictures/jog-recording.svg");
        assert!(
            written == draw().expect("drawn"),
            "cargo xtask fidelity writes it anew"
        );
        let recorded = recorded();
        let (_, first) = recorded[0];
        let periodic = simulated(Profile::default(), first).expect("an arm");
        let continuous = simulated(Profile::continuous(), first).expect("an arm");
        assert!(
            max_deviation(&recorded, &periodic) < 0.05
                && max_deviation(&recorded, &continuous) > 1.0
        );
    }
}
