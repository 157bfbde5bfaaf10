//! Seeds of cases: the robots of `assets/`, files of the fuzzer's own, and recordings that the library writes.

use dualbody::view::Recording;
use dualbody::{Model, State, model::samples};
use rand::{RngExt, SeedableRng};

use crate::input::{Kind, Random};
use crate::mutate::xml::Element;

/// A seed, at the level at which it is changed.
#[derive(Debug)]
pub(crate) enum Content {
    Xml(Element),
    Json(serde_json::Value),
    /// Lines of cells and their separators.
    Lines(String, char),
    Bytes(Vec<u8>),
}

#[derive(Debug)]
struct Seed {
    kind: Kind,
    content: Content,
    /// About how long it is.
    size: usize,
}

/// All seeds, and the words of each kind.
#[derive(Debug)]
pub(crate) struct Seeds {
    seeds: Vec<Seed>,
    words: Vec<Vec<String>>,
}

macro_rules! robots {
    ($($name:literal),*) => { [$(include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/", $name, ".urdf"))),*] };
}

const URDF: [&str; 10] = robots!(
    "acrobot",
    "box",
    "cartpole",
    "double_pendulum",
    "four_bar",
    "hopper",
    "panda",
    "quadruped",
    "sphere",
    "ur5"
);

const SDF: [&str; 3] = [
    include_str!("seeds/arm.sdf"),
    include_str!("seeds/nested.sdf"),
    include_str!("seeds/world.sdf"),
];

/// The descriptions whose dynamics are compared with those of another engine, and one with elements that refer to bodies.
const MJCF: [&str; 4] = [
    include_str!("../mjcf/chain.xml"),
    include_str!("../mjcf/free.xml"),
    include_str!("../mjcf/world.xml"),
    include_str!("seeds/scene.xml"),
];

/// Words that the languages know and the seeds do not use.
const WORDS: [&str; 32] = [
    "include",
    "uri",
    "merge",
    "static",
    "plane",
    "mesh",
    "ellipsoid",
    "heightmap",
    "screw",
    "gearbox",
    "floating",
    "spherical",
    "fluid_added_mass",
    "IDREF_array",
    "lines",
    "tristrips",
    "instance_controller",
    "skew",
    "lookat",
    "replicate",
    "attach",
    "frame",
    "freejoint",
    "childclass",
    "fromto",
    "fullinertia",
    "springdamper",
    "mtllib /dev/zero",
    "f -1 99999999 0",
    "usemtl",
    "vp",
    "curv",
];

/// Names of columns, and other content of a table.
const COLUMNS: [&str; 12] = [
    "time",
    "u0",
    "u2",
    "contact0",
    "contact3",
    "f.pole.x",
    "f.base.y",
    "series.q",
    "q.base.0",
    "cartpole 1/u0",
    "=1+1",
    "v.linear",
];

impl Seeds {
    pub(crate) fn new() -> Self {
        let xml = |kind, text: &&str| Seed::new(kind, Content::Xml(Element::parse(text)));
        let lines =
            |kind, text: String, separator| Seed::new(kind, Content::Lines(text, separator));
        let shapes = include_str!("seeds/shapes.urdf");
        let mut seeds: Vec<Seed> = URDF
            .iter()
            .chain([&shapes])
            .map(|text| xml(Kind::Urdf, text))
            .collect();
        seeds.extend(SDF.iter().map(|text| xml(Kind::Sdf, text)));
        seeds.extend(MJCF.iter().map(|text| xml(Kind::Mjcf, text)));
        seeds.push(xml(Kind::Dae, &include_str!("seeds/tetrahedron.dae")));
        seeds.push(lines(
            Kind::Obj,
            include_str!("seeds/shapes.obj").into(),
            ' ',
        ));
        seeds.push(lines(
            Kind::Stl,
            include_str!("seeds/corner.stl").into(),
            ' ',
        ));
        seeds.push(Seed::new(Kind::Stl, Content::Bytes(binary_stl())));
        for faces in [&[][..], &[0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3]] {
            seeds.push(Seed::new(Kind::Msh, Content::Bytes(msh(faces))));
        }
        let pairs = include_str!("seeds/pairs.txt");
        seeds.push(lines(Kind::Pairs, pairs.into(), ' '));
        for models in recorded_models() {
            let recording = recording(&models);
            seeds.push(lines(Kind::Csv, recording.to_csv(), ','));
            let value = serde_json::from_str(&recording.to_json());
            let value = value.unwrap_or_else(|error| panic!("a recording is JSON: {error}"));
            seeds.push(Seed::new(Kind::Json, Content::Json(value)));
        }
        let words = Kind::ALL.map(|kind| words(kind, &seeds)).into();
        Self { seeds, words }
    }

    /// A seed of a kind, more often a small one, with its number among those of its kind.
    pub(crate) fn any(&self, kind: Kind, random: &mut Random) -> (usize, &Content) {
        let own: Vec<&Seed> = self.of(kind).collect();
        let mut pick = || random.random_range(0..own.len());
        let picked = [pick(), pick(), pick()];
        let smallest = picked.into_iter().min_by_key(|&i| own[i].size);
        let i = smallest.unwrap_or_default();
        (i, &own[i].content)
    }

    fn of(&self, kind: Kind) -> impl Iterator<Item = &Seed> {
        self.seeds.iter().filter(move |seed| seed.kind == kind)
    }

    /// The trees of a kind.
    pub(crate) fn trees(&self, kind: Kind) -> Vec<&Element> {
        let trees = self.of(kind).filter_map(|seed| match &seed.content {
            Content::Xml(tree) => Some(tree),
            _ => None,
        });
        trees.collect()
    }

    /// Names and values of the files of a kind, and words of its language.
    pub(crate) fn words(&self, kind: Kind) -> &[String] {
        &self.words[kind as usize]
    }
}

impl Seed {
    fn new(kind: Kind, content: Content) -> Self {
        let size = content.size();
        Self {
            kind,
            content,
            size,
        }
    }
}

impl Content {
    /// About how long it is.
    fn size(&self) -> usize {
        match self {
            Self::Xml(tree) => tree.words().len(),
            Self::Json(_) => 0,
            Self::Lines(text, _) => text.len(),
            Self::Bytes(bytes) => bytes.len(),
        }
    }
}

fn words(kind: Kind, seeds: &[Seed]) -> Vec<String> {
    let own = seeds.iter().filter(|seed| seed.kind == kind);
    let mut out: Vec<String> = own.flat_map(|seed| seed.content.words()).collect();
    let known = if kind == Kind::Csv {
        &COLUMNS[..]
    } else {
        &WORDS[..]
    };
    out.extend(known.iter().map(|&word| word.to_owned()));
    out.sort_unstable();
    out.dedup();
    out
}

impl Content {
    fn words(&self) -> Vec<String> {
        match self {
            Self::Xml(tree) => tree.words(),
            Self::Lines(text, separator) => {
                let cells = text.lines().flat_map(|line| line.split(*separator));
                cells
                    .filter(|cell| cell.parse::<f64>().is_err())
                    .map(Into::into)
                    .collect()
            }
            Self::Json(_) | Self::Bytes(_) => Vec::new(),
        }
    }
}

/// Two triangles.
fn binary_stl() -> Vec<u8> {
    const HEADER: usize = 80;
    let mut out = vec![b' '; HEADER];
    out.extend(2_u32.to_le_bytes());
    for z in [0.0_f32, 1.0] {
        let numbers = [0.0, 0.0, 1.0, 0.0, 0.0, z, 1.0, 0.0, z, 0.0, 1.0, z];
        out.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
        out.extend([0; 2]);
    }
    out
}

/// A tetrahedron with a normal, and with these faces.
fn msh(faces: &[i32]) -> Vec<u8> {
    let counts = [4, 1, 0, faces.len() as i32 / 3];
    let numbers = [
        0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0,
    ];
    let words = counts.map(i32::to_le_bytes).into_iter();
    let words = words.chain(numbers.map(f32::to_le_bytes));
    let words = words.chain(faces.iter().map(|n| n.to_le_bytes()));
    words.flatten().collect()
}

/// The robots of each recording, in the order of the seeds.
pub(crate) fn recorded_models() -> [Vec<Model>; 3] {
    let sphere = Model::from_urdf_str(URDF[8]).unwrap_or_else(|error| panic!("{error}"));
    [
        vec![samples::cartpole()],
        vec![sphere],
        vec![
            samples::random_tree(4, 1),
            samples::cartpole(),
            samples::cartpole(),
        ],
    ]
}

/// A few moments with everything beside them.
fn recording(models: &[Model]) -> Recording {
    let models: Vec<&Model> = models.iter().collect();
    let mut random = Random::seed_from_u64(1);
    let mut out = Recording::of_robots(&models).with_title("seed");
    for k in 0..4 {
        let states = models.iter().map(|model| {
            let contact = nalgebra::DVector::from_element(3, 0.001);
            State::random(model, &mut random, 1.0).with_contact(contact)
        });
        let states: Vec<State> = states.collect();
        let moments: Vec<_> = states
            .iter()
            .map(|state| (state, &[0.5, -0.25][..]))
            .collect();
        out.push_all(0.1 * f64::from(k), &moments);
    }
    out.add_series("height [m]", [0.5, f64::NAN, 1e-300, -0.0]);
    out.add_series("u2", [1.0; 4]);
    let frame = models[0].link_names()[0].to_owned();
    let track = out.robot_mut(0);
    let force = nalgebra::Vector3::new(1.0, 2.0, 3.0);
    let drawn = track
        .add_force(&frame, [force; 4])
        .and_then(|track| track.trace(&frame));
    drawn.unwrap_or_else(|error| panic!("{error}"));
    out.add_axes("goal", dualbody::spatial::Transform::identity());
    out
}
