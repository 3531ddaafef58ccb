//! Which faces share an edge.

/// No face, no node.
pub(super) const NONE: u32 = u32::MAX;

/// For each face its neighbours across the edges 0-1, 1-2, 2-0; [`NONE`] on the border.
pub(super) fn neighbours(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut edges: Vec<(u32, u32, u32, u8)> = Vec::with_capacity(3 * faces.len());
    for (number, face) in faces.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            edges.push((a.min(b), a.max(b), number as u32, k as u8));
        }
    }
    edges.sort_unstable();
    let mut out = vec![[NONE; 3]; faces.len()];
    for pair in edges.windows(2) {
        let ((a, b, f, i), (c, d, g, j)) = (pair[0], pair[1]);
        if (a, b) == (c, d) {
            out[f as usize][i as usize] = g;
            out[g as usize][j as usize] = f;
        }
    }
    out
}
