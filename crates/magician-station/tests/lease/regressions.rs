//! Faults that the search has found in control, as single tests.

use std::time::Duration;

use magician_protocol::HostInstant;
use magician_station::control::{
    ASK_TIMEOUT, ArmId, Control, Effect, JobId, JobPhase, LEASE_TIMEOUT, LeaseLossPolicy,
    RequestId, SessionId, WorkKind,
};

const ANNA: SessionId = SessionId(1);
const BEN: SessionId = SessionId(2);
const CARL: SessionId = SessionId(3);
const ARM: ArmId = ArmId(0);
const OTHER: ArmId = ArmId(1);
const START: HostInstant = HostInstant::from_micros(1_000_000);

/// Returns control with three sessions and two arms; Anna holds the first by request 1.
fn control() -> Control {
    let mut control = Control::new(2);
    for session in [ANNA, BEN, CARL] {
        control.join(START, session);
    }
    control.acquire(START, ANNA, ARM, RequestId(1), Duration::ZERO);
    control
}

fn effects(control: &mut Control) -> Vec<Effect> {
    std::iter::from_fn(|| control.poll_effect()).collect()
}

#[test]
fn motion_counts_as_keep_alive_until_its_stop() {
    let mut control = control();
    { control.begin(START, ANNA, ARM, RequestId(2), WorkKind::Motion) }.unwrap();
    let later = START + 2 * LEASE_TIMEOUT;
    control.handle_timeout(later);
    assert_eq!(control.stop(later, ARM), [RequestId(2)]);
    control.handle_timeout(later);
    assert_eq!(control.holder(ARM), Some(ANNA));
}

#[test]
fn request_at_one_arm_keeps_the_lease_of_another() {
    let mut control = control();
    control.acquire(START, ANNA, OTHER, RequestId(2), Duration::ZERO);
    { control.begin(START, ANNA, ARM, RequestId(3), WorkKind::Motion) }.unwrap();
    control.handle_timeout(START + 2 * LEASE_TIMEOUT);
    assert_eq!(control.holder(OTHER), Some(ANNA));
}

#[test]
fn timeout_of_a_waiter_updates_the_places_behind_it() {
    let mut control = control();
    let (short, long) = (Duration::from_secs(1), Duration::from_secs(60));
    control.acquire(START, BEN, ARM, RequestId(2), short);
    control.acquire(START, CARL, ARM, RequestId(3), long);
    effects(&mut control);
    control.handle_timeout(START + short);
    let (session, arm, place) = (CARL, ARM, 1);
    assert_eq!(
        effects(&mut control).last(),
        Some(&Effect::Place {
            session,
            arm,
            place
        })
    );
}

#[test]
fn pending_question_passes_to_the_next_holder_with_full_time() {
    let mut control = control();
    control.ask(START, CARL, ARM, RequestId(2));
    effects(&mut control);
    let later = START + ASK_TIMEOUT - Duration::from_secs(1);
    control.keep_alive(later, ANNA);
    control.take(later, BEN, ARM, RequestId(3));
    let asked = Effect::Asked {
        arm: ARM,
        holder: BEN,
        session: CARL,
        request: RequestId(2),
    };
    assert!(effects(&mut control).contains(&asked));
    for second in 0..20 {
        let now = later + Duration::from_secs(second);
        control.handle_timeout(now);
        control.keep_alive(now, BEN);
    }
    assert_eq!(control.holder(ARM), Some(BEN));
    control.handle_timeout(later + ASK_TIMEOUT);
    assert_eq!(control.holder(ARM), Some(CARL));
}

#[test]
fn continuing_job_is_not_stopped_for_queued_or_steering_requests() {
    let mut control = control();
    { control.begin(START, ANNA, ARM, RequestId(2), WorkKind::Queued) }.unwrap();
    control.finish(START, ARM, RequestId(2));
    { control.begin(START, ANNA, ARM, RequestId(3), WorkKind::StartJob) }.unwrap();
    let active = Some(JobPhase::Active);
    control.set_job_phase(START, ARM, JobId(1), LeaseLossPolicy::Continue, active);
    { control.begin(START, ANNA, ARM, RequestId(4), WorkKind::JobSetting) }.unwrap();
    effects(&mut control);
    control.take(START, BEN, ARM, RequestId(5));
    let ended = effects(&mut control);
    let ended = ended.iter().find_map(|effect| match effect {
        Effect::EndWork { requests, stop, .. } => Some((requests.clone(), *stop)),
        _ => None,
    });
    assert_eq!(ended, Some((vec![RequestId(3), RequestId(4)], false)));
}

#[test]
fn released_work_continues_after_a_later_lease_ends() {
    let mut control = control();
    { control.begin(START, ANNA, ARM, RequestId(2), WorkKind::Motion) }.unwrap();
    let Some(Effect::Granted { lease, .. }) = control.poll_effect() else {
        panic!("it was granted");
    };
    control.release(START, ANNA, lease);
    control.acquire(START, BEN, ARM, RequestId(3), Duration::ZERO);
    control.take(START, CARL, ARM, RequestId(4));
    let ended = effects(&mut control);
    let stopped = |effect: &Effect| matches!(effect, Effect::EndWork { .. });
    assert!(!ended.iter().any(stopped), "{ended:?}");
    assert!(control.finish(START, ARM, RequestId(2)), "it is under way");
}
