//! Checks of the `Host` and `Origin` headers.

use std::net::{IpAddr, Ipv6Addr};

/// Whether a request comes from our own page. Programs other than browsers send no origin, and
/// could forge any.
pub(super) fn is_ours(host: &str, origin: Option<&str>) -> bool {
    let Some(origin) = origin else { return true };
    let site = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    site.is_some_and(|site| site.eq_ignore_ascii_case(host))
}

/// The name or address of a `Host` header, in lower case, without its port; none if it is not of the form
/// `NAME`, `NAME:PORT`, `[ADDRESS]` or `[ADDRESS]:PORT`.
pub(super) fn name_of(host: &str) -> Option<String> {
    let (name, port) = match host.strip_prefix('[') {
        Some(rest) => {
            let (address, rest) = rest.split_once(']')?;
            // Only an address may stand in brackets: a name in them would pass all other checks.
            address.parse::<Ipv6Addr>().ok()?;
            (address, if rest.is_empty() { None } else { Some(rest.strip_prefix(':')?) })
        }
        None => {
            let (name, port) = host.split_once(':').map_or((host, None), |(n, p)| (n, Some(p)));
            let is_of_names = |b: u8| b.is_ascii_alphanumeric() || matches!(b, b'-' | b'_' | b'.');
            if !name.bytes().all(is_of_names) {
                return None;
            }
            (name, port)
        }
    };
    // Digits alone: Rust's own integers may begin with a sign.
    let is_port =
        |port: &str| port.bytes().all(|b| b.is_ascii_digit()) && port.parse::<u16>().is_ok();
    // `localhost.` is the same name, fully qualified.
    let name = name.strip_suffix('.').unwrap_or(name).to_ascii_lowercase();
    (!name.is_empty() && port.is_none_or(is_port)).then_some(name)
}

/// Whether a page is served under a name of [`name_of`]. Names that are not stated could be pointed here by their
/// owner (DNS rebinding), addresses could not.
pub(super) fn is_known(name: &str, is_local: bool, stated: &[String]) -> bool {
    let is_address = |address: IpAddr| !is_local || address.is_loopback();
    name == "localhost"
        || name.ends_with(".localhost")
        || name.parse().is_ok_and(is_address)
        || stated.iter().any(|stated| stated.eq_ignore_ascii_case(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_of_the_same_host_are_ours() {
        assert!(is_ours("127.0.0.1:8000", None));
        assert!(is_ours("127.0.0.1:8000", Some("http://127.0.0.1:8000")));
        assert!(is_ours("Camera.local", Some("https://camera.local")));
        for other in ["http://example.org", "http://127.0.0.1:8001", "null", "", "127.0.0.1:8000"] {
            assert!(!is_ours("127.0.0.1:8000", Some(other)), "{other}");
        }
    }

    #[test]
    fn names_of_this_machine() {
        let is_own = |host: &str| name_of(host).is_some_and(|name| is_known(&name, true, &[]));
        let own = ["localhost", "LocalHost:80", "a.localhost:1", "127.0.0.1:80", "127.9.9.9"];
        for host in own.into_iter().chain(["[::1]", "[::1]:80", "localhost."]) {
            assert!(is_own(host), "{host}");
        }
        for host in ["example.org", "10.0.0.1:80", "localhost.example.org", "[fe80::1]"] {
            assert!(!is_own(host) && name_of(host).is_some(), "{host}");
        }
    }

    #[test]
    fn other_machines_ask_by_address_or_by_a_stated_name() {
        let stated = ["Camera.local".to_owned()];
        for host in ["10.0.0.1:80", "[fe80::1]:80", "camera.local:8765", "localhost"] {
            assert!(is_known(&name_of(host).expect(host), false, &stated), "{host}");
        }
        for host in ["evil.com", "camera.local.evil.com", "10.0.0.1.evil.com"] {
            assert!(!is_known(&name_of(host).expect(host), false, &stated), "{host}");
        }
    }

    #[test]
    fn what_is_no_host_is_refused() {
        let wrong = [
            "",
            ".",
            ":80",
            "[::1",
            "[::1].evil.com",
            "[::1]evil.com",
            "[localhost]",
            "localhost:80@evil.com",
            "localhost:80:80",
            "user@localhost",
            "localhost:+80",
            "localhost:65536",
            "localhost/evil.com",
            "localhost evil.com",
            "::1",
        ];
        for host in wrong {
            assert_eq!(name_of(host), None, "{host}");
        }
    }
}
