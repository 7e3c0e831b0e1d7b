//! A virtual arm that a program talks to like any other, and can also look at from outside.

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

/// A virtual arm in this process, for tests and simulations: [`Arm::simulated`](crate::Arm::simulated) connects to it,
/// and this handle shows what the connection cannot: where the arm really is, what it holds, what its world looks like.
///
/// Handles are cheap to clone; all are of the same arm.
///
/// A cell with a cube and a belt, and a program that puts one on the other:
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
    /// Unlike that of every other virtual arm of this process, also of one that is gone.
    number: u64,
}

impl Default for VirtualArm {
    /// An arm that has just been switched on, in an empty world, at full speed.
    fn default() -> Self {
        Self::new(Controller::default(), SimSpeed::Max)
    }
}

impl From<Runner> for VirtualArm {
    fn from(runner: Runner) -> Self {
        static MADE: AtomicU64 = AtomicU64::new(0);
        Self {
            cell: Arc::new(Mutex::new(Cell::new(runner))),
            number: MADE.fetch_add(1, Ordering::Relaxed),
        }
    }
}

impl From<Controller> for VirtualArm {
    /// At full speed.
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
    /// True if the arm lets its time pass itself, at full speed or in virtual time, and not with the wall's clock.
    pub(crate) fn passes_time_itself(&self) -> bool {
        self.lock().can_be_led()
    }

    /// Number of this arm among the virtual arms of this process.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// An arm at the end of a line that takes no time.
    #[must_use]
    pub fn new(controller: Controller, speed: SimSpeed) -> Self {
        let speed = match speed {
            SimSpeed::Max => Speed::Max,
            SimSpeed::Times(times) => Speed::Times(times),
        };
        Runner::new(controller, speed, LineTiming::default()).into()
    }

    /// An arm that has just been switched on in the world of a scenario, at full speed.
    #[must_use]
    pub fn in_scenario(scenario: &Scenario) -> Self {
        Self::in_scenario_at(scenario, SimSpeed::Max)
    }

    /// As [`in_scenario`](Self::in_scenario), at this speed.
    #[must_use]
    pub fn in_scenario_at(scenario: &Scenario, speed: SimSpeed) -> Self {
        let world = World::from_scenario(scenario);
        Self::new(Controller::in_world(Profile::default(), world), speed)
    }

    /// The same arm with another tool chosen before it was switched on: its poses are those of that tool. It has the suction cup
    /// unless its scenario says otherwise; [`ToolBias::NONE`] is an arm that was never told of a tool.
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

    /// The same arm in virtual time: its clock runs only for what the arm does, which takes no time as at full speed, and
    /// when [`advance`](Self::advance) says so. While the arm has nothing to do nothing happens in its world, however
    /// long the program takes: every run is the same run.
    ///
    /// What a program runs (`run`, `start`, `move_to` and all that waits for the arm's queue) takes, as at full speed, the time
    /// that it takes on a real arm whose host is never late: the clock goes on only when the next commands are in the queue, as far as
    /// it takes them, and all answers are there, so a path does not stop for want of its next segment. It waits so for a
    /// second of the wall's clock; while a program thinks about its next command for longer, or the arm owes it an answer
    /// (a cable that was pulled), time passes as on the wall. What is queued without a run is done before the next request is
    /// read, as at full speed.
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

    /// The same arm with lines that break when its cable is pulled, as those of a USB adapter do that is gone: a connection then has
    /// lost its arm ([`Link`](crate::Link)), and finds it again once the cable is in. Without this what is sent meanwhile is lost, as
    /// over Wi-Fi, and the connection hears nothing.
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

    /// Lets so much time pass at once, as if the program had waited for it: belts run on, scenarios go on, jogs go their way.
    /// At full speed and in virtual time it is time of the arm's clock, else time of the wall's.
    pub fn advance(&self, time: Duration) {
        self.lock().put_forward(time);
        self.with(|_| ());
    }

    /// The arm and its world as they are, in the midst of what they do: to [`restore`](Self::restore), or for a
    /// [`Simulation`](crate::Simulation).
    #[must_use]
    pub fn snapshot(&self) -> Controller {
        self.with(|arm| arm.clone().without_peers())
    }

    /// Puts arm and world back to a snapshot: its queue, its settings, its alarms, what moves, and its clock.
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
    /// [`InvalidInput`](crate::ErrorKind::InvalidInput) while a connection is open: its picture of the queue and the settings
    /// would be wrong from then on.
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

    /// Switches the arm off, and on again in the world of a scenario: all that it keeps is its flash. Its clock begins anew, by
    /// which a connection sees that the arm was reset when it asks for it ([`DeviceTime`](crate::commands::DeviceTime)).
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
        cell.runner.handle_timeout(now);
        let world = World::from_scenario(scenario);
        let arm = cell.runner.controller().switched_on_in(world);
        cell.runner.replace(arm);
        cell.wake();
    }

    pub(crate) fn powered_up(speed: SimSpeed) -> Self {
        Self::new(Controller::new(Profile::default()), speed)
    }

    /// Looks at the arm, or does something to it from outside: presses its key, drives an input, lets it slip. Its
    /// clock has come to the present. The connection waits meanwhile.
    pub fn with<T>(&self, act: impl FnOnce(&mut Controller) -> T) -> T {
        let mut cell = self.lock();
        let now = cell.now();
        cell.runner.handle_timeout(now);
        let outcome = act(cell.runner.controller_mut());
        cell.runner.handle_timeout(now);
        cell.touched();
        cell.wake();
        outcome
    }

    /// Everything about the arm at the present instant.
    #[must_use]
    pub fn state(&self) -> ControllerState {
        self.with(|controller| controller.state())
    }

    /// An `act` that has panicked leaves the arm as a step of its own did: whole.
    pub(crate) fn lock(&self) -> MutexGuard<'_, Cell> {
        self.cell.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
