//! Options for drawing, engraving and running a file, as plain data: flags of the command, keyword
//! arguments of Python, `setup` of a station. Each option has one name, one meaning, and one row of
//! [`table`].

mod fields;
mod framed;
mod grid;
mod pens;
mod spec;
mod table;
mod value;

pub use fields::OptionError;
pub use grid::Grid;
use magician_host::{Message, message};
use magician_host::{Set, build};
pub use pens::{PenMatch, PenOptions};
pub use spec::{DefaultValue, Need, OptionGroup, OptionKind, OptionSpec};
pub use table::SetupOptions;

use crate::artwork::{Marking, Sheet, Tidy};
use crate::fill::{FillMode, Filling};
use crate::formats::Dialect;
use crate::lettering::TextOptions;
use crate::raster::{Adjust, Engrave, Size, Tone, Trace};
use crate::{
    Action, Ending, Fills, Frame, Framing, Page, PartRule, Placement, Plan, Power, ReadOptions,
    Setup, Surface, SystemFonts, Tool, Work,
};
use magician_formats::keywords::keywords;

/// Acceleration on paths if a speed is given, as at power-up, mm/s2.
const PATH_ACCELERATION: f32 = 100.0;

/// Kind of work to make of drawings and images, if given.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum WorkOption {
    /// Draw everything with a pen.
    Draw,
    /// Engrave everything with the laser.
    Engrave,
    /// Draw drawings, engrave images, and run other files as they are.
    ByFile,
}

impl WorkOption {
    /// Names of the kinds that a user can choose.
    pub const NAMES: &'static [&'static str] = &["draw", "engrave"];

    /// Returns why an option of this work does not apply, if the other work was chosen.
    fn excluded_by(self, asked: Option<Self>) -> Option<Message> {
        match (self, asked) {
            (Self::Engrave, Some(Self::Draw)) => Some(message!("the laser engraves: work is draw")),
            (Self::Draw, Some(Self::Engrave)) => Some(message!("the pen draws: work is engrave")),
            _ => None,
        }
    }

    /// Values of the option `work` that make options of this work applicable.
    fn values(self) -> &'static [&'static str] {
        match self {
            Self::Draw => &["draw"],
            Self::Engrave => &["engrave"],
            Self::ByFile => Self::NAMES,
        }
    }
}

/// Conversion of grey levels to power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ModeOption {
    /// Power proportional to darkness.
    Grey,
    /// Full power for dark pixels, no power for others.
    Threshold,
    /// Dots of full power, denser in dark areas.
    Dither,
}

keywords! {
    ModeOption, "mode":
    Grey = "grey",
    Threshold = "threshold",
    Dither = "dither",
}

/// Defaults from the settings, for omitted options.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SetupDefaults {
    /// Tool usually mounted on the arm.
    pub tool: Option<Tool>,
    /// Sheet for drawings.
    pub sheet: Option<Sheet>,
    /// Work surface for drawings and images.
    pub surface: Option<Surface>,
    /// Surface assumed if none is known: the table of a virtual arm.
    pub assumed_surface: Option<Surface>,
    /// Drawing speed of the pen, mm/s.
    pub draw_speed: Option<f64>,
    /// Travel speed of the pen between lines, mm/s.
    pub draw_travel_speed: Option<f64>,
    /// Pen lift between lines, mm.
    pub draw_lift: Option<f64>,
    /// Laser speed on drawings and images, mm/s.
    pub engrave_speed: Option<f64>,
    /// Full laser power.
    pub engrave_power: Option<Power>,
    /// Parking position of the tool tip at the end, mm.
    pub park: Option<[f64; 3]>,
}

impl SetupOptions {
    /// Options for a file that is run as it is: only the settings apply.
    #[must_use]
    pub fn by_file() -> Self {
        Self {
            work: Some(WorkOption::ByFile),
            ..Self::default()
        }
    }

    /// Returns the setup for the file.
    #[must_use]
    pub fn setup(&self, defaults: &SetupDefaults) -> Setup {
        let usual = Marking::pen();
        let placement = Placement {
            frame: match (self.place, self.raw) {
                (_, true) => Frame::Arm,
                (true, _) => Frame::Own,
                _ => Frame::Default,
            },
            pen_z: self.pen_z,
            at: self.at,
            page: self.page_with_margin(),
            grid: self.grid,
            scale: self.scale.unwrap_or(1.0),
            rotate: self.rotate.unwrap_or(0.0),
            fit: self.fit,
            turn: self.turn.unwrap_or(true),
            mirror: self.mirror,
            keeps_page: false,
            by: self.by.unwrap_or_default(),
        };
        let speed = |said: Option<f64>, usual| said.map_or(usual, |speed| speed as f32);
        Setup {
            tool: self.tool,
            default_tool: defaults.tool,
            surface: self.surface.map(Surface::level),
            default_surface: defaults.surface,
            assumed_surface: defaults.assumed_surface,
            sheet: defaults.sheet,
            placement,
            pen: Marking {
                lift: self.lift_or_default(defaults),
                hop: self.hop.or(usual.hop),
                speed: speed(defaults.draw_speed, usual.speed),
                travel: speed(
                    self.travel_speed.or(defaults.draw_travel_speed),
                    usual.travel,
                ),
                ..usual
            },
            tidy: self.tidy(),
            tidy_programs: self.dedupe == Some(true),
            order: self.order.unwrap_or(true),
            work: self.work(defaults),
            engrave: self.engrave(),
            size: self.size(),
            adjust: self.adjust(defaults),
            speed: self.speed.map(|speed| speed as f32),
            laser_speed: defaults.engrave_speed,
            filling: self.filling(),
            power: self.power,
            default_power: defaults.engrave_power,
            parts: self.parts,
            only: self.only.clone(),
            passes: self.passes,
            pens: self.pens.iter().map(PartRule::from).collect(),
            no_pause: self.no_pause,
            fence: None,
            framing: self.frame.map(|shape| Framing {
                power: self.frame_power,
                ..Framing::of(shape)
            }),
            depths: self.depths.unwrap_or_default(),
        }
    }

    /// Page with its margin, if one was given.
    pub(super) fn page_with_margin(&self) -> Option<Page> {
        let mut page = Page::of(self.page?);
        page.margin = self.margin.unwrap_or(page.margin);
        Some(page)
    }

    /// Returns the options for reading the file.
    #[must_use]
    pub fn reading(&self, setup: &Setup) -> ReadOptions {
        let mut options = ReadOptions::default();
        options.tolerance = self.tolerance.unwrap_or(options.tolerance);
        options.scale = self.scale.unwrap_or(options.scale);
        options.white = self.white.unwrap_or_default();
        options.clip_page = self.clip_page;
        let fills = |pen: &PenOptions| pen.fill.is_some_and(|mode| mode != FillMode::None);
        if self.filling().mode != FillMode::None || self.pens.iter().any(fills) {
            options.fills = Fills::Areas;
        }
        options.resample = self.resample;
        options.crop = self.crop;
        options.text = self.text_options();
        options.text_lines = self.text.unwrap_or_default();
        options.system_fonts = self.system_fonts.unwrap_or(SystemFonts::On);
        options.strict_text = self.strict_text;
        setup.set_gcode_options(&mut options.gcode, setup.known_surface());
        // A full-power value of S exists only in laser G-code.
        let of_laser = self.s_max.map(|_| Dialect::Laser);
        options.gcode.dialect = self.dialect.or(of_laser).unwrap_or_default();
        options.gcode.burns = matches!(setup.work, Work::Engrave(_));
        options.gcode.s_max = self.s_max;
        options.gcode.laser_speed = setup.laser_speed.unwrap_or(options.gcode.laser_speed);
        options
    }

    /// Options for tidying the lines of a drawing.
    fn tidy(&self) -> Tidy {
        let mut tidy = Tidy::default();
        tidy.merge = self.merge.unwrap_or(tidy.merge);
        tidy.dedupe = self.dedupe.unwrap_or(tidy.dedupe);
        tidy.simplify = self.simplify.unwrap_or(tidy.simplify);
        tidy
    }

    /// Options for filling shapes.
    fn filling(&self) -> Filling {
        let mut filling = Filling::default();
        filling.mode = self.fill.unwrap_or_default();
        filling.spacing = self.fill_spacing;
        filling.angle = self.fill_angle;
        filling.inset = self.fill_inset;
        filling
    }

    /// Options for setting text.
    fn text_options(&self) -> TextOptions {
        let mut text = TextOptions::default();
        text.font = self.font.clone().unwrap_or(text.font);
        text.size = self.size.unwrap_or(text.size);
        text.wrap = self.wrap;
        text.align = self.align.unwrap_or(text.align);
        text.line_height = self.line_height.unwrap_or(text.line_height);
        text
    }

    /// Ending of pen and arm; `drawing` as in [`Ending::drawing`].
    #[must_use]
    pub fn ending(&self, defaults: &SetupDefaults, drawing: bool) -> Ending {
        Ending {
            lift: self.lift_or_default(defaults),
            stay: self.stay,
            drawing,
            park: self.park.or(defaults.park).filter(|_| !self.stay),
            depths: self.depths.unwrap_or_default(),
        }
    }

    /// Kind of work: as given, or derived from the tool.
    fn choice(&self, defaults: &SetupDefaults) -> WorkOption {
        self.work
            .unwrap_or_else(|| match self.tool.or(defaults.tool) {
                // Options for drawing an image imply a pen, unless the laser was named explicitly.
                _ if self.image.is_some() && self.tool != Some(Tool::Laser) => WorkOption::Draw,
                Some(Tool::Laser) => WorkOption::Engrave,
                _ => WorkOption::Draw,
            })
    }

    fn work(&self, defaults: &SetupDefaults) -> Work {
        match self.choice(defaults) {
            WorkOption::ByFile if self.image.is_none() => Work::Default,
            WorkOption::Draw | WorkOption::ByFile => {
                let mut trace = Trace::default();
                trace.level = self.threshold.unwrap_or(trace.level);
                trace.tolerance = self.tolerance.unwrap_or(trace.tolerance);
                trace.style = self.image.unwrap_or_default();
                trace.levels = self.levels;
                trace.despeckle = self.despeckle.unwrap_or(trace.despeckle);
                trace.spacing = self.spacing;
                trace.pen_width = self.pen_width.unwrap_or(trace.pen_width);
                Work::Draw(trace)
            }
            WorkOption::Engrave => Work::Engrave(self.engrave()),
        }
    }

    /// Adjustments of an image's grey levels before anything else. For engraving, inversion and
    /// gamma are applied with the power instead.
    fn adjust(&self, defaults: &SetupDefaults) -> Adjust {
        let mut adjust = Adjust::default();
        adjust.brightness = self.brightness.unwrap_or(adjust.brightness);
        adjust.contrast = self.contrast.unwrap_or(adjust.contrast);
        if let Work::Draw(_) = self.work(defaults) {
            adjust.invert = self.invert;
            adjust.gamma = self.gamma.unwrap_or(adjust.gamma);
        }
        adjust
    }

    fn engrave(&self) -> Engrave {
        let usual = Engrave::default();
        Engrave {
            tone: match self.mode {
                None | Some(ModeOption::Grey) => Tone::Grey,
                Some(ModeOption::Threshold) => Tone::Threshold(self.threshold.unwrap_or(128)),
                Some(ModeOption::Dither) => Tone::Dither,
            },
            invert: self.invert,
            both_directions: !self.one_way,
            spacing: self.spacing.unwrap_or(usual.spacing),
            overscan: self.overscan.or(usual.overscan),
            gamma: self.gamma.unwrap_or(usual.gamma),
            ..usual
        }
    }

    fn size(&self) -> Size {
        match (self.width, self.height) {
            (Some(width), _) => Size::Width(width),
            (None, Some(height)) => Size::Height(height),
            (None, None) => Size::Natural,
        }
    }

    fn lift_or_default(&self, defaults: &SetupDefaults) -> f64 {
        let lift = self.lift.or(defaults.draw_lift);
        lift.unwrap_or(Marking::pen().lift)
    }

    /// Settings to send before the commands of the plan. `taught` is true for a plan in arm
    /// coordinates.
    pub(crate) fn settings(&self, plan: &mut Plan, taught: bool) -> Vec<Set> {
        let mut settings = Vec::new();
        if let Some(ratio) = self.speed_ratio {
            settings.push(plan.moves_at(ratio as f32));
        }
        let path = |action: &Action| matches!(action, Action::Path { .. } | Action::Burn { .. });
        if let Some(speed) = self.speed.filter(|_| taught)
            && plan.steps.iter().any(|step| path(&step.action))
        {
            settings.push(build::path_speed(speed as f32, PATH_ACCELERATION));
        }
        settings
    }
}
