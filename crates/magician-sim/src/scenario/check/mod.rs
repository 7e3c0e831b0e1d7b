//! Validation of a scenario file, and its conversion to a [`Scenario`].
//!
//! The checks run in a fixed order: table and conveyor before the objects that rest on them. The
//! first invalid value ends the validation with a [`Diagnostic`]: the path to the value and a
//! sentence that says what to do.

use super::error::{Diagnostic, Key};
use super::file::{self, Facing, File};
use super::setting::{
    Arm, Beam, Conveyor, MAX_DISTANCE, Sensor, SensorKind, Table, Tool, ToolKind,
};
use super::{Scenario, Script};

mod objects;
mod rules;
mod script;

pub(super) use objects::intersect;
use rules::{Checked, SectionPath};

/// Validates a file and converts it to a scenario.
pub(super) fn scenario(file: File) -> Checked<Scenario> {
    let (table, conveyor) = (file.table, file.conveyor);
    table.as_ref().map_or(Ok(()), check_table)?;
    conveyor.as_ref().map_or(Ok(()), check_conveyor)?;
    let objects = objects::objects(&file.object, table.as_ref(), conveyor.as_ref())?;
    let mut script = Script::default();
    script::inputs(&file.input, &mut script)?;
    script::hands(&file.hand, &mut script)?;
    script::keys(&file.key, &mut script)?;
    script::faults(&file.fault, &mut script)?;
    // The script is played in order of time; the sort is stable, so entries of the same instant
    // keep the order of the file.
    script.timed.sort_by_key(|(at, _)| *at);
    let arm = file.arm.unwrap_or_default();
    check_arm(&arm)?;
    Ok(Scenario {
        title: file.title,
        arm,
        tool: file.tool.as_ref().map(tool).transpose()?,
        sensors: sensors(&file.sensor, conveyor.as_ref())?,
        table,
        conveyor,
        objects,
        script,
    })
}

fn check_arm(arm: &Arm) -> Checked<()> {
    let at = SectionPath::section("arm");
    at.number("base_angle", arm.base_angle, -180.0..=180.0, "deg")?;
    // Homing makes the assumed base angle equal to the true one (model section 11).
    if arm.homed && arm.base_angle != 0.0 {
        return at.diagnostic(
            "base_angle",
            "a homed arm knows its base angle: remove base_angle, or set homed = false",
        );
    }
    Ok(())
}

fn tool(tool: &file::Tool) -> Checked<Tool> {
    let at = SectionPath::section("tool");
    let mut checked = Tool::new(tool.kind);
    if let Some(give) = tool.give {
        checked.give = at.number("give", give, 0.0..=100.0, "mm")?;
    }
    if let Some(opening) = tool.opening {
        if tool.kind != ToolKind::Gripper {
            return at.diagnostic(
                "opening",
                "only a gripper has an opening: remove it, or set kind = \"gripper\"",
            );
        }
        checked.opening = at.length("opening", opening, 200.0)?;
    }
    Ok(checked)
}

fn check_table(table: &Table) -> Checked<()> {
    let at = SectionPath::section("table");
    // Wider than the workspace (-147 to 173 mm), so that a table out of reach can be tried, too.
    at.number("height", table.height, -500.0..=500.0, "mm")?;
    for (name, [from, to]) in [("x", table.x), ("y", table.y)] {
        at.numbers(name, &[from, to], -MAX_DISTANCE..=MAX_DISTANCE, "mm")?;
        if from >= to {
            let message =
                format!("{name} is [{from}, {to}], it must go from the smaller to the larger");
            return at.diagnostic(name, message);
        }
    }
    Ok(())
}

fn check_conveyor(conveyor: &Conveyor) -> Checked<()> {
    let at = SectionPath::section("conveyor");
    at.numbers("start", &conveyor.start, -MAX_DISTANCE..=MAX_DISTANCE, "mm")?;
    if conveyor.stepper > 1 {
        let message = format!(
            "stepper is {}, the arm has stepper outputs 0 and 1",
            conveyor.stepper
        );
        return at.diagnostic("stepper", message);
    }
    at.number("direction", conveyor.direction, -360.0..=360.0, "deg")?;
    at.length("length", conveyor.length, MAX_DISTANCE)?;
    at.length("width", conveyor.width, MAX_DISTANCE)?;
    at.number("height", conveyor.height, -500.0..=500.0, "mm")?;
    at.length("roller_diameter", conveyor.roller_diameter, 500.0)?;
    at.number("pulses_per_turn", conveyor.pulses_per_turn, 1.0..=1e9, "")?;
    Ok(())
}

fn sensors(sensors: &[file::Sensor], conveyor: Option<&Conveyor>) -> Checked<Vec<Sensor>> {
    let mut checked: Vec<Sensor> = Vec::new();
    for (nth, sensor) in sensors.iter().enumerate() {
        let at = SectionPath::entry("sensor", nth);
        let (kind, port) = (sensor.kind, sensor.port);
        // One plug per connector.
        if checked.iter().any(|other| other.port == port) {
            return at.diagnostic(
                "port",
                "another sensor is at this port: choose GP1, GP2, GP4 or GP5",
            );
        }
        let beam = beam(&at, sensor, conveyor)?;
        checked.push(Sensor { kind, port, beam });
    }
    Ok(checked)
}

fn beam(at: &SectionPath, sensor: &file::Sensor, conveyor: Option<&Conveyor>) -> Checked<Beam> {
    match (sensor.at, sensor.belt_at) {
        (Some(from), None) => free_beam(at, sensor, from),
        (None, Some(along)) => belt_beam(at, sensor, along, conveyor),
        (Some(_), Some(_)) => {
            at.diagnostic("belt_at", "a sensor has one position: give at or belt_at")
        }
        (None, None) => at.diagnostic(
            "",
            "the sensor has no position: give at = [x, y, z], or belt_at = mm along the belt",
        ),
    }
}

/// Line of sight of a sensor with its own position.
fn free_beam(at: &SectionPath, sensor: &file::Sensor, from: [f64; 3]) -> Checked<Beam> {
    at.numbers("at", &from, -MAX_DISTANCE..=MAX_DISTANCE, "mm")?;
    at.absent("above", sensor.above.is_some(), "above is for belt_at")?;
    // The default range of 50 mm and the heights above the belt in `belt_beam` are choices that
    // suit small cubes.
    let range = at.length("range", sensor.range.unwrap_or(50.0), MAX_DISTANCE)?;
    Ok(match sensor.facing.unwrap_or(Facing::Down) {
        Facing::Up => Beam::upright(from, range),
        Facing::Down => Beam::upright(from, -range),
        Facing::Level(degrees) => {
            at.number("facing", degrees, -360.0..=360.0, "deg")?;
            Beam::level(from, degrees, range)
        }
    })
}

/// Line of sight of a sensor at the belt: infrared looks across it, colour down onto its middle.
fn belt_beam(
    at: &SectionPath,
    sensor: &file::Sensor,
    along: f64,
    conveyor: Option<&Conveyor>,
) -> Checked<Beam> {
    let Some(belt) = conveyor else {
        return at.diagnostic(
            "belt_at",
            "there is no belt: add [conveyor], or give at = [x, y, z]",
        );
    };
    at.absent("facing", sensor.facing.is_some(), "facing is for at")?;
    at.number("belt_at", along, 0.0..=belt.length, "mm")?;
    let place = |across: f64, above: f64| {
        let inner = crate::world::ObjectPose {
            x: along,
            y: across,
            z: above,
            yaw: 0.0,
        };
        let place = belt.frame().then(&inner);
        [place.x, place.y, place.z]
    };
    match sensor.kind {
        SensorKind::Infrared => {
            let above = at.length("above", sensor.above.unwrap_or(5.0), 500.0)?;
            let range = at.length("range", sensor.range.unwrap_or(belt.width), MAX_DISTANCE)?;
            // The sensor stands at the edge of the belt and looks to the opposite one.
            let side = belt.width / 2.0;
            Ok(Beam {
                from: place(-side, above),
                to: place(range - side, above),
            })
        }
        SensorKind::Color => {
            let above = at.length("above", sensor.above.unwrap_or(50.0), 500.0)?;
            let range = at.length("range", sensor.range.unwrap_or(above), MAX_DISTANCE)?;
            Ok(Beam {
                from: place(0.0, above),
                to: place(0.0, above - range),
            })
        }
    }
}

/// Creates the diagnostic of a value, by the path to it.
fn diagnostic<T>(path: Vec<Key>, message: impl Into<String>) -> Checked<T> {
    let message = message.into();
    Err(Diagnostic { path, message })
}
