//! The setting of the layout of a map.

use crate::named;

named! {
    /// Layout of the texels that vertices sample.
    #[derive(Default)]
    pub enum LayoutChoice {
        /// The mesh's own UVs, with private texels for vertices that miss their height there; else one texel for each vertex.
        #[default]
        Auto = "auto",
        /// The mesh's own UVs.
        Uv = "uv",
        /// One texel for each vertex: always exact, needs no UVs.
        Vertex = "vertex",
        /// New UVs, made by xatlas; only in a planish built with --features unwrap.
        Unwrap = "unwrap",
    }
}
