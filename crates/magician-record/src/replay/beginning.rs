//! State of the recorded arm at the start of a session, as far as the session reveals it.

use magician_motion::{Geometry, JointAngles, Pose, ToolBias};
use magician_protocol::commands::{self, EndEffectorParams, QueuedCmdStartExec};
use magician_protocol::{Direction, Frame, Layout, Readable, Writable};
use magician_sim::Profile;

use super::Replay;

/// Largest distance at which joints and pose of one answer match, mm: printed poses have two
/// decimals.
const TOGETHER: f64 = 0.05;
/// Longest tool, mm. A choice, far above the vendor's tools.
const LONGEST_TOOL: f64 = 200.0;

impl Replay<'_> {
    /// Returns the profile of a virtual arm that stands where the recorded one stood at the start.
    ///
    /// * The first pose, if it was read before anything was set: the arm starts there. Its tool is
    ///   the bias at which pose and joints match. If the joints reveal nothing, it is the tool of
    ///   the profile, or none if the pose is out of reach with that.
    /// * A session that queues commands but never starts the queue relies on an earlier session:
    ///   the queue is running.
    ///
    /// ```
    /// use magician_record::replay::Replay;
    /// use magician_sim::{Controller, Profile};
    ///
    /// # fn replayed(trace: &[u8]) -> Result<(), Box<dyn std::error::Error>> {
    /// let session = Replay::new(trace)?;
    /// let arm = Controller::new(session.beginning(Profile::default()));
    /// let session = session.fitted(&arm);
    /// println!("{:?}", session.against(&mut arm.clone()).differences);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn beginning(&self, mut profile: Profile) -> Profile {
        if let Some(read) = self.first_pose() {
            let pose = Pose::new(read.x.into(), read.y.into(), read.z.into(), read.r.into());
            let joints = JointAngles::from(read.joint_angle.map(f64::from));
            let usual =
                Geometry::magician(profile.power_up.tool).forward(&profile.power_up.joints.into());
            let as_usual = usual.distance_to(&pose) <= TOGETHER
                && (usual.r - pose.r).abs() <= TOGETHER
                && joints_near(&joints, &profile.power_up.joints.into());
            if !as_usual {
                stand(&mut profile, &pose, &joints);
            }
        }
        let queues = self.requests().any(|frame| frame.ctrl().queued());
        let starts = self
            .requests()
            .any(|frame| frame.id() == QueuedCmdStartExec::ROW.id && frame.ctrl().write());
        profile.power_up.queue_started |= queues && !starts;
        profile
    }

    /// True if a command in the session moves the arm.
    #[cfg(feature = "mcap")]
    pub(crate) fn moves(&self) -> bool {
        self.requests().any(|frame| {
            let ctrl = frame.ctrl();
            (ctrl.write() || ctrl.queued()) && moves_arm(frame.id())
        })
    }

    fn requests(&self) -> impl Iterator<Item = Frame<'_>> {
        let requests = self.packets.iter();
        let requests = requests.filter(|packet| packet.direction == Some(Direction::Request));
        requests.filter_map(|packet| Frame::new(packet.bytes))
    }

    /// First pose that was read before any command that may move the arm or change its tool.
    fn first_pose(&self) -> Option<commands::Pose> {
        let before = self.packets.iter().map_while(|packet| {
            let frame = Frame::new(packet.bytes)?;
            let ctrl = frame.ctrl();
            let sets =
                packet.direction == Some(Direction::Request) && (ctrl.write() || ctrl.queued());
            let moves = sets && changes_pose(frame.id());
            (!moves).then_some((packet.direction, frame))
        });
        let row = <commands::Pose as Readable>::ROW;
        before
            .filter(|(direction, frame)| {
                *direction == Some(Direction::Reply) && frame.id() == row.id
            })
            .find_map(|(_, frame)| commands::Pose::decode(frame.params()).ok())
    }
}

/// True if a command may change the next pose.
fn changes_pose(id: u8) -> bool {
    id == <EndEffectorParams as Writable>::ROW.id || moves_arm(id)
}

fn moves_arm(id: u8) -> bool {
    use magician_protocol::{Effect, Row};
    Row::with_id(id).is_some_and(|row| matches!(row.effect, Effect::Motion | Effect::Jog))
}

fn joints_near(joints: &JointAngles, others: &JointAngles) -> bool {
    let pairs = joints.to_array().into_iter().zip(others.to_array());
    pairs
        .into_iter()
        .all(|(one, other)| (one - other).abs() <= TOGETHER)
}

/// Puts the arm of a profile at a pose.
fn stand(profile: &mut Profile, pose: &Pose, joints: &JointAngles) {
    let own = profile.power_up.tool;
    let told = tool_between(pose, joints);
    let mut tools = [told, Some(own), Some(ToolBias::NONE)]
        .into_iter()
        .flatten();
    let limits = profile.arm_model().limits;
    let found = tools.find_map(|tool| {
        let joints = Geometry::magician(tool)
            .inverse_within(pose, &limits)
            .ok()?;
        Some((tool, joints))
    });
    if let Some((tool, joints)) = found {
        profile.power_up.tool = tool;
        profile.power_up.joints = joints.to_array();
    }
}

/// Tool bias at which the joints yield the pose; `None` if they reveal nothing.
fn tool_between(pose: &Pose, joints: &JointAngles) -> Option<ToolBias> {
    let bare = Geometry::magician(ToolBias::NONE).forward(joints);
    if (bare.r - pose.r).abs() > TOGETHER {
        return None;
    }
    let (sin, cos) = libm::sincos(joints.j1.to_radians());
    let (off_x, off_y) = (pose.x - bare.x, pose.y - bare.y);
    let [x, y, z] = [
        off_x * cos + off_y * sin,
        off_y * cos - off_x * sin,
        bare.z - pose.z,
    ];
    // The usual tools lie in the plane of the arm at the height of the wrist. Any other difference
    // means that the joints were not recorded.
    let is_tool = y.abs() <= TOGETHER && z.abs() <= TOGETHER && x.abs() <= LONGEST_TOOL;
    // Apart from printed digits, a bias is a round number.
    let round = |value: f64| (value * 10.0).round() / 10.0;
    is_tool.then(|| ToolBias::new(round(x) + 0.0, 0.0, 0.0))
}
