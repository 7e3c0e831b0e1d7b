//! Sections of a DXF file besides its entities: header, tables, objects, blocks.

use std::collections::HashMap;
use std::ops::Range;

use magician_host::message;

use super::color;
use super::pairs::Record;
use super::text::Style;
use crate::{Color, Diagnostic, Origin};

/// A DXF file, split into its parts.
pub(super) struct Drawing<'p> {
    pub(super) records: &'p [Record<'p>],
    /// Records of the entities section.
    pub(super) entities: Range<usize>,
    /// Blocks by upper-case name. Names in DXF ignore case.
    pub(super) blocks: HashMap<String, Block>,
    /// Invisible layers by upper-case name.
    hidden: HashMap<String, Hidden>,
    /// Text styles by upper-case name.
    styles: HashMap<String, Style>,
    /// Length of arrows by dimension style, and the default, in drawing units.
    arrows: HashMap<String, f64>,
    arrow: f64,
    /// Indices of non-graphical objects by upper-case handle.
    objects: HashMap<String, usize>,
    /// Colours of layers by upper-case name.
    colors: HashMap<String, Color>,
    /// Size of a drawing unit, mm; `None` if the file gives none.
    pub(super) unit: Option<f64>,
    /// Place of the last record if the end marker is missing.
    pub(super) cut: Option<Origin>,
}

/// A block: entities drawn wherever it is inserted.
pub(super) struct Block {
    pub(super) base: [f64; 3],
    pub(super) records: Range<usize>,
}

/// Reason why a layer is invisible.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hidden {
    /// Off, or not plotted.
    Off,
    /// Frozen, which also hides everything inserted on it.
    Frozen,
}

impl<'p> Drawing<'p> {
    pub(super) fn new(records: &'p [Record<'p>]) -> Result<Self, Diagnostic> {
        let mut drawing = Self {
            records,
            entities: 0..0,
            blocks: HashMap::new(),
            hidden: HashMap::new(),
            styles: HashMap::new(),
            arrows: HashMap::new(),
            arrow: DEFAULT_ARROW_LENGTH,
            objects: HashMap::new(),
            colors: HashMap::new(),
            unit: None,
            cut: records
                .last()
                .filter(|last| last.kind != "EOF")
                .map(|last| last.origin),
        };
        let mut sections = 0;
        let mut at = 0;
        while let Some(record) = records.get(at) {
            at += 1;
            if record.kind != "SECTION" {
                continue;
            }
            sections += 1;
            let body = at..drawing.find(at, "ENDSEC");
            at = body.end;
            match record.text(2).unwrap_or_default() {
                "HEADER" => {
                    drawing.unit = unit(record)?;
                    drawing.arrow = arrow(record)?;
                }
                "TABLES" => {
                    drawing.layers(body.clone())?;
                    drawing.styles(body)?;
                }
                "OBJECTS" => drawing.objects(body),
                "BLOCKS" => drawing.blocks(body)?,
                "ENTITIES" => drawing.entities = body,
                // Classes and thumbnails draw nothing.
                _ => {}
            }
        }
        if sections == 0 {
            return Err(Diagnostic::of_file(message!(
                "this is not a DXF file: it has no sections"
            )));
        }
        Ok(drawing)
    }

    /// Returns why a layer is invisible; `None` if it is visible.
    pub(super) fn hides(&self, layer: &str) -> Option<Hidden> {
        let name = layer.to_uppercase();
        // The layer of the definition points of dimensions is never plotted, whatever its settings.
        let usual = (name == "DEFPOINTS").then_some(Hidden::Off);
        self.hidden.get(&name).copied().or(usual)
    }

    /// Returns a text style, or a plain one if it is unknown.
    pub(super) fn style(&self, name: &str) -> Style {
        let style = self.styles.get(&name.to_uppercase());
        style.copied().unwrap_or_default()
    }

    /// Length of arrows in a dimension style.
    pub(super) fn arrow(&self, style: &str) -> f64 {
        let own = self.arrows.get(&style.to_uppercase());
        own.copied().unwrap_or(self.arrow)
    }

    /// Returns an object by its handle.
    pub(super) fn object(&self, handle: &str) -> Option<&'p Record<'p>> {
        let at = self.objects.get(&handle.to_uppercase())?;
        self.records.get(*at)
    }

    /// Returns the colour of a layer.
    pub(super) fn color(&self, layer: &str) -> Option<Color> {
        self.colors.get(&layer.to_uppercase()).copied()
    }

    pub(super) fn block(&self, name: &str) -> Option<&Block> {
        self.blocks.get(&name.to_uppercase())
    }

    /// Index of the next record of a kind, or the number of records.
    pub(super) fn find(&self, from: usize, kind: &str) -> usize {
        let rest = self.records.get(from..).unwrap_or_default();
        let found = rest.iter().position(|record| record.kind == kind);
        found.map_or(self.records.len(), |at| from + at)
    }

    fn layers(&mut self, body: Range<usize>) -> Result<(), Diagnostic> {
        let records = self.records.get(body).unwrap_or_default();
        for layer in records.iter().filter(|record| record.kind == "LAYER") {
            let (Some(name), flags) = (layer.text(2), layer.integer(70)?) else {
                continue;
            };
            if let Some(Some(color)) = color::of(layer) {
                self.colors.insert(name.to_uppercase(), color);
            }
            let plotted = layer.text(290).is_none_or(|plots| plots != "0");
            let hidden = if flags & 1 != 0 {
                Hidden::Frozen
            } else if layer.integer(62)? < 0 || !plotted {
                Hidden::Off
            } else {
                continue;
            };
            self.hidden.insert(name.to_uppercase(), hidden);
        }
        Ok(())
    }

    fn styles(&mut self, body: Range<usize>) -> Result<(), Diagnostic> {
        for record in self.records.get(body).unwrap_or_default() {
            let Some(name) = record.text(2).map(str::to_uppercase) else {
                continue;
            };
            let above_zero =
                |code| Ok::<_, Diagnostic>(record.number(code)?.filter(|it| *it > 0.0));
            match record.kind {
                "STYLE" => {
                    let style = Style {
                        height: above_zero(40)?.unwrap_or_default(),
                        width: above_zero(41)?.unwrap_or(1.0),
                        oblique: record.number(50)?.unwrap_or_default(),
                    };
                    self.styles.insert(name, style);
                }
                "DIMSTYLE" => {
                    let scale = above_zero(40)?.unwrap_or(1.0);
                    if let Some(size) = record.number(41)? {
                        self.arrows.insert(name, size * scale);
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn objects(&mut self, body: Range<usize>) {
        for at in body {
            let record = self.records.get(at);
            if let Some(handle) = record.and_then(|record| record.text(5)) {
                self.objects.insert(handle.to_uppercase(), at);
            }
        }
    }

    fn blocks(&mut self, body: Range<usize>) -> Result<(), Diagnostic> {
        let mut at = body.start;
        while at < body.end {
            let start = self.find(at, "BLOCK");
            let Some(head) = self.records.get(start).filter(|_| start < body.end) else {
                break;
            };
            let end = self.find(start, "ENDBLK").min(body.end);
            if let Some(name) = head.text(2) {
                let base = match head.text(10) {
                    Some(_) => head.point(10)?,
                    None => [0.0; 3],
                };
                let records = start + 1..end;
                self.blocks
                    .insert(name.to_uppercase(), Block { base, records });
            }
            at = end;
        }
        Ok(())
    }
}

/// Default length of arrows, in drawing units: that of `$DIMASZ` in metric templates.
const DEFAULT_ARROW_LENGTH: f64 = 2.5;

/// Returns the length of arrows by `$DIMASZ` and `$DIMSCALE`.
fn arrow(header: &Record<'_>) -> Result<f64, Diagnostic> {
    let value = |name: &str| {
        let mut pairs = header.pairs.iter();
        pairs.find(|pair| (pair.code, pair.value) == (9, name))?;
        Some(pairs.next()?.number())
    };
    let size = value("$DIMASZ")
        .transpose()?
        .unwrap_or(DEFAULT_ARROW_LENGTH);
    let scale = value("$DIMSCALE").transpose()?.filter(|scale| *scale > 0.0);
    Ok(size * scale.unwrap_or(1.0))
}

/// Returns the size of a drawing unit by `$INSUNITS`, mm; `None` if the drawing is unitless.
fn unit(header: &Record<'_>) -> Result<Option<f64>, Diagnostic> {
    let mut pairs = header.pairs.iter();
    if !pairs.any(|pair| (pair.code, pair.value) == (9, "$INSUNITS")) {
        return Ok(None);
    }
    let Some(unit) = pairs.next() else {
        return Ok(None);
    };
    Ok(Some(match unit.value {
        "1" => 25.4,
        "2" => 304.8,
        "3" => 1_609_344.0,
        "4" => 1.0,
        "5" => 10.0,
        "6" => 1e3,
        "7" => 1e6,
        "8" => 25.4e-6,
        "9" => 25.4e-3,
        "10" => 914.4,
        "11" => 1e-7,
        "12" => 1e-6,
        "13" => 1e-3,
        "14" => 1e2,
        "15" => 1e4,
        "16" => 1e5,
        "21" => 1200.0 / 3937.0 * 1e3,
        "22" => 100.0 / 3937.0 * 1e3,
        "23" => 3600.0 / 3937.0 * 1e3,
        "0" => return Ok(None),
        other => {
            let why = message!("{unit} is not a usable unit of length", unit = other);
            return Err(Diagnostic::new(unit.origin, why));
        }
    }))
}
