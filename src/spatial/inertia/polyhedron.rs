//! Inertia of a solid bounded by triangles.

use nalgebra::{Matrix4, Vector3};

use super::Inertia;
use crate::scalar::Scalar;
use crate::spatial::linear::{cross, dot};

/// Volume of a tetrahedron, in the product a · (b × c) of its edges.
const TETRAHEDRON: f64 = 1.0 / 6.0;
/// Second moment of a tetrahedron with one corner at the origin, in its volume times the sum of a aᵀ, b bᵀ, c cᵀ and (a + b + c)(a + b + c)ᵀ.
const SECOND_MOMENT: f64 = 1.0 / 20.0;

impl<P: Scalar> Inertia<P> {
    /// The inertia of a homogeneous solid bounded by a closed surface of triangles, about the origin: the sum over the tetrahedra of triangles and
    /// origin, with signed volumes.
    ///
    /// * `density` – kg/m³
    /// * `triangles` – their vertices, m, counter-clockwise as seen from outside; clockwise, all results have the opposite sign
    ///
    /// # Limitations
    /// The function does not check that the surface is closed.
    ///
    /// # References
    /// [Tonon 2004].
    pub(crate) fn solid_polyhedron(
        density: P,
        triangles: impl Iterator<Item = [Vector3<P>; 3]>,
    ) -> Self {
        let mut sum = Matrix4::zeros();
        for [a, b, c] in triangles {
            let mass = dot(&a, &cross(&b, &c)) * density * TETRAHEDRON;
            let all = a + b + c;
            for i in 0..3 {
                for j in i..3 {
                    let squares = a[i] * a[j] + b[i] * b[j] + c[i] * c[j] + all[i] * all[j];
                    sum[(i, j)] += squares * mass * SECOND_MOMENT;
                }
                sum[(i, 3)] += all[i] * mass * 0.25;
            }
            sum[(3, 3)] += mass;
        }
        Self::from_pseudo_inertia(&sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;

    /// The six faces of a box from `low` to `high`, two triangles each, seen from outside.
    fn faces(low: [f64; 3], high: [f64; 3]) -> Vec<[Vector3<f64>; 3]> {
        let corner = |k: usize| {
            Vector3::from_fn(|axis, _| {
                if k >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            })
        };
        let quads = [
            [0, 4, 6, 2],
            [1, 3, 7, 5],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 2, 3, 1],
            [4, 5, 7, 6],
        ];
        quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]].map(|t| t.map(corner)))
            .collect()
    }

    #[test]
    fn polyhedron_of_a_box_away_from_the_origin_equals_the_box() {
        let solid =
            Inertia::solid_polyhedron(500.0, faces([0.1, -0.4, 1.0], [0.5, 0.2, 1.3]).into_iter());
        let middle = Vector3::new(0.3, -0.1, 1.15);
        let box_ = Inertia::solid_box(500.0 * 0.4 * 0.6 * 0.3, [0.4, 0.6, 0.3]);
        let expected = Inertia::from_com(box_.mass, &middle, &box_.rotational);
        let error = (solid.to_matrix() - expected.to_matrix()).amax();
        assert!(
            error < 100.0 * ROUNDING * expected.to_matrix().amax(),
            "{error:e}"
        );
    }
}
