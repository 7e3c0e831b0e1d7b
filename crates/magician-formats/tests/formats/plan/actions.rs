//! Commands and actions convert into each other without loss.

use magician_formats::Action;
use magician_protocol::{MAX_PARAMS, Set, Writer};
use proptest::prelude::*;

use super::strategies::{action, any_set, cases};

fn bytes(command: &Set) -> Vec<u8> {
    let mut room = [0; MAX_PARAMS];
    let mut writer = Writer::new(&mut room);
    command.encode(&mut writer);
    let count = writer.finish().unwrap();
    room[..count].to_vec()
}

proptest! {
    #![proptest_config(cases(600))]

    #[test]
    fn command_round_trips_through_its_action_bit_for_bit(command in any_set()) {
        let back = Action::from(command).command().expect("it has one");
        prop_assert_eq!(back.row().id, command.row().id);
        prop_assert_eq!(bytes(&back), bytes(&command));
    }

    #[test]
    fn action_round_trips_through_its_command(action in action()) {
        // Compared as text, because NaN then equals itself and -0 differs from 0.
        let back = Action::from(action.command().expect("it has one"));
        prop_assert_eq!(format!("{back:?}"), format!("{action:?}"));
    }
}

#[test]
fn lossy_named_action_stays_a_raw_command() {
    use magician_protocol::commands::{CpCmd, SetEndEffectorSuctionCup};
    use magician_protocol::{CpMode, Flag};
    let minus_zero = CpCmd {
        cp_mode: CpMode::Absolute,
        x: 1.0,
        y: 2.0,
        z: 3.0,
        velocity_or_power: -0.0,
    };
    let odd_flag = SetEndEffectorSuctionCup {
        enable_ctrl: Flag(7),
        suck: Flag::ON,
    };
    let not_a_number = CpCmd {
        x: f32::NAN,
        velocity_or_power: 0.0,
        ..minus_zero
    };
    for command in [Set::from(minus_zero), odd_flag.into(), not_a_number.into()] {
        assert!(
            matches!(Action::from(command), Action::Command(_)),
            "{command:?}"
        );
    }
    let plain = CpCmd {
        velocity_or_power: 0.0,
        ..minus_zero
    };
    assert_eq!(
        Action::from(Set::from(plain)),
        Action::Path {
            to: [1.0, 2.0, 3.0]
        }
    );
}
