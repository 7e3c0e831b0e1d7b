//! Bringing the arm to a stand.

use std::sync::atomic::Ordering;
use std::time::Duration;

use magician_protocol::JogCommand;
use magician_protocol::commands::{JogCmd, Pose, QueuedCmdStopExec};
use tokio::time::{Instant, sleep};

use super::Arm;
use super::exposure::Exposure;
use crate::connection::{Priority, Request};
use crate::{Error, ErrorKind, Result};

/// How long the arm may take to come to a stand: from full speed at twice the acceleration, and the
/// end of a motion that a Clear lets finish.
const BRAKING: Duration = Duration::from_secs(5);
/// Poses so far apart that are equal are those of an arm that stands.
const APART: Duration = Duration::from_millis(30);

impl Arm {
    /// Stops the motion, switches the laser off, drops what waits in the queue, and makes sure that
    /// the arm stands: two equal poses. It overtakes everything; commands that have not gone out
    /// end with [`ErrorKind::Closed`]. Suction and gripper stay as they are.
    ///
    /// This is a convenience, not a safety function: the arm has a power switch.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] when the arm does not answer or does not come to a stand.
    pub async fn stop(&self) -> Result<()> {
        let deadline = self.deadline();
        let stops = 1 + self.shared.stops.fetch_add(1, Ordering::SeqCst);
        let mut answers = Vec::with_capacity(3);
        for request in Request::halt()? {
            let frame = *request.frame();
            answers.push((self.submit(request, deadline, stops).await?, frame));
        }
        let mut outcome = Ok(());
        for (answer, frame) in answers {
            let answer = self.answer(answer, &frame, deadline).await;
            outcome = outcome.and(answer.map(drop));
        }
        outcome?;
        self.own().clear();
        self.wait_still().await
    }

    /// Lets the command under way finish and then holds the queue (document 1.19.2). What waits
    /// stays; [`start_queue`](Self::start_queue) goes on with it.
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn stop_gentle(&self) -> Result<()> {
        let request = Request::set(&QueuedCmdStopExec {})?;
        self.ask(request.priority(Priority::Stop)).await.map(drop)
    }

    /// Drops what waits in the queue; the command under way finishes (document 1.19.6).
    ///
    /// # Errors
    /// As [`get`](Self::get).
    pub async fn clear_queue(&self) -> Result<()> {
        self.set(&magician_protocol::commands::QueuedCmdClear {})
            .await?;
        self.own().clear();
        Ok(())
    }

    /// Ends a jog, at once and for sure: repeated until the arm stands.
    ///
    /// # Errors
    /// As [`stop`](Self::stop).
    pub async fn stop_jog(&self) -> Result<()> {
        let stop = JogCmd {
            is_joint: magician_protocol::Flag::OFF,
            cmd: JogCommand::Stop,
        };
        let until = self.deadline();
        loop {
            let request = Request::set(&stop)?.priority(Priority::Stop);
            let patience = Instant::now() + Duration::from_millis(300);
            match self.ask_until(request, patience.min(until)).await {
                Ok(_) => return self.wait_still().await,
                Err(error) if !again(&error) || Instant::now() >= until => return Err(error),
                Err(_) => {}
            }
        }
    }

    /// Waits until the arm stands: two equal poses in succession.
    ///
    /// # Errors
    /// [`ErrorKind::Timeout`] when it still moves after five seconds, else as [`get`](Self::get).
    pub async fn wait_still(&self) -> Result<()> {
        let until = Instant::now() + BRAKING;
        let mut before = self.get::<Pose>().await?;
        loop {
            sleep(APART).await;
            let pose = self.get::<Pose>().await?;
            if pose == before {
                Exposure::stands_still(&mut self.exposure());
                return Ok(());
            }
            if Instant::now() >= until {
                return Err(Error::new(ErrorKind::Timeout, "the arm still moves"));
            }
            before = pose;
        }
    }
}

/// Whether what failed may work the next time: not on a line that is gone.
fn again(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::Timeout | ErrorKind::Uncertain)
}
