//! Translates keys into actions. Carries out none of them.

use magician_sim::world::Press;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::terminal::Help;

/// Mode of the keyboard.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Mode {
    /// Keys act at once.
    Watch,
    /// The list of keys is shown.
    Help(Help),
    /// A line is being typed.
    Ask {
        /// Question that the line answers.
        question: Question,
        /// Text typed so far.
        text: String,
    },
    /// An input is being selected and driven.
    Inputs {
        /// Address of the input, 1 to 20.
        address: u8,
        /// True if the last key was a digit of the address.
        typed: bool,
    },
}

/// Question answered by a typed line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Question {
    /// Code of an alarm to raise.
    Alarm,
    /// Joint that slips, and the angle.
    Slip,
}

/// Push by hand over a small distance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Nudge {
    pub(super) axis: Axis,
    pub(super) forward: bool,
}

/// Direction of a push.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Axis {
    /// Towards the right of the screen, as seen from above.
    Right,
    /// Towards the top of the screen, as seen from above.
    Ahead,
    Z,
    /// Around the selected joint.
    Joint,
}

/// Action of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Nothing,
    Quit,
    Interrupt,
    Redraw,
    Help,
    /// Turn the page of the list of keys, or close it.
    Page(KeyCode),
    /// Turn the view.
    View,
    /// Return to watching.
    Leave,
    /// Show the arm this many places further.
    Turn(isize),
    Press(Press),
    Unlock,
    /// Switch between fine and coarse pushes.
    Fine,
    /// Select the joint for [`Axis::Joint`], 1 to 4.
    Joint(u8),
    Nudge(Nudge),
    Cable,
    Reset,
    Ask(Question),
    Type(char),
    Erase,
    Answer,
    Inputs,
    /// Select the input this many places further.
    Step(i8),
    /// Digit of an input's address.
    Digit(u8),
    Toggle,
}

/// Returns the action of a key in a mode. `unlocked` is true while a hand guides the arm.
pub(super) fn action(mode: &Mode, is_unlocked: bool, key: KeyEvent) -> Action {
    if key.kind == KeyEventKind::Release {
        return Action::Nothing;
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return match key.code {
            KeyCode::Char('c') => Action::Interrupt,
            KeyCode::Char('l') => Action::Redraw,
            _ => Action::Nothing,
        };
    }
    match mode {
        Mode::Help(_) => Action::Page(key.code),
        Mode::Ask { .. } => answering(key.code),
        Mode::Inputs { .. } => inputs(key.code),
        Mode::Watch => match guiding(key.code).filter(|_| is_unlocked) {
            Some(action) => action,
            None => watching(key.code),
        },
    }
}

fn watching(code: KeyCode) -> Action {
    match code {
        KeyCode::Char('q') => Action::Quit,
        KeyCode::Char('?' | 'h') | KeyCode::F(1) => Action::Help,
        KeyCode::Char(' ' | 'k') => Action::Press(Press::Short),
        KeyCode::Char('K') => Action::Press(Press::Long),
        KeyCode::Char('u') => Action::Unlock,
        KeyCode::Char('p') => Action::Cable,
        KeyCode::Char('r') => Action::Reset,
        KeyCode::Char('a') => Action::Ask(Question::Alarm),
        KeyCode::Char('s') => Action::Ask(Question::Slip),
        KeyCode::Char('i') => Action::Inputs,
        KeyCode::Char('V') => Action::View,
        KeyCode::Tab => Action::Turn(1),
        KeyCode::BackTab => Action::Turn(-1),
        _ => Action::Nothing,
    }
}

/// Returns the action of a key that has a meaning only while a hand guides the arm.
fn guiding(code: KeyCode) -> Option<Action> {
    let nudge = |axis, forward| Action::Nudge(Nudge { axis, forward });
    Some(match code {
        KeyCode::Up => nudge(Axis::Ahead, true),
        KeyCode::Down => nudge(Axis::Ahead, false),
        KeyCode::Left => nudge(Axis::Right, false),
        KeyCode::Right => nudge(Axis::Right, true),
        KeyCode::PageUp => nudge(Axis::Z, true),
        KeyCode::PageDown => nudge(Axis::Z, false),
        KeyCode::Char('+' | '=') => nudge(Axis::Joint, true),
        KeyCode::Char('-') => nudge(Axis::Joint, false),
        KeyCode::Char('1') => Action::Joint(1),
        KeyCode::Char('2') => Action::Joint(2),
        KeyCode::Char('3') => Action::Joint(3),
        KeyCode::Char('4') => Action::Joint(4),
        KeyCode::Char('f') => Action::Fine,
        KeyCode::Esc => Action::Unlock,
        _ => return None,
    })
}

fn answering(code: KeyCode) -> Action {
    match code {
        KeyCode::Char(typed) => Action::Type(typed),
        KeyCode::Backspace => Action::Erase,
        KeyCode::Enter => Action::Answer,
        KeyCode::Esc => Action::Leave,
        _ => Action::Nothing,
    }
}

fn inputs(code: KeyCode) -> Action {
    match code {
        KeyCode::Char('q') => Action::Quit,
        KeyCode::Up | KeyCode::Left => Action::Step(-1),
        KeyCode::Down | KeyCode::Right => Action::Step(1),
        KeyCode::Char(' ') | KeyCode::Enter => Action::Toggle,
        KeyCode::Char('i') | KeyCode::Esc => Action::Leave,
        KeyCode::Char(digit) => match digit.to_digit(10).and_then(|d| u8::try_from(d).ok()) {
            Some(digit) => Action::Digit(digit),
            None => Action::Nothing,
        },
        _ => Action::Nothing,
    }
}

/// Returns the address `by` places further, wrapping around.
pub(super) fn stepped(address: u8, by: i8) -> u8 {
    let place = i16::from(address) - 1 + i16::from(by);
    u8::try_from(place.rem_euclid(20) + 1).unwrap_or(1)
}

/// Returns the address after a digit: a two-digit address if the previous key was its first digit
/// and the address exists, otherwise the digit alone.
pub(super) fn with_digit(address: u8, typed: bool, digit: u8) -> u8 {
    let two = address.saturating_mul(10).saturating_add(digit);
    match (two, digit) {
        (10..=20, _) if typed => two,
        (_, 1..=9) => digit,
        _ => address,
    }
}

/// Parses an alarm's code: hexadecimal, with or without `0x`.
pub(super) fn alarm(text: &str) -> Option<u8> {
    let text = text.trim();
    let digits = text.strip_prefix("0x").or(text.strip_prefix("0X"));
    let digits = digits.unwrap_or(text);
    let plain = digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    u8::from_str_radix(digits, 16).ok().filter(|_| plain)
}

/// Parses a slip: joint and degrees.
pub(super) fn slip(text: &str) -> Option<(u8, f64)> {
    let text = text.trim().trim_start_matches(['J', 'j']);
    let (joint, degrees) = text.split_once(char::is_whitespace)?;
    let joint = joint.parse().ok().filter(|joint| (1..=4).contains(joint))?;
    let degrees = degrees.trim().parse().ok();
    let degrees = degrees.filter(|degrees: &f64| degrees.abs() <= 360.0)?;
    Some((joint, degrees))
}

#[cfg(test)]
mod tests {
    use super::*;

    const INPUTS: Mode = Mode::Inputs {
        address: 1,
        typed: false,
    };

    fn press(mode: &Mode, is_unlocked: bool, code: KeyCode) -> Action {
        action(mode, is_unlocked, KeyEvent::new(code, KeyModifiers::NONE))
    }

    #[test]
    fn keys_act_at_once_while_watching() {
        for (key, wanted) in [
            ('q', Action::Quit),
            ('?', Action::Help),
            (' ', Action::Press(Press::Short)),
            ('k', Action::Press(Press::Short)),
            ('K', Action::Press(Press::Long)),
            ('u', Action::Unlock),
            ('p', Action::Cable),
            ('r', Action::Reset),
            ('a', Action::Ask(Question::Alarm)),
            ('s', Action::Ask(Question::Slip)),
            ('i', Action::Inputs),
            ('c', Action::Nothing),
            ('+', Action::Nothing),
        ] {
            let got = press(&Mode::Watch, false, KeyCode::Char(key));
            assert_eq!(got, wanted, "{key}");
        }
        assert_eq!(press(&Mode::Watch, false, KeyCode::Up), Action::Nothing);
        assert_eq!(press(&Mode::Watch, false, KeyCode::Tab), Action::Turn(1));
    }

    #[test]
    fn unlocked_arm_has_additional_keys() {
        let nudge = |axis, forward| Action::Nudge(Nudge { axis, forward });
        for (code, wanted) in [
            (KeyCode::Up, nudge(Axis::Ahead, true)),
            (KeyCode::Left, nudge(Axis::Right, false)),
            (KeyCode::PageDown, nudge(Axis::Z, false)),
            (KeyCode::Char('3'), Action::Joint(3)),
            (KeyCode::Char('-'), nudge(Axis::Joint, false)),
            (KeyCode::Char('f'), Action::Fine),
            (KeyCode::Char('u'), Action::Unlock),
            (KeyCode::Char('q'), Action::Quit),
            (KeyCode::Char('5'), Action::Nothing),
        ] {
            assert_eq!(press(&Mode::Watch, true, code), wanted, "{code:?}");
        }
    }

    #[test]
    fn typed_text_is_no_command() {
        let text = String::new();
        let question = Question::Alarm;
        let mode = Mode::Ask { question, text };
        for key in ['q', 'a', ' ', '?'] {
            assert_eq!(press(&mode, true, KeyCode::Char(key)), Action::Type(key));
        }
        assert_eq!(press(&mode, false, KeyCode::Esc), Action::Leave);
        assert_eq!(press(&mode, false, KeyCode::Enter), Action::Answer);
    }

    #[test]
    fn ctrl_c_interrupts_in_every_mode() {
        let key = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        let text = String::new();
        let question = Question::Slip;
        let ask = Mode::Ask { question, text };
        for mode in [Mode::Watch, Mode::Help(Help::default()), ask, INPUTS] {
            assert_eq!(action(&mode, false, key), Action::Interrupt);
        }
        let released = KeyEvent::new_with_kind(key.code, key.modifiers, KeyEventKind::Release);
        assert_eq!(action(&Mode::Watch, false, released), Action::Nothing);
    }

    #[test]
    fn inputs_are_chosen_by_digits_and_arrows() {
        let mode = INPUTS;
        assert_eq!(press(&mode, false, KeyCode::Down), Action::Step(1));
        assert_eq!(press(&mode, true, KeyCode::Char('4')), Action::Digit(4));
        assert_eq!(press(&mode, false, KeyCode::Enter), Action::Toggle);
        assert_eq!((stepped(20, 1), stepped(1, -1), stepped(5, 1)), (1, 20, 6));
        let typed = |digits: &[u8]| {
            let type_one = |(at, typed), digit: &u8| (with_digit(at, typed, *digit), true);
            digits.iter().fold((1, false), type_one).0
        };
        for (digits, wanted) in [
            (&[1, 5][..], 15),
            (&[5], 5),
            (&[2, 0], 20),
            (&[2, 1], 1),
            (&[9], 9),
            (&[0], 1),
            (&[1, 0, 5], 5),
        ] {
            assert_eq!(typed(digits), wanted, "{digits:?}");
        }
    }

    #[test]
    fn codes_are_hexadecimal_and_slips_have_two_numbers() {
        for (text, wanted) in [
            ("12", Some(0x12)),
            ("0x4a", Some(0x4A)),
            (" 0X00 ", Some(0)),
            ("", None),
            ("0x", None),
            ("+1", None),
            ("100", None),
            ("zz", None),
        ] {
            assert_eq!(alarm(text), wanted, "{text:?}");
        }
        for (text, wanted) in [
            ("2 8", Some((2, 8.0))),
            ("J3 -1.5", Some((3, -1.5))),
            (" 1  360 ", Some((1, 360.0))),
            ("5 1", None),
            ("2", None),
            ("2 nan", None),
            ("2 inf", None),
            ("2 361", None),
        ] {
            assert_eq!(slip(text), wanted, "{text:?}");
        }
    }
}
