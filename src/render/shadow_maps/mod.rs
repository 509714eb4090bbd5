//! Shadow maps, for views that are rendered frame by frame where rays are slow.
//!
//! A point light has a cube of maps. A spot light has one map, or a cube if its cone is wide. They are drawn once for a scene,
//! and again only when an instance has moved. A directional light has cascades around the head, not around the view's frustum.
//! Both eyes and all directions of the head therefore read the same texels, and a cascade is drawn again only after the head
//! has moved by a quarter of its half width. The last cascade covers the whole scene and is fixed; in a small scene it is the
//! only one. Docs: docs/rendering.md, "Shadow maps".

mod draw;
mod lookup;
mod map_view;

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

use ash::vk;
use glam::{DAffine3, DVec3};

use super::context::instance_corners;
use super::shared::{LightMapsData, ShadowMapData};
use super::upload::{self, SceneResources};
use crate::gpu::{Buffer, Frame, Gpu, GpuError, Image, ImageDesc, PassTime};
use crate::scene::{Instance, Light, LightSource, Scene};

use draw::{DrawInputs, DrawPass};
pub use lookup::MappedShadowsPass;
use map_view::{Corners, LightSpaceBounds, LocalLight, ShadowMapView};

/// The largest number of texels in all maps together: 128 MiB.
const MOST_TEXELS: u64 = 1 << 25;
/// The possible widths of a map, texels.
const SIDES: [u32; 6] = [2048, 1024, 512, 256, 128, 64];
/// Each cascade is this many times as wide as the next finer one.
const CASCADE_STEP: f64 = 4.0;
/// A cascade whose half width is at most this has no finer one inside it; metres.
const FINEST_REACH_M: f64 = 2.0;
/// The largest number of cascades of a light.
const MOST_CASCADES: usize = 4;
/// A cascade follows the head when the head is off the cascade's centre by this share of its half width.
const FOLLOW: f64 = 0.25;
/// Maps drawn in one submission.
const MAPS_A_SUBMISSION: usize = 32;

/// A cascade that follows the head.
struct HeadCascade {
    layers: Vec<usize>,
    bounds: LightSpaceBounds,
    /// Half width, metres.
    half: f64,
    /// Where the head was when it was last drawn, world space; `None`: never drawn.
    center: Cell<Option<DVec3>>,
}

/// See the module's documentation.
pub struct ShadowMaps {
    /// Origin of the maps' space, in world space; everything below is relative to it.
    origin: DVec3,
    /// Half the diagonal of the scene's bounds, metres.
    radius: f64,
    image: Image,
    side: u32,
    /// The view of each layer, as shaders read it.
    views: Buffer,
    /// The layers of each light.
    lights: Buffer,
    instances: Buffer,
    /// The bounding box of each instance.
    boxes: RefCell<Vec<Corners>>,
    /// The instances' transforms.
    places: RefCell<Vec<DAffine3>>,
    layers: RefCell<Vec<Layer>>,
    cascades: Vec<HeadCascade>,
    /// The layers that must be drawn again.
    outdated: RefCell<BTreeSet<usize>>,
    draw: DrawPass,
    scene: Arc<Scene>,
    resources: Rc<SceneResources>,
    gpu: Rc<Gpu>,
}

/// What a layer of the image shows.
#[derive(Clone, Copy)]
struct Layer {
    view: ShadowMapView,
    /// The layer shows transmitting matter, and not opaque matter.
    dims: bool,
    /// The light's position and range, metres; `None`: a directional light.
    reach: Option<(DVec3, f64)>,
}

/// The layers of all lights, planned before the image is allocated.
struct Plan {
    lights: Vec<LightMapsData>,
    layers: Vec<Layer>,
    cascades: Vec<HeadCascade>,
}

impl ShadowMaps {
    /// Allocates the maps of every light that casts shadows. Nothing is drawn yet. `origin`: of the maps' space, world space.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(
        gpu: &Rc<Gpu>,
        scene: &Arc<Scene>,
        resources: &Rc<SceneResources>,
        origin: DVec3,
    ) -> Result<ShadowMaps, GpuError> {
        let boxes: Vec<Corners> =
            scene.instances.iter().map(|i| instance_corners(scene, i).map(|c| c - origin)).collect();
        let corners = || boxes.iter().flatten().copied();
        let low = corners().fold(DVec3::INFINITY, DVec3::min);
        let high = corners().fold(DVec3::NEG_INFINITY, DVec3::max);
        let radius = ((high - low).length() / 2.0).max(1e-6);
        let plan = Plan::new(scene, &boxes, (origin, radius), gpu.max_layers());
        let skipped = plan.lights.iter().zip(&scene.lights).filter(|(m, l)| m.count == 0 && l.casts_shadow).count();
        if skipped > 0 {
            let room = gpu.max_layers();
            tracing::warn!("{skipped} lights cast no shadow: the device's images have room for {room} shadow maps");
        }
        // At least two layers, because `Image` makes no array view of a single one, and the shader needs an array.
        let layers = plan.layers.len().max(2);
        let fits = |side: u32| layers as u64 * u64::from(side) * u64::from(side) <= MOST_TEXELS;
        let side = SIDES.into_iter().find(|&side| fits(side)).unwrap_or(SIDES[SIDES.len() - 1]);
        let desc = ImageDesc { layers: layers as u32, ..ImageDesc::stereo_target(side, side, vk::Format::D32_SFLOAT) };
        let places = scene.places();
        let instances = upload::instance_buffer(gpu, scene, &places, &resources.ranges, origin)?;
        Ok(ShadowMaps {
            origin,
            radius,
            image: Image::new(gpu, "shadow maps", desc)?,
            side,
            views: Buffer::upload(gpu, "views of lights", (plan.layers.len() * size_of::<ShadowMapData>()) as u64)?,
            lights: Buffer::with_content(gpu, "maps of lights", &plan.lights)?,
            instances,
            boxes: RefCell::new(boxes),
            places: RefCell::new(places),
            outdated: RefCell::new((0..plan.layers.len()).collect()),
            layers: RefCell::new(plan.layers),
            cascades: plan.cascades,
            draw: DrawPass::new(gpu, scene, resources)?,
            scene: Arc::clone(scene),
            resources: Rc::clone(resources),
            gpu: Rc::clone(gpu),
        })
    }

    /// Whether a view from `head` can use the maps: single precision suffices as far from the origin as the scene is wide.
    pub fn covers_view_from(&self, head: DVec3) -> bool {
        head.distance(self.origin) <= 2.0 * self.radius
    }

    /// Sets the instances' transforms. If they differ, every map is due. Directional lights still cover only the bounds that the
    /// scene had at first.
    pub fn place(&self, places: &[DAffine3]) {
        if *self.places.borrow() == places {
            return;
        }
        *self.places.borrow_mut() = places.to_vec();
        let instances = upload::instances(&self.scene, places, &self.resources.ranges, self.origin);
        self.instances.write(bytemuck::cast_slice(&instances));
        let placed = self.scene.instances.iter().zip(places);
        let corners = placed.map(|(i, place)| {
            let moved = Instance { world_from_object: *place, ..i.clone() };
            instance_corners(&self.scene, &moved).map(|c| c - self.origin)
        });
        *self.boxes.borrow_mut() = corners.collect();
        self.outdated.borrow_mut().extend(0..self.layers.borrow().len());
    }

    /// Lets the cascades follow the head, and draws the maps that are due. Must not be called during a frame.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn follow(&self, head: DVec3) -> Result<Vec<PassTime>, GpuError> {
        for cascade in &self.cascades {
            if cascade.center.get().is_none_or(|c| c.distance(head) > FOLLOW * cascade.half) {
                let view = cascade.bounds.centered_at(head - self.origin, cascade.half, self.side);
                for &layer in &cascade.layers {
                    self.layers.borrow_mut()[layer].view = view;
                    self.outdated.borrow_mut().insert(layer);
                }
                cascade.center.set(Some(head));
            }
        }
        let outdated: Vec<usize> = self.outdated.borrow().iter().copied().collect();
        if outdated.is_empty() {
            return Ok(Vec::new());
        }
        let (layers, boxes) = (self.layers.borrow(), self.boxes.borrow());
        let views: Vec<ShadowMapData> = layers.iter().map(|l| l.view.data()).collect();
        self.views.write(bytemuck::cast_slice(&views));
        let mut times = Vec::new();
        for some in outdated.chunks(MAPS_A_SUBMISSION) {
            let mut frame = Frame::begin(&self.gpu)?;
            for &layer in some {
                let inputs = DrawInputs { maps: &self.views, instances: &self.instances };
                let scene = (&*self.scene, &*self.resources);
                let dims = |number: usize| self.scene.material_of(&self.scene.instances[number]).transmission > 0.0;
                let shown = layers[layer];
                let casts = |number: usize| dims(number) == shown.dims && shown.shows(&boxes[number]);
                self.draw.record(&mut frame, scene, &inputs, (&self.image, layer), casts)?;
            }
            times.extend(frame.finish()?);
            self.outdated.borrow_mut().retain(|layer| !some.contains(layer));
        }
        Ok(times)
    }
}

impl Layer {
    /// Whether matter in the box may hide the light from anything in this layer.
    fn shows(&self, corners: &Corners) -> bool {
        let is_reached = self.reach.is_none_or(|(position, range)| {
            let low = corners.iter().copied().fold(DVec3::INFINITY, DVec3::min);
            let high = corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
            position.clamp(low, high).distance(position) <= range
        });
        is_reached && self.view.sees(corners)
    }
}

impl Plan {
    fn new(scene: &Scene, boxes: &[Corners], (origin, radius): (DVec3, f64), most_layers: usize) -> Plan {
        let mut plan = Plan { lights: Vec::new(), layers: Vec::new(), cascades: Vec::new() };
        let dims = scene.instances.iter().any(|i| scene.material_of(i).transmission > 0.0);
        for light in &scene.lights {
            let (first, followed) = (plan.layers.len(), plan.cascades.len());
            if light.casts_shadow && !boxes.is_empty() {
                plan.add(light, boxes, origin, radius);
            }
            let mut count = plan.layers.len() - first;
            if dims {
                for cascade in &mut plan.cascades[followed..] {
                    cascade.layers.push(cascade.layers[0] + count);
                }
                plan.layers.extend_from_within(first..);
                plan.layers[first + count..].iter_mut().for_each(|layer| layer.dims = true);
            }
            if plan.layers.len() > most_layers {
                plan.layers.truncate(first);
                plan.cascades.truncate(followed);
                count = 0;
            }
            let dimming = if dims { count } else { 0 };
            plan.lights.push(LightMapsData { first: first as u32, count: count as u32, dimming: dimming as u32 });
        }
        plan
    }

    fn add(&mut self, light: &Light, boxes: &[Corners], origin: DVec3, radius: f64) {
        let local_light = |position: DVec3| LocalLight {
            position: position - origin,
            radius: f64::from(light.size),
            scene_radius: radius,
        };
        match light.source {
            LightSource::Directional { direction, .. } => {
                let bounds = LightSpaceBounds::new(direction.as_dvec3(), boxes, radius);
                let mut halves = vec![radius];
                while halves.len() < MOST_CASCADES && halves[0] > FINEST_REACH_M {
                    halves.insert(0, halves[0] / CASCADE_STEP);
                }
                for &half in &halves[..halves.len() - 1] {
                    let layers = vec![self.layers.len()];
                    self.cascades.push(HeadCascade { layers, bounds, half, center: Cell::new(None) });
                    self.layers.push(Layer { view: bounds.whole_scene(), dims: false, reach: None });
                }
                self.layers.push(Layer { view: bounds.whole_scene(), dims: false, reach: None });
            }
            LightSource::Point { position, range_m, .. } => {
                self.add_perspectives(&map_view::cube(local_light(position)), position - origin, range_m);
            }
            LightSource::Spot { position, direction, range_m, outer_rad, .. } => {
                let at = position - origin;
                match map_view::spot(local_light(position), direction.as_dvec3(), f64::from(outer_rad)) {
                    Some(one) => self.add_perspectives(&[one], at, range_m),
                    None => self.add_perspectives(&map_view::cube(local_light(position)), at, range_m),
                }
            }
        }
    }

    fn add_perspectives(&mut self, views: &[ShadowMapView], position: DVec3, range_m: f32) {
        let reach = Some((position, f64::from(range_m)));
        self.layers.extend(views.iter().map(|&view| Layer { view, dims: false, reach }));
    }
}
