//! The swarm live in Foxglove: a WebSocket server that its app connects to.
//!
//! What is sent is what a recording holds, made by `drover_record::foxglove`. Nothing here waits for anybody: every
//! client has a queue, and one that does not keep up loses its oldest messages. What nobody is subscribed to is not
//! made.

mod stage;

use drover_contract::Severity;
use drover_record::foxglove::log;
use drover_record::{Moment, Setting};
use foxglove::messages::Log;
use foxglove::websocket::{ChannelView, Client, ServerListener};
use foxglove::{Channel, ChannelBuilder, Context, FoxgloveError, PartialMetadata, WebSocketServer};
use foxglove::{SinkId, WebSocketServerHandle};
use stage::Stage;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};

/// Why the server did not start.
#[derive(Debug, thiserror::Error)]
#[error("no Foxglove server at {address}: {source}")]
pub struct StartError {
    /// Where it was to listen.
    pub address: SocketAddr,
    source: FoxgloveError,
}

/// A server that Foxglove connects to. It ends when it is dropped.
pub struct FoxgloveServer {
    address: SocketAddr,
    /// `None` only while it is being dropped.
    handle: Option<WebSocketServerHandle>,
    shared: Arc<Shared>,
}

/// What the server and those who serve its clients share.
struct Shared {
    /// Ties the channels to the clients; without it nothing is sent.
    context: Arc<Context>,
    log: Channel<Log>,
    /// The run that is shown; `None` before the first.
    stage: Mutex<Option<Arc<Stage>>>,
}

impl Shared {
    /// The run that is shown. The lock is held for this copy only: nobody waits for a client.
    fn stage(&self) -> Option<Arc<Stage>> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

/// Tells a client that subscribes late what was sent once.
struct Latecomers(Arc<Shared>);

impl ServerListener for Latecomers {
    fn on_subscribe(&self, client: Client, channel: ChannelView<'_>) {
        if let Some(stage) = self.0.stage() {
            stage.tell_once(channel.topic(), client.sink_id());
        }
    }
}

impl FoxgloveServer {
    /// Listen at `address`, port 0 for any. Its tasks run on the Tokio runtime that this is called from.
    ///
    /// # Errors
    /// [`StartError`] if nothing can listen there.
    pub async fn start(address: SocketAddr) -> Result<Self, StartError> {
        let context = Context::new();
        let log = ChannelBuilder::new("/log").context(&context).build();
        let shared = Arc::new(Shared { context, log, stage: Mutex::new(None) });
        // The library joins host and port with a colon, so an IPv6 address needs its brackets.
        let host = match address.ip() {
            IpAddr::V4(ip) => ip.to_string(),
            IpAddr::V6(ip) => format!("[{ip}]"),
        };
        let server = WebSocketServer::new()
            .name("drover")
            .context(&shared.context)
            .listener(Arc::new(Latecomers(Arc::clone(&shared))))
            .bind(host, address.port());
        let handle = server.start().await.map_err(|source| StartError { address, source })?;
        let address = SocketAddr::new(address.ip(), handle.port());
        Ok(Self { address, handle: Some(handle), shared })
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// How many clients are connected.
    #[must_use]
    pub fn clients(&self) -> usize {
        self.handle.as_ref().map_or(0, WebSocketServerHandle::client_count)
    }

    /// A run begins: its place and its robots replace those of the run before.
    pub fn begin(&self, setting: &Setting) {
        let mut shown = self.shared.stage.lock().unwrap_or_else(PoisonError::into_inner);
        // The channels of the run before close first: two channels must not share a topic.
        if let Some(before) = shown.take() {
            before.close();
        }
        let stage = Arc::new(Stage::new(&self.shared.context, setting));
        *shown = Some(Arc::clone(&stage));
        drop(shown);
        stage.tell_all();
    }

    /// The swarm at `unix_us`, microseconds since the Unix epoch. Before [`Self::begin`] it does nothing.
    pub fn show(&self, unix_us: u64, moment: &Moment) {
        let Some(stage) = self.shared.stage() else { return };
        stage.show(unix_us, moment);
        // Whoever subscribes to the log later is then told how everybody is: none of that was told before.
        if !self.shared.log.has_sinks() {
            return;
        }
        for (severity, robot, words) in stage.news(moment) {
            self.log(unix_us, severity, robot, &words);
        }
    }

    /// Words for people at `unix_us`, microseconds since the Unix epoch, about one robot; `robot` 0: about the swarm.
    pub fn log(&self, unix_us: u64, severity: Severity, robot: u32, words: &str) {
        if self.shared.log.has_sinks() {
            self.shared.log.log_with_meta(&log(unix_us, severity, robot, words), at(unix_us));
        }
    }
}

impl Drop for FoxgloveServer {
    fn drop(&mut self) {
        // Without this the library would go on listening. What `stop` returns ends the clients' tasks when dropped.
        if let Some(handle) = self.handle.take() {
            drop(handle.stop());
        }
    }
}

/// When a message holds.
fn at(unix_us: u64) -> PartialMetadata {
    PartialMetadata { log_time: Some(unix_us.saturating_mul(1_000)) }
}

/// Send what `make` makes, if anybody is subscribed; to `only` alone if it is given.
fn send<M: foxglove::Encode>(channel: &Channel<M>, unix_us: u64, only: Option<SinkId>, make: impl FnOnce() -> M) {
    if channel.has_sinks() {
        channel.log_with_meta_to_sink(&make(), at(unix_us), only);
    }
}
