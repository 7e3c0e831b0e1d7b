//! Strategies for arbitrary commands, actions and plans.

use magician_formats::{Action, Grip, Origin, Plan, Step, Surface, Tool, Travel};
use magician_protocol::{Row, Set, TABLE};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::test_runner::RngSeed;

/// Configures a test to run `count` cases of a fixed seed; `PROPTEST_CASES` sets another number of
/// random ones.
pub(crate) fn cases(count: u32) -> ProptestConfig {
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    match std::env::var_os("PROPTEST_CASES") {
        Some(_) => config,
        None => ProptestConfig {
            cases: count,
            rng_seed: RngSeed::Fixed(0xD0B07),
            ..config
        },
    }
}

/// Returns a strategy for 32 bits as a number, two shorts or four flags, with special values among
/// them.
fn word() -> impl Strategy<Value = u32> {
    prop_oneof![
        3 => any::<u32>(),
        1 => Just(0),
        1 => Just((-0.0f32).to_bits()),
        1 => Just(f32::NAN.to_bits()),
        1 => Just(1),
        2 => (-400.0f32..400.0).prop_map(f32::to_bits),
        1 => any::<[bool; 4]>().prop_map(|flags| u32::from_le_bytes(flags.map(u8::from))),
    ]
}

fn of_row(row: &'static Row) -> impl Strategy<Value = Set> {
    let layout = row.set.expect("it can be set");
    let sizes: Vec<usize> = match layout.size() {
        Some(size) => vec![size, layout.min_size()],
        None => [0, 4, 12, 57 * 4]
            .map(|rest| (layout.min_size() + rest).min(245))
            .to_vec(),
    };
    let bytes = prop::collection::vec(word(), 62).prop_map(|words| {
        words
            .into_iter()
            .flat_map(u32::to_le_bytes)
            .collect::<Vec<u8>>()
    });
    (select(sizes), bytes).prop_filter_map("a form that is not taken", move |(size, bytes)| {
        Set::decode(row.id, &bytes[..size]).ok()
    })
}

/// Returns a strategy for any set command.
pub(crate) fn any_set() -> impl Strategy<Value = Set> {
    select(
        TABLE
            .iter()
            .filter(|row| row.set.is_some())
            .collect::<Vec<_>>(),
    )
    .prop_flat_map(of_row)
}

/// Returns a strategy for any set command that can be queued.
pub(crate) fn queued_set() -> impl Strategy<Value = Set> {
    let rows = TABLE
        .iter()
        .filter(|row| row.set.is_some() && row.queueable);
    select(rows.collect::<Vec<_>>()).prop_flat_map(of_row)
}

/// Returns a strategy for any number but NaN.
pub(crate) fn number() -> impl Strategy<Value = f32> {
    word()
        .prop_map(f32::from_bits)
        .prop_filter("NaN", |number| !number.is_nan())
}

fn travel() -> impl Strategy<Value = Travel> {
    select(vec![Travel::Joints, Travel::Line, Travel::Jump])
}

/// Returns a strategy for any action; unnamed commands are in canonical form.
pub(crate) fn action() -> impl Strategy<Value = Action> {
    let four = || prop::array::uniform4(number());
    let three = || prop::array::uniform3(number());
    prop_oneof![
        (four(), travel()).prop_map(|(to, by)| Action::Move { to, by }),
        (four(), travel()).prop_map(|(to, by)| Action::Joints { to, by }),
        (four(), any::<bool>()).prop_map(|(by, line)| Action::Shift { by, line }),
        (four(), four()).prop_map(|(via, to)| Action::Arc { via, to }),
        three().prop_map(|to| Action::Path { to }),
        (three(), number()).prop_map(|(to, power)| Action::Burn { to, power }),
        any::<bool>().prop_map(Action::Suction),
        select(vec![Grip::Off, Grip::Open, Grip::Close]).prop_map(Action::Gripper),
        any::<bool>().prop_map(Action::Laser),
        any::<u32>().prop_map(Action::Wait),
        Just(Action::Home),
        queued_set().prop_map(Action::from),
    ]
}

fn origin() -> impl Strategy<Value = Origin> {
    let place = prop_oneof![
        Just([0; 3]),
        any::<[u32; 3]>(),
        prop::array::uniform3(0u32..100),
    ];
    (place, 0u32..5).prop_map(|([line, column, length], name)| Origin {
        line,
        column,
        length,
        name,
    })
}

fn tool() -> impl Strategy<Value = Option<Tool>> {
    prop_oneof![
        Just(None),
        select(Tool::NAMED_TOOLS.to_vec()).prop_map(|(_, tool)| Some(tool)),
        prop::array::uniform3(number()).prop_map(|bias| Some(Tool::Bias(bias))),
    ]
}

fn surface() -> impl Strategy<Value = Option<Surface>> {
    let number = || any::<f64>().prop_filter("NaN", |number| !number.is_nan());
    prop::option::of(
        (number(), number(), number()).prop_map(|(height, x, y)| Surface {
            height,
            slope: [x, y],
        }),
    )
}

/// Returns a strategy for any plan, whose names are in any order, repeated or unused.
pub(crate) fn plan() -> impl Strategy<Value = Plan> {
    let names = prop::collection::vec("[ab\"\\\\\u{e9}\n]{0,2}", 0..4);
    let steps = prop::collection::vec((action(), origin()), 0..12);
    (any::<String>(), tool(), surface(), steps, names).prop_map(
        |(title, tool, surface, steps, names)| Plan {
            title,
            tool,
            surface,
            steps: steps
                .into_iter()
                .map(|(action, origin)| Step::new(action, origin))
                .collect(),
            names,
            ..Plan::default()
        },
    )
}
