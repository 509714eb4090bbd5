//! Splits Rust sources into tokens and finds the paths that they name. Comments and strings are ignored.

/// The text with spaces in place of comments, strings and character literals, so that lines and columns stay the same.
pub fn code(text: &str) -> String {
    let c: Vec<char> = text.chars().collect();
    let at = |i: usize| c.get(i).copied().unwrap_or('\0');
    let is_word = |x: char| x.is_alphanumeric() || x == '_';
    let mut out = String::with_capacity(text.len());
    let blank = |x: char| if x == '\n' { '\n' } else { ' ' };
    let mut i = 0;
    while i < c.len() {
        let from = i;
        if at(i) == '/' && at(i + 1) == '/' {
            while i < c.len() && at(i) != '\n' {
                i += 1;
            }
        } else if at(i) == '/' && at(i + 1) == '*' {
            let mut depth = 0;
            while i < c.len() {
                match (at(i), at(i + 1)) {
                    ('/', '*') => (depth, i) = (depth + 1, i + 2),
                    ('*', '/') => (depth, i) = (depth - 1, i + 2),
                    _ => i += 1,
                }
                if depth == 0 {
                    break;
                }
            }
        } else if let Some(end) = raw_string_end(&c, i).filter(|_| i == 0 || !is_word(at(i - 1))) {
            i = end;
        } else if at(i) == '"' {
            i += 1;
            while i < c.len() && at(i) != '"' {
                i += if at(i) == '\\' { 2 } else { 1 };
            }
            i += 1;
        } else if at(i) == '\'' && at(i + 1) == '\\' {
            i += 3;
            while i < c.len() && at(i) != '\'' {
                i += 1;
            }
            i += 1;
        } else if at(i) == '\'' && at(i + 2) == '\'' {
            i += 3;
        } else {
            out.push(at(i));
            i += 1;
            continue;
        }
        i = i.min(c.len());
        out.extend(c[from..i].iter().map(|x| blank(*x)));
    }
    out
}

/// The index after a raw string that begins at `i` (`r"…"`, `r#"…"#`, `br"…"`, `cr"…"`).
fn raw_string_end(c: &[char], i: usize) -> Option<usize> {
    let mut k = i;
    if matches!(c.get(k), Some('b' | 'c')) {
        k += 1;
    }
    if c.get(k) != Some(&'r') {
        return None;
    }
    k += 1;
    let hashes = c[k..].iter().take_while(|x| **x == '#').count();
    k += hashes;
    if c.get(k) != Some(&'"') {
        return None;
    }
    k += 1;
    while k < c.len() {
        if c[k] == '"' && c[k + 1..].iter().take(hashes).filter(|x| **x == '#').count() == hashes {
            return Some(k + 1 + hashes);
        }
        k += 1;
    }
    Some(k)
}

/// A word, `::`, or any other character that is not white space, with its line (from 1).
#[derive(Debug, Clone, PartialEq)]
pub struct Token {
    pub text: String,
    pub line: usize,
}

pub fn tokens(text: &str) -> Vec<Token> {
    let mut out = Vec::new();
    for (line, content) in code(text).lines().enumerate() {
        let c: Vec<char> = content.chars().collect();
        let mut i = 0;
        while i < c.len() {
            let from = i;
            if c[i].is_alphanumeric() || c[i] == '_' {
                while i < c.len() && (c[i].is_alphanumeric() || c[i] == '_') {
                    i += 1;
                }
            } else if c[i] == ':' && c.get(i + 1) == Some(&':') {
                i += 2;
            } else {
                i += 1;
                if c[from].is_whitespace() {
                    continue;
                }
            }
            out.push(Token { text: c[from..i].iter().collect(), line: line + 1 });
        }
    }
    out
}

/// Lines that name one of `words`. A word is an identifier, a path such as `std::time` (which the source may write out
/// or as part of a group), or a crate such as `ash::`, which stands for everything in it.
pub fn naming(text: &str, words: &[&str]) -> Vec<(usize, String)> {
    let tokens = tokens(text);
    let mut found = Vec::new();
    for (i, token) in tokens.iter().enumerate() {
        let starts_path = i == 0 || tokens[i - 1].text != "::";
        for word in words {
            let hit = match word.split_once("::") {
                None => token.text == *word,
                Some((first, "")) => {
                    let used = i > 0 && tokens[i - 1].text == "use";
                    let path = tokens.get(i + 1).is_some_and(|t| t.text == "::");
                    starts_path && token.text == first && (used || path)
                }
                Some((first, _)) => {
                    starts_path && token.text == first && {
                        let mut paths = Vec::new();
                        paths_from(&tokens, i, &mut Vec::new(), &mut paths);
                        paths.iter().any(|(_, p)| {
                            let p = p.join("::");
                            p == *word || p.starts_with(&format!("{word}::"))
                        })
                    }
                }
            };
            if hit {
                found.push((token.line, (*word).to_owned()));
            }
        }
    }
    found
}

/// Adds every path that begins at token `i` to `out`, with groups multiplied out. Returns the index after them.
fn paths_from(tokens: &[Token], i: usize, prefix: &mut Vec<String>, out: &mut Vec<(usize, Vec<String>)>) -> usize {
    let text = |k: usize| tokens.get(k).map_or("", |t| t.text.as_str());
    let depth = prefix.len();
    let line = tokens[i].line;
    let mut k = i;
    loop {
        prefix.push(text(k).to_owned());
        k += 1;
        if text(k) != "::" {
            break;
        }
        if text(k + 1) == "{" {
            k += 2;
            while k < tokens.len() && text(k) != "}" {
                if text(k) == "," {
                    k += 1;
                    continue;
                }
                k = paths_from(tokens, k, prefix, out);
                // Skips `as name`.
                while k < tokens.len() && text(k) != "," && text(k) != "}" {
                    k += 1;
                }
            }
            prefix.truncate(depth);
            return k + 1;
        }
        if !text(k + 1).starts_with(|x: char| x.is_alphabetic() || x == '_' || x == '*') {
            break;
        }
        k += 1;
    }
    out.push((line, prefix.clone()));
    prefix.truncate(depth);
    k
}

/// The paths within this crate that a source names, from the crate's root. These are `crate::…`, and `self::…` and
/// `super::…` resolved from `module` (the file's own module path) and from the modules written inside the file.
pub fn named_modules(text: &str, module: &[String]) -> Vec<(usize, Vec<String>)> {
    let tokens = tokens(text);
    let (mut found, mut inner, mut depth) = (Vec::new(), Vec::<(String, usize)>::new(), 0usize);
    for (i, token) in tokens.iter().enumerate() {
        let before = |n: usize| i.checked_sub(n).map_or("", |k| tokens[k].text.as_str());
        match token.text.as_str() {
            "{" => {
                depth += 1;
                if before(2) == "mod" {
                    inner.push((before(1).to_owned(), depth));
                }
            }
            "}" => {
                inner.retain(|(_, d)| *d != depth);
                depth = depth.saturating_sub(1);
            }
            "crate" | "super" | "self" if before(1) != "::" => {
                let next = |n: usize| tokens.get(i + n).map_or("", |t| t.text.as_str());
                // `use crate as other` would hide every path that begins with `other`.
                if token.text == "crate" && next(1) == "as" {
                    found.push((token.line, vec!["*".to_owned()]));
                }
                if next(1) != "::" {
                    continue;
                }
                let mut paths = Vec::new();
                paths_from(&tokens, i, &mut Vec::new(), &mut paths);
                let here: Vec<String> =
                    module.iter().cloned().chain(inner.iter().map(|(name, _)| name.clone())).collect();
                found.extend(paths.into_iter().map(|(line, path)| (line, absolute(path, &here))));
            }
            _ => {}
        }
    }
    found
}

/// The path from the crate's root for a path that is written in the module `here`.
fn absolute(path: Vec<String>, here: &[String]) -> Vec<String> {
    let mut from_root = here.to_vec();
    for word in path {
        match word.as_str() {
            "crate" => from_root.clear(),
            "super" => drop(from_root.pop()),
            "self" => {}
            _ => from_root.push(word),
        }
    }
    from_root
}

/// Paths of at least two words whose first word `begins` accepts, with groups multiplied out.
pub fn paths_that_begin(text: &str, begins: impl Fn(&str) -> bool) -> Vec<Vec<String>> {
    let tokens = tokens(text);
    let is = |at: Option<usize>, word: &str| at.and_then(|at| tokens.get(at)).is_some_and(|t| t.text == word);
    let mut found = Vec::new();
    for at in 0..tokens.len() {
        if is(Some(at + 1), "::") && !is(at.checked_sub(1), "::") && begins(&tokens[at].text) {
            let mut paths = Vec::new();
            paths_from(&tokens, at, &mut Vec::new(), &mut paths);
            found.extend(paths.into_iter().map(|(_, path)| path));
        }
    }
    found
}

/// The paths, from the crate's root, that a source re-exports by `pub use` or `pub(…) use`. `module` is the file's own.
pub fn public_uses(text: &str, module: &[String]) -> Vec<Vec<String>> {
    let tokens = tokens(text);
    let is_public = |at: usize| match at.checked_sub(1).map(|k| tokens[k].text.as_str()) {
        Some("pub") => true,
        Some(")") => tokens[..at]
            .iter()
            .rev()
            .find(|t| ["pub", ";", "}"].contains(&t.text.as_str()))
            .is_some_and(|t| t.text == "pub"),
        _ => false,
    };
    let mut found = Vec::new();
    for at in (0..tokens.len()).filter(|&at| tokens[at].text == "use" && is_public(at)) {
        let mut paths = Vec::new();
        paths_from(&tokens, at + 1, &mut Vec::new(), &mut paths);
        found.extend(paths.into_iter().map(|(_, path)| absolute(path, module)));
    }
    found
}

/// The path of a file's module within its crate: `src/study/session/mod.rs` → study, session.
pub fn module_of(path: &str) -> Vec<String> {
    let inside = path.strip_prefix("analysis/").unwrap_or(path);
    let inside = inside.strip_prefix("src/").unwrap_or(inside);
    let mut parts: Vec<String> = inside.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if matches!(parts.last().map(String::as_str), Some("mod" | "lib" | "main")) {
        parts.pop();
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn modules(path: &str, text: &str) -> Vec<String> {
        named_modules(text, &module_of(path)).into_iter().map(|(_, named)| named.join("::")).collect()
    }

    #[test]
    fn comments_strings_and_characters_are_no_code() {
        let text =
            "a // crate::gpu\n/* b /* c */ d */ e \"crate::\\\"f\" g r#\"h\"i\"# 'j' '\\'' '\\u{41}' k<'l> b\"m\" n";
        let words: Vec<String> = tokens(text).into_iter().map(|t| t.text).filter(|t| t.len() == 1).collect();
        assert_eq!(words.concat(), "aegk<'l>bn");
        let lines: Vec<usize> = tokens("a\n\"b\nc\"\nd").iter().map(|t| t.line).collect();
        assert_eq!(lines, [1, 4]);
        assert_eq!(code("x'y'\nz").lines().count(), 2);
    }

    #[test]
    fn names_are_resolved_from_where_they_stand() {
        assert_eq!(modules("src/study/a.rs", "use crate::gpu::Gpu;"), ["gpu::Gpu"]);
        assert_eq!(
            modules("src/study/a.rs", "use crate::{gpu::{Gpu, Frame as F}, scene as s, render};"),
            ["gpu::Gpu", "gpu::Frame", "scene", "render"]
        );
        assert_eq!(modules("src/study/a.rs", "fn f(x: crate::gpu::Gpu<u8>) {}"), ["gpu::Gpu"]);
        assert_eq!(modules("src/study/a.rs", "use super::super::gpu;"), ["gpu"]);
        assert_eq!(modules("src/study/mod.rs", "use super::gpu::Gpu;"), ["gpu::Gpu"]);
        assert_eq!(modules("src/study/a.rs", "use super::gpu::Gpu;"), ["study::gpu::Gpu"]);
        let inner = "mod tests { use super::super::super::gpu; } use super::b;";
        assert_eq!(modules("src/study/a.rs", inner), ["gpu", "study::b"]);
        assert_eq!(modules("src/study/a.rs", "pub(crate) fn f(&self) { self.gpu.go() }"), [""; 0]);
        assert_eq!(modules("src/study/a.rs", "use crate as c;"), ["*"]);
        assert_eq!(modules("src/study/a.rs", "use crate::*;"), ["*"]);
        assert_eq!(modules("src/study/a.rs", "// use crate::gpu;\nlet s = \"crate::gpu\";"), [""; 0]);
    }
}
