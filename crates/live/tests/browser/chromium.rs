//! A headless Chromium, driven by its DevTools protocol.

use std::io::{BufRead, BufReader};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket};

/// Usual names of its program.
const NAMES: [&str; 6] = [
    "chromium",
    "chromium-browser",
    "chromium-headless-shell",
    "chrome-headless-shell",
    "google-chrome",
    "google-chrome-stable",
];

/// No window, no sandbox, which root cannot have, and nothing that asks the network.
const FLAGS: [&str; 8] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

pub(crate) struct Chromium {
    process: Child,
    socket: WebSocket<TcpStream>,
    session: Value,
    asked: u64,
    complaints: Vec<String>,
    /// Deleted on drop.
    _profile: TempDir,
}

impl Chromium {
    pub(crate) fn start() -> Option<Self> {
        let named = std::env::var("EVPOSE_CHROMIUM").ok();
        let names = named.as_deref().into_iter().chain(NAMES);
        let profile = tempfile::tempdir().unwrap();
        let mut process = names
            .filter_map(|name| {
                Command::new(name)
                    .args(FLAGS)
                    .args(["--remote-debugging-port=0", "--window-size=1440,900"])
                    .arg(format!("--user-data-dir={}", profile.path().display()))
                    .arg("about:blank")
                    .stdin(Stdio::null())
                    .stdout(Stdio::null())
                    .stderr(Stdio::piped())
                    .spawn()
                    .ok()
            })
            .next()?;
        let mut said = BufReader::new(process.stderr.take().unwrap());
        let mut address = String::new();
        while !address.starts_with("DevTools listening on ") {
            address.clear();
            assert!(said.read_line(&mut address).unwrap() > 0, "Chromium ended at once");
        }
        // It goes on talking to somebody who listens.
        std::thread::spawn(move || std::io::copy(&mut said, &mut std::io::sink()));
        let address = address.trim_start_matches("DevTools listening on ").trim().to_owned();
        let host = address.trim_start_matches("ws://").split('/').next().unwrap();
        let stream = TcpStream::connect(host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        let (socket, _) = tungstenite::client(address.as_str(), stream).unwrap();
        let mut browser = Self {
            process,
            socket,
            session: Value::Null,
            asked: 0,
            complaints: Vec::new(),
            _profile: profile,
        };
        let tab = browser.call("Target.createTarget", &json!({ "url": "about:blank" }));
        let to_tab = json!({ "targetId": tab["targetId"], "flatten": true });
        browser.session = browser.call("Target.attachToTarget", &to_tab)["sessionId"].clone();
        browser.call("Runtime.enable", &json!({}));
        Some(browser)
    }

    pub(crate) fn open(&mut self, address: &str) {
        self.call("Page.navigate", &json!({ "url": address }));
    }

    /// The value of a piece of JavaScript; nothing where it fails, as before the page is there.
    pub(crate) fn says(&mut self, expression: &str) -> Value {
        let question = json!({ "expression": expression, "returnByValue": true });
        self.call("Runtime.evaluate", &question)["result"]["value"].take()
    }

    pub(crate) fn screenshot(&mut self) -> Vec<u8> {
        let taken = self.call("Page.captureScreenshot", &json!({ "format": "png" }));
        STANDARD.decode(taken["data"].as_str().unwrap()).unwrap()
    }

    /// Errors of the page that nobody caught.
    pub(crate) fn complaints(&self) -> Vec<String> {
        self.complaints.clone()
    }

    fn call(&mut self, method: &str, params: &Value) -> Value {
        self.asked += 1;
        let mut question = json!({ "id": self.asked, "method": method, "params": params });
        if !self.session.is_null() {
            question["sessionId"] = self.session.clone();
        }
        self.socket.send(Message::text(question.to_string())).unwrap();
        loop {
            let Message::Text(text) = self.socket.read().unwrap() else { continue };
            let mut answer: Value = serde_json::from_str(&text).unwrap();
            if answer["method"] == "Runtime.exceptionThrown" {
                self.complaints.push(answer["params"].to_string());
            }
            // Events of the page arrive in between: only our own answer ends the wait.
            if answer["id"] == self.asked {
                return answer["result"].take();
            }
        }
    }
}

impl Drop for Chromium {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}
