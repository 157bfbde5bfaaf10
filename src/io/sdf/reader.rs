//! Reads models with their frames, links, joints, nested and included models.

use std::borrow::Cow;
use std::path::PathBuf;

use super::scene::{FrameEntry, FrameKind, ModelEntry, Nesting, Pose, Scene};
use super::schema;
use super::values::{check_value, text, text_of, truth};
use super::version::WITH_FRAMES;
use crate::error::LoadError;
use crate::io::ModelOptions;
use crate::io::context::{Context, Node, child, children, is_native, tag};
use crate::io::mesh_path::MeshFinder;
use crate::io::place::element;
use crate::io::schema::check;
use crate::io::values::{Attributes, Values};
use crate::io::version::Version;
use crate::sorting::sort_seldom;

/// Largest depth of nested models: robots need three or so, and the stack has room for more.
const MAX_DEPTH: usize = 50;

/// Remark: whether a merged model is static is not read.
pub(super) const MERGED_IS_STATIC: &str = "merged parts move or stay as the model around them does";

/// State that all files of a robot share.
#[derive(Debug)]
pub(super) struct Shared<'s> {
    pub(super) scene: Scene,
    pub(super) options: &'s ModelOptions,
    /// The files that are being read, one included by the other.
    pub(super) open: Vec<PathBuf>,
    /// Number of files included so far.
    pub(super) included: usize,
    /// Bytes that the included files have together.
    pub(super) included_bytes: u64,
    pub(super) depth: usize,
}

/// The reader of one file.
#[derive(Debug)]
pub(super) struct Reader<'r, 'c, 's> {
    pub(super) shared: &'r mut Shared<'s>,
    pub(super) context: Context<'c>,
    pub(super) version: Version,
    pub(super) finder: MeshFinder,
}

/// Values that an include sets in the stead of the model's own.
#[derive(Clone, Debug, Default)]
pub(super) struct Overrides {
    pub(super) name: Option<String>,
    pub(super) pose: Option<Pose>,
    pub(super) is_static: Option<bool>,
    pub(super) placement_frame: Option<String>,
    pub(super) nesting: Nesting,
}

impl Reader<'_, '_, '_> {
    /// Reads a model into a scope; returns its index.
    pub(super) fn model(
        &mut self,
        node: Node<'_>,
        scope: usize,
        overrides: Overrides,
    ) -> Result<usize, LoadError> {
        check(&mut self.context, node, &schema::MODEL)?;
        let is_static = self.is_static(node, scope, &overrides)?;
        let name = overrides.name.map_or_else(|| self.name(node), Ok)?;
        let pose = overrides.pose.map_or_else(|| self.pose(node), Ok)?;
        let nesting = overrides.nesting;
        let index = self.shared.scene.models.len();
        let prefix = self.prefix(scope, index, &name, nesting);
        let placement_frame = overrides.placement_frame;
        let model = ModelEntry {
            nesting,
            is_static,
            canonical_link: attribute(node, "canonical_link"),
            placement_frame: placement_frame.or_else(|| attribute(node, "placement_frame")),
            ..ModelEntry::new(self.shared.scene.frames.len(), prefix)
        };
        self.shared.scene.models.push(model);
        let kind = FrameKind::Model(index);
        if nesting == Nesting::Scoped {
            self.add_frame(node, scope, &name, kind, pose)?;
            self.parts(node, index)?;
        } else {
            self.add_nameless_frame(node, scope, &name, kind, pose);
            self.parts(node, index)?;
            self.merge_names(index, scope)?;
        }
        Ok(index)
    }

    /// Whether a model stays where it is: as a part of one that does, or by itself.
    fn is_static(
        &mut self,
        node: Node<'_>,
        scope: usize,
        overrides: &Overrides,
    ) -> Result<bool, LoadError> {
        let around = self.shared.scene.models[scope].is_static;
        let own = self.flag(node, "static")?;
        if overrides.nesting == Nesting::Scoped {
            return Ok(around || overrides.is_static.or(own).unwrap_or_default());
        }
        if let Some(flag) = child(node, "static") {
            self.context.ignore(flag, MERGED_IS_STATIC);
        }
        Ok(around)
    }

    /// Prefix of the names of a model's parts; empty for the model that becomes the robot.
    fn prefix(&mut self, scope: usize, index: usize, name: &str, nesting: Nesting) -> String {
        let scene = &mut self.shared.scene;
        let around = &scene.models[scope].prefix;
        if nesting == Nesting::Merged {
            return around.clone();
        }
        let robot = *scene.robot.get_or_insert(index);
        if robot == index {
            return String::new();
        }
        format!("{around}{name}::")
    }

    /// Gives the parts of a merged model their names in the model around it.
    fn merge_names(&mut self, merged: usize, scope: usize) -> Result<(), LoadError> {
        let scene = &mut self.shared.scene;
        let names = scene.models[merged].names.clone();
        let mut names: Vec<(String, usize)> = names.into_iter().collect();
        sort_seldom(&mut names, |(_, one), (_, other)| one.cmp(other));
        for (name, frame) in names {
            if scene.models[scope].names.contains_key(&name) {
                return Err(scene.frames[frame].place.duplicate(&name));
            }
            scene.models[scope].names.insert(name, frame);
        }
        Ok(())
    }

    /// Nesting depth of models.
    fn enter(&mut self, node: Node<'_>) -> Result<(), LoadError> {
        self.shared.depth += 1;
        if self.shared.depth <= MAX_DEPTH {
            return Ok(());
        }
        let reason = format!("models are nested more than {MAX_DEPTH} deep");
        Err(self.unsupported(node, reason))
    }

    fn parts(&mut self, model: Node<'_>, index: usize) -> Result<(), LoadError> {
        self.enter(model)?;
        for part in model.children().filter(|part| is_native(*part)) {
            match tag(part) {
                "link" => self.link(part, index)?,
                "joint" => self.joint(part, index)?,
                "frame" => self.frame(part, index)?,
                "model" => {
                    self.model(part, index, Overrides::default())?;
                }
                "include" => {
                    self.include(part, index)?;
                }
                _ => {}
            }
        }
        self.shared.depth -= 1;
        Ok(())
    }

    /// Reads a frame.
    pub(super) fn frame(&mut self, node: Node<'_>, scope: usize) -> Result<(), LoadError> {
        check(&mut self.context, node, &schema::FRAME)?;
        let name = self.name(node)?;
        let mut attached_to = attribute(node, "attached_to");
        if attached_to.is_some() && self.version < WITH_FRAMES {
            let reason = "read from version 1.7 of the SDF on";
            self.context.ignore_attribute(node, "attached_to", reason);
            attached_to = None;
        }
        let pose = self.pose(node)?;
        self.add_frame(node, scope, &name, FrameKind::Free(attached_to), pose)?;
        Ok(())
    }

    /// Gives a place a name in a scope; returns its index.
    pub(super) fn add_frame(
        &mut self,
        node: Node<'_>,
        scope: usize,
        name: &str,
        kind: FrameKind,
        pose: Pose,
    ) -> Result<usize, LoadError> {
        let index = self.shared.scene.frames.len();
        let model = &mut self.shared.scene.models[scope];
        // Names of joints were apart before version 1.7.
        let is_apart = self.version < WITH_FRAMES && matches!(kind, FrameKind::Joint(_));
        if name == "world" || (name.starts_with("__") && name.ends_with("__")) {
            let reason = "the name is reserved";
            return Err(self.context.malformed(node, "name", reason));
        }
        if model.names.contains_key(name) && !is_apart {
            return Err(LoadError::DuplicateName {
                at: self.context.position(node),
                element: tag(node).into(),
                name: name.into(),
            });
        }
        model.names.entry(name.into()).or_insert(index);
        Ok(self.add_nameless_frame(node, scope, name, kind, pose))
    }

    /// Adds a place to a scope, where nothing can refer to it by the name; returns its index.
    fn add_nameless_frame(
        &mut self,
        node: Node<'_>,
        scope: usize,
        name: &str,
        kind: FrameKind,
        pose: Pose,
    ) -> usize {
        let scene = &mut self.shared.scene;
        let index = scene.frames.len();
        scene.models[scope].members.push(index);
        scene.frames.push(FrameEntry {
            scope,
            name: format!("{}{name}", scene.models[scope].prefix),
            kind,
            pose,
            place: self.context.keep(node),
        });
        index
    }

    /// The name that an element must have.
    pub(super) fn name(&mut self, node: Node<'_>) -> Result<String, LoadError> {
        Attributes::required_text(&mut self.context, node, "name").map(Cow::into_owned)
    }

    /// A child element that says yes or no, if there is one.
    pub(super) fn flag(&mut self, node: Node<'_>, name: &str) -> Result<Option<bool>, LoadError> {
        match child(node, name) {
            None => Ok(None),
            Some(flag) => {
                check_value(&mut self.context, flag, "")?;
                truth(&self.context, node, name, &text_of(flag)).map(Some)
            }
        }
    }

    pub(super) fn unsupported(&self, node: Node<'_>, reason: impl Into<String>) -> LoadError {
        LoadError::Unsupported {
            at: self.context.position(node),
            element: element(node),
            name: self.context.name_or_line(node),
            reason: reason.into(),
        }
    }

    /// Reads the values that an include sets in the stead of the model's own.
    pub(super) fn overrides(&mut self, node: Node<'_>) -> Result<Overrides, LoadError> {
        let pose = child(node, "pose").map(|_| self.pose(node)).transpose()?;
        let placement = text(&mut self.context, node, "placement_frame")?;
        let merge = node.attribute("merge").unwrap_or_default();
        let nesting = if truth(&self.context, node, "merge", merge)? {
            Nesting::Merged
        } else {
            Nesting::Scoped
        };
        Ok(Overrides {
            nesting,
            name: text(&mut self.context, node, "name")?,
            pose,
            is_static: self.flag(node, "static")?,
            placement_frame: placement.or_else(|| attribute(node, "placement_frame")),
        })
    }
}

/// An attribute that is not empty.
pub(super) fn attribute(node: Node<'_>, name: &str) -> Option<String> {
    let value = node.attribute(name).filter(|value| !value.is_empty());
    value.map(Into::into)
}

/// The models and includes in an element.
pub(super) fn candidates<'a>(node: Node<'a>) -> impl Iterator<Item = Node<'a>> {
    children(node, "model").chain(children(node, "include"))
}
