//! Commands that a network may duplicate.

use super::rig::{Rig, SECOND, START, burnt, increment, jump, laser, path, segment, wait};
use crate::connection::Settings;
use crate::stream::item::Entry;
use crate::stream::{Stream, StreamSettings};

#[test]
fn only_absolute_targets_may_be_executed_twice() {
    let [x, y, z] = START;
    let there = [x, y + 10.0, z];
    for (item, bears) in [
        (segment(there, 1000), true),
        (jump(there, 1000), true),
        (increment(START, [0.0, 10.0, 0.0], 1000), false),
        (wait(100, there), false),
        (laser(true, there), false),
        // Burning twice is burning too much.
        (burnt(there, 1000), false),
    ] {
        let command = item.command;
        assert_eq!(
            Entry::new(item, false).tolerates_duplicate(),
            bears,
            "{command:?}"
        );
    }
    // Even a segment without power burns while the switched laser is lit.
    assert!(!Entry::new(segment(there, 1000), true).tolerates_duplicate());
}

#[test]
fn leftover_is_sorted_by_index_after_a_duplicated_command() {
    for taken in [1, 2, 7] {
        let program = path(taken, 1.5, SECOND / 4);
        let settings = StreamSettings {
            start: false,
            ..StreamSettings::default()
        };
        let mut rig = Rig::new(Settings::ORDERED, settings, &program);
        while rig.reported_accepted < taken as u64 {
            rig.turn(SECOND);
        }
        let next = rig.stream.last_index().unwrap() + 1;
        assert!(rig.stream.note_duplicate(next, next));
        let stream = std::mem::replace(&mut rig.stream, Stream::new(settings));
        let leftover = stream.leftover();
        let indices: Vec<_> = leftover.items().map(|(index, _)| index).collect();
        assert_eq!(indices, (2..=next).map(Some).collect::<Vec<_>>());
    }
}
