//! Who may come in: whoever has the token, by a name of this server, from its own page.

use axum::http::{HeaderMap, header};
use std::net::IpAddr;

/// Bytes of a token: 128 bits, which nobody guesses.
const TOKEN_BYTES: usize = 16;

/// The token, and the names of the server.
pub(crate) struct Guard {
    token: String,
    address: IpAddr,
}

impl Guard {
    /// With this token, or with a new one.
    ///
    /// # Errors
    ///
    /// Where the system has no random numbers.
    pub(crate) fn new(address: IpAddr, token: Option<&str>) -> Result<Guard, getrandom::Error> {
        let is_digit = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        let is_token = |text: &&str| text.len() == 2 * TOKEN_BYTES && text.bytes().all(is_digit);
        if let Some(token) = token.filter(is_token) {
            return Ok(Guard { token: token.to_owned(), address });
        }
        let mut bytes = [0; TOKEN_BYTES];
        getrandom::fill(&mut bytes)?;
        let token = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(Guard { token, address })
    }

    pub(crate) fn token(&self) -> &str {
        &self.token
    }

    /// Whether a text is the token; it takes as long whichever part of it is right.
    pub(crate) fn is_token(&self, text: &str) -> bool {
        let (own, given) = (self.token.as_bytes(), text.as_bytes());
        own.len() == given.len() && own.iter().zip(given).fold(0, |all, (a, b)| all | (a ^ b)) == 0
    }

    /// Whether the server is called by a name of its own. A foreign name that leads here is one that a foreign page has made
    /// to lead here. The port may be another: that of a tunnel.
    pub(crate) fn check_host(&self, headers: &HeaderMap) -> bool {
        let Some(host) = text(headers, header::HOST).map(host_of) else { return false };
        let host = host.trim_start_matches('[').trim_end_matches(']');
        let is_local = host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback());
        // Who listens on all addresses is called by any of them, but not by a name.
        let is_address =
            host.parse::<IpAddr>().is_ok_and(|ip| ip == self.address || self.address.is_unspecified());
        is_local || is_address
    }

    /// The cookie that stands for the token. Its name has the port: cookies do not tell ports apart, and several viewers may run.
    pub(crate) fn cookie(&self, headers: &HeaderMap) -> String {
        let name = cookie_name(headers);
        format!("{name}={}; Path=/; SameSite=Strict; HttpOnly", self.token)
    }

    /// Whether a request has the cookie.
    pub(crate) fn is_known(&self, headers: &HeaderMap) -> bool {
        let name = cookie_name(headers);
        let mut cookies = headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok());
        cookies.any(|cookies| {
            let mut pairs = cookies.split(';').filter_map(|pair| pair.trim().split_once('='));
            pairs.any(|(given, value)| given == name && self.is_token(value))
        })
    }

    /// Whether a request comes from the page of this server.
    pub(crate) fn is_own_page(&self, headers: &HeaderMap) -> bool {
        match (text(headers, header::ORIGIN), text(headers, header::HOST)) {
            (Some(origin), Some(host)) => origin.strip_prefix("http://") == Some(host),
            _ => false,
        }
    }
}

fn text(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    headers.get(name)?.to_str().ok()
}

/// A `Host` without its port.
fn host_of(host: &str) -> &str {
    match host.rsplit_once(':') {
        // An IPv6 address without a port ends in a bracket.
        Some((name, port)) if !port.ends_with(']') => name,
        _ => host,
    }
}

fn cookie_name(headers: &HeaderMap) -> String {
    let port =
        text(headers, header::HOST).and_then(|host| host.rsplit_once(':')).map_or("80", |(_, port)| port);
    let port: String = port.chars().filter(char::is_ascii_digit).collect();
    format!("eosphor-{port}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;

    fn headers(pairs: &[(header::HeaderName, &'static str)]) -> HeaderMap {
        pairs.iter().map(|(name, value)| (name.clone(), HeaderValue::from_static(value))).collect()
    }

    #[test]
    fn names_of_the_server() {
        let local = Guard::new(IpAddr::from([127, 0, 0, 1]), None).unwrap();
        let others = Guard::new(IpAddr::from([0, 0, 0, 0]), None).unwrap();
        for host in ["127.0.0.1:8000", "localhost:81", "localhost", "[::1]:8000", "127.1.2.3"] {
            assert!(local.check_host(&headers(&[(header::HOST, host)])), "{host}");
            assert!(others.check_host(&headers(&[(header::HOST, host)])), "{host}");
        }
        for host in ["evil.example", "localhost.evil.example:8000", "127.0.0.1.evil.example", ""] {
            assert!(!local.check_host(&headers(&[(header::HOST, host)])), "{host}");
            assert!(!others.check_host(&headers(&[(header::HOST, host)])), "{host}");
        }
        let foreign = headers(&[(header::HOST, "10.0.0.7:8000")]);
        assert!(!local.check_host(&foreign) && others.check_host(&foreign));
        assert!(!local.check_host(&HeaderMap::new()));
    }

    #[test]
    fn tokens_cookies_and_origins() {
        let guard = Guard::new(IpAddr::from([127, 0, 0, 1]), None).unwrap();
        let other = Guard::new(IpAddr::from([127, 0, 0, 1]), None).unwrap();
        assert_eq!(guard.token().len(), 32);
        let again = |token: &str| Guard::new(IpAddr::from([127, 0, 0, 1]), Some(token)).unwrap();
        assert_eq!(again(guard.token()).token(), guard.token());
        for wrong in ["", "0", &guard.token()[1..], &"x".repeat(32), &"A".repeat(32)] {
            assert!(again(wrong).token() != wrong && again(wrong).token().len() == 32);
        }
        assert!(guard.is_token(guard.token()) && !guard.is_token(other.token()) && !guard.is_token(""));
        let mut asked = headers(&[(header::HOST, "localhost:8000")]);
        assert!(!guard.is_known(&asked));
        let cookie = guard.cookie(&asked);
        let pair = cookie.split(';').next().unwrap();
        asked.insert(header::COOKIE, HeaderValue::from_str(&format!("a=b; {pair}")).unwrap());
        assert!(guard.is_known(&asked) && !other.is_known(&asked));
        assert!(!guard.is_own_page(&asked));
        asked.insert(header::ORIGIN, HeaderValue::from_static("http://localhost:8000"));
        assert!(guard.is_own_page(&asked));
        for origin in ["http://localhost:8001", "https://localhost:8000", "null", "http://evil.example"] {
            asked.insert(header::ORIGIN, HeaderValue::from_static(origin));
            assert!(!guard.is_own_page(&asked), "{origin}");
        }
    }
}
