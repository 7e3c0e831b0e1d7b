//! Property tests with clients that send anything and arms that may not answer, in any order: the
//! station does not panic, answers each request once, stays within its bounds, and moves an arm for
//! its holder alone.

mod host;
mod strangers;

use magician_station::api::{IdKind, Kind, METHODS, Method};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::{Index, select};
use proptest::test_runner::RngSeed;
use serde_json::{Map, Value, json};

use self::host::Simulation;

/// Values that no parameter accepts.
fn hostile() -> BoxedStrategy<Value> {
    prop_oneof![
        Just(Value::Null),
        any::<bool>().prop_map(Value::from),
        any::<i64>().prop_map(Value::from),
        any::<u64>().prop_map(Value::from),
        select(vec![1e308, -1e308, 1e-308, 4e9, -0.0, 65536.5]).prop_map(Value::from),
        ".{0,8}".prop_map(Value::from),
        select(vec![200, 5000]).prop_map(|count| json!("\u{1F9BE}".repeat(count))),
        (1..120_usize).prop_map(|depth| (0..depth).fold(json!(0), |inner, _| json!([inner]))),
        Just(json!({"name": {"name": {}}, "": [], "\u{0}": -1})),
    ]
    .boxed()
}

/// Value that a parameter of this type accepts.
fn good(name: &'static str, kind: Kind) -> BoxedStrategy<Value> {
    // Ids are small numbers, so that many of them exist.
    let id = |mark: char| (1..60_u32).prop_map(move |number| json!(format!("{mark}0-{number}")));
    match (name, kind) {
        ("client", _) => "[a-z]{1,4}".prop_map(|name| json!({"name": name})).boxed(),
        ("token", _) => select(vec![json!("good"), json!("bad")]).boxed(),
        ("resume", _) => (1..12_u32)
            .prop_map(|at| json!(format!("secret-{at}")))
            .boxed(),
        ("arm", _) => select(vec![json!("arm0"), json!("arm1")]).boxed(),
        (_, Kind::Id(of)) => match of {
            IdKind::Lease => id('l').boxed(),
            IdKind::Jog => id('g').boxed(),
            IdKind::Session => id('s').boxed(),
            IdKind::Job => id('j').boxed(),
            IdKind::Subscription => (1..5_u32).prop_map(Value::from).boxed(),
        },
        ("set", _) => select(vec![
            json!({"floor": -20, "speed": 50}),
            json!({"keep_out": [{"x": [0, 1], "y": [0, 1], "z": [0, 1]}]}),
            json!(null),
        ])
        .boxed(),
        ("command" | "row", _) => {
            let names = [
                "PTPCmd",
                "PTPCommonParams",
                "Pose",
                "ClearAllAlarmsState",
                "nothing",
            ];
            select(names.map(Value::from).to_vec()).boxed()
        }
        ("fields", _) => select(vec![
            json!({}),
            json!({"velocity_ratio": 50, "acceleration_ratio": 50}),
            json!({"mode": 1, "x": 200, "y": 0, "z": 50, "r": 0}),
            json!({"x": 1e300}),
        ])
        .boxed(),
        ("laser", _) => Just(json!({"on": true})).boxed(),
        (_, Kind::Text(_)) => ".{0,20}".prop_map(Value::from).boxed(),
        (_, Kind::Choice(names)) => select(names).prop_map(Value::from).boxed(),
        (_, Kind::Null) => Just(json!(null)).boxed(),
        (_, Kind::Switch) => any::<bool>().prop_map(Value::from).boxed(),
        (_, Kind::Integer(least, most)) => prop_oneof![
            Just(least),
            Just(most),
            (least..=least.saturating_add(50).min(most))
        ]
        .prop_map(Value::from)
        .boxed(),
        (_, Kind::Number(least, most)) => {
            select(vec![least, most, least.max(0.0), 50.0_f64.min(most)])
                .prop_map(Value::from)
                .boxed()
        }
        (_, Kind::Numbers(least, most)) => vec(-400.0..400.0_f64, least..=most)
            .prop_map(Value::from)
            .boxed(),
        ("pupil", _) => Just(json!({"name": "Ada", "code": "7K3M"})).boxed(),
        (_, Kind::Texts(_)) => Just(json!(["arm0"])).boxed(),
        (_, Kind::Object(_)) => Just(json!({})).boxed(),
        (_, Kind::Objects(_)) => Just(json!([{"kind": "input", "address": 1}])).boxed(),
        (_, Kind::Either(kinds)) => {
            let kinds = kinds.to_vec();
            select(kinds)
                .prop_flat_map(move |kind| good("", kind))
                .boxed()
        }
    }
}

/// Parameters of a method, mostly valid.
fn params(method: &'static Method) -> BoxedStrategy<Map<String, Value>> {
    let mut all: BoxedStrategy<Map<String, Value>> = prop_oneof![
        30 => Just(Map::new()),
        1 => hostile().prop_map(|value| Map::from_iter([("else".to_owned(), value)])),
    ]
    .boxed();
    for param in method.params {
        let given = if param.required { 30 } else { 8 };
        // With two arms most methods need the name of one.
        let given = if param.name == "arm" { 30 } else { given };
        let value = prop_oneof![
            given => good(param.name, param.kind).prop_map(Some),
            1 => hostile().prop_map(Some),
            6 => Just(None),
        ];
        all = (all, value)
            .prop_map(|(mut all, value)| {
                if let Some(value) = value {
                    all.insert(param.name.to_owned(), value);
                }
                all
            })
            .boxed();
    }
    all
}

/// Message of one of four clients.
fn message() -> BoxedStrategy<String> {
    let each: Vec<_> = METHODS
        .iter()
        .map(|method| params(method).boxed())
        .collect();
    let known = any::<Index>().prop_flat_map(move |at| {
        let at = at.index(METHODS.len());
        each[at]
            .clone()
            .prop_map(move |params| (METHODS[at].name, params))
    });
    // Methods with effects are called more often than their share of the table.
    let often = select(vec![
        "lease.acquire",
        "lease.ask",
        "arm.move",
        "jog.start",
        "arm.subscribe",
    ]);
    let often = often.prop_flat_map(|name| {
        let method = Method::named(name).expect("it is in the table");
        params(method).prop_map(move |params| (name, params))
    });
    let id = prop_oneof![
        20 => (0..1_000_000_i64).prop_map(|id| Some(json!(id))),
        2 => "[a-z]{0,3}".prop_map(|id| Some(json!(id))),
        1 => hostile().prop_map(Some),
        2 => Just(None),
    ];
    (0..4_u32, prop_oneof![known, often], id)
        .prop_map(|(client, (method, params), id)| {
            let mut message = json!({"jsonrpc": "2.0", "method": method, "params": params});
            if let Some(id) = id {
                message["id"] = id;
            }
            format!("{client}{message}")
        })
        .boxed()
}

/// Line of a script.
fn line() -> BoxedStrategy<String> {
    let hello = (0..4_u32, good("resume", Kind::Text(20))).prop_map(|(client, resume)| {
        let params = json!({"client": {"name": "a"}, "resume": resume});
        let hello = json!({"jsonrpc": "2.0", "id": 7, "method": "session.hello", "params": params});
        format!("{client}{hello}")
    });
    let mark = |marks: &'static [&'static str], most: u32| {
        (select(marks), 0..most).prop_map(|(mark, number)| format!("{mark}{number}"))
    };
    prop_oneof![
        40 => message(),
        4 => hello,
        2 => (0..4_u32, ".{0,30}").prop_map(|(client, text)| format!("{client}{text}")),
        1 => (0..4_u32, (1..400_usize)).prop_map(|(client, depth)| format!("{client}{}", "[".repeat(depth))),
        6 => mark(&["r", "r", "r", "e"], 8),
        6 => mark(&[">"], 4),
        4 => mark(&["?", "l", "L", "L", "j"], 2),
        4 => mark(&["t"], 9_000),
        1 => mark(&["t"], 300),
        2 => mark(&["p", "-"], 4),
        3 => mark(&["+"], 4),
        1 => Just("x".to_owned()),
    ]
    .boxed()
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(1),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn every_request_is_answered_once_in_any_sequence(script in vec(line(), 1..150)) {
        let mut life = Simulation::default();
        // Some clients are connected from the start.
        life.live("+3\n+2\n+2\n+1\n");
        let hello = r#"{"jsonrpc":"2.0","id":"hello","method":"session.hello","params":{"client":{"name":"a"}}}"#;
        for client in 0..4 {
            life.live(&format!("{client}{hello}\n>{client}"));
        }
        life.live(&script.join("\n"));
        life.end();
    }
}

#[test]
fn flood_of_every_method_stays_within_bounds() {
    let mut life = Simulation::default();
    life.live("+3");
    let hello = json!({"jsonrpc": "2.0", "id": 0, "method": "session.hello", "params": {"client": {"name": "a"}}});
    life.live(&format!("0{hello}"));
    for round in 1..400 {
        for method in METHODS {
            let mut params = json!({"arm": "arm0"});
            if method.name == "jog.start" {
                params["axis"] = json!("x+");
            }
            let message =
                json!({"jsonrpc": "2.0", "id": round, "method": method.name, "params": params});
            life.live(&format!("0{message}"));
        }
        life.live("t100");
    }
    life.end();
}
