//! Decides from scene, method and settings which parts of a frame run. What is left out costs no pass, no memory and no branch.
//!
//! `Renderer::prepare` asks [`FrameNeeds::of`]; `Targets` and the passes are made for the result. Each decision is conservative: a
//! part is left out only where that provably does not change the picture.

use crate::scene::{Alpha, Fallback, Light, Material, Scene};

use super::method::{Ao, Blend, HitSource, Method, Reuse, Traversal};
use super::settings::{Settings, ShadingReuse, Shadows};

/// Rays to the rim of a light's disc. Where all of them have the same result, the pixel counts as outside the penumbra.
pub const RIM_RAYS: u32 = 6;

/// A pass or a part of one, whether it runs, and why.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct PassDecision {
    pub name: &'static str,
    #[serde(skip)]
    pub runs: bool,
    pub why: String,
}

/// The decisions of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameNeeds {
    /// Some material emits.
    pub emission: bool,
    /// Some material is cut out.
    pub mask: bool,
    /// Some light casts shadows.
    pub shadows: bool,
    /// The shadows in the views are looked up in shadow maps. Those at the hits of rays are traced all the same.
    pub shadow_maps: bool,
    /// The eyes share the shading by punctual lights.
    pub shading_reuse: bool,
    /// Baked light replaces the environment's diffuse light.
    pub indirect: bool,
    /// The images of the composite are needed. The finer twin of a view (antialiasing) has none: the view composites.
    pub composite: bool,
    /// Some material transmits light.
    pub glass: bool,
    /// Back faces bound the matter of closed meshes.
    pub back_faces: bool,
    /// Some surface may trace a ray.
    pub rays: bool,
    /// Rays are marched through the views.
    pub screen_space: bool,
    /// Hits are filtered.
    pub resolve: bool,
    /// A probe stands in for unknown rays.
    pub probe: bool,
    /// All reflection rays go through the scene's geometry.
    pub path_trace: bool,
    /// The processor traces the reference's paths, and not the device.
    pub cpu_paths: bool,
    /// The processor traces the shadows in the views.
    pub cpu_shadows: bool,
    /// Rays that the views lose ask the scene's geometry.
    pub geometry: bool,
    /// The filter computes the variance of its result.
    pub moments: bool,
    /// The filter's output (known light, weight, nearness) is kept for blending with the other eye or with later frames.
    pub pairs: bool,
    /// Frames are accumulated.
    pub accumulate: bool,
    /// The scene has motions, and the history needs to know where instances were in the last frame.
    pub motion: bool,
    /// The eyes are blended by the variances.
    pub blend_by_variance: bool,
    /// The method of ambient occlusion.
    pub ao: Ao,
    decisions: Vec<PassDecision>,
}

impl FrameNeeds {
    /// What `method` needs for pictures of `scene` with these settings.
    pub fn of(scene: &Scene, method: &Method, settings: &Settings) -> FrameNeeds {
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
        let method = method.technique();
        let screen = method.hit_source == HitSource::ScreenSpace;
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
                decisions.never(name, "another pass traces the method's rays");
            }
        }
        let accumulation = method.accumulation.filter(|_| resolve);
        let motion = accumulation.is_some() && !scene.motions.is_empty();
        let motion = match accumulation {
            Some(_) => {
                decisions.needed("motion", motion, "something moves by itself", "nothing in the scene moves by itself")
            }
            None => decisions.never("motion", "the method uses no earlier frame"),
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
            decisions.never("trace_geometry", "rays that the views lose do not ask the geometry");
        }
        let by_variance = method.reprojection.is_some_and(|r| r.blend == Blend::Variance) && reuse == Reuse::Balance;
        let moments = by_variance || weber.is_some() || accumulation.is_some();
        if moments {
            let why = "eyes or frames are compared by the variance of what each knows";
            decisions.add("moments", rays, why, "no surface traces a ray");
        } else {
            decisions.never("moments", "nothing needs the variance of what an eye knows");
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
        FrameNeeds {
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

    /// The same with the reference's paths, if there are any, traced by the processor.
    pub fn with_paths_on_the_cpu(mut self) -> FrameNeeds {
        self.cpu_paths = self.path_trace && !self.resolve;
        if self.cpu_paths
            && let Some(part) = self.decisions.iter_mut().find(|p| p.name == "path_trace")
        {
            part.why.push_str(", traced by the processor");
        }
        self
    }

    /// The same with the shadows in the views traced by the processor, if they are found by rays. The eyes then share no shading
    /// unless `reuse` insists on it, because the device takes longer to look up the left eye's light than the processor takes to
    /// trace the shadows.
    pub fn with_shadows_on_the_cpu(mut self, reuse: ShadingReuse) -> FrameNeeds {
        if self.shadow_rays() && self.shading_reuse && reuse == ShadingReuse::Auto {
            self.shading_reuse = false;
            if let Some(part) = self.decisions.iter_mut().find(|p| p.name == "shading_reuse") {
                part.runs = false;
                part.why = "the processor traces the shadows sooner than the left eye's are looked up".to_owned();
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

    /// The needs of surfaces and their light alone, without reflections: those of a view's finer twin.
    pub fn of_surfaces(&self) -> FrameNeeds {
        FrameNeeds {
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

    /// Whether the shadows in the views are traced by rays.
    pub fn shadow_rays(&self) -> bool {
        self.shadows && !self.shadow_maps
    }

    /// Whether the device traces them.
    pub fn device_shadow_rays(&self) -> bool {
        self.shadow_rays() && !self.cpu_shadows
    }

    /// Whether the light of the punctual lights is computed before the lighting pass, into an image of its own.
    pub fn direct(&self) -> bool {
        self.shadows || self.shading_reuse
    }

    /// Specialisation constants 0–3 of the shaders that trace rays through the geometry and shade their hits.
    pub fn of_hits(&self) -> [u32; 4] {
        [self.mask, self.shadows, self.glass, self.indirect].map(u32::from)
    }

    /// Every part in order.
    pub fn decisions(&self) -> &[PassDecision] {
        &self.decisions
    }

    /// The parts that were left out, with the reasons.
    pub fn left_out(&self) -> Vec<PassDecision> {
        self.decisions.iter().filter(|p| !p.runs).cloned().collect()
    }
}

/// Decides whether lights cast shadows, and whether those in the views are looked up in maps.
fn shadows(decisions: &mut Decisions, settings: &Settings, casts: bool) -> (bool, bool) {
    const WAYS: [(&str, Shadows, &str); 2] =
        [("shadows", Shadows::Rays, "by rays"), ("shadow_maps", Shadows::Maps, "in maps drawn from the lights")];
    for (name, way, how) in WAYS {
        if !settings.shadows {
            decisions.never(name, "shadows are switched off");
        } else if settings.shadows_by != way {
            decisions.never(name, &format!("shadows are not to be found {how}"));
        } else {
            let yes = format!("lights cast shadows, which are found {how}");
            decisions.needed(name, casts, &yes, "no light in the scene casts a shadow");
        }
    }
    let shadows = settings.shadows && casts;
    (shadows, shadows && settings.shadows_by == Shadows::Maps)
}

/// The least number of a pixel's rays to lights with which shading reuse saves time.
const RAYS_THAT_PAY: usize = 4;
/// The least number of lights with which it saves time where no light casts a shadow.
const LIGHTS_THAT_PAY: usize = 16;

/// Decides about shading reuse. `all_passes` does not force it on, because it changes the picture, if only within a bound.
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
        _ if maps => decisions.never(name, "looking up a shadow map is as quick as looking into the left eye"),
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

/// The number of rays to a light from a pixel outside its penumbra.
fn rays_to(light: &Light) -> usize {
    if light.size > 0.0 { RIM_RAYS as usize } else { 1 }
}

/// Decides about the passes of ambient occlusion. `all_passes` does not force them on, because they change the picture.
fn ambient_occlusion(decisions: &mut Decisions, ao: Ao) {
    let mut part = |name, needed, yes: &str| {
        let no = match ao {
            Ao::None => "ambient light is not occluded".to_owned(),
            other => format!("`{}` does not use it", other.name()),
        };
        decisions.needed(name, needed, yes, &no);
    };
    part("ao_rays", ao == Ao::RayTraced, "rays find what hides the surroundings");
    part("ao_pairs", ao.is_stereo(), "both eyes' visibility of the surroundings is combined");
    let views = if ao.samples_both_views() { "both views" } else { "each view" };
    part("ao_obscurance", ao.is_estimated(), &format!("{views} show what hides the surroundings"));
    part("ao_reproject", ao.samples_both_views(), "a pixel's visibility is copied to its pair in the other eye");
    part("ao_filter", ao.is_estimated(), "neighbours share what they found");
    part("ao_adaptive", ao.is_adaptive(), "only pixels that differ visibly between the eyes are blended");
    part("ao_blend", ao.is_stereo(), "the eyes' filters are blended by their weights");
}

/// Collects the decisions.
struct Decisions {
    all: bool,
    list: Vec<PassDecision>,
}

impl Decisions {
    /// A part that runs if it is needed, or if every pass is forced on (`Settings::all_passes`).
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

    /// A part that runs only if it is needed. It is not forced on, because nothing would read its result.
    fn needed(&mut self, name: &'static str, needed: bool, yes: &str, no: &str) -> bool {
        self.list.push(PassDecision { name, runs: needed, why: if needed { yes } else { no }.to_owned() });
        needed
    }

    fn always(&mut self, name: &'static str) {
        self.list.push(PassDecision { name, runs: true, why: "every frame".to_owned() });
    }

    /// A part that does not run. It is not forced on, because the method is defined without it.
    fn never(&mut self, name: &'static str, why: &str) -> bool {
        self.list.push(PassDecision { name, runs: false, why: why.to_owned() });
        false
    }
}

/// Whether some point of the material may be smooth enough for a ray. A texture's values lie in [0, 1], so that roughness lies
/// between 0 and the material's factor.
fn may_reflect(material: &Material, limit: f32) -> bool {
    material.roughness <= limit || material.metallic_roughness_texture.is_some()
}
