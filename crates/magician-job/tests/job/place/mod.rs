//! Programs, and virtual arms at real speed on the test's clock.
#![allow(dead_code, reason = "each test uses what it needs")]

use magician::commands::PtpCmd;
use magician::sim::world::Drawing;
use magician::{Arm, Options, SimSpeed, VirtualArm, build};
use magician_program::rehearse::{RehearseOptions, stage};
use magician_program::{Action, Origin, Plan, Program, Surface, Tool, Travel};
use magician_protocol::PtpMode;

pub(crate) const PAPER: f64 = -60.0;
pub(crate) const UP: f32 = -45.0;

/// Kind of motion that draws.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// Continuous paths: long ones, and a bend of short ones.
    Paths,
    /// Straight lines, point by point.
    Lines,
    /// Arcs.
    Arcs,
    /// Dots that the arm jumps between.
    Jumps,
}

pub(crate) const KINDS: [Kind; 4] = [Kind::Paths, Kind::Lines, Kind::Arcs, Kind::Jumps];

fn corners() -> Vec<[f64; 2]> {
    let mut points = vec![[205.0, -30.0], [235.0, -30.0], [235.0, -12.0]];
    let bend = (1..=60).map(|nth| {
        let turned = f64::from(nth) * 3.0_f64.to_radians();
        [
            235.0 + 8.0 * (1.0 - turned.cos()),
            -12.0 + 8.0 * turned.sin(),
        ]
    });
    points.extend(bend);
    points.push([251.0, -30.0]);
    points
}

pub(crate) fn plan(kind: Kind) -> Plan {
    let mut plan = Plan::new("a drawing");
    plan.tool = Some(Tool::Pen);
    plan.surface = Some(Surface::level(PAPER));
    let paper = PAPER as f32;
    let at = |[x, y]: [f64; 2], z: f32| [x as f32, y as f32, z, 0.0];
    let line = |to| Action::Move {
        to,
        by: Travel::Line,
    };
    let corners = corners();
    let mut push = |action: Action| plan.push(action, Origin::NONE);
    push(build::path_speed(40.0, 100.0).into());
    push(build::speed(35.0, 60.0).into());
    match kind {
        Kind::Paths | Kind::Lines => {
            let last = corners[corners.len() - 1];
            push(line(at(corners[0], UP)));
            push(line(at(corners[0], paper)));
            for corner in &corners[1..] {
                let [x, y, ..] = at(*corner, paper);
                push(match kind {
                    Kind::Paths => Action::Path { to: [x, y, paper] },
                    _ => line(at(*corner, paper)),
                });
            }
            push(line(at(last, UP)));
        }
        Kind::Arcs => {
            push(line(at([205.0, -20.0], UP)));
            push(line(at([205.0, -20.0], paper)));
            for y in [0.0, 20.0] {
                let via = at([215.0, y - 10.0], paper);
                push(build::arc_to(via, at([205.0, y], paper)).into());
            }
            push(line(at([205.0, 20.0], UP)));
        }
        Kind::Jumps => {
            push(build::jump_height(12.0, 0.0).into());
            for nth in 0..5 {
                let [x, y, z, r] = at([205.0, -20.0 + 10.0 * f64::from(nth)], paper);
                let jump = PtpCmd {
                    ptp_mode: PtpMode::JumpXyz,
                    x,
                    y,
                    z,
                    r,
                };
                push(magician::Set::from(jump).into());
                push(Action::Shift {
                    by: [4.0, 0.0, 0.0, 0.0],
                    line: true,
                });
            }
            push(line(at([209.0, 20.0], UP)));
        }
    }
    plan
}

pub(crate) fn program(kind: Kind, iterations: u64) -> Program {
    Program::new(plan(kind), Some(iterations))
}

/// An arm that can run this program.
pub(crate) async fn place(program: &Program) -> (VirtualArm, Arm) {
    let arm = stage(program.plan(), &RehearseOptions::default()).expect("a stage");
    let cell = VirtualArm::new(arm, SimSpeed::Times(1.0)).with_breaking_lines();
    let arm = Arm::simulated(cell.clone(), Options::default()).await;
    (cell, arm.expect("a virtual arm"))
}

/// The ink and its length, mm.
pub(crate) fn ink(cell: &VirtualArm) -> (Drawing, f64) {
    let drawing = cell.with(|arm| arm.drawing());
    let length = |points: &Vec<[f64; 2]>| -> f64 {
        let pairs = points.windows(2);
        pairs
            .map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]))
            .sum()
    };
    let all = drawing
        .strokes()
        .iter()
        .map(|stroke| length(&stroke.points))
        .sum();
    (drawing, all)
}
