//! What a network may double.

use super::rig::{START, burnt, increment, jump, laser, segment, wait};
use crate::stream::item::Entry;

#[test]
fn only_what_leads_to_a_place_of_its_own_bears_doubling() {
    let [x, y, z] = START;
    let there = [x, y + 10.0, z];
    for (item, bears) in [
        (segment(there, 1000), true),
        (jump(there, 1000), true),
        (increment(START, [0.0, 10.0, 0.0], 1000), false),
        (wait(100, there), false),
        (laser(true, there), false),
        // Burnt twice is burnt too much.
        (burnt(there, 1000), false),
    ] {
        let command = item.command;
        assert_eq!(
            Entry::new(item, false).bears_doubling(),
            bears,
            "{command:?}"
        );
    }
    // What sets something is no motion, but a dark one under a laser that is lit burns.
    assert!(!Entry::new(segment(there, 1000), true).bears_doubling());
}
