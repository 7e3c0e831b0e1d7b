//! `fleet studio`: serves the studio with the arms of all stations.

use std::sync::Arc;
use std::time::Duration;

use magician_site::carrier::ZenohSite;
use magician_site::hub::{HubConfig, RunningHub};
use magician_site::{Caller, Site};
use magician_station::http::JournalFile;
use magician_station::{FormatReader, StationConfig};
use serde_json::json;
use tokio::sync::watch;
use tokio::time::timeout;

use super::stop::no_token;
use super::{Studio, gather};
use crate::context::Context;
use crate::failure::Failure;
use crate::paint::print_stderr;
use crate::serving::{print_ready, unix_time};
use crate::verbs::{job, serve};
use magician::stations::folder;

/// Longest wait for sockets to close at the end. A choice.
const CLOSE_TIMEOUT: Duration = Duration::from_secs(2);

impl Studio {
    pub(super) fn run(
        mut self,
        context: &mut Context,
        caller: Caller,
        join: impl AsyncFnOnce() -> Result<ZenohSite, Failure>,
    ) -> Result<(), Failure> {
        // Without a token the stations would refuse every request, and the page's stop button would
        // do nothing.
        let token = caller.token.ok_or_else(no_token)?;
        let config = context.config()?;
        self.front.fill_in(&config);
        let store = self.front.tokens()?;
        let tls = self.front.tls()?;
        let epoch = format!("{:x}", unix_time().as_millis());
        let mut station = StationConfig::new(Vec::new(), epoch);
        station.read_only = self.front.read_only;
        let mut reader = FormatReader::new(job::defaults(&config)?);
        if let Some(programs) = self.front.programs()? {
            reader = reader.with_library(Arc::clone(&programs));
            station.programs = programs;
        }
        station.reader = Arc::new(reader);
        let journal = folder().map(|folder| JournalFile::at(folder.join("hub.jsonl")));
        let json = context.global.json;
        context.close_connection()?;
        context.run_without_arm(async |_, signals| {
            let listener = self.front.bind(tls).await?;
            let site = join().await?;
            // A page opened now shows all arms at once; arms that appear later are added.
            let arms = gather(&site).await.map(|known| known.len());
            // Read last, because the hub counts its time from its start.
            station.unix_zero = unix_time().as_secs_f64();
            let hub = HubConfig {
                station,
                token: Some(token),
                journal: Box::new(move |line| {
                    if let Some(journal) = &journal {
                        journal.write(&line);
                    }
                }),
            };
            let name = site.name().to_owned();
            let hub = RunningHub::start(hub, Arc::new(site));
            hub.check_class().await;
            hub.read_roster().await;
            let (url, api) = (listener.url(), listener.api_url());
            let exposed = !listener.is_loopback();
            let options = self.front.http(store.clone(), serve::pages());
            let (over, ends) = watch::channel(false);
            let serving = tokio::spawn(listener.serve(hub.clone(), options, ends));
            match arms {
                Ok(arms) => print_stderr(format_args!(
                    "serving {url}: {arms} arms of the site {name}"
                )),
                Err(_) => print_stderr(format_args!(
                    "serving {url}: the site {name} has no arms yet"
                )),
            }
            if exposed {
                print_stderr(format_args!(
                    "other computers can connect, each with a token"
                ));
            }
            self.front.print_code(&store)?;
            if !self.no_open {
                serve::open_in_browser(&url);
            }
            if json {
                use std::io::Write;
                let ready = json!({"ready": true, "url": url, "api": api, "site": name});
                let mut stdout = std::io::stdout().lock();
                writeln!(stdout, "{ready}")?;
                stdout.flush()?;
            } else {
                print_ready();
            }
            signals.next().await;
            let _ = over.send(true);
            tokio::select! {
                _ = timeout(CLOSE_TIMEOUT, serving) => {}
                _ = signals.next() => return Err(Failure::interrupted()),
            }
            drop(hub);
            Ok(())
        })
    }
}
