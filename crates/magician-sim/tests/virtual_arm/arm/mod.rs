//! A virtual arm under test, in virtual time: send, let time pass, inspect.
#![allow(dead_code, unreachable_pub)]

use magician_protocol::commands::*;
use magician_protocol::{
    Ctrl, Flag, FrameBuf, IoFunction, JogCommand, Layout, NoArgs, PtpMode, QueuedCmdIndex,
    Readable, Writable,
};
use magician_sim::scenario::Scenario;
use magician_sim::{ArmInstant, Controller, ControllerState, Event, LinkId, Profile, World};

/// Link used by most tests.
pub const USB: LinkId = LinkId(0);
/// Microseconds of the arm's clock.
pub type Micros = u64;
/// A second of arm time.
pub const SECOND: Micros = 1_000_000;

/// An arm with helpers to operate it.
pub struct TestArm {
    pub arm: Controller,
}

/// A new arm, its reset alarm cleared.
pub fn arm() -> TestArm {
    arm_with(|_| ())
}

/// A profile in continuous time, for which closed forms hold. Indices start at 1, so that the index
/// of a command is its number.
fn plain() -> Profile {
    let mut profile = Profile::continuous();
    profile.queue.first_index = 1;
    profile
}

/// A new arm with a changed profile.
pub fn arm_with(change: impl FnOnce(&mut Profile)) -> TestArm {
    let mut profile = plain();
    change(&mut profile);
    profile.check().expect("a sensible profile");
    let mut bench = TestArm {
        arm: Controller::new(profile),
    };
    bench.set(&ClearAlarmsState {});
    bench
}

/// A new arm in the world of a scenario, with its queue started.
pub fn arm_in(scenario: &str) -> TestArm {
    let scenario = Scenario::from_toml(scenario).expect("a scenario");
    let world = World::from_scenario(&scenario);
    let mut bench = TestArm {
        arm: Controller::in_world(plain(), world),
    };
    bench.set(&ClearAlarmsState {});
    bench.start();
    bench
}

/// A new arm with its queue started.
pub fn running_arm() -> TestArm {
    let mut bench = arm();
    bench.set(&QueuedCmdStartExec {});
    bench
}

/// Instant at which the arm's clock shows this many microseconds.
pub fn at(micros: Micros) -> ArmInstant {
    ArmInstant::from_micros(micros)
}

/// Parses a line of hex.
pub fn hex(text: &str) -> Vec<u8> {
    text.split_whitespace()
        .map(|byte| u8::from_str_radix(byte, 16).expect("hex"))
        .collect()
}

impl TestArm {
    /// Sends bytes; returns all replies.
    pub fn send(&mut self, bytes: &[u8]) -> Vec<FrameBuf> {
        self.send_over(USB, bytes)
    }

    pub fn send_over(&mut self, link: LinkId, bytes: &[u8]) -> Vec<FrameBuf> {
        self.arm.exchange(link, bytes)
    }

    /// Pending replies on a link.
    pub fn replies(&mut self, link: LinkId) -> Vec<FrameBuf> {
        self.arm.exchange(link, &[])
    }

    /// Sends a request and expects a reply, both in hex.
    #[track_caller]
    pub fn exchange(&mut self, request: &str, reply: &str) {
        let replies = self.send(&hex(request));
        let bytes: Vec<u8> = replies.iter().flat_map(|r| r.bytes().to_vec()).collect();
        assert_eq!(bytes, hex(reply), "reply to {request}: {replies:?}");
    }

    /// Sends a frame and expects exactly one reply with the same id and Ctrl. Ignores bit 2 of the
    /// reply's Ctrl, which a full queue sets.
    #[track_caller]
    pub fn frame(&mut self, id: u8, ctrl: Ctrl, params: &[u8]) -> FrameBuf {
        let replies = self.send(FrameBuf::new(id, ctrl, params).unwrap().bytes());
        let [reply] = replies[..] else {
            panic!("one reply to id {id}, not {replies:?}")
        };
        assert_eq!(reply.frame().id(), id);
        assert_eq!(Ctrl(reply.frame().ctrl().0 & !4), ctrl);
        reply
    }

    #[track_caller]
    pub fn get<T: Readable<Query = NoArgs>>(&mut self) -> T {
        self.get_with(&NoArgs)
    }

    #[track_caller]
    pub fn get_with<T: Readable>(&mut self, query: &T::Query) -> T {
        let request = FrameBuf::get(query, T::ROW).unwrap();
        let reply = self.frame(T::ROW.id, Ctrl::GET, request.frame().params());
        T::decode(reply.frame().params()).unwrap()
    }

    /// Sends an immediate set and expects an empty reply.
    #[track_caller]
    pub fn set<T: Writable>(&mut self, value: &T) {
        let request = FrameBuf::encode(T::ROW.id, Ctrl::SET, value).unwrap();
        let reply = self.frame(T::ROW.id, Ctrl::SET, request.frame().params());
        assert_eq!(reply.frame().params(), [0u8; 0]);
    }

    /// Queues a command; returns its index.
    #[track_caller]
    pub fn enqueue<T: Writable>(&mut self, value: &T) -> u64 {
        let request = FrameBuf::encode(T::ROW.id, Ctrl::QUEUED, value).unwrap();
        let reply = self.frame(T::ROW.id, Ctrl::QUEUED, request.frame().params());
        assert_eq!(reply.frame().params().len(), 8);
        QueuedCmdIndex::decode(reply.frame().params()).unwrap().0
    }

    pub fn start(&mut self) {
        self.set(&QueuedCmdStartExec {});
    }

    /// Lets time pass.
    pub fn pass(&mut self, span: Micros) {
        self.arm.advance(self.arm.now().after_micros(span));
    }

    /// Advances until nothing is scheduled; returns the time passed.
    pub fn rest(&mut self) -> Micros {
        let from = self.arm.now();
        while let Some(at) = self.arm.poll_timeout() {
            self.arm.advance(at);
        }
        self.arm.now().micros_since(from)
    }

    pub fn state(&self) -> ControllerState {
        self.arm.state()
    }

    #[track_caller]
    pub fn current_index(&mut self) -> u64 {
        self.get::<QueuedCmdCurrentIndex>().queued_cmd_current_index
    }

    #[track_caller]
    pub fn left_space(&mut self) -> u32 {
        self.get::<QueuedCmdLeftSpace>().left_space
    }

    /// Codes of the standing alarms, read over the protocol.
    #[track_caller]
    pub fn alarms(&mut self) -> Vec<u8> {
        self.get::<AlarmsState>().alarms_state.codes().collect()
    }

    /// Pose x, y, z, r, read over the protocol.
    #[track_caller]
    pub fn pose(&mut self) -> [f32; 4] {
        let Pose { x, y, z, r, .. } = self.get::<Pose>();
        [x, y, z, r]
    }

    #[track_caller]
    pub fn joints(&mut self) -> [f32; 4] {
        self.get::<Pose>().joint_angle
    }

    /// Takes all pending events; drops `Event::Assumes`.
    pub fn events(&mut self) -> Vec<Event> {
        std::iter::from_fn(|| self.arm.poll_event())
            .filter(|event| !matches!(event, Event::Assumes { .. }))
            .collect()
    }

    /// Sets both ratios to 100 %.
    pub fn full_speed(&mut self) {
        self.set(&PtpCommonParams {
            velocity_ratio: 100.0,
            acceleration_ratio: 100.0,
        });
    }

    pub fn suction_bias(&mut self) {
        self.bias(59.7);
    }

    /// Sets the tool bias to 0, so that the wrist is reported.
    pub fn no_tool(&mut self) {
        self.bias(0.0);
    }

    fn bias(&mut self, x_bias: f32) {
        self.set(&EndEffectorParams {
            x_bias,
            y_bias: 0.0,
            z_bias: 0.0,
        });
    }
}

/// A point-to-point command.
pub fn ptp(mode: u8, [x, y, z, r]: [f32; 4]) -> PtpCmd {
    let ptp_mode = PtpMode::from(mode);
    PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    }
}

pub fn jog(is_joint: bool, cmd: u8) -> JogCmd {
    JogCmd {
        is_joint: Flag::from(is_joint),
        cmd: JogCommand::from(cmd),
    }
}

pub fn joints_to(joints: [f32; 4]) -> PtpCmd {
    ptp(4, joints)
}

pub fn wait(ms: u32) -> WaitCmd {
    WaitCmd { timeout: ms }
}

pub fn home() -> HomeCmd {
    HomeCmd { reserved: 0 }
}

pub fn suck(on: bool) -> SetEndEffectorSuctionCup {
    SetEndEffectorSuctionCup {
        enable_ctrl: Flag::ON,
        suck: Flag::from(on),
    }
}

pub fn grip(on: bool) -> SetEndEffectorGripper {
    SetEndEffectorGripper {
        enable_ctrl: Flag::ON,
        grip: Flag::from(on),
    }
}

/// Sets the function of a pin.
pub fn multiplex(bench: &mut TestArm, address: u8, multiplex: IoFunction) {
    bench.set(&IoMultiplexing { address, multiplex });
}

/// Sets the level of an output.
pub fn output(bench: &mut TestArm, address: u8, on: bool) {
    let level = Flag::from(on);
    bench.set(&IoDo { address, level });
}

/// Duration of a motion from rest to rest, s (model section 7).
pub fn trapezoid(way: f64, velocity: f64, acceleration: f64) -> f64 {
    if way > velocity * velocity / acceleration {
        way / velocity + velocity / acceleration
    } else {
        2.0 * (way / acceleration).sqrt()
    }
}

/// Duration of referencing the base at its switch from the angle `j1`, s (model section 11).
pub fn search_lasts(j1: f64) -> f64 {
    trapezoid(j1 + 135.0, 20.0, 30.0)
        + trapezoid(0.5, 20.0, 30.0)
        + trapezoid(0.25, 1.0, 30.0)
        + trapezoid(0.25, 0.5, 30.0)
}

/// Duration of homing from the angle `j1` of the base to the default home point, s.
pub fn homing_lasts(j1: f64) -> f64 {
    search_lasts(j1) + trapezoid(135.0, 30.0, 30.0)
}

/// Asserts a duration in microseconds, to 0.1 ms.
#[track_caller]
pub fn lasts(measured: u64, seconds: f64) {
    let error = measured as f64 / 1e6 - seconds;
    assert!(error.abs() < 1e-4, "{measured} us, expected {seconds} s");
}
