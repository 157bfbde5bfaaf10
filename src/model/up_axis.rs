//! The axis of a mesh file that points up.

/// Treatment of the up axis of a COLLADA file.
///
/// In robot descriptions z points up. A file with another `<up_axis>` is either rotated, so that this axis points along z, or its coordinates are
/// used unchanged, as in `RViz`. In both cases the HTML viewer and [`Contacts::mesh_remarks`](crate::contact::Contacts::mesh_remarks) report it. STL
/// and OBJ files have no up axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "view", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "view", serde(rename_all = "lowercase"))]
#[non_exhaustive]
pub enum UpAxis {
    /// Rotates the file, unless `MeshLab` (its library `VCGLib`) wrote it, which always writes `Y_UP`.
    ///
    /// In all tested robots, files of `MeshLab` have z up, and other files have the stated axis up.
    #[default]
    Auto,
    /// Rotates the file according to its up axis.
    Honour,
    /// Uses the coordinates unchanged.
    Ignore,
}
