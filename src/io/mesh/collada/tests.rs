//! Files written by hand, against positions and colours worked out by hand.

use super::*;
use crate::io::mesh::soup::{Color, Mesh};

/// A triangle in millimetres.
pub(in crate::io::mesh) const TRIANGLE: &str = r##"<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit name="millimeter" meter="0.001"/><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="pa" count="9">0 0 0 2000 0 0 0 3000 0</float_array><technique_common>
<accessor source="#pa" count="3" stride="3"><param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"##;

fn load(text: &str) -> Result<Mesh, String> {
    read(text.as_bytes(), UpAxis::Auto)?.finish()
}

/// The vertices of all parts.
fn vertices(text: &str) -> Vec<[f32; 3]> {
    let parts = load(text).unwrap().parts;
    parts.into_iter().flat_map(|part| part.vertices).collect()
}

/// The triangle with other polygons, over the square of five positions in metres.
fn with_polygons(polygons: &str) -> String {
    let (start, rest) = TRIANGLE.split_once("<triangles").unwrap();
    let end = rest.split_once("</triangles>").unwrap().1;
    let text = format!("{start}{polygons}{end}").replace("0.001", "1");
    text.replace("0 0 0 2000 0 0 0 3000 0", "0 0 0 1 0 0 1 1 0 0 1 0 0 0 1")
}

fn triangles(polygons: &str) -> Vec<[[f32; 3]; 3]> {
    let part = &load(&with_polygons(polygons)).unwrap().parts[0];
    let corners = |t: &[u32; 3]| t.map(|i| part.vertices[i as usize]);
    part.triangles.iter().map(corners).collect()
}

#[test]
fn positions_equal_those_of_the_file_in_metres() {
    let expected = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
    assert_eq!(vertices(TRIANGLE), expected);
    let comma = TRIANGLE
        .replace("0.001", "0,001")
        .replace("2000", "2<!-- -->000,0e0");
    // A comment parts words.
    assert!(vertices(&comma.replace("<!-- -->", "")) == expected && load(&comma).is_err());
    let padded = TRIANGLE
        .replace("2000 0", "2000<!-- --> 0")
        .replace("stride=\"3\"", "stride=\"3\" offset=\"0\"");
    assert_eq!(vertices(&padded), expected);
}

#[test]
fn up_axis_is_turned_to_z_as_the_option_says() {
    let stated = |axis: &str| TRIANGLE.replace("Z_UP", axis);
    let meshlab =
        "<asset><contributor><authoring_tool>VCGLib | MeshLab</authoring_tool></contributor>";
    let of_meshlab = stated("Y_UP").replace("<asset>", meshlab);
    let as_it_stands = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 3.0, 0.0]];
    // The axis that is up in the file, y or x, becomes z.
    let y_turned = [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 0.0, 3.0]];
    let x_turned = [[0.0; 3], [0.0, 0.0, 2.0], [-3.0, 0.0, 0.0]];
    for (text, up_axis, expected, remarks) in [
        (stated("Z_UP"), UpAxis::Honour, as_it_stands, 0),
        (stated("Y_UP"), UpAxis::Auto, y_turned, 1),
        (stated("Y_UP"), UpAxis::Honour, y_turned, 1),
        (stated("Y_UP"), UpAxis::Ignore, as_it_stands, 1),
        (stated("X_UP"), UpAxis::Auto, x_turned, 1),
        (of_meshlab.clone(), UpAxis::Auto, as_it_stands, 1),
        (of_meshlab, UpAxis::Honour, y_turned, 1),
        (
            TRIANGLE.replace("<up_axis>Z_UP</up_axis>", ""),
            UpAxis::Honour,
            as_it_stands,
            0,
        ),
    ] {
        let mesh = read(text.as_bytes(), up_axis).unwrap().finish().unwrap();
        assert_eq!(mesh.parts[0].vertices, expected, "{up_axis:?}");
        assert_eq!(mesh.remarks.len(), remarks, "{:?}", mesh.remarks);
    }
}

#[test]
fn transforms_of_nodes_apply_from_the_inside_outwards_and_from_the_last_to_the_first() {
    let nested = TRIANGLE
        .replace("0.001", "1")
        .replace("2000", "2")
        .replace("3000", "3")
        .replace(
            "<node id=\"n\">",
            "<node><translate>10 0 0</translate><rotate>0 0 1 90</rotate><node id='n'>\
         <matrix>1 0 0 0  0 1 0 5  0 0 1 0  0 0 0 1</matrix><scale>1 1 -2</scale>",
        );
    let nested = nested.replace("</node>", "</node></node>");
    // (x, y, z) → (x, y + 5, −2 z) → (−y − 5, x, …) → (5 − y, x, −2 z)
    let expected = [[5.0, 0.0, 0.0], [5.0, 2.0, 0.0], [2.0, 0.0, 0.0]];
    for (found, expected) in vertices(&nested).iter().zip(expected) {
        let error = (0..3).map(|i| (found[i] - expected[i]).abs()).sum::<f32>();
        assert!(error < 1e-6, "{found:?} for {expected:?}");
    }
}

#[test]
fn shapes_are_drawn_as_often_as_the_scene_says() {
    let twice = "<instance_geometry url='#g'/></node><node><translate>0 0 7000</translate><instance_node url='#n'/>";
    let twice = TRIANGLE.replace("<instance_geometry url=\"#g\"/>", twice);
    let found = vertices(&twice);
    assert_eq!((found.len(), found[3]), (6, [0.0, 0.0, 7.0]));
    let unused = TRIANGLE.replace("<instance_geometry url=\"#g\"/>", "");
    assert_eq!(load(&unused).unwrap_err(), "has no triangles");
    let controller = "<library_controllers><controller id='c'><skin source='#g'/></controller></library_controllers><scene>";
    let skinned = TRIANGLE.replace("<scene>", controller);
    let skinned = skinned.replace(
        "<instance_geometry url=\"#g\"/>",
        "<instance_controller url='#c'/>",
    );
    assert_eq!(vertices(&skinned).len(), 3);
    let start = TRIANGLE.find("<library_visual_scenes>").unwrap();
    let no_scene = TRIANGLE[..start].to_owned() + "</COLLADA>";
    assert_eq!(vertices(&no_scene)[1], [2.0, 0.0, 0.0]);
}

#[test]
fn polygons_of_all_kinds_equal_their_triangles() {
    let [a, b, c, d, e] = [
        [0., 0., 0.],
        [1., 0., 0.],
        [1., 1., 0.],
        [0., 1., 0.],
        [0., 0., 1.],
    ];
    let vertex = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let quad = vec![[a, b, c], [a, c, d]];
    for (polygons, expected) in [
        (format!("<triangles>{vertex}<p>0 1 2 0 2 3</p></triangles>"), &quad),
        (format!("<polylist>{vertex}<vcount>4</vcount><p>0 1 2 3</p></polylist>"), &quad),
        (format!("<polylist>{vertex}<vcount>3 3</vcount><p>0 1 2 0 2 3</p></polylist>"), &quad),
        (format!("<polygons>{vertex}<p>0 1 2</p><ph><p>0 2 3</p><h>1 2 3</h></ph></polygons>"), &quad),
        (format!("<trifans>{vertex}<p>0 1 2 3</p></trifans>"), &quad),
        (format!("<tristrips>{vertex}<p>0 1 2 3 4</p></tristrips>"), &vec![[a, b, c], [c, b, d], [c, d, e]]),
        (
            "<triangles><input semantic='NORMAL' source='#x' offset='0'/><input semantic='VERTEX' source='#v' offset='1'/>\
             <p>9 0 9 1 9 2 9 0 9 2 9 3</p></triangles>".into(),
            &quad,
        ),
    ] {
        assert_eq!(triangles(&polygons), *expected, "{polygons}");
    }
    let lines = with_polygons(&format!("<lines>{vertex}<p>0 1</p></lines>"));
    assert_eq!(load(&lines).unwrap_err(), "has no triangles");
}

#[test]
fn wrong_numbers_say_what_they_are() {
    let vertex = "<input semantic='VERTEX' source='#v' offset='0'/>";
    for (polygons, reason) in [
        (format!("<triangles>{vertex}<p>0 1</p></triangles>"), "more or fewer corners"),
        (format!("<triangles>{vertex}<p>0 1 5</p></triangles>"), "has no vertex 5"),
        (format!("<triangles>{vertex}<p>0 1 -1</p></triangles>"), "a corner that is not a vertex"),
        (format!("<polylist>{vertex}<vcount>9</vcount><p>0 1 2</p></polylist>"), "more or fewer corners"),
        (format!("<polylist>{vertex}<vcount>0 3</vcount><p>0 1 2</p></polylist>"), "more or fewer corners"),
        ("<triangles><input semantic='VERTEX' source='#v' offset='1'/><p>0 1 2</p></triangles>".into(), "more or fewer indices"),
        ("<triangles><input semantic='VERTEX' source='#v' offset='18446744073709551615'/><p>0</p></triangles>".into(), "more or fewer indices"),
        ("<triangles><input semantic='VERTEX' source='#v' offset='x'/><p>0</p></triangles>".into(), "not a count"),
    ] {
        let error = load(&with_polygons(&polygons)).unwrap_err();
        assert!(error.contains(reason), "{polygons}: {error}");
    }
    for (from, to, reason) in [
        (
            "stride=\"3\"",
            "stride=\"2\"",
            "positions of 2 numbers each",
        ),
        ("2000", "two", "a position that is not three numbers"),
        ("2000", "nan", "NaN"),
        ("0.001", "0", "unit of length"),
        ("<COLLADA", "<COLLADA><a>", "not well-formed XML on line 10"),
        ("COLLADA", "collada", "is not COLLADA"),
        ("#pa", "#none", ""),
        ("url=\"#g\"", "url=\"#none\"", "has no triangles"),
        (
            "<node id=\"n\">",
            "<node><translate>1 2</translate>",
            "a <translate> that is not 3 finite numbers",
        ),
    ] {
        let found = load(&TRIANGLE.replace(from, to));
        let reason_found = found.err().unwrap_or_default();
        assert!(reason_found.contains(reason), "{to}: {reason_found}");
    }
}

#[test]
fn colours_equal_those_of_the_bound_materials() {
    let effect = |id: &str, inside: &str| {
        format!(
            "<effect id='e{id}'><profile_COMMON><technique sid='t'><phong><diffuse>{inside}</diffuse></phong></technique></profile_COMMON></effect>\
             <material id='m{id}'><instance_effect url='#e{id}'/></material>"
        )
    };
    let library = effect("1", "<color>1 0 0 0.5</color>")
        + &effect("2", "<texture texture='x' texcoord='y'/>");
    let bind = "<instance_geometry url='#g'><bind_material><technique_common>\
        <instance_material symbol='a' target='#m1'/><instance_material symbol='b' target='#m2'/>\
        </technique_common></bind_material></instance_geometry>";
    let vertex = "<input semantic='VERTEX' source='#v' offset='0'/>";
    let polygons: String = ["a", "b", "c"]
        .iter()
        .map(|m| format!("<triangles material='{m}'>{vertex}<p>0 1 2</p></triangles>"))
        .collect();
    let text = with_polygons(&polygons)
        .replace("<instance_geometry url=\"#g\"/>", bind)
        .replace("<scene>", &format!("{library}<scene>"));
    let colors: Vec<Color> = load(&text)
        .unwrap()
        .parts
        .iter()
        .map(|part| part.color)
        .collect();
    assert_eq!(
        colors,
        [Some([1.0, 0.0, 0.0, 0.5]), Some([0.6, 0.6, 0.6, 1.0]), None]
    );
}

/// Counts are not believed, names among numbers are passed over, whatever is in them.
#[test]
fn counts_and_arrays_of_names_change_nothing() {
    let expected = vertices(TRIANGLE);
    let names = "<mesh><source id='q'><Name_array id='qa' count='1'>x</Name_array></source><source id='r'><IDREF_array id='ra' count='9'>x y</IDREF_array></source>";
    for text in [
        TRIANGLE.replace("count=\"9\"", "count=\"4294967295\""),
        TRIANGLE.replace("<triangles count=\"1\"", "<triangles count=\"4294967295\""),
        TRIANGLE.replace("count=\"3\"", "count=\"18446744073709551616\""),
        TRIANGLE.replace("<mesh>", names),
    ] {
        assert_eq!(vertices(&text), expected, "{text}");
    }
}

#[test]
fn nodes_of_any_depth_are_drawn_on_a_small_stack() {
    const DEPTH: usize = 100_000;
    let thread = std::thread::Builder::new().stack_size(1 << 20).spawn(|| {
        let open = "<node><translate>0 0 1</translate>".repeat(DEPTH);
        let deep = TRIANGLE.replace("<node id=\"n\">", &format!("{open}<node>"));
        let deep = deep.replace(
            "</visual_scene>",
            &("</node>".repeat(DEPTH) + "</visual_scene>"),
        );
        assert!((vertices(&deep)[0][2] - DEPTH as f32 * 1e-3).abs() < 1e-4);
    });
    thread.unwrap().join().unwrap();
}

/// Each of these took minutes or for ever with a reader that follows every reference anew.
#[test]
fn what_refers_to_one_another_ends() {
    let draws = |inside: &str| {
        let text = TRIANGLE.replace("<instance_geometry url=\"#g\"/>", inside);
        load(&text).map(|mesh| mesh.parts[0].triangles.len())
    };
    let circle = draws("<instance_node url='#n'/><instance_geometry url='#g'/>");
    assert!(circle.unwrap_err().contains("contain each other"));
    // A tower of nodes each of which holds the next twice.
    let tower: String = (0..64)
        .map(|i| {
            format!(
                "<node id='t{i}'><instance_node url='#t{0}'/><instance_node url='#t{0}'/></node>",
                i + 1
            )
        })
        .collect();
    assert!(draws(&tower).unwrap_err().contains("contain each other"));
    let often = "<instance_geometry url='#g'/>".repeat(50_000);
    assert_eq!(draws(&often).unwrap(), 50_000);
    let too_often = "<instance_geometry url='#g'/>".repeat(250_000);
    assert_eq!(
        draws(&too_often).unwrap_err(),
        "draws the same triangles too often"
    );
    // Many materials over one large effect, bound many times.
    let effect = "<effect id='e'>".to_owned() + &"<newparam/>".repeat(50_000) + "</effect>";
    let materials: String = (0..20_000)
        .map(|i| format!("<material id='m{i}'><instance_effect url='#e'/></material>"))
        .collect();
    let bind: String = (0..20_000)
        .map(|i| format!("<instance_material symbol='s{i}' target='#m{i}'/>"))
        .collect();
    let instance = format!(
        "<node id='i'><instance_geometry url='#g'><bind_material><technique_common>{bind}</technique_common></bind_material></instance_geometry></node>"
    );
    let again = "<instance_node url='#i'/>".repeat(20_000);
    let text = TRIANGLE.replace("<scene>", &format!("{effect}{materials}<scene>"));
    let text = text.replace(
        "<instance_geometry url=\"#g\"/>",
        &format!("{instance}{again}"),
    );
    assert_eq!(load(&text).unwrap().parts[0].triangles.len(), 20_001);
}

#[test]
fn floods_of_attributes_and_name_spaces_and_document_types_are_refused() {
    let attributes: String = (0..60_000).map(|i| format!(" a{i}='0'")).collect();
    let spaces: String = (0..30_000)
        .map(|i| format!("<x xmlns:a{i}='u'/>"))
        .collect();
    for (text, reason) in [
        (
            TRIANGLE.replace("<asset>", &format!("<asset{attributes}>")),
            "more than 1000 attributes",
        ),
        (
            TRIANGLE.replace("</asset>", &format!("{spaces}</asset>")),
            "more than 1000 declarations of name spaces",
        ),
        (
            TRIANGLE.replace("<COLLADA", "<!DOCTYPE a [<!ENTITY b 'c'>]><COLLADA"),
            "a document type declaration",
        ),
    ] {
        let error = load(&text).unwrap_err();
        assert!(error.contains(reason), "{error}");
    }
}
