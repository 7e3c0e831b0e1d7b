//! Runs the program and reads the pose meanwhile, so that the picture shows measured positions.

use std::sync::Arc;
use std::time::Duration;

use magician::commands::Pose;
use magician::{Arm, Set};
use magician_job::{Fault, JobError, JobHandle, JobSummary};
use magician_picture::RunReading;

use super::display::{Display, DisplayState};
use crate::failure::Failure;

/// Pause between readings. A choice: short enough for a smooth path, and it leaves the line to the
/// commands.
pub(super) const PAUSE: Duration = Duration::from_millis(3);
/// Pause between readings in virtual time, by the arm's clock.
pub(super) const ARM_PAUSE: Duration = Duration::from_millis(20);

/// Records the readings of a run.
pub(super) struct Recorder {
    readings: Vec<(Pose, u64)>,
    /// For each command, true if the arm carries a cube once it has finished.
    carrying: Vec<bool>,
    pause: Duration,
}

impl Recorder {
    pub(super) fn new(commands: &[Set], pause: Duration) -> Self {
        let carrying = commands.iter().scan(false, |carrying, command| {
            if let Set::SetEndEffectorSuctionCup(cup) = command {
                *carrying = cup.suck.is_on();
            }
            Some(*carrying)
        });
        Self {
            readings: Vec::new(),
            carrying: carrying.collect(),
            pause,
        }
    }

    /// Reads poses until all commands have run.
    pub(super) async fn watch(
        &mut self,
        arm: &Arm,
        job: &JobHandle,
        display: &mut Display<'_>,
    ) -> Result<Arc<JobSummary>, Failure> {
        let watch = async {
            loop {
                self.read(arm, job, display).await?;
                tokio::time::sleep(self.pause).await;
            }
        };
        let done = tokio::select! {
            done = job.outcome() => done.map_err(|error| told(&error))?,
            failed = watch => {
                let failed: Result<std::convert::Infallible, Failure> = failed;
                match failed {
                    Ok(never) => match never {},
                    Err(failure) => return Err(failure),
                }
            }
        };
        self.read(arm, job, display).await?;
        Ok(done)
    }

    async fn read(
        &mut self,
        arm: &Arm,
        job: &JobHandle,
        display: &mut Display<'_>,
    ) -> Result<(), Failure> {
        let pose = arm.get::<Pose>().await?;
        let index = arm.queue().current_index().await?.0;
        self.readings.push((pose, index));
        if !display.due() {
            return Ok(());
        }
        let done = job.progress().step;
        let placed = self.placed(usize::try_from(done).unwrap_or(usize::MAX));
        let left = arm.queue().left_space().await?;
        display.show(&DisplayState {
            placed,
            pose,
            index,
            left,
        })
    }

    /// Returns the number of cubes released once `done` commands have finished.
    fn placed(&self, done: usize) -> usize {
        let done = self.carrying.get(..done).unwrap_or(&self.carrying);
        done.windows(2)
            .filter(|pair| matches!(pair, [true, false]))
            .count()
    }

    pub(super) fn count(&self) -> usize {
        self.readings.len()
    }

    /// Returns the readings for the picture, from index `first` on, when the settings of this run
    /// apply. Consecutive equal readings are merged.
    pub(super) fn samples(&self, first: u64) -> Vec<RunReading> {
        let mut samples: Vec<RunReading> = self
            .readings
            .iter()
            .filter(|(_, index)| *index >= first)
            .map(|(pose, index)| RunReading {
                at: [pose.x, pose.y, pose.z].map(f64::from),
                holds: self.carrying_at(index - first),
            })
            .collect();
        samples.dedup();
        samples
    }

    fn carrying_at(&self, finished: u64) -> bool {
        let at = usize::try_from(finished).unwrap_or(usize::MAX);
        self.carrying.get(at).copied().unwrap_or(false)
    }
}

/// Converts the error of a job into a failure.
fn told(error: &JobError) -> Failure {
    let refused_step = match &error.fault {
        Fault::Refused { report, .. } => report.refused_steps.first(),
        _ => None,
    };
    match (&error.fault, refused_step) {
        (Fault::Arm(error), _) => Failure::from(&**error),
        (_, Some(refused_step)) => Failure::from(&refused_step.error),
        _ => Failure::unexpected(error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::program::commands;
    use super::super::scene::CUBES;
    use super::*;

    #[test]
    fn a_cube_counts_when_it_has_been_let_go() {
        let commands = commands();
        let recorder = Recorder::new(&commands, PAUSE);
        assert_eq!(recorder.placed(0), 0);
        assert_eq!(recorder.placed(8), 0);
        assert_eq!(recorder.placed(9), 1);
        assert_eq!(recorder.placed(usize::MAX), CUBES.len());
        assert!(!recorder.carrying_at(4) && recorder.carrying_at(5) && !recorder.carrying_at(8));
    }
}
