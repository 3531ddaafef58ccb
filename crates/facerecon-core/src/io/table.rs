//! Tables: `matches.csv`, and points from CSV, PLY or any mesh file.

use std::fmt::Write as _;
use std::path::Path;

use super::error::{Fault, IoError};
use super::mesh::{MeshFormat, read_any};
use super::source::{decode_text, read_bytes};
use super::{atomic, ply};
use crate::data::{Cloud, Dot};
use crate::math::{Vec2, Vec3};

/// Longest table, MB: about two million rows.
const MAX_FILE_MB: u64 = 256;
/// Largest number in a cell. Larger ones are garbage in any unit.
const MAX_VALUE: f64 = 1e9;
/// Columns of a header that are read.
const MAX_COLUMNS: usize = 100;
/// Characters of a cell that an error message shows.
const MAX_SHOWN: usize = 30;
/// The columns of `matches.csv`.
const COLUMNS: [&str; 12] =
    ["id", "xl", "yl", "xr", "yr", "disparity", "x_mm", "y_mm", "z_mm", "column", "row", "score"];

/// One row of `matches.csv`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchRow {
    /// Number of the match.
    pub id: usize,
    /// Position in the left photo, pixels.
    pub left: Vec2,
    /// Position in the right photo, pixels.
    pub right: Vec2,
    /// Disparity `xl - xr` of the rectified pair, pixels; `None` where unknown.
    pub disparity: Option<f64>,
    /// Position in the camera frame, millimetres; `None` without a rig.
    pub position: Option<Vec3>,
    /// `[column, row]` of the dot in the pattern; `None` where unknown.
    pub lattice: Option<[i32; 2]>,
    /// Confidence, 0 to 1.
    pub score: f64,
}

/// Writes the dots of one photo as a table `id,x,y,sigma_px,amplitude,score`, pixels.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_dots(path: &Path, dots: &[Dot]) -> Result<(), IoError> {
    let mut out = String::from("id,x,y,sigma_px,amplitude,score\n");
    for (id, dot) in dots.iter().enumerate() {
        let (x, y) = (dot.position.x, dot.position.y);
        let (sigma, amplitude, score) = (dot.sigma_px, dot.amplitude, dot.score);
        let _ = writeln!(out, "{id},{x:.5},{y:.5},{sigma:.4},{amplitude:.3},{score:.4}");
    }
    atomic::write(path, out.as_bytes())
}

/// The text of `matches.csv`: five decimal places for lengths, empty cells where unknown.
fn matches_csv(rows: &[MatchRow]) -> String {
    let mut out = COLUMNS.join(",") + "\n";
    for row in rows {
        let (xl, yl) = (row.left.x, row.left.y);
        let (xr, yr) = (row.right.x, row.right.y);
        let _ = write!(out, "{},{xl:.5},{yl:.5},{xr:.5},{yr:.5},", row.id);
        if let Some(disparity) = row.disparity {
            let _ = write!(out, "{disparity:.5}");
        }
        let _ = match row.position {
            Some(p) => write!(out, ",{:.5},{:.5},{:.5},", p.x, p.y, p.z),
            None => write!(out, ",,,,"),
        };
        let _ = match row.lattice {
            Some([column, line]) => write!(out, "{column},{line}"),
            None => write!(out, ","),
        };
        let _ = writeln!(out, ",{:.4}", row.score);
    }
    out
}

/// Writes `matches.csv` atomically.
///
/// # Errors
/// [`IoError::Write`].
pub fn write_matches(path: &Path, rows: &[MatchRow]) -> Result<(), IoError> {
    atomic::write(path, matches_csv(rows).as_bytes())
}

/// Reads a table of matches: any CSV with the columns `xl yl xr yr`, and the other columns of
/// `matches.csv` where it has them, in any order.
///
/// # Errors
/// [`IoError`] with the line.
pub fn read_matches(path: &Path) -> Result<Vec<MatchRow>, IoError> {
    let bytes = read_bytes(path, "table", MAX_FILE_MB)?;
    parse_matches(&bytes).map_err(|e| e.in_file(path))
}

/// Reads the bytes of a table of matches; see [`read_matches`].
///
/// # Errors
/// [`Fault`] with the line.
fn parse_matches(bytes: &[u8]) -> Result<Vec<MatchRow>, Fault> {
    let text = decode_text(bytes);
    let table = Table::new(&text)?;
    let place = |name: &str| table.header.iter().position(|h| h == name);
    let required = |name: &str| {
        place(name).ok_or_else(|| {
            let found = table.header.join(",");
            Fault::at(
                1,
                format!(
                    "there is no column {name}; the columns are {found}, but xl,yl,xr,yr are needed"
                ),
            )
        })
    };
    let corners = [required("xl")?, required("yl")?, required("xr")?, required("yr")?];
    let others = ["id", "disparity", "x_mm", "y_mm", "z_mm", "column", "row", "score"].map(place);
    table
        .rows()
        .enumerate()
        .map(|(i, (line, cells))| {
            let cell = |place: Option<usize>| match place.and_then(|k| cells.get(k)) {
                Some(cell) if !cell.is_empty() => number(cell, line).map(Some),
                _ => Ok(None),
            };
            let mut at = [0.0; 4];
            for (value, place) in at.iter_mut().zip(corners) {
                *value = cell(Some(place))?.ok_or_else(|| {
                    Fault::at(line, "the match needs numbers in xl, yl, xr and yr")
                })?;
            }
            let [id, disparity, x, y, z, column, row, score] = [
                cell(others[0])?,
                cell(others[1])?,
                cell(others[2])?,
                cell(others[3])?,
                cell(others[4])?,
                cell(others[5])?,
                cell(others[6])?,
                cell(others[7])?,
            ];
            Ok(MatchRow {
                id: id.map_or(i, |v| v.max(0.0) as usize),
                left: Vec2::new(at[0], at[1]),
                right: Vec2::new(at[2], at[3]),
                disparity,
                position: x.zip(y).zip(z).map(|((x, y), z)| Vec3::new(x, y, z)),
                lattice: column.zip(row).map(|(c, r)| [c as i32, r as i32]),
                score: score.unwrap_or(1.0),
            })
        })
        .collect()
}

/// Reads points: PLY, CSV or XYZ text (columns `x y z`, `x_mm y_mm z_mm`, `X Y Z`, or the first
/// three of a table without header), or the vertices of any mesh file. Rows of `matches.csv`
/// without a position are ignored.
///
/// # Errors
/// [`IoError`] with the line, or for a file without points.
pub fn read_points(path: &Path) -> Result<Cloud, IoError> {
    let bytes = read_bytes(path, "table of points", MAX_FILE_MB)?;
    let cloud = match MeshFormat::of(path, &bytes) {
        Some(MeshFormat::Ply) => ply::decode_cloud(&bytes).map_err(|e| e.in_file(path))?,
        Some(_) => {
            let mesh = read_any(path)?.mesh;
            Cloud { colors: mesh.colors, ..Cloud::from_points(mesh.vertices) }
        }
        None => parse_points(&bytes).map_err(|e| e.in_file(path))?,
    };
    if cloud.is_empty() {
        return Err(IoError::malformed(path, "the file has no points"));
    }
    Ok(cloud)
}

/// Reads the bytes of a table of points; see [`read_points`].
///
/// # Errors
/// [`Fault`] with the line.
fn parse_points(bytes: &[u8]) -> Result<Cloud, Fault> {
    let text = decode_text(bytes);
    let table = Table::new(&text)?;
    let find = |names: [&str; 3]| {
        let places = names.map(|n| table.header.iter().position(|h| h == n));
        Some([places[0]?, places[1]?, places[2]?])
    };
    let places = match find(["x", "y", "z"]).or(find(["x_mm", "y_mm", "z_mm"])) {
        Some(places) => places,
        None if table.numeric => [0, 1, 2],
        None => {
            let found = table.header.join(",");
            return Err(Fault::at(
                1,
                format!("there are no columns x,y,z or x_mm,y_mm,z_mm; the columns are {found}"),
            ));
        }
    };
    let mut cloud = Cloud::default();
    for (line, cells) in table.rows() {
        let cell = places.map(|k| cells.get(k).copied().unwrap_or_default());
        if cell.iter().all(|c| c.is_empty()) {
            continue;
        }
        let mut point = Vec3::zeros();
        for (value, cell) in point.iter_mut().zip(cell) {
            *value = number(cell, line)?;
        }
        cloud.points.push(point);
    }
    Ok(cloud)
}

/// A table of cells separated by commas, semicolons, tabs or blanks.
struct Table<'a> {
    text: &'a str,
    separator: Option<char>,
    /// Names in lower case; the first row of a table without header.
    header: Vec<String>,
    /// Whether the first line has numbers, not names.
    numeric: bool,
}

impl<'a> Table<'a> {
    fn new(text: &'a str) -> Result<Self, Fault> {
        let first = data_lines(text).next().ok_or_else(|| Fault::new("the table is empty"))?.1;
        let separator = [',', ';', '\t'].into_iter().find(|c| first.contains(*c));
        let header: Vec<String> =
            cells(first, separator).iter().take(MAX_COLUMNS).map(|c| c.to_lowercase()).collect();
        let numeric = header.iter().all(|c| c.parse::<f64>().is_ok());
        Ok(Self { text, separator, header, numeric })
    }

    /// Line number and cells of every row of data.
    fn rows(&self) -> impl Iterator<Item = (usize, Vec<&'a str>)> {
        let separator = self.separator;
        data_lines(self.text)
            .skip(usize::from(!self.numeric))
            .map(move |(line, row)| (line, cells(row, separator)))
    }
}

/// Numbered lines that are neither empty nor comments.
fn data_lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

fn cells(line: &str, separator: Option<char>) -> Vec<&str> {
    match separator {
        Some(c) => line.split(c).map(|cell| cell.trim().trim_matches('"')).collect(),
        None => line.split_whitespace().collect(),
    }
}

fn number(cell: &str, line: usize) -> Result<f64, Fault> {
    let shown = || cell.chars().take(MAX_SHOWN).collect::<String>();
    match cell.parse::<f64>() {
        Ok(value) if value.is_finite() && value.abs() < MAX_VALUE => Ok(value),
        Ok(_) => Err(Fault::at(line, format!("{} is not a possible value", shown()))),
        Err(_) => Err(Fault::at(line, format!("{:?} is not a number", shown()))),
    }
}

#[cfg(test)]
mod tests;
