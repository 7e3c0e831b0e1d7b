//! The arm, what is known of it, and a pad, for programs that have all three.

use std::time::Instant;

use magician::commands::{
    DeviceName, DeviceWithL, EndEffectorGripper, EndEffectorSuctionCup, JogCommonParams, PoseL,
    PtpCommonParams,
};
use magician::{Arm, ErrorKind, Events, StateWatch};
use magician_job::Polled;
use ratatui::crossterm::event::{Event, KeyEvent};
use tokio::time::{Duration, timeout};

use super::pad::{Pad, Reply, Tone, Tools};
use super::wording;
use crate::context::{STAND_BY, not_confirmed, stop};
use crate::failure::{Failure, Kind};
use crate::saved::SavedSettings;
use crate::terminal::{Seen, Stage, Told, event_text, take_log};
use magician_job::jog::{Hands, Ratios};

/// Readings a second: as many as frames.
const RATE: f64 = 20.0;
/// Looks at the rail are so far apart.
const RAIL: Duration = Duration::from_millis(250);

/// What has happened.
#[derive(Debug)]
pub(crate) enum Happened {
    Key(KeyEvent),
    /// Text, which is no row of keys.
    Pasted(String),
    /// What was ordered is done; the pad knows.
    Done,
    /// The arm was read, or something else is new.
    News,
    Beat,
    /// The window lost the focus.
    Away,
    /// The terminal is gone.
    Gone,
}

/// How a program at the desk ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    Quit,
    /// Ctrl-C, or the terminal is gone.
    Interrupt,
}

pub(crate) struct Desk {
    pub(crate) arm: Arm,
    pub(crate) seen: Seen,
    pub(crate) pad: Pad,
    pub(crate) hands: Hands,
    saved: SavedSettings,
    state: StateWatch,
    events: Events,
    begun: Instant,
    /// The rail, if there is one.
    rail: Option<Polled<f32>>,
}

impl Desk {
    /// Reads what a pad has to know.
    pub(crate) async fn open(arm: &Arm, saved: &SavedSettings) -> Result<Self, Failure> {
        arm.check_dark().await?;
        let ratios = Ratios {
            jog: arm.get::<JogCommonParams>().await?,
            moves: arm.get::<PtpCommonParams>().await?,
        };
        let rail = known(arm.get::<DeviceWithL>().await)?.is_some_and(|rail| rail.with_l.is_on());
        let (_, places) = arm.stats().await?;
        let pad = Pad::new(ratios.jog.velocity_ratio, tools(arm).await?, rail);
        let rail = rail.then(|| rail_of(arm));
        Ok(Self {
            seen: Seen::new(title(arm).await?, places),
            pad,
            hands: Hands::new(arm, saved.clone(), ratios),
            saved: saved.clone(),
            state: arm.state(RATE)?,
            events: arm.events(),
            arm: arm.clone(),
            begun: Instant::now(),
            rail,
        })
    }

    /// Waits for what happens next.
    pub(crate) async fn next<M: Send + 'static>(
        &mut self,
        stage: &mut Stage<M>,
    ) -> Result<Happened, Failure> {
        let happened = tokio::select! {
            biased;
            told = stage.next() => match told {
                Told::Event(Event::Key(key)) => Happened::Key(key),
                Told::Event(Event::FocusLost) => Happened::Away,
                Told::Event(Event::Paste(text)) => Happened::Pasted(text),
                Told::Event(_) => Happened::News,
                Told::Beat => Happened::Beat,
                Told::Gone => Happened::Gone,
            },
            done = self.hands.next() => {
                self.pad.done(&done);
                if let Err(error) = &done.outcome {
                    self.seen.note(wording::failure(error).fact());
                }
                Happened::Done
            }
            status = self.state.changed() => {
                self.seen.arm.see(status?);
                Happened::News
            }
            Some(event) = self.events.next() => {
                self.seen.note(event_text(&event));
                Happened::News
            }
            Some(rail) = next_of(&mut self.rail) => {
                self.seen.arm.rail = Some(rail);
                Happened::News
            }
        };
        for line in take_log() {
            self.seen.note(line);
        }
        self.note_motion();
        self.seen.arm.look(Instant::now());
        Ok(happened)
    }

    /// Lets the pad know what moves the arm, and the readings that something does.
    fn note_motion(&mut self) {
        self.pad.doing = self.hands.doing();
        if self.pad.doing.is_some() {
            self.seen.arm.stir();
        }
    }

    /// Time since the beginning, as the pad counts it.
    pub(crate) fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    /// Does what a key came to.
    pub(crate) fn obey(&mut self, reply: Reply) -> Option<End> {
        match reply {
            Reply::Order(order) => {
                if let Some(done) = self.hands.order(order) {
                    self.pad.done(&done);
                }
                self.note_motion();
            }
            Reply::Quit => return Some(End::Quit),
            Reply::Interrupt => return Some(End::Interrupt),
            Reply::Unknown => self.pad.say(Tone::Plain, "? lists the keys"),
            Reply::Nothing => {}
        }
        None
    }

    /// What a pad does by itself with what happened: all but keys.
    pub(crate) fn attend(&mut self, happened: &Happened) -> Option<End> {
        match happened {
            Happened::Beat => {
                let reply = self.pad.beat(self.now());
                self.obey(reply)
            }
            Happened::Away => {
                let reply = self.pad.let_go();
                self.obey(reply)
            }
            Happened::Gone => Some(End::Interrupt),
            _ => None,
        }
    }

    /// Leaves the arm standing, its laser dark, and its settings as they were.
    pub(crate) async fn leave(self, end: End) -> Result<(), Failure> {
        match end {
            End::Quit => {
                let lit = self.pad.may_burn();
                self.hands.finish().await?;
                match lit {
                    true => Ok(self.arm.darken().await?),
                    false => Ok(()),
                }
            }
            End::Interrupt => {
                drop(self.hands);
                let stopped = timeout(STAND_BY, stop(&self.arm, &self.saved)).await;
                let message = match stopped {
                    Ok(Ok(message) | Err(message)) => message,
                    Err(_) => not_confirmed("it took too long"),
                };
                Err(Failure::new(Kind::Interrupted, message))
            }
        }
    }
}

/// Where the carriage is, again and again.
pub(crate) fn rail_of(arm: &Arm) -> Polled<f32> {
    let arm = arm.clone();
    Polled::every(RAIL, move || {
        let arm = arm.clone();
        // What cannot be read now is read the next time.
        async move { arm.get::<PoseL>().await.ok().map(|at| at.pose_l) }
    })
}

/// The next reading, if anything is read at all.
pub(crate) async fn next_of<T: Clone + Send + Sync + 'static>(
    polled: &mut Option<Polled<T>>,
) -> Option<T> {
    match polled {
        Some(polled) => Some(polled.next().await),
        None => None,
    }
}

/// Nothing where an arm has no such thing.
fn known<T>(answer: magician::Result<T>) -> Result<Option<T>, Failure> {
    match answer {
        Ok(answer) => Ok(Some(answer)),
        Err(error)
            if matches!(
                error.kind(),
                ErrorKind::Timeout | ErrorKind::Unsupported | ErrorKind::Unexpected
            ) =>
        {
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}

/// What the tools do.
pub(crate) async fn tools(arm: &Arm) -> Result<Tools, Failure> {
    let suction = known(arm.get::<EndEffectorSuctionCup>().await)?;
    let gripper = known(arm.get::<EndEffectorGripper>().await)?;
    Ok(Tools {
        suction: suction.is_some_and(|cup| cup.is_ctrl_enabled.is_on() && cup.is_sucked.is_on()),
        grips: gripper
            .filter(|gripper| gripper.is_ctrl_enabled.is_on())
            .map(|gripper| gripper.is_gripped.is_on()),
        laser: arm.laser().await? == Some(true),
    })
}

/// What the arm is called, and where it is.
pub(crate) async fn title(arm: &Arm) -> Result<String, Failure> {
    let name = known(arm.get::<DeviceName>().await)?.map(|name| name.device_name.to_string());
    let name = name.unwrap_or_default();
    Ok(match name.is_empty() {
        true => arm.name().to_owned(),
        false => format!("{} | {name}", arm.name()),
    })
}
