//! Masses and inertias link by link, where several links make up one body.

use super::Model;
use crate::error::UnknownName;
use crate::spatial::Inertia;

impl Model<f64> {
    /// Inertia of a link in its own frame, about the origin of that: its mass, [centre of mass](Inertia::com) and the
    /// matrix 6 × 6 ([`Inertia::to_matrix`]) follow.
    ///
    /// That of the link alone, as the description has it, where links fixed to one another are one body; links that are
    /// fixed to the world have theirs too. Of a body whose inertia was [changed](Self::with_inertia), the first link has all of it.
    ///
    /// Costs a [description](Self::to_builder), linear in the number of links; allocates. For several links,
    /// [`link_inertias`](Self::link_inertias) is as cheap as for one.
    ///
    /// # Errors
    /// If there is no link of the name.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let rod = samples::pendulum().link_inertia("rod")?;
    /// assert_eq!((rod.mass, rod.com().z), (1.0, -0.5));
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn link_inertia(&self, link: &str) -> Result<Inertia<f64>, UnknownName> {
        let names = self.link_names();
        let place = names.iter().position(|name| *name == link);
        let unknown = || UnknownName {
            model: self.name.clone(),
            element: "link".into(),
            name: link.into(),
            known: names.iter().map(ToString::to_string).collect(),
        };
        Ok(self.link_inertias()[place.ok_or_else(unknown)?])
    }

    /// Inertia of each link in its own frame, about the origin of that, in the order of [`links`](Self::links); see
    /// [`link_inertia`](Self::link_inertia). Allocates.
    pub fn link_inertias(&self) -> Vec<Inertia<f64>> {
        let builder = self.to_builder();
        let places =
            super::description::indices(builder.links().iter().map(|link| link.name.as_str()));
        let inertia = |name: &str| match places.get(name) {
            Some(&place) => builder.links()[place].inertia,
            None => Inertia::zero(),
        };
        self.link_names().into_iter().map(inertia).collect()
    }
}
