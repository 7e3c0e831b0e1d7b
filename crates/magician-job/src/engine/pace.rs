//! Speed of a running job, in percent of the speed its program sets.
//!
//! To change it, the engine inserts settings between the commands of the program. Commands that the
//! arm has already keep their speed. Only the three documented settings for moves, paths and arcs
//! are changed; each gets the value that the program (or the arm, if the program sets none) gives
//! it, the *full* value, times the share.
//!
//! A path comes to rest at each setting. A job that burns must not stop with its laser on, so there
//! the change waits for a travel line that is long enough to be cut in two (see `seam`).

use std::collections::VecDeque;
use std::iter::Peekable;
use std::mem::{Discriminant, discriminant};
use std::time::Duration;

use magician::commands::{ArcParams, CpLeCmd, CpParams, PtpCommonParams};
use magician::{Arm, Error, Set, SettingsBackup, build};
use magician_program::Timetable;
use magician_protocol::{CpMode, Effect, PtpMode};

use super::Engine;
use super::segment::Segment;
use crate::background::{BackgroundTurns, run_in_background};
use crate::event::JobEvent;
use crate::handle::FULL_SPEED;

/// Margin factor on the distance that braking and accelerating at full speed need, when a travel
/// line is cut. A choice: 10 %.
const BRAKING_MARGIN: f64 = 1.1;
/// Smallest ratio allowed for a move, percent (1.10.4).
const MIN_SPEED_RATIO: f32 = 1.0;

/// The settings that determine how fast an arm moves.
#[derive(Clone, Copy, Debug, Default)]
struct Speeds {
    moves: Option<PtpCommonParams>,
    paths: Option<CpParams>,
    arcs: Option<ArcParams>,
}

/// Speed of a job, as requested and as sent.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// Speed for the commands from now on, percent. Set once everything it needs is known.
    requested: u8,
    /// Speed that the arm was set to last, percent.
    sent: u8,
    full: Speeds,
    /// Settings to send next, before the program continues.
    next: VecDeque<Set>,
    /// Kinds of settings that are restored at the end of the job.
    saved: Vec<Discriminant<Set>>,
    /// Timetables by the step of the segment from which each applies, in order. The last entry that
    /// begins early enough counts.
    tables: Vec<(u64, Timetable)>,
    /// Timetable for the requested speed.
    table: Option<Timetable>,
}

impl Speeds {
    /// Records a setting, if it is one of the three.
    fn note(&mut self, command: &Set) {
        match command {
            Set::PtpCommonParams(moves) => self.moves = Some(*moves),
            Set::CpParams(paths) => self.paths = Some(*paths),
            Set::ArcParams(arcs) => self.arcs = Some(*arcs),
            _ => {}
        }
    }

    /// Fills settings unknown here from `other`.
    fn or(self, other: Self) -> Self {
        Self {
            moves: self.moves.or(other.moves),
            paths: self.paths.or(other.paths),
            arcs: self.arcs.or(other.arcs),
        }
    }

    fn settings(self) -> impl Iterator<Item = Set> {
        let moves = self.moves.map(Set::from);
        let others = [self.paths.map(Set::from), self.arcs.map(Set::from)];
        moves.into_iter().chain(others.into_iter().flatten())
    }
}

/// A command at this speed.
///
/// Velocities get the share. Accelerations get its square, so that ramps last as much longer as the
/// even parts. The acceleration of paths gets the share alone, because corners are taken as fast as
/// it allows (model section 8): at no place is the path slower than its share. A laser power that
/// follows the speed also gets the share, so nothing is burnt deeper than at full speed.
fn at_speed(command: Set, percent: u8) -> Set {
    if percent == FULL_SPEED {
        return command;
    }
    let share = f32::from(percent) / f32::from(FULL_SPEED);
    let square = share * share;
    match command {
        Set::PtpCommonParams(moves) => {
            // The arm takes more than 100 % as 100 %, so the share applies to at most that.
            let ratio = |ratio: f32, share: f32| (ratio.min(100.0) * share).max(MIN_SPEED_RATIO);
            PtpCommonParams {
                velocity_ratio: ratio(moves.velocity_ratio, share),
                acceleration_ratio: ratio(moves.acceleration_ratio, square),
            }
            .into()
        }
        Set::CpParams(paths) => {
            // With real-time tracking this field is a period, which grows as the speed falls.
            let last = if paths.real_time_track.is_on() {
                share.recip()
            } else {
                1.0
            };
            CpParams {
                plan_acc: paths.plan_acc * share,
                junction_vel: paths.junction_vel * share,
                acc_or_period: paths.acc_or_period * last,
                ..paths
            }
            .into()
        }
        Set::CpLeCmd(line) => CpLeCmd {
            velocity_or_power: line.velocity_or_power * share,
            ..line
        }
        .into(),
        Set::ArcParams(arcs) => ArcParams {
            xyz_velocity: arcs.xyz_velocity * share,
            r_velocity: arcs.r_velocity * share,
            xyz_acceleration: arcs.xyz_acceleration * square,
            r_acceleration: arcs.r_acceleration * square,
        }
        .into(),
        // Other commands do not depend on these speeds.
        other => other,
    }
}

impl Pace {
    /// Speed state of a job that restores these settings at its end.
    pub(super) fn new<'s>(saved: impl IntoIterator<Item = &'s Set>) -> Self {
        Self {
            requested: FULL_SPEED,
            sent: FULL_SPEED,
            saved: saved.into_iter().map(discriminant).collect(),
            ..Self::default()
        }
    }

    /// Time left of a segment when `steps` of its steps are finished.
    pub(super) fn left(&self, full: &Timetable, steps: u64) -> Option<Duration> {
        let behind = self.tables.iter().take_while(|(from, _)| *from <= steps);
        let behind = behind.count();
        let table = |nth: usize| nth.checked_sub(1).map_or(full, |at| &self.tables[at].1);
        let mut left = table(behind).left(steps)?;
        // Up to the step where the next speed begins by the current table, from there by the next
        // one.
        for (nth, (from, next)) in self.tables.iter().enumerate().skip(behind) {
            left = left.saturating_sub(table(nth).left(*from)?) + next.left(*from)?;
        }
        Some(left)
    }

    /// Queues the settings of the requested speed, with `before` ahead of them.
    ///
    /// Called between two commands of the program.
    fn queue_settings(&mut self, step: u64, before: Option<Set>) {
        self.sent = self.requested;
        let percent = self.sent;
        let settings = self.full.settings().map(|set| at_speed(set, percent));
        self.next = before.into_iter().chain(settings).collect();
        self.tables
            .extend(self.table.clone().map(|table| (step, table)));
    }

    /// Returns a command of the program at the current speed, and records it if it is a setting.
    fn pass(&mut self, command: Set) -> Set {
        self.full.note(&command);
        at_speed(command, self.sent)
    }
}

/// Commands of a segment, with the settings of its speed inserted.
pub(super) struct Paced<'w, I: Iterator<Item = Set>> {
    pub(super) engine: &'w Engine,
    pub(super) commands: Peekable<I>,
    pub(super) lead: u64,
    /// End of the last command, if known.
    pub(super) end: Option<[f32; 3]>,
    /// True if the last command was a segment of a path.
    pub(super) on_path: bool,
}

impl<I: Iterator<Item = Set>> Paced<'_, I> {
    /// Command to send before new settings. `None`: the settings have to wait. `Some(None)`: they
    /// can go out now.
    ///
    /// A path comes to rest at a setting. A burn must not do that with a power made for a higher
    /// speed. So a line with the laser off is cut in its middle, if it is long enough that its
    /// neighbours are as fast as without the cut.
    fn seam(&mut self, full: &Speeds) -> Option<Option<Set>> {
        let next = self.commands.peek()?;
        if !self.engine.burns || !self.on_path {
            return Some(None);
        }
        let Set::CpLeCmd(line) = next else {
            // Before any other motion a path comes to rest anyway.
            return (!matches!(next, Set::CpCmd(_))).then_some(None);
        };
        let (from, paths) = (self.end?, full.paths?);
        let to = [line.x, line.y, line.z];
        let off = [0, 1, 2].map(|axis| f64::from(to[axis] - from[axis]));
        let long = off.iter().map(|off| off * off).sum::<f64>().sqrt();
        let speed = f64::from(paths.junction_vel);
        let least = BRAKING_MARGIN * speed * speed / f64::from(paths.plan_acc);
        let is_dark = line.velocity_or_power == 0.0 && line.cp_mode == CpMode::Absolute;
        let fits = is_dark && !paths.real_time_track.is_on() && long >= least;
        let [x, y, z] = [0, 1, 2].map(|axis| f32::midpoint(from[axis], to[axis]));
        let half = CpLeCmd { x, y, z, ..*line };
        fits.then(|| Some(half.into()))
    }

    fn note(&mut self, command: &Set) {
        self.on_path = matches!(command, Set::CpCmd(_) | Set::CpLeCmd(_));
        // Settings do not move the arm.
        if let Some(end) = end_of(command) {
            self.end = end;
        }
    }
}

/// End position of a command. `None` if it does not move the arm, `Some(None)` if its end is
/// unknown.
fn end_of(command: &Set) -> Option<Option<[f32; 3]>> {
    match command {
        Set::CpLeCmd(line) if line.cp_mode == CpMode::Absolute => {
            Some(Some([line.x, line.y, line.z]))
        }
        Set::PtpCmd(to) if matches!(to.ptp_mode, PtpMode::MovlXyz | PtpMode::MovjXyz) => {
            Some(Some([to.x, to.y, to.z]))
        }
        other if other.row().effect == Effect::Setting => None,
        _ => Some(None),
    }
}

impl<I: Iterator<Item = Set>> Iterator for Paced<'_, I> {
    type Item = Set;

    fn next(&mut self) -> Option<Set> {
        // Release the lock first: `seam` reads ahead in the program.
        let full = {
            let pace = self.engine.pace();
            (pace.next.is_empty() && pace.requested != pace.sent).then_some(pace.full)
        };
        let seam = full.and_then(|full| self.seam(&full));
        let mut tracker = self.engine.tracker();
        let mut pace = self.engine.pace();
        if let Some(half) = seam {
            pace.queue_settings(tracker.steps_pulled(self.lead), half);
        }
        if let Some(setting) = pace.next.pop_front() {
            tracker.note_inserted(self.lead);
            drop((pace, tracker));
            self.note(&setting);
            return Some(setting);
        }
        drop((pace, tracker));
        let command = self.commands.next()?;
        self.note(&command);
        self.engine.tracker().note_pulled(self.lead);
        Some(self.engine.pace().pass(command))
    }
}

impl Engine {
    /// Follows requests to change the speed: later commands go out at the requested one.
    pub(super) async fn follow_pace(&self, segment: &Segment) -> std::convert::Infallible {
        let mut requested = self.shared.pace.subscribe();
        loop {
            let percent = *requested.borrow_and_update();
            let before = self.pace().requested;
            if before != percent && self.apply_pace(segment, percent).await.is_err() {
                // An arm that does not report its speeds keeps them. The run sees the same error,
                // so it is not reported here.
                self.shared.pace.send_replace(before);
                self.shared.emit(JobEvent::Speed(before));
            }
            // Cannot fail: the job itself owns the sender.
            let _ = requested.changed().await;
        }
    }

    /// Prepares the speed of a segment: full, or the share that was requested before.
    pub(super) async fn prepare_pace(&self, segment: &Segment) -> Result<(), Error> {
        {
            let mut pace = self.pace();
            (pace.requested, pace.sent) = (FULL_SPEED, FULL_SPEED);
            pace.full = Speeds::default();
            pace.next.clear();
            pace.tables.clear();
            pace.table = None;
        }
        let percent = *self.shared.pace.borrow();
        if percent == FULL_SPEED {
            return Ok(());
        }
        Box::pin(self.apply_pace(segment, percent)).await?;
        let mut pace = self.pace();
        pace.tables = pace
            .table
            .clone()
            .map(|table| (0, table))
            .into_iter()
            .collect();
        Ok(())
    }

    /// Applies `percent` to the commands from now on. Saves the settings that it changes, to be
    /// restored at the end.
    async fn apply_pace(&self, segment: &Segment, percent: u8) -> Result<(), Error> {
        // The values do not matter: these commands only name the settings to read.
        let kinds = [
            build::speed(FULL_SPEED.into(), FULL_SPEED.into()),
            build::path_speed(1.0, 1.0),
            build::arc_speed(1.0, 1.0),
        ];
        let found = SettingsBackup::read(&self.arm, &kinds).await?;
        let mut own = Speeds::default();
        found
            .settings()
            .iter()
            .for_each(|setting| own.note(setting));
        if let Some(saved) = &self.spec.saved {
            let mut new = SettingsBackup::default();
            for setting in found.settings() {
                let kind = discriminant(setting);
                if !self.pace().saved.contains(&kind) {
                    new.save(*setting);
                    self.pace().saved.push(kind);
                }
            }
            saved.save_all(&self.arm, new).await;
        }
        let full = self.pace().full.or(own);
        let table = if percent == FULL_SPEED {
            segment.timetable.clone()
        } else {
            let (rest, table) = (segment.rest.clone(), segment.timetable.clone());
            let before: Vec<Set> = full.settings().map(|set| at_speed(set, percent)).collect();
            run_in_background(async move {
                let at_percent = |set| at_speed(set, percent);
                { rest.timetable_with(&table, &before, at_percent, &BackgroundTurns) }.await
            })
            .await?
        };
        let mut pace = self.pace();
        // The program may have set more in the meantime.
        pace.full = pace.full.or(full);
        (pace.requested, pace.table) = (percent, Some(table));
        Ok(())
    }

    /// Restores full speed between two segments and before the pen goes up: a person who moves the
    /// arm in a pause expects its usual speed.
    pub(super) async fn restore_full_speed(&self, arm: &Arm) -> Result<(), Error> {
        let full = {
            let mut pace = self.pace();
            if pace.sent == FULL_SPEED {
                return Ok(());
            }
            (pace.requested, pace.sent) = (FULL_SPEED, FULL_SPEED);
            pace.full
        };
        for setting in full.settings() {
            arm.set_any(&setting).await?;
        }
        Ok(())
    }
}
