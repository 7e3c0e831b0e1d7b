//! Readings of a host as a recording.

use std::io::{self, Write};

use magician_motion::{ArmModel, JointAngles, Pose, ToolBias};
use magician_protocol::Direction;

use super::file::{File, Topic};
use super::frames::HostLine;
use super::message::{Alarms, HostQueue, Joints, Log, PoseInFrame};
use super::scene::{ArmConfiguration, Ink, SAMPLES_PER_TRANSFORM, Scene};
use super::{Micros, SECOND};
use crate::{Reading, WriteReadings};

/// Writes readings of a host to the topics of a recording, with the same schemas.
///
/// Values that were not read are absent. Queue and alarms are written on change, and every second.
///
/// ```
/// use magician_protocol::commands::Pose;
/// use magician_record::mcap::Readings;
/// use magician_record::{Reading, WriteReadings};
///
/// let pose = Pose { x: 200.0, y: 0.0, z: 0.0, r: 0.0, joint_angle: [0.0, 45.0, 45.0, 0.0] };
/// let alarms = Default::default();
/// let first = Reading { t: 0.0, step: None, pose, rail: None, index: 0, left_space: 32, capacity: 32, alarms };
/// let mut readings = Readings::new(Vec::new(), 0, 20.0)?;
/// readings.write(&first)?;
/// readings.write(&Reading { t: 0.05, ..first })?;
/// let file = readings.into_file()?;
///
/// let topics: Vec<_> = mcap::MessageStream::new(&file)?
///     .map(|message| message.map(|message| message.channel.topic.clone()))
///     .collect::<Result<_, _>>()?;
/// let frames = ["/tf"; 7]; // of the turret, and of everything that it carries
/// assert_eq!(topics[..2], ["/pose", "/joints"]);
/// assert_eq!(topics[2..9], frames);
/// assert_eq!(topics[9..], ["/scene", "/queue", "/alarms", "/pose", "/joints"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Readings<W: Write> {
    file: File<W>,
    scene: Scene,
    /// Paper on which a pen draws.
    paper: Option<Plane>,
    /// Positions of the tip on the paper since the last corner.
    pen: Vec<[f64; 3]>,
    /// Time at which frames are written next, and their interval.
    transforms: (Micros, Micros),
    lines: Vec<HostLine>,
    last: Option<Reading>,
    /// Time at which everything is written again.
    again: Micros,
}

impl<W: Write> Readings<W> {
    /// Begins a recording at `rate` readings per second, on a clock that showed 0 at `epoch`, in
    /// nanoseconds since 1970.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(out: W, epoch: u64, rate: f64) -> io::Result<Self> {
        // A rate of 0 would divide by zero; below one reading in ten seconds the value has no use.
        let period = micros(1.0 / rate.max(0.1)).max(1);
        Ok(Self {
            file: File::begin(out, "host", epoch, &rate.to_string())?,
            scene: Scene::of(ArmModel::MAGICIAN, period),
            paper: None,
            pen: Vec::new(),
            transforms: (0, SAMPLES_PER_TRANSFORM * period),
            lines: Vec::new(),
            last: None,
            again: 0,
        })
    }

    /// Sets the paper of a mounted pen: its lines are written as strokes, straight from reading to
    /// reading.
    #[must_use]
    pub fn on_paper(mut self, paper: Plane) -> Self {
        self.paper = Some(paper);
        self
    }

    /// Writes the frames that bytes of a line complete, `t` seconds after the start, and bytes
    /// outside of frames.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn passed(
        &mut self,
        t: f64,
        line: &str,
        direction: Direction,
        bytes: &[u8],
    ) -> io::Result<()> {
        let known = self.lines.iter().position(|known| known.name() == line);
        let known = known.unwrap_or_else(|| {
            self.lines.push(HostLine::of(line));
            self.lines.len() - 1
        });
        self.lines[known].push_bytes_after_silence(&mut self.file, micros(t), direction, bytes)
    }

    /// Writes summary and index and returns the writer.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn into_file(mut self) -> io::Result<W> {
        self.draw(None);
        let last = self.last.map_or(0, |last| micros(last.t));
        for line in &mut self.lines {
            line.end(&mut self.file, last)?;
        }
        self.scene.show(&mut self.file, last)?;
        self.file.finish()
    }
}

/// A plane on which a pen draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Height at x = y = 0, mm in the arm's coordinates.
    pub height: f64,
    /// Rise per mm of x and of y.
    pub slope: [f64; 2],
}

impl Plane {
    /// Height above the plane up to which a pen draws, mm. An arm that brakes joint by
    /// joint rises less above its line, and a lifted pen is higher.
    const AT_PAPER: f64 = 0.3;

    fn has(&self, [x, y, z]: [f64; 3]) -> bool {
        let [along_x, along_y] = self.slope;
        z <= self.height + along_x * x + along_y * y + Self::AT_PAPER
    }
}

/// Largest distance of readings from a line that joins them, mm ..
const STRAIGHT: f64 = 0.05;
/// .. and most readings on one line, which bounds the check of each new reading.
const LONGEST: usize = 64;

/// Distance of a point from a line segment, mm.
fn off_chord(point: [f64; 3], from: [f64; 3], to: [f64; 3]) -> f64 {
    let along = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let there = [0, 1, 2].map(|axis| point[axis] - from[axis]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let share = dot(along, there) / dot(along, along).max(1e-12);
    let share = share.clamp(0.0, 1.0);
    let off = [0, 1, 2].map(|axis| there[axis] - share * along[axis]);
    libm::sqrt(dot(off, off))
}

/// Tool bias that follows from a pose and its joints.
fn tool_of(pose: &Pose, joints: &JointAngles) -> ToolBias {
    let bare = ArmModel::MAGICIAN.geometry(ToolBias::default());
    let wrist = bare.forward(joints);
    let (sin, cos) = (
        libm::sin(joints.j1.to_radians()),
        libm::cos(joints.j1.to_radians()),
    );
    let [x, y] = [pose.x - wrist.x, pose.y - wrist.y];
    // A bias has tenths of a millimetre; a reading has the digits of binary32.
    let tenth = |mm: f64| (mm * 10.0).round() / 10.0;
    ToolBias::new(
        tenth(x * cos + y * sin),
        tenth(y * cos - x * sin),
        tenth(wrist.z - pose.z),
    )
}

impl<W: Write> Readings<W> {
    /// Continues the pen's line at `tip`, or ends it if `None`.
    fn draw(&mut self, tip: Option<[f64; 3]>) {
        let Some(first) = self.pen.first().copied() else {
            self.pen.extend(tip);
            return;
        };
        let last = self.pen.last().copied().unwrap_or(first);
        let goes_on = |tip| {
            let strays = |point: &[f64; 3]| off_chord(*point, first, tip) > STRAIGHT;
            self.pen.len() < LONGEST && !self.pen.iter().any(strays)
        };
        match tip {
            Some(tip) if tip == last => {}
            Some(tip) if goes_on(tip) => self.pen.push(tip),
            _ => {
                if first != last {
                    self.scene.draw(Ink::Pen, first, last);
                }
                self.pen.clear();
                self.pen.extend(tip.map(|_| last));
                self.pen.extend(tip);
            }
        }
    }

    /// Writes the frames of the links, and the strokes.
    fn write_scene(
        &mut self,
        now: Micros,
        all: bool,
        configuration: &ArmConfiguration,
        pose: &Pose,
    ) -> io::Result<()> {
        let tip = [pose.x, pose.y, pose.z];
        let touches = self.paper.is_some_and(|paper| paper.has(tip));
        // Strokes are in the frame of the rail, where the arm slides along Y.
        let along = configuration.rail.unwrap_or(0.0);
        self.draw(touches.then_some([pose.x, pose.y + along, pose.z]));
        if now >= self.transforms.0 {
            let period = self.transforms.1;
            self.transforms.0 = (now / period + 1).saturating_mul(period);
            self.scene.follow(&mut self.file, now, configuration)?;
        }
        if all {
            self.scene.show(&mut self.file, now)?;
        }
        Ok(())
    }
}

fn micros(seconds: f64) -> Micros {
    (seconds * 1e6) as Micros
}

impl<W: Write> WriteReadings for Readings<W> {
    fn write(&mut self, reading: &Reading) -> io::Result<()> {
        let now = micros(reading.t);
        let all = now >= self.again;
        let last = self.last.replace(*reading).filter(|_| !all);
        let file = &mut self.file;
        let place = [
            reading.pose.x,
            reading.pose.y,
            reading.pose.z,
            reading.pose.r,
        ];
        let pose = Pose::from(place.map(f64::from));
        let joints = JointAngles::from(reading.pose.joint_angle.map(f64::from));
        file.write(Topic::Pose, now, |t| PoseInFrame::new(t, &pose))?;
        file.write(Topic::Joints, now, |t| {
            Joints::new(t, &joints, reading.rail)
        })?;
        let configuration = ArmConfiguration {
            tool: tool_of(&pose, &joints),
            joints,
            rail: reading.rail,
        };
        self.write_scene(now, all, &configuration, &pose)?;
        let file = &mut self.file;
        let queue = |of: &Reading| (of.capacity, of.left_space, of.index);
        if last.is_none_or(|last| queue(&last) != queue(reading)) {
            file.write(Topic::Queue, now, |timestamp| HostQueue {
                timestamp,
                capacity: reading.capacity,
                waiting: reading.capacity.saturating_sub(reading.left_space),
                current_index: reading.index,
            })?;
        }
        if last.is_none_or(|last| last.alarms != reading.alarms) {
            file.write(Topic::Alarms, now, |t| Alarms::new(t, &reading.alarms))?;
        }
        if all {
            self.again = now.saturating_add(SECOND);
        }
        Ok(())
    }

    fn note(&mut self, t: f64, warning: bool, words: &str) -> io::Result<()> {
        self.file.write(Topic::Events, micros(t), |t| {
            Log::noticed(t, warning, words)
        })
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.into_file().map(drop)
    }
}
