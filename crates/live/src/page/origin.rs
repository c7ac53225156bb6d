//! Checks of the `Host` and `Origin` headers.

use std::net::IpAddr;

/// Whether a request comes from our own page. Programs other than browsers send no origin, and
/// could forge any.
pub(super) fn is_ours(host: &str, origin: Option<&str>) -> bool {
    let Some(origin) = origin else { return true };
    let site = origin.strip_prefix("http://").or_else(|| origin.strip_prefix("https://"));
    site.is_some_and(|site| site.eq_ignore_ascii_case(host))
}

/// Whether `host`, with or without a port, is a loopback name. Any other name could be pointed here
/// by its owner (DNS rebinding).
pub(super) fn is_this_machine(host: &str) -> bool {
    let name = match host.strip_prefix('[').and_then(|rest| rest.split_once(']')) {
        Some((address, _)) => address,
        None => host.split_once(':').map_or(host, |(name, _)| name),
    };
    // `localhost.` is the same name, fully qualified.
    let name = name.trim_end_matches('.').to_ascii_lowercase();
    name == "localhost"
        || name.ends_with(".localhost")
        || name.parse::<IpAddr>().is_ok_and(|address| address.is_loopback())
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
        let own = ["localhost", "LocalHost:80", "a.localhost:1", "127.0.0.1:80", "127.9.9.9"];
        for host in own.into_iter().chain(["[::1]", "[::1]:80", "localhost."]) {
            assert!(is_this_machine(host), "{host}");
        }
        for host in ["example.org", "10.0.0.1:80", "localhost.example.org", "", "[fe80::1]", "[::1"]
        {
            assert!(!is_this_machine(host), "{host}");
        }
    }
}
