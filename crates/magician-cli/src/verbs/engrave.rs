//! `engrave`: an image or a drawing with the laser.

use clap::{Args, ValueEnum};
use magician_program::{FrameShape, ModeOption, SetupOptions, WorkOption};

use super::job::Job;
use super::job::options::{
    DrawingFlags, File, ImageFlags, LaserFlags, PlacementOptions, PreviewFlags, RunFlags,
    SpeedFlag, frame_power, positive,
};
use crate::context::Context;
use crate::failure::Failure;

/// Burn a file with the laser: an image line by line, or a drawing
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician engrave photo.png --width 60 --preview out.png
  magician engrave --frame photo.png --width 60    go round it first, with the laser off
  magician engrave photo.png --width 60 --power 5..70 --yes
  magician engrave logo.svg --power 80 --speed 10 --yes
  magician engrave job.gcode --power 50 --check
  magician engrave photo.png --mode dither --spacing 0.25 --port sim --picture out.png

A laser blinds and starts fires: wear goggles for its wavelength, keep the space behind the work clear, and never leave it alone. On a real arm \
nothing burns without --yes; --check, --estimate and --preview move nothing.")]
pub(crate) struct Verb {
    #[command(flatten)]
    file: File,
    /// Go round what would be burnt, with the laser off: its box, its convex hull, or its outline (see `magician frame`) [default shape: box]
    #[arg(
        long,
        value_name = "SHAPE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "box",
        value_parser = str::parse::<FrameShape>
    )]
    frame: Option<FrameShape>,
    /// With --frame: light the laser on the way with P percent, 5 at most; needs --yes
    #[arg(long, value_name = "P", requires = "frame", value_parser = frame_power)]
    frame_power: Option<f64>,
    /// With --frame: go round until Ctrl-C
    #[arg(long, requires = "frame", conflicts_with = "loops")]
    repeat: bool,
    #[command(flatten)]
    look: PreviewFlags,
    #[command(flatten)]
    beam: LaserFlags,
    #[command(flatten)]
    laser: Laser,
    #[command(flatten)]
    image: ImageFlags,
    #[command(flatten)]
    drawing: DrawingFlags,
    #[command(flatten)]
    place: PlacementOptions,
    #[command(flatten)]
    speed: SpeedFlag,
    #[command(flatten)]
    way: RunFlags,
}

/// How it burns.
#[derive(Args, Debug)]
#[command(next_help_heading = "The laser")]
pub(crate) struct Laser {
    /// How grey levels become power [default: grey]
    #[arg(long, value_enum, value_name = "MODE")]
    mode: Option<Mode>,
    /// With --mode threshold: burn what is darker than this, 1 to 255 [default: 128]
    #[arg(long, value_name = "GREY", value_parser = clap::value_parser!(u8).range(1..))]
    threshold: Option<u8>,
    /// Burn all lines in the same direction: slower, but free of backlash
    #[arg(long)]
    one_way: bool,
    /// Run-up and run-out of the tool at the ends of a line, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    overscan: Option<f64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Mode {
    /// More power where it is darker
    Grey,
    /// Full power for dark pixels, none for the rest
    Threshold,
    /// Dots of full power, denser where it is darker
    Dither,
}

impl Laser {
    /// Says it as options.
    pub(crate) fn say(&self, options: &mut SetupOptions) {
        options.mode = self.mode.map(|mode| match mode {
            Mode::Grey => ModeOption::Grey,
            Mode::Threshold => ModeOption::Threshold,
            Mode::Dither => ModeOption::Dither,
        });
        options.threshold = self.threshold;
        options.one_way = self.one_way;
        options.overscan = self.overscan;
    }
}

impl Verb {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        self.job().run(context)
    }

    /// What its flags say.
    pub(super) fn job(self) -> Job {
        let engrave = WorkOption::Engrave;
        let mut job = Job::new(engrave, self.file, self.look, &self.place, self.way);
        self.speed.say(&mut job.options);
        self.beam.say(&mut job.options);
        self.laser.say(&mut job.options);
        self.image.say(&mut job.options);
        self.drawing.say(&mut job.options);
        job.options.frame = self.frame;
        job.options.frame_power = self.frame_power;
        job.repeats = self.repeat;
        job
    }
}
