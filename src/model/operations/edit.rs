//! Editing masses and inertias of links.

use std::collections::HashSet;

use crate::error::EditError;
use crate::model::{Model, ModelBuilder};
use crate::spatial::Inertia;

impl ModelBuilder {
    /// [`Model::with_link_mass`].
    pub(crate) fn set_link_mass(&mut self, link: &str, mass: f64) -> Result<&mut Self, EditError> {
        let index = self.link_index(link)?;
        positive("mass", mass)?;
        let inertia = &mut self.links[index].inertia;
        if inertia.mass == 0.0 {
            return Err(EditError::NoMass { link: link.into() });
        }
        *inertia = inertia.scaled(mass / inertia.mass);
        inertia.mass = mass;
        Ok(self)
    }
}

impl ModelBuilder {
    /// Adds an inertia to that of each of some links; names that are unknown are passed over.
    pub(crate) fn add_inertia<'a>(
        &mut self,
        links: impl Iterator<Item = &'a str>,
        added: &Inertia<f64>,
    ) {
        let wanted: HashSet<&str> = links.collect();
        for link in &mut self.links {
            if wanted.contains(link.name.as_str()) {
                link.inertia = link.inertia + *added;
            }
        }
    }
}

impl Model<f64> {
    /// Returns the robot with another mass of a link, kg. It scales the density: the inertia changes in proportion and the centre of mass is unchanged.
    ///
    /// # Errors
    /// If there is no such link, it has no mass yet, or the mass is not positive.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::samples;
    ///
    /// let heavy = samples::cartpole().with_link_mass("pole", 2.0)?;
    /// assert_eq!(heavy.total_mass(), 3.0);
    /// # Ok::<(), dualbody::error::EditError>(())
    /// ```
    pub fn with_link_mass(&self, link: &str, mass: f64) -> Result<Self, EditError> {
        Ok(self.to_builder().set_link_mass(link, mass)?.build()?)
    }

    /// Returns the robot with another inertia of a link, in its own frame about its origin.
    ///
    /// # Errors
    /// If there is no such link, or the mass is negative.
    pub fn with_link_inertia(&self, link: &str, inertia: Inertia<f64>) -> Result<Self, EditError> {
        let mut builder = self.to_builder();
        let index = builder.link_index(link)?;
        builder.links[index].inertia = inertia;
        Ok(builder.build()?)
    }
}

/// A factor or quantity that must be positive and finite.
pub(in crate::model) fn positive(quantity: &str, value: f64) -> Result<(), EditError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let quantity = quantity.into();
    Err(EditError::NotPositive { quantity, value })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::samples;

    // The same shape of k times the density: m, h and J by k.
    #[test]
    fn inertia_of_a_heavier_link_equals_that_of_a_denser_one() {
        let builder = samples::random_tree(3, 1).to_builder();
        let before = builder.links[1].inertia;
        let mut heavier = builder.clone();
        heavier.set_link_mass("link0", before.mass * 4.0).unwrap();
        assert_eq!(heavier.links[1].inertia, before.scaled(4.0));
    }

    #[test]
    fn impossible_masses_are_errors() {
        let model = samples::cartpole();
        for mass in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let error = model.with_link_mass("pole", mass).unwrap_err();
            assert!(matches!(error, EditError::NotPositive { .. }), "{error}");
        }
        let error = model.with_link_mass("world", 1.0).unwrap_err();
        assert!(matches!(error, EditError::NoMass { .. }), "{error}");
        assert!(model.with_link_mass("wheel", 1.0).is_err());
        let empty = model.with_link_inertia("pole", Inertia::zero()).unwrap();
        assert_eq!(
            empty.check_mass_matrix().unwrap_err().joints[0].link,
            "pole"
        );
    }
}
