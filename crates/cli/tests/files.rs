//! No files of a crate go in a circle, and a command is for nobody but the user.
//!
//! Compared are siblings: the modules of one folder, each with what is below it. A module and its parent belong
//! together, so a child may use its parent.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::indexing_slicing, reason = "a test may panic")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemUse, Meta, UseTree};

/// The path of a module in its crate; the crate itself is empty.
type Module = Vec<String>;

fn crates() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The files below a folder as the modules that they are.
fn modules(folder: &Path, at: &Module, found: &mut BTreeMap<Module, syn::File>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let root = at.is_empty() && matches!(name.as_str(), "lib" | "main");
        let module = if root { Module::new() } else { [at.as_slice(), &[name]].concat() };
        if path.is_dir() {
            modules(&path, &module, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.insert(module, syn::parse_file(&fs::read_to_string(path).unwrap()).unwrap());
        }
    }
}

/// What a file names in its own crate.
struct Uses<'a> {
    module: &'a Module,
    paths: BTreeSet<Module>,
    /// What it hands on: the name, and what stands behind it.
    handed_on: BTreeMap<String, Module>,
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        _ => false,
    })
}

impl Uses<'_> {
    fn of(module: &Module, file: &syn::File) -> (BTreeSet<Module>, BTreeMap<String, Module>) {
        let mut uses = Uses { module, paths: BTreeSet::new(), handed_on: BTreeMap::new() };
        uses.visit_file(file);
        (uses.paths, uses.handed_on)
    }

    /// A path from the root of the crate; one that does not begin with `crate`, `super` or `self` may begin with a
    /// module of this one.
    fn rooted(&self, path: &[String]) -> Module {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let above = &self.module[..self.module.len().saturating_sub(supers)];
        match path.first().map(String::as_str) {
            Some("crate") => path[1..].to_vec(),
            Some("self") => [self.module, &path[1..]].concat(),
            _ => [above, &path[supers..]].concat(),
        }
    }

    fn tree(&mut self, tree: &UseTree, before: &[String], item: &ItemUse) {
        let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
        let (path, name) = match tree {
            UseTree::Path(path) => return self.tree(&path.tree, &with(&path.ident), item),
            UseTree::Group(group) => {
                return group.items.iter().for_each(|tree| self.tree(tree, before, item));
            }
            UseTree::Name(name) => (with(&name.ident), name.ident.to_string()),
            UseTree::Rename(rename) => (with(&rename.ident), rename.rename.to_string()),
            UseTree::Glob(_) => (before.to_vec(), String::new()),
        };
        let path = self.rooted(&path);
        if !matches!(item.vis, syn::Visibility::Inherited) {
            self.handed_on.insert(name, path.clone());
        }
        self.paths.insert(path);
    }
}

impl<'ast> Visit<'ast> for Uses<'_> {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Mod(item) => &item.attrs,
            Item::Fn(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            _ => return visit::visit_item(self, item),
        };
        if !is_test(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.tree(&item.tree, &[], item);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let path_of: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if path_of.len() > 1 {
            let path_of = self.rooted(&path_of);
            self.paths.insert(path_of);
        }
        visit::visit_path(self, path);
    }
}

/// Which modules of a crate use which others. A name that one hands on stands for where it comes from.
fn uses(source: &Path) -> BTreeMap<Module, BTreeSet<Module>> {
    let mut files = BTreeMap::new();
    modules(source, &Module::new(), &mut files);
    files.retain(|module, _| module.iter().all(|name| name != "tests"));
    let found: BTreeMap<_, _> =
        files.iter().map(|(module, file)| (module.clone(), Uses::of(module, file))).collect();
    let home = |path: &Module| {
        let mut path = path.clone();
        // Who hands on what was handed on; longer chains there are none.
        for _ in 0..4 {
            let known = (0..=path.len()).rev().find(|n| found.contains_key(&path[..*n])).unwrap_or(0);
            let (_, handed_on) = &found[&path[..known]];
            match path.get(known).and_then(|name| handed_on.get(name)) {
                Some(origin) if *origin != path => path = [origin.as_slice(), &path[known + 1..]].concat(),
                _ => return path[..known].to_vec(),
            }
        }
        unreachable!("{path:?} is handed on too often")
    };
    found.iter().map(|(module, (paths, _))| (module.clone(), paths.iter().map(home).collect())).collect()
}

/// The edges among siblings, each by its path.
fn siblings(uses: &BTreeMap<Module, BTreeSet<Module>>) -> BTreeMap<Module, BTreeSet<Module>> {
    let mut edges: BTreeMap<Module, BTreeSet<Module>> = BTreeMap::new();
    for (from, targets) in uses {
        for to in targets {
            let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
            // One of them may be the other, or above it.
            if common < from.len().min(to.len()) {
                edges.entry(from[..=common].to_vec()).or_default().insert(to[..=common].to_vec());
            }
        }
    }
    edges
}

/// The way from a module back to itself, if there is one.
fn circle(edges: &BTreeMap<Module, BTreeSet<Module>>, from: &Module) -> Option<Vec<Module>> {
    let mut ways = vec![vec![from.clone()]];
    let mut seen = BTreeSet::new();
    while let Some(way) = ways.pop() {
        for next in edges.get(way.last()?).into_iter().flatten() {
            let longer = [way.as_slice(), std::slice::from_ref(next)].concat();
            if next == from {
                return Some(longer);
            }
            if seen.insert(next.clone()) {
                ways.push(longer);
            }
        }
    }
    None
}

#[test]
fn no_files_of_a_crate_go_in_a_circle() {
    let mut circles = Vec::new();
    for entry in fs::read_dir(crates()).unwrap() {
        let source = entry.unwrap().path().join("src");
        let edges = siblings(&uses(&source));
        let found = edges.keys().filter_map(|module| circle(&edges, module));
        circles.extend(found.map(|way| {
            let way: Vec<_> = way.iter().map(|module| module.join("::")).collect();
            format!("{}: {}", source.display(), way.join(" -> "))
        }));
    }
    assert!(circles.is_empty(), "{}", circles.join("\n"));
}

#[test]
fn nothing_imports_a_command() {
    let source = crates().join("cli/src");
    let main = fs::read_to_string(source.join("main.rs")).unwrap();
    let (_, list) = main.split_once("\ncommands! {").expect("the list of the commands");
    let pairs = list.trim_end().trim_end_matches('}').split(',').filter(|pair| !pair.trim().is_empty());
    let commands: BTreeSet<&str> = pairs.map(|pair| pair.split_whitespace().nth(1).unwrap()).collect();
    assert!(commands.contains("decode") && commands.len() > 10, "{commands:?}");
    for (module, targets) in uses(&source) {
        for target in &targets {
            let command = target.first().filter(|name| commands.contains(name.as_str()));
            assert!(
                module.is_empty() || command.is_none() || command == module.first(),
                "{} imports the command {}",
                module.join("::"),
                target.join("::")
            );
        }
    }
}
