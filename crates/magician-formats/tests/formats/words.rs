//! Text that is drawn with the pen.

use magician_formats::{
    Align, Artwork, BundledFont, Content, Diagnostic, DiagnosticCode, FontChoice, Format,
    ReadOptions, TextLines, read,
};

fn options(font: BundledFont, size: f64) -> ReadOptions {
    let mut options = ReadOptions::default();
    options.text.font = FontChoice::Bundled(font);
    options.text.size = size;
    options
}

fn written(text: &str, options: &ReadOptions) -> (Artwork, Vec<Diagnostic>) {
    let parsed = read(Format::Text, text.as_bytes(), options).unwrap();
    let Content::Artwork(artwork) = parsed.content else {
        panic!("{:?}", parsed.content);
    };
    (artwork, parsed.notes)
}

/// Returns all visible characters of Latin-1 and Latin Extended-A.
fn latin() -> impl Iterator<Item = char> {
    let ranges = ['!'..='~', '\u{A1}'..='\u{FF}', '\u{100}'..='\u{17F}'];
    let all = ranges.into_iter().flatten();
    all.filter(|character| *character != '\u{AD}')
}

#[test]
fn every_letter_of_latin_1_and_extended_a_is_in_each_font() {
    for font in BundledFont::ALL {
        let mut options = options(font, 10.0);
        options.strict_text = true;
        for character in latin() {
            let (artwork, notes) = written(&character.to_string(), &options);
            assert!(notes.is_empty(), "{font} {character}: {notes:?}");
            assert!(!artwork.strokes.is_empty(), "{font} {character}");
        }
    }
}

#[test]
fn a_capital_is_as_high_as_the_size() {
    for font in BundledFont::ALL {
        for size in [0.7, 3.0, 12.0, 99.9] {
            let (artwork, _) = written("H", &options(font, size));
            let [least, most] = artwork.bounds().unwrap();
            let height = most[1] - least[1];
            assert!((height - size).abs() < 1e-6, "{font} {size}: {height}");
        }
    }
}

const PROSE: &str = "The quick brown fox jumps over the lazy dog. Zażółć gęślą jaźń, \
Příliš žluťoučký kůň; Straße, œuvre, Þórður.\n\n    Indented, and a-hyphenated-word-that-is-long, \
Donaudampfschifffahrtselektrizitätenhauptbetriebswerkbauunterbeamtengesellschaft.";

#[test]
fn wrapped_lines_fit_the_width_and_lose_nothing() {
    for font in BundledFont::ALL {
        let count = |text: &str, options: &ReadOptions| written(text, options).0.strokes.len();
        for align in [Align::Left, Align::Center, Align::Right] {
            for wrap in [12.0, 40.0, 90.0, 400.0] {
                let mut options = options(font, 5.0);
                options.text.align = align;
                let all = count(PROSE, &options);
                options.text.wrap = Some(wrap);
                let (artwork, _) = written(PROSE, &options);
                let [least, most] = artwork.bounds().unwrap();
                assert!(most[0] - least[0] <= wrap + 1e-6, "{font} {align} {wrap}");
                assert_eq!(artwork.strokes.len(), all, "{font} {align} {wrap}");
            }
        }
        let mut narrow = options(font, 5.0);
        narrow.text.wrap = Some(1.0);
        let refused = read(Format::Text, b"wide", &narrow).unwrap_err();
        assert!(refused.message.contains("'w' is"), "{refused}");
    }
}

#[test]
fn lines_follow_their_alignment() {
    let middles = |align| {
        let mut options = options(BundledFont::Sans, 10.0);
        options.text.align = align;
        options.text.line_height = 2.0;
        let (artwork, _) = written("HHH\nH", &options);
        let line = |from: f64, to: f64| {
            let points = artwork.strokes.iter().flat_map(|stroke| &stroke.points);
            let xs = points
                .filter(|[_, y]| (from..=to).contains(y))
                .map(|[x, _]| *x);
            xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
                [least.min(x), most.max(x)]
            })
        };
        (line(-0.1, 10.1), line(19.9, 30.1))
    };
    let (short, long) = middles(Align::Left);
    assert!((short[0] - long[0]).abs() < 1e-9, "{short:?} {long:?}");
    let (short, long) = middles(Align::Right);
    assert!((short[1] - long[1]).abs() < 1e-9, "{short:?} {long:?}");
    let (short, long) = middles(Align::Center);
    let middle = |[from, to]: [f64; 2]| (from + to) / 2.0;
    assert!(
        (middle(short) - middle(long)).abs() < 1e-9,
        "{short:?} {long:?}"
    );
}

#[test]
fn missing_characters_are_named_and_refused_in_strict_mode() {
    let mut options = options(BundledFont::Sans, 10.0);
    let (artwork, notes) = written("a中b\n中文", &options);
    let of_letters = written("ab", &options).0.strokes.len();
    assert_eq!(artwork.strokes.len(), of_letters);
    let told: Vec<_> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        [
            "U+4E2D '中' is left out: the font sans does not have it",
            "U+6587 '文' is left out: the font sans does not have it"
        ]
    );
    assert_eq!(notes[0].code, DiagnosticCode::LeftOut);
    assert_eq!((notes[1].origin.line, notes[1].origin.column), (2, 2));
    assert_eq!(notes[0].remedies[0].act.to_string(), "font FILE");
    options.strict_text = true;
    let refused = read(Format::Text, "a中b".as_bytes(), &options).unwrap_err();
    assert_eq!((refused.origin.line, refused.origin.column), (1, 2));
    assert_eq!(refused.code, DiagnosticCode::Problem);
}

#[test]
fn combining_mark_equals_the_precomposed_letter() {
    let options = options(BundledFont::Script, 10.0);
    let lines = |text| -> Vec<_> {
        let strokes = written(text, &options).0.strokes.into_iter();
        strokes.map(|stroke| stroke.points).collect()
    };
    assert_eq!(lines("e\u{301}i\u{308}c\u{327}"), lines("éïç"));
    assert_eq!(lines("a\u{200B}b\r"), lines("ab"));
}

#[test]
fn unwritable_text_is_refused() {
    let options = options(BundledFont::Sans, 10.0);
    let refused = |bytes: &[u8]| read(Format::Text, bytes, &options).unwrap_err().message;
    assert_eq!(refused(b" \n\t"), "there is no text");
    assert_eq!(refused(b"ab\xff\0"), "this is not UTF-8 text");
    let long = "a".repeat(100_001);
    assert!(refused(long.as_bytes()).contains("limit 100000"));
}

#[test]
fn every_stroke_has_its_character_as_origin() {
    let (artwork, _) = written("Hi\nno", &options(BundledFont::Sans, 10.0));
    let origins = artwork.strokes.iter().map(|stroke| stroke.origin);
    let mut places: Vec<_> = origins.map(|origin| (origin.line, origin.column)).collect();
    places.dedup();
    assert_eq!(places, [(1, 1), (1, 2), (2, 1), (2, 2)]);
}

fn options_with_font(name: &str, bytes: &[u8]) -> ReadOptions {
    let mut options = ReadOptions::default();
    options.text.font = FontChoice::file(name, bytes);
    options
}

const SVG_FONT: &str = r#"<svg xmlns="http://www.w3.org/2000/svg"><defs>
<font id="one" horiz-adv-x="500"><font-face units-per-em="1000" cap-height="900"/>
<glyph unicode="H" d="M100 0V600M400 0V600M100 300H400"/>
<glyph unicode="o" horiz-adv-x="400" d="M50 200C50 400 350 400 350 200S50 0 50 200"/>
<glyph unicode="ffi" d="M0 0"/><glyph unicode="&#233;" d="M0 0H10"/></font></defs></svg>"#;

#[test]
fn svg_font_is_drawn_unchanged() {
    let options = options_with_font("one.svg", SVG_FONT.as_bytes());
    let (artwork, notes) = written("Ho", &options);
    assert_eq!(artwork.strokes.len(), 4);
    assert!(notes.is_empty() && !artwork.in_order);
    // The H is 600 units high, whatever the font states, and 10 mm when drawn.
    let left: Vec<_> = artwork.strokes[0].points.clone();
    assert_eq!(left, [[0.0, 0.0], [0.0, 10.0]]);
    let round = &artwork.strokes[3];
    assert!((round.points[0][0] - 450.0 / 60.0).abs() < 1e-9);
    for [x, y] in &round.points {
        assert!(
            (7.5..12.51).contains(x) && (-0.1..6.0).contains(y),
            "{x} {y}"
        );
    }
    let (_, notes) = written("Hi é", &options);
    let told: Vec<_> = notes.iter().map(|note| note.message.as_str()).collect();
    assert_eq!(
        told,
        ["written in sans, because the font one.svg does not have them: 'i'"]
    );
}

#[test]
fn an_outline_font_gives_the_edges_of_its_letters() {
    let roboto = include_bytes!("../../fonts/Roboto-Regular.ttf");
    for size in [4.0, 30.0] {
        let mut options = options_with_font("Roboto.ttf", roboto);
        options.text.size = size;
        let (artwork, notes) = written("HOé", &options);
        assert!(notes.is_empty(), "{notes:?}");
        assert!(
            artwork
                .strokes
                .iter()
                .all(magician_formats::Stroke::is_closed)
        );
        let (capital, _) = written("H", &options);
        let [least, most] = capital.bounds().unwrap();
        assert!((most[1] - least[1] - size).abs() < 1e-6);
    }
    let mut strict = options_with_font("Roboto.ttf", roboto);
    strict.strict_text = true;
    assert!(read(Format::Text, "東".as_bytes(), &strict).is_err());
}

const KANJI: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.0//EN" "http://www.w3.org/TR/2001/REC-SVG-20010904/DTD/svg10.dtd" [
<!ATTLIST g xmlns:kvg CDATA #FIXED "http://kanjivg.tagaini.net" kvg:element CDATA #IMPLIED >
]>
<svg xmlns="http://www.w3.org/2000/svg" width="109" height="109" viewBox="0 0 109 109">
<g id="kvg:StrokePaths_04e8c"><g id="kvg:04e8c" kvg:element="二">
<path id="kvg:04e8c-s1" d="M25,30c10,1 40,1 60,0"/><path id="kvg:04e8c-s2" d="M10,85c20,1 60,1 90,0"/>
</g></g><g id="kvg:StrokeNumbers_04e8c"><text>1</text></g></svg>"#;

/// Strokes of a character keep their order and direction, even where another order would shorten
/// the travel.
#[test]
fn strokes_of_characters_are_drawn_in_their_order() {
    let medians =
        r#"{"strokes":["M 0 0"],"medians":[[[200,700],[800,700]],[[100,100],[900,100]]]}"#;
    let all = format!(r#"{{"二":{medians},"一":{{"medians":[[[100,400],[900,400]]]}}}}"#);
    let lines = format!(
        "{}\n{}\n",
        r#"{"character":"二","strokes":["M 0 0"],"medians":[[[200,700],[800,700]],[[100,100],[900,100]]]}"#,
        r#"{"character":"一","strokes":[],"medians":[[[100,400],[900,400]]]}"#
    );
    let one_file = KANJI
        .replace("<svg ", "<kanjivg xmlns:kvg='k' ")
        .replace("</svg>", "</kanjivg>");
    let one_file = one_file.replace("g id=\"kvg:StrokePaths_", "g id=\"kvg:kanji_");
    for (name, file) in [
        ("04e8c.svg", KANJI),
        ("kanjivg.xml", &one_file),
        ("data/二.json", medians),
        ("all.json", &all),
        ("graphics.txt", &lines),
    ] {
        let (artwork, notes) = written("二二", &options_with_font(name, file.as_bytes()));
        assert!(notes.is_empty(), "{name}: {notes:?}");
        assert!(artwork.in_order, "{name}");
        let strokes = &artwork.strokes;
        assert_eq!(strokes.len(), 4, "{name}");
        for [upper, lower] in [[&strokes[0], &strokes[1]], [&strokes[2], &strokes[3]]] {
            assert!(upper.points[0][1] > lower.points[0][1] + 5.0, "{name}");
            for stroke in [upper, lower] {
                assert!(stroke.points[0][0] < stroke.points[stroke.points.len() - 1][0]);
            }
        }
    }
    let refused = |name, text: &str| {
        let refused = read(
            Format::Text,
            "二".as_bytes(),
            &options_with_font(name, text.as_bytes()),
        );
        refused.unwrap_err().message
    };
    assert!(refused("two.json", medians).contains("named for it"));
    assert!(refused("a.json", "{}").contains("no character"));
    assert!(refused("a.svg", "<svg/>").contains("neither TrueType"));
    assert!(refused("a.svg", "<svg><font></font></svg>").contains("no glyph"));
    let far = r#"<svg><font><glyph unicode="二" d="M0 0C1e300 0 1 1 2 2"/></font></svg>"#;
    assert!(refused("a.svg", far).contains("too far away"));
    let flat = r#"<svg><font><glyph unicode="H" d="M0 0H1"/></font></svg>"#;
    assert!(refused("a.svg", flat).contains("no height"));
    assert!(refused("二.json", &medians.replace("900", "1e300")).contains("too far away"));
}

fn svg(body: &str, options: &ReadOptions) -> (Artwork, Vec<Diagnostic>) {
    let svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="100mm" viewBox="0 0 200 100">{body}</svg>"#
    );
    let parsed = read(Format::Svg, svg.as_bytes(), options).unwrap();
    let Content::Artwork(artwork) = parsed.content else {
        panic!("{:?}", parsed.content);
    };
    (artwork, parsed.notes)
}

#[test]
fn texts_use_single_lines_by_font_or_option() {
    let usual = ReadOptions::default();
    let mut stroke = ReadOptions::default();
    stroke.text_lines = TextLines::Stroke;
    let text = |family: &str| {
        format!(r#"<text x="10" y="50" font-size="20" font-family="'{family}'">HIT</text>"#)
    };
    let lines = |family: &str, options| svg(&text(family), options);
    for family in [
        "Hershey Sans 1-stroke",
        "HersheyScript1",
        "EMS Nixish Single Line",
        "My 1-Stroke",
    ] {
        let (artwork, notes) = lines(family, &usual);
        assert!(notes.is_empty(), "{family}: {notes:?}");
        assert!(
            artwork.strokes.iter().all(|stroke| !stroke.is_closed()),
            "{family}"
        );
    }
    let (sans, _) = lines("Hershey", &usual);
    // Three strokes of the H, one of the I, two of the T.
    assert_eq!(sans.strokes.len(), 6);
    assert_eq!(lines("Arial", &stroke).0.strokes.len(), 6);
    assert!(
        lines("Arial", &usual)
            .0
            .strokes
            .iter()
            .all(magician_formats::Stroke::is_closed)
    );
    // The strokes lie on the outlines and have the same height.
    let (outlines, _) = lines("Roboto", &usual);
    let ([from, to], [of, end]) = (sans.bounds().unwrap(), outlines.bounds().unwrap());
    for (one, other) in [from, to]
        .into_iter()
        .flatten()
        .zip([of, end].into_iter().flatten())
    {
        assert!((one - other).abs() < 1.5, "{from:?} {to:?} {of:?} {end:?}");
    }
    assert!((to[1] - from[1] - (end[1] - of[1])).abs() < 0.05);
}

#[test]
fn font_with_an_unquoted_name_is_found() {
    let usual = ReadOptions::default();
    for attribute in [
        r#"font-family="Hershey Sans 1-stroke""#,
        "font-family='Hershey Sans 1-stroke'",
        r#"font-family="My 1-stroke , serif""#,
        r#"style="fill:black;font-family: Hershey Sans 1-stroke ;stroke:none""#,
        r#"style="font-family:'Hershey Sans 1-stroke'""#,
    ] {
        let (artwork, notes) = svg(
            &format!(
                r#"<text x="10" y="50" font-size="20" {attribute}>HI<tspan {attribute}>T</tspan></text>"#
            ),
            &usual,
        );
        assert!(notes.is_empty(), "{attribute}: {notes:?}");
        assert_eq!(artwork.strokes.len(), 6, "{attribute}");
    }
}

#[test]
fn single_lines_follow_anchors_tspans_and_transforms() {
    let usual = ReadOptions::default();
    let bounds = |body: &str| svg(body, &usual).0.bounds().unwrap();
    let text =
        |rest: &str| format!(r#"<text font-size="10" font-family="Hershey" {rest}>HH</text>"#);
    let [start, end] = bounds(&text(r#"x="100" y="50""#));
    assert!(start[0] > 100.0 && start[1] - 50.0 < 1e-3, "{start:?}");
    let [from, to] = bounds(&text(r#"x="100" y="50" text-anchor="end""#));
    assert!(to[0] < 100.0 && (to[0] - from[0] - (end[0] - start[0])).abs() < 1e-3);
    let [from, to] = bounds(&text(r#"x="100" y="50" text-anchor="middle""#));
    assert!(((from[0] + to[0]) / 2.0 - 100.0).abs() < 0.5);
    let [from, to] = bounds(&text(r#"transform="translate(50 50) rotate(90) scale(2)""#));
    assert!((to[1] - from[1] - 2.0 * (end[0] - start[0])).abs() < 1e-2);
    let both = r#"<text x="10" y="20" font-size="10" font-family="Hershey">H<tspan x="10" y="60" font-size="20">H</tspan></text>"#;
    let strokes = svg(both, &usual).0.strokes;
    let height = |nth: usize| (strokes[nth].points[0][1] - strokes[nth].points[1][1]).abs();
    assert_eq!(strokes.len(), 6);
    assert!((height(3) - 2.0 * height(0)).abs() < 1e-3);
}

#[test]
fn characters_missing_in_all_fonts_are_named_or_refused() {
    for family in ["Hershey", "Arial"] {
        let body = format!(r#"<text x="5" y="50" font-family="{family}">a中b</text>"#);
        let mut options = ReadOptions::default();
        let (_, notes) = svg(&body, &options);
        let named = |note: &&Diagnostic| note.message.starts_with("U+4E2D '中' is left out");
        let note = notes.iter().find(named).expect(family);
        assert_eq!(note.code, DiagnosticCode::LeftOut);
        options.strict_text = true;
        let svg =
            format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">{body}</svg>"#);
        let refused = read(Format::Svg, svg.as_bytes(), &options).unwrap_err();
        assert!(
            refused.message.starts_with("U+4E2D '中': the font"),
            "{refused}"
        );
    }
}
