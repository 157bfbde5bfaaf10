//! The models of a description: its own, and those that it attaches, each with its settings.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::assets::{Assets, Settings};
use super::compiler::Compiler;
use super::defaults::Classes;
use super::include::{AttachError, Files};
use super::tree::{Node, Tree};
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::nested::IntoNested;

/// A model as elements.
#[derive(Debug)]
pub(super) struct Document {
    pub(super) tree: Tree,
    folder: Option<PathBuf>,
    /// Models that it attaches, by name.
    models: HashMap<String, usize>,
}

/// Reads a description and all models that it attaches; its own comes first.
pub(super) fn read(
    files: &mut Files<'_>,
    file: &str,
    text: &str,
    path: Option<&Path>,
) -> Result<Vec<Document>, LoadError> {
    let tree = files.tree(file, text, path)?;
    let folder = path.and_then(Path::parent).map(Path::to_path_buf);
    let mut documents = vec![Document::new(tree, folder)];
    let mut at = 0;
    while at < documents.len() {
        let attached = attached(files, &documents[at])?;
        for (name, document) in attached {
            let index = documents.len();
            documents[at].models.insert(name, index);
            documents.push(document);
        }
        at += 1;
    }
    Ok(documents)
}

impl Document {
    fn new(tree: Tree, folder: Option<PathBuf>) -> Self {
        Self {
            tree,
            folder,
            models: HashMap::new(),
        }
    }
}

/// The models that one names in its assets.
fn attached(
    files: &mut Files<'_>,
    document: &Document,
) -> Result<Vec<(String, Document)>, LoadError> {
    let mut out = Vec::new();
    let assets = document.tree.root().all("asset").nested(Node::children);
    for node in assets.filter(|node| node.tag() == "model").map(Node::read) {
        let missing = |name: &str| node.place().missing(&format!("attribute {name}"));
        let uri = node.filled("file").ok_or_else(|| missing("file"))?;
        let name = node.filled("name").ok_or_else(|| missing("name"))?;
        let read = files.attached(uri, document.folder.as_deref());
        let (path, tree) = read.map_err(|error| match error {
            AttachError::Load(error) => error,
            AttachError::Reference(reason) => {
                let at = node.place().position;
                LoadError::Include {
                    file: at.file,
                    line: at.line,
                    uri: uri.into(),
                    reason,
                }
            }
        })?;
        let folder = path.parent().map(Path::to_path_buf);
        out.push((name.to_owned(), Document::new(tree, folder)));
    }
    Ok(out)
}

/// A model with its settings.
#[derive(Debug)]
pub(super) struct Source<'t> {
    pub(super) root: Node<'t>,
    pub(super) compiler: Compiler,
    pub(super) classes: Classes<'t>,
    pub(super) assets: Assets,
    pub(super) models: &'t HashMap<String, usize>,
}

impl<'t> Source<'t> {
    /// Reads the settings, classes and assets of a model.
    pub(super) fn of(document: &'t Document, options: &ModelOptions) -> Result<Self, LoadError> {
        let root = document.tree.root().read();
        // Attached models do not need it.
        root.attribute("model");
        let classes = Classes::read(root)?;
        let compiler = Compiler::read(root, &classes)?;
        let settings = Settings {
            compiler: &compiler,
            classes: &classes,
            folder: document.folder.as_deref(),
        };
        let assets = Assets::read(root, settings, options)?;
        Ok(Self {
            root,
            compiler,
            classes,
            assets,
            models: &document.models,
        })
    }
}
