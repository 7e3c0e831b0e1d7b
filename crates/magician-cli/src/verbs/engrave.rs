//! `engrave`: an image or a drawing with the laser.

use std::str::FromStr;

use clap::{Args, ValueEnum};
use magician_program::Work;
use magician_program::raster::{Engrave, Size, Tone};

use super::job::Job;
use super::job::options::{File, Look, Pen, Place, Way, positive};
use crate::config::Config;
use crate::context::Context;
use crate::failure::Failure;

/// Burn a file with the laser: an image line by line, a drawing along its lines
#[derive(Args, Debug)]
#[command(after_help = "\
Examples:
  magician engrave photo.png --width 60 --preview out.png
  magician engrave photo.png --width 60 --power 5..70 --yes
  magician engrave logo.svg --power 80 --speed 10 --yes
  magician engrave photo.png --mode dither --spacing 0.25 --port sim --picture out.png

A laser blinds and sets fire: goggles for its wavelength, nothing behind the wood, and somebody beside it. On a real arm \
nothing burns without --yes; --check, --estimate and --preview move nothing.")]
pub(crate) struct Verb {
    #[command(flatten)]
    file: File,
    #[command(flatten)]
    look: Look,
    #[command(flatten)]
    laser: Laser,
    #[command(flatten)]
    place: Place,
    #[command(flatten)]
    way: Way,
}

/// How it burns.
#[derive(Args, Debug)]
#[command(next_help_heading = "The laser")]
struct Laser {
    /// Power for black, percent; with two numbers also that for the lightest grey
    #[arg(long, value_name = "MOST|LEAST..MOST")]
    power: Option<Power>,
    /// How grey becomes power
    #[arg(long, value_enum, value_name = "MODE", default_value_t = Mode::Grey)]
    mode: Mode,
    /// With --mode threshold: what is darker is burnt, 1 to 255
    #[arg(long, value_name = "GREY", default_value_t = 128, value_parser = clap::value_parser!(u8).range(1..))]
    threshold: u8,
    /// Burn white and leave black
    #[arg(long)]
    invert: bool,
    /// Width of an image, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    width: Option<f64>,
    /// Height of an image, mm
    #[arg(long, value_name = "MM", value_parser = positive, conflicts_with = "width")]
    height: Option<f64>,
    /// From one line of an image to the next, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    spacing: Option<f64>,
    /// Burn all lines in the same direction: slower, and free of play
    #[arg(long)]
    one_way: bool,
    /// How far the tool runs up and out at either end of a line, mm
    #[arg(long, value_name = "MM", value_parser = positive)]
    overscan: Option<f64>,
    /// Exponent of the darkness; above 1 spares the light parts
    #[arg(long, value_name = "EXPONENT", value_parser = positive)]
    gamma: Option<f64>,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Mode {
    /// The darker, the more power
    Grey,
    /// Full power for what is dark, none for the rest
    Threshold,
    /// Dots of full power, the denser the darker
    Dither,
}

/// Least and most power, percent.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Power {
    least: Option<f64>,
    most: f64,
}

impl FromStr for Power {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| {
            let value = text.trim().trim_end_matches('%').parse::<f64>().ok();
            value.filter(|value| (0.0..=100.0).contains(value))
        };
        let parsed = match text.split_once("..") {
            Some((least, most)) => number(least).zip(number(most)),
            None => number(text).map(|most| (-1.0, most)),
        };
        let parsed = parsed.filter(|(least, most)| least <= most && *most > 0.0);
        let (least, most) =
            parsed.ok_or_else(|| "expected percent, such as 80 or 5..80".to_owned())?;
        Ok(Self {
            least: Some(least).filter(|least| *least >= 0.0),
            most,
        })
    }
}

impl Laser {
    fn engrave(&self, config: &Config) -> Engrave {
        let mut engrave = Engrave::default();
        let [least, most] = engrave.power;
        let usual = config.number("engrave.power").unwrap_or(most);
        engrave.power = match self.power {
            Some(power) => [power.least.unwrap_or(least).min(power.most), power.most],
            None => [least.min(usual), usual],
        };
        engrave.tone = match self.mode {
            Mode::Grey => Tone::Grey,
            Mode::Threshold => Tone::Threshold(self.threshold),
            Mode::Dither => Tone::Dither,
        };
        engrave.invert = self.invert;
        engrave.both_directions = !self.one_way;
        engrave.spacing = self.spacing.unwrap_or(engrave.spacing);
        engrave.overscan = self.overscan.or(engrave.overscan);
        engrave.gamma = self.gamma.unwrap_or(engrave.gamma);
        engrave.speed = config.number("engrave.speed").unwrap_or(engrave.speed);
        engrave
    }
}

impl Verb {
    pub(crate) fn run(self, context: &mut Context) -> Result<(), Failure> {
        let config = context.config()?;
        let laser = self.laser.engrave(&config);
        let size = match (self.laser.width, self.laser.height) {
            (Some(width), _) => Size::Width(width),
            (None, Some(height)) => Size::Height(height),
            (None, None) => Size::Natural,
        };
        let job = Job {
            file: self.file,
            look: self.look,
            place: self.place,
            way: self.way,
            pen: Pen::default(),
            work: Work::Engrave(laser),
            size,
            pause: 0,
        };
        job.run(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_one_number_or_two() {
        let power = |least, most| Ok(Power { least, most });
        assert_eq!("80".parse(), power(None, 80.0));
        assert_eq!("5..70%".parse(), power(Some(5.0), 70.0));
        for wrong in ["", "0", "101", "70..5", "a..b", "-5..20", "nan"] {
            assert!(wrong.parse::<Power>().is_err(), "{wrong}");
        }
    }
}
