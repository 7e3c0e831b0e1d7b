//! DobotBlockly workspaces (`.blockly`), run when the plan is made.
//!
//! Loops, conditions and sums are followed then, and what the robot's blocks say becomes steps; so whatever a program asks the
//! arm while it runs, a sensor or an input, is refused with the block's kind, id and place, before anything moves. Where the arm
//! is, is known as far as the blocks before tell.
//!
//! * Stacks run one after the other in the order in which Blockly makes code of them: by where they begin on the workspace, from
//!   the top to the bottom.
//! * Disabled blocks are left out, a block in a value takes the place of its shadow.
//! * `dobot_goto` keeps r: that of the last block that set it. Before any has, r is taken for 0, with a note: the tool may turn,
//!   its x, y and z are those of the block.
//! * A program that goes on for more than 200,000 blocks counts as one without end, and is refused; so are blocks that are more
//!   than 100 deep in each other.

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
use crate::encoding::{Otherwise, decode};

pub(super) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let decoded = decode(bytes, Otherwise::Western)?;
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
