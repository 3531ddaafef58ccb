//! Laplacian steps, alone or in pairs (thesis section 4.3; Taubin 1995).

use rayon::prelude::*;

use super::{SmoothError, SmoothParams};
use crate::data::{Mesh, Topology};
use crate::math::Vec3;
use crate::observer::{Event, Observer};

/// Steps with factor lambda, each followed by one with `mu` when given. Returns the vertices and
/// the mean movement of a vertex in each step.
pub(super) fn smooth(
    mesh: &Mesh,
    params: &SmoothParams,
    mu: Option<f64>,
    observer: &dyn Observer,
) -> Result<(Vec<Vec3>, Vec<f64>), SmoothError> {
    let topology = Topology::new(mesh);
    let free = |i: usize| !(params.keep_border && topology.border[i]);
    let mut vertices = mesh.vertices.clone();
    let mut movement = Vec::new();
    for step in 1..=params.steps {
        observer.check()?;
        let mut next = apply(&vertices, &topology, params.lambda, free);
        if let Some(mu) = mu {
            next = apply(&next, &topology, mu, free);
        }
        let moved = vertices.iter().zip(&next).map(|(a, b)| (a - b).norm()).sum::<f64>()
            / vertices.len() as f64;
        vertices = next;
        movement.push(moved);
        observer.event(&Event::Iteration { stage: "smooth", step, error: moved });
        if moved < params.threshold {
            break;
        }
    }
    Ok((vertices, movement))
}

/// One step: each free vertex moves toward the mean of its neighbours.
fn apply(
    vertices: &[Vec3],
    topology: &Topology,
    factor: f64,
    free: impl Fn(usize) -> bool + Sync,
) -> Vec<Vec3> {
    (0..vertices.len())
        .into_par_iter()
        .map(|i| {
            let near = &topology.neighbours[i];
            if near.is_empty() || !free(i) {
                return vertices[i];
            }
            let sum: Vec3 = near.iter().map(|&j| vertices[j as usize] - vertices[i]).sum();
            let delta = sum / near.len() as f64; // Eq. 4.9
            vertices[i] + delta * factor // Eq. 4.10
        })
        .collect()
}
