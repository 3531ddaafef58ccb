//! Computes the figures that a verdict rests on, from the result alone.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::norms::{NORMS, Norm};
use super::outcome::VerdictFigures;
use crate::data::LANDMARKS;
use crate::math::{Vec3, median};
use crate::pipeline::{FaceLandmark, LandmarkStatus, Reconstruction};
use crate::spatial::SurfaceIndex;

/// The face reaches from the level of the ears this far toward the nose tip, as a fraction of the
/// depth between them: cheeks are in it, temples and ears are not.
const FACE_DEPTH: f64 = 0.35;
/// Points and vertices of which distances are measured; more give the same medians.
const SAMPLES: usize = 3000;
/// A point farther from the next landmark is of no region: neck, hair, clothing, wall.
const REGION_MM: f64 = 40.0;
/// Measured area counts for a region within this distance of its landmarks.
const REGION_CORE_MM: f64 = 25.0;
/// Least number of distances that determine a size.
const MIN_DISTANCES: usize = 3;
/// A landmark farther from its vertex, mm, is not followed by the mesh; at most 1.6 on captures with
/// known truth.
const LANDMARK_OFF_MM: f64 = 4.0;
/// The same in standard deviations of the landmark.
const LANDMARK_OFF_SIGMAS: f64 = 3.0;

/// Computes the figures of a result.
pub(super) fn figures_of(found: &Reconstruction) -> VerdictFigures {
    let landmarks = found.face_landmarks();
    let count = |status| landmarks.iter().filter(|l| l.status == status).count();
    let scores: Vec<f64> = found.matches.iter().map(|m| m.score).collect();
    let distances = measured_distances(found);
    let offsets = measured_offsets(found, &landmarks);
    let mut figures = VerdictFigures {
        landmarks_found: count(LandmarkStatus::Found),
        landmarks_marked: count(LandmarkStatus::Marked),
        proportions_sd: distances.iter().map(|(n, mm)| (n.name, n.excess(*mm))).collect(),
        size_sd: size(&distances),
        matched_share: Some(
            found.matches.len() as f64 / found.dots[0].min(found.dots[1]).max(1) as f64,
        ),
        landmark_offset_mm: median(&offsets.iter().map(|o| o.1).collect::<Vec<_>>()),
        landmarks_off_mm: offsets
            .iter()
            .filter(|(l, distance)| is_off(l, *distance))
            .map(|(l, distance)| (l.term.name, *distance))
            .collect(),
        match_score: median(&scores),
        row_offset_px: found.rows.offset_px,
        blur_difference: found.blur_difference,
        dots_before_eyes: found.dots_before_eyes,
        ..VerdictFigures::default()
    };
    if let Some(pose) = &found.registration {
        let camera_from_model = found.model_from_camera.inverse();
        // camera axes: y down, z away from the camera
        let up = camera_from_model.rotate(&Vec3::y());
        let toward = camera_from_model.rotate(&Vec3::z());
        figures.roll_deg = Some(up.x.atan2(-up.y).to_degrees().abs());
        figures.turn_deg = Some((-toward.z).clamp(-1.0, 1.0).acos().to_degrees());
        figures.registration_rms_mm = Some(pose.rms_after);
        figures.registration_growth =
            (pose.rms_before > 0.0).then(|| pose.rms_after / pose.rms_before);
        let matches = found.matches.len().max(1);
        figures.registration_share = Some(pose.inliers.len() as f64 / matches as f64);
    }
    if let Some(face) = FaceFrame::new(found) {
        let triangles = face.triangles(found);
        figures.measured_share = FaceFrame::measured_share(&triangles);
        figures.nose_protrusion_mm = face.nose_protrusion();
        figures.nose_relief = figures.nose_protrusion_mm.map(|mm| mm / face.biocular_width());
        figures.measured_region = face.measured_regions(&triangles);
        if let Some(surface) = SurfaceIndex::new(&found.mesh) {
            figures.asymmetry_mm = face.asymmetry(found, &surface);
            figures.residual_mm = face.residuals(found, &surface);
        }
    }
    figures
}

/// The measured distances that have a norm, mm.
fn measured_distances(found: &Reconstruction) -> Vec<(&'static Norm, f64)> {
    let distances = found.face_distances();
    let of_norm = |norm: &'static Norm| {
        let distance = distances.iter().find(|d| d.is_measured && d.term.name == norm.name)?;
        Some((norm, distance.value_mm))
    };
    NORMS.iter().filter_map(of_norm).collect()
}

/// Mean deviation of the measured distances from those of adults, standard deviations.
fn size(distances: &[(&Norm, f64)]) -> Option<f64> {
    let deviations = distances.iter().map(|(norm, mm)| (mm - norm.adult_mm) / norm.adult_sd_mm);
    (distances.len() >= MIN_DISTANCES).then(|| deviations.sum::<f64>() / distances.len() as f64)
}

/// The measured landmarks with the distances of their vertices from them.
fn measured_offsets<'a>(
    found: &Reconstruction,
    landmarks: &'a [FaceLandmark],
) -> Vec<(&'a FaceLandmark, f64)> {
    let offset = |l: &'a FaceLandmark| {
        let vertex = found.mesh.vertices.get(l.vertex?)?;
        l.status.is_measured().then(|| (l, (vertex - l.in_model).norm()))
    };
    landmarks.iter().filter_map(offset).collect()
}

/// Whether the mesh does not follow a landmark whose vertex is this far from it.
fn is_off(landmark: &FaceLandmark, distance: f64) -> bool {
    distance > LANDMARK_OFF_MM.max(LANDMARK_OFF_SIGMAS * landmark.sigma)
}

/// A triangle of the face.
struct FaceTriangle {
    /// Model frame.
    middle: Vec3,
    /// Twice its area, and as much of it as its corners were measured, mm^2.
    area: f64,
    measured_area: f64,
}

/// The landmarks' vertices on the mesh, model frame.
struct FaceFrame {
    places: BTreeMap<&'static str, Vec3>,
}

impl FaceFrame {
    /// `None` without all landmarks of the mesh.
    fn new(found: &Reconstruction) -> Option<Self> {
        let place = |name: &'static str| {
            Some((name, *found.mesh.vertices.get(*found.landmarks.get(name)?)?))
        };
        let places = LANDMARKS.iter().map(|n| place(n)).collect::<Option<_>>()?;
        Some(Self { places })
    }

    fn at(&self, name: &str) -> Vec3 {
        self.places.get(name).copied().unwrap_or_default()
    }

    /// Whether a position (model frame) is in the face.
    fn contains(&self, p: &Vec3) -> bool {
        let ears = 0.5 * (self.at("ear_left_upper").z + self.at("ear_right_upper").z);
        let front = ears + FACE_DEPTH * (self.at("nose_tip").z - ears);
        p.z > front && p.y > self.at("chin").y && p.y < self.at("forehead").y
    }

    fn measured_share(triangles: &[FaceTriangle]) -> Option<f64> {
        let all: f64 = triangles.iter().map(|t| t.area).sum();
        let measured: f64 = triangles.iter().map(|t| t.measured_area).sum();
        (all > 0.0).then(|| measured / all)
    }

    /// Share of the area that was measured, by region.
    fn measured_regions(&self, triangles: &[FaceTriangle]) -> BTreeMap<&'static str, f64> {
        let mut areas: BTreeMap<&'static str, [f64; 2]> = BTreeMap::new();
        for triangle in triangles {
            let Some(region) = self.region(&triangle.middle, REGION_CORE_MM) else { continue };
            let sums = areas.entry(region).or_default();
            sums[0] += triangle.measured_area;
            sums[1] += triangle.area;
        }
        let shares = areas.into_iter().filter(|(_, [_, all])| *all > 0.0);
        shares.map(|(region, [known, all])| (region, known / all)).collect()
    }

    /// The triangles of the face; none where nothing is known about the mesh's uncertainty.
    fn triangles(&self, found: &Reconstruction) -> Vec<FaceTriangle> {
        let mesh = &found.mesh;
        if !mesh.has_uncertainty() {
            return Vec::new();
        }
        let triangle = |face: &[u32; 3]| {
            let corners = face.map(|i| mesh.vertices[i as usize]);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let area = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).norm();
            let known = face.iter().filter(|i| mesh.measured[**i as usize]).count();
            FaceTriangle { middle, area, measured_area: area * known as f64 / 3.0 }
        };
        mesh.faces.iter().map(triangle).filter(|t| self.contains(&t.middle)).collect()
    }

    fn biocular_width(&self) -> f64 {
        (self.at("eye_left_outer") - self.at("eye_right_outer")).norm()
    }

    fn nose_protrusion(&self) -> Option<f64> {
        let [a, b] = [self.at("eye_left_outer"), self.at("eye_right_outer")];
        let [c, d] = [self.at("mouth_left"), self.at("mouth_right")];
        // the diagonals of the four corners span the plane that fits them
        let normal = (b - c).cross(&(a - d)).try_normalize(1e-9)?;
        let forward = if normal.z < 0.0 { -normal } else { normal };
        Some(forward.dot(&(self.at("nose_tip") - (a + b + c + d) / 4.0)))
    }

    /// Median distance of the measured face from its mirror image.
    fn asymmetry(&self, found: &Reconstruction, surface: &SurfaceIndex) -> Option<f64> {
        let mesh = &found.mesh;
        let pairs: Vec<(Vec3, Vec3)> = LANDMARKS
            .iter()
            .filter(|name| name.contains("left"))
            .map(|name| (self.at(name), self.at(&name.replace("left", "right"))))
            .collect();
        let across: Vec3 = pairs.iter().map(|(l, r)| r - l).sum();
        let normal = across.try_normalize(1e-9)?;
        let middle: Vec3 =
            pairs.iter().map(|(l, r)| (l + r) / 2.0).sum::<Vec3>() / pairs.len() as f64;
        let is_used = |v: &usize| {
            mesh.measured.get(*v).copied().unwrap_or(false) && self.contains(&mesh.vertices[*v])
        };
        let used: Vec<usize> = (0..mesh.vertices.len()).filter(is_used).collect();
        let distances: Vec<f64> = sampled(&used)
            .into_par_iter()
            .filter_map(|v| {
                let p = mesh.vertices[v];
                let mirrored = p - normal * (2.0 * normal.dot(&(p - middle)));
                surface.closest(&mirrored).map(|c| c.distance)
            })
            .collect();
        median(&distances)
    }

    /// Median distance of the measured points from the mesh, by the region of the nearest landmark.
    fn residuals(
        &self,
        found: &Reconstruction,
        surface: &SurfaceIndex,
    ) -> BTreeMap<&'static str, f64> {
        let points: Vec<usize> = (0..found.cloud.len()).collect();
        let distances: Vec<(&'static str, f64)> = sampled(&points)
            .into_par_iter()
            .filter_map(|i| {
                let p = found.model_from_camera.apply(&found.cloud.points[i]);
                Some((self.region(&p, REGION_MM)?, surface.closest(&p)?.distance))
            })
            .collect();
        let mut regions: BTreeMap<&'static str, Vec<f64>> = BTreeMap::new();
        for (region, distance) in distances {
            regions.entry(region).or_default().push(distance);
        }
        regions.into_iter().filter_map(|(name, all)| Some((name, median(&all)?))).collect()
    }

    /// Region of the landmark nearest to a position, if it is nearer than `reach_mm`.
    fn region(&self, p: &Vec3, reach_mm: f64) -> Option<&'static str> {
        let far = |a: &Vec3| (a - p).norm_squared();
        let (nearest, place) = self.places.iter().min_by(|a, b| far(a.1).total_cmp(&far(b.1)))?;
        if far(place) > reach_mm.powi(2) {
            return None;
        }
        Some(match *nearest {
            "chin" => "chin",
            "forehead" => "forehead",
            name if name.starts_with("eye") => "eyes",
            name if name.starts_with("ear") => "ears",
            name if name.starts_with("mouth") => "mouth",
            _ => "nose",
        })
    }
}

/// Evenly spaced entries, about [`SAMPLES`] of them.
fn sampled(all: &[usize]) -> Vec<usize> {
    all.iter().copied().step_by(all.len().div_ceil(SAMPLES).max(1)).collect()
}
