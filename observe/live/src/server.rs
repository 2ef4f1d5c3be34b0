//! The server.

use crate::access::{Access, Denied};
use crate::client;
use crate::feed::Feed;
use crate::page::{File, INDEX, PARTS};
use axum::Router;
use axum::extract::ws::WebSocketUpgrade;
use axum::extract::{Request, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, REFERRER_POLICY, X_CONTENT_TYPE_OPTIONS, X_FRAME_OPTIONS,
};
use axum::http::{HeaderMap, HeaderName, HeaderValue, StatusCode, Uri};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use drover_io::OpenError;
use std::net::SocketAddr;
use std::sync::Arc;
use tokio::sync::watch;

/// Where and to whom a swarm is shown.
#[derive(Clone, Debug)]
pub struct LiveOptions {
    /// Where to listen; port 0 lets the system choose one.
    pub address: SocketAddr,
    /// What the page's address has to end in. `None`: nothing on loopback, and elsewhere 128 random bits.
    pub token: Option<String>,
}

/// A server that shows a swarm until it is dropped.
#[derive(Debug)]
pub struct Live {
    url: String,
    address: SocketAddr,
    /// Dropped with this: the server and its clients see it and end.
    _open: watch::Sender<()>,
}

/// On every answer. The page is allowed its own files and this server, and nobody may put it into a frame: a stop
/// button must not lie under somebody else's picture.
const HEADERS: [(HeaderName, HeaderValue); 5] = [
    (
        CONTENT_SECURITY_POLICY,
        HeaderValue::from_static(
            "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; \
             base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        ),
    ),
    (X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
    (X_FRAME_OPTIONS, HeaderValue::from_static("DENY")),
    (REFERRER_POLICY, HeaderValue::from_static("no-referrer")),
    (CACHE_CONTROL, HeaderValue::from_static("no-store")),
];

#[derive(Clone)]
struct Shared {
    access: Arc<Access>,
    feed: Feed,
    open: watch::Receiver<()>,
}

impl Live {
    /// Serve what `feed` shows.
    ///
    /// # Errors
    /// [`OpenError`] if the address cannot be listened at or the token is unfit.
    pub async fn start(options: LiveOptions, feed: Feed) -> Result<Self, OpenError> {
        let listener = drover_io::listen(options.address).await?;
        let address = listener.local_addr().map_err(|error| {
            OpenError::new(format!("http://{}", options.address), error.to_string(), "start it again")
        })?;
        let access = Access::new(address, options.token)?;
        let url = access.url(address);
        let (closer, open) = watch::channel(());
        let router = router(Shared { access: Arc::new(access), feed, open: open.clone() });
        tokio::spawn(async move {
            let closed = client::closed(open);
            if let Err(error) = axum::serve(listener, router).with_graceful_shutdown(closed).await {
                tracing::warn!(%error, "the live view's server ended");
            }
        });
        tracing::info!(%address, "live view");
        Ok(Self { url, address, _open: closer })
    }

    /// What to open in a browser on this computer, with the token if there is one.
    #[must_use]
    pub fn url(&self) -> &str {
        &self.url
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

fn router(shared: Shared) -> Router {
    let bare = Router::new().route("/", get(index)).route("/live", get(live)).route("/healthz", get(async || "ok\n"));
    // The page has its own icon; a browser that was refused it asks for this one, and would complain of a missing file.
    let bare = bare.route("/favicon.ico", get(async || StatusCode::NO_CONTENT));
    let with_parts = PARTS.iter().fold(bare, |router, part| router.route(part.path, get(async || answer(part))));
    let outer = middleware::from_fn_with_state(shared.clone(), guard);
    with_parts.with_state(shared).layer(outer)
}

/// Around everything: strange hosts are turned away, and every answer has our headers.
async fn guard(State(shared): State<Shared>, request: Request, next: Next) -> Response {
    let mut response = match shared.access.check_host(request.headers()) {
        Ok(()) => next.run(request).await,
        Err(denied) => denied.into_response(),
    };
    response.headers_mut().extend(HEADERS);
    response
}

async fn index(State(shared): State<Shared>, uri: Uri) -> Response {
    match shared.access.check_token(&uri) {
        Ok(()) => answer(&INDEX),
        Err(denied) => denied.into_response(),
    }
}

async fn live(State(shared): State<Shared>, uri: Uri, headers: HeaderMap, upgrade: WebSocketUpgrade) -> Response {
    let checked = shared.access.check_origin(&headers).and_then(|()| shared.access.check_token(&uri));
    if let Err(denied) = checked {
        return denied.into_response();
    }
    let Some(seat) = shared.feed.seat() else {
        return (StatusCode::SERVICE_UNAVAILABLE, "Too many pages are open. Close one.\n").into_response();
    };
    let bounded = upgrade.max_message_size(client::MESSAGE_BYTES_MAX).max_frame_size(client::MESSAGE_BYTES_MAX);
    bounded.on_upgrade(async move |socket| {
        client::serve(socket, shared.feed, shared.open).await;
        drop(seat);
    })
}

fn answer(file: &File) -> Response {
    ([(CONTENT_TYPE, file.kind)], file.text).into_response()
}

impl IntoResponse for Denied {
    fn into_response(self) -> Response {
        let status = match self {
            Self::Host | Self::Origin => StatusCode::FORBIDDEN,
            Self::Token => StatusCode::UNAUTHORIZED,
        };
        tracing::warn!(why = ?self, "a request to the live view was turned away");
        (status, self.words()).into_response()
    }
}
