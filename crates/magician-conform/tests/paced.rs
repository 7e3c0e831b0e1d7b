//! Runs the cases over a line with a baud rate (`--baud`), on an arm that follows the wall clock
//! (`--speed`), as a real arm does. The test advances the wall clock itself.

use std::time::Duration;

use magician::Result;
use magician_conform::{Case, LINE_LOOK, Outcome, Runner, Suite, Target};
use magician_sim::{Controller, HostInstant, LineTiming, LinkId, Profile, Speed};

const LINK: LinkId = LinkId(0);

/// Virtual arm at the end of a paced line, and the time of the wall clock.
struct PacedArm {
    runner: magician_sim::Runner,
    wall: HostInstant,
}

impl PacedArm {
    fn new(speed: Speed, line: LineTiming) -> Self {
        let arm = Controller::new(Profile::default());
        Self {
            runner: magician_sim::Runner::new(arm, speed, line),
            wall: HostInstant::ZERO,
        }
    }

    fn replies(&mut self) -> Vec<u8> {
        let mut bytes = Vec::new();
        while let Some(reply) = self.runner.poll_transmit(self.wall, LINK) {
            bytes.extend_from_slice(reply.bytes());
        }
        bytes
    }

    /// Advances the wall clock to the next event, at most to `end`.
    fn go_to(&mut self, end: HostInstant) {
        let next = self.runner.poll_change().unwrap_or(end);
        self.wall = next.clamp(self.wall, end);
        self.runner.handle_timeout(self.wall);
    }

    fn after(&self, span: Duration) -> HostInstant {
        self.wall + span
    }
}

impl Target for PacedArm {
    async fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.runner.receive(self.wall, LINK, bytes);
        Ok(())
    }

    async fn receive(&mut self, within: Duration) -> Result<Vec<u8>> {
        let end = self.after(within);
        loop {
            let bytes = self.replies();
            if !bytes.is_empty() || self.wall >= end {
                return Ok(bytes);
            }
            let before = self.wall;
            self.go_to(end);
            if self.wall == before {
                self.wall += Duration::from_micros(1);
            }
        }
    }

    async fn pass(&mut self, span: Duration) -> Result<()> {
        let end = self.after(span);
        while self.wall < end {
            let before = self.wall;
            self.go_to(end);
            if self.wall == before {
                self.wall += Duration::from_micros(1);
            }
        }
        Ok(())
    }

    async fn go_on(&mut self, at_most: Duration) -> Result<()> {
        self.pass(LINE_LOOK.min(at_most)).await
    }
}

/// Returns the failures among the cases that a line supports, and the number that passed.
fn failed(speed: Speed, line: LineTiming, which: fn(&Case) -> bool) -> (Vec<String>, usize) {
    let suite = Suite::built_in().unwrap_or_else(|error| panic!("{error}"));
    let arm = PacedArm::new(speed, line);
    let mut runner = Runner::new(arm, Duration::from_secs(3)).expect("the beginnings are read");
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    runtime.expect("a runtime").block_on(async {
        let (mut failed, mut passed) = (Vec::new(), 0);
        runner.begin().await.expect("the arm answers");
        for case in suite.cases().iter().filter(|case| which(case)) {
            match runner.run(case).await.expect("no line to lose") {
                Outcome::Failed(mismatch) => failed.push(format!("{}: {mismatch:?}", case.id)),
                Outcome::Passed => passed += 1,
                Outcome::Skipped(_) => {}
            }
        }
        runner
            .end()
            .await
            .expect("the arm takes its parameters back");
        (failed, passed)
    })
}

const USB: LineTiming = LineTiming {
    baud: Some(115_200),
    turnaround: Duration::from_millis(1),
};

#[test]
fn cases_pass_at_115200_baud() {
    let (failed, passed) = failed(Speed::Times(1.0), USB, |_| true);
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(passed > 150, "{passed} cases were done");
}

/// Runs only cases without waits. A wait follows the wall clock and is twice as long for this arm;
/// durations of commands follow the arm's clock.
#[test]
fn commands_take_as_long_on_an_arm_twice_as_fast() {
    let timed = |case: &Case| {
        let begins = |word| case.steps().any(|step| step.starts_with(word));
        begins("done after") && !begins("wait ") && !begins("at ")
    };
    let (failed, passed) = failed(Speed::Times(2.0), USB, timed);
    assert!(failed.is_empty(), "{failed:#?}");
    assert!(passed > 40, "{passed} cases were done");
}
