//! Pages of a class to print: codes to cut out, and results.

use std::fmt::Write;

use serde_json::Value;

/// Margin around a picture, mm.
const MARGIN: f64 = 2.0;
/// Most points of a picture. Keeps the file of 500 results small.
const MAX_POINTS: usize = 4000;

const HTML_HEAD: &str = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
<meta name=\"viewport\" content=\"width=device-width\">\n<style>\n\
:root{color-scheme:light dark;--line:#888}\nbody{font:16px/1.4 system-ui,sans-serif;margin:1.5rem}\n\
h1{font-size:1.4rem}ul{list-style:none;padding:0;display:grid;gap:1rem;grid-template-columns:repeat(auto-fill,minmax(15rem,1fr))}\n\
li{border:1px dashed var(--line);border-radius:4px;padding:.8rem;break-inside:avoid}\nsmall{color:GrayText}\n\
code{font-size:1.8rem;letter-spacing:.15em}img{display:block;width:100%;height:12rem;margin-bottom:.5rem;object-fit:contain;background:#fff}\n\
@media print{body{margin:0;color:#000;background:#fff}}\n</style>\n";

/// Escapes text for HTML.
fn escaped(text: &str) -> String {
    // Control characters first, then the characters that HTML reserves.
    let text = magician_protocol::visible(text).to_string();
    let text = text
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;");
    text.replace('"', "&quot;")
}

fn text_of<'v>(value: &'v Value, name: &str) -> &'v str {
    value[name].as_str().unwrap_or_default()
}

/// Returns a page with the codes of a class, from the answer of `class.get`.
#[must_use]
pub fn codes_page(class: &Value) -> String {
    let mut page = format!(
        "{HTML_HEAD}<title>Codes</title></head><body>\n<h1>Codes of the class</h1>\n<ul>\n"
    );
    for pupil in class["pupils"].as_array().into_iter().flatten() {
        let group = pupil["group"]
            .as_str()
            .map(|group| format!(" <small>{}</small>", escaped(group)));
        let _ = writeln!(
            page,
            "<li>{}{}<br><code>{}</code></li>",
            escaped(text_of(pupil, "name")),
            group.unwrap_or_default(),
            escaped(text_of(pupil, "code"))
        );
    }
    page.push_str("</ul>\n</body></html>\n");
    page
}

/// Returns a self-contained page with the results of a class, from the answer of `class.results`.
#[must_use]
pub fn results_page(results: &Value) -> String {
    let mut page = format!(
        "{HTML_HEAD}<title>Results</title></head><body>\n<h1>What the class has made</h1>\n"
    );
    let items = results["results"].as_array().map_or(&[][..], Vec::as_slice);
    if items.is_empty() {
        page.push_str("<p>Nothing yet: a job of a pupil that is done comes here.</p>\n");
    }
    let mut names: Vec<_> = items.iter().map(|item| text_of(item, "pupil")).collect();
    names.sort_unstable();
    // One heading per pupil.
    names.dedup();
    for name in names {
        let _ = writeln!(page, "<h2>{}</h2>\n<ul>", escaped(name));
        for item in items.iter().filter(|item| text_of(item, "pupil") == name) {
            let drawn = item["drawn_mm"]
                .as_f64()
                .map(|mm| format!(" · {mm:.0} mm drawn"));
            let _ = writeln!(
                page,
                "<li>{}<strong>{}</strong><br><small>{} · {}{}</small></li>",
                image(text_of(item, "svg")),
                escaped(text_of(item, "title")),
                escaped(text_of(item, "time_local")),
                escaped(text_of(item, "arm")),
                drawn.unwrap_or_default()
            );
        }
        page.push_str("</ul>\n");
    }
    page.push_str("</body></html>\n");
    page
}

/// Returns the strokes of a result as an SVG document of the drawing's size in mm, as seen by the
/// reader in front of the arm: y to the right, and the arm, where x is smallest, at the top. Empty
/// without strokes.
pub(crate) fn picture_svg(strokes: &Value) -> String {
    let strokes = strokes.as_array().map_or(&[][..], Vec::as_slice);
    let points = |stroke: &Value| -> Vec<[f64; 2]> {
        let points = stroke.as_array().into_iter().flatten();
        let pair = |point: &Value| Some([point[0].as_f64()?, point[1].as_f64()?]);
        points.filter_map(pair).collect()
    };
    let strokes: Vec<_> = strokes.iter().map(points).collect();
    let mut all = strokes.iter().flatten();
    let Some(first) = all.next() else {
        return String::new();
    };
    let (mut least, mut most) = (*first, *first);
    for point in all {
        for axis in 0..2 {
            least[axis] = least[axis].min(point[axis]);
            most[axis] = most[axis].max(point[axis]);
        }
    }
    // At least 1 mm: a single point has no extent.
    let [width, height] = [1, 0].map(|axis| (most[axis] - least[axis]).max(1.0) + 2.0 * MARGIN);
    let mut path = String::new();
    for stroke in &strokes {
        for (at, point) in stroke.iter().enumerate() {
            let sign = if at == 0 { 'M' } else { 'L' };
            // The arm's y runs to the reader's right, and its x away from the arm, that is down the
            // page.
            let (x, y) = (point[1] - least[1], point[0] - least[0]);
            let _ = write!(path, "{sign}{:.1} {:.1}", x + MARGIN, y + MARGIN);
        }
    }
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.1}mm\" height=\"{height:.1}mm\" viewBox=\"0 0 {width:.1} \
         {height:.1}\"><path d=\"{path}\" fill=\"none\" stroke=\"#222\" stroke-width=\".6\" stroke-linecap=\"round\" \
         stroke-linejoin=\"round\"/></svg>"
    )
}

/// Returns an SVG picture as an `img` element. As an image it cannot run scripts, whatever it
/// contains.
fn image(svg: &str) -> String {
    if svg.is_empty() {
        return String::new();
    }
    let mut data = String::with_capacity(svg.len() * 5 / 4);
    for sign in svg.chars() {
        match sign {
            '"' => data.push('\''),
            '<' | '>' | '#' | '%' | '&' | '\'' => {
                let _ = write!(data, "%{:02X}", u32::from(sign));
            }
            _ => data.push(sign),
        }
    }
    format!("<img alt=\"\" src=\"data:image/svg+xml,{data}\">")
}

/// Returns the strokes of a preview as stored in a result, `[[[x, y]]]`, thinned out.
pub(crate) fn picture(preview: &Value) -> Value {
    let strokes = preview["strokes"].as_array().map_or(&[][..], Vec::as_slice);
    let points = |stroke: &Value| stroke["points"].as_array().cloned().unwrap_or_default();
    let strokes: Vec<_> = strokes.iter().map(points).collect();
    let all: usize = strokes.iter().map(Vec::len).sum();
    let every = all.div_ceil(MAX_POINTS).max(1);
    let thinned = strokes.into_iter().map(|points| {
        let last = points.len().saturating_sub(1);
        // The last point stays, so that closed lines stay closed.
        let kept = |(at, point): (usize, Value)| (at % every == 0 || at == last).then_some(point);
        Value::Array(points.into_iter().enumerate().filter_map(kept).collect())
    });
    // Bounded as well: a drawing of dots has many strokes of one point.
    Value::Array(thinned.take(MAX_POINTS).collect())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn names_and_titles_are_escaped_on_the_page() {
        let evil = "<script>alert(1)</script>\"&";
        let results = json!({"results": [{"pupil": evil, "title": evil, "time_local": evil, "arm": "arm",
            "drawn_mm": 12.4, "svg": format!("<svg>{evil}</svg>")}]});
        let page = results_page(&results);
        assert!(!page.contains("<script"), "{page}");
        assert!(!page.contains("</svg>"), "{page}");
        assert!(page.contains("12 mm drawn"), "{page}");
        let codes = codes_page(&json!({"pupils": [{"name": evil, "group": evil, "code": "7K3M"}]}));
        assert!(!codes.contains("<script") && codes.contains("7K3M"));
    }

    #[test]
    fn picture_is_upright_for_a_reader_facing_the_arm() {
        let svg = picture_svg(&json!([[[200, 0], [220, 10]], [[200, 10], [210, 10]]]));
        assert!(
            svg.contains("M2.0 2.0L12.0 22.0M12.0 2.0L12.0 12.0"),
            "{svg}"
        );
        assert!(svg.contains("viewBox=\"0 0 14.0 24.0\""), "{svg}");
        assert_eq!(picture_svg(&json!([])), "");
    }

    #[test]
    fn thinned_picture_keeps_stroke_ends() {
        let points: Vec<_> = (0..10_000).map(|at| json!([at, 0])).collect();
        let strokes = picture(&json!({"strokes": [{"points": points}]}));
        let stroke = strokes[0].as_array().unwrap();
        assert!(stroke.len() <= MAX_POINTS + 1);
        assert_eq!(
            (&stroke[0], stroke.last()),
            (&json!([0, 0]), Some(&json!([9999, 0])))
        );
    }
}
