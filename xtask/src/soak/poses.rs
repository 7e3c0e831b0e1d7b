//! R1: alterations that the checksum misses, and where the arm ends because of them.

use std::error::Error;

use magician::commands::{ClearAllAlarmsState, HomeCmd, Pose};
use magician::connection::{Request, Settings};
use magician::faults::Faults;
use magician_protocol::{NoArgs, PtpMode};

use super::submitted::{pair_with_running_queue, poll, run_request};
use super::{Scope, SoakResult, program};
use crate::bench::figure::Figure;

const SECOND: u64 = 1_000_000;
/// Ten times the corrupted bytes of R1, for a hundred times the undetected alterations to examine.
const CORRUPTED_LINE: Faults = Faults {
    replace: 1e-2,
    drop: 1e-3,
    ..Faults::NONE
};
/// Deviation from the target that is noticed, mm and deg: less than an arm's repeatability.
const NOTICED_DEVIATION: f32 = 0.1;

#[derive(Default)]
struct Tally {
    altered: u64,
    noticed: u64,
    /// The arm ended at its target, within [`NOTICED_DEVIATION`].
    harmless: u64,
    /// The arm ended there by another path: mainly the mode was altered.
    detours: u64,
    false_alarms: u64,
}

pub(super) fn moves(scope: Scope) -> Result<SoakResult, Box<dyn Error>> {
    let failed = |failure| format!("{failure:?}");
    let mut pair = pair_with_running_queue(Settings::ORDERED, scope.seed).map_err(failed)?;
    pair.set_faults(CORRUPTED_LINE);
    let mut tally = Tally::default();
    for number in 1..=scope.cases {
        let command = program::to_point(number, PtpMode::MovjXyz);
        let request = program::request(&command);
        let accepted = run_request(&mut pair, request).is_ok();
        // Until the move has ended; a held queue shows in the alarms, a stopped one in the index.
        let mut held = false;
        while pair.arm.state().queue.running.is_some() || pair.arm.state().queue.waiting > 0 {
            let soon = pair.now + SECOND;
            pair.run_until(soon);
            if !pair.arm.state().queue.started {
                held = true;
                poll(&mut pair);
            }
            if pair.arm.state().queue.held {
                // A joint at its limit must be homed before it can move on.
                if held {
                    run_request(&mut pair, Request::set(&HomeCmd { reserved: 0 })?).ok();
                    while pair.arm.state().moving {
                        let soon = pair.now + SECOND;
                        pair.run_until(soon);
                    }
                }
                held = true;
                run_request(&mut pair, Request::set(&ClearAllAlarmsState {})?).ok();
            }
        }
        let taken = std::mem::take(&mut pair.accepted);
        pair.heard.clear();
        while pair.arm.poll_event().is_some() {}
        let sent = request.frame().frame();
        let altered = taken.iter().any(|(params, _)| params != sent.params());
        let pose = run_request(&mut pair, Request::get::<Pose>(&NoArgs)?);
        let (true, Ok(reply)) = (accepted, pose) else {
            continue;
        };
        let Ok(pose) = reply.frame().read::<Pose>() else {
            continue;
        };
        let target = program::position(number);
        let found = [pose.x, pose.y, pose.z, pose.r];
        let mut apart = target
            .iter()
            .zip(&found)
            .map(|(target, found)| (target - found).abs());
        let noticed = held || !apart.all(|apart| apart <= NOTICED_DEVIATION);
        tally.altered += u64::from(altered);
        tally.noticed += u64::from(altered && noticed);
        let mode = |params: &[u8]| params.first().copied();
        let detour = taken
            .iter()
            .any(|(params, _)| mode(params) != mode(sent.params()));
        tally.harmless += u64::from(altered && !noticed && !detour);
        tally.detours += u64::from(altered && !noticed && detour);
        tally.false_alarms += u64::from(!altered && noticed);
    }
    let count = |name: &str, value: u64| Figure::new(name, value as f64, "moves");
    Ok(SoakResult {
        figures: vec![
            count("sent", scope.cases),
            count("altered", tally.altered),
            count("noticed by the final pose", tally.noticed),
            count("altered by less than 0.1 mm or deg", tally.harmless),
            count("another way to the same end", tally.detours),
            count("noticed though not altered", tally.false_alarms),
        ],
        digest: Some(pair.digest.0),
    })
}
