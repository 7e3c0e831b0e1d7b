//! Execution of the blocks, while the plan is made.

use std::collections::{HashMap, HashSet};

use magician_host::{Message, Setting, SettingValue, message};

use super::known::KnownState;
use super::tree::{Block, Tree};
use super::value::BlockValue;
use crate::{Action, Diagnostic, DiagnosticCode, Parsed, Plan};

/// Largest number of executed blocks. More counts as an endless loop.
pub(super) const MAX_BLOCKS: u32 = 200_000;
/// Largest nesting depth. A stack counts as one level regardless of its length.
pub(super) const MAX_DEPTH: u32 = 100;

/// Outcome of a stack of blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    Next,
    /// Leave the loop.
    Break,
    /// Continue with the next round of the loop.
    Continue,
}

pub(super) struct Machine<'t> {
    pub(super) tree: &'t Tree,
    pub(super) plan: Plan,
    pub(super) notes: Vec<Diagnostic>,
    /// Topics already noted per block.
    noted: HashSet<(usize, &'static str)>,
    variables: HashMap<String, BlockValue>,
    pub(super) course: KnownState,
    steps: u32,
}

impl<'t> Machine<'t> {
    pub(super) fn run(tree: &'t Tree) -> Result<Parsed<Plan>, Diagnostic> {
        let mut machine = Self {
            tree,
            plan: Plan::default(),
            notes: Vec::new(),
            noted: HashSet::new(),
            variables: HashMap::new(),
            course: KnownState::default(),
            steps: 0,
        };
        for block in &tree.blocks {
            machine.plan.name(block.name());
        }
        machine.note_stacks();
        for top in &tree.tops {
            machine.stack(Some(*top), 0)?;
        }
        Ok(Parsed {
            content: machine.plan,
            notes: machine.notes,
        })
    }

    pub(super) fn block(&self, index: usize) -> Result<&'t Block, Diagnostic> {
        let block = self.tree.blocks.get(index);
        block.ok_or_else(|| Diagnostic::of_file(message!("a block is missing")))
    }

    fn note_stacks(&mut self) {
        if let [first, second, ..] = *self.tree.tops.as_slice() {
            let count = self.tree.tops.len();
            let what = message!(
                "the workspace has {count} stacks; they run one after the other, the topmost first",
                count
            );
            self.note(second, "stacks", what);
            self.noted.insert((first, "stacks"));
        }
    }

    /// Adds a note about a block, once per topic.
    pub(super) fn note(&mut self, index: usize, about: &'static str, what: impl Into<Message>) {
        if let Some(block) = self.tree.blocks.get(index)
            && self.noted.insert((index, about))
        {
            self.notes
                .push(block.diagnostic(what).coded(DiagnosticCode::Assumed));
        }
    }

    pub(super) fn push(&mut self, index: usize, action: impl Into<Action>) {
        let origin = self.tree.blocks.get(index).map(|block| block.origin);
        let origin = origin.unwrap_or_default().named(index);
        self.plan.push(action, origin);
    }

    /// Counts an executed block, and refuses a program that does not end.
    pub(super) fn count(&mut self, block: &Block, depth: u32) -> Result<(), Diagnostic> {
        if depth > MAX_DEPTH {
            let message = message!(
                "blocks are nested more than {most} deep here",
                most = MAX_DEPTH
            );
            return Err(block.diagnostic(message));
        }
        self.steps += 1;
        if self.steps > MAX_BLOCKS {
            let message = message!(
                "the program has not ended after {most} blocks",
                most = MAX_BLOCKS
            );
            let help = message!("end its loops");
            return Err(block.diagnostic(message).help(help).remedy(
                (Setting::Loops, SettingValue::Any("N")),
                "repeats all of it",
            ));
        }
        Ok(())
    }

    /// Executes a stack of blocks.
    pub(super) fn stack(&mut self, first: Option<usize>, depth: u32) -> Result<Flow, Diagnostic> {
        let mut next = first;
        while let Some(index) = next {
            let block = self.block(index)?;
            self.count(block, depth)?;
            if !block.disabled {
                let flow = self.statement(index, block, depth)?;
                if flow != Flow::Next {
                    return Ok(flow);
                }
            }
            next = block.next;
        }
        Ok(Flow::Next)
    }

    fn statement(
        &mut self,
        index: usize,
        block: &'t Block,
        depth: u32,
    ) -> Result<Flow, Diagnostic> {
        match block.kind.as_str() {
            "controls_if" => return self.branch(block, depth),
            "controls_for" => self.counted(index, block, depth)?,
            "controls_repeat" | "controls_repeat_ext" => self.repeated(index, block, depth)?,
            "controls_whileUntil" => self.conditional(block, depth)?,
            "controls_flow_statements" => {
                return Ok(match block.field("FLOW") {
                    Some("CONTINUE") => Flow::Continue,
                    _ => Flow::Break,
                });
            }
            "variables_set" => {
                let value = self.value(block, "VALUE", depth)?;
                let value = value.unwrap_or(BlockValue::Number(0.0));
                self.variables.insert(variable(block)?, value);
            }
            "math_change" => {
                let by = self.number(index, block, &["DELTA"], 0.0, depth)?;
                let before = self
                    .variables
                    .get(&variable(block)?)
                    .and_then(BlockValue::number);
                let after = finite(block, before.unwrap_or(0.0) + by)?;
                self.variables.insert(variable(block)?, after);
            }
            "text_print" => {
                let said = self.value(block, "TEXT", depth)?;
                let said = said.map(|value| value.to_text()).unwrap_or_default();
                self.note(index, "print", message!("it prints: {said}", said));
            }
            _ if self.is_value(block) => {
                let what = message!("its value is unused: it is left out");
                self.note(index, "value", what);
            }
            _ => self.robot(index, block, depth)?,
        }
        Ok(Flow::Next)
    }

    fn branch(&mut self, block: &'t Block, depth: u32) -> Result<Flow, Diagnostic> {
        for n in block.numbered_inputs(["IF", "DO"]) {
            let met = self.value(block, &format!("IF{n}"), depth)?;
            if met.is_some_and(|met| met.is_true()) {
                return self.stack(block.input(&format!("DO{n}")), depth + 1);
            }
        }
        self.stack(block.input("ELSE"), depth + 1)
    }

    /// Executes one round of a loop. Returns false after a `break`.
    fn round(&mut self, block: &'t Block, depth: u32) -> Result<bool, Diagnostic> {
        // Counts the loop itself, because an empty loop has no blocks to count.
        self.count(block, depth)?;
        Ok(self.stack(block.input("DO"), depth + 1)? != Flow::Break)
    }

    /// Executes a counted loop between two numbers, both inclusive, up or down. Changes of the
    /// variable in the body do not affect the count.
    fn counted(&mut self, index: usize, block: &'t Block, depth: u32) -> Result<(), Diagnostic> {
        let from = self.number(index, block, &["FROM"], 0.0, depth)?;
        let to = self.number(index, block, &["TO"], 0.0, depth)?;
        let by = self.number(index, block, &["BY"], 1.0, depth)?.abs();
        let name = variable(block)?;
        let by = if from <= to { by } else { -by };
        let within = |at: f64| if from <= to { at <= to } else { at >= to };
        let mut at = from;
        while within(at) {
            self.variables.insert(name.clone(), BlockValue::Number(at));
            if !self.round(block, depth)? {
                break;
            }
            if at + by == at {
                let message = message!("with steps of {by} from {at} it never ends", by, at);
                return Err(block.diagnostic(message));
            }
            at += by;
        }
        Ok(())
    }

    fn repeated(&mut self, index: usize, block: &'t Block, depth: u32) -> Result<(), Diagnostic> {
        let times = self.number(index, block, &["TIMES"], 0.0, depth)?;
        let mut left = times.trunc();
        while left >= 1.0 && self.round(block, depth)? {
            left -= 1.0;
        }
        Ok(())
    }

    fn conditional(&mut self, block: &'t Block, depth: u32) -> Result<(), Diagnostic> {
        let until = block.field("MODE") == Some("UNTIL");
        loop {
            let met = self.value(block, "BOOL", depth)?;
            let met = met.is_some_and(|met| met.is_true());
            if met == until || !self.round(block, depth)? {
                return Ok(());
            }
        }
    }

    pub(super) fn variable(&self, block: &Block) -> Result<BlockValue, Diagnostic> {
        let name = variable(block)?;
        self.variables.get(&name).cloned().ok_or_else(|| {
            block.diagnostic(message!("the variable '{name}' has no value yet", name))
        })
    }
}

fn variable(block: &Block) -> Result<String, Diagnostic> {
    let name = block.field("VAR").filter(|name| !name.is_empty());
    let missing = || {
        block.diagnostic(message!(
            "the block {kind} names no variable",
            kind = block.kind
        ))
    };
    name.map(str::to_owned).ok_or_else(missing)
}

/// Wraps a computed number, unless it is not finite.
pub(super) fn finite(block: &Block, number: f64) -> Result<BlockValue, Diagnostic> {
    if number.is_finite() {
        Ok(BlockValue::Number(number))
    } else {
        Err(block.diagnostic(message!("its result is not a number")))
    }
}
