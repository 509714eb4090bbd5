//! Draws a sheet: [`super::Sheet`] goes in and the page comes out.
//!
//! A row belongs to a method. It has a block for the whole view and then one for each enlarged part. Every block has
//! the pictures of the left and of the right eye, and below them the difference between the eyes and the numbers.

use super::canvas::{Canvas, Color, Rect, bytes, resized};
use super::text::{Align, Typesetter};
use super::{Part, Row, Scores, Sheet, heat};

/// The height of every picture, and the width of enlarged parts. The side of a part always divides it.
const CELL: usize = 192;
const MARGIN: usize = 40;
/// The space between the pictures of a block.
const GAP: usize = 6;
const BETWEEN_BLOCKS: usize = 34;
/// The height of a method's name and description.
const ROW_HEAD: usize = 46;
const BETWEEN_ROWS: usize = 26;
/// The height of everything above the first row.
const HEAD: usize = 152;
const SCALE_WIDTH: usize = 240;

const GROUND: Color = [255, 255, 255];
const INK: Color = [24, 24, 26];
const QUIET: Color = [92, 94, 99];
const LINE: Color = [214, 216, 220];
/// Okabe & Ito's orange, sky blue and reddish purple. Colour-blind readers can tell them apart, on dark and on light
/// pictures.
const MARKS: [Color; 3] = [[230, 159, 0], [86, 180, 233], [204, 121, 167]];
const LETTERS: [&str; 3] = ["A", "B", "C"];

const TITLE: f32 = 26.0;
const NAME: f32 = 19.0;
const TEXT: f32 = 15.0;

/// A page that is being drawn.
struct Page {
    canvas: Canvas,
    letters: Typesetter,
    /// The width of the picture of a whole view.
    view: usize,
}

/// The sheet as pixels.
pub fn draw(sheet: &Sheet) -> Canvas {
    let (width, height) = sheet.size;
    let view = ((CELL * width) as f64 / height as f64).round() as usize;
    let blocks = 2 * view + GAP + sheet.parts.len() * (BETWEEN_BLOCKS + 2 * CELL + GAP);
    let row = ROW_HEAD + 2 * CELL + GAP + BETWEEN_ROWS;
    // A page without parts must still be wide enough for the words in its head.
    let size = ((2 * MARGIN + blocks).max(1100), HEAD + sheet.rows.len() * row + MARGIN - BETWEEN_ROWS);
    let mut page = Page { canvas: Canvas::new(size.0, size.1, GROUND), letters: Typesetter::new(), view };
    page.head(sheet);
    for (i, content) in sheet.rows.iter().enumerate() {
        page.row(sheet, content, HEAD + i * row);
    }
    page.canvas
}

impl Page {
    fn text(&mut self, at: (usize, usize), style: (f32, Align), color: Color, text: &str) {
        self.letters.draw(&mut self.canvas, at, style, color, text);
    }

    fn right(&self) -> usize {
        self.canvas.width as usize - MARGIN
    }

    /// The left edge of a part's block.
    fn block(&self, part: usize) -> usize {
        MARGIN + 2 * self.view + GAP + BETWEEN_BLOCKS + part * (2 * CELL + GAP + BETWEEN_BLOCKS)
    }

    fn head(&mut self, sheet: &Sheet) {
        self.text((MARGIN, 26), (TITLE, Align::Left), INK, &sheet.title);
        self.text((MARGIN, 66), (TEXT, Align::Left), QUIET, &sheet.about);
        self.scale();
        let y = HEAD - 42;
        self.text(
            (MARGIN, y),
            (TEXT, Align::Left),
            INK,
            "Whole view: left eye, right eye; below them where they differ",
        );
        for (i, part) in sheet.parts.iter().enumerate() {
            let x = self.block(i);
            self.canvas.fill(Rect { x, y: y + 4, width: 14, height: 14 }, MARKS[i]);
            let zoom = CELL / part.rects[0].width;
            let title = format!("{}  {}   ({zoom}×)", LETTERS[i], part.step);
            self.text((x + 22, y), (TEXT, Align::Left), INK, &title);
        }
    }

    /// Draws the scale of the difference between the eyes.
    fn scale(&mut self) {
        let (x, y) = (self.right() - SCALE_WIDTH, 38);
        for i in 0..SCALE_WIDTH {
            let contrast = heat::FULL * (i as f32 + 0.5) / SCALE_WIDTH as f32;
            self.canvas.fill(Rect { x: x + i, y, width: 1, height: 14 }, heat::color(contrast));
        }
        self.text((x - 14, y - 5), (TEXT, Align::Right), INK, "left–right difference of the reflection");
        let full = 100.0 * heat::FULL;
        let ticks =
            [(0, Align::Left, "0".to_owned()), (SCALE_WIDTH / 2, Align::Middle, format!("{:.0} %", full / 2.0))];
        for (at, align, tick) in ticks.into_iter().chain([(SCALE_WIDTH, Align::Right, format!("≥ {full:.0} %"))]) {
            self.text((x + at, y + 17), (TEXT, align), QUIET, &tick);
        }
        let words = "no partner in the right eye";
        let left = x - 14 - self.letters.width(words, TEXT);
        self.text((x - 14, y + 17), (TEXT, Align::Right), QUIET, words);
        self.canvas.fill(Rect { x: left - 24, y: y + 21, width: 16, height: 14 }, heat::NO_PARTNER);
    }

    fn row(&mut self, sheet: &Sheet, row: &Row, top: usize) {
        self.canvas.fill(Rect { x: MARGIN, y: top, width: self.right() - MARGIN, height: 1 }, LINE);
        self.text((MARGIN, top + 11), (NAME, Align::Left), INK, &row.name);
        let after = MARGIN + self.letters.width(&row.name, NAME) + 16;
        self.text((after, top + 15), (TEXT, Align::Left), QUIET, &row.about);

        let y = top + ROW_HEAD;
        let (size, to) = (sheet.size, (self.view, CELL));
        for eye in [0, 1] {
            let x = MARGIN + eye * (self.view + GAP);
            let small = resized(&row.compared.shown[eye], size, to);
            let colors: Vec<Color> = small.into_iter().map(bytes).collect();
            self.canvas.picture((x, y), &colors, self.view, 1);
            for (i, part) in sheet.parts.iter().enumerate() {
                self.mark((x, y), size, part.rects[eye], i);
            }
        }
        let known: Vec<[f32; 2]> = row.compared.contrast.iter().map(|c| c.map_or([0.0; 2], |c| [c, 1.0])).collect();
        let small = resized(&known, size, to);
        // A pixel of the smaller map has a value where at least half of what it covers has one.
        let mean = |[sum, share]: [f32; 2]| if share < 0.5 { heat::NO_PARTNER } else { heat::color(sum / share) };
        let colors: Vec<Color> = small.into_iter().map(mean).collect();
        self.canvas.picture((MARGIN, y + CELL + GAP), &colors, self.view, 1);
        let numbers = (MARGIN + self.view + GAP + 10, y + CELL + GAP);
        self.numbers(numbers, ("whole view", row), &row.whole);
        for (i, (part, scores)) in sheet.parts.iter().zip(&row.parts).enumerate() {
            self.part(sheet, row, (i, part), scores, (self.block(i), y));
        }
    }

    /// Draws the frame and the letter of a part into the whole view at `at`.
    fn mark(&mut self, at: (usize, usize), (width, height): (usize, usize), part: Rect, index: usize) {
        let (x, y) = (at.0 + part.x * self.view / width, at.1 + part.y * CELL / height);
        let rect = Rect { x, y, width: part.width * self.view / width, height: part.height * CELL / height };
        // A dark rim separates the colour from the picture.
        self.canvas.frame(rect.grown(1), 1, INK);
        self.canvas.frame(Rect { x: x + 1, y: y + 1, width: rect.width - 2, height: rect.height - 2 }, 2, MARKS[index]);
        self.canvas.fill(Rect { x, y, width: 15, height: 16 }, MARKS[index]);
        self.text((x + 7, y - 1), (13.0, Align::Middle), INK, LETTERS[index]);
    }

    fn part(&mut self, sheet: &Sheet, row: &Row, (i, part): (usize, &Part), scores: &Scores, (x, y): (usize, usize)) {
        let zoom = CELL / part.rects[0].width;
        let pixels = |r: Rect| {
            let columns = move |y: usize| (r.x..r.x + r.width).map(move |x| y * sheet.size.0 + x);
            (r.y..r.y + r.height).flat_map(columns)
        };
        for eye in [0, 1] {
            let rect = part.rects[eye];
            let colors: Vec<Color> = pixels(rect).map(|p| bytes(row.compared.shown[eye][p])).collect();
            self.canvas.picture((x + eye * (CELL + GAP), y), &colors, rect.width, zoom);
        }
        let contrast = |p: usize| row.compared.contrast[p].map_or(heat::NO_PARTNER, heat::color);
        let colors: Vec<Color> = pixels(part.rects[0]).map(contrast).collect();
        self.canvas.picture((x, y + CELL + GAP), &colors, part.rects[0].width, zoom);
        self.canvas.fill(Rect { x, y: y - 4, width: 2 * CELL + GAP, height: 3 }, MARKS[i]);
        self.numbers((x + CELL + GAP + 10, y + CELL + GAP), (LETTERS[i], row), scores);
    }

    /// Draws a small table of numbers that is as wide as a part.
    fn numbers(&mut self, (x, y): (usize, usize), (what, row): (&str, &Row), scores: &Scores) {
        let [middle, right] = [x + CELL - 70, x + CELL - 12];
        self.text((x, y + 2), (TEXT, Align::Left), INK, &row.name);
        self.text((x, y + 24), (TEXT, Align::Left), QUIET, what);
        let mut y = y + 54;
        if !row.is_reference {
            self.text((middle, y), (TEXT, Align::Right), QUIET, "left");
            self.text((right, y), (TEXT, Align::Right), QUIET, "right");
            for (name, values) in [("1 − SSIM", scores.dissimilarity), ("RSE", scores.rse)] {
                y += 24;
                self.text((x, y), (TEXT, Align::Left), QUIET, name);
                for (value, at) in values.into_iter().zip([middle, right]) {
                    let number = value.map_or("–".to_owned(), number);
                    self.text((at, y), (TEXT, Align::Right), INK, &number);
                }
            }
            y += 24;
        }
        self.text((x, y), (TEXT, Align::Left), QUIET, "L–R difference");
        let percent = scores.contrast.map_or("–".to_owned(), |c| format!("{:.1} %", 100.0 * c));
        self.text((right, y), (TEXT, Align::Right), INK, &percent);
        self.text((x, y + 24), (TEXT, Align::Left), QUIET, &format!("over {} pairs", grouped(scores.pairs)));
    }
}

/// A count with a comma between groups of three digits.
fn grouped(count: usize) -> String {
    let digits = count.to_string();
    let comma = |i: usize| if i > 0 && (digits.len() - i).is_multiple_of(3) { "," } else { "" };
    digits.chars().enumerate().map(|(i, digit)| format!("{}{digit}", comma(i))).collect()
}

/// A number with three decimals, or with fewer where it is large.
fn number(value: f64) -> String {
    match value.abs() {
        v if v < 10.0 => format!("{value:.3}"),
        v if v < 100.0 => format!("{value:.1}"),
        _ => format!("{value:.0}"),
    }
}
