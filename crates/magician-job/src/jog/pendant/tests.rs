//! Tests of the pendant's controls and orders.

use super::*;
use crate::jog::OrderError;

const NOW: Duration = Duration::ZERO;
const X: JogDirection = JogDirection {
    axis: Axis::X,
    forward: true,
};

fn pendant() -> Pendant {
    Pendant::new(50.0, ToolState::default(), false)
}

fn done(pendant: &mut Pendant, activity: Activity) {
    let outcome = Ok(());
    pendant.done(&OrderDone { activity, outcome });
}

#[test]
fn steps_have_the_selected_length_and_run_in_sequence() {
    let mut pendant = pendant();
    let mut lengths = vec![pendant.step];
    (0..5).for_each(|_| pendant.longer_step());
    lengths.push(pendant.step);
    (0..9).for_each(|_| pendant.shorter_step());
    lengths.push(pendant.step);
    assert_eq!(lengths, [5.0, 50.0, 0.1]);
    let step = PendantOrder::Step {
        direction: X,
        length: 0.1,
        burning: false,
    };
    assert_eq!(pendant.press(X, NOW), Some(step.clone()));
    assert_eq!(pendant.repeat(X, NOW), Some(step));
    pendant.activity = Some(Activity::Step(X));
    assert_eq!(pendant.press(X, NOW), None);
    assert!(pendant.moves(Axis::X) && !pendant.moves(Axis::Y));
}

#[test]
fn speed_moves_to_the_neighbouring_list_entry() {
    let mut pendant = Pendant::new(42.0, ToolState::default(), false);
    let speeds = [pendant.faster(), pendant.slower()];
    assert_eq!(
        speeds,
        [PendantOrder::Speed(50.0), PendantOrder::Speed(30.0)]
    );
    done(&mut pendant, Activity::Speed(100.0));
    assert_eq!(pendant.faster(), PendantOrder::Speed(100.0));
}

#[test]
fn held_jog_ends_on_frame_change_mode_change_or_refusal() {
    type Change = fn(&mut Pendant) -> Option<PendantOrder>;
    let changes: [Change; 3] = [
        |pendant| pendant.set_frame(JogFrame::Joints),
        |pendant| pendant.set_mode(JogMode::Step),
        Pendant::release_all,
    ];
    for change in changes {
        let mut pendant = pendant();
        assert_eq!(pendant.set_mode(JogMode::Hold), None);
        assert!(matches!(
            pendant.press(X, NOW),
            Some(PendantOrder::Jog { .. })
        ));
        assert_eq!(change(&mut pendant), Some(PendantOrder::EndJog));
        assert_eq!(change(&mut pendant), None);
    }
    let mut pendant = pendant();
    pendant.set_mode(JogMode::Hold);
    pendant.press(X, NOW);
    let (activity, outcome) = (Activity::Jog(X), Err(OrderError::Busy));
    pendant.done(&OrderDone { activity, outcome });
    assert_eq!(pendant.hold.direction(), None);
}

#[test]
fn tool_state_follows_confirmed_orders() {
    let mut pendant = pendant();
    let PendantOrder::Tool(suction) = pendant.toggle_suction() else {
        panic!("no tool");
    };
    assert!(!pendant.tools.suction);
    done(&mut pendant, Activity::Tool(suction));
    assert!(pendant.tools.suction);
    let mut grips = Vec::new();
    for _ in 0..3 {
        let PendantOrder::Tool(grip) = pendant.next_gripper() else {
            panic!("no tool");
        };
        done(&mut pendant, Activity::Tool(grip));
        assert!(!pendant.tools.suction, "one pump is for both");
        grips.push(pendant.tools.gripper);
    }
    assert_eq!(grips, [Grip::Close, Grip::Open, Grip::Off]);
}

#[test]
fn laser_may_burn_from_its_order_until_confirmed_off() {
    let mut pendant = pendant();
    let laser = |on| Activity::Tool(ToolOrder::Laser(on));
    pendant.laser(true);
    assert!(pendant.may_burn() && !pendant.tools.laser);
    // The reply of another tool says nothing about the laser.
    done(&mut pendant, Activity::Tool(ToolOrder::Suction(true)));
    assert!(pendant.may_burn() && !pendant.tools.laser);
    done(&mut pendant, laser(true));
    assert!(pendant.tools.laser);
    pendant.laser(false);
    assert!(pendant.may_burn(), "not dark yet");
    done(&mut pendant, laser(false));
    assert!(!pendant.may_burn());
    pendant.laser(true);
    let (activity, outcome) = (laser(true), Err(OrderError::Busy));
    pendant.done(&OrderDone { activity, outcome });
    assert!(!pendant.may_burn(), "refused");
    pendant.laser(true);
    assert_eq!(pendant.stop(), PendantOrder::Stop);
    assert!(!pendant.may_burn());
}
