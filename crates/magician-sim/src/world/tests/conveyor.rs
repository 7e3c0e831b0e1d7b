//! The belt, the objects on it, and the sensors beside it.

use magician_protocol::Port;

use super::{Arm, SECOND, near};
use crate::Micros;
use crate::world::{ExternalEvent, Support, WorldEvent, WorldEventKind};

/// A belt along X at height -50, 300 mm long. The light barrier crosses it at 200, the colour
/// sensor is above 100.
const BELT: &str = r#"
[tool]
kind = "suction"
[table]
height = -70
[conveyor]
start = [100, 0]
direction = 0
length = 300
width = 60
height = -50
stepper = 1
[[sensor]]
kind = "infrared"
port = "GP2"
belt_at = 200
[[sensor]]
kind = "color"
port = "GP1"
belt_at = 100
[[object]]
name = "cube"
size = [20, 20, 20]
at = [120, 5]
on = "belt"
color = [200, 30, 10]
"#;

/// Pulses per second for a speed in mm/s.
fn pulses(speed: f64) -> f64 {
    speed * crate::CONVEYOR_PULSES_PER_MM
}

fn arm(text: &str) -> Arm {
    Arm::new(text, [200.0, 0.0, 50.0, 0.0])
}

#[test]
fn a_cube_passes_the_light_barrier_at_the_computed_instants() {
    let mut arm = arm(BELT);
    arm.wait_until(SECOND);
    arm.world.stepper(SECOND, 1, pulses(40.0));
    // The front of the cube is at 30 along the belt, its back at 10: 170 and 190 mm before 200.
    let (comes, goes) = (SECOND + 4_250_000, SECOND + 4_750_000);
    // Before that it passes the colour sensor at 100.
    let (comes_color, goes_color) = (SECOND + 1_750_000, SECOND + 2_250_000);
    arm.wait_until(7 * SECOND);
    let times: Vec<Micros> = arm.happened.iter().map(|(at, _)| *at).collect();
    let expected = [comes_color, goes_color, comes, goes];
    assert_eq!(times.len(), 4, "{times:?}");
    for (time, expected) in times.iter().zip(expected) {
        assert!(time.abs_diff(expected) <= 1, "{time} {expected}");
    }
    assert!(
        arm.happened
            .iter()
            .all(|(_, what)| *what == ExternalEvent::Input)
    );
}

#[test]
fn a_sensor_has_changed_when_it_is_told() {
    let mut arm = arm(BELT);
    arm.world.stepper(0, 1, pulses(33.3));
    let mut levels = Vec::new();
    while let Some(at) = arm.world.next_event() {
        assert_eq!(
            arm.world.infrared(at - 1, Port::Gp2),
            levels.last() == Some(&true)
        );
        assert_eq!(arm.world.poll_external(at), Some(ExternalEvent::Input));
        levels.push(arm.world.infrared(at, Port::Gp2));
    }
    // Colour on and off, the barrier on and off, the end of the belt.
    assert_eq!(levels, [false, false, true, false, false]);
}

#[test]
fn the_colour_sensor_tells_what_is_under_it() {
    let mut arm = arm(BELT);
    assert_eq!(arm.world.color(0, Port::Gp1), [0; 3]);
    arm.world.stepper(0, 1, pulses(40.0));
    arm.wait_until(2 * SECOND);
    assert_eq!(arm.world.color(arm.now, Port::Gp1), [200, 30, 10]);
    assert_eq!(
        arm.world.color(arm.now, Port::Gp2),
        [0; 3],
        "that one is infrared"
    );
    assert!(
        !arm.world.infrared(arm.now, Port::Gp1),
        "that one sees colours"
    );
    arm.wait_until(3 * SECOND);
    assert_eq!(arm.world.color(arm.now, Port::Gp1), [0; 3]);
    let look = arm.look();
    let cube = look.object("cube").unwrap();
    assert!(cube.seen_by(Port::Gp1) && !cube.seen_by(Port::Gp2));
}

#[test]
fn the_belt_goes_as_its_stepper_does() {
    let mut arm = arm(BELT);
    arm.world.stepper(0, 0, pulses(40.0));
    arm.wait_until(SECOND);
    assert_eq!(arm.look().belt_travel(), 0.0, "the other output");
    arm.world.stepper(SECOND, 1, pulses(40.0));
    arm.wait_until(2 * SECOND);
    arm.world.stepper(2 * SECOND, 1, pulses(-10.0));
    arm.wait_until(3 * SECOND);
    arm.world.stepper(3 * SECOND, 1, 0.0);
    arm.wait_until(9 * SECOND);
    assert!(near(arm.look().belt_travel(), 30.0));
    let look = arm.look();
    let cube = look.object("cube").unwrap();
    assert!(cube.on_belt());
    assert!(
        near(cube.place().x, 150.0) && near(cube.place().y, 5.0) && near(cube.place().z, -50.0)
    );
    assert_eq!(arm.world.next_event(), None);
}

#[test]
fn the_belt_runs_a_cube_off_its_end() {
    let mut arm = arm(BELT);
    arm.world.stepper(0, 1, pulses(100.0));
    // The middle of the cube is 280 mm from the end.
    arm.wait_until(2_799_999);
    assert!(arm.look().object("cube").unwrap().on_belt());
    arm.wait_until(2_800_002);
    let look = arm.look();
    let cube = look.object("cube").unwrap();
    assert!(cube.on_table());
    assert!(
        near(cube.place().x, 410.0) && near(cube.place().z, -70.0),
        "{:?}",
        cube.place()
    );
    let Some(WorldEvent { kind, .. }) = arm.world.poll_event() else {
        panic!("told")
    };
    assert_eq!(kind, WorldEventKind::FellOffBelt(0, Support::Table));
    assert_eq!(arm.world.next_event(), None);
}

#[test]
fn backwards_the_belt_runs_a_stack_off_its_start() {
    let stack = format!(
        "{BELT}\n[[object]]\nname = \"lid\"\nsize = [10, 10, 5]\nat = [122, 6]\non = \"cube\"\n"
    );
    let mut arm = arm(&stack);
    arm.world.stepper(0, 1, pulses(-10.0));
    arm.wait_until(3 * SECOND);
    let look = arm.look();
    let (cube, lid) = (look.object("cube").unwrap(), look.object("lid").unwrap());
    assert!(cube.on_table() && lid.on("cube"));
    assert!(near(cube.place().x, 90.0) && near(lid.place().x, 92.0));
    assert!(near(lid.place().z, -50.0));
}

#[test]
fn without_a_table_it_is_lost() {
    let text = BELT.replace("[table]\nheight = -70\n", "");
    let mut arm = arm(&text);
    arm.world.stepper(0, 1, pulses(100.0));
    arm.wait_until(5 * SECOND);
    assert!(arm.look().object("cube").unwrap().is_lost());
}

#[test]
fn a_slanted_belt_and_a_turned_cube_pass_as_geometry_says() {
    // The belt runs left and back at 120 degrees; the cube is turned by 45 degrees against it.
    let text = r#"
        [conveyor]
        start = [200, -100]
        direction = 120
        length = 300
        width = 60
        height = -50
        stepper = 0
        [[sensor]]
        kind = "infrared"
        port = "GP5"
        belt_at = 150
        [[object]]
        name = "cube"
        size = [20, 20, 20]
        at = [200, -100]
        yaw = 165
        on = "belt"
        "#;
    let mut arm = arm(text);
    arm.world.stepper(0, 0, pulses(50.0));
    arm.wait_until(5 * SECOND);
    let corner = 10.0 * std::f64::consts::SQRT_2;
    let expected = [(150.0 - corner) / 50.0, (150.0 + corner) / 50.0];
    for ((at, _), expected) in arm.happened.iter().zip(expected) {
        assert!((*at as f64 - expected * 1e6).abs() < 2.0, "{at} {expected}");
    }
    assert_eq!(arm.happened.len(), 2);
}

#[test]
fn the_barrier_sees_what_is_carried_through_it() {
    let mut arm = arm(BELT);
    arm.go([120.0, 5.0, -30.0, 0.0], SECOND);
    arm.suck(true);
    assert!(arm.world.holding());
    arm.go([120.0, 5.0, -20.0, 0.0], SECOND);
    arm.go([240.0, 5.0, -20.0, 0.0], SECOND);
    assert_eq!(arm.happened.len(), 3, "picked, and past the colour sensor");
    arm.happened.clear();
    // The cube hangs from -40 to -20 and the beam is at -45, so it passes above the beam.
    arm.go([340.0, 5.0, -20.0, 0.0], SECOND);
    assert_eq!(arm.happened, []);
    // 8 mm lower it passes back through the beam at x = 300, from 310 to 290.
    arm.go([340.0, 5.0, -28.0, 0.0], SECOND);
    let start = arm.now;
    arm.go([240.0, 5.0, -28.0, 0.0], SECOND);
    let times: Vec<Micros> = arm.happened.iter().map(|(at, _)| at - start).collect();
    assert!(
        times.len() == 2 && times[0].abs_diff(300_000) <= 1 && times[1].abs_diff(500_000) <= 1,
        "{times:?}"
    );
    assert!(arm.look().object("cube").unwrap().seen_by(Port::Gp2));
    // Held in the beam, it is seen while the arm stands still.
    arm.go([300.0, 5.0, -28.0, 0.0], SECOND);
    assert!(arm.world.infrared(arm.now, Port::Gp2));
}

#[test]
fn what_is_put_on_a_running_belt_goes_with_it() {
    let mut arm = arm(BELT);
    arm.go([120.0, 5.0, -30.0, 0.0], SECOND);
    arm.suck(true);
    arm.go([120.0, 5.0, 0.0, 0.0], SECOND);
    arm.world.stepper(arm.now, 1, pulses(40.0));
    arm.go([160.0, -5.0, -29.0, 0.0], SECOND);
    arm.suck(false);
    arm.happened.clear();
    let put = arm.now;
    arm.wait_until(put + SECOND);
    let look = arm.look();
    let cube = look.object("cube").unwrap();
    assert!(cube.on_belt() && near(cube.place().x, 200.0) && near(cube.place().y, -5.0));
    // The front of the object was 70 along the belt: 30 before the colour sensor.
    let (first, _) = arm.happened[0];
    assert!(first.abs_diff(put + 750_000) <= 1, "{first} {put}");
}
