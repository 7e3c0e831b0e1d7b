//! What a pad has the arm do: one thing that moves it at a time, and a stop that overtakes it.

use std::collections::VecDeque;
use std::fmt;
use std::future::{Future, poll_fn};
use std::pin::Pin;
use std::sync::{Arc, Mutex, PoisonError};
use std::task::Poll;
use std::time::Duration;

use magician::commands::{JogCommonParams, PtpCommonParams};
use magician::words::{self, Guards};
use magician::{Arm, Error, ErrorKind, Jog, JogOptions, Owed, Set, ToolBias};
use magician_program::{Ending, Grip, Plan, Program};

use super::Heading;
use crate::{JobError, JobHandle, JobSpec, NoJournal, SavedSettings, Start};

/// What is to be done.
#[derive(Clone, Debug, PartialEq)]
pub enum Order {
    /// Jog until told otherwise, or until it was not kept up for so long.
    Jog {
        /// Which way.
        heading: Heading,
        /// How long it goes on without [`Order::Keep`].
        keep: Duration,
    },
    /// Let the jog go on.
    Keep,
    /// End the jog.
    EndJog,
    /// A checked move by so much.
    Step {
        /// Which way.
        heading: Heading,
        /// How far, mm or deg; above 0.
        length: f32,
        /// The laser burns, and that is meant.
        burning: bool,
    },
    /// Stop whatever moves, now.
    Stop,
    /// Home the arm.
    Home,
    /// Clear the alarms that stand.
    ClearAlarms,
    /// Something of the tools, at once and past the queue.
    Tool(ToolOrder),
    /// Share of the set speeds of jogs and moves, percent.
    Speed(f32),
    /// A program from one of its steps (from 0) on, checked as a whole first.
    Run {
        /// The program.
        plan: Box<Plan>,
        /// The step it begins with.
        from: usize,
    },
}

/// What a tool is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ToolOrder {
    /// The suction cup goes on or off.
    Suction(bool),
    /// The gripper closes, opens, or its pump goes off.
    Gripper(Grip),
    /// The laser burns, or is dark. Who orders it has made sure that it may burn.
    Laser(bool),
    /// The arm counts from a tip that is so far from its flange, mm.
    Tip(ToolBias),
}

impl ToolOrder {
    fn command(self) -> Set {
        match self {
            Self::Suction(on) => words::suction(on),
            Self::Gripper(Grip::Close) => words::grip(),
            Self::Gripper(Grip::Open) => words::release(),
            Self::Gripper(Grip::Off) => words::pump_off(),
            Self::Laser(on) => words::laser(on),
            Self::Tip(bias) => words::tool(bias),
        }
    }
}

/// What was being done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// A jog, as long as it goes on.
    Jog(Heading),
    /// A checked move by a step.
    Step(Heading),
    /// A stop.
    Stop,
    /// Homing.
    Home,
    /// Clearing the alarms.
    ClearAlarms,
    /// Something of the tools.
    Tool(ToolOrder),
    /// Setting the speeds to so many percent.
    Speed(f32),
    /// A program.
    Run,
}

/// What came of something.
#[derive(Debug)]
pub struct Done {
    /// What was ordered.
    pub what: What,
    /// Whether it was done.
    pub outcome: Result<(), OrderError>,
}

/// Why an order was not carried out.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum OrderError {
    /// Something else moves the arm: only a stop, and a jog for a jog, does not wait for it.
    Busy,
    /// The arm or its line.
    Arm(Arc<Error>),
    /// The program did not come to its end.
    Program(Arc<JobError>),
}

impl From<Error> for OrderError {
    fn from(error: Error) -> Self {
        Self::Arm(Arc::new(error))
    }
}

/// For logs: what people read is made by the program that they use.
impl fmt::Display for OrderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Busy => f.write_str("the arm is doing something else"),
            Self::Arm(error) => error.fmt(f),
            Self::Program(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for OrderError {}

type Worked = Result<Option<Jog>, OrderError>;
type Work = Pin<Box<dyn Future<Output = Worked> + Send>>;
/// The program that runs, or ran last.
type Running = Arc<Mutex<Option<JobHandle>>>;

struct Job {
    what: What,
    work: Work,
}

/// The settings that jogs and moves go by, as they were found.
#[derive(Clone, Copy, Debug)]
pub struct Ratios {
    /// Of jogs.
    pub jog: JogCommonParams,
    /// Of moves.
    pub moves: PtpCommonParams,
}

/// The arm in the hands of a pad.
pub struct Hands {
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
    program: Running,
}

impl Hands {
    /// At this arm; what it changes is restored by `saved`.
    #[must_use]
    pub fn new(arm: &Arm, saved: SavedSettings, ratios: Ratios) -> Self {
        Self {
            arm: arm.clone(),
            saved,
            ratios,
            changed: false,
            jog: None,
            moving: None,
            beside: VecDeque::new(),
            program: Running::default(),
        }
    }

    /// What moves the arm, as far as this knows.
    #[must_use]
    pub fn doing(&self) -> Option<What> {
        let jog = self.jog.as_ref().map(|(heading, _)| What::Jog(*heading));
        self.moving.as_ref().map(|job| job.what).or(jog)
    }

    /// The step of the program that the arm is at, from 0, once that is known.
    #[must_use]
    pub fn step(&self) -> Option<usize> {
        let program = lock(&self.program).clone();
        usize::try_from(program?.progress().step).ok()
    }

    /// Does what is ordered, or says what came of it at once. What was ordered before and is not done yet gives way only to a
    /// stop, and a jog to another jog.
    pub fn order(&mut self, order: Order) -> Option<Done> {
        match order {
            Order::Keep => self.keep(),
            Order::EndJog => {
                self.end_jog();
                None
            }
            Order::Stop => {
                self.jog = None;
                // The last that holds it, but for what waits for it and is let go of here: it stops.
                drop(lock(&self.program).take());
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
            Order::Tool(tool) => {
                // Whoever is at the pad has answered that it may burn.
                let arm = self.arm.allowing_laser();
                let work = async move { Ok(arm.set_any(&tool.command()).await.map(|()| None)?) };
                self.beside(What::Tool(tool), work)
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
                let program = Arc::clone(&self.program);
                let work = run(self.arm.clone(), *plan, from, program);
                self.begin_if_free(What::Run, work)
            }
        }
    }

    /// Waits until something is done.
    pub async fn next(&mut self) -> Done {
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
    ///
    /// # Errors
    /// When the arm does not confirm that it stands, and as [`SavedSettings::restore`].
    pub async fn finish(mut self) -> magician::Result<()> {
        self.moving = None;
        self.beside.clear();
        let program = lock(&self.program).take();
        if let Some(program) = program {
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
        self.saved.restore(&self.arm).await
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
        work: impl Future<Output = Worked> + Send + 'static,
    ) -> Option<Done> {
        let jog_for_jog = matches!(what, What::Jog(_)) || self.jog.is_none();
        if self.moving.is_none() && jog_for_jog {
            self.begin(what, work);
            return None;
        }
        let outcome = Err(OrderError::Busy);
        Some(Done { what, outcome })
    }

    fn begin(&mut self, what: What, work: impl Future<Output = Worked> + Send + 'static) {
        let work = Box::pin(work);
        self.moving = Some(Job { what, work });
    }

    fn beside(
        &mut self,
        what: What,
        work: impl Future<Output = Worked> + Send + 'static,
    ) -> Option<Done> {
        let work = Box::pin(work);
        self.beside.push_back(Job { what, work });
        None
    }
}

/// Checks a program from here on, and runs it.
async fn run(arm: Arm, plan: Plan, from: usize, program: Running) -> Worked {
    drop(lock(&program).take());
    arm.wait_still().await?;
    // Who stops it wants the tool where it is.
    let ending = Ending {
        stay: true,
        ..Ending::default()
    };
    let spec = JobSpec::new(Program::new(plan, Some(1)))
        .start(Start::Step(from as u64))
        .ending(ending);
    let job = crate::Job::start(&arm, spec, NoJournal);
    lock(&program).replace(job.clone());
    match job.outcome().await {
        Ok(_) => Ok(None),
        Err(error) => Err(OrderError::Program(error)),
    }
}

fn lock(program: &Running) -> std::sync::MutexGuard<'_, Option<JobHandle>> {
    program.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use magician::commands::EndEffectorLaser;

    use super::*;

    #[tokio::test]
    async fn nothing_is_switched_on_after_a_stop_that_was_asked_for_later() {
        let arm = Arm::connect(&"sim".parse().unwrap()).await.unwrap();
        let ratios = Ratios {
            jog: arm.get::<JogCommonParams>().await.unwrap(),
            moves: arm.get::<PtpCommonParams>().await.unwrap(),
        };
        let mut hands = Hands::new(&arm, SavedSettings::default(), ratios);
        let laser = Order::Tool(ToolOrder::Laser(true));
        assert!(hands.order(laser).is_none());
        assert!(hands.order(Order::Stop).is_none());
        assert_eq!(hands.next().await.what, What::Stop);
        assert!(hands.beside.is_empty());
        // What is asked for after it is done.
        let suction = ToolOrder::Suction(true);
        assert!(hands.order(Order::Tool(suction)).is_none());
        assert_eq!(hands.next().await.what, What::Tool(suction));
        let laser = arm.get::<EndEffectorLaser>().await.unwrap();
        assert!(!laser.is_on.is_on());
    }
}
