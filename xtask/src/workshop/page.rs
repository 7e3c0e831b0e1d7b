//! Page of the gallery.

use std::fmt::Write as _;

use super::PICTURES;
use super::pieces::Piece;
use super::run::PieceResult;

pub(super) const INTRODUCTION: &str = "\
# The workshop

Pieces made with pen and laser, each by the two commands above its pictures. The first looks and moves nothing; the second makes the piece, here on
a virtual arm, which replies byte for byte and moves like the real one. For your arm leave out `--port sim` and `--picture`, and give the
[height of the paper](../recipes/draw.md#draw). **A laser blinds and starts fires**: read [Engrave with the laser](../recipes/engrave.md) first.

On the left is the file, in the middle the preview, on the right what pen or laser left. The figures below say how well they match. Preview and
result are compared as lines, and the position of the result with the estimate's; dots, where the pen only touches the paper, are markers in a preview. Some files are compared with the result too, read by code that
shares nothing with our readers except the SVG parser. File and result match where they are within 0.1 mm of each other, preview and result within
0.2 mm: a preview leaves out corners of curves.

`cargo xtask workshop` makes all of it again. The files were made for this project, most of them by [make.py](workshop/files/make.py), the photo by
[landscape.py](../recipes/landscape.py); they are in `docs/evidence/workshop/files` and `crates/magician-program/samples`. The font is Roboto (Apache License 2.0).
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
