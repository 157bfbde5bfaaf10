//! Robots for the tests.

mod meshes;
mod mjcf;
mod urdf;

use crate::joint::JointKind;
use crate::model::{
    Geometry, JointSpec, Limits, LinkSpec, Mass, Mimic, Model, ModelBuilder, UpAxis, Visual,
    samples,
};
use crate::spatial::Transform;

/// Rounding of roll, pitch and yaw, and of moments about the centre of mass.
const TEXT_ROUNDING: f64 = 1e-13;

/// A name that needs every escape.
const AWKWARD: &str = "a & b < c > \"d\" 'e' ü";

fn assets() -> Vec<Model> {
    let folder = format!("{}/assets", env!("CARGO_MANIFEST_DIR"));
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let urdf = files.filter(|path| {
        path.extension()
            .is_some_and(|extension| extension == "urdf")
    });
    urdf.map(|path| Model::from_urdf_file(path).unwrap())
        .collect()
}

/// A robot with every kind of shape, limit and name.
fn everything() -> Model {
    let mut builder = ModelBuilder::new(AWKWARD).with_gravity([0.0, 0.0, -1.6]);
    let mass = Mass::Density(900.0);
    builder.add_link(LinkSpec::solid_box("torso", [0.3, 0.2, 0.1], mass));
    let solids = [
        LinkSpec::solid_sphere(AWKWARD, 0.1, mass),
        LinkSpec::solid_cylinder("arm", 0.1, 0.3, mass),
        LinkSpec::solid_capsule("leg", 0.1, 0.3, mass),
    ];
    let limits = [
        (Some(-1.0), None),
        (None, Some(0.1 + 0.2)),
        (Some(-0.5), Some(0.5)),
    ];
    for (i, (link, (lower, upper))) in solids.into_iter().zip(limits).enumerate() {
        let mesh = Visual {
            name: Some(AWKWARD.into()),
            placement: Transform::from_translation([0.1, 0.0, 0.0].into()),
            geometry: Geometry::Mesh {
                uri: "package://x/--y.stl".into(),
                path: None,
                scale: [0.001; 3],
                up_axis: UpAxis::Auto,
            },
            color: Some([0.1, 0.2, 0.3, 1.0]),
        };
        let (child, link) = (link.name.to_owned(), link.with_visual(mesh));
        builder.add_link(link);
        let limits = Limits {
            lower,
            upper,
            velocity: None,
            effort: Some(i as f64),
        };
        let joint = JointSpec::new(format!("{AWKWARD}{i}"), JointKind::Revolute, "torso", child)
            .with_axis([0.3, -0.4, 1.7])
            .with_limits(limits)
            .with_friction(0.25)
            .with_damping(0.5);
        let leader = format!("{AWKWARD}0");
        builder.add_joint(if i == 2 {
            joint.with_mimic(Mimic {
                leader,
                multiplier: -1.5,
                offset: 0.1,
            })
        } else {
            joint
        });
    }
    builder.add_frame(
        "tool <1>",
        AWKWARD,
        Transform::from_translation([0.0, 0.1, 0.0].into()),
    );
    builder.build().unwrap()
}

fn models_of(tree: impl Fn(u64) -> Model) -> Vec<Model> {
    let mut models = assets();
    models.extend([
        samples::pendulum(),
        samples::double_pendulum(),
        samples::cartpole(),
        samples::arm(),
    ]);
    models.extend((0..6).map(tree));
    models.push(everything());
    models
}
