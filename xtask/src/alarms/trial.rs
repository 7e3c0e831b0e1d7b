//! Holds the virtual arm to what is claimed of an alarm.

use magician_protocol::commands::{ClearAlarmsState, HomeCmd, QueuedCmdStartExec, WaitCmd};
use magician_protocol::{Ctrl, FrameBuf, PtpMode, Set};
use magician_sim::world::ExternalEvent;
use magician_sim::{Controller, LinkId, Micros};

use super::table::{Act, Arises, Claim, Goes, ptp};

const USB: LinkId = LinkId(0);
const SECOND: Micros = 1_000_000;
/// The longest that anything here lasts.
const LONGEST: Micros = 120 * SECOND;

/// What was found instead of what was claimed.
pub(super) type Verdict = Result<(), String>;

/// An arm whose queue runs and whose alarms are cleared.
struct Trial(Controller);

impl Trial {
    fn new() -> Self {
        let mut trial = Self(Controller::default());
        trial.clear();
        trial.start();
        trial
    }

    fn send(&mut self, set: &Set, ctrl: Ctrl) {
        let frame = FrameBuf::set(set, ctrl).expect("what the table holds fits a frame");
        self.bytes(frame.bytes());
    }

    fn bytes(&mut self, bytes: &[u8]) {
        self.0.receive(USB, bytes);
        while self.0.poll_transmit(USB).is_some() {}
    }

    fn clear(&mut self) {
        self.send(&Set::ClearAlarmsState(ClearAlarmsState {}), Ctrl::SET);
    }

    fn start(&mut self) {
        self.send(&Set::QueuedCmdStartExec(QueuedCmdStartExec {}), Ctrl::SET);
    }

    fn pass(&mut self, span: Micros) {
        self.0.advance(self.0.now() + span);
    }

    fn rest(&mut self) {
        let end = self.0.now() + LONGEST;
        while let Some(at) = self.0.poll_timeout().filter(|at| *at <= end) {
            self.0.advance(at);
        }
    }

    fn act(&mut self, act: &Act) {
        match act {
            Act::Now(set) => self.send(set, Ctrl::SET),
            Act::Queue(set) => self.send(set, Ctrl::QUEUED),
            Act::Bytes(bytes) => self.bytes(bytes),
            Act::Happen(happening) => self.0.inject(*happening),
            Act::Pass => self.pass(SECOND / 2),
            Act::Rest => self.rest(),
        }
    }

    fn acts(&mut self, acts: &[Act]) {
        acts.iter().for_each(|act| self.act(act));
    }

    fn alarms(&self) -> Vec<u8> {
        self.0.state().alarms.codes().collect()
    }

    fn stand(&self, codes: &[u8], when: &str) -> Verdict {
        let found = self.alarms();
        if found == codes {
            return Ok(());
        }
        Err(format!("{when} {found:#04x?} stand, not {codes:#04x?}"))
    }

    /// Whether a command queued now is carried out in time.
    fn runs(&mut self) -> bool {
        self.start();
        let wait = Set::WaitCmd(WaitCmd { timeout: 0 });
        self.send(&wait, Ctrl::QUEUED);
        self.pass(SECOND);
        self.idle()
    }

    fn idle(&self) -> bool {
        let queue = self.0.state().queue;
        queue.waiting == 0 && queue.running.is_none()
    }

    fn holds(&mut self, wanted: bool) -> Verdict {
        expect(self.runs() != wanted, "the queue does not wait as claimed")
    }

    fn freed(&mut self) -> Verdict {
        self.clear();
        self.stand(&[], "after a clear")?;
        self.rest();
        expect(self.idle(), "the queue does not go on after a clear")
    }
}

fn expect(good: bool, otherwise: &str) -> Verdict {
    if good {
        Ok(())
    } else {
        Err(otherwise.to_owned())
    }
}

/// Everything that is claimed of an alarm.
pub(super) fn try_claim(claim: &Claim) -> Verdict {
    match &claim.arises {
        Arises::When { acts, .. } => arises(claim, acts)?,
        Arises::Injected(_) => {}
        Arises::Never { tried, .. } => tried.iter().try_for_each(|acts| never(claim.code, acts))?,
    }
    try_injected(claim.code, claim.holds)
}

/// Everything that is said of an alarm that is injected.
pub(super) fn try_injected(code: u8, holds: bool) -> Verdict {
    injected(code, holds)?;
    while_moving(code, holds)?;
    at_once(code)?;
    homing(code)?;
    reset(code)
}

fn arises(claim: &Claim, acts: &[Act]) -> Verdict {
    let code = claim.code;
    let mut trial = Trial::new();
    trial.acts(acts);
    trial.stand(&[code], "after what raises it")?;
    trial.holds(claim.holds)?;
    trial.pass(60 * SECOND);
    trial.stand(&[code], "a minute later")?;
    match &claim.goes {
        Goes::Cleared => trial.freed(),
        Goes::Inside { back, .. } => {
            trial.clear();
            trial.stand(&[code], "after a clear at the limit")?;
            expect(!trial.idle(), "a clear at the limit frees the queue")?;
            trial.acts(back);
            trial.stand(&[], "back inside")?;
            expect(!trial.idle(), "the queue goes on without a clear")?;
            trial.freed()
        }
        Goes::UntilHomed { look } => {
            trial.freed()?;
            trial.acts(look);
            trial.stand(&[code], "after another look")?;
            trial.freed()?;
            trial.send(&Set::HomeCmd(HomeCmd { reserved: 0 }), Ctrl::SET);
            trial.rest();
            trial.acts(look);
            trial.stand(&[], "after homing and another look")
        }
    }
}

/// What comes nearest to causing it does not.
fn never(code: u8, acts: &[Act]) -> Verdict {
    let mut trial = Trial::new();
    trial.acts(acts);
    expect(!trial.alarms().contains(&code), "it arises after all")
}

/// At rest: the cause does not stand, so the first clear is enough, for a limit too.
fn injected(code: u8, holds: bool) -> Verdict {
    let mut trial = Trial::new();
    trial.0.inject(ExternalEvent::Alarm(code));
    trial.stand(&[code], "injected,")?;
    trial.holds(holds)?;
    trial.pass(60 * SECOND);
    trial.stand(&[code], "injected, a minute later")?;
    trial.freed()
}

/// A motion under way goes on to its end.
fn while_moving(code: u8, holds: bool) -> Verdict {
    let mut trial = Trial::new();
    for j1 in [30.0, 60.0] {
        let goal = ptp(PtpMode::MovjAngle, [j1, 45.0, 45.0, 0.0]);
        trial.send(&goal, Ctrl::QUEUED);
    }
    trial.pass(SECOND / 10);
    trial.0.inject(ExternalEvent::Alarm(code));
    trial.rest();
    let j1 = if holds { 30.0 } else { 60.0 };
    expect(
        trial.0.state().joints.j1 == j1,
        "a motion under way does not end as claimed",
    )?;
    trial.freed()
}

/// Immediate commands are carried out.
fn at_once(code: u8) -> Verdict {
    let mut trial = Trial::new();
    trial.0.inject(ExternalEvent::Alarm(code));
    let goal = ptp(PtpMode::MovjAngle, [30.0, 45.0, 45.0, 0.0]);
    trial.send(&goal, Ctrl::SET);
    trial.rest();
    let there = trial.0.state().joints.j1 == 30.0;
    expect(there, "an immediate move is not carried out")
}

/// Homing runs all the same, and frees nothing.
fn homing(code: u8) -> Verdict {
    let mut trial = Trial::new();
    trial.0.inject(ExternalEvent::Alarm(code));
    trial.send(&Set::HomeCmd(HomeCmd { reserved: 0 }), Ctrl::QUEUED);
    trial.rest();
    expect(trial.0.state().homed, "homing does not run")?;
    trial.holds(code > 7)
}

/// A reset leaves none but its own.
fn reset(code: u8) -> Verdict {
    let mut trial = Trial::new();
    trial.0.inject(ExternalEvent::Alarm(code));
    trial.0.inject(ExternalEvent::Reset);
    trial.stand(&[0x00], "after a reset")?;
    trial.holds(false)
}
