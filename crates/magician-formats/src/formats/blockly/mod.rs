//! Reader of DobotBlockly workspaces (`.blockly`). The program is executed while the plan is made.
//!
//! Loops, conditions and arithmetic are evaluated, and the blocks of the robot become steps. A
//! block that asks the arm for something while it runs (a sensor, an input) is refused with its
//! kind, id and place, before anything moves. The arm's position is known as far as earlier blocks
//! determine it.
//!
//! * Stacks run one after the other in the order in which Blockly generates code: by their position
//!   on the workspace, from top to bottom.
//! * Disabled blocks are left out. A block in a value input replaces its shadow.
//! * `dobot_goto` keeps the r that an earlier block has set. Before that r is 0, with a note: the
//!   tool may turn, but x, y and z are those of the block.
//! * A program of more than 200,000 executed blocks counts as endless and is refused; so are blocks
//!   nested more than 100 deep.

mod eval;
mod known;
mod machine;
mod refused;
mod robot;
mod settings;
mod tree;
mod value;

use super::{Content, Parsed, ReadOptions};
use crate::Diagnostic;
use crate::encoding::{Fallback, decode};

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let decoded = decode(bytes, Fallback::Western)?;
    let tree = tree::Tree::read(&decoded.text)?;
    let Parsed {
        content: mut plan,
        mut notes,
    } = machine::Machine::run(&tree)?;
    notes.extend(decoded.note);
    plan.title.clone_from(&options.title);
    Ok(Parsed {
        content: Content::Plan(plan),
        notes,
    })
}
