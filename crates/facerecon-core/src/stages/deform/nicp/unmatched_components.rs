//! Components of a template without data (eyeballs, teeth, lashes) move with the skin around them.

use super::surface_match::SurfaceMatch;
use crate::data::{Mesh, Topology};
use crate::math::{Vec3, fit_similarity};
use crate::spatial::PointIndex;

/// Nearest skin vertices of each vertex of a component whose motion it follows.
const NEIGHBOURS: usize = 8;
/// A component is matched when it has at least one in so many of the matches: a few stray points do
/// not measure it.
const MATCHES_PER_COMPONENT_MATCH: usize = 50;

/// Moves every component without matches by the similarity that the nearest vertices of matched
/// components went through.
pub(super) fn move_unmatched_components(rest: &Mesh, bent: &mut Mesh, matches: &[SurfaceMatch]) {
    let component = Topology::new(rest).components();
    let count = component.iter().max().map_or(0, |m| *m as usize + 1);
    let mut own_matches = vec![0usize; count];
    matches.iter().for_each(|m| own_matches[component[m.corners[0]] as usize] += 1);
    let is_matched =
        |c: u32| own_matches[c as usize] * MATCHES_PER_COMPONENT_MATCH >= matches.len();
    if count < 2 || (0..count as u32).all(is_matched) {
        return;
    }
    let skin: Vec<usize> = (0..component.len()).filter(|&v| is_matched(component[v])).collect();
    let positions: Vec<Vec3> = skin.iter().map(|&v| rest.vertices[v]).collect();
    let Some(index) = PointIndex::<3>::new(&positions) else { return };
    for c in (0..count as u32).filter(|&c| !is_matched(c)) {
        let members: Vec<usize> = (0..component.len()).filter(|&v| component[v] == c).collect();
        let mut around: Vec<usize> = members
            .iter()
            .flat_map(|&v| index.nearest_n(&rest.vertices[v].into(), NEIGHBOURS))
            .map(|near| skin[near.index])
            .collect();
        around.sort_unstable();
        around.dedup();
        let from: Vec<Vec3> = around.iter().map(|&v| rest.vertices[v]).collect();
        let to: Vec<Vec3> = around.iter().map(|&v| bent.vertices[v]).collect();
        let Some(motion) = fit_similarity(&from, &to, &[], true) else { continue };
        for v in members {
            bent.vertices[v] = motion.apply(&rest.vertices[v]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::surface_match::fixtures::{match_at, sheet};
    use super::*;

    /// A curved skin of 100 vertices with an eyeball of 9 behind it.
    fn skin_with_eyeball() -> Mesh {
        let mut mesh = sheet(10, 1.0);
        mesh.vertices.iter_mut().for_each(|v| v.z = 0.1 * (v.x - 4.5).powi(2));
        let eyeball = sheet(3, 1.0);
        mesh.vertices.extend(eyeball.vertices.iter().map(|p| p + Vec3::new(3.0, 3.0, -2.0)));
        mesh.faces.extend(eyeball.faces.iter().map(|f| f.map(|i| i + 100)));
        mesh
    }

    #[test]
    fn an_eyeball_without_matches_follows_the_skin_around_it() {
        let rest = skin_with_eyeball();
        let motion = |p: &Vec3| p * 1.1 + Vec3::new(2.0, 0.0, 5.0);
        let mut bent = rest.clone();
        bent.vertices[..100].iter_mut().for_each(|v| *v = motion(v));
        let mut matches: Vec<SurfaceMatch> =
            (0..100).map(|v| match_at(&rest, v, rest.vertices[v])).collect();
        // a single stray point does not measure the eyeball
        matches.push(match_at(&rest, 104, Vec3::zeros()));
        move_unmatched_components(&rest, &mut bent, &matches);
        for v in 100..109 {
            assert!((bent.vertices[v] - motion(&rest.vertices[v])).norm() < 1e-9);
        }
        // with its own matches it stays where they have moved it
        matches.extend((100..109).map(|v| match_at(&rest, v, rest.vertices[v])));
        let mut measured = rest.clone();
        measured.vertices[..100].iter_mut().for_each(|v| *v = motion(v));
        move_unmatched_components(&rest, &mut measured, &matches);
        assert_eq!(measured.vertices[100..], rest.vertices[100..]);
    }
}
