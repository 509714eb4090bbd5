//! The compiled shaders of `shaders/display/`.

use crate::gpu::{Aligned, Shader};

include!(concat!(env!("OUT_DIR"), "/display_shaders.rs"));
