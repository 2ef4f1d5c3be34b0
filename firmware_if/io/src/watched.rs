//! A non-blocking socket that can wake a task.
//!
//! Reads and writes go straight to the socket: a socket that tokio has not yet looked at can be used at once, and
//! without any runtime. Only [`Watched::poll_readable`] goes through tokio. It peeks before it says "ready", because
//! direct reads leave tokio's idea of readiness stale.

use crate::errno::is_nothing_now;
use socket2::SockRef;
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::AsFd;
use std::sync::Arc;
use std::task::{Context, Poll, ready};
use tokio::io::Interest;

pub(crate) struct Watched<T: AsFd> {
    socket: Arc<T>,
    watcher: Option<Watcher>,
    /// An error that a peek took from the socket; the next read reports it.
    seen: Option<io::Error>,
}

/// A duplicate of the socket that tokio watches. Whatever the socket's family, tokio takes it as a UDP socket: the one
/// owned type that it watches without `unsafe`. Nothing is read through it, so the family does not matter.
struct Watcher(tokio::net::UdpSocket);

impl Watcher {
    fn new(socket: &impl AsFd) -> io::Result<Self> {
        let duplicate = socket.as_fd().try_clone_to_owned()?;
        tokio::net::UdpSocket::from_std(duplicate.into()).map(Self)
    }

    /// Ready with `Ok` when there is a message.
    fn poll_message(&self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        loop {
            ready!(self.0.poll_recv_ready(cx))?;
            match self.0.try_io(Interest::READABLE, || peek(&self.0)) {
                Err(error) if is_nothing_now(&error) => {}
                peeked => return Poll::Ready(peeked),
            }
        }
    }
}

fn peek(socket: &impl AsFd) -> io::Result<()> {
    SockRef::from(socket).peek(&mut [MaybeUninit::uninit(); 1]).map(|_len| ())
}

impl<T: AsFd> Watched<T> {
    pub(crate) fn new(socket: T) -> Self {
        Self { socket: Arc::new(socket), watcher: None, seen: None }
    }

    /// The socket itself, for another thread that must not wait for this one.
    pub(crate) fn share(&self) -> Arc<T> {
        Arc::clone(&self.socket)
    }

    pub(crate) fn get(&self) -> &T {
        &self.socket
    }

    /// Read with `read`; `None` if there is nothing now.
    pub(crate) fn try_read<R>(&mut self, read: impl FnOnce(&T) -> io::Result<R>) -> io::Result<Option<R>> {
        if let Some(error) = self.seen.take() {
            return Err(error);
        }
        match read(&self.socket) {
            Ok(value) => Ok(Some(value)),
            Err(error) if is_nothing_now(&error) => Ok(None),
            Err(error) => Err(error),
        }
    }

    /// Ready when a read will give something (a message or an error); else the task is woken later.
    ///
    /// Must be called within a tokio runtime that has I/O enabled.
    pub(crate) fn poll_readable(&mut self, cx: &mut Context<'_>) -> Poll<()> {
        if self.seen.is_some() {
            return Poll::Ready(());
        }
        if let Err(error) = ready!(self.poll_message(cx)) {
            self.seen = Some(error);
        }
        Poll::Ready(())
    }

    fn poll_message(&mut self, cx: &mut Context<'_>) -> Poll<io::Result<()>> {
        let watcher = match self.watcher.take() {
            Some(watcher) => watcher,
            None => Watcher::new(&self.socket)?,
        };
        self.watcher.insert(watcher).poll_message(cx)
    }
}
