//! Interception of objects that move on a belt.

use std::time::Duration;

use magician::build;
use magician::commands::DeviceTime;
use magician::preflight::MovingTarget;
use magician::{Arm, Set};
use pyo3::prelude::*;

use super::verbs::commands;
use super::{Core, seconds};
use crate::call::Call;

/// Clock of the arm at the rendezvous, s; position, mm; duration of the descent.
type RendezvousParts = (f64, [f64; 3], Duration);

/// Approach of the arm to the object.
struct Approach {
    before: Vec<Set>,
    /// Height above the object at which the descent begins, mm.
    approach: f64,
    r: f64,
}

impl Approach {
    fn to(&self, [x, y, z]: [f64; 3]) -> Vec<Set> {
        let [x, y, z, r] = [x, y, z, self.r].map(|number| number as f32);
        let mut way = self.before.clone();
        way.push(build::move_to(x, y, z + self.approach as f32, r));
        way.push(build::line_to(x, y, z, r));
        way
    }
}

async fn meet(
    arm: Arm,
    target: MovingTarget,
    since: Option<f64>,
    way: Approach,
    ready: Duration,
) -> magician::Result<RendezvousParts> {
    let check = arm.preflight_for(&way.to(target.position)).await?;
    let clock = f64::from(arm.get::<DeviceTime>().await?.g_systick) / 1e3;
    let now = MovingTarget {
        position: target.after(since.map_or(0.0, |since| clock - since)),
        ..target
    };
    let rendezvous = tokio::task::spawn_blocking(move || {
        let rendezvous = check.meet(&now, ready, |place| way.to(place))?;
        let whole = way.to(rendezvous.position);
        let above = whole.split_last().map_or(&[][..], |(_, above)| above);
        let down = rendezvous.takes - check.estimate(above)?;
        Ok((
            clock + rendezvous.after.as_secs_f64(),
            rendezvous.position,
            down,
        ))
    });
    let bug = |error: tokio::task::JoinError| {
        magician::Error::new(magician::ErrorCode::Closed, error.to_string())
    };
    rendezvous.await.map_err(bug)?
}

#[pymethods]
impl Core {
    /// Computes time and position at which the arm, after these commands, meets a target that was
    /// at `position` at time `since` of its clock.
    #[allow(clippy::too_many_arguments)]
    fn meet(
        &self,
        py: Python<'_>,
        position: [f64; 4],
        velocity: [f64; 3],
        since: Option<f64>,
        before: &Bound<'_, PyAny>,
        approach: f64,
        ready: f64,
    ) -> PyResult<Call> {
        let [x, y, z, r] = position;
        let way = Approach {
            before: commands(before)?,
            approach,
            r,
        };
        let target = MovingTarget {
            position: [x, y, z],
            velocity,
        };
        let ready = seconds(py, "ready", ready)?;
        let arm = self.arm(py)?;
        let meet = meet(arm, target, since, way, ready);
        Ok(Call::start(
            meet,
            |py, (at, place, down): RendezvousParts| {
                let found = (at, (place[0], place[1], place[2]), down.as_secs_f64());
                Ok(found.into_pyobject(py)?.into_any().unbind())
            },
        ))
    }
}
