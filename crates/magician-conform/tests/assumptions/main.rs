//! Every assumption of the virtual arm is proved by cases: each case that names one fails on an arm
//! that violates it, is counted by an arm that satisfies it, and is refused by a strict arm if the
//! assumption is a mere choice.
//!
//! For an assumption without a case, the error lists the candidates: the cases that fail without
//! it.

mod arm;
mod violations;

use std::collections::BTreeSet;
use std::time::Duration;

use arm::{ViolatingArm, Violation};
use magician_conform::{Begin, Case, Outcome, Runner, SimTarget, Suite, Target};
use magician_sim::fidelity::{Assumption, Fidelity, Strictness};
use magician_sim::{Event, Profile, Refusal};
use violations::{mistakes, violation};

/// Returns the outcome of each case on this arm, with a look at the arm after it.
fn run<'c, T: Target, S>(
    target: T,
    cases: impl IntoIterator<Item = &'c Case>,
    mut look: impl FnMut(&mut T) -> S,
) -> Vec<(&'c Case, Outcome, S)> {
    let mut runner = Runner::new(target, Duration::from_secs(1)).expect("the beginnings are read");
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    runtime.expect("a runtime").block_on(async {
        let mut outcomes = Vec::new();
        for case in cases {
            let outcome = runner.run(case).await.expect("no line to lose");
            outcomes.push((case, outcome, look(runner.target())));
        }
        outcomes
    })
}

fn suite() -> Suite {
    Suite::built_in().unwrap_or_else(|error| panic!("{error}"))
}

/// Assumptions that nothing outside of the arm can observe.
const UNSEEN: &[(Assumption, &str)] = &[];

/// Returns the cases that fail if an assumption is violated, which could name it. Most cases of a
/// common one only need it on their way.
fn failing_without(assumption: Assumption, suite: &Suite) -> Vec<String> {
    let arm = ViolatingArm::new(move || violation(assumption));
    let outcomes = run(arm, suite.cases(), |_| ()).into_iter();
    outcomes
        .filter(|(_, outcome, ())| matches!(outcome, Outcome::Failed(_)))
        .map(|(case, ..)| case.id.clone())
        .collect()
}

#[test]
fn every_assumption_that_can_be_seen_is_held_by_a_case() {
    let suite = suite();
    let held: BTreeSet<_> = suite
        .cases()
        .iter()
        .flat_map(|case| case.assumes.clone())
        .collect();
    let unseen: BTreeSet<_> = UNSEEN.iter().map(|(assumption, _)| *assumption).collect();
    let missing: Vec<_> = (Assumption::ALL.iter())
        .filter(|assumption| !held.contains(assumption) && !unseen.contains(assumption))
        .map(|assumption| (assumption, failing_without(*assumption, &suite)))
        .collect();
    assert!(
        missing.is_empty(),
        "no case names them; these would fail without: {missing:#?}"
    );
    let both: Vec<_> = held.intersection(&unseen).collect();
    assert!(both.is_empty(), "held after all: {both:?}");
}

#[test]
fn a_case_fails_where_one_of_its_assumptions_is_violated() {
    let suite = suite();
    let mut passed = Vec::new();
    for assumption in Assumption::ALL {
        let named = suite
            .cases()
            .iter()
            .filter(|case| case.assumes.contains(assumption));
        for (case, outcome, ()) in run(
            ViolatingArm::new(move || violation(*assumption)),
            named,
            |_| (),
        ) {
            if !matches!(outcome, Outcome::Failed(_)) {
                passed.push(format!("{} passes without {assumption:?}", case.id));
            }
        }
    }
    assert!(passed.is_empty(), "{passed:#?}");
}

/// Mistakes of an arm that concern no assumption, and a case that finds each.
#[allow(clippy::type_complexity)]
const MISTAKES: &[(fn() -> Violation, &str)] = &[
    (mistakes::one_link, "framing.peers-get-their-own-answers"),
    (mistakes::one_link, "framing.peers-do-not-mix-their-frames"),
    (mistakes::never_times_out, "framing.long-gap-in-a-frame"),
    (mistakes::drops_split_frames, "framing.short-gap-in-a-frame"),
    (mistakes::applies_at_receipt, "queue.turn-of-*"),
    (
        mistakes::applies_at_receipt,
        "queue.parameters-between-moves",
    ),
    (mistakes::weak_joints, "*.joint-ceilings"),
    (mistakes::one_ratio_for_both, "*.ratios-apart-*"),
    (mistakes::lifts_first, "ptp.jump-corner-out-of-reach-*"),
];

#[test]
fn mistakes_are_found() {
    let suite = suite();
    for (mistake, pattern) in MISTAKES {
        let cases = suite.select(&[(*pattern).to_owned()], &[]);
        assert!(!cases.is_empty(), "{pattern}");
        for (case, outcome, ()) in run(ViolatingArm::new(*mistake), cases, |_| ()) {
            assert!(matches!(outcome, Outcome::Failed(_)), "{} passes", case.id);
        }
    }
}

/// Returns the assumptions that an arm used in each case, and the choices it refused.
fn counted<'c>(
    strict: bool,
    cases: &[&'c Case],
) -> Vec<(&'c Case, Outcome, Fidelity, Vec<Assumption>)> {
    let mut profile = Profile::default();
    profile.fidelity.strict = strict;
    let refused = |event| match event {
        Event::Refused {
            reason: Refusal::OnlyAChoice(assumption),
            ..
        } => Some(assumption),
        _ => None,
    };
    let outcomes = run(SimTarget::new(profile), cases.iter().copied(), |target| {
        let arm = target.arm();
        let events = std::iter::from_fn(|| arm.poll_event());
        let refusals: Vec<_> = events.filter_map(refused).collect();
        (arm.fidelity().clone(), refusals)
    });
    let flat = |(case, outcome, (fidelity, refusals))| (case, outcome, fidelity, refusals);
    outcomes.into_iter().map(flat).collect()
}

/// Returns the assumptions used before a case begins: none at power-up.
fn before() -> impl Fn(&Case) -> Fidelity {
    let text = |id: &str, moves: bool| {
        format!(
            "[[case]]\nid = \"idle.{id}\"\ntitle = \"t\"\nsource = \"s\"\nconfidence = \"G\"\nmoves = {moves}\n\
             steps = \"\"\"\nsilence\n\"\"\"\n"
        )
    };
    let mut idle = Suite::default();
    for (id, moves) in [("still", false), ("moves", true)] {
        idle.read("idle", &text(id, moves)).expect("a case");
    }
    let cases: Vec<_> = idle.cases().iter().collect();
    let counts: Vec<Fidelity> = counted(false, &cases)
        .into_iter()
        .map(|found| found.2)
        .collect();
    move |case| match case.begin {
        Begin::PowerUp => Fidelity::default(),
        Begin::Ready => counts[usize::from(case.moves)].clone(),
    }
}

#[test]
fn what_a_case_assumes_is_counted() {
    let (suite, before) = (suite(), before());
    let cases: Vec<_> = suite.cases().iter().collect();
    let mut uncounted = Vec::new();
    for (case, _, fidelity, refusals) in counted(false, &cases) {
        assert_eq!(refusals, [], "{}: not strict", case.id);
        let before = before(case);
        for assumption in &case.assumes {
            if fidelity.uses(*assumption) <= before.uses(*assumption) {
                uncounted.push(format!("{} does not use {assumption:?}", case.id));
            }
        }
    }
    assert!(uncounted.is_empty(), "{uncounted:#?}");
}

/// Facts and kept choices work as usual; every other choice is refused, for its own reason.
#[test]
fn a_strict_arm_refuses_the_choices_and_nothing_else() {
    let (suite, before) = (suite(), before());
    let cases: Vec<_> = suite.cases().iter().collect();
    let is_refused = |assumption: &Assumption| assumption.strictness() == Strictness::Refused;
    let mut unrefused: BTreeSet<_> = Assumption::ALL.iter().copied().filter(is_refused).collect();
    let mut wrong = Vec::new();
    for (free, strict) in counted(false, &cases)
        .into_iter()
        .zip(counted(true, &cases))
    {
        let (case, _, fidelity, _) = free;
        let (_, outcome, _, refusals) = strict;
        let before = before(case);
        let chooses = (Assumption::ALL.iter())
            .any(|choice| is_refused(choice) && fidelity.uses(*choice) > before.uses(*choice));
        if !chooses && (outcome != Outcome::Passed || !refusals.is_empty()) {
            wrong.push(format!("{}: {outcome:?}, refused {refusals:?}", case.id));
        }
        unrefused.retain(|choice| !(case.assumes.contains(choice) && refusals.contains(choice)));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(unrefused.is_empty(), "never refused: {unrefused:?}");
}
