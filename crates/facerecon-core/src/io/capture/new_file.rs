//! The commented `capture.toml` of a new capture.

use crate::data::LANDMARKS;

/// Landmark names in one line of the file.
const NAMES_PER_LINE: usize = 6;

/// The commented `capture.toml` that `facerecon new` writes for the user to fill in.
pub fn new_capture_toml() -> String {
    let mut out = String::from(
        r##"# A capture for facerecon: the photographs of one session and what is known about them.
# Paths are relative to this file and must stay inside its folder. Lines that begin with # are
# comments.

[images]
# The dotted pair: both photos with the projected pattern, taken at the same moment.
# PNG, JPEG or GIF, all of the same size.
left = "left_dots.png"
right = "right_dots.png"
# The plain pair: the same view without the pattern. It gives the texture and improves the matches.
left_plain = "left_plain.png"
right_plain = "right_plain.png"

# Extra plain photos, each with its camera: X_cam = R X_left + T, millimetres.
# [[images.extra]]
# image = "profile_plain.png"
# K = [[2291.67, 0, 383.5], [0, 2291.67, 287.5], [0, 0, 1]]
# D = [0, 0, 0, 0, 0]
# R = [[0.643, 0, 0.766], [0, 1, 0], [-0.766, 0, 0.643]]
# T = [-918.9, -3.0, 413.8]

[pattern]
kind = "dots"        # "dots" or "stripes"
columns = 85         # dots in a row of the projected image
rows = 64            # dots in a column
# rotation_deg = 0.0 # rotation of the lattice, clockwise

[rig]
# Without a rig the result has the right shape but no absolute size.
# The stereo calibration: OpenCV YAML, XML or JSON with K1 D1 K2 D2 R T, millimetres.
calibration = "calibration.yml"
# Or, for parallel cameras, these four keys (a calibration file takes precedence):
# baseline_mm = 150.0
# focal_px = 2765.96
# principal_left = [383.5, 287.5]   # pixel centres at integers: the centre of 768x576
# principal_right = [383.5, 287.5]

# The three seeds of the thesis (only the profile "facebuilder" needs them): one dot on the
# forehead and one at each ear, in pixels of both photos; left_ear is at the left of the picture.
# [seeds]
# head = { left = [548.0, 187.9], right = [219.0, 187.9] }
# left_ear = { left = [399.6, 359.0], right = [79.4, 359.0] }
# right_ear = { left = [678.2, 319.7], right = [357.3, 319.7] }

# Landmarks marked in both photos, any of these (left and right as seen in the picture):
"##,
    );
    for names in LANDMARKS.chunks(NAMES_PER_LINE) {
        out += &format!("#   {}\n", names.join(" "));
    }
    out += "# [landmarks]\n# nose_tip = { left = [552.4, 363.4], right = [214.4, 363.4] }\n";
    out
}
