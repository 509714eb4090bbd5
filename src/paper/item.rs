//! One table or figure of a publication that was made again. `tables`, `figures`, `statistics` and `ambient` make an
//! [`Item`]; the page and `paper.json` are made of it.

use cyclopean_analysis::report::Block;
use serde::Serialize;
use serde::ser::Serializer;

use super::published::Publication;

/// One table or figure of a publication that was made again.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Item {
    /// Its name in `paper.json`, such as `table2`.
    pub id: &'static str,
    pub title: String,
    pub publication: Publication,
    /// Where it is printed: its number and the section.
    pub printed_in: &'static str,
    /// What is printed there, in words.
    pub printed: String,
    /// What is shown here, and how it was made.
    pub here: String,
    pub tables: Vec<Grid>,
    pub pictures: Vec<Picture>,
    #[serde(skip)]
    pub drawings: Vec<Drawing>,
    /// Blocks of another report, such as that of a study. In `paper.json` they are under `studies`.
    #[serde(skip)]
    pub blocks: Vec<Block>,
    /// What differs from what is printed, and why.
    pub differs: Vec<String>,
    /// The command that makes only this item.
    pub call: Option<String>,
}

/// A table that shows our numbers beside the publication's.
#[derive(Debug, Clone, Serialize)]
pub struct Grid {
    pub caption: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<Cell>>,
}

/// A picture in a file. The page also contains its bytes.
#[derive(Debug, Clone, Serialize)]
pub struct Picture {
    pub caption: String,
    /// The file's path below the folder of the page.
    pub file: String,
    #[serde(skip)]
    pub png: Vec<u8>,
}

/// An SVG file with its own colours.
#[derive(Debug, Clone)]
pub struct Drawing {
    pub caption: String,
    pub svg: String,
}

/// A cell of a table. It is never empty: it has a word, a number, or the reason why there is no number.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    Word(String),
    /// A value, the number of its decimals, and the unit that follows it.
    Number(f64, usize, &'static str),
    /// The reason why there is no number.
    None(String),
}

impl Cell {
    pub fn word(text: impl Into<String>) -> Cell {
        Cell::Word(text.into())
    }

    /// A cell with `value`, or with the reason `why` there is none.
    pub fn number(value: Option<f64>, digits: usize, unit: &'static str, why: &str) -> Cell {
        match value.filter(|v| v.is_finite()) {
            Some(value) => Cell::Number(value, digits, unit),
            None => Cell::None(why.to_owned()),
        }
    }

    pub fn text(&self) -> String {
        match self {
            Cell::Word(text) | Cell::None(text) => text.clone(),
            Cell::Number(value, digits, unit) => format!("{value:.digits$}{unit}"),
        }
    }
}

/// In JSON a word is a text, a number is a number, and a reason is `{"none": why}`.
impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Cell::Word(text) => serializer.serialize_str(text),
            Cell::Number(value, ..) => serializer.serialize_f64(*value),
            Cell::None(why) => std::collections::BTreeMap::from([("none", why)]).serialize(serializer),
        }
    }
}

impl Grid {
    pub fn new(caption: impl Into<String>, columns: &[&str]) -> Grid {
        Grid { caption: caption.into(), columns: columns.iter().map(|c| (*c).to_owned()).collect(), rows: Vec::new() }
    }

    /// What is wrong with the table: a row that is longer or shorter than the head, or an empty cell.
    pub fn fault(&self) -> Option<String> {
        self.rows.iter().enumerate().find_map(|(i, row)| {
            let empty = row.iter().position(|cell| cell.text().trim().is_empty());
            match empty {
                _ if row.len() != self.columns.len() => Some(format!(
                    "row {i} of `{}` has {} cells for {} columns",
                    self.caption,
                    row.len(),
                    self.columns.len()
                )),
                Some(at) => Some(format!("row {i} of `{}` says nothing under `{}`", self.caption, self.columns[at])),
                None => None,
            }
        })
    }

    fn block(&self) -> Block {
        let rows = self.rows.iter().map(|row| row.iter().map(Cell::text).collect()).collect();
        Block::Table { caption: self.caption.clone(), head: self.columns.clone(), rows }
    }
}

impl Item {
    /// The item as blocks of the page.
    pub fn blocks(&self) -> Vec<Block> {
        let mut out = vec![
            Block::Heading(1, self.title.clone()),
            Block::Text(format!("Printed ({}, {}): {}", self.publication.cite(), self.printed_in, self.printed)),
            Block::Text(format!("Here: {}", self.here)),
        ];
        out.extend(self.tables.iter().map(Grid::block));
        let drawing = |d: &Drawing| Block::Drawing { caption: d.caption.clone(), svg: d.svg.clone() };
        out.extend(self.drawings.iter().map(drawing));
        out.extend(self.pictures.iter().map(|p| Block::Picture { caption: p.caption.clone(), png: p.png.clone() }));
        // The headings of another report are one level lower here.
        out.extend(self.blocks.iter().map(|block| match block {
            Block::Heading(_, text) => Block::Heading(2, text.clone()),
            other => other.clone(),
        }));
        if !self.differs.is_empty() {
            out.push(Block::Heading(2, "What differs, and why".to_owned()));
            out.push(Block::Notes(self.differs.clone()));
        }
        if let Some(call) = &self.call {
            let summary = "The command that makes only this".to_owned();
            out.push(Block::Details { summary, body: call.clone() });
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_with_a_gap_is_found() {
        let mut grid = Grid::new("times", &["scene", "ms"]);
        grid.rows.push(vec![Cell::word("room"), Cell::number(Some(1.5), 2, "", "")]);
        grid.rows.push(vec![Cell::word("pica"), Cell::number(None, 2, "", "it failed")]);
        assert_eq!(grid.fault(), None);
        grid.rows.push(vec![Cell::word("wine")]);
        assert!(grid.fault().expect("a fault").contains("row 2"));
        grid.rows[2].push(Cell::word(" "));
        assert!(grid.fault().expect("a fault").contains("says nothing under `ms`"));
    }

    #[test]
    fn cells_are_written_as_what_they_are() {
        let row =
            [Cell::word("room"), Cell::Number(1.0 / 3.0, 3, " %"), Cell::number(Some(f64::NAN), 1, "", "undefined")];
        assert_eq!(row.each_ref().map(Cell::text), ["room", "0.333 %", "undefined"]);
        let json = serde_json::to_string(&row).expect("JSON");
        assert_eq!(json, r#"["room",0.3333333333333333,{"none":"undefined"}]"#);
    }
}
