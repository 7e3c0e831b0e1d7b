//! Blocks that a plan cannot contain, with the reason.

use magician_host::message;

use super::tree::Block;
use crate::Diagnostic;

/// Reason why a block cannot be in a plan.
#[derive(Clone, Copy)]
enum Reason {
    /// The value comes from the arm while it runs.
    Sensor,
    /// The value comes from the clock or from chance.
    Clock,
    /// A block for the M1.
    OtherArm,
    /// A block of DobotLab.
    Lab,
    /// A block for a MagicBox or one of its modules.
    MagicBox,
}

const REFUSED_BLOCKS: [(&str, Reason); 20] = [
    ("dobot_get_input", Reason::Sensor),
    ("dobot_get_adc", Reason::Sensor),
    ("dobot_getiopwm", Reason::Sensor),
    ("dobot_get_12voutput", Reason::Sensor),
    ("dobot_get_colorseneor", Reason::Sensor),
    ("dobot_GetInfraredSensor", Reason::Sensor),
    ("dobot_time", Reason::Clock),
    ("math_random_int", Reason::Clock),
    ("math_random_float", Reason::Clock),
    ("dobot_SetArmSpeedRatio", Reason::MagicBox),
    ("dobot_GetArmSpeedRatio", Reason::MagicBox),
    ("dobot_SetLSpeedRatio", Reason::MagicBox),
    ("dobot_GetLSpeedRatio", Reason::MagicBox),
    ("dobot_SetServoAngle", Reason::MagicBox),
    ("dobot_set_armori", Reason::OtherArm),
    ("dobot_nonlinear_movement", Reason::OtherArm),
    ("dobot_nonlinear_movement_joint", Reason::OtherArm),
    ("dobot_nonlinear_movement_movj", Reason::OtherArm),
    ("dobot_nonlinear_movement_descartes_movj", Reason::OtherArm),
    ("dobot_linear_movement_movl", Reason::OtherArm),
];

fn reason(kind: &str) -> Option<Reason> {
    let mut known = REFUSED_BLOCKS.iter();
    if let Some((_, reason)) = known.find(|(own, _)| own.eq_ignore_ascii_case(kind)) {
        return Some(*reason);
    }
    let lower = kind.to_ascii_lowercase();
    if lower.starts_with("magician_") || lower.starts_with("dobotlab_") {
        return Some(Reason::Lab);
    }
    if lower.starts_with("magicbox_") || lower.starts_with("magicianlite_") {
        return Some(Reason::MagicBox);
    }
    let robot = lower.starts_with("dobot");
    let has = |part| robot && lower.contains(part);
    if has("seeed") || has("servo") || has("speedratio") {
        return Some(Reason::MagicBox);
    }
    if has("nonlinear_movement") || has("linear_movement") || has("armori") {
        return Some(Reason::OtherArm);
    }
    (has("_get") || has("getpose")).then_some(Reason::Sensor)
}

/// Returns the diagnostic for a block that cannot be in a plan.
pub(super) fn diagnostic(block: &Block) -> Diagnostic {
    let kind = block.kind.as_str();
    let (why, help) = match reason(kind) {
        Some(Reason::Sensor) => (
            message!("asks the arm while it runs, but a plan is made before anything moves"),
            Some(message!(
                "write a program for that, with the Rust library or the Python package"
            )),
        ),
        Some(Reason::Clock) => (
            message!(
                "gives another value each time, but a plan is made once, before anything moves"
            ),
            Some(message!("put a number in its place")),
        ),
        Some(Reason::Lab) => (
            message!("is a block of DobotLab, whose blocks are not read"),
            Some(message!(
                "DobotLab shows its blocks as Python: run that program with the Python package; or \
                build it from the blocks of DobotStudio"
            )),
        ),
        Some(Reason::OtherArm) => (message!("is for the M1, not for the Magician"), None),
        Some(Reason::MagicBox) => (
            message!(
                "is for a MagicBox and its modules, which the Magician's protocol cannot reach"
            ),
            None,
        ),
        None if kind.is_empty() => (message!("has no type"), None),
        None => (message!("is an unknown block"), None),
    };
    let diagnostic = block.diagnostic(message!("'{kind}' {why}", kind, why));
    match help {
        Some(help) => diagnostic.help(help),
        None => diagnostic,
    }
}
