//! A virtual arm in virtual time, with its queue kept full, and chance from a seed.

use magician::protocol::{FrameBuf, NoArgs, Readable};
use magician::sim::{Controller, LinkId, Profile};
use magician::words::Readings;
use magician::{Ctrl, Set, commands};
use magician_program::Plan;

const LINK: LinkId = LinkId(0);

pub(crate) struct Bench {
    pub(crate) arm: Controller,
    now: u64,
}

/// What a plan has come to.
#[derive(Debug)]
pub(crate) struct Done {
    /// How long it took, us.
    pub(crate) took: u64,
    /// Everything has been done.
    pub(crate) finished: bool,
    /// An alarm holds the arm.
    pub(crate) alarm: Option<String>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self {
            arm: Controller::new(Profile::default()),
            now: 0,
        }
    }

    fn ask(&mut self, frame: &FrameBuf) -> FrameBuf {
        self.arm.receive(LINK, frame.bytes());
        self.arm.poll_transmit(LINK).expect("it answers")
    }

    fn get<T: Readable<Query = NoArgs>>(&mut self) -> T {
        let reply = self.ask(&FrameBuf::get(&NoArgs, T::ROW).expect("it fits"));
        T::decode(reply.frame().params()).expect("its own form")
    }

    /// All that the arm says before a program.
    pub(crate) fn readings(&mut self) -> Readings {
        let mut read = Readings::default();
        read.pose = Some(self.get());
        read.tool = self.get();
        read.laser = self.get();
        read.home = Some(self.get());
        read.joint_speeds = self.get();
        read.line_speeds = self.get();
        read.ratios = self.get();
        read.jump = self.get();
        read.arc_speeds = self.get();
        read.path_speeds = self.get();
        read.with_rail = self.get::<commands::DeviceWithL>().with_l.is_on();
        read.rail = Some(self.get::<commands::PoseL>().pose_l);
        read.rail_speeds = self.get();
        read
    }

    /// What the tools are told to do: suction cup, gripper, laser.
    pub(crate) fn tools(&mut self) -> impl PartialEq + std::fmt::Debug + use<> {
        let cup: commands::EndEffectorSuctionCup = self.get();
        let gripper: commands::EndEffectorGripper = self.get();
        let laser: commands::EndEffectorLaser = self.get();
        (cup, gripper, laser)
    }

    /// Does all of a plan, or as much as an alarm lets it.
    pub(crate) fn run(&mut self, plan: &Plan) -> Done {
        let commands: Vec<Set> = plan.commands().collect();
        let mut rest = commands.iter();
        let last = self.arm.state().queue.current_index + commands.len() as u64;
        let start =
            FrameBuf::set(&commands::QueuedCmdStartExec {}.into(), Ctrl::SET).expect("it fits");
        let mut begun = None;
        while self.arm.state().queue.current_index < last && !self.arm.state().alarms.blocking() {
            let queue = self.arm.state().queue;
            let taken = queue.waiting + usize::from(queue.running.is_some());
            for command in rest.by_ref().take(queue.capacity - taken) {
                self.ask(&FrameBuf::set(command, Ctrl::QUEUED).expect("it fits"));
            }
            if begun.is_none() {
                begun = Some(self.now);
                self.ask(&start);
                continue;
            }
            let Some(at) = self.arm.poll_timeout() else {
                break;
            };
            self.now = at.max(self.now);
            self.arm.advance(self.now);
        }
        let state = self.arm.state();
        Done {
            took: self.now - begun.unwrap_or(self.now),
            finished: state.queue.current_index >= last,
            alarm: state.alarms.blocking().then(|| state.alarms.to_string()),
        }
    }
}
