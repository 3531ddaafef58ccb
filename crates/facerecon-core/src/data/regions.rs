//! Connected sets of marked pixels; pixels are connected by their edges.

use super::Raster;

/// Visits the marked pixels connected to `start`, by their number (row-major); `visit` tells whether a
/// pixel is new.
pub(crate) fn flood(marked: &Raster<bool>, start: usize, visit: &mut dyn FnMut(usize) -> bool) {
    let (width, height) = marked.size();
    let mut stack = vec![start];
    visit(start);
    while let Some(i) = stack.pop() {
        let (x, y) = (i % width, i / width);
        let near = [
            (x > 0).then(|| i - 1),
            (x + 1 < width).then_some(i + 1),
            (y > 0).then(|| i - width),
            (y + 1 < height).then_some(i + width),
        ];
        for j in near.into_iter().flatten() {
            if marked.data()[j] && visit(j) {
                stack.push(j);
            }
        }
    }
}

/// The marked pixels and all that they enclose.
pub(crate) fn without_holes(marked: &Raster<bool>) -> Raster<bool> {
    let (width, height) = marked.size();
    let open = marked.map(|m| !m);
    let mut outside = vec![false; width * height];
    for i in 0..width * height {
        let (x, y) = (i % width, i / width);
        let at_border = x == 0 || y == 0 || x + 1 == width || y + 1 == height;
        if at_border && open.data()[i] && !outside[i] {
            flood(&open, i, &mut |j| !std::mem::replace(&mut outside[j], true));
        }
    }
    Raster::from_fn(width, height, |x, y| !outside[y * width + x])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enclosed_pixels_are_filled_and_bays_are_not() {
        // a ring with a bay at its left side, and a pixel that touches it by a corner only
        let rows = ["......", ".####.", ".#..#.", ".####.", "#....."];
        let marked = Raster::from_fn(6, 5, |x, y| rows[y].as_bytes()[x] == b'#');
        let filled = without_holes(&marked);
        assert!(filled.at(2, 2) && filled.at(3, 2) && !filled.at(0, 2) && !filled.at(5, 4));
        let mut visited = [false; 30];
        flood(&marked, 7, &mut |i| !std::mem::replace(&mut visited[i], true));
        assert_eq!(visited.iter().filter(|v| **v).count(), 10);
        assert!(!visited[24], "pixels that touch by a corner are not connected");
    }
}
