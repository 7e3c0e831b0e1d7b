//! Texts (LB): until they are drawn, what they say is told.

use super::lexer::Instruction;
use super::plotter::Plotter;
use crate::DiagnosticCode;

/// As many texts are quoted, and as many characters of each.
const QUOTED: usize = 5;
const LONGEST: usize = 40;

/// The texts that were left out.
#[derive(Debug, Default)]
pub(super) struct Texts {
    first: Option<crate::Origin>,
    quoted: Vec<String>,
    more: usize,
}

impl Plotter<'_> {
    pub(super) fn text(&mut self, instruction: &Instruction) {
        let text: String = instruction
            .text
            .chars()
            .map(|sign| if sign.is_control() { ' ' } else { sign })
            .collect();
        let text = text.trim();
        if text.is_empty() || self.pen == 0.0 {
            return;
        }
        let origin = self.lines.origin(instruction.range.clone());
        self.texts.first.get_or_insert(origin);
        let quote = match text.char_indices().nth(LONGEST) {
            Some((end, _)) => format!("{:?}..", text.get(..end).unwrap_or_default()),
            None => format!("{text:?}"),
        };
        if self.texts.quoted.contains(&quote) {
            return;
        }
        if self.texts.quoted.len() < QUOTED {
            self.texts.quoted.push(quote);
        } else {
            self.texts.more += 1;
        }
    }

    /// One note for all of them.
    pub(super) fn tell_texts(&mut self) {
        let Some(first) = self.texts.first else {
            return;
        };
        let more = match self.texts.more {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let message = format!(
            "text (LB) is left out: {}{more}",
            self.texts.quoted.join(", ")
        );
        let help = "export the plot with its text as lines";
        self.notes
            .add_with(DiagnosticCode::LeftOut, first, &message, |note| {
                note.help(help)
            });
    }
}
