//! Programs that are checked first.

use std::sync::atomic::Ordering;

use magician_protocol::commands::{ClearAlarmsState, DeviceWithL, HomeCmd, Pose, PoseL};
use magician_protocol::{Alarm, Set};

use super::Arm;
use super::run::{Ran, RunOptions};
use crate::connection::Request;
use crate::words::{Guards, Needs, Preflight, Readings, refuse};
use crate::{ErrorKind, Result};

impl Arm {
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
        let stops = self.stops();
        self.permit(commands)?;
        if guards.alarms || guards.require_homed {
            self.check_alarms(commands, guards).await?;
        }
        let check = self.preflight_for(commands).await?;
        check.clone().guards(guards).program(commands)?;
        let run = self.begin(commands.iter().copied(), RunOptions::default());
        let mut run = run.along(check).unless_stopped_since(stops);
        run.finish(|_| {}).await
    }

    /// Whether the arm is ready for these commands, as far as its alarms tell and these guards ask: what
    /// [`perform_with`](Self::perform_with) looks at first. An alarm that holds the queue lets nothing run but homing.
    ///
    /// # Errors
    /// [`ErrorKind::Alarm`] for the guard `alarms`, [`ErrorKind::InvalidInput`] for `require_homed`; else as
    /// [`get`](Self::get).
    pub async fn check_alarms(&self, commands: &[Set], guards: Guards) -> Result<()> {
        let homes = matches!(commands.first(), Some(Set::HomeCmd(_)));
        let alarms = self.alarms().await?;
        if guards.alarms && alarms.blocking() && !homes {
            return Err(self.stopped_by(alarms).await);
        }
        let reset = alarms.contains(Alarm::ResetOccurred);
        let why = "the arm was reset and nobody has homed it since (`magician home`)";
        refuse(
            guards.require_homed && reset && !homes,
            "require_homed",
            why,
        )
    }

    /// Whether the arm is ready for a program of many steps: as [`check_alarms`](Self::check_alarms), and with the laser dark,
    /// as every program begins. Whether commands of others wait in its queue, a run of nothing tells.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidInput`] when the laser is on, else as [`check_alarms`](Self::check_alarms).
    pub async fn check_ready(&self, commands: &[Set], guards: Guards) -> Result<()> {
        self.check_alarms(commands, guards).await?;
        self.check_dark().await
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

    pub(super) async fn read(&self, needs: Needs, on_rail: bool) -> Result<Preflight> {
        let before = self.get::<Pose>().await?;
        let mut read = Readings::default();
        read.tool = self.get().await?;
        read.laser = self.get().await?;
        read.joint_speeds = self.get().await?;
        read.line_speeds = self.get().await?;
        read.ratios = self.get().await?;
        read.jump = self.get().await?;
        read.with_rail = on_rail;
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
        let waits = self.waiting().await? > 0;
        let pose = self.get::<Pose>().await?;
        read.pose = (!waits && pose == before).then_some(pose);
        Ok(self.fenced(Preflight::new(&read).model(self.inner.options.model)))
    }

    /// Homes the arm, waits until it is done, and clears the alarms (document 1.6.2). It takes up to
    /// half a minute. A laser that is on goes out first.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub async fn home(&self) -> Result<()> {
        self.home_with(RunOptions::default()).await
    }

    /// As [`home`](Self::home), with options for what waits in the queue.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub async fn home_with(&self, options: RunOptions) -> Result<()> {
        self.inner.warned.store(true, Ordering::SeqCst);
        if self.laser().await? == Some(true) {
            self.darken().await?;
        }
        let home = Set::from(HomeCmd { reserved: 0 });
        self.run_with([home], options, |_| {}).await?;
        // Nothing waits that this could let run.
        self.ask(Request::set(&ClearAlarmsState {})?)
            .await
            .map(drop)
    }
}
