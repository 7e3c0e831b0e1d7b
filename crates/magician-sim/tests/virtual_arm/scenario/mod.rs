//! Scenario files: valid ones, invalid ones with their position, and the schema for editors.

mod manual;
mod refusals;
mod schema;

use magician_sim::scenario::{On, Scenario, SensorKind, ToolKind};

/// Every example beside the schema.
const EXAMPLES: [(&str, &str); 5] = Scenario::BUILT_IN;

#[test]
fn every_example_is_a_scenario() {
    for (name, text) in EXAMPLES {
        if let Err(error) = Scenario::from_toml(text) {
            panic!("{name}.toml: {error}");
        }
    }
}

#[test]
fn an_empty_file_is_an_empty_world() {
    assert_eq!(Scenario::from_toml("").unwrap(), Scenario::default());
}

#[test]
fn a_scenario_says_what_stands_where() {
    let scenario = Scenario::from_toml(EXAMPLES[2].1).unwrap();
    assert_eq!(scenario.title(), Some("Pick and sort"));
    assert_eq!(scenario.tool().kind, ToolKind::Suction);
    let belt = scenario.conveyor().unwrap();
    assert!((belt.mm_per_pulse() - std::f64::consts::PI * 34.0 / 16_000.0).abs() < 1e-15);
    let names: Vec<_> = scenario
        .objects()
        .iter()
        .map(|object| object.name.as_str())
        .collect();
    assert_eq!(names, ["red cube", "green cube", "blue cube"]);
    assert!(
        scenario
            .objects()
            .iter()
            .all(|object| object.on == On::Belt && object.place.z == -30.0)
    );

    // Across the belt, 310 mm from its start and 5 mm above it.
    let barrier = &scenario.sensors()[0];
    assert_eq!(barrier.kind, SensorKind::Infrared);
    assert_eq!(barrier.beam.from, [300.0, 10.0, -25.0]);
    assert_eq!(barrier.beam.to, [220.0, 10.0, -25.0]);
}

#[test]
fn objects_stand_on_one_another() {
    let scenario = Scenario::from_toml(
        r##"
        [table]
        height = -60
        [[object]]
        name = "a"
        size = [30, 30, 10]
        at = [200, 0]
        color = "#0a0b0c"
        [[object]]
        name = "b"
        size = [20, 20, 5]
        at = [205, 3]
        on = "a"
        color = [1, 2, 3]
        "##,
    )
    .unwrap();
    let [a, b] = scenario.objects() else {
        panic!("two objects")
    };
    assert_eq!((a.place.z, b.place.z), (-60.0, -50.0));
    assert_eq!((a.color.0, b.color.0), ([10, 11, 12], [1, 2, 3]));
    assert_eq!(b.on, On::Object(0));
}
