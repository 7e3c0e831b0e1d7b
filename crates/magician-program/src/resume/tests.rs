//! Tests of counting steps and of finding the place to resume at.

use super::step_counter::MAX_INDEX_PAIRS;
use super::*;

fn exactly(steps: u64) -> StepRange {
    StepRange {
        least: steps,
        most: steps,
    }
}

#[test]
fn index_maps_to_its_step() {
    let mut counter = StepCounter::new(2, false);
    assert_eq!(counter.finished(0), exactly(0));
    counter.note(10, 110);
    assert_eq!(counter.finished(101), exactly(0));
    assert_eq!(counter.finished(102), exactly(0));
    assert_eq!(counter.finished(103), exactly(1));
    assert_eq!(counter.finished(110), exactly(8));
    counter.note(14, 114);
    assert_eq!(counter.finished(112), exactly(10));
    assert_eq!(counter.last(), Some((114, 12)));
}

#[test]
fn duplicates_are_in_doubt_only_after_the_last_known_index() {
    let mut counter = StepCounter::new(2, false);
    counter.note(10, 110);
    assert_eq!(counter.certain(109), exactly(7));
    assert_eq!(counter.certain(110), exactly(8));
    assert_eq!(counter.certain(112), StepRange { least: 8, most: 10 });
}

#[test]
fn inserted_commands_are_in_doubt_until_passed() {
    let mut counter = StepCounter::new(0, true);
    counter.note(5, 5);
    counter.note(9, 10);
    assert_eq!(counter.finished(5), exactly(5));
    assert_eq!(counter.finished(3), StepRange { least: 3, most: 5 });
    assert_eq!(counter.finished(7), StepRange { least: 6, most: 7 });
    assert_eq!(counter.finished(10), exactly(9));
}

#[test]
fn inserted_commands_count_for_no_step() {
    let mut counter = StepCounter::new(1, false);
    counter.note(3, 103);
    for command in [4, 5] {
        counter.insert(command);
    }
    assert!(!counter.has_passed_inserted(104));
    counter.note(8, 108);
    let finished = [101, 102, 103, 104, 105, 106, 108].map(|index| counter.finished(index));
    assert_eq!(finished, [0, 1, 2, 2, 2, 3, 5].map(exactly));
    assert_eq!(counter.last(), Some((108, 5)));
    assert!(counter.has_passed_inserted(105) && !counter.has_passed_inserted(104));
    // Of the oldest inserted commands only the number is kept.
    let mut counter = StepCounter::new(0, false);
    let many = 3 * MAX_INDEX_PAIRS as u64;
    for command in 1..=many {
        counter.insert(command);
    }
    counter.note(many + 10, many + 10);
    assert_eq!(counter.finished(many + 4), exactly(4));
}

#[test]
fn resent_commands_have_new_indices() {
    let mut counter = StepCounter::new(0, false);
    counter.note(4, 4);
    counter.note(10, 10);
    counter.note(7, 7);
    counter.note(12, 15);
    assert_eq!(counter.finished(15), exactly(12));
    assert_eq!(counter.finished(7), exactly(7));
}

fn checkpoint() -> Checkpoint {
    Checkpoint {
        finished: 40,
        handed: 100,
        index: Some((150, 50)),
        clock: 5000,
        ..Checkpoint::new("pen", Some(200), false)
    }
}

fn progress_at(current: u64) -> Option<ObservedProgress> {
    Some(ObservedProgress {
        current,
        clock: 6000,
    })
}

#[test]
fn killed_run_resumes_from_the_state_of_the_arm() {
    assert_eq!(
        checkpoint().resume_point(progress_at(160), &StepNumbering::default(), |_| Some(true)),
        ResumePoint::After(60)
    );
    assert_eq!(
        checkpoint().resume_point(progress_at(145), &StepNumbering::default(), |_| Some(true)),
        ResumePoint::After(45)
    );
    assert_eq!(
        checkpoint().resume_point(progress_at(160), &StepNumbering::default(), |_| None),
        ResumePoint::After(60)
    );
    // The arm was stopped in the meantime.
    assert_eq!(
        checkpoint().resume_point(progress_at(160), &StepNumbering::default(), |_| Some(false)),
        ResumePoint::Again(59)
    );
}

#[test]
fn unknowable_progress_is_in_doubt() {
    let any_step = ResumePoint::Doubt(StepRange {
        least: 40,
        most: 100,
    });
    let reset = Some(ObservedProgress {
        current: 160,
        clock: 4000,
    });
    for seen in [
        None,
        reset,
        progress_at(3),
        progress_at(139),
        progress_at(201),
    ] {
        assert_eq!(
            checkpoint().resume_point(seen, &StepNumbering::default(), |_| Some(true)),
            any_step,
            "{seen:?}"
        );
    }
    let mixed = Checkpoint {
        mixed: true,
        ..checkpoint()
    };
    let few = ResumePoint::Doubt(StepRange {
        least: 50,
        most: 53,
    });
    assert_eq!(
        mixed.resume_point(progress_at(153), &StepNumbering::default(), |_| Some(true)),
        few
    );
    let fresh = Checkpoint::new("pen", Some(200), false);
    assert_eq!(
        fresh.resume_point(None, &StepNumbering::default(), |_| None),
        ResumePoint::After(0)
    );
    let just_begun = Checkpoint { handed: 1, ..fresh };
    assert_eq!(
        just_begun.resume_point(None, &StepNumbering::default(), |_| None),
        ResumePoint::Again(0)
    );
}

#[test]
fn run_without_replies_is_judged_by_the_index_at_rest() {
    let checkpoint = Checkpoint {
        handed: 64,
        clock: 5000,
        rest: Some(7),
        ..Checkpoint::new("pen", Some(200), false)
    };
    let resume_point = |checkpoint: &Checkpoint, current| {
        checkpoint.resume_point(progress_at(current), &StepNumbering::default(), |_| {
            Some(true)
        })
    };
    assert_eq!(
        resume_point(&checkpoint, 7),
        ResumePoint::After(0),
        "nothing was taken"
    );
    assert_eq!(
        resume_point(&checkpoint, 8),
        ResumePoint::Again(0),
        "one may have been"
    );
    let several = ResumePoint::Doubt(StepRange { least: 0, most: 3 });
    assert_eq!(resume_point(&checkpoint, 10), several);
    let any_step = ResumePoint::Doubt(StepRange { least: 0, most: 64 });
    assert_eq!(resume_point(&checkpoint, 6), any_step, "it was reset");
    let unknown = Checkpoint {
        rest: None,
        ..checkpoint
    };
    assert_eq!(resume_point(&unknown, 7), any_step);
    // A lost reply causes the same doubt while the run lasts.
    let counter = StepCounter::new(0, false).from_rest(Some(7));
    assert_eq!(counter.certain(7), exactly(0));
    assert_eq!(counter.certain(8), StepRange { least: 0, most: 1 });
}

#[test]
fn recorded_end_of_a_run_is_trusted() {
    for resume_point in [
        ResumePoint::After(61),
        ResumePoint::Again(61),
        ResumePoint::Doubt(StepRange {
            least: 61,
            most: 64,
        }),
    ] {
        let checkpoint = checkpoint().ended(resume_point);
        assert_eq!(
            checkpoint.resume_point(progress_at(7), &StepNumbering::default(), |_| Some(false)),
            resume_point
        );
        let text = serde_json::to_string(&checkpoint).expect("it can be written");
        assert_eq!(
            serde_json::from_str::<Checkpoint>(&text).expect("and read"),
            checkpoint
        );
    }
}

#[test]
fn index_of_the_first_step_is_known_from_the_index_at_rest() {
    let mut counter = StepCounter::new(2, false).from_rest(Some(7));
    assert_eq!(counter.last(), Some((9, 0)));
    counter.note(1, 8);
    assert_eq!(
        counter.last(),
        Some((9, 0)),
        "one of two commands ahead was taken"
    );
    counter.insert(2);
    assert_eq!(counter.last(), Some((10, 0)), "another one goes out ahead");
    counter.note(5, 12);
    assert_eq!(counter.last(), Some((12, 2)));
    counter.insert(6);
    assert_eq!(
        counter.last(),
        Some((12, 2)),
        "behind the first step it shifts nothing"
    );
}

#[test]
fn run_without_an_answer_is_counted_from_the_index_at_rest() {
    let checkpoint = Checkpoint {
        handed: 64,
        clock: 5000,
        rest: Some(7),
        index: Some((9, 0)),
        ..Checkpoint::new("pen", Some(200), false)
    };
    let numbering = StepNumbering::default();
    let point_and_doubt = |current, stands_after| {
        let point =
            checkpoint.resume_point(progress_at(current), &numbering, |_| Some(stands_after));
        (
            point,
            checkpoint
                .doubt(progress_at(current), &numbering)
                .map(|doubt| doubt.why),
        )
    };
    for ahead in 7..=9 {
        assert_eq!(point_and_doubt(ahead, true), (ResumePoint::After(0), None));
    }
    assert_eq!(point_and_doubt(12, true), (ResumePoint::After(3), None));
    assert_eq!(point_and_doubt(12, false), (ResumePoint::Again(2), None));
    assert_eq!(point_and_doubt(6, true).1, Some(DoubtReason::Reset));
    assert_eq!(
        point_and_doubt(74, true).1,
        Some(DoubtReason::ForeignCommands)
    );
    assert!(checkpoint.is_untouched(progress_at(7)) && !checkpoint.is_untouched(progress_at(8)));
    // The first command after power-up gets index 2.
    let after_power_up = Checkpoint {
        rest: Some(0),
        index: StepCounter::new(0, false).from_rest(Some(0)).last(),
        ..checkpoint.clone()
    };
    for (current, steps) in [(0, 0), (2, 1), (3, 2)] {
        let point = after_power_up.resume_point(progress_at(current), &numbering, |_| Some(true));
        assert_eq!(point, ResumePoint::After(steps));
    }
    let counter = StepCounter::new(2, false).from_rest(Some(0));
    assert_eq!(counter.last(), Some((3, 0)));
    let reset = ObservedProgress {
        current: 7,
        clock: 4000,
    };
    assert_eq!(
        checkpoint
            .doubt(Some(reset), &numbering)
            .map(|doubt| doubt.why),
        Some(DoubtReason::Reset)
    );
    assert_eq!(
        checkpoint.doubt(None, &numbering).map(|doubt| doubt.why),
        Some(DoubtReason::NotReadable)
    );
    let mixed = Checkpoint {
        mixed: true,
        ..checkpoint.clone()
    };
    assert_eq!(
        mixed.resume_point(progress_at(9), &numbering, |_| None),
        ResumePoint::After(0)
    );
    let doubt = mixed.doubt(progress_at(12), &numbering).expect("a doubt");
    assert_eq!(
        (doubt.why, doubt.span),
        (DoubtReason::Mixed, StepRange { least: 0, most: 3 })
    );
}
