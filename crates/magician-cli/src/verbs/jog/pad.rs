//! What keys mean on a pad, and what it shows of itself: nothing is done here.

use std::time::Duration;

use magician_motion::TopView;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use super::wording;
use crate::terminal::Help;
use magician_job::jog::{Axis, Heading};
use magician_job::jog::{Done, Order, ToolOrder, What};
use magician_job::jog::{Hold, Turn};
use magician_program::Grip;

/// Lengths of steps, mm or degrees.
const STEPS: [f32; 5] = [0.1, 1.0, 5.0, 10.0, 50.0];
/// Shares of the set speeds, percent.
const SPEEDS: [f32; 8] = [1.0, 5.0, 10.0, 20.0, 30.0, 50.0, 75.0, 100.0];

/// What arrows move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Frame {
    Cartesian,
    Joints,
}

/// What a press does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Way {
    /// The arm moves while the key is held.
    Hold,
    /// Each press is a checked move by so much.
    Step,
}

/// What has to be answered with y before it is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Question {
    Home,
    Laser,
}

impl Question {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Self::Home => "home: the base turns to its end and back, half a minute. Way free? y/n",
            Self::Laser => "switch the laser on: does everybody wear goggles? y/n",
        }
    }
}

/// How good or bad a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tone {
    Plain,
    Bad,
}

/// What a key comes to for the program as a whole.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Reply {
    /// Nothing more.
    Nothing,
    /// The arm is to do something.
    Order(Order),
    Quit,
    /// Ctrl-C.
    Interrupt,
    /// The key is none of the pad's.
    Unknown,
}

/// What the tools were last told or seen to do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Tools {
    pub(crate) suction: bool,
    /// `None`: its pump is off.
    pub(crate) grips: Option<bool>,
    pub(crate) laser: bool,
}

/// The pad's own state.
#[derive(Clone, Debug)]
pub(crate) struct Pad {
    pub(crate) frame: Frame,
    pub(crate) way: Way,
    pub(crate) step: f32,
    pub(crate) speed: f32,
    pub(crate) tools: Tools,
    /// Whether there is a rail.
    pub(crate) rail: bool,
    pub(crate) hold: Hold,
    /// What moves the arm.
    pub(crate) doing: Option<What>,
    pub(crate) question: Option<Question>,
    /// The list of keys, while it is shown.
    pub(crate) help: Option<Help>,
    /// From where the arm is seen: the arrows lead where they point.
    pub(crate) view: TopView,
    pub(crate) message: Option<(Tone, String)>,
    /// The last move that was refused, and why.
    pub(crate) refusal: Option<String>,
    wanted: Tools,
}

impl Pad {
    pub(crate) fn new(speed: f32, tools: Tools, rail: bool) -> Self {
        Self {
            frame: Frame::Cartesian,
            way: Way::Step,
            step: 5.0,
            speed,
            tools,
            rail,
            hold: Hold::new(),
            doing: None,
            question: None,
            help: None,
            view: TopView::BEHIND,
            message: None,
            refusal: None,
            wanted: tools,
        }
    }

    /// What a key comes to.
    pub(crate) fn key(&mut self, key: KeyEvent, now: Duration) -> Reply {
        let pressed = key.kind != KeyEventKind::Release;
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return match key.code {
                KeyCode::Char('c') if pressed => Reply::Interrupt,
                _ => Reply::Unknown,
            };
        }
        let heading = self.heading(key.code);
        if !pressed {
            return self.turn(|hold| hold.release(heading));
        }
        if key.code == KeyCode::Char(' ') {
            return self.stop();
        }
        if let Some(help) = self.help {
            self.help = help.after(key.code);
            return Reply::Nothing;
        }
        if let Some(question) = self.question.take() {
            return self.answer(question, key.code);
        }
        self.message = None;
        if let Some(heading) = heading {
            return self.go(heading, key.kind, now);
        }
        self.other(key.code)
    }

    /// The terminal is well: what is held goes on, or ends when it was not seen held for too long.
    pub(crate) fn beat(&mut self, now: Duration) -> Reply {
        self.turn(|hold| hold.beat(now))
    }

    /// Whether the laser burns, or was told to and has not answered.
    pub(crate) fn may_burn(&self) -> bool {
        self.tools.laser || self.wanted.laser
    }

    /// Nobody may be looking any more: what is held ends.
    pub(crate) fn let_go(&mut self) -> Reply {
        self.turn(Hold::let_go)
    }

    /// Takes note of what came of something.
    pub(crate) fn done(&mut self, done: &Done) {
        let failure = match &done.outcome {
            Ok(()) => return self.well_done(done.what),
            Err(error) => wording::failure(error).fact().to_owned(),
        };
        match done.what {
            What::Jog(heading) => {
                self.hold.let_go();
                self.refusal = Some(format!("{heading}: {failure}"));
            }
            What::Step(heading) => self.refusal = Some(format!("{heading}: {failure}")),
            What::Tool(_) => self.wanted = self.tools,
            _ => {}
        }
        self.say(Tone::Bad, failure);
    }

    fn well_done(&mut self, what: What) {
        match what {
            What::Stop => self.say(Tone::Plain, "stopped: the arm stands, the queue is empty"),
            What::Home => self.say(Tone::Plain, "homed"),
            What::ClearAlarms => self.say(Tone::Plain, "alarms cleared"),
            What::Tool(tool) => {
                self.tools = self.wanted;
                self.say(Tone::Plain, wording::tool(tool));
            }
            What::Speed(percent) => self.speed = percent,
            What::Run => self.say(Tone::Plain, "played"),
            What::Jog(_) | What::Step(_) => {}
        }
    }

    pub(crate) fn say(&mut self, tone: Tone, text: impl Into<String>) {
        self.message = Some((tone, text.into()));
    }

    /// What a key moves, in the frame in force.
    pub(crate) fn heading(&self, code: KeyCode) -> Option<Heading> {
        let heading = |axis, forward| Some(Heading { axis, forward });
        let (cartesian, joint) = match code {
            KeyCode::Up | KeyCode::Down | KeyCode::Left | KeyCode::Right => {
                return self.arrow(code);
            }
            KeyCode::PageUp | KeyCode::PageDown | KeyCode::Char('w' | 's') => (Axis::Z, Axis::J3),
            KeyCode::Char('a' | 'd') => (Axis::R, Axis::J4),
            KeyCode::Char(']' | '[') if self.rail => (Axis::L, Axis::L),
            _ => return None,
        };
        let forward = matches!(code, KeyCode::PageUp | KeyCode::Char('w' | 'a' | ']'));
        match self.frame {
            Frame::Cartesian => heading(cartesian, forward),
            Frame::Joints => heading(joint, forward),
        }
    }

    /// An arrow leads where it points, as the arm is seen.
    fn arrow(&self, code: KeyCode) -> Option<Heading> {
        let arrow = match code {
            KeyCode::Up => [0.0, 1.0],
            KeyCode::Down => [0.0, -1.0],
            KeyCode::Left => [-1.0, 0.0],
            KeyCode::Right => [1.0, 0.0],
            _ => return None,
        };
        let (axis, forward) = match self.frame {
            Frame::Cartesian => {
                let [x, y] = self.view.unproject(arrow);
                match x.abs() > y.abs() {
                    true => (Axis::X, x > 0.0),
                    false => (Axis::Y, y > 0.0),
                }
            }
            // Joints have no direction on the ground. The arrows at the sides turn the base, as they move the tool to the
            // sides for who stands behind the arm.
            Frame::Joints => match code {
                KeyCode::Up | KeyCode::Down => (Axis::J2, code == KeyCode::Up),
                _ => (Axis::J1, code == KeyCode::Left),
            },
        };
        Some(Heading { axis, forward })
    }

    fn go(&mut self, heading: Heading, kind: KeyEventKind, now: Duration) -> Reply {
        match (self.way, self.doing) {
            (Way::Hold, _) if kind == KeyEventKind::Repeat => {
                self.turn(|hold| hold.repeat(heading, now))
            }
            (Way::Hold, _) => self.turn(|hold| hold.press(heading, now)),
            // A step is made after the other: presses that come too soon are not kept for later.
            (Way::Step, Some(_)) => Reply::Nothing,
            (Way::Step, None) => Reply::Order(Order::Step {
                heading,
                length: self.step,
                burning: self.tools.laser,
            }),
        }
    }

    fn turn(&mut self, turn: impl FnOnce(&mut Hold) -> Turn) -> Reply {
        match turn(&mut self.hold) {
            Turn::Begin { heading, keep } => Reply::Order(Order::Jog { heading, keep }),
            Turn::Keep => Reply::Order(Order::Keep),
            Turn::End => Reply::Order(Order::EndJog),
            Turn::Nothing => Reply::Nothing,
        }
    }

    fn stop(&mut self) -> Reply {
        self.hold.let_go();
        self.question = None;
        self.help = None;
        self.tools.laser = false;
        self.wanted = self.tools;
        self.say(Tone::Plain, "stopping");
        Reply::Order(Order::Stop)
    }

    fn answer(&mut self, question: Question, code: KeyCode) -> Reply {
        match (question, code) {
            (Question::Home, KeyCode::Char('y' | 'Y')) => {
                self.say(Tone::Plain, "homing; space stops it");
                Reply::Order(Order::Home)
            }
            (Question::Laser, KeyCode::Char('y' | 'Y')) => {
                self.wanted.laser = true;
                Reply::Order(Order::Tool(ToolOrder::Laser(true)))
            }
            _ => Reply::Nothing,
        }
    }

    fn other(&mut self, code: KeyCode) -> Reply {
        match code {
            KeyCode::Char('q') => return Reply::Quit,
            KeyCode::Char('?') | KeyCode::F(1) => self.help = Some(Help::default()),
            KeyCode::Char('V') => {
                self.view = self.view.turned();
                return self.let_go();
            }
            KeyCode::Tab | KeyCode::BackTab => {
                self.frame = match self.frame {
                    Frame::Cartesian => Frame::Joints,
                    Frame::Joints => Frame::Cartesian,
                };
                return self.let_go();
            }
            KeyCode::Char('m') => {
                self.way = match self.way {
                    Way::Hold => Way::Step,
                    Way::Step => Way::Hold,
                };
                return self.let_go();
            }
            KeyCode::Char('+' | '=') => self.step = next(&STEPS, self.step, true),
            KeyCode::Char('-' | '_') => self.step = next(&STEPS, self.step, false),
            KeyCode::Char('.' | '>') => {
                return Reply::Order(Order::Speed(next(&SPEEDS, self.speed, true)));
            }
            KeyCode::Char(',' | '<') => {
                return Reply::Order(Order::Speed(next(&SPEEDS, self.speed, false)));
            }
            KeyCode::Char('h') => self.question = Some(Question::Home),
            KeyCode::Char('c') => return Reply::Order(Order::ClearAlarms),
            KeyCode::Char('p') => return self.suction(),
            KeyCode::Char('g') => return self.gripper(),
            KeyCode::Char('l') if self.tools.laser => {
                self.wanted.laser = false;
                return Reply::Order(Order::Tool(ToolOrder::Laser(false)));
            }
            KeyCode::Char('l') => self.question = Some(Question::Laser),
            _ => return Reply::Unknown,
        }
        Reply::Nothing
    }

    fn suction(&mut self) -> Reply {
        let on = !self.tools.suction;
        self.wanted = Tools {
            suction: on,
            grips: None,
            ..self.tools
        };
        Reply::Order(Order::Tool(ToolOrder::Suction(on)))
    }

    /// Closed, open, off, and so on.
    fn gripper(&mut self) -> Reply {
        let (grips, order) = match self.tools.grips {
            None => (Some(true), Grip::Close),
            Some(true) => (Some(false), Grip::Open),
            Some(false) => (None, Grip::Off),
        };
        self.wanted = Tools {
            suction: false,
            grips,
            ..self.tools
        };
        Reply::Order(Order::Tool(ToolOrder::Gripper(order)))
    }
}

/// The next one of a list, upwards or downwards.
fn next(list: &[f32], now: f32, up: bool) -> f32 {
    let found = match up {
        true => list.iter().find(|one| **one > now),
        false => list.iter().rev().find(|one| **one < now),
    };
    found.copied().unwrap_or(now)
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: Heading = Heading {
        axis: Axis::X,
        forward: true,
    };

    fn pad() -> Pad {
        Pad::new(50.0, Tools::default(), false)
    }

    fn press(pad: &mut Pad, code: KeyCode) -> Reply {
        pad.key(KeyEvent::new(code, KeyModifiers::NONE), Duration::ZERO)
    }

    fn letter(pad: &mut Pad, letter: char) -> Reply {
        press(pad, KeyCode::Char(letter))
    }

    #[test]
    fn a_press_is_a_step_of_the_length_that_is_set() {
        let mut pad = pad();
        letter(&mut pad, '+');
        let step = |heading, length| {
            Reply::Order(Order::Step {
                heading,
                length,
                burning: false,
            })
        };
        assert_eq!(press(&mut pad, KeyCode::Up), step(X, 10.0));
        (0..9).for_each(|_| drop(letter(&mut pad, '-')));
        assert_eq!(press(&mut pad, KeyCode::Up), step(X, 0.1));
        press(&mut pad, KeyCode::Tab);
        let base = Heading {
            axis: Axis::J1,
            forward: true,
        };
        assert_eq!(press(&mut pad, KeyCode::Left), step(base, 0.1));
        // One after the other.
        pad.doing = Some(What::Step(base));
        assert_eq!(press(&mut pad, KeyCode::Left), Reply::Nothing);
    }

    #[test]
    fn arrows_lead_where_the_view_shows_it() {
        const ARROWS: [(KeyCode, [f64; 2]); 4] = [
            (KeyCode::Up, [0.0, 1.0]),
            (KeyCode::Down, [0.0, -1.0]),
            (KeyCode::Left, [-1.0, 0.0]),
            (KeyCode::Right, [1.0, 0.0]),
        ];
        let mut pad = pad();
        let told = |pad: &Pad| {
            [KeyCode::Up, KeyCode::Left].map(|code| pad.heading(code).unwrap().to_string())
        };
        assert_eq!(told(&pad), ["x+", "y+"]);
        for seen in [["y+", "x-"], ["x-", "y-"], ["y-", "x+"], ["x+", "y+"]] {
            letter(&mut pad, 'V');
            assert_eq!(told(&pad), seen);
            for (code, arrow) in ARROWS {
                let heading = pad.heading(code).unwrap();
                let by = f64::from(heading.signed(1.0));
                let way = match heading.axis {
                    Axis::X => [by, 0.0],
                    _ => [0.0, by],
                };
                assert_eq!(pad.view.project(way), arrow, "{code:?}");
            }
        }
        // A key that is held leads elsewhere after the turn: it has to be pressed anew.
        letter(&mut pad, 'm');
        press(&mut pad, KeyCode::Up);
        assert_eq!(letter(&mut pad, 'V'), Reply::Order(Order::EndJog));
        // Joints are not of the ground.
        press(&mut pad, KeyCode::Tab);
        assert_eq!(told(&pad), ["j2+", "j1+"]);
    }

    #[test]
    fn arrows_turn_pages_of_the_help_and_move_nothing() {
        let mut pad = pad();
        letter(&mut pad, '?');
        assert_eq!(press(&mut pad, KeyCode::Down), Reply::Nothing);
        assert_ne!(pad.help, Some(Help::default()));
        assert_eq!(letter(&mut pad, 'q'), Reply::Nothing);
        assert_eq!(pad.help, None);
    }

    #[test]
    fn a_refusal_is_kept_until_the_next_one() {
        let mut pad = pad();
        let refused = "joint 2 would be at 91.3 deg, limit 90.0 deg";
        let error = magician::Error::invalid(refused).with_command("SetPTPCmd");
        let outcome = Err(error.into());
        let what = What::Step(X);
        pad.done(&Done { what, outcome });
        letter(&mut pad, '+');
        let refusal = pad.refusal.as_deref().unwrap();
        assert_eq!(refusal, "x+: joint 2 would be at 91.3 deg, limit 90.0 deg");
        assert!(pad.message.is_none());
    }

    #[test]
    fn a_held_key_jogs_and_space_stops_everything() {
        let mut pad = pad();
        letter(&mut pad, 'm');
        let Reply::Order(Order::Jog { heading, .. }) = press(&mut pad, KeyCode::Up) else {
            panic!("no jog");
        };
        assert_eq!(heading, X);
        assert_eq!(letter(&mut pad, ' '), Reply::Order(Order::Stop));
        assert_eq!(pad.hold.heading(), None);
        press(&mut pad, KeyCode::Down);
        assert_eq!(pad.let_go(), Reply::Order(Order::EndJog));
        // Whatever is asked or shown.
        for key in ['h', 'l', '?'] {
            letter(&mut pad, key);
            assert_eq!(letter(&mut pad, ' '), Reply::Order(Order::Stop));
            assert!(pad.question.is_none() && pad.help.is_none());
        }
    }

    #[test]
    fn what_may_hurt_is_asked_first() {
        let mut pad = pad();
        assert_eq!(letter(&mut pad, 'h'), Reply::Nothing);
        assert_eq!(letter(&mut pad, 'n'), Reply::Nothing);
        letter(&mut pad, 'h');
        assert_eq!(letter(&mut pad, 'y'), Reply::Order(Order::Home));
        letter(&mut pad, 'l');
        // Arrows are no answer, and move nothing.
        assert_eq!(press(&mut pad, KeyCode::Up), Reply::Nothing);
        letter(&mut pad, 'l');
        assert!(matches!(
            letter(&mut pad, 'y'),
            Reply::Order(Order::Tool(_))
        ));
        assert!(
            !pad.tools.laser && pad.may_burn(),
            "the arm has not answered yet"
        );
        let what = What::Tool(ToolOrder::Laser(true));
        let outcome = Ok(());
        pad.done(&Done { what, outcome });
        assert!(pad.tools.laser);
        // Off without a question.
        assert!(matches!(
            letter(&mut pad, 'l'),
            Reply::Order(Order::Tool(_))
        ));
    }

    #[test]
    fn keys_of_the_rail_need_a_rail() {
        let mut pad = pad();
        assert_eq!(letter(&mut pad, ']'), Reply::Unknown);
        pad.rail = true;
        assert!(matches!(
            letter(&mut pad, ']'),
            Reply::Order(Order::Step { heading, .. }) if heading.axis == Axis::L
        ));
    }

    #[test]
    fn speeds_go_up_and_down_the_list_from_wherever_they_are() {
        let mut pad = pad();
        pad.speed = 42.0;
        assert_eq!(letter(&mut pad, '.'), Reply::Order(Order::Speed(50.0)));
        assert_eq!(letter(&mut pad, ','), Reply::Order(Order::Speed(30.0)));
        pad.speed = 100.0;
        assert_eq!(letter(&mut pad, '.'), Reply::Order(Order::Speed(100.0)));
        let interrupt = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(pad.key(interrupt, Duration::ZERO), Reply::Interrupt);
    }
}
