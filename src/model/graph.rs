//! Graph of links and joints: finds the root of the tree, loops, and where the base is.

use std::collections::HashMap;

use super::builder::{JointSpec, ModelBuilder};
use super::parts::Base;
use crate::error::LoadError;
use crate::joint::JointKind;

/// Name of the link that is the world itself.
const WORLD: &str = "world";

/// Joint that carries each link, and joints that each link carries.
pub(super) struct Graph {
    link_of_name: HashMap<String, usize>,
    carrier: Vec<Option<usize>>,
    /// The joints that each link carries.
    pub(super) carried: Vec<Vec<usize>>,
    /// The link that each joint moves.
    pub(super) child: Vec<usize>,
}

impl Graph {
    pub(super) fn new(builder: &ModelBuilder) -> Result<Self, LoadError> {
        let n = builder.links.len();
        if n == 0 {
            let (file, name) = (builder.source.clone(), builder.name.clone());
            return Err(LoadError::Missing {
                file,
                element: "robot".into(),
                name,
                missing: "link".into(),
            });
        }
        let link_of_name = builder
            .links
            .iter()
            .enumerate()
            .map(|(i, link)| (link.name.clone(), i))
            .collect();
        let mut graph = Self {
            link_of_name,
            carrier: vec![None; n],
            carried: vec![Vec::new(); n],
            child: Vec::new(),
        };
        for (i, joint) in builder.joints.iter().enumerate() {
            graph.connect(builder, i, joint)?;
        }
        Ok(graph)
    }

    fn connect(
        &mut self,
        builder: &ModelBuilder,
        i: usize,
        joint: &JointSpec,
    ) -> Result<(), LoadError> {
        let (file, name) = (builder.source.clone(), joint.name.clone());
        let Some(&parent) = self.link_of_name.get(&joint.parent) else {
            return Err(LoadError::UnknownParent {
                file,
                element: "joint".into(),
                name,
                link: joint.parent.clone(),
            });
        };
        let Some(&child) = self.link_of_name.get(&joint.child) else {
            return Err(LoadError::UnknownChild {
                file,
                joint: name,
                link: joint.child.clone(),
            });
        };
        if self.carrier[child].is_some() || parent == child {
            return Err(LoadError::Loop {
                file,
                joint: name,
                link: joint.child.clone(),
            });
        }
        self.carrier[child] = Some(i);
        self.carried[parent].push(i);
        self.child.push(child);
        Ok(())
    }

    fn root(&self, builder: &ModelBuilder) -> Result<usize, LoadError> {
        let mut roots = (0..self.carrier.len()).filter(|&i| self.carrier[i].is_none());
        match (roots.next(), roots.next()) {
            (Some(root), None) => Ok(root),
            (Some(first), Some(second)) => Err(LoadError::SeveralRoots {
                file: builder.source.clone(),
                roots: [first, second]
                    .into_iter()
                    .chain(roots)
                    .map(|i| builder.links[i].name.clone())
                    .collect(),
            }),
            (None, _) => Err(self.loop_at(builder, 0)),
        }
    }

    /// Checks that a walk from the root reached every link: with one root and one carrier a link, what was not reached
    /// hangs on a loop.
    pub(super) fn check_reached(
        &self,
        builder: &ModelBuilder,
        seen: &[bool],
    ) -> Result<(), LoadError> {
        match seen.iter().position(|&seen| !seen) {
            None => Ok(()),
            Some(lost) => Err(self.loop_at(builder, lost)),
        }
    }

    /// The loop that is met by walking up from a link that has no root above it.
    fn loop_at(&self, builder: &ModelBuilder, from: usize) -> LoadError {
        let mut link = from;
        let mut joint = String::new();
        for _ in 0..builder.links.len() {
            let Some(carrier) = self.carrier[link] else {
                break;
            };
            joint.clone_from(&builder.joints[carrier].name);
            link = self.link_of_name[&builder.joints[carrier].parent];
        }
        LoadError::Loop {
            file: builder.source.clone(),
            joint,
            link: builder.links[link].name.clone(),
        }
    }

    /// The link from which the tree grows, as the wanted base says.
    pub(super) fn start(&self, builder: &ModelBuilder) -> Result<Start, LoadError> {
        let root = self.root(builder)?;
        let is_world = builder.links[root].name == WORLD;
        match builder.base {
            Base::Fixed => Ok(Start::at(root, false)),
            Base::Auto => Ok(Start::at(root, !is_world)),
            Base::Floating if !is_world => Ok(Start::at(root, true)),
            Base::Floating => match self.carried[root][..] {
                [only] if builder.joints[only].kind == JointKind::Fixed => Ok(Start {
                    world: Some(root),
                    joint: Some(only),
                    ..Start::at(self.child[only], true)
                }),
                _ => Err(LoadError::UnsupportedBase {
                    file: builder.source.clone(),
                    link: WORLD.into(),
                    reason: "it floats only if exactly one link hangs on it, by a fixed joint"
                        .into(),
                }),
            },
        }
    }
}

/// Start of the walk.
pub(super) struct Start {
    /// The link that stands in the world or floats.
    pub(super) link: usize,
    pub(super) floating: bool,
    /// A link called `world` above it that is left out of the tree.
    pub(super) world: Option<usize>,
    /// The fixed joint on the link `world`, if that is left out: its placement is the pose of the link in the frame that floats.
    pub(super) joint: Option<usize>,
}

impl Start {
    fn at(link: usize, floating: bool) -> Self {
        Self {
            link,
            floating,
            world: None,
            joint: None,
        }
    }
}
