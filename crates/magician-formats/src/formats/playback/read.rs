//! Reader of playback files: from XML to rows.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use magician_host::{Message, message};
use roxmltree::Node;

use super::lab;
use super::row::{Part, Places, RAIL_ITEM, numbered};
use super::{Playback, Point, PointMotion, Row};
use crate::encoding::{Fallback, decode};
use crate::formats::rail::RailCourse;
use crate::formats::{Content, Parsed, ReadOptions, xml};
use crate::{Diagnostic, DiagnosticCode, Grip, Lines, Origin, Travel};

/// Number of items whose meaning is known, without that of the rail.
const KNOWN_ITEMS: u32 = 13;

pub(in crate::formats) fn read(bytes: &[u8], options: &ReadOptions) -> Result<Parsed, Diagnostic> {
    let decoded = decode(bytes, Fallback::Western)?;
    if decoded.text.trim_start().starts_with('[') {
        let mut parsed = lab::read(&decoded.text)?;
        parsed.content.title.clone_from(&options.title);
        parsed.notes.extend(decoded.note);
        return Ok(Parsed {
            content: Content::Plan(parsed.content),
            notes: parsed.notes,
        });
    }
    let playback = Playback::of_text(&decoded.text)?;
    let Parsed {
        content: mut plan,
        notes,
    } = playback.to_plan();
    plan.title.clone_from(&options.title);
    Ok(Parsed {
        content: Content::Plan(plan),
        notes: (playback.notes.into_iter())
            .chain(notes)
            .chain(decoded.note)
            .collect(),
    })
}

impl Playback {
    /// Reads a file.
    ///
    /// # Errors
    /// The first [`Diagnostic`] that makes it unreadable, with its place: not XML, another kind of
    /// file, a missing coordinate, an invalid number, an unknown motion style.
    pub fn read(bytes: &[u8]) -> Result<Self, Diagnostic> {
        Self::of_text(&decode(bytes, Fallback::Western)?.text)
    }

    fn of_text(text: &str) -> Result<Self, Diagnostic> {
        let playback = document(text)?;
        playback.check_tool()?;
        playback.check_rail()?;
        Ok(playback)
    }

    /// Checks that only one tool is used.
    fn check_tool(&self) -> Result<(), Diagnostic> {
        let grips = |row: &&Row| row.point.gripper.is_some_and(|grip| grip != Grip::Off);
        let sucks = |row: &&Row| row.point.suction == Some(true);
        let (grips, sucks) = (self.rows.iter().find(grips), self.rows.iter().find(sucks));
        let (Some(grips), Some(sucks)) = (grips, sucks) else {
            return Ok(());
        };
        let message = message!(
            "row{gripping} uses the gripper and row{sucking} the suction cup; the arm has one tool",
            gripping = grips.number,
            sucking = sucks.number
        );
        Err(Diagnostic::new(sucks.places.suction, message).named(format!("row{}", sucks.number)))
    }
}

impl Playback {
    /// Checks that the rail moves only during moves.
    fn check_rail(&self) -> Result<(), Diagnostic> {
        let mut rail = RailCourse::of(self.rows.iter().map(|row| row.point.rail));
        for row in &self.rows {
            rail.with_rail(row.point.motion(), row.point.rail)
                .map_err(|why| {
                    Diagnostic::new(row.places.motion, why)
                        .named(format!("row{}", row.number))
                        .help(message!("teach a point of its own to which the rail moves"))
                })?;
        }
        Ok(())
    }
}

fn document(text: &str) -> Result<Playback, Diagnostic> {
    let document = xml::parse(text)?;
    let lines = Lines::new(text);
    let root = document.root_element();
    let file = File {
        text,
        lines: &lines,
    };
    if root.tag_name().name() != "root" {
        return Err(file.other_xml_error(root));
    }
    let mut playback = Playback::default();
    for node in xml::elements(root) {
        file.add(&mut playback, node)?;
    }
    if playback.rows.is_empty() {
        let place = file.start_of(root);
        let message = message!("this is not a playback file of DobotStudio: it has no rows");
        let help = message!("its points are in elements called row0, row1 and so on");
        return Err(Diagnostic::new(place, message).help(help));
    }
    file.note_order(&mut playback);
    Ok(playback)
}

struct File<'t> {
    text: &'t str,
    lines: &'t Lines<'t>,
}

impl File<'_> {
    fn at(&self, range: Range<usize>) -> Origin {
        self.lines.origin(range)
    }

    /// Returns the place of an element's start tag.
    fn start_of(&self, node: Node<'_, '_>) -> Origin {
        let whole = node.range();
        let text = self.text.get(whole.clone()).unwrap_or_default();
        let length = text.find('>').map_or(text.len(), |at| at + 1);
        self.at(whole.start..whole.start + length)
    }

    /// Creates the error for other XML files.
    fn other_xml_error(&self, root: Node<'_, '_>) -> Diagnostic {
        let name = root.tag_name().name();
        let help = match name {
            "xml" => {
                message!("this looks like a DobotBlockly workspace: rename it to '.blockly'")
            }
            "svg" => message!("this looks like a drawing: rename it to '.svg'"),
            _ => message!("the outermost element of a playback file is 'root'"),
        };
        let message = message!(
            "this is not a playback file of DobotStudio: its outermost element is '{name}'",
            name
        );
        Diagnostic::new(self.start_of(root), message).help(help)
    }

    fn add(&self, playback: &mut Playback, node: Node<'_, '_>) -> Result<(), Diagnostic> {
        let name = node.tag_name().name();
        if let Some(number) = numbered(name, "row") {
            let row = self.row(number, node, &mut playback.notes)?;
            playback.rows.push(row);
            return Ok(());
        }
        let first = || xml::elements(node).find(|item| item.tag_name().name() == "item_0");
        match (name, first()) {
            ("row_StudioVersion", Some(item)) if playback.version.is_none() => {
                playback.version = Some(xml::content(item).trim().to_owned());
            }
            ("DobotType", Some(item)) if playback.dobot_type.is_none() => {
                let kind = xml::content(item).trim().to_owned();
                self.check_kind(&kind, item)?;
                playback.dobot_type = Some(kind);
            }
            _ => {
                let note = message!("'{name}' is unknown: it is kept but not played", name);
                let note = Diagnostic::new(self.start_of(node), note);
                playback.notes.push(note.coded(DiagnosticCode::LeftOut));
                playback.others.extend(self.source(node));
            }
        }
        Ok(())
    }

    /// Refuses points taught on another kind of arm, because its coordinates mean other positions.
    fn check_kind(&self, kind: &str, item: Node<'_, '_>) -> Result<(), Diagnostic> {
        if kind.is_empty() || kind.to_ascii_lowercase().starts_with("magician") {
            return Ok(());
        }
        let place = self.at(content_range(item));
        let message = message!(
            "this was taught on a {kind}, and its points are other positions here",
            kind
        );
        let help = message!("teach the points again on a Magician");
        Err(Diagnostic::new(place, message).help(help))
    }

    /// Returns the source of an element; `None` if it is not valid on its own.
    fn source(&self, node: Node<'_, '_>) -> Option<String> {
        let source = self.text.get(node.range())?;
        roxmltree::Document::parse(source).ok()?;
        Some(source.to_owned())
    }

    fn row(
        &self,
        number: u32,
        node: Node<'_, '_>,
        notes: &mut Vec<Diagnostic>,
    ) -> Result<Row, Diagnostic> {
        let mut items = Items {
            file: self,
            row: node,
            number,
            found: Vec::new(),
        };
        let mut parts = Vec::new();
        for item in xml::elements(node) {
            let name = item.tag_name().name();
            // An item with attributes or children could not be written again as text, so keep its
            // source.
            let plain = item.attributes().len() == 0 && xml::elements(item).next().is_none();
            match numbered(name, "item_") {
                Some(n) if plain || is_known(n) => {
                    items.take(n, item)?;
                    parts.push(Part::Item(n, xml::content(item).into_owned()));
                }
                _ => parts.extend(self.source(item).map(Part::Other)),
            }
        }
        let point = items.point(notes)?;
        Ok(Row {
            number,
            parts,
            places: items.places(matches!(point.way, PointMotion::Arc { .. })),
            point,
        })
    }

    /// Notes rows out of order and unknown items.
    fn note_order(&self, playback: &mut Playback) {
        let rows = &playback.rows;
        let wrong = (0..).zip(rows).find(|(nth, row)| row.number != *nth);
        if let Some((nth, row)) = wrong {
            let message = message!(
                "row{number} found where row{nth} is expected; rows are played in the order of the file",
                number = row.number,
                nth
            );
            let note = Diagnostic::new(row.places.motion, message).coded(DiagnosticCode::Assumed);
            playback.notes.push(note);
        }
        let mut strange = BTreeSet::new();
        for row in &playback.rows {
            strange.extend(row.parts.iter().filter_map(|part| match part {
                Part::Item(n, _) if is_known(*n) => None,
                Part::Item(n, _) => Some(format!("item_{n}")),
                Part::Other(source) => {
                    let end = source.find([' ', '/', '>']).unwrap_or(source.len());
                    Some(source.get(1..end).unwrap_or_default().to_owned())
                }
            }));
        }
        if !strange.is_empty() {
            let names: Vec<_> = strange.into_iter().collect();
            let names = names.join(", ");
            let note = message!(
                "rows have unknown items ({names}): they are kept but not played",
                names
            );
            playback
                .notes
                .push(Diagnostic::of_file(note).coded(DiagnosticCode::LeftOut));
        }
        for number in changing(&playback.rows) {
            let note = message!(
                "item_{number} is unknown and changes from row to row: if it is a motion, that is not played",
                number
            );
            let note = Diagnostic::of_file(note).coded(DiagnosticCode::LeftOut);
            playback.notes.push(note);
        }
    }
}

/// True if the meaning of an item is known.
fn is_known(number: u32) -> bool {
    number < KNOWN_ITEMS || number == RAIL_ITEM
}

/// Returns unknown items whose numbers differ between rows.
fn changing(rows: &[Row]) -> Vec<u32> {
    let mut first: BTreeMap<u32, f64> = BTreeMap::new();
    let mut changes = BTreeSet::new();
    for part in rows.iter().flat_map(|row| &row.parts) {
        if let Part::Item(number, text) = part
            && !is_known(*number)
            && let Ok(value) = text.trim().parse::<f64>()
            && *first.entry(*number).or_insert(value) != value
        {
            changes.insert(*number);
        }
    }
    changes.into_iter().collect()
}

/// Items of a row.
struct Items<'f, 'a, 'i> {
    file: &'f File<'f>,
    row: Node<'a, 'i>,
    number: u32,
    found: Vec<(u32, Node<'a, 'i>)>,
}

impl<'a, 'i> Items<'_, 'a, 'i> {
    fn take(&mut self, number: u32, item: Node<'a, 'i>) -> Result<(), Diagnostic> {
        if self.node(number).is_some() {
            return Err(self.wrong(item, message!("item_{number} appears twice", number)));
        }
        self.found.push((number, item));
        Ok(())
    }

    fn node(&self, number: u32) -> Option<Node<'a, 'i>> {
        let mut found = self.found.iter();
        found.find(|(own, _)| *own == number).map(|(_, node)| *node)
    }

    /// Returns the text of an item; `None` if it is absent or empty.
    fn text(&self, number: u32) -> Option<(String, Node<'a, 'i>)> {
        let node = self.node(number)?;
        let text = xml::content(node).trim().to_owned();
        (!text.is_empty()).then_some((text, node))
    }

    fn wrong(&self, item: Node<'_, '_>, message: Message) -> Diagnostic {
        let place = self.file.at(content_range(item));
        Diagnostic::new(place, message).named(format!("row{}", self.number))
    }

    fn missing(&self, number: u32) -> Diagnostic {
        let meaning = meaning(number);
        let place = match self.node(number) {
            Some(item) => self.file.at(item.range()),
            None => self.file.start_of(self.row),
        };
        let message = message!("it has no item_{number} ({meaning})", number, meaning);
        Diagnostic::new(place, message).named(format!("row{}", self.number))
    }

    fn number(&self, number: u32) -> Result<Option<f64>, Diagnostic> {
        let Some((text, item)) = self.text(number) else {
            return Ok(None);
        };
        let value = text.parse::<f64>().map_err(|_| {
            let message = message!(
                "item_{number} ({meaning}) is '{text}', which is not a number",
                number,
                meaning = meaning(number),
                text
            );
            let diagnostic = self.wrong(item, message);
            if text.contains(',') {
                diagnostic.help(message!("numbers are written with a decimal point"))
            } else {
                diagnostic
            }
        })?;
        if !(value as f32).is_finite() {
            let message = message!(
                "item_{number} ({meaning}) is {text}, which is out of range",
                number,
                meaning = meaning(number),
                text
            );
            return Err(self.wrong(item, message));
        }
        Ok(Some(value))
    }

    /// Parses one of a few whole numbers.
    fn code(
        &self,
        number: u32,
        most: u8,
        known: fn() -> Message,
    ) -> Result<Option<u8>, Diagnostic> {
        let Some(value) = self.number(number)? else {
            return Ok(None);
        };
        let code = (0..=most).find(|code| f64::from(*code) == value);
        if let (None, Some(item)) = (code, self.node(number)) {
            let message = message!(
                "item_{number} ({meaning}) is {value}; known are {known}",
                number,
                meaning = meaning(number),
                value,
                known = known()
            );
            return Err(self.wrong(item, message));
        }
        Ok(code)
    }

    /// Parses x, y, z, r from this item on. A missing r is 0, with a note.
    fn pose(&self, first: u32, notes: &mut Vec<Diagnostic>) -> Result<[f32; 4], Diagnostic> {
        let mut pose = [0.0; 4];
        for (number, value) in (first..).zip(&mut pose) {
            match self.number(number)? {
                // Parse the text as f32 directly, to round only once.
                Some(_) => *value = self.single(number),
                None if number == first + 3 => {
                    notes.push(Diagnostic {
                        code: DiagnosticCode::Assumed,
                        message: message!("it has no R: 0 is used"),
                        ..self.missing(number)
                    });
                }
                None => return Err(self.missing(number)),
            }
        }
        Ok(pose)
    }

    fn single(&self, number: u32) -> f32 {
        let text = self.text(number).map(|(text, _)| text);
        text.and_then(|text| text.parse().ok()).unwrap_or_default()
    }

    fn point(&self, notes: &mut Vec<Diagnostic>) -> Result<Point, Diagnostic> {
        let styles = || message!("0 JUMP, 1 MOVJ, 2 MOVL, 3 or 4 ARC");
        let style = self.code(0, 4, styles)?.ok_or_else(|| self.missing(0))?;
        let first = self.pose(2, notes)?;
        let (way, to) = match style {
            0 => (PointMotion::Move(Travel::Jump), first),
            1 => (PointMotion::Move(Travel::Joints), first),
            2 => (PointMotion::Move(Travel::Line), first),
            arc => (PointMotion::Arc { via: first }, self.second(arc, notes)?),
        };
        let name = self
            .node(1)
            .map(|item| xml::content(item).trim().to_owned());
        // A value may have been lost, so an empty item is reported.
        for number in 10..=12 {
            if let Some(item) = self.node(number).filter(|_| self.text(number).is_none()) {
                let message = message!(
                    "item_{number} ({meaning}) is empty: it is left out",
                    number,
                    meaning = meaning(number)
                );
                notes.push(self.wrong(item, message).coded(DiagnosticCode::LeftOut));
            }
        }
        let gripper = self.code(11, 2, || message!("0 off, 1 open, 2 closed"))?;
        let suction = self.code(12, 1, || message!("0 off, 1 on"))?;
        Ok(Point {
            name: name.unwrap_or_default(),
            way,
            to,
            gripper: gripper.map(|code| match code {
                0 => Grip::Off,
                1 => Grip::Open,
                _ => Grip::Close,
            }),
            suction: suction.map(|code| code == 1),
            pause: self.pause()?,
            rail: self.number(RAIL_ITEM)?.map(|l| l as f32),
        })
    }

    /// Parses the end of an arc.
    ///
    /// Studios 1.7 to 1.9 write style 3 for an arc and 1.4 writes 4; the meaning of style 3 in 1.4
    /// is unknown. So only a row with a second point is an arc. A second point of zeros, as other
    /// styles have, does not count.
    fn second(&self, style: u8, notes: &mut Vec<Diagnostic>) -> Result<[f32; 4], Diagnostic> {
        let mut any = false;
        for number in 6..=9 {
            any |= self.number(number)?.is_some_and(|value| value != 0.0);
        }
        if any {
            return self.pose(6, notes);
        }
        let place = self.node(0).map_or_else(
            || self.file.start_of(self.row),
            |item| self.file.at(content_range(item)),
        );
        let message = message!(
            "motion style {style} is an arc, but items 6 to 9 have no second point; another \
                meaning is unknown",
            style
        );
        Err(Diagnostic::new(place, message)
            .named(format!("row{}", self.number))
            .help(message!(
                "teach this point again, or give it style 0 (JUMP), 1 (MOVJ) or 2 (MOVL)"
            )))
    }

    /// Returns the pause in ms. The file has seconds.
    fn pause(&self) -> Result<u32, Diagnostic> {
        let seconds = self.number(10)?.unwrap_or(0.0);
        let milliseconds = (seconds * 1000.0).round();
        match self.node(10) {
            Some(item) if !(0.0..=f64::from(u32::MAX)).contains(&milliseconds) => {
                let most = f64::from(u32::MAX) / 1000.0;
                let message = message!(
                    "it pauses for {seconds} s, it must be 0 to {most} s",
                    seconds,
                    most
                );
                Err(self.wrong(item, message))
            }
            _ => Ok(milliseconds as u32),
        }
    }

    fn places(&self, arc: bool) -> Places {
        let at = |number| {
            self.node(number)
                .map_or(Origin::NONE, |item| self.file.at(item.range()))
        };
        // An arc ends with items 6 to 9; for other styles these are unused zeros.
        let last = if arc { 9 } else { 5 };
        let motion = (self.found.iter())
            .filter(|(number, _)| (2..=last).contains(number))
            .map(|(_, item)| item.range())
            .reduce(|a, b| a.start.min(b.start)..a.end.max(b.end));
        Places {
            motion: motion.map_or(Origin::NONE, |range| self.file.at(range)),
            gripper: at(11),
            suction: at(12),
            pause: at(10),
        }
    }
}

/// Meaning of an item, for messages.
fn meaning(number: u32) -> Message {
    match number {
        RAIL_ITEM => message!("rail position"),
        0 => message!("motion style"),
        1 => message!("name"),
        2 => "X".into(),
        3 => "Y".into(),
        4 => "Z".into(),
        5 => "R".into(),
        6 => message!("second X"),
        7 => message!("second Y"),
        8 => message!("second Z"),
        9 => message!("second R"),
        10 => message!("pause"),
        11 => message!("gripper"),
        12 => message!("suction cup"),
        _ => message!("not known"),
    }
}

/// Returns the range of an element's text, or of the element if it has none.
fn content_range(node: Node<'_, '_>) -> Range<usize> {
    let texts = || node.children().filter(Node::is_text);
    match (texts().next(), texts().next_back()) {
        (Some(first), Some(last)) => first.range().start..last.range().end,
        _ => node.range(),
    }
}
