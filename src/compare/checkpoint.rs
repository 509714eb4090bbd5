//! Keeps the sums of a reference's paths in a file, so that a later run can add paths: after Ctrl-C, or for a larger
//! number of paths. The file also has the errors that were found at the checks so far. `reference` calls it. A damaged
//! file counts as missing.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, WriteError};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::render::Prepared;
use crate::render::cpu::{KeptPixel, KeptSums};

use super::CompareError;

/// The most bytes of a file that is read. A file has 48 bytes for each pixel of both eyes.
const MOST_KEPT: u64 = 32 << 30;
/// The version of the layout of the files. A file of another version counts as missing.
const VERSION: u32 = 1;

/// The kept sums of the paths of a view with one seed, whatever their number.
pub struct Checkpoint {
    file: PathBuf,
    content: Option<CheckpointContent>,
}

/// The content of a file. The file begins with a digest of the rest, then there is a line of JSON, then the sums of the
/// pixels.
#[derive(Debug, Clone, PartialEq)]
struct CheckpointContent {
    /// The relative error that was found at each number of samples.
    checks: BTreeMap<u32, f64>,
    /// The sums of paths that the processor traced. `None`: the graphics card traced them, so there are none.
    sums: Option<KeptSums>,
}

#[derive(Serialize, Deserialize)]
struct Header {
    version: u32,
    samples: Option<u32>,
    checks: BTreeMap<u32, f64>,
}

impl Checkpoint {
    /// Reads what is kept of a reference. `key` names the reference, and `number` says which of its seeds.
    pub fn open(cache: &Path, key: &str, number: usize) -> Checkpoint {
        let file = cache.join("paths").join(format!("{key}-{number}.paths"));
        let content = CheckpointContent::read(&file);
        Checkpoint { file, content }
    }

    /// The smallest number of samples, up to `most`, at which the error was found to be at most `until`. `None`: no
    /// check so far found that.
    pub fn count_for(&self, until: f64, most: u32) -> Option<u32> {
        let checks = &self.content.as_ref()?.checks;
        checks.range(..=most).find(|(_, error)| **error <= until).map(|(count, _)| *count)
    }

    /// Lends the sums to the next frame, unless they have more samples than it asks for.
    pub fn resume(&self, prepared: &Prepared) {
        let sums = self.content.as_ref().and_then(|s| s.sums.as_ref());
        prepared.continue_from(sums.filter(|s| s.samples <= prepared.method().samples()).cloned());
    }

    /// Keeps the sums of the last frame, whether it was finished or not, unless sums with more samples are kept
    /// already.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn keep(&mut self, prepared: &Prepared) -> Result<(), CompareError> {
        let sums = prepared.sums();
        let mut checks: BTreeMap<u32, f64> = prepared.checks().into_iter().collect();
        if sums.is_none() && checks.is_empty() {
            return Ok(());
        }
        // Another program may have added more paths in the meantime.
        self.content = CheckpointContent::read(&self.file);
        let pixels = |sums: &Option<KeptSums>| -> Option<Vec<u32>> {
            Some(sums.as_ref()?.pixels.iter().map(KeptPixel::packed).collect())
        };
        if let Some(before) = self.content.as_ref().filter(|s| pixels(&s.sums) == pixels(&sums)) {
            let samples = |sums: &Option<KeptSums>| sums.as_ref().map_or(0, |s| s.samples);
            if samples(&before.sums) > samples(&sums) {
                return Ok(());
            }
            checks.extend(&before.checks);
        }
        let content = CheckpointContent { checks, sums };
        if self.content.as_ref() != Some(&content) {
            let folder = self.file.parent().unwrap_or(Path::new("."));
            std::fs::create_dir_all(folder).map_err(|source| WriteError { path: folder.to_owned(), source })?;
            files::write_bytes(&self.file, &content.encode()?)?;
            self.content = Some(content);
        }
        Ok(())
    }
}

impl CheckpointContent {
    fn read(file: &Path) -> Option<CheckpointContent> {
        files::read(file, MOST_KEPT).ok().and_then(|bytes| CheckpointContent::decode(&bytes))
    }

    fn encode(&self) -> Result<Vec<u8>, serde_json::Error> {
        let samples = self.sums.as_ref().map(|s| s.samples);
        let mut rest = serde_json::to_vec(&Header { version: VERSION, samples, checks: self.checks.clone() })?;
        rest.push(b'\n');
        if let Some(sums) = &self.sums {
            rest.extend_from_slice(bytemuck::cast_slice(&sums.pixels));
        }
        let mut bytes = Sha256::digest(&rest).to_vec();
        bytes.append(&mut rest);
        Ok(bytes)
    }

    fn decode(bytes: &[u8]) -> Option<CheckpointContent> {
        let (digest, rest) = bytes.split_at_checked(32)?;
        if Sha256::digest(rest).as_slice() != digest {
            return None;
        }
        let end = rest.iter().position(|b| *b == b'\n')?;
        let header: Header = serde_json::from_slice(&rest[..end]).ok()?;
        let pixels = rest[end + 1..].chunks_exact(size_of::<KeptPixel>()).map(bytemuck::pod_read_unaligned);
        let sums = header.samples.map(|samples| KeptSums { samples, pixels: pixels.collect() });
        (header.version == VERSION).then_some(CheckpointContent { checks: header.checks, sums })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_and_nothing_else() {
        let pixels: Vec<KeptPixel> = vec![bytemuck::Zeroable::zeroed(); 3];
        let content = CheckpointContent {
            checks: BTreeMap::from([(16, 0.25), (32, 0.1)]),
            sums: Some(KeptSums { samples: 40, pixels }),
        };
        let bytes = content.encode().expect("JSON");
        assert_eq!(CheckpointContent::decode(&bytes), Some(content));
        for at in [0, 40, bytes.len() - 1] {
            let mut wrong = bytes.clone();
            wrong[at] ^= 1;
            assert_eq!(CheckpointContent::decode(&wrong), None, "byte {at}");
        }
        assert_eq!(CheckpointContent::decode(&bytes[..20]), None);
    }

    #[test]
    fn the_first_count_that_is_good_enough_is_known() {
        let content =
            Some(CheckpointContent { checks: BTreeMap::from([(16, 0.25), (32, 0.1), (48, 0.08)]), sums: None });
        let checkpoint = Checkpoint { file: PathBuf::new(), content };
        assert_eq!(checkpoint.count_for(0.1, 64), Some(32));
        assert_eq!(checkpoint.count_for(0.1, 16), None);
        assert_eq!(checkpoint.count_for(0.01, 64), None);
    }
}
