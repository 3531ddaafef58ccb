//! The text of an OBJ file: vertices in file order, polygons as triangle fans.

use crate::data::Mesh;
use crate::io::error::Fault;
use crate::io::source::decode_text;
use crate::math::Vec3;

/// The content of an OBJ file.
#[derive(Debug, Default)]
pub(super) struct Parsed {
    pub mesh: Mesh,
    /// Material files, in the order of the file.
    pub libraries: Vec<String>,
    /// Materials in the order of first use, with the number of triangles each covers.
    pub materials: Vec<(String, usize)>,
    pub warnings: Vec<String>,
}

/// One corner of a polygon: vertex, and texture coordinate where given.
type Corner = (u32, Option<u32>);

/// Reads OBJ text. Groups, normals, lines, points and smoothing groups are ignored; free-form curves
/// and surfaces too, with a warning.
pub(super) fn parse(bytes: &[u8]) -> Result<Parsed, Fault> {
    let mut reader = Reader::default();
    let mut joined: Option<(usize, String)> = None;
    // A carriage return alone ends a line as well.
    for (number, line) in (Lines { rest: bytes, number: 0 }) {
        let line = decode_text(line);
        let comment = joined.is_none() && line.trim_start().starts_with('#');
        let continues = line.trim_end().strip_suffix('\\').filter(|_| !comment);
        match (continues, &mut joined) {
            (Some(head), Some((_, text))) => *text = format!("{text} {head}"),
            (Some(head), None) => joined = Some((number, head.to_owned())),
            (None, Some(_)) => {
                if let Some((first, text)) = joined.take() {
                    reader.statement(&format!("{text} {line}"), first)?;
                }
            }
            (None, None) => reader.statement(&line, number)?,
        }
    }
    if let Some((first, text)) = joined {
        reader.statement(&text, first)?;
    }
    Ok(reader.finish())
}

/// Numbered lines that end in LF, CR LF or CR.
struct Lines<'a> {
    rest: &'a [u8],
    number: usize,
}

impl<'a> Iterator for Lines<'a> {
    type Item = (usize, &'a [u8]);

    fn next(&mut self) -> Option<Self::Item> {
        if self.rest.is_empty() {
            return None;
        }
        self.number += 1;
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        let (line, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest.strip_prefix(b"\r\n").or(rest.get(1..)).unwrap_or_default();
        Some((self.number, line))
    }
}

#[derive(Default)]
struct Reader {
    out: Parsed,
    /// For each triangle its texture coordinates, where the polygon had them.
    uv_of_face: Vec<Option<[u32; 3]>>,
    colored: usize,
    degenerate: usize,
    unknown: usize,
    material: Option<usize>,
    corners: Vec<Corner>,
}

impl Reader {
    fn statement(&mut self, line: &str, number: usize) -> Result<(), Fault> {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        match keyword {
            "v" => self.vertex(without_comment(rest), number),
            "vt" => self.texture_coordinate(without_comment(rest), number),
            "f" | "fo" => self.face(without_comment(rest), number),
            "mtllib" => {
                self.out.libraries.push(name(rest));
                Ok(())
            }
            "usemtl" => {
                let name = name(rest);
                let found = self.out.materials.iter().position(|(n, _)| *n == name);
                self.material = Some(found.unwrap_or_else(|| {
                    self.out.materials.push((name, 0));
                    self.out.materials.len() - 1
                }));
                Ok(())
            }
            "" | "vn" | "vp" | "g" | "o" | "s" | "l" | "p" | "mg" | "lod" | "usemap" | "maplib"
            | "bevel" | "c_interp" | "d_interp" | "shadow_obj" | "trace_obj" => Ok(()),
            "curv" | "curv2" | "surf" | "cstype" | "deg" | "bmat" | "step" | "parm" | "trim"
            | "hole" | "scrv" | "sp" | "end" | "con" | "call" | "csh" | "ctech" | "stech" => {
                self.unknown += 1;
                Ok(())
            }
            comment if comment.starts_with('#') => Ok(()),
            // Programs add their own statements; but a file does not begin with one.
            other if !self.out.mesh.vertices.is_empty() && other.is_ascii() => {
                self.unknown += 1;
                Ok(())
            }
            other => {
                let shown: String = other.chars().take(20).collect();
                Err(Fault::at(
                    number,
                    format!("{shown:?} is not an OBJ statement; check that this is an OBJ file"),
                ))
            }
        }
    }

    fn vertex(&mut self, rest: &str, number: usize) -> Result<(), Fault> {
        let values = numbers::<8>(rest, number)?;
        let (&[x, y, z], tail) = values.split().ok_or_else(|| {
            Fault::at(
                number,
                format!("a vertex has {} coordinates, but 3 are expected", values.count),
            )
        })?;
        index_limit(self.out.mesh.vertices.len(), number)?;
        self.out.mesh.vertices.push(Vec3::new(x, y, z));
        // x y z r g b, or with alpha; a single fourth number is a weight.
        if let [r, g, b, ..] = *tail {
            self.colored += 1;
            let scale = if r.max(g).max(b) > 1.0 { 1.0 } else { 255.0 };
            let byte = |c: f64| (c * scale).round().clamp(0.0, 255.0) as u8;
            self.out.mesh.colors.push([byte(r), byte(g), byte(b)]);
        }
        Ok(())
    }

    fn texture_coordinate(&mut self, rest: &str, number: usize) -> Result<(), Fault> {
        let values = numbers::<3>(rest, number)?;
        let (u, v) = match values.slice() {
            [] => {
                return Err(Fault::at(
                    number,
                    "a texture coordinate has 0 numbers, but 2 are expected",
                ));
            }
            [u] => (*u, 0.0),
            [u, v, ..] => (*u, *v),
        };
        index_limit(self.out.mesh.uvs.len(), number)?;
        self.out.mesh.uvs.push([u, v]);
        Ok(())
    }

    fn face(&mut self, rest: &str, number: usize) -> Result<(), Fault> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for word in rest.split_whitespace() {
            let mut parts = word.split('/');
            let vertex = index(parts.next(), self.out.mesh.vertices.len(), "vertex", number)?
                .ok_or_else(|| Fault::at(number, format!("{word:?} is not a vertex number")))?;
            let uv = index(parts.next(), self.out.mesh.uvs.len(), "texture coordinate", number)?;
            corners.push((vertex, uv));
        }
        let mut whole = 0;
        for pair in corners.get(1..).unwrap_or_default().windows(2) {
            let triangle = [corners[0], pair[0], pair[1]];
            let [a, b, c] = triangle.map(|(v, _)| v);
            if a == b || b == c || c == a {
                continue;
            }
            whole += 1;
            self.out.mesh.faces.push([a, b, c]);
            self.uv_of_face.push(match triangle.map(|(_, uv)| uv) {
                [Some(p), Some(q), Some(r)] => Some([p, q, r]),
                _ => None,
            });
        }
        if let Some((_, covered)) = self.material.and_then(|m| self.out.materials.get_mut(m)) {
            *covered += whole;
        }
        self.degenerate += usize::from(whole + 2 != corners.len());
        self.corners = corners;
        Ok(())
    }

    fn finish(mut self) -> Parsed {
        let mesh = &mut self.out.mesh;
        let with_uv = self.uv_of_face.iter().flatten().count();
        if with_uv > 0 {
            let missing = self.uv_of_face.len() - with_uv;
            let fallback = mesh.uvs.len() as u32;
            if missing > 0 {
                mesh.uvs.push([0.0, 0.0]);
                self.out.warnings.push(format!(
                    "{missing} of {} triangles have no texture coordinates; they get the colour of \
                     the texture's lower left corner",
                    self.uv_of_face.len()
                ));
            }
            mesh.face_uvs = self.uv_of_face.iter().map(|uv| uv.unwrap_or([fallback; 3])).collect();
        }
        if self.colored != mesh.vertices.len() {
            if self.colored > 0 {
                self.out.warnings.push(format!(
                    "only {} of {} vertices have a colour; the colours are ignored",
                    self.colored,
                    mesh.vertices.len()
                ));
            }
            mesh.colors.clear();
        }
        if self.degenerate > 0 {
            self.out.warnings.push(format!(
                "{} faces have repeated corners; triangles without area are not read",
                self.degenerate
            ));
        }
        if self.unknown > 0 {
            self.out.warnings.push(format!(
                "{} statements (free-form curves and surfaces, or unknown) are ignored",
                self.unknown
            ));
        }
        self.out
    }
}

fn without_comment(text: &str) -> &str {
    text.split('#').next().unwrap_or_default()
}

/// A name, which may contain blanks and `#`, without the comment after it.
fn name(text: &str) -> String {
    text.split(" #").next().unwrap_or_default().trim().trim_matches('"').to_owned()
}

fn index_limit(count: usize, line: usize) -> Result<(), Fault> {
    if count >= u32::MAX as usize - 1 {
        return Err(Fault::at(line, "the mesh has more vertices than 32-bit indices allow"));
    }
    Ok(())
}

/// Resolves an index: counted from 1, or negative from the last one read; `None` where absent.
fn index(word: Option<&str>, count: usize, what: &str, line: usize) -> Result<Option<u32>, Fault> {
    let Some(word) = word.filter(|w| !w.is_empty()) else { return Ok(None) };
    let value: i64 =
        word.parse().map_err(|_| Fault::at(line, format!("{word:?} is not a {what} number")))?;
    let resolved =
        if value < 0 { i128::from(value) + count as i128 } else { i128::from(value) - 1 };
    match u32::try_from(resolved) {
        Ok(i) if (i as usize) < count => Ok(Some(i)),
        _ => Err(Fault::at(
            line,
            format!("the face names {what} {value}, but {count} have been read so far"),
        )),
    }
}

/// Up to `N` numbers of a line.
struct Numbers<const N: usize> {
    values: [f64; N],
    count: usize,
}

impl<const N: usize> Numbers<N> {
    fn slice(&self) -> &[f64] {
        &self.values[..self.count]
    }

    /// The first three and the rest.
    fn split(&self) -> Option<(&[f64; 3], &[f64])> {
        self.slice().split_first_chunk()
    }
}

fn numbers<const N: usize>(text: &str, line: usize) -> Result<Numbers<N>, Fault> {
    let mut out = Numbers { values: [0.0; N], count: 0 };
    for word in text.split_whitespace().take(N) {
        let value: f64 =
            word.parse().map_err(|_| Fault::at(line, format!("{word:?} is not a number")))?;
        if !value.is_finite() {
            return Err(Fault::at(line, format!("{word} is not a finite number")));
        }
        out.values[out.count] = value;
        out.count += 1;
    }
    Ok(out)
}
