//! Stands in for `tract` in a build without the feature `networks`. `super` calls it.

use super::NetworkError;

/// A network. It has no values, because this build cannot run any.
pub enum Model {}

impl Model {
    /// # Errors
    /// [`NetworkError::Absent`], always.
    pub fn parse(_onnx: &[u8]) -> Result<Model, NetworkError> {
        Err(NetworkError::Absent)
    }

    /// This can never be called, because there is no [`Model`].
    pub fn distance(&self, _size: (usize, usize), _pictures: [&[[f32; 3]]; 2]) -> Result<Option<f64>, NetworkError> {
        match *self {}
    }
}
