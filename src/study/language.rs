//! The languages of pages, questionnaires and buttons: files of one form, four of which are built in.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, MOST_DATA, MOST_TEXT};
use serde::Deserialize;

use super::validate::Study;
use crate::display::content::Words;

const BUILT_IN: [(&str, &str); 4] = [
    ("en", include_str!("../../languages/en.json")),
    ("de", include_str!("../../languages/de.json")),
    ("fr", include_str!("../../languages/fr.json")),
    ("zh", include_str!("../../languages/zh.json")),
];

/// One language.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Language {
    /// The language's name in that language.
    pub name: String,
    /// Font files with its letters, of which the first that is installed is used; empty: the built-in font has them.
    #[serde(default)]
    pub font: Vec<String>,
    pub words: Words,
    /// Item name → question; where one is missing, English is used.
    #[serde(default)]
    pub items: BTreeMap<String, String>,
    /// English option, or `item/option` → the option's words; where one is missing, English is used.
    #[serde(default)]
    pub options: BTreeMap<String, String>,
}

/// A language cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LanguageError {
    #[error("language: `{name}` is neither one of {known} nor a file that can be read ({}: {source})", path.display())]
    Unknown { name: String, known: String, path: PathBuf, source: std::io::Error },
    #[error("language: {}: {source}", path.display())]
    Form { path: PathBuf, source: serde_json::Error },
    #[error(
        "language: the letters of {name} are not in the built-in font, and none of {wanted} is installed (Debian: apt-get install fonts-wqy-microhei)"
    )]
    Font { name: String, wanted: String },
}

impl Language {
    /// The study's language.
    ///
    /// # Errors
    /// [`LanguageError::Unknown`], [`LanguageError::Form`].
    pub fn of(study: &Study) -> Result<Language, LanguageError> {
        let name = &study.definition.language;
        let built_in = BUILT_IN.iter().find(|(known, _)| known == name);
        let path = study.path.parent().unwrap_or(Path::new("")).join(name);
        let text = match built_in {
            Some((_, text)) => (*text).to_owned(),
            None => files::read_text(&path, MOST_TEXT).map_err(|source| {
                let known = BUILT_IN.map(|(name, _)| format!("`{name}`")).join(", ");
                LanguageError::Unknown { name: name.clone(), known, path: path.clone(), source }
            })?,
        };
        serde_json::from_str(&text).map_err(|source| LanguageError::Form { path, source })
    }

    /// The question of an item; or, by the name of its phase, the text above a questionnaire's items.
    pub fn item<'a>(&'a self, name: &str, english: &'a str) -> &'a str {
        self.items.get(name).map_or(english, String::as_str)
    }

    /// The words for an option of an item.
    pub fn option(&self, item: &str, option: &str) -> String {
        let specific = self.options.get(&format!("{item}/{option}"));
        specific.or_else(|| self.options.get(option)).cloned().unwrap_or_else(|| option.to_owned())
    }

    /// The font file that has the language's letters; none: the built-in font has them.
    ///
    /// # Errors
    /// [`LanguageError::Font`] when the language needs a font that is not installed.
    pub fn font(&self) -> Result<Option<Vec<u8>>, LanguageError> {
        if self.font.is_empty() {
            return Ok(None);
        }
        let home = std::env::var_os("HOME").map(PathBuf::from).unwrap_or_default();
        let folders = [
            home.join(".local/share/fonts"),
            home.join("Library/Fonts"),
            PathBuf::from("/usr/local/share/fonts"),
            PathBuf::from("/usr/share/fonts"),
            PathBuf::from("/System/Library/Fonts"),
            PathBuf::from("C:\\Windows\\Fonts"),
        ];
        for name in &self.font {
            let found = folders.iter().find_map(|folder| find(folder, name, 4));
            if let Some(bytes) = found.and_then(|path| files::read(&path, MOST_DATA).ok()) {
                return Ok(Some(bytes));
            }
        }
        Err(LanguageError::Font { name: self.name.clone(), wanted: self.font.join(", ") })
    }
}

/// The first file of this name in `folder` or at most `depth` folders below it.
fn find(folder: &Path, name: &str, depth: usize) -> Option<PathBuf> {
    let mut folders = Vec::new();
    for entry in std::fs::read_dir(folder).ok()?.flatten() {
        let path = entry.path();
        if path.is_dir() {
            folders.push(path);
        } else if entry.file_name() == name {
            return Some(path);
        }
    }
    folders.sort();
    folders.iter().filter(|_| depth > 0).find_map(|folder| find(folder, name, depth - 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::questionnaire::FORMS;

    #[test]
    fn every_built_in_language_is_whole() {
        for (name, text) in BUILT_IN {
            let language: Language = serde_json::from_str(text).unwrap_or_else(|e| panic!("{name}: {e}"));
            for (item, _, options) in FORMS.iter().flat_map(|form| form.items) {
                assert!(name == "en" || language.items.contains_key(*item), "{name}: {item}");
                for option in *options {
                    let there = language.option(item, option) != **option;
                    let same = name == "en" || option.chars().any(|c| c.is_ascii_digit());
                    assert!(there || same, "{name}: {item}: {option}");
                }
            }
            let phases = FORMS.iter().flat_map(|form| [form.before, form.after]).flatten();
            let known: Vec<&str> =
                FORMS.iter().flat_map(|form| form.items).map(|(item, ..)| *item).chain(phases).collect();
            assert!(language.items.keys().all(|item| known.contains(&item.as_str())), "{name}");
            for (text, holes) in [
                (&language.words.progress, &["{at}", "{of}"][..]),
                (&language.words.consent_small, &["{purpose}", "{until}"]),
                (&language.words.time_left, &["{seconds}"]),
            ] {
                assert!(holes.iter().all(|hole| text.contains(hole)), "{name}: {text}");
            }
        }
    }
}
