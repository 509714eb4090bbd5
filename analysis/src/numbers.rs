//! Reads plain columns of numbers, and subtracts two columns so that equal differences stay equal.

use std::path::Path;

use crate::error::{Error, Result};

/// Reads one column of differences, or two columns x and y whose differences x − y are taken.
///
/// Columns are separated by commas, semicolons, tabs or spaces; empty lines and lines that begin with `#`
/// are passed over; a first line without any number is a header. Two columns are subtracted as decimal
/// numbers, exactly where they have up to 15 digits, so that 0.825 − 0.775 ties with 0.375 − 0.325.
///
/// # Errors
/// [`Error::Line`] for what is not a finite number or not one or two columns, [`Error::Data`] without any number.
///
/// ```
/// use cyclopean_analysis::numbers::differences;
/// let d = differences(b"x,y\n0.825,0.775\n0.375,0.325\n", "pairs.csv".as_ref())?;
/// assert_eq!(d[0], d[1]); // in floating point they differ in the last bit
/// # Ok::<(), cyclopean_analysis::Error>(())
/// ```
pub fn differences(content: &[u8], path: &Path) -> Result<Vec<f64>> {
    let text = std::str::from_utf8(content)
        .map_err(|_| Error::Data(format!("{}: not UTF-8 text; columns of numbers are expected", path.display())))?;
    let mut out = Vec::new();
    let mut columns = None;
    for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let wrong = |what: String| Error::Line { path: path.to_owned(), line: i as u64 + 1, what };
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let fields: Vec<&str> = if line.contains([',', ';', '\t']) {
            line.split([',', ';', '\t']).map(|f| f.trim().trim_matches('"')).collect()
        } else {
            line.split_whitespace().collect()
        };
        if columns.is_none() && fields.iter().all(|f| f.parse::<f64>().is_err()) {
            if out.is_empty() && fields.len() <= 2 {
                columns = Some(fields.len());
                continue;
            }
            return Err(wrong(format!("{} columns; one (differences) or two (x and y) are expected", fields.len())));
        }
        let width = *columns.get_or_insert(fields.len());
        if fields.len() != width || width > 2 {
            return Err(wrong(format!(
                "{} columns; {} expected: one (differences) or two (x and y)",
                fields.len(),
                width.min(2)
            )));
        }
        let number = |field: &str| -> Result<f64> {
            let value: f64 =
                field.parse().map_err(|_| wrong(format!("`{field}` is not a number, such as 4 or -0.5")))?;
            if value.is_finite() { Ok(value) } else { Err(wrong(format!("`{field}` is not a finite number"))) }
        };
        out.push(match fields[..] {
            [d] => number(d)?,
            [x, y] => {
                let d = subtract(x, y).unwrap_or(number(x)? - number(y)?);
                if !d.is_finite() {
                    return Err(wrong(format!("the difference {x} - {y} is beyond the range of numbers")));
                }
                d
            }
            _ => return Err(wrong("no number".to_owned())),
        });
    }
    if out.is_empty() {
        return Err(Error::Data(format!(
            "{}: no numbers; one column of differences or two of x and y are expected",
            path.display()
        )));
    }
    Ok(out)
}

/// x − y in decimal arithmetic: both become whole numbers over the same power of ten, and only the result is rounded.
fn subtract(x: &str, y: &str) -> Option<f64> {
    let ((a, p), (b, q)) = (decimal(x)?, decimal(y)?);
    let places = p.max(q);
    let scaled = |v: i128, from: u32| v.checked_mul(10i128.checked_pow(places - from)?);
    let difference = scaled(a, p)?.checked_sub(scaled(b, q)?)?;
    // Parsing the decimal text gives the nearest f64, whatever the number of places.
    format!("{difference}e-{places}").parse().ok()
}

/// Digits and the number of decimal places of plain notation; `None` for exponents and long numbers.
fn decimal(text: &str) -> Option<(i128, u32)> {
    let (whole, part) = text.split_once('.').unwrap_or((text, ""));
    let digits = format!("{whole}{part}");
    if digits.len() > 18 || !part.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    Some((digits.parse().ok()?, part.len() as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wilcoxon::{Alternative, Options, signed_rank};

    #[test]
    fn the_example_of_scipys_documentation_keeps_its_ties() {
        let pairs = b"0.5 0.525\n.825 .775\n0.375 0.325\n0.5 0.55\n";
        let d = differences(pairs, "x".as_ref()).unwrap();
        assert_eq!(d, [-0.025, 0.05, 0.05, -0.05]);
        // scipy 1.17.1: wilcoxon([-.025, .05, .05, -.05], alternative="greater") → 0.5; on x, y it says 0.5625
        let greater = Options { alternative: Alternative::Greater, ..Options::default() };
        assert_eq!(signed_rank(&d, &greater).unwrap().p_exact, Some(0.5));
    }

    #[test]
    fn wrong_lines_are_named() {
        let error = |text: &str| differences(text.as_bytes(), "n.csv".as_ref()).unwrap_err().to_string();
        assert_eq!(error("1\n2\nx\n"), "n.csv, line 3: `x` is not a number, such as 4 or -0.5");
        assert_eq!(error("a,b\n1,inf\n"), "n.csv, line 2: `inf` is not a finite number");
        assert!(error("1,2\n3\n").contains("line 2: 1 columns; 2 expected"));
        assert!(error("").contains("no numbers"));
        assert!(error("1e308,-1e308").contains("beyond the range"));
        assert!(error("1,2,3").contains("3 columns"));
    }
}
