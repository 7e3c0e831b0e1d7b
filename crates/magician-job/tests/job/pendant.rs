//! A person moves a virtual arm by a pendant, in virtual time: a released jog stops, and one
//! activity moves the arm at a time.

use std::time::Duration;

use magician::commands::{EndEffectorLaser, JogCommonParams, PtpCommonParams};
use magician::sim::Controller;
use magician::{Arm, Options, SimSpeed, VirtualArm};
use magician_job::SavedSettings;
use magician_job::jog::{
    Activity, Axis, JogDirection, JogMode, OrderDone, OrderError, Pendant, PendantEvent,
    PendantOrder, PendantSession, ToolOrder,
};
use magician_job::teach::TeachEditor;
use magician_program::{Action, Origin, Plan, Travel};
use tokio::time::{Instant, sleep, timeout};

const RIGHT: JogDirection = JogDirection {
    axis: Axis::Y,
    forward: false,
};
const LEFT: JogDirection = JogDirection {
    axis: Axis::Y,
    forward: true,
};

fn ms(time: u64) -> Duration {
    Duration::from_millis(time)
}

/// An arm at normal speed with a person at its pendant.
struct Bench {
    cell: VirtualArm,
    arm: Arm,
    session: PendantSession,
    pendant: Pendant,
    begun: Instant,
}

impl Bench {
    async fn new() -> Self {
        let cell = VirtualArm::new(Controller::default(), SimSpeed::Times(1.0));
        let arm = Arm::simulated(cell.clone(), Options::default())
            .await
            .expect("a line");
        let saved = SavedSettings::default();
        let (session, mut pendant) = PendantSession::open(&arm, &saved).await.expect("read");
        pendant.hold.set_reports_releases(true);
        Self {
            cell,
            arm,
            session,
            pendant,
            begun: Instant::now(),
        }
    }

    fn y(&self) -> f64 {
        self.cell.state().pose.y
    }

    fn order(&mut self, order: PendantOrder) -> Option<OrderDone> {
        let refused = self.session.order(order);
        if let Some(done) = &refused {
            self.pendant.done(done);
        }
        self.pendant.activity = self.session.activity();
        refused
    }

    /// Lets time pass; returns the orders done by then.
    async fn wait(&mut self, time: Duration) -> Vec<OrderDone> {
        let until = Instant::now() + time;
        let mut all = Vec::new();
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let Ok(event) = timeout(left, self.session.next()).await else {
                return all;
            };
            if let PendantEvent::Done(done) = event.expect("a line") {
                self.pendant.done(&done);
                all.push(done);
            }
            self.pendant.activity = self.session.activity();
        }
    }

    /// Holds the control for a while, with a tick every 50 ms.
    async fn hold(&mut self, time: Duration) {
        let until = Instant::now() + time;
        while Instant::now() < until {
            if let Some(order) = self.pendant.tick(self.begun.elapsed()) {
                assert!(self.order(order).is_none());
            }
            self.wait(ms(50)).await;
        }
    }

    async fn press(&mut self, direction: JogDirection) {
        let order = self.pendant.press(direction, self.begun.elapsed());
        let refused = self.order(order.expect("an order"));
        assert!(refused.is_none(), "{refused:?}");
    }

    /// True if the arm stands.
    async fn stands(&self) -> bool {
        let before = self.cell.state().pose;
        sleep(ms(500)).await;
        self.cell.state().pose == before
    }
}

async fn jogging() -> Bench {
    let mut place = Bench::new().await;
    place.pendant.set_mode(JogMode::Hold);
    place.press(LEFT).await;
    place.hold(ms(1000)).await;
    assert_eq!(place.session.activity(), Some(Activity::Jog(LEFT)));
    assert!(place.y() > 5.0, "{}", place.y());
    place
}

fn plan() -> Box<Plan> {
    let mut plan = Plan::new("to and fro");
    for y in [60.0, -60.0, 0.0] {
        let (to, by) = ([220.0, y, 20.0, 0.0], Travel::Line);
        plan.push(Action::Move { to, by }, Origin::NONE);
    }
    Box::new(plan)
}

#[tokio::test(start_paused = true)]
async fn jog_stops_without_keep_alive() {
    let mut place = jogging().await;
    let before = place.y();
    // The pendant's program hangs: the session is polled, the control is not.
    place.wait(ms(2000)).await;
    assert!(place.stands().await);
    // Far less than 2 s of motion: 0.3 s, and braking.
    let moved = place.y() - before;
    assert!(moved < before, "{moved} after {before}");
    // The late keep-alive reports that the jog is over, which is not a failure.
    let order = place.pendant.tick(place.begun.elapsed());
    let done = place.order(order.expect("held as far as it knows"));
    let done = done.expect("it ended");
    assert_eq!(done.activity, Activity::Jog(LEFT));
    assert!(done.outcome.is_ok());
    assert_eq!(place.session.activity(), None);
}

#[tokio::test(start_paused = true)]
async fn jog_stops_if_the_session_is_not_polled() {
    let place = jogging().await;
    let before = place.y();
    sleep(ms(2000)).await;
    assert!(place.stands().await);
    assert!(place.y() - before < before);
}

#[tokio::test(start_paused = true)]
async fn release_ends_the_jog() {
    let mut place = jogging().await;
    let order = place.pendant.release(Some(LEFT));
    assert!(place.order(order.expect("held")).is_none());
    place.wait(ms(500)).await;
    assert!(place.stands().await);
    assert_eq!(place.session.activity(), None);
    // The next order is accepted.
    place.pendant.set_mode(JogMode::Step);
    let before = place.y();
    place.press(RIGHT).await;
    place.wait(ms(2000)).await;
    assert!((before - place.y() - 5.0).abs() < 0.01);
}

#[tokio::test(start_paused = true)]
async fn dropped_session_stops_the_arm() {
    // Another handle keeps the connection open.
    let place = jogging().await;
    let Bench {
        cell, arm, session, ..
    } = place;
    let before = cell.state().pose.y;
    drop(session);
    sleep(ms(1000)).await;
    let stopped = cell.state().pose;
    assert!(stopped.y - before < before);
    sleep(ms(1000)).await;
    assert_eq!(cell.state().pose, stopped);
    drop(arm);

    let from = 0;
    let run = PendantOrder::Run { plan: plan(), from };
    let step = PendantOrder::Step {
        direction: LEFT,
        length: 100.0,
        burning: false,
    };
    for order in [step, run] {
        let mut place = Bench::new().await;
        let name = format!("{order:?}");
        assert!(place.order(order).is_none());
        place.wait(ms(400)).await;
        assert!(place.session.activity().is_some(), "{name}");
        let Bench {
            cell, arm, session, ..
        } = place;
        drop(session);
        sleep(ms(1000)).await;
        let stopped = cell.state().pose;
        assert!(stopped.y < 55.0, "{name}: {stopped:?}");
        sleep(ms(2000)).await;
        assert_eq!(cell.state().pose, stopped, "{name}");
        assert!(!arm.moving(), "{name}");
    }
}

#[tokio::test(start_paused = true)]
async fn second_activity_is_refused_as_busy() {
    let mut place = jogging().await;
    let from = 0;
    let step = PendantOrder::Step {
        direction: RIGHT,
        length: 1.0,
        burning: false,
    };
    let run = PendantOrder::Run { plan: plan(), from };
    for order in [step.clone(), PendantOrder::Home, run] {
        let done = place.order(order).expect("refused");
        assert!(matches!(done.outcome, Err(OrderError::Busy)), "{done:?}");
        assert_eq!(place.session.activity(), Some(Activity::Jog(LEFT)));
    }
    // Tools and speeds are handled in order meanwhile, and the jog continues.
    let suction = ToolOrder::Suction(true);
    assert!(place.order(PendantOrder::Tool(suction)).is_none());
    assert!(place.order(PendantOrder::Speed(20.0)).is_none());
    let before = place.y();
    place.hold(ms(500)).await;
    assert!(place.y() > before);
    assert!(place.pendant.tools.suction);
    assert_eq!(place.pendant.speed, 20.0);
    // Another direction replaces the jog.
    place.press(RIGHT).await;
    place.hold(ms(300)).await;
    assert_eq!(place.session.activity(), Some(Activity::Jog(RIGHT)));
    let before = place.y();
    place.hold(ms(500)).await;
    assert!(place.y() < before);
    // A stop ends the jog, and the next order is accepted.
    let stop = place.pendant.stop();
    assert!(place.order(stop).is_none());
    assert_eq!(place.session.activity(), Some(Activity::Stop));
    let done = place.wait(ms(1000)).await;
    assert!(done.iter().any(|done| done.activity == Activity::Stop));
    assert!(place.stands().await);
    assert_eq!(place.session.activity(), None);
    assert!(place.order(step).is_none());
    let done = place.wait(ms(2000)).await;
    let done = done.last().expect("a step");
    assert!(done.activity == Activity::Step(RIGHT) && done.outcome.is_ok());
}

/// An arm that is being stopped.
async fn stopping() -> Bench {
    let mut place = jogging().await;
    let stop = place.pendant.stop();
    assert!(place.order(stop).is_none());
    assert_eq!(place.session.activity(), Some(Activity::Stop));
    place
}

#[tokio::test(start_paused = true)]
async fn control_held_during_a_stop_jogs_after_it() {
    let mut place = stopping().await;
    // The newest order wins.
    place.press(LEFT).await;
    place.press(RIGHT).await;
    assert_eq!(place.session.activity(), Some(Activity::Stop));
    place.hold(ms(1000)).await;
    assert_eq!(place.session.activity(), Some(Activity::Jog(RIGHT)));
    let before = place.y();
    place.hold(ms(300)).await;
    assert!(place.y() < before);
    let order = place.pendant.release(Some(RIGHT));
    place.order(order.expect("held"));
    place.wait(ms(500)).await;
    assert!(place.stands().await);
    // A step is done once.
    let mut place = stopping().await;
    place.pendant.set_mode(JogMode::Step);
    place.press(LEFT).await;
    place.press(LEFT).await;
    let (mut stood, mut done) = (f64::NAN, Vec::new());
    while !matches!(done.last(), Some(Activity::Step(_))) {
        for one in place.wait(ms(10)).await {
            assert!(one.outcome.is_ok(), "{one:?}");
            if one.activity == Activity::Stop {
                stood = place.y();
            }
            done.push(one.activity);
        }
    }
    assert_eq!(done, [Activity::Stop, Activity::Step(LEFT)]);
    assert!((place.y() - stood - 5.0).abs() < 0.01, "{stood}");
    assert!(place.stands().await);
}

#[tokio::test(start_paused = true)]
async fn control_released_during_a_stop_moves_nothing() {
    for (mode, hangs) in [
        (JogMode::Hold, false),
        (JogMode::Hold, true),
        (JogMode::Step, false),
    ] {
        let mut place = stopping().await;
        place.pendant.set_mode(mode);
        place.press(LEFT).await;
        if hangs {
            // The pendant's program hangs, and the session is not polled either.
            sleep(ms(1000)).await;
        } else {
            let order = place.pendant.release(Some(LEFT));
            assert!(place.order(order.expect("it waits")).is_none());
        }
        let done = place.wait(ms(1000)).await;
        let done: Vec<_> = done.iter().map(|done| done.activity).collect();
        assert_eq!(done, [Activity::Stop], "{mode:?}");
        assert_eq!(place.session.activity(), None);
        assert!(place.stands().await);
    }
    // Another stop drops the waiting order too.
    let mut place = stopping().await;
    place.press(LEFT).await;
    let stop = place.pendant.stop();
    place.order(stop);
    place.wait(ms(1000)).await;
    assert_eq!(place.session.activity(), None);
    assert!(place.stands().await);
}

#[tokio::test(start_paused = true)]
async fn unreachable_step_is_refused_and_moves_nothing() {
    let mut place = Bench::new().await;
    let before = place.cell.state().pose;
    let far = PendantOrder::Step {
        direction: LEFT,
        length: 900.0,
        burning: false,
    };
    assert!(place.order(far).is_none());
    let done = place.wait(ms(500)).await;
    let Some(Err(OrderError::Arm(error))) = done.into_iter().map(|done| done.outcome).next() else {
        panic!("not refused");
    };
    assert!(error.limit().is_some(), "{error}");
    assert_eq!(place.cell.state().pose, before);
}

#[tokio::test(start_paused = true)]
async fn session_reports_the_current_step_of_a_program() {
    let mut place = Bench::new().await;
    let from = 1;
    assert!(
        place
            .order(PendantOrder::Run { plan: plan(), from })
            .is_none()
    );
    let mut steps = Vec::new();
    loop {
        let done = place.wait(ms(50)).await;
        if let Some(done) = done.into_iter().next() {
            assert!(done.activity == Activity::Run && done.outcome.is_ok());
            break;
        }
        steps.extend(place.session.step());
    }
    steps.dedup();
    assert!(steps.contains(&1) && steps.contains(&2), "{steps:?}");
}

#[tokio::test(start_paused = true)]
async fn closing_the_session_restores_the_settings() {
    let mut place = Bench::new().await;
    let read = async |arm: &Arm| {
        let jog = arm.get::<JogCommonParams>().await.expect("read");
        (jog, arm.get::<PtpCommonParams>().await.expect("read"))
    };
    let before = read(&place.arm).await;
    assert!(place.order(PendantOrder::Speed(5.0)).is_none());
    let laser = place.pendant.laser(true);
    assert!(place.order(laser).is_none());
    place.wait(ms(500)).await;
    assert!(place.pendant.tools.laser && read(&place.arm).await != before);
    let Bench {
        arm,
        session,
        pendant,
        ..
    } = place;
    session.close(&pendant).await.expect("closed");
    assert_eq!(read(&arm).await, before);
    let laser = arm.get::<EndEffectorLaser>().await.expect("read");
    assert!(!laser.is_on.is_on());
}

/// A server may keep sessions and models in any task.
#[tokio::test]
async fn sessions_and_models_are_send() {
    fn is<T: Send + 'static>() {}
    fn sent<T: Send>(value: T) -> T {
        value
    }
    is::<PendantSession>();
    is::<Pendant>();
    is::<TeachEditor>();
    is::<PendantEvent>();
    let arm = Arm::connect("sim").await.expect("an arm");
    let open = sent(PendantSession::open(&arm, &SavedSettings::default())).await;
    let (mut session, pendant) = open.expect("read");
    sent(session.next()).await.expect("an event");
    sent(session.close(&pendant)).await.expect("closed");
}
