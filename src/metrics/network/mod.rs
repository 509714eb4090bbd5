//! Distances that a trained network measures: LPIPS (Zhang et al. 2018), DISTS (Ding et al. 2020), and any other network that
//! keeps the contract of `docs/compare.md`, *Networks*. The user names the files; none comes with the program.

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

/// The most bytes of a network's file.
pub const MOST_BYTES: u64 = 1 << 30;

/// The largest distance of two equal pictures: what rounding may leave of 0.
const ALIKE: f64 = 1e-3;

/// What networks measure, in the order of the tables.
pub const MEASURES: [&str; 2] = ["lpips", "dists"];

/// Which of [`MEASURES`] a key of a result is: of the composite, or with `reflection_` before it of the reflection alone.
/// `None`: no network measures it.
pub fn measure_of(key: &str) -> Option<&'static str> {
    let measure = key.strip_prefix("reflection_").unwrap_or(key);
    MEASURES.into_iter().find(|m| *m == measure)
}

/// A network cannot be used, or not for these pictures.
#[derive(Debug, thiserror::Error)]
pub enum NetworkError {
    #[error(
        "this build runs no networks; one with the feature `networks` does: cargo build --release --features networks"
    )]
    Absent,
    #[error("it is no network that compares two pictures: {0}")]
    Unusable(String),
    #[error("it compares pictures of at least {least}×{least} pixels, and these have {width}×{height}")]
    TooSmall { least: usize, width: usize, height: usize },
}

/// A network in the host's memory.
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
    /// From the content of an ONNX file; `measure` is one of [`MEASURES`].
    ///
    /// # Errors
    /// The build runs no networks, or this is none that it can run.
    pub fn new(measure: &'static str, onnx: &[u8]) -> Result<Network, NetworkError> {
        let sha256 = format!("{:x}", Sha256::digest(onnx));
        Ok(Network { measure, sha256, model: Model::parse(onnx)? })
    }

    /// One of [`MEASURES`].
    pub fn measure(&self) -> &'static str {
        self.measure
    }

    /// SHA-256 of the file, hexadecimal.
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Makes the network ready for pictures of `width`×`height` pixels, and tries it on two black ones.
    ///
    /// # Errors
    /// The pictures are too small, or the network gives no number for them, or one that is not near 0.
    pub fn prepare(&self, size: (usize, usize)) -> Result<(), NetworkError> {
        let black = vec![[0.0; 3]; size.0 * size.1];
        let wrong = |found: String| Err(NetworkError::Unusable(format!("of two equal pictures it says {found}")));
        match self.distance(size, &black, &black)? {
            None => wrong("no finite number".to_owned()),
            Some(distance) if distance.abs() > ALIKE => wrong(format!("{distance}, and not 0")),
            Some(_) => Ok(()),
        }
    }

    /// The distance of `picture` from `reference`, both sRGB-encoded display values in [0, 1], rows from the top. 0: alike;
    /// `None`: the network gives no finite number.
    ///
    /// # Errors
    /// As [`Network::prepare`].
    ///
    /// # Panics
    /// When a picture has not that many pixels.
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

/// The networks that a comparison uses, one a measure at the most.
#[derive(Debug, Default)]
pub struct Networks(Vec<Network>);

impl Networks {
    /// In the order of [`MEASURES`].
    pub fn new(mut networks: Vec<Network>) -> Networks {
        networks.sort_by_key(|n| MEASURES.iter().position(|m| *m == n.measure));
        networks.dedup_by_key(|n| n.measure);
        Networks(networks)
    }

    pub fn iter(&self) -> impl Iterator<Item = &Network> {
        self.0.iter()
    }

    /// Whether there is a network for one of [`MEASURES`].
    pub fn measures(&self, measure: &str) -> bool {
        self.0.iter().any(|n| n.measure == measure)
    }

    /// The distance by each of [`MEASURES`]; `None` without its network, or where it gives no finite number. See
    /// [`Network::distance`].
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
