//! Stands in for the runtime in a build without the feature `networks`.

use super::NetworkError;

/// There is none.
pub enum Model {}

impl Model {
    /// # Errors
    /// [`NetworkError::Absent`], always.
    pub fn parse(_onnx: &[u8]) -> Result<Model, NetworkError> {
        Err(NetworkError::Absent)
    }

    /// Nobody has a model to ask.
    pub fn distance(&self, _size: (usize, usize), _pictures: [&[[f32; 3]]; 2]) -> Result<Option<f64>, NetworkError> {
        match *self {}
    }
}
