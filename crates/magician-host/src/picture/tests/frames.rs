//! Settings, tested on frames alone.

use magician_protocol::commands::{
    EndEffectorLaser, IoMultiplexing, PtpCommonParams, PtpJump2Params, PtpJumpParams,
    QueuedCmdCurrentIndex, QueuedCmdStartExec,
};
use magician_protocol::{Ctrl, Flag, FrameBuf, NoArgs, Readable, Set};

use crate::build;
use crate::picture::{ArmPicture, Origin, settings};

const JUMP: PtpJumpParams = PtpJumpParams {
    jump_height: 20.0,
    z_limit: 100.0,
};

#[derive(Default)]
struct Rig(ArmPicture);

impl Rig {
    fn answer(&mut self, request: FrameBuf, params: &[u8]) {
        let request = request.frame();
        let reply = FrameBuf::new(request.id(), request.ctrl(), params).unwrap();
        self.0.sent(6, &request);
        self.0.answered(7, Origin::Caller, &request, &reply.frame());
    }

    fn sets(&mut self, command: impl Into<Set>) {
        let request = FrameBuf::set(&command.into(), Ctrl::SET).unwrap();
        self.answer(request, &[]);
    }

    fn queues(&mut self, index: u64, command: impl Into<Set>) {
        let request = FrameBuf::set(&command.into(), Ctrl::QUEUED).unwrap();
        self.answer(request, &index.to_le_bytes());
    }

    fn reads<T: Readable<Query = NoArgs>>(&mut self, value: &T) {
        let value = FrameBuf::encode(T::ROW.id, Ctrl::GET, value).unwrap();
        let request = FrameBuf::get(&NoArgs, T::ROW).unwrap();
        self.answer(request, value.frame().params());
    }

    fn finishes(&mut self, current: u64) {
        self.reads(&QueuedCmdCurrentIndex {
            queued_cmd_current_index: current,
        });
    }

    fn ratio(&self) -> Option<f32> {
        let known = self.0.get::<PtpCommonParams>(0);
        known.map(|known| known.velocity_ratio)
    }
}

fn ratio(velocity_ratio: f32) -> PtpCommonParams {
    PtpCommonParams {
        velocity_ratio,
        acceleration_ratio: 50.0,
    }
}

#[test]
fn value_read_or_set_is_known_until_it_may_change() {
    let mut rig = Rig::default();
    rig.reads(&ratio(40.0));
    assert_eq!(rig.ratio(), Some(40.0));
    let request = FrameBuf::set(&ratio(60.0).into(), Ctrl::SET).unwrap();
    rig.0.sent(0, &request.frame());
    assert_eq!(rig.ratio(), None, "it is unknown whether the arm took it");
    rig.sets(ratio(60.0));
    assert_eq!(rig.ratio(), Some(60.0));
    assert!(rig.0.get::<PtpCommonParams>(8).is_none(), "it is too old");
    rig.0.forget();
    assert_eq!(rig.ratio(), None);
}

#[test]
fn queued_set_takes_effect_when_executed() {
    let mut rig = Rig::default();
    rig.sets(ratio(40.0));
    rig.queues(5, ratio(70.0));
    rig.finishes(4);
    // Until command 5 has finished, the arm may change the ratio at any time.
    rig.reads(&ratio(40.0));
    assert_eq!(rig.ratio(), None);
    rig.queues(6, ratio(90.0));
    rig.finishes(5);
    assert_eq!(rig.ratio(), None);
    rig.finishes(6);
    assert_eq!(rig.ratio(), Some(90.0));
    rig.queues(7, ratio(10.0));
    rig.sets(magician_protocol::commands::QueuedCmdClear {});
    rig.finishes(8);
    assert_eq!(rig.ratio(), None, "it was dropped, or not");
    rig.reads(&ratio(90.0));
    assert_eq!(rig.ratio(), Some(90.0));
}

#[test]
fn queue_still_changes_settings_after_a_lost_line() {
    let mut rig = Rig::default();
    rig.queues(5, ratio(70.0));
    rig.0.forget();
    rig.reads(&ratio(40.0));
    assert_eq!(rig.ratio(), None);
    rig.finishes(5);
    assert_eq!(rig.ratio(), None);
    rig.reads(&ratio(70.0));
    assert_eq!(rig.ratio(), Some(70.0));
    rig.queues(6, ratio(80.0));
    rig.0.reset();
    rig.reads(&ratio(50.0));
    assert_eq!(rig.ratio(), Some(50.0), "nothing waits after a reset");
}

#[test]
fn both_jump_heights_default_to_one_and_burning_commands_touch_the_laser() {
    let mut rig = Rig::default();
    let both = PtpJump2Params {
        start_jump_height: 1.0,
        end_jump_height: 2.0,
        z_limit: 3.0,
    };
    rig.sets(both);
    assert_eq!(rig.0.get::<PtpJump2Params>(0), Some(both));
    rig.sets(JUMP);
    assert_eq!(rig.0.get::<PtpJump2Params>(0), None);
    let dark = EndEffectorLaser {
        is_ctrl_enabled: Flag::OFF,
        is_on: Flag::OFF,
    };
    for light in [build::laser(true), build::output(2, true)] {
        rig.reads(&dark);
        assert_eq!(rig.0.get::<EndEffectorLaser>(0), Some(dark));
        rig.sets(light);
        assert_eq!(rig.0.get::<EndEffectorLaser>(0), None, "{light:?}");
    }
    rig.queues(9, build::laser(true));
    rig.reads(&dark);
    assert_eq!(
        rig.0.get::<EndEffectorLaser>(0),
        None,
        "it may be lit by now"
    );
}

#[test]
fn frames_without_settings_change_no_setting_and_unknown_frames_change_all() {
    let mut rig = Rig::default();
    rig.sets(ratio(40.0));
    rig.sets(QueuedCmdStartExec {});
    rig.queues(1, build::move_to(220.0, 0.0, 0.0, 0.0));
    assert_eq!(rig.ratio(), Some(40.0));
    rig.sets(ratio(f32::NAN));
    assert_eq!(rig.ratio(), None, "what an arm makes of that is unknown");
    rig.sets(ratio(40.0));
    let unknown = FrameBuf::new(99, Ctrl::SET, &[1]).unwrap();
    rig.answer(unknown, &[]);
    assert_eq!(rig.ratio(), None);
}

#[test]
fn number_of_remembered_values_is_bounded() {
    let mut rig = Rig::default();
    for query in 0..=255_u8 {
        let row = <IoMultiplexing as Readable>::ROW;
        let request = FrameBuf::new(row.id, Ctrl::GET, &[query]).unwrap();
        rig.answer(request, &[query, 0]);
    }
    assert_eq!(rig.0.values.settings.len(), settings::MAX_VALUES);
}
