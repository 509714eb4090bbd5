//! The report as one self-contained HTML page: it needs no network, and suits light and dark modes, paper and narrow
//! screens.

use std::fmt::Write;

use super::document::{Block, document};
use super::input::ReportInput;
use crate::escape::html as escape;

const STYLE: &str = include_str!("style.css");

/// The page, as one string: styles, plots and pictures inside.
///
/// ```no_run
/// use cyclopean_analysis::data::Selection;
/// use cyclopean_analysis::report::{Figure, ReportInput, ReportOptions, html};
/// let mut input = ReportInput::gather(&["sessions".into()], &Selection::default(), &ReportOptions::default())?;
/// input.figures.push(Figure { caption: "pica, stereo".into(), png: std::fs::read("pica.png")? });
/// std::fs::write("report.html", html(&input))?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn html(input: &ReportInput) -> String {
    page(&input.title, input.stamp.as_deref(), &document(input))
}

/// A page of other blocks in the same style. `stamp` names the kind of data, such as `simulated`, where they are not
/// answers of real participants.
pub fn page(title: &str, stamp: Option<&str>, blocks: &[Block]) -> String {
    let mut out = head(title, "");
    if let Some(stamp) = stamp {
        let _ = write!(
            out,
            "<p class=\"stamp-line\">{} data: not people's answers to the study</p>",
            escape(&stamp.to_uppercase())
        );
    }
    let titles: Vec<&str> = blocks
        .iter()
        .filter_map(|block| match block {
            Block::Heading(1, title) => Some(title.as_str()),
            _ => None,
        })
        .collect();
    let mut section = 0;
    for block in blocks {
        match block {
            Block::Heading(1, title) => {
                section += 1;
                let _ = write!(out, "<h2 id=\"s{section}\">{}</h2>", escape(title));
            }
            Block::Contents => {
                let link =
                    |(i, title): (usize, &&str)| format!("<li><a href=\"#s{}\">{}</a></li>", i + 1, escape(title));
                let links: String = titles.iter().enumerate().map(link).collect();
                let _ = write!(out, "<nav><ul>{links}</ul></nav>");
            }
            block => write_block(&mut out, block),
        }
    }
    out += "</main></body></html>\n";
    out
}

/// The beginning of a page, up to its title; `style` adds rules for this page.
pub(super) fn head(title: &str, style: &str) -> String {
    let title = escape(title);
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <meta name=\"color-scheme\" content=\"light dark\"><title>{title}</title><style>{STYLE}{style}</style></head>\
         <body><main><h1 class=\"title\">{title}</h1>"
    )
}

/// A table of names and values, one pair in each row.
pub(super) fn facts_table(facts: &[(&str, String)]) -> String {
    let rows: String = facts
        .iter()
        .map(|(name, value)| format!("<tr><th>{}</th><td>{}</td></tr>", escape(name), escape(value)))
        .collect();
    format!("<div class=\"scroll\"><table><tbody>{rows}</tbody></table></div>")
}

fn write_block(out: &mut String, block: &Block) {
    let _ = match block {
        Block::Contents => Ok(()),
        Block::Heading(level, text) => write!(out, "<h{0}>{1}</h{0}>", level + 1, escape(text)),
        Block::Text(text) => write!(out, "<p>{}</p>", escape(text)),
        Block::Notes(notes) => {
            let items: String = notes.iter().map(|n| format!("<li>{}</li>", escape(n))).collect();
            write!(out, "<ul>{items}</ul>")
        }
        Block::Table { caption, head, rows } => write!(out, "{}", table(caption, head, rows)),
        Block::Plot { caption, svg } => {
            write!(out, "<figure class=\"plot\"><div>{svg}</div><figcaption>{}</figcaption></figure>", escape(caption))
        }
        Block::Drawing { caption, svg } => write!(
            out,
            "<figure><img alt=\"{0}\" src=\"data:image/svg+xml;base64,{1}\"><figcaption>{0}</figcaption></figure>",
            escape(caption),
            base64(svg.as_bytes())
        ),
        Block::Picture { caption, png } => write!(
            out,
            "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>",
            escape(caption),
            base64(png)
        ),
        Block::Details { summary, body } => {
            let body: Vec<String> = body.lines().map(|line| escape(&line.replace('\t', "    "))).collect();
            write!(out, "<details><summary>{}</summary><pre>{}</pre></details>", escape(summary), body.join("\n"))
        }
    };
}

fn table(caption: &str, head: &[String], rows: &[Vec<String>]) -> String {
    let numeric = |t: &str| t == "-" || t.starts_with(|c: char| c.is_ascii_digit() || "-[<±".contains(c));
    let right: Vec<bool> =
        (0..head.len()).map(|c| c > 0 && rows.iter().all(|r| r.get(c).is_none_or(|t| numeric(t)))).collect();
    let class = |c: usize| if right.get(c).copied().unwrap_or(false) { " class=\"n\"" } else { "" };
    let mut out = String::from("<figure class=\"table\"><div class=\"scroll\"><table><thead><tr>");
    for (c, h) in head.iter().enumerate() {
        let _ = write!(out, "<th scope=\"col\"{}>{}</th>", class(c), escape(h));
    }
    out += "</tr></thead><tbody>";
    for row in rows {
        out += "<tr>";
        for (c, cell) in row.iter().enumerate() {
            let _ = write!(out, "<td{}>{}</td>", class(c), escape(cell));
        }
        out += "</tr>";
    }
    let _ = write!(out, "</tbody></table></div><figcaption>{}</figcaption></figure>", escape(caption));
    out
}

/// RFC 4648, with padding.
pub(super) fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = (0..3).fold(0u32, |w, i| w << 8 | u32::from(chunk.get(i).copied().unwrap_or(0)));
        for i in 0..4 {
            let digit = DIGITS[(word >> (18 - 6 * i)) as usize & 63];
            out.push(if i <= chunk.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    #[test]
    fn base64_of_the_rfc() {
        // RFC 4648, section 10
        for (text, want) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(super::base64(text.as_bytes()), want);
        }
    }
}
