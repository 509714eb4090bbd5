//! The networks that a command names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use cyclopean_analysis::files;

use super::WrongUsage;
use crate::metrics::Networks;
use crate::metrics::network::{MOST_BYTES, Network, NetworkError};

/// Files with networks, in ONNX. `docs/compare.md`, *Networks*, says how they are made.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct NetworkFiles {
    /// The network of LPIPS, an ONNX file as scripts/export_networks.py writes it. Without one there are no columns of it.
    #[arg(long, value_name = "FILE")]
    pub lpips: Option<PathBuf>,
    /// The network of DISTS, likewise.
    #[arg(long, value_name = "FILE")]
    pub dists: Option<PathBuf>,
}

impl NetworkFiles {
    /// Reads the networks and tries each of them on pictures of `size`, before anything is rendered.
    ///
    /// # Errors
    /// A file that cannot be read, or a network that cannot compare such pictures. Exit code 2 where this build runs no
    /// networks or the pictures are too small.
    pub fn load(&self, size: (usize, usize)) -> anyhow::Result<Arc<Networks>> {
        let named = [("lpips", &self.lpips), ("dists", &self.dists)];
        let named = named.into_iter().filter_map(|(measure, path)| Some((measure, path.as_deref()?)));
        let networks = named.map(|(measure, path)| network(measure, path, size)).collect::<anyhow::Result<_>>()?;
        Ok(Arc::new(Networks::new(networks)))
    }

    /// The same on a command line.
    #[cfg(feature = "gpu")]
    pub fn named(&self) -> impl Iterator<Item = (&'static str, &Path)> {
        let named = [("--lpips", &self.lpips), ("--dists", &self.dists)];
        named.into_iter().filter_map(|(option, path)| Some((option, path.as_deref()?)))
    }
}

fn network(measure: &'static str, path: &Path, size: (usize, usize)) -> anyhow::Result<Network> {
    let refused = |error: NetworkError| {
        let text = format!("--{measure} {}: {error}", path.display());
        match error {
            NetworkError::Unusable(_) => anyhow::anyhow!(text),
            NetworkError::Absent | NetworkError::TooSmall { .. } => WrongUsage(text).into(),
        }
    };
    let onnx = files::read(path, MOST_BYTES).with_context(|| format!("cannot read --{measure} {}", path.display()))?;
    let network = Network::new(measure, &onnx).map_err(refused)?;
    network.prepare(size).map_err(refused)?;
    Ok(network)
}
