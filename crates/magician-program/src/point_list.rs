//! Plan as a list of points.

use std::fmt::Write as _;

use magician_protocol::Set;
use magician_protocol::commands::{PtpCmd, PtpWithLCmd};

use crate::{Action, Plan, Travel};

/// Returns the steps of a plan as CSV, each with its target point.
#[must_use]
pub fn point_list(plan: &Plan) -> String {
    // The column for rail positions appears only if the program uses a rail.
    let on_rail = plan.uses_rail();
    let mut text = "step,action,x,y,z,r,line,name".to_owned();
    text.push_str(if on_rail { ",l\n" } else { "\n" });
    for (nth, step) in plan.steps.iter().enumerate() {
        let rail = without_rail(&step.action);
        let (action, l) = match &rail {
            Some((action, l)) => (action, l.to_string()),
            None => (&step.action, String::new()),
        };
        let point = action
            .target()
            .map(|point| point.map(|value| value.to_string()));
        let [x, y, z] = point.unwrap_or_default();
        let r = match action {
            Action::Move { to: [.., r], .. } | Action::Arc { to: [.., r], .. } => r.to_string(),
            _ => String::new(),
        };
        let line = match step.origin.line {
            0 => String::new(),
            line => line.to_string(),
        };
        let name = plan.name_of(&step.origin).map(quoted).unwrap_or_default();
        let word = word(action);
        // Writing to a string cannot fail.
        let _ = write!(text, "{},{word},{x},{y},{z},{r},{line},{name}", nth + 1);
        if on_rail {
            let _ = write!(text, ",{l}");
        }
        text.push('\n');
    }
    text
}

/// Splits a move with rail into the same move without it, and the rail position.
fn without_rail(action: &Action) -> Option<(Action, f32)> {
    let Action::Command(command) = action else {
        return None;
    };
    let Set::PtpWithLCmd(ptp) = **command else {
        return None;
    };
    let PtpWithLCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
        l,
    } = ptp;
    let alone = PtpCmd {
        ptp_mode,
        x,
        y,
        z,
        r,
    };
    Some((Action::from(Set::from(alone)), l))
}

fn word(action: &Action) -> &'static str {
    match action {
        Action::Move { by, .. } => match by {
            Travel::Joints => "movj",
            Travel::Line => "movl",
            Travel::Jump => "jump",
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        },
        Action::Joints { .. } => "joints",
        Action::Shift { .. } => "shift",
        Action::Arc { .. } => "arc",
        Action::Path { .. } => "path",
        Action::Burn { .. } => "burn",
        Action::Suction(_) => "suction",
        Action::Gripper(_) => "gripper",
        Action::Laser(_) => "laser",
        Action::Wait(_) => "wait",
        Action::Home => "home",
        Action::Command(command) => command.row().set_name,
        Action::Part(_) | Action::Pause(_) => action.name(),
        #[cfg(not(magician_workspace))]
        _ => unreachable!(),
    }
}

/// Quotes a CSV field if necessary.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
