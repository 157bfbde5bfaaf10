//! Masses and inertias of individual links.

use super::Model;
use crate::error::UnknownName;
use crate::spatial::Inertia;

impl Model<f64> {
    /// Returns the inertia of a link in its own frame, about its origin; it contains mass, [centre of mass](Inertia::com) and the 6 × 6 matrix
    /// ([`Inertia::to_matrix`]).
    ///
    /// It is that of the link alone in the description, also if several fixed links form one body, and also for links that are fixed to the world.
    /// For a body with a [changed](Self::with_inertia) inertia, the first link has all of it.
    ///
    /// Builds a [description](Self::to_builder), linear in the number of links; allocates. For several links, [`link_inertias`](Self::link_inertias)
    /// costs as much as for one.
    ///
    /// # Errors
    /// If there is no link with this name.
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

    /// Returns the inertia of each link in its own frame, about its origin, in the order of [`links`](Self::links); see
    /// [`link_inertia`](Self::link_inertia). Allocates.
    pub fn link_inertias(&self) -> Vec<Inertia<f64>> {
        let builder = self.to_builder();
        let places =
            super::description::indices(builder.links.iter().map(|link| link.name.as_str()));
        let inertia = |name: &str| match places.get(name) {
            Some(&place) => builder.links[place].inertia,
            None => Inertia::zero(),
        };
        self.link_names().into_iter().map(inertia).collect()
    }
}
