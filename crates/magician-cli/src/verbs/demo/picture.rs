//! Picture of the run: the tool's measured path and the cubes it moved.

use magician_motion::JointAngles;
use magician_picture::{ArmView, MovedObject, RunReading, RunView, Snapshot};

use super::scene::{CUBE_SIZE, CUBES, TABLE_Z, TOOL};

const TITLE: &str = "Six cubes, picked from a row and placed on a grid";

/// Draws a run as SVG.
pub(super) fn draw(readings: Vec<RunReading>, subtitle: String) -> String {
    let mut arm = ArmView::default();
    arm.title = TITLE.to_owned();
    arm.joints = JointAngles::HOME;
    arm.tool = TOOL;
    arm.facts = vec![subtitle];
    let mut run = RunView::default();
    run.readings = readings;
    run.table = Some(TABLE_Z);
    run.place = "home".to_owned();
    let cubes = (1..).zip(CUBES).map(|(number, cube)| {
        let on_table = |(x, y)| [x, y, TABLE_Z];
        MovedObject {
            name: number.to_string(),
            size: [CUBE_SIZE; 3],
            from: on_table(cube.from),
            to: on_table(cube.to),
        }
    });
    run.objects = cubes.collect();
    Snapshot::of_run(&arm, &run).to_svg().to_owned()
}

#[cfg(test)]
mod tests {
    use magician_picture::svg::palette;

    use super::super::scene::{CUBE_TOP_Z, LIFT_HEIGHT};
    use super::*;

    /// Readings at the corners of the path only.
    fn corners() -> Vec<RunReading> {
        let mut readings = Vec::new();
        for cube in CUBES {
            for ((x, y), holds) in [(cube.from, false), (cube.to, true)] {
                for z in [CUBE_TOP_Z + LIFT_HEIGHT, CUBE_TOP_Z] {
                    let at = [x, y, z];
                    readings.push(RunReading { at, holds });
                }
            }
            let (x, y) = cube.to;
            let at = [x, y, CUBE_TOP_Z + LIFT_HEIGHT];
            readings.push(RunReading { at, holds: false });
        }
        readings
    }

    #[test]
    fn a_run_is_drawn_with_both_tracks_all_cubes_and_all_labels() {
        let picture = draw(corners(), "a subtitle".to_owned());
        for part in [
            TITLE,
            palette::EMPTY,
            palette::CARRIED,
            palette::CARGO,
            "From above",
            "From the side",
            "a subtitle",
            "home",
            "base",
            "table",
            "object, before",
            "object, after",
            "within reach at some height",
            "within reach at z = −35 mm",
            "distance from the base axis / mm",
        ] {
            assert!(picture.contains(part), "{part}");
        }
        for number in 1..=CUBES.len() {
            // Each number occurs twice: at the cube's start and at its destination.
            assert_eq!(picture.matches(&format!(">{number}</text>")).count(), 2);
        }
        assert_eq!(
            picture.matches("<g ").count(),
            picture.matches("</g>").count()
        );
        assert!(!picture.contains("NaN"));
    }
}
