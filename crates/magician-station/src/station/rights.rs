//! Who may do what beyond the role and the lease that the table of methods asks for. Each rule is written here once.

use magician::message;
use magician::{Set, burns};

use super::dispatch::{Call, forbidden};
use super::{Grant, Station};
use crate::api::{Danger, Role, RpcError};
use crate::control::ArmId;
#[cfg(feature = "class")]
use crate::control::{JobClaim, QueuedChange};

/// What would burn or is dangerous, as refusals name it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Risk<'a> {
    /// What needs the role.
    needs_role: &'a str,
    /// What needs `yes`.
    needs_yes: &'a str,
    /// The command or method.
    command: &'a str,
}

impl<'a> Risk<'a> {
    /// A command of the protocol.
    pub(super) fn of_command(set: &'a Set) -> Self {
        let name = set.row().set_name;
        Self {
            needs_role: name,
            needs_yes: name,
            command: name,
        }
    }

    /// The dangerous commands of a job.
    pub(super) const fn of_dangerous_job() -> Self {
        Self {
            needs_role: "a dangerous command",
            needs_yes: "a command",
            command: "job.start",
        }
    }

    /// The laser of a job, which this method starts or resumes.
    pub(super) const fn of_job(method: &'a str) -> Self {
        Self {
            needs_role: "a laser",
            needs_yes: "the job",
            command: method,
        }
    }
}

impl Station {
    /// Whether a request may light the laser of an arm: a virtual one lights nothing; of a real arm it takes the role, and
    /// `yes`. Every way to the laser asks here: commands, jobs, jobs that wait. (Programs for DobotLink have no `yes`: the
    /// flag `--link-laser` says it for them.)
    ///
    /// # Errors
    /// The refusal of the role (-32001), or for want of `yes` (-32005).
    pub(super) fn may_burn(
        &self,
        call: &Call<'_>,
        arm: ArmId,
        risk: Risk<'_>,
    ) -> Result<(), RpcError> {
        if self.arm(arm).entry.is_virtual {
            return Ok(());
        }
        let needs = if self.config.student_laser {
            Role::Student
        } else {
            Role::Teacher
        };
        confirmed(&call.grant, call.yes(), needs, risk, Danger::Laser)
    }

    /// Whether the laser may burn by this command of a request.
    ///
    /// # Errors
    /// It would burn and may not, or it is dangerous and not allowed.
    pub(super) fn laser(
        &self,
        call: &Call<'_>,
        arm: ArmId,
        command: Option<&Set>,
    ) -> Result<bool, RpcError> {
        if let Some(set) = command
            && let Some(danger) = set.row().danger()
        {
            may_endanger(call, Risk::of_command(set), Danger::Arm(danger))?;
        }
        let burning = command.filter(|set| burns(set, self.arm(arm).entry.laser_pins));
        match burning {
            Some(set) => { self.may_burn(call, arm, Risk::of_command(set)) }.map(|()| true),
            // What it may not light then it does not.
            None => Ok(self.may_burn(call, arm, Risk::of_job("arm.set")).is_ok()),
        }
    }

    /// Whether a request may change a job that waits for an arm. [`may_change`](crate::control::Control) decides.
    ///
    /// # Errors
    /// The refusal (-32001), which names those who may.
    #[cfg(feature = "class")]
    pub(super) fn check_queued(
        &self,
        call: &Call<'_>,
        claim: &JobClaim,
        change: QueuedChange,
    ) -> Result<(), RpcError> {
        if self.control.may_change(call.session, claim, change) {
            return Ok(());
        }
        let owned = match claim.person {
            Some(person) => format!("its owner {}", self.person_name(person)),
            None => "its owner, a teacher".to_owned(),
        };
        let name = &self.arm(claim.arm).entry.name;
        let (may, who) = match change {
            QueuedChange::Resume => (
                &["owner", "teacher"][..],
                format!("{owned}, or a teacher, lets it go on"),
            ),
            QueuedChange::Stop => (
                &["owner", "holder", "teacher"][..],
                format!("{owned}, the holder of the lease of {name}, or a teacher, takes it out"),
            ),
            QueuedChange::Reorder => (
                &["owner", "holder", "teacher"][..],
                format!("{owned}, the holder of the lease of {name}, or a teacher, moves it"),
            ),
        };
        let why = message!("the job waits in the queue of {name}: {who}", name, who);
        Err(RpcError::new(RpcError::FORBIDDEN, why)
            .with("role", call.grant.role.name())
            .with("needs", Role::Teacher.name())
            .with("may", may))
    }
}

/// Whether a request may do what is dangerous for the arm.
///
/// # Errors
/// The refusal of the role (-32001), or for want of `yes` (-32005).
pub(super) fn may_endanger(
    call: &Call<'_>,
    risk: Risk<'_>,
    danger: Danger,
) -> Result<(), RpcError> {
    confirmed(&call.grant, call.yes(), Role::Teacher, risk, danger)
}

/// What is dangerous takes a role, and the word of a person that it is meant.
fn confirmed(
    grant: &Grant,
    yes: bool,
    needs: Role,
    risk: Risk<'_>,
    danger: Danger,
) -> Result<(), RpcError> {
    if grant.role < needs {
        return Err(forbidden(grant, needs, risk.needs_role));
    }
    if !yes {
        return Err(RpcError::dangerous(risk.needs_yes, risk.command, danger));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The whole rule: role, and `yes`.
    #[test]
    fn danger_needs_the_role_first_and_then_the_word() {
        use Role::{Student, Teacher, Viewer};
        for needs in [Student, Teacher] {
            for role in [Viewer, Student, Teacher] {
                for yes in [false, true] {
                    let grant = Grant { role, token: None };
                    let risk = Risk::of_job("job.start");
                    let code = { confirmed(&grant, yes, needs, risk, Danger::Laser) }
                        .map_err(|error| error.code);
                    let expected = match (role >= needs, yes) {
                        (false, _) => Err(RpcError::FORBIDDEN),
                        (true, false) => Err(RpcError::DANGEROUS),
                        (true, true) => Ok(()),
                    };
                    assert_eq!(code, expected, "{needs:?} {role:?} {yes}");
                }
            }
        }
    }
}
