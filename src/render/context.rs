//! What the passes of a frame share: uniforms, lights, instances, counters, the BRDF table, baked light and samplers.
//!
//! `Renderer::prepare` makes a [`Context`] for each prepared view, relative to its head.

use std::cell::Cell;
use std::rc::Rc;

use glam::{DAffine3, DVec3};

use crate::gpu::{Buffer, Dispatch, Filter, Gpu, GpuError, Image, Sampler};
use crate::scene::{Eye, Fallback, Instance, Scene, StereoCamera};

use super::baked::light::BakedLight;
use super::settings::{Firefly, Settings, Streams};
use super::shared::{CountersData, EyeUniform, FrameUniform};
use super::upload::{self, EnvironmentMaps, SceneResources};

/// See the module's documentation.
pub struct Context {
    /// Where the head was when this was made, in world space: the origin of render space.
    pub head: DVec3,
    /// Lower and upper corner of the box around the scene and the head, world space.
    bounds: [DVec3; 2],
    guard: [u32; 2],
    pub frame: Buffer,
    uniform: Cell<FrameUniform>,
    pub lights: Buffer,
    pub instances: Buffer,
    pub counters: Buffer,
    pub brdf_table: Rc<Image>,
    /// A placeholder where no pass reads it.
    pub baked: Rc<BakedLight>,
    pub nearest: Sampler,
    pub linear: Sampler,
}

impl Context {
    /// # Errors
    /// When device memory runs out.
    pub fn new(
        gpu: &Rc<Gpu>,
        scene: &Scene,
        resources: &SceneResources,
        (brdf_table, baked): (Rc<Image>, Rc<BakedLight>),
        (camera, settings, guard): (&StereoCamera, &Settings, [u32; 2]),
    ) -> Result<Context, GpuError> {
        let head = camera.head();
        let bounds = bounds(scene, head);
        let words = |n: usize| n as u64 * 4;
        let frame = Buffer::upload(gpu, "frame", size_of::<FrameUniform>() as u64)?;
        let uniform = frame_uniform(scene, camera, settings, guard, (head, bounds));
        frame.write(bytemuck::bytes_of(&uniform));
        let instances = upload::instance_buffer(gpu, scene, &scene.places(), &resources.ranges, head)?;
        Ok(Context {
            head,
            bounds,
            guard,
            frame,
            uniform: Cell::new(uniform),
            lights: Buffer::with_content(gpu, "lights", &upload::lights(scene, head))?,
            instances,
            counters: Buffer::device(gpu, "counters", words(size_of::<CountersData>() / 4))?,
            brdf_table,
            baked,
            nearest: Sampler::new(gpu, Filter::NEAREST)?,
            linear: Sampler::new(gpu, Filter::LINEAR)?,
        })
    }

    /// Sets other eyes, another seed or another frame number for the next frame. Size and scene must be the same as before. Must
    /// not be called during a frame.
    pub fn update(&self, camera: &StereoCamera, settings: &Settings, scene: &Scene) {
        let uniform = frame_uniform(scene, camera, settings, self.guard, (self.head, self.bounds));
        self.frame.write(bytemuck::bytes_of(&uniform));
        self.uniform.set(uniform);
    }

    /// Moves the instances to `places`. For scenes with motions only; must not be called during a frame.
    pub fn place(&self, scene: &Scene, places: &[DAffine3], resources: &SceneResources) {
        let instances = upload::instances(scene, places, &resources.ranges, self.head);
        self.instances.write(bytemuck::cast_slice(&instances));
    }

    /// Binds what `shade.glsl` and `outgoing.glsl` need in the passes of the filter: the environment's radiance and irradiance,
    /// the prefiltered map that stands in for unknown rays, the BRDF table, and the lights.
    pub fn bind_surroundings<'f>(
        &'f self,
        chain: Dispatch<'f>,
        environment: &'f EnvironmentMaps,
        fallback: &'f EnvironmentMaps,
    ) -> Dispatch<'f> {
        chain
            .sampled(&environment.radiance, &environment.sampler)
            .sampled(&environment.irradiance, &environment.sampler)
            .sampled(&fallback.specular, &fallback.sampler)
            .sampled(&self.brdf_table, &self.linear)
            .read_buffer(&self.lights)
    }

    /// Binds what `shade.glsl` reads: the environment's three maps and the table of the lobe's albedo.
    pub fn bind_environment<'f>(&'f self, chain: Dispatch<'f>, environment: &'f EnvironmentMaps) -> Dispatch<'f> {
        chain
            .sampled(&environment.radiance, &environment.sampler)
            .sampled(&environment.irradiance, &environment.sampler)
            .sampled(&environment.specular, &environment.sampler)
            .sampled(&self.brdf_table, &self.linear)
    }

    /// The uniforms as they are on the device.
    pub fn uniform(&self) -> FrameUniform {
        self.uniform.get()
    }
}

fn frame_uniform(
    scene: &Scene,
    camera: &StereoCamera,
    settings: &Settings,
    guard: [u32; 2],
    (head, [low, high]): (DVec3, [DVec3; 2]),
) -> FrameUniform {
    let eyes = Eye::BOTH.map(|eye| {
        let e = camera.eye(eye);
        let view_from_render = e.view_from_relative(head);
        let p = (e.position - head).as_vec3();
        let [left, right, down, up] = [e.fov.left_rad, e.fov.right_rad, e.fov.down_rad, e.fov.up_rad].map(f64::tan);
        let direction = |view: DVec3| (e.world_from_view * view).as_vec3().extend(0.0).to_array();
        let token = match settings.streams {
            Streams::Independent => eye.layer() as u32,
            Streams::Shared => 0,
        };
        EyeUniform {
            clip_from_render: (e.clip_from_view() * view_from_render).to_cols_array(),
            view_from_render: view_from_render.to_cols_array(),
            ray_first: direction(DVec3::new(left, up, -1.0)),
            ray_across: direction(DVec3::new((right - left) / f64::from(settings.width), 0.0, 0.0)),
            ray_down: direction(DVec3::new(0.0, (down - up) / f64::from(settings.height), 0.0)),
            position_near: [p.x, p.y, p.z, e.near_m as f32],
            stream: [token, 0, 0, 0],
        }
    });
    FrameUniform {
        eyes,
        size: [settings.width, settings.height],
        seed: settings.seed,
        frame: settings.frame,
        ray_roughness_limit: settings.ray_roughness_limit,
        delta_roughness: settings.delta_roughness,
        open_mesh_thickness: scene.open_mesh_thickness_m,
        edge_fade: settings.edge_fade,
        // Longer than any way through the scene: twice the diagonal of the box around the scene and the head.
        ray_length: (2.0 * (high.max(camera.head()) - low.min(camera.head())).length()).max(1e-3) as f32,
        exposure: scene.exposure,
        light_count: scene.lights.len() as u32,
        max_steps: settings.max_steps,
        fallback: u32::from(settings.fallback(scene) != Fallback::Black),
        firefly: match settings.firefly {
            None | Some(Firefly::None) => 0,
            Some(Firefly::ToneMapped) => 1,
            Some(Firefly::BoundedShare) => 2,
        },
        guard,
    }
}

/// Lower and upper corner of the box around the scene and the head, world space.
fn bounds(scene: &Scene, head: DVec3) -> [DVec3; 2] {
    let (mut low, mut high) = (head, head);
    for corner in scene.instances.iter().flat_map(|i| instance_corners(scene, i)) {
        low = low.min(corner);
        high = high.max(corner);
    }
    [low, high]
}

/// The eight corners, in world space, of an instance's bounding box in object space. Without vertices all of them are the
/// instance's origin.
pub fn instance_corners(scene: &Scene, instance: &Instance) -> [DVec3; 8] {
    let positions = &scene.primitives[instance.primitive].positions;
    let first = positions.first().copied().unwrap_or_default();
    let (low, high) = positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    std::array::from_fn(|corner| {
        let pick = |i: usize| f64::from(if corner >> i & 1 == 1 { high[i] } else { low[i] });
        instance.world_from_object.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    })
}
