//! Distances between two pictures by a trained network: LPIPS (Zhang et al. 2018), DISTS (Ding et al. 2020), or another
//! network that does what `docs/compare.md`, *Networks*, asks of it. The content of an ONNX file and two pictures go
//! in, and a number comes out. The user names the files; none comes with the program. `compare` and the command that
//! compares two pictures call it.

#[cfg(not(feature = "networks"))]
mod absent;
#[cfg(feature = "networks")]
mod tract;

use std::fmt;

use sha2::{Digest, Sha256};

#[cfg(not(feature = "networks"))]
use absent::Model;
#[cfg(feature = "networks")]
use tract::Model;

/// The most bytes that the file of a network may have.
pub const MOST_BYTES: u64 = 1 << 30;

/// The largest distance that a network may find between two equal pictures. It would be 0 without rounding.
const ALIKE: f64 = 1e-3;

/// The names of the measures that networks compute, in the order of the tables.
pub const MEASURES: [&str; 2] = ["lpips", "dists"];

/// Which of [`MEASURES`] a key of a result belongs to. A key with `reflection_` in front is of the reflection alone,
/// one without it of the composite. `None`: no network computes it.
pub fn measure_of(key: &str) -> Option<&'static str> {
    let measure = key.strip_prefix("reflection_").unwrap_or(key);
    MEASURES.into_iter().find(|m| *m == measure)
}

/// A network cannot be used at all, or not for pictures of this size.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    #[error(
        "this build cannot run networks. Build with the feature `networks`: cargo build --release --features networks"
    )]
    Absent,
    #[error("it is not a network that compares two pictures: {0}")]
    Unusable(String),
    #[error("it needs pictures of at least {least}×{least} pixels, and these have {width}×{height}")]
    TooSmall { least: usize, width: usize, height: usize },
}

/// A network that was read and can compare pictures.
pub struct Network {
    measure: &'static str,
    sha256: String,
    model: Model,
}

impl fmt::Debug for Network {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Network").field("measure", &self.measure).field("sha256", &self.sha256).finish()
    }
}

impl Network {
    /// Reads the content of an ONNX file. `measure` is one of [`MEASURES`].
    ///
    /// # Errors
    /// This build cannot run networks, or the file is not a network that it can run.
    pub fn new(measure: &'static str, onnx: &[u8]) -> Result<Network, NetworkError> {
        let sha256 = format!("{:x}", Sha256::digest(onnx));
        Ok(Network { measure, sha256, model: Model::parse(onnx)? })
    }

    /// What the network measures: one of [`MEASURES`].
    pub fn measure(&self) -> &'static str {
        self.measure
    }

    /// The SHA-256 of the file, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Makes the network ready for pictures of `size` (width, height) pixels, and tries it on two black pictures.
    ///
    /// # Errors
    /// The pictures are too small, the network gives no finite number for the two black ones, or that number is not
    /// near 0.
    pub fn prepare(&self, size: (usize, usize)) -> Result<(), NetworkError> {
        let black = vec![[0.0; 3]; size.0 * size.1];
        let wrong = |found: String| Err(NetworkError::Unusable(format!("for two equal pictures it gives {found}")));
        match self.distance(size, &black, &black)? {
            None => wrong("no finite number".to_owned()),
            Some(distance) if distance.abs() > ALIKE => wrong(format!("{distance}, and not 0")),
            Some(_) => Ok(()),
        }
    }

    /// The distance of `picture` from `reference`. Both are sRGB-encoded display values in [0, 1], rows from the top.
    /// Equal pictures have a distance of about 0. `None`: the network gives no finite number.
    ///
    /// # Errors
    /// As [`Network::prepare`].
    ///
    /// # Panics
    /// When a picture does not have `width`×`height` pixels.
    pub fn distance(
        &self,
        (width, height): (usize, usize),
        reference: &[[f32; 3]],
        picture: &[[f32; 3]],
    ) -> Result<Option<f64>, NetworkError> {
        assert_eq!([reference.len(), picture.len()], [width * height; 2], "pictures of one size");
        self.model.distance((width, height), [reference, picture])
    }
}

/// The networks that a comparison uses, at most one for each measure.
#[derive(Debug, Default)]
pub struct Networks(Vec<Network>);

impl Networks {
    /// Sorts networks into the order of [`MEASURES`]. Of several with the same measure the first is kept.
    pub fn new(mut networks: Vec<Network>) -> Networks {
        networks.sort_by_key(|n| MEASURES.iter().position(|m| *m == n.measure));
        networks.dedup_by_key(|n| n.measure);
        Networks(networks)
    }

    pub fn iter(&self) -> impl Iterator<Item = &Network> {
        self.0.iter()
    }

    /// Whether there is a network for this measure, which is one of [`MEASURES`].
    pub fn measures(&self, measure: &str) -> bool {
        self.0.iter().any(|n| n.measure == measure)
    }

    /// The distance by each of [`MEASURES`], as [`Network::distance`] gives it. `None` where there is no network for
    /// the measure, or where the network gives no finite number.
    ///
    /// # Errors
    /// As [`Network::prepare`].
    pub fn distances(
        &self,
        size: (usize, usize),
        reference: &[[f32; 3]],
        picture: &[[f32; 3]],
    ) -> Result<[Option<f64>; MEASURES.len()], NetworkError> {
        let mut found = [None; MEASURES.len()];
        for (found, measure) in found.iter_mut().zip(MEASURES) {
            let network = self.0.iter().find(|n| n.measure == measure);
            *found = network.map(|n| n.distance(size, reference, picture)).transpose()?.flatten();
        }
        Ok(found)
    }
}
