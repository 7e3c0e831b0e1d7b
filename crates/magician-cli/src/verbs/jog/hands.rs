//! What a pad has the arm do: one thing that moves it at a time, and a stop that overtakes it.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::rc::Rc;
use std::task::Poll;
use std::time::Duration;

use magician::commands::{JogCommonParams, PtpCommonParams};
use magician::words::Guards;
use magician::{Arm, ErrorKind, Jog, JogOptions, Owed, Set};
use magician_job::{Fault, JobError, JobHandle, JobSpec, NoJournal, Start};
use magician_program::{Ending, Plan, Program};

use magician_job::jog::Heading;

use crate::failure::{Failure, Kind};
use crate::saved::SavedSettings;

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Order {
    /// Jog until told otherwise, or until it was not kept up for so long.
    Jog {
        heading: Heading,
        keep: Duration,
    },
    /// Let the jog go on.
    Keep,
    /// End the jog.
    EndJog,
    /// A checked move by so much.
    Step {
        heading: Heading,
        length: f32,
        /// The laser burns, and that is meant.
        burning: bool,
    },
    /// Stop whatever moves, now.
    Stop,
    Home,
    ClearAlarms,
    /// A command at once, past the queue.
    Tool {
        what: &'static str,
        command: Box<Set>,
    },
    /// Share of the set speeds of jogs and moves, percent.
    Speed(f32),
    /// A program from one of its steps (from 0) on, checked as a whole first.
    Run {
        plan: Box<Plan>,
        from: usize,
    },
}

/// What was being done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum What {
    Jog(Heading),
    Step(Heading),
    Stop,
    Home,
    ClearAlarms,
    Tool(&'static str),
    Speed(f32),
    Run,
}

/// What came of something.
#[derive(Debug)]
pub(crate) struct Done {
    pub(crate) what: What,
    pub(crate) outcome: Result<(), Failure>,
}

type Work = Pin<Box<dyn Future<Output = Result<Option<Jog>, Failure>>>>;

struct Job {
    what: What,
    work: Work,
}

/// The settings that jogs and moves go by, as they were found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ratios {
    pub(crate) jog: JogCommonParams,
    pub(crate) moves: PtpCommonParams,
}

/// The arm in the hands of a pad.
pub(crate) struct Hands {
    arm: Arm,
    saved: SavedSettings,
    ratios: Ratios,
    /// Whether the ratios are not those that were found.
    changed: bool,
    jog: Option<(Heading, Jog)>,
    /// What moves it.
    moving: Option<Job>,
    /// What is done beside.
    beside: VecDeque<Job>,
    /// The program that runs, or ran last.
    program: Rc<RefCell<Option<JobHandle>>>,
}

impl Hands {
    pub(crate) fn new(arm: &Arm, saved: SavedSettings, ratios: Ratios) -> Self {
        Self {
            arm: arm.clone(),
            saved,
            ratios,
            changed: false,
            jog: None,
            moving: None,
            beside: VecDeque::new(),
            program: Rc::default(),
        }
    }

    /// What moves the arm, as far as this knows.
    pub(crate) fn doing(&self) -> Option<What> {
        let jog = self.jog.as_ref().map(|(heading, _)| What::Jog(*heading));
        self.moving.as_ref().map(|job| job.what).or(jog)
    }

    /// The step of the program that the arm is at, from 0, once that is known.
    pub(crate) fn step(&self) -> Option<usize> {
        let program = self.program.borrow();
        usize::try_from(program.as_ref()?.progress().step).ok()
    }

    /// Does what is ordered, or says what came of it at once. What was ordered before and is not done yet gives way only to a
    /// stop, and a jog to another jog.
    pub(crate) fn order(&mut self, order: Order) -> Option<Done> {
        match order {
            Order::Keep => self.keep(),
            Order::EndJog => {
                self.end_jog();
                None
            }
            Order::Stop => {
                self.jog = None;
                // The last that holds it, but for what waits for it and is let go of here: it stops.
                self.program.take();
                // What has not been sent would come after it: a laser that is switched on, say.
                self.beside.retain(|job| !matches!(job.what, What::Tool(_)));
                let arm = self.arm.clone();
                let work = async move { Ok(arm.stop().await.map(|()| None)?) };
                self.begin(What::Stop, work);
                None
            }
            Order::ClearAlarms => {
                let arm = self.arm.clone();
                let work = async move { Ok(arm.clear_alarms().await.map(|()| None)?) };
                self.beside(What::ClearAlarms, work)
            }
            Order::Tool { what, command } => {
                // Whoever is at the pad has answered that it may burn.
                let arm = self.arm.allowing_laser();
                let work = async move { Ok(arm.set_any(&command).await.map(|()| None)?) };
                self.beside(What::Tool(what), work)
            }
            Order::Speed(percent) => self.speed(percent),
            Order::Jog { heading, keep } => self.start_jog(heading, keep),
            Order::Step {
                heading,
                length,
                burning,
            } => {
                let what = What::Step(heading);
                let command = heading.axis.step(heading.signed(length));
                let guards = Guards::default().laser(!burning);
                let arm = self.arm.clone();
                let work = async move {
                    // From where it has come to rest: a jog may be ending.
                    arm.wait_still().await?;
                    arm.perform_with(&[command], guards).await?;
                    Ok(None)
                };
                self.begin_if_free(what, work)
            }
            Order::Home => {
                let arm = self.arm.clone();
                let work = async move { Ok(arm.home().await.map(|()| None)?) };
                self.begin_if_free(What::Home, work)
            }
            Order::Run { plan, from } => {
                let program = Rc::clone(&self.program);
                let work = run(self.arm.clone(), *plan, from, program);
                self.begin_if_free(What::Run, work)
            }
        }
    }

    /// Waits until something is done.
    pub(crate) async fn next(&mut self) -> Done {
        let (what, outcome) = poll_fn(|context| {
            if let Some(job) = &mut self.moving
                && let Poll::Ready(outcome) = job.work.as_mut().poll(context)
            {
                let what = job.what;
                self.moving = None;
                return Poll::Ready((what, outcome));
            }
            if let Some(job) = self.beside.front_mut()
                && let Poll::Ready(outcome) = job.work.as_mut().poll(context)
            {
                let what = job.what;
                self.beside.pop_front();
                return Poll::Ready((what, outcome));
            }
            Poll::Pending
        })
        .await;
        let outcome = outcome.map(|jog| {
            if let (What::Jog(heading), Some(jog)) = (what, jog) {
                self.jog = Some((heading, jog));
            }
        });
        Done { what, outcome }
    }

    /// Ends what is under way: what moves is stopped, and settings are given back.
    pub(crate) async fn finish(mut self) -> Result<(), Failure> {
        self.moving = None;
        self.beside.clear();
        if let Some(program) = self.program.take() {
            program.stop();
            // It gives back its settings.
            let _ = program.outcome().await;
        }
        if let Some((_, jog)) = self.jog.take() {
            jog.stop().await?;
        }
        if self.arm.moving() {
            self.arm.stop().await?;
        }
        Ok(self.saved.restore(&self.arm).await?)
    }

    fn keep(&mut self) -> Option<Done> {
        let (heading, jog) = self.jog.as_ref()?;
        let (what, kept) = (What::Jog(*heading), jog.keep());
        let error = kept.err()?;
        self.jog = None;
        // That it was kept up too late is how a held key ends that was seen too late.
        let outcome = match error.kind() {
            ErrorKind::Timeout => Ok(()),
            _ => Err(error.into()),
        };
        Some(Done { what, outcome })
    }

    fn end_jog(&mut self) {
        self.jog = None;
        if self.jogs() {
            self.moving = None;
        }
    }

    /// Whether what moves it is a jog that begins.
    fn jogs(&self) -> bool {
        (self.moving.as_ref()).is_some_and(|job| matches!(job.what, What::Jog(_)))
    }

    fn start_jog(&mut self, heading: Heading, keep: Duration) -> Option<Done> {
        if self.jogs() {
            self.moving = None;
        }
        let arm = self.arm.clone();
        let options = JogOptions::default().keep(keep);
        let work = async move { Ok(arm.jog_with(heading.jog(), options).await.map(Some)?) };
        // The one under way is kept until this one has taken its place: so the arm goes over into it.
        self.begin_if_free(What::Jog(heading), work)
    }

    fn speed(&mut self, percent: f32) -> Option<Done> {
        let first = !std::mem::replace(&mut self.changed, true);
        let mut before = Owed::default();
        before.owe(self.ratios.jog);
        before.owe(self.ratios.moves);
        let jog = JogCommonParams {
            velocity_ratio: percent,
            ..self.ratios.jog
        };
        let moves = PtpCommonParams {
            velocity_ratio: percent,
            ..self.ratios.moves
        };
        let (arm, saved) = (self.arm.clone(), self.saved.clone());
        let work = async move {
            if first {
                saved.save_all(&arm, before).await;
            }
            arm.set(&jog).await?;
            arm.set(&moves).await?;
            Ok(None)
        };
        self.beside(What::Speed(percent), work)
    }

    fn begin_if_free(
        &mut self,
        what: What,
        work: impl Future<Output = Result<Option<Jog>, Failure>> + 'static,
    ) -> Option<Done> {
        let jog_for_jog = matches!(what, What::Jog(_)) || self.jog.is_none();
        if self.moving.is_none() && jog_for_jog {
            self.begin(what, work);
            return None;
        }
        let message = "the arm is at something: space stops it";
        let outcome = Err(Failure::new(Kind::Driver(ErrorKind::Closed), message));
        Some(Done { what, outcome })
    }

    fn begin(
        &mut self,
        what: What,
        work: impl Future<Output = Result<Option<Jog>, Failure>> + 'static,
    ) {
        let work = Box::pin(work);
        self.moving = Some(Job { what, work });
    }

    fn beside(
        &mut self,
        what: What,
        work: impl Future<Output = Result<Option<Jog>, Failure>> + 'static,
    ) -> Option<Done> {
        let work = Box::pin(work);
        self.beside.push_back(Job { what, work });
        None
    }
}

/// Checks a program from here on, and runs it.
async fn run(
    arm: Arm,
    plan: Plan,
    from: usize,
    program: Rc<RefCell<Option<JobHandle>>>,
) -> Result<Option<Jog>, Failure> {
    program.take();
    arm.wait_still().await?;
    // Who stops it wants the tool where it is.
    let ending = Ending {
        stay: true,
        ..Ending::default()
    };
    let spec = JobSpec::new(Program::new(plan, Some(1)))
        .start(Start::Step(from as u64))
        .ending(ending);
    let job = magician_job::Job::start(&arm, spec, NoJournal);
    program.replace(Some(job.clone()));
    match job.outcome().await {
        Ok(_) => Ok(None),
        Err(error) => Err(told(&error)),
    }
}

/// Why a program did not come to its end, as a pad says it.
fn told(error: &JobError) -> Failure {
    match &error.fault {
        Fault::Arm(error) => Failure::from(&**error),
        Fault::Program(problem) => {
            let name = problem.name.as_ref();
            let name = name.map_or_else(String::new, |name| format!("{name}: "));
            Failure::invalid(format!("{name}{}", problem.message))
        }
        Fault::Refused { report, .. } if let Some(complaint) = report.complaints.first() => {
            let name = complaint.name.clone();
            let name = name.unwrap_or_else(|| format!("step {}", report.number(complaint.step)));
            let message = format!("{name}: {}", complaint.error.message());
            Failure::new(Kind::Driver(complaint.error.kind()), message)
        }
        _ => Failure::new(Kind::Driver(ErrorKind::Closed), error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use magician::commands::EndEffectorLaser;
    use magician::words;

    use super::*;

    #[tokio::test]
    async fn nothing_is_switched_on_after_a_stop_that_was_asked_for_later() {
        let arm = Arm::connect(&"sim".parse().unwrap()).await.unwrap();
        let ratios = Ratios {
            jog: arm.get::<JogCommonParams>().await.unwrap(),
            moves: arm.get::<PtpCommonParams>().await.unwrap(),
        };
        let mut hands = Hands::new(&arm, SavedSettings::default(), ratios);
        let (what, command) = ("the laser burns", Box::new(words::laser(true)));
        assert!(hands.order(Order::Tool { what, command }).is_none());
        assert!(hands.order(Order::Stop).is_none());
        assert_eq!(hands.next().await.what, What::Stop);
        assert!(hands.beside.is_empty());
        // What is asked for after it is done.
        let (what, command) = ("suction on", Box::new(words::suction(true)));
        assert!(hands.order(Order::Tool { what, command }).is_none());
        assert_eq!(hands.next().await.what, What::Tool("suction on"));
        let laser = arm.get::<EndEffectorLaser>().await.unwrap();
        assert!(!laser.is_on.is_on());
    }
}
