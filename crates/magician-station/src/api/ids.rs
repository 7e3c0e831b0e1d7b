//! Places of ids in messages. A hub between a client and several stations uses them to replace the
//! ids of one station by its own.

use serde_json::Value;

use super::{Kind, Method};

/// Kind of an id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IdKind {
    /// A session.
    Session,
    /// A lease.
    Lease,
    /// A jog.
    Jog,
    /// A job.
    Job,
    /// A subscription of a socket: a number from 1 to 65535.
    Subscription,
}

/// Place of an id that may be present: member names separated by points, with `[]` after an array
/// whose items are meant.
pub type IdPlace = (&'static str, IdKind);

use IdKind::{Job, Jog, Lease, Session, Subscription};

const STATE: &[IdPlace] = &[("job", Job), ("jog", Jog), ("holder.session", Session)];
const JOB: &[IdPlace] = &[
    ("job", Job),
    ("holder.session", Session),
    ("error.holder.session", Session),
    ("error.by", Session),
];

/// Ids in turns.
pub(super) const TURNS: &[IdPlace] = &[("arms[].jobs[].job", Job)];

/// Ids in the results of methods. Other results contain none.
const RESULTS: &[(&str, &[IdPlace])] = &[
    ("session.hello", &[("session", Session)]),
    ("session.list", &[("sessions[].session", Session)]),
    (
        "arm.list",
        &[
            ("arms[].holder.session", Session),
            ("arms[].waiting[].session", Session),
            ("arms[].job", Job),
        ],
    ),
    ("arm.state", STATE),
    ("arm.move", STATE),
    ("arm.home", STATE),
    ("arm.clear_alarms", STATE),
    ("arm.tool", STATE),
    ("jog.step", STATE),
    ("world.guide", STATE),
    ("arm.subscribe", &[("subscription", Subscription)]),
    (
        "events.since",
        &[
            ("events[].by", Session),
            ("events[].holder.session", Session),
            ("events[].job", Job),
            ("events[].jog", Jog),
        ],
    ),
    ("turn.join", TURNS),
    ("turn.list", TURNS),
    ("lease.acquire", &[("lease", Lease)]),
    ("lease.ask", &[("lease", Lease)]),
    ("lease.take", &[("lease", Lease)]),
    ("jog.start", &[("jog", Jog)]),
    ("job.start", &[("job", Job)]),
    (
        "class.send",
        &[
            ("jobs[].job", Job),
            ("jobs[].error.holder.session", Session),
            ("jobs[].error.by", Session),
            ("jobs[].error.job", Job),
        ],
    ),
    ("class.results", &[("results[].job", Job)]),
    ("job.get", JOB),
    ("job.pause", JOB),
    ("job.resume", JOB),
    ("job.stop", JOB),
    ("job.reorder", JOB),
    (
        "job.history",
        &[
            ("jobs[].job", Job),
            ("jobs[].holder.session", Session),
            ("jobs[].error.holder.session", Session),
            ("jobs[].error.by", Session),
        ],
    ),
    (
        "job.list",
        &[
            ("jobs[].job", Job),
            ("jobs[].holder.session", Session),
            ("jobs[].error.holder.session", Session),
            ("jobs[].error.by", Session),
        ],
    ),
];

/// Ids in `data` of an error.
pub static ERROR_IDS: &[IdPlace] = &[
    ("holder.session", Session),
    ("by", Session),
    ("job", Job),
    ("jog", Jog),
];

impl Method {
    /// Returns the ids in the method's result.
    #[must_use]
    pub fn result_ids(&self) -> &'static [IdPlace] {
        let known = RESULTS.iter().find(|(name, _)| *name == self.name);
        known.map_or(&[], |(_, ids)| ids)
    }

    /// Returns the parameter that is an id, and its kind. `None` without such a parameter.
    #[must_use]
    pub fn id_param(&self) -> Option<(&'static str, IdKind)> {
        self.params.iter().find_map(|param| match param.kind {
            Kind::Id(kind) => Some((param.name, kind)),
            _ => None,
        })
    }

    /// True if a parameter names an arm.
    #[must_use]
    pub fn takes_arm(&self) -> bool {
        self.params.iter().any(|param| param.name == "arm")
    }
}

/// Calls `change` for each id at these places. Skips ids that are null or missing.
pub fn each_id(value: &mut Value, places: &[IdPlace], change: &mut dyn FnMut(IdKind, &mut Value)) {
    for (place, kind) in places {
        at(value, place, &mut |id| {
            // Null means that there is no session or job, so there is nothing to rename.
            if !id.is_null() {
                change(*kind, id);
            }
        });
    }
}

fn at(value: &mut Value, place: &str, change: &mut dyn FnMut(&mut Value)) {
    let (name, rest) = place.split_once('.').unwrap_or((place, ""));
    let (name, many) = match name.strip_suffix("[]") {
        Some(name) => (name, true),
        None => (name, false),
    };
    let Some(member) = value.get_mut(name) else {
        return;
    };
    let mut go = |value: &mut Value| match rest {
        "" => change(value),
        rest => at(value, rest, change),
    };
    match (many, member) {
        (false, member) => go(member),
        (true, Value::Array(items)) => items.iter_mut().for_each(go),
        (true, _) => {}
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::api::METHODS;

    #[test]
    fn only_listed_places_are_ids() {
        let mut value = json!({
            "arms": [
                {"name": "s1", "holder": {"session": "s1", "name": "s1"}, "waiting": [{"session": "s2"}], "job": null},
                {"name": "b", "holder": null, "waiting": "s3", "job": "j1"},
                7,
            ],
        });
        let places = Method::named("arm.list").unwrap().result_ids();
        let mut found = Vec::new();
        each_id(&mut value, places, &mut |kind, id| {
            found.push((kind, id.clone()));
            *id = json!("other");
        });
        let expected = [
            (Session, json!("s1")),
            (Session, json!("s2")),
            (Job, json!("j1")),
        ];
        assert_eq!(found, expected);
        assert_eq!(value["arms"][0]["holder"]["name"], "s1");
        assert_eq!(value["arms"][0]["holder"]["session"], "other");
        assert_eq!(value["arms"][1]["waiting"], "s3");
    }

    #[test]
    fn every_result_row_names_a_method() {
        for (name, _) in RESULTS {
            if name.starts_with("class.") && cfg!(not(feature = "class")) {
                continue;
            }
            assert!(Method::named(name).is_some(), "{name}");
        }
        // A new method with an id among its parameters and without an arm must be added to this
        // list.
        let by_id = METHODS.iter().filter(|method| method.id_param().is_some());
        let by_id: Vec<_> = by_id.map(|method| method.name).collect();
        let expected = [
            "arm.unsubscribe",
            "lease.renew",
            "lease.release",
            "lease.answer",
            "jog.keep",
            "jog.stop",
            "job.get",
            "job.pause",
            "job.resume",
            "job.stop",
            "job.reorder",
            "job.delete",
        ];
        assert_eq!(by_id, expected);
    }
}
