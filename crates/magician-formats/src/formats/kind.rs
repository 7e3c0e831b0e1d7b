//! Table of the formats: name, file name extensions, reader, and the cargo feature of the reader.

use magician_host::message;
use std::fmt;
use std::str::FromStr;

use super::{Chords, Content, Format, Parsed, ReadOptions, content};
use crate::plan::file;
use crate::{Diagnostic, Missing};

/// Reader of a format: parses bytes into content.
type Reader = fn(&[u8], &ReadOptions, &Chords) -> Result<Parsed, Diagnostic>;

/// Pairs a cargo feature with the reader that it builds in (`None` without the feature). `curved`
/// readers flatten curves and get the tolerance.
macro_rules! behind {
    ($feature:literal, $module:ident) => {
        behind!($feature, |bytes, options, _| super::$module::read(
            bytes, options
        ))
    };
    ($feature:literal, curved $module:ident) => {
        behind!($feature, super::$module::read)
    };
    ($feature:literal, $reader:expr) => {{
        #[cfg(feature = $feature)]
        let reader: Option<Reader> = Some($reader);
        #[cfg(not(feature = $feature))]
        let reader: Option<Reader> = None;
        (Some($feature), reader)
    }};
}

impl Format {
    /// All formats, in the order in which users see them.
    pub const ALL: [Self; 11] = [
        Self::Playback,
        Self::Svg,
        Self::Gcode,
        Self::Image,
        Self::Dxf,
        Self::Hpgl,
        Self::Blockly,
        Self::Points,
        Self::Text,
        Self::TestGrid,
        Self::Plan,
    ];

    /// Name, as users type it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Plan => "plan",
            Self::Playback => "playback",
            Self::Gcode => "gcode",
            Self::Svg => "svg",
            Self::Hpgl => "hpgl",
            Self::Dxf => "dxf",
            Self::Blockly => "blockly",
            Self::Image => "image",
            Self::Points => "points",
            Self::Text => "text",
            Self::TestGrid => "testgrid",
        }
    }

    /// File name extensions, the usual one first. Empty for text, since points and G-code use the
    /// same extensions. `.xml` and `.json` are absent because several formats use them.
    #[must_use]
    pub fn endings(self) -> &'static [&'static str] {
        match self {
            Self::Plan => &[".plan.json", ".plan"],
            Self::Playback => &[".playback"],
            Self::Gcode => &[".gcode", ".nc", ".ngc", ".gc", ".g", ".tap"],
            Self::Svg => &[".svg", ".svgz"],
            Self::Hpgl => &[".plt", ".hpgl", ".hgl"],
            Self::Dxf => &[".dxf"],
            Self::Blockly => &[".blockly"],
            Self::Image => &[
                ".png", ".jpg", ".jpeg", ".bmp", ".webp", ".gif", ".tif", ".tiff", ".pgm", ".pbm",
                ".ppm", ".pnm",
            ],
            Self::Points => &[".csv", ".xyz", ".mcap"],
            // `.txt` may be points or G-code, so no extension means text to write.
            Self::Text => &[],
            Self::TestGrid => &[".testgrid.json", ".testgrid"],
        }
    }

    /// Returns the file name without folder and extension: a title for the content.
    ///
    /// ```
    /// use magician_formats::Format;
    ///
    /// assert_eq!(Format::title("work/pick.plan.json"), "pick");
    /// assert_eq!(Format::title(r"C:\work\house.v2.svg"), "house.v2");
    /// assert_eq!(Format::title(".svg"), ".svg");
    /// ```
    #[must_use]
    pub fn title(name: &str) -> &str {
        let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
        let plain = name
            .strip_suffix(".plan.json")
            .or_else(|| name.strip_suffix(".testgrid.json"))
            .or_else(|| name.rsplit_once('.').map(|(plain, _)| plain));
        plain.filter(|plain| !plain.is_empty()).unwrap_or(name)
    }

    /// Description, a noun phrase.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Plan => "our own plan file, to be read, changed and compared",
            Self::Playback => "Teaching & Playback of DobotStudio",
            Self::Gcode => "G-code of pens and lasers",
            Self::Svg => "SVG drawing",
            Self::Hpgl => "HPGL plot",
            Self::Dxf => "DXF drawing",
            Self::Blockly => "DobotBlockly workspace",
            Self::Image => "PNG, JPEG, BMP, WebP, GIF, TIFF or PNM image",
            Self::Points => "points as CSV, JSON or text, and recordings as CSV or MCAP",
            Self::Text => "text, to be written with the pen",
            Self::TestGrid => "squares to be burnt with many powers and speeds",
        }
    }

    /// Returns the cargo feature of the reader, and the reader if this build has it.
    fn built_in(self) -> (Option<&'static str>, Option<Reader>) {
        match self {
            Self::Plan => (None, Some(read_plan)),
            Self::Playback => behind!("programs", playback),
            Self::Gcode => behind!("programs", curved gcode),
            Self::Svg => behind!("drawings", curved svg),
            Self::Hpgl => behind!("drawings", curved hpgl),
            Self::Dxf => behind!("drawings", curved dxf),
            Self::Blockly => behind!("programs", blockly),
            Self::Image => behind!("images", image),
            Self::Points => behind!("programs", points),
            Self::Text => behind!("lettering", curved plain_text),
            Self::TestGrid => behind!("lettering", testgrid),
        }
    }

    /// Cargo feature of this crate that builds the reader in. `None` for our own plan files, which
    /// are always read.
    ///
    /// ```
    /// use magician_formats::Format;
    ///
    /// assert_eq!(Format::Svg.feature(), Some("drawings"));
    /// assert_eq!(Format::Plan.feature(), None);
    /// ```
    #[must_use]
    pub fn feature(self) -> Option<&'static str> {
        self.built_in().0
    }

    /// True if this build reads the format.
    #[must_use]
    pub fn is_built_in(self) -> bool {
        self.built_in().1.is_some()
    }

    pub(super) fn reader(self) -> Result<Reader, Diagnostic> {
        let (feature, reader) = self.built_in();
        reader.ok_or_else(|| {
            let feature = feature.unwrap_or_default();
            let message = message!(
                "this build cannot read {format} files: it lacks the feature \
                {feature} of magician-formats",
                format = self.to_string(),
                feature
            );
            Diagnostic::of_file(message).with_missing(Some(Missing::Feature(feature)))
        })
    }

    /// True for drawings, images and G-code, whose coordinates refer to a sheet and must be placed.
    /// Taught points and plans are already in the arm's coordinates.
    #[must_use]
    pub fn is_drawing(self) -> bool {
        match self {
            Self::Svg
            | Self::Gcode
            | Self::Image
            | Self::Dxf
            | Self::Hpgl
            | Self::Text
            | Self::TestGrid => true,
            Self::Playback | Self::Blockly | Self::Points | Self::Plan => false,
        }
    }

    /// Detects the format by the extension of a name (with or without a path), or by the content if
    /// the extension is missing or ambiguous (`.xml`, `.json`, `.txt`). `None` if neither
    /// determines it.
    ///
    /// ```
    /// use magician_formats::Format;
    ///
    /// assert_eq!(Format::of("house.svg", b""), Some(Format::Svg));
    /// assert_eq!(Format::of("old.xml", b"<root><row0></row0></root>"), Some(Format::Playback));
    /// assert_eq!(Format::of("notes.txt", b"G21\nG90\nG1 X10 F600"), Some(Format::Gcode));
    /// assert_eq!(Format::of("notes.txt", b"Good morning"), None);
    /// ```
    #[must_use]
    pub fn of(name: &str, bytes: &[u8]) -> Option<Self> {
        let name = name.to_ascii_lowercase();
        let ends = |format: &Self| format.endings().iter().any(|ending| name.ends_with(ending));
        Self::ALL
            .into_iter()
            .find(ends)
            .or_else(|| content::of(bytes))
    }
}

fn read_plan(bytes: &[u8], options: &ReadOptions, _: &Chords) -> Result<Parsed, Diagnostic> {
    let read = file::read(bytes, options)?;
    Ok(Parsed {
        content: Content::Plan(read.content),
        notes: read.notes,
    })
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Format {
    type Err = String;

    /// Parses a name or an extension, ignoring case.
    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = text.trim().trim_start_matches('.').to_ascii_lowercase();
        let is_meant = |format: &Self| {
            let mut endings = format.endings().iter();
            format.name() == wanted
                || endings.any(|ending| ending.trim_start_matches('.') == wanted)
        };
        Self::ALL.into_iter().find(is_meant).ok_or_else(|| {
            let names = Self::ALL.map(Self::name).join(", ");
            format!("unknown format '{}'; known are {names}", text.trim())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_detected_by_name_and_by_content() {
        let samples =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../magician-program/samples");
        let mut seen = 0;
        for entry in std::fs::read_dir(samples).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap();
            if name.ends_with(".md") {
                continue;
            }
            let by_name = Format::of(name, b"");
            let by_content = Format::of("sample", &std::fs::read(&path).unwrap());
            assert!(by_name.is_some(), "{name}");
            assert_eq!(by_content, by_name, "{name}");
            seen += 1;
        }
        assert!(seen >= 10, "{seen} samples");
    }

    #[test]
    fn format_that_is_not_built_in_is_refused_with_its_feature() {
        for format in Format::ALL {
            let read = crate::read(format, b"", &ReadOptions::default());
            let missing = read.err().and_then(|diagnostic| diagnostic.missing);
            let expected = if format.is_built_in() {
                None
            } else {
                format.feature().map(Missing::Feature)
            };
            assert_eq!(missing, expected, "{format}");
            for ending in format.endings() {
                assert_eq!(Format::of(&format!("a{ending}"), b""), Some(format));
            }
        }
        assert!(Format::Plan.is_built_in());
    }

    #[test]
    fn extension_takes_precedence_over_content() {
        let is = |name: &str, text: &str| Format::of(name, text.as_bytes());
        assert_eq!(is("A.PLAYBACK", "<svg/>"), Some(Format::Playback));
        assert_eq!(is("dir.svg/a.nc", ""), Some(Format::Gcode));
        assert_eq!(is("a.plan.json", ""), Some(Format::Plan));
        assert_eq!(
            is("a.json", "{\"format\": \"magician-plan\"}"),
            Some(Format::Plan)
        );
        assert_eq!(
            is("a.json", "{\"format\": \"magician-testgrid\"}"),
            Some(Format::TestGrid)
        );
        assert_eq!(is("a.json", "{}"), None);
        let svg = "\u{FEFF}<?xml version=\"1.0\"?>\n<!-- <root> -->\n<!DOCTYPE svg [<!ENTITY a \"b\">]>\n<s:svg xmlns:s=\"x\">";
        assert_eq!(is("a.xml", svg), Some(Format::Svg));
        assert_eq!(is("a.xml", "<xml xmlns=\"x\"/>"), Some(Format::Blockly));
        assert_eq!(is("a.xml", "<html>"), None);
        assert_eq!(
            is("a", "999\r\nfrom a program\r\n  0\r\nSECTION\r\n"),
            Some(Format::Dxf)
        );
        assert_eq!(
            is("a", "%\n(a comment)\n; another\nN10 G0 X - 1.5 Y2"),
            Some(Format::Gcode)
        );
        for plot in [
            "IN;SP1;PU0,0;",
            "\u{1B}.(\u{1B}.I81;;17:\u{1B}.N;19:IN;SP1;",
            "\u{1B}E\u{1B}%-12345X@PJL ENTER LANGUAGE=HPGL2\n\u{1B}%0BBP5,1;IN;",
        ] {
            assert_eq!(is("a", plot), Some(Format::Hpgl), "{plot}");
        }
        for text in [
            "",
            "Good 1 morning",
            "G",
            "Inside; out",
            "<",
            "<!--",
            "<!D",
            "M",
            "1 2 3",
            "{",
        ] {
            assert_eq!(is("a.txt", text), None, "{text}");
        }
    }

    #[test]
    fn names_and_endings_are_read_back_and_unique() {
        let mut endings: Vec<&str> = Format::ALL
            .iter()
            .flat_map(|format| format.endings())
            .copied()
            .collect();
        for format in Format::ALL {
            assert_eq!(format.to_string().parse(), Ok(format));
            assert_eq!(format.name().to_uppercase().parse(), Ok(format));
            for ending in format.endings() {
                assert_eq!(ending.parse(), Ok(format));
            }
            assert!(!format.description().is_empty());
        }
        endings.sort_unstable();
        let count = endings.len();
        endings.dedup();
        assert_eq!(endings.len(), count);
        assert!("doc".parse::<Format>().unwrap_err().contains("playback"));
    }
}
