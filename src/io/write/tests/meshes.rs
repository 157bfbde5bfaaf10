//! Meshes in MJCF.

use crate::io::temporary::Folder;
use crate::joint::JointKind;
use crate::model::{Collision, Geometry, JointSpec, LinkSpec, Model, UpAxis, samples};
use crate::spatial::Transform;

const TETRAHEDRON: [[[f32; 3]; 3]; 4] = {
    const CORNERS: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 3.0, 0.0],
        [0.0, 0.0, 4.0],
    ];
    let [o, a, b, c] = CORNERS;
    [[o, b, a], [o, a, c], [o, c, b], [a, b, c]]
};

fn text_stl(triangles: &[[[f32; 3]; 3]]) -> String {
    let mut out = "solid t\n".to_owned();
    for triangle in triangles {
        out += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            out += &format!("vertex {x} {y} {z}\n");
        }
        out += "endloop\nendfacet\n";
    }
    out + "endsolid t\n"
}

fn binary_stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        out.extend([0; 12]);
        out.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

/// A pendulum with a collision for each file of a folder.
fn with_meshes(folder: &Folder, names: &[&str]) -> Model {
    let mut builder = samples::pendulum().to_builder();
    let mut link = LinkSpec::new("meshes").with_mass(1.0, [0.0; 3], [1.0; 3]);
    for &name in names {
        link = link.with_collision(Collision {
            name: None,
            placement: Transform::identity(),
            geometry: Geometry::Mesh {
                uri: name.into(),
                path: Some(folder.path(name)),
                scale: [1.0; 3],
                up_axis: UpAxis::default(),
            },
        });
    }
    builder.add_link(link);
    builder.add_joint(JointSpec::new("weld", JointKind::Fixed, "rod", "meshes"));
    builder.build().unwrap()
}

#[test]
fn meshes_in_mjcf_are_such_that_mujoco_takes_them() {
    let folder = Folder::new();
    let flat = [
        [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
        [[1.0, 1.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
    ];
    folder.write("text.stl", text_stl(&TETRAHEDRON));
    folder.write("flat.stl", text_stl(&flat));
    std::fs::write(folder.path("binary.stl"), binary_stl(&TETRAHEDRON)).unwrap();
    std::fs::write(folder.path("one.stl"), binary_stl(&TETRAHEDRON[..1])).unwrap();
    let names = [
        "text.stl",
        "flat.stl",
        "binary.stl",
        "one.stl",
        "none.stl",
        "scene.dae",
    ];
    let xml = with_meshes(&folder, &names).to_mjcf().unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let assets: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name("mesh"))
        .collect();
    assert!(
        assets
            .iter()
            .all(|asset| asset.attribute("inertia") == Some("shell"))
    );
    let numbers = |k: usize, attribute| assets[k].attribute(attribute).unwrap().split(' ').count();
    assert_eq!(
        (numbers(0, "vertex"), numbers(0, "face")),
        (12, 12),
        "{xml}"
    );
    assert_eq!((numbers(1, "vertex"), numbers(1, "face")), (12, 6));
    assert!(assets[2].attribute("file").unwrap().ends_with("binary.stl"));
    assert_eq!(assets.len(), 3);
    let geoms = document
        .descendants()
        .filter(|node| node.attribute("type") == Some("mesh"));
    let types: Vec<_> = geoms
        .map(|geom| (geom.attribute("mesh"), geom.attribute("contype")))
        .collect();
    assert_eq!(
        types,
        [
            (Some("mesh_0"), Some("1")),
            (Some("mesh_1"), None),
            (Some("mesh_2"), Some("1"))
        ]
    );
    for left_out in [
        "mesh one.stl",
        "mesh none.stl",
        "mesh scene.dae",
        "does not collide: its mesh is flat",
    ] {
        assert!(xml.contains(left_out), "{left_out} is not in\n{xml}");
    }
}
