//! Common path of all verbs that run a file: read it, place it, check it, then show it or run it.
//!
//! A file is parsed before an arm is looked for, so that a wrong file is reported without one.
//! Without a port, `--check` and the other previews assume an arm that was just homed; a port or a
//! station supplies the arm's real position and settings. `sim` runs the program on a virtual arm
//! of this process, with a real arm's checks.

mod defaults;
mod input;
mod job_run;
mod keys;
mod list_parts;
#[cfg(test)]
mod option_tests;
pub(crate) mod options;
mod progress_reporter;
mod reading;
mod report;
mod running_job;
mod show;
mod suspend;
mod tui;
mod unusual;
mod wording;

use std::io::{self, Write};
use std::path::Path;

use magician::preflight::Preflight;
use magician::sim::Controller;
use magician::{Options, SimSpeed, Target, VirtualArm, blocking, burns};
use magician_job::report::with_advice;
use magician_picture::DrawingOptions;
use magician_program::rehearse::{RehearseOptions, stage};
use magician_program::{
    Diagnostic, DiagnosticCode, Format, Plan, PreparedProgram, SetupOptions, WorkOption,
};
use magician_protocol::visible_lines;

use self::job_run::{DEFAULT_RECORD_RATE, JobRun, RunEnd};
use self::options::{File, OptionFlags, PreviewFlags, RunFlags};
use crate::context::{Context, JobPolicy, StopPolicy};
use crate::diagnostics::Severity;
use crate::failure::{Failure, incomplete};
use crate::paint::Paint;
use crate::permission::ConfirmationSource;
use crate::source::Source;
use crate::terminal;
use crate::verbs::preset;
use crate::verbs::sim::picture::Picture;
use crate::voice::Command;

pub(crate) use defaults::defaults;
#[cfg(test)]
pub(super) use tui::examples;

/// Largest number of notes shown. A choice: the rest is counted.
const MAX_NOTES: usize = 10;

/// File with everything that flags say about it.
#[derive(Debug)]
pub(crate) struct Job {
    pub(crate) file: File,
    /// Text or test grid from the command line, instead of the file's content.
    pub(crate) text: Option<String>,
    pub(crate) look: PreviewFlags,
    pub(crate) way: RunFlags,
    /// Options of drawing and engraving from flags.
    pub(crate) options: SetupOptions,
    /// Pause at the end of each loop, ms.
    pub(crate) pause: u32,
    /// True if the job is run or previewed; false if it is converted into another file.
    pub(crate) runs: bool,
    /// True if it repeats until it is stopped, which is its regular end.
    pub(crate) repeats: bool,
    /// Note of the preset for people.
    preset_note: Option<Diagnostic>,
}

/// File whose program is ready to be shown or run.
struct PreparedJob {
    source: Source,
    prepared: PreparedProgram,
    /// True if every refused step is shown.
    verbose: bool,
}

/// Place where a program is checked or run.
enum RunPlace {
    /// No arm: checked for an arm that was just homed.
    NoArm,
    /// Virtual arm in this process.
    VirtualArm(SimSpeed),
    /// Arm at a port or a station.
    Arm,
}

impl Job {
    /// Creates the job of a file from its flags.
    ///
    /// # Errors
    /// Returns a usage error if an option is invalid.
    pub(crate) fn new<V>(
        work: impl Into<Option<WorkOption>>,
        file: File,
        look: PreviewFlags,
        flags: &OptionFlags<V>,
        way: RunFlags,
    ) -> Result<Self, Failure> {
        let mut options = flags.options(way.preset.is_some())?;
        options.work = work.into();
        Ok(Self {
            file,
            text: None,
            look,
            way,
            options,
            pause: 0,
            runs: true,
            repeats: false,
            preset_note: None,
        })
    }

    /// Applies the preset to options that no flag sets.
    fn preset(&mut self) -> Result<(), Failure> {
        let Some(name) = self.way.preset.take() else {
            return Ok(());
        };
        let preset = preset::load(&name)?;
        let completed = preset.complete(&self.options, self.file.format);
        (self.options, self.preset_note) =
            completed.map_err(|error| Failure::usage(error.to_string()))?;
        Ok(())
    }

    /// Shows or runs the job.
    pub(crate) fn run(mut self, context: &mut Context) -> Result<(), Failure> {
        self.preset()?;
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
        if self.look.list_parts {
            return self.list_parts(context);
        }
        let place = self.place(looks, context);
        let parsed = self.parse_file(place.as_ref().unwrap_or(&RunPlace::NoArm), context)?;
        let place = match place {
            Ok(place) => place,
            Err(no_arm) => {
                // An error in the file would occur with any arm, so it is reported first.
                self.prepared(parsed, &RunPlace::NoArm, context)?;
                return Err(no_arm);
            }
        };
        let picture = self.picture(&place, context)?;
        let made = self.prepared(parsed, &place, context)?;
        let from = self.way.from.map_or(0, |step| step - 1);
        let there = made.prepared.program.check_step(from);
        there.map_err(|problem| Failure::usage(problem.to_string()))?;
        if made.prepared.has_lost_start(from, self.way.resume) {
            return Err(needs_start());
        }
        if !looks {
            self.check_pauses(&made, from, context)?;
        }
        let look = show::PreviewedProgram {
            made: &made,
            from,
            look: &self.look,
        };
        match place {
            RunPlace::NoArm => look.show(made.virtual_start()?, context),
            RunPlace::Arm if looks => look.show(made.arm_start(context)?, context),
            RunPlace::VirtualArm(speed) => self.run_on_virtual_arm(&made, speed, picture, context),
            RunPlace::Arm => self.run_on_arm(&made, context),
        }
    }

    /// Fails if the program pauses for the user and nobody can answer.
    fn check_pauses(
        &self,
        made: &PreparedJob,
        from: u64,
        context: &Context,
    ) -> Result<(), Failure> {
        let plan = made.prepared.program.plan();
        let goes_over_again = self.way.resume || made.prepared.program.iterations() != Some(1);
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
            "the job would pause at step {} ({text}), but could not be resumed without a terminal",
            step + 1
        );
        Err(Failure::usage(message).hint("run it at a terminal or with --json, or add --no-pause"))
    }

    /// Fails if the job cannot have the whole terminal.
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

    /// Returns the title for the full-screen picture.
    fn verb(&self, made: &PreparedJob) -> &'static str {
        match self.options.work {
            _ if self.options.frame.is_some() => "frame",
            _ if made.prepared.format == Format::TestGrid => "testgrid",
            Some(WorkOption::Draw) => "draw",
            Some(WorkOption::Engrave) => "engrave",
            _ if made.prepared.format == Format::Playback => "play",
            _ => "run",
        }
    }

    /// Runs the job on a virtual arm in this process.
    fn run_on_virtual_arm(
        &self,
        made: &PreparedJob,
        speed: SimSpeed,
        picture: Option<Picture>,
        context: &mut Context,
    ) -> Result<(), Failure> {
        let stage = made.stage()?;
        let (arm, pace) = match speed {
            SimSpeed::Times(times) => {
                let arm = VirtualArm::new(stage, speed);
                context.use_virtual(arm.clone());
                (arm, times)
            }
            // A recorder samples by timers, so timers must run by virtual time too, not only the
            // arm.
            SimSpeed::Max if self.way.record.is_some() => {
                let arm = VirtualArm::new(stage, SimSpeed::Times(1.0));
                context.use_virtual_in_arm_time(arm.clone());
                (arm, f64::INFINITY)
            }
            SimSpeed::Max => {
                let arm = VirtualArm::from(stage).in_virtual_time();
                context.use_virtual(arm.clone());
                (arm, f64::INFINITY)
            }
        };
        let outcome = self.run_under_policy(
            &self.job_run(made, Some(pace), context),
            JobPolicy::Dark,
            context,
        );
        // The picture shows the drawn part even if the job failed.
        let mut options = DrawingOptions::default().whole(self.way.whole);
        options.sheet = made.paper();
        let drawn =
            picture.map(|picture| arm.with(|arm| picture.write_one(&arm.drawing(), &options)));
        let done = outcome?;
        drawn.transpose()?;
        self.report_end(&done, made, context)
    }

    /// Runs the job on the arm at a port or a station.
    fn run_on_arm(&self, made: &PreparedJob, context: &mut Context) -> Result<(), Failure> {
        let asks = if self.file.file == Path::new("-") {
            ConfirmationSource::Never
        } else {
            ConfirmationSource::AtTheTerminal
        };
        if self.way.keep {
            context.permit_queue()?;
        }
        if !self.way.resume {
            made.confirm_unusual(self.way.from.map_or(0, |step| step - 1), asks, context)?;
        }
        let pins = context.laser_pins()?;
        let burns = made
            .prepared
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
        let done = self.run_under_policy(&self.job_run(made, None, context), policy, context)?;
        self.report_end(&done, made, context)
    }

    /// Reads the file and places it, for verbs that do not run it.
    pub(crate) fn plan(
        &mut self,
        context: &mut Context,
    ) -> Result<(Source, Plan, Vec<Diagnostic>), Failure> {
        self.preset()?;
        let parsed = self.parse_file(&RunPlace::NoArm, context)?;
        let PreparedJob {
            source, prepared, ..
        } = self.prepared(parsed, &RunPlace::NoArm, context)?;
        Ok((source, prepared.program.into_plan(), prepared.notes))
    }

    /// Returns the place to check or run. A preview ignores a port from the settings file, so that
    /// it works without the arm.
    fn place(&self, looks: bool, context: &mut Context) -> Result<RunPlace, Failure> {
        if context.global.station.is_some() {
            return Ok(RunPlace::Arm);
        }
        let given = context
            .global
            .port
            .as_deref()
            .is_some_and(|port| !port.is_empty());
        // A check needs no arm unless the user named one.
        if looks && !given && !context.is_connected() {
            return Ok(RunPlace::NoArm);
        }
        Ok(match context.target(None)? {
            Target::Sim(_) if looks && !context.is_connected() => RunPlace::NoArm,
            Target::Sim(speed) if !context.is_connected() => RunPlace::VirtualArm(speed),
            _ => RunPlace::Arm,
        })
    }

    /// Returns the picture to write, after checking that its path is writable.
    fn picture(&self, place: &RunPlace, context: &Context) -> Result<Option<Picture>, Failure> {
        let Some(path) = &self.way.picture else {
            return Ok(None);
        };
        match place {
            RunPlace::VirtualArm(_) => {}
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

    fn job_run<'a>(
        &'a self,
        made: &'a PreparedJob,
        pace: Option<f64>,
        context: &Context,
    ) -> JobRun<'a> {
        let way = &self.way;
        JobRun {
            made,
            from: way.from,
            resume: way.resume,
            overlap: way.overlap.unwrap_or_default(),
            keep: way.keep,
            windowed: context.global.window.is_some_and(|window| window > 1),
            require_homed: way.require_homed,
            unhomed: way.unhomed,
            record: way.record.as_deref(),
            rate: way.rate.unwrap_or(DEFAULT_RECORD_RATE),
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

    /// Runs the job under a policy.
    fn run_under_policy(
        &self,
        drive: &JobRun<'_>,
        policy: JobPolicy,
        context: &mut Context,
    ) -> Result<RunEnd, Failure> {
        let saved = context.saved.clone();
        let input = self.input(context);
        context.job(policy, async |arm, out, signals| {
            drive.run(arm, out, &saved, signals, input).await
        })
    }

    /// Reports how the job ended.
    fn report_end(
        &self,
        ran: &RunEnd,
        made: &PreparedJob,
        context: &mut Context,
    ) -> Result<(), Failure> {
        let done = match ran {
            RunEnd::Completed(done) => done,
            RunEnd::Stopped(stopped) => return stopped.show(context),
        };
        // An incomplete recording is reported as an error; the file of that name may be an older
        // one.
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

impl PreparedJob {
    /// Returns the corners of the page or sheet under the drawing; `None` if unknown.
    fn paper(&self) -> Option<Vec<[f64; 2]>> {
        let page = self.prepared.placed.and_then(|placed| placed.page);
        let sheet = || {
            self.prepared
                .setup
                .sheet
                .and_then(|sheet| show::corners(&sheet))
        };
        page.map(Vec::from).or_else(sheet)
    }

    /// Creates a virtual arm prepared for this program.
    fn stage(&self) -> Result<Controller, Failure> {
        let mut options = RehearseOptions::default();
        let setup = &self.prepared.setup;
        options.tool = setup.tool.or(setup.default_tool);
        options.standing = self.prepared.staged_joints;
        Ok(stage(self.prepared.program.plan(), &options)?)
    }

    /// Returns position and settings of such a virtual arm.
    fn virtual_start(&self) -> Result<Preflight, Failure> {
        let options = Options::default().fence(self.prepared.setup.fence);
        let arm = blocking::Arm::simulated(self.stage()?, options)?;
        Ok(arm.preflight_for(&self.prepared.program.kinds())?)
    }

    /// Returns position and settings of the arm at the port.
    fn arm_start(&self, context: &mut Context) -> Result<Preflight, Failure> {
        let kinds = self.prepared.program.kinds();
        context.arm(StopPolicy::Look, async |arm, _| {
            Ok(arm.preflight_for(&kinds).await?)
        })
    }
}

/// Failure of a resumed program that depends on its start position, if that is lost.
fn needs_start() -> Failure {
    let message =
        "this program depends on the start position of the tool, and the tool has moved since";
    Failure::usage(message).hint("add --start X,Y,Z as printed by the interrupted run")
}

/// Prints notes on how a file was interpreted, one line each; with `-v` also the place in the file.
pub(crate) fn notes(source: &Source, notes: &[Diagnostic], context: &Context) {
    if context.global.json {
        return;
    }
    // The order of drawing matters to few people, so this note appears only with `-v`.
    let all = context.global.verbose > 0;
    let is_told = |note: &&Diagnostic| all || note.code != DiagnosticCode::Reordered;
    let notes: Vec<_> = notes.iter().filter(is_told).collect();
    for note in notes.iter().take(MAX_NOTES) {
        match context.global.verbose {
            0 => print_line(&line_of(source, note)),
            _ => print_line(&source.draw(note, Severity::Note)),
        }
    }
    if notes.len() > MAX_NOTES {
        print_line(&format!("and {} more notes", notes.len() - MAX_NOTES));
    }
}

fn line_of(source: &Source, note: &Diagnostic) -> String {
    let text = with_advice(&Command, format!("{}: {note}", source.short_name()), note);
    let paint = Paint::for_stderr();
    format!("{} {}", paint.note("note:"), visible_lines(&text))
}

/// Prints a line to stderr. An unwritable stderr is ignored.
fn print_line(text: &str) {
    let _ = writeln!(io::stderr(), "{text}");
}

impl PreviewFlags {
    /// True if steps that the arm cannot do are failed checks: a preview is asked for to see them.
    fn checks(&self) -> bool {
        self.check || self.preview.is_some()
    }

    /// True if a preview of any kind is asked for.
    pub(crate) fn is_wanted(&self) -> bool {
        let listed = self.list_parts;
        self.check || self.estimate || self.preview.is_some() || self.dry_run || listed
    }
}
