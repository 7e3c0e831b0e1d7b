//! Replays: the same arm gives the same answers, and differences are named.

use magician_protocol::Direction::{Reply, Request};
use magician_protocol::commands::{
    DeviceTime, Pose, PtpCmd, PtpCommonParams, QueuedCmdCurrentIndex, QueuedCmdStartExec, WaitCmd,
};
use magician_protocol::{Ctrl, FrameBuf, NoArgs, PtpMode, QueuedCmdIndex, Readable, Row, Set};
use magician_record::replay::{DifferenceKind, Replay, ReplayError, Report, Tolerances};
use magician_record::trace::{TraceError, TraceLink, TraceWriter};
use magician_sim::{ArmInstant, Controller, LinkId, Profile};
use proptest::prelude::*;

const NOON: u64 = 1_800_000_000_000_000;
const SECOND: u64 = 1_000_000;

/// Sends requests to an arm and records the session.
struct Recorder<'f> {
    trace: TraceWriter<&'f mut Vec<u8>>,
    link: TraceLink,
    arm: Controller,
    /// Changes an answer before it is recorded.
    alter: fn(FrameBuf) -> Option<FrameBuf>,
}

impl Recorder<'_> {
    fn ask(&mut self, frame: &FrameBuf) {
        let now = NOON + self.arm.now().as_micros();
        (self.trace)
            .record(self.link, now, Request, frame.bytes())
            .unwrap();
        for reply in self.arm.exchange(LinkId(9), frame.bytes()) {
            if let Some(reply) = (self.alter)(reply) {
                (self.trace)
                    .record(self.link, now + 30, Reply, reply.bytes())
                    .unwrap();
            }
        }
    }

    fn get(&mut self, row: &Row) {
        self.ask(&FrameBuf::get(&NoArgs, row).unwrap());
    }

    fn set(&mut self, set: impl Into<Set>, ctrl: Ctrl) {
        self.ask(&FrameBuf::set(&set.into(), ctrl).unwrap());
    }

    fn pass(&mut self, time: u64) {
        self.arm.advance(self.arm.now().after_micros(time));
    }

    /// A move, with reads of the pose on the way.
    fn session(&mut self) {
        self.get(DeviceTime::ROW);
        self.get(PtpCommonParams::ROW);
        self.set(to(220.0), Ctrl::QUEUED);
        self.set(WaitCmd { timeout: 100 }, Ctrl::QUEUED);
        self.set(QueuedCmdStartExec {}, Ctrl::SET);
        for _ in 0..40 {
            self.pass(SECOND / 20);
            self.get(Pose::ROW);
            self.get(QueuedCmdCurrentIndex::ROW);
        }
        self.get(DeviceTime::ROW);
    }
}

fn to(x: f32) -> PtpCmd {
    PtpCmd {
        ptp_mode: PtpMode::MovlXyz,
        x,
        y: 30.0,
        z: 20.0,
        r: 0.0,
    }
}

fn recorded_of(
    arm: Controller,
    alter: fn(FrameBuf) -> Option<FrameBuf>,
    fill: impl FnOnce(&mut Recorder<'_>),
) -> Vec<u8> {
    let mut file = Vec::new();
    let mut trace = TraceWriter::new(&mut file).unwrap();
    let link = trace.link("./arm").unwrap();
    let mut recorder = Recorder {
        trace,
        link,
        arm,
        alter,
    };
    fill(&mut recorder);
    drop(recorder);
    file
}

fn recorded(fill: impl FnOnce(&mut Recorder<'_>)) -> Vec<u8> {
    recorded_of(Controller::default(), Some, fill)
}

fn replayed(file: &[u8]) -> Report {
    let replay = Replay::new(file).unwrap();
    replay.against(&mut Controller::default())
}

/// Differing fields, with their command.
fn fields(report: &Report) -> Vec<(&'static str, &'static str)> {
    let fields = report.differences.iter().map(|found| match found.what {
        DifferenceKind::Value(field) => (found.command, field.name),
        _ => (found.command, ""),
    });
    fields.collect()
}

#[test]
fn the_same_arm_gives_the_same_answers() {
    let report = replayed(&recorded(|recorder| recorder.session()));
    assert_eq!(report.differences, []);
    assert_eq!((report.requests, report.answers), (86, 86));
    assert_eq!(report.unanswered, 0);
    // 40 poses of 5 fields, 40 indices, 2 times, 2 ratios, 2 queued.
    assert_eq!(report.fields, 246);
}

#[test]
fn another_arm_is_told_apart_by_field_and_value() {
    let file = recorded(|recorder| recorder.session());
    let mut profile = Profile::default();
    profile.defaults.ptp.acceleration_ratio = 40.0;
    let report = Replay::new(&file)
        .unwrap()
        .against(&mut Controller::new(profile));
    let first = &report.differences[0];
    assert_eq!(
        first.to_string(),
        "GetPTPCommonParams acceleration_ratio: recorded 50, now 40"
    );
    assert_eq!((first.time.as_micros(), first.link.as_str()), (0, "./arm"));
    let found = fields(&report);
    assert!(found.contains(&("GetPose", "x")), "{found:?}");
    assert!(
        found.contains(&("GetQueuedCmdCurrentIndex", "queued_cmd_current_index")),
        "it arrives later"
    );
    assert_eq!(report.found, found.len() as u64);
}

#[test]
fn what_is_ignored_does_not_differ() {
    let file = recorded_of(Controller::default(), spoilt, |recorder| recorder.session());
    let report = replayed(&file);
    assert_eq!(
        fields(&report),
        [("GetPTPCommonParams", "velocity_ratio")],
        "the spoilt one"
    );
    for name in [
        "PTPCommonParams",
        "ptp-common-params.velocity_ratio",
        "velocity_ratio",
        "83",
    ] {
        let replay = Replay::new(&file).unwrap().ignoring(name).unwrap();
        let report = replay.against(&mut Controller::default());
        assert_eq!((report.found, report.ignored), (0, 1), "{name}");
    }
    let wrong = Replay::new(&file).unwrap().ignoring("Pose.warmth");
    assert!(matches!(wrong, Err(ReplayError::NoSuchField { .. })));
}

/// Another velocity ratio: a setting, which no tolerance covers.
fn spoilt(reply: FrameBuf) -> Option<FrameBuf> {
    if reply.frame().id() != PtpCommonParams::ROW.id {
        return Some(reply);
    }
    let mut params = reply.frame().params().to_vec();
    params[0] ^= 1;
    FrameBuf::new(reply.frame().id(), reply.frame().ctrl(), &params).ok()
}

#[test]
fn indices_are_rebased_and_a_broken_row_is_told_once() {
    fn later(reply: FrameBuf) -> Option<FrameBuf> {
        let (id, ctrl) = (reply.frame().id(), reply.frame().ctrl());
        if !ctrl.queued() && id != QueuedCmdCurrentIndex::ROW.id {
            return Some(reply);
        }
        let index: QueuedCmdIndex = reply.frame().read().ok()?;
        FrameBuf::encode(id, ctrl, &QueuedCmdIndex(index.0 + 1000)).ok()
    }
    let file = recorded_of(Controller::default(), later, |recorder| recorder.session());
    assert_eq!(replayed(&file).differences, []);

    fn skips(reply: FrameBuf) -> Option<FrameBuf> {
        let (id, ctrl) = (reply.frame().id(), reply.frame().ctrl());
        let index: Option<QueuedCmdIndex> = reply.frame().read().ok().filter(|_| ctrl.queued());
        match index {
            Some(QueuedCmdIndex(index)) if index > 2 => {
                FrameBuf::encode(id, ctrl, &QueuedCmdIndex(index + 1)).ok()
            }
            _ => Some(reply),
        }
    }
    let file = recorded_of(Controller::default(), skips, |recorder| {
        for _ in 0..6 {
            recorder.set(WaitCmd { timeout: 1 }, Ctrl::QUEUED);
        }
    });
    let report = replayed(&file);
    assert_eq!(fields(&report), [("SetWAITCmd", "queued_cmd_index")]);
}

#[test]
fn the_arm_has_been_on_as_long_as_the_trace_says() {
    let mut old = Controller::default();
    old.advance(ArmInstant::from_micros(1234 * SECOND));
    let file = recorded_of(old, Some, |recorder| recorder.session());
    let replay = Replay::new(&file).unwrap();
    let mut arm = Controller::default();
    assert_eq!(replay.against(&mut arm).differences, []);
    // The trace lasts two seconds.
    assert_eq!(arm.now().as_micros(), 1236 * SECOND);
}

#[test]
fn a_lost_answer_is_told_and_does_not_shift_the_others() {
    fn no_index(reply: FrameBuf) -> Option<FrameBuf> {
        Some(reply).filter(|reply| !reply.frame().ctrl().queued())
    }
    let file = recorded_of(Controller::default(), no_index, |recorder| {
        recorder.session();
        recorder.pass(4 * SECOND);
        recorder.get(Pose::ROW);
    });
    let report = replayed(&file);
    let whats: Vec<_> = report.differences.iter().map(|found| found.what).collect();
    assert_eq!(whats, [DifferenceKind::Answered, DifferenceKind::Answered]);
    assert_eq!(report.answers, 85);
}

#[test]
fn damage_and_noise_reach_the_arm_as_they_were() {
    let file = recorded(|recorder| {
        let time = NOON + recorder.arm.now().as_micros();
        let link = recorder.link;
        for bytes in [&b"M10\r\n"[..], &[0xAA, 0xAA, 0x02, 0x0A, 0x00, 0xF7]] {
            recorder.trace.record(link, time, Request, bytes).unwrap();
        }
        recorder.get(Pose::ROW);
        let unknown = FrameBuf::new(0xEE, Ctrl::GET, &[]).unwrap();
        recorder.ask(&unknown);
        recorder.get(magician_protocol::commands::AlarmsState::ROW);
    });
    let report = replayed(&file);
    assert_eq!(report.differences, []);
    assert_eq!(
        (report.requests, report.answers, report.unanswered),
        (3, 2, 1)
    );
}

#[test]
fn measured_values_may_be_off_by_the_tolerance_and_settings_may_not() {
    fn moved(reply: FrameBuf) -> Option<FrameBuf> {
        let mut pose: Pose = match reply.frame().id() {
            10 => reply.frame().read().ok()?,
            _ => return Some(reply),
        };
        pose.z += 0.5;
        FrameBuf::encode(10, Ctrl::GET, &pose).ok()
    }
    let file = recorded_of(Controller::default(), moved, |recorder| {
        recorder.get(Pose::ROW)
    });
    assert_eq!(fields(&replayed(&file)), [("GetPose", "z")]);
    let tolerances = Tolerances {
        measured: 0.6,
        ..Tolerances::default()
    };
    let replay = Replay::new(&file).unwrap().tolerances(tolerances);
    assert_eq!(replay.against(&mut Controller::default()).found, 0);
}

#[test]
fn one_link_of_several() {
    let mut file = Vec::new();
    let mut trace = TraceWriter::new(&mut file).unwrap();
    let get_pose = FrameBuf::get(&NoArgs, Pose::ROW).unwrap();
    for name in ["usb", "wifi", "wifi"] {
        let link = trace.link(name).unwrap();
        trace.record(link, NOON, Request, get_pose.bytes()).unwrap();
    }
    drop(trace);
    let requests = |name: &str| {
        let replay = Replay::new(&file).unwrap().only_link(name).unwrap();
        replay.against(&mut Controller::default()).requests
    };
    assert_eq!(
        (requests("usb"), requests("wifi"), requests("2")),
        (1, 2, 1)
    );
    assert_eq!(replayed(&file).requests, 3);
    let wrong = Replay::new(&file).unwrap().only_link("ble").unwrap_err();
    assert_eq!(
        wrong.to_string(),
        "the trace has no link 'ble'; it has 'usb', 'wifi', 'wifi'"
    );
}

#[test]
fn files_that_cannot_be_replayed_are_refused_with_the_reason() {
    let good = recorded(|recorder| recorder.session());
    assert_eq!(Replay::new(&[]).unwrap_err(), ReplayError::Empty);
    let text = Replay::new(b"AA AA 02 0A 00 F6").unwrap_err();
    assert_eq!(text, ReplayError::Trace(TraceError::NotATrace));
    let cut = Replay::new(&good[..good.len() - 3]).unwrap_err();
    assert!(matches!(
        cut,
        ReplayError::Trace(TraceError::Truncated { .. })
    ));
    let nothing = recorded(|_| {});
    assert_eq!(Replay::new(&nothing).unwrap_err(), ReplayError::Empty);

    let written = |times: &[(u64, magician_protocol::Direction)]| {
        let mut file = Vec::new();
        let mut trace = TraceWriter::new(&mut file).unwrap();
        let link = trace.link("usb").unwrap();
        for (time, direction) in times {
            trace.record(link, *time, *direction, b"x").unwrap();
        }
        drop(trace);
        Replay::new(&file).map(drop)
    };
    let replies = written(&[(5, Reply), (6, Reply)]);
    assert_eq!(replies, Err(ReplayError::NoRequests { packets: 2 }));
    let back = written(&[(9, Request), (7, Request)]);
    let link = "usb".to_owned();
    assert_eq!(
        back,
        Err(ReplayError::Order {
            packet: 2,
            link,
            by: 2
        })
    );
    assert_eq!(written(&[(9, Request), (7, Reply)]), Ok(()));
    let long = written(&[(0, Request), (40 * 24 * 3600 * SECOND, Request)]);
    assert_eq!(long, Err(ReplayError::Span { days: 40 }));
}

proptest! {
    #[test]
    fn no_bytes_do_harm(
        bytes in prop::collection::vec((any::<bool>(), 0u64..200_000, prop::collection::vec(any::<u8>(), 0..40)), 1..40),
    ) {
        let mut file = Vec::new();
        let mut trace = TraceWriter::new(&mut file).unwrap();
        let link = trace.link("usb").unwrap();
        let mut now = NOON;
        for (reply, gap, bytes) in &bytes {
            now += gap;
            let direction = if *reply { Reply } else { Request };
            let frame = FrameBuf::new(bytes.first().copied().unwrap_or(10), Ctrl(gap.to_le_bytes()[0]), bytes).unwrap();
            trace.record(link, now, direction, bytes).unwrap();
            trace.record(link, now, direction, frame.bytes()).unwrap();
        }
        drop(trace);
        if let Ok(replay) = Replay::new(&file) {
            let once = replay.against(&mut Controller::default());
            prop_assert_eq!(once, replay.against(&mut Controller::default()));
        }
    }

    #[test]
    fn a_damaged_file_is_refused_or_replayed(at in 0usize..4000, bit in 0u8..8) {
        let mut file = recorded(|recorder| recorder.session());
        let at = at % file.len();
        file[at] ^= 1 << bit;
        if let Ok(replay) = Replay::new(&file) {
            let _ = replay.against(&mut Controller::default());
        }
    }
}
