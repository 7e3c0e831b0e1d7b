//! Texts longer than their bound: refused with line, number and limit, never cut off.

use magician_formats::{Diagnostic, Format, ReadOptions, read};

fn refused(format: Format, text: &str) -> Diagnostic {
    read(format, text.as_bytes(), &ReadOptions::default()).unwrap_err()
}

#[test]
fn text_beyond_its_bound_is_refused_with_line_number_and_limit() {
    let svg = |text: &str| {
        format!(
            "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'>\n<path d='M1 1H5' stroke='red'/>\n{text}</svg>"
        )
    };
    let long = "a".repeat(50_001);
    let parts = format!(
        "<text id='label'>{}</text>",
        format!("<tspan>{}</tspan>", "b".repeat(25_000)).repeat(3)
    );
    let label = format!("IN;SP1;PA0,0;\nLB{}\u{3};", "a".repeat(12_000));
    let dxf = |kind: &str| {
        format!(
            "0\nSECTION\n2\nENTITIES\n0\n{kind}\n10\n0\n20\n0\n40\n5\n1\n{}\n0\nENDSEC\n0\nEOF\n",
            "a".repeat(120_000)
        )
    };
    for (format, text, line, count, limit) in [
        (
            Format::Svg,
            svg(&format!("<text>{long}</text>")),
            3,
            "50001",
            "50000",
        ),
        (
            Format::Svg,
            svg(&format!(
                "<text>{}</text>\n<text>{}</text>",
                &long[..30_000],
                &long[..30_000]
            )),
            4,
            "60000",
            "50000",
        ),
        (Format::Svg, svg(&parts), 3, "75000", "50000"),
        (Format::Hpgl, label, 2, "12000", "10000"),
        (Format::Dxf, dxf("TEXT"), 5, "120000", "100000"),
        (Format::Dxf, dxf("MTEXT"), 5, "120000", "100000"),
        (Format::Text, "a".repeat(100_001), 0, "100001", "100000"),
    ] {
        let refused = refused(format, &text);
        let message = &refused.message;
        assert!(
            message.contains(count) && message.contains(&format!("limit {limit}")),
            "{format}: {message}"
        );
        assert!(
            line == 0 || (refused.origin.line as i32 - line).abs() <= 1,
            "{format}: {refused}"
        );
    }
}

#[test]
fn repeatedly_used_text_is_bounded() {
    let uses = "<use href='#t'/>".repeat(2_000);
    let text = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='9mm' height='9mm'><text id='t'>{}</text>{uses}</svg>",
        "a".repeat(10_000)
    );
    let refused = refused(Format::Svg, &text);
    assert!(refused.message.contains("limit"), "{refused}");
}
