//! Jog pad: translates keys into orders and holds what the pad shows. It carries out nothing
//! itself.

use std::time::Duration;

use magician_job::jog::{
    Activity, Axis, JogDirection, JogFrame, JogMode, OrderDone, Pendant, PendantOrder,
};
use magician_motion::TopView;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::wording;
use crate::terminal::Help;

/// Question to be answered with `y` before the order is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Question {
    Home,
    Laser,
}

impl Question {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Home => "home: the base turns to its end and back, half a minute. Way clear? y/n",
            Self::Laser => "switch the laser on: is everyone wearing goggles? y/n",
        }
    }
}

/// Severity of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    Plain,
    Bad,
}

/// Effect of a key.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum KeyEffect {
    /// No further effect.
    Nothing,
    /// Order for the arm.
    Order(PendantOrder),
    Quit,
    /// Ctrl-C.
    Interrupt,
    /// Not a key of the pad.
    Unknown,
}

impl KeyEffect {
    fn of(order: Option<PendantOrder>) -> Self {
        order.map_or(Self::Nothing, Self::Order)
    }
}

/// Pendant on a terminal.
#[derive(Clone, Debug)]
pub(crate) struct Pad {
    pub(crate) pendant: Pendant,
    pub(crate) question: Option<Question>,
    /// List of keys while it is shown.
    pub(crate) help: Option<Help>,
    /// Direction from which the user sees the arm: arrow keys move the tool where they point.
    pub(crate) view: TopView,
    pub(crate) message: Option<(Tone, String)>,
    /// Last refused move with the reason.
    pub(crate) refusal: Option<String>,
}

impl Pad {
    pub(crate) fn new(mut pendant: Pendant) -> Self {
        // Windows consoles always report key releases; other terminals show it with the first
        // release.
        pendant.hold.set_reports_releases(cfg!(windows));
        Self {
            pendant,
            question: None,
            help: None,
            view: TopView::BEHIND,
            message: None,
            refusal: None,
        }
    }

    /// Returns the effect of a key.
    pub(crate) fn key(&mut self, key: KeyEvent, now: Duration) -> KeyEffect {
        let pressed = key.kind != KeyEventKind::Release;
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return match key.code {
                KeyCode::Char('c') if pressed => KeyEffect::Interrupt,
                _ => KeyEffect::Unknown,
            };
        }
        let direction = self.direction(key.code);
        // Before all other uses of a key: a held jog must end even if a question has appeared
        // meanwhile.
        if !pressed {
            return KeyEffect::of(self.pendant.release(direction));
        }
        // Space stops the arm in every state of the pad.
        if key.code == KeyCode::Char(' ') {
            return self.stop();
        }
        if let Some(help) = self.help {
            self.help = help.after(key.code);
            return KeyEffect::Nothing;
        }
        // Any key answers the question, and only y agrees.
        if let Some(question) = self.question.take() {
            return self.answer(question, key.code);
        }
        self.message = None;
        if let Some(direction) = direction {
            return self.go(direction, key.kind, now);
        }
        self.other(key.code)
    }

    /// Handles a beat: a held jog continues, or ends if the key has not been seen held for too
    /// long.
    pub(crate) fn beat(&mut self, now: Duration) -> KeyEffect {
        KeyEffect::of(self.pendant.tick(now))
    }

    /// Handles the loss of the focus: a held jog ends.
    pub(crate) fn focus_lost(&mut self) -> KeyEffect {
        KeyEffect::of(self.pendant.release_all())
    }

    /// Handles the completion of an order.
    pub(crate) fn done(&mut self, done: &OrderDone) {
        self.pendant.done(done);
        let failure = match &done.outcome {
            Ok(()) => return self.report_done(done.activity),
            Err(error) => wording::failure(error).fact().to_owned(),
        };
        if let Activity::Jog(direction) | Activity::Step(direction) = done.activity {
            self.refusal = Some(format!("{direction}: {failure}"));
        }
        self.say(Tone::Bad, failure);
    }

    fn report_done(&mut self, what: Activity) {
        let text = match what {
            Activity::Stop => "stopped: the arm stands, the queue is empty",
            Activity::Home => "homed",
            Activity::ClearAlarms => "alarms cleared",
            Activity::Tool(tool) => wording::tool(tool),
            Activity::Run => "played",
            Activity::Speed(_) | Activity::Jog(_) | Activity::Step(_) => return,
            #[cfg(not(magician_workspace))]
            _ => unreachable!(),
        };
        self.say(Tone::Plain, text);
    }

    pub(crate) fn say(&mut self, tone: Tone, text: impl Into<String>) {
        self.message = Some((tone, text.into()));
    }

    /// Returns the direction in which a key moves the arm, in the current frame.
    pub(crate) fn direction(&self, code: KeyCode) -> Option<JogDirection> {
        let direction = |axis, forward| Some(JogDirection { axis, forward });
        let (cartesian, joint) = match code {
            KeyCode::Up | KeyCode::Down | KeyCode::Left | KeyCode::Right => {
                return self.arrow(code);
            }
            KeyCode::PageUp | KeyCode::PageDown | KeyCode::Char('w' | 's') => (Axis::Z, Axis::J3),
            KeyCode::Char('a' | 'd') => (Axis::R, Axis::J4),
            KeyCode::Char(']' | '[') if self.pendant.rail => (Axis::L, Axis::L),
            _ => return None,
        };
        let forward = matches!(code, KeyCode::PageUp | KeyCode::Char('w' | 'a' | ']'));
        match self.pendant.frame {
            JogFrame::Cartesian => direction(cartesian, forward),
            JogFrame::Joints => direction(joint, forward),
        }
    }

    /// Returns the direction of an arrow key, as the user sees the arm.
    fn arrow(&self, code: KeyCode) -> Option<JogDirection> {
        let arrow = match code {
            KeyCode::Up => [0.0, 1.0],
            KeyCode::Down => [0.0, -1.0],
            KeyCode::Left => [-1.0, 0.0],
            KeyCode::Right => [1.0, 0.0],
            _ => return None,
        };
        let (axis, forward) = match self.pendant.frame {
            JogFrame::Cartesian => {
                let [x, y] = self.view.unproject(arrow);
                if x.abs() > y.abs() {
                    (Axis::X, x > 0.0)
                } else {
                    (Axis::Y, y > 0.0)
                }
            }
            // Joints have no direction on the ground. Left and right turn the base, which moves the
            // tool sideways for a user behind the arm.
            JogFrame::Joints => match code {
                KeyCode::Up | KeyCode::Down => (Axis::J2, code == KeyCode::Up),
                _ => (Axis::J1, code == KeyCode::Left),
            },
        };
        Some(JogDirection { axis, forward })
    }

    fn go(&mut self, direction: JogDirection, kind: KeyEventKind, now: Duration) -> KeyEffect {
        KeyEffect::of(match kind {
            KeyEventKind::Repeat => self.pendant.repeat(direction, now),
            _ => self.pendant.press(direction, now),
        })
    }

    fn stop(&mut self) -> KeyEffect {
        self.question = None;
        self.help = None;
        self.say(Tone::Plain, "stopping");
        KeyEffect::Order(self.pendant.stop())
    }

    fn answer(&mut self, question: Question, code: KeyCode) -> KeyEffect {
        match (question, code) {
            (Question::Home, KeyCode::Char('y' | 'Y')) => {
                self.say(Tone::Plain, "homing; space stops it");
                KeyEffect::Order(PendantOrder::Home)
            }
            (Question::Laser, KeyCode::Char('y' | 'Y')) => {
                KeyEffect::Order(self.pendant.laser(true))
            }
            _ => KeyEffect::Nothing,
        }
    }

    fn other(&mut self, code: KeyCode) -> KeyEffect {
        match code {
            KeyCode::Char('q') => return KeyEffect::Quit,
            KeyCode::Char('?') | KeyCode::F(1) => self.help = Some(Help::default()),
            KeyCode::Char('V') => {
                // The arrows stand for other axes from now on, so a held jog ends.
                self.view = self.view.turned();
                return self.focus_lost();
            }
            KeyCode::Tab | KeyCode::BackTab => {
                let frame = match self.pendant.frame {
                    JogFrame::Cartesian => JogFrame::Joints,
                    JogFrame::Joints => JogFrame::Cartesian,
                };
                return KeyEffect::of(self.pendant.set_frame(frame));
            }
            KeyCode::Char('m') => {
                let mode = match self.pendant.mode {
                    JogMode::Hold => JogMode::Step,
                    JogMode::Step => JogMode::Hold,
                };
                return KeyEffect::of(self.pendant.set_mode(mode));
            }
            KeyCode::Char('+' | '=') => self.pendant.longer_step(),
            KeyCode::Char('-' | '_') => self.pendant.shorter_step(),
            KeyCode::Char('.' | '>') => return KeyEffect::Order(self.pendant.faster()),
            KeyCode::Char(',' | '<') => return KeyEffect::Order(self.pendant.slower()),
            KeyCode::Char('h') => self.question = Some(Question::Home),
            KeyCode::Char('c') => return KeyEffect::Order(PendantOrder::ClearAlarms),
            KeyCode::Char('p') => return KeyEffect::Order(self.pendant.toggle_suction()),
            KeyCode::Char('g') => return KeyEffect::Order(self.pendant.next_gripper()),
            KeyCode::Char('l') if self.pendant.tools.laser => {
                return KeyEffect::Order(self.pendant.laser(false));
            }
            KeyCode::Char('l') => self.question = Some(Question::Laser),
            _ => return KeyEffect::Unknown,
        }
        KeyEffect::Nothing
    }
}

#[cfg(test)]
mod tests {
    use magician_job::jog::{ToolOrder, ToolState};

    use super::*;

    const X: JogDirection = JogDirection {
        axis: Axis::X,
        forward: true,
    };

    fn pad() -> Pad {
        Pad::new(Pendant::new(50.0, ToolState::default(), false))
    }

    fn press(pad: &mut Pad, code: KeyCode) -> KeyEffect {
        pad.key(KeyEvent::new(code, KeyModifiers::NONE), Duration::ZERO)
    }

    fn letter(pad: &mut Pad, letter: char) -> KeyEffect {
        press(pad, KeyCode::Char(letter))
    }

    #[test]
    fn a_press_is_a_step_of_the_length_that_is_set() {
        let mut pad = pad();
        letter(&mut pad, '+');
        let step = |direction, length| {
            KeyEffect::Order(PendantOrder::Step {
                direction,
                length,
                burning: false,
            })
        };
        assert_eq!(press(&mut pad, KeyCode::Up), step(X, 10.0));
        (0..9).for_each(|_| drop(letter(&mut pad, '-')));
        assert_eq!(press(&mut pad, KeyCode::Up), step(X, 0.1));
        press(&mut pad, KeyCode::Tab);
        let base = JogDirection {
            axis: Axis::J1,
            forward: true,
        };
        assert_eq!(press(&mut pad, KeyCode::Left), step(base, 0.1));
        // A second order is ignored while a step runs.
        pad.pendant.activity = Some(Activity::Step(base));
        assert_eq!(press(&mut pad, KeyCode::Left), KeyEffect::Nothing);
    }

    #[test]
    fn arrows_follow_the_view() {
        const ARROWS: [(KeyCode, [f64; 2]); 4] = [
            (KeyCode::Up, [0.0, 1.0]),
            (KeyCode::Down, [0.0, -1.0]),
            (KeyCode::Left, [-1.0, 0.0]),
            (KeyCode::Right, [1.0, 0.0]),
        ];
        let mut pad = pad();
        let told = |pad: &Pad| {
            [KeyCode::Up, KeyCode::Left].map(|code| pad.direction(code).unwrap().to_string())
        };
        assert_eq!(told(&pad), ["x+", "y+"]);
        for expected in [["y+", "x-"], ["x-", "y-"], ["y-", "x+"], ["x+", "y+"]] {
            letter(&mut pad, 'V');
            assert_eq!(told(&pad), expected);
            for (code, arrow) in ARROWS {
                let direction = pad.direction(code).unwrap();
                let by = f64::from(direction.signed(1.0));
                let way = match direction.axis {
                    Axis::X => [by, 0.0],
                    _ => [0.0, by],
                };
                assert_eq!(pad.view.project(way), arrow, "{code:?}");
            }
        }
        // After the view is turned, a held key would move elsewhere, so its jog ends.
        letter(&mut pad, 'm');
        press(&mut pad, KeyCode::Up);
        assert_eq!(
            letter(&mut pad, 'V'),
            KeyEffect::Order(PendantOrder::EndJog)
        );
        // Joints do not depend on the view.
        press(&mut pad, KeyCode::Tab);
        assert_eq!(told(&pad), ["j2+", "j1+"]);
    }

    #[test]
    fn arrows_page_the_help_without_moving_the_arm() {
        let mut pad = pad();
        letter(&mut pad, '?');
        assert_eq!(press(&mut pad, KeyCode::Down), KeyEffect::Nothing);
        assert_ne!(pad.help, Some(Help::default()));
        assert_eq!(letter(&mut pad, 'q'), KeyEffect::Nothing);
        assert_eq!(pad.help, None);
    }

    #[test]
    fn refusal_is_shown_until_the_next_one() {
        let mut pad = pad();
        let refused = "joint 2 would be at 91.3 deg, limit 90.0 deg";
        let error = magician::Error::invalid(refused).with_command("SetPTPCmd");
        let outcome = Err(error.into());
        let activity = Activity::Step(X);
        pad.done(&OrderDone { activity, outcome });
        letter(&mut pad, '+');
        let refusal = pad.refusal.as_deref().unwrap();
        assert_eq!(refusal, "x+: joint 2 would be at 91.3 deg, limit 90.0 deg");
        assert!(pad.message.is_none());
    }

    #[test]
    fn a_held_key_jogs_and_space_stops_everything() {
        let mut pad = pad();
        letter(&mut pad, 'm');
        let KeyEffect::Order(PendantOrder::Jog { direction, .. }) = press(&mut pad, KeyCode::Up)
        else {
            panic!("no jog");
        };
        assert_eq!(direction, X);
        assert_eq!(letter(&mut pad, ' '), KeyEffect::Order(PendantOrder::Stop));
        assert_eq!(pad.pendant.hold.direction(), None);
        press(&mut pad, KeyCode::Down);
        assert_eq!(pad.focus_lost(), KeyEffect::Order(PendantOrder::EndJog));
        // Space stops whatever question or help is shown.
        for key in ['h', 'l', '?'] {
            letter(&mut pad, key);
            assert_eq!(letter(&mut pad, ' '), KeyEffect::Order(PendantOrder::Stop));
            assert!(pad.question.is_none() && pad.help.is_none());
        }
    }

    #[test]
    fn dangerous_keys_ask_for_confirmation() {
        let mut pad = pad();
        assert_eq!(letter(&mut pad, 'h'), KeyEffect::Nothing);
        assert_eq!(letter(&mut pad, 'n'), KeyEffect::Nothing);
        letter(&mut pad, 'h');
        assert_eq!(letter(&mut pad, 'y'), KeyEffect::Order(PendantOrder::Home));
        letter(&mut pad, 'l');
        // Arrow keys do not answer a question and move nothing.
        assert_eq!(press(&mut pad, KeyCode::Up), KeyEffect::Nothing);
        letter(&mut pad, 'l');
        assert!(matches!(
            letter(&mut pad, 'y'),
            KeyEffect::Order(PendantOrder::Tool(_))
        ));
        assert!(
            !pad.pendant.tools.laser && pad.pendant.may_burn(),
            "the arm has not answered yet"
        );
        let activity = Activity::Tool(ToolOrder::Laser(true));
        let outcome = Ok(());
        pad.done(&OrderDone { activity, outcome });
        assert!(pad.pendant.tools.laser);
        // Switching off needs no question.
        assert!(matches!(
            letter(&mut pad, 'l'),
            KeyEffect::Order(PendantOrder::Tool(_))
        ));
    }

    #[test]
    fn keys_of_the_rail_need_a_rail() {
        let mut pad = pad();
        assert_eq!(letter(&mut pad, ']'), KeyEffect::Unknown);
        pad.pendant.rail = true;
        assert!(matches!(
            letter(&mut pad, ']'),
            KeyEffect::Order(PendantOrder::Step { direction, .. }) if direction.axis == Axis::L
        ));
    }

    #[test]
    fn speed_keys_step_through_the_list_from_any_speed() {
        let mut pad = pad();
        pad.pendant.speed = 42.0;
        assert_eq!(
            letter(&mut pad, '.'),
            KeyEffect::Order(PendantOrder::Speed(50.0))
        );
        assert_eq!(
            letter(&mut pad, ','),
            KeyEffect::Order(PendantOrder::Speed(30.0))
        );
        pad.pendant.speed = 100.0;
        assert_eq!(
            letter(&mut pad, '.'),
            KeyEffect::Order(PendantOrder::Speed(100.0))
        );
        let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(pad.key(interrupt, Duration::ZERO), KeyEffect::Interrupt);
    }
}
