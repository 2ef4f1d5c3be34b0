//! Where a run is looked at: the page in a browser, and Foxglove if it is asked for.

use anyhow::{Context, Result};
use drover_foxglove::FoxgloveServer;
use drover_live::{Feed, Live, LiveOptions};
use drover_record::{Control, Controls, Moment, Onlooker, Setting};
use std::net::SocketAddr;
use tokio::sync::mpsc::Receiver;

/// Where the page is served unless something else is asked for.
const PAGE: &str = "127.0.0.1:7780";

/// How a run may be looked at.
#[derive(clap::Args, Clone, Debug)]
pub(crate) struct ViewArguments {
    /// Serve the live page at this address; one that is not loopback needs a token, which DROVER_VIEW_TOKEN sets and
    /// which is made up otherwise. Port 0: any free one
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) view: Option<SocketAddr>,
    /// Serve a Foxglove WebSocket at this address, for example 127.0.0.1:8765
    #[arg(long, value_name = "ADDRESS:PORT")]
    pub(crate) foxglove: Option<SocketAddr>,
}

/// The servers, and what they are fed with.
pub(crate) struct View {
    feed: Feed,
    controls: Receiver<Control>,
    page: Option<Live>,
    foxglove: Option<FoxgloveServer>,
    started_unix_us: u64,
}

impl View {
    /// Start what is asked for; without a wish the page, at its usual address or, if that is taken, at any free port.
    pub(crate) async fn start(arguments: &ViewArguments, page: bool) -> Result<Self> {
        let (feed, controls) = Feed::new(Setting::default(), Controls::default());
        let page = match arguments.view {
            Some(address) => Some(serve(address, &feed).await?),
            None if page => {
                let usual: SocketAddr = PAGE.parse()?;
                match serve(usual, &feed).await {
                    Ok(live) => Some(live),
                    Err(_) => Some(serve(SocketAddr::new(usual.ip(), 0), &feed).await?),
                }
            }
            None => None,
        };
        let foxglove = match arguments.foxglove {
            Some(address) => {
                anyhow::ensure!(
                    address.ip().is_loopback(),
                    "{address}: Foxglove's protocol has no token, so it is served on loopback alone: use an address \
                     like 127.0.0.1:8765, and a tunnel (ssh -L) to reach it from elsewhere"
                );
                Some(FoxgloveServer::start(address).await.context("the Foxglove server")?)
            }
            None => None,
        };
        Ok(Self { feed, controls, page, foxglove, started_unix_us: 0 })
    }

    /// Say where it can be looked at.
    pub(crate) fn announce(&self) {
        if let Some(page) = &self.page {
            eprintln!("live view: {}", page.url());
        }
        if let Some(server) = &self.foxglove {
            eprintln!("Foxglove: ws://{}", server.address());
        }
    }
}

async fn serve(address: SocketAddr, feed: &Feed) -> Result<Live> {
    let token = std::env::var("DROVER_VIEW_TOKEN").ok().filter(|token| !token.is_empty());
    Ok(Live::start(LiveOptions { address, token }, feed.clone()).await?)
}

impl Onlooker for View {
    fn begin(&mut self, setting: Setting, controls: Controls) {
        self.started_unix_us = setting.started_unix_us;
        if let Some(server) = &self.foxglove {
            server.begin(&setting);
        }
        self.feed.begin(setting, controls);
    }

    fn show(&mut self, moment: Moment) {
        if let Some(server) = &self.foxglove {
            server.show(self.started_unix_us.saturating_add((moment.time_s * 1e6) as u64), &moment);
        }
        self.feed.show(moment);
    }

    fn next_control(&mut self) -> Option<Control> {
        self.controls.try_recv().ok()
    }

    fn is_watching(&self) -> bool {
        self.feed.is_watched() || self.foxglove.as_ref().is_some_and(|server| server.clients() > 0)
    }
}
