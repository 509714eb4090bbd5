//! Names that come from people and files, made harmless for the medium they are written to: one function for each
//! medium.
//!
//! A name can hold control sequences for a terminal (`ESC [ 2 J` clears it), formulas for a spreadsheet
//! (`=HYPERLINK(…)`), and code for a page or a typesetter. Such characters become visible, as Rust writes them:
//! `\u{1b}`.

use std::borrow::Cow;
use std::fmt::Write;

/// Whether a character is invisible and no part of words: control characters (C0, DEL, C1), line and paragraph
/// separators, and marks that change the direction of text.
fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{2028}' | '\u{2029}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Makes hidden characters visible, except those that `keep` accepts.
fn visible(text: &str, keep: impl Fn(char) -> bool) -> Cow<'_, str> {
    let hide = |c: char| is_hidden(c) && !keep(c);
    if !text.contains(hide) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if hide(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    Cow::Owned(out)
}

/// For a terminal: text of several lines, whose line feeds and tabs stay.
pub fn terminal(text: &str) -> Cow<'_, str> {
    visible(text, |c| matches!(c, '\n' | '\t'))
}

/// For a terminal: one line. Line feeds become visible too, so that a name cannot begin a second line.
pub fn line(text: &str) -> Cow<'_, str> {
    visible(text, |_| false)
}

/// For a terminal: a JSON text. Hidden characters become JSON escapes, so that strings keep their meaning; `serde_json`
/// by itself escapes only C0.
pub fn json(text: &str) -> Cow<'_, str> {
    let hide = |c: char| is_hidden(c) && !matches!(c, '\n' | '\t');
    if !text.contains(hide) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        // Every hidden character is below U+10000, so one unit of UTF-16 is enough.
        let _ = if hide(c) { write!(out, "\\u{:04x}", u32::from(c)) } else { out.write_char(c) };
    }
    Cow::Owned(out)
}

/// For HTML and SVG, as text of one line or within a quoted attribute.
pub fn html(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in line(text).chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c => out.push(c),
        }
    }
    out
}

/// For Markdown, within a line or a table's cell. The result ends no line and no column, and begins no tag.
pub fn markdown(text: &str) -> String {
    let text = line(text);
    let mut out = String::with_capacity(text.len());
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        let begins_tag = |next: &char| next.is_ascii_alphabetic() || matches!(next, '/' | '!' | '?');
        match c {
            '|' => out += "\\|",
            '<' if rest.peek().is_some_and(begins_tag) => out += "&lt;",
            c => out.push(c),
        }
    }
    out
}

/// For LaTeX, as text within a line, a table's cell or an item.
pub fn latex(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in line(text).chars() {
        match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                out.push('\\');
                out.push(c);
            }
            '~' => out += "\\textasciitilde{}",
            '^' => out += "\\textasciicircum{}",
            '\\' => out += "\\textbackslash{}",
            '<' => out += "\\textless{}",
            '>' => out += "\\textgreater{}",
            // After `\\` and `\item` these characters would be arguments.
            '[' => out += "{[}",
            '*' => out += "{*}",
            '±' => out += "$\\pm$",
            '·' => out += "$\\cdot$",
            c => out.push(c),
        }
    }
    out
}

/// For a file's name without its extension. The result leads to no other folder, holds no hidden character, and is
/// short enough for any file system.
pub fn file_name(text: &str) -> String {
    const LONGEST: usize = 180;
    let plain = |c: char| if matches!(c, '/' | '\\' | ' ') || is_hidden(c) { '-' } else { c };
    let mut name = String::new();
    for c in text.chars().map(plain) {
        if name.len() + c.len_utf8() > LONGEST {
            break;
        }
        name.push(c);
    }
    name
}

/// For a cell of text in CSV, before it is quoted. No spreadsheet takes the result for a formula, and [`csv_read`]
/// restores the text. Cells with numbers are written as they are, without this function.
///
/// Text that begins with `=`, `+`, `-` or `@` gets a quote mark before it, which spreadsheets read as a mark of text.
/// Hidden characters are made visible.
pub fn csv(text: &str) -> Cow<'_, str> {
    let plain = !is_guarded(text) && !text.contains(is_hidden) && !text.contains("\\u{");
    if plain {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    if is_guarded(text) {
        out.push('\'');
    }
    for (at, c) in text.char_indices() {
        if is_hidden(c) || (c == '\\' && text[at..].starts_with("\\u{")) {
            out.extend(c.escape_unicode());
        } else {
            out.push(c);
        }
    }
    Cow::Owned(out)
}

/// Restores the text from which [`csv()`] made `cell`.
pub fn csv_read(cell: &str) -> Cow<'_, str> {
    let text = cell.strip_prefix('\'').filter(|rest| is_guarded(rest)).unwrap_or(cell);
    if !text.contains("\\u{") {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("\\u{") {
        let (before, escaped) = rest.split_at(at);
        out += before;
        let digits = escaped[3..].split_once('}');
        let read = digits.and_then(|(hex, after)| Some((char::from_u32(u32::from_str_radix(hex, 16).ok()?)?, after)));
        match read {
            Some((c, after)) => {
                out.push(c);
                rest = after;
            }
            // This is no escape that `csv` writes, so it stays.
            None => {
                out += "\\u{";
                rest = &escaped[3..];
            }
        }
    }
    out += rest;
    Cow::Owned(out)
}

/// Whether the text begins a formula, or would begin one without its leading quote marks.
fn is_guarded(text: &str) -> bool {
    text.trim_start_matches('\'').starts_with(['=', '+', '-', '@'])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nothing_that_a_medium_obeys_is_left() {
        let name = "a\u{1b}[2J\u{9b}2J\r\nb\t\u{202e}c\u{7f}";
        assert_eq!(line(name), r"a\u{1b}[2J\u{9b}2J\r\nb\t\u{202e}c\u{7f}");
        assert_eq!(terminal("a\nb\tc\u{7}"), "a\nb\tc\\u{7}");
        assert!(matches!(line("plain, ± and 漢字"), Cow::Borrowed(_)));
        assert_eq!(html("<script>'\u{1}"), "&lt;script&gt;&#39;\\u{1}");
        assert_eq!(markdown("a|b\n<b> p < 1"), r"a\|b\n&lt;b> p < 1");
        assert_eq!(latex("[1] \\input{x}\n*"), r"{[}1] \textbackslash{}input\{x\}\textbackslash{}n{*}");
        assert_eq!(file_name("../a b\u{1b}"), "..-a-b-");
        assert_eq!(file_name(&"é".repeat(200)).len(), 180);
        let object = serde_json::json!({ "name": name }).to_string();
        assert!(!json(&object).contains(is_hidden));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&json(&object)).unwrap()["name"], name);
    }

    #[test]
    fn a_spreadsheet_computes_no_name() {
        for (text, cell) in [
            ("=1+1", "'=1+1"),
            ("@x", "'@x"),
            ("-p", "'-p"),
            ("+p", "'+p"),
            ("'=1", "''=1"),
            ("'a", "'a"),
            ("p-1", "p-1"),
        ] {
            assert_eq!(csv(text), cell);
            assert_eq!(csv_read(cell), text);
        }
        assert_eq!(csv("\t=1"), "\\u{9}=1");
        assert_eq!(csv_read("\\u{zz} \\u{110000} \\u{"), "\\u{zz} \\u{110000} \\u{");
    }

    proptest! {
        #[test]
        fn text_comes_back_from_csv(text in any::<String>(), marks in "['=+@-]{0,3}(\\\\u\\{[0-9a-f]{0,3}\\}?){0,2}") {
            let text = format!("{marks}{text}");
            let cell = csv(&text).into_owned();
            prop_assert_eq!(csv_read(&cell), text.as_str());
            prop_assert!(!cell.contains(is_hidden) && !cell.starts_with(['=', '+', '-', '@']));
        }
    }
}
