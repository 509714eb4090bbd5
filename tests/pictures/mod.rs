//! Small scenes whose pictures are known, and functions that render and compare them.

use std::f64::consts::{FRAC_PI_2, PI};
use std::rc::Rc;
use std::sync::Arc;

use cyclopean::gpu::{Gpu, GpuOptions, OwnDevice};
use cyclopean::picture::StereoPicture;
use cyclopean::render::{Method, Rendered, Renderer, Request, Settings};
use cyclopean::scene::{Alpha, Instance, Light, Material, Primitive, Scene, StereoCamera, Texture, TextureRef, Wrap};

pub use cyclopean::stress::shapes::{
    constant_environment, glowing, look, material, place, plane, scene, settings, sphere, upright,
};
use glam::{DAffine3, DQuat, DVec3, Mat3, Vec3, Vec4};

/// The best device, with Vulkan validation. A validation message makes rendering fail.
pub fn gpu() -> Rc<Gpu> {
    let options = GpuOptions { validation: true, pipeline_cache: None };
    Gpu::open(&OwnDevice::default(), &options).expect("a Vulkan device; ./x test installs one")
}

/// Renders a frame of the scene's first view. A validation message or a value that is not a number makes it fail.
pub fn render(gpu: &Rc<Gpu>, scene: &Arc<Scene>, method: &str, settings: &Settings) -> Rendered {
    let camera = scene.views[0].stereo_camera(settings.aspect());
    render_from(gpu, scene, method, settings, &camera)
}

pub fn render_from(
    gpu: &Rc<Gpu>,
    scene: &Arc<Scene>,
    method: &str,
    settings: &Settings,
    camera: &StereoCamera,
) -> Rendered {
    let method = Method::parse(method).expect("a method");
    let mut renderer = Renderer::new(gpu, Arc::clone(scene)).expect("uploaded");
    let request = Request { camera, method: &method, settings, frames: 1 };
    renderer.render(&request, &mut |_, _| Ok(())).expect("rendered without a message")
}

/// Σ(x − y)²/Σ(y − ȳ)² over both eyes where `mask` holds.
pub fn relative_squared_error(x: &StereoPicture, y: &StereoPicture, mask: impl Fn(usize, usize) -> bool) -> f64 {
    let (mut pairs, mut sum) = (Vec::new(), 0.0);
    for eye in 0..2 {
        for i in 0..x.eyes[eye].len() {
            if mask(eye, i) {
                for c in 0..3 {
                    let pair = (f64::from(x.eyes[eye][i][c]), f64::from(y.eyes[eye][i][c]));
                    sum += pair.1;
                    pairs.push(pair);
                }
            }
        }
    }
    let mean = sum / pairs.len() as f64;
    let squares = |f: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(|p| f(p) * f(p)).sum::<f64>();
    squares(&|p| p.0 - p.1) / squares(&|p| p.1 - mean)
}

/// The hall, with the eyes so far apart that a small picture shows what only one of them sees.
pub fn hall(roughness: f32) -> Arc<Scene> {
    Arc::new(cyclopean::stress::shapes::hall(roughness, 0.3))
}

/// A material that reflects diffusely.
pub fn chalk() -> Material {
    Material { metallic: 0.0, ..material(1.0) }
}

/// The parts with a floor at y = 0, seen from above.
pub fn with_floor(mut parts: Vec<(Primitive, Material, DAffine3)>, lights: Vec<Light>) -> Arc<Scene> {
    parts.insert(0, (plane(2), chalk(), DAffine3::from_scale(DVec3::new(10.0, 1.0, 10.0))));
    let mut made = scene(parts, 0.0, look(DVec3::new(0.3, 3.0, 2.5), DVec3::new(0.0, 0.0, 0.0)));
    made.lights = lights;
    Arc::new(made)
}

/// The six sides of a box, from −a to a in x and z, that floats above the floor between the heights `low` and `high`.
pub fn floating_box(a: f64, low: f64, high: f64) -> Vec<(Primitive, Material, DAffine3)> {
    let (middle, half) = ((low + high) / 2.0, (high - low) / 2.0);
    let side = |turn: DQuat, scale: [f64; 3], at: [f64; 3]| {
        let place = DAffine3::from_translation(at.into())
            * DAffine3::from_quat(turn)
            * DAffine3::from_scale(2.0 * DVec3::from(scale));
        (plane(1), chalk(), place)
    };
    let (x, z) = (DQuat::from_rotation_x(FRAC_PI_2), DQuat::from_rotation_z(-FRAC_PI_2));
    vec![
        side(DQuat::IDENTITY, [a, 1.0, a], [0.0, high, 0.0]),
        side(DQuat::from_rotation_x(PI), [a, 1.0, a], [0.0, low, 0.0]),
        side(x, [a, 1.0, half], [0.0, middle, a]),
        side(x.inverse(), [a, 1.0, half], [0.0, middle, -a]),
        side(z, [half, 1.0, a], [a, middle, 0.0]),
        side(z.inverse(), [half, 1.0, a], [-a, middle, 0.0]),
    ]
}

/// The hall with cut-out lattices, single- and double-sided, one of them mirrored. It has everything that two ways of
/// tracing rays could treat differently.
pub fn lattices() -> Scene {
    let mut scene = cyclopean::stress::shapes::hall(0.3, 0.064);
    let texels: Vec<u8> = (0..64).flat_map(|i| [255, 255, 255, if (i / 8 + i) % 2 == 0 { 255 } else { 0 }]).collect();
    scene.textures.push(Texture {
        name: "lattice".to_owned(),
        width: 8,
        height: 8,
        rgba8: Arc::new(texels),
        srgb: true,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        nearest: true,
    });
    let transform = Mat3::from_diagonal(Vec3::new(2.0, 2.0, 1.0));
    let turned = upright() * DQuat::from_rotation_z(0.4);
    for (i, (double_sided, scale_x, shape)) in
        [(false, 1.0, plane(3)), (true, 1.0, plane(3)), (false, -1.0, plane(3)), (true, 0.4, sphere(8))]
            .into_iter()
            .enumerate()
    {
        let mut primitive = shape;
        primitive.material = scene.materials.len();
        let base_color_texture = Some(TextureRef { texture: 0, uv_set: 0, transform });
        let material = Material {
            double_sided,
            alpha: Alpha::Mask { cutoff: 0.5 },
            base_color_texture,
            ..glowing(Vec3::new(0.9, 0.2, 0.4))
        };
        scene.materials.push(Material { base_color: Vec4::ONE, ..material });
        let at = [1.0 * i as f64 - 1.6, 0.6, -1.2 - 0.3 * i as f64];
        let world_from_object = place([scale_x, 1.0, 1.0], turned, at);
        let primitive_index = scene.primitives.len();
        scene.primitives.push(primitive);
        scene.instances.push(Instance {
            primitive: primitive_index,
            world_from_object,
            previous_world_from_object: world_from_object,
        });
    }
    scene
}

pub fn values(picture: &StereoPicture) -> impl Iterator<Item = f32> {
    picture.eyes.iter().flatten().flatten().copied()
}

/// The difference over its standard error, for every value with noise. Where all paths agree (mirrors, black) the
/// estimated errors are only rounding, so that these values are left out.
pub fn deviations(a: &Rendered, b: &Rendered) -> Vec<f64> {
    let (Some(ea), Some(eb)) = (&a.error, &b.error) else { panic!("the reference has a standard error") };
    values(&a.reflection)
        .zip(values(&b.reflection))
        .zip(values(ea).zip(values(eb)))
        .filter(|((x, _), (ex, ey))| ex.hypot(*ey) > 1e-3 * x.abs().max(1e-6))
        .map(|((x, y), (ex, ey))| f64::from((x - y) / ex.hypot(ey)))
        .collect()
}
