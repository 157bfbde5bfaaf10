//! Pairs of links that do not collide, from SRDF files.

use std::collections::HashSet;
use std::path::Path;

use super::context::{Context, Node, children};
use super::guard::parse;
use super::place::ImportNote;
use super::schema::{Known, check, known, leaf};
use super::{ModelOptions, place};
use crate::contact::CollisionOptions;
use crate::error::LoadError;
use crate::model::Model;

/// Name of the source in errors for SRDF that is not in a file.
const TEXT_SOURCE: &str = "SRDF text";

const ROBOT: Known = known("name version", "", "disable_collisions");
const PAIR: Known = leaf("link1 link2 reason");

impl CollisionOptions {
    /// Excludes the pairs of links that an SRDF file lists as `<disable_collisions link1="…" link2="…"/>`. Also returns the other content of the file
    /// (groups, states, `<disable_default_collisions>`), which is not read.
    ///
    /// * `prefix` – prefix of link names, as in [`World::add`](crate::World::add); empty for a single robot
    ///
    /// # Errors
    /// If the file cannot be read or is not SRDF, if a pair lacks a link, or if the model has no such link; with file and line.
    pub fn with_srdf_file(
        self,
        model: &Model,
        prefix: &str,
        path: impl AsRef<Path>,
    ) -> Result<(Self, Vec<ImportNote>), LoadError> {
        let (file, text) = ModelOptions::default().read_file(path.as_ref())?;
        self.with_srdf(model, prefix, &file, &text)
    }

    /// [`with_srdf_file`](Self::with_srdf_file) from the text of a file.
    ///
    /// # Errors
    /// As [`with_srdf_file`](Self::with_srdf_file).
    ///
    /// # Examples
    /// ```
    /// use dualbody::{contact::CollisionOptions, model::samples};
    ///
    /// let srdf = r#"<robot name="arm"><disable_collisions link1="link1" link2="link3" reason="Never"/></robot>"#;
    /// let (options, rest) = CollisionOptions::default().with_srdf_str(&samples::arm(), "", srdf)?;
    /// assert_eq!(options.excluded, [["link1", "link3"]]);
    /// assert!(rest.is_empty());
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn with_srdf_str(
        self,
        model: &Model,
        prefix: &str,
        xml: &str,
    ) -> Result<(Self, Vec<ImportNote>), LoadError> {
        self.with_srdf(model, prefix, TEXT_SOURCE, xml)
    }

    fn with_srdf(
        mut self,
        model: &Model,
        prefix: &str,
        file: &str,
        text: &str,
    ) -> Result<(Self, Vec<ImportNote>), LoadError> {
        let document = parse(file, text, "robot")?;
        let mut context = Context::new(file, text);
        let robot = document.root_element();
        check(&mut context, robot, &ROBOT)?;
        let links = model.links().iter();
        let links: HashSet<&str> = links
            .map(|link| model.frames()[link.frame.0].name.as_str())
            .collect();
        for pair in children(robot, "disable_collisions") {
            check(&mut context, pair, &PAIR)?;
            let link = |attribute| link(&context, &links, prefix, pair, attribute);
            self.excluded.push([link("link1")?, link("link2")?]);
        }
        Ok((self, context.ignored))
    }
}

/// The name in the model of a link of a pair.
fn link(
    context: &Context<'_>,
    links: &HashSet<&str>,
    prefix: &str,
    pair: Node<'_>,
    attribute: &str,
) -> Result<String, LoadError> {
    let own = pair.attribute(attribute);
    let own = own.ok_or_else(|| context.missing(pair, attribute))?;
    let name = format!("{prefix}{own}");
    if links.contains(name.as_str()) {
        return Ok(name);
    }
    Err(LoadError::UnknownFrame {
        at: context.position(pair),
        element: place::element(pair),
        name: context.name_or_line(pair),
        frame: name,
    })
}
