//! Who may look and ask.
//!
//! A browser lets any website send requests to this computer. Two things keep them out: the name in `Host` must be this
//! server's own (a site that points its name at 127.0.0.1 still sends its own name), and a WebSocket's `Origin`, which
//! a page cannot forge, must be that host. Beyond loopback names say nothing: there a token in the address is asked
//! for.

use axum::http::header::{HOST, ORIGIN};
use axum::http::{HeaderMap, Uri};
use drover_io::OpenError;
use rand::TryRngCore;
use rand::rngs::OsRng;
use std::fmt::Write;
use std::hint::black_box;
use std::net::{IpAddr, SocketAddr};

/// A token shorter than this could be guessed.
const TOKEN_CHARACTERS_MIN: usize = 8;

/// Who may look and ask.
pub(crate) struct Access {
    /// The hosts that requests may name; empty: any.
    hosts: Vec<String>,
    token: Option<String>,
}

/// Why a request is turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Denied {
    Host,
    Origin,
    Token,
}

impl Denied {
    /// What to do, in words for whoever asked.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Host => "This is not the name of this server. Use the address that drover printed when it started.\n",
            Self::Origin => "Another website asked for this. Open the address that drover printed when it started.\n",
            Self::Token => {
                "A token is missing or wrong. Use the whole address that drover printed when it started: it ends in \
                 ?token=...\n"
            }
        }
    }
}

impl Access {
    /// Access to a server at `address` with the token that the caller chose, or one made up where one is needed.
    ///
    /// # Errors
    /// [`OpenError`] if the token is unfit, or none can be made.
    pub(crate) fn new(address: SocketAddr, chosen: Option<String>) -> Result<Self, OpenError> {
        let token = match chosen {
            Some(token) => Some(fit(address, token)?),
            None if address.ip().is_loopback() => None,
            None => Some(made_up(address)?),
        };
        let hosts = if address.ip().is_loopback() { own_names(address) } else { Vec::new() };
        Ok(Self { hosts, token })
    }

    /// The address to open in a browser on this computer.
    pub(crate) fn url(&self, address: SocketAddr) -> String {
        let ip = match address.ip() {
            IpAddr::V4(ip) if ip.is_unspecified() => IpAddr::from([127, 0, 0, 1]),
            IpAddr::V6(ip) if ip.is_unspecified() => IpAddr::from([0, 0, 0, 0, 0, 0, 0, 1]),
            ip => ip,
        };
        let query = self.token.as_ref().map_or_else(String::new, |token| format!("?token={token}"));
        format!("http://{}/{query}", SocketAddr::new(ip, address.port()))
    }

    /// The host named is this server.
    pub(crate) fn check_host(&self, headers: &HeaderMap) -> Result<(), Denied> {
        let host = headers.get(HOST).and_then(|host| host.to_str().ok()).ok_or(Denied::Host)?;
        let is_own = self.hosts.is_empty() || self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if is_own { Ok(()) } else { Err(Denied::Host) }
    }

    /// What asks is a page of this server, or no page at all.
    pub(crate) fn check_origin(&self, headers: &HeaderMap) -> Result<(), Denied> {
        let Some(origin) = headers.get(ORIGIN) else { return Ok(()) };
        let host = headers.get(HOST).and_then(|host| host.to_str().ok()).ok_or(Denied::Origin)?;
        let origin = origin.to_str().map_err(|_| Denied::Origin)?;
        // https: somebody may have put a server with a certificate in front of this one.
        let site = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
        if site.is_some_and(|site| site.eq_ignore_ascii_case(host)) { Ok(()) } else { Err(Denied::Origin) }
    }

    /// The address has the token, if one is asked for.
    pub(crate) fn check_token(&self, uri: &Uri) -> Result<(), Denied> {
        let Some(token) = &self.token else { return Ok(()) };
        let parts = uri.query().unwrap_or_default().split('&');
        let given = parts.filter_map(|part| part.strip_prefix("token=")).next().unwrap_or_default();
        if is_same(given.as_bytes(), token.as_bytes()) { Ok(()) } else { Err(Denied::Token) }
    }
}

/// What a request to this loopback address may call it.
fn own_names(address: SocketAddr) -> Vec<String> {
    let port = address.port();
    let ip = match address.ip() {
        IpAddr::V4(ip) => ip.to_string(),
        IpAddr::V6(ip) => format!("[{ip}]"),
    };
    let names = [ip, "127.0.0.1".to_owned(), "localhost".to_owned(), "[::1]".to_owned()];
    let with_port = names.iter().map(|name| format!("{name}:{port}"));
    let bare = names.iter().filter(|_| port == 80).cloned();
    with_port.chain(bare).collect()
}

fn fit(address: SocketAddr, token: String) -> Result<String, OpenError> {
    let plain = token.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.' | b'~'));
    if plain && token.len() >= TOKEN_CHARACTERS_MIN {
        return Ok(token);
    }
    let advice = format!("use at least {TOKEN_CHARACTERS_MIN} letters, digits, '-', '_', '.' or '~'");
    Err(OpenError::new(format!("http://{address}"), "the token is unfit for an address", advice))
}

/// 128 random bits, in hexadecimal digits.
fn made_up(address: SocketAddr) -> Result<String, OpenError> {
    let mut bits = [0_u8; 16];
    OsRng.try_fill_bytes(&mut bits).map_err(|error| {
        OpenError::new(format!("http://{address}"), format!("no random token: {error}"), "choose a token yourself")
    })?;
    Ok(bits.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    }))
}

/// Equal, found out in a time that depends on the lengths alone.
fn is_same(one: &[u8], other: &[u8]) -> bool {
    let differing = one.iter().zip(other).fold(0, |all, (a, b)| black_box(all | (a ^ b)));
    one.len() == other.len() && differing == 0
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOOPBACK: SocketAddr = SocketAddr::new(IpAddr::V4(std::net::Ipv4Addr::LOCALHOST), 8123);
    const EVERYWHERE: SocketAddr = SocketAddr::new(IpAddr::V4(std::net::Ipv4Addr::UNSPECIFIED), 8123);

    fn headers(host: &str, origin: Option<&str>) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(HOST, host.parse().unwrap());
        if let Some(origin) = origin {
            headers.insert(ORIGIN, origin.parse().unwrap());
        }
        headers
    }

    #[test]
    fn on_loopback_only_its_own_names_are_answered() {
        let access = Access::new(LOOPBACK, None).unwrap();
        for host in ["127.0.0.1:8123", "localhost:8123", "LOCALHOST:8123", "[::1]:8123"] {
            assert_eq!(access.check_host(&headers(host, None)), Ok(()), "{host}");
        }
        for host in ["evil.example:8123", "127.0.0.1", "127.0.0.1:80", "localhost.evil.example:8123", ""] {
            assert_eq!(access.check_host(&headers(host, None)), Err(Denied::Host), "{host}");
        }
        assert_eq!(access.check_host(&HeaderMap::new()), Err(Denied::Host));
    }

    #[test]
    fn only_pages_of_the_same_host_may_ask() {
        let access = Access::new(LOOPBACK, None).unwrap();
        let from = |origin| access.check_origin(&headers("localhost:8123", origin));
        assert_eq!(from(None), Ok(()));
        assert_eq!(from(Some("http://localhost:8123")), Ok(()));
        for origin in ["http://evil.example", "http://localhost", "null", "", "http://localhost:8123.evil.example"] {
            assert_eq!(from(Some(origin)), Err(Denied::Origin), "{origin}");
        }
    }

    #[test]
    fn beyond_loopback_a_token_of_128_bits_is_made_up() {
        let access = Access::new(EVERYWHERE, None).unwrap();
        let url = access.url(EVERYWHERE);
        let token = url.strip_prefix("http://127.0.0.1:8123/?token=").unwrap();
        assert_eq!(token.len(), 32);
        assert_eq!(access.check_token(&format!("/?token={token}").parse().unwrap()), Ok(()));
        for uri in ["/", "/?token=", "/?token=0", &format!("/?token={token}0"), &format!("/?broken={token}")] {
            assert_eq!(access.check_token(&uri.parse().unwrap()), Err(Denied::Token), "{uri}");
        }
        assert_ne!(Access::new(EVERYWHERE, None).unwrap().token, access.token);
    }

    #[test]
    fn a_token_that_is_short_or_does_not_fit_an_address_is_refused() {
        for token in ["", "short", "with space 123", "ampersand&123"] {
            assert!(Access::new(LOOPBACK, Some(token.to_owned())).is_err(), "{token}");
        }
    }
}
