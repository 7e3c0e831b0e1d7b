use magician_program::formats::playback::Playback;
use magician_program::{Action, Format, Grip, Tool, Travel};

use crate::machine::{plan, run, sample};

const NAMES: [&str; 4] = [
    "arc_movl_v1412",
    "gripper_pick_v194",
    "jump_suction_named_v170",
    "suction_points_v194",
];

#[test]
fn x() {
    for name in NAMES {
        let bytes = sample(&format!("{name}.playback"));
        let (plan, notes) = plan(Format::Playback, &bytes);
        println!("{name} {:?} {notes:#?}", plan.tool);
        for step in &plan.steps {
            println!(
                "{:?} {:?} {:?}",
                step.action,
                step.origin,
                plan.name_of(&step.origin)
            );
        }
        println!("{:?}", run(&plan, Tool::Suction));
        let doc = Playback::read(&bytes).unwrap();
        assert_eq!(doc.to_xml().as_bytes(), bytes);
    }
}
