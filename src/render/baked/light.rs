//! Baked light on a device, as passes read it.

use std::rc::Rc;

use ash::vk;

use crate::gpu::{Dispatch, Gpu, GpuError, Image, ImageDesc, Sampler};

/// Baked light on a device.
pub struct BakedLight {
    pub(super) patches: Image,
    pub(super) light: Image,
    pub(super) gathered: HostBakedLight,
}

/// Baked light in the host's memory.
#[derive(Default)]
pub struct HostBakedLight {
    /// See [`super::lattice::Lattice::patches`].
    pub patches: Vec<u32>,
    /// For each point irradiance / π in red, green and blue, then 1.
    pub light: Vec<[f32; 4]>,
}

impl BakedLight {
    /// A placeholder without any light.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn placeholder(gpu: &Rc<Gpu>) -> Result<BakedLight, GpuError> {
        let desc = ImageDesc::texture(1, 1, 1, vk::Format::R32G32B32A32_UINT);
        let image = |what| Image::with_content(gpu, what, desc, &[vec![0; 16]]);
        Ok(BakedLight { patches: image("no patches")?, light: image("no light")?, gathered: HostBakedLight::default() })
    }

    /// The same light in the host's memory, for paths that the processor traces.
    pub fn gathered(&self) -> &HostBakedLight {
        &self.gathered
    }

    /// Binds what `baked.glsl` reads.
    pub fn bind<'f>(&'f self, chain: Dispatch<'f>, nearest: &'f Sampler) -> Dispatch<'f> {
        chain.sampled(&self.patches, nearest).sampled(&self.light, nearest)
    }
}
