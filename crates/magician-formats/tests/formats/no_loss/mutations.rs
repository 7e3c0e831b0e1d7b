//! Mutation tests: each sample with one unusual element is read unchanged, or a note or a refusal
//! reports the difference.

use std::collections::BTreeSet;
use std::path::Path;

use magician_formats::{Content, Diagnostic, Format, Parsed, ReadOptions, read};

use super::utf16;

/// Size of a file's content: number of strokes or steps, and their length in hundredths of a
/// millimetre.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LineFigures {
    count: usize,
    length: f64,
}

impl LineFigures {
    fn of(content: &Content) -> Self {
        match content {
            Content::Artwork(artwork) => Self {
                count: artwork.strokes.len() + artwork.areas.len(),
                length: super::length(artwork),
            },
            Content::Plan(plan) => {
                let commands: Vec<String> = plan
                    .commands()
                    .map(|command| format!("{command:?}"))
                    .collect();
                Self {
                    count: plan.steps.len(),
                    length: commands.concat().len() as f64,
                }
            }
            Content::Image(raster) => Self {
                count: raster.width,
                length: raster.grey.iter().map(|grey| f64::from(*grey)).sum(),
            },
            other => panic!("{other:?}"),
        }
    }

    fn is_like(self, other: Self) -> bool {
        self.count == other.count
            && (self.length - other.length).abs() <= 1e-3 * other.length + 1e-6
    }
}

fn reading(format: Format, bytes: &[u8]) -> Result<(LineFigures, BTreeSet<String>), Diagnostic> {
    let Parsed { content, notes } = read(format, bytes, &ReadOptions::default())?;
    let told = notes.iter().map(|note| note.message.to_string());
    Ok((LineFigures::of(&content), told.collect()))
}

/// Numbers of mutations that were read unchanged, read with a note, refused, or lost.
#[derive(Default, Debug)]
struct OutcomeCounts {
    same: usize,
    noted: usize,
    refused: usize,
    lost: Vec<String>,
}

impl OutcomeCounts {
    fn add(&mut self, name: &str, format: Format, whole: &str, what: &str, bytes: &[u8]) {
        let (expected, before) = reading(format, whole.as_bytes()).unwrap();
        match reading(format, bytes) {
            Err(refused) => {
                self.refused += 1;
                assert!(!refused.message.is_empty());
            }
            Ok((found, _)) if found.is_like(expected) => self.same += 1,
            Ok((_, notes)) if notes.difference(&before).next().is_some() => self.noted += 1,
            Ok((found, _)) => self
                .lost
                .push(format!("{name}: {what}: {found:?} of {expected:?}")),
        }
    }
}

fn sample(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../magician-program/samples")
        .join(name);
    std::fs::read_to_string(path).unwrap().replace("\r\n", "\n")
}

/// Tries every mutation of a text: the whole text in other encodings, then each piece changed by
/// itself.
fn mutate(
    tally: &mut OutcomeCounts,
    name: &str,
    format: Format,
    whole: &str,
    pieces: &[std::ops::Range<usize>],
    odd: &dyn Fn(&str) -> Vec<String>,
) {
    for (what, bytes) in [
        ("UTF-16", utf16(whole)),
        ("CR", whole.replace('\n', "\r").into_bytes()),
        ("CRLF", whole.replace('\n', "\r\n").into_bytes()),
        ("byte order mark", format!("\u{FEFF}{whole}").into_bytes()),
    ] {
        tally.add(name, format, whole, what, &bytes);
    }
    for piece in pieces {
        let own = &whole[piece.clone()];
        for new in odd(own) {
            let text = [&whole[..piece.start], &new, &whole[piece.end..]].concat();
            tally.add(
                name,
                format,
                whole,
                &format!("{own:.60} -> {new:.80}"),
                text.as_bytes(),
            );
        }
    }
}

/// Returns the ranges of all pieces that start with `begin` and end with `end`.
fn between(text: &str, begin: &str, end: &str) -> Vec<std::ops::Range<usize>> {
    let found = text.match_indices(begin).filter_map(|(at, _)| {
        let rest = &text[at..];
        Some(at..at + rest.find(end)? + end.len())
    });
    found.collect()
}

fn lines(text: &str) -> Vec<std::ops::Range<usize>> {
    let mut at = 0;
    let all = text.split_inclusive('\n').map(|line| {
        let range = at..at + line.trim_end().len();
        at += line.len();
        range
    });
    all.filter(|range| !range.is_empty()).collect()
}

/// Adds an attribute to a start tag, replacing one of the same name.
fn tag_with_attribute(tag: &str, name: &str, value: &str) -> String {
    let mut plain = tag.to_owned();
    let known = format!(" {name}=\"");
    if let Some(at) = plain.find(&known) {
        let end = at + known.len() + plain[at + known.len()..].find('"').unwrap() + 1;
        plain.replace_range(at..end, "");
    }
    let close = if plain.ends_with("/>") {
        plain.len() - 2
    } else {
        plain.len() - 1
    };
    plain.insert_str(close, &format!(" {name}=\"{value}\""));
    plain
}

fn elements_with_one_odd_attribute(tag: &str) -> Vec<String> {
    let mut odd = Vec::new();
    for paint in [
        "huh",
        "var(--no)",
        "var(--no, red)",
        "CURRENTCOLOR",
        "rgb(0 0 0 / 80%)",
        "oklch(50% .1 120)",
        "url(#no)",
        "context-stroke",
        "color(display-p3 1 0 0)",
        "light-dark(black, white)",
    ] {
        odd.push(tag_with_attribute(tag, "stroke", paint));
        odd.push(tag_with_attribute(tag, "style", &format!("stroke:{paint}")));
    }
    odd.push(tag_with_attribute(tag, "fill", "huh"));
    for width in ["0", "-1", "1furlong", "thin", "var(--no)", "var(--no, 0)"] {
        odd.push(tag_with_attribute(tag, "stroke-width", width));
        odd.push(tag_with_attribute(
            tag,
            "style",
            &format!("stroke-width:{width}"),
        ));
    }
    odd.push(tag_with_attribute(tag, "transform", "twist(3)"));
    odd.push(tag_with_attribute(tag, "transform", "translate(1,2,3,4)"));
    for (name, value) in [
        ("d", "M0 0 L nonsense"),
        ("d", ""),
        ("d", "M 0 0 H 5 Q 1"),
        ("points", "1,2 3"),
        ("points", "1 2 x 4"),
        ("r", "abc"),
        ("r", "0"),
        ("r", "-2"),
        ("width", "wide"),
        ("width", "0"),
        ("height", "5parsec"),
        ("x1", "left"),
        ("rx", "none"),
        ("cx", "1e"),
    ] {
        if tag.contains(&format!(" {name}=\"")) {
            odd.push(tag_with_attribute(tag, name, value));
        }
    }
    let end = tag[1..]
        .find(|sign: char| !sign.is_ascii_alphanumeric())
        .unwrap()
        + 1;
    odd.push(format!("<wormhole{}", &tag[end..]));
    odd.push(tag.replacen(&tag[1..end], "use", 1));
    odd
}

#[test]
fn one_odd_element_of_a_drawing_is_drawn_noted_or_refused() {
    let mut tally = OutcomeCounts::default();
    for name in ["house.svg", "curves.svg", "logo.svg"] {
        let whole = sample(name);
        let mut pieces = Vec::new();
        for tag in [
            "rect", "polyline", "polygon", "line", "circle", "ellipse", "path",
        ] {
            pieces.extend(between(&whole, &format!("<{tag} "), ">"));
        }
        pieces.retain(|piece| whole[piece.clone()].ends_with("/>"));
        pieces.truncate(12);
        mutate(
            &mut tally,
            name,
            Format::Svg,
            &whole,
            &pieces,
            &elements_with_one_odd_attribute,
        );
    }
    println!(
        "SVG: {} same, {} noted, {} refused",
        tally.same, tally.noted, tally.refused
    );
    assert_eq!(tally.lost, [""; 0]);
    assert!(tally.same + tally.noted + tally.refused > 500, "{tally:?}");
}

#[test]
fn one_odd_line_of_a_program_or_plot_is_carried_out_noted_or_refused() {
    let mut tally = OutcomeCounts::default();
    let odd_words = |line: &str| {
        let mut odd = vec![
            line.replacen("G1", "G999", 1),
            line.replacen("G2 ", "G2.7 ", 1),
            format!("/{line}"),
            format!("?\n{line}"),
            format!("{line} $0"),
            format!("M73 P5\n{line}"),
            format!("M999\n{line}"),
            format!("G4\n{line}"),
            format!("{line} Q"),
            line.replacen('X', "X abc", 1),
            line.replacen('X', "X1.2.3", 1),
            line.replacen('Y', ",Y", 1),
            // An exponent with a sign has a single meaning; one without may be a word E.
            line.replacen("Y0", "Y0E-3", 1),
            line.replacen('Y', "Y1E3", 1),
            line.replacen('G', "WHILE [1] DO1\nG", 1),
            line.replacen('X', "U", 1),
        ];
        odd.retain(|new| new != line);
        odd
    };
    for name in ["pen_outline.gcode", "laser_checker.gcode"] {
        let whole = sample(name);
        let mut pieces = lines(&whole);
        pieces.retain(|piece| !whole[piece.clone()].starts_with(';'));
        pieces.truncate(30);
        mutate(&mut tally, name, Format::Gcode, &whole, &pieces, &odd_words);
    }
    let plot = sample("star.plt");
    let odd_instructions = |line: &str| {
        let mut odd = vec![
            line.replacen("PD", "QQ", 1),
            line.replacen("PD", "!PD", 1),
            format!("!ZZ1;{line}"),
            format!("?{line}"),
            line.replacen(' ', " x", 1),
            line.replacen(';', " 5;", 1),
            line.replacen("SP1", "SP0", 1),
            line.replacen("PU1600", "PU99999999", 1),
        ];
        odd.retain(|new| new != line && new != "SP0;");
        odd
    };
    mutate(
        &mut tally,
        "star.plt",
        Format::Hpgl,
        &plot,
        &lines(&plot),
        &odd_instructions,
    );
    println!(
        "G-code, HPGL: {} same, {} noted, {} refused",
        tally.same, tally.noted, tally.refused
    );
    assert_eq!(tally.lost, [""; 0]);
    assert!(tally.same + tally.noted + tally.refused > 250, "{tally:?}");
}

const DXF: &str = "0\nSECTION\n2\nENTITIES\n0\nLINE\n8\nA\n10\n0\n20\n0\n11\n20\n21\n10\n0\nCIRCLE\n8\nB\n10\n5\n20\n5\n40\n4\n0\nSPLINE\n8\nA\n70\n8\n71\n3\n11\n0\n21\n0\n11\n10\n21\n20\n11\n20\n21\n0\n0\nARC\n8\nB\n10\n5\n20\n5\n40\n9\n50\n0\n51\n90\n0\nENDSEC\n0\nEOF\n";

#[test]
fn one_odd_pair_of_a_dxf_is_drawn_noted_or_refused() {
    let mut tally = OutcomeCounts::default();
    for (name, whole) in [
        ("generated.dxf", DXF.to_owned()),
        ("plate.dxf", sample("plate.dxf")),
    ] {
        let mut pieces = lines(&whole);
        pieces.truncate(200);
        let odd = |line: &str| {
            if line.trim().parse::<f64>().is_ok() {
                return vec!["abc".to_owned(), "1,5,2".to_owned()];
            }
            match line {
                "LINE" | "CIRCLE" | "SPLINE" | "ARC" | "LWPOLYLINE" => {
                    vec![
                        "WORMHOLE".to_owned(),
                        "HELIX".to_owned(),
                        "3DSOLID".to_owned(),
                    ]
                }
                _ => Vec::new(),
            }
        };
        mutate(&mut tally, name, Format::Dxf, &whole, &pieces, &odd);
    }
    println!(
        "DXF: {} same, {} noted, {} refused",
        tally.same, tally.noted, tally.refused
    );
    assert_eq!(tally.lost, [""; 0]);
    assert!(tally.same + tally.noted + tally.refused > 100, "{tally:?}");
}

#[test]
fn one_odd_item_of_taught_points_and_blocks_is_played_noted_or_refused() {
    let mut tally = OutcomeCounts::default();
    let numbers = |own: &str| {
        let open = own.find('>').unwrap() + 1;
        let close = own.rfind('<').unwrap();
        let name = &own[1..open - 1];
        let mut odd: Vec<String> = ["abc", "1,5,2", "", "1e999"]
            .iter()
            .map(|value| [&own[..open], value, &own[close..]].concat())
            .collect();
        odd.push(own.replace(name, "item_77"));
        odd.push(own.replace(name, "stranger"));
        odd
    };
    for name in [
        "arc_movl_v1412.playback",
        "gripper_pick_v194.playback",
        "suction_points_v194.playback",
        "jump_suction_named_v170.playback",
    ] {
        let whole = sample(name);
        let mut pieces = Vec::new();
        for item in [0, 2, 3, 4, 5, 10, 11, 12] {
            let begin = format!("<item_{item}>");
            pieces.extend(
                between(&whole, &begin, &begin.replace('<', "</"))
                    .into_iter()
                    .take(3),
            );
        }
        mutate(
            &mut tally,
            name,
            Format::Playback,
            &whole,
            &pieces,
            &numbers,
        );
    }
    let blocks = sample("example_loop.blockly");
    let types = between(&blocks, "<block type=\"", "\"");
    let pieces: Vec<_> = between(&blocks, "<block type=\"", ">");
    assert!(!types.is_empty());
    let odd_blocks = |own: &str| {
        let kind = own.split('"').nth(1).unwrap();
        vec![
            own.replacen(kind, "wormhole", 1),
            own.replacen(kind, "Magician_SetPTPCmd", 1),
        ]
    };
    mutate(
        &mut tally,
        "example_loop.blockly",
        Format::Blockly,
        &blocks,
        &pieces,
        &odd_blocks,
    );
    let lab = String::from_utf8(super::data("dobotlab.playback")).unwrap();
    let words: Vec<_> = [
        "\"move\"",
        "\"moveJ\"",
        "\"endtool\"",
        "\"suctionCup\"",
        "\"on\"",
        "\"Magician\"",
        "[220,0,40,0]",
    ]
    .iter()
    .flat_map(|word| {
        between(&lab, word, &word[word.len() - 1..])
            .into_iter()
            .map(|range| range.start..range.start + word.len())
    })
    .collect();
    let odd_words = |_: &str| {
        vec![
            "\"stranger\"".to_owned(),
            "null".to_owned(),
            "[1,2]".to_owned(),
        ]
    };
    mutate(
        &mut tally,
        "dobotlab.playback",
        Format::Playback,
        &lab,
        &words,
        &odd_words,
    );
    let points = "X,Y,Z,R,Pause,Suction\n200,0,10,0,0,1\n210,5,10,0,1,0\n220,5,10,0,0,1\n";
    let odd_lines = |line: &str| {
        let mut odd = vec![
            line.replacen("Pause", "Wormhole", 1),
            line.replacen("Suction", "Tool 7", 1),
            line.replacen('X', "Q", 1),
            line.replacen(",10,", ",abc,", 1),
            line.replacen(",10,", ",,", 1),
            format!("{line},9"),
            line.replacen("0,1", "0,on?", 1),
        ];
        odd.retain(|new| new != line);
        odd
    };
    mutate(
        &mut tally,
        "points.csv",
        Format::Points,
        points,
        &lines(points),
        &odd_lines,
    );
    println!(
        "taught: {} same, {} noted, {} refused",
        tally.same, tally.noted, tally.refused
    );
    assert_eq!(tally.lost, [""; 0]);
    assert!(tally.same + tally.noted + tally.refused > 400, "{tally:?}");
}
