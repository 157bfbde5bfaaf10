//! `<include>`: models from other files, which must be at hand; nothing is fetched from anywhere.

use std::path::PathBuf;

use super::reader::{Reader, candidates};
use super::schema;
use super::values::required_text;
use super::version::Version;
use crate::error::LoadError;
use crate::io::context::{Context, Node, tag};
use crate::io::mesh_path::MeshFinder;
use crate::io::schema::check;
use crate::io::{guard, read_text};

/// Most files of a robot: enough for any, and few enough that files that include one another soon end.
const MAX_INCLUDED: usize = 500;

/// The file of a model in the folder of its name.
const MODEL_FILE: &str = "model.sdf";

impl Reader<'_, '_, '_> {
    /// Reads an included model into a scope; returns its index.
    pub(super) fn include(&mut self, node: Node<'_>, scope: usize) -> Result<usize, LoadError> {
        check(&mut self.context, node, &schema::INCLUDE)?;
        let uri = required_text(&mut self.context, node, "uri")?;
        if node
            .attribute("merge")
            .is_some_and(|merge| matches!(merge, "true" | "1"))
        {
            return Err(self.unsupported(node, "merging an included model is not supported"));
        }
        let overrides = self.overrides(node)?;
        let path = self.find_included(node, &uri)?;
        let file = path.display().to_string();
        let content = read_text(&file, &path)?;
        let xml = guard::parse(&file, &content, "sdf")?;
        let root = xml.root_element();
        let mut context = Context::new(&file, &content);
        check(&mut context, root, &schema::ROOT)?;
        let version = Version::read(&mut context, root)?;
        let model = included_model(&mut context, root)?;
        let finder = MeshFinder::new(path.parent(), self.shared.search_paths);
        self.shared.open.push(path.clone());
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
    /// The file of an include, if it may be read.
    fn find_included(&mut self, node: Node<'_>, uri: &str) -> Result<PathBuf, LoadError> {
        let in_folder = || format!("{}/{MODEL_FILE}", uri.trim_end_matches('/'));
        let found = self
            .finder
            .find(uri)
            .or_else(|| self.finder.find(&in_folder()));
        let fail = |reason: &str| LoadError::Include {
            file: self.context.file.into(),
            line: self.context.line(node),
            uri: uri.into(),
            reason: reason.into(),
        };
        let path = found.ok_or_else(|| {
            fail("there is no such file; with_search_path says where to look for models")
        })?;
        if self.shared.open.contains(&path) {
            return Err(fail("the file includes itself"));
        }
        self.shared.included += 1;
        if self.shared.included > MAX_INCLUDED {
            return Err(fail("too many files"));
        }
        Ok(path)
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
