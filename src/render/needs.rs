//! What a frame needs, decided from the scene and the method; the rest is left out: no pass, no memory, no branch.
//!
//! Each predicate is conservative: it proves the image unchanged.

use crate::scene::{Alpha, Fallback, Light, Material, Scene};

use super::method::Ao;
use super::method::{Blend, HitSource, Method, Reuse, Traversal};
use super::settings::{Settings, ShadingReuse, Shadows};

/// Rays to the rim of a light's disc: where all are alike, the pixel lies in no penumbra.
pub const RIM_RAYS: u32 = 6;

/// A pass (or a part of one) and why it runs or not.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct PassDecision {
    pub name: &'static str,
    #[serde(skip)]
    pub runs: bool,
    pub why: String,
}

/// The decisions of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Needs {
    /// Some material emits.
    pub emission: bool,
    /// Some material is cut out.
    pub mask: bool,
    /// Lights cast shadows.
    pub shadows: bool,
    /// Those on the views are found in maps; at what rays hit they are found by rays all the same.
    pub shadow_maps: bool,
    /// The eyes share what lights put on them.
    pub shading_reuse: bool,
    /// Baked light stands in for the environment's diffuse light.
    pub indirect: bool,
    /// The picture is put together here; a finer twin of the view leaves that to the view.
    pub composite: bool,
    /// Light passes through some material.
    pub glass: bool,
    /// Back faces bound the matter of closed meshes.
    pub back_faces: bool,
    /// Some surface may trace a ray.
    pub rays: bool,
    /// Depth pyramid and screen-space march.
    pub screen_space: bool,
    /// Hits are filtered.
    pub resolve: bool,
    /// A probe stands in for unknown rays.
    pub probe: bool,
    /// Rays through the scene's geometry.
    pub path_trace: bool,
    /// The processor traces them, and the device has no part in it.
    pub cpu_paths: bool,
    /// The shadows of the views are traced by the processor.
    pub cpu_shadows: bool,
    /// Rays that the views lose ask the scene's geometry.
    pub geometry: bool,
    /// The filter keeps the variance of what it finds.
    pub moments: bool,
    /// What an eye's filter knows is kept apart from what it makes of it: for the other eye or the frames to come.
    pub pairs: bool,
    /// What the frames before knew is used.
    pub accumulate: bool,
    /// Something moves by itself, and the last frame is asked where it was.
    pub motion: bool,
    /// The eyes are blended by it.
    pub blend_by_variance: bool,
    /// How the visibility of the surroundings is found.
    pub ao: Ao,
    decisions: Vec<PassDecision>,
}

impl Needs {
    /// What `method` needs of `scene`.
    pub fn of(scene: &Scene, method: &Method, settings: &Settings) -> Needs {
        let all = settings.all_passes;
        let used = || scene.instances.iter().map(|i| scene.material_of(i));
        let emission = used().any(|m| m.emissive.max_element() > 0.0);
        let mask = used().any(|m| matches!(m.alpha, Alpha::Mask { .. }));
        let rays = used().any(|m| may_reflect(m, settings.ray_roughness_limit));
        let closed = scene.instances.iter().any(|i| {
            let primitive = &scene.primitives[i.primitive];
            primitive.closed && scene.materials[primitive.material].alpha == Alpha::Opaque
        });
        let (lost_share, reuse) = (method.lost_share(), settings.reuse(method));
        let weber = method.weber_share();
        let method = method.parts();
        let screen = method.answer == HitSource::ScreenSpace;
        let resolve = screen || method.resolved;
        let fallback = settings.fallback(scene);

        let mut decisions = Decisions { all, list: Vec::new() };
        decisions.always("gbuffer");
        let emission = decisions.add("emission", emission, "a material emits", "no material in the scene emits");
        let mask = decisions.add("cut-outs", mask, "a material is cut out", "no material in the scene is cut out");
        let back_faces = if screen && method.back_faces {
            let no = if rays { "no mesh in the scene is closed" } else { "no surface traces a ray" };
            decisions.add("backface", rays && closed, "closed meshes bound the rays", no)
        } else {
            decisions.never("backface", "the method does not use back faces")
        };
        let casts = scene.lights.iter().any(|l| l.casts_shadow && !scene.instances.is_empty());
        let (shadows, shadow_maps) = shadows(&mut decisions, settings, casts);
        let indirect = if settings.indirect {
            decisions.needed(
                "indirect",
                !scene.instances.is_empty(),
                "surfaces light each other",
                "there is no surface",
            )
        } else {
            decisions.never("indirect", "indirect light was not asked for")
        };
        let shading_reuse = shading_reuse(&mut decisions, scene, (shadows, shadow_maps), (screen, settings));
        ambient_occlusion(&mut decisions, settings.ao.method);
        decisions.always("lighting");
        let rays = decisions.add("classify", rays, "surfaces reflect", "every surface is too rough for a ray");
        for name in ["depth_pyramid", "trace"] {
            if screen {
                decisions.add(name, rays, "rays are marched through the views", "no surface traces a ray");
            } else {
                decisions.never(name, "the method asks the scene's geometry");
            }
        }
        if resolve {
            decisions.add("resolve", rays, "neighbours share their rays", "no surface traces a ray");
        } else {
            decisions.never("resolve", "each pixel averages its own paths");
        }
        let probe = match (screen, fallback) {
            (true, Fallback::Probe) => {
                decisions.needed("probe", rays, "unknown rays see the scene's probe", "no surface traces a ray")
            }
            _ => decisions.never("probe", "nothing falls back to a probe"),
        };
        for (name, runs) in [("path_trace", !method.resolved), ("path_rays", method.resolved)] {
            if screen {
                decisions.never(name, "the method asks the views");
            } else if runs {
                decisions.add(name, rays, "rays go through the scene's geometry", "no surface traces a ray");
            } else {
                decisions.never(name, "the method's rays take the other way to the picture");
            }
        }
        let accumulation = method.accumulation.filter(|_| resolve);
        let motion = accumulation.is_some() && !scene.motions.is_empty();
        let motion = match accumulation {
            Some(_) => {
                decisions.needed("motion", motion, "something moves by itself", "nothing in the scene moves by itself")
            }
            None => decisions.never("motion", "the method looks back to no frame"),
        };
        if method.traversal == Traversal::TwoStages {
            decisions.add("trace_other_eye", rays, "rays may go on in the other eye's view", "no surface traces a ray");
        } else {
            decisions.never("trace_other_eye", "the method keeps each ray in its own eye's view");
        }
        let geometry = screen && lost_share > 0.0;
        if geometry {
            let why = format!("{:.0} % of the rays that the views lose ask the geometry", 100.0 * lost_share);
            decisions.add("trace_geometry", rays, &why, "no surface traces a ray");
        } else {
            decisions.never("trace_geometry", "what the views lose is not looked for in the geometry");
        }
        let by_variance = method.reprojection.is_some_and(|r| r.blend == Blend::Variance) && reuse == Reuse::Balance;
        let moments = by_variance || weber.is_some() || accumulation.is_some();
        if moments {
            let why = "eyes or frames are compared by the variance of what each knows";
            decisions.add("moments", rays, why, "no surface traces a ray");
        } else {
            decisions.never("moments", "nothing asks for the variance of what an eye knows");
        }
        if let Some(weber) = weber {
            let why = format!("only where the eyes may differ by more than {} %", 100.0 * weber);
            decisions.add("reproject", rays, &why, "no surface traces a ray");
        } else if method.reprojection.is_some() {
            decisions.add("reproject", rays, "the other eye knows of the same reflection", "no surface traces a ray");
        } else {
            decisions.never("reproject", "the method resolves each eye for itself");
        }
        if accumulation.is_some() {
            decisions.add(
                "accumulate",
                rays,
                "the frames before knew of the same reflection",
                "no surface traces a ray",
            );
        } else {
            decisions.never("accumulate", "the method takes each frame for itself");
        }
        if settings.antialias > 1 {
            let side = settings.antialias;
            decisions.add("antialias", true, &format!("surfaces are drawn with {side}×{side} samples a pixel"), "");
        } else {
            decisions.never("antialias", "it was not asked for");
        }
        decisions.always("composite");
        let decisions = decisions.list;
        Needs {
            emission,
            mask,
            shadows,
            shadow_maps,
            shading_reuse,
            indirect,
            composite: true,
            glass: used().any(|m| m.transmission > 0.0),
            back_faces,
            rays,
            screen_space: screen && rays,
            resolve: resolve && rays,
            probe,
            path_trace: !screen && rays,
            cpu_paths: false,
            cpu_shadows: false,
            geometry: geometry && rays,
            moments: moments && rays,
            pairs: (method.reprojection.is_some() || accumulation.is_some()) && rays,
            accumulate: accumulation.is_some() && rays,
            motion: motion && rays,
            blend_by_variance: by_variance && rays,
            ao: settings.ao.method,
            decisions,
        }
    }

    /// The same with the reference's paths traced by the processor, if any are.
    pub fn with_paths_on_the_cpu(mut self) -> Needs {
        self.cpu_paths = self.path_trace && !self.resolve;
        if self.cpu_paths
            && let Some(part) = self.decisions.iter_mut().find(|p| p.name == "path_trace")
        {
            part.why.push_str(", traced by the processor");
        }
        self
    }

    /// The same with the shadows of the views traced by the processor, if rays find any. The eyes then share no shading
    /// unless it is insisted on: the device takes longer to look into the left eye than the processor to find the shadows.
    pub fn with_shadows_on_the_cpu(mut self, reuse: ShadingReuse) -> Needs {
        if self.shadow_rays() && self.shading_reuse && reuse == ShadingReuse::Auto {
            self.shading_reuse = false;
            if let Some(part) = self.decisions.iter_mut().find(|p| p.name == "shading_reuse") {
                part.runs = false;
                part.why = "the processor finds the shadows sooner than the device looks into the left eye".to_owned();
            }
        }
        self.cpu_shadows = self.shadow_rays() && !self.shading_reuse;
        if self.cpu_shadows
            && let Some(part) = self.decisions.iter_mut().find(|p| p.name == "shadows")
        {
            part.why.push_str(", traced by the processor");
        }
        self
    }

    /// Of surfaces and their light alone.
    pub fn of_surfaces(&self) -> Needs {
        Needs {
            composite: false,
            ao: Ao::None,
            rays: false,
            screen_space: false,
            back_faces: false,
            resolve: false,
            path_trace: false,
            cpu_paths: false,
            geometry: false,
            pairs: false,
            accumulate: false,
            ..self.clone()
        }
    }

    /// Shadows on the views ask the geometry.
    pub fn shadow_rays(&self) -> bool {
        self.shadows && !self.shadow_maps
    }

    /// And the device traces them.
    pub fn device_shadow_rays(&self) -> bool {
        self.shadow_rays() && !self.cpu_shadows
    }

    /// What lights put on each pixel has an image of its own.
    pub fn direct(&self) -> bool {
        self.shadows || self.shading_reuse
    }

    /// What the shaders that ask the geometry and shade what they hit are specialised for, by constant.
    pub fn of_hits(&self) -> [u32; 4] {
        [self.mask, self.shadows, self.glass, self.indirect].map(u32::from)
    }

    /// Every part in order.
    pub fn decisions(&self) -> &[PassDecision] {
        &self.decisions
    }

    /// What was left out and why.
    pub fn left_out(&self) -> Vec<PassDecision> {
        self.decisions.iter().filter(|p| !p.runs).cloned().collect()
    }
}

/// Whether lights cast shadows, and whether those on the views are found in maps.
fn shadows(decisions: &mut Decisions, settings: &Settings, casts: bool) -> (bool, bool) {
    const WAYS: [(&str, Shadows, &str); 2] =
        [("shadows", Shadows::Rays, "by rays"), ("shadow_maps", Shadows::Maps, "in maps drawn from the lights")];
    for (name, way, how) in WAYS {
        if !settings.shadows {
            decisions.never(name, "shadows are switched off");
        } else if settings.shadows_by != way {
            decisions.never(name, &format!("shadows are not looked for {how}"));
        } else {
            let yes = format!("lights cast shadows, which are found {how}");
            decisions.needed(name, casts, &yes, "no light in the scene casts a shadow");
        }
    }
    let shadows = settings.shadows && casts;
    (shadows, shadows && settings.shadows_by == Shadows::Maps)
}

/// Rays of a pixel to lights from which on the eyes share shading.
const RAYS_THAT_PAY: usize = 4;
/// Likewise lights, where none casts a shadow.
const LIGHTS_THAT_PAY: usize = 16;

/// Not forced either: shared shading is another picture, within a bound.
fn shading_reuse(
    decisions: &mut Decisions,
    scene: &Scene,
    (shadows, maps): (bool, bool),
    (screen, settings): (bool, &Settings),
) -> bool {
    let name = "shading_reuse";
    let lights = scene.lights.len();
    let rays: usize = match shadows {
        true => scene.lights.iter().filter(|l| l.casts_shadow).map(rays_to).sum(),
        false => 0,
    };
    match settings.shading_reuse {
        ShadingReuse::Off => decisions.never(name, "each eye is lit in full"),
        _ if !screen => decisions.never(name, "rays through the geometry take nothing from the other eye"),
        _ if maps => decisions.never(name, "a shadow map is looked up as quickly as the left eye"),
        _ if lights == 0 || scene.instances.is_empty() => decisions.never(name, "there is no light or no surface"),
        ShadingReuse::Always => decisions.needed(name, true, "it was asked for, whether it pays or not", ""),
        ShadingReuse::Auto if rays > 0 => {
            let yes = format!("{rays} rays a pixel cost more than looking into the left eye");
            let no = format!(
                "{rays} rays a pixel cost less than looking into the left eye; it pays from {RAYS_THAT_PAY} on"
            );
            decisions.needed(name, rays >= RAYS_THAT_PAY, &yes, &no)
        }
        ShadingReuse::Auto => {
            let yes = format!("{lights} lights cost more than looking into the left eye");
            let no = format!(
                "{lights} lights without shadows cost less than looking into the left eye; it pays from {LIGHTS_THAT_PAY} on"
            );
            decisions.needed(name, lights >= LIGHTS_THAT_PAY, &yes, &no)
        }
    }
}

/// Of a pixel that lies in no penumbra.
fn rays_to(light: &Light) -> usize {
    if light.size > 0.0 { RIM_RAYS as usize } else { 1 }
}

/// Not forced either: what is not occluded is another picture than what is.
fn ambient_occlusion(decisions: &mut Decisions, ao: Ao) {
    let mut part = |name, needed, yes: &str| {
        let no = match ao {
            Ao::None => "ambient light is not occluded".to_owned(),
            other => format!("`{}` does without", other.name()),
        };
        decisions.needed(name, needed, yes, &no);
    };
    part("ao_rays", ao == Ao::RayTraced, "rays find what hides the surroundings");
    part("ao_pairs", ao.is_stereo(), "both eyes have a say in what hides the surroundings");
    let views = if ao.samples_both_views() { "both views" } else { "each view" };
    part("ao_obscurance", ao.is_estimated(), &format!("{views} show what hides the surroundings"));
    part("ao_reproject", ao.samples_both_views(), "what one eye's pixel found is its pair's, too");
    part("ao_filter", ao.is_estimated(), "neighbours share what they found");
    part("ao_adaptive", ao.is_adaptive(), "only pixels that differ visibly between the eyes go on");
    part("ao_blend", ao.is_stereo(), "the eyes' filters are blended by their weights");
}

/// Collects what is decided.
struct Decisions {
    all: bool,
    list: Vec<PassDecision>,
}

impl Decisions {
    /// Runs when it is needed, or when every pass is forced on.
    fn add(&mut self, name: &'static str, needed: bool, yes: &str, no: &str) -> bool {
        let why = match (needed, self.all) {
            (true, _) => yes.to_owned(),
            (false, false) => no.to_owned(),
            (false, true) => format!("forced on, though {no}"),
        };
        let runs = needed || self.all;
        self.list.push(PassDecision { name, runs, why });
        runs
    }

    /// Runs when it is needed; forcing it on would bring nothing that is looked at.
    fn needed(&mut self, name: &'static str, needed: bool, yes: &str, no: &str) -> bool {
        self.list.push(PassDecision { name, runs: needed, why: if needed { yes } else { no }.to_owned() });
        needed
    }

    fn always(&mut self, name: &'static str) {
        self.list.push(PassDecision { name, runs: true, why: "every frame".to_owned() });
    }

    /// Not forced either: the method is defined without it.
    fn never(&mut self, name: &'static str, why: &str) -> bool {
        self.list.push(PassDecision { name, runs: false, why: why.to_owned() });
        false
    }
}

/// The texture's values lie in [0, 1], so the factor is the most that roughness can be and 0 the least.
fn may_reflect(material: &Material, limit: f32) -> bool {
    material.roughness <= limit || material.metallic_roughness_texture.is_some()
}
