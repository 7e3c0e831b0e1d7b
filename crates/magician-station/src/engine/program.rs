//! Reading of programs for checks and jobs, off the engine's task.
//!
//! Reading may take seconds, and another program may do part of it (`ProgramReading::Pending`), so
//! it must not hold up the arm. A program is read with what the arm knows (fence, surface, tool),
//! and again with the position of the arm if it depends on that. Its digest identifies the content
//! that was read: a job started with the digest of a check runs only that content.

use std::sync::Arc;

use magician::commands::EndEffectorParams;
use magician::{Arm, message};
use magician_job::background::run_in_background;
use magician_job::report::CheckReport;
use magician_program::{PreparedProgram, Tool};
use serde_json::{Value, json};
use tokio::sync::Notify;

use super::jobs::refused;
use crate::api::RpcError;
use crate::job::{self, ProgramReading, Reader, ReadingArm, Source};
use crate::reading::to_value;
use crate::surface::ArmSurface;

/// Program that was read for a job.
pub(super) struct ReadProgram {
    pub(super) program: PreparedProgram,
    /// Digest of its content, for [`JobOrder::digest`](crate::order::JobOrder::digest).
    pub(super) digest: String,
    /// Report of its check, if it cannot be placed within reach.
    pub(super) report: Option<Value>,
}

/// Returns the report of a check for clients, with the digest of the program.
pub(super) fn report_value(report: &CheckReport, digest: &str) -> Result<Value, RpcError> {
    let mut report = to_value(report)?;
    report["digest"] = json!(digest);
    Ok(report)
}

/// Adds the report of a check to a program that cannot be placed, because every refusal of a
/// program carries a report.
pub(super) async fn with_check_report(
    arm: &Arm,
    program: PreparedProgram,
    digest: String,
) -> Result<ReadProgram, RpcError> {
    if program.misfit.is_none() {
        return Ok(ReadProgram {
            program,
            digest,
            report: None,
        });
    }
    let start = arm.preflight_for(&program.program.kinds()).await?;
    let checked = run_in_background(async move {
        let report = job::check(&program, start).await;
        (program, report)
    });
    let (program, report) =
        { checked.await }.map_err(|error| RpcError::internal(error.to_string()))?;
    let report = Some(report_value(&report?, &digest)?);
    Ok(ReadProgram {
        program,
        digest,
        report,
    })
}

/// Error for a program that differs from the checked one.
pub(super) fn changed_program_error(digest: &str) -> RpcError {
    let why = message!("the program is another one than was checked; nothing was sent");
    RpcError::new(RpcError::CHANGED, why).with("digest", digest)
}

/// Reads a program off the engine's task, and returns it with its digest.
///
/// A program that depends on the position of the arm starts at the current position, or at `start`
/// if its job was started before. `runs_on` is the handle that will run the program, with its
/// permissions; `None` for a check.
pub(super) async fn read(
    arm: &Arm,
    runs_on: Option<&Arm>,
    reader: Arc<dyn Reader>,
    surface: &ArmSurface,
    source: Source,
    start: Option<[f64; 3]>,
    cancel: &Notify,
) -> Result<(PreparedProgram, String), RpcError> {
    let mut reading_arm = ReadingArm {
        is_virtual: arm.is_virtual(),
        fence: arm.fence(),
        start,
        surface: surface.known().await?,
        ..ReadingArm::default()
    };
    // A frame is traced with the tool in force, unless the options name the tool.
    if { source.setup.as_ref() }.is_some_and(|options| options.needs_tool_in_force()) {
        reading_arm.tool = Some(Tool::from(&arm.get::<EndEffectorParams>().await?));
    }
    loop {
        let (reader, source, arm_here) = (Arc::clone(&reader), source.clone(), reading_arm.clone());
        let mut read = run_blocking(move || reader.read(&source, &arm_here)).await??;
        while let ProgramReading::Pending(pending) = read {
            read = tokio::select! {
                read = pending => read?,
                () = cancel.notified() => return Err(refused(message!("the job is over"))),
            };
        }
        match read {
            ProgramReading::Done(program, digest) => return Ok((*program, digest)),
            // Not possible after the loop above.
            ProgramReading::Pending(_) => {}
            ProgramReading::LacksSurface(error) => {
                // Measuring the surface needs a homed arm, so an arm not homed gets the error about
                // homing first.
                if let Some(arm) = runs_on {
                    arm.homing().check().await?;
                }
                return Err(error);
            }
            // At most one second reading: with the start known, the program must be readable.
            ProgramReading::NeedsStart if reading_arm.start_state.is_none() => {
                reading_arm.start_state = Some(arm.preflight_for(&[]).await?);
            }
            ProgramReading::NeedsStart => {
                return Err(refused(message!("it is not known where the arm stands")));
            }
        }
    }
}

/// Runs a computation on a blocking thread, or on this thread if the target has no threads.
pub(crate) async fn run_blocking<T: Send + 'static>(
    compute: impl FnOnce() -> T + Send + 'static,
) -> Result<T, RpcError> {
    let computed = run_in_background(async move { compute() }).await;
    computed.map_err(|error| RpcError::internal(error.to_string()))
}
