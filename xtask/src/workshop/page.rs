//! Page of the gallery.

use std::fmt::Write as _;

use super::PICTURES;
use super::pieces::Piece;
use super::run::PieceResult;

pub(super) const INTRODUCTION: &str = "\
# The workshop

Pieces made with pen and laser, each by the two commands above its pictures. The first moves
nothing; the second makes the piece, here on a virtual arm. For your arm leave out `--port sim` and
`--picture`, and give the [height of the paper](../recipes/draw.md#draw). **A laser blinds and
starts fires**: read [Engrave with the laser](../recipes/engrave.md) first.

Left: the file; middle: the preview; right: the result. The figures below compare preview and result
as lines, and the end position with the estimate's; dots, where the pen only touches the paper, are
markers in a preview. Some files are compared with the result too, read by code that shares only the
SVG parser with our readers. A match of file and result is within 0.1 mm, of preview and result
within 0.2 mm, because a preview leaves out corners of curves.

`cargo xtask workshop` makes all of it again. The files, made for this project, most by
[make.py](workshop/files/make.py), the photo by [landscape.py](../recipes/landscape.py), are in
`docs/evidence/workshop/files` and `crates/magician-program/samples`. The font is Roboto (Apache
License 2.0).
";

/// Returns the part of an entry that does not depend on the run.
pub(super) fn head(piece: &Piece) -> String {
    format!(
        "\n## {}\n\n{}\n\n```sh\n{}\n{}\n```\n",
        piece.title,
        piece.description,
        piece.preview_command(),
        piece.make_command()
    )
}

pub(super) fn entry(piece: &Piece, made: &PieceResult) -> String {
    let mut entry = head(piece);
    // Writing to a `String` cannot fail.
    let _ = write!(entry, "\n```text\n{}```\n\n", made.output);
    let _ = writeln!(entry, "{}", table(piece, made));
    let _ = writeln!(entry, "{}", made.figures);
    entry
}

fn table(piece: &Piece, made: &PieceResult) -> String {
    let width = if made.shown.len() > 2 { 270 } else { 400 };
    let heads: Vec<&str> = made.shown.iter().map(|(head, _)| *head).collect();
    let cells = made.shown.iter().map(|(head, name)| {
        let (title, head) = (piece.title, head.trim_matches('`'));
        format!("<img src=\"{PICTURES}/{name}\" width=\"{width}\" alt=\"{title}: {head}\">")
    });
    let cells: Vec<String> = cells.collect();
    format!(
        "| {} |\n|{}\n| {} |\n",
        heads.join(" | "),
        "---|".repeat(heads.len()),
        cells.join(" | ")
    )
}
