//! One page that looks on: what it is told, and what it asks for.
//!
//! Reading and writing go on side by side: a STOP from a page is heard even when that page is too slow for what it is
//! told. A ping follows every moment, and a client that has not answered the last few gets no more until it does: what
//! it sees is then old by its own delay, not by all that fits into the buffers between.

use crate::feed::{Feed, View, refused};
use axum::extract::ws::{CloseFrame, Message, Utf8Bytes, WebSocket, close_code};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep_until, timeout};

/// A client's message is at most this long.
pub(crate) const MESSAGE_BYTES_MAX: usize = 4096;

/// Pings go out this often even when nothing is shown.
const PING_PERIOD: Duration = Duration::from_secs(5);

/// A client that is silent for longer (it answers pings by itself), or takes longer to take a message, is gone.
const SILENCE_MAX: Duration = Duration::from_secs(15);

/// Pings that a client may owe an answer to before it gets no more moments.
const UNANSWERED_MAX: u64 = 4;

/// Refusals that wait to be told; more are dropped.
const REFUSALS_WAITING_MAX: usize = 8;

type Outlet = SplitSink<WebSocket, Message>;

/// The client is gone.
struct Gone;

/// Serve one client until it goes, or until `open`'s sender is dropped.
pub(crate) async fn serve(socket: WebSocket, feed: Feed, open: watch::Receiver<()>) {
    let (outlet, inlet) = socket.split();
    let (refusals, refusals_told) = mpsc::channel(REFUSALS_WAITING_MAX);
    let (answered, answers) = watch::channel(0);
    let teller = Teller { outlet, views: feed.views(), refusals: refusals_told, answers, pings: 0, run: 0, frame: 0 };
    tokio::select! {
        () = hear(inlet, feed, refusals, answered) => {}
        Gone = tell(teller, open) => {}
    }
}

/// Returns when `open`'s sender is dropped.
pub(crate) async fn closed(mut open: watch::Receiver<()>) {
    while open.changed().await.is_ok() {}
}

/// Take what the client sends, until it goes.
async fn hear(
    mut inlet: SplitStream<WebSocket>,
    feed: Feed,
    refusals: mpsc::Sender<Utf8Bytes>,
    answered: watch::Sender<u64>,
) {
    while let Ok(Some(Ok(message))) = timeout(SILENCE_MAX, inlet.next()).await {
        let asked = match &message {
            Message::Text(text) => feed.ask(text),
            Message::Binary(_) => Err("not a control: not text".to_owned()),
            Message::Pong(number) => {
                let number = number.as_ref().try_into().map_or(0, u64::from_be_bytes);
                answered.send_if_modified(|newest| std::mem::replace(newest, number.max(*newest)) < number);
                Ok(())
            }
            Message::Ping(_) => Ok(()),
            Message::Close(_) => return,
        };
        if let Err(why) = asked {
            tracing::debug!(why, "refused to the live view");
            // A client that asks faster than it listens need not be told of every refusal.
            let _ = refusals.try_send(refused(&why));
        }
    }
}

/// Tell the client what there is, until it goes or the server closes.
async fn tell(mut teller: Teller, open: watch::Receiver<()>) -> Gone {
    let told = tokio::select! {
        Err(gone) = teller.tell_all() => return gone,
        () = closed(open) => teller.say_goodbye(),
    };
    // The goodbye is a courtesy: a client that does not take it at once finds out by itself.
    let _ = timeout(Duration::from_millis(200), told).await;
    Gone
}

struct Teller {
    outlet: Outlet,
    views: watch::Receiver<View>,
    refusals: mpsc::Receiver<Utf8Bytes>,
    /// The newest ping that was answered.
    answers: watch::Receiver<u64>,
    /// Pings sent.
    pings: u64,
    /// The run and the frame that were told last.
    run: u64,
    frame: u64,
}

impl Teller {
    async fn tell_all(&mut self) -> Result<(), Gone> {
        self.views.mark_changed();
        loop {
            let ping_at = Instant::now() + PING_PERIOD;
            let may_tell = self.pings - *self.answers.borrow() < UNANSWERED_MAX;
            tokio::select! {
                changed = self.views.changed(), if may_tell => {
                    changed.map_err(|_| Gone)?;
                    self.tell_view().await?;
                }
                Some(refusal) = self.refusals.recv() => self.send(Message::Text(refusal)).await?,
                changed = self.answers.changed() => changed.map_err(|_| Gone)?,
                () = sleep_until(ping_at) => self.ping().await?,
            }
        }
    }

    async fn tell_view(&mut self) -> Result<(), Gone> {
        let View { run, frame } = self.views.borrow_and_update().clone();
        if run.number != self.run {
            self.send(Message::Text(run.text())).await?;
            (self.run, self.frame) = (run.number, 0);
        }
        let Some(frame) = frame.filter(|frame| frame.number != self.frame) else { return Ok(()) };
        self.send(Message::Text(frame.text_after(self.frame))).await?;
        self.frame = frame.number;
        self.ping().await
    }

    async fn ping(&mut self) -> Result<(), Gone> {
        self.pings += 1;
        self.send(Message::Ping(self.pings.to_be_bytes().to_vec().into())).await
    }

    async fn send(&mut self, message: Message) -> Result<(), Gone> {
        match timeout(SILENCE_MAX, self.outlet.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) | Err(_) => Err(Gone),
        }
    }

    async fn say_goodbye(&mut self) {
        let reason = Utf8Bytes::from_static("the run is over");
        let goodbye = Message::Close(Some(CloseFrame { code: close_code::AWAY, reason }));
        // Whether it arrives does not matter any more.
        let _ = self.outlet.send(goodbye).await;
    }
}
