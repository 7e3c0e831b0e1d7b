//! A method of the API: what it takes, needs and is for.

use super::link::OF_LINKS;
use super::{Kind, METHODS, Param};
use crate::control::WorkKind;

/// What a session may do, each with all of the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// It looks, and may stop.
    Viewer,
    /// It moves the arm, under a lease.
    Student,
    /// It takes leases away, and does what is dangerous.
    Teacher,
}

impl Role {
    /// Its name in interfaces.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Student => "student",
            Self::Teacher => "teacher",
        }
    }

    /// The role of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let roles = [Self::Viewer, Self::Student, Self::Teacher];
        roles.into_iter().find(|role| role.name() == name)
    }
}

/// What a method needs of the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Needs {
    /// Nothing.
    Nothing,
    /// The lease, for this.
    Lease(WorkKind),
}

/// A method of the API.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Method {
    /// Its name.
    pub name: &'static str,
    /// Who may call it.
    pub role: Role,
    /// What it needs of the arm.
    pub needs: Needs,
    /// Whether it is obeyed without an id, in any number: the stops, and what keeps a jog up.
    pub always: bool,
    /// Whether it takes a session of its own: a socket, not a single request.
    pub session: bool,
    /// Its parameters. `arm` may be left out while the station has one.
    pub params: &'static [Param],
    /// What it does.
    pub about: &'static str,
    /// What it answers.
    pub result: &'static str,
}

impl Method {
    /// The method of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<&'static Self> {
        METHODS.iter().find(|method| method.name == name)
    }

    /// The method of a name, of those for links alone.
    pub(crate) fn of_link(name: &str) -> Option<&'static Self> {
        OF_LINKS.iter().find(|method| method.name == name)
    }
}

pub(super) const fn needed(name: &'static str, kind: Kind, about: &'static str) -> Param {
    Param {
        name,
        kind,
        required: true,
        about,
    }
}

pub(super) const fn may(name: &'static str, kind: Kind, about: &'static str) -> Param {
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
    /// Whether it changes something of a class.
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
