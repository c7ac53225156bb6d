//! One self-contained HTML page: no script from elsewhere, no file beside it.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

const STYLE: &str = "
:root{--ink:#1d2430;--soft:#5d6675;--line:#e2e4ea;--paper:#fcfcfd}
*{box-sizing:border-box}
body{font:15px/1.55 system-ui,sans-serif;color:var(--ink);background:var(--paper);margin:0}
main{max-width:1180px;margin:0 auto;padding:28px 24px 60px}
h1{font-size:26px;margin:0 0 4px}h2{font-size:19px;margin:36px 0 8px}
p{margin:6px 0 10px;max-width:76ch}.soft{color:var(--soft)}
table{border-collapse:collapse;margin:10px 0}
th,td{padding:5px 14px 5px 0;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
th:first-child,td:first-child{text-align:left}td small{color:var(--soft)}
.plots{display:flex;flex-wrap:wrap;gap:14px}
.wide{overflow-x:auto}.words{display:inline-block;white-space:normal;max-width:34ch;text-align:left}
.plots svg{border:1px solid var(--line);background:#fff;max-width:100%;height:auto}
img{max-width:100%;border:1px solid var(--line);image-rendering:pixelated}
figure{margin:12px 0}figcaption{color:var(--soft);font-size:13px;margin-top:4px}
.key{display:inline-block;width:22px;height:4px;border-radius:2px;vertical-align:middle;margin:0 5px 0 12px}
pre{background:#f2f3f6;padding:12px;overflow:auto;font-size:12.5px}
";

/// A page put together from top to bottom.
pub struct HtmlPage {
    title: String,
    body: String,
}

/// Text as it may stand in HTML.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

impl HtmlPage {
    /// An empty page.
    pub fn new(title: &str, subtitle: &str) -> Self {
        let body =
            format!("<h1>{}</h1>\n<p class=\"soft\">{}</p>\n", escape(title), escape(subtitle));
        Self { title: title.to_owned(), body }
    }

    /// A heading and a paragraph of plain text below it.
    pub fn section(&mut self, heading: &str, text: &str) {
        self.body += &format!("<h2>{}</h2>\n<p>{}</p>\n", escape(heading), escape(text));
    }

    /// A table; cells may hold markup.
    pub fn table(&mut self, header: &[&str], rows: &[Vec<String>]) {
        self.body += "<div class=\"wide\"><table><tr>";
        for cell in header {
            self.body += &format!("<th>{}</th>", escape(cell));
        }
        self.body += "</tr>\n";
        for row in rows {
            let cells: String = row.iter().map(|cell| format!("<td>{cell}</td>")).collect();
            self.body += &format!("<tr>{cells}</tr>\n");
        }
        self.body += "</table></div>\n";
    }

    /// Plots side by side.
    pub fn plots(&mut self, svgs: &[String]) {
        self.body += &format!("<div class=\"plots\">{}</div>\n", svgs.join("\n"));
    }

    /// An embedded image; `kind` is its MIME type. The caption may hold markup.
    pub fn image(&mut self, kind: &str, bytes: &[u8], alt: &str, caption: &str) {
        let _ = writeln!(
            self.body,
            "<figure><img alt=\"{}\" src=\"data:{kind};base64,{}\"><figcaption>{caption}\
             </figcaption></figure>",
            escape(alt),
            STANDARD.encode(bytes)
        );
    }

    /// Markup as it is.
    pub fn markup(&mut self, markup: &str) {
        self.body += markup;
        self.body.push('\n');
    }

    /// Text as typed, behind a fold.
    pub fn details(&mut self, summary: &str, text: &str) {
        self.body += &format!(
            "<details><summary>{}</summary><pre>{}</pre></details>\n",
            escape(summary),
            escape(text)
        );
    }

    /// The page as HTML.
    pub fn finish(self) -> String {
        format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\
             <title>{}</title><style>{STYLE}</style></head>\n<body><main>\n{}</main></body></html>\n",
            escape(&self.title),
            self.body
        )
    }
}
