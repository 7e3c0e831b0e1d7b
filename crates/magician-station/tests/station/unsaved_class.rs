//! Changes of a class before their file is on the disk: they have no effect, and their answers
//! wait.

use serde_json::{Value, json};

use crate::bare::BareStation;

const CLASS: &str = "[[pupil]]\nname = \"Ada\"\n";

/// Returns the new answers.
fn answers(bare: &mut BareStation) -> Vec<Value> {
    let mut heard = bare.received();
    heard.retain(|message| message.get("id").is_some());
    heard
}

#[test]
fn change_takes_effect_and_is_answered_once_saved() {
    let mut bare = BareStation::new();
    bare.send("class.set", &json!({"text": CLASS}));
    bare.send("class.get", &json!({}));
    let before = answers(&mut bare);
    assert_eq!(before.len(), 1, "{before:?}");
    assert_eq!(before[0]["result"]["class"], Value::Null);
    let files = bare.station.poll_files();
    let file = &files["class.toml"];
    assert!(file.text.contains("Ada"), "{}", file.text);
    let written = file.revision;
    // An earlier revision is another version.
    bare.station
        .file_written(bare.now, "class.toml", written - 1, Ok(()));
    bare.station
        .file_written(bare.now, "schedule.toml", written, Ok(()));
    assert_eq!(answers(&mut bare), Vec::<Value>::new());
    bare.station
        .file_written(bare.now, "class.toml", written, Ok(()));
    let after = answers(&mut bare);
    assert_eq!(after[0]["result"]["pupils"][0]["name"], "Ada", "{after:?}");
}

#[test]
fn second_change_is_refused_until_the_first_is_answered() {
    let mut bare = BareStation::new();
    bare.send("class.set", &json!({"text": CLASS}));
    bare.send("class.set", &json!({"text": ""}));
    let refused = answers(&mut bare);
    assert_eq!(refused.len(), 1, "{refused:?}");
    assert_eq!(refused[0]["error"]["data"]["kind"], "queue-full");
    // The schedule is another file.
    bare.send("schedule.set", &json!({"text": ""}));
    let files = bare.station.poll_files();
    for (name, file) in files {
        bare.station
            .file_written(bare.now, name, file.revision, Ok(()));
    }
    assert_eq!(answers(&mut bare).len(), 2);
    bare.send("class.codes", &json!({}));
    let files = bare.station.poll_files();
    let why = Err("full".to_owned());
    bare.station
        .file_written(bare.now, "class.toml", files["class.toml"].revision, why);
    let refused = answers(&mut bare);
    assert_eq!(
        refused[0]["error"]["data"]["reason"], "unkept",
        "{refused:?}"
    );
}

#[test]
fn roster_takes_effect_once_saved() {
    let mut bare = BareStation::new();
    let expected =
        json!({"arms": [{"arm": "a1", "machine": "bench-1"}, {"arm": "a2", "machine": ""}]});
    let mut write = |outcome: Result<(), String>| {
        bare.send("site.expect", &expected);
        assert_eq!(answers(&mut bare), Vec::<Value>::new());
        let file = &bare.station.poll_files()["roster.json"];
        assert_eq!(serde_json::from_str::<Value>(&file.text).unwrap(), expected);
        bare.station
            .file_written(bare.now, "roster.json", file.revision, outcome);
        let answer = answers(&mut bare).remove(0);
        bare.send("site.roster", &json!({}));
        (answer, answers(&mut bare)[0]["result"].clone())
    };
    let (refused, after) = write(Err("full".to_owned()));
    assert_eq!(refused["error"]["data"]["reason"], "unkept", "{refused}");
    assert_eq!(after, json!({"arms": []}));
    let (written, after) = write(Ok(()));
    assert_eq!((&written["result"], &after), (&expected, &expected));
    for wrong in [
        json!([{"arm": "*"}]),
        json!([{"machine": "m"}]),
        json!([{"arm": "a", "x": 1}]),
    ] {
        bare.send("site.expect", &json!({"arms": wrong}));
        let refused = answers(&mut bare);
        assert_eq!(refused[0]["error"]["code"], -32602, "{refused:?}");
    }
    bare.send("site.roster", &json!({}));
    assert_eq!(answers(&mut bare)[0]["result"], expected);
}
