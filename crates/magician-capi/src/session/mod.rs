//! The connected arms.

mod connect;
mod search;

use std::collections::BTreeMap;
use std::ffi::c_int;
use std::ops::Deref;
use std::sync::{Arc, PoisonError, RwLock};

use magician::protocol::{Queueable, Row, Writable};
use magician::{QueueIndex, Set, blocking};

use crate::Family;
use crate::code::{Code, Fault, Outcome};

pub use connect::{connect_v1, connect_v2, connect_v3};
pub use search::search;

/// A connected arm.
#[derive(Debug)]
pub struct Session {
    arm: blocking::Arm,
}

/// The connected arms by id; `v1` has one, with the id 0.
static ARMS: RwLock<BTreeMap<c_int, Arc<Session>>> = RwLock::new(BTreeMap::new());

/// The arm with an id.
///
/// # Errors
/// [`Code::Timeout`] when it is not connected; `v3` says [`Code::InvalidDevice`].
pub fn find(family: Family, id: c_int) -> Result<Arc<Session>, Fault> {
    let arms = ARMS.read().unwrap_or_else(PoisonError::into_inner);
    arms.get(&id).cloned().ok_or_else(|| Fault {
        code: if family == Family::V3 {
            Code::InvalidDevice
        } else {
            Code::Timeout
        },
        message: "no arm is connected; ConnectDobot comes first".to_owned(),
    })
}

impl Session {
    /// Whether a command may be sent: a dangerous one must have been allowed.
    ///
    /// # Errors
    /// [`Code::InvalidParams`].
    pub(crate) fn permit(&self, row: &Row) -> Outcome {
        if row.dangerous && std::env::var_os("MAGICIAN_ALLOW").is_none() {
            return Err(Fault::invalid("dangerous; MAGICIAN_ALLOW allows it"));
        }
        Ok(())
    }

    /// As [`magician::blocking::Arm::set`], but dangerous commands must have been allowed.
    pub(crate) fn set<T: Writable>(&self, value: &T) -> Outcome {
        self.permit(T::ROW)?;
        Ok(self.arm.set(value)?)
    }

    /// As [`magician::blocking::Arm::enqueue`].
    pub(crate) fn enqueue<T>(&self, value: &T) -> Result<QueueIndex, Fault>
    where
        T: Queueable + Copy + Into<Set>,
    {
        Ok(self.arm.enqueue(value)?)
    }
}

impl Deref for Session {
    type Target = blocking::Arm;

    fn deref(&self) -> &Self::Target {
        &self.arm
    }
}
