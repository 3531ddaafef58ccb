//! Sizes of faces of adults and children.

/// Mean and standard deviation of a distance in adults and in children of six years, mm.
///
/// After the norms of Farkas ("Anthropometry of the Head and Face", 2nd edition, 1994, appendix A),
/// both sexes together and rounded; the standard deviations are widened to the differences between
/// populations (Farkas et al., "International anthropometric study of facial morphology in various
/// ethnic groups/races", J Craniofac Surg 16, 2005; Bouhadana et al., "Expanding the Classic Facial
/// Canons", Plast Reconstr Surg Glob Open 10, 2022: means of the intercanthal width from 31.2 to
/// 38.5 mm). Adults of some populations have means of 98 mm for the biocular and 43 mm for the nasal
/// width, within two of these deviations.
pub(super) struct Norm {
    /// Name of the distance.
    pub(super) name: &'static str,
    pub(super) adult_mm: f64,
    pub(super) adult_sd_mm: f64,
    pub(super) child_mm: f64,
    pub(super) child_sd_mm: f64,
}

const fn norm(
    name: &'static str,
    [adult_mm, adult_sd_mm]: [f64; 2],
    [child_mm, child_sd_mm]: [f64; 2],
) -> Norm {
    Norm { name, adult_mm, adult_sd_mm, child_mm, child_sd_mm }
}

/// The distances that are compared.
pub(super) const NORMS: [Norm; 6] = [
    norm("intercanthal_width", [33.5, 4.0], [30.0, 3.0]),
    norm("biocular_width", [90.5, 5.5], [78.0, 4.5]),
    norm("nose_width", [36.0, 5.0], [28.5, 3.0]),
    norm("mouth_width", [52.5, 5.0], [42.0, 4.0]),
    norm("nose_bridge_length", [47.0, 5.0], [34.0, 4.0]),
    norm("face_height", [115.0, 8.0], [95.0, 6.0]),
];

impl Norm {
    /// Standard deviations by which a value lies above adults (positive) or below children
    /// (negative); 0 between the means of both.
    pub(super) fn excess(&self, value_mm: f64) -> f64 {
        if value_mm > self.adult_mm {
            (value_mm - self.adult_mm) / self.adult_sd_mm
        } else if value_mm < self.child_mm {
            (value_mm - self.child_mm) / self.child_sd_mm
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::DISTANCES;

    #[test]
    fn every_norm_is_of_a_known_distance_and_grows_with_age() {
        for norm in NORMS {
            assert!(DISTANCES.iter().any(|d| d.name == norm.name), "{}", norm.name);
            assert!(norm.adult_mm > norm.child_mm);
        }
    }

    #[test]
    fn values_between_child_and_adult_are_normal() {
        let width = &NORMS[1];
        assert_eq!(width.excess(85.0), 0.0);
        assert!((width.excess(112.5) - 4.0).abs() < 1e-12);
        assert!((width.excess(60.0) + 4.0).abs() < 1e-12);
    }
}
