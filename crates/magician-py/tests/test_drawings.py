"""Text that is written, shapes that are filled, lines that are tidied."""

from __future__ import annotations

import inspect
import io
import re
from pathlib import Path
from typing import Any

import magician
import pytest
from conftest import in_notebook
from magician import Plan
from magician.errors import InvalidInputError
from magician.programs import SetupOptions

ROOT = Path(__file__).parents[3]


def test_text_is_written_and_previewed(tmp_path: Path) -> None:
    plan = magician.write("Anna\nund Bert", font="script", size=8, surface=-60)
    assert (plan.title, plan.tool, plan.format) == ("Anna", "pen", "text")
    assert plan.check().ok and {note.code for note in plan.notes} == {"reordered"}
    picture = plan.preview(tmp_path / "words.svg")
    assert (tmp_path / "words.svg").read_text(encoding="utf-8") == picture.svg == in_notebook(plan)
    with magician.Arm("sim:20") as arm:
        assert arm.run(plan).steps == len(plan)
    longer = magician.write("Anna\nund Bert", font="script", size=16, surface=-60)
    assert _drawn(longer) == pytest.approx(2 * _drawn(plan), rel=0.03)


def test_options_of_text_have_the_meaning_of_the_command() -> None:
    words = "one two three"
    assert _width(magician.write(words, wrap=30)) <= 30 < _width(magician.write(words))
    height = [_height(magician.write("a\na", line_height=line)) for line in (1.8, 3)]
    assert height[1] - height[0] == pytest.approx(1.2 * 10, abs=0.1)
    assert magician.write("a\na", line_height=1.8) == magician.write("a\na")
    left, right = (magician.write("wide line\ni", align=align) for align in ("left", "right"))
    assert left != right
    assert magician.write(words, font="gothic") != magician.write(words)
    loaded = magician.load(io.BytesIO(words.encode()), format="text", title=words, size=12)
    assert loaded == magician.write(words, size=12)


def test_texts_of_a_drawing_are_outlined_or_single_lines() -> None:
    text = '<text x="5" y="60" font-size="40">Lo</text>'
    assert _svg(text) == _svg(text, text="outline")
    assert _drawn(_svg(text, text="stroke")) < 0.7 * _drawn(_svg(text))


def test_missing_glyphs_are_noted_or_refused() -> None:
    assert any("U+4E2D" in str(note) for note in magician.write("中 and ink").notes)
    with pytest.raises(InvalidInputError, match=r"U\+4E2D"):
        magician.write("中 and ink", strict_text=True)


def test_a_font_may_be_a_file(tmp_path: Path) -> None:
    font = tmp_path / "bars.svg"
    font.write_text(
        '<svg><font horiz-adv-x="500"><font-face units-per-em="1000" cap-height="700"/>'
        '<glyph unicode="i" d="M100 0V700"/></font></svg>',
        encoding="utf-8",
    )
    assert _drawn(magician.write("i", font=font, size=10)) == pytest.approx(10, abs=0.1)
    with pytest.raises(FileNotFoundError, match=r"font takes sans, script, gothic or the path of a file: .*'serif'"):
        magician.write("i", font="serif")
    font.write_bytes(b"no font")
    with pytest.raises(InvalidInputError, match=r"bars\.svg"):
        magician.write("i", font=font)
    with pytest.raises(InvalidInputError, match="font is sans, script or gothic, not 3"):
        magician.write("i", font=3)  # type: ignore[arg-type]


def test_a_filled_logo_is_longer_than_its_outline(samples: Path) -> None:
    logo = samples / "logo.svg"
    outline = _drawn(_logo(samples))
    hatched = _drawn(_logo(samples, fill="hatch"))
    assert hatched > 4 * outline
    assert _drawn(_logo(samples, fill="cross")) > 1.8 * hatched
    assert _drawn(_logo(samples, fill="contour")) > 4 * outline
    assert _drawn(_logo(samples, fill="hatch", fill_spacing=1.6)) == pytest.approx(hatched / 2, rel=0.15)
    assert _drawn(_logo(samples, fill="hatch", fill_inset=2)) < 0.8 * hatched
    assert _logo(samples, fill="hatch", fill_angle=0) != _logo(samples, fill="hatch")
    assert _logo(samples, fill="hatch", fill_angle=45) == _logo(samples, fill="hatch")
    assert _logo(samples, fill="none") == magician.load(logo, surface=-60, fit=True)
    assert _logo(samples, fill="hatch", fill_spacing=2).rehearse().ok


def test_the_laser_fills_with_finer_lines(samples: Path) -> None:
    pen = _drawn(_logo(samples, fill="hatch"))
    burnt = _logo(samples, fill="hatch", work="engrave", power=20)
    assert burnt.tool == "laser" and burnt.check().power == (20, 20)
    assert _drawn(burnt) == pytest.approx(4 * pen, rel=0.15)


def test_lines_are_tidied_as_far_as_asked() -> None:
    line = '<path d="M10 10H40" stroke="black"/><path d="M40.05 10H70" stroke="black"/>'
    merged, apart = _svg(line), _svg(line, merge=0)
    assert apart.check().counts["path"] > merged.check().counts["path"]
    twice = '<path d="M10 10H40" stroke="black"/>' * 2
    assert _drawn(_svg(twice, dedupe=False)) == pytest.approx(2 * _drawn(_svg(twice)))
    lines = b"G21\nG90\nG0 Z5\n" + b"G0 X200 Y0\nG1 Z0 F900\nG1 X220 Y0\nG0 Z5\n" * 2
    gcode: dict[str, Any] = {"format": "gcode", "at": (220, 0), "surface": -60}
    drawn = [_drawn(magician.load(io.BytesIO(lines), **gcode, dedupe=dedupe)) for dedupe in (None, True)]
    assert drawn[0] == pytest.approx(2 * drawn[1])
    zigzag = "".join(f"L{10 + nth} {10 + nth % 2 / 2}" for nth in range(30))
    bent = f'<path d="M10 10{zigzag}" stroke="black" fill="none"/>'
    assert len(_svg(bent, simplify=1)) < len(_svg(bent))


@pytest.mark.parametrize("image", ["outline", "centerline", "halftone", "squiggle", "hatch"])
def test_an_image_is_drawn_with_the_pen_as_asked(samples: Path, image: Any) -> None:
    plan = magician.load(samples / "landscape.png", image=image, width=60, crop=(40, 60, 240, 180), contrast=20)
    assert plan.tool == "pen" and plan.check().ok
    report = plan.check()
    assert report.drawn > 100


@pytest.mark.parametrize(
    ("crop", "said"),
    [
        ((0, 0, 400, 10), "crop 0,0,400,10 is not within the image of 360 by 270 pixels"),
        ((0, 0, 10), "crop is four whole numbers of pixels"),
        ((0, 0, 0, 10), "W and H, the last two above 0"),
    ],
)
def test_a_crop_beyond_the_image_is_refused(samples: Path, crop: Any, said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        magician.load(samples / "landscape.png", crop=crop)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("fill", "solid", 'fill is none, hatch, cross or contour, not "solid"'),
        ("fill_spacing", 0.01, "fill_spacing is a number from 0.02 to 10000 mm, not 0.01"),
        ("fill_inset", -1, "fill_inset is a number from 0 to 10000 mm, not -1"),
        ("fill_angle", float("nan"), "fill_angle is a number .*, not nan"),
        ("merge", -1, "merge is a number from 0 to 10000 mm, not -1"),
        ("simplify", -1, "simplify is a number from 0 to 10000 mm, not -1"),
        ("size", 0, "size is a number above 0 and at most 10000 mm, not 0"),
        ("wrap", 0, "wrap is a number above 0 and at most 10000 mm, not 0"),
        ("line_height", 0, "line_height is a number above 0 and at most 1000, not 0"),
        ("align", "middle", "align is .*middle"),
        ("text", "filled", "text is .*filled"),
        ("mode", "shiny", "mode is .*shiny"),
        ("despeckle", -1, "despeckle is a number from 0 to 10000 mm, not -1"),
        ("brightness", 101, "brightness is a number from -100 to 100, not 101"),
        ("contrast", -101, "contrast is a number from -100 to 100, not -101"),
        ("image", "photo", "image is .*photo"),
        ("levels", 65, "levels is a whole number from 1 to 64, not 65"),
    ],
)
def test_invalid_values_name_their_option(samples: Path, name: str, value: Any, said: str) -> None:
    with pytest.raises(InvalidInputError, match=said):
        _logo(samples, **{"fill": "hatch", name: value, "work": "engrave"})
    wrong = 3 if isinstance(value, str) else "wide"
    with pytest.raises(InvalidInputError, match=rf'{name} is .*, not "?{wrong}'):
        _logo(samples, **{name: wrong})


@pytest.mark.parametrize("name", ["fill_spacing", "fill_angle", "fill_inset"])
def test_options_of_a_fill_need_one(samples: Path, name: str) -> None:
    with pytest.raises(InvalidInputError, match=f"{name} needs fill: hatch, cross or contour"):
        _logo(samples, **{name: 1})


def test_options_that_contradict_each_other_are_refused(samples: Path) -> None:
    with pytest.raises(InvalidInputError, match="overscan counts where the laser engraves"):
        magician.load(samples / "engrave_gradient.png", work="draw", overscan=2)
    with pytest.raises(InvalidInputError, match="image counts where the pen draws"):
        magician.load(samples / "engrave_gradient.png", work="engrave", image="hatch")
    with pytest.raises(InvalidInputError, match="levels needs image: halftone or hatch"):
        magician.load(samples / "engrave_gradient.png", image="squiggle", levels=3)


def test_options_of_files_have_the_names_of_a_station() -> None:
    """One option, one name: an argument of :func:`load` is a member of ``setup``, and the other way round."""
    elsewhere = {"grid": "Plan.on_grid", "speed_ratio": "Arm.speed", "stay": "Arm.run", "park": "Arm.run"}
    taken = set(SetupOptions.__annotations__)
    page = (ROOT / "docs" / "reference" / "STATION-API.md").read_text(encoding="utf-8")
    options = page.split("## Options of a program", 1)[1].split("\n## ", 1)[0]
    members = set(re.findall(r"^\| `(\w+)` \|", options, re.MULTILINE))
    assert len(members) > 40
    assert members - set(elsewhere) == taken


def test_write_accepts_the_parameters_of_load() -> None:
    own = inspect.signature(magician.write).parameters
    load = inspect.signature(magician.load).parameters
    for name, parameter in own.items():
        if name in load:
            assert parameter == load[name]
    assert magician.write("i", at=(230, 0), speed=20, surface=-60).check().ok
    with pytest.raises(TypeError, match="colour"):
        magician.write("i", colour="red")  # type: ignore[call-arg]  # pyright: ignore[reportCallIssue]
    with pytest.raises(TypeError, match="words is 3; it takes text"):
        magician.write(3)  # type: ignore[arg-type]
    with pytest.raises(InvalidInputError, match="text"):
        magician.write("")


def _logo(samples: Path, **options: Any) -> Plan:
    return magician.load(samples / "logo.svg", surface=-60, fit=True, **options)


def _svg(shapes: str, **options: Any) -> Plan:
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="90mm" height="90mm" viewBox="0 0 90 90">{shapes}</svg>'
    return magician.load(io.BytesIO(text.encode()), format="svg", surface=-60, **options)


def _drawn(plan: Plan) -> float:
    report = plan.check()
    assert report.ok, report.complaints
    return report.drawn


def _width(plan: Plan) -> float:
    """Text runs along the arm's X."""
    return _span(plan, 0)


def _height(plan: Plan) -> float:
    return _span(plan, 1)


def _span(plan: Plan, axis: int) -> float:
    bounds = plan.check().bounds
    assert bounds is not None
    return bounds[1][axis] - bounds[0][axis]
