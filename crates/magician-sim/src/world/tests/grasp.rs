//! Picking, carrying and releasing objects.

use super::{Arm, SECOND, near};
use crate::world::{GripCount, Support, WorldEvent, WorldEventKind};

const TABLE: &str = r#"
[table]
height = -70
[[object]]
name = "red"
size = [20, 20, 20]
at = [200, 50]
[[object]]
name = "blue"
size = [30, 24, 10]
at = [220, -50]
yaw = 30
"#;

fn arm(tool: &str) -> Arm {
    let text = format!("[tool]\nkind = \"{tool}\"\n{TABLE}");
    Arm::new(&text, [200.0, 50.0, 0.0, 0.0])
}

fn events(arm: &mut Arm) -> Vec<WorldEventKind> {
    std::iter::from_fn(|| arm.world.poll_event())
        .map(|WorldEvent { kind, .. }| kind)
        .collect()
}

#[test]
fn a_cube_is_picked_carried_and_put_on_another() {
    let mut arm = arm("suction");
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    arm.suck(true);
    assert!(arm.world.holding() && arm.look().object("red").unwrap().is_held());
    let count = GripCount { begun: 1, taken: 1 };
    assert_eq!(arm.look().grip_count(), count);
    arm.go([200.0, 50.0, 0.0, 0.0], SECOND);
    assert!(near(arm.look().object("red").unwrap().place().z, -20.0));
    arm.go([220.0, -50.0, 0.0, 45.0], SECOND);
    arm.go([220.0, -50.0, -38.0, 45.0], SECOND);
    arm.suck(false);
    assert!(!arm.world.holding());
    let look = arm.look();
    let red = look.object("red").unwrap();
    let place = red.place();
    assert!(red.on("blue") && !red.on_table());
    assert!(
        near(place.x, 220.0) && near(place.y, -50.0) && near(place.z, -60.0),
        "{place:?}"
    );
    assert!(near(place.yaw, 45.0));
    assert_eq!(
        events(&mut arm),
        [
            WorldEventKind::Picked(0),
            WorldEventKind::Released(0, Support::Object(1))
        ]
    );
}

#[test]
fn grip_of_nothing_is_counted_and_takes_nothing() {
    let mut arm = arm("suction");
    arm.suck(true);
    arm.go([260.0, 0.0, 0.0, 0.0], SECOND);
    arm.suck(false);
    arm.suck(true);
    let count = GripCount { begun: 2, taken: 0 };
    assert_eq!(arm.look().grip_count(), count);
    // A cup that already sucks takes the object that it is put on; no new grip begins.
    arm.go([200.0, 50.0, 0.0, 0.0], SECOND);
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    let count = GripCount { begun: 2, taken: 1 };
    assert_eq!(arm.look().grip_count(), count);
}

#[test]
fn a_stack_is_carried_as_one() {
    let mut arm = arm("suction");
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    arm.suck(true);
    arm.go([200.0, 50.0, 0.0, 0.0], SECOND);
    arm.go([210.0, -50.0, -40.0, 0.0], SECOND);
    arm.suck(false);
    // Takes the blue cube at a point beside the red one, which stands on it.
    arm.go([229.0, -46.0, 0.0, 0.0], SECOND);
    arm.go([229.0, -46.0, -60.0, 0.0], SECOND);
    arm.suck(true);
    let look = arm.look();
    assert_eq!(look.held().unwrap().name(), "blue");
    arm.go([229.0, 50.0, -20.0, 90.0], SECOND);
    let look = arm.look();
    let (red, blue) = (look.object("red").unwrap(), look.object("blue").unwrap());
    assert!(blue.is_held() && red.on("blue"));
    // The red cube was at (-10, 0) from the middle of the blue one; turned by 90 degrees it is at
    // (0, -10).
    let between = [
        red.place().x - blue.place().x,
        red.place().y - blue.place().y,
    ];
    assert!(
        near(between[0], 0.0) && near(between[1], -10.0),
        "{between:?}"
    );
    assert!(near(red.place().z, blue.place().z + 10.0));
}

#[test]
fn what_is_let_go_falls_straight_down() {
    let mut arm = arm("suction");
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    arm.suck(true);
    arm.go([240.0, 90.0, 20.0, 0.0], SECOND);
    arm.suck(false);
    let look = arm.look();
    let red = look.object("red").unwrap();
    assert!(red.on_table());
    assert!(near(red.place().x, 240.0) && near(red.place().z, -70.0));
}

#[test]
fn the_cup_takes_only_what_it_is_on() {
    for (at, held) in [
        ([200.0, 50.0, -50.0], Some("red")),
        ([209.9, 59.9, -50.0], Some("red")),
        ([210.1, 50.0, -50.0], None),
        ([200.0, 50.0, -49.1], Some("red")),
        ([200.0, 50.0, -48.9], None),
        // Pressed down by almost as much as the cup gives way, then by more.
        ([200.0, 50.0, -54.9], Some("red")),
        ([200.0, 50.0, -55.1], None),
        // The blue cube is turned: its corner is at (227.0, -32.1), further out than any side.
        ([227.0, -33.0, -60.0], Some("blue")),
        ([234.0, -39.0, -60.0], None),
    ] {
        let mut arm = arm("suction");
        let [x, y, z] = at;
        arm.go([x, y, z, 0.0], SECOND);
        arm.suck(true);
        assert_eq!(
            arm.look().held().map(|object| object.name()),
            held,
            "{at:?}"
        );
    }
}

#[test]
fn a_cup_that_sucks_already_takes_what_it_comes_down_on() {
    let mut arm = arm("suction");
    arm.suck(true);
    assert!(!arm.world.holding());
    arm.go([200.0, 50.0, -40.0, 0.0], SECOND);
    assert!(!arm.world.holding());
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    assert!(arm.world.holding());
}

#[test]
fn the_gripper_takes_what_fits_between_its_fingers() {
    for (at, held) in [
        ([200.0, 50.0, -60.0, 0.0], true),
        // Turned: the diagonal is 28.3 mm wide, the gripper opens 27.5 mm.
        ([200.0, 50.0, -60.0, 45.0], false),
        // Further aside than there is room.
        ([200.0, 54.0, -60.0, 0.0], false),
        ([200.0, 53.0, -60.0, 0.0], true),
        // Too high; then as low as possible, with the palm just above the cube.
        ([200.0, 50.0, -51.0, 0.0], false),
        ([200.0, 50.0, -69.9, 0.0], true),
    ] {
        let mut arm = arm("gripper");
        let [x, y, _, r] = at;
        arm.go([x, y, 0.0, r], SECOND);
        arm.go(at, SECOND);
        arm.close(true);
        assert_eq!(arm.world.holding(), held, "{at:?}");
    }
}

#[test]
fn the_gripper_lets_go_when_it_opens() {
    let mut arm = arm("gripper");
    arm.go([200.0, 50.0, -62.0, 0.0], SECOND);
    arm.close(true);
    arm.go([200.0, 50.0, -22.0, 0.0], SECOND);
    assert!(near(arm.look().object("red").unwrap().place().z, -30.0));
    arm.close(false);
    assert!(arm.look().object("red").unwrap().on_table());
}

#[test]
fn a_pen_takes_nothing() {
    let mut arm = arm("pen");
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    arm.suck(true);
    arm.close(true);
    assert!(!arm.world.holding());
}

#[test]
fn the_rail_carries_the_arm_and_what_it_holds() {
    let mut arm = arm("suction");
    arm.go([200.0, 50.0, -50.0, 0.0], SECOND);
    arm.suck(true);
    let mut joint_state = arm.joint_state(&arm.at);
    joint_state.rail = 300.0;
    let look = arm.world.look(arm.now, &joint_state);
    assert!(near(look.object("red").unwrap().place().y, 350.0));
}

#[test]
fn the_same_is_told_twice_alike() {
    let run = || {
        let mut arm = arm("suction");
        arm.suck(true);
        arm.go([200.0, 50.0, -50.0, 0.0], 777_777);
        arm.go([231.0, -41.0, 3.0, 17.0], 999_999);
        arm.suck(false);
        let places: Vec<_> = arm.look().objects().map(|object| object.place()).collect();
        (format!("{places:?}"), arm.happened)
    };
    assert_eq!(run(), run());
}

#[test]
fn the_palm_keeps_the_gripper_from_reaching_down_too_far() {
    let text = "[tool]\nkind = \"gripper\"\n[table]\nheight = -70\n\
        [[object]]\nname = \"tower\"\nsize = [20, 20, 40]\nat = [200, 50]\n";
    for (z, held) in [(-50.9, true), (-51.1, false)] {
        let mut arm = Arm::new(text, [200.0, 50.0, z, 0.0]);
        arm.close(true);
        assert_eq!(arm.world.holding(), held, "{z}");
    }
}

#[test]
fn a_thin_stack_does_not_fall_on_itself() {
    let text = "[tool]\nkind = \"suction\"\n[table]\nheight = -70\n\
        [[object]]\nname = \"plate\"\nsize = [40, 40, 1]\nat = [200, 50]\n\
        [[object]]\nname = \"sheet\"\nsize = [10, 10, 1]\nat = [200, 50]\non = \"plate\"\n";
    let mut arm = Arm::new(text, [215.0, 50.0, -69.0, 0.0]);
    arm.suck(true);
    arm.go([220.0, 50.0, -40.0, 0.0], SECOND);
    arm.go([200.0, 60.0, -67.0, 0.0], SECOND);
    arm.suck(false);
    let look = arm.look();
    assert!(look.object("plate").unwrap().on_table());
    assert!(look.object("sheet").unwrap().on("plate"));
}

#[test]
fn a_held_cube_is_seen_where_there_is_nothing_to_touch() {
    let text = "[tool]\nkind = \"suction\"\n\
        [[sensor]]\nkind = \"infrared\"\nport = \"GP4\"\nat = [200, 100, -20]\nfacing = 180\nrange = 50\n\
        [[object]]\nname = \"cube\"\nsize = [20, 20, 20]\nat = [200, 0]\nz = -30\n";
    let mut arm = Arm::new(text, [200.0, 0.0, -10.0, 0.0]);
    arm.suck(true);
    arm.happened.clear();
    arm.go([200.0, 120.0, -10.0, 0.0], SECOND);
    let times: Vec<_> = arm.happened.iter().map(|(at, _)| *at).collect();
    assert!(
        times.len() == 2 && times[0].abs_diff(750_000) <= 1 && times[1].abs_diff(916_667) <= 1,
        "{times:?}"
    );
}
