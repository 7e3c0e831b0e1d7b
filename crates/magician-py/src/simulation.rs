//! Virtual arms that are stepped directly, many at once, with the interpreter's lock released.
//!
//! Each arm has its own random numbers from the seed plus its index, so that results do not depend
//! on the number of threads.

use std::sync::{Mutex, MutexGuard, PoisonError};

use magician::faults::Dice;
use magician::sim::Controller;
use magician::sim::scenario::Scenario;
use magician::{ActionKind, Error, JointAngles, Observation, Simulation, StepAction};
use magician_picture::{View, pixels};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyByteArray, PyBytes};

use crate::cell::{controller, scenario_of};
use crate::core::seconds;
use crate::errors;
use crate::program::{floats, numbers};

/// Initial conditions of arms.
struct Start {
    scenario: Option<Scenario>,
    tool: Option<[f64; 3]>,
    speed: Option<f64>,
    /// Largest random offset of each object in x and y, mm, and of each joint, deg.
    object_noise: f64,
    joint_noise: f64,
}

/// An arm with its random number generator.
#[derive(Clone)]
struct SimulatedArm {
    arm: Simulation,
    dice: Dice,
}

impl Start {
    fn begin(&self, mut dice: Dice) -> Result<SimulatedArm, Error> {
        let mut share = || dice.share();
        let scattered = match &self.scenario {
            Some(scenario) if self.object_noise > 0.0 => {
                Some(scenario.scattered(self.object_noise, &mut share))
            }
            _ => None,
        };
        let mut arm = controller(scattered.as_ref().or(self.scenario.as_ref()), self.tool);
        if self.joint_noise > 0.0 {
            let joints = arm.state().joints.to_array();
            let joints = joints.map(|joint| joint + (share() * 2.0 - 1.0) * self.joint_noise);
            // Guide the arm by hand: that takes no time and queues nothing.
            arm.unlock(true);
            arm.guide(JointAngles::from(joints));
            arm.unlock(false);
        }
        let arm = Simulation::new(arm, self.speed)?;
        Ok(SimulatedArm { arm, dice })
    }
}

/// An arm and its world at an instant.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Saved {
    pub(crate) arm: Controller,
    one: Option<SimulatedArm>,
}

impl Saved {
    pub(crate) fn new(arm: Controller) -> Self {
        Self { arm, one: None }
    }
}

#[pymethods]
impl Saved {
    /// Clock of the arm, s.
    fn time(&self) -> f64 {
        self.arm.now().as_micros() as f64 / 1e6
    }
}

/// Arms that are stepped.
#[pyclass(frozen, module = "magician._magician")]
pub(crate) struct Sims {
    start: Start,
    kind: ActionKind,
    arms: Mutex<Vec<SimulatedArm>>,
}

/// Rows of pose, joints and time; and rows of flags: moving, refused, alarm, holding.
type SnapshotRows<'py> = (Bound<'py, PyBytes>, Bound<'py, PyBytes>);

fn snapshot_rows<'py>(py: Python<'py>, seen: &[Observation]) -> SnapshotRows<'py> {
    let row = |seen: &Observation| {
        let [x, y, z, r] = seen.pose;
        let [j1, j2, j3, j4] = seen.joints;
        [x, y, z, r, j1, j2, j3, j4, seen.time]
    };
    let values: Vec<[f64; 9]> = seen.iter().map(row).collect();
    let flags = |seen: &Observation| [seen.moving, seen.refused, seen.alarm, seen.holding];
    let flags: Vec<u8> = seen.iter().flat_map(flags).map(u8::from).collect();
    (numbers(py, values.as_flattened()), PyBytes::new(py, &flags))
}

/// Applies `act` to each arm, on up to `threads` threads. The results do not depend on the number
/// of threads.
fn for_each_arm<T: Send>(
    arms: &mut [SimulatedArm],
    threads: usize,
    act: impl Fn(usize, &mut SimulatedArm) -> T + Sync,
) -> Vec<T> {
    let part = arms.len().div_ceil(threads.max(1)).max(1);
    let act = &act;
    std::thread::scope(|scope| {
        let mut parts = arms.chunks_mut(part).enumerate().map(|(nth, arms)| {
            move || {
                let arms = arms.iter_mut().enumerate();
                arms.map(|(at, one)| act(nth * part + at, one))
                    .collect::<Vec<T>>()
            }
        });
        let own = parts.next();
        let others: Vec<_> = parts.map(|part| scope.spawn(part)).collect();
        let mut done = own.map_or_else(Vec::new, |mut own| own());
        for other in others {
            match other.join() {
                Ok(more) => done.extend(more),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        done
    })
}

impl Sims {
    fn arms(&self) -> MutexGuard<'_, Vec<SimulatedArm>> {
        self.arms.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Runs `act` on one arm with the interpreter's lock released.
    fn with<T: Send>(
        &self,
        py: Python<'_>,
        nth: usize,
        act: impl FnOnce(&mut SimulatedArm) -> T + Send,
    ) -> PyResult<T> {
        let done = py.detach(|| self.arms().get_mut(nth).map(act));
        done.ok_or_else(|| {
            PyIndexError::new_err(format!("there is no arm {nth}: they count from 0"))
        })
    }
}

#[pymethods]
impl Sims {
    #[new]
    #[pyo3(signature = (count, scenario, tool, action, speed, seed, object_noise, joint_noise))]
    // Each Python keyword is an argument.
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        count: usize,
        scenario: Option<&str>,
        tool: Option<[f64; 3]>,
        action: &str,
        speed: Option<f64>,
        seed: u64,
        object_noise: f64,
        joint_noise: f64,
    ) -> PyResult<Self> {
        let scenario = scenario_of(py, scenario)?;
        let mut kinds = ActionKind::NAMED.iter();
        let Some((_, kind)) = kinds.find(|(name, _)| *name == action) else {
            let names: Vec<&str> = ActionKind::NAMED.iter().map(|(name, _)| *name).collect();
            let why = format!("unknown action {action:?}; there are {}", names.join(", "));
            return Err(errors::raise(py, &Error::invalid(why)));
        };
        let start = Start {
            scenario,
            tool,
            speed,
            object_noise,
            joint_noise,
        };
        let begun: Result<Vec<SimulatedArm>, Error> = py.detach(|| {
            let seeds = (seed..).take(count);
            seeds.map(|seed| start.begin(Dice::new(seed))).collect()
        });
        let arms = begun.map_err(|error| errors::raise(py, &error))?;
        Ok(Self {
            start,
            kind: *kind,
            arms: Mutex::new(arms),
        })
    }

    /// Resets all or the marked arms. Without a seed each continues its own random sequence.
    fn reset(
        &self,
        py: Python<'_>,
        seed: Option<u64>,
        which: Option<&[u8]>,
        threads: usize,
    ) -> PyResult<()> {
        let done = py.detach(|| {
            let marked = |nth: usize| {
                which.is_none_or(|which| which.get(nth).is_some_and(|mark| *mark != 0))
            };
            let begin = |nth: usize, one: &mut SimulatedArm| {
                if marked(nth) {
                    let dice = match seed {
                        Some(seed) => Dice::new(seed.wrapping_add(nth as u64)),
                        None => one.dice.clone(),
                    };
                    *one = self.start.begin(dice)?;
                }
                Ok(())
            };
            for_each_arm(&mut self.arms(), threads, begin)
                .into_iter()
                .collect::<Result<(), Error>>()
        });
        done.map_err(|error| errors::raise(py, &error))
    }

    /// Steps all arms. A row holds a target and, in a fifth column, the tool.
    fn step<'py>(
        &self,
        py: Python<'py>,
        actions: &[u8],
        columns: usize,
        time: Option<f64>,
        threads: usize,
    ) -> PyResult<SnapshotRows<'py>> {
        let time = time.map(|time| seconds(py, "dt", time)).transpose()?;
        let values = floats(actions);
        let seen = py.detach(|| {
            let mut arms = self.arms();
            if values.len() != arms.len() * columns || !(4..=5).contains(&columns) {
                return None;
            }
            let step = |nth: usize, one: &mut SimulatedArm| {
                let row = values.get(nth * columns..).unwrap_or_default();
                let tool = row.get(4).filter(|_| columns == 5);
                let action = StepAction {
                    target: row.first_chunk::<4>().copied(),
                    tool: tool.filter(|tool| !tool.is_nan()).map(|tool| *tool > 0.0),
                };
                one.arm.step(self.kind, action, time)
            };
            Some(for_each_arm(&mut arms, threads, step))
        });
        let seen = seen.ok_or_else(|| PyValueError::new_err("as many actions as arms"))?;
        Ok(snapshot_rows(py, &seen))
    }

    /// Snapshots of all arms.
    fn look<'py>(&self, py: Python<'py>) -> SnapshotRows<'py> {
        let seen: Vec<_> = py.detach(|| self.arms().iter().map(|one| one.arm.observe()).collect());
        snapshot_rows(py, &seen)
    }

    /// Names of the objects.
    fn names(&self) -> Vec<String> {
        let scenario = self.start.scenario.iter();
        let objects = scenario.flat_map(|scenario| scenario.objects());
        objects.map(|object| object.name.clone()).collect()
    }

    /// Rows of x, y, z and yaw: the objects of the first arm, of the second, ..
    fn objects<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let places: Vec<[f64; 4]> = py.detach(|| {
            let arms = self.arms();
            let places = arms.iter().flat_map(|one| {
                let look = one.arm.arm().look();
                let places: Vec<_> = look.objects().map(|object| object.place()).collect();
                places
            });
            places
                .map(|place| [place.x, place.y, place.z, place.yaw])
                .collect()
        });
        numbers(py, places.as_flattened())
    }

    fn snapshot(&self, py: Python<'_>, nth: usize) -> PyResult<Saved> {
        self.with(py, nth, |one| Saved {
            arm: one.arm.arm().clone(),
            one: Some(one.clone()),
        })
    }

    fn restore(&self, py: Python<'_>, nth: usize, saved: &Saved) -> PyResult<()> {
        let arm = match &saved.one {
            Some(one) => Ok(one.clone()),
            None => Simulation::new(saved.arm.clone(), self.start.speed).map(|arm| SimulatedArm {
                arm,
                dice: Dice::new(0),
            }),
        };
        let arm = arm.map_err(|error| errors::raise(py, &error))?;
        self.with(py, nth, |one| *one = arm)
    }

    /// Pixels of each requested image, concatenated.
    fn images<'py>(
        &self,
        py: Python<'py>,
        which: Vec<usize>,
        top: bool,
        size: [u32; 2],
        threads: usize,
    ) -> PyResult<Bound<'py, PyByteArray>> {
        let view = if top { View::Top } else { View::Side };
        let drawn = py.detach(|| {
            let arms: Option<Vec<SimulatedArm>> = {
                let arms = self.arms();
                which.iter().map(|nth| arms.get(*nth).cloned()).collect()
            };
            let drawn = for_each_arm(&mut arms?, threads, |_, one| {
                pixels(one.arm.arm(), view, size)
            });
            drawn.into_iter().collect::<Option<Vec<_>>>()
        });
        let Some(drawn) = drawn else {
            let [height, width] = size;
            let why =
                format!("a picture of {height} by {width} pixels cannot be made: 1 to 64 million");
            return Err(errors::raise(py, &Error::invalid(why)));
        };
        Ok(PyByteArray::new(py, &drawn.concat()))
    }
}
