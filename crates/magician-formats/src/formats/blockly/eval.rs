//! Evaluation of value blocks.

use magician_host::message;

use super::machine::{Machine, finite};
use super::tree::Block;
use super::value::{BlockValue, arithmetic, compare, constant, function, modulo};
use super::{refused, robot};
use crate::Diagnostic;

/// Standard value blocks.
const VALUE_BLOCKS: [&str; 16] = [
    "logic_boolean",
    "logic_compare",
    "logic_negate",
    "logic_operation",
    "logic_ternary",
    "math_arithmetic",
    "math_constant",
    "math_constrain",
    "math_modulo",
    "math_number",
    "math_round",
    "math_single",
    "math_trig",
    "text",
    "variables_get",
    "dobot_get_current_coordinate",
];

impl Machine<'_> {
    pub(super) fn is_value(&self, block: &Block) -> bool {
        VALUE_BLOCKS.contains(&block.kind.as_str()) || block.kind == robot::JOINT_ANGLE
    }

    /// Evaluates the block in an input; `None` if the input is empty.
    pub(super) fn value(
        &mut self,
        block: &Block,
        input: &str,
        depth: u32,
    ) -> Result<Option<BlockValue>, Diagnostic> {
        let Some(index) = block.input(input) else {
            return Ok(None);
        };
        let inner = self.block(index)?;
        // A disabled block generates no code, so the input is as if empty.
        if inner.disabled {
            return Ok(None);
        }
        self.count(inner, depth + 1)?;
        self.evaluate(index, inner, depth + 1).map(Some)
    }

    /// Returns the number in the first of these inputs or fields that the block has. If all are
    /// missing, uses the default of DobotStudio's block, `otherwise`, and adds a note.
    pub(super) fn number(
        &mut self,
        index: usize,
        block: &Block,
        names: &[&'static str],
        otherwise: f64,
        depth: u32,
    ) -> Result<f64, Diagnostic> {
        for name in names {
            if let Some(value) = self.value(block, name, depth)? {
                let number = value.number().filter(|number| number.is_finite());
                return number.ok_or_else(|| {
                    let said = value.to_text();
                    block.diagnostic(message!(
                        "{name} of {kind} is '{said}', not a number",
                        name,
                        kind = block.kind,
                        said
                    ))
                });
            }
            if let Some(text) = block.field(name) {
                return field_number(block, name, text);
            }
        }
        let name = names.first().copied().unwrap_or_default();
        let what = message!(
            "{kind} has no {name}: {otherwise} is used",
            kind = block.kind,
            name,
            otherwise
        );
        self.note(index, name, what);
        Ok(otherwise)
    }

    /// Returns an operand of a standard block. A missing one is 0, as in Blockly, without a note.
    fn operand(&mut self, block: &Block, name: &str, depth: u32) -> Result<f64, Diagnostic> {
        let Some(value) = self.value(block, name, depth)? else {
            return Ok(0.0);
        };
        value.number().ok_or_else(|| {
            let said = value.to_text();
            block.diagnostic(message!(
                "{kind} computes with '{said}', not a number",
                kind = block.kind,
                said
            ))
        })
    }

    fn truth(&mut self, block: &Block, name: &str, depth: u32) -> Result<Option<bool>, Diagnostic> {
        Ok(self.value(block, name, depth)?.map(|value| value.is_true()))
    }

    fn evaluate(
        &mut self,
        index: usize,
        block: &Block,
        depth: u32,
    ) -> Result<BlockValue, Diagnostic> {
        let operator = block.field("OP").unwrap_or_default();
        let unknown = || {
            let message = message!(
                "{kind} has an unknown operator: '{operator}'",
                kind = block.kind,
                operator
            );
            block.diagnostic(message)
        };
        let number = match block.kind.as_str() {
            "math_number" => {
                let text = block.field("NUM").unwrap_or_default();
                field_number(block, "NUM", text)?
            }
            "math_arithmetic" => {
                let a = self.operand(block, "A", depth)?;
                let b = self.operand(block, "B", depth)?;
                arithmetic(operator, a, b).ok_or_else(unknown)?
            }
            "math_single" | "math_round" | "math_trig" => {
                let a = self.operand(block, "NUM", depth)?;
                function(operator, a).ok_or_else(unknown)?
            }
            "math_modulo" => {
                let a = self.operand(block, "DIVIDEND", depth)?;
                modulo(a, self.operand(block, "DIVISOR", depth)?)
            }
            "math_constrain" => {
                let low = self.operand(block, "LOW", depth)?;
                let high = self.operand(block, "HIGH", depth)?;
                self.operand(block, "VALUE", depth)?.max(low).min(high)
            }
            "math_constant" => {
                let name = block.field("CONSTANT").unwrap_or_default();
                constant(name).unwrap_or(f64::INFINITY)
            }
            "logic_boolean" => return Ok(BlockValue::Truth(block.field("BOOL") == Some("TRUE"))),
            "logic_negate" => {
                let truth = self.truth(block, "BOOL", depth)?;
                // Like the code that Blockly generates: a missing operand counts as true before the
                // negation.
                return Ok(BlockValue::Truth(!truth.unwrap_or(true)));
            }
            "logic_compare" => {
                let zero = BlockValue::Number(0.0);
                let a = self.value(block, "A", depth)?.unwrap_or(zero.clone());
                let b = self.value(block, "B", depth)?.unwrap_or(zero);
                let incomparable = || {
                    let (a, b) = (a.to_text(), b.to_text());
                    block.diagnostic(message!(
                        "{operator} cannot compare '{a}' with '{b}'",
                        operator,
                        a,
                        b
                    ))
                };
                return compare(operator, &a, &b)
                    .ok_or_else(incomparable)
                    .map(BlockValue::Truth);
            }
            "logic_operation" => return self.operation(block, operator, depth),
            "logic_ternary" => {
                let condition = self.truth(block, "IF", depth)?.unwrap_or(false);
                let branch = if condition { "THEN" } else { "ELSE" };
                let value = self.value(block, branch, depth)?;
                let missing = || block.diagnostic(message!("it has no {what}", what = branch));
                return value.ok_or_else(missing);
            }
            "text" => {
                let text = block.field("TEXT").unwrap_or_default();
                return Ok(BlockValue::Text(text.to_owned()));
            }
            "variables_get" => return self.variable(block),
            "dobot_get_current_coordinate" | robot::JOINT_ANGLE => {
                self.reading(index, block, depth)?
            }
            _ => return Err(refused::diagnostic(block)),
        };
        finite(block, number)
    }

    /// Evaluates AND or OR with short-circuiting. A missing operand is ignored.
    fn operation(
        &mut self,
        block: &Block,
        operator: &str,
        depth: u32,
    ) -> Result<BlockValue, Diagnostic> {
        let all = match operator {
            "AND" => true,
            "OR" => false,
            _ => {
                let message = message!("'{operator}' is neither AND nor OR", operator);
                return Err(block.diagnostic(message));
            }
        };
        let (a, b) = (block.input("A"), block.input("B"));
        if a.is_none() && b.is_none() {
            return Ok(BlockValue::Truth(false));
        }
        // Short-circuit: the second operand is not evaluated, so it may be a block that is refused.
        if self.truth(block, "A", depth)?.unwrap_or(all) != all {
            return Ok(BlockValue::Truth(!all));
        }
        let b = self.truth(block, "B", depth)?;
        Ok(BlockValue::Truth(b.unwrap_or(all)))
    }
}

fn field_number(block: &Block, name: &str, text: &str) -> Result<f64, Diagnostic> {
    let number = text.trim().parse::<f64>().ok();
    number.filter(|number| number.is_finite()).ok_or_else(|| {
        let message = message!(
            "{name} of {kind} is '{text}', which is not a number",
            name,
            kind = block.kind,
            text
        );
        block.diagnostic(message)
    })
}
