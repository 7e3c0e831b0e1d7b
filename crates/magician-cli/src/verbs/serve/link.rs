//! Interface for programs of the vendor's DobotLink, beside the pages and the API.

use std::sync::Arc;

use clap::Args;
use magician_station::RunningStation;
use magician_station::http::{Admission, LinkCalls, ListenError};
use magician_station::link::{ImageStub, LinkListener, LinkOptions, LinkService};
use tokio::sync::watch;

use crate::failure::Failure;

/// Flags of the protocol of DobotLink.
#[derive(Args, Debug)]
#[command(next_help_heading = "Programs for DobotLink")]
pub(super) struct LinkFlags {
    /// Serve programs for DobotLink (DobotLab's scripts, DobotEDU, dobotkit) at localhost:9090, or
    /// at another address reachable only from this machine
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true)]
    link: Option<Option<String>>,
    /// Answer ConnectDobot with empty strings, as DobotLink does
    #[arg(long)]
    link_empty_connect: bool,
    /// Reject parameters unknown to a call, instead of only counting them
    #[arg(long)]
    link_strict: bool,
    /// Let programs write serial numbers, calibrations and Wi-Fi settings
    #[arg(long)]
    link_dangerous: bool,
    /// Let programs switch on the laser of a real arm
    #[arg(long)]
    link_laser: bool,
    /// Accept connections at port 10001, which DobotEDU waits for when it is imported
    #[arg(long)]
    link_image: bool,
}

/// Endpoint of programs for DobotLink.
pub(super) struct Link {
    listener: LinkListener,
    image: Option<ImageStub>,
}

impl LinkFlags {
    /// Enables the link because the settings ask for it.
    pub(super) fn enabled_by_settings(&mut self) {
        self.link.get_or_insert(None);
    }

    /// Fails if options of the link are given without it. Not a `requires` of clap, because the
    /// settings may enable the link.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let given = [
            (self.link_empty_connect, "--link-empty-connect"),
            (self.link_strict, "--link-strict"),
            (self.link_dangerous, "--link-dangerous"),
            (self.link_laser, "--link-laser"),
            (self.link_image, "--link-image"),
        ];
        match { given.iter() }.find(|(given, _)| *given && self.link.is_none()) {
            Some((_, flag)) => Err(Failure::usage(format!(
                "{flag} needs --link: programs for DobotLink are not served"
            ))
            .hint("add --link, or set serve.link")),
            None => Ok(()),
        }
    }

    /// Binds the endpoint; `None` if the link is disabled.
    pub(super) async fn bind(&self) -> Result<Option<Link>, Failure> {
        let Some(address) = &self.link else {
            return Ok(None);
        };
        let listener = match LinkListener::bind(address.as_deref()).await {
            Err(error @ ListenError::Beyond(_)) => {
                return Err(Failure::usage(error.to_string()).hint(
                    "DobotLink's protocol has no login: --link serves only programs on this machine",
                ));
            }
            listener => listener?,
        };
        let image = if self.link_image {
            Some(ImageStub::bind().await?)
        } else {
            None
        };
        Ok(Some(Link { listener, image }))
    }

    /// Creates the service that answers the programs.
    pub(super) fn service(&self, station: &RunningStation) -> LinkService {
        let mut options = LinkOptions::default();
        options.strict = self.link_strict;
        options.dangerous = self.link_dangerous;
        options.laser = self.link_laser;
        options.empty_connect = self.link_empty_connect;
        env!("CARGO_PKG_VERSION").clone_into(&mut options.version);
        LinkService::new(station.clone(), options)
    }
}

/// Returns the source of the report on programs' calls.
pub(super) fn calls(service: LinkService) -> LinkCalls {
    LinkCalls(Arc::new(move || service.report()))
}

impl Link {
    /// Returns the address of the endpoint.
    pub(super) fn url(&self) -> String {
        let address = self.listener.addresses().first().map(ToString::to_string);
        format!("ws://{}", address.unwrap_or_default())
    }

    /// Serves programs until `over` is true.
    pub(super) async fn serve(
        self,
        service: LinkService,
        admission: Admission,
        over: watch::Receiver<bool>,
    ) {
        let image = async {
            if let Some(image) = self.image {
                image.serve(over.clone()).await;
            }
        };
        let link = self.listener.serve(service, admission, over.clone());
        tokio::join!(link, image);
    }
}
