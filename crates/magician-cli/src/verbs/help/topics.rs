//! Topics of `help`: subjects that concern several verbs.

/// Topic of `help`.
pub(super) struct Topic {
    pub(super) name: &'static str,
    /// Short description for the list.
    pub(super) about: &'static str,
    pub(super) text: &'static str,
}

pub(super) const TOPICS: [Topic; 5] = [
    Topic {
        name: "units",
        about: "units, axes and number formats",
        text: UNITS,
    },
    Topic {
        name: "pen",
        about: "draw with a pen, step by step",
        text: PEN,
    },
    Topic {
        name: "laser",
        about: "laser safety, permission, power and switching off",
        text: LASER,
    },
    Topic {
        name: "resume",
        about: "resume a run that was interrupted",
        text: RESUME,
    },
    Topic {
        name: "exit-status",
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
