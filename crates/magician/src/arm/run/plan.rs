//! What a run knows of its commands before it sends them.

use magician_protocol::Set;

use super::Run;
use crate::Result;
use crate::arm::driver::micros;
use crate::stream::Item;
use crate::words::{Guards, Preflight};

/// So few are in the arm whatever they take: their times are of no use.
const ALWAYS: usize = 2;
/// So many are looked at beforehand, to read only what they depend on.
const AHEAD: usize = 32;

/// A command that waits.
#[derive(Debug)]
pub(super) enum Planned {
    /// From the caller.
    Fresh(Set),
    /// Given back by the task, with what was known of it.
    Item(Item),
}

impl<C: Iterator<Item = Set>> Run<C> {
    /// Reads what the times of the commands depend on, unless they are too few to matter.
    pub(super) async fn plan(&mut self) -> Result<()> {
        if std::mem::replace(&mut self.planned, true) {
            if self.pending.is_empty() {
                self.look_ahead(1);
            }
            return Ok(());
        }
        self.look_ahead(AHEAD);
        if self.pending.len() <= ALWAYS {
            return Ok(());
        }
        let course = match self.pending.len() < AHEAD {
            true => {
                let all: Vec<Set> = self.pending.iter().map(Planned::command).collect();
                self.arm.preflight_for(&all).await?
            }
            false => self.arm.preflight().await?,
        };
        self.course = Some(course.guards(Guards::NONE));
        Ok(())
    }

    fn look_ahead(&mut self, count: usize) {
        while self.pending.len() < count
            && let Some(command) = self.commands.next()
        {
            self.pending.push_back(Planned::Fresh(command));
        }
    }

    pub(super) fn next(&mut self) -> Option<Item> {
        let planned = self.pending.pop_front();
        match planned.or_else(|| self.commands.next().map(Planned::Fresh))? {
            Planned::Item(item) => Some(item),
            Planned::Fresh(command) => Some(item(self.course.as_mut(), command)),
        }
    }
}

impl Planned {
    pub(super) fn command(&self) -> Set {
        match self {
            Self::Fresh(command) => *command,
            Self::Item(item) => item.command,
        }
    }
}

/// What is known of a command beforehand.
fn item(course: Option<&mut Preflight>, command: Set) -> Item {
    let unknown = Item {
        command,
        time: u64::MAX,
        end: None,
        laser: true,
    };
    let Some(Ok(step)) = course.map(|course| course.check(&command)) else {
        return unknown;
    };
    let pose = step.end.map(|end| end.pose);
    Item {
        command,
        time: micros(step.time),
        end: pose.map(|pose| [pose.x, pose.y, pose.z, pose.r]),
        laser: step.laser,
    }
}
