//! How fast a job goes, in percent of what its program says: settings that go out between its commands.
//!
//! What is sent already keeps its speed. Of the arm's settings three are changed, which are the documented ones for moves, paths
//! and arcs; each has the value that the program, or the arm without it, gives it (the *full* one), times the share.

use std::collections::VecDeque;
use std::iter::Peekable;
use std::mem::{Discriminant, discriminant};
use std::time::Duration;

use magician::commands::{ArcParams, CpLeCmd, CpParams, PtpCommonParams};
use magician::{Arm, Error, Set, SettingsBackup, build};
use magician_program::Timetable;
use magician_protocol::{CpMode, Effect, PtpMode};

use super::Work;
use super::segment::Segment;
use crate::beside::{BesideTurns, beside};
use crate::event::JobEvent;
use crate::handle::FULL;

/// A way that is cut is so much longer than speeding up and slowing down takes at full speed.
const ROOM: f64 = 1.1;
/// The least ratio that a move may have (1.10.4).
const LEAST_RATIO: f32 = 1.0;

/// The settings that say how fast an arm goes.
#[derive(Clone, Copy, Debug, Default)]
struct Speeds {
    moves: Option<PtpCommonParams>,
    paths: Option<CpParams>,
    arcs: Option<ArcParams>,
}

/// The pace of a job.
#[derive(Debug, Default)]
pub(super) struct Pace {
    /// What is wanted of what goes out from now on, percent, once all is known that it needs.
    wanted: u8,
    /// What the arm has been told.
    told: u8,
    full: Speeds,
    /// Settings that go out next.
    next: VecDeque<Set>,
    /// Which settings are restored at the end of the job.
    saved: Vec<Discriminant<Set>>,
    /// From which step of the segment on how long is left is in which table: the last that begins so early.
    tables: Vec<(u64, Timetable)>,
    /// The one of what is wanted.
    table: Option<Timetable>,
}

impl Speeds {
    /// Notes a setting, if it is one of these.
    fn note(&mut self, command: &Set) {
        match command {
            Set::PtpCommonParams(moves) => self.moves = Some(*moves),
            Set::CpParams(paths) => self.paths = Some(*paths),
            Set::ArcParams(arcs) => self.arcs = Some(*arcs),
            _ => {}
        }
    }

    /// Takes from others what is not known here.
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

/// A command at this pace. A power that follows the speed has the share. What speeds up and slows down takes as much longer as what goes evenly: accelerations have the square
/// of the share. Those of paths have the share itself, because corners are as fast as they allow (model section 8):
/// so a path is at no place slower than its share, and what burns at the same share of its power burns nowhere deeper.
fn paced(command: Set, percent: u8) -> Set {
    if percent == FULL {
        return command;
    }
    let share = f32::from(percent) / f32::from(FULL);
    let square = share * share;
    match command {
        Set::PtpCommonParams(moves) => {
            let ratio = |ratio: f32, share: f32| (ratio.min(100.0) * share).max(LEAST_RATIO);
            PtpCommonParams {
                velocity_ratio: ratio(moves.velocity_ratio, share),
                acceleration_ratio: ratio(moves.acceleration_ratio, square),
            }
            .into()
        }
        Set::CpParams(paths) => {
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
        other => other,
    }
}

impl Pace {
    /// A job that restores these settings at its end.
    pub(super) fn new<'s>(saved: impl IntoIterator<Item = &'s Set>) -> Self {
        Self {
            wanted: FULL,
            told: FULL,
            saved: saved.into_iter().map(discriminant).collect(),
            ..Self::default()
        }
    }

    /// How long is left of a segment when so many of its steps are finished.
    pub(super) fn left(&self, full: &Timetable, steps: u64) -> Option<Duration> {
        let behind = self.tables.iter().take_while(|(from, _)| *from <= steps);
        let behind = behind.count();
        let table = |nth: usize| nth.checked_sub(1).map_or(full, |at| &self.tables[at].1);
        let mut left = table(behind).left(steps)?;
        // Up to where the next pace begins by this one, and from there by the next.
        for (nth, (from, next)) in self.tables.iter().enumerate().skip(behind) {
            left = left.saturating_sub(table(nth).left(*from)?) + next.left(*from)?;
        }
        Some(left)
    }

    /// The settings of what is wanted, if the arm has not been told them; to be called between two commands of the program.
    /// `before` goes out before them.
    fn turns(&mut self, step: u64, before: Option<Set>) {
        self.told = self.wanted;
        let percent = self.told;
        let settings = self.full.settings().map(|set| paced(set, percent));
        self.next = before.into_iter().chain(settings).collect();
        self.tables
            .extend(self.table.clone().map(|table| (step, table)));
    }

    /// A command of the program, as it goes out.
    fn passes(&mut self, command: Set) -> Set {
        self.full.note(&command);
        paced(command, self.told)
    }
}

/// The commands of a segment with the settings that its pace puts between them.
pub(super) struct Paced<'w, I: Iterator<Item = Set>> {
    pub(super) work: &'w Work,
    pub(super) commands: Peekable<I>,
    pub(super) lead: u64,
    /// Where the last command ends, if it says so.
    pub(super) end: Option<[f32; 3]>,
    /// Whether the last command was a segment of a path.
    pub(super) on_path: bool,
}

impl<I: Iterator<Item = Set>> Paced<'_, I> {
    /// What goes out before the settings: nothing where they can go out at once, none if they have to wait.
    ///
    /// A path comes to rest at a setting. What burns is not to do that with a power that was made for more speed, so a way with
    /// the laser off is cut in its middle, if it is long enough for what comes before and behind it to be as fast as without.
    fn seam(&mut self, full: &Speeds) -> Option<Option<Set>> {
        let next = self.commands.peek()?;
        if !self.work.burns || !self.on_path {
            return Some(None);
        }
        let Set::CpLeCmd(line) = next else {
            // Before all else that moves a path comes to rest anyway.
            return (!matches!(next, Set::CpCmd(_))).then_some(None);
        };
        let (from, paths) = (self.end?, full.paths?);
        let to = [line.x, line.y, line.z];
        let off = [0, 1, 2].map(|axis| f64::from(to[axis] - from[axis]));
        let long = off.iter().map(|off| off * off).sum::<f64>().sqrt();
        let speed = f64::from(paths.junction_vel);
        let least = ROOM * speed * speed / f64::from(paths.plan_acc);
        let is_dark = line.velocity_or_power == 0.0 && line.cp_mode == CpMode::Absolute;
        let fits = is_dark && !paths.real_time_track.is_on() && long >= least;
        let [x, y, z] = [0, 1, 2].map(|axis| f32::midpoint(from[axis], to[axis]));
        let half = CpLeCmd { x, y, z, ..*line };
        fits.then(|| Some(half.into()))
    }

    fn notes(&mut self, command: &Set) {
        self.on_path = matches!(command, Set::CpCmd(_) | Set::CpLeCmd(_));
        // Settings leave it where it is.
        if let Some(end) = end_of(command) {
            self.end = end;
        }
    }
}

/// Where a command leads, if it says so; none if it leads nowhere.
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
        let full = {
            let pace = self.work.pace();
            (pace.next.is_empty() && pace.wanted != pace.told).then_some(pace.full)
        };
        let seam = full.and_then(|full| self.seam(&full));
        let mut track = self.work.track();
        let mut pace = self.work.pace();
        if let Some(half) = seam {
            pace.turns(track.steps_pulled(self.lead), half);
        }
        if let Some(setting) = pace.next.pop_front() {
            track.inserts(self.lead);
            drop((pace, track));
            self.notes(&setting);
            return Some(setting);
        }
        drop((pace, track));
        let command = self.commands.next()?;
        self.notes(&command);
        self.work.track().pulls(self.lead);
        Some(self.work.pace().passes(command))
    }
}

impl Work {
    /// Waits for wishes to be faster or slower, and has what goes out from then on follow them.
    pub(super) async fn follow_pace(&self, segment: &Segment) -> std::convert::Infallible {
        let mut wanted = self.shared.pace.subscribe();
        loop {
            let percent = *wanted.borrow_and_update();
            let before = self.pace().wanted;
            if before != percent && self.takes_pace(segment, percent).await.is_err() {
                // An arm that does not tell its speeds keeps them; the run hears of it as well.
                self.shared.pace.send_replace(before);
                self.shared.tell(JobEvent::Speed(before));
            }
            // The sender is the job's own.
            let _ = wanted.changed().await;
        }
    }

    /// A segment begins: the arm has the speeds of the program, or its own.
    pub(super) async fn begins_paced(&self, segment: &Segment) -> Result<(), Error> {
        {
            let mut pace = self.pace();
            (pace.wanted, pace.told) = (FULL, FULL);
            pace.full = Speeds::default();
            pace.next.clear();
            pace.tables.clear();
            pace.table = None;
        }
        let percent = *self.shared.pace.borrow();
        if percent == FULL {
            return Ok(());
        }
        Box::pin(self.takes_pace(segment, percent)).await?;
        let mut pace = self.pace();
        pace.tables = pace
            .table
            .clone()
            .map(|table| (0, table))
            .into_iter()
            .collect();
        Ok(())
    }

    /// From now on what goes out has this pace: the settings that it changes are restored at the end.
    async fn takes_pace(&self, segment: &Segment, percent: u8) -> Result<(), Error> {
        // What they say is no matter: these settings are read.
        let kinds = [
            build::speed(FULL.into(), FULL.into()),
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
        let table = if percent == FULL {
            segment.timetable.clone()
        } else {
            let (rest, table) = (segment.rest.clone(), segment.timetable.clone());
            let before: Vec<Set> = full.settings().map(|set| paced(set, percent)).collect();
            beside(async move {
                let paced = |set| paced(set, percent);
                { rest.timetable_with(&table, &before, paced, &BesideTurns) }.await
            })
            .await?
        };
        let mut pace = self.pace();
        // The program may have said more meanwhile.
        pace.full = pace.full.or(full);
        (pace.wanted, pace.table) = (percent, Some(table));
        Ok(())
    }

    /// Gives the arm the full speeds again, between two segments and before the pen goes up: a person who moves it then goes as fast
    /// as always.
    pub(super) async fn leaves_pace(&self, arm: &Arm) -> Result<(), Error> {
        let full = {
            let mut pace = self.pace();
            if pace.told == FULL {
                return Ok(());
            }
            (pace.wanted, pace.told) = (FULL, FULL);
            pace.full
        };
        for setting in full.settings() {
            arm.set_any(&setting).await?;
        }
        Ok(())
    }
}
