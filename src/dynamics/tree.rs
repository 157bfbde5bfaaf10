//! The tree along which joints are eliminated: the bodies of a model one by one, or several abreast.

use std::ops::{Add, Range};

use crate::model::{Body, BodyId, Model};
use crate::scalar::{Over, Scalar};
use crate::spatial::{ArticulatedInertia, Force, Motion};

/// Bodies, the parents before what they carry, and how numbers go from one to the other.
pub(super) trait Tree<P: Scalar, T: Over<P>> {
    /// Range of the bodies that are worked on.
    fn range(&self) -> Range<usize>;

    /// The bodies with the places of their coordinates.
    fn bodies(&self) -> &[Body<P>];

    /// The motion of the body p that carries body i.
    fn parent_motion(&self, i: usize, p: BodyId, motions: &[Motion<T>]) -> Motion<T>;

    /// Hands down to body p what it feels of body i; `all` is what each body feels so far.
    fn add_to_parent<X: Copy + Add<Output = X>>(&self, i: usize, p: BodyId, x: X, all: &mut [X]);

    /// Takes up what was handed down to body i and is not in what it feels yet, before it hands down itself.
    fn add_children(
        &self,
        i: usize,
        forces: &mut [Force<T>],
        inertias: &mut [ArticulatedInertia<T>],
    );

    /// Whether body i is eliminated again when one before it is the `last` that is eliminated otherwise.
    fn repeats(&self, i: usize, last: usize) -> bool;

    /// Whether body i forgets what it feels when body `last` is the last that is eliminated otherwise.
    fn starts_anew(&self, i: usize, last: usize) -> bool;
}

/// The first bodies of a model.
pub(super) struct Bodies<'a, P> {
    model: &'a Model<P>,
    n: usize,
}

impl<'a, P: Scalar> Bodies<'a, P> {
    pub(super) fn all(model: &'a Model<P>) -> Self {
        let n = model.n_bodies();
        Self { model, n }
    }

    pub(super) fn first(model: &'a Model<P>, n: usize) -> Self {
        Self { model, n }
    }
}

impl<P: Scalar, T: Over<P>> Tree<P, T> for Bodies<'_, P> {
    #[inline(always)]
    fn range(&self) -> Range<usize> {
        0..self.n
    }

    #[inline(always)]
    fn bodies(&self) -> &[Body<P>] {
        self.model.bodies()
    }

    #[inline(always)]
    fn parent_motion(&self, _: usize, p: BodyId, motions: &[Motion<T>]) -> Motion<T> {
        motions[p.0]
    }

    #[inline(always)]
    fn add_to_parent<X: Copy + Add<Output = X>>(&self, _: usize, p: BodyId, x: X, all: &mut [X]) {
        all[p.0] = all[p.0] + x;
    }

    #[inline(always)]
    fn add_children(&self, _: usize, _: &mut [Force<T>], _: &mut [ArticulatedInertia<T>]) {}

    /// Where its parent, whose sum it is in, starts anew.
    #[inline(always)]
    fn repeats(&self, i: usize, last: usize) -> bool {
        let parent = self.model.bodies()[i].parent;
        parent.is_some_and(|p| p.0 < last)
    }

    /// The last one has all that its children hand down.
    #[inline(always)]
    fn starts_anew(&self, i: usize, last: usize) -> bool {
        i < last
    }
}
