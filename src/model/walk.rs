//! The links of a description, in the order of the tree.

use std::collections::HashMap;

use super::{JointSpec, LinkSpec, ModelBuilder};

/// A link with the joint that carries it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step<'a> {
    pub(crate) link: &'a LinkSpec,
    /// `None` for a root.
    pub(crate) joint: Option<&'a JointSpec>,
    /// Number of links above it.
    pub(crate) depth: usize,
    /// `true` if no link after it has the same parent.
    pub(crate) is_last: bool,
}

impl<'a> Step<'a> {
    fn root(link: &'a LinkSpec) -> Self {
        Self {
            link,
            joint: None,
            depth: 0,
            is_last: true,
        }
    }
}

impl ModelBuilder {
    /// Walks over every link that can be reached from a root, parents first, in the order in which a model has them.
    /// Iterative; time linear in the number of links.
    pub(crate) fn walk(&self) -> Vec<Step<'_>> {
        let links = self.links.iter().map(|link| link.name.as_str());
        let link_of_name: HashMap<&str, usize> = links.zip(0..).collect();
        let mut carried: Vec<Vec<&JointSpec>> = vec![Vec::new(); self.links.len()];
        let mut is_root = vec![true; self.links.len()];
        for joint in &self.joints {
            let find = |name: &String| link_of_name.get(name.as_str());
            if let (Some(&parent), Some(&child)) = (find(&joint.parent), find(&joint.child)) {
                carried[parent].push(joint);
                is_root[child] = false;
            }
        }
        let roots = self.links.iter().zip(&is_root);
        let roots = roots.filter(|(_, is_root)| **is_root);
        let mut open: Vec<Step<'_>> = roots.map(|(link, _)| Step::root(link)).collect();
        open.reverse();
        let mut steps = Vec::with_capacity(self.links.len());
        while let Some(step) = open.pop() {
            steps.push(step);
            let mut is_last = true;
            for joint in carried[link_of_name[step.link.name.as_str()]].iter().rev() {
                open.push(Step {
                    link: &self.links[link_of_name[joint.child.as_str()]],
                    joint: Some(joint),
                    depth: step.depth + 1,
                    is_last,
                });
                is_last = false;
            }
        }
        steps
    }
}

#[cfg(test)]
mod tests {
    use crate::model::samples;

    #[test]
    fn order_of_the_walk_equals_the_order_of_the_model() {
        for seed in 0..5 {
            let model = samples::random_tree(25, seed);
            let builder = model.to_builder();
            let walked: Vec<_> = builder.walk().iter().map(|step| &step.link.name).collect();
            assert_eq!(walked, model.link_names());
        }
    }
}
