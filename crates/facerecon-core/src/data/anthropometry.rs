//! The names that anthropometry has for the landmarks and for the distances between them (Farkas,
//! "Anthropometry of the Head and Face", 2nd edition, 1994; Caple and Stephan, "A standardized
//! nomenclature for craniofacial and facial anthropometry", 2016).

crate::settings::choices! {
    /// Side of the picture on which a landmark lies.
    pub enum PictureSide {
        /// At the left of the picture: the right side of the subject.
        Left = "left",
        /// At the right of the picture: the left side of the subject.
        Right = "right",
        /// On the midline.
        Middle = "middle",
    }
}

impl PictureSide {
    /// The side of the subject's own body.
    pub fn anatomical(self) -> &'static str {
        match self {
            Self::Left => "right",
            Self::Right => "left",
            Self::Middle => "midline",
        }
    }
}

/// What a landmark is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LandmarkTerm {
    /// Name in files and messages, one of `LANDMARKS`.
    pub name: &'static str,
    /// Name in anthropometry.
    pub term: &'static str,
    /// Abbreviation, without the side.
    pub abbreviation: &'static str,
    /// Side.
    pub side: PictureSide,
    /// Where it lies.
    pub definition: &'static str,
}

const fn term(
    name: &'static str,
    term: &'static str,
    abbreviation: &'static str,
    side: PictureSide,
    definition: &'static str,
) -> LandmarkTerm {
    LandmarkTerm { name, term, abbreviation, side, definition }
}

const OUTER_EYE: &str = "outer corner of the eye fissure, where the lids meet";
const INNER_EYE: &str = "inner corner of the eye fissure, where the lids meet";
const UPPER_EAR: &str = "upper attachment of the ear to the head";
const LOWER_EAR: &str = "lower attachment of the ear lobe to the cheek";
const MOUTH_CORNER: &str = "corner of the mouth, where the lips meet";
const ALA: &str = "most lateral point of the nose wing";

/// The 18 landmarks in the order of `LANDMARKS`.
pub const LANDMARK_TERMS: [LandmarkTerm; 18] = [
    term("eye_left_outer", "exocanthion", "ex", PictureSide::Left, OUTER_EYE),
    term("eye_left_inner", "endocanthion", "en", PictureSide::Left, INNER_EYE),
    term("eye_right_inner", "endocanthion", "en", PictureSide::Right, INNER_EYE),
    term("eye_right_outer", "exocanthion", "ex", PictureSide::Right, OUTER_EYE),
    term("ear_left_upper", "otobasion superius", "obs", PictureSide::Left, UPPER_EAR),
    term("ear_left_lower", "otobasion inferius", "obi", PictureSide::Left, LOWER_EAR),
    term("ear_right_upper", "otobasion superius", "obs", PictureSide::Right, UPPER_EAR),
    term("ear_right_lower", "otobasion inferius", "obi", PictureSide::Right, LOWER_EAR),
    term("mouth_left", "cheilion", "ch", PictureSide::Left, MOUTH_CORNER),
    term("mouth_right", "cheilion", "ch", PictureSide::Right, MOUTH_CORNER),
    term(
        "mouth_up",
        "labiale superius",
        "ls",
        PictureSide::Middle,
        "middle of the upper border of the upper lip",
    ),
    term(
        "mouth_down",
        "labiale inferius",
        "li",
        PictureSide::Middle,
        "middle of the lower border of the lower lip",
    ),
    term("ala_left", "alare", "al", PictureSide::Left, ALA),
    term("ala_right", "alare", "al", PictureSide::Right, ALA),
    term(
        "nose_saddle",
        "sellion",
        "se",
        PictureSide::Middle,
        "deepest point of the root of the nose; a few mm below the bony nasion",
    ),
    term("nose_tip", "pronasale", "prn", PictureSide::Middle, "most forward point of the nose"),
    term(
        "chin",
        "gnathion",
        "gn",
        PictureSide::Middle,
        "most forward and low point of the chin, between its most forward point (pogonion) and its \
         lowest point (menton); Farkas places gnathion at the lowest point, a few mm below",
    ),
    term(
        "forehead",
        "metopion",
        "m",
        PictureSide::Middle,
        "middle of the forehead, about 40 mm above sellion; no sharp feature marks it",
    ),
];

/// What a distance between two landmarks is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DistanceTerm {
    /// Name in files.
    pub name: &'static str,
    /// Name in anthropometry.
    pub term: &'static str,
    /// The abbreviations of its ends; `r` and `l` are the subject's own sides.
    pub abbreviation: &'static str,
    /// Landmark at one end.
    pub from: &'static str,
    /// Landmark at the other end.
    pub to: &'static str,
}

const fn distance(
    name: &'static str,
    term: &'static str,
    abbreviation: &'static str,
    from: &'static str,
    to: &'static str,
) -> DistanceTerm {
    DistanceTerm { name, term, abbreviation, from, to }
}

/// The distances of a result, straight lines between two landmarks.
pub const DISTANCES: [DistanceTerm; 16] = [
    distance(
        "intercanthal_width",
        "intercanthal width",
        "en-en",
        "eye_left_inner",
        "eye_right_inner",
    ),
    distance("biocular_width", "biocular width", "ex-ex", "eye_left_outer", "eye_right_outer"),
    distance(
        "eye_fissure_length_left",
        "length of the eye fissure, subject's right",
        "ex-en r",
        "eye_left_outer",
        "eye_left_inner",
    ),
    distance(
        "eye_fissure_length_right",
        "length of the eye fissure, subject's left",
        "ex-en l",
        "eye_right_outer",
        "eye_right_inner",
    ),
    distance("nose_width", "width of the nose", "al-al", "ala_left", "ala_right"),
    distance(
        "nose_bridge_length",
        "length of the nasal bridge",
        "se-prn",
        "nose_saddle",
        "nose_tip",
    ),
    distance("mouth_width", "width of the mouth", "ch-ch", "mouth_left", "mouth_right"),
    distance("lips_height", "height of both lips", "ls-li", "mouth_up", "mouth_down"),
    distance("nose_tip_to_upper_lip", "nose tip to upper lip", "prn-ls", "nose_tip", "mouth_up"),
    distance("chin_height", "lower lip to chin", "li-gn", "mouth_down", "chin"),
    distance(
        "face_height",
        "morphological face height from sellion",
        "se-gn",
        "nose_saddle",
        "chin",
    ),
    distance("forehead_height", "forehead to sellion", "m-se", "forehead", "nose_saddle"),
    distance(
        "ear_attachment_length_left",
        "length of the ear attachment, subject's right",
        "obs-obi r",
        "ear_left_upper",
        "ear_left_lower",
    ),
    distance(
        "ear_attachment_length_right",
        "length of the ear attachment, subject's left",
        "obs-obi l",
        "ear_right_upper",
        "ear_right_lower",
    ),
    distance(
        "upper_ear_width",
        "width of the face at the upper ear attachments",
        "obs-obs",
        "ear_left_upper",
        "ear_right_upper",
    ),
    distance(
        "lower_ear_width",
        "width of the face at the lower ear attachments",
        "obi-obi",
        "ear_left_lower",
        "ear_right_lower",
    ),
];

#[cfg(test)]
mod tests {
    use super::super::LANDMARKS;
    use super::*;

    #[test]
    fn every_landmark_has_a_term_and_distances_join_known_landmarks() {
        assert_eq!(LANDMARK_TERMS.map(|t| t.name), LANDMARKS);
        for d in DISTANCES {
            assert!(LANDMARKS.contains(&d.from) && LANDMARKS.contains(&d.to), "{}", d.name);
            assert_ne!(d.from, d.to);
        }
    }

    #[test]
    fn the_side_of_the_picture_is_opposite_to_that_of_the_subject() {
        for t in LANDMARK_TERMS {
            let side = if t.name.contains("left") { "right" } else { "left" };
            let paired = t.name.contains("left") || t.name.contains("right");
            assert_eq!(t.side.anatomical(), if paired { side } else { "midline" }, "{}", t.name);
        }
    }
}
