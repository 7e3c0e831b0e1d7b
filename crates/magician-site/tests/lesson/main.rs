//! A lesson of 45 minutes in virtual time: ten arms at four stations, thirty pupils, a teacher at
//! the hub, and two cut cables.

#[expect(
    dead_code,
    reason = "a lesson needs less of it than the tests of the hub"
)]
#[path = "../hub/bench.rs"]
mod bench;
mod class;
mod drawing;
mod laws;
mod page;
mod pictures;
mod pupil;
mod room;
mod teacher;

use std::path::Path;
use std::time::Duration;

use room::Room;
use tokio::task::JoinSet;

/// Length of the lesson.
const LESSON: Duration = Duration::from_secs(45 * 60);

/// `MAGICIAN_WRITE=1` rewrites the log. `MAGICIAN_LESSON_PICTURES` is for `interop/lesson/run`.
#[tokio::test(start_paused = true)]
#[ignore = "takes a minute: the step lesson of .ci/wide"]
async fn lesson_obeys_its_laws_and_reproduces_its_log() {
    let room = Room::open().await;
    let mut tasks = JoinSet::new();
    tasks.spawn(teacher::teaches(room.clone()));
    tasks.spawn(laws::watches(room.clone()));
    for at in 0..class::pupils().len() {
        tasks.spawn(pupil::take_part(room.clone(), at));
    }
    while let Some(ended) = tasks.join_next().await {
        ended.unwrap();
    }
    laws::hold(&room).await;
    if pictures::wanted() {
        return;
    }
    let log = room.log();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/evidence/lesson/log.txt");
    if std::env::var_os("MAGICIAN_WRITE").is_some() {
        std::fs::write(&path, &log).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    let differs = log.lines().zip(kept.lines()).find(|(is, was)| is != was);
    assert!(
        log == kept,
        "docs/evidence/lesson/log.txt is not of this lesson ({differs:?}): MAGICIAN_WRITE=1 writes it anew"
    );
}
