//! Colours and widths of the stripes. Every sequence of three colours occurs once in a period of 252
//! stripes, and neighbours have different colours.

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

/// Stripes after which the colours repeat: all triples with different neighbours, 7 * 6 * 6.
pub const STRIPE_PERIOD: usize = 252;

/// Widths as a fraction of the distance between left edges.
const WIDTHS: [f64; 3] = [0.32, 0.46, 0.62];

/// One stripe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stripe {
    /// Index into [`PALETTE`].
    pub color_index: usize,
    /// Width as a fraction of the distance between left edges.
    pub width: f64,
}

/// The stripe of an index, counted from 0 at the left.
pub fn stripe(number: usize) -> Stripe {
    static ORDER: LazyLock<Vec<usize>> = LazyLock::new(color_order);
    // The width is not a function of the colour.
    let width = WIDTHS[(number * 5 + number / 3) % 3];
    Stripe { color_index: ORDER[number % STRIPE_PERIOD], width }
}

/// A cyclic sequence with each triple (a, b, c), a != b, b != c, once: an Euler circuit of the graph
/// whose nodes are the pairs (a, b) (de Bruijn 1946; Hierholzer's algorithm).
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
