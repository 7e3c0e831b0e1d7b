//! Virtual arms and their worlds: access to state, objects and inputs without the protocol.

use magician::sim::scenario::Scenario;
use magician::sim::world::{ExternalEvent, ObjectView, Press, Support};
use magician::sim::{Controller, Profile, World};
use magician::{Arm, Error, JointAngles, SimSpeed, ToolBias, VirtualArm};
use magician_picture::Snapshot;
use magician_protocol::Port;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::call::Call;
use crate::core::{self, Core, seconds};
use crate::picture::{Ink, Picture};
use crate::serving::{EndpointAddresses, Served, serve_arm};
use crate::simulation::Saved;
use crate::{errors, values};

/// Connectors of sensors by name.
const SENSOR_PORTS: [(&str, Port); 4] = [
    ("GP1", Port::Gp1),
    ("GP2", Port::Gp2),
    ("GP4", Port::Gp4),
    ("GP5", Port::Gp5),
];

/// A virtual arm and its world.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Cell {
    pub(crate) arm: VirtualArm,
}

impl Cell {
    /// Runs `operation` on the controller with the interpreter's lock released.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        operation: impl FnOnce(&mut Controller) -> T + Send,
    ) -> T {
        py.detach(|| self.arm.with(operation))
    }
}

/// Parses a scenario.
///
/// # Errors
/// `magician.errors.InvalidInputError` for an invalid scenario.
pub(crate) fn scenario_of(py: Python<'_>, text: Option<&str>) -> PyResult<Option<Scenario>> {
    let scenario = text.map(Scenario::from_toml).transpose();
    scenario.map_err(|error| errors::raise(py, &Error::invalid(format!("scenario: {error}"))))
}

/// Creates a controller that has just been switched on in the world of a scenario. `tool` is the
/// bias stored before power-up; `None` for the default.
pub(crate) fn controller(scenario: Option<&Scenario>, tool: Option<[f64; 3]>) -> Controller {
    let world = scenario.map(World::from_scenario);
    let controller = Controller::in_world(Profile::default(), world.unwrap_or_default());
    match tool {
        Some([x, y, z]) => controller.with_tool(ToolBias::new(x, y, z)),
        None => controller,
    }
}

/// State of an object at one instant.
struct ObjectState {
    name: String,
    size: [f64; 3],
    color: [u8; 3],
    place: [f64; 4],
    rest: String,
    seen_by: Vec<&'static str>,
}

impl ObjectState {
    fn of(object: &ObjectView<'_>, names: &[String]) -> Self {
        let place = object.place();
        let rest = match object.rest() {
            Support::Table => "table".to_owned(),
            Support::Belt => "belt".to_owned(),
            Support::Shelf => "shelf".to_owned(),
            Support::Tool => "tool".to_owned(),
            Support::Object(below) => names.get(usize::from(below)).cloned().unwrap_or_default(),
            _ => "floor".to_owned(),
        };
        let ports = SENSOR_PORTS
            .into_iter()
            .filter(|(_, port)| object.seen_by(*port));
        Self {
            name: object.name().to_owned(),
            size: object.size(),
            color: object.color().0,
            place: [place.x, place.y, place.z, place.yaw],
            rest,
            seen_by: ports.map(|(name, _)| name).collect(),
        }
    }
}

#[pymethods]
impl Cell {
    /// Creates a virtual arm in the world of a scenario. Without a speed it runs in virtual time;
    /// speed 0 is full speed. `tool` is the bias set before power-up, if not the default.
    #[new]
    #[pyo3(signature = (scenario, speed, tool = None))]
    fn new(
        py: Python<'_>,
        scenario: Option<&str>,
        speed: Option<f64>,
        tool: Option<[f64; 3]>,
    ) -> PyResult<Self> {
        let controller = controller(scenario_of(py, scenario)?.as_ref(), tool);
        let arm = match speed {
            None => VirtualArm::new(controller, SimSpeed::Max).in_virtual_time(),
            Some(0.0) => VirtualArm::new(controller, SimSpeed::Max),
            Some(times) if times > 0.0 && times.is_finite() => {
                VirtualArm::new(controller, SimSpeed::Times(times))
            }
            Some(other) => {
                let error = Error::invalid(format!(
                    "the speed must be a number above 0 (1 is real time), not {other}"
                ));
                return Err(errors::raise(py, &error));
            }
        };
        Ok(Self { arm })
    }

    /// Connects to the arm.
    #[pyo3(signature = (*, timeout, window, probe, reconnect, echo, fence = None, trace = None))]
    // Each Python keyword is an argument.
    #[allow(clippy::too_many_arguments)]
    fn connect(
        &self,
        py: Python<'_>,
        timeout: f64,
        window: usize,
        probe: bool,
        reconnect: bool,
        echo: f64,
        fence: Option<&str>,
        trace: Option<std::path::PathBuf>,
    ) -> PyResult<Call> {
        let options = core::options(py, timeout, window, probe, reconnect, echo)?;
        let options = core::with_trace(core::with_fence(py, options, fence)?, trace)?;
        let arm = self.arm.clone();
        Core::connecting(py, async move { Arm::simulated(arm, options).await })
    }

    /// Serves the arm to other programs.
    fn serve(&self, py: Python<'_>, addresses: EndpointAddresses) -> PyResult<Served> {
        serve_arm(py, self.arm.clone(), addresses)
    }

    /// Title of the scenario.
    fn title(&self, py: Python<'_>) -> Option<String> {
        self.with(py, |arm| {
            let scenario = arm.world().scenario()?;
            scenario.title().map(str::to_owned)
        })
    }

    /// Current state of the arm.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let state = self.with(py, |arm| arm.state());
        let parts = PyDict::new(py);
        parts.set_item("time", state.now.as_micros() as f64 / 1e6)?;
        parts.set_item("pose", state.pose.to_array())?;
        parts.set_item("joints", state.joints.to_array())?;
        parts.set_item("true_joints", state.true_joints.to_array())?;
        parts.set_item("moving", state.moving)?;
        parts.set_item("homed", state.homed)?;
        parts.set_item("alarms", values::alarms(py, &state.alarms)?)?;
        parts.set_item("waiting", state.queue.waiting)?;
        parts.set_item("index", state.queue.current_index)?;
        parts.set_item("running", state.queue.running.is_some())?;
        parts.set_item("suction", state.suction.commanded)?;
        parts.set_item("gripper_closed", state.gripper.commanded)?;
        parts.set_item("holding", state.holding)?;
        parts.set_item("laser", state.laser_power)?;
        parts.set_item("rail", state.rail)?;
        parts.set_item("belt", self.with(py, |arm| arm.look().belt_travel()))?;
        Ok(parts)
    }

    /// Current state of all objects.
    fn objects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let states = self.with(py, |arm| {
            let look = arm.look();
            let names: Vec<String> = look
                .objects()
                .map(|object| object.name().to_owned())
                .collect();
            look.objects()
                .map(|object| ObjectState::of(&object, &names))
                .collect::<Vec<_>>()
        });
        let objects = PyList::empty(py);
        for state in states {
            let parts = PyDict::new(py);
            parts.set_item("name", state.name)?;
            parts.set_item("size", state.size)?;
            parts.set_item("color", state.color.map(u32::from))?;
            parts.set_item("place", state.place)?;
            parts.set_item("rest", state.rest)?;
            parts.set_item("seen_by", state.seen_by)?;
            objects.append(parts)?;
        }
        Ok(objects)
    }

    /// Advances the clock by a number of seconds.
    fn advance(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        let time = seconds(py, "the time", time)?;
        py.detach(|| self.arm.advance(time));
        Ok(())
    }

    /// Sets a digital input. Returns false if the address has no digital input.
    fn set_input(&self, py: Python<'_>, address: i64, level: bool) -> bool {
        let address = u8::try_from(address);
        address.is_ok_and(|address| self.with(py, |arm| arm.set_input(address, level)))
    }

    /// Sets an analog input, 0 to 4095. Returns false if the address has no analog input.
    fn set_analog(&self, py: Python<'_>, address: i64, value: u16) -> bool {
        let address = u8::try_from(address);
        address.is_ok_and(|address| self.with(py, |arm| arm.set_analog(address, value)))
    }

    fn press_key(&self, py: Python<'_>, long: bool) {
        let press = if long { Press::Long } else { Press::Short };
        self.with(py, |arm| arm.press(press));
    }

    fn unlock(&self, py: Python<'_>, held: bool) {
        self.with(py, |arm| arm.unlock(held));
    }

    fn guide(&self, py: Python<'_>, joints: [f64; 4]) {
        self.with(py, |arm| arm.guide(JointAngles::from(joints)));
    }

    fn slip(&self, py: Python<'_>, joint: u8, degrees: f64) -> PyResult<()> {
        if !(1..=4).contains(&joint) || !degrees.is_finite() {
            let error = Error::invalid(format!(
                "J{joint} cannot slip by {degrees} deg: joints are 1 to 4"
            ));
            return Err(errors::raise(py, &error));
        }
        self.with(py, |arm| arm.inject(ExternalEvent::Slip { joint, degrees }));
        Ok(())
    }

    fn raise_alarm(&self, py: Python<'_>, code: u8) {
        self.with(py, |arm| arm.inject(ExternalEvent::Alarm(code)));
    }

    fn plug(&self, py: Python<'_>, plugged: bool) {
        self.with(py, |arm| arm.inject(ExternalEvent::Cable { plugged }));
    }

    fn delay(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        let time = seconds(py, "the time", time)?;
        self.with(py, |arm| arm.inject(ExternalEvent::Delay(time)));
        Ok(())
    }

    fn reset(&self, py: Python<'_>) {
        self.with(py, |arm| arm.inject(ExternalEvent::Reset));
    }

    /// Events since the last call, as sentences; routine events are omitted.
    fn events(&self, py: Python<'_>) -> Vec<String> {
        self.with(py, |arm| {
            let mut lines = Vec::new();
            while let Some(event) = arm.poll_event() {
                if !event.is_routine() {
                    lines.push(event.in_words(arm.world().scenario()).to_string());
                }
            }
            lines
        })
    }

    /// Strokes of pen and laser.
    fn drawing(&self, py: Python<'_>) -> Ink {
        Ink::new(self.with(py, |arm| arm.drawing()))
    }

    /// Snapshot of the arm and its world.
    fn save(&self, py: Python<'_>) -> Saved {
        Saved::new(py.detach(|| self.arm.snapshot()))
    }

    /// Restores the arm and its world from a snapshot.
    fn restore(&self, py: Python<'_>, saved: &Saved) -> PyResult<()> {
        let done = py.detach(|| self.arm.restore(&saved.arm));
        done.map_err(|error| errors::raise(py, &error))
    }

    /// Picture of the arm and its world.
    fn snapshot(&self, py: Python<'_>) -> Picture {
        // Draw a copy, so that the arm is not blocked meanwhile.
        let arm = self.with(py, |arm| arm.clone());
        Picture::new(py.detach(|| Snapshot::of_world(&arm).to_svg().to_owned()))
    }
}
