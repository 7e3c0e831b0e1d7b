//! Values of blocks and their arithmetic, as in the Python that the studio generates.

/// Value of a block.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum BlockValue {
    Number(f64),
    Truth(bool),
    Text(String),
}

impl BlockValue {
    /// Returns the number; a boolean counts as 1 or 0. `None` for text.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Truth(truth) => Some(f64::from(u8::from(*truth))),
            Self::Text(_) => None,
        }
    }

    pub(super) fn is_true(&self) -> bool {
        match self {
            Self::Number(number) => *number != 0.0,
            Self::Truth(truth) => *truth,
            Self::Text(text) => !text.is_empty(),
        }
    }

    pub(super) fn to_text(&self) -> String {
        match self {
            Self::Number(number) => number.to_string(),
            Self::Truth(truth) => truth.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

pub(super) fn compare(operator: &str, a: &BlockValue, b: &BlockValue) -> Option<bool> {
    let same = || match (a.number(), b.number()) {
        (Some(a), Some(b)) => a == b,
        _ => a == b,
    };
    let order = || match (a, b) {
        (BlockValue::Text(a), BlockValue::Text(b)) => Some(a.cmp(b)),
        _ => a.number()?.partial_cmp(&b.number()?),
    };
    Some(match operator {
        "EQ" => same(),
        "NEQ" => !same(),
        "LT" => order()?.is_lt(),
        "LTE" => order()?.is_le(),
        "GT" => order()?.is_gt(),
        "GTE" => order()?.is_ge(),
        _ => return None,
    })
}

pub(super) fn arithmetic(operator: &str, a: f64, b: f64) -> Option<f64> {
    Some(match operator {
        "ADD" => a + b,
        "MINUS" => a - b,
        "MULTIPLY" => a * b,
        "DIVIDE" => a / b,
        "POWER" => libm::pow(a, b),
        _ => return None,
    })
}

/// Applies a function of one number; angles are in degrees.
pub(super) fn function(operator: &str, a: f64) -> Option<f64> {
    Some(match operator {
        "ROOT" => a.sqrt(),
        "ABS" => a.abs(),
        "NEG" => -a,
        "LN" => libm::log(a),
        "LOG10" => libm::log10(a),
        "EXP" => libm::exp(a),
        "POW10" => libm::pow(10.0_f64, a),
        "ROUND" => a.round_ties_even(),
        "ROUNDUP" => a.ceil(),
        "ROUNDDOWN" => a.floor(),
        "SIN" => libm::sin(a.to_radians()),
        "COS" => libm::cos(a.to_radians()),
        "TAN" => libm::tan(a.to_radians()),
        "ASIN" => libm::asin(a).to_degrees(),
        "ACOS" => libm::acos(a).to_degrees(),
        "ATAN" => libm::atan(a).to_degrees(),
        _ => return None,
    })
}

/// Remainder with the sign of the divisor, as in Python.
pub(super) fn modulo(a: f64, b: f64) -> f64 {
    let left = a % b;
    if left != 0.0 && (left < 0.0) != (b < 0.0) {
        left + b
    } else {
        left
    }
}

pub(super) fn constant(name: &str) -> Option<f64> {
    use std::f64::consts;
    Some(match name {
        "PI" => consts::PI,
        "E" => consts::E,
        "GOLDEN_RATIO" => (1.0 + 5.0_f64.sqrt()) / 2.0,
        "SQRT2" => consts::SQRT_2,
        "SQRT1_2" => consts::FRAC_1_SQRT_2,
        _ => return None,
    })
}
