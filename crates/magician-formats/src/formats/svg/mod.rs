//! Reader of SVG drawings: every visible line becomes a stroke, in true size.
//!
//! The crate `usvg` resolves `use`, markers, nested drawings, styles and text layout. This module
//! prepares the text for it ([`source`]), bounds its work ([`cost`]), and walks its tree
//! ([`collector`]).
//!
//! * A painted stroke becomes its centre line, whatever its width. A fill without a stroke becomes
//!   its outline, or an area on request.
//! * Clip paths and black-and-white masks cut lines; gradual masks are ignored with a note.
//! * White is drawn only on darker shapes.
//! * Texts are written in the bundled font, as outlines or in single lines.
//! * Images and filters are left out with a note.

mod area;
mod clip;
mod collector;
mod cost;
mod css;
mod cycles;
mod families;
mod filled;
mod lines;
mod mask;
mod notes;
mod numbers;
mod source;
mod text;
mod values;
mod white;

use kurbo::Affine;
use magician_host::message;
use magician_host::{Setting, SettingValue};
use usvg::tiny_skia_path::PathSegment;
use usvg::{ClipPath, Group, ImageHrefResolver, Mask, Node, Options, Tree};

use self::collector::StrokeCollector;
use self::lines::Closeness;
use self::notes::Notes;
use self::source::{Page, Source};
use self::white::Whites;
use super::{Chords, Content, Parsed, ReadOptions, SystemFonts};
use crate::encoding::{Fallback, decode};
use crate::{Artwork, Diagnostic, DiagnosticCode, Stroke};

/// Largest size of a file, bytes. It bounds memory, of which the parsed document takes a multiple.
const MAX_FILE_SIZE: usize = 64 << 20;
/// Size of a pixel, mm: 96 per inch (CSS Values and Units 3, section 6.2).
const PIXEL_SIZE: f64 = 25.4 / 96.0;
/// Distance beyond the page that still counts as on it, mm. A choice: frames are often drawn on the
/// very edge.
const PAGE_TOLERANCE: f64 = 1.0;
/// Largest factor by which a drawing is enlarged for usvg, whose numbers have 32 bits.
const MAX_ENLARGEMENT: f64 = 4096.0;
/// Stack for usvg, bytes, because it reads nested elements recursively.
#[cfg_attr(target_family = "wasm", allow(dead_code))]
const STACK_SIZE: usize = 64 << 20;
/// Style sheet that disables filters, and markers on the lines of markers, which usvg would follow
/// without end.
const STYLE_SHEET: &str = "* { filter: none !important }
marker * { marker-start: none !important; marker-mid: none !important; marker-end: none !important }
marker use { display: none !important }";

pub(super) fn read(
    bytes: &[u8],
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed, Diagnostic> {
    if bytes.len() > MAX_FILE_SIZE {
        let message = message!(
            "it has {bytes} bytes, limit {largest}",
            bytes = bytes.len(),
            largest = MAX_FILE_SIZE
        );
        return Err(Diagnostic::of_file(message));
    }
    let bytes = crate::gzip::unpack(bytes, MAX_FILE_SIZE)?;
    let bytes = bytes.as_ref();
    let decoded = decode(bytes, Fallback::Western)?;
    let mut drawing = with_deep_stack(|| drawing(&decoded.text, options, chords))?;
    drawing.notes.extend(decoded.note);
    Ok(Parsed {
        content: Content::Artwork(drawing.content),
        notes: drawing.notes,
    })
}

/// Runs `work` directly. Without threads the caller's stack must be large enough: link with
/// `-zstack-size` of [`STACK_SIZE`].
#[cfg(target_family = "wasm")]
fn with_deep_stack<T>(work: impl FnOnce() -> Result<T, Diagnostic>) -> Result<T, Diagnostic> {
    work()
}

/// Runs `work` on a thread with a large stack. A panic of usvg becomes an error of the file.
#[cfg(not(target_family = "wasm"))]
fn with_deep_stack<T: Send>(
    work: impl FnOnce() -> Result<T, Diagnostic> + Send,
) -> Result<T, Diagnostic> {
    std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().stack_size(STACK_SIZE);
        match thread
            .spawn_scoped(scope, work)
            .map(|running| running.join())
        {
            Ok(Ok(done)) => done,
            Ok(Err(_)) => Err(Diagnostic::of_file(message!("this drawing cannot be read"))),
            Err(error) => Err(Diagnostic::of_file(message!(
                "there is no room to read it: {error}",
                error = error.to_string()
            ))),
        }
    })
}

fn drawing(
    text: &str,
    options: &ReadOptions,
    chords: &Chords,
) -> Result<Parsed<Artwork>, Diagnostic> {
    let mut notes = Notes::default();
    let source = source::prepare(text, &mut notes)?;
    let mut installed = options.system_fonts == SystemFonts::On && text::names_fonts(&source.text);
    let of_file = text::FileFonts::of(&source.text, &mut notes)?;
    let mut fonts = text::fonts(&of_file, installed);
    let mut tree = tree_of(&source.text, &fonts, installed)?;
    if installed && text::lacks_glyphs(tree.root()) {
        // Installed fonts draw a box for a missing character, so fall back to the bundled font.
        installed = false;
        fonts = text::fonts(&of_file, installed);
        tree = tree_of(&source.text, &fonts, installed)?;
    }
    let (width, height) = (tree.size().width(), tree.size().height());
    let page = [width, height].map(|side| f64::from(side) * PIXEL_SIZE);
    if source.page == Page::ViewBox {
        let [width, height] = page;
        let remark = message!(
            "no size is given: with 1/96 inch per unit the page is {width:.1} by {height:.1} mm",
            width,
            height
        );
        notes.add(Diagnostic::of_file(remark).coded(DiagnosticCode::Assumed));
    }
    let times = enlargement(chords);
    let larger = if times > 1.0 && text::runs_along_paths(tree.root()) {
        let size = match source.page {
            Page::Sized | Page::ViewBox => [width, height],
            // Percentages refer to this size if the file gives none.
            Page::Unknown => {
                let fallback = Options::default().default_size;
                [fallback.width(), fallback.height()]
            }
        };
        source::enlarged(&source.text, size, times as f32)?
    } else {
        None
    };
    let mut pixel = PIXEL_SIZE;
    if let Some(larger) = larger {
        tree = tree_of(&larger, &fonts, installed)?;
        pixel /= times;
    }
    // Flip y: in artwork it goes up from the lower edge of the page.
    let to = Affine::new([pixel, 0.0, 0.0, -pixel, 0.0, page[1]]);
    let tolerance = if has_curves(tree.root()) {
        chords.for_curve()
    } else {
        chords.tolerance()
    };
    let close = Closeness::new(tolerance, chords.unit());
    let Source {
        elements,
        layers: in_file,
        page: says,
        shapes,
        is_font,
        ..
    } = source;
    let whites = Whites::of(tree.root(), options.white);
    let mut collector = StrokeCollector::new(
        &elements, &in_file, close, options, whites, &mut notes, fonts,
    );
    collector.all(tree.root(), to)?;
    let StrokeCollector {
        strokes,
        areas,
        names,
        layers,
        colors,
        ..
    } = collector;
    let areas = areas.into_filled();
    if strokes.is_empty() && areas.is_empty() && notes.is_empty() {
        notes.add(nothing_visible(shapes, is_font));
    }
    if says != Page::Unknown && !options.clip_page {
        note_beyond_page(&strokes, page, &mut notes);
    }
    let artwork = Artwork {
        title: options.title.clone(),
        page: (says != Page::Unknown).then_some(page),
        strokes,
        areas,
        names,
        layers,
        colors,
        ..Artwork::default()
    };
    Ok(Parsed {
        content: artwork,
        notes: notes.into_diagnostics(),
    })
}

/// Factor by which a drawing is enlarged for usvg, so that letters along a path are placed
/// precisely at the size drawn: usvg places them within about half a pixel.
///
/// A power of 2 changes only the exponent of numbers.
fn enlargement(chords: &Chords) -> f64 {
    let finest = PIXEL_SIZE / (2.0 * chords.tolerance());
    libm::exp2(libm::ceil(libm::log2(finest.clamp(1.0, MAX_ENLARGEMENT))))
}

/// True if any part may contain a curve.
fn has_curves(group: &Group) -> bool {
    let clip = group.clip_path().map(ClipPath::root);
    let mask = group.mask().map(Mask::root);
    let curved = |node: &Node| match node {
        Node::Group(group) => has_curves(group),
        Node::Path(path) => path
            .data()
            .segments()
            .any(|segment| matches!(segment, PathSegment::QuadTo(..) | PathSegment::CubicTo(..))),
        Node::Text(_) => true,
        Node::Image(_) => false,
    };
    clip.into_iter().chain(mask).any(has_curves) || group.children().iter().any(curved)
}

/// Returns a note why a drawing has no lines.
fn nothing_visible([shapes, hidden]: [usize; 2], is_font: bool) -> Diagnostic {
    let message = match shapes {
        0 if is_font => {
            let message =
                message!("the file is a font: it has letters, and draws nothing by itself");
            let note = Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut);
            return note.remedy(
                (Setting::Font, SettingValue::Any("FILE")),
                "writes text with it",
            );
        }
        0 => message!("the drawing has no shapes"),
        1 if hidden == 1 => message!("the only shape of the drawing is hidden"),
        all if all == hidden => message!("all {all} shapes of the drawing are hidden", all),
        1 => message!("the only shape of the drawing has no visible line or fill, or is cut off"),
        all => message!(
            "of the {all} shapes of the drawing none has a visible line or fill that is not cut off",
            all
        ),
    };
    Diagnostic::of_file(message).coded(DiagnosticCode::LeftOut)
}

/// Notes lines beyond the page. A viewer would hide them, but the pen draws them, maybe beside the
/// paper.
fn note_beyond_page(strokes: &[Stroke], [width, height]: [f64; 2], notes: &mut Notes) {
    let within = |at: &[f64; 2]| {
        let [x, y] = *at;
        (-PAGE_TOLERANCE..=width + PAGE_TOLERANCE).contains(&x)
            && (-PAGE_TOLERANCE..=height + PAGE_TOLERANCE).contains(&y)
    };
    for stroke in strokes {
        if !stroke.points.iter().all(within) {
            let remark = message!("a line leaves the page and is drawn there too");
            let note = Diagnostic::new(stroke.origin, remark).coded(DiagnosticCode::Assumed);
            notes.add(note.remedy((Setting::ClipPage, SettingValue::On), "cuts it off"));
        }
    }
}

fn tree_of(source: &str, fonts: &text::LaidFonts, installed: bool) -> Result<Tree, Diagnostic> {
    let mut options = Options {
        dpi: 96.0,
        style_sheet: Some(STYLE_SHEET.to_owned()),
        // Images are not drawn, and a drawing must not read other files.
        image_href_resolver: ImageHrefResolver {
            resolve_data: Box::new(|_, _, _| None),
            resolve_string: Box::new(|_, _| None),
        },
        ..Options::default()
    };
    text::set_up(&mut options, fonts, installed);
    let document = source::parse(source)?;
    Tree::from_xmltree(&document, &options).map_err(|error| {
        let message = match error {
            usvg::Error::InvalidSize => message!("the drawing has no size (width or height is 0)"),
            usvg::Error::ParsingFailed(roxmltree::Error::NodesLimitReached) => {
                message!("it has too many elements, or too deeply nested ones")
            }
            other => other.to_string().into(),
        };
        Diagnostic::of_file(message)
    })
}
