//! The scenes and methods that a study may ask for. The list is the same with and without a device, so that a build
//! that renders nothing can check studies.

use crate::method::{Ao, Method};
use crate::scene::head_path::GENERIC;
use crate::scene::{builtin, manifest::Manifest};
use crate::study::stimulus::{Catalogue, CatalogueScene};

/// The built-in scenes with their views and paths, and every method.
pub fn catalogue() -> Catalogue {
    let scenes = builtin::NAMES.iter().map(|&name| {
        let manifest = builtin::manifest(name).and_then(|text| serde_json::from_str::<Manifest>(text).ok());
        let (views, paths) = manifest.map_or((Vec::new(), Vec::new()), |manifest| {
            let views = manifest.views.into_iter().map(|v| v.name).collect();
            (views, manifest.paths.into_iter().map(|p| p.name).collect())
        });
        CatalogueScene { name: name.to_owned(), views, paths }
    });
    let owned = |names: Vec<&str>| names.into_iter().map(str::to_owned).collect();
    Catalogue {
        scenes: scenes.collect(),
        methods: owned(Method::names()),
        with_percentage: owned(Method::names_with_percentage()),
        paths: GENERIC.iter().map(|(name, _)| (*name).to_owned()).collect(),
        ao: owned(Ao::ALL.into_iter().filter(|ao| *ao != Ao::None).map(Ao::name).collect()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_can_be_asked_for() {
        let catalogue = catalogue();
        for (name, _) in Method::described() {
            assert!(catalogue.has_method(name) && catalogue.has_method(&format!("{name}@4")), "{name}");
        }
        assert!(catalogue.has_method("stereo-hybrid-12.5@2"));
        for wrong in ["stereo-5", "stereo-hybrid-101", "stereo-hybrid-", "stereo-hybrid-x"] {
            assert!(!catalogue.has_method(wrong), "{wrong}");
        }
        assert!(catalogue.scenes.iter().all(|scene| scene.views.len() == 2), "{:?}", catalogue.scenes);
    }
}
