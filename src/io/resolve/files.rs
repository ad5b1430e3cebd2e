//! The files that a scene names.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::{Error, ErrorKind, Result, did_you_mean};
use crate::geometry::Shape;
use crate::scene::description::Reference;
use crate::scene::{Instance, SceneDescription};

use super::super::read_model;
use super::{Loader, ReadOptions};

/// The folders whose trees the scene may read from.
pub(super) fn roots(description: &SceneDescription, options: &ReadOptions) -> Result<Vec<PathBuf>> {
    let canonical = |path: &Path| path.canonicalize().map_err(|e| Error::read(path, &e));
    let own = canonical(description.source.folder())?;
    let scenes = own.ancestors().find(|folder| folder.ends_with("scenes"));
    let beside = scenes.and_then(|scenes| scenes.with_file_name("assets").canonicalize().ok());
    let allowed = options.allow_paths.iter().map(|path| canonical(path));
    let mut roots = allowed.collect::<Result<Vec<_>>>()?;
    roots.extend(beside);
    roots.push(own);
    Ok(roots)
}

impl Loader<'_> {
    /// The parts of a model.
    pub(super) fn model(&mut self, file: &Reference) -> Result<&Vec<Instance>> {
        let path = self.find(file)?;
        if !self.models.contains_key(&path) {
            let model = read_model(&path).map_err(|e| e.at(self.place(file.offset)))?;
            let parts = self.scene.adopt(model);
            for part in &parts {
                if let Shape::Mesh(id) = part.shape {
                    let source = || (path.clone(), part.name.clone());
                    self.meshes.entry(id).or_insert_with(source);
                }
            }
            self.models.insert(path.clone(), parts);
        }
        Ok(&self.models[&path])
    }

    /// The real path of a file that the scene names, which must exist inside one of the roots.
    pub(super) fn find(&self, file: &Reference) -> Result<PathBuf> {
        let path = self.description.source.folder().join(&file.name);
        let real = path.canonicalize().map_err(|e| {
            let message = format!("cannot read the file `{}`: {e}", file.name);
            let error = Error::new(ErrorKind::Read, message).at(self.place(file.offset));
            error.help(self.neighbour(&path).unwrap_or_else(|| {
                format!(
                    "paths start at the scene's folder, so this is {}",
                    path.display()
                )
            }))
        })?;
        if self.may_read(&real) {
            return Ok(real);
        }
        let allow = real.parent().unwrap_or(&real).display();
        Err(Error::input(format!(
            "the file `{}` is outside the folders that this scene may read",
            file.name
        ))
        .at(self.place(file.offset))
        .help(format!(
            "move it into the scene's folder, or allow its own with `--allow-path {allow}`"
        )))
    }

    /// The help for a file that is not in its folder: another there whose name is much like it.
    fn neighbour(&self, path: &Path) -> Option<String> {
        let folder = path.parent()?.canonicalize().ok()?;
        if !self.may_read(&folder) {
            return None;
        }
        let entries = std::fs::read_dir(folder).ok()?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let names: BTreeSet<String> = names.collect();
        let help = did_you_mean(
            path.file_name()?.to_str()?,
            names.iter().map(String::as_str),
        );
        help.starts_with("did").then_some(help)
    }

    fn may_read(&self, real: &Path) -> bool {
        self.roots.iter().any(|root| real.starts_with(root))
    }
}
