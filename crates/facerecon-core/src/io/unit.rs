//! Units of length of mesh files and calibrations.

crate::settings::choices! {
    /// The length of one unit of a file's coordinates.
    pub enum LengthUnit {
        /// Micrometre.
        Micrometre = "um",
        /// Millimetre.
        Millimetre = "mm",
        /// Centimetre.
        Centimetre = "cm",
        /// Decimetre.
        Decimetre = "dm",
        /// Metre.
        Metre = "m",
        /// Inch, 25.4 mm.
        Inch = "in",
    }
}

impl LengthUnit {
    /// All units, smallest first.
    pub const ALL: [Self; 6] = [
        Self::Micrometre,
        Self::Millimetre,
        Self::Centimetre,
        Self::Inch,
        Self::Decimetre,
        Self::Metre,
    ];

    /// Its length in millimetres.
    pub fn in_mm(self) -> f64 {
        match self {
            Self::Micrometre => 1e-3,
            Self::Millimetre => 1.0,
            Self::Centimetre => 10.0,
            Self::Decimetre => 100.0,
            Self::Metre => 1000.0,
            Self::Inch => 25.4,
        }
    }
}
