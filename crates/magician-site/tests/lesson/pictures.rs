//! Screenshots of the hub at one instant of the lesson. Time runs on for some seconds while a
//! browser looks at it.

use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

use magician_site::hub::RunningHub;
use magician_station::http::{HttpOptions, Listener, PageFile, Pages, TokenStore};
use tokio::sync::watch;

/// Target directory `MAGICIAN_LESSON_PICTURES`, and the program `MAGICIAN_LESSON_CAMERA`, which is
/// called with the address of the page and the file.
fn asked() -> Option<(PathBuf, OsString)> {
    let directory = std::env::var_os("MAGICIAN_LESSON_PICTURES")?;
    Some((
        directory.into(),
        std::env::var_os("MAGICIAN_LESSON_CAMERA")?,
    ))
}

pub(crate) fn wanted() -> bool {
    asked().is_some()
}

/// Takes screenshots of the hub's page, if they are wanted.
pub(crate) struct Camera(Option<Serving>);

struct Serving {
    directory: PathBuf,
    program: OsString,
    url: String,
    _over: watch::Sender<bool>,
}

impl Camera {
    pub(crate) async fn of(hub: &RunningHub) -> Self {
        let Some((directory, program)) = asked() else {
            return Self(None);
        };
        let listener = Listener::bind(Some("127.0.0.1:0")).await.unwrap();
        let files = magician_studio::FILES.iter().map(|file| PageFile {
            path: file.path,
            kind: file.kind,
            gzip: file.gzip,
        });
        let options = HttpOptions {
            pages: Pages::new(files),
            ..HttpOptions::new(TokenStore::at("/nowhere/tokens.toml"), "0.0.0")
        };
        let (over, ends) = watch::channel(false);
        let url = listener.url();
        tokio::spawn(listener.serve(hub.clone(), options, ends));
        Self(Some(Serving {
            directory,
            program,
            url,
            _over: over,
        }))
    }

    pub(crate) async fn takes(&self, name: &str) {
        let Some(serving) = &self.0 else { return };
        let mut camera = Command::new(&serving.program);
        camera
            .arg(&serving.url)
            .arg(serving.directory.join(format!("{name}.png")));
        tokio::time::resume();
        let status = tokio::task::spawn_blocking(move || camera.status()).await;
        tokio::time::pause();
        assert!(status.unwrap().unwrap().success(), "no picture {name}");
    }
}
