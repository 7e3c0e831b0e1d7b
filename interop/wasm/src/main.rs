//! Prints the complete results of a recorded session on the virtual arm, and of files that are
//! planned, checked and rehearsed: every byte, pose and step to the last bit. The output must be
//! the same natively and as WebAssembly (`interop/wasm/run`).

use std::error::Error;

use magician_host::preflight::Preflight;
use magician_motion::{JointAngles, ToolBias};
use magician_picture::{DrawingOptions, drawing_svg};
use magician_program::rehearse::{RehearseOptions, rehearse};
use magician_program::{Format, ReadOptions, Setup, Surface, Tool, check, read};
use magician_protocol::Direction;
use magician_record::replay::Replay;
use magician_sim::{ArmInstant, Controller, LinkId, Profile};

/// Taught program with arcs and lines on a virtual arm in real time, recorded by `magician --port
/// sim:1 --trace`.
const SESSION: &[u8] = include_bytes!("../session.pcapng");

const FILES: [(&str, Tool, &[u8]); 5] = [
    (
        "curves.svg",
        Tool::Pen,
        include_bytes!("../../../crates/magician-program/samples/curves.svg"),
    ),
    (
        "star.plt",
        Tool::Pen,
        include_bytes!("../../../crates/magician-program/samples/star.plt"),
    ),
    (
        "plate.dxf",
        Tool::Pen,
        include_bytes!("../../../crates/magician-program/samples/plate.dxf"),
    ),
    (
        "laser_checker.gcode",
        Tool::Laser,
        include_bytes!("../../../crates/magician-program/samples/laser_checker.gcode"),
    ),
    (
        "engrave_gradient.png",
        Tool::Laser,
        include_bytes!("../../../crates/magician-program/samples/engrave_gradient.png"),
    ),
];

fn main() -> Result<(), Box<dyn Error>> {
    let replay = Replay::new(SESSION)?;
    let differences = replay.against(&mut Controller::new(Profile::default()));
    println!("{differences:?}");
    play(&replay);
    for (name, tool, bytes) in FILES {
        plan(name, tool, bytes)?;
    }
    Ok(())
}

/// Prints every reply and pose.
fn play(replay: &Replay<'_>) {
    let mut arm = Controller::new(Profile::default());
    let packets = replay.packets();
    let begin = packets.first().map_or(0, |packet| packet.time);
    let link = LinkId(0);
    for packet in packets {
        if packet.direction != Some(Direction::Request) {
            continue;
        }
        arm.advance(ArmInstant::from_micros(packet.time - begin));
        for answer in arm.exchange(link, packet.bytes) {
            println!("{} {}", arm.now().as_micros(), hex(answer.bytes()));
        }
        let pose = arm.state().pose.to_array().map(f64::to_bits);
        println!("{} {pose:x?}", arm.now().as_micros());
    }
}

/// Plans, checks and rehearses a file. Prints every command, the report and the drawing of the
/// virtual arm.
fn plan(name: &str, tool: Tool, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let format = Format::of(name, bytes).ok_or("unrecognised file type")?;
    let reading = read(format, bytes, &ReadOptions::default())?;
    let mut setup = Setup::default();
    setup.tool = Some(tool);
    setup.surface = Some(Surface::level(-60.0));
    setup.placement.at = Some([240.0, 0.0]);
    let plan = setup.plan(format, reading.content)?.plan;
    println!("{name}");
    for command in plan.commands() {
        println!("{command:?}");
    }
    let report = check(&plan, &Preflight::at(JointAngles::HOME, ToolBias::SUCTION));
    println!(
        "{:?} {:?} {:x}",
        report.time,
        report.refused_steps.len(),
        report.drawn.to_bits()
    );
    let rehearsal = rehearse(&plan, &RehearseOptions::default())?;
    println!(
        "{}",
        drawing_svg(&rehearsal.drawing, &DrawingOptions::default())
    );
    Ok(())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
