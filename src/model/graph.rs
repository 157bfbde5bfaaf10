//! Graph of links and joints: finds the root of the tree, loops, and the base.

use std::collections::HashMap;

use super::builder::{JointSpec, ModelBuilder};
use super::parts::Base;
use crate::error::LoadError;
use crate::joint::JointKind;

/// Name of the link that is the world itself.
pub(crate) const WORLD: &str = "world";

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
            let name = builder.name.clone();
            return Err(LoadError::Missing {
                at: builder.position("robot", &name),
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
        let name = joint.name.clone();
        let at = builder.position("joint", &name);
        let Some(&parent) = self.link_of_name.get(&joint.parent) else {
            return Err(LoadError::UnknownParent {
                at,
                element: "joint".into(),
                name,
                link: joint.parent.clone(),
            });
        };
        let Some(&child) = self.link_of_name.get(&joint.child) else {
            return Err(LoadError::UnknownChild {
                at,
                joint: name,
                link: joint.child.clone(),
            });
        };
        let link = joint.child.clone();
        if parent == child {
            let joints = vec![name];
            return Err(LoadError::Loop { at, joints, link });
        }
        if let Some(first) = self.carrier[child] {
            let joints = [builder.joints[first].name.clone(), name];
            return Err(LoadError::SeveralParents { at, joints, link });
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
    /// depends on a loop.
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
        let above = |link: &usize| {
            let joint = &builder.joints[self.carrier[*link]?];
            self.link_of_name.get(&joint.parent).copied()
        };
        let up = |from| std::iter::successors(Some(from), above);
        // After as many steps as there are links the walk is on the loop.
        let on_loop = up(from).nth(builder.links.len()).unwrap_or(from);
        let others = up(on_loop).skip(1).take_while(|&link| link != on_loop);
        let links = std::iter::once(on_loop).chain(others);
        let carriers = links.filter_map(|link| self.carrier[link]);
        let mut joints: Vec<_> = carriers.map(|i| builder.joints[i].name.clone()).collect();
        joints.reverse();
        LoadError::Loop {
            at: builder.position("joint", joints.first().map_or("", |name| name)),
            joints,
            link: builder.links[on_loop].name.clone(),
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
                    at: builder.position("link", WORLD),
                    link: WORLD.into(),
                    reason: "a link of that name stands still, and floats only with a single child on a fixed joint; load the robot with a fixed \
                             base, or rename the link to let it float with all its joints"
                        .into(),
                }),
            },
        }
    }
}

/// Start of the walk.
pub(super) struct Start {
    /// The root link, fixed to the world or floating.
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
