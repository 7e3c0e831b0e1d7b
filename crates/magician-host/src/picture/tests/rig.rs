//! A host with a picture and a virtual arm in virtual time.

use magician_protocol::commands::{
    EndEffectorGripper, EndEffectorLaser, EndEffectorParams, EndEffectorSuctionCup,
    PtpCommonParams, QueuedCmdCurrentIndex,
};
use magician_protocol::{Ctrl, FrameBuf, NoArgs, Readable, Row, Set};

use crate::connection::{Micros, Request, Settings};
use crate::faults::Faults;
use crate::pair::Pair;
use crate::picture::{ArmPicture, GripperState, Origin, PictureEvent};

/// Timeout of a request, longer than any answered request takes, us.
const PATIENCE: Micros = 2_000_000;

/// A host with a picture and a virtual arm in virtual time.
pub(super) struct PictureRig {
    pub(super) pair: Pair,
    pub(super) picture: ArmPicture,
    /// Rounds in which the laser burned, and in which the picture said so.
    pub(super) burnt: u32,
    /// Rounds in which the arm moved, and in which the picture said so.
    pub(super) moved: u32,
    /// Events that replies have caused.
    pub(super) events: Vec<PictureEvent>,
    /// Frames sent so far.
    log: Vec<String>,
}

impl PictureRig {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            pair: Pair::new(Settings::default(), Faults::default(), seed),
            picture: ArmPicture::default(),
            burnt: 0,
            moved: 0,
            events: Vec::new(),
            log: Vec::new(),
        }
    }

    pub(super) fn ask(&mut self, frame: FrameBuf) {
        self.picture.handed_over(&frame.frame());
        self.picture.sent(self.pair.now, &frame.frame());
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
        self.picture.returned(&frame.frame());
        match result {
            Ok(reply) => {
                let now = self.pair.now;
                (self.picture).answered(now, Origin::Caller, &frame.frame(), &reply.frame());
                self.take_events();
            }
            Err(failure) => self.picture.failed(Some(&frame.frame()), &failure),
        }
        self.log.push(format!(
            "{} {:?} {frame:?} {result:?}",
            self.pair.now,
            Row::with_id(frame.frame().id()).map(|row| row.name)
        ));
        self.law();
    }

    pub(super) fn set(&mut self, command: impl Into<Set>) {
        self.ask(FrameBuf::set(&command.into(), Ctrl::SET).unwrap());
    }

    pub(super) fn queue(&mut self, command: Set) {
        self.ask(FrameBuf::set(&command, Ctrl::QUEUED).unwrap());
    }

    pub(super) fn read<T: Readable<Query = NoArgs>>(&mut self) {
        self.ask(FrameBuf::get(&NoArgs, T::ROW).unwrap());
    }

    pub(super) fn read_all(&mut self) {
        self.read::<EndEffectorSuctionCup>();
        self.read::<EndEffectorGripper>();
        self.read::<EndEffectorParams>();
        self.read::<PtpCommonParams>();
        self.read::<EndEffectorLaser>();
        self.picture.note_laser_pins(Some(false));
    }

    pub(super) fn wait(&mut self, time: Micros) {
        let end = self.pair.now + time;
        while self.pair.now < end {
            self.pair.step(end);
            self.law();
        }
    }

    /// Asserts that the end of each command is reported once.
    fn take_events(&mut self) {
        while let Some(event) = self.picture.poll_event() {
            if let PictureEvent::Finished { first, last } = event {
                assert!(first <= last);
                let mut before = self.events.iter().rev();
                let before = before.find_map(|event| match event {
                    PictureEvent::Finished { last, .. } => Some(last.0),
                    _ => None,
                });
                assert!(
                    before.is_none_or(|before| before + 1 == first.0),
                    "{before:?} {event:?}"
                );
            }
            self.events.push(event);
        }
    }

    /// Asserts that a burning laser is reported, and a moving arm.
    fn law(&mut self) {
        let state = self.pair.arm.state();
        let motion = self.picture.motion();
        // A queue that was stopped lets the current command end.
        let may_move = motion.is_moving() || motion.is_braking() || motion.started() == Some(false);
        assert!(
            !state.moving || may_move,
            "at {} it moves: {motion:?}\n{:#?}",
            self.pair.now,
            self.log
        );
        self.moved += u32::from(state.moving);
        let burns = state.laser_power > 0.0;
        let told = self.picture.outputs().laser;
        assert!(
            !burns || told == Some(true),
            "at {} it burns, and {told:?} is told: {:?}\n{:#?}",
            self.pair.now,
            self.picture,
            self.log
        );
        self.burnt += u32::from(burns);
    }

    /// Asserts that everything is reported correctly once the queue is empty and was read.
    pub(super) fn agrees(&mut self) {
        self.read::<QueuedCmdCurrentIndex>();
        let state = self.pair.arm.state();
        let told = self.picture.outputs();
        let is = (Some(state.tool.x as f32), Some(state.laser_power > 0.0));
        let tool = told.tool.map(|[x, ..]| x);
        assert_eq!(
            (tool, told.laser),
            is,
            "{:?}\n{:#?}",
            self.picture,
            self.log
        );
        // After a lapse, readings do not show whether suction cup or gripper has the pump.
        if self.picture.snapshot().lapses == 0 {
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
