//! Iterative closest points: the loop that all registrations share.

use crate::math::Similarity;

/// Why an iteration ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Termination {
    /// The last step changed too little to continue.
    Converged,
    /// The allowed number of iterations was used up.
    MaxIterations,
    /// No further step was possible or plausible.
    Stopped,
}

/// One iteration, before its step.
#[derive(Debug)]
pub struct IcpIteration<'a, P> {
    /// Number of the iteration, from 1.
    pub number: usize,
    /// The present pose.
    pub pose: &'a Similarity,
    /// The pairs of points and closest points under this pose.
    pub pairs: &'a P,
}

/// The step of an iteration.
#[derive(Clone, Debug)]
pub struct IcpStep<P> {
    /// The pose after the step.
    pub pose: Similarity,
    /// The pairs under that pose, where the step had to find them; otherwise the loop does.
    pub pairs: Option<P>,
    /// Whether the iteration ends with this step.
    pub converged: bool,
}

/// Result of an iteration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Icp {
    /// The last pose.
    pub pose: Similarity,
    /// Steps taken.
    pub iterations: usize,
    /// Why it ended.
    pub termination: Termination,
}

/// Iterative closest points (Besl and McKay 1992), from `start`, with at most `max_iterations`
/// steps.
///
/// `find_pairs` finds the closest points under a pose and leaves out the pairs that must not count
/// (the rejector). `step` computes the next pose from them; `None` ends the iteration at the
/// present pose.
///
/// # Errors
/// The first error of `step`.
///
/// ```
/// use facerecon_core::math::{Similarity, Vec3, fit_similarity};
/// use facerecon_core::spatial::{IcpStep, PointIndex, iterate_closest_points};
///
/// let model: Vec<Vec3> = (0..27)
///     .map(|i| Vec3::new(f64::from(i % 3), f64::from(i / 3 % 3), f64::from(i / 9)) * 10.0)
///     .collect();
/// let shift = Vec3::new(1.0, 2.0, -1.0);
/// let data: Vec<Vec3> = model.iter().map(|p| p + shift).collect();
/// let index = PointIndex::<3>::new(&model).unwrap();
/// let find_pairs = |pose: &Similarity| -> Vec<(Vec3, Vec3)> {
///     let closest = |p: &Vec3| index.nearest(&pose.apply(p).into()).map(|n| (*p, model[n.index]));
///     data.iter().filter_map(closest).collect()
/// };
/// let found = iterate_closest_points(Similarity::identity(), 20, find_pairs, |iteration| {
///     let (points, targets): (Vec<Vec3>, Vec<Vec3>) = iteration.pairs.iter().copied().unzip();
///     let pose = fit_similarity(&points, &targets, &[], false).ok_or("the points are on one line")?;
///     let converged = (pose.translation - iteration.pose.translation).norm() < 1e-9;
///     Ok::<_, &str>(Some(IcpStep { pose, pairs: None, converged }))
/// });
/// assert!((found.unwrap().pose.translation + shift).norm() < 1e-9);
/// ```
pub fn iterate_closest_points<P, E>(
    start: Similarity,
    max_iterations: usize,
    find_pairs: impl Fn(&Similarity) -> P,
    mut step: impl FnMut(&IcpIteration<'_, P>) -> Result<Option<IcpStep<P>>, E>,
) -> Result<Icp, E> {
    let mut pose = start;
    let mut next_pairs = None;
    for number in 1..=max_iterations {
        let pairs = next_pairs.take().unwrap_or_else(|| find_pairs(&pose));
        let Some(next) = step(&IcpIteration { number, pose: &pose, pairs: &pairs })? else {
            return Ok(Icp { pose, iterations: number - 1, termination: Termination::Stopped });
        };
        (pose, next_pairs) = (next.pose, next.pairs);
        if next.converged {
            return Ok(Icp { pose, iterations: number, termination: Termination::Converged });
        }
    }
    Ok(Icp { pose, iterations: max_iterations, termination: Termination::MaxIterations })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Mat3, Vec3};
    use std::cell::Cell;

    fn shifted(by: f64) -> Similarity {
        Similarity::rigid(Mat3::identity(), Vec3::x() * by)
    }

    /// Halves the translation from x = 8. Step `converge_at` converges, step `stop_at` is refused.
    fn run(max: usize, converge_at: usize, stop_at: usize, give_pairs: bool) -> (Icp, usize) {
        let searches = Cell::new(0);
        let find = |pose: &Similarity| {
            searches.set(searches.get() + 1);
            pose.translation.x
        };
        let icp = iterate_closest_points(shifted(8.0), max, find, |iteration| {
            assert_eq!(*iteration.pairs, iteration.pose.translation.x);
            let next = iteration.pairs / 2.0;
            let converged = iteration.number == converge_at;
            let step =
                IcpStep { pose: shifted(next), pairs: give_pairs.then_some(next), converged };
            Ok::<_, ()>((iteration.number != stop_at).then_some(step))
        });
        (icp.unwrap(), searches.get())
    }

    #[test]
    fn iterations_and_termination_are_reported() {
        for (arguments, x, iterations, termination) in [
            ((10, 3, 99), 1.0, 3, Termination::Converged),
            ((2, 3, 99), 2.0, 2, Termination::MaxIterations),
            ((10, 99, 3), 2.0, 2, Termination::Stopped),
            ((0, 1, 1), 8.0, 0, Termination::MaxIterations),
        ] {
            let (max, converge_at, stop_at) = arguments;
            let (icp, _) = run(max, converge_at, stop_at, false);
            assert_eq!((icp.pose.translation.x, icp.iterations), (x, iterations));
            assert_eq!(icp.termination, termination);
        }
    }

    #[test]
    fn pairs_that_a_step_has_found_are_not_searched_again() {
        assert_eq!(run(5, 99, 99, false).1, 5);
        assert_eq!(run(5, 99, 99, true).1, 1);
    }

    #[test]
    fn an_error_of_the_step_ends_the_iteration() {
        let result = iterate_closest_points(
            Similarity::identity(),
            9,
            |_| (),
            |iteration| if iteration.number < 3 { Ok(None) } else { Err("unreachable") },
        );
        assert_eq!(result.unwrap().iterations, 0);
        let result = iterate_closest_points(
            Similarity::identity(),
            9,
            |_| (),
            |_| Err::<Option<IcpStep<()>>, _>("no pairs"),
        );
        assert_eq!(result.unwrap_err(), "no pairs");
    }
}
