use super::*;
use magician_sim::{Profile, Scenario, World};

#[test]
fn a_world_shows_its_objects_by_name() {
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
fn an_arm_alone_stands_where_its_joints_say() {
    let mut view = ArmView::default();
    (view.title, view.joints) = ("arm".to_owned(), JointAngles::HOME);
    view.tool = ToolBias::SUCTION;
    let svg = Snapshot::of_arm(&view).to_svg().to_owned();
    assert!(svg.contains("x 259.1  y 0  z −8.5  r 0"), "{svg}");
    view.joints.j1 = 90.0;
    assert!(Snapshot::of_arm(&view).to_svg().contains("x 0  y 259.1"));
}
