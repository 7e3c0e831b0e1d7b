//! Pictures of arms in known states, as text.

use magician::serve::Server;
use magician_motion::TopView;
use magician_protocol::commands::{PtpCmd, QueuedCmdStartExec, WaitCmd};
use magician_protocol::{Ctrl, FrameBuf, PtpMode, Set};
use magician_sim::scenario::Scenario;
use magician_sim::{ArmInstant, Controller, ExternalEvent, LinkId, Profile, World};
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};
use ratatui::style::Color;

use super::super::app::{App, Subject};
use super::super::arm_view::{ArmView, Cursor};
use super::super::feed::{Feed, Line};
use super::super::keys::{Mode, Question, action};
use super::draw;
use crate::terminal::test::{self, Example, assert_shows};
use crate::terminal::{Help, Theme};

/// Creates the state of an arm in the world of a scenario.
fn app(controller: &Controller) -> App {
    let scenario = controller.world().scenario().cloned().unwrap_or_default();
    let subject = Subject {
        handle: Server::new(Controller::default()).handle(),
        feed: Feed::new(),
        title: "virtual arm".to_owned(),
        limits: Profile::default().arm_model().limits,
        table: scenario.table().copied(),
        conveyor: scenario.conveyor().copied(),
    };
    let mut app = App::new(vec![subject]);
    app.replace_view(ArmView::at(controller, Cursor::default()));
    app
}

fn sorting() -> Controller {
    let scenario = Scenario::from_toml(Scenario::PICK_AND_SORT).unwrap();
    Controller::in_world(Profile::default(), World::from_scenario(&scenario))
}

fn send(controller: &mut Controller, command: impl Into<Set>, ctrl: Ctrl) {
    let frame = FrameBuf::set(&command.into(), ctrl).unwrap();
    controller.receive(LinkId(0), frame.bytes());
}

fn terminal(app: &App, width: u16, height: u16, theme: Theme) -> Terminal<TestBackend> {
    test::terminal(width, height, |frame| draw(frame, app, theme))
}

/// Draws the screen as lines of text.
fn screen(app: &App, width: u16, height: u16) -> Vec<String> {
    test::screen(width, height, |frame| draw(frame, app, Theme::PLAIN))
}

fn dots(screen: &[String]) -> usize {
    let braille = |sign: &char| ('\u{2801}'..='\u{28FF}').contains(sign);
    screen
        .iter()
        .flat_map(|line| line.chars())
        .filter(braille)
        .count()
}

/// Served arm in several states.
pub(in crate::verbs) fn examples() -> Vec<Example> {
    fn example(
        name: &'static str,
        needs: &[&str],
        change: fn(&mut Controller, &mut App),
    ) -> Example {
        let shown = move |help: Option<Help>| {
            let mut arm = sorting();
            let mut app = app(&arm);
            app.feed_state.endpoints =
                vec!["UDP 127.0.0.1:8899".to_owned(), "PTY ./arm".to_owned()];
            let text =
                "a line that is longer than a log is wide beside all the other panels".to_owned();
            app.feed_state.say(Line { at: 1.5, text });
            change(&mut arm, &mut app);
            app.replace_view(ArmView::at(&arm, Cursor::default()));
            if let Some(help) = help {
                app.mode = Mode::Help(help);
            }
            app
        };
        Example::new(name, needs, &super::KEYS, shown, draw)
    }
    let always = [
        "virtual arm | UDP 127.0.0.1:8899 | PTY ./arm",
        "0:00",
        "x 259.1 y 0.0",
        "z -8.5 r 0.0",
        "J1 0.0 J2 45.0",
        "J3 45.0 J4 0.0",
        "○ suction ○ gripper",
        "○ laser",
        "cable in, 0 clients",
        "a line that is longer than a log is wide beside all the other panels",
    ];
    let need = |more: &[&'static str]| [&always[..], more].concat();
    vec![
        example(
            "sim",
            &need(&[
                "at rest, not homed",
                "empty",
                "0x00 ResetOccurred:",
                "home the arm",
                "q quit",
                "? help",
            ]),
            |_, _| {},
        ),
        example(
            "sim, unlocked",
            &need(&[
                "unlocked, not homed",
                "arrows x+ ↑ y+ ←",
                "? help J1 coarse",
            ]),
            |arm, _| arm.inject(ExternalEvent::Unlock(true)),
        ),
        example(
            "sim that asks",
            &need(&[
                "raise alarm 0x12_ PlanInvLimit: the target would take a joint beyond its limit",
            ]),
            |_, app| {
                app.mode = Mode::Ask {
                    question: Question::Alarm,
                    text: "12".to_owned(),
                };
            },
        ),
        example(
            "sim, an input",
            &need(&["input 7 digits arrows choose space toggle esc back"]),
            |_, app| {
                app.mode = Mode::Inputs {
                    address: 7,
                    typed: false,
                };
            },
        ),
    ]
}

#[test]
fn an_arm_at_power_up_on_a_narrow_terminal() {
    let mut app = app(&Controller::default());
    let text = "the last line".to_owned();
    app.feed_state.say(Line { at: 1.5, text });
    let screen = screen(&app, 80, 24);
    assert_shows(
        &screen,
        &[
            "virtual arm",
            "from above",
            "from the side",
            "x    259.1   y      0.0",
            "J1     0.0   J2    45.0",
            "at rest, not homed",
            "0/32",
            "stopped, done 0",
            "alarms: 1",
            "0x00 ResetOccurred:",
            "home the arm",
            "○ suction  ○ gripper",
            "cable in, 0 clients",
            "16 ○ 17 ○ 18 ○ 19 ○ 20 ○",
            "    1.50  the last line",
            "i input",
        ],
    );
    assert!(dots(&screen) > 100);
}

#[test]
fn running_and_blocked_queue() {
    let mut arm = Controller::default();
    send(&mut arm, QueuedCmdStartExec {}, Ctrl::SET);
    for _ in 0..16 {
        send(&mut arm, WaitCmd { timeout: 1000 }, Ctrl::QUEUED);
    }
    let busy = screen(&app(&arm), 80, 24);
    assert_shows(&busy, &["16/32", "2 WAITCmd", "started, done 0"]);
    let full = |line: &String| line.matches('█').count();
    assert_eq!(busy.iter().map(full).sum::<usize>(), 10);

    arm.inject(ExternalEvent::Alarm(0x12));
    let held = screen(&app(&arm), 120, 40);
    assert_shows(
        &held,
        &[
            "alarms: 2, the queue is held",
            "0x12 PlanInvLimit: the target would take a joint beyond its limit",
            "     choose another target, then clear the alarms",
            "held by alarm",
        ],
    );
}

#[test]
fn a_world_on_a_wide_terminal() {
    let mut arm = sorting();
    let sizes = [(160, 50), (200, 60), (120, 24)];
    let looks = sizes.map(|(width, height)| screen(&app(&arm), width, height));
    let cube = "■ red cube    260.0 -120.0  -30.0  on the belt";
    assert_shows(&looks[0], &["objects, belt at 0 mm", cube]);
    assert_shows(&looks[1], &["objects, belt at 0 mm", cube]);
    assert_shows(&looks[2], &["■ red cube", "and 2 more"]);
    assert_shows(&looks[0], &["20 ○ -"]);
    assert!(dots(&looks[1]) > dots(&looks[2]));

    arm.inject(ExternalEvent::Slip {
        joint: 2,
        degrees: 8.0,
    });
    assert_shows(&screen(&app(&arm), 160, 50), &["actual J2 +8.0"]);
    arm.inject(ExternalEvent::Unlock(true));
    assert_shows(
        &screen(&app(&arm), 160, 50),
        &["unlocked, not homed", "arrows x+ ↑ y+ ←"],
    );
}

#[test]
fn arrows_follow_the_view_from_every_side() {
    let mut app = app(&Controller::default());
    // Place of the tip on the screen; the tool is ahead of the arm, at y 0.
    let tip = |app: &App| {
        let screen = screen(app, 80, 24);
        let rows = screen.iter().enumerate().skip(2).take(11);
        let mut found = rows.filter_map(|(row, line)| {
            let at = line.chars().take(26).position(|sign| sign == 'o')?;
            Some([at as f64 - 13.0, 7.0 - row as f64])
        });
        found.next().unwrap()
    };
    for axes in ["x+ ↑ y+ ←", "x+ → y+ ↑", "x+ ↓ y+ →", "x+ ← y+ ↓"] {
        assert_shows(&screen(&app, 80, 24), &[&format!("from above: {axes}")]);
        let [right, up] = app.view.project([1.0, 0.0]);
        let [column, row] = tip(&app);
        assert!(column * right + row * up > 2.0, "{axes}: {column} {row}");
        let key = KeyEvent::new(KeyCode::Char('V'), KeyModifiers::NONE);
        let turned = app.act(action(&app.mode, false, key));
        assert!(matches!(turned, Ok(None)));
    }
    assert_eq!(app.view, TopView::BEHIND);
}

#[test]
fn trail_shows_earlier_tool_positions() {
    let mut arm = Controller::default();
    send(&mut arm, QueuedCmdStartExec {}, Ctrl::SET);
    let there = PtpCmd {
        ptp_mode: PtpMode::MovjXyz,
        x: 180.0,
        y: 150.0,
        z: 40.0,
        r: 0.0,
    };
    send(&mut arm, there, Ctrl::QUEUED);
    let mut app = app(&arm);
    let count = app.trail.len();
    arm.advance(ArmInstant::from_micros(300_000));
    app.replace_view(ArmView::at(&arm, Cursor::default()));
    arm.advance(ArmInstant::from_micros(10_000_000));
    app.replace_view(ArmView::at(&arm, Cursor::default()));
    app.replace_view(ArmView::at(&arm, Cursor::default()));
    assert_eq!((count, app.trail.len()), (1, 3));
    let last = app.trail.back().unwrap().above;
    assert!((last[0] - 180.0).hypot(last[1] - 150.0) < 0.01, "{last:?}");
    assert_shows(&screen(&app, 80, 24), &["x    180.0   y    150.0"]);
}

#[test]
fn questions_are_answered_in_the_last_line() {
    let mut app = app(&Controller::default());
    let text = "4a".to_owned();
    app.mode = Mode::Ask {
        question: Question::Alarm,
        text,
    };
    let typed = screen(&app, 80, 24);
    assert!(typed[23].starts_with(" raise alarm 0x4a_"), "{}", typed[23]);
    let text = "12".to_owned();
    app.mode = Mode::Ask {
        question: Question::Alarm,
        text,
    };
    assert_shows(&screen(&app, 80, 24), &["PlanInvLimit: the target would"]);
    app.mode = Mode::Help(Help::default());
    assert_shows(
        &screen(&app, 80, 24),
        &["pull the cable, or plug it in", "redraw the screen"],
    );
    let (address, typed) = (7, false);
    app.mode = Mode::Inputs { address, typed };
    let chosen = screen(&app, 80, 24);
    assert!(chosen[23].starts_with(" input 7"), "{}", chosen[23]);
    app.message = Some("no further".to_owned());
    assert!(screen(&app, 80, 24)[23].starts_with(" no further"));
}

#[test]
fn every_size_has_a_picture() {
    let mut arm = sorting();
    (0..=255).for_each(|code| arm.inject(ExternalEvent::Alarm(code)));
    let mut app = app(&arm);
    let text = "a line that is longer than many a terminal is wide, and that is cut off".repeat(3);
    (0..300).for_each(|_| {
        app.feed_state.say(Line {
            at: 1e6,
            text: text.clone(),
        })
    });
    let question = Question::Slip;
    let ask = Mode::Ask { question, text };
    let inputs = Mode::Inputs {
        address: 20,
        typed: true,
    };
    for mode in [Mode::Watch, Mode::Help(Help::default()), ask, inputs] {
        app.mode = mode;
        for width in [1, 2, 5, 10, 29, 71, 72, 80, 119, 120, 300] {
            for height in [1, 2, 3, 5, 10, 21, 22, 23, 24, 30, 37, 43, 60, 120] {
                assert_eq!(screen(&app, width, height).len(), usize::from(height));
            }
        }
    }
    app.mode = Mode::Watch;
    let small = screen(&app, 10, 5);
    assert_shows(&small, &["x    259.1"]);
}

#[test]
fn plain_theme_writes_no_colours() {
    let app = app(&sorting());
    let colors = |theme| {
        let terminal = terminal(&app, 160, 50, theme);
        let cells = terminal.backend().buffer().content().to_vec();
        let plain = |color| color == Color::Reset;
        cells
            .iter()
            .filter(|cell| !(plain(cell.fg) && plain(cell.bg)))
            .count()
    };
    assert_eq!(colors(Theme::PLAIN), 0);
    assert!(colors(Theme::COLORED) > 300);
}
