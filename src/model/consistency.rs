//! Physical consistency of inertias.

use std::collections::HashMap;
use std::fmt;

use super::Model;
use crate::linalg::symmetric_eigen3;
use crate::scalar::MapEach;
use crate::sorting::sort_seldom;
use crate::spatial::Inertia;

/// Largest violation of what holds for the moments of bodies, relative to the largest moment: the rounding of six
/// printed digits.
const TOLERANCE: f64 = 1e-6;

/// Rounding in moments about the centre of mass, relative to those about the origin that they are a difference of.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Violation of physical consistency of an inertia.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum InertiaFlaw {
    /// A principal moment about the centre of mass is negative.
    NegativeMoment {
        /// Principal moments about the centre of mass in rising order, kg·m².
        moments: [f64; 3],
    },
    /// A principal moment about the centre of mass exceeds the sum of the others.
    TriangleInequality {
        /// Principal moments about the centre of mass in rising order, kg·m².
        moments: [f64; 3],
    },
    /// The body has rotational inertia but no mass.
    NoMass {
        /// Principal moments in rising order, kg·m².
        moments: [f64; 3],
    },
}

impl fmt::Display for InertiaFlaw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (flaw, [a, b, c]) = match *self {
            Self::NegativeMoment { moments } => {
                ("a principal moment of inertia is negative", moments)
            }
            Self::TriangleInequality { moments } => (
                "a principal moment of inertia exceeds the sum of the others (triangle inequality)",
                moments,
            ),
            Self::NoMass { moments } => ("there is rotational inertia without mass", moments),
        };
        write!(
            f,
            "{flaw}: eigenvalues {a:.6e}, {b:.6e}, {c:.6e} kg·m² about the centre of mass"
        )
    }
}

/// Finds the flaw of an inertia in any frame, if it has one. Limiting cases (points, thin rods, plates) are right.
pub(crate) fn inertia_flaw(inertia: &Inertia<f64>) -> Option<InertiaFlaw> {
    let about_com = if inertia.mass == 0.0 {
        inertia.rotational
    } else {
        inertia.about_com()
    };
    let largest_entry = inertia.rotational.to_matrix().amax();
    let matrix = about_com.to_matrix() / largest_entry;
    if matrix.iter().any(|x| !x.is_finite()) {
        // No rotational inertia at all, or numbers that are reported elsewhere.
        return None;
    }
    let (moments, _) = symmetric_eigen3(&matrix)?;
    let mut scaled: [f64; 3] = moments.into();
    sort_seldom(&mut scaled, f64::total_cmp);
    let moments = scaled.map_each(|moment| moment * largest_entry);
    let [a, b, c] = scaled;
    if inertia.mass == 0.0 {
        Some(InertiaFlaw::NoMass { moments })
    } else if a < -TOLERANCE * c.abs() - ROUNDING {
        Some(InertiaFlaw::NegativeMoment { moments })
    } else if c > (a + b) * (1.0 + TOLERANCE) + ROUNDING {
        Some(InertiaFlaw::TriangleInequality { moments })
    } else {
        None
    }
}

impl Model<f64> {
    /// Returns the links with physically inconsistent inertias, each with the violation. Includes edits of the model, as in [`to_builder`](Self::to_builder).
    pub fn inertia_flaws(&self) -> Vec<(&str, InertiaFlaw)> {
        let builder = self.to_builder();
        let inertias: HashMap<&str, &Inertia<f64>> = (builder.links.iter())
            .map(|link| (link.name.as_str(), &link.inertia))
            .collect();
        let flaw = |link: &super::Link| {
            let name = self.frames()[link.frame.0].name.as_str();
            Some((name, inertia_flaw(inertias.get(name)?)?))
        };
        self.links().iter().filter_map(flaw).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{BodyId, JointSpec, LinkSpec, ModelBuilder, samples};
    use crate::spatial::{Quaternion, Symmetric3, Transform};
    use crate::tests::ROUNDING;
    use nalgebra::Vector3;

    fn flaw_of(mass: f64, moments: [f64; 3]) -> Option<InertiaFlaw> {
        let about_com = Symmetric3::diagonal(&moments.into());
        let turned = Transform::new(
            Quaternion::exp(&Vector3::new(0.3, -1.0, 0.5)).to_matrix(),
            Vector3::new(0.4, -0.2, 0.1),
        );
        inertia_flaw(&turned.inertia(&Inertia::from_com(mass, &Vector3::zeros(), &about_com)))
    }

    #[test]
    fn flaws_in_a_turned_frame_equal_those_of_the_principal_moments() {
        for good in [
            [1.0, 1.0, 1.0],
            [1.0, 2.0, 3.0],
            [0.0, 1.0, 1.0],
            [0.0; 3],
            [1e-9, 1e-9, 2e-9],
            [1e300, 1e300, 1e300],
        ] {
            assert_eq!(flaw_of(1.0, good), None, "{good:?}");
        }
        let Some(InertiaFlaw::NegativeMoment { moments }) = flaw_of(1.0, [2.0, -0.1, 1.0]) else {
            panic!("a negative moment is not seen");
        };
        assert!((Vector3::from(moments) - Vector3::new(-0.1, 1.0, 2.0)).amax() < 10.0 * ROUNDING);
        assert!(matches!(
            flaw_of(1.0, [1.0, 1.0, 2.1]),
            Some(InertiaFlaw::TriangleInequality { .. })
        ));
        assert!(matches!(
            flaw_of(0.0, [1.0, 1.0, 1.0]),
            Some(InertiaFlaw::NoMass { .. })
        ));
    }

    #[test]
    fn a_model_lists_the_links_that_are_wrong_and_samples_have_none() {
        for model in [
            samples::pendulum(),
            samples::cartpole(),
            samples::random_tree(20, 3),
        ] {
            assert_eq!(model.inertia_flaws(), [], "{}", model.name());
        }
        let mut builder = ModelBuilder::new("flawed");
        builder
            .add_link(LinkSpec::new("world"))
            .add_link(LinkSpec::new("block").with_mass(1.0, [0.0; 3], [1.0, 1.0, 5.0]));
        let kind = crate::joint::JointKind::Prismatic;
        builder.add_joint(JointSpec::new("slide", kind, "world", "block"));
        let model = builder.build().unwrap();
        assert_eq!(model.inertia_flaws()[0].0, "block");
        let unit = Symmetric3::diagonal(&Vector3::repeat(1.0));
        let mended = Inertia::from_com(1.0, &Vector3::zeros(), &unit);
        let mended = model.with_inertia(BodyId(0), mended);
        assert_eq!(mended.inertia_flaws(), []);
    }
}
