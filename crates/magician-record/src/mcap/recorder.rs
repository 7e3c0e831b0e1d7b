//! Recordings of a virtual arm, with all of its state.

use std::io::{self, Write};

use magician_protocol::{AlarmSet, FrameBuf};
use magician_sim::world::{Drawing, StrokeKind};
use magician_sim::{ArmInstant, Controller, ControllerState, LinkId, Observer, QueueState};

use super::file::{File, Topic};
use super::message::{Alarms, Joints, Log, PoseInFrame};
use super::scene::{ArmConfiguration, Ink, SAMPLES_PER_TRANSFORM, Scene};
use super::{Micros, SECOND};

mod lines;
mod state;

use lines::Lines;
use state::{Io, Queue, Status};

/// Sample interval on the arm's clock, us: the controller's period, so no pose is missed.
const PERIOD: Micros = 20_000;

/// Records a virtual arm.
///
/// The owner of the arm's clock must stop at the recorder's samples, as a
/// [`Runner`](magician_sim::Runner) and [`Controller::advance_observed`] do. A recorder that cannot
/// write keeps the first [error](Self::error) and asks for no further samples; the arm is not
/// affected.
///
/// ```
/// use magician_record::mcap::Recorder;
/// use magician_sim::{ArmInstant, Controller, Observer};
///
/// let mut arm = Controller::default();
/// let mut recorder = Recorder::new(Vec::new(), 0)?;
/// recorder.observe(&arm);
/// arm.advance_observed(ArmInstant::from_micros(1_000_000), &mut recorder);
/// let file = recorder.finish()?;
///
/// let poses = mcap::MessageStream::new(&file)?
///     .filter(|message| message.as_ref().is_ok_and(|message| message.channel.topic == "/pose"))
///     .count();
/// assert_eq!(poses, 51); // at 0, 20, .. 1000 ms
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Recorder<W: Write> {
    file: File<W>,
    lines: Lines,
    scene: Option<Scene>,
    /// Number of strokes in the scene, and of points of the last one.
    drawn: (usize, usize),
    /// Next multiple of [`PERIOD`] to record.
    next: Micros,
    /// Number of the next event to record.
    next_event: u64,
    /// State written last.
    last: Option<Last>,
    error: Option<io::Error>,
}

/// State that is written on change.
#[derive(Clone, PartialEq)]
struct Last {
    queue: QueueState,
    io: Io,
    alarms: AlarmSet,
    status: Status,
}

impl<W: Write> Recorder<W> {
    /// Begins a recording of an arm whose clock showed 0 at `epoch`, in nanoseconds since 1970 (or
    /// since any other origin that the reader will use).
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn new(out: W, epoch: u64) -> io::Result<Self> {
        Ok(Self {
            file: File::begin(out, "arm", epoch, &(SECOND / PERIOD).to_string())?,
            lines: Lines::default(),
            scene: None,
            drawn: (0, 0),
            next: 0,
            next_event: 0,
            last: None,
            error: None,
        })
    }

    /// Sets the name of a link in recorded frames; `link 3` by default.
    pub fn name(&mut self, link: LinkId, name: &str) {
        self.lines.name(link, name);
    }

    /// Error that ended the recording; `None` while it goes on.
    #[must_use]
    pub fn error(&self) -> Option<&io::Error> {
        self.error.as_ref()
    }

    /// Writes summary and index and returns the writer.
    ///
    /// # Errors
    /// Errors of the writer, now or at the first failed write.
    pub fn finish(self) -> io::Result<W> {
        match self.error {
            Some(error) => Err(error),
            None => self.file.finish(),
        }
    }

    /// Writes unless an earlier write has failed.
    fn attempt(&mut self, write: impl FnOnce(&mut Self) -> io::Result<()>) {
        if self.error.is_none() {
            self.error = write(self).err();
        }
    }

    fn see(&mut self, arm: &Controller) -> io::Result<()> {
        let (now, state) = (arm.now().as_micros(), arm.state());
        self.see_events(arm)?;
        let sample = now >= self.next && now.is_multiple_of(PERIOD);
        if sample {
            self.file
                .write(Topic::Pose, now, |t| PoseInFrame::new(t, &state.pose))?;
            self.file.write(Topic::Joints, now, |t| {
                Joints::new(t, &state.joints, state.rail)
            })?;
        }
        if now >= self.next {
            self.next = (now / PERIOD + 1).saturating_mul(PERIOD);
        }
        let full_second = sample && now.is_multiple_of(SECOND);
        if sample && now.is_multiple_of(SAMPLES_PER_TRANSFORM * PERIOD) {
            self.see_scene(arm, &state, full_second)?;
        }
        self.see_changes(arm, &state, full_second)?;
        // A killed program loses at most a second of the arm's clock.
        if full_second {
            self.file.flush()?;
        }
        Ok(())
    }

    /// Writes the frames of the links, and every second the strokes.
    fn see_scene(
        &mut self,
        arm: &Controller,
        state: &ControllerState,
        full_second: bool,
    ) -> io::Result<()> {
        let now = state.now.as_micros();
        let scene = { &mut self.scene }.get_or_insert_with(|| Scene::of(*arm.arm_model(), PERIOD));
        let configuration = ArmConfiguration {
            joints: state.joints,
            tool: state.tool,
            rail: state.rail,
        };
        scene.follow(&mut self.file, now, &configuration)?;
        if full_second {
            if let Some(drawing) = arm.world().drawing() {
                let table = { arm.world().scenario() }.and_then(|scenario| scenario.table());
                let height = table.map_or(state.pose.z, |table| table.height);
                self.drawn = add_strokes(scene, drawing, self.drawn, height);
            }
            scene.show(&mut self.file, now)?;
        }
        Ok(())
    }

    /// Writes everything that has changed; all of it if `again`.
    fn see_changes(
        &mut self,
        arm: &Controller,
        state: &ControllerState,
        again: bool,
    ) -> io::Result<()> {
        let now = state.now.as_micros();
        let seen = Last {
            queue: state.queue,
            io: Io::of(arm, state),
            alarms: state.alarms,
            status: Status::of(state),
        };
        let last = self.last.replace(seen.clone()).filter(|_| !again);
        let file = &mut self.file;
        if last.as_ref().is_none_or(|last| last.queue != seen.queue) {
            file.write(Topic::Queue, now, |t| Queue::new(t, &seen.queue))?;
        }
        if last.as_ref().is_none_or(|last| last.io != seen.io) {
            file.write(Topic::Io, now, |t| seen.io.at(t))?;
        }
        if last.as_ref().is_none_or(|last| last.alarms != seen.alarms) {
            file.write(Topic::Alarms, now, |t| Alarms::new(t, &seen.alarms))?;
        }
        if last.as_ref().is_none_or(|last| last.status != seen.status) {
            file.write(Topic::Status, now, |t| seen.status.at(t))?;
        }
        Ok(())
    }

    fn see_events(&mut self, arm: &Controller) -> io::Result<()> {
        let now = arm.now().as_micros();
        for (number, event) in arm.events() {
            // The arm's log holds 256 events: a gap in the numbers means that some were dropped.
            let missed = number.saturating_sub(self.next_event);
            if missed > 0 {
                self.file
                    .write(Topic::Events, now, |t| Log::missed(t, missed))?;
            }
            if number >= self.next_event {
                let words = event.in_words(arm.world().scenario());
                self.file
                    .write(Topic::Events, now, |t| Log::event(t, &event, words))?;
                self.next_event = number + 1;
            }
        }
        Ok(())
    }
}

/// Adds the strokes of a drawing beyond those already added. Returns the new counts of strokes and
/// of points of the last stroke.
fn add_strokes(
    scene: &mut Scene,
    drawing: &Drawing,
    (strokes, points): (usize, usize),
    height: f64,
) -> (usize, usize) {
    let all = drawing.strokes();
    let (strokes, points) = if strokes > all.len() {
        // The arm was restarted with an empty drawing.
        scene.clear();
        (0, 0)
    } else {
        (strokes, points)
    };
    let first = strokes.saturating_sub(1);
    for (at, stroke) in all.iter().enumerate().skip(first) {
        let known = if at + 1 == strokes { points } else { 0 };
        let ink = match stroke.kind {
            StrokeKind::Ink => Ink::Pen,
            StrokeKind::Burn => Ink::Laser,
        };
        let place = |[x, y]: [f64; 2]| [x, y, height];
        // A dot is a line of no length.
        if let ([only], 0) = (&*stroke.points, known) {
            scene.draw(ink, place(*only), place(*only));
        }
        for pair in stroke.points.windows(2).skip(known.saturating_sub(1)) {
            scene.draw(ink, place(pair[0]), place(pair[1]));
        }
    }
    (
        all.len(),
        all.last().map_or(0, |stroke| stroke.points.len()),
    )
}

impl<W: Write> Observer for Recorder<W> {
    fn next_sample(&self) -> Option<ArmInstant> {
        let next = ArmInstant::from_micros(self.next);
        self.error.is_none().then_some(next)
    }

    fn observe(&mut self, arm: &Controller) {
        self.attempt(|recorder| recorder.see(arm));
    }

    fn request_bytes(&mut self, now: ArmInstant, link: LinkId, bytes: &[u8]) {
        self.attempt(|Self { lines, file, .. }| {
            lines.push_bytes(file, now.as_micros(), link, bytes)
        });
    }

    fn silence(&mut self, now: ArmInstant, link: LinkId) {
        self.attempt(|Self { lines, file, .. }| lines.silence(file, now.as_micros(), link));
    }

    fn reply(&mut self, now: ArmInstant, link: LinkId, frame: &FrameBuf) {
        self.attempt(|Self { lines, file, .. }| {
            lines.push_reply(file, now.as_micros(), link, frame)
        });
    }

    fn closed(&mut self, link: LinkId) {
        self.lines.forget(link);
    }
}
