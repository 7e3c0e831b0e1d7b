//! Text that is written with the pen.

use std::fmt::Write;

use magician_program::{
    Align, Artwork, BundledFont, Content, Diagnostic, DiagnosticCode, FontChoice, Format,
    ReadOptions, read,
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

/// All that can be seen of Latin-1 and Latin Extended-A.
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
fn no_line_is_wider_than_the_wrap_and_nothing_is_lost() {
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
fn lines_lie_where_they_are_aligned() {
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
fn characters_that_the_font_lacks_are_named_and_refused_if_that_is_wanted() {
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
fn a_letter_and_its_mark_are_the_letter_with_the_mark() {
    let options = options(BundledFont::Script, 10.0);
    let lines = |text| -> Vec<_> {
        let strokes = written(text, &options).0.strokes.into_iter();
        strokes.map(|stroke| stroke.points).collect()
    };
    assert_eq!(lines("e\u{301}i\u{308}c\u{327}"), lines("éïç"));
    assert_eq!(lines("a\u{200B}b\r"), lines("ab"));
}

#[test]
fn text_that_cannot_be_written_is_refused() {
    let options = options(BundledFont::Sans, 10.0);
    let refused = |bytes: &[u8]| read(Format::Text, bytes, &options).unwrap_err().message;
    assert_eq!(refused(b" \n\t"), "there is no text");
    assert_eq!(refused(b"ab\xff"), "the text is not UTF-8 from byte 2 on");
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

/// Writes pictures of the fonts to the directory `FONT_SHEETS`, to be looked at.
#[test]
#[ignore = "writes pictures: FONT_SHEETS=DIR"]
fn sheets_of_the_fonts() {
    let directory = std::env::var("FONT_SHEETS").unwrap();
    for font in BundledFont::ALL {
        let mut options = options(font, 8.0);
        options.text.line_height = 2.2;
        let all: Vec<char> = latin().collect();
        let mut text = String::new();
        for row in all.chunks(24) {
            for character in row {
                let _ = write!(text, "{character} ");
            }
            text.push('\n');
        }
        text.push_str("Straße Ærøskøbing Þórður łódź œuvre 12½ £5 €3 “a” ‘b’ – …\nZażółć gęślą jaźń. Příliš žluťoučký kůň.");
        let (artwork, _) = written(&text, &options);
        let [_, most] = artwork.bounds().unwrap();
        let mut svg = format!(
            "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-5 -5 {} {}' width='{}' fill='none' stroke='black' stroke-width='0.4'><rect x='-5' y='-5' width='999' height='999' fill='white' stroke='none'/>",
            most[0] + 10.0,
            most[1] + 10.0,
            5.0 * most[0]
        );
        for stroke in &artwork.strokes {
            svg.push_str("<path d='M");
            for [x, y] in &stroke.points {
                let _ = write!(svg, " {x:.2} {:.2}", most[1] - y);
            }
            svg.push_str("'/>");
        }
        svg.push_str("</svg>");
        std::fs::write(format!("{directory}/{font}.svg"), svg).unwrap();
    }
}
