//! The measures of the built-in head, in millimetres.
//!
//! Lengths, breadths and depths are adult means after L. G. Farkas, "Anthropometry of the Head
//! and Face" (2nd ed., 1994), averaged over sexes and rounded. Depths that the tables do not give
//! (skin surface at heights between landmarks) were chosen by eye and by comparison with average
//! faces.
//! Frame: origin midway between the tragi, x to the viewer's right, y up, z toward the viewer.

/// A horizontal loop around the head; `base` interpolates between loops.
#[derive(Debug, Clone)]
pub(crate) struct Loop {
    /// Height `[front, side, back]`.
    pub(crate) y: [f64; 3],
    pub(crate) half_breadth: f64,
    /// z of the frontmost and the rearmost point.
    pub(crate) front: f64,
    pub(crate) back: f64,
    /// z of the greatest breadth.
    pub(crate) centre: f64,
    /// Superellipse exponent of the front and the back half (2 is an ellipse).
    pub(crate) squareness: [f64; 2],
}

const fn ring(
    y: [f64; 3],
    half_breadth: f64,
    front: f64,
    back: f64,
    centre: f64,
    squareness: [f64; 2],
) -> Loop {
    Loop { y, half_breadth, front, back, centre, squareness }
}

/// Crown to neck border.
pub(super) const LOOPS: [Loop; 16] = [
    ring([133.5; 3], 0.0, -4.0, -4.0, -4.0, [2.0, 2.0]),
    ring([128.5; 3], 27.0, 29.0, -40.0, -6.0, [2.0, 2.0]),
    ring([114.0; 3], 52.0, 69.0, -66.0, -6.0, [2.0, 2.1]),
    ring([94.0; 3], 67.0, 88.5, -81.5, -7.0, [2.0, 2.2]),
    ring([70.0; 3], 74.0, 98.5, -89.5, -8.0, [2.0, 2.2]),
    ring([46.0; 3], 76.0, 102.0, -91.5, -8.0, [1.97, 2.2]),
    ring([24.0; 3], 74.0, 93.0, -89.0, -6.0, [2.3, 2.15]),
    ring([1.0; 3], 69.8, 91.0, -82.0, -2.0, [2.45, 2.1]),
    ring([-28.0, -27.0, -24.0], 66.5, 94.0, -71.0, 0.0, [2.3, 2.1]),
    ring([-50.0, -46.0, -40.0], 62.5, 93.5, -67.0, 2.0, [2.05, 2.1]),
    ring([-67.0, -58.0, -52.0], 57.5, 88.0, -66.0, 2.0, [1.75, 2.05]),
    ring([-85.0, -69.0, -62.0], 53.5, 80.0, -66.0, 0.0, [1.65, 2.0]),
    ring([-95.0, -79.0, -72.0], 51.0, 46.0, -66.5, -5.0, [1.8, 2.0]),
    ring([-105.0, -94.0, -86.0], 52.0, 29.0, -68.5, -14.0, [2.0, 2.0]),
    ring([-128.0, -122.0, -112.0], 55.5, 26.0, -77.0, -22.0, [2.0, 2.0]),
    ring([-160.0, -154.0, -145.0], 60.0, 24.0, -87.0, -29.0, [2.0, 2.0]),
];

/// A Gaussian displacement of the loft along its normal, outward or (negative height) inward.
#[derive(Debug, Clone)]
pub(crate) struct Mound {
    /// The anatomical region.
    pub(crate) name: &'static str,
    /// Centre; mirrored to the other side.
    pub(crate) at: [f64; 3],
    /// Standard deviations along the axes.
    pub(crate) sigma: [f64; 3],
    pub(crate) height: f64,
}

const fn mound(name: &'static str, at: [f64; 3], sigma: [f64; 3], height: f64) -> Mound {
    Mound { name, at, sigma, height }
}

/// Displacements of the loft that give the planes of the face.
pub(super) const MOUNDS: [Mound; 24] = [
    mound("brow", [26.0, 40.0, 98.0], [12.0, 6.0, 20.0], 1.5),
    mound("brow", [45.0, 38.0, 86.0], [9.0, 7.0, 20.0], 4.5),
    mound("frontal eminence", [26.0, 78.0, 94.0], [16.0, 16.0, 30.0], 1.0),
    mound("temple", [70.0, 34.0, 44.0], [20.0, 24.0, 18.0], -2.5),
    mound("upper lid", [33.0, 32.5, 88.0], [14.0, 4.5, 30.0], 3.4),
    mound("orbit", [15.0, 21.0, 90.0], [5.0, 7.0, 30.0], -3.5),
    mound("lid floor", [31.0, 9.5, 86.0], [13.0, 5.0, 20.0], 0.9),
    mound("cheek", [48.0, 2.0, 76.0], [14.0, 12.0, 22.0], 3.2),
    mound("zygoma", [64.0, 6.0, 50.0], [14.0, 12.0, 18.0], 2.5),
    mound("jowl", [52.0, -22.0, 62.0], [14.0, 16.0, 22.0], 2.0),
    mound("canine", [21.0, -12.0, 88.0], [7.0, 10.0, 20.0], -1.0),
    mound("nasolabial", [27.0, -38.0, 86.0], [4.0, 9.0, 20.0], -0.8),
    mound("muzzle", [0.0, -42.0, 95.0], [13.0, 13.0, 30.0], 1.2),
    mound("mouth corner", [24.0, -50.0, 84.0], [7.0, 7.5, 20.0], -3.8),
    mound("sublabial", [0.0, -66.0, 88.0], [14.0, 5.0, 20.0], -1.5),
    mound("chin", [0.0, -76.0, 88.0], [13.0, 8.0, 20.0], 2.4),
    mound("chin side", [20.0, -72.0, 76.0], [7.0, 9.0, 20.0], -1.0),
    mound("jaw angle", [54.0, -58.0, 22.0], [12.0, 13.0, 16.0], 3.5),
    mound("under jaw", [40.0, -86.0, 34.0], [17.0, 8.0, 20.0], -4.0),
    mound("behind jaw", [56.0, -56.0, -14.0], [14.0, 24.0, 10.0], -5.0),
    mound("mastoid", [64.0, -22.0, -22.0], [12.0, 12.0, 10.0], 1.5),
    mound("sternomastoid", [44.0, -112.0, 2.0], [12.0, 26.0, 10.0], 2.5),
    mound("larynx", [0.0, -122.0, 28.0], [9.0, 11.0, 16.0], 2.5),
    mound("nape", [0.0, -75.0, -68.0], [14.0, 34.0, 20.0], -2.0),
];
