//! What verbs that run a file have in common: read, place, check, and then look at it or run it.

mod drive;
mod input;
mod keys;
mod list_parts;
pub(crate) mod options;
mod reading;
mod report;
mod setting;
#[cfg(test)]
mod setup_keys;
mod show;
mod suspend;
mod tell;
mod tui;
mod under_way;
mod unusual;
mod wording;

use std::io::{self, Write};
use std::path::Path;

use magician::commands::EndEffectorParams;
use magician::sim::Controller;
use magician::sim::world::PictureOptions;
use magician::words::Preflight;
use magician::{JointAngles, Options, SimSpeed, Target, VirtualArm, blocking, burns};
use magician_job::report::advised;
use magician_program::rehearse::{RehearseOptions, stage};
use magician_program::{
    AppliedPlacement, Diagnostic, DiagnosticCode, Ending, Format, Plan, Program, Setup,
    SetupOptions, Tool, WorkOption, WouldFit,
};
use magician_protocol::visible_lines;

use self::drive::{Drive, RATE, Ran};
use self::options::{File, PlacementOptions, PreviewFlags, RunFlags};
use self::reading::Read;
use crate::context::{Context, JobPolicy, StopPolicy};
use crate::diagnostics::Severity;
use crate::failure::{Failure, Kind, incomplete};
use crate::paint::Paint;
use crate::permission::{Asks, homed};
use crate::source::Source;
use crate::terminal;
use crate::verbs::preset;
use crate::verbs::sim::picture::Picture;
use crate::voice::Command;

pub(crate) use setting::defaults;
#[cfg(test)]
pub(super) use tui::examples;

/// As many notes are shown.
const NOTES: usize = 10;

/// A file, and what is to be done with it.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) file: File,
    /// The text that is written, instead of what is in the file.
    pub(crate) text: Option<String>,
    pub(crate) look: PreviewFlags,
    pub(crate) way: RunFlags,
    /// How it is to be done: what its flags say.
    pub(crate) options: SetupOptions,
    /// Rest at the end of each loop, ms.
    pub(crate) pause: u32,
    /// Whether it is run or looked at, and not made another file of.
    pub(crate) runs: bool,
    /// Whether it goes on until it is stopped, which is its good end.
    pub(crate) repeats: bool,
    /// What its preset tells people.
    preset_note: Option<Diagnostic>,
    /// What is told before all else.
    told_first: Vec<Diagnostic>,
}

/// What has become of a file.
struct Made {
    source: Source,
    setup: Setup,
    program: Program,
    /// Where the tool was, if the program depends on it and it was not given.
    start: Option<[f64; 3]>,
    /// What of the file was taken in a certain way.
    notes: Vec<Diagnostic>,
    /// How it lies, if it was placed.
    placed: Option<AppliedPlacement>,
    /// Why it does not fit there, if it is only looked at, and what would.
    misfit: Option<Diagnostic>,
    would_fit: Option<WouldFit>,
    format: Format,
    ending: Ending,
    /// How a virtual arm stands when it begins, if it depends on that.
    standing: Option<JointAngles>,
    /// True if everything that is refused is shown.
    verbose: bool,
}

/// Where a program is tried or run.
enum Where {
    /// Nowhere: it is only looked at, as an arm would do it that was just homed.
    Nowhere,
    /// On a virtual arm of its own.
    Stage(SimSpeed),
    /// On an arm that is there.
    Arm,
}

impl Job {
    /// A file that is run, with what these flags say of it.
    pub(crate) fn new(
        work: impl Into<Option<WorkOption>>,
        file: File,
        look: PreviewFlags,
        place: &PlacementOptions,
        way: RunFlags,
    ) -> Self {
        let mut options = SetupOptions::default();
        options.work = work.into();
        file.say(&mut options);
        place.say(&mut options);
        way.say(&mut options);
        Self {
            file,
            text: None,
            look,
            way,
            options,
            pause: 0,
            runs: true,
            repeats: false,
            preset_note: None,
            told_first: Vec::new(),
        }
    }

    /// With what its preset says where its flags say nothing.
    fn preset(&mut self) -> Result<(), Failure> {
        let Some(name) = self.way.preset.take() else {
            return Ok(());
        };
        let preset = preset::load(&name)?;
        self.options = self.options.or(&preset.options_for(self.file.format));
        self.options
            .check()
            .map_err(|error| Failure::usage(format!("with the preset {name}: {error}")))?;
        self.preset_note = preset.told();
        Ok(())
    }

    /// Checks what the flags say together; each by itself was checked as it was read.
    fn check_options(&self) -> Result<(), Failure> {
        let checked = self.options.check_extremes();
        checked.map_err(|error| Failure::usage(error.to_string()))
    }

    /// Does it.
    pub(crate) fn run(mut self, context: &mut Context) -> Result<(), Failure> {
        self.preset()?;
        self.check_options()?;
        let looks = self.look.is_wanted();
        if looks && (self.way.resume || self.way.picture.is_some() || self.way.record.is_some()) {
            return Err(
                Failure::usage("--resume, --picture and --record need a run")
                    .hint("remove --check, --estimate, --preview and --dry-run"),
            );
        }
        if self.way.tui {
            self.check_terminal(looks, context)?;
        }
        let opened = self.opened()?;
        if self.look.list_parts {
            return self.list_parts(opened, &Where::Nowhere, context);
        }
        let place = match self.place(looks, context) {
            Ok(place) => place,
            Err(no_arm) => {
                // What is wrong with the file would be wrong with every arm.
                let read = self.read(opened, &Where::Nowhere, context)?;
                self.made(read, &Where::Nowhere, context)?;
                return Err(no_arm);
            }
        };
        let framed = self.framed(&place, context)?;
        let framed: Vec<_> = framed.into_iter().collect();
        notes(&opened.source, &framed, context);
        self.told_first = framed;
        let read = self.read(opened, &place, context)?;
        let picture = self.picture(&place, context)?;
        let made = self.made(read, &place, context)?;
        let from = self.way.from.map_or(0, |step| step - 1);
        let there = made.program.has(from);
        there.map_err(|problem| Failure::usage(problem.to_string()))?;
        let goes_on = made.program.depends_on_start(from)
            || self.way.resume && made.program.depends_throughout();
        if made.start.is_some() && goes_on {
            return Err(needs_start());
        }
        if !looks {
            self.check_pauses(&made, from, context)?;
        }
        let look = show::Shown {
            made: &made,
            from,
            look: &self.look,
        };
        match place {
            Where::Nowhere => look.show(made.start_on_stage()?, context),
            Where::Arm if looks => look.show(made.start_here(context)?, context),
            Where::Stage(speed) => self.run_on_stage(&made, speed, picture, context),
            Where::Arm => self.run_on_arm(&made, context),
        }
    }

    /// A job that waits for a person wants somebody who can go on with it.
    fn check_pauses(&self, made: &Made, from: u64, context: &Context) -> Result<(), Failure> {
        let plan = made.program.plan();
        let goes_over_again = self.way.resume || made.program.iterations() != Some(1);
        let first = if goes_over_again { 0 } else { from };
        let mut ahead = plan.pauses().filter(|(step, _)| *step as u64 >= first);
        let Some((step, pause)) = ahead.next() else {
            return Ok(());
        };
        if self.input(context).can_answer(self.way.tui) {
            return Ok(());
        }
        let text = visible_lines(&pause.text);
        let message = format!(
            "the job would pause at step {} ({text}), and nobody can resume it",
            step + 1
        );
        Err(Failure::usage(message).hint("run it at a terminal or with --json, or add --no-pause"))
    }

    /// Whether the whole terminal can be had.
    fn check_terminal(&self, looks: bool, context: &Context) -> Result<(), Failure> {
        let refused = if looks {
            Some("--tui needs a run")
        } else if context.global.json {
            Some("--tui cannot be used with --json")
        } else if context.in_shell() {
            Some("--tui needs the whole terminal, which the shell uses")
        } else if self.file.file == Path::new("-") {
            Some("--tui needs the keyboard, and stdin is the file")
        } else {
            None
        };
        match refused {
            Some(message) => Err(Failure::usage(message).hint("remove --tui")),
            None => terminal::check("--tui", "remove --tui"),
        }
    }

    /// What it is called on the whole terminal.
    fn verb(&self, made: &Made) -> &'static str {
        match self.options.work {
            _ if self.options.frame.is_some() => "frame",
            _ if made.format == Format::TestGrid => "testgrid",
            Some(WorkOption::Draw) => "draw",
            Some(WorkOption::Engrave) => "engrave",
            _ if made.format == Format::Playback => "play",
            _ => "run",
        }
    }

    /// Runs it on a virtual arm of its own.
    fn run_on_stage(
        &self,
        made: &Made,
        speed: SimSpeed,
        picture: Option<Picture>,
        context: &mut Context,
    ) -> Result<(), Failure> {
        let stage = made.stage()?;
        let (arm, pace) = match speed {
            SimSpeed::Times(times) => {
                let arm = VirtualArm::new(stage, speed);
                context.put_up(arm.clone());
                (arm, times)
            }
            // A recorder needs time to pass for itself too, not for the arm alone.
            SimSpeed::Max if self.way.record.is_some() => {
                let arm = VirtualArm::new(stage, SimSpeed::Times(1.0));
                context.put_up_in_arm_time(arm.clone());
                (arm, f64::INFINITY)
            }
            SimSpeed::Max => {
                let arm = VirtualArm::from(stage).in_virtual_time();
                context.put_up(arm.clone());
                (arm, f64::INFINITY)
            }
        };
        let outcome = self.go(
            &self.drive(made, Some(pace), context),
            JobPolicy::Dark,
            context,
        );
        // What was drawn is there however it ended.
        let mut options = PictureOptions::default().whole(self.way.whole);
        options.sheet = made.paper();
        let drawn = picture.map(|picture| arm.with(|arm| picture.keep(&arm.drawing(), &options)));
        let done = outcome?;
        drawn.transpose()?;
        self.tell(&done, made, context)
    }

    /// Runs it on an arm that is there.
    fn run_on_arm(&self, made: &Made, context: &mut Context) -> Result<(), Failure> {
        let asks = match self.file.file == Path::new("-") {
            true => Asks::Never,
            false => Asks::AtTheTerminal,
        };
        if self.way.keep {
            context.permit_queue()?;
        }
        if !self.way.resume {
            made.confirm_unusual(self.way.from.map_or(0, |step| step - 1), asks, context)?;
        }
        let pins = context.laser_pins()?;
        let burns = made
            .program
            .plan()
            .commands()
            .any(|command| burns(&command, pins));
        let policy = if burns {
            context.permit_laser(asks)?;
            JobPolicy::Burning
        } else {
            JobPolicy::Dark
        };
        let done = self.go(&self.drive(made, None, context), policy, context)?;
        self.tell(&done, made, context)
    }

    /// Decides what a frame goes round, by the tool in force on the arm; what has to be said of it.
    fn framed(
        &mut self,
        place: &Where,
        context: &mut Context,
    ) -> Result<Option<Diagnostic>, Failure> {
        if self.options.frame.is_none() || self.options.work.is_some() {
            return Ok(None);
        }
        let config = context.config()?;
        let defaults = place.defaults(&config, self.runs)?;
        let in_force = match place {
            Where::Arm if self.options.tool.is_none() => {
                let tool = context.arm(StopPolicy::Look, async |arm, _| {
                    Ok(arm.get::<EndEffectorParams>().await?)
                })?;
                Some(Tool::from(&tool))
            }
            _ => None,
        };
        Ok(self.options.frame_for(&defaults, in_force))
    }

    /// What flags and settings say of how the file is to be done.
    fn setup(&self, place: &Where, context: &mut Context) -> Result<Setup, Failure> {
        let config = context.config()?;
        let defaults = place.defaults(&config, self.runs)?;
        Ok(self.options.setup(&defaults))
    }

    /// Makes a program of what was in the file.
    fn made(&self, read: Read, place: &Where, context: &mut Context) -> Result<Made, Failure> {
        let Read {
            source,
            mut file,
            standing,
        } = read;
        let format = file.format;
        let of_preset: Vec<_> = self.preset_note.iter().cloned().collect();
        notes(&source, &of_preset, context);
        let mut told = self.told_first.clone();
        told.extend(of_preset);
        told.append(&mut file.notes);
        let start = (file.begun.as_ref())
            .filter(|begun| !begun.said)
            .map(|begun| begun.at);
        let config = context.config()?;
        let defaults = place.defaults(&config, self.runs)?;
        let mut setup = self.options.setup(&defaults);
        setup.fence = context.fence();
        // A drawing that does not fit is a finding of the check; an unknown surface is an error.
        let fails = self.look.checks() && setup.known_surface().is_some();
        let refused = |problem: Diagnostic| {
            let mut failure = source.failure(&problem);
            if fails {
                failure.kind = Kind::CheckFailed;
            }
            failure
        };
        let laid = self.options.lay(&setup, file);
        let runs = matches!(place, Where::Arm) && !self.look.is_wanted();
        if let Err(problem) = &laid
            && problem.lacks_surface()
            && runs
        {
            // A surface is found with an arm that is homed: that comes first.
            let unhomed = self.way.unhomed;
            context.arm(StopPolicy::Look, async |arm, _| {
                homed(arm, unhomed).await.map(drop)
            })?;
        }
        let mut laid = laid.map_err(|problem| refused(problem).noted(&told))?;
        notes(&source, &laid.notes, context);
        told.append(&mut laid.notes);
        let (placed, would_fit) = (laid.placed, laid.would_fit);
        let misfit = laid.misfit.take();
        let misfit = match self.look.is_wanted() {
            true => misfit,
            false => misfit.map_or(Ok(None), |misfit| Err(refused(misfit).noted(&told)))?,
        };
        let ending = (self.options).ending(&defaults, self.options.is_drawing(&setup, format));
        let loops = match self.repeats {
            true => None,
            false => Some(self.way.loops.unwrap_or(1)).filter(|loops| *loops > 0),
        };
        let program = laid.program(&self.options, &ending, self.pause, loops);
        let program = program.map_err(refused)?;
        if program.plan().steps.is_empty() {
            return Err(Failure::invalid(format!(
                "{}: nothing to do in this file",
                source.name
            )));
        }
        Ok(Made {
            ending,
            source,
            setup,
            program,
            start,
            standing,
            notes: told,
            placed,
            misfit,
            would_fit,
            format,
            verbose: context.global.verbose > 0,
        })
    }

    /// Reads it and makes a plan of it, for verbs that do not run it.
    pub(crate) fn plan(
        &mut self,
        context: &mut Context,
    ) -> Result<(Source, Plan, Vec<Diagnostic>), Failure> {
        self.preset()?;
        let read = self.read(self.opened()?, &Where::Nowhere, context)?;
        let made = self.made(read, &Where::Nowhere, context)?;
        Ok((made.source, made.program.into_plan(), made.notes))
    }

    /// Where it is tried or run. A port that only the file of settings names is not needed for a look.
    fn place(&self, looks: bool, context: &mut Context) -> Result<Where, Failure> {
        if context.global.station.is_some() {
            return Ok(Where::Arm);
        }
        let given = context
            .global
            .port
            .as_deref()
            .is_some_and(|port| !port.is_empty());
        if looks && !given && !context.is_connected() {
            return Ok(Where::Nowhere);
        }
        Ok(match context.target(None)? {
            Target::Sim(_) if looks && !context.is_connected() => Where::Nowhere,
            Target::Sim(speed) if !context.is_connected() => Where::Stage(speed),
            _ => Where::Arm,
        })
    }

    /// The picture that was asked for, known to be writable.
    fn picture(&self, place: &Where, context: &Context) -> Result<Option<Picture>, Failure> {
        let Some(path) = &self.way.picture else {
            return Ok(None);
        };
        match place {
            Where::Stage(_) => {}
            _ if context.is_connected() => {
                return Err(Failure::usage(
                    "--picture needs a virtual arm of its own, not that of a shell",
                ));
            }
            _ => {
                let message = "--picture needs a virtual arm in this process";
                let hint = "use --port sim; `magician sim --picture` shows what an arm that it serves has drawn";
                return Err(Failure::usage(message).hint(hint));
            }
        }
        let picture = Picture::at(path.clone()).map_err(Failure::usage)?;
        picture.check(None)?;
        Ok(Some(picture))
    }

    fn drive<'a>(&'a self, made: &'a Made, pace: Option<f64>, context: &Context) -> Drive<'a> {
        let way = &self.way;
        Drive {
            made,
            from: way.from,
            resume: way.resume,
            overlap: way.overlap.unwrap_or_default(),
            keep: way.keep,
            windowed: context.global.window.is_some_and(|window| window > 1),
            require_homed: way.require_homed,
            unhomed: way.unhomed,
            record: way.record.as_deref(),
            rate: way.rate.unwrap_or(RATE),
            units: way.units,
            json: context.global.json,
            tui: way.tui,
            repeats: self.repeats,
            verb: self.verb(made),
            at_station: context.global.station.is_some(),
            lasting: pace.is_none(),
            pace,
        }
    }

    /// Runs it.
    fn go(
        &self,
        drive: &Drive<'_>,
        policy: JobPolicy,
        context: &mut Context,
    ) -> Result<Ran, Failure> {
        let saved = context.saved.clone();
        let input = self.input(context);
        context.job(policy, async |arm, out, signals| {
            drive.run(arm, out, &saved, signals, input).await
        })
    }

    /// How it ended.
    fn tell(&self, ran: &Ran, made: &Made, context: &mut Context) -> Result<(), Failure> {
        let done = match ran {
            Ran::Done(done) => done,
            Ran::Stopped(stopped) => return stopped.show(context),
        };
        // One that is not complete is told of as an error; the file of that name may be an older one.
        let record = self.way.record.as_ref();
        let record = record.filter(|_| done.unrecorded.is_none());
        let files = [("picture", self.way.picture.as_ref()), ("record", record)];
        let files = files.map(|(name, path)| (name, path.map(|path| path.display().to_string())));
        show::done(done, made, &files, context)?;
        match &done.unrecorded {
            Some(why) => Err(incomplete("recording", &why.message)),
            None => Ok(()),
        }
    }
}

impl Made {
    /// The corners of the page or the sheet that it lies on, as far as one is known.
    fn paper(&self) -> Option<Vec<[f64; 2]>> {
        let page = self.placed.and_then(|placed| placed.page);
        let sheet = || self.setup.sheet.and_then(|sheet| show::corners(&sheet));
        page.map(Vec::from).or_else(sheet)
    }

    /// A virtual arm that is ready for it.
    fn stage(&self) -> Result<Controller, Failure> {
        let mut options = RehearseOptions::default();
        options.tool = self.setup.tool.or(self.setup.default_tool);
        options.standing = self.standing;
        Ok(stage(self.program.plan(), &options)?)
    }

    /// What such an arm says of itself.
    fn start_on_stage(&self) -> Result<Preflight, Failure> {
        let options = Options::default().fence(self.setup.fence);
        let arm = blocking::Arm::simulated(self.stage()?, options)?;
        Ok(arm.preflight_for(&self.program.kinds())?)
    }

    /// What the arm at the port says of itself.
    fn start_here(&self, context: &mut Context) -> Result<Preflight, Failure> {
        let kinds = self.program.kinds();
        context.arm(StopPolicy::Look, async |arm, _| {
            Ok(arm.preflight_for(&kinds).await?)
        })
    }
}

/// A program that goes on where all depends on where it was begun needs to know that place.
fn needs_start() -> Failure {
    let message = "this program depends on where the tool was when it began, and the tool has \
        moved since";
    Failure::usage(message).hint("add --start X,Y,Z as printed by the interrupted run")
}

/// What was read in a certain way, for people: a line each, and with `-v` the place in the file.
pub(crate) fn notes(source: &Source, notes: &[Diagnostic], context: &Context) {
    if context.global.json {
        return;
    }
    // In which order lines are drawn is of no use to most people.
    let all = context.global.verbose > 0;
    let is_told = |note: &&Diagnostic| all || note.code != DiagnosticCode::Reordered;
    let notes: Vec<_> = notes.iter().filter(is_told).collect();
    for note in notes.iter().take(NOTES) {
        match context.global.verbose {
            0 => say(&line_of(source, note)),
            _ => say(&source.draw(note, Severity::Note)),
        }
    }
    if notes.len() > NOTES {
        say(&format!("and {} more notes", notes.len() - NOTES));
    }
}

fn line_of(source: &Source, note: &Diagnostic) -> String {
    let text = advised(&Command, format!("{}: {note}", source.short_name()), note);
    let paint = Paint::for_stderr();
    format!("{} {}", paint.note("note:"), visible_lines(&text))
}

/// A closed stderr is no reason to stop.
fn say(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

impl PreviewFlags {
    /// Whether what the arm cannot do is a check that failed: a picture of it is asked for to see that.
    fn checks(&self) -> bool {
        self.check || self.preview.is_some()
    }

    /// Whether anything is to be looked at.
    pub(crate) fn is_wanted(&self) -> bool {
        let listed = self.list_parts;
        self.check || self.estimate || self.preview.is_some() || self.dry_run || listed
    }
}
