//! What a DXF file says beside its entities: units, layers, blocks.

use std::collections::HashMap;
use std::ops::Range;

use super::color;
use super::pairs::Record;
use crate::{Color, Diagnostic, Origin};

/// A file, taken apart.
pub(super) struct Drawing<'p> {
    pub(super) records: &'p [Record<'p>],
    /// Which of them are drawn as they stand.
    pub(super) entities: Range<usize>,
    /// By their names in capitals.
    pub(super) blocks: HashMap<String, Block>,
    /// Layers that are not seen, by their names in capitals.
    hidden: HashMap<String, Hidden>,
    /// The colours of layers, by their names in capitals.
    colors: HashMap<String, Color>,
    /// How many mm a unit is, where the file says so.
    pub(super) unit: Option<f64>,
    /// Where it ends, if it does not say that it ends there.
    pub(super) cut: Option<Origin>,
}

/// Entities that are drawn wherever they are inserted.
pub(super) struct Block {
    pub(super) base: [f64; 3],
    pub(super) records: Range<usize>,
}

/// Why a layer is not seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Hidden {
    /// It is off, or not plotted.
    Off,
    /// It is frozen, and all that is inserted on it.
    Frozen,
}

impl<'p> Drawing<'p> {
    pub(super) fn new(records: &'p [Record<'p>]) -> Result<Self, Diagnostic> {
        let mut drawing = Self {
            records,
            entities: 0..0,
            blocks: HashMap::new(),
            hidden: HashMap::new(),
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
                "HEADER" => drawing.unit = unit(record)?,
                "TABLES" => drawing.layers(body)?,
                "BLOCKS" => drawing.blocks(body)?,
                "ENTITIES" => drawing.entities = body,
                _ => {}
            }
        }
        if sections == 0 {
            return Err(Diagnostic::of_file(
                "this is not a DXF file: it has no sections",
            ));
        }
        Ok(drawing)
    }

    /// Why what is on a layer is not seen.
    pub(super) fn hides(&self, layer: &str) -> Option<Hidden> {
        self.hidden.get(&layer.to_uppercase()).copied()
    }

    /// The colour of a layer, if it has one.
    pub(super) fn color(&self, layer: &str) -> Option<Color> {
        self.colors.get(&layer.to_uppercase()).copied()
    }

    pub(super) fn block(&self, name: &str) -> Option<&Block> {
        self.blocks.get(&name.to_uppercase())
    }

    /// Where the next record of a kind is, from here on.
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

/// How many mm a drawing unit is, by `$INSUNITS`; nothing where it has none.
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
            let why = format!("{other} is not a usable unit of length");
            return Err(Diagnostic::new(unit.origin, why));
        }
    }))
}
