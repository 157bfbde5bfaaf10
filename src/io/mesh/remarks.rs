//! Remarks on many meshes, each made once.

use std::collections::BTreeMap;

/// Remarks on meshes, with the meshes of each: robots hold many files of one kind.
#[derive(Debug, Default)]
pub(crate) struct Remarks(BTreeMap<String, Meshes>);

/// The meshes that a remark is about.
#[derive(Debug)]
struct Meshes {
    /// The first, as the description refers to it.
    first: String,
    others: usize,
}

impl Remarks {
    /// Adds the remarks on a mesh.
    pub(crate) fn add(&mut self, uri: &str, remarks: &[String]) {
        for remark in remarks {
            let known = self.0.entry(remark.clone());
            let count = |meshes: &mut Meshes| meshes.others += 1;
            known.and_modify(count).or_insert_with(|| Meshes {
                first: uri.into(),
                others: 0,
            });
        }
    }

    /// A sentence for each remark.
    pub(crate) fn sentences(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(remark, meshes)| {
            let Meshes { first, others } = meshes;
            match others {
                0 => format!("the mesh \"{first}\" {remark}"),
                1 => format!("the mesh \"{first}\", like another, {remark}"),
                _ => format!("the mesh \"{first}\", like {others} others, {remark}"),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_with_the_same_remark_share_a_sentence() {
        let mut remarks = Remarks::default();
        let [grey, old] = ["is grey".to_owned(), "is old".to_owned()];
        remarks.add("a", &[grey.clone(), old]);
        remarks.add("b", std::slice::from_ref(&grey));
        let sentences: Vec<_> = remarks.sentences().collect();
        let expected = [
            "the mesh \"a\", like another, is grey",
            "the mesh \"a\" is old",
        ];
        assert_eq!(sentences, expected);
        remarks.add("c", &[grey]);
        let sentence = remarks.sentences().next();
        assert_eq!(sentence.unwrap(), "the mesh \"a\", like 2 others, is grey");
    }
}
