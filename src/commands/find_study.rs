//! The study that a command names.

use std::path::Path;

use crate::study::validate::{self, Study, StudyError};

/// Loads a study by path, or by the name of a file in `studies/`.
///
/// # Errors
/// It cannot be read, or has problems.
pub fn find_study(name: &Path) -> Result<Study, StudyError> {
    let named = Path::new("studies").join(name).with_extension("json");
    let is_name = !name.exists() && name.components().count() == 1 && named.exists();
    validate::load(if is_name { &named } else { name })
}
