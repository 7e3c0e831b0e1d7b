//! The replay itself: packet by packet, in the trace's time.
//!
//! Before each read of the pose during a motion the arm is also asked at a few earlier and later
//! instants. A recorded pose that equals one of those was read near the boundary of a period, where
//! the jitter of the host decides.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use magician_protocol::{
    Ctrl, Deframer, Direction, Event, Frame, FrameBuf, INTER_BYTE_TIMEOUT_MS, Readable, Row,
    commands,
};

use super::compare::Comparer;
use super::report::{Difference, DifferenceKind, Report};
use super::residue::PoseComparison;
use super::{Packet, Replay};
use magician_sim::{ArmClock, ArmInstant, Controller, HostInstant, LinkId, Observer, Speed};

/// Placeholder for no observer.
type Nobody = Option<Box<dyn Observer + Send>>;

/// Time after which an unanswered request is given up.
const REPLY_TIMEOUT: Duration = Duration::from_secs(3);
/// Longest uptime that is simulated before the session. With a longer one a scenario might act
/// meanwhile.
const LONGEST_UPTIME: ArmInstant = ArmInstant::from_micros(3_600_000_000);
const SILENCE: Duration = Duration::from_millis(INTER_BYTE_TIMEOUT_MS);

/// A replayed packet.
#[derive(Clone, Debug)]
pub struct ReplayedPacket<'a> {
    /// The packet.
    pub packet: &'a Packet<'a>,
    /// Answers of the virtual arm.
    pub replies: Vec<FrameBuf>,
    /// Differences found by this packet.
    pub differences: Vec<Difference>,
}

/// A replay in progress; made by [`Replay::play`].
#[derive(Debug)]
pub struct Play<'r, 'a> {
    replay: &'r Replay<'a>,
    arm: &'r mut Controller,
    clock: ArmClock,
    next: usize,
    links: BTreeMap<u32, Link>,
    comparer: Comparer,
    poses: PoseComparison,
    /// Time of the latest command that sets or queues something.
    commanded: Option<HostInstant>,
    report: Report,
    /// True if the trace has any answers: a trace of requests only is not compared.
    answered: bool,
}

/// State of one link.
#[derive(Debug, Default)]
struct Link {
    name: String,
    requests: Deframer,
    replies: Deframer,
    /// Time of the latest bytes for the arm.
    heard: HostInstant,
    asked: VecDeque<PendingRequest>,
}

/// Uncertainty of the time at which a request reached the recorded arm, us. A USB adapter holds
/// bytes for up to 1 ms, or a few with a latency timer, and so does the host.
pub(crate) const JITTER: u64 = 5_000;

/// A request, and the answer of the virtual arm.
#[derive(Debug)]
struct PendingRequest {
    time: HostInstant,
    request: FrameBuf,
    reply: Option<FrameBuf>,
    beside: NeighbourAnswers,
}

/// Answers of the virtual arm to the same request at earlier and later instants.
#[derive(Debug, Default)]
struct NeighbourAnswers {
    /// Earlier and later by [`JITTER`].
    near: [Option<FrameBuf>; 2],
    /// Earlier and later by one period.
    far: [Option<FrameBuf>; 2],
}

impl PendingRequest {
    fn is_answered_by(&self, frame: &Frame<'_>) -> bool {
        let own = self.request.frame();
        own.id() == frame.id() && own.ctrl().with_error() == frame.ctrl().with_error()
    }
}

impl<'r, 'a> Play<'r, 'a> {
    pub(super) fn new(replay: &'r Replay<'a>, arm: &'r mut Controller) -> Self {
        // First of all: the uptime decides the phase of the periods, and `shift` is added to it.
        if let Some(uptime) = replay.uptime().filter(|uptime| *uptime <= LONGEST_UPTIME) {
            arm.advance(uptime);
        }
        if let Some(serial) = replay.virtual_serial() {
            arm.identify_as(serial, None);
        }
        if !replay.shift.is_zero() {
            arm.advance(arm.now() + replay.shift);
        }
        let replies = |packet: &Packet<'_>| packet.direction == Some(Direction::Reply);
        Self {
            clock: ArmClock::new(replay.clock, arm.now()),
            comparer: Comparer::new(replay.tolerances, replay.ignored.clone()),
            poses: PoseComparison::default(),
            commanded: None,
            answered: replay.packets.iter().any(replies),
            replay,
            arm,
            next: 0,
            links: BTreeMap::new(),
            report: Report::default(),
        }
    }

    /// Replays the next packet; `None` after the last.
    pub fn step(&mut self) -> Option<ReplayedPacket<'r>> {
        let replay = self.replay;
        let packet = replay.packets.get(self.next)?;
        self.next += 1;
        let known = self.report.differences.len();
        let time = replay.time(packet.time);
        let period = self.period_us();
        let mut beside = NeighbourAnswers::default();
        // A motion begins a period after its command.
        let may_begin = self
            .commanded
            .is_some_and(|at| time <= at.after_micros(2 * period + JITTER));
        let is_moving = self.arm.state().moving || may_begin;
        let looks_beside =
            is_pose_request(packet) && is_moving && replay.clock == Speed::Times(1.0);
        let NeighbourAnswers { near, far } = &mut beside;
        if looks_beside {
            for (by, answer) in [(period, &mut far[0]), (JITTER, &mut near[0])] {
                if let Some(earlier) = time.as_micros().checked_sub(by) {
                    let earlier = HostInstant::from_micros(earlier);
                    self.clock.pass(self.arm, &mut Nobody::None, earlier);
                }
                *answer = answer_of(self.arm, packet);
            }
        }
        // A recorded answer does not affect the arm, which can still be asked about earlier
        // instants then.
        if packet.direction == Some(Direction::Request) {
            self.clock.pass(self.arm, &mut Nobody::None, time);
        }
        if looks_beside {
            let mut later = self.arm.clone();
            let now = later.now();
            for (by, answer) in [(JITTER, &mut near[1]), (period, &mut far[1])] {
                later.advance(now.after_micros(by));
                *answer = answer_of(&later, packet);
            }
        }
        let link = self.links.entry(packet.link).or_default();
        if link.name.is_empty() {
            link.name = packet.link_name.to_string();
        }
        let replies = match packet.direction {
            Some(Direction::Request) => {
                let frame = Frame::new(packet.bytes);
                if frame.is_some_and(|frame| frame.ctrl().write() || frame.ctrl().queued()) {
                    self.commanded = Some(time);
                }
                let replies = self.request(packet, time);
                if let Some(asked) = self.links.get_mut(&packet.link)
                    && let Some(asked) = asked.asked.back_mut()
                {
                    asked.beside = beside;
                }
                replies
            }
            Some(Direction::Reply) => {
                self.recorded(packet, time);
                Vec::new()
            }
            None => {
                self.report.undirected += 1;
                Vec::new()
            }
        };
        self.give_up(packet.link, time);
        let fresh = self.report.differences.get(known..).unwrap_or_default();
        Some(ReplayedPacket {
            packet,
            replies,
            differences: fresh.to_vec(),
        })
    }

    fn period_us(&self) -> u64 {
        u64::from(self.arm.arm_model().law.period_us())
    }

    /// Number of replayed packets.
    #[must_use]
    pub fn done(&self) -> usize {
        self.next
    }

    /// Ends the replay. Requests without an answer by now count as unanswered.
    #[must_use]
    pub fn finish(mut self) -> Report {
        let links: Vec<u32> = self.links.keys().copied().collect();
        let end = HostInstant::ZERO + self.replay.span();
        for number in links {
            self.give_up(number, end);
            let left = self.links.get_mut(&number).map(|link| link.asked.len());
            self.report.unanswered += left.unwrap_or_default() as u64;
        }
        self.report.fields = self.comparer.fields;
        self.report.ignored = self.comparer.left_out;
        self.report
    }

    /// Sends bytes of the host to the arm.
    fn request(&mut self, packet: &Packet<'_>, time: HostInstant) -> Vec<FrameBuf> {
        let Self {
            links, arm, report, ..
        } = self;
        let id = LinkId(packet.link);
        let Some(link) = links.get_mut(&packet.link) else {
            return Vec::new();
        };
        let mut replies = Vec::new();
        let first = link.asked.len();
        // The virtual arm has no wall clock here: the silence is derived from the times of the
        // trace.
        if time - link.heard >= SILENCE {
            link.requests.expire();
            arm.expire(id);
            link.ask(time, &[]);
        }
        link.heard = time;
        link.ask(time, packet.bytes);
        // One request at a time: at full speed the arm finishes a command before it reads on.
        let mut input = packet.bytes;
        loop {
            let handled = arm.receive_one(id, &mut input);
            while let Some(reply) = arm.poll_transmit(id) {
                link.answer(first, &reply);
                replies.push(reply);
            }
            if !handled {
                break;
            }
            self.clock.jump(arm, &mut Nobody::None, time);
        }
        report.requests += (link.asked.len() - first) as u64;
        replies
    }

    /// Compares bytes of the recorded arm with the answers of the virtual one.
    fn recorded(&mut self, packet: &Packet<'_>, time: HostInstant) {
        let Some(link) = self.links.get_mut(&packet.link) else {
            return;
        };
        let mut frames = Vec::new();
        let mut input = packet.bytes;
        while let Some(event) = link.replies.next(&mut input) {
            if let Event::Frame { frame, .. } = event {
                frames.push(FrameBuf::from(frame));
            }
        }
        for frame in frames {
            self.compare(packet.link, time, &frame);
        }
    }

    fn compare(&mut self, number: u32, time: HostInstant, recorded: &FrameBuf) {
        let Some(link) = self.links.get_mut(&number) else {
            return;
        };
        let position =
            (link.asked.iter()).position(|asked| asked.is_answered_by(&recorded.frame()));
        let Some(at) = position else {
            self.differ(
                number,
                time,
                &recorded.frame(),
                DifferenceKind::Unasked,
                Some(recorded),
                None,
            );
            return;
        };
        // Answers arrive in order: an earlier request without an answer will not get one.
        let passed: Vec<PendingRequest> = link.asked.drain(..=at).collect();
        let Some((asked, silent)) = passed.split_last() else {
            return;
        };
        for asked in silent {
            self.unanswered(number, asked);
        }
        let Some(reply) = &asked.reply else {
            self.differ(
                number,
                asked.time,
                &recorded.frame(),
                DifferenceKind::Silent,
                Some(recorded),
                None,
            );
            return;
        };
        self.report.answers += 1;
        let is_continuous = self.period_us() == 0;
        let places = [&asked.beside.near[0], &asked.reply, &asked.beside.near[1]];
        if let Some((off, moved)) = self.poses.residue(recorded, places, is_continuous) {
            let tolerance = self.replay.tolerances.measured;
            (self.report.residue).add(off, moved, tolerance, asked.time);
        }
        let mut found = self.comparer.compare(&recorded.frame(), &reply.frame());
        // In continuous time there are no neighbouring periods.
        if !found.is_empty() && !is_continuous {
            // A pose is compared as a whole: all of it must stem from the same other instant.
            let is_one_of = |answers: &[Option<FrameBuf>]| {
                answers.iter().flatten().any(|other| {
                    let mut comparer = self.comparer.clone();
                    comparer
                        .compare(&recorded.frame(), &other.frame())
                        .is_empty()
                })
            };
            if is_one_of(&asked.beside.near) {
                self.report.late += 1;
                found.clear();
            } else if is_one_of(&asked.beside.far) {
                found = vec![DifferenceKind::Period];
            }
        }
        for what in found {
            self.differ(
                number,
                asked.time,
                &recorded.frame(),
                what,
                Some(recorded),
                Some(reply),
            );
        }
    }

    /// Gives up requests that have waited too long.
    fn give_up(&mut self, number: u32, now: HostInstant) {
        let old = |asked: &PendingRequest| now - asked.time > REPLY_TIMEOUT;
        while let Some(link) = self.links.get_mut(&number)
            && link.asked.front().is_some_and(old)
        {
            if let Some(asked) = link.asked.pop_front() {
                self.unanswered(number, &asked);
            }
        }
    }

    /// Reports a request that the recorded arm did not answer.
    fn unanswered(&mut self, number: u32, asked: &PendingRequest) {
        match &asked.reply {
            Some(reply) if self.answered => {
                self.differ(
                    number,
                    asked.time,
                    &reply.frame(),
                    DifferenceKind::Answered,
                    None,
                    Some(reply),
                );
            }
            _ => self.report.unanswered += 1,
        }
    }

    fn differ(
        &mut self,
        number: u32,
        time: HostInstant,
        about: &Frame<'_>,
        what: DifferenceKind,
        recorded: Option<&FrameBuf>,
        replayed: Option<&FrameBuf>,
    ) {
        let (id, ctrl) = (about.id(), Ctrl(about.ctrl().0));
        if self.comparer.ignores(id, None) {
            return;
        }
        let link = self.links.get(&number);
        self.report.add(Difference {
            time,
            link: link.map(|link| link.name.clone()).unwrap_or_default(),
            id,
            command: Row::with_id(id).map_or("", |row| row.form_name(ctrl)),
            what,
            recorded: recorded.copied(),
            replayed: replayed.copied(),
        });
    }
}

/// True for a request of the pose that is alone in its packet.
fn is_pose_request(packet: &Packet<'_>) -> bool {
    let frame = Frame::new(packet.bytes);
    packet.direction == Some(Direction::Request)
        && frame.is_some_and(|frame| frame.id() == <commands::Pose as Readable>::ROW.id)
}

/// Answer of an arm to a request, which leaves the arm unchanged.
fn answer_of(arm: &Controller, packet: &Packet<'_>) -> Option<FrameBuf> {
    let (mut arm, link) = (arm.clone(), LinkId(packet.link));
    arm.receive(link, packet.bytes);
    arm.poll_transmit(link)
}

impl Link {
    /// Decodes the requests in bytes for the arm.
    fn ask(&mut self, time: HostInstant, bytes: &[u8]) {
        let mut input = bytes;
        while let Some(event) = self.requests.next(&mut input) {
            if let Event::Frame { frame, .. } = event {
                self.asked.push_back(PendingRequest {
                    time,
                    request: frame.into(),
                    reply: None,
                    beside: NeighbourAnswers::default(),
                });
            }
        }
    }

    /// Assigns an answer of the virtual arm to its request, among those since `first`.
    fn answer(&mut self, first: usize, reply: &FrameBuf) {
        let mut open = self.asked.iter_mut().skip(first);
        let asked =
            open.find(|asked| asked.reply.is_none() && asked.is_answered_by(&reply.frame()));
        if let Some(asked) = asked {
            asked.reply = Some(*reply);
        }
    }
}
