//! Reads a file and what it includes into one tree.
//!
//! The elements of an included file replace its `<include>`. Its path is taken from the folder of the description, or else from
//! that of the file that includes it. Nothing is fetched.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use super::tree::{Attribute, Element, Tree};
use crate::error::LoadError;
use crate::input::MAX_TEXT_BYTES;
use crate::io::ModelOptions;
use crate::io::context::{Context, Node as XmlNode, is_native, tag};
use crate::io::guard;
use crate::io::mesh_path::MeshFinder;
use crate::io::place::ImportNote;

/// Most files of a robot: enough for any, and few enough that files that include each other soon end.
const MAX_INCLUDED: usize = 500;

/// Root elements of files that may be included.
const ROOTS: [&str; 2] = ["mujocoinclude", "mujoco"];

/// Data that the readers of all files of a description share.
#[derive(Debug)]
pub(super) struct Files<'o> {
    pub(super) options: &'o ModelOptions,
    pub(super) ignored: Vec<ImportNote>,
    /// The files that are being read, one named by the other.
    open: Vec<PathBuf>,
    /// Number of files read so far, and their bytes together.
    count: usize,
    bytes: u64,
}

impl<'o> Files<'o> {
    pub(super) fn new(options: &'o ModelOptions) -> Self {
        Self {
            options,
            ignored: Vec::new(),
            open: Vec::new(),
            count: 0,
            bytes: 0,
        }
    }

    /// Reads a description with all that it includes.
    pub(super) fn tree(
        &mut self,
        file: &str,
        text: &str,
        path: Option<&Path>,
    ) -> Result<Tree, LoadError> {
        let mut tree = Tree::new();
        let folder = path.and_then(Path::parent).map(Path::to_path_buf);
        self.open.extend(path.map(Path::to_path_buf));
        let source = Source {
            file,
            folder: folder.clone(),
            main: folder,
        };
        self.read(&mut tree, text, &source, None)?;
        self.open
            .truncate(self.open.len() - usize::from(path.is_some()));
        Ok(tree)
    }

    /// Reads the elements of a file below an element, or as the root.
    fn read(
        &mut self,
        tree: &mut Tree,
        text: &str,
        source: &Source<'_>,
        below: Option<usize>,
    ) -> Result<(), LoadError> {
        let document = match below {
            None => guard::parse(source.file, text, "mujoco")?,
            Some(_) => guard::parse_any(source.file, text)?,
        };
        let mut context = Context::new(source.file, text);
        let file = tree.files.len();
        tree.files.push(Rc::from(source.file));
        let root = document.root_element();
        let parent = below.unwrap_or_else(|| push(tree, &context, root, 0, file));
        let mut open = Vec::new();
        push_children(&mut open, &mut context, root, parent);
        while let Some((node, parent)) = open.pop() {
            if tag(node) == "include" {
                self.include(tree, &context, node, source, parent)?;
                continue;
            }
            let index = push(tree, &context, node, parent, file);
            push_children(&mut open, &mut context, node, index);
        }
        self.ignored.extend(context.ignored);
        Ok(())
    }

    fn include(
        &mut self,
        tree: &mut Tree,
        context: &Context<'_>,
        node: XmlNode<'_>,
        source: &Source<'_>,
        parent: usize,
    ) -> Result<(), LoadError> {
        let uri = node.attribute("file").filter(|file| !file.is_empty());
        let uri = uri.ok_or_else(|| context.missing(node, "attribute file"))?;
        let folders = [source.main.as_deref(), source.folder.as_deref()];
        let refused = |reason: String| refused(context, node, uri, reason);
        let (path, text) = self.open_file(uri, &folders, &ROOTS).map_err(refused)?;
        let file = path.display().to_string();
        let included = Source {
            file: &file,
            folder: path.parent().map(Path::to_path_buf),
            main: source.main.clone(),
        };
        self.open.push(path.clone());
        self.read(tree, &text, &included, Some(parent))?;
        self.open.pop();
        Ok(())
    }

    /// Finds and reads a file that another one names. No reason quotes it, as anyone can write a reference to any file.
    pub(super) fn open_file(
        &mut self,
        uri: &str,
        folders: &[Option<&Path>],
        roots: &[&str],
    ) -> Result<(PathBuf, String), String> {
        let finders = folders.iter().flatten();
        let mut finders: Vec<MeshFinder> = finders
            .map(|folder| MeshFinder::new(Some(folder), self.options))
            .collect();
        finders.push(MeshFinder::new(None, self.options));
        let places = finders[0].places();
        let path = finders.iter_mut().find_map(|finder| finder.find(uri));
        let path = path.ok_or_else(|| {
            format!("there is no such file{places}; a search path says where to look")
        })?;
        if self.open.contains(&path) {
            return Err("the file includes itself".into());
        }
        self.count += 1;
        if self.count > MAX_INCLUDED {
            return Err("too many files".into());
        }
        let name = path.display().to_string();
        let text = self.options.read_text(&name, &path);
        let text = text.map_err(|_| "the file cannot be read".to_owned())?;
        self.bytes += text.len() as u64;
        if self.bytes > MAX_TEXT_BYTES {
            let reason = format!("the included files have more than {MAX_TEXT_BYTES} bytes");
            return Err(reason);
        }
        if !roots.iter().any(|root| guard::begins_with(&text, root)) {
            return Err("the file is not MJCF".into());
        }
        Ok((path, text))
    }

    /// Reads a model that another one attaches.
    pub(super) fn attached(
        &mut self,
        uri: &str,
        folder: Option<&Path>,
    ) -> Result<(PathBuf, Tree), AttachError> {
        let (path, text) = self.open_file(uri, &[folder], &ROOTS[1..])?;
        let file = path.display().to_string();
        let tree = self.tree(&file, &text, Some(&path))?;
        Ok((path, tree))
    }
}

/// Error of a model that another one attaches: of the reference, or of the file.
#[derive(Debug)]
pub(super) enum AttachError {
    Reference(String),
    Load(LoadError),
}

impl From<String> for AttachError {
    fn from(reason: String) -> Self {
        Self::Reference(reason)
    }
}

impl From<LoadError> for AttachError {
    fn from(error: LoadError) -> Self {
        Self::Load(error)
    }
}

/// The file that elements are from.
struct Source<'a> {
    file: &'a str,
    folder: Option<PathBuf>,
    /// Folder of the description that includes it, at the end.
    main: Option<PathBuf>,
}

fn refused(context: &Context<'_>, node: XmlNode<'_>, uri: &str, reason: String) -> LoadError {
    LoadError::Include {
        file: context.file.into(),
        line: context.line(node),
        uri: uri.into(),
        reason,
    }
}

/// Adds an element to its parent; returns its number.
fn push(
    tree: &mut Tree,
    context: &Context<'_>,
    node: XmlNode<'_>,
    parent: usize,
    file: usize,
) -> usize {
    let index = tree.elements.len();
    let attributes = node.attributes().map(|attribute| Attribute {
        name: attribute.name().into(),
        value: attribute.value().into(),
        is_read: Default::default(),
    });
    let section = match parent {
        0 => index,
        _ => tree.elements[parent].section,
    };
    tree.elements.push(Element {
        section,
        tag: tag(node).into(),
        attributes: attributes.collect(),
        parent,
        children: Vec::new(),
        line: context.line(node),
        file,
        is_read: Default::default(),
    });
    if index > 0 {
        tree.elements[parent].children.push(index);
    }
    index
}

/// Puts the child elements on a stack, the first on top; reports other nodes.
fn push_children<'a>(
    open: &mut Vec<(XmlNode<'a>, usize)>,
    context: &mut Context<'_>,
    node: XmlNode<'a>,
    parent: usize,
) {
    for child in node.children().rev() {
        if child.is_text() && !child.text().unwrap_or_default().trim().is_empty() {
            let note = text_note(context, node);
            context.ignored.push(note);
        } else if child.is_element() && !is_native(child) {
            let note = ImportNote::new(tag(child), "", context.line(child), FOREIGN);
            context.ignored.push(note);
        } else if child.is_element() {
            open.push((child, parent));
        }
    }
}

/// Reason of an element of another name space.
const FOREIGN: &str = "not read: an element of another name space";

fn text_note(context: &Context<'_>, node: XmlNode<'_>) -> ImportNote {
    ImportNote::new(
        tag(node),
        "",
        context.line(node),
        "text between the elements",
    )
}
