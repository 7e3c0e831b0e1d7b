//! Proof that each safeguard is needed: without it, a check fails.

use super::super::planted_bug::{PlantedBug, is_noticed};

const NOTICED: [(PlantedBug, fn()); 11] = [
    (
        PlantedBug::MatchById,
        super::stops::a_stop_is_not_confirmed_by_the_answer_to_what_it_stops,
    ),
    (
        PlantedBug::NoFence,
        super::replies::an_answer_that_was_lost_costs_the_next_request_no_timeout,
    ),
    (
        PlantedBug::NoFence,
        super::faults::datagrams_that_overtake_each_other_are_not_mixed_up,
    ),
    (
        PlantedBug::AcceptGaps,
        super::doubts::wrong_index_leaves_command_uncertain,
    ),
    (
        PlantedBug::ResendBlindly,
        super::faults::executes_each_command_once_over_a_serial_line_that_loses_damages_and_delays,
    ),
    (
        PlantedBug::NoInterByteTimeout,
        super::replies::a_frame_that_stays_away_holds_up_no_answer,
    ),
    (
        PlantedBug::NoLifetime,
        super::faults::datagrams_lost_late_and_out_of_order_lead_to_no_silent_mistake,
    ),
    (
        PlantedBug::ResendAfterStop,
        super::stops::what_was_lost_before_a_stop_is_not_sent_after_it,
    ),
    (
        PlantedBug::QueueWhileStopping,
        super::stops::a_clear_that_goes_out_again_finds_nothing_that_was_accepted_meanwhile,
    ),
    (
        PlantedBug::PairAfterLoss,
        super::pairs::a_controller_that_takes_one_frame_at_a_time_is_left_alone_after_a_few_losses,
    ),
    (
        PlantedBug::JudgeInWindow,
        super::doubts::request_lost_in_a_window_is_not_resent_after_the_next,
    ),
];

#[test]
fn every_planted_bug_is_noticed() {
    let silent: Vec<_> = (NOTICED.iter())
        .filter(|(flaw, check)| !is_noticed(*flaw, *check))
        .map(|(flaw, _)| flaw)
        .collect();
    assert!(silent.is_empty(), "{silent:?} would go unnoticed");
}
