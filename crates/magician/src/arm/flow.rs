//! Many commands in a row: never more than the queue holds, never less than it could do.

use std::collections::VecDeque;
use std::time::Duration;

use magician_protocol::commands::{
    DeviceWithL, HomeCmd, Pose, PoseL, QueuedCmdCurrentIndex, QueuedCmdStartExec,
};
use magician_protocol::{Alarm, Ctrl, FrameBuf, Set};
use tokio::sync::oneshot;
use tokio::time::{Instant, sleep};

use super::Arm;
use super::watch::{Progress, Watch};
use crate::connection::Request;
use crate::preflight::{Needs, refuse};
use crate::words::{Guards, Preflight, Readings};
use crate::{Error, ErrorKind, QueueIndex, Result};

/// How often a queue that has no room is looked at.
const FULL_PAUSE: Duration = Duration::from_millis(10);
/// How often a stream looks for alarms while it has room.
const LOOK_PAUSE: Duration = Duration::from_millis(100);

/// What is known of the room in the queue. Whoever puts commands into it holds this.
#[derive(Debug, Default)]
pub(super) struct Flow {
    /// Places known to be free.
    pub(super) room: u32,
}

/// How [`Arm::run_with`] treats a queue.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub struct RunOptions {
    /// Runs commands of an earlier program that still wait in the queue, before these.
    pub keep: bool,
}

impl RunOptions {
    /// Sets [`keep`](Self::keep).
    #[must_use]
    pub fn keep(mut self, keep: bool) -> Self {
        self.keep = keep;
        self
    }
}

/// What a run has done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Ran {
    /// How many commands the arm took and finished.
    pub commands: u64,
    /// Index of the first.
    pub first: Option<QueueIndex>,
    /// Index of the last.
    pub last: Option<QueueIndex>,
}

/// The request that queues a command.
pub(super) fn queued(command: &Set) -> Result<Request> {
    let row = command.row();
    if !row.queueable {
        let error = Error::invalid("it cannot be queued; set it at once");
        return Err(error.with_command(row.set_name));
    }
    Ok(Request::of(FrameBuf::set(command, Ctrl::QUEUED)?))
}

/// A command in flight.
struct InFlight {
    command: Set,
    frame: FrameBuf,
    answer: oneshot::Receiver<Result<FrameBuf>>,
    deadline: Instant,
}

impl Arm {
    /// Runs commands through the queue: puts them in as room allows, starts the queue, and returns
    /// when the last has finished. `progress` is called now and then.
    ///
    /// The commands are sent as they are; [`perform`](Self::perform) checks them first.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`] as soon as an alarm holds the queue,
    /// [`ErrorKind::InvalidInput`] when commands of an earlier
    /// program wait in the queue, [`ErrorKind::Closed`] when a stop came,
    /// else as [`enqueue`](Self::enqueue) and [`wait`](Self::wait). What was put into the queue
    /// before the error stays there: [`stop`](Self::stop) drops it.
    pub async fn run<C>(&self, commands: C, progress: impl FnMut(Progress)) -> Result<Ran>
    where
        C: IntoIterator<Item = Set>,
    {
        self.run_with(commands, RunOptions::default(), progress)
            .await
    }

    /// As [`run`](Self::run), with options.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub async fn run_with<C>(
        &self,
        commands: C,
        options: RunOptions,
        mut progress: impl FnMut(Progress),
    ) -> Result<Ran>
    where
        C: IntoIterator<Item = Set>,
    {
        let stops = self.stops();
        let mut commands = commands.into_iter();
        let total = match commands.size_hint() {
            (least, Some(most)) if least == most => Some(least as u64),
            _ => None,
        };
        let mut flow = self.take_turn(self.deadline(), "a run").await?;
        // Whoever goes away in the middle of a run leaves behind what has to be counted anew.
        flow.room = 0;
        self.mishap(None)?;
        let mut room = self.left_space().await?;
        self.note_room(room).await?;
        if !options.keep {
            self.refuse_strangers(room).await?;
        }
        self.warn_if_not_homed().await?;
        let mut ran = Ran::default();
        let mut watch = Watch::new(total, stops);
        let mut started = false;
        let mut looked = Instant::now();
        let mut next = commands.next();
        while next.is_some() {
            self.fill(&mut room, &mut next, &mut commands, &mut ran, stops)
                .await?;
            if !started {
                self.start_queue_unless_stopped(stops).await?;
                started = true;
            }
            if room == 0 {
                room = self.left_space().await?;
            }
            if room == 0 || looked.elapsed() >= LOOK_PAUSE {
                looked = Instant::now();
                watch.sent(ran.commands, ran.last);
                progress(self.look(&mut watch).await?);
            }
            if room == 0 {
                sleep(FULL_PAUSE).await;
                watch.not_stopped(self)?;
            }
        }
        drop(flow);
        if let Some(last) = ran.last {
            watch.sent(ran.commands, ran.last);
            self.watch_until(last, &mut watch, &mut progress).await?;
        }
        Ok(ran)
    }

    /// Checks a program as the arm stands now, before any of it is sent, and runs it.
    ///
    /// # Errors
    /// [`ErrorKind::Unreachable`] with value and limit and
    /// [`ErrorKind::InvalidInput`] from the check,
    /// [`ErrorKind::Alarm`] when one holds the queue already, else as
    /// [`run`](Self::run).
    pub async fn perform(&self, commands: &[Set]) -> Result<Ran> {
        self.perform_with(commands, Guards::default()).await
    }

    /// As [`perform`](Self::perform), refusing only what these guards refuse.
    ///
    /// # Errors
    /// As [`perform`](Self::perform).
    pub async fn perform_with(&self, commands: &[Set], guards: Guards) -> Result<Ran> {
        if guards.alarms || guards.require_homed {
            self.check_alarms(commands, guards).await?;
        }
        let check = self.preflight_for(commands).await?;
        check.guards(guards).program(commands)?;
        self.run(commands.iter().copied(), |_| {}).await
    }

    /// An alarm that holds the queue would let nothing of the program run but homing.
    async fn check_alarms(&self, commands: &[Set], guards: Guards) -> Result<()> {
        let homes = matches!(commands.first(), Some(Set::HomeCmd(_)));
        let alarms = self.alarms().await?;
        if guards.alarms && alarms.blocking() && !homes {
            return Err(Error::alarm(alarms));
        }
        let reset = alarms.contains(Alarm::ResetOccurred);
        let why = "the arm was reset and nobody has homed it since (`magician home`)";
        refuse(
            guards.require_homed && reset && !homes,
            "require_homed",
            why,
        )
    }

    /// What commands from here would meet: reads where the arm stands, its tool, and all speeds.
    ///
    /// While the arm moves, or has commands in its queue, its start is unknown; and where homing would
    /// lead is, but for [`preflight_for`](Self::preflight_for) a program that homes.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn preflight(&self) -> Result<Preflight> {
        let on_rail = self.get::<DeviceWithL>().await?.with_l.is_on();
        let needs = Needs {
            home: false,
            arc: true,
            path: true,
            rail: on_rail,
        };
        self.read(needs, on_rail).await
    }

    /// As [`preflight`](Self::preflight), reading only what these commands depend on.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn preflight_for(&self, commands: &[Set]) -> Result<Preflight> {
        let needs = Needs::of(commands);
        let on_rail = needs.rail && self.get::<DeviceWithL>().await?.with_l.is_on();
        self.read(needs, on_rail).await
    }

    async fn read(&self, needs: Needs, on_rail: bool) -> Result<Preflight> {
        let before = self.get::<Pose>().await?;
        let mut read = Readings {
            tool: self.get().await?,
            laser: self.get().await?,
            joint_speeds: self.get().await?,
            line_speeds: self.get().await?,
            ratios: self.get().await?,
            jump: self.get().await?,
            with_rail: on_rail,
            ..Readings::default()
        };
        if needs.home {
            read.home = match self.get().await {
                Ok(home) => Some(home),
                // An arm may have none to tell before one was set.
                Err(error) if error.kind() == ErrorKind::Unexpected => None,
                Err(error) => return Err(error),
            };
        }
        if needs.arc {
            read.arc_speeds = self.get().await?;
        }
        if needs.path {
            read.path_speeds = self.get().await?;
        }
        if needs.rail {
            read.rail = Some(self.get::<PoseL>().await?.pose_l);
            read.rail_speeds = self.get().await?;
        }
        let room = self.left_space().await?;
        let (_, capacity) = self.stats().await?;
        let waits = room < capacity;
        let pose = self.get::<Pose>().await?;
        read.pose = (!waits && pose == before).then_some(pose);
        Ok(Preflight::new(&read))
    }

    /// Homes the arm, waits until it is done, and clears the alarms (document 1.6.2). It takes up to
    /// half a minute.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub async fn home(&self) -> Result<()> {
        self.inner
            .warned
            .store(true, std::sync::atomic::Ordering::SeqCst);
        let home = Set::from(HomeCmd { reserved: 0 });
        self.run([home], |_| {}).await?;
        self.clear_alarms().await
    }

    /// Commands that others put into the queue and nobody has run are not run by accident.
    async fn refuse_strangers(&self, room: u32) -> Result<()> {
        let (_, capacity) = self.stats().await?;
        let waiting = capacity.saturating_sub(room);
        if waiting == 0 {
            return Ok(());
        }
        let current = self.get::<QueuedCmdCurrentIndex>().await?;
        let ours = self.own().waiting(current.queued_cmd_current_index);
        if ours >= u64::from(waiting) {
            return Ok(());
        }
        Err(Error::invalid(format!(
            "{waiting} commands of an earlier program wait in the arm's queue and would run first: \
             `magician stop` drops them, `--keep` runs them"
        )))
    }

    /// Lets the queue run, but not for a run that a stop has ended.
    async fn start_queue_unless_stopped(&self, stops: u64) -> Result<()> {
        let request = Request::set(&QueuedCmdStartExec {})?;
        let (frame, deadline) = (*request.frame(), self.deadline());
        let answer = self.submit(request, deadline, stops).await?;
        self.answer(answer, &frame, deadline).await.map(drop)
    }

    /// Puts commands into the queue until it has no room or there are none, up to a window at once.
    async fn fill(
        &self,
        room: &mut u32,
        next: &mut Option<Set>,
        commands: &mut impl Iterator<Item = Set>,
        ran: &mut Ran,
        stops: u64,
    ) -> Result<()> {
        let window = self.inner.options.window.max(1);
        let batch = Instant::now();
        let mut in_flight: VecDeque<InFlight> = VecDeque::with_capacity(window);
        loop {
            let fresh = batch.elapsed() < LOOK_PAUSE;
            while fresh && in_flight.len() < window && u64::from(*room) > in_flight.len() as u64 {
                let Some(command) = next.take() else { break };
                *next = commands.next();
                let request = queued(&command)?;
                let (frame, deadline) = (*request.frame(), self.deadline());
                let answer = self.submit(request, deadline, stops).await?;
                in_flight.push_back(InFlight {
                    command,
                    frame,
                    answer,
                    deadline,
                });
            }
            let Some(oldest) = in_flight.pop_front() else {
                return Ok(());
            };
            let reply = self
                .answer(oldest.answer, &oldest.frame, oldest.deadline)
                .await;
            let index = self.accepted(room, &oldest.command, reply)?;
            ran.commands += 1;
            ran.first = ran.first.or(Some(index));
            ran.last = Some(index);
        }
    }
}
