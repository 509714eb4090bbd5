//! Keeps loaded scenes that may be needed again, so that several comparisons of one scene load it once. Comparisons and
//! the reproduction of the paper load their scenes here.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use super::{Loading, Scene, SceneError, load_with};

/// The most scenes that are kept. The one that was used longest ago is dropped first.
const MOST: usize = 8;

/// A scene, and the name under which it was asked for.
type NamedScene = (String, Arc<Scene>);

/// See the module's documentation. A clone shares the same scenes.
#[derive(Debug, Clone, Default)]
pub struct SceneCache {
    loading: Loading,
    /// The most recently used scene is last.
    scenes: Rc<RefCell<Vec<NamedScene>>>,
}

impl SceneCache {
    /// An empty cache, whose scenes will be loaded with these options.
    pub fn new(loading: Loading) -> SceneCache {
        SceneCache { loading, scenes: Rc::default() }
    }

    /// The scene that is kept under this name, or else the result of [`load_with`].
    ///
    /// # Errors
    /// As [`load_with`].
    pub fn load(&self, source: &str) -> Result<Arc<Scene>, SceneError> {
        let at = self.scenes.borrow().iter().position(|(name, _)| name == source);
        let found = match at {
            Some(at) => self.scenes.borrow_mut().remove(at),
            None => (source.to_owned(), Arc::new(load_with(source, self.loading)?)),
        };
        let scene = Arc::clone(&found.1);
        let mut scenes = self.scenes.borrow_mut();
        if scenes.len() >= MOST {
            scenes.remove(0);
        }
        scenes.push(found);
        Ok(scene)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_is_loaded_once_and_the_oldest_goes_first() {
        let scene_cache = SceneCache::new(Loading { detail: Some(0.01), ..Loading::default() });
        let first = scene_cache.load("room").expect("built in");
        assert!(Arc::ptr_eq(&first, &scene_cache.clone().load("room").expect("built in")));
        assert!(scene_cache.load("nowhere").is_err(), "what cannot be loaded is no scene");
        // Names beyond the cache's capacity push out those that were used before them.
        let names: Vec<String> = (0..MOST).map(|i| format!("other {i}")).collect();
        scene_cache.scenes.borrow_mut().splice(0..0, names[1..].iter().map(|name| (name.clone(), Arc::clone(&first))));
        assert_eq!(scene_cache.scenes.borrow().len(), MOST);
        scene_cache.load("pica").expect("built in");
        let kept: Vec<String> = scene_cache.scenes.borrow().iter().map(|(name, _)| name.clone()).collect();
        assert_eq!(kept.len(), MOST);
        assert_eq!((kept[0].as_str(), kept[MOST - 2].as_str(), kept[MOST - 1].as_str()), ("other 2", "room", "pica"));
    }
}
