//! Makes a tree of joints between links: finds the root and tells which joints lead towards it.

use super::frames::Placements;
use super::scene::{Scene, WORLD};
use crate::error::LoadError;

/// A joint on its way from the root outwards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Traversal {
    /// The walk goes from the parent of the joint to its child.
    Forward,
    /// The walk goes from the child of the joint to its parent.
    Backward,
}

/// An edge of the tree.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    pub(super) joint: usize,
    pub(super) direction: Traversal,
}

/// The joints in an order in which parents come before children.
#[derive(Debug)]
pub(super) struct Tree {
    /// The link at the root; `None` is the world.
    pub(super) root: Option<usize>,
    pub(super) edges: Vec<Edge>,
    /// Links on floating joints, if the root is the world with all models.
    pub(super) floating: Vec<usize>,
}

/// The ends of a joint; `None` is the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub(super) parent: Option<usize>,
    pub(super) child: Option<usize>,
}

/// The links at the ends of a joint.
pub(super) fn ends(
    scene: &Scene,
    placements: &Placements,
    joint: usize,
) -> Result<Ends, LoadError> {
    let joint = &scene.joints[joint];
    let entry = &scene.frames[joint.frame];
    let link = |name: &str| -> Result<Option<usize>, LoadError> {
        Ok(placements.link[scene.resolve(entry.scope, name, &entry.place)?])
    };
    let unknown = |_| LoadError::UnknownParent {
        at: entry.place.position.clone(),
        element: "joint".into(),
        name: entry.name.clone(),
        link: joint.parent.clone(),
    };
    Ok(Ends {
        parent: link(&joint.parent).map_err(unknown)?,
        child: link(&joint.child)?,
    })
}

/// `true` for a link that does not move whatever its joints are.
pub(super) fn is_static(scene: &Scene, link: usize) -> bool {
    scene.models[scene.frames[scene.links[link].frame].scope].is_static
}

/// Builds the tree.
pub(super) fn build(
    scene: &Scene,
    placements: &Placements,
    robot: usize,
) -> Result<Tree, LoadError> {
    let graph = Graph::new(scene, placements)?;
    let mut walk = Walk::new(scene, &graph);
    if robot == WORLD {
        return walk.all(&graph, placements);
    }
    let root = graph.root(placements, scene.models[robot].frame);
    walk.from(&graph, graph.node(root))?;
    graph.check_reached(scene, root, &walk.seen)?;
    Ok(Tree {
        root,
        edges: walk.edges,
        floating: Vec::new(),
    })
}

/// Node 0 is the world with everything static, node i + 1 is link i.
struct Graph {
    /// Joints at each node, with the node at the other end.
    joints: Vec<Vec<(Edge, usize)>>,
    /// Whether a joint has the node as its child, for each node.
    is_child: Vec<bool>,
    /// Whether anything holds on to the world.
    has_world: bool,
    is_static: Vec<bool>,
}

impl Graph {
    fn new(scene: &Scene, placements: &Placements) -> Result<Self, LoadError> {
        let n = scene.links.len();
        let is_static: Vec<bool> = (0..n).map(|link| is_static(scene, link)).collect();
        let mut graph = Self {
            joints: vec![Vec::new(); n + 1],
            is_child: vec![false; n + 1],
            has_world: is_static.contains(&true),
            is_static,
        };
        for joint in 0..scene.joints.len() {
            let ends = ends(scene, placements, joint)?;
            let (parent, child) = (graph.node(ends.parent), graph.node(ends.child));
            if is_held(scene, joint) {
                continue;
            }
            graph.has_world |= parent == 0 || child == 0;
            graph.is_child[child] = true;
            let edge = |direction| Edge { joint, direction };
            graph.joints[parent].push((edge(Traversal::Forward), child));
            graph.joints[child].push((edge(Traversal::Backward), parent));
        }
        Ok(graph)
    }

    fn node(&self, link: Option<usize>) -> usize {
        link.map_or(0, |link| if self.is_static[link] { 0 } else { link + 1 })
    }

    /// The world if anything holds on to it; else the link that no joint moves; of several, the canonical one.
    fn root(&self, placements: &Placements, robot: usize) -> Option<usize> {
        if self.has_world {
            return None;
        }
        let canonical = placements.link[robot];
        let is_free = |link: &usize| !self.is_child[link + 1];
        canonical
            .filter(is_free)
            .or_else(|| (0..self.is_static.len()).find(is_free))
            .or(canonical)
    }

    fn check_reached(
        &self,
        scene: &Scene,
        root: Option<usize>,
        seen: &[bool],
    ) -> Result<(), LoadError> {
        let name = |link: usize| scene.frames[scene.links[link].frame].name.clone();
        let lost = |link: &usize| !self.is_static[*link] && !seen[link + 1];
        let mut lost_links = (0..self.is_static.len()).filter(lost).peekable();
        let Some(&first) = lost_links.peek() else {
            return Ok(());
        };
        let mut roots = vec![root.map_or_else(|| "world".to_owned(), name)];
        let is_root = |link: &usize| !self.is_child[link + 1];
        roots.extend(lost_links.filter(is_root).map(name));
        if roots.len() == 1 {
            // Every one of them is moved by another.
            roots.push(name(first));
        }
        Err(LoadError::SeveralRoots {
            file: scene.frames[scene.links[first].frame]
                .place
                .position
                .file
                .clone(),
            roots,
        })
    }
}

/// A walk over the links, breadth first.
struct Walk<'s> {
    scene: &'s Scene,
    edges: Vec<Edge>,
    seen: Vec<bool>,
    /// Joints that were met.
    used: Vec<bool>,
    /// The joint that leads to each node, and the node from where.
    carriers: Vec<Option<(usize, usize)>>,
}

impl<'s> Walk<'s> {
    fn new(scene: &'s Scene, graph: &Graph) -> Self {
        let n = graph.joints.len();
        Self {
            scene,
            edges: Vec::new(),
            seen: vec![false; n],
            used: vec![false; scene.joints.len()],
            carriers: vec![None; n],
        }
    }

    /// Visits what joints connect to a node.
    fn from(&mut self, graph: &Graph, start: usize) -> Result<(), LoadError> {
        self.seen[start] = true;
        let mut order = vec![start];
        let mut next = 0;
        while let Some(&node) = order.get(next) {
            next += 1;
            for &(edge, other) in &graph.joints[node] {
                if std::mem::replace(&mut self.used[edge.joint], true) {
                    continue;
                }
                if std::mem::replace(&mut self.seen[other], true) {
                    let ends = [node, other];
                    return Err(closes_loop(self.scene, &self.carriers, edge.joint, ends));
                }
                self.carriers[other] = Some((edge.joint, node));
                self.edges.push(edge);
                order.push(other);
            }
        }
        Ok(())
    }

    /// Visits everything: first what is held, then groups of links from one that no joint moves, a canonical one before others.
    fn all(mut self, graph: &Graph, placements: &Placements) -> Result<Tree, LoadError> {
        self.from(graph, 0)?;
        let models = self.scene.models.iter();
        let canonical = models.filter_map(|model| placements.link[model.frame]);
        let links = 0..self.scene.links.len();
        let unmoved = |link: &usize| !graph.is_child[link + 1];
        let starts = canonical.filter(unmoved);
        let starts = starts.chain(links.clone().filter(unmoved)).chain(links);
        let mut floating = Vec::new();
        for link in starts {
            if !graph.is_static[link] && !self.seen[link + 1] {
                floating.push(link);
                self.from(graph, link + 1)?;
            }
        }
        Ok(Tree {
            root: None,
            edges: self.edges,
            floating,
        })
    }
}

/// `true` for a joint inside a static model: it cannot move.
pub(super) fn is_held(scene: &Scene, joint: usize) -> bool {
    scene.models[scene.frames[scene.joints[joint].frame].scope].is_static
}

/// The loop that a joint closes between two nodes.
///
/// * `carriers` – joint that leads to each node, and the node from where
fn closes_loop(
    scene: &Scene,
    carriers: &[Option<(usize, usize)>],
    joint: usize,
    ends: [usize; 2],
) -> LoadError {
    let up = |node: usize| {
        std::iter::successors(carriers[node], |&(_, from)| carriers[from]).map(|(joint, _)| joint)
    };
    let [first, second] = ends.map(|node| up(node).collect::<Vec<_>>());
    let name = |joint: usize| scene.frames[scene.joints[joint].frame].name.clone();
    // Down to one end, across, and up from the other, except for what leads to both.
    let down = first.iter().rev().filter(|joint| !second.contains(joint));
    let back = second.iter().filter(|joint| !first.contains(joint));
    let around = down.chain([&joint]).chain(back);
    let link = ends[1].checked_sub(1);
    let link = link.map(|link| scene.frames[scene.links[link].frame].name.clone());
    LoadError::Loop {
        at: scene.frames[scene.joints[joint].frame]
            .place
            .position
            .clone(),
        joints: around.map(|&joint| name(joint)).collect(),
        link: link.unwrap_or_else(|| "world".to_owned()),
    }
}
