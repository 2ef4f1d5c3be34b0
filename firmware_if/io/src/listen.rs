//! Listening for connections: the live view's web server.

use crate::OpenError;
use crate::errno::{EACCES, EADDRINUSE, EADDRNOTAVAIL};
use std::io;
use std::net::SocketAddr;
use tokio::net::TcpListener;

/// Listen for TCP connections at `address`; port 0 lets the system choose one. Needs tokio's runtime.
///
/// # Errors
/// [`OpenError`] with what to do, if the address is not this computer's or its port is taken.
pub async fn listen(address: SocketAddr) -> Result<TcpListener, OpenError> {
    TcpListener::bind(address).await.map_err(|error| refused(address, &error))
}

fn refused(address: SocketAddr, error: &io::Error) -> OpenError {
    let (why, advice) = match error.raw_os_error() {
        Some(EADDRINUSE) => ("the port is taken".to_owned(), "choose another port, or end what listens there"),
        Some(EADDRNOTAVAIL) => (
            "this computer has no such address".to_owned(),
            "use 127.0.0.1 for this computer alone, or an address that `ip address` lists",
        ),
        Some(EACCES) => (error.to_string(), "use a port from 1024 on: those below need the right to bind them"),
        _ => (error.to_string(), "check the address"),
    };
    OpenError::new(format!("http://{address}"), why, advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_port_that_is_taken_is_refused_with_what_to_do() {
        let first = listen(SocketAddr::from(([127, 0, 0, 1], 0))).await.unwrap();
        let taken = first.local_addr().unwrap();
        let error = listen(taken).await.unwrap_err();
        assert_eq!(error.address, format!("http://{taken}"));
        assert_eq!(error.why, "the port is taken");
        assert!(error.advice.contains("another port"));
    }

    #[tokio::test]
    async fn an_address_of_somebody_else_is_refused() {
        // TEST-NET-1 (RFC 5737): nobody has it.
        let error = listen(SocketAddr::from(([192, 0, 2, 1], 0))).await.unwrap_err();
        assert!(error.why.contains("no such address"));
    }
}
