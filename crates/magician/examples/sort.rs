//! Sorts cubes by colour: a belt brings them, an infrared sensor detects each, and the suction cup
//! moves it over the colour sensor and from there to its place on the table.
//!
//! `cargo run -p magician --example sort`
//!
//! The arm is a virtual one, in the world of `crates/magician-sim/scenarios/pick_and_sort.toml`; at
//! the end the program checks there that every cube is in its place. To watch the same program in
//! real time, start
//! `magician sim --pty ./arm --scenario crates/magician-sim/scenarios/pick_and_sort.toml` in one
//! terminal and `cargo run -p magician --example sort -- ./arm` in another.

use std::error::Error;
use std::time::Duration;

use magician::commands::{ColorSensor, GetColorSensor, GetIrSwitch, IrSwitch};
use magician::protocol::{IoFunction, Port, SensorVersion, Stepper};
use magician::sim::Scenario;
use magician::{Options, Set, VirtualArm, blocking::Arm, build};

/// Layout of the cell, as in the scenario.
const CELL: &str = Scenario::PICK_AND_SORT;
const BUTTON: u8 = 15;
const BELT: Stepper = Stepper::Stepper1;
const AT_THE_BELT: Port = Port::Gp2;
const ON_THE_TABLE: Port = Port::Gp1;

/// 50 mm/s: a turn of the roller is 16000 pulses and 34 mm times pi.
const BELT_SPEED: i32 = 7490;
/// Time the belt runs between two sensor readings: 1 mm.
const LOOK: Duration = Duration::from_millis(20);
/// Readings without a cube after which the belt counts as empty.
const PATIENCE: u32 = 500;

/// Positions of the cup, x, y, z in mm: on a cube in front of the sensor, and over the colour
/// sensor with a cube.
const PICK: [f32; 3] = [260.0, 0.0, -10.0];
const SHOW: [f32; 3] = [160.0, 180.0, -10.0];
/// Places for the cubes of each colour, a cube's height above the table.
const PLACES: [(&str, [f32; 3]); 3] = [
    ("red cube", [140.0, -200.0, -50.0]),
    ("green cube", [170.0, -200.0, -50.0]),
    ("blue cube", [200.0, -200.0, -50.0]),
];

/// Moves over a position, down to it, and holds or releases the cube.
fn carry(to: [f32; 3], hold: bool) -> [Set; 3] {
    let [x, y, z] = to;
    [
        build::jump_to(x, y, z, 0.0),
        build::suction(hold),
        build::wait(Duration::from_millis(500)),
    ]
}

/// Runs the belt until a cube is in front of the sensor; `false` if none comes.
fn cube_comes(arm: &Arm) -> magician::Result<bool> {
    let port = Some(AT_THE_BELT);
    let mut seen = false;
    arm.run(&[build::motor(BELT, BELT_SPEED)])?;
    for _ in 0..PATIENCE {
        seen = arm
            .get_with::<IrSwitch>(&GetIrSwitch { port })?
            .state
            .is_on();
        if seen {
            break;
        }
        // The arm waits, not the program: a virtual arm at full speed then advances as a real one
        // in 20 ms.
        arm.run(&[build::wait(LOOK)])?;
    }
    arm.run(&[build::motor(BELT, 0)])?;
    Ok(seen)
}

/// Returns the place for a cube of this colour. The sensor reports red, green and blue from 0 to
/// 255.
fn place_for(color: ColorSensor) -> (&'static str, [f32; 3]) {
    let ColorSensor { r, g, b } = color;
    let [red, green, blue] = PLACES;
    match r.max(g).max(b) {
        most if most == r => red,
        most if most == g => green,
        _ => blue,
    }
}

/// Sorts until the belt is empty, and returns the cubes in order.
fn sort(arm: &Arm) -> magician::Result<Vec<&'static str>> {
    arm.home()?;
    arm.run(&[
        build::tool_named("suction")?,
        build::jump_height(40.0, 100.0),
        build::infrared(AT_THE_BELT, true, SensorVersion::V2),
        build::color_sensor(ON_THE_TABLE, true, SensorVersion::V2),
        build::multiplex(BUTTON, IoFunction::DigitalInput),
        build::wait_for_level(BUTTON, true),
    ])?;
    let mut sorted = Vec::new();
    while cube_comes(arm)? {
        arm.run(&[carry(PICK, true), carry(SHOW, true)].concat())?;
        let port = Some(ON_THE_TABLE);
        let (name, place) = place_for(arm.get_with(&GetColorSensor { port })?);
        println!("a {name}");
        arm.run(&carry(place, false))?;
        sorted.push(name);
    }
    Ok(sorted)
}

/// Checks from outside, without sensors and motors, that every cube is in its place.
fn inspect(cell: &VirtualArm) {
    cell.with(|arm| {
        let look = arm.look();
        for (name, [x, y, _]) in PLACES {
            let cube = look.object(name).expect("it is in the scenario");
            let place = cube.place();
            println!("{name}: x {:.1} y {:.1} on the table", place.x, place.y);
            assert!(cube.on_table(), "{name}: {:?}", cube.rest());
            assert!(cube.seen_by(AT_THE_BELT) && cube.seen_by(ON_THE_TABLE));
            // The cup holds a cube where it touches it: off centre by the distance that the belt
            // ran on.
            let off = (place.x - f64::from(x)).hypot(place.y - f64::from(y));
            assert!(off < 10.0, "{name} lies {off} mm away from its place");
        }
    });
}

fn main() -> Result<(), Box<dyn Error>> {
    let port = std::env::args().nth(1).unwrap_or_else(|| "sim".into());
    if port != "sim" {
        let sorted = sort(&Arm::connect(port)?)?;
        println!("{} cubes sorted", sorted.len());
        return Ok(());
    }
    let cell = VirtualArm::in_scenario(&Scenario::from_toml(CELL)?);
    let sorted = sort(&Arm::simulated(cell.clone(), Options::default())?)?;
    assert_eq!(sorted, ["red cube", "green cube", "blue cube"]);
    inspect(&cell);
    Ok(())
}
