//! Contact models of the points of a robot; checks that all are of one kind.

use super::laws::{ContactLaw, LawKind};
use super::material::Material;
use crate::numbers::numbers;
use crate::scalar::Scalar;

/// Contact models points, one for each point, all of one kind.
#[derive(Clone, Debug)]
pub(super) struct PointLaws<P>(Vec<ContactLaw<P>>);

numbers! { struct PointLaws(laws: part(ContactLaw)) }

impl<P: Scalar> PointLaws<P> {
    /// Repeats a law, which has been checked, for so many points.
    pub(super) fn repeated(law: ContactLaw<P>, points: usize) -> Self {
        Self(vec![law; points])
    }

    /// # Panics
    /// If the laws are of different kinds, or a parameter is out of range.
    pub(super) fn new(laws: Vec<ContactLaw<P>>) -> Self {
        let mut out = Self(Vec::with_capacity(laws.len()));
        laws.into_iter().for_each(|law| out.push(law));
        out
    }

    /// Adds the law of one more point.
    ///
    /// # Panics
    /// If it is of another kind than those of the other points, or a parameter is out of range.
    pub(super) fn push(&mut self, law: ContactLaw<P>) {
        self.check(&law);
        self.0.push(law);
    }

    /// Adds the law of one more point before others.
    ///
    /// # Panics
    /// As [`push`](Self::push).
    pub(super) fn insert(&mut self, at: usize, law: ContactLaw<P>) {
        self.check(&law);
        self.0.insert(at, law);
    }

    /// Keeps so many first ones.
    pub(super) fn truncate(&mut self, count: usize) {
        self.0.truncate(count);
    }

    /// Replaces the laws of some points.
    ///
    /// # Panics
    /// If the law is of another kind than those of the other points, or a parameter is out of range.
    pub(super) fn replace(&mut self, law: ContactLaw<P>, is_chosen: impl Fn(usize) -> bool) {
        self.check(&law);
        self.for_each_mut(|point, own| {
            if is_chosen(point) {
                *own = law;
            }
        });
    }

    fn check(&self, law: &ContactLaw<P>) {
        if let Some(kind) = self.kind() {
            let (first, other) = (kind.name, law.kind().name);
            assert_eq!(first, other, "all points have contact models of one kind");
        }
        law.check();
    }

    /// Passes each point with its law to `change`, which keeps the kind.
    pub(super) fn for_each_mut(&mut self, mut change: impl FnMut(usize, &mut ContactLaw<P>)) {
        let laws = self.0.iter_mut().enumerate();
        laws.for_each(|(point, law)| change(point, law));
    }

    /// Sets friction and other surface parameters of some points from a pair of materials.
    pub(super) fn set_material(&mut self, pair: Material<P>, is_chosen: impl Fn(usize) -> bool) {
        self.for_each_mut(|point, law| {
            if is_chosen(point) {
                law.set_material(pair);
            }
        });
    }

    /// Keeps the laws of the points that are marked, and all after these.
    pub(super) fn retain(&mut self, kept: &[bool]) {
        let mut own = kept.iter();
        self.0.retain(|_| own.next() != Some(&false));
    }

    /// Common properties; `None` without points.
    pub(super) fn kind(&self) -> Option<&'static LawKind> {
        self.0.first().map(ContactLaw::kind)
    }

    pub(super) fn first(&self) -> Option<&ContactLaw<P>> {
        self.0.first()
    }

    pub(super) fn as_slice(&self) -> &[ContactLaw<P>] {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{RelaxedRigid, Rigid};

    fn rigid(friction: f64) -> ContactLaw {
        ContactLaw::Rigid(Rigid {
            friction,
            ..Rigid::default()
        })
    }

    #[test]
    fn chosen_points_are_changed_and_marked_ones_are_kept() {
        let mut laws = PointLaws::new(vec![rigid(0.1), rigid(0.2), rigid(0.3)]);
        laws.replace(rigid(0.9), |point| point == 1);
        let pair = Material {
            friction: 0.7,
            restitution: 0.0,
        };
        laws.set_material(pair, |point| point == 2);
        assert_eq!(laws.as_slice(), [rigid(0.1), rigid(0.9), rigid(0.7)]);
        laws.retain(&[false, true, true]);
        laws.push(rigid(0.4));
        assert_eq!(laws.as_slice(), [rigid(0.9), rigid(0.7), rigid(0.4)]);
        assert_eq!(laws.kind().map(|kind| kind.name), Some("rigid"));
        assert!(PointLaws::<f64>::new(Vec::new()).kind().is_none());
    }

    #[test]
    #[should_panic(expected = "all points have contact models of one kind")]
    fn laws_of_two_kinds_are_refused() {
        let other = ContactLaw::RelaxedRigid(RelaxedRigid::default());
        let _ = PointLaws::new(vec![rigid(0.1), other]);
    }
}
