//! Virtual arm in this process: connected to like any other arm, and observable from outside.

use std::fmt;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use magician_motion::ToolBias;
use magician_sim::{
    Controller, ControllerState, LineTiming, Profile, Runner, Scenario, Speed, World,
};

use crate::SimSpeed;

mod cell;
mod sampling;

pub(crate) use cell::Cell;

/// Virtual arm in this process, for tests and simulations.
///
/// [`Arm::simulated`](crate::Arm::simulated) connects to it. This handle shows what the connection
/// cannot: the true position of the arm, the object it holds, the state of its world. Handles are
/// cheap to clone, and all refer to the same arm.
///
/// A cell with a cube and a belt, and a program that moves the cube to the belt:
///
/// ```
/// use magician::{Options, VirtualArm, blocking::Arm, sim::Scenario, build};
///
/// let scenario = Scenario::from_toml(r#"
///     tool = { kind = "suction" }
///     table = { height = -60 }
///     object = [{ name = "red cube", size = [20, 20, 20], at = [220, 80], color = "red" }]
///     conveyor = { start = [200, -200], direction = 90, length = 200, width = 60, height = -40, stepper = 0 }
/// "#)?;
/// let cell = VirtualArm::in_scenario(&scenario);
/// let arm = Arm::simulated(cell.clone(), Options::default())?;
/// arm.run(&[
///     build::jump_to(220.0, 80.0, -40.0, 0.0),
///     build::suction(true),
///     build::wait(std::time::Duration::from_millis(500)),
///     build::jump_to(200.0, -100.0, -20.0, 0.0),
///     build::suction(false),
///     build::wait(std::time::Duration::from_millis(500)),
/// ])?;
/// assert!(cell.with(|arm| arm.look().object("red cube").unwrap().on_belt()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct VirtualArm {
    cell: Arc<Mutex<Cell>>,
    /// Unique among all virtual arms that this process has had.
    number: u64,
}

impl Default for VirtualArm {
    /// Returns an arm just after power-up, in an empty world, at full speed.
    fn default() -> Self {
        Self::new(Controller::default(), SimSpeed::Max)
    }
}

impl From<Runner> for VirtualArm {
    fn from(runner: Runner) -> Self {
        static MADE: AtomicU64 = AtomicU64::new(0);
        Self {
            cell: Arc::new(Mutex::new(Cell::new(runner))),
            // Relaxed: only uniqueness matters.
            number: MADE.fetch_add(1, Ordering::Relaxed),
        }
    }
}

impl From<Controller> for VirtualArm {
    /// Creates an arm at full speed.
    fn from(controller: Controller) -> Self {
        Self::new(controller, SimSpeed::Max)
    }
}

impl fmt::Debug for VirtualArm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("VirtualArm")
            .field("state", &self.state())
            .finish()
    }
}

impl VirtualArm {
    /// True if the arm advances its clock itself (full speed or virtual time), instead of following
    /// the wall clock.
    pub(crate) fn passes_time_itself(&self) -> bool {
        self.lock().can_be_led()
    }

    /// Returns the number of this arm among the virtual arms of this process.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// Creates an arm at the end of a line without delay.
    #[must_use]
    pub fn new(controller: Controller, speed: SimSpeed) -> Self {
        let speed = match speed {
            SimSpeed::Max => Speed::Max,
            SimSpeed::Times(times) => Speed::Times(times),
        };
        Runner::new(controller, speed, LineTiming::default()).into()
    }

    /// Creates an arm just after power-up in the world of a scenario, at full speed.
    #[must_use]
    pub fn in_scenario(scenario: &Scenario) -> Self {
        Self::in_scenario_at(scenario, SimSpeed::Max)
    }

    /// Creates an arm as [`in_scenario`](Self::in_scenario) does, at this speed.
    #[must_use]
    pub fn in_scenario_at(scenario: &Scenario, speed: SimSpeed) -> Self {
        let world = World::from_scenario(scenario);
        Self::new(Controller::in_world(Profile::default(), world), speed)
    }

    /// Selects another tool, as if it was set before power-up: poses refer to its tip.
    ///
    /// The default is the suction cup, unless the scenario says otherwise; [`ToolBias::NONE`] is an
    /// arm whose tool was never set.
    ///
    /// ```
    /// use magician::{ToolBias, VirtualArm};
    ///
    /// assert_eq!(VirtualArm::default().state().pose.x.round(), 259.0);
    /// let arm = VirtualArm::default().tool(ToolBias::NONE);
    /// assert_eq!(arm.state().pose.x.round(), 199.0);
    /// ```
    #[must_use]
    pub fn tool(self, tool: ToolBias) -> Self {
        self.with(|arm| *arm = arm.clone().with_tool(tool));
        self
    }

    /// Puts the arm into virtual time: its clock runs only while the arm works, which takes no
    /// wall-clock time, and when [`advance`](Self::advance) is called.
    ///
    /// While the arm is idle nothing happens in its world, however long the program takes, so every
    /// run is the same run.
    ///
    /// Commands that a program runs (`run`, `start`, `move_to` and everything that waits for the
    /// queue) take, as at full speed, the time of a real arm whose host is never late. The clock
    /// advances only when the next commands are in the queue, as far as it accepts them, and all
    /// answers have arrived, so a path does not stop for lack of its next segment. The clock waits
    /// for up to a second of wall-clock time. If the program takes longer for its next command, or
    /// the arm owes an answer (a pulled cable), time follows the wall clock. Commands queued
    /// without a run finish before the next request is read, as at full speed.
    ///
    /// ```
    /// use std::time::Duration;
    /// use magician::{VirtualArm, sim::Scenario};
    ///
    /// let cell = VirtualArm::in_scenario(&Scenario::default()).in_virtual_time();
    /// cell.advance(Duration::from_secs(2));
    /// assert_eq!(cell.state().now.as_micros(), 2_000_000);
    /// ```
    #[must_use]
    pub fn in_virtual_time(self) -> Self {
        self.lock().stand();
        self
    }

    /// Makes the lines break when the cable is pulled, as those of a USB adapter do.
    ///
    /// A connection then loses its arm ([`Link`](crate::Link)), and reconnects once the cable is
    /// plugged in. By default frames are lost silently meanwhile, as over Wi-Fi.
    ///
    /// ```
    /// use magician::{Arm, ErrorKind, Options, VirtualArm, commands::Pose, sim::ExternalEvent};
    ///
    /// # #[tokio::main(flavor = "current_thread")]
    /// # async fn main() -> magician::Result<()> {
    /// let outside = VirtualArm::default().with_breaking_lines();
    /// let arm = Arm::simulated(outside.clone(), Options::default()).await?;
    /// outside.with(|arm| arm.inject(ExternalEvent::Cable { plugged: false }));
    /// let lost = arm.get::<Pose>().await.unwrap_err();
    /// assert_eq!(lost.kind(), ErrorKind::Port);
    /// outside.with(|arm| arm.inject(ExternalEvent::Cable { plugged: true }));
    /// arm.reconnected().await?;
    /// arm.get::<Pose>().await?;
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn with_breaking_lines(self) -> Self {
        self.lock().break_lines();
        self
    }

    /// Lets `time` pass at once, as if the program had waited for it: belts, scenarios and jogs
    /// continue. At full speed and in virtual time it is the arm's time, otherwise wall-clock time.
    pub fn advance(&self, time: Duration) {
        self.lock().put_forward(time);
        // Touching the cell lets the events of the passed time happen now, not at the next request.
        self.with(|_| ());
    }

    /// Returns the arm and its world in their current state, including motion: for
    /// [`restore`](Self::restore) or a [`Simulation`](crate::Simulation).
    #[must_use]
    pub fn snapshot(&self) -> Controller {
        self.with(|arm| arm.clone().without_peers())
    }

    /// Restores the arm and its world from a snapshot: queue, settings, alarms, motion and clock.
    ///
    /// ```
    /// use std::time::Duration;
    /// use magician::{Options, VirtualArm, blocking::Arm};
    ///
    /// let cell = VirtualArm::default().in_virtual_time();
    /// let before = cell.snapshot();
    /// let arm = Arm::simulated(cell.clone(), Options::default())?;
    /// assert!(cell.restore(&before).is_err());
    /// arm.close();
    /// cell.advance(Duration::from_secs(2));
    /// cell.restore(&before)?;
    /// assert_eq!(cell.state().now.as_micros(), 0);
    /// # Ok::<(), magician::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) while a connection is open, because its
    /// picture of the queue and the settings would be wrong.
    pub fn restore(&self, snapshot: &Controller) -> crate::Result<()> {
        let mut cell = self.lock();
        if cell.is_connected() {
            let why = "the virtual arm is connected, and the connection's picture of queue and settings would be wrong: \
                       close the arm, restore, and connect again";
            return Err(crate::Error::invalid(why));
        }
        cell.runner.replace(snapshot.clone());
        Ok(())
    }

    /// Power-cycles the arm in the world of a scenario; only its flash is kept. Its clock restarts,
    /// which shows a connection that the arm was reset when it reads the clock
    /// ([`DeviceTime`](crate::commands::DeviceTime)).
    ///
    /// ```
    /// use magician::{VirtualArm, sim::Scenario};
    ///
    /// let arm = VirtualArm::default();
    /// arm.restart_in(&Scenario::from_toml(Scenario::PICK_AND_SORT)?);
    /// assert!(arm.with(|arm| arm.look().objects().count()) > 0);
    /// # Ok::<(), magician::sim::ScenarioError>(())
    /// ```
    pub fn restart_in(&self, scenario: &Scenario) {
        let mut cell = self.lock();
        let now = cell.now();
        // Brought to the present first, so that the restart does not swallow events before it.
        cell.runner.handle_timeout(now);
        let world = World::from_scenario(scenario);
        let arm = cell.runner.controller().switched_on_in(world);
        cell.runner.replace(arm);
        cell.wake();
    }

    pub(crate) fn powered_up(speed: SimSpeed) -> Self {
        Self::new(Controller::new(Profile::default()), speed)
    }

    /// Observes the arm, or acts on it from outside: presses its key, drives an input, makes it
    /// slip. Its clock is brought to the present first. Connections wait meanwhile.
    pub fn with<T>(&self, act: impl FnOnce(&mut Controller) -> T) -> T {
        let mut cell = self.lock();
        let now = cell.now();
        cell.runner.handle_timeout(now);
        let outcome = act(cell.runner.controller_mut());
        // Once more: the action may have made an event due now.
        cell.runner.handle_timeout(now);
        cell.touched();
        cell.wake();
        outcome
    }

    /// Returns the state of the arm at the present instant.
    #[must_use]
    pub fn state(&self) -> ControllerState {
        self.with(|controller| controller.state())
    }

    /// Locks the cell, also after a panic in `act`: the arm is as consistent as after any step.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Cell> {
        self.cell.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
