//! What the picture tells beside what a virtual arm does, for generated programs on a line that may lose answers.

use magician_protocol::commands::{
    ClearAllAlarmsState, EndEffectorGripper, EndEffectorLaser, EndEffectorParams,
    EndEffectorSuctionCup, PtpCommonParams, QueuedCmdClear, QueuedCmdCurrentIndex,
    QueuedCmdForceStopExec, QueuedCmdStartExec, QueuedCmdStopExec,
};
use magician_protocol::{Ctrl, FrameBuf, NoArgs, Readable, Set};

use super::*;
use crate::connection::{Request, Settings};
use crate::faults::{Dice, Faults};
use crate::pair::Pair;
use crate::{ToolBias, build};

/// Longer than a request takes that is answered.
const PATIENCE: Micros = 2_000_000;

/// A host with a picture and a virtual arm in virtual time.
struct PictureRig {
    pair: Pair,
    picture: ArmPicture,
    /// Rounds in which the laser burnt, and was told to.
    burnt: u32,
    /// What was sent so far.
    log: Vec<String>,
}

impl PictureRig {
    fn new(seed: u64) -> Self {
        Self {
            pair: Pair::new(Settings::default(), Faults::default(), seed),
            picture: ArmPicture::default(),
            burnt: 0,
            log: Vec::new(),
        }
    }

    fn ask(&mut self, frame: FrameBuf) {
        self.picture.sent(&frame.frame());
        self.law();
        let ticket = (self.pair.host).submit(Request::of(frame).deadline(self.pair.now + PATIENCE));
        let end = self.pair.now + PATIENCE + 1;
        let result = loop {
            if let Some(result) = self.pair.results.remove(&ticket) {
                break result;
            }
            self.pair.step(end);
            self.law();
        };
        match result {
            Ok(reply) => {
                let now = self.pair.now;
                (self.picture).answered(now, &frame.frame(), &reply.frame());
            }
            Err(failure) => self.picture.failed(&frame.frame(), &failure),
        }
        self.log.push(format!(
            "{} {:?} {frame:?} {result:?}",
            self.pair.now,
            Row::with_id(frame.frame().id()).map(|row| row.name)
        ));
        self.law();
    }

    fn set(&mut self, command: impl Into<Set>) {
        self.ask(FrameBuf::set(&command.into(), Ctrl::SET).unwrap());
    }

    fn queue(&mut self, command: Set) {
        self.ask(FrameBuf::set(&command, Ctrl::QUEUED).unwrap());
    }

    fn read<T: Readable<Query = NoArgs>>(&mut self) {
        self.ask(FrameBuf::get(&NoArgs, T::ROW).unwrap());
    }

    fn read_all(&mut self) {
        self.read::<EndEffectorSuctionCup>();
        self.read::<EndEffectorGripper>();
        self.read::<EndEffectorParams>();
        self.read::<PtpCommonParams>();
        self.read::<EndEffectorLaser>();
        self.picture.note_laser_pins(Some(false));
    }

    fn wait(&mut self, time: Micros) {
        let end = self.pair.now + time;
        while self.pair.now < end {
            self.pair.step(end);
            self.law();
        }
    }

    /// A laser that burns was told.
    fn law(&mut self) {
        let burns = self.pair.arm.state().laser_power > 0.0;
        let told = self.picture.outputs(true).laser;
        assert!(
            !burns || told == Some(true),
            "at {} it burns, and {told:?} is told: {:?}\n{:#?}",
            self.pair.now,
            self.picture,
            self.log
        );
        self.burnt += u32::from(burns);
    }

    /// Everything is told as it is, once the queue has nothing left and was read.
    fn agrees(&mut self) {
        self.read::<QueuedCmdCurrentIndex>();
        let state = self.pair.arm.state();
        let told = self.picture.outputs(true);
        let is = (Some(state.tool.x as f32), Some(state.laser_power > 0.0));
        let tool = told.tool.map(|[x, ..]| x);
        assert_eq!(
            (tool, told.laser),
            is,
            "{:?}\n{:#?}",
            self.picture,
            self.log
        );
        // Once it is unknown, reading does not show which of the two has the pump.
        if self.picture.lapses() == 0 {
            let is = (state.suction.commanded, state.gripper.commanded);
            let gripper = told.gripper.map(|gripper| gripper == GripperState::Closed);
            let told = (told.suction, gripper);
            assert_eq!(
                told,
                (Some(is.0), Some(is.1)),
                "{:?}\n{:#?}",
                self.picture,
                self.log
            );
        }
    }
}

/// What a program may switch, by chance.
fn any_output(dice: &mut Dice) -> Set {
    match dice.below(9) {
        0 => build::suction(dice.chance(0.5)),
        1 => build::grip(),
        2 => build::release(),
        3 => build::pump_off(),
        4 => build::laser(true),
        5 => build::laser(false),
        6 => build::tool(if dice.chance(0.5) {
            ToolBias::PEN
        } else {
            ToolBias::LASER
        }),
        7 => build::speed(1.0 + dice.below(99) as f32, 50.0),
        _ => build::output(3, true),
    }
}

fn any_segment(dice: &mut Dice) -> Set {
    let power = if dice.chance(0.6) { 60.0 } else { 0.0 };
    let (x, y) = (dice.below(20) as f32, dice.below(20) as f32);
    build::engrave_to(210.0 + x, y - 10.0, 0.0, power)
}

fn stop(bench: &mut PictureRig) {
    for request in Request::halt().unwrap() {
        bench.ask(*request.frame());
    }
    assert_eq!(
        bench.picture.outputs(true).laser,
        Some(false),
        "after a stop: {:#?}",
        bench.picture
    );
}

/// One step of a program.
fn step(bench: &mut PictureRig, dice: &mut Dice) {
    match dice.below(16) {
        0..=3 => bench.set(any_output(dice)),
        4..=6 => bench.queue(any_output(dice)),
        7..=9 => bench.queue(any_segment(dice)),
        10 => bench.set(QueuedCmdStartExec {}),
        11 => bench.set(QueuedCmdStopExec {}),
        12 => bench.read::<QueuedCmdCurrentIndex>(),
        13 => bench.wait(dice.below(1_500_000)),
        14 => stop(bench),
        _ => match dice.below(4) {
            0 => bench.set(QueuedCmdClear {}),
            1 => bench.set(QueuedCmdForceStopExec {}),
            2 => {
                bench.read_all();
                bench.read::<Pose>();
            }
            _ => bench.queue(build::move_to(220.0, 10.0, 20.0, 0.0)),
        },
    }
}

fn program(seed: u64, lossy: bool) -> u32 {
    let mut dice = Dice::new(seed);
    let mut bench = PictureRig::new(seed);
    bench.set(ClearAllAlarmsState {});
    bench.set(QueuedCmdStartExec {});
    bench.queue(build::move_to(220.0, 0.0, 20.0, 0.0));
    bench.wait(3_000_000);
    bench.read_all();
    for _ in 0..40 {
        if lossy && dice.chance(0.1) {
            if dice.chance(0.5) {
                bench.pair.lose_next_reply()
            } else {
                bench.pair.lose_next_request()
            }
        }
        step(&mut bench, &mut dice);
    }
    // Let it end, and put the laser out.
    bench.set(QueuedCmdStartExec {});
    bench.wait(60_000_000);
    bench.read::<QueuedCmdCurrentIndex>();
    if lossy {
        // Nothing else tells that a command which was not answered is not in the queue.
        stop(&mut bench);
    } else {
        bench.set(build::laser(false));
    }
    // An arm that turns round shows each pose twice, and none a third time.
    for _ in 0..3 {
        bench.wait(100_000);
        bench.read::<Pose>();
    }
    if lossy || bench.picture.lapses() > 0 {
        bench.read_all();
    }
    bench.agrees();
    bench.burnt
}

#[test]
fn told_outputs_are_those_of_the_arm_for_any_program() {
    let burnt: u32 = (0..400).map(|seed| program(seed, false)).sum();
    assert!(burnt > 1000, "{burnt}");
}

#[test]
fn told_laser_errs_towards_burning_when_answers_are_lost() {
    let burnt: u32 = (1000..1300).map(|seed| program(seed, true)).sum();
    assert!(burnt > 1000, "{burnt}");
}
