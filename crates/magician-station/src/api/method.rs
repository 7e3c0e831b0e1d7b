//! Description of a method: parameters, requirements, texts.

use super::link::LINK_METHODS;
use super::{Kind, METHODS, Param};
use crate::control::WorkKind;

/// Rights of a session. Each role includes the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// May watch and stop.
    Viewer,
    /// May move the arm, with a lease.
    Student,
    /// May take leases away and send dangerous commands.
    Teacher,
}

impl Role {
    /// Returns the name used in interfaces.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Student => "student",
            Self::Teacher => "teacher",
        }
    }

    /// Returns the role with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let roles = [Self::Viewer, Self::Student, Self::Teacher];
        roles.into_iter().find(|role| role.name() == name)
    }
}

/// Requirement of a method on the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// No requirement.
    Nothing,
    /// The lease, for this kind of work.
    Lease(WorkKind),
}

/// Method of the API.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Name.
    pub name: &'static str,
    /// Least role that may call it.
    pub role: Role,
    /// Requirement on the arm.
    pub needs: Needs,
    /// True if it is processed without an id and without rate limit: stops, and keeping a jog
    /// alive.
    pub always: bool,
    /// True if it needs a socket with a session, not a single request.
    pub session: bool,
    /// Parameters. `arm` may be omitted while the station has only one.
    pub params: &'static [Param],
    /// Description.
    pub about: &'static str,
    /// Description of the result.
    pub result: &'static str,
}

impl Method {
    /// Returns the method with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        METHODS.iter().find(|method| method.name == name)
    }

    /// Returns the method with this name among those reserved for links.
    pub(crate) fn of_link(name: &str) -> Option<&'static Self> {
        LINK_METHODS.iter().find(|method| method.name == name)
    }
}

pub(super) const fn required_param(name: &'static str, kind: Kind, about: &'static str) -> Param {
    Param {
        name,
        kind,
        required: true,
        about,
    }
}

pub(super) const fn optional_param(name: &'static str, kind: Kind, about: &'static str) -> Param {
    Param {
        name,
        kind,
        required: false,
        about,
    }
}

pub(super) const fn method(
    name: &'static str,
    role: Role,
    params: &'static [Param],
    about: &'static str,
    result: &'static str,
) -> Method {
    Method {
        name,
        role,
        needs: Needs::Nothing,
        always: false,
        session: false,
        params,
        about,
        result,
    }
}

impl Method {
    /// True if the method changes something of a class.
    pub(crate) fn is_of_class(&self) -> bool {
        let of_class = ["class.", "turn.", "schedule.", "site."];
        let reads = [".get", ".list", ".results", ".roster"];
        of_class.iter().any(|of| self.name.starts_with(of))
            && !reads.iter().any(|reads| self.name.ends_with(reads))
    }

    pub(super) const fn leased(self, kind: WorkKind) -> Self {
        Self {
            needs: Needs::Lease(kind),
            ..self
        }
    }

    pub(super) const fn always(self) -> Self {
        Self {
            always: true,
            ..self
        }
    }

    pub(super) const fn of_sessions(self) -> Self {
        Self {
            session: true,
            ..self
        }
    }
}
