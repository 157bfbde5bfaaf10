//! Height fields of MJCF from PNG pictures, against the heights that `MuJoCo` 4.0 finds by rays at the points of the same pictures.

use std::fs;
use std::path::PathBuf;

use dualbody::ModelOptions;
use dualbody::contact::Terrain;

/// A picture of 4 × 3 pixels in hexadecimal digits, and the heights that `mj_ray` finds along y = −1, 0, 1 for x = −1.5, −0.5, 0.5, 1.5 from the
/// geom's origin, m.
struct Picture {
    bytes: &'static str,
    heights: [[f64; 3]; 4],
}

/// 8 bits, 16 bits of which the upper half counts, red of three channels, a palette of four colours.
const PICTURES: [Picture; 4] = [
    Picture {
        bytes: "89504e470d0a1a0a0000000d4948445200000004000000030800000000919ff11a000000174944415478da63e01291d360f865cbcec1c07922851900131902e3300685180000000049454e44ae426082",
        heights: [
            [0.059717, 0.45, 0.061336],
            [0.369028, 0.143927, 0.07753],
            [0.207085, 0.056478, 0.093725],
            [0.05, 0.058097, 0.109919],
        ],
    },
    Picture {
        bytes: "89504e470d0a1a0a0000000d4948445200000004000000031000000000c10f2d59000000244944415478da63607ec17e81fde2ffff0c731ce62c61d461f8cfc0c8506a606079c51000968609f55d06c2a30000000049454e44ae426082",
        heights: [
            [0.051569, 0.294706, 0.054706],
            [0.233529, 0.294706, 0.06098],
            [0.125294, 0.051569, 0.06098],
            [0.382549, 0.05, 0.45],
        ],
    },
    Picture {
        bytes: "89504e470d0a1a0a0000000d49484452000000040000000308020000003b9639910000002f4944415478da63e03a2127c2c824c7c2a2c1c9c9f08b81c1969d9d9d9393838383819391f1041353caffffccbe4e0066d806a91fd24c3c0000000049454e44ae426082",
        heights: [
            [0.059717, 0.45, 0.061336],
            [0.369028, 0.143927, 0.07753],
            [0.207085, 0.056478, 0.093725],
            [0.05, 0.058097, 0.109919],
        ],
    },
    Picture {
        bytes: "89504e470d0a1a0a0000000d4948445200000004000000030203000000c99a46550000000c504c54450a63621403043206075a01011c040a000000000e4944415478da63906678c2100400038b0152739f44200000000049454e44ae426082",
        heights: [
            [0.1, 0.45, 0.05],
            [0.1, 0.25, 0.1],
            [0.05, 0.1, 0.25],
            [0.25, 0.05, 0.45],
        ],
    },
];

/// Of 60,000 × 60,000 pixels according to its header.
const BOMB: &str = "89504e470d0a1a0a0000000d494844520000ea600000ea600800000000a5b92a9e000000114944415478da63601805a360140c77000003e80001ce494c58";

/// Of 1 × 2 pixels.
const NARROW: &str = "89504e470d0a1a0a0000000d4948445200000001000000020800000000bceae9fb0000000c4944415478da6360646002000009000479da23d40000000049454e44ae426082";

fn bytes(digits: &str) -> Vec<u8> {
    let pairs = digits.as_bytes().chunks(2);
    let byte = |pair| u8::from_str_radix(std::str::from_utf8(pair).expect("digits"), 16);
    pairs.map(|pair| byte(pair).expect("a byte")).collect()
}

/// The ground of a picture, and the report.
fn load(name: &str, bytes: &[u8]) -> (Option<Terrain>, String) {
    let file = format!("heights_{}_{name}", std::process::id());
    let path: PathBuf = std::env::temp_dir().join(file);
    fs::write(&path, bytes).expect("a file");
    let xml = format!(
        "<mujoco><asset><hfield name='h' size='1.5 1 0.4 0.1' file='{}'/></asset>
         <worldbody><geom type='hfield' hfield='h' pos='0.2 0.1 0.05'/><body><freejoint/><geom size='0.1'/></body></worldbody></mujoco>",
        path.display()
    );
    let loaded = ModelOptions::default().load_mjcf_scene_str(&xml);
    fs::remove_file(&path).expect("the file");
    let (scene, report) = loaded.unwrap_or_else(|error| panic!("{error}"));
    let heights = scene.contacts.heights.map(Terrain::HeightField);
    (heights, report.to_string())
}

#[test]
fn heights_of_pictures_equal_those_of_mujoco() {
    for (k, picture) in PICTURES.iter().enumerate() {
        let (ground, report) = load(&format!("{k}.PNG"), &bytes(picture.bytes));
        let ground = ground.unwrap_or_else(|| panic!("{report}"));
        for (row, x) in picture.heights.iter().zip([-1.5, -0.5, 0.5, 1.5]) {
            for (theirs, y) in row.iter().zip([-1.0, 0.0, 1.0]) {
                let ours = ground.surface(&(0.2 + x), &(0.1 + y)).height;
                assert!(
                    (ours - theirs).abs() < 2e-6,
                    "{k}: {ours} {theirs} at {x}, {y}"
                );
            }
        }
    }
}

#[test]
fn broken_pictures_are_reported_with_file_and_reason() {
    let whole = bytes(PICTURES[0].bytes);
    let refused = |bytes: &[u8], says: &str| {
        let (ground, report) = load("broken.png", bytes);
        assert!(
            ground.is_none() && report.contains("_broken.png"),
            "{report}"
        );
        assert!(report.contains(says), "{report}");
    };
    // The last chunk, which has no data, may be missing in part.
    for length in 0..whole.len() - 12 {
        refused(&whole[..length], "is not a PNG picture that can be read");
    }
    for at in [16, 24, 45, 60] {
        let mut changed = whole.clone();
        changed[at] ^= 0x40;
        refused(&changed, "");
    }
    refused(&bytes(BOMB), "60000 × 60000");
    refused(&bytes(NARROW), "has 1 × 2 pixels: expected 2 × 2 or more");
    refused(b"GIF89a", "is not a PNG picture that can be read");
}
