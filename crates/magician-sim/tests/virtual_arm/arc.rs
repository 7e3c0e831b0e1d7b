//! Arcs and circles over the protocol (document 1.12, model section 9).

use super::arm::{TestArm, joints_to, lasts, ptp, running_arm, trapezoid};
use magician_protocol::commands::*;
use std::f64::consts::PI;

/// Start of the arcs, on a circle of radius 40 mm around (200, 0).
const START: [f32; 4] = [200.0, -40.0, 0.0, 0.0];
const VIA: [f32; 4] = [240.0, 0.0, 0.0, 123.0];
const END: [f32; 4] = [200.0, 40.0, 0.0, 30.0];

fn arc(cir_point: [f32; 4], to_point: [f32; 4]) -> ArcCmd {
    ArcCmd {
        cir_point,
        to_point,
    }
}

fn circle(count: u32) -> CircleCmd {
    CircleCmd {
        cir_point: VIA,
        to_point: END,
        count,
    }
}

fn at_start() -> TestArm {
    let mut bench = running_arm();
    bench.enqueue(&ptp(1, START));
    bench.rest();
    bench
}

/// Samples the motion every millisecond. Returns the smallest and the greatest distance of the tool
/// from the centre of the circle, and its smallest distance from `VIA`.
fn look(bench: &mut TestArm) -> (f64, f64, f64) {
    let (mut least, mut most, mut nearest) = (f64::MAX, 0.0_f64, f64::MAX);
    while bench.state().moving {
        let pose = bench.state().pose;
        let radius = (pose.x - 200.0).hypot(pose.y);
        (least, most) = (least.min(radius), most.max(radius));
        nearest = nearest.min((pose.x - 240.0).hypot(pose.y));
        assert!(pose.z.abs() < 1e-9);
        bench.pass(1000);
    }
    (least, most, nearest)
}

#[track_caller]
#[test]
fn half_a_circle_takes_its_length_at_the_speeds_of_point_to_point_moves() {
    // Values at power-up: 200 mm/s and 200 mm/s2, both at a ratio of 50 %.
    let length = 40.0 * PI;
    let mut bench = at_start();
    bench.enqueue(&arc(VIA, END));
    lasts(bench.rest(), trapezoid(length, 100.0, 100.0));
    assert_eq!(
        bench.pose(),
        END,
        "r as well, and not the r of the point on the way"
    );

    let mut bench = at_start();
    bench.set(&PtpCoordinateParams {
        xyz_velocity: 100.0,
        r_velocity: 200.0,
        xyz_acceleration: 400.0,
        r_acceleration: 200.0,
    });
    bench.set(&PtpCommonParams {
        velocity_ratio: 50.0,
        acceleration_ratio: 25.0,
    });
    // The arm stores these parameters without effect.
    bench.set(&ArcParams {
        xyz_velocity: 1.0,
        r_velocity: 1.0,
        xyz_acceleration: 1.0,
        r_acceleration: 1.0,
    });
    bench.set(&ArcCommonParams {
        velocity_ratio: 1.0,
        acceleration_ratio: 1.0,
    });
    bench.enqueue(&arc(VIA, END));
    lasts(bench.rest(), trapezoid(length, 50.0, 100.0));
}

#[test]
fn the_rotation_decides_where_it_takes_longer() {
    let mut bench = at_start();
    bench.set(&PtpCoordinateParams {
        xyz_velocity: 200.0,
        r_velocity: 10.0,
        xyz_acceleration: 200.0,
        r_acceleration: 100.0,
    });
    bench.full_speed();
    bench.enqueue(&arc(VIA, END));
    lasts(bench.rest(), trapezoid(30.0, 10.0, 100.0));
}

#[test]
fn an_arc_is_round_and_goes_through_its_point() {
    let mut bench = at_start();
    bench.enqueue(&arc(VIA, END));
    let (least, most, nearest) = look(&mut bench);
    assert!(least > 39.99 && most < 40.01, "{least} to {most}");
    assert!(nearest < 0.2, "{nearest}");
    // In the opposite direction, through a point on the other side.
    let mut bench = at_start();
    bench.enqueue(&arc([160.0, 0.0, 0.0, 0.0], END));
    let (least, most, nearest) = look(&mut bench);
    assert!(least > 39.99 && most < 40.01, "{least} to {most}");
    assert!(nearest > 50.0, "{nearest}");
}

#[test]
fn a_circle_comes_back_after_its_turns() {
    for count in [1, 3] {
        let mut bench = at_start();
        let before = bench.pose();
        bench.enqueue(&circle(count));
        let began = bench.arm.now();
        let (least, most, nearest) = look(&mut bench);
        assert!(least > 39.99 && most < 40.01 && nearest < 0.2);
        assert_eq!(bench.pose(), before);
        let length = f64::from(count) * 2.0 * 40.0 * PI;
        let lasted = (bench.arm.now() - began).as_secs_f64();
        let expected = trapezoid(length, 100.0, 100.0);
        assert!(
            (0.0..2e-3).contains(&(lasted - expected)),
            "{lasted}, expected {expected}"
        );
    }
}

#[test]
fn a_turn_to_the_same_place_from_the_queue_and_at_once_is_the_same() {
    let mut queued = at_start();
    queued.enqueue(&circle(1));
    let mut at_once = at_start();
    at_once.set(&circle(1));
    while queued.state().moving {
        assert_eq!(queued.state().joints, at_once.state().joints);
        queued.pass(10_000);
        at_once.pass(10_000);
    }
    assert!(!at_once.state().moving);
}

#[test]
fn points_that_make_no_circle_are_refused() {
    let [near, line] = [START, [220.0, -40.0, 0.0, 0.0]];
    for (via, to, code) in [
        (near, END, 0x13),
        (VIA, VIA, 0x13),
        (VIA, START, 0x13),
        (line, [230.0, -40.0, 0.0, 0.0], 0x14),
        ([f32::NAN, 0.0, 0.0, 0.0], END, 0x11),
        (VIA, [240.0, 700.0, 0.0, 0.0], 0x11),
        (VIA, [f32::INFINITY, 0.0, 0.0, 0.0], 0x11),
    ] {
        let mut bench = at_start();
        let index = bench.enqueue(&arc(via, to));
        let next = bench.enqueue(&joints_to([0.0, 45.0, 45.0, 0.0]));
        assert_eq!(bench.alarms(), [code], "{via:?} {to:?}");
        assert_eq!((bench.rest(), bench.current_index()), (0, index));
        assert_eq!(bench.pose(), START);
        bench.set(&ClearAllAlarmsState {});
        bench.rest();
        assert_eq!(bench.current_index(), next);
    }
}

#[test]
fn speeds_that_are_none_are_refused() {
    for bad in [0.0, -5.0, f32::NAN] {
        let mut bench = at_start();
        bench.set(&PtpCommonParams {
            velocity_ratio: bad,
            acceleration_ratio: 100.0,
        });
        bench.enqueue(&arc(VIA, END));
        assert_eq!((bench.alarms(), bench.pose()), (vec![0x1A], START));
    }
}

#[test]
fn an_arc_that_leaves_the_limits_on_its_way_ends_there() {
    // Out past the longest reach and back.
    let mut bench = running_arm();
    bench.no_tool();
    bench.enqueue(&ptp(1, [250.0, -60.0, 0.0, 0.0]));
    bench.rest();
    let index = bench.enqueue(&arc([262.0, -40.0, 0.0, 0.0], [250.0, 60.0, 0.0, 0.0]));
    bench.rest();
    let alarms = bench.alarms();
    assert!(alarms == [0x22] || alarms == [0x21], "{alarms:x?}");
    assert_eq!(bench.current_index(), index);
    let [x, y, ..] = bench.pose();
    assert!(y < 0.0 && x.hypot(y) < 269.1, "{x} {y}");
}

#[test]
fn an_arc_is_stopped_and_braked_like_any_move() {
    let mut bench = at_start();
    bench.enqueue(&arc(VIA, END));
    bench.enqueue(&joints_to([0.0, 45.0, 45.0, 0.0]));
    bench.pass(500_000);
    bench.set(&QueuedCmdStopExec {});
    bench.rest();
    assert_eq!((bench.pose(), bench.left_space()), (END, 31));

    let mut bench = at_start();
    bench.enqueue(&arc(VIA, END));
    bench.pass(700_000);
    bench.set(&QueuedCmdForceStopExec {});
    assert!(bench.rest() > 0);
    assert!(bench.pose() != END && !bench.state().moving);
    assert_eq!((bench.left_space(), bench.alarms()), (32, vec![]));
}
