//! The stored part of the built-in head: chart positions of its vertices, texture coordinates and
//! triangles. Vertex positions in space are computed by the sculpt.

use nalgebra::Vector2;

/// Names of the landmarks in the order they are stored; `{}` stands for the side.
pub const HALF_LANDMARKS: [&str; 12] = [
    "forehead",
    "nose_saddle",
    "nose_tip",
    "mouth_up",
    "mouth_down",
    "chin",
    "eye_{}_inner",
    "eye_{}_outer",
    "mouth_{}",
    "ala_{}",
    "ear_{}_upper",
    "ear_{}_lower",
];

/// One half (x >= 0) of a head.
#[derive(Debug, Clone, PartialEq)]
pub struct HalfHead {
    /// Number of vertices on the midline. They come first, in order from the front of the neck
    /// over the crown to the back of the neck.
    pub midline: usize,
    /// Position of each vertex in the chart of the sculpt.
    pub q: Vec<Vector2<f64>>,
    /// Texture coordinates of each vertex.
    pub uv: Vec<[f64; 2]>,
    /// Triangles, counter-clockwise from outside.
    pub faces: Vec<[u32; 3]>,
    /// Vertices of [`HALF_LANDMARKS`].
    pub landmarks: Vec<usize>,
}

/// Reads little-endian numbers one after the other; reads zero past the end.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let Some((head, tail)) = self.0.split_first_chunk::<N>() else { return [0; N] };
        self.0 = tail;
        *head
    }
    fn u16(&mut self) -> usize {
        u16::from_le_bytes(self.take()).into()
    }
    fn f32(&mut self) -> f64 {
        f32::from_le_bytes(self.take()).into()
    }
}

impl HalfHead {
    /// Reads the stored form: 16 bit counts (vertices, midline, faces), then q and uv as 32 bit
    /// floats, faces and landmarks as 16 bit numbers, all little endian.
    pub fn decode(bytes: &[u8]) -> Self {
        let mut r = Reader(bytes);
        let [vertices, midline, faces] = [r.u16(), r.u16(), r.u16()];
        Self {
            midline,
            q: (0..vertices).map(|_| Vector2::new(r.f32(), r.f32())).collect(),
            uv: (0..vertices).map(|_| [r.f32(), r.f32()]).collect(),
            faces: (0..faces).map(|_| [(); 3].map(|()| r.u16() as u32)).collect(),
            landmarks: HALF_LANDMARKS.iter().map(|_| r.u16()).collect(),
        }
    }

    /// The stored form that [`Self::decode`] reads.
    pub fn encode(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for n in [self.q.len(), self.midline, self.faces.len()] {
            out.extend((n as u16).to_le_bytes());
        }
        for q in &self.q {
            out.extend((q.x as f32).to_le_bytes());
            out.extend((q.y as f32).to_le_bytes());
        }
        for c in self.uv.iter().flatten() {
            out.extend((*c as f32).to_le_bytes());
        }
        for i in self.faces.iter().flatten() {
            out.extend((*i as u16).to_le_bytes());
        }
        for l in &self.landmarks {
            out.extend((*l as u16).to_le_bytes());
        }
        out
    }

    /// The half with every triangle split in four; new vertices bisect the edges in the chart.
    pub(crate) fn split(&self) -> Self {
        let mut out = self.clone();
        let mut midpoints = std::collections::BTreeMap::new();
        let mut on_midline = Vec::new();
        out.faces.clear();
        for f in &self.faces {
            let mid = [0, 1, 2].map(|k| {
                let (a, b) = (f[k].min(f[(k + 1) % 3]), f[k].max(f[(k + 1) % 3]));
                *midpoints.entry((a, b)).or_insert_with(|| {
                    let [a, b] = [a as usize, b as usize];
                    let mut q = 0.5 * (self.q[a] + self.q[b]);
                    if b < self.midline && b == a + 1 {
                        q /= q.norm();
                        on_midline.push(out.q.len());
                    }
                    out.q.push(q);
                    out.uv.push([0, 1].map(|k| 0.5 * (self.uv[a][k] + self.uv[b][k])));
                    out.q.len() as u32 - 1
                })
            });
            out.faces.push([f[0], mid[0], mid[2]]);
            out.faces.push([f[1], mid[1], mid[0]]);
            out.faces.push([f[2], mid[2], mid[1]]);
            out.faces.push(mid);
        }
        out.midline_first(&on_midline)
    }

    /// Renumbers so that the vertices of the midline, with those added to it, come first and in
    /// order.
    fn midline_first(self, added: &[usize]) -> Self {
        let mut order: Vec<usize> = (0..self.midline).chain(added.iter().copied()).collect();
        let angle = |i: usize| {
            let a = self.q[i].y.atan2(self.q[i].x);
            if a < -std::f64::consts::FRAC_PI_2 { a + std::f64::consts::TAU } else { a }
        };
        order.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
        let midline = order.len();
        let mut placed = vec![false; self.q.len()];
        order.iter().for_each(|&i| placed[i] = true);
        order.extend((0..self.q.len()).filter(|&i| !placed[i]));
        let mut new_index = vec![0; order.len()];
        order.iter().enumerate().for_each(|(new, &old)| new_index[old] = new);
        Self {
            midline,
            q: order.iter().map(|&i| self.q[i]).collect(),
            uv: order.iter().map(|&i| self.uv[i]).collect(),
            faces: self.faces.iter().map(|f| f.map(|i| new_index[i as usize] as u32)).collect(),
            landmarks: self.landmarks.iter().map(|&i| new_index[i]).collect(),
        }
    }
}
