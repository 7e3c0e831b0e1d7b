//! `watch`: shows an arm at work, as a picture or line by line.

mod line;
mod readings;
mod view;

use std::io::{self, IsTerminal};
use std::path::{Path, PathBuf};
use std::time::{Instant, SystemTime};

use clap::{Args, ValueHint};
use magician::commands::DeviceWithL;
use magician::report::StatusReport;
use magician::{Arm, ArmOutputs, Link};
use magician_job::jog::rail_position;
use magician_job::recording::{Options, Recorder};
use ratatui::crossterm::event::{Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

use crate::context::{Context, SignalPolicy, StopPolicy};
use crate::failure::{Failure, Kind};
use crate::output::Output;
use crate::terminal::{self, FullScreen, Help, ObservedArm, TerminalEvent, take_log};
use crate::verbs::jog::{REAL_TIME_ARM, next_of, title};
use crate::verbs::pose::rate;
use crate::verbs::record;
use view::Model;

pub(super) use readings::{Around, around};
#[cfg(test)]
pub(super) use view::tests::examples;
pub(super) use view::{alarms_and_log, queue_panel};

/// Watch the arm live: pose, queue, pins, alarms, tools, speeds, line
#[derive(Args, Debug)]
#[command(after_help = "\
Only reads: nothing is moved or changed. On a terminal it draws a live display on stderr until q; \
otherwise, and with --json, it prints one line per reading until Ctrl-C.")]
pub(crate) struct Watch {
    /// Readings per second, 0.01 to 1000 [default: 20 on a terminal, otherwise 10]
    #[arg(long, value_name = "HZ", value_parser = rate)]
    rate: Option<f64>,
    /// Also record the readings to a file, as `magician record` does
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    record: Option<PathBuf>,
    /// Print the deviation of the readings from the law of motion at the end (see `magician replay
    /// --help`)
    #[arg(long, requires = "record")]
    law: bool,
}

impl Watch {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let json = context.global.json;
        let drawn = !json && io::stdout().is_terminal() && io::stdin().is_terminal();
        if drawn {
            terminal::check("watch", "`magician watch | cat` gives lines")?;
        }
        let rate = self.rate.unwrap_or(if drawn { 20.0 } else { 10.0 });
        let shown = async |arm: &Arm, out: &mut Output| {
            if drawn {
                draw(arm, rate).await
            } else {
                lines(arm, rate, json, out).await
            }
        };
        match &self.record {
            None => context.arm_or(REAL_TIME_ARM, StopPolicy::Watch, shown),
            Some(file) => self.recorded(file, rate, context, shown),
        }
    }

    /// Records while the arm is shown. Both end together.
    fn recorded(
        &self,
        file: &Path,
        rate: f64,
        context: &mut Context,
        shown: impl AsyncFnOnce(&Arm, &mut Output) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        record::check(file, self.law, context)?;
        let summary = context.until_signal(
            REAL_TIME_ARM,
            SignalPolicy::Record,
            async |arm, out, over| {
                let options = Options::new(SystemTime::now(), rate);
                let mut recorder = Recorder::begin(arm, file, options).await?;
                let watched = tokio::select! {
                    // The requested end takes precedence over a recording that fails at the same
                    // time.
                    biased;
                    () = over => Ok(()),
                    error = recorder.failed() => return Err(Failure::from(error)),
                    watched = shown(arm, out) => watched,
                };
                let summary = recorder.finish().await?;
                match watched {
                    // Ctrl-C is the regular end of a recording.
                    Err(failure) if failure.kind != Kind::Interrupted => Err(failure),
                    _ => Ok(summary),
                }
            },
        )?;
        record::show(&summary, self.law, context)
    }
}

/// Prints one line per reading.
async fn lines(arm: &Arm, rate: f64, json: bool, out: &mut Output) -> Result<(), Failure> {
    let mut state = arm.state(rate)?;
    let mut outputs = readings::outputs(arm);
    let mut known = arm.read_outputs().await?;
    loop {
        let status = tokio::select! {
            biased;
            read = outputs.next() => {
                known = read;
                continue;
            }
            status = state.changed() => status?,
        };
        // While the line is broken another program may switch outputs, so nothing is claimed.
        let link = match status.link {
            Link::Up => known,
            _ => ArmOutputs::default(),
        };
        if json {
            out.json(&StatusReport::new(&status, &link))?;
        } else {
            out.line(line::plain(&status, &link))?;
        }
        out.flush()?;
    }
}

/// Shows the picture until a key ends it.
async fn draw(arm: &Arm, rate: f64) -> Result<(), Failure> {
    let (_, places) = arm.stats().await?;
    let observed = ObservedArm::new(title(arm).await?, places).with_reading_rate(rate);
    let mut model = Model::new(observed);
    let on_rail = arm.get::<DeviceWithL>().await;
    let mut rail = on_rail
        .is_ok_and(|rail| rail.with_l.is_on())
        .then(|| rail_position(arm));
    let (mut around, mut pins) = (readings::around(arm), readings::pins(arm));
    let (mut state, mut events) = (arm.state(rate)?, arm.events());
    let mut stage = FullScreen::open(view::draw)?;
    loop {
        stage.show(model.clone());
        tokio::select! {
            biased;
            event = stage.next() => match event {
                TerminalEvent::Event(Event::Key(key)) => match press(key, &mut model.help) {
                    Press::Nothing => {}
                    Press::Quit => return stage.close(),
                    Press::Interrupt => {
                        stage.close()?;
                        return Err(Failure::interrupted());
                    }
                },
                TerminalEvent::Gone => return Err(Failure::interrupted()),
                TerminalEvent::Event(_) | TerminalEvent::Beat => {}
            },
            status = state.changed() => model.observed.arm.observe(status?),
            Some(event) = events.next() => model.observed.note(event.to_string()),
            read = around.next() => model.around = read,
            pin = pins.next() => model.note(pin),
            Some(rail) = next_of(&mut rail) => model.observed.arm.rail = Some(rail),
        }
        for line in take_log() {
            model.observed.note(line);
        }
        model.observed.arm.tick(Instant::now());
    }
}

/// Effect of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Press {
    Nothing,
    Quit,
    Interrupt,
}

fn press(key: KeyEvent, help: &mut Option<Help>) -> Press {
    let control = key.modifiers.contains(KeyModifiers::CONTROL);
    if key.kind == KeyEventKind::Release {
        return Press::Nothing;
    }
    if control && key.code == KeyCode::Char('c') {
        return Press::Interrupt;
    }
    if let Some(shown) = *help {
        *help = shown.after(key.code);
        return Press::Nothing;
    }
    match key.code {
        KeyCode::Char('q') => return Press::Quit,
        KeyCode::Char('?') | KeyCode::F(1) => *help = Some(Help::default()),
        _ => {}
    }
    Press::Nothing
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_show_help_and_end_it() {
        let mut help = None;
        let mut letter = |letter, modifiers| {
            let press = press(KeyEvent::new(KeyCode::Char(letter), modifiers), &mut help);
            (press, help.is_some())
        };
        let none = KeyModifiers::NONE;
        assert_eq!(letter('?', none), (Press::Nothing, true));
        assert_eq!(letter('q', none), (Press::Nothing, false));
        assert_eq!(letter('q', none), (Press::Quit, false));
        assert_eq!(letter('c', none), (Press::Nothing, false));
        let interrupt = (Press::Interrupt, false);
        assert_eq!(letter('c', KeyModifiers::CONTROL), interrupt);
    }
}
