//! Time left at each step of a run.
//!
//! Cumulative times are stored for the first part and for one iteration only, so memory does not
//! grow with the number of iterations, and a look-up takes constant time.

use std::time::Duration;

/// Cumulative durations of a run by step, by the arm's clock, from
/// [`RemainingProgram::timetable`](super::RemainingProgram::timetable).
#[derive(Clone, Debug, Default)]
pub struct Timetable {
    /// Total duration; `None` if unknown.
    total: Option<Duration>,
    /// Number of commands before the first step.
    lead: usize,
    /// Time up to each command of the first part, s.
    first: Vec<f64>,
    /// Time up to each step of a later iteration, from its beginning, s.
    iteration: Vec<f64>,
}

impl Timetable {
    pub(super) fn new(total: Duration, lead: usize, first: Vec<f64>, iteration: Vec<f64>) -> Self {
        Self {
            total: Some(total),
            lead,
            first,
            iteration,
        }
    }

    /// Time left when `steps` of the run are finished; `None` if its end is unknown.
    #[must_use]
    pub fn left(&self, steps: u64) -> Option<Duration> {
        let left = self.total?.as_secs_f64() - self.elapsed_after(steps);
        Some(Duration::try_from_secs_f64(left.max(0.0)).unwrap_or_default())
    }

    fn elapsed_after(&self, steps: u64) -> f64 {
        let of_first = self.first.len().saturating_sub(self.lead) as u64;
        let Some(later) = steps.checked_sub(of_first) else {
            let commands = self
                .lead
                .saturating_add(usize::try_from(steps).unwrap_or(usize::MAX));
            return sum_of_first(&self.first, commands);
        };
        let total = sum_of_first(&self.first, self.first.len());
        let length = self.iteration.len().max(1) as u64;
        let within = usize::try_from(later % length).unwrap_or(usize::MAX);
        let iterations =
            (later / length) as f64 * sum_of_first(&self.iteration, self.iteration.len());
        total + iterations + sum_of_first(&self.iteration, within)
    }
}

/// Duration of the first `count` entries.
fn sum_of_first(sums: &[f64], count: usize) -> f64 {
    let last = count.checked_sub(1).and_then(|last| sums.get(last));
    last.copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn later_iterations_have_their_own_duration() {
        // A lead of 1 s, two steps of 2 s, then iterations of three steps of 1 s.
        let table = Timetable::new(
            Duration::from_secs(11),
            1,
            vec![1.0, 3.0, 5.0],
            vec![1.0, 2.0, 3.0],
        );
        let left: Vec<u64> = (0..=9)
            .map(|steps| table.left(steps).expect("known").as_secs())
            .collect();
        assert_eq!(left, [10, 8, 6, 5, 4, 3, 2, 1, 0, 0]);
        assert_eq!(Timetable::default().left(1), None);
    }
}
