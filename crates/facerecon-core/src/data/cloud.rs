//! Clouds of measured points.

use crate::math::{Similarity, Vec3};

/// Points in space with their measured properties. Optional lists are empty or as long as
/// `points`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// Positions, millimetres (or model units for an unknown rig).
    pub points: Vec<Vec3>,
    /// Unit normals, toward the cameras.
    pub normals: Vec<Vec3>,
    /// sRGB colour.
    pub colors: Vec<[u8; 3]>,
    /// Standard deviations along the line of sight, in the unit of the points.
    pub sigmas: Vec<f64>,
}

impl Cloud {
    /// A cloud of positions only.
    pub fn from_points(points: Vec<Vec3>) -> Self {
        Self { points, ..Self::default() }
    }

    /// Number of points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no point.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The cloud in another frame.
    pub fn transformed(&self, target_from_source: &Similarity) -> Self {
        Self {
            points: self.points.iter().map(|p| target_from_source.apply(p)).collect(),
            normals: self.normals.iter().map(|n| target_from_source.rotate(n)).collect(),
            colors: self.colors.clone(),
            sigmas: self.sigmas.iter().map(|s| s * target_from_source.scale).collect(),
        }
    }

    /// Keeps the points of which `keep` (number and position) is true, with their properties.
    pub fn retain(&mut self, keep: impl Fn(usize, &Vec3) -> bool) {
        let kept: Vec<bool> = self.points.iter().enumerate().map(|(i, p)| keep(i, p)).collect();
        fn filter<T>(values: &mut Vec<T>, kept: &[bool]) {
            let mut flags = kept.iter();
            values.retain(|_| flags.next().copied().unwrap_or(true));
        }
        filter(&mut self.points, &kept);
        filter(&mut self.normals, &kept);
        filter(&mut self.colors, &kept);
        filter(&mut self.sigmas, &kept);
    }

    /// Smallest and largest coordinates; `None` for an empty cloud.
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.points.first()?;
        Some(self.points.iter().fold((first, first), |(lo, hi), p| (lo.inf(p), hi.sup(p))))
    }
}

/// The frame of a cloud of points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CloudFrame {
    /// The camera frame, millimetres.
    Metric,
    /// The camera frame, in an unknown unit.
    Camera,
    /// Approximately the model frame, in its unit.
    Model,
}

impl CloudFrame {
    /// Whether lengths are millimetres.
    pub fn is_metric(self) -> bool {
        self == Self::Metric
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_kept_with_their_properties() {
        let mut cloud = Cloud::from_points(vec![Vec3::x(), Vec3::y(), Vec3::z()]);
        cloud.sigmas = vec![1.0, 2.0, 3.0];
        cloud.retain(|i, p| i != 0 && p.z == 0.0);
        assert_eq!((cloud.points, cloud.sigmas), (vec![Vec3::y()], vec![2.0]));
        assert!(cloud.normals.is_empty() && cloud.colors.is_empty());
    }
}
