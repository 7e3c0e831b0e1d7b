//! How long a continuous path takes while it is not known how it goes on (model section 8).

use std::collections::VecDeque;

use magician_motion::{CpSegment, LookAhead, VelocityProfile};

/// Segments that the arm knows ahead of the one under way: its queue holds 32 commands (model section 14).
const AHEAD: usize = 31;

/// Whole microseconds that hold so many seconds, as the planner counts them.
pub(super) fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6 - 1e-3).ceil() as u64
}

/// The path since the tool was at rest last.
///
/// The speed at the end of a segment depends on as many segments behind it as the arm knows by then. What is older
/// than that is settled; the rest is taken to end where the path is known to end, at rest. Each new segment makes
/// the whole longer by the difference, so that what was told of it is never less than the arm takes to its end
/// as it is known, and comes out exact at the real one.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    look_ahead: Option<LookAhead>,
    open: VecDeque<CpSegment>,
    /// The speed at which the first of them is entered, mm/s.
    entry: f64,
    /// Time of the segments before them, us.
    settled: u64,
    /// Time told so far, us.
    told: u64,
    /// Nothing is told before it is settled.
    lazy: bool,
    /// The profile of every settled segment, if requested.
    profiles: Option<Vec<VelocityProfile>>,
}

impl Path {
    /// A path of which only what is certain is told, and the rest at its end: the same sum for less work.
    pub(super) fn lazy() -> Self {
        Self {
            lazy: true,
            ..Self::default()
        }
    }

    /// One that keeps the profile of each segment, once it is settled.
    pub(super) fn keeping_profiles() -> Self {
        Self {
            profiles: Some(Vec::new()),
            ..Self::lazy()
        }
    }

    /// The profiles that were settled since, in the order of their segments.
    pub(super) fn take_profiles(&mut self) -> Vec<VelocityProfile> {
        self.profiles
            .as_mut()
            .map(std::mem::take)
            .unwrap_or_default()
    }

    /// Adds a segment; by how much the path takes longer now, us.
    pub(super) fn add(&mut self, look_ahead: LookAhead, segment: CpSegment) -> u64 {
        self.look_ahead = Some(look_ahead);
        self.open.push_back(segment);
        if self.open.len() > AHEAD {
            self.settle(&look_ahead);
        }
        self.tell(self.lazy)
    }

    /// The path ends here; what has not been told of it yet, us.
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
        let open = if only_settled { 0 } else { self.to_rest() };
        let more = (self.settled.saturating_add(open)).saturating_sub(self.told);
        self.told = self.told.saturating_add(more);
        more
    }

    /// The first segment will not change any more.
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

    /// How long the open segments take if the last of them ends at rest.
    fn to_rest(&self) -> u64 {
        let times = self
            .open_profiles()
            .map(|profile| microseconds(profile.duration()));
        times.fold(0, u64::saturating_add)
    }

    /// The profiles of the open segments if the last of them ends at rest.
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
