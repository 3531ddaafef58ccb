//! The order of the stripes: seven colours in which every three neighbours occur once in a period
//! of 252, neighbours always of different colour, and three widths.

use std::sync::LazyLock;

/// Colours of the stripes, linear light: red, green, blue, cyan, magenta, yellow, white.
pub const PALETTE: [[f64; 3]; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 1.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 0.0],
    [1.0, 1.0, 1.0],
];

/// Stripes after which the order of colours repeats: all triples with unequal neighbours,
/// 7 * 6 * 6.
pub const STRIPE_PERIOD: usize = 252;

/// Widths in units of the distance from left edge to left edge.
const WIDTHS: [f64; 3] = [0.32, 0.46, 0.62];

/// One stripe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripe {
    /// Index into [`PALETTE`].
    pub color_index: usize,
    /// Width as a fraction of the distance from left edge to left edge.
    pub width: f64,
}

/// The stripe of a number, counted from 0 at the left.
pub fn stripe(number: usize) -> Stripe {
    static ORDER: LazyLock<Vec<usize>> = LazyLock::new(color_order);
    // 5 and 3 share no factor with 7: width and colour do not run in step
    let width = WIDTHS[(number * 5 + number / 3) % 3];
    Stripe { color_index: ORDER[number % STRIPE_PERIOD], width }
}

/// A closed walk through all triples (a, b, c), a != b, b != c, each once: an Euler circuit on
/// the graph whose nodes are the pairs (a, b) (de Bruijn 1946, by Hierholzer's method).
fn color_order() -> Vec<usize> {
    let colors = PALETTE.len();
    let mut next = vec![0usize; colors * colors];
    let (mut stack, mut circuit) = (vec![(0usize, 1usize)], Vec::new());
    while let Some(&(a, b)) = stack.last() {
        let node = a * colors + b;
        if next[node] == b {
            next[node] += 1;
        }
        if next[node] < colors {
            stack.push((b, next[node]));
            next[node] += 1;
        } else {
            circuit.push(a);
            stack.pop();
        }
    }
    circuit.reverse();
    circuit.truncate(STRIPE_PERIOD);
    circuit
}
