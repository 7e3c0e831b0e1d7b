//! Residue of logs against the law of motion: sessions with commands, and readings alone.

use magician_protocol::Direction::{Reply, Request};
use magician_protocol::commands::{
    ArcCmd, ClearAlarmsState, CpCmd, HomeCmd, JogCmd, JogCommonParams, JogCoordinateParams, Pose,
    PtpCmd, PtpCommonParams, QueuedCmdStartExec,
};
use magician_protocol::{CpMode, Ctrl, Flag, FrameBuf, JogCommand, NoArgs, PtpMode, Readable, Set};
use magician_record::csv::Csv;
use magician_record::jsonl::JsonLines;
use magician_record::law::{
    Basis, Kind, LIMIT, LawGap, LawReport, LogError, Sample, Samples, Speeds,
};
use magician_record::replay::Replay;
use magician_record::trace::{TraceLink, TraceWriter};
use magician_record::{Reading, WriteReadings, mcap};
use magician_sim::{Controller, LinkId, Profile};

const NOON: u64 = 1_800_000_000_000_000;
/// Interval between two poses: 23 per second, not a whole number of periods.
const INTERVAL_US: u64 = 43_000;

/// A host that reads poses of a virtual arm in virtual time, with a jittering clock.
struct Host<'f> {
    trace: TraceWriter<&'f mut Vec<u8>>,
    link: TraceLink,
    arm: Controller,
    /// Largest error of the time of a pose, us.
    jitter: u64,
    /// Delay of commands, unknown to the host, us.
    command_late: u64,
    interval: u64,
    random: u64,
    samples: Vec<Sample>,
}

/// A session as a trace, and its poses alone.
struct Log {
    trace: Vec<u8>,
    readings: Samples,
}

impl Log {
    fn of(profile: Profile, fill: impl FnOnce(&mut Host<'_>)) -> Self {
        Self::read_every(INTERVAL_US, 2_000, profile, fill)
    }

    fn read_every(
        interval: u64,
        jitter: u64,
        profile: Profile,
        fill: impl FnOnce(&mut Host<'_>),
    ) -> Self {
        let mut file = Vec::new();
        let mut trace = TraceWriter::new(&mut file).unwrap();
        let link = trace.link("./arm").unwrap();
        let mut host = Host {
            trace,
            link,
            arm: Controller::new(profile),
            jitter,
            command_late: 0,
            interval,
            random: 1,
            samples: Vec::new(),
        };
        // An arbitrary instant within a period: the host does not know the phase of the arm's
        // periods.
        host.arm.advance(host.arm.now().after_micros(7_300));
        fill(&mut host);
        let samples = std::mem::take(&mut host.samples);
        drop(host);
        Self {
            trace: file,
            readings: Samples {
                samples,
                cut: false,
            },
        }
    }

    fn by_commands(&self) -> LawReport {
        LawReport::of_session(&Replay::new(&self.trace).unwrap(), None)
    }

    fn by_readings(&self) -> LawReport {
        LawReport::of_samples(&self.readings, None)
    }
}

impl Host<'_> {
    fn random_up_to(&mut self, most: u64) -> u64 {
        self.random = self
            .random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.random >> 33) % (most + 1)
    }

    /// Sends a command, which reaches the arm later than the host believes.
    fn send(&mut self, frame: &FrameBuf) {
        let sent_at = NOON + self.arm.now().as_micros();
        let late = self.command_late;
        self.arm.advance(self.arm.now().after_micros(late));
        (self.trace)
            .record(self.link, sent_at, Request, frame.bytes())
            .unwrap();
        let reply = self.arm.exchange(LinkId(9), frame.bytes()).remove(0);
        (self.trace)
            .record(self.link, sent_at + late, Reply, reply.bytes())
            .unwrap();
    }

    fn set(&mut self, set: impl Into<Set>, ctrl: Ctrl) {
        self.send(&FrameBuf::set(&set.into(), ctrl).unwrap());
    }

    /// Reads poses for a while. Each request reaches the arm later than the host believes.
    fn read_poses(&mut self, seconds: f64) {
        let end = self.arm.now().after_micros((seconds * 1e6) as u64);
        let request = FrameBuf::get(&NoArgs, Pose::ROW).unwrap();
        while self.arm.now() < end {
            let sent_at = NOON + self.arm.now().as_micros();
            let late = self.random_up_to(self.jitter);
            self.arm.advance(self.arm.now().after_micros(late));
            (self.trace)
                .record(self.link, sent_at, Request, request.bytes())
                .unwrap();
            let reply = self.arm.exchange(LinkId(9), request.bytes()).remove(0);
            (self.trace)
                .record(self.link, sent_at + 3_000, Reply, reply.bytes())
                .unwrap();
            let pose: Pose = reply.frame().read().unwrap();
            let [j1, j2, j3, j4] = pose.joint_angle;
            let values = [pose.x, pose.y, pose.z, pose.r, j1, j2, j3, j4].map(f64::from);
            let t = (sent_at - NOON) as f64 / 1e6;
            self.samples.push(Sample { t, values });
            self.arm
                .advance(self.arm.now().after_micros(self.interval - late));
        }
    }

    fn begin(&mut self) {
        self.set(ClearAlarmsState {}, Ctrl::SET);
        self.set(QueuedCmdStartExec {}, Ctrl::SET);
        self.read_poses(0.5);
    }

    fn jog(&mut self, is_joint: bool, cmd: u8, seconds: f64) {
        let is_joint = Flag::from(is_joint);
        let jog = |cmd| JogCmd {
            is_joint,
            cmd: JogCommand::from(cmd),
        };
        self.set(jog(cmd), Ctrl::SET);
        self.read_poses(seconds);
        self.set(jog(0), Ctrl::SET);
        self.read_poses(1.5);
    }

    fn moves(&mut self, ptp_mode: PtpMode, [x, y, z, r]: [f32; 4]) {
        let ptp = PtpCmd {
            ptp_mode,
            x,
            y,
            z,
            r,
        };
        self.set(ptp, Ctrl::QUEUED);
        self.read_poses(4.0);
    }
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 0.005 * b
}

/// The speeds of one kind.
fn speeds_of(report: &LawReport, kind: Kind) -> Speeds {
    let mut found = report.speeds.iter().filter(|speeds| speeds.kind == kind);
    *found
        .next()
        .unwrap_or_else(|| panic!("{kind:?} {report:#?}"))
}

fn assert_zero(report: &LawReport) {
    assert_eq!(report.profile.as_deref(), Some("3.6.14"), "{report:#?}");
    assert_eq!(report.period_ms, Some(20.0));
    let best = &report.residues[0];
    assert!(best.mm < 0.002 && best.deg < 0.002, "{report:#?}");
    assert_eq!(best.same, ["3.7.0", "4.0.3"]);
    assert_eq!(report.residues[1].profile, "continuous");
}

fn jogs(host: &mut Host<'_>) {
    host.begin();
    host.jog(false, 1, 1.5);
    host.jog(false, 4, 1.2);
    host.jog(true, 1, 1.5);
}

#[test]
fn jogs_leave_no_residue_and_reveal_period_acceleration_and_ratio() {
    let log = Log::of(Profile::default(), jogs);
    let report = log.by_commands();
    assert_zero(&report);
    assert_eq!(
        (report.basis, &report.untold[..]),
        (Basis::Commands, &[][..])
    );
    let speeds_at_half = |kind, acceleration, speed| Speeds {
        kind,
        acceleration,
        speed: Some(speed),
        ratio: Some(50.0),
    };
    assert_eq!(
        report.speeds,
        [
            speeds_at_half(Kind::JogSpace, 60.0, 30.0),
            speeds_at_half(Kind::JogJoint, 50.0, 7.5)
        ]
    );
    let report = log.by_readings();
    assert_zero(&report);
    assert_eq!(
        (report.basis, &report.untold[..]),
        (Basis::Readings, &[][..])
    );
    assert_eq!(
        speeds_of(&report, Kind::StraightWay),
        speeds_at_half(Kind::StraightWay, 60.0, 30.0)
    );
    assert_eq!(
        speeds_of(&report, Kind::JointWay),
        speeds_at_half(Kind::JointWay, 50.0, 7.5)
    );
}

#[test]
fn commands_logged_in_a_neighbouring_period_leave_no_residue() {
    let log = Log::of(Profile::default(), |host| {
        host.begin();
        for (nth, cmd) in [2, 4, 1, 3, 2, 6, 1, 5].into_iter().enumerate() {
            // Alternately: sent and received just before the end of a period, and sent before the
            // end but received after it.
            let (phase, late) = [(19_500, 400), (19_000, 2_500)][nth % 2];
            let now = host.arm.now().as_micros();
            host.arm
                .advance(host.arm.now().after_micros(20_000 + phase - now % 20_000));
            host.command_late = late;
            host.jog(false, cmd, 0.7);
        }
    });
    // No phase of the periods explains all commands.
    let session = Replay::new(&log.trace).unwrap();
    let arm = Controller::new(session.beginning(Profile::default()));
    let fitted = session.fitted(&arm);
    let plain = fitted.against(&mut arm.clone()).residue;
    assert!(plain.mm > 0.1, "{:?} {plain:?}", fitted.shift());
    assert!(fitted.residue(&arm).mm < 1e-4);
    assert_zero(&log.by_commands());
}

#[test]
fn moves_from_point_to_point_leave_no_residue() {
    let log = Log::of(Profile::default(), |host| {
        host.begin();
        host.moves(PtpMode::MovlXyz, [220.0, 80.0, 40.0, 0.0]);
        host.moves(PtpMode::MovjAngle, [-30.0, 40.0, 30.0, 10.0]);
        host.moves(PtpMode::MovlXyzInc, [0.0, 3.0, 0.0, 0.0]);
    });
    assert_zero(&log.by_commands());
    let report = log.by_readings();
    assert_zero(&report);
    let line = speeds_of(&report, Kind::StraightWay);
    assert!(close(line.acceleration, 100.0), "{report:#?}");
    let joints = speeds_of(&report, Kind::JointWay);
    assert!(close(joints.acceleration, 100.0), "{report:#?}");
}

#[test]
fn paths_arcs_jumps_and_homing_leave_no_residue_by_their_commands() {
    let log = Log::of(Profile::default(), |host| {
        host.begin();
        host.moves(PtpMode::MovlXyz, [220.0, 0.0, 40.0, 0.0]);
        host.moves(PtpMode::JumpXyz, [200.0, 60.0, 30.0, 0.0]);
        for nth in 1..=20_u8 {
            let cp = CpCmd {
                cp_mode: CpMode::Relative,
                x: if nth % 2 == 0 { 2.0 } else { 0.5 },
                y: -1.0,
                z: 0.0,
                velocity_or_power: 0.0,
            };
            host.set(cp, Ctrl::QUEUED);
        }
        host.read_poses(3.0);
        let arc = ArcCmd {
            cir_point: [240.0, 0.0, 30.0, 0.0],
            to_point: [220.0, -40.0, 30.0, 0.0],
        };
        host.set(arc, Ctrl::QUEUED);
        host.read_poses(4.0);
        host.set(HomeCmd { reserved: 0 }, Ctrl::QUEUED);
        host.read_poses(25.0);
    });
    let report = log.by_commands();
    assert_zero(&report);
    assert!(report.moving > 100, "{report:#?}");
    // Poses alone do not explain curved motions.
    let untold = log.by_readings().untold;
    assert!(
        untold
            .iter()
            .any(|what| matches!(what, LawGap::Bent { .. })),
        "{untold:?}"
    );
}

#[test]
fn continuous_time_is_identified_as_its_profile() {
    let log = Log::of(Profile::continuous(), jogs);
    for report in [log.by_commands(), log.by_readings()] {
        assert_eq!(report.profile.as_deref(), Some("continuous"), "{report:#?}");
        assert_eq!(report.period_ms, Some(0.0));
        assert!(report.residues[0].mm <= LIMIT, "{report:#?}");
        assert!(report.residues[1].mm > 2.0 * LIMIT, "{report:#?}");
    }
}

#[test]
fn changed_settings_are_found_whether_set_in_the_log_or_before() {
    let set = |host: &mut Host<'_>| {
        let params = JogCoordinateParams {
            velocity: [80.0; 4],
            acceleration: [120.0; 4],
        };
        host.set(params, Ctrl::SET);
        let ratios = JogCommonParams {
            velocity_ratio: 55.0,
            acceleration_ratio: 10.0,
        };
        host.set(ratios, Ctrl::SET);
        host.begin();
        host.jog(false, 2, 1.5);
        host.jog(false, 4, 1.2);
    };
    let log = Log::of(Profile::default(), set);
    let report = log.by_commands();
    assert_zero(&report);
    let expected = Speeds {
        kind: Kind::JogSpace,
        acceleration: 120.0,
        speed: Some(44.0),
        ratio: Some(55.0),
    };
    assert_eq!(report.speeds, [expected]);
    // The same settings at power-up, without the frames that set them.
    let mut profile = Profile::default();
    profile.defaults.jog.coordinate_velocity = [80.0; 4];
    profile.defaults.jog.coordinate_acceleration = [120.0; 4];
    profile.defaults.jog.velocity_ratio = 55.0;
    let before = Log::of(profile.clone(), |host| {
        host.begin();
        host.jog(false, 2, 1.5);
        host.jog(false, 4, 1.2);
    });
    let report = before.by_commands();
    assert_zero(&report);
    assert_eq!(report.basis, Basis::Readings);
    assert_eq!(report.untold[0], LawGap::SetBefore);
    let measured = speeds_of(&report, Kind::StraightWay);
    assert!(close(measured.acceleration, 120.0), "{measured:?}");
    assert!(
        measured.speed.is_some_and(|speed| close(speed, 44.0)),
        "{measured:?}"
    );
    // 120 mm/s2 is not the acceleration of a power-up jog.
    assert_eq!(measured.ratio, None);
    assert!(report.untold.contains(&LawGap::Ratio));
    // A profile with these settings fits the commands.
    let session = Replay::new(&before.trace).unwrap();
    let report = LawReport::of_session(&session, Some(("own".to_owned(), profile)));
    assert_eq!(report.profile.as_deref(), Some("own"), "{report:#?}");
}

#[test]
fn a_ratio_of_a_move_scales_speed_and_acceleration() {
    let log = Log::of(Profile::default(), |host| {
        let ratios = PtpCommonParams {
            velocity_ratio: 20.0,
            acceleration_ratio: 20.0,
        };
        host.set(ratios, Ctrl::SET);
        host.begin();
        host.moves(PtpMode::MovlXyz, [220.0, 80.0, 40.0, 0.0]);
    });
    let report = log.by_readings();
    assert_zero(&report);
    let measured = speeds_of(&report, Kind::StraightWay);
    assert_eq!(
        (measured.acceleration, measured.speed, measured.ratio),
        (40.0, Some(40.0), Some(20.0))
    );
}

#[test]
fn noise_is_residue_and_hides_neither_period_nor_acceleration() {
    let mut log = Log::of(Profile::default(), jogs);
    let mut random = 7_u64;
    for sample in &mut log.readings.samples {
        for value in &mut sample.values {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            *value += ((random >> 33) % 1001) as f64 * 1e-5 - 0.005;
        }
    }
    let report = log.by_readings();
    assert_eq!(report.profile.as_deref(), Some("3.6.14"), "{report:#?}");
    let best = &report.residues[0];
    assert!((0.003..0.015).contains(&best.mm), "{report:#?}");
    let measured = speeds_of(&report, Kind::StraightWay);
    assert!((measured.acceleration - 60.0).abs() < 1.0, "{measured:?}");
}

#[test]
fn report_lists_what_a_log_does_not_reveal() {
    let still = Log::of(Profile::default(), |host| host.read_poses(3.0));
    assert_eq!(still.by_commands().untold, [LawGap::AtRest]);
    assert_eq!(still.by_readings().untold, [LawGap::AtRest]);

    let slow = Log::read_every(500_000, 0, Profile::default(), |host| {
        host.begin();
        host.moves(PtpMode::MovlXyz, [220.0, 80.0, 40.0, 0.0]);
    });
    let report = slow.by_readings();
    assert!(
        report.untold.contains(&LawGap::Slow { every_ms: 500 }),
        "{report:#?}"
    );
    assert!(
        report.untold.contains(&LawGap::Sparse { motions: 1 }),
        "{report:#?}"
    );
    assert_eq!(
        (report.profile, report.period_ms, report.speeds.len()),
        (None, None, 0)
    );

    // Read at a multiple of the period, a motion in steps looks like a continuous one.
    let even = Log::read_every(100_000, 0, Profile::default(), jogs).by_readings();
    assert!(even.untold.contains(&LawGap::Alike), "{even:#?}");
    assert_eq!(even.period_ms, None);
    assert!(
        close(speeds_of(&even, Kind::StraightWay).acceleration, 60.0),
        "{even:#?}"
    );

    // A log that starts and ends during a motion.
    let mut open = Log::of(Profile::default(), jogs).readings;
    open.samples.retain(|sample| (1.0..1.6).contains(&sample.t));
    let report = LawReport::of_samples(&open, None);
    assert_eq!(report.untold, [LawGap::Open { motions: 1 }]);

    let one = Samples {
        samples: open.samples[..1].to_vec(),
        cut: false,
    };
    let report = LawReport::of_samples(&one, None);
    assert_eq!((report.untold, report.profile), (vec![LawGap::Brief], None));
}

/// The readings of a log in each file format.
fn files(log: &Samples) -> Vec<Vec<u8>> {
    let write = |mut out: Box<dyn WriteReadings + '_>| {
        for sample in &log.samples {
            let [x, y, z, r, joints @ ..] = sample.values.map(|value| value as f32);
            let pose = Pose {
                x,
                y,
                z,
                r,
                joint_angle: joints,
            };
            out.write(&Reading {
                t: sample.t,
                step: None,
                pose,
                rail: None,
                index: 0,
                left_space: 32,
                capacity: 32,
                alarms: Default::default(),
            })
            .unwrap();
        }
        out.note(1e9, true, "the cable was pulled").unwrap();
        out.finish().unwrap();
    };
    let (mut plain, mut units, mut lines, mut mcap) = Default::default();
    let began = std::time::UNIX_EPOCH;
    write(Box::new(Csv::new(&mut plain, began, false, false).unwrap()));
    write(Box::new(Csv::new(&mut units, began, true, true).unwrap()));
    write(Box::new(JsonLines::new(&mut lines)));
    write(Box::new(mcap::Readings::new(&mut mcap, 0, 20.0).unwrap()));
    vec![plain, units, lines, mcap]
}

#[test]
fn all_recording_formats_give_the_same_result() {
    let log = Log::of(Profile::default(), jogs);
    for file in files(&log.readings) {
        let read = Samples::read(&file).unwrap();
        assert_eq!(read.samples.len(), log.readings.samples.len());
        let report = LawReport::of_samples(&read, None);
        assert_zero(&report);
        assert_eq!(speeds_of(&report, Kind::StraightWay).acceleration, 60.0);
    }
}

#[test]
fn file_that_is_not_a_log_is_refused_with_the_reason() {
    let read = |text: &str| Samples::read(text.as_bytes()).map(|log| (log.samples.len(), log.cut));
    let line = |line, what: &str| {
        Err(LogError::Line {
            line,
            what: what.to_owned(),
        })
    };
    assert_eq!(read(""), Err(LogError::Empty));
    assert_eq!(read(" \n\n"), Err(LogError::Empty));
    assert_eq!(read("t,x,y,z\n"), Err(LogError::Empty));
    assert_eq!(read("{\"t\":1,\"event\":\"x\"}\n"), Err(LogError::Empty));
    assert_eq!(read("G1 X10\n"), Err(LogError::Foreign));
    assert_eq!(read("{\"steps\":[]}\n"), Err(LogError::Foreign));
    assert_eq!(Samples::read(b"\xff\xfe\x00"), Err(LogError::Foreign));
    assert_eq!(read("t,x,y,z\n0,1,2,3\n"), Ok((1, false)));
    assert_eq!(read("t,x,y,z\n0,1,NaN,3\n"), line(2, "y is NaN"));
    assert_eq!(read("t,x,y,z\n0,1,inf,3\n"), line(2, "y is inf"));
    assert_eq!(
        read("t,x,y,z\n0,1,2\n1,1,2,3\n"),
        line(2, "z is '', which is no number")
    );
    assert_eq!(
        read("t,x,y,z\n1,1,2,3\n0,1,2,3\n"),
        line(3, "its time is before that of the line before")
    );
    assert_eq!(read("t,x,y,z\n0,1,2,3\n0.1,1,"), Ok((1, true)));
    let good = "{\"t\":0,\"x\":1,\"y\":2,\"z\":3}\n";
    assert_eq!(read(good), Ok((1, false)));
    assert_eq!(read(&format!("{good}{{\"t\":0.1,\"x")), Ok((1, true)));
    assert!(matches!(
        read(&format!("{good}nonsense\n{good}")),
        Err(LogError::Line { line: 2, .. })
    ));
    assert_eq!(
        read(&format!("{good}{{\"t\":0.1,\"x\":1}}\n")),
        line(2, "t, x, y or z is missing")
    );
    let cut = Samples::read(b"t,x,y,z\n0,1,2,3\n0.1,1,").unwrap();
    assert_eq!(
        LawReport::of_samples(&cut, None).untold,
        [LawGap::Cut, LawGap::Brief]
    );
}

#[test]
fn damaged_recording_is_refused_or_read_up_to_the_damage() {
    let log = Log::of(Profile::default(), jogs).readings;
    let file = files(&log).pop().unwrap();
    for end in [0, 8, 9, 100, file.len() / 2, file.len() - 1] {
        if let Ok(read) = Samples::read(&file[..end]) {
            assert!(read.samples.len() <= log.samples.len());
        }
    }
}
