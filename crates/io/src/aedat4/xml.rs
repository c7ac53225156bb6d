//! The XML of a header: nodes in nodes, and attributes with a text each.
//!
//! Only what DV and jAER write is understood: `<node name="…">`, and in it
//! `<attr key="…" type="…">text</attr>`. Everything else is skipped.

use std::borrow::Cow;

/// Bytes of the longest name of a letter: `#x10FFFF`, and some zeros to spare.
const LONGEST_NAME: usize = 16;
/// Nodes in nodes; DV's are five deep. Beyond, it is no header of a recording.
const DEEPEST: usize = 64;

/// Calls `found` with the names of the nodes around an attribute, its key and its text, for each.
/// Stops where the text is no XML, or nodes are deeper than those of a header.
pub(super) fn attributes(text: &str, mut found: impl FnMut(&[Cow<'_, str>], &str, &str)) {
    let mut nodes = Vec::new();
    let mut rest = text;
    while let Some((_, tag)) = rest.split_once('<') {
        // Comments may hold brackets.
        if let Some(comment) = tag.strip_prefix("!--") {
            let Some((_, behind)) = comment.split_once("-->") else { return };
            rest = behind;
            continue;
        }
        // Without its end, the tag is cut.
        let Some((tag, behind)) = tag.split_once('>') else { return };
        rest = behind;
        if tag.starts_with("node") && !tag.ends_with('/') {
            // A hostile header would otherwise take memory for each opening tag.
            if nodes.len() == DEEPEST {
                return;
            }
            nodes.push(value(tag, "name").map(plain).unwrap_or_default());
        } else if tag.starts_with("/node") {
            nodes.pop();
        } else if tag.starts_with("attr") {
            // The text lasts until the next tag, whichever that is.
            let text = rest.split_once('<').map_or(rest, |(text, _)| text);
            if let Some(key) = value(tag, "key") {
                found(&nodes, &plain(key), &plain(text.trim()));
            }
        }
    }
}

/// The quoted value behind `name=`.
fn value<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let mut rest = tag;
    loop {
        let (before, behind) = rest.split_once('=')?;
        let behind = behind.trim_start();
        let quote = behind.chars().next().filter(|c| matches!(c, '"' | '\''))?;
        let (text, behind) = behind[1..].split_once(quote)?;
        if before.trim_end().ends_with(name) {
            return Some(text);
        }
        rest = behind;
    }
}

/// The text that an escaped one stands for.
fn plain(text: &str) -> Cow<'_, str> {
    if !text.contains('&') {
        return text.into();
    }
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('&') {
        out.push_str(before);
        // No name is longer: without an end, every `&` would be followed to the end of the text.
        let near = behind.bytes().take(LONGEST_NAME + 1).position(|byte| byte == b';');
        // An entity without an end, or of an unknown name, stays as it is.
        let found = near.and_then(|end| {
            let (name, behind) = (&behind[..end], &behind[end + 1..]);
            let letter = match name {
                "lt" => '<',
                "gt" => '>',
                "amp" => '&',
                "quot" => '"',
                "apos" => '\'',
                _ => {
                    let number = name.strip_prefix('#')?;
                    let code = match number.strip_prefix('x') {
                        Some(hex) => u32::from_str_radix(hex, 16).ok()?,
                        None => number.parse().ok()?,
                    };
                    char::from_u32(code)?
                }
            };
            Some((letter, behind))
        });
        let (letter, behind) = found.unwrap_or(('&', behind));
        out.push(letter);
        rest = behind;
    }
    (out + rest).into()
}

/// The same text with nothing in it that means something to XML.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            '"' => out.push_str("&quot;"),
            // Readers normalise plain line breaks in attributes to spaces.
            letter if letter.is_control() => out.push_str(&format!("&#{};", u32::from(letter))),
            letter => out.push(letter),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn all(text: &str) -> Vec<String> {
        let mut out = Vec::new();
        attributes(text, |nodes, key, text| {
            out.push(format!("{}:{key}={text}", nodes.join("/")));
        });
        out
    }

    #[test]
    fn attributes_come_with_the_nodes_around_them() {
        let text = "<?xml version='1.0'?><dv version=\"2.0\"><!-- <node name=\"no\"> -->\
            <node path=\"/a/\" name = 'a'><attr key=\"k\" type=\"int\"> 7 </attr>\
            <node name=\"leaf\"/><node name=\"b\"><attr type=\"string\" key=\"s\">x &lt;&#65;&amp;\
            </attr></node><attr key=\"last\"></attr></node></dv>";
        assert_eq!(all(text), ["a:k=7", "a/b:s=x <A&", "a:last="]);
    }

    #[test]
    fn what_is_no_xml_ends_it() {
        for text in
            ["", "<", "<node", "</node></node><attr key=\"k\">", "<attr key=>", "<attr =\"\">"]
        {
            assert!(all(text).len() <= 1, "{text}");
        }
    }

    #[test]
    fn what_would_take_for_ever_does_not() {
        // Of names without an end, and of nodes that are all looked through for every attribute.
        let text = "&".repeat(1 << 20);
        assert_eq!(plain(&text), text);
        let deep = "<node name=\"a\">".repeat(1000) + "<attr key=\"k\">1</attr>";
        assert!(all(&deep).is_empty());
    }

    proptest! {
        #[test]
        fn any_text_survives_escaping(text in any::<String>()) {
            let escaped = escaped(&text);
            prop_assert_eq!(plain(&escaped), text);
        }

        #[test]
        fn random_tags_never_panic(
            parts in prop::collection::vec(
                prop::sample::select(vec![
                    "<", ">", "/", "node", "attr", " name=", " key=", "\"", "'", "=", "é", "&", ";",
                    "#x", "!--", "-->",
                ]),
                0..40,
            ),
        ) {
            all(&parts.concat());
        }
    }
}
