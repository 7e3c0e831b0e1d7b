//! Parts of a drawing: division, selection and pens.

use magician_host::message;
use magician_host::{Setting, SettingValue};

use super::Setup;
use crate::artwork::{DrawingPart, PartPen};
use crate::{Action, Artwork, Color, Diagnostic, DiagnosticCode, Part, PauseCause, Plan};
use magician_formats::keywords::keywords;

/// Largest number of parts named in an error.
const MAX_NAMED_PARTS: usize = 20;
/// Largest number of passes.
pub(crate) const MAX_PASSES: u32 = 1000;

/// Division of a drawing into parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PartMode {
    /// No parts.
    None,
    /// By layer, pen or tool.
    Layer,
    /// By colour.
    Color,
}

keywords! {
    PartMode, "parts":
    None = "none",
    Layer = "layer",
    Color = "color",
}

/// Pen, and the parts that it draws.
#[derive(Clone, Debug, PartialEq)]
pub struct PartRule {
    /// Selection of the parts.
    pub matches: PartMatch,
    /// Properties of the pen.
    pub pen: PartPen,
    /// Number of passes over its parts.
    pub passes: Option<u32>,
}

/// Selection of parts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PartMatch {
    /// By name or colour.
    Name(String),
    /// By number, from 1.
    Number(u64),
}

impl PartMatch {
    fn selects(&self, part: &DrawingPart) -> bool {
        match self {
            Self::Name(name) => part.has_name(name) || part.has_color(name.parse().ok()),
            Self::Number(n) => part.part.n == *n,
        }
    }
}

/// Plotter commands at the start of a layer's name: `%` skips the layer, `!` pauses before it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct LayerCommands {
    skips: bool,
    waits: bool,
}

impl LayerCommands {
    fn of(name: &str) -> Self {
        let mut commands = Self::default();
        for sign in name.trim_start().chars() {
            match sign {
                '%' => commands.skips = true,
                '!' => commands.waits = true,
                _ => break,
            }
        }
        commands
    }
}

impl Setup {
    /// Division of a drawing: as given, or implied by other options.
    fn part_mode(&self, artwork: &Artwork) -> PartMode {
        let commanded = artwork.layers.iter().any(|layer| {
            let name = layer.name.as_deref().filter(|_| layer.inkscape);
            name.is_some_and(|name| LayerCommands::of(name) != LayerCommands::default())
        });
        let implied = !self.only.is_empty() || !self.pens.is_empty() || commanded;
        self.parts.unwrap_or(if implied {
            PartMode::Layer
        } else {
            PartMode::None
        })
    }

    /// All parts of a drawing, including those left out.
    ///
    /// # Errors
    /// [`Diagnostic`] for a requested part that does not exist.
    pub fn parts_of(
        &self,
        artwork: &Artwork,
        mode: PartMode,
    ) -> Result<(Vec<DrawingPart>, Vec<Diagnostic>), Diagnostic> {
        let keys = || {
            let strokes = artwork.strokes.iter().map(|stroke| stroke.style);
            strokes.chain(artwork.areas.iter().map(|filled| filled.style))
        };
        let key = |style: crate::artwork::Style| match mode {
            PartMode::None => 0,
            PartMode::Layer => style.layer,
            PartMode::Color => style.color,
        };
        let last = keys().map(key).max().unwrap_or(0) as usize;
        let mut colors: Vec<Option<Option<u32>>> = vec![None; last + 1];
        for style in keys() {
            if let Some(known) = colors.get_mut(key(style) as usize) {
                // A part has a colour only if all its lines share it.
                *known = match known {
                    None => Some(Some(style.color)),
                    Some(Some(color)) if *color == style.color => continue,
                    Some(_) => Some(None),
                };
            }
        }
        let listed = |color: u32| {
            let place = (color as usize).checked_sub(1)?;
            artwork.colors.get(place).copied()
        };
        let mut parts: Vec<DrawingPart> = Vec::new();
        for (nth, color) in colors.into_iter().enumerate() {
            let layer = nth.checked_sub(1).and_then(|at| artwork.layers.get(at));
            let name = layer.filter(|_| mode == PartMode::Layer);
            let name = name.and_then(|layer| layer.name.clone());
            let commands = name.as_deref().map(LayerCommands::of).unwrap_or_default();
            // A part without lines keeps its index but is never drawn.
            let empty = color.is_none();
            let part = Part {
                n: 0,
                name,
                color: color
                    .flatten()
                    .filter(|_| mode != PartMode::None)
                    .and_then(listed),
                pass: None,
            };
            let mut drawn = DrawingPart::default();
            drawn.part = part;
            drawn.waits = commands.waits;
            drawn.skipped = empty || commands.skips;
            drawn.passes = if empty { 0 } else { self.passes.unwrap_or(1) };
            parts.push(drawn);
        }
        // Numbers that users see count only the parts with lines.
        let there = parts.iter_mut().filter(|part| part.passes > 0);
        for (n, part) in (1..).zip(there) {
            part.part.n = n;
        }
        let mut notes = Vec::new();
        for rule in &self.pens {
            let mut found = false;
            for part in parts.iter().filter(|part| part.passes > 0) {
                found |= rule.matches.selects(part);
            }
            // A rule for a part that does not exist is more likely a typing error than intended.
            if !found {
                let what = match &rule.matches {
                    PartMatch::Name(name) => message!(
                        "a pen is not used: no part has the name or colour '{name}'",
                        name
                    ),
                    PartMatch::Number(n) => message!("a pen is not used: there is no part {n}", n),
                };
                notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut));
            }
        }
        for part in parts.iter_mut().filter(|part| part.passes > 0) {
            // The first matching rule applies, so that users can order them from special to
            // general.
            if let Some(rule) = self.pens.iter().find(|rule| rule.matches.selects(part)) {
                part.pen = rule.pen;
                part.passes = rule.passes.unwrap_or(part.passes);
            }
        }
        self.choose(&mut parts)?;
        Ok((parts, notes))
    }

    /// Leaves out the parts that were not requested, if any were.
    fn choose(&self, parts: &mut [DrawingPart]) -> Result<(), Diagnostic> {
        if self.only.is_empty() {
            return Ok(());
        }
        let mut chosen = vec![false; parts.len()];
        for wanted in &self.only {
            let there = |part: &DrawingPart| part.passes > 0;
            let color: Option<Color> = wanted.parse().ok();
            let number = wanted.trim().parse().ok();
            let named = |part: &DrawingPart| there(part) && part.has_name(wanted);
            let coloured = |part: &DrawingPart| there(part) && part.has_color(color);
            let counted = |part: &DrawingPart| there(part) && Some(part.part.n) == number;
            // Names first: a layer may be called "2" or "red".
            let ways: [&dyn Fn(&DrawingPart) -> bool; 3] = [&named, &coloured, &counted];
            let Some(way) = ways.into_iter().find(|way| parts.iter().any(way)) else {
                return Err(unknown_part(wanted, parts));
            };
            for (part, chosen) in parts.iter().zip(&mut chosen) {
                *chosen |= way(part);
            }
        }
        for (part, chosen) in parts.iter_mut().zip(chosen) {
            // A part requested by the user is drawn, even if its name says to skip it.
            part.skipped &= !chosen;
            part.unasked = !chosen;
        }
        Ok(())
    }

    /// Divides a drawing into parts, without those left out.
    pub(super) fn divide(
        &self,
        mut artwork: Artwork,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<Artwork, Diagnostic> {
        let mode = self.part_mode(&artwork);
        if mode == PartMode::None {
            notes.extend(pens_draw_alike_note(&artwork));
            // Without parts, passes or pens the drawing stays as it is.
            if self.passes.unwrap_or(1) == 1 && self.pens.is_empty() && self.only.is_empty() {
                return Ok(artwork);
            }
        }
        let (parts, more) = self.parts_of(&artwork, mode)?;
        notes.extend(more);
        let key = |style: &mut crate::artwork::Style| {
            style.part = 1 + match mode {
                PartMode::None => 0,
                PartMode::Layer => style.layer,
                PartMode::Color => style.color,
            };
            let part = parts.get(style.part as usize - 1);
            part.is_some_and(|part| !part.skipped)
        };
        artwork.strokes.retain_mut(|stroke| key(&mut stroke.style));
        artwork.areas.retain_mut(|filled| key(&mut filled.style));
        if artwork.strokes.is_empty() && artwork.areas.is_empty() {
            return Err(Diagnostic::of_file(message!(
                "all parts of the drawing are left out"
            )));
        }
        // No note if the user chose the parts: the user left out the others on purpose.
        let is_noted = self.only.is_empty();
        let left_out = |part: &&DrawingPart| is_noted && part.skipped && part.passes > 0;
        for part in parts.iter().filter(left_out) {
            let what = message!("left out: part {part}", part = part.part.to_string());
            notes.push(Diagnostic::of_file(what).coded(DiagnosticCode::LeftOut));
        }
        artwork.parts = parts;
        Ok(artwork)
    }

    /// Turns the tools of a program into parts, if requested, and adds the passes.
    pub(super) fn with_passes(&self, mut plan: Plan, gcode: bool) -> Result<Plan, Diagnostic> {
        if let Some(setting) = [
            (!self.only.is_empty()).then_some(Setting::Only),
            (!self.pens.is_empty()).then_some(Setting::Pens),
        ]
        .into_iter()
        .flatten()
        .next()
        {
            let what =
                message!("only the parts of a drawing can be chosen, and have pens of their own");
            return Err(Diagnostic::of_file(what).with(magician_host::Remedy::without(setting)));
        }
        if gcode {
            self.convert_tools(&mut plan);
        }
        let passes = self.passes.unwrap_or(1);
        if passes > 1 {
            let is_part = |step: &crate::Step| matches!(step.action, Action::Part(_));
            if plan.steps.iter().any(is_part) {
                let what = message!("a program that has parts already cannot have passes");
                let remedy = magician_host::Remedy::without(Setting::Passes);
                return Err(Diagnostic::of_file(what).with(remedy));
            }
            let once = std::mem::take(&mut plan.steps);
            for pass in 1..=u64::from(passes) {
                let part = Part {
                    n: 1,
                    pass: Some(pass),
                    ..Part::default()
                };
                plan.push(Action::Part(Box::new(part)), crate::Origin::NONE);
                plan.steps.extend(once.iter().cloned());
            }
        }
        Ok(plan)
    }

    /// Keeps the tool changes of a program as parts, or drops them.
    fn convert_tools(&self, plan: &mut Plan) {
        if self.parts != Some(PartMode::Layer) {
            plan.steps
                .retain(|step| !matches!(step.action, Action::Part(_)));
            return;
        }
        let next: Vec<bool> = { plan.steps.iter().skip(1) }
            .map(|step| matches!(step.action, Action::Part(_)))
            .collect();
        for (step, next) in plan.steps.iter_mut().zip(next) {
            if let (Action::Pause(pause), true) = (&mut step.action, next) {
                pause.cause = PauseCause::Part;
            }
        }
    }
}

fn unknown_part(wanted: &str, parts: &[DrawingPart]) -> Diagnostic {
    let known = parts.iter().filter(|part| part.passes > 0);
    let all = known.clone().count();
    let names: Vec<String> = known
        .take(MAX_NAMED_PARTS)
        .map(|part| part.part.to_string())
        .collect();
    let parts = names.join("; ");
    let message = if all > MAX_NAMED_PARTS {
        message!(
            "no part has the name, colour or number '{wanted}'; the parts are {parts}; and more",
            wanted,
            parts
        )
    } else {
        message!(
            "no part has the name, colour or number '{wanted}'; the parts are {parts}",
            wanted,
            parts
        )
    };
    Diagnostic::of_file(message).remedy(
        (Setting::Parts, SettingValue::Word("color")),
        "divides the drawing by colour",
    )
}

/// Note that all pens of a plot are drawn with the arm's one pen.
fn pens_draw_alike_note(artwork: &Artwork) -> Option<Diagnostic> {
    let pens = artwork.layers.iter();
    let pens = pens.map(|layer| layer.name.as_deref()?.strip_prefix("pen "));
    let pens: Vec<&str> = pens.collect::<Option<_>>()?;
    (pens.len() > 1 && artwork.areas.is_empty()).then(|| {
        let what = message!(
            "pens {pens} draw alike: the arm has one pen",
            pens = pens.join(", ")
        );
        let note = Diagnostic::of_file(what).coded(DiagnosticCode::Assumed);
        note.remedy(
            (Setting::Parts, SettingValue::Word("layer")),
            "pauses to change the pen",
        )
    })
}
