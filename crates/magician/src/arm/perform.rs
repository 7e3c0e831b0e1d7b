//! Checked programs: read the settings, check every command, then run.
//!
//! The check plans from where the arm stands, with the settings that the commands depend on.
//! [`Arm::preflight_for`] finds out which these are, and reads only the values that the picture
//! does not know.

use std::sync::atomic::Ordering;

use magician_host::picture::QueueLook;
use magician_protocol::commands::{ClearAlarmsState, DeviceWithL, HomeCmd, Pose, PoseL};
use magician_protocol::{Alarm, AlarmSet, Set};

use super::Arm;
use super::run::{RunOptions, RunSummary};
use super::watch::Progress;
use crate::connection::Request;
use crate::preflight::{
    CheckedProgram, Guards, Needs, Preflight, Readings, doubt_in_words, refuse,
};
use crate::{Action, ErrorKind, RestDetector, Result};

/// Commands checked before other tasks get a turn. Choice: the check of a thousand takes
/// milliseconds.
const TURN: usize = 1024;

/// Checks a whole program including its end. Yields now and then, because a long program would
/// block the thread of other connections. An error names the step if there are several.
async fn check_all(check: Preflight, commands: &[Set]) -> Result<CheckedProgram> {
    let mut program = CheckedProgram::begin(check);
    if let [command] = commands {
        program.add(command)?;
    } else {
        for some in commands.chunks(TURN) {
            program.extend(some)?;
            if some.len() == TURN {
                // The driver of the connection may share this thread, and must not be starved.
                tokio::task::yield_now().await;
            }
        }
    }
    program.finish()?;
    Ok(program)
}

impl Arm {
    /// Runs commands as [`run`](Self::run) does, with options. `progress` is called now and then.
    ///
    /// # Errors
    /// Same as [`run`](Self::run).
    pub async fn run_with(
        &self,
        commands: &[Set],
        options: RunOptions,
        progress: impl FnMut(Progress),
    ) -> Result<RunSummary> {
        let stops = options.stops.unwrap_or_else(|| self.stops());
        let guards = options.guards;
        self.permission().check(commands)?;
        if guards.alarms || guards.require_homed {
            let alarms = self.known().alarms().await?;
            self.refuse_alarms(alarms, commands, guards).await?;
        }
        if (commands.iter()).any(|command| matches!(command, Set::HomeCmd(_))) {
            self.homing().expect().await;
        }
        let check = self.preflight_for(commands).await?;
        let program = check_all(check.guards(guards), commands).await?;
        if let Some(cause) = program.doubt().filter(|_| !self.is_virtual()) {
            let told = doubt_in_words(cause);
            tracing::warn!("{}: a motion leads where {told}", self.name());
        }
        let options = options.unless_stopped_since(stops);
        self.start_checked(program, options).wait(progress).await
    }

    pub(super) async fn refuse_alarms(
        &self,
        alarms: AlarmSet,
        commands: &[Set],
        guards: Guards,
    ) -> Result<()> {
        let homes = matches!(commands.first(), Some(Set::HomeCmd(_)));
        if guards.alarms && alarms.blocking() && !homes {
            return Err(self.stopped_by(alarms).await);
        }
        let reset = alarms.contains(Alarm::ResetOccurred);
        let why = "the arm was reset and not homed since";
        let refused = refuse(
            guards.require_homed && reset && !homes,
            "require_homed",
            why,
        );
        refused.map_err(|error| error.remedy(Action::Home, "homes it"))
    }

    /// Reads pose, tool and speeds, and returns a [`Preflight`] that starts there.
    ///
    /// After a stop over this connection it waits until the arm is at rest. While the arm moves, or
    /// has commands in its queue, the start is unknown. The home point is unknown too, unless
    /// [`preflight_for`](Self::preflight_for) is given a program that homes.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn preflight(&self) -> Result<Preflight> {
        self.come_to_rest().await?;
        let look = self.known().look_at_queue().await?;
        let on_rail = self.known().setting::<DeviceWithL>().await?.with_l.is_on();
        let needs = Needs {
            home: false,
            path: true,
            rail: on_rail,
        };
        self.read(needs, on_rail, &look).await
    }

    /// Reads as [`preflight`](Self::preflight) does, but only the settings these commands depend
    /// on.
    ///
    /// # Errors
    /// Same as [`get`](Self::get).
    pub async fn preflight_for(&self, commands: &[Set]) -> Result<Preflight> {
        self.come_to_rest().await?;
        // Finished commands of other programs invalidate known settings, and the queue shows them
        // first.
        let look = self.known().look_at_queue().await?;
        let needs = Needs::of(commands);
        let on_rail = needs.rail && self.known().setting::<DeviceWithL>().await?.with_l.is_on();
        self.read(needs, on_rail, &look).await
    }

    pub(super) async fn read(
        &self,
        needs: Needs,
        on_rail: bool,
        look: &QueueLook,
    ) -> Result<Preflight> {
        // With a fence the pose is always read, because a hand may have moved the arm.
        let known = self.picture().standing().pose(self.clock(), look);
        let known = known.filter(|_| self.fence().is_none());
        let mut rest = RestDetector::default();
        let before = match known {
            Some(pose) => pose,
            None => {
                let pose = self.get::<Pose>().await?;
                rest.see(self.clock(), pose);
                pose
            }
        };
        let mut read = Readings::at_power_up(self.model());
        read.settings.tool = self.known().setting().await?;
        read.laser = self.known().setting().await?;
        read.settings.ptp_joint = self.known().setting().await?;
        read.settings.ptp_coordinate = self.known().setting().await?;
        read.settings.ptp_common = self.known().setting().await?;
        read.settings.ptp_jump2 = self.known().setting().await?;
        read.settings.rail_setting.with_l = on_rail.into();
        if needs.home {
            read.home = match self.known().setting().await {
                Ok(home) => Some(home),
                // An arm may have no home point to report before one was set.
                Err(error) if error.kind() == ErrorKind::Unexpected => None,
                Err(error) => return Err(error),
            };
        }
        if needs.path {
            read.settings.cp = self.known().setting().await?;
        }
        if needs.rail {
            read.rail = Some(self.get::<PoseL>().await?.pose_l);
            read.settings.ptp_rail = self.known().setting().await?;
        }
        read.pose = match known {
            Some(pose) => Some(pose),
            None => self.known().stands_at(before, rest, look).await?,
        };
        Ok(self.fenced(Preflight::new(&read).model(*self.model())))
    }

    /// Homes as [`home`](Self::home) does, with options for the commands in the queue.
    ///
    /// # Errors
    /// Same as [`Run::wait`](super::Run::wait); [`ErrorCode::NotHomed`](crate::ErrorCode::NotHomed)
    /// if the homing was interrupted.
    pub async fn home_with(&self, options: RunOptions) -> Result<()> {
        // Homing itself clears the reset, so a warning before it would only confuse.
        self.inner
            .reset_asked
            .store(super::homing::READ_FOR_MOTION, Ordering::SeqCst);
        if self.laser().told().await? == Some(true) {
            self.laser().switch_off().await?;
        }
        self.homing().expect().await;
        let home = Set::from(HomeCmd { reserved: 0 });
        self.start_with([home], options).wait(|_| {}).await?;
        self.homing().check_ended()?;
        // Clearing starts a held queue, but it is empty after the run; so no permission is needed.
        self.ask(Request::set(&ClearAlarmsState {})?)
            .await
            .map(drop)
    }
}
