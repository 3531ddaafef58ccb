//! Parts of a template that no data reach (eyeballs, teeth, lashes) go along with the skin.

use super::matching::Found;
use crate::data::{Mesh, Topology};
use crate::math::{Vec3, fit_similarity};
use crate::spatial::PointIndex;

/// Skin vertices that carry each vertex' part along.
const NEIGHBOURS: usize = 8;

/// Moves every part without matches by the similarity that the nearest vertices of matched parts
/// went through.
pub(super) fn carry_along(rest: &Mesh, bent: &mut Mesh, found: &[Found]) {
    let part = Topology::new(rest).components();
    let count = part.iter().max().map_or(0, |m| *m as usize + 1);
    let mut matches = vec![0usize; count];
    found.iter().for_each(|f| matches[part[f.corners[0]] as usize] += 1);
    // a few stray points do not measure a part
    let measured = |p: u32| matches[p as usize] * 50 >= found.len();
    if count < 2 || (0..count as u32).all(measured) {
        return;
    }
    let skin: Vec<usize> = (0..part.len()).filter(|&v| measured(part[v])).collect();
    let places: Vec<Vec3> = skin.iter().map(|&v| rest.vertices[v]).collect();
    let Some(index) = PointIndex::<3>::new(&places) else { return };
    for p in (0..count as u32).filter(|&p| !measured(p)) {
        let members: Vec<usize> = (0..part.len()).filter(|&v| part[v] == p).collect();
        let mut carriers: Vec<usize> = members
            .iter()
            .flat_map(|&v| index.nearest_n(&rest.vertices[v].into(), NEIGHBOURS))
            .map(|near| skin[near.index])
            .collect();
        carriers.sort_unstable();
        carriers.dedup();
        let from: Vec<Vec3> = carriers.iter().map(|&v| rest.vertices[v]).collect();
        let to: Vec<Vec3> = carriers.iter().map(|&v| bent.vertices[v]).collect();
        let Some(motion) = fit_similarity(&from, &to, &[], true) else { continue };
        for v in members {
            bent.vertices[v] = motion.apply(&rest.vertices[v]);
        }
    }
}
