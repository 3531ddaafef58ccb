//! Parameters of the stage.

crate::settings::choices! {
    /// How the texture is made.
    pub enum TextureMethod {
        /// Rows of the photos, resampled to the texture (thesis chapter 5); needs no cameras.
        Scanline = "scanline",
        /// All photos projected through their cameras and blended.
        Projective = "projective",
    }
}

crate::settings::choices! {
    /// The region of the photo that the scan-line method copies.
    pub enum Boundary {
        /// The bounding box of the four extreme dots (thesis Fig. 5.2).
        Rectangle = "rectangle",
        /// The box with its four corners cut off, closer to the face (thesis Fig. 5.3, 5.4).
        Hexagon = "hexagon",
    }
}

crate::settings::choices! {
    /// The photo from which the scan-line method takes its rows.
    pub enum Source {
        /// The left half of the face from the left photo, the right half from the right one.
        Halves = "halves",
        /// The left photo alone.
        Left = "left",
        /// The right photo alone.
        Right = "right",
    }
}

crate::settings::choices! {
    /// The colour of texels that no photo shows.
    pub enum Rest {
        /// The median colour of the face.
        Skin = "skin",
        /// The template's own texture, where it has one; else the median colour.
        Template = "template",
    }
}

crate::settings::settings! {
    /// Making the texture.
    pub struct TextureParams {
        /// How the texture is made.
        method: TextureMethod = TextureMethod::Scanline;
        /// Width and height of the square texture; the thesis starts with 1024.
        size: usize = 1024, range 16.0..=8192.0, unit "px";
        /// Scan-line: the region that is copied.
        boundary: Boundary = Boundary::Hexagon;
        /// Scan-line: the photo from which the rows are taken.
        source: Source = Source::Halves;
        /// Scan-line: segments in which a row is stretched, each between dots near it; 1 stretches
        /// the whole row evenly from edge to edge, as in the thesis.
        segments: usize = 10, range 1.0..=64.0, alias "stretches";
        /// Scan-line: colour of texels that no photo shows.
        rest: Rest = Rest::Skin;
        /// Parameters of the projective method.
        projective: ProjectiveParams = ProjectiveParams::default();
    }
}

crate::settings::settings! {
    /// Texture from photos with cameras.
    pub struct ProjectiveParams {
        /// Whether a motion of the head between the dotted and the plain photos is estimated and
        /// corrected.
        motion: bool = true;
        /// Whether the exposures of the photos are matched to that of the first.
        exposure: bool = true;
        /// Whether texels that no photo shows take the colour of the mirrored side of the face,
        /// where that is visible.
        mirror: bool = true;
        /// A point is hidden when it lies more than this behind the surface that the camera sees.
        bias_mm: f64 = 0.5, range 0.0..=100.0, unit "mm";
        /// Pixels nearer than this to a depth discontinuity are not used, since its position is
        /// uncertain; three times this distance at the silhouette, where the background shows.
        edge_px: f64 = 3.0, range 0.0..=5.0, unit "px";
        /// Surfaces seen at an angle with a smaller cosine to their normal are not used.
        least_cosine: f64 = 0.15, range 0.0..=0.99;
    }
}
