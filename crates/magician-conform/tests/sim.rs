//! Runs every case on the virtual arm, and checks which cases fail with other profiles. The tests
//! in `assumptions` check that a case fails for each violated assumption.

use std::time::Duration;

use magician_conform::{Case, Outcome, Runner, SimTarget, Suite, hex};
use magician_sim::Profile;

fn suite() -> Suite {
    Suite::built_in().unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the outcomes of cases on virtual arms with this profile.
fn run<'c>(profile: Profile, cases: &[&'c Case]) -> Vec<(&'c Case, Outcome)> {
    let target = SimTarget::new(profile);
    let mut runner = Runner::new(target, Duration::from_secs(1)).expect("the beginnings are read");
    let runtime = tokio::runtime::Builder::new_current_thread()
        .build()
        .expect("a runtime");
    runtime.block_on(async {
        runner.begin().await.expect("a virtual arm answers");
        let mut outcomes = Vec::new();
        for case in cases {
            let outcome = runner.run(case).await.expect("no line to lose");
            outcomes.push((*case, outcome));
        }
        runner.end().await.expect("a virtual arm answers");
        outcomes
    })
}

fn describe(case: &Case, outcome: &Outcome) -> String {
    match outcome {
        Outcome::Failed(m) => format!(
            "{} ({}.toml:{})\n    {}\n    sent     {}\n    expected {}\n    got      {} [{}]",
            case.id,
            case.chapter(),
            m.line,
            m.step,
            hex(&m.sent),
            m.expected,
            m.got,
            hex(&m.received)
        ),
        other => format!("{}: {other:?}", case.id),
    }
}

#[test]
fn the_virtual_arm_passes_every_case() {
    let suite = suite();
    let cases: Vec<_> = suite.cases().iter().collect();
    let outcomes = run(Profile::default(), &cases);
    let failures: Vec<_> = outcomes
        .iter()
        .filter(|(_, outcome)| *outcome != Outcome::Passed)
        .map(|(case, outcome)| describe(case, outcome))
        .collect();
    assert!(failures.is_empty(), "\n{}", failures.join("\n"));
}

/// Returns the cases that an arm with another profile fails.
fn failed_with(change: impl FnOnce(&mut Profile)) -> Vec<String> {
    let mut profile = Profile::default();
    change(&mut profile);
    profile.check().expect("a sensible profile");
    let suite = suite();
    let cases: Vec<_> = suite.cases().iter().collect();
    let outcomes = run(profile, &cases);
    let failed = outcomes
        .iter()
        .filter(|(_, outcome)| matches!(outcome, Outcome::Failed(_)));
    failed.map(|(case, _)| case.id.clone()).collect()
}

#[track_caller]
fn fails(change: impl FnOnce(&mut Profile), named: &[&str]) {
    let failed = failed_with(change);
    for name in named {
        assert!(
            failed.iter().any(|id| id == name),
            "{name} passes; failed: {failed:?}"
        );
    }
    assert!(failed.len() < 150, "everything fails: {failed:?}");
}

#[test]
fn another_first_index_fails_only_the_power_up_case() {
    let failed = failed_with(|profile| profile.queue.first_index = 1);
    assert_eq!(failed, ["queue.at-power-up"]);
}

#[test]
fn another_limit_of_j3_fails_only_its_cases() {
    let failed = failed_with(|profile| profile.limits.controller.j3.min = -14.0);
    for id in &failed {
        assert!(
            [
                "ptp.j3-minus-limit",
                "pose.forward-pk03",
                "pose.inverse-pk03"
            ]
            .contains(&id.as_str()),
            "{id}"
        );
    }
    assert_eq!(failed.len(), 3, "{failed:?}");
}

#[test]
fn lower_ceilings_are_found() {
    fails(
        |profile| profile.ceilings.linear_velocity = 90.0,
        &["ptp.movl-100-mm", "ptp.movl-on-the-way", "ptp.ceilings"],
    );
}

#[test]
fn another_home_is_found() {
    fails(
        |profile| profile.home.joints.j2 = 44.0,
        &[
            "home.params-at-power-up",
            "home.params-with-tool",
            "home.default-home-point",
        ],
    );
}

/// The profile `continuous` describes the same arm except for its times.
#[test]
fn arm_in_continuous_time_fails_only_cases_about_times_and_positions_on_the_way() {
    let suite = suite();
    let cases: Vec<_> = suite.cases().iter().collect();
    let outcomes = run(Profile::continuous(), &cases);
    let timed = ["jog", "ptp", "cp", "arc", "wait", "queue", "rail"];
    let mut count = 0;
    for (case, outcome) in outcomes {
        if let Outcome::Failed(_) = &outcome {
            count += 1;
            assert!(
                timed.contains(&case.chapter()),
                "{}",
                describe(case, &outcome)
            );
        }
    }
    assert!((40..80).contains(&count), "{count} of {}", cases.len());
}
