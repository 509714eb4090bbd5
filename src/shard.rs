//! Splits a list of work into parts, so that several machines can each do one. The commands read a [`Shard`] from their
//! arguments. They then take that part of the stimuli of a study (`study::prepare`) or of the scenes of a comparison.

/// One part of n. Item i of a list belongs to part i mod n.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which part it is, counted from 0.
    pub index: u32,
    pub count: u32,
}

impl Shard {
    /// The only part: all of the list.
    pub const WHOLE: Shard = Shard { index: 0, count: 1 };

    /// The items of this part, in the order of the list.
    pub fn of<T>(self, items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        let (index, count) = (u64::from(self.index), u64::from(self.count.max(1)));
        items.into_iter().zip(0u64..).filter(move |(_, i)| i % count == index).map(|(item, _)| item)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    /// Reads `i/n`, where i is from 0 to n − 1.
    fn from_str(text: &str) -> Result<Shard, String> {
        let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse::<u32>().ok()?, n.parse::<u32>().ok()?)));
        match parsed {
            Some((index, count)) if index < count => Ok(Shard { index, count }),
            _ => Err(format!("`{text}` is not `i/n` with i from 0 to n − 1, such as 0/4")),
        }
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_has_one_part() {
        let part = |index| Shard { index, count: 3 }.of("abcdefg".chars()).collect::<String>();
        assert_eq!([part(0), part(1), part(2)], ["adg", "be", "cf"]);
        assert_eq!(Shard { index: 9, count: 10 }.of(0..3).count(), 0);
        assert_eq!(Shard::WHOLE.of(0..3).collect::<Vec<_>>(), [0, 1, 2]);
    }

    #[test]
    fn parts_are_read_as_they_are_written() {
        for text in ["0/1", "2/3", "7/4294967295"] {
            assert_eq!(text.parse::<Shard>().expect("a part").to_string(), text);
        }
        for bad in ["", "1", "0/0", "3/3", "-1/2", "1/-2", "a/b", "0/4294967296", "0/1/2"] {
            assert!(bad.parse::<Shard>().expect_err("refused").contains("such as 0/4"), "{bad}");
        }
    }
}
