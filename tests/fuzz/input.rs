//! Cases: the kind and the contents of a file. A seed and an index make a case, the same one on every machine.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use crate::mutate::{bytes, json, lines, xml};
use crate::seeds::{Content, Seeds};

pub(crate) type Random = Xoshiro256PlusPlus;

/// Kinds of files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    Urdf,
    Sdf,
    Mjcf,
    Stl,
    Obj,
    Dae,
    Msh,
    Csv,
    Json,
    Pairs,
}

impl Kind {
    pub(crate) const ALL: [Self; 10] = [
        Self::Urdf,
        Self::Sdf,
        Self::Mjcf,
        Self::Stl,
        Self::Obj,
        Self::Dae,
        Self::Msh,
        Self::Csv,
        Self::Json,
        Self::Pairs,
    ];

    /// How often it is tried beside the others: descriptions are the largest language.
    fn weight(self) -> u32 {
        match self {
            Self::Urdf | Self::Sdf | Self::Mjcf => 3,
            _ => 1,
        }
    }

    /// The ending of its files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Urdf => "urdf",
            Self::Sdf => "sdf",
            Self::Mjcf => "mjcf",
            Self::Stl => "stl",
            Self::Obj => "obj",
            Self::Dae => "dae",
            Self::Msh => "msh",
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Pairs => "pairs",
        }
    }

    /// Kinds by their names, separated by commas.
    pub(crate) fn listed(names: &str) -> Vec<Self> {
        let find = |name: &str| Self::ALL.into_iter().find(|kind| kind.name() == name);
        let found = names
            .split(',')
            .map(|name| find(name).unwrap_or_else(|| panic!("no kind \"{name}\"")));
        found.collect()
    }

    fn any(kinds: &[Self], random: &mut Random) -> Self {
        let weights = kinds.iter().map(|kind| kind.weight());
        let mut left = random.random_range(0..weights.sum());
        for &kind in kinds {
            match left.checked_sub(kind.weight()) {
                Some(rest) => left = rest,
                None => return kind,
            }
        }
        kinds[0]
    }
}

/// One execution.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) kind: Kind,
    pub(crate) bytes: Vec<u8>,
    /// Index of the seed that it was made from.
    pub(crate) seed: usize,
    /// Decides everything about the execution that is left to decide.
    pub(crate) random: Random,
}

impl Case {
    pub(crate) fn new(seeds: &Seeds, kinds: &[Kind], seed: u64, index: u64) -> Self {
        /// The golden ratio in 64 bits: indices side by side become numbers far from one another.
        const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
        let mut random = Random::seed_from_u64(seed ^ index.wrapping_mul(GOLDEN));
        let kind = Kind::any(kinds, &mut random);
        let (seed, content) = seeds.any(kind, &mut random);
        let words = seeds.words(kind);
        let mut bytes = match content {
            Content::Xml(root) => {
                let others = seeds.trees(kind);
                xml::mutated(root, &others, words, &mut random).into_bytes()
            }
            Content::Json(value) => json::mutated(value, &mut random).into_bytes(),
            Content::Lines(text, separator) => {
                lines::mutated(text, *separator, words, &mut random).into_bytes()
            }
            Content::Bytes(bytes) => bytes.clone(),
        };
        let is_raw = matches!(content, Content::Bytes(_));
        if is_raw || random.random_range(0..8) == 0 {
            bytes::mutate(&mut bytes, &mut random);
        }
        Self {
            kind,
            bytes,
            seed,
            random,
        }
    }

    /// As text; invalid bytes are replaced.
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.bytes).into_owned()
    }
}
