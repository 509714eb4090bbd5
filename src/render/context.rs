//! What every pass of a frame reads: the uniforms, the lights, the instances, the counters, the shared samplers.

use std::cell::Cell;
use std::rc::Rc;

use glam::{DAffine3, DVec3};

use crate::gpu::{Buffer, Dispatch, Filter, Gpu, GpuError, Image, Sampler};
use crate::scene::{Eye, Fallback, Instance, Scene, StereoCamera};

use super::baked::light::BakedLight;
use super::settings::{Firefly, Settings, Streams};
use super::shared::{CountersData, EyeUniform, FrameUniform};
use super::upload::{self, EnvironmentMaps, SceneResources};

/// Frame-wide inputs.
pub struct Context {
    /// Where the head was when this was made: the origin of render space.
    pub head: DVec3,
    /// Corners of everything in the scene, world space.
    bounds: [DVec3; 2],
    guard: [u32; 2],
    pub frame: Buffer,
    uniform: Cell<FrameUniform>,
    pub lights: Buffer,
    pub instances: Buffer,
    pub counters: Buffer,
    pub brdf_table: Rc<Image>,
    /// Empty where no pass reads it.
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

    /// Other eyes, seed or frame number; size and scene are what they were. Between frames only.
    pub fn update(&self, camera: &StereoCamera, settings: &Settings, scene: &Scene) {
        let uniform = frame_uniform(scene, camera, settings, self.guard, (self.head, self.bounds));
        self.frame.write(bytemuck::bytes_of(&uniform));
        self.uniform.set(uniform);
    }

    /// Places the instances of a scene in which something moves. Between frames only.
    pub fn place(&self, scene: &Scene, places: &[DAffine3], resources: &SceneResources) {
        let instances = upload::instances(scene, places, &resources.ranges, self.head);
        self.instances.write(bytemuck::cast_slice(&instances));
    }

    /// What `shade.glsl` and `outgoing.glsl` ask of the surroundings: the environment's two maps, what unknown rays see, the
    /// table of the lobe's albedo, and the lights.
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

    /// What the device has of the frame.
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
        // Beyond it lies nothing of the scene, from anywhere in it: twice the diagonal of its bounds and the head's.
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

/// Corners of the scene and the head.
fn bounds(scene: &Scene, head: DVec3) -> [DVec3; 2] {
    let (mut low, mut high) = (head, head);
    for corner in scene.instances.iter().flat_map(|i| instance_corners(scene, i)) {
        low = low.min(corner);
        high = high.max(corner);
    }
    [low, high]
}

/// Corners of the box of its object's space that an instance fills, world space; its place alone if it is empty.
pub fn instance_corners(scene: &Scene, instance: &Instance) -> [DVec3; 8] {
    let positions = &scene.primitives[instance.primitive].positions;
    let first = positions.first().copied().unwrap_or_default();
    let (low, high) = positions.iter().fold((first, first), |(low, high), &p| (low.min(p), high.max(p)));
    std::array::from_fn(|corner| {
        let pick = |i: usize| f64::from(if corner >> i & 1 == 1 { high[i] } else { low[i] });
        instance.world_from_object.transform_point3(DVec3::new(pick(0), pick(1), pick(2)))
    })
}
