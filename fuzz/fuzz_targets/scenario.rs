#![no_main]
//! Scenario file of arbitrary bytes: refused with a place in the file, or a world in which an arm
//! runs for a while.

use libfuzzer_sys::fuzz_target;
use magician_protocol::{Ctrl, FrameBuf};
use magician_sim::{Controller, LinkId, Profile, Scenario, World};

/// Host that uses everything a scenario can have: the belt, the sensors, the tools, and moves.
fn host(arm: &mut Controller) {
    let mut order = |id, ctrl, params: &[u8]| {
        let frame = FrameBuf::new(id, ctrl, params).expect("it is short");
        arm.exchange(LinkId(0), frame.bytes());
    };
    order(240, Ctrl::SET, &[]);
    order(135, Ctrl::SET, &[0, 1, 0x10, 0x27, 0, 0]);
    for port in 0..4 {
        order(137, Ctrl::SET, &[1, port, 1]);
        order(138, Ctrl::SET, &[1, port, 1]);
        order(137, Ctrl::GET, &[port]);
        order(138, Ctrl::GET, &[port]);
    }
    for (tool, to) in [
        (62, [220.0, 0.0, -60.0, 0.0]),
        (63, [200.0, 60.0, 20.0, 0.0]),
    ] {
        let to: [f32; 4] = to;
        let to = [&[2][..], to.map(f32::to_le_bytes).as_flattened()].concat();
        order(84, Ctrl::QUEUED, &to);
        order(tool, Ctrl::QUEUED, &[1, 1]);
    }
}

fuzz_target!(|data: &[u8]| {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    let scenario = match Scenario::from_toml(text) {
        Ok(scenario) => scenario,
        Err(error) => {
            assert!(!error.message.is_empty() && !error.message.contains('\n'));
            let line = text
                .split('\n')
                .nth(error.line - 1)
                .expect("there is such a line");
            assert!(
                (1..=line.chars().count() + 1).contains(&error.column),
                "{error}"
            );
            return;
        }
    };
    let mut arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    host(&mut arm);
    for _ in 0..200 {
        let Some(next) = arm.poll_timeout() else {
            break;
        };
        arm.advance(next);
        while arm.poll_event().is_some() {}
    }
    let look = arm.look();
    let objects = look.objects().map(|object| object.place());
    assert!(
        objects
            .into_iter()
            .all(|at| [at.x, at.y, at.z, at.yaw].iter().all(|x| x.is_finite()))
    );
    let _ = magician_picture::drawing_svg(&arm.drawing(), &Default::default());
});
