//! Virtual arms of this process.

use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use magician::sim::{Controller, Profile};
use magician::{SimSpeed, VirtualArm};

use super::registry::lock;

/// Pool of virtual arms. They live as long as the process, so that a new connection finds the arm
/// as the last one left it.
#[derive(Debug, Default)]
pub(super) struct Pool(Mutex<Vec<Member>>);

#[derive(Debug)]
struct Member {
    speed: SimSpeed,
    arm: VirtualArm,
    taken: Arc<AtomicBool>,
}

/// Exclusive use of a virtual arm, until dropped.
#[derive(Debug)]
pub(super) struct Lease {
    pub(super) arm: VirtualArm,
    taken: Arc<AtomicBool>,
}

impl Pool {
    /// Takes a free arm of this speed, or creates one.
    pub(super) fn take(&self, speed: SimSpeed) -> Lease {
        let mut members = lock(&self.0);
        let free = members
            .iter()
            .find(|member| member.speed == speed && !member.taken.swap(true, Ordering::SeqCst));
        if let Some(member) = free {
            return Lease {
                arm: member.arm.clone(),
                taken: Arc::clone(&member.taken),
            };
        }
        let arm = VirtualArm::new(Controller::new(Profile::default()), speed);
        let taken = Arc::new(AtomicBool::new(true));
        members.push(Member {
            speed,
            arm: arm.clone(),
            taken: Arc::clone(&taken),
        });
        Lease { arm, taken }
    }
}

impl Drop for Lease {
    fn drop(&mut self) {
        self.taken.store(false, Ordering::SeqCst);
    }
}
