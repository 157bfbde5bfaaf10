//! Materials of links and ground, and pair properties.

use super::compliance::Compliance;
use super::turning::TurningFriction;
use crate::error::UnknownName;
use crate::numbers::{Numbers, numbers};
use crate::scalar::Scalar;

/// Friction, restitution, margin and compliance of a surface, or between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material<P = f64> {
    /// μ, the coefficient of friction (of a material against itself); infinite for no slip. For all contact models.
    pub friction: P,
    /// e in 0..1, the coefficient of restitution (of a material against itself). For [`Rigid`](super::Rigid) only; the restitution of other contact
    /// models follows from their damping.
    pub restitution: P,
    /// Thickness of a layer around the surface at which contact begins, m: between two surfaces contact begins at a distance of both margins together, and its depth counts
    /// from there. Nearest points and distances remain those of the shapes. For all contact models.
    pub margin: P,
    /// Torsional and rolling friction; none by default. For all contact models.
    pub turning: TurningFriction<P>,
    /// How the surface yields; `None` for the parameters of the contact model.
    pub compliance: Option<Compliance<P>>,
}

numbers! { pub struct Material {
    friction: NotNegativeOrInfinite("friction"),
    restitution: WithinOne("restitution"),
    margin: NotNegative("margin"),
    turning: part(TurningFriction),
    compliance: part(Compliance),
} }

impl Default for Material {
    /// μ = ½, as that of contact models; no restitution, no margin, no torsional and no rolling friction, and the compliance of the contact model.
    fn default() -> Self {
        Self {
            friction: 0.5,
            restitution: 0.0,
            margin: 0.0,
            turning: TurningFriction::default(),
            compliance: None,
        }
    }
}

/// A table of materials and material pairs, by name.
///
/// For a pair that is not in the table, friction is the harmonic mean of both materials, 2 μ₁ μ₂ / (μ₁ + μ₂), as in Drake; so is restitution. So two
/// surfaces of one material have its values, the smaller value dominates, and a frictionless material is frictionless against all others. (`MuJoCo`
/// uses the larger friction; add such pairs to the table.) [Torsional and rolling friction](TurningFriction) are the larger ones of both, the margin is the
/// sum, as in `MuJoCo`.
/// [`Compliance`] has its own rule.
///
/// # Examples
/// ```
/// use dualbody::contact::{Material, Materials};
///
/// let materials = Materials::default()
///     .with_material("rubber", Material { friction: 0.9, restitution: 0.6, ..Material::default() })
///     .with_material("steel", Material { friction: 0.45, restitution: 0.9, ..Material::default() })
///     .with_material("ice", Material { friction: 0.05, restitution: 0.1, ..Material::default() })
///     .with_pair(["steel", "ice"], Material { friction: 0.02, restitution: 0.1, ..Material::default() })?;
/// let mean = materials.between("rubber", "steel")?;
/// assert!((mean.friction - 0.6).abs() < 1e-15); // 2 · 0.9 · 0.45 / 1.35
/// assert_eq!(materials.between("ice", "steel")?.friction, 0.02);
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
///
/// # References
/// Friction of two surfaces: `CalcContactFrictionFromSurfaceProperties` of Drake's manual, contact parameters in the chapter on computation of
/// that of `MuJoCo`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Materials {
    materials: Vec<(String, Material)>,
    pairs: Vec<([String; 2], Material)>,
}

impl<P: Scalar> Material<P> {
    /// Friction and restitution between two surfaces: harmonic means; torsional and rolling friction: the larger ones; margin: the sum; compliance: by its own rule.
    pub(super) fn between(&self, other: &Self) -> Self {
        Self {
            turning: self.turning.between(&other.turning),
            friction: harmonic_mean(self.friction, other.friction),
            restitution: harmonic_mean(self.restitution, other.restitution),
            margin: self.margin + other.margin,
            compliance: Compliance::of_both(self.compliance, other.compliance),
        }
    }
}

impl Materials {
    /// Adds a material, or replaces the one of this name.
    ///
    /// # Panics
    /// If its friction is negative or NaN, its restitution is not in 0..1, or a parameter of its compliance is out of range. If its compliance is for another
    /// contact model than that of another material.
    #[must_use]
    pub fn with_material(mut self, name: &str, material: Material) -> Self {
        self.check(&material);
        self.materials.retain(|(other, _)| other != name);
        self.materials.push((name.into(), material));
        self
    }

    /// Sets friction and restitution between two materials, in either order, instead of their means.
    ///
    /// # Errors
    /// If there is no material with this name.
    ///
    /// # Panics
    /// As [`with_material`](Self::with_material).
    pub fn with_pair(mut self, names: [&str; 2], pair: Material) -> Result<Self, UnknownName> {
        self.check(&pair);
        for name in names {
            self.find(name)?;
        }
        self.pairs.retain(|(other, _)| !are_the_same(other, names));
        self.pairs.push((names.map(Into::into), pair));
        Ok(self)
    }

    /// Returns friction and restitution between two materials.
    ///
    /// # Errors
    /// If there is no material with this name.
    pub fn between(&self, one: &str, other: &str) -> Result<Material, UnknownName> {
        let (a, b) = (self.find(one)?, self.find(other)?);
        let given = self
            .pairs
            .iter()
            .find(|(names, _)| are_the_same(names, [one, other]));
        Ok(given.map_or_else(|| a.between(&b), |(_, pair)| *pair))
    }

    /// # Panics
    /// If a parameter is out of range, or the compliance is for another contact model than that of another material.
    fn check(&self, material: &Material) {
        material.check_numbers();
        let pairs = self.pairs.iter().map(|(_, own)| own);
        let own = self.materials.iter().map(|(_, own)| own).chain(pairs);
        let mut others = own.filter_map(|own| own.compliance);
        let is_alike = |own: &Compliance| others.all(|other| own.is_like(&other));
        assert!(
            material.compliance.as_ref().is_none_or(is_alike),
            "all materials of a table have compliances for one contact model"
        );
    }

    fn find(&self, name: &str) -> Result<Material, UnknownName> {
        let found = self.materials.iter().find(|(other, _)| other == name);
        found
            .map(|(_, material)| *material)
            .ok_or_else(|| UnknownName {
                model: "the table of materials".into(),
                element: "material".into(),
                name: name.into(),
                known: self
                    .materials
                    .iter()
                    .map(|(name, _)| name.clone())
                    .collect(),
            })
    }
}

fn are_the_same(pair: &[String; 2], [a, b]: [&str; 2]) -> bool {
    (pair[0] == a && pair[1] == b) || (pair[0] == b && pair[1] == a)
}

/// Numbers above this count as it in a harmonic mean, and their inverse as no part of a sum with that of any friction.
const LARGEST: f64 = 1e100;

/// 2 a b / (a + b): 0 if one of them is 0, twice the other one if one is infinite, infinite if both are. Of two zeros the derivatives are zero.
fn harmonic_mean<P: Scalar>(a: P, b: P) -> P {
    let largest = P::constant(LARGEST);
    let (x, y) = (a.min(largest), b.min(largest));
    let sum = (x + y).max(P::constant(f64::MIN_POSITIVE));
    let mean = x / sum * y * 2.0;
    mean.select_lt(largest, mean, a.max(b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SoftContact, Terrain};
    use crate::model::Model;

    fn table() -> Materials {
        let material = |friction, restitution| Material {
            friction,
            restitution,
            ..Material::default()
        };
        Materials::default()
            .with_material("rubber", material(0.8, 0.6))
            .with_material("wood", material(0.4, 0.3))
            .with_material("teflon", material(0.0, 0.0))
    }

    #[test]
    fn pairs_that_are_not_in_the_table_are_harmonic_means() {
        let table = table();
        let pair = table.between("rubber", "wood").expect("materials");
        // 2 · 0.8 · 0.4 / 1.2 and 2 · 0.6 · 0.3 / 0.9
        assert!((pair.friction - 1.6 / 3.0).abs() < 1e-15);
        assert!((pair.restitution - 0.4).abs() < 1e-15);
        assert_eq!(table.between("wood", "rubber"), Ok(pair));
        let own = table.between("wood", "wood").expect("materials");
        assert!((own.friction - 0.4).abs() < 1e-15 && (own.restitution - 0.3).abs() < 1e-15);
        for other in ["rubber", "teflon"] {
            assert_eq!(
                table.between("teflon", other).expect("materials").friction,
                0.0
            );
        }
    }

    #[test]
    fn pairs_of_the_table_come_first_and_the_last_of_them() {
        let pair = |friction| Material {
            friction,
            restitution: 0.5,
            ..Material::default()
        };
        let table = table()
            .with_pair(["rubber", "wood"], pair(0.7))
            .expect("materials");
        let table = table
            .with_pair(["wood", "rubber"], pair(0.75))
            .expect("materials");
        assert_eq!(table.between("rubber", "wood"), Ok(pair(0.75)));
        assert_eq!(table.pairs.len(), 1);
        let error = table.between("wood", "glass").expect_err("no glass");
        assert_eq!(
            (error.element.as_str(), error.name.as_str()),
            ("material", "glass")
        );
        assert!(table.with_pair(["glass", "wood"], pair(0.1)).is_err());
    }

    #[test]
    fn laws_take_what_they_have_from_the_pair() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
        let model = Model::from_urdf_file(path).expect("an asset");
        let soft = SoftContact::estimate(1.0, 1, 1e-3);
        for law in [
            ContactLaw::Rigid(Rigid::default()),
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            ContactLaw::Soft(soft),
        ] {
            let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
                .with_links(&model, &["FR_foot", "FL_foot"])
                .expect("links");
            let links = [("FL_foot", "wood")];
            let given = contacts
                .clone()
                .with_materials(&model, &table(), "rubber", &links);
            let given = given.expect("links and materials");
            let [first, second] = ["FR_foot", "FL_foot"].map(|link| {
                let link = model.find_frame(link).expect("a link");
                let at = given.points().iter().position(|point| point.link == link);
                given.laws()[at.expect("a point")]
            });
            assert_eq!(first, law);
            let friction: f64 = second.bounded_friction();
            assert!((friction - 1.6 / 3.0).abs() < 1e-15);
            if let ContactLaw::Rigid(law) = second {
                assert!((law.restitution - 0.4).abs() < 1e-15);
            }
            let unknown = contacts.with_materials(&model, &table(), "rubber", &[("nose", "wood")]);
            assert_eq!(unknown.expect_err("no nose").name, "nose");
        }
    }

    #[test]
    #[should_panic(expected = "the friction is -0.1: negative or not a number")]
    fn negative_friction_is_refused() {
        let _ = Materials::default().with_material(
            "odd",
            Material {
                friction: -0.1,
                ..Material::default()
            },
        );
    }
}
