//! `<include>`: models from other files, which must be at hand; nothing is fetched from anywhere.
//!
//! A reference to a folder means the file that its `model.config` names, or else the `model.sdf` in it. With
//! `merge="true"` the parts of the model stand in the including one as its own, placed by the frame of the included
//! model.

use std::path::{Path, PathBuf};

use super::reader::{Reader, candidates};
use super::scene::{Nesting, WORLD};
use super::schema;
use super::values::{Elements, text_of};
use super::version;
use crate::error::LoadError;
use crate::input::MAX_TEXT_BYTES;
use crate::io::context::{Context, Node, child, children, tag};
use crate::io::guard;
use crate::io::mesh_path::MeshFinder;
use crate::io::schema::check;
use crate::io::values::Values;
use crate::io::version::Version;

/// Most files of a robot: enough for any, and few enough that files that include each other soon end.
const MAX_INCLUDED: usize = 500;

/// The file that says which file of a folder holds the model, by version of the SDF.
const CONFIG_FILE: &str = "model.config";

/// Default file of a model, in the folder with its name.
const MODEL_FILE: &str = "model.sdf";

impl Reader<'_, '_, '_> {
    /// Reads an included model into a scope; returns its index.
    pub(super) fn include(&mut self, node: Node<'_>, scope: usize) -> Result<usize, LoadError> {
        check(&mut self.context, node, &schema::INCLUDE)?;
        let uri = Elements::required_text(&mut self.context, node, "uri")?;
        let overrides = self.overrides(node)?;
        if overrides.nesting == Nesting::Merged {
            self.check_merge(node, scope)?;
        }
        let path = self.find_included(node, &uri)?;
        let file = path.display().to_string();
        let content = self.shared.options.read_text(&file, &path)?;
        self.check_content(node, &uri, &content)?;
        let xml = guard::parse(&file, &content, "sdf")?;
        let root = xml.root_element();
        let mut context = Context::new(&file, &content);
        check(&mut context, root, &schema::ROOT)?;
        let version = version::read(&mut context, root)
            .map_err(|_| self.refused(node, &uri, "the file states no version of the SDF"))?;
        let model = included_model(&mut context, root)?;
        let finder = MeshFinder::new(path.parent(), self.shared.options);
        self.shared.open.push(path);
        let mut reader = Reader {
            shared: &mut *self.shared,
            context,
            version,
            finder,
        };
        let index = reader.model(model, scope, overrides)?;
        let remarks = reader.context;
        self.shared.open.pop();
        self.context.take_remarks(remarks);
        Ok(index)
    }

    /// Checks that parts are merged into a model, not into a world; they move as that model does.
    fn check_merge(&mut self, node: Node<'_>, scope: usize) -> Result<(), LoadError> {
        if scope == WORLD {
            let reason =
                "models are merged into models, not into a world: remove the attribute merge";
            return Err(self.unsupported(node, reason));
        }
        if let Some(flag) = child(node, "static") {
            self.context.ignore(flag, super::reader::MERGED_IS_STATIC);
        }
        Ok(())
    }

    /// Refuses a file that is not SDF, or too large with the others. No error quotes it, as anyone can write a reference
    /// to any file.
    fn check_content(&mut self, node: Node<'_>, uri: &str, content: &str) -> Result<(), LoadError> {
        self.shared.included_bytes += content.len() as u64;
        if self.shared.included_bytes > MAX_TEXT_BYTES {
            let reason = format!("the included files have more than {MAX_TEXT_BYTES} bytes");
            return Err(self.refused(node, uri, &reason));
        }
        if guard::begins_with(content, "sdf") {
            return Ok(());
        }
        Err(self.refused(node, uri, "the file is not SDF"))
    }

    /// The file of an include, if it may be read.
    fn find_included(&mut self, node: Node<'_>, uri: &str) -> Result<PathBuf, LoadError> {
        let config = self.finder.find_in_folder(uri, CONFIG_FILE);
        let found = match (self.finder.find(uri), config) {
            (Some(path), _) => Some(path),
            (None, Some(config)) => Some(self.configured(node, uri, &config)?),
            (None, None) => self.finder.find_in_folder(uri, MODEL_FILE),
        };
        let places = self.finder.places();
        let path = found.ok_or_else(|| {
            let hint = "a search path says where to look for models";
            self.refused(node, uri, &format!("there is no such file{places}; {hint}"))
        })?;
        if self.shared.open.contains(&path) {
            return Err(self.refused(node, uri, "the file includes itself"));
        }
        self.shared.included += 1;
        if self.shared.included > MAX_INCLUDED {
            return Err(self.refused(node, uri, "too many files"));
        }
        Ok(path)
    }

    /// The file that a `model.config` names for the newest version of the SDF that is known.
    fn configured(&self, node: Node<'_>, uri: &str, config: &Path) -> Result<PathBuf, LoadError> {
        let file = config.display().to_string();
        let content = self.shared.options.read_text(&file, config)?;
        if !guard::begins_with(&content, "model") {
            let reason = format!("{file} does not describe a model");
            return Err(self.refused(node, uri, &reason));
        }
        let xml = guard::parse(&file, &content, "model")?;
        let root = xml.root_element();
        let context = Context::new(&file, &content);
        let version = |node: &Node<'_>| {
            let version = Version::parse(node.attribute("version").unwrap_or_default());
            (version.is_none_or(version::is_known), version)
        };
        let newest = children(root, "sdf").max_by_key(version);
        let newest = newest.ok_or_else(|| context.missing(root, "child element <sdf>"))?;
        let name = text_of(newest);
        let found = self.finder.existing(&config.with_file_name(&name));
        let places = self.finder.places();
        let reason = format!("there is no such file{places}");
        found.ok_or_else(|| context.malformed_value(newest, "file", &name, reason))
    }

    fn refused(&self, node: Node<'_>, uri: &str, reason: &str) -> LoadError {
        LoadError::Include {
            file: self.context.file.into(),
            line: self.context.line(node),
            uri: uri.into(),
            reason: reason.into(),
        }
    }
}

/// The first model of a file.
fn included_model<'a>(context: &mut Context<'_>, root: Node<'a>) -> Result<Node<'a>, LoadError> {
    let mut models = candidates(root);
    let model = models.next().filter(|model| tag(*model) == "model");
    let model = model.ok_or_else(|| context.missing(root, "child element <model>"))?;
    for other in models {
        context.ignore(other, "only the first model is included");
    }
    Ok(model)
}
