//! Rights beyond the role and lease in the table of methods: the laser, dangerous commands, jobs in
//! the queue.
//!
//! Each rule is written once, here, and every path to the laser asks it.

#[cfg(feature = "class")]
use magician::message;
use magician::{Message, Set, burns};

use super::dispatch::{Call, forbidden};
use super::{Grant, Station};
use crate::api::{Danger, Role, RpcError};
use crate::control::ArmId;
#[cfg(feature = "class")]
use crate::control::{JobClaim, QueuedChange};

/// Something that would burn or is dangerous, with its names in refusals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Risk<'a> {
    /// Name in a refusal because of the role.
    needs_role: &'static str,
    /// Name in a refusal because of a missing `yes`.
    needs_yes: &'static str,
    /// Command or method.
    command: &'a str,
}

impl<'a> Risk<'a> {
    /// Returns the risk of a command of the protocol.
    pub(super) fn of_command(set: &'a Set) -> Self {
        let name = set.row().set_name;
        Self {
            needs_role: name,
            needs_yes: name,
            command: name,
        }
    }

    /// Returns the risk of dangerous commands in a job.
    pub(super) const fn of_dangerous_job() -> Self {
        Self {
            needs_role: "a dangerous command",
            needs_yes: "a command",
            command: "job.start",
        }
    }

    /// Returns the risk of the laser in a job that this method starts or resumes.
    pub(super) const fn of_job(method: &'a str) -> Self {
        Self {
            needs_role: "a laser",
            needs_yes: "the job",
            command: method,
        }
    }
}

impl Station {
    /// Checks whether a request may switch on the laser of an arm. A virtual arm burns nothing. A
    /// real arm needs the role and `yes`. Commands, jobs and queued jobs all pass this check.
    /// (Programs for DobotLink cannot send `yes`: the flag `--link-laser` gives it for them.)
    ///
    /// # Errors
    /// Refusal of the role (-32001), or because `yes` is missing (-32005).
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
        confirmed(&call.grant, call.is_confirmed(), needs, risk, Danger::Laser)
    }

    /// Checks a command. Returns true if it may switch the laser on.
    ///
    /// # Errors
    /// The command burns and must not, or it is dangerous and not allowed.
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
            // For a command that does not burn, a missing permission is not an error: it is carried
            // out without.
            None => Ok(self.may_burn(call, arm, Risk::of_job("arm.set")).is_ok()),
        }
    }

    /// Checks whether a request may change a job that waits for an arm, as decided by
    /// [`may_change`](crate::control::Control).
    ///
    /// # Errors
    /// Refusal (-32001) that names who may.
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
            Some(person) => message!("its owner {name}", name = self.person_name(person)),
            None => message!("its owner, a teacher"),
        };
        let name = &self.arm(claim.arm).entry.name;
        let (may, who) = match change {
            QueuedChange::Resume => (
                &["owner", "teacher"][..],
                message!("{owned}, or a teacher, lets it go on", owned),
            ),
            QueuedChange::Stop => (
                &["owner", "holder", "teacher"][..],
                message!(
                    "{owned}, the holder of the lease of {name}, or a teacher, takes it out",
                    owned,
                    name
                ),
            ),
            QueuedChange::Reorder => (
                &["owner", "holder", "teacher"][..],
                message!(
                    "{owned}, the holder of the lease of {name}, or a teacher, moves it",
                    owned,
                    name
                ),
            ),
        };
        let why = message!("the job waits in the queue of {name}: {who}", name, who);
        Err(RpcError::new(RpcError::FORBIDDEN, why)
            .with("role", call.grant.role.name())
            .with("needs", Role::Teacher.name())
            .with("may", may))
    }
}

/// Checks whether a request may send a command that is dangerous for the arm.
///
/// # Errors
/// Refusal of the role (-32001), or because `yes` is missing (-32005).
pub(super) fn may_endanger(
    call: &Call<'_>,
    risk: Risk<'_>,
    danger: Danger,
) -> Result<(), RpcError> {
    confirmed(
        &call.grant,
        call.is_confirmed(),
        Role::Teacher,
        risk,
        danger,
    )
}

/// Requires a role, and then a confirmation by a person.
fn confirmed(
    grant: &Grant,
    yes: bool,
    needs: Role,
    risk: Risk<'_>,
    danger: Danger,
) -> Result<(), RpcError> {
    // The role first: `yes` from a student must not look like the missing part.
    if grant.role < needs {
        return Err(forbidden(grant, needs, Message::word(risk.needs_role)));
    }
    if !yes {
        return Err(RpcError::dangerous(risk.needs_yes, risk.command, danger));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The whole rule: first the role, then `yes`.
    #[test]
    fn dangerous_command_needs_the_role_before_the_confirmation() {
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
