//! Footprints and positions.

use proptest::prelude::*;

use super::near;
use crate::world::{Footprint, ObjectPose, rotate};

fn footprint(x: f64, y: f64, yaw: f64, half: [f64; 2]) -> Footprint {
    let place = ObjectPose { x, y, z: 0.0, yaw };
    Footprint { place, half }
}

#[test]
fn rectangles_overlap_when_their_insides_do() {
    let square = footprint(0.0, 0.0, 0.0, [10.0, 10.0]);
    for (x, y, yaw, overlap) in [
        (19.99, 0.0, 0.0, true),
        (20.0, 0.0, 0.0, false),
        (19.0, 19.0, 90.0, true),
        // A corner is 14.14 mm from the middle.
        (24.0, 0.0, 45.0, true),
        (24.2, 0.0, 45.0, false),
        // The bounding boxes overlap, the squares do not.
        (17.2, 17.2, 45.0, false),
        (17.0, 17.0, 45.0, true),
    ] {
        let other = footprint(x, y, yaw, [10.0, 10.0]);
        assert_eq!(square.overlaps(&other), overlap, "{x} {y} {yaw}");
        assert_eq!(other.overlaps(&square), overlap, "{x} {y} {yaw}");
    }
}

#[test]
fn quarter_turns_are_exact() {
    let turned = [0.0, 90.0, 180.0, 270.0, -90.0].map(|degrees| rotate([3.0, 2.0], degrees));
    assert_eq!(
        turned,
        [
            [3.0, 2.0],
            [-2.0, 3.0],
            [-3.0, -2.0],
            [2.0, -3.0],
            [2.0, -3.0]
        ]
    );
}

proptest! {
    #[test]
    fn a_place_seen_from_another_is_found_again(
        x in -300.0..300.0_f64, y in -300.0..300.0_f64, z in -100.0..100.0_f64, yaw in -360.0..360.0_f64,
        dx in -300.0..300.0_f64, dy in -300.0..300.0_f64, turn in -360.0..360.0_f64,
    ) {
        let (here, there) = (ObjectPose { x, y, z, yaw }, ObjectPose { x: dx, y: dy, z: 5.0, yaw: turn });
        let again = here.then(&here.to(&there));
        prop_assert!(near(again.x, dx) && near(again.y, dy) && near(again.z, 5.0) && near(again.yaw, turn));
    }
}
