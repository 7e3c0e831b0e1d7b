//! Evaluation of real values in RS-274: numbers, parameters, bracketed expressions and functions.

use magician_host::{Message, message};

use super::lexer::Words;
use super::parameters::{Key, LAST_PARAMETER};
use crate::formats::span::SpanDiagnostic;

/// Largest nesting depth. It protects the stack of the recursive parser.
const MAX_DEPTH: u32 = 60;
/// Tolerance of comparisons. It absorbs the rounding of computed loop variables.
const EQUALITY_TOLERANCE: f64 = 1e-6;
/// Tolerance for a parameter number to count as whole. It absorbs the rounding of computed numbers.
const WHOLE_TOLERANCE: f64 = 1e-4;

const FUNCTIONS: [&str; 14] = [
    "ABS", "ACOS", "ASIN", "ATAN", "COS", "EXISTS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN",
    "SQRT", "TAN",
];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operator {
    Power,
    Multiply,
    Divide,
    Modulo,
    Add,
    Subtract,
    Equal,
    Unequal,
    Greater,
    GreaterOrEqual,
    Less,
    LessOrEqual,
    And,
    Or,
    Xor,
}

use Operator::{
    Add, And, Divide, Equal, Greater, GreaterOrEqual, Less, LessOrEqual, Modulo, Multiply, Or,
    Power, Subtract, Unequal, Xor,
};

/// Operators as written, longer ones before their prefixes.
const OPERATORS: [(&str, Operator); 15] = [
    ("**", Power),
    ("*", Multiply),
    ("/", Divide),
    ("MOD", Modulo),
    ("+", Add),
    ("-", Subtract),
    ("EQ", Equal),
    ("NE", Unequal),
    ("GT", Greater),
    ("GE", GreaterOrEqual),
    ("LT", Less),
    ("LE", LessOrEqual),
    ("AND", And),
    ("OR", Or),
    ("XOR", Xor),
];

impl Operator {
    /// Precedence; higher binds tighter, equal ones associate to the left.
    fn precedence(self) -> u8 {
        match self {
            Power => 5,
            Multiply | Divide | Modulo => 4,
            Add | Subtract => 3,
            Equal | Unequal | Greater | GreaterOrEqual | Less | LessOrEqual => 2,
            And | Or | Xor => 1,
        }
    }

    fn apply(self, left: f64, right: f64) -> f64 {
        let truth = |holds: bool| f64::from(u8::from(holds));
        let equal = (left - right).abs() < EQUALITY_TOLERANCE;
        let (a, b) = (left != 0.0, right != 0.0);
        match self {
            Power => libm::pow(left, right),
            Multiply => left * right,
            Divide => left / right,
            Modulo => left.rem_euclid(right),
            Add => left + right,
            Subtract => left - right,
            Equal => truth(equal),
            Unequal => truth(!equal),
            Greater => truth(left > right && !equal),
            GreaterOrEqual => truth(left > right || equal),
            Less => truth(left < right && !equal),
            LessOrEqual => truth(left < right || equal),
            And => truth(a && b),
            Or => truth(a || b),
            Xor => truth(a != b),
        }
    }
}

impl Words<'_> {
    /// Parses a real value. `None` without a value at the cursor.
    pub(super) fn value(&mut self) -> Result<Option<f64>, SpanDiagnostic> {
        self.value_at(0)
    }

    fn value_at(&mut self, depth: u32) -> Result<Option<f64>, SpanDiagnostic> {
        let start = self.at;
        if let Some(number) = self.number() {
            return Ok(Some(number));
        }
        self.at = start;
        let mut sign = 1.0;
        while let Some(byte @ (b'+' | b'-')) = self.peek() {
            if byte == b'-' {
                sign = -sign;
            }
            self.at += 1;
            self.skip_blanks();
        }
        if self.at > start
            && let Some(number) = self.number()
        {
            return Ok(Some(sign * number));
        }
        if depth > MAX_DEPTH {
            let message = message!("values are nested more than {most} deep", most = MAX_DEPTH);
            return Err(SpanDiagnostic::new(start..self.at + 1, message));
        }
        let value = match self.peek() {
            Some(b'[') => self.bracket(depth)?,
            Some(b'#') => {
                let start = self.at;
                let key = self.key_at(depth)?;
                let read = self.values.read(&key);
                read.map_err(|message| self.unknown(start, message))?
            }
            Some(byte) if byte.is_ascii_alphabetic() => match self.function(depth)? {
                Some(value) => value,
                None => {
                    self.at = start;
                    return Ok(None);
                }
            },
            _ => {
                self.at = start;
                return Ok(None);
            }
        };
        Ok(Some(sign * value))
    }

    fn unknown(&self, start: usize, message: Message) -> SpanDiagnostic {
        let help = message!("export the file with plain numbers, or set it in the file");
        SpanDiagnostic::new(start..self.at, message).help(help)
    }

    /// Parses `#` and the parameter after it.
    pub(super) fn key(&mut self) -> Result<Key, SpanDiagnostic> {
        self.key_at(0)
    }

    fn key_at(&mut self, depth: u32) -> Result<Key, SpanDiagnostic> {
        let start = self.at;
        self.at += 1;
        self.skip_blanks();
        if self.peek() == Some(b'<') {
            return self.name().map(Key::Name);
        }
        let Some(number) = self.value_at(depth + 1)? else {
            let message = message!("# has no parameter number or name");
            return Err(SpanDiagnostic::new(start..start + 1, message));
        };
        let whole = number.round();
        if (number - whole).abs() < WHOLE_TOLERANCE
            && (1.0..=f64::from(LAST_PARAMETER)).contains(&whole)
        {
            return Ok(Key::Number(whole as u16));
        }
        let message = message!(
            "unknown parameter #{number}; they are #1 to #{last}",
            number,
            last = LAST_PARAMETER
        );
        Err(SpanDiagnostic::new(start..self.at, message))
    }

    /// Parses a name in angle brackets. Case and blanks are ignored.
    pub(super) fn name(&mut self) -> Result<Box<str>, SpanDiagnostic> {
        let start = self.at;
        let rest = self.line.get(start + 1..).unwrap_or_default();
        let Some(length) = rest.find('>') else {
            return Err(SpanDiagnostic::new(
                start..start + 1,
                message!("a name ends with > on its line"),
            ));
        };
        self.at = start + length + 2;
        let letters = rest.get(..length).unwrap_or_default().chars();
        let letters = letters.filter(|letter| !letter.is_whitespace());
        let name: String = letters.map(|letter| letter.to_ascii_lowercase()).collect();
        if name.is_empty() {
            return Err(SpanDiagnostic::new(
                start..self.at,
                message!("a name has no letters"),
            ));
        }
        Ok(name.into())
    }

    /// Parses a bracketed expression.
    pub(super) fn bracket(&mut self, depth: u32) -> Result<f64, SpanDiagnostic> {
        let start = self.at;
        self.at += 1;
        let value = self.terms(depth, 0)?;
        self.skip_blanks();
        if self.peek() != Some(b']') {
            return Err(SpanDiagnostic::new(
                start..start + 1,
                message!("this bracket is not closed"),
            ));
        }
        self.at += 1;
        Ok(value)
    }

    /// Parses values joined by operators of at least this precedence (precedence climbing).
    fn terms(&mut self, depth: u32, min_precedence: u8) -> Result<f64, SpanDiagnostic> {
        self.skip_blanks();
        let start = self.at;
        let Some(mut left) = self.value_at(depth + 1)? else {
            return Err(SpanDiagnostic::new(
                start..start + 1,
                message!("a value is missing here"),
            ));
        };
        loop {
            self.skip_blanks();
            let before = self.at;
            let Some(operator) = self.operator() else {
                return Ok(left);
            };
            if operator.precedence() < min_precedence {
                self.at = before;
                return Ok(left);
            }
            let right = self.terms(depth, operator.precedence() + 1)?;
            let value = operator.apply(left, right);
            if !value.is_finite() {
                let name = self.line.get(before..before + 1).unwrap_or_default();
                let message = if operator == Divide || operator == Modulo {
                    message!("this divides by 0")
                } else {
                    message!(
                        "this of {left} and {right} is not a number ({name}..)",
                        left,
                        right,
                        name
                    )
                };
                return Err(SpanDiagnostic::new(start..self.at, message));
            }
            left = value;
        }
    }

    fn operator(&mut self) -> Option<Operator> {
        let rest = self.line.as_bytes().get(self.at..)?;
        let (name, operator) = OPERATORS.into_iter().find(|(name, _)| {
            let begin = rest.get(..name.len());
            begin.is_some_and(|begin| begin.eq_ignore_ascii_case(name.as_bytes()))
        })?;
        self.at += name.len();
        Some(operator)
    }

    /// Parses a function call and returns its value. `None` if no known function starts here.
    fn function(&mut self, depth: u32) -> Result<Option<f64>, SpanDiagnostic> {
        let start = self.at;
        self.pass(|byte| byte.is_ascii_alphabetic());
        let name = self.line.get(start..self.at).unwrap_or_default();
        let mut names = FUNCTIONS.into_iter();
        let Some(name) = names.find(|known| known.eq_ignore_ascii_case(name)) else {
            return Ok(None);
        };
        self.skip_blanks();
        if self.peek() != Some(b'[') {
            return Ok(None);
        }
        if name == "EXISTS" {
            return self.exists(start, depth).map(Some);
        }
        let argument = self.bracket(depth + 1)?;
        let value = match name {
            "ABS" => argument.abs(),
            "ACOS" => libm::acos(argument).to_degrees(),
            "ASIN" => libm::asin(argument).to_degrees(),
            "ATAN" => {
                self.skip_blanks();
                let slash = self.at;
                self.at += usize::from(self.peek() == Some(b'/'));
                self.skip_blanks();
                if slash == self.at || self.peek() != Some(b'[') {
                    let message = message!("ATAN takes two values: ATAN[1]/[2]");
                    return Err(SpanDiagnostic::new(start..self.at, message));
                }
                libm::atan2(argument, self.bracket(depth + 1)?).to_degrees()
            }
            "COS" => libm::cos(argument.to_radians()),
            "EXP" => libm::exp(argument),
            "FIX" => argument.floor(),
            "FUP" => argument.ceil(),
            "LN" => libm::log(argument),
            "ROUND" => argument.round(),
            "SIN" => libm::sin(argument.to_radians()),
            "SQRT" => argument.sqrt(),
            // Only TAN is left.
            _ => libm::tan(argument.to_radians()),
        };
        if value.is_finite() {
            Ok(Some(value))
        } else {
            Err(SpanDiagnostic::new(
                start..self.at,
                message!("{name} of {of} is not a number", name, of = argument),
            ))
        }
    }

    /// Evaluates EXISTS. Every numbered parameter exists; a named one exists once it is set.
    fn exists(&mut self, start: usize, depth: u32) -> Result<f64, SpanDiagnostic> {
        self.at += 1;
        self.skip_blanks();
        let mut exists = None;
        if self.peek() == Some(b'#') {
            self.at += 1;
            self.skip_blanks();
            if self.peek() == Some(b'<') {
                let name = self.name()?;
                exists = Some(self.values.exists(&name));
            } else if let Some(number) = self.value_at(depth + 1)? {
                exists = Some((1.0..=f64::from(LAST_PARAMETER)).contains(&number));
            }
        }
        self.skip_blanks();
        match exists.filter(|_| self.peek() == Some(b']')) {
            Some(exists) => {
                self.at += 1;
                Ok(f64::from(u8::from(exists)))
            }
            None => Err(SpanDiagnostic::new(
                start..self.at,
                message!("EXISTS takes a parameter: EXISTS[#<name>]"),
            )),
        }
    }
}
