//! Puts more into the scene of a made-up person: a second one, or things with one colour.

use super::Person;
use crate::data::{Mesh, Raster, Rgb};
use crate::math::Vec3;

/// Width of the part of a texture that has one colour, texels.
const COLOUR_PX: usize = 8;

impl Person {
    /// With a mesh of one sRGB colour, in the frame of the head; it is not part of the face.
    pub fn with_part(&self, part: &Mesh, color: [u8; 3]) -> Self {
        let mut mesh = part.clone();
        mesh.uvs = vec![[0.5, 0.5]];
        mesh.face_uvs = vec![[0; 3]; mesh.faces.len()];
        self.joined(&mesh, &Raster::filled(COLOUR_PX, COLOUR_PX, color))
    }

    /// With another person, moved by `shift` (frame of the head, mm), whose face does not count as
    /// the face.
    pub fn with_neighbour(&self, other: &Self, shift: Vec3) -> Self {
        let mesh = &other.head.mesh;
        let moved = mesh.with_vertices(mesh.vertices.iter().map(|v| v + shift).collect());
        self.joined(&moved, &other.skin)
    }

    /// With a mesh and its texture: both textures are put side by side.
    fn joined(&self, other: &Mesh, texture: &Rgb) -> Self {
        let mut joined = self.clone();
        let (mesh, n) = (&mut joined.head.mesh, self.head.mesh.vertices.len() as u32);
        mesh.vertices.extend(&other.vertices);
        mesh.faces.extend(other.faces.iter().map(|f| f.map(|i| i + n)));
        joined.face.resize(mesh.vertices.len(), false);

        let (left, right) = (self.skin.width(), texture.width());
        let height = self.skin.height().max(texture.height());
        joined.skin = Raster::from_fn(left + right, height, |x, y| {
            let (from, x) = if x < left { (&self.skin, x) } else { (texture, x - left) };
            // v = 0 is the lower border; above a texture its upper row is repeated
            let up = (height - 1 - y).min(from.height() - 1);
            from.at(x, from.height() - 1 - up)
        });
        let (width, tall) = ((left + right) as f64, height as f64);
        let own = [left as f64 / width, self.skin.height() as f64 / tall];
        let its = [right as f64 / width, texture.height() as f64 / tall];
        let m = mesh.uvs.len() as u32;
        mesh.uvs.iter_mut().for_each(|uv| *uv = [uv[0] * own[0], uv[1] * own[1]]);
        mesh.uvs.extend(other.uvs.iter().map(|uv| [own[0] + uv[0] * its[0], uv[1] * its[1]]));
        mesh.face_uvs.extend(other.face_uvs.iter().map(|f| f.map(|i| i + m)));
        joined
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::sample_texture;

    #[test]
    fn every_face_keeps_its_colour() {
        let (one, two) = (Person::new(1), Person::new(2));
        let both = one.with_neighbour(&two, Vec3::new(150.0, 0.0, 0.0));
        let triangle = Mesh {
            vertices: vec![Vec3::zeros(), Vec3::x(), Vec3::y()],
            faces: vec![[0, 1, 2]],
            ..Mesh::default()
        };
        let all = both.with_part(&triangle, [9, 200, 30]);
        assert!(all.head.mesh.validate().is_ok());
        assert_eq!(all.face.len(), all.head.mesh.vertices.len());
        assert_eq!(
            all.face.iter().filter(|f| **f).count(),
            one.face.iter().filter(|f| **f).count()
        );
        let colour = |person: &Person, face: usize| {
            let uv = person.head.mesh.face_uvs[face].map(|i| person.head.mesh.uvs[i as usize]);
            sample_texture(&person.skin, [0, 1].map(|k| (uv[0][k] + uv[1][k] + uv[2][k]) / 3.0))
        };
        let n = one.head.mesh.faces.len();
        for face in (0..n).step_by(997) {
            for (person, index) in [(&one, face), (&two, n + face)] {
                let (expected, found) = (colour(person, face), colour(&all, index));
                let off = (0..3).map(|k| (expected[k] - found[k]).abs()).fold(0.0, f64::max);
                assert!(off < 1.0, "face {index}: {found:?}, expected {expected:?}");
            }
        }
        let last = all.head.mesh.faces.len() - 1;
        assert_eq!(colour(&all, last).map(f64::round), [9.0, 200.0, 30.0]);
    }
}
