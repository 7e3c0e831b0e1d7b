//! Results: the completed jobs of pupils, with a picture of each.

use std::sync::Arc;
use std::time::{Duration, UNIX_EPOCH};

use serde_json::{Value, json};

use super::Station;
use super::class::RESULTS_FILE;
use crate::control::{ArmId, JobId, RequestId};
use crate::order::{ArmOrder, JobOrder};

/// Most results that are kept.
const MAX_RESULTS: usize = 500;
/// Title of a program without one, such as text typed into a page.
const UNTITLED: &str = "without a title";

impl Station {
    /// Stores the result of a pupil's completed job and orders its picture.
    pub(super) fn store_result(&mut self, arm: ArmId, job: JobId, order: Option<&Arc<JobOrder>>) {
        let Some(record) = self.records.numbered(job) else {
            return;
        };
        let Some(pupil) = record.pupil.clone().filter(|_| record.state == "done") else {
            return;
        };
        let (id, title) = (record.id.clone(), record.title.clone());
        let ended = record.ended.unwrap_or_default();
        // `from_secs_f64` panics on negative numbers.
        let time = UNIX_EPOCH + Duration::from_secs_f64(ended.max(0.0));
        let drawn = record.drawn_mm;
        let group = self.group_of(&pupil).map(str::to_owned);
        let result = json!({
            "job": id, "pupil": pupil, "group": group, "title": title, "arm": self.arm(arm).entry.name,
            "time": humantime::format_rfc3339_seconds(time).to_string(),
            "drawn_mm": drawn, "strokes": [],
        });
        let results = &mut self.class.results;
        // A job that is resumed and completed again counts once.
        results.retain(|known| known["job"] != json!(id));
        results.push(result);
        let over = results.len().saturating_sub(MAX_RESULTS);
        // The oldest results go first.
        results.drain(..over);
        if let Some(order) = order {
            let request = RequestId(self.next_id());
            self.class.pictures.insert(request, id);
            let (source, preview) = (Box::new(order.source.clone()), true);
            self.order(
                arm,
                ArmOrder::CheckJob {
                    request,
                    source,
                    preview,
                },
            );
        }
        self.write_results();
    }

    /// Takes the preview for a result. Returns false if the request was not for a picture.
    pub(super) fn store_picture(&mut self, request: RequestId, outcome: Option<&Value>) -> bool {
        let Some(id) = self.class.pictures.remove(&request) else {
            return false;
        };
        let of = |result: &&mut Value| result["job"] == json!(id);
        if let (Some(result), Some(outcome)) = (self.class.results.iter_mut().find(of), outcome) {
            result["strokes"] = crate::class::picture(&outcome["preview"]);
        }
        self.write_results();
        true
    }

    /// Returns the results as answered by `class.results`.
    #[must_use]
    pub(super) fn shown_results(&self) -> Value {
        let results = self.class.results.iter().map(|kept| {
            let mut shown = kept.clone();
            let time = kept["time"].as_str().unwrap_or_default();
            let unix = humantime::parse_rfc3339(time).ok();
            let unix = unix.and_then(|time| time.duration_since(UNIX_EPOCH).ok());
            shown["time_local"] = json!(unix.map(|unix| self.local_time(unix.as_secs() as i64)));
            let title = kept["title"].as_str().filter(|title| !title.is_empty());
            shown["title"] = json!(title.unwrap_or(UNTITLED));
            if let Some(members) = shown.as_object_mut() {
                let strokes = members.remove("strokes").unwrap_or_default();
                members.insert("svg".to_owned(), json!(crate::class::picture_svg(&strokes)));
            }
            shown
        });
        json!({"results": results.collect::<Vec<_>>()})
    }

    pub(super) fn write_results(&mut self) {
        let text = Value::Array(self.class.results.clone()).to_string();
        self.class.files.write(RESULTS_FILE, text);
    }
}
