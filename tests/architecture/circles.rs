//! Finds files that import each other in a circle.
//!
//! A file imports another when it names something that the other defines, directly or through a `pub use`. What a file
//! takes from a module that contains it (`super`, an ancestor's `mod.rs`) does not count, because the files of a folder
//! share what its `mod.rs` defines. Tests inside a file do not count either.

use std::collections::{BTreeMap, BTreeSet};

use super::source::{module_of, named_modules, paths_that_begin, public_uses};

type Module = Vec<String>;

/// The modules of one crate, with the paths that each names and those that it re-exports by `pub use`.
struct Crate<'a> {
    files: BTreeMap<Module, &'a str>,
    named: BTreeMap<Module, Vec<Module>>,
    handed_on: BTreeMap<Module, Vec<Module>>,
}

/// Every import on a circle or between two circles, one line each. `sources` has the path and the text of each file of
/// one crate.
pub fn circles(sources: &[(String, String)]) -> Vec<String> {
    let parts = Crate::read(sources);
    let mut imports = parts.imports();
    // A file that imports none of the remaining files, or that none of them imports, lies on no circle.
    loop {
        let imported: BTreeSet<Module> = imports.values().flatten().cloned().collect();
        let ends: Vec<Module> =
            imports.iter().filter(|(m, of)| of.is_empty() || !imported.contains(*m)).map(|(m, _)| m.clone()).collect();
        if ends.is_empty() {
            break;
        }
        ends.iter().for_each(|end| drop(imports.remove(end)));
        imports.values_mut().for_each(|of| of.retain(|to| !ends.contains(to)));
    }
    let line = |(from, to): (&Module, &Module)| format!("{} imports {}", parts.files[from], parts.files[to]);
    imports.iter().flat_map(|(from, of)| of.iter().map(move |to| line((from, to)))).collect()
}

impl<'a> Crate<'a> {
    fn read(sources: &'a [(String, String)]) -> Crate<'a> {
        let programs = |path: &str| path.ends_with("/main.rs") || path.contains("/bin/");
        let of_library = || sources.iter().filter(|(path, _)| !programs(path));
        let files: BTreeMap<Module, &str> = of_library().map(|(path, _)| (module_of(path), path.as_str())).collect();
        let (mut named, mut handed_on) = (BTreeMap::new(), BTreeMap::new());
        for (path, text) in of_library() {
            let text = text.split("\n#[cfg(test)]\nmod ").next().unwrap_or_default();
            let module = module_of(path);
            named.insert(module.clone(), names(text, &module, &files));
            handed_on.insert(module.clone(), public_uses(text, &module));
        }
        Crate { files, named, handed_on }
    }

    fn imports(&self) -> BTreeMap<Module, BTreeSet<Module>> {
        let of = |from: &Module, named: &Vec<Module>| -> BTreeSet<Module> {
            // A `mod.rs` that only re-exports a name does not depend on it.
            let used = named.iter().filter(|path| !self.handed_on[from].contains(path));
            used.filter_map(|path| self.definer(path, 8)).filter(|to| !from.starts_with(to)).collect()
        };
        self.named.iter().map(|(from, named)| (from.clone(), of(from, named))).collect()
    }

    /// The file that defines the last word of `path`, found through at most `steps` re-exports.
    fn definer(&self, path: &[String], steps: usize) -> Option<Module> {
        let length = (0..=path.len()).rev().find(|n| self.files.contains_key(&path[..*n]))?;
        let module = path[..length].to_vec();
        let handed_on = |name: &String| self.handed_on[&module].iter().find(|p| p.last() == Some(name));
        match path.get(length).and_then(handed_on) {
            Some(next) if steps > 0 && next != path => self.definer(next, steps - 1),
            _ => Some(module),
        }
    }
}

/// The paths that a source names, from the crate's root, including those that it writes from a module inside its own.
fn names(text: &str, module: &Module, files: &BTreeMap<Module, &str>) -> Vec<Module> {
    let inside = |word: &str| -> Module { module.iter().cloned().chain([word.to_owned()]).collect() };
    let from_inside = paths_that_begin(text, |word| files.contains_key(&inside(word)));
    let from_inside = from_inside.into_iter().map(|path| module.iter().cloned().chain(path).collect());
    named_modules(text, module).into_iter().map(|(_, path)| path).chain(from_inside).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(files: &[(&str, &str)]) -> Vec<String> {
        circles(&files.iter().map(|(path, text)| ((*path).to_owned(), (*text).to_owned())).collect::<Vec<_>>())
    }

    #[test]
    fn a_circle_is_found_through_what_hands_names_on() {
        let root = ("src/lib.rs", "mod a; mod b; mod c;");
        let a = ("src/a.rs", "use super::b::B;\npub struct A(B);");
        let c = ("src/c.rs", "use crate::a::A;");
        assert_eq!(found(&[root, a, ("src/b.rs", "pub struct B;"), c]), [""; 0]);
        let both = ["src/a.rs imports src/b.rs", "src/b.rs imports src/a.rs"];
        assert_eq!(found(&[root, a, ("src/b.rs", "pub struct B; fn f(_: crate::a::A) {}"), c]), both);
        // Here `b` is a folder, and its `mod.rs` re-exports what `part.rs` defines.
        let face = ("src/b/mod.rs", "mod part;\npub(crate) use part::{B, Other};");
        let part = ("src/b/part.rs", "use super::super::a::A;\npub struct B(A);");
        let both = ["src/a.rs imports src/b/part.rs", "src/b/part.rs imports src/a.rs"];
        assert_eq!(found(&[root, a, face, part]), both);
    }

    #[test]
    fn a_part_may_use_what_its_folder_defines_and_tests_may_use_all() {
        let face = ("src/b/mod.rs", "mod part; pub struct Shared; fn f() { part::g() }");
        let part = ("src/b/part.rs", "use super::Shared; pub fn g() {}");
        assert_eq!(found(&[("src/lib.rs", "mod b;"), face, part]), [""; 0]);
        let tested = ("src/a.rs", "pub struct A;\n#[cfg(test)]\nmod tests {\n    use crate::c::C;\n}\n");
        assert_eq!(found(&[tested, ("src/c.rs", "use crate::a::A;\npub struct C(A);")]), [""; 0]);
    }
}
