//! Meshes for tests: open and closed grids of quads, each quad two triangles.

use super::Mesh;
use crate::math::Vec3;

/// An open grid of `columns` x `rows` vertices at `place(column, row)`.
pub(crate) fn open_grid(columns: u32, rows: u32, place: impl Fn(f64, f64) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    for y in 0..rows {
        for x in 0..columns {
            mesh.vertices.push(place(f64::from(x), f64::from(y)));
        }
    }
    for y in 0..rows - 1 {
        for x in 0..columns - 1 {
            let i = y * columns + x;
            mesh.faces.push([i, i + 1, i + columns]);
            mesh.faces.push([i + 1, i + columns + 1, i + columns]);
        }
    }
    mesh
}

/// A closed surface of `rings` + 1 rings of `around` vertices at `place(direction)`, poles up and
/// down.
pub(crate) fn closed_grid(rings: u32, around: u32, place: impl Fn(Vec3) -> Vec3) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..=rings {
        let polar = std::f64::consts::PI * f64::from(i) / f64::from(rings);
        for j in 0..around {
            let turn = std::f64::consts::TAU * f64::from(j) / f64::from(around);
            let direction =
                Vec3::new(polar.sin() * turn.sin(), polar.cos(), polar.sin() * turn.cos());
            mesh.vertices.push(place(direction));
        }
    }
    for i in 0..rings {
        for j in 0..around {
            let (a, b) = (i * around + j, i * around + (j + 1) % around);
            mesh.faces.push([a, a + around, b]);
            mesh.faces.push([b, a + around, b + around]);
        }
    }
    mesh
}

/// An ellipsoid with a bump for a nose, model frame, mm.
pub(crate) fn dummy_head(rings: u32, around: u32) -> Mesh {
    closed_grid(rings, around, |d| {
        let (x, y, z) = (d.x, d.y, d.z);
        let nose = 25.0 * (-(x * x * 40.0 + y * y * 18.0)).exp() * f64::from(z > 0.0);
        Vec3::new(75.0 * x, 110.0 * y, 90.0 * z + nose)
    })
}
