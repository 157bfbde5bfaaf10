//! Contact models of the points of a robot; checks that all are of one kind.

use super::laws::{ContactLaw, LawKind};
use super::material::Material;
use super::turning::TurningFriction;
use crate::numbers::{Domain, EachIn, Number, Numbers, numbers, of};
use crate::scalar::{Over, Scalar};

/// Contact models of points, one for each point, all of one kind, with their torsional and rolling friction and their margins.
#[derive(Clone, Debug)]
pub(super) struct PointLaws<P> {
    laws: Vec<ContactLaw<P>>,
    /// One for each point, or none at all.
    turning: Vec<TurningFriction<P>>,
    /// Heights of the points above the ground at which contact begins, m; one for each point, or none at all.
    margins: Vec<P>,
}

numbers! { struct PointLaws {
    laws: part(ContactLaw),
    turning: part(TurningFriction),
    margins: hidden(),
} }

impl<P: Scalar> PointLaws<P> {
    /// Repeats a law, which has been checked, for so many points.
    pub(super) fn repeated(law: ContactLaw<P>, points: usize) -> Self {
        Self {
            laws: vec![law; points],
            turning: Vec::new(),
            margins: Vec::new(),
        }
    }

    /// # Panics
    /// If the laws are of different kinds, or a parameter is out of range.
    pub(super) fn new(laws: Vec<ContactLaw<P>>) -> Self {
        let mut out = Self {
            laws: Vec::with_capacity(laws.len()),
            turning: Vec::new(),
            margins: Vec::new(),
        };
        laws.into_iter().for_each(|law| out.push(law));
        out
    }

    /// Takes torsional and rolling friction and margins from the laws of as many points.
    pub(super) fn with_rest_of<Q: Scalar>(mut self, other: &PointLaws<Q>) -> Self
    where
        P: Over<Q>,
    {
        self.turning = other.turning.lift();
        self.margins = other.margins.iter().map(|&own| P::from(own)).collect();
        self
    }

    /// Torsional and rolling friction of a point.
    pub(super) fn turning(&self, point: usize) -> TurningFriction<P> {
        let own = self.turning.get(point);
        own.copied().unwrap_or_else(TurningFriction::none)
    }

    /// Whether some points may have torsional or rolling friction.
    pub(super) fn have_turning(&self) -> bool {
        !self.turning.is_empty()
    }

    /// Height above the ground at which contact of a point begins, m; `None` where no point has one.
    #[inline]
    pub(super) fn margin(&self, point: usize) -> Option<P> {
        self.margins.get(point).copied()
    }

    /// Whether some points may have a margin.
    pub(super) fn have_margins(&self) -> bool {
        !self.margins.is_empty()
    }

    /// Sets the margin of some points.
    pub(super) fn set_margin(&mut self, margin: P, is_chosen: impl Fn(usize) -> bool) {
        let is_none = margin.has_value() && (0..P::LANES).all(|lane| margin.value(lane) == 0.0);
        if self.margins.is_empty() && is_none {
            return;
        }
        self.margins.resize(self.laws.len(), P::zero());
        for (point, own) in self.margins.iter_mut().enumerate() {
            if is_chosen(point) {
                *own = margin;
            }
        }
    }

    /// Sets torsional and rolling friction of some points.
    pub(super) fn set_turning(
        &mut self,
        turning: TurningFriction<P>,
        is_chosen: impl Fn(usize) -> bool,
    ) {
        if self.turning.is_empty() && !turning.acts() {
            return;
        }
        let count = self.laws.len();
        self.turning.resize(count, TurningFriction::none());
        for (point, own) in self.turning.iter_mut().enumerate() {
            if is_chosen(point) {
                *own = turning;
            }
        }
    }

    /// Passes the margin of a point, where points have some, to `each`.
    pub(super) fn each_margin_of<G: Copy>(
        &mut self,
        point: usize,
        group: G,
        each: &mut EachIn<'_, G, P>,
    ) {
        if let Some(own) = self.margins.get_mut(point) {
            let name = "margin";
            each(group, Number::new(&name, &name, Domain::NotNegative), own);
        }
    }

    /// Passes each parameter of the law of a point, and of its torsional and rolling friction where points have some, to `each`.
    pub(super) fn each_number_of<G: Copy>(
        &mut self,
        point: usize,
        [law, turning]: [G; 2],
        each: &mut EachIn<'_, G, P>,
    ) {
        if let Some(own) = self.laws.get_mut(point) {
            own.each_number(&mut of(law, each));
        }
        if let Some(own) = self.turning.get_mut(point) {
            own.each_number(&mut of(turning, each));
        }
    }

    /// Adds the law of one more point.
    ///
    /// # Panics
    /// If it is of another kind than those of the other points, or a parameter is out of range.
    pub(super) fn push(&mut self, law: ContactLaw<P>) {
        self.insert(self.laws.len(), law);
    }

    /// Adds the law of one more point before others.
    ///
    /// # Panics
    /// As [`push`](Self::push).
    pub(super) fn insert(&mut self, at: usize, law: ContactLaw<P>) {
        self.check(&law);
        self.laws.insert(at, law);
        if !self.turning.is_empty() {
            self.turning.insert(at, TurningFriction::none());
        }
        if !self.margins.is_empty() {
            self.margins.insert(at, P::zero());
        }
    }

    /// Keeps so many first ones.
    pub(super) fn truncate(&mut self, count: usize) {
        self.laws.truncate(count);
        self.turning.truncate(count);
        self.margins.truncate(count);
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
        let laws = self.laws.iter_mut().enumerate();
        laws.for_each(|(point, law)| change(point, law));
    }

    /// Sets friction and other surface parameters of some points from a pair of materials.
    pub(super) fn set_material(&mut self, pair: Material<P>, is_chosen: impl Fn(usize) -> bool) {
        self.for_each_mut(|point, law| {
            if is_chosen(point) {
                law.set_material(pair);
            }
        });
        self.set_turning(pair.turning, &is_chosen);
        self.set_margin(pair.margin, is_chosen);
    }

    /// Keeps the laws of the points that are marked, and all after these.
    pub(super) fn retain(&mut self, kept: &[bool]) {
        let keeps = || {
            let mut own = kept.iter();
            move || own.next() != Some(&false)
        };
        let [mut law, mut turning, mut margin] = [keeps(), keeps(), keeps()];
        self.laws.retain(|_| law());
        self.turning.retain(|_| turning());
        self.margins.retain(|_| margin());
    }

    /// Common properties; `None` without points.
    pub(super) fn kind(&self) -> Option<&'static LawKind> {
        self.laws.first().map(ContactLaw::kind)
    }

    pub(super) fn first(&self) -> Option<&ContactLaw<P>> {
        self.laws.first()
    }

    pub(super) fn as_slice(&self) -> &[ContactLaw<P>] {
        &self.laws
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
            ..Material::default()
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
