//! One line of a journal: its envelope, its check sum, its wall time. The application writes by it, and the reader
//! reads.
//!
//! A line is `P` + `,"crc":"` + eight lower-case hex digits + `"}` + `\n`, where `P` begins with `{"seq":` and
//! the digits are the CRC-32 (IEEE 802.3, reflected, as in zip) of the bytes of `P`.

use chrono::{DateTime, NaiveDate, SecondsFormat, Utc};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::record::{Kind, Record};

/// `,"crc":"` + digits + `"}`.
const TRAILER: usize = 18;
const TRAILER_HEAD: &[u8] = b",\"crc\":\"";

/// A line that was read and whose check sum is right.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// 0 on the first line, one more on each.
    pub seq: u64,
    /// The session's monotonic clock, nanoseconds since its start; goes on from the last line after a resume.
    pub t_ns: u64,
    /// Wall time, UTC, RFC 3339 with milliseconds. May go back when somebody sets the clock.
    #[serde(with = "wall")]
    pub wall: DateTime<Utc>,
    /// Whose session it is; the same on every line of a file.
    pub kind: Kind,
    /// What happened.
    pub record: Record,
}

/// Why a line cannot be believed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LineError {
    /// The trailer with the check sum is missing or has another form.
    #[error("has no check sum at its end")]
    NoCheckSum,
    /// The bytes are not those that were written.
    #[error("has check sum {found:08x}, but its bytes give {computed:08x}: it was damaged or edited")]
    CheckSum {
        /// The check sum that the line states.
        found: u32,
        /// The check sum of the line's bytes.
        computed: u32,
    },
    /// The check sum is right, but the content is no record that this program knows.
    #[error("is not a known record ({message}): it comes from another version of the program")]
    Syntax {
        /// The parser's words.
        message: String,
    },
}

/// Appends the line of `entry`, with its line feed, to `line`.
///
/// # Errors
/// A number that JSON cannot express (NaN, infinity); `line` is then as it was.
pub fn encode(entry: &Entry, line: &mut Vec<u8>) -> Result<(), serde_json::Error> {
    let start = line.len();
    if let Err(error) = serde_json::to_writer(&mut *line, entry) {
        line.truncate(start);
        return Err(error);
    }
    // The envelope's closing brace moves behind the check sum.
    line.pop();
    let crc = crc32fast::hash(&line[start..]);
    line.extend_from_slice(TRAILER_HEAD);
    for shift in (0..8).rev() {
        line.push(b"0123456789abcdef"[(crc >> (4 * shift)) as usize & 15]);
    }
    line.extend_from_slice(b"\"}\n");
    Ok(())
}

/// Reads a line without its line feed.
///
/// # Errors
/// See [`LineError`].
pub fn decode(line: &[u8]) -> Result<Entry, LineError> {
    check(line)?;
    // The parser ignores the trailer, as it ignores every field that it does not know.
    serde_json::from_slice(line).map_err(|error| LineError::Syntax { message: error.to_string() })
}

/// Checks the check sum alone.
///
/// # Errors
/// See [`LineError`]; never `Syntax`.
pub fn check(line: &[u8]) -> Result<(), LineError> {
    let split = line.len().checked_sub(TRAILER).ok_or(LineError::NoCheckSum)?;
    let (body, trailer) = line.split_at(split);
    let digits = trailer
        .strip_prefix(TRAILER_HEAD)
        .and_then(|rest| rest.strip_suffix(b"\"}"))
        .filter(|digits| digits.iter().all(|d| matches!(d, b'0'..=b'9' | b'a'..=b'f')))
        .ok_or(LineError::NoCheckSum)?;
    let found =
        digits.iter().fold(0u32, |sum, &d| sum << 4 | u32::from(if d <= b'9' { d - b'0' } else { d - b'a' + 10 }));
    let computed = crc32fast::hash(body);
    if found == computed { Ok(()) } else { Err(LineError::CheckSum { found, computed }) }
}

/// RFC 3339 with exactly milliseconds and `Z`. It is on every line, so it is parsed without the slower general parser.
mod wall {
    use super::*;

    pub fn serialize<S: Serializer>(time: &DateTime<Utc>, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&time.to_rfc3339_opts(SecondsFormat::Millis, true))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<DateTime<Utc>, D::Error> {
        let text = <&str>::deserialize(deserializer)?;
        parse(text.as_bytes()).ok_or_else(|| {
            serde::de::Error::custom(format_args!("`{text}` is not a time of the form 2026-01-31T23:59:59.999Z"))
        })
    }

    fn parse(text: &[u8]) -> Option<DateTime<Utc>> {
        let text: &[u8; 24] = text.try_into().ok()?;
        let number = |from: usize, digits: usize| {
            text[from..from + digits]
                .iter()
                .try_fold(0u32, |n, d| d.is_ascii_digit().then(|| n * 10 + u32::from(d - b'0')))
        };
        let marks = [(4, b'-'), (7, b'-'), (10, b'T'), (13, b':'), (16, b':'), (19, b'.'), (23, b'Z')];
        if marks.iter().any(|&(at, mark)| text[at] != mark) {
            return None;
        }
        let date = NaiveDate::from_ymd_opt(number(0, 4)?.cast_signed(), number(5, 2)?, number(8, 2)?)?;
        Some(date.and_hms_milli_opt(number(11, 2)?, number(14, 2)?, number(17, 2)?, number(20, 3)?)?.and_utc())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::journal::record::{Change, Pause};
    use proptest::prelude::*;

    fn entry(seq: u64, t_ns: u64, ms: i64, record: Record) -> Entry {
        Entry { seq, t_ns, wall: DateTime::from_timestamp_millis(ms).unwrap(), kind: Kind::Simulated, record }
    }

    #[test]
    fn the_check_sum_is_the_one_of_zip() {
        // python 3.11: '%08x' % zlib.crc32(b'{"seq":0,"t_ns":0,"wall":"1970-01-01T00:00:00.000Z","kind":"simulated","record":{"pause":{"reason":"operator"}}')
        let mut line = Vec::new();
        encode(&entry(0, 0, 0, Record::Pause(Pause { reason: "operator".into() })), &mut line).unwrap();
        let expected = concat!(
            r#"{"seq":0,"t_ns":0,"wall":"1970-01-01T00:00:00.000Z","kind":"simulated","#,
            r#""record":{"pause":{"reason":"operator"}},"crc":"CRC"}"#
        );
        let crc = "25f7f87f";
        assert_eq!(String::from_utf8(line).unwrap(), expected.replace("CRC", crc) + "\n");
    }

    proptest! {
        #[test]
        fn what_is_written_is_read(seq: u64, t_ns: u64, ms in 0i64..253_402_300_799_999, choice: u32, text in ".*") {
            for record in [
                Record::Change(Change { presentation: choice, attempt: 0, choice, after_ns: t_ns }),
                Record::Pause(Pause { reason: text.clone() }),
            ] {
                let written = entry(seq, t_ns, ms, record);
                let mut line = Vec::new();
                encode(&written, &mut line).unwrap();
                prop_assert_eq!(line.pop(), Some(b'\n'));
                prop_assert!(!line.contains(&b'\n'));
                prop_assert_eq!(decode(&line).unwrap(), written);
            }
        }

        #[test]
        fn a_flipped_bit_is_found(at: prop::sample::Index, bit in 0u32..8, t_ns: u64) {
            let mut line = Vec::new();
            encode(&entry(7, t_ns, 1_700_000_000_123, Record::Pause(Pause { reason: "operator".into() })), &mut line).unwrap();
            line.pop();
            let at = at.index(line.len());
            line[at] ^= 1 << bit;
            let found = matches!(decode(&line), Err(LineError::NoCheckSum | LineError::CheckSum { .. }));
            prop_assert!(found, "{}", String::from_utf8_lossy(&line));
        }

        #[test]
        fn any_bytes_are_refused_without_a_panic(bytes: Vec<u8>) {
            prop_assert!(decode(&bytes).is_err());
        }
    }
}
