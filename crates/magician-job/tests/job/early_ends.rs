//! Ends of runs in every way and at every time: the pen is up, the laser is off, and the arm's
//! settings are restored.

use std::time::Duration;

use magician::commands::{EndEffectorLaser, Pose};
use magician::{Arm, Set, SettingsBackup};
use magician_job::{
    Fault, Job, JobSpec, JobState, NoJournal, PauseReason, SECOND_STOP_DELAY, SavedSettings,
    StopOrder, StopRule, StopSignal,
};
use magician_program::{Action, Origin, Plan, Program, Tool, Travel};
use tokio::time::{Instant, sleep};

use super::fixtures::{KINDS, PAPER, bench, plan};

/// Instants at which runs are ended.
const INSTANTS: u64 = 200;
/// Latest instant, ms into a run. Most programs below take longer.
const MAX_INSTANT_MS: u64 = 9_000;

/// Pseudo-random numbers from a seed.
struct Seeded(u64);

impl Seeded {
    /// A number below `end`.
    fn below(&mut self, end: u64) -> u64 {
        // Knuth's MMIX generator, whose upper bits are good.
        self.0 = (self.0)
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % end
    }

    fn ms(&mut self, end: u64) -> Duration {
        Duration::from_millis(self.below(end))
    }
}

/// Way to end a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EndCause {
    /// Up to four signals within a tenth of a second.
    Signals,
    /// Hang-ups that continue for seconds.
    HangUps,
    /// A pause, and a stop during it.
    Paused,
    /// The drop of the last handle.
    Dropped,
    /// A second stop by a person: nothing moves after it.
    AtOnce,
    /// The announced end of the line, often with the Ctrl-C that ended the station too.
    LineEnds,
}

const END_CAUSES: [EndCause; 6] = [
    EndCause::Signals,
    EndCause::HangUps,
    EndCause::Paused,
    EndCause::Dropped,
    EndCause::AtOnce,
    EndCause::LineEnds,
];

/// A burn that sets its own speeds.
fn burn() -> Plan {
    let mut plan = Plan::new("a burn");
    plan.tool = Some(Tool::Laser);
    let mut push = |action: Action| plan.push(action, Origin::NONE);
    push(magician::build::path_speed(30.0, 100.0).into());
    let line = |to: [f32; 4]| Action::Move {
        to,
        by: Travel::Line,
    };
    push(line([210.0, -40.0, 0.0, 0.0]));
    for y in [40.0, -40.0, 40.0, -40.0] {
        push(Action::Burn {
            to: [210.0, y, 0.0],
            power: 60.0,
        });
    }
    push(Action::Laser(false));
    plan
}

async fn settings(arm: &Arm, plan: &Plan) -> Vec<Set> {
    let changes: Vec<Set> = plan.commands().collect();
    let read = SettingsBackup::read(arm, &changes).await;
    read.expect("they are read").settings().to_vec()
}

async fn height(arm: &Arm) -> f64 {
    arm.get::<Pose>().await.expect("a pose").z.into()
}

/// Passes signals to a job as a front end does.
struct Signals<'a> {
    rule: StopRule,
    begun: Instant,
    job: &'a magician_job::JobHandle,
    at_once: bool,
}

impl<'a> Signals<'a> {
    fn of(job: &'a magician_job::JobHandle) -> Self {
        Self {
            rule: StopRule::default(),
            begun: Instant::now(),
            job,
            at_once: false,
        }
    }

    fn send(&mut self, signal: StopSignal) {
        if let Some(order) = self.rule.order_for(signal, self.begun.elapsed()) {
            self.job.stop();
            self.at_once |= order == StopOrder::Halt;
        }
    }
}

#[tokio::test(start_paused = true)]
async fn early_end_at_any_instant_leaves_pen_up_laser_off_and_settings_restored() {
    let signals = [
        StopSignal::Interrupt,
        StopSignal::Terminate,
        StopSignal::HangUp,
        StopSignal::Request,
    ];
    let (mut stopped, mut lifted, mut halted) = (0, 0, 0);
    for seed in 0..INSTANTS {
        let mut seeded = Seeded(seed);
        seeded.below(2);
        let plan = match KINDS.get((seed % 5) as usize) {
            Some(kind) => plan(*kind),
            None => burn(),
        };
        let how = END_CAUSES[(seed / 5 % 6) as usize];
        let program = Program::new(plan.clone(), Some(1));
        let (_cell, arm) = bench(&program).await;
        let before = settings(&arm, &plan).await;
        assert!(!before.is_empty());
        let saved = SavedSettings::default();
        let spec = JobSpec::new(program).saved(saved.clone());
        let job = Job::start(&arm, spec, NoJournal);
        let at = seeded.ms(MAX_INSTANT_MS);
        let what = format!("seed {seed}: {}, {how:?} after {at:?}", plan.title);
        sleep(at).await;
        let mut ends = Signals::of(&job);
        match how {
            EndCause::Signals => {
                for _ in 0..=seeded.below(4) {
                    ends.send(signals[seeded.below(4) as usize]);
                    sleep(seeded.ms(30)).await;
                }
            }
            EndCause::HangUps => {
                for _ in 0..40 {
                    ends.send(StopSignal::HangUp);
                    sleep(seeded.ms(100)).await;
                }
            }
            EndCause::Paused => {
                drop(job.pause(PauseReason::Person));
                sleep(seeded.ms(2_000)).await;
                ends.send(StopSignal::HangUp);
            }
            EndCause::Dropped => {}
            EndCause::AtOnce => {
                ends.send(StopSignal::Interrupt);
                sleep(SECOND_STOP_DELAY).await;
                ends.send(StopSignal::Interrupt);
            }
            EndCause::LineEnds => {
                arm.front_end().end_notice().set(true);
                if seeded.below(2) == 1 {
                    sleep(seeded.ms(400)).await;
                    ends.send(StopSignal::Interrupt);
                }
            }
        }
        let at_once = ends.at_once;
        let outcome = if how == EndCause::Dropped {
            drop(job);
            sleep(Duration::from_secs(20)).await;
            None
        } else {
            Some(job.outcome().await)
        };
        let twice = matches!(&outcome, Some(Err(error)) if matches!(error.fault, Fault::Stopped { twice: true }));
        assert!(!twice || at_once, "{what}: {outcome:?}");
        if let (EndCause::LineEnds, Some(Err(error))) = (how, &outcome) {
            assert!(error.stopped_by_line_end, "{what}: {error}");
        }
        stopped += u64::from(matches!(outcome, Some(Err(_))));
        halted += u64::from(twice);
        let laser = arm.get::<EndEffectorLaser>().await.expect("read");
        assert!(!laser.is_on.is_on(), "{what}: it burns");
        assert_eq!(settings(&arm, &plan).await, before, "{what}");
        assert!(saved.is_empty(), "{what}");
        let stands = height(&arm).await;
        if plan.tool == Some(Tool::Pen) && !twice {
            assert!(stands > PAPER + 9.0, "{what}: the pen is at {stands}");
            lifted += 1;
        }
        sleep(Duration::from_secs(2)).await;
        assert_eq!(height(&arm).await, stands, "{what}: it stands");
    }
    // Most runs ended in the middle.
    assert!(
        stopped > 100 && lifted > 100 && halted > 10,
        "{stopped} {lifted} {halted}"
    );
}

#[tokio::test(start_paused = true)]
async fn second_stop_during_the_lift_restores_settings() {
    for ms in [0, 1, 5, 20, 60, 150, 400] {
        let plan = plan(KINDS[0]);
        let program = Program::new(plan.clone(), Some(1));
        let (_cell, arm) = bench(&program).await;
        let before = settings(&arm, &plan).await;
        let job = Job::start(&arm, JobSpec::new(program), NoJournal);
        sleep(Duration::from_secs(4)).await;
        assert_eq!(job.state(), JobState::Running);
        job.stop();
        sleep(Duration::from_millis(ms)).await;
        job.stop();
        let _ = job.outcome().await;
        assert_eq!(settings(&arm, &plan).await, before, "{ms} ms");
    }
}

#[tokio::test(start_paused = true)]
async fn second_stop_after_the_end_of_the_line_moves_nothing() {
    let program = Program::new(plan(KINDS[0]), Some(1));
    let (_cell, arm) = bench(&program).await;
    let mut ending = JobSpec::new(program.clone()).ending;
    ending.lift = 60.0;
    let job = Job::start(&arm, JobSpec::new(program).ending(ending), NoJournal);
    sleep(Duration::from_secs(4)).await;
    arm.front_end().end_notice().set(true);
    let mut ends = Signals::of(&job);
    ends.send(StopSignal::Interrupt);
    while height(&arm).await < PAPER + 1.0 {
        sleep(Duration::from_millis(10)).await;
    }
    sleep(SECOND_STOP_DELAY.saturating_sub(ends.begun.elapsed())).await;
    ends.send(StopSignal::Interrupt);
    let error = job.outcome().await.expect_err("stopped");
    assert!(ends.at_once && matches!(error.fault, Fault::Stopped { twice: true }));
    assert!(height(&arm).await < PAPER + 59.0);
}

#[tokio::test(start_paused = true)]
async fn end_of_the_line_before_the_first_command_does_not_stop_the_arm() {
    let program = Program::new(plan(KINDS[0]), Some(1));
    let (_cell, arm) = bench(&program).await;
    // Another client lifts its pen.
    let lift = magician::build::line_by(0.0, 0.0, 30.0, 0.0);
    let run = arm.start(vec![lift]);
    arm.front_end().end_notice().set(true);
    let before = arm.stops();
    let job = Job::start(&arm, JobSpec::new(program), NoJournal);
    let error = job.outcome().await.expect_err("stopped");
    assert!(error.is_stop() && error.stopped_by_line_end && error.pose.is_none());
    assert!(error.resume_place.is_none() && arm.stops() == before);
    drop(run);
}
