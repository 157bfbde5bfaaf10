//! Nothing is lost silently.

use super::*;
use crate::tests::ROUNDING;

#[test]
fn report_lists_every_unused_part_with_its_line() {
    let text = "<sdf version='1.9'><model name='r'>
<plugin name='p' filename='f'><x/></plugin>
<self_collide>true</self_collide><gripper name='g'/>
<link name='a'><inertial><mass>1</mass><inertia><ixx>1</ixx><ixy>0</ixy><ixz>0</ixz><iyy>1</iyy><iyz>0</iyz><izz>1</izz></inertia></inertial>
<sensor name='s' type='camera'/><gravity>false</gravity>
<visual name='v'><geometry><plane/></geometry></visual>
<visual name='w'><geometry><box><size>1 1 1</size></box></geometry><material><diffuse>1 0.5 0</diffuse><script/></material></visual>
<collision name='c'><geometry><mesh><uri>none.stl</uri><scale>1 2 3</scale></mesh></geometry><surface/></collision></link>
<joint name='j' type='revolute'><parent>world</parent><child>a</child>
<axis><xyz>1 0 0</xyz><dynamics><spring_stiffness>3</spring_stiffness></dynamics><limit><stiffness>1</stiffness></limit></axis>
<axis2/><physics/></joint></model></sdf>";
    let (model, report) = load(text);
    assert_eq!(
        places(&report.ignored),
        [
            ("sdf/model/plugin", "r", 2),
            ("sdf/model/self_collide", "r", 3),
            ("sdf/model/gripper", "r", 3),
            ("sdf/model/link/sensor", "a", 5),
            ("sdf/model/link/visual/geometry/plane", "a", 6),
            ("sdf/model/link/visual", "a", 6),
            ("sdf/model/link/visual/material/script", "a", 7),
            ("sdf/model/link/collision/surface", "a", 8),
            ("sdf/model/joint/axis/limit/stiffness", "j", 10),
            ("sdf/model/joint/physics", "j", 11),
            ("sdf/model/joint/axis2", "j", 11),
        ]
    );
    let reason = &report.ignored[8].reason;
    assert!(
        reason.contains("position limits of its actuators"),
        "{reason}"
    );
    assert_eq!(
        places(&report.warnings),
        [("sdf/model/link/collision/geometry/mesh", "a", 8)]
    );
    assert_eq!(
        model.links()[1].visuals[0].color,
        Some([1.0, 0.5, 0.0, 1.0])
    );
}

#[test]
fn defaults_of_the_sdf_are_taken_with_a_warning() {
    for (parts, mass, moment, warnings) in [
        ("", 1.0, 1.0, 1),
        ("<inertial/>", 1.0, 1.0, 2),
        ("<inertial><mass>3</mass></inertial>", 3.0, 1.0, 1),
        (
            "<inertial><inertia><ixx>2</ixx><ixy>0</ixy><ixz>0</ixz><iyy>1</iyy><iyz>0</iyz></inertia></inertial>",
            1.0,
            2.0,
            2,
        ),
    ] {
        let (model, report) = load(&robot(&format!("<link name='a'>{parts}</link>")));
        let inertia = model.to_builder().links[0].inertia;
        assert_eq!(
            (inertia.mass, inertia.rotational.xx),
            (mass, moment),
            "{parts}"
        );
        assert_eq!(report.warnings.len(), warnings, "{parts}: {report}");
    }
    let none = load(&robot(&link("a", ""))).1;
    assert_eq!((none.warnings.len(), none.ignored.len()), (0, 0));
}

#[test]
fn what_may_not_be_meant_is_a_warning() {
    let reasons = |text: &str| load(text).1.to_string();
    for (text, expected) in [
        (
            robot(&link("a", "<pose>1 0 0 0 0 0</pose>")),
            "initial pose of a floating robot",
        ),
        (robot_of("1.4", &link("a", "")), "read as 1.5"),
        (robot_of("1.12", &link("a", "")), "read as 1.11"),
        (
            robot(&(link("a", "") + &joint("j", "revolute", "world", "a", ""))),
            "no axis: taken as 0 0 1",
        ),
        (
            robot(
                &(link("a", "")
                    + &link("b", "")
                    + &anchor("a")
                    + &joint("j", "ball", "b", "a", "")),
            ),
            "inverse rotation",
        ),
        (
            robot(&format!(
                "<static>1</static>{}{}",
                link("a", ""),
                anchor("a")
            )),
            "does not move",
        ),
        (
            robot_of("1.6", &link("a", "<pose frame='__model__'/>")),
            "leaves open",
        ),
    ] {
        let report = reasons(&text);
        assert!(report.contains(expected), "{expected} is not in {report}");
    }
}

// Two cubes of 0.1 m, 0.2 m apart: of water 1 kg each, of the density 500 kg/m³ half of it.
#[test]
fn automatic_inertia_equals_that_of_the_solids_at_their_places() {
    let cube = |name: &str, z: f64, more: &str| {
        format!(
            "<collision name='{name}'><pose>0 0 {z} 0 0 0</pose><geometry><box><size>0.1 0.1 0.1</size></box></geometry>{more}</collision>"
        )
    };
    let link = |inertial: &str, more: &str| {
        let shapes = cube("a", 0.1, "") + &cube("b", -0.1, more);
        robot(&format!("<link name='l'>{inertial}{shapes}</link>"))
    };
    let (model, report) = load(&link("<inertial auto='true'/>", ""));
    let inertia = model.to_builder().links[0].inertia;
    // Across: 2 (m a²/6 + m d²) = 2 (1/600 + 1/100).
    assert!(
        (inertia.mass - 2.0).abs() < 10.0 * ROUNDING
            && (inertia.about_com().xx - 7.0 / 300.0).abs() < ROUNDING
    );
    assert_eq!((report.warnings.len(), report.ignored.len()), (0, 0));
    let light = "<inertial auto='true'><mass>9</mass><density>500</density></inertial>";
    let (model, report) = load(&link(light, "<density>1500</density>"));
    let inertia = model.to_builder().links[0].inertia;
    // 0.5 kg above and 1.5 kg below: the centre is (0.5 − 1.5) 0.1 / 2 above the origin.
    assert!(
        (inertia.mass - 2.0).abs() < 10.0 * ROUNDING && (inertia.com().z + 0.05).abs() < ROUNDING
    );
    assert_eq!(
        places(&report.ignored),
        [("sdf/model/link/inertial/mass", "l", 1)]
    );
    let mesh = "<static>1</static><link name='l'><inertial auto='1'/><collision name='c'><geometry><mesh><uri>x</uri></mesh></geometry></collision></link>";
    assert!(
        load(&robot(mesh))
            .1
            .to_string()
            .contains("meshes are not read")
    );
}

// What singular inertia makes of M is said at the joint, or at the model whose base floats.
#[test]
fn singular_inertia_is_a_warning_at_the_joint_that_nothing_resists() {
    let inertial = |xx: &str, yy: &str, zz: &str| {
        format!(
            "<inertial><pose>0 0 0.1 0 0 0</pose><mass>1.5</mass><inertia><ixx>{xx}</ixx><iyy>{yy}</iyy><izz>{zz}</izz>\
             <ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>"
        )
    };
    let link = |name: &str, inertial: &str| format!("<link name='{name}'>{inertial}</link>");
    let solid = inertial("0.1", "0.1", "0.1");
    let axis = "<axis><xyz>0 0 1</xyz></axis>";
    let plate_on_edge = link("a", &inertial("0", "0.1", "0.1"));
    let rod = link("a", &solid)
        + "\n"
        + &link("b", &inertial("0.1", "0.1", "-0"))
        + "\n"
        + &joint("j", "revolute", "a", "b", axis);
    let cross =
        link("a", &solid) + &link("b", &solid) + "\n" + &joint("u", "universal", "a", "b", "");
    for (parts, name, line) in [(plate_on_edge, "r", 1), (rod, "j", 3), (cross, "u", 2)] {
        let (model, report) = load(&robot(&parts));
        let singular = report
            .warnings
            .iter()
            .filter(|note| note.reason.contains("singular"));
        let singular: Vec<_> = singular
            .map(|note| (note.name.as_str(), note.line))
            .collect();
        assert_eq!(singular, [(name, line)], "{report}");
        assert!(model.check_mass_matrix().is_err());
    }
}
