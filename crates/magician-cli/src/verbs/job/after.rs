//! What becomes of a run that ended before its end, and where the next one goes on.

use std::time::{Duration, Instant};

use magician::commands::{DeviceTime, Pose};
use magician::{Arm, Error, ErrorKind};
use magician_program::Rest;
use magician_program::resume::{Mark, Seen, Span, Verdict, settle};
use tokio::time::{sleep, timeout};

use super::drive::{Drive, State};
use super::journal::Journal;
use crate::context::Stood;
use crate::failure::{Failure, Kind};
use crate::progress::attended;

/// How long an arm that failed is asked how it stands.
const AFTERMATH: Duration = Duration::from_secs(3);
/// How long a line that broke while the laser burnt is waited for.
const BACK: Duration = Duration::from_secs(10);
/// Between two looks at an arm that still has something to do.
const LOOKS: Duration = Duration::from_millis(100);
/// A queue that stands for so long does not go on by itself.
const STANDING: Duration = Duration::from_secs(3);

impl Drive<'_> {
    /// The run has failed: the arm is stopped and asked how far it came, if it can be.
    pub(super) async fn fails(&self, arm: &Arm, failure: Failure) -> Failure {
        let gone = matches!(failure.kind, Kind::Driver(ErrorKind::Port));
        // On a line that is found again the laser is put out first.
        let gone = gone && !(self.made.program.plan().burns() && self.is_back(arm).await);
        let asked = async {
            arm.stop().await?;
            let pose = arm.get::<Pose>().await?;
            let index = arm.current_index().await?.0;
            let clock = arm.get::<DeviceTime>().await?.g_systick;
            Ok::<_, Error>((Stood { pose, index }, clock))
        };
        let stood = match gone {
            true => None,
            false => timeout(AFTERMATH, asked).await.ok().and_then(Result::ok),
        };
        let uncertain = matches!(failure.kind, Kind::Driver(ErrorKind::Uncertain));
        if let Some((stood, clock)) = &stood
            && uncertain
            && self.was_reset(stood, *clock)
        {
            return self.forgotten(failure);
        }
        let stood = stood.map(|(stood, _)| stood);
        let lifts = !matches!(failure.kind, Kind::Driver(kind) if !kind.lifts());
        let mut failure = self.over(failure, stood);
        if let Some(stood) = stood.filter(|_| lifts)
            && let Some(said) = self.lift(arm, &stood).await
        {
            failure.message = format!("{}; {said}", failure.message);
        }
        failure
    }

    /// A signal has stopped the arm: what is known is kept before anything moves, because a lift counts among the arm's
    /// commands, and then the pen goes up. What came of that, if something had to go up.
    pub(super) async fn stopped(&self, arm: &Arm, stood: &Stood) -> Option<String> {
        self.keeps(false, Some(*stood));
        self.lift(arm, stood).await
    }

    /// The pen of a drawing that has begun goes up; once, whatever comes of it.
    async fn lift(&self, arm: &Arm, stood: &Stood) -> Option<String> {
        let height = {
            let mut state = self.state.borrow_mut();
            let State { rest, tally, .. } = &*state;
            let moved = |rest: &Rest| rest.has_moved(tally, stood.index, &stood.pose);
            let moved = rest.as_ref().is_some_and(moved);
            if !moved {
                return None;
            }
            state.lift.take()
        };
        let Some(height) = height else {
            let stays = self.made.ending.stay && self.made.ending.draws(self.made.program.plan());
            return stays.then(|| "the pen stays down (`--stay`)".to_owned());
        };
        Some(match arm.lift(height).await {
            Ok(lifted) => lifted.to_string(),
            Err(error) => format!("the pen was not lifted: {error}"),
        })
    }

    /// Waits a while for a line that broke while the laser burnt; whether it is back.
    async fn is_back(&self, arm: &Arm) -> bool {
        let what = "the line broke: waiting for it, to switch the laser off";
        let back = timeout(BACK, arm.reconnected());
        matches!(attended(self.json, what, back).await, Ok(Ok(())))
    }

    /// Whether the arm counts anew since the run began: its index says nothing of the run then.
    fn was_reset(&self, stood: &Stood, clock: u32) -> bool {
        let state = self.state.borrow();
        let Some(journal) = &state.journal else {
            return false;
        };
        let most = state.from() + state.tally.finished(stood.index).most;
        clock < journal.mark.clock || most < journal.mark.finished
    }

    /// The arm has forgotten what it did: only what was seen to be finished is certain.
    fn forgotten(&self, failure: Failure) -> Failure {
        let mut state = self.state.borrow_mut();
        let Some(mut journal) = state.journal.take() else {
            return failure;
        };
        if state.pulled == 0 {
            return failure;
        }
        journal.mark.handed = self.handed(&state);
        let span = Span {
            least: journal.mark.finished,
            most: journal.mark.handed,
        };
        journal.ends(Verdict::Doubt(span));
        failure.hint(self.in_doubt(span))
    }

    /// Steps that have been given to the arm, at most.
    fn handed(&self, state: &State) -> u64 {
        let steps = state.from() + state.pulled;
        steps.min(self.made.program.steps().unwrap_or(u64::MAX))
    }

    /// The run is over before its end: what is known is kept, and the failure says how to go on.
    pub(super) fn over(&self, failure: Failure, stood: Option<Stood>) -> Failure {
        let uncertain = matches!(failure.kind, Kind::Driver(ErrorKind::Uncertain));
        match self.keeps(uncertain, stood) {
            Some(advice) => failure.hint(advice),
            None => failure,
        }
    }

    /// Keeps what is known of a run that is over before its end, if that was not done yet; how to go on.
    fn keeps(&self, uncertain: bool, stood: Option<Stood>) -> Option<String> {
        let mut state = self.state.borrow_mut();
        if let Some(journal) = state.journal.take().filter(|_| state.pulled > 0) {
            state.advice = Some(self.kept(&state, journal, uncertain, stood));
        }
        state.advice.clone()
    }

    fn kept(
        &self,
        state: &State,
        mut journal: Journal,
        uncertain: bool,
        stood: Option<Stood>,
    ) -> String {
        journal.mark.handed = self.handed(state);
        let command = format!("the same command with {}--resume", self.with_start());
        let Some(stood) = stood else {
            journal.breaks_off();
            return format!(
                "the arm finishes what it has; {command} asks it how far it came, and goes on"
            );
        };
        let span = match uncertain {
            true => state.tally.certain(stood.index),
            false => state.tally.finished(stood.index),
        };
        let from = state.from();
        let verdict = match span.least == span.most {
            true => settle(from + span.least, |steps| {
                let rest = state.rest.as_ref()?;
                rest.stands_after(steps, &stood.pose, true)
            }),
            false => Verdict::Doubt(Span {
                least: from + span.least,
                most: from + span.most,
            }),
        };
        let goes_on = (state.rest.as_ref()).and_then(|rest| rest.goes_on(verdict, &stood.pose));
        let (verdict, within) = match goes_on {
            Some((steps, Some(place))) => (Verdict::Again(steps), Some((steps, place))),
            _ => (verdict, None),
        };
        journal.mark.within = within;
        journal.ends(verdict);
        self.advice(verdict, within.is_some(), &command)
    }

    fn advice(&self, verdict: Verdict, within: bool, command: &str) -> String {
        let of = self.of();
        match verdict {
            Verdict::Again(steps) if within => format!(
                "{steps}{of} steps are done and the next was cut short; {command} goes on where it stopped, in step {}",
                steps + 1
            ),
            Verdict::After(steps) => format!(
                "{steps}{of} steps are done; {command} goes on with step {}",
                steps + 1
            ),
            Verdict::Again(steps) => format!(
                "{steps}{of} steps are done and the next was cut short; {command} goes on with step {}",
                steps + 1
            ),
            Verdict::Doubt(span) => self.in_doubt(span),
        }
    }

    /// The steps behind which an earlier run of the same goes on, and the place within the next, if it is not at its beginning.
    pub(super) async fn resumed(
        &self,
        arm: &Arm,
        journal: &Journal,
    ) -> Result<(u64, Option<[f64; 3]>), Failure> {
        let mark = journal.left()?;
        if mark.ended.is_none() {
            self.settled(arm).await?;
        }
        let seen = Seen {
            current: arm.current_index().await?.0,
            clock: arm.get::<DeviceTime>().await?.g_systick,
        };
        let pose = arm.get::<Pose>().await?;
        let start = arm.preflight_for(&self.made.program.kinds()).await?;
        let whole = self.made.program.rest(0, start).ok();
        let seen = self.lasting.then_some(seen);
        let verdict = mark.verdict(seen, |steps| {
            whole.as_ref()?.stands_after(steps, &pose, false)
        });
        // An arm that was stopped and has said nothing of it stands where it was stopped still, if it stands on that line.
        let stopped = matches!(verdict, Verdict::Again(_)) && mark.ended.is_none();
        let standing = whole.as_ref().filter(|_| stopped);
        let standing = standing.and_then(|whole| whole.goes_on(verdict, &pose));
        let (steps, within) = match (verdict, standing) {
            (_, Some((steps, Some(place)))) => (steps, Some(place)),
            (Verdict::After(steps) | Verdict::Again(steps), _) => (steps, mark.place_after(steps)),
            (Verdict::Doubt(span), _) => return Err(self.doubtful(&mark, span)),
        };
        match (verdict, within) {
            (_, Some(_)) => self.say(&format!(
                "step {} was cut short: it goes on where it stopped",
                steps + 1
            )),
            (Verdict::Again(_), None) => self.say(&format!(
                "step {} was cut short, or nobody knows how it ended: it is done again",
                steps + 1
            )),
            _ => {}
        }
        if self.made.program.steps().is_some_and(|all| steps >= all) {
            journal.remove();
            return Err(Failure::invalid(
                "there is nothing to resume: all steps are done",
            ));
        }
        Ok((steps, within))
    }

    /// The error when the step to resume at is not known.
    fn doubtful(&self, mark: &Mark, span: Span) -> Failure {
        let message = match mark.ended {
            Some(_) => "it is not certain how far the last run came",
            None => {
                "nobody can tell how far the last run came: the arm was switched off, or others have used it"
            }
        };
        let failure = Failure::new(Kind::Driver(ErrorKind::Uncertain), message);
        failure.hint(self.in_doubt(span))
    }

    /// Waits until the arm has done what a run that died has left in its queue.
    async fn settled(&self, arm: &Arm) -> Result<(), Failure> {
        let (_, places) = arm.stats().await?;
        let wait = async {
            let mut before = None;
            let mut changed = Instant::now();
            loop {
                let left = arm.left_space().await?;
                let waiting = places.saturating_sub(left);
                let now = (arm.current_index().await?, arm.get::<Pose>().await?);
                if waiting == 0 && before == Some(now) {
                    return Ok(());
                }
                if before.replace(now) != Some(now) {
                    changed = Instant::now();
                }
                if changed.elapsed() > STANDING {
                    let message = format!(
                        "{waiting} commands of the last run wait in the arm's queue, and nothing moves"
                    );
                    return Err(Failure::invalid(message).hint(
                        "`magician alarms` shows what may hold it; `magician stop` drops them, then --resume goes on",
                    ));
                }
                sleep(LOOKS).await;
            }
        };
        attended(self.json, "waiting for what the arm still has", wait).await
    }

    fn say(&self, text: &str) {
        if !self.json {
            super::say(text);
        }
    }

    fn in_doubt(&self, Span { least, most }: Span) -> String {
        let which = match most.saturating_sub(least) {
            0 | 1 => format!("step {}", least + 1),
            _ => format!("steps {} to {most}", least + 1),
        };
        let start = self.with_start();
        format!(
            "{least} steps are done for certain, {which} may be: look at the work, then {start}--from {} does them again, \
         {start}--from {} leaves them out",
            least + 1,
            most + 1
        )
    }

    /// What has to be said besides, for a program that began where the tool stood.
    fn with_start(&self) -> String {
        match self.made.start {
            Some([x, y, z]) if self.made.program.depends_throughout() => {
                format!("--start {x:.3},{y:.3},{z:.3} ")
            }
            _ => String::new(),
        }
    }
}
