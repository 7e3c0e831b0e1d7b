//! Duration of a continuous path while its continuation is not known (model section 8).

use std::collections::VecDeque;

use magician_motion::{CpSegment, LookAhead, VelocityProfile};

/// Number of segments that the arm knows ahead of the current one: its queue holds 32 commands
/// (model section 14).
const AHEAD: usize = 31;

/// Converts seconds to whole microseconds, rounded up as the planner does.
pub(super) fn microseconds(seconds: f64) -> u64 {
    // Less than 1 ns above a whole microsecond is rounding, not time.
    (seconds * 1e6 - 1e-3).ceil() as u64
}

/// The path since the tool was last at rest.
///
/// The speed at the end of a segment depends on the following segments that the arm knows by then.
/// Older segments are settled; the rest is assumed to end at rest at the last known point. Each new
/// segment makes the whole longer by the difference, so the sum reported is never less than the arm
/// takes to the known end, and is exact at the real one.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    look_ahead: Option<LookAhead>,
    open: VecDeque<CpSegment>,
    /// Speed at which the first open segment is entered, mm/s.
    entry: f64,
    /// Time of the settled segments, us.
    settled: u64,
    /// Time reported so far, us.
    told: u64,
    /// True if only settled time is reported.
    lazy: bool,
    /// Velocity profiles of the settled segments, if requested.
    profiles: Option<Vec<VelocityProfile>>,
}

impl Path {
    /// Creates a path that reports only settled time, and the rest at its end: the same sum for
    /// less work.
    pub(super) fn lazy() -> Self {
        Self {
            lazy: true,
            ..Self::default()
        }
    }

    /// Creates a path that also keeps the profile of each settled segment.
    pub(super) fn keeping_profiles() -> Self {
        Self {
            profiles: Some(Vec::new()),
            ..Self::lazy()
        }
    }

    /// Returns the profiles settled since the last call, in the order of their segments.
    pub(super) fn take_profiles(&mut self) -> Vec<VelocityProfile> {
        self.profiles
            .as_mut()
            .map(std::mem::take)
            .unwrap_or_default()
    }

    /// Adds a segment. Returns the time by which the path gets longer, us.
    pub(super) fn add(&mut self, look_ahead: LookAhead, segment: CpSegment) -> u64 {
        self.look_ahead = Some(look_ahead);
        self.open.push_back(segment);
        // The arm cannot look further ahead, so the first segment's end speed is final.
        if self.open.len() > AHEAD {
            self.settle(&look_ahead);
        }
        self.tell(self.lazy)
    }

    /// Ends the path. Returns the time not reported yet, us.
    pub(super) fn end(&mut self) -> u64 {
        let rest = self.tell(false);
        if self.profiles.is_some() {
            let open: Vec<VelocityProfile> = self.open_profiles().collect();
            self.profiles.get_or_insert_default().extend(open);
        }
        self.open.clear();
        (self.entry, self.settled, self.told) = (0.0, 0, 0);
        rest
    }

    fn tell(&mut self, only_settled: bool) -> u64 {
        // Reported time is never taken back: `saturating_sub` keeps the sum monotonic.
        let open = if only_settled { 0 } else { self.to_rest() };
        let more = (self.settled.saturating_add(open)).saturating_sub(self.told);
        self.told = self.told.saturating_add(more);
        more
    }

    /// Settles the first open segment, which can no longer change.
    fn settle(&mut self, look_ahead: &LookAhead) {
        let Some(first) = self.open.pop_front() else {
            return;
        };
        let profile = next_profile(look_ahead, self.entry, &first, self.open.iter());
        self.entry = profile.exit();
        if let Some(profiles) = &mut self.profiles {
            profiles.push(profile);
        }
        self.settled = self
            .settled
            .saturating_add(microseconds(profile.duration()));
    }

    /// Time of the open segments if the last one ends at rest, us.
    fn to_rest(&self) -> u64 {
        let times = self
            .open_profiles()
            .map(|profile| microseconds(profile.duration()));
        times.fold(0, u64::saturating_add)
    }

    /// Profiles of the open segments if the last one ends at rest.
    fn open_profiles(&self) -> impl Iterator<Item = VelocityProfile> {
        let mut entry = self.entry;
        let ahead = self.look_ahead.iter();
        ahead
            .flat_map(|ahead| self.open.iter().enumerate().map(move |each| (ahead, each)))
            .map(move |(ahead, (at, segment))| {
                let profile = next_profile(ahead, entry, segment, self.open.range(at + 1..));
                entry = profile.exit();
                profile
            })
    }
}

fn next_profile<'a>(
    look_ahead: &LookAhead,
    entry: f64,
    segment: &'a CpSegment,
    behind: impl Iterator<Item = &'a CpSegment>,
) -> VelocityProfile {
    let exit = look_ahead.exit_speed(segment, behind);
    look_ahead.profile(segment, entry, exit)
}
