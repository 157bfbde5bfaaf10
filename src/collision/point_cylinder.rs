//! The feature of a cylinder that is nearest to a point, or to a sphere about it.

use super::feature::{Face, Feature, FeatureId, NormalSource, PairFeature};
use super::solid::Solid;

/// The nearest features of a cylinder and of the centre of a sphere.
pub(super) fn nearest_to_center(
    cylinder: &Solid<'_>,
    radius: f64,
    half_length: f64,
    sphere: &Solid<'_>,
) -> PairFeature {
    let apart = sphere.X.translation - cylinder.X.translation;
    let axis = cylinder.X.rotation.column(2).into_owned();
    let along = apart.dot(&axis);
    let across = apart - axis * along;
    let end = u32::from(along > 0.0);
    let outward = if along > 0.0 { axis } else { -axis };
    let radial = across.try_normalize(f64::MIN_POSITIVE);
    let radial = radial.unwrap_or_else(|| cylinder.X.rotation.column(0).into_owned());
    let (above, beside) = (along.abs() - half_length, across.norm() - radius);
    let (feature, normal, seed) = if above > 0.0 && beside > 0.0 {
        let seed = (outward * above + radial * beside).normalize();
        (Feature::Rim(end), NormalSource::Features, seed)
    } else if beside > above {
        (Feature::Edge([0, 1]), NormalSource::Features, radial)
    } else {
        (
            Feature::Vertex(end),
            NormalSource::First(Face::Cap(end)),
            outward,
        )
    };
    PairFeature {
        id: FeatureId {
            features: [feature, Feature::Vertex(0)],
            normal,
        },
        seed,
    }
}
