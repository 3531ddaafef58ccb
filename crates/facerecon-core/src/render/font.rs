//! A bitmap font of five by seven pixels for numbers and labels in pictures.

use crate::data::Rgb;

/// Height of a glyph, pixels.
pub const GLYPH_HEIGHT: usize = 7;
const GLYPH_WIDTH: usize = 5;

/// Width of a text at zoom 1, pixels.
pub fn text_width(text: &str) -> usize {
    (text.chars().count() * (GLYPH_WIDTH + 1)).saturating_sub(1)
}

/// Draws a text with its upper left corner at `(x, y)`, clipped at the picture's border. Small
/// letters are drawn as capitals, except `m` (the unit `mm`); an unknown character leaves a gap.
pub fn draw_text(image: &mut Rgb, x: usize, y: usize, text: &str, zoom: usize, color: [u8; 3]) {
    let (width, height) = image.size();
    let zoom = zoom.max(1);
    let mut left = x;
    for letter in text.chars() {
        for (row, bits) in glyph(letter).into_iter().enumerate() {
            for column in 0..GLYPH_WIDTH {
                if bits >> (GLYPH_WIDTH - 1 - column) & 1 == 0 {
                    continue;
                }
                for py in (y + row * zoom..y + (row + 1) * zoom).take_while(|p| *p < height) {
                    for px in (left + column * zoom..left + (column + 1) * zoom)
                        .take_while(|p| *p < width)
                    {
                        image.set(px, py, color);
                    }
                }
            }
        }
        left += (GLYPH_WIDTH + 1) * zoom;
    }
}

/// Seven rows from the top, five bits each, the leftmost pixel in the highest bit.
fn glyph(letter: char) -> [u8; GLYPH_HEIGHT] {
    match if letter == 'm' { 'm' } else { letter.to_ascii_uppercase() } {
        '0' => [14, 17, 19, 21, 25, 17, 14],
        '1' => [4, 12, 4, 4, 4, 4, 14],
        '2' => [14, 17, 1, 6, 8, 16, 31],
        '3' => [30, 1, 1, 14, 1, 1, 30],
        '4' => [2, 6, 10, 18, 31, 2, 2],
        '5' => [31, 16, 30, 1, 1, 17, 14],
        '6' => [6, 8, 16, 30, 17, 17, 14],
        '7' => [31, 1, 2, 4, 8, 8, 8],
        '8' => [14, 17, 17, 14, 17, 17, 14],
        '9' => [14, 17, 17, 15, 1, 2, 12],
        'A' => [4, 10, 17, 17, 31, 17, 17],
        'B' => [30, 17, 17, 30, 17, 17, 30],
        'C' => [14, 17, 16, 16, 16, 17, 14],
        'D' => [28, 18, 17, 17, 17, 18, 28],
        'E' => [31, 16, 16, 30, 16, 16, 31],
        'F' => [31, 16, 16, 30, 16, 16, 16],
        'G' => [14, 17, 16, 23, 17, 17, 15],
        'H' => [17, 17, 17, 31, 17, 17, 17],
        'I' => [14, 4, 4, 4, 4, 4, 14],
        'J' => [7, 2, 2, 2, 2, 18, 12],
        'K' => [17, 18, 20, 24, 20, 18, 17],
        'L' => [16, 16, 16, 16, 16, 16, 31],
        'M' => [17, 27, 21, 21, 17, 17, 17],
        'm' => [0, 0, 26, 21, 21, 21, 21],
        'N' => [17, 25, 21, 21, 19, 17, 17],
        'O' => [14, 17, 17, 17, 17, 17, 14],
        'P' => [30, 17, 17, 30, 16, 16, 16],
        'Q' => [14, 17, 17, 17, 21, 18, 13],
        'R' => [30, 17, 17, 30, 20, 18, 17],
        'S' => [15, 16, 16, 14, 1, 1, 30],
        'T' => [31, 4, 4, 4, 4, 4, 4],
        'U' => [17, 17, 17, 17, 17, 17, 14],
        'V' => [17, 17, 17, 17, 17, 10, 4],
        'W' => [17, 17, 17, 21, 21, 21, 10],
        'X' => [17, 17, 10, 4, 10, 17, 17],
        'Y' => [17, 17, 10, 4, 4, 4, 4],
        'Z' => [31, 1, 2, 4, 8, 16, 31],
        '.' => [0, 0, 0, 0, 0, 12, 12],
        ',' => [0, 0, 0, 0, 12, 4, 8],
        ':' => [0, 12, 12, 0, 12, 12, 0],
        '-' => [0, 0, 0, 31, 0, 0, 0],
        '+' => [0, 4, 4, 31, 4, 4, 0],
        '=' => [0, 0, 31, 0, 31, 0, 0],
        '%' => [24, 25, 2, 4, 8, 19, 3],
        '/' => [1, 1, 2, 4, 8, 16, 16],
        '(' => [2, 4, 8, 8, 8, 4, 2],
        ')' => [8, 4, 2, 2, 2, 4, 8],
        '<' => [2, 4, 8, 16, 8, 4, 2],
        '>' => [8, 4, 2, 1, 2, 4, 8],
        _ => [0; GLYPH_HEIGHT],
    }
}
