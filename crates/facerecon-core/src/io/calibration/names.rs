//! Names that calibration programs give to the matrices, normalised as by [`normalised`] and
//! separated by blanks. Earlier names take precedence.

pub(super) const LEFT_K: &str = "k1 m1 cameramatrix1 cameramatrixleft cameramatrixl \
    leftcameramatrix kleft kl leftk mtx1 mtxl mtxleft leftmtx intrinsics1 intrinsicsleft \
    leftintrinsics intrinsicmatrix1 intrinsicmatrixleft a1 camera1matrix";
pub(super) const RIGHT_K: &str = "k2 m2 cameramatrix2 cameramatrixright cameramatrixr \
    rightcameramatrix kright kr rightk mtx2 mtxr mtxright rightmtx intrinsics2 intrinsicsright \
    rightintrinsics intrinsicmatrix2 intrinsicmatrixright a2 camera2matrix";
pub(super) const LEFT_D: &str = "d1 distcoeffs1 distcoeffsleft distcoeffsl leftdistcoeffs dist1 \
    distl distleft leftdist dleft dl leftd distcoef1 distcoeff1 distcoeffleft distortion1 \
    distortionleft leftdistortion distortioncoefficients1 distortioncoefficientsleft \
    leftdistortioncoefficients kc1";
pub(super) const RIGHT_D: &str = "d2 distcoeffs2 distcoeffsright distcoeffsr rightdistcoeffs dist2 \
    distr distright rightdist dright dr rightd distcoef2 distcoeff2 distcoeffright distortion2 \
    distortionright rightdistortion distortioncoefficients2 distortioncoefficientsright \
    rightdistortioncoefficients kc2";
pub(super) const ROTATION: &str = "r rot rotation rotationmatrix rmat stereor om";
pub(super) const TRANSLATION: &str = "t trans translation translationvector tvec stereot tvector";
pub(super) const UNIT: &str = "unit units tunit translationunit lengthunit";
pub(super) const IMAGE_SIZE: &str = "imagesize size imgsize resolution imageshape";
pub(super) const LENS_MODEL: &str = "distortionmodel cameramodel model lensmodel";
/// Lens models that are not a pinhole with radial and tangential distortion.
pub(super) const FISHEYE_MODELS: [&str; 4] = ["fisheye", "equidistant", "omni", "mei"];

/// A name in lower case, without `_`, `-` and blanks.
pub(super) fn normalised(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).flat_map(char::to_lowercase).collect()
}
