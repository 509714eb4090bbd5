//! The scene's geometry for rays, on the device or for the processor. It is built when it is first needed and kept for later
//! uses. The renderer owns it; prepared views ask for it.

use std::cell::{OnceCell, RefCell};
use std::rc::Rc;
use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::gpu::{Gpu, GpuError};
use crate::scene::Scene;

use super::bvh::RayScene;
use super::cpu::{StaticScene, World};
use super::settings::Trace;
use super::upload::SceneResources;

/// See the module's documentation.
pub struct LazyRays {
    gpu: Rc<Gpu>,
    scene: Arc<Scene>,
    resources: Rc<SceneResources>,
    /// The instances' transforms.
    places: RefCell<Vec<DAffine3>>,
    built: RefCell<Option<Rc<RayScene>>>,
    /// The geometry for the processor, and the part of it that does not change when instances move.
    world: RefCell<Option<Rc<World>>>,
    content: OnceCell<Arc<StaticScene>>,
}

impl LazyRays {
    /// Builds nothing yet.
    pub fn new(gpu: &Rc<Gpu>, scene: &Arc<Scene>, resources: &Rc<SceneResources>) -> LazyRays {
        let (gpu, scene, resources) = (Rc::clone(gpu), Arc::clone(scene), Rc::clone(resources));
        let places = RefCell::new(scene.places());
        let (built, world, content) = (RefCell::new(None), RefCell::new(None), OnceCell::new());
        LazyRays { gpu, scene, resources, places, built, world, content }
    }

    /// Sets the instances' transforms. If they differ, what was built is dropped.
    pub fn place(&self, places: &[DAffine3]) {
        if *self.places.borrow() != places {
            *self.places.borrow_mut() = places.to_vec();
            *self.built.borrow_mut() = None;
            *self.world.borrow_mut() = None;
        }
    }

    /// The geometry relative to `head` for the processor. What was built last is used again if it fits.
    pub fn world(&self, head: DVec3) -> Rc<World> {
        if let Some(world) = self.world.borrow().as_ref().filter(|w| w.head == head) {
            return Rc::clone(world);
        }
        let content = self.content.get_or_init(|| Arc::new(StaticScene::new(&self.scene)));
        let world = Rc::new(World::new(content, &self.places.borrow(), head));
        *self.world.borrow_mut() = Some(Rc::clone(&world));
        world
    }

    /// The geometry relative to `head` on the device. What was built last is used again if it fits.
    ///
    /// # Errors
    /// When device memory runs out, or `trace` asks for ray queries and the device has none.
    pub fn obtain(&self, head: DVec3, trace: Trace) -> Result<Rc<RayScene>, GpuError> {
        if let Some(built) = self.built.borrow().as_ref().filter(|r| r.head == head && r.answers(&self.gpu, trace)) {
            return Ok(Rc::clone(built));
        }
        let scene = (&*self.scene, self.places.borrow());
        let rays = RayScene::new(&self.gpu, (scene.0, &scene.1), &self.resources.ranges, head, trace)?;
        let rays = Rc::new(rays);
        if rays.halvings > 0 {
            tracing::warn!("the textures that rays hit were halved {} times to fit the device", rays.halvings);
        }
        *self.built.borrow_mut() = Some(Rc::clone(&rays));
        Ok(rays)
    }
}
