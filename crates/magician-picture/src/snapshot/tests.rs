//! Tests of snapshots.

use super::*;
use magician_sim::{Profile, Scenario, World};

#[test]
fn snapshot_labels_objects_by_name() {
    let scenario = Scenario::from_toml(
        r##"
        title = "A <cell>"
        tool = { kind = "suction" }
        table = { height = -60 }
        object = [{ name = "red & round", size = [20, 20, 20], at = [220, 80], color = "#ff0102" }]
        conveyor = { start = [200, -200], direction = 90, length = 200, width = 60, height = -40, stepper = 0 }
        "##,
    )
    .unwrap();
    let arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    let snapshot = Snapshot::of_world(&arm);
    let svg = snapshot.to_svg();
    for wanted in [
        "A &lt;cell&gt;",
        "red &amp; round",
        "#ff0102",
        "J1 0",
        "alarm 0x00",
    ] {
        assert!(svg.contains(wanted), "{wanted}");
    }
}

#[test]
fn arm_is_drawn_at_its_joint_angles() {
    let mut view = ArmView::default();
    (view.title, view.joints) = ("arm".to_owned(), JointAngles::HOME);
    view.tool = ToolBias::SUCTION;
    let svg = Snapshot::of_arm(&view).to_svg().to_owned();
    assert!(svg.contains("x 259.1  y 0  z −8.5  r 0"), "{svg}");
    view.joints.j1 = 90.0;
    assert!(Snapshot::of_arm(&view).to_svg().contains("x 0  y 259.1"));
}

#[test]
fn names_of_stacked_objects_are_listed_vertically() {
    let scenario = Scenario::from_toml(
        r#"
        tool = { kind = "suction" }
        table = { height = -60 }
        object = [
            { name = "lower", size = [20, 20, 20], at = [220, 80], color = "red" },
            { name = "upper", size = [20, 20, 20], at = [220, 80], on = "lower", color = "blue" },
            { name = "apart", size = [20, 20, 20], at = [220, -80], color = "blue" },
        ]
        "#,
    )
    .unwrap();
    let arm = Controller::in_world(Profile::default(), World::from_scenario(&scenario));
    let svg = Snapshot::of_world(&arm).to_svg().to_owned();
    let line = |name: &str| -> f64 {
        let text = svg.split(&format!(">{name}<")).next().unwrap();
        let y = text.rsplit(" y=\"").next().unwrap();
        y.split('"').next().unwrap().parse().unwrap()
    };
    assert!(line("upper") - line("lower") >= 2.8, "{svg}");
    assert_eq!(line("apart") - line("lower"), 160.0 * SCALE);
}
