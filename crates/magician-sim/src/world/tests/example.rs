//! The pick-and-sort example, driven by direct calls as a program would over the protocol.

use magician_protocol::Port;

use super::{Arm, SECOND};

#[test]
fn the_cubes_are_sorted_by_colour() {
    let mut arm = Arm::new(
        include_str!("../../../scenarios/pick_and_sort.toml"),
        [260.0, 0.0, 30.0, 0.0],
    );
    let speed = |mm: f64| mm * 16_000.0 / (std::f64::consts::PI * 34.0);
    for (name, at_end) in [
        ("red cube", false),
        ("green cube", false),
        ("blue cube", true),
    ] {
        assert!(arm.look().object(name).unwrap().on_belt(), "{name}");
        arm.world.stepper(arm.now, 0, speed(50.0));
        while !arm.world.infrared(arm.now, Port::Gp2) {
            let next = arm.world.next_event().expect("a cube comes");
            arm.wait_until(next);
        }
        arm.world.stepper(arm.now, 0, 0.0);

        // The front of the object has reached y = 10.
        arm.go([260.0, 0.0, -10.0, 0.0], SECOND);
        arm.suck(true);
        assert_eq!(arm.look().held().map(|object| object.name()), Some(name));
        arm.go([260.0, 0.0, 30.0, 0.0], SECOND);
        arm.go([160.0, 180.0, 30.0, 0.0], SECOND);
        arm.go([160.0, 180.0, -10.0, 0.0], SECOND);
        let [r, g, b] = arm.world.color(arm.now, Port::Gp1);
        let bin = match name {
            "red cube" => 200.0,
            "green cube" => 230.0,
            _ => 250.0,
        };
        let told = [("red cube", r), ("green cube", g), ("blue cube", b)];
        assert!(
            told.iter()
                .all(|(other, byte)| (*byte == 255) == (*other == name)),
            "{told:?}"
        );

        arm.go([160.0, 180.0, 30.0, 0.0], SECOND);
        arm.go([bin - 60.0, -200.0, 30.0, 0.0], SECOND);
        arm.go([bin - 60.0, -200.0, -50.0, 0.0], SECOND);
        arm.suck(false);
        let look = arm.look();
        let cube = look.object(name).unwrap();
        assert!(
            cube.on_table() && !cube.on_belt() && cube.seen_by(Port::Gp1),
            "{name}"
        );
        assert_eq!(look.objects().any(|object| object.on_belt()), !at_end);
        arm.go([bin - 60.0, -200.0, 30.0, 0.0], SECOND);
        arm.go([260.0, 0.0, 30.0, 0.0], SECOND);
    }
    assert!(arm.touches().is_empty(), "{:?}", arm.touches());
}
