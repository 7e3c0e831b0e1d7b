//! Tests of reading G-code as plans.

mod cycles;
mod full_power;
mod interpreter;
mod power;
mod reading;
mod samples;
mod servo;
mod words;

use magician_formats::Action;

use reading::*;

fn burn(x: f32, y: f32, z: f32, power: f32) -> Action {
    let to = [x, y, z];
    Action::Burn { to, power }
}

fn arc(via: [f32; 3], to: [f32; 3]) -> Action {
    let pose = |[x, y, z]: [f32; 3]| [x, y, z, 0.0];
    let (via, to) = (pose(via), pose(to));
    Action::Arc { via, to }
}
