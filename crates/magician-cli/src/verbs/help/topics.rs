//! Topics of `help`: subjects that concern several verbs.

/// Topic of `help`.
pub(super) struct Topic {
    pub(super) name: &'static str,
    pub(super) aliases: &'static [&'static str],
    /// Short description for the list.
    pub(super) about: &'static str,
    pub(super) text: &'static str,
}

impl Topic {
    /// True for the name of the topic, or another word that people look it up by.
    pub(super) fn is(&self, word: &str) -> bool {
        self.name == word || self.aliases.contains(&word)
    }
}

pub(super) const TOPICS: [Topic; 10] = [
    Topic {
        name: "units",
        aliases: &["axes", "coordinates"],
        about: "units, axes and number formats",
        text: UNITS,
    },
    Topic {
        name: "pen",
        aliases: &["drawing", "paper", "surface"],
        about: "draw with a pen, step by step",
        text: PEN,
    },
    Topic {
        name: "text",
        aliases: &["font", "fonts", "letters"],
        about: "write text, fonts, text in drawings",
        text: TEXT,
    },
    Topic {
        name: "fill",
        aliases: &["hatch", "shading"],
        about: "fill shapes with lines",
        text: FILL,
    },
    Topic {
        name: "pens",
        aliases: &["parts", "layers", "colors", "colours"],
        about: "layers, colours, and changes of pens",
        text: PENS,
    },
    Topic {
        name: "gcode",
        aliases: &["g-code", "cnc", "lightburn"],
        about: "run G-code, unchanged or placed",
        text: GCODE,
    },
    Topic {
        name: "laser",
        aliases: &["burn", "burning", "engraving"],
        about: "laser safety, permission, power and switching off",
        text: LASER,
    },
    Topic {
        name: "resume",
        aliases: &["interrupted", "continue"],
        about: "resume a run that was interrupted",
        text: RESUME,
    },
    Topic {
        name: "class",
        aliases: &["teacher", "pupils", "lesson", "turns"],
        about: "several arms and pupils at one computer",
        text: CLASS,
    },
    Topic {
        name: "exit-status",
        aliases: &["exit", "errors"],
        about: "exit statuses and error kinds",
        text: EXIT_STATUS,
    },
];

const UNITS: &str = "\
Units of all verbs, of files of this program and of JSON:
    lengths mm, angles degrees, times seconds, speeds mm/s and deg/s,
    power and fractions in percent

Axes of the arm:
    x  ahead            the base axis is at x = 0, y = 0
    y  to the arm's left
    z  up               0 is the height of joint 2
    r  rotation of the tool, counter-clockwise seen from above
    J1 base, J2 rear arm and J3 forearm (J3 from the horizontal), J4 tool
x, y and z are those of the tip of the tool that is set on the arm.
`magician pose` shows them; `--tool` and `magician calibrate tool` set the tool.

Files:
    G-code: mm, or inches after G20; F in mm or inches per minute
    SVG: the size in the file; without a size one unit is 1/96 inch
    DXF: the unit in the file, or mm; HPGL: 40 units per mm

Commands of the protocol (`get`, `set`, `enqueue`) have their own units:
`magician help PTPJointParams` shows the unit of each field.

Negative numbers are written as usual: magician move 220 -40 30";

const PEN: &str = "\
Draw with a pen:
    1. Mount the pen, switch the arm on, and home it: magician home
    2. Measure the height of the paper: magician calibrate surface --tool pen
       (or give it each time as --surface Z: the z that `magician pose` shows
       when the tip touches the paper)
    3. Preview the drawing: magician draw FILE --preview where.svg
       and check that the arm can draw all of it: magician draw FILE --check
    4. Draw: magician draw FILE

Position and size: --at X,Y, --page a4, --fit, --scale, --rotate, --mirror.
Content: --clip-page clips at the page, --white draw also draws white lines.
Motion: --speed MM/S, --lift MM between lines, --no-order.

The first Ctrl-C stops the arm and lifts the pen (--stay leaves it down). A
second one, at least half a second later, stops the arm without lifting. A
closed terminal counts as the first. To resume, see `magician help resume`.
--park X,Y,Z parks the pen at that position at the end.

Without an arm: magician draw FILE --port sim --picture drawn.svg";

const TEXT: &str = "\
Write text: magician write 'Hello' --size 15
A file of text: magician draw notice.txt; `-` reads stdin.

    --font NAME|FILE   a built-in font (`magician write --fonts` lists them), or
                       a TrueType, OpenType or SVG font. Built-in fonts draw
                       single strokes; font files are drawn as outlines
    --size MM          height of capital letters
    --wrap MM          width at which lines break
    --align WORD       left, center or right
    --line-height N    line spacing, times the height of capitals

Text in an SVG or DXF is drawn as outlines; --text stroke draws single strokes.
A missing character is left out, with a note; --strict-text refuses it.";

const FILL: &str = "\
Shapes are outlined. --fill draws lines inside them too:
    --fill hatch       parallel lines
    --fill cross       two crossed sets of lines
    --fill contour     rings from the edge inwards

    --fill-spacing MM  spacing of the lines (pen 0.8, laser 0.2)
    --fill-angle DEG   angle of the lines from x (45)
    --fill-inset MM    distance to the edge (half of the spacing)

White shapes on an empty background are skipped; --white draw fills them too.
`magician help pens` shows how to fill one colour only.
Preview: magician draw FILE --fill hatch --preview where.svg";

const PENS: &str = "\
A drawing with layers or colours can be drawn part by part:
    magician draw FILE --parts color --list-parts    lists the parts
    magician draw FILE --parts color                 pauses between parts

Change the pen at a pause, and press `p`. --no-pause draws on without one.

    --parts layer|color   split by layer (pens of a plot, tools of G-code), or
                          by colour
    --only NAME           only this part: name, colour or number; repeatable
    --passes N            draw each part N times
    --pens FILE           settings of each pen, in TOML:
                              [[pen]]
                              match = \"#ff0000\"
                              speed = 30
                              fill = \"hatch\"

`magician preset` saves the flags of a pen or a material under a name.";

const GCODE: &str = "\
Run G-code:
    magician run FILE --check             check that the arm can do all of it
    magician run FILE                     coordinates are the arm's own, in mm
    magician run FILE --place             centred where the arm has room
    magician draw FILE --surface Z        placed, drawn with the pen at height Z
    magician engrave FILE                 placed, burnt with the laser

Most files have their zero at a corner of a machine's table: place them.
    --at X,Y            centre of the drawn lines
    --fit               shrink it to fit
    --pen-z Z           Z of the file at which the pen touches
    --depths keep       go down to the depths of the file

    --dialect pen|laser|servo   machine that the file is for
    --s-max N                   S of full laser power
Units are those of the file: mm, or inches after G20.";

const LASER: &str = "\
The laser blinds at any distance, also by reflection, and starts fires. Everyone
in the room wears goggles for its wavelength (405 nm). Remove shiny objects,
ventilate the room, and never leave the laser alone.

On a real arm nothing burns without --yes, or `y` at the terminal: no file, no
`laser on`, and no `set`, `enqueue` or `io` that lights the laser. Every arm
except `--port sim` counts as real.

Power: --power P sets full power to P percent; --power 10..60 maps the weakest
to 10 and the strongest to 60 percent. For G-code, --s-max N is the S value of
full power. --check and --estimate show the power: burns with 12 to 60 %.

However a run ends, the laser is switched off: at its end, on a stop, on Ctrl-C,
on an error, when the terminal is closed. After kill -9, or while the cable is
unplugged, nothing can be sent: the arm then burns for at most one second, plus
the current segment. Keep a hand at its power switch.

`magician info` shows `laser  ON` while it is on; `magician laser off` needs
no confirmation.";

const RESUME: &str = "\
Resume a run that was interrupted (Ctrl-C, an alarm, a pulled cable):
    repeat the command with --resume

The file, the flags and the arm must be the same; otherwise it is refused.

    After Ctrl-C or an error   continues the interrupted step
    After a pulled cable       plug it in and touch nothing: the progress is
                               read from the arm
    After a power failure      home the arm first; it is no longer certain
                               which steps are done (exit status 9)

--from STEP starts at any step, counted from 1; --dry-run -v lists the steps.
A straight line continues within 0.2 mm of where it stopped; an arc or other
curve is repeated as a whole.";

const CLASS: &str = "\
One computer with several arms, and pupils at its page:
    magician serve --listen 0.0.0.0:8910 --arm a1=/dev/ttyUSB0 --arm a2=/dev/ttyUSB1
Open http://127.0.0.1:8910/ and go to *Class*: paste the names, choose arms and
the length of a turn, print the slips. Pupils sign in with name and code, take
turns, and draw; *Freeze all* stops every arm.

`magician station class` shows and changes the class from the command line.
With virtual arms: --scenario drawing --arm a1=sim --arm a2=sim";

const EXIT_STATUS: &str = "\
Exit status, and kind of the error object that --json writes to stderr:
    0  done
    1  bug            an internal error
    2  usage          invalid command line, or --yes is missing
    3  invalid-input  invalid value
       unreachable    position out of reach
    4  port           the port is missing, not permitted, in use, or disconnected
       closed         the connection was closed, or a stop came first
    5  timeout        no reply by the deadline
    6  unexpected     invalid reply from the peer
       unsupported    not supported by this build or this arm
    7  queue-full     the arm's queue has no room
    8  alarm          an alarm holds the arm's queue
    9  uncertain      the arm may or may not have received the command: look at it
   10  check-failed   a check failed
  130  interrupted    Ctrl-C

The error object has kind and message and, where they apply: code (more
specific than the kind: stopped, not-homed, foreign-commands), command,
step, value, limit, unit, fence, from and to (queue indices in doubt), and
remedies. Each remedy has its effect and is an action (home, clear-alarms),
an option with its value, an option to omit (without), or a command of the
system. Programs should evaluate kind and code, never the message.";
