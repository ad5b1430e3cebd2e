//! Real roots of polynomials, by closed forms that do not cancel and by bracketing.

/// The roots of `a x^2 + 2 b x + c`, least first, given its discriminant `b^2 - a c >= 0`.
///
/// The caller passes the discriminant because its problem knows a form that does not cancel. Neither
/// root is a difference of nearly equal numbers (Goldberg 1991, "What every computer scientist should
/// know about floating-point arithmetic", section 1.4). As `a` goes to 0 one root goes to infinity and
/// is infinite at 0; that of `a = b = 0` are 0.
pub fn quadratic(a: f64, b: f64, c: f64, discriminant: f64) -> (f64, f64) {
    let q = -(b + discriminant.sqrt().copysign(b));
    if q == 0.0 {
        return (0.0, 0.0);
    }
    let (x, y) = (q / a, c / q);
    (x.min(y), x.max(y))
}

/// The real parts of the three roots of `x^3 + p x + q`, in ascending order.
///
/// Their error is a few ulps of the greatest root, times the usual loss at a multiple root (its square
/// or cube root).
pub fn depressed_cubic(p: f64, q: f64) -> [f64; 3] {
    // Newton's iteration falls steadily from this upper bound to the outermost root, taken positive.
    let fold = (-p / 3.0).max(0.0).sqrt();
    let mut outer = if q.abs() <= 2.0 * fold * fold * fold {
        2.0 * fold
    } else {
        3.0_f64.sqrt() * fold + q.abs().cbrt()
    };
    let mut falling = true;
    while falling {
        let square = outer * outer;
        let next = (2.0 * outer * square + q.abs()) / (3.0 * square + p);
        // The step after one this small ends within rounding; and 0 / 0 is not less than anything.
        falling = next < outer * (1.0 - 1e-8);
        outer = outer.min(next);
    }
    let outer = outer.copysign(-q);
    let half = -0.5 * outer;
    let spread = (-p - 3.0 * half * half).max(0.0).sqrt();
    if outer < 0.0 {
        [outer, half - spread, half + spread]
    } else {
        [half - spread, half + spread, outer]
    }
}

/// Newton's iteration from `x` for as long as it brings the value closer to 0; `f` gives value and slope.
pub fn polish(mut x: f64, f: impl Fn(f64) -> (f64, f64)) -> f64 {
    let (mut value, mut slope) = f(x);
    loop {
        let next = x - value / slope;
        let at_next = f(next);
        // Not so at a NaN either.
        if at_next.0.abs() < value.abs() {
            x = next;
            (value, slope) = at_next;
        } else {
            return x;
        }
    }
}

/// When [`bracketed`] is done.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// A value this close to 0 is 0.
    pub value: f64,
    /// A Newton step no longer than this is the last.
    pub step: f64,
}

/// A root of a function between `outside`, where it counts as positive, and `inside`, where it does not.
///
/// `f` gives the value and Newton's step, value over slope. The iteration starts at `guess`, never leaves
/// the bracket, bisects where it converges slowly, and ends at the latest where the bracket holds no
/// further number.
pub fn bracketed(
    mut outside: f64,
    mut inside: f64,
    guess: f64,
    tolerance: Tolerance,
    f: impl Fn(f64) -> (f64, f64),
) -> f64 {
    let between = |x: f64, a: f64, b: f64| (x > a && x < b) || (x > b && x < a);
    let mut x = guess;
    let mut last = f64::INFINITY;
    loop {
        if !between(x, outside, inside) {
            x = 0.5 * (outside + inside);
            last = (outside - inside).abs();
            if !between(x, outside, inside) {
                return inside;
            }
        }
        let (value, step) = f(x);
        if value.abs() <= tolerance.value {
            return x;
        }
        *(if value > 0.0 {
            &mut outside
        } else {
            &mut inside
        }) = x;
        let next = x - step;
        if step.abs() <= tolerance.step && between(next, outside, inside) {
            return next;
        }
        // Steps must halve: the bracket's own middle is better than one that does not.
        x = if step.abs() <= 0.5 * last {
            next
        } else {
            f64::NAN
        };
        last = step.abs();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64, tolerance: f64) -> bool {
        (a - b).abs() <= tolerance
    }

    #[test]
    fn quadratic_keeps_the_small_root_exact() {
        // (x - 1e-9) (x - 1e9): the textbook formula loses the small root altogether.
        let b = -0.5 * (1e-9 + 1e9);
        let (x, y) = quadratic(1.0, b, 1.0, b * b - 1.0);
        assert!(close(x, 1e-9, 1e-24), "{x}");
        assert!(close(y, 1e9, 1e-6), "{y}");
    }

    #[test]
    fn quadratic_without_its_square_has_one_finite_root() {
        assert_eq!(quadratic(0.0, 2.0, -8.0, 4.0), (f64::NEG_INFINITY, 2.0));
        assert_eq!(quadratic(0.0, -2.0, -8.0, 4.0), (-2.0, f64::INFINITY));
        assert_eq!(quadratic(0.0, 0.0, 1.0, 0.0), (0.0, 0.0));
    }

    #[test]
    fn cubic_finds_the_roots_it_was_made_from() {
        for (a, b) in [
            (-3.0, 1.0),
            (-1.0, 0.25),
            (-1e-6, -1.0),
            (1.0, 1.0),
            (0.0, 5.0),
            (2.0, -7.5),
        ] {
            let c: f64 = -(a + b);
            let mut truth = [a, b, c];
            truth.sort_by(f64::total_cmp);
            let found = depressed_cubic(a * b + a * c + b * c, -(a * b * c));
            let scale = truth[2].max(-truth[0]);
            for i in 0..3 {
                assert!(
                    close(found[i], truth[i], 3e-8 * scale),
                    "{found:?} {truth:?}"
                );
            }
        }
    }

    #[test]
    fn cubic_gives_the_real_part_of_a_complex_pair() {
        // (x - 2) (x + 1 - 3i) (x + 1 + 3i) = x^3 + 6 x - 20
        let found = depressed_cubic(6.0, -20.0);
        assert!(close(found[0], -1.0, 1e-15) && close(found[1], -1.0, 1e-15));
        assert!(close(found[2], 2.0, 1e-15));
        assert_eq!(depressed_cubic(0.0, 0.0), [0.0; 3]);
        assert_eq!(depressed_cubic(1.0, 0.0), [0.0; 3]);
    }

    #[test]
    fn polish_only_improves() {
        let square = |x: f64| (x * x - 2.0, 2.0 * x);
        assert!(close(polish(1.5, square), 2.0_f64.sqrt(), 3e-16));
        // Newton's step from here is far worse than to stay.
        assert_eq!(polish(1e-3, square), 1e-3);
        assert_eq!(polish(f64::INFINITY, square), f64::INFINITY);
    }

    const EXACT: Tolerance = Tolerance {
        value: 0.0,
        step: 0.0,
    };

    #[test]
    fn bracketed_converges_from_any_guess_even_where_the_slope_misleads() {
        let cube = |x: f64| (x * x * x - 2.0, (x - 2.0 / (x * x)) / 3.0);
        let flat = |x: f64| (x.atan() - 1.5, (x.atan() - 1.5) * (1.0 + x * x));
        for guess in [f64::NAN, -10.0, 0.0, 1e-9, 1.0, 99.0, 1e300] {
            let root = bracketed(100.0, 0.0, guess, EXACT, cube);
            assert!(close(root, 2.0_f64.cbrt(), 5e-16));
            let root = bracketed(1e4, -1e4, guess, EXACT, flat);
            assert!(close(root, 1.5_f64.tan(), 1e-11));
        }
    }

    #[test]
    fn bracketed_ends_at_a_jump_and_on_an_empty_bracket() {
        let jump = |x: f64| (if x > 0.3 { 1.0 } else { -1.0 }, f64::INFINITY);
        assert!(close(bracketed(1.0, 0.0, 0.5, EXACT, jump), 0.3, 1e-16));
        assert_eq!(bracketed(2.0, 2.0, 2.0, EXACT, jump), 2.0);
    }

    #[test]
    fn bracketed_takes_one_last_step_within_its_tolerance() {
        let line = |x: f64| (x - 0.5, x - 0.5);
        let loose = Tolerance {
            value: 0.0,
            step: 0.1,
        };
        assert_eq!(bracketed(1.0, 0.0, 0.5625, loose, line), 0.5);
        let rough = Tolerance {
            value: 0.1,
            step: 0.0,
        };
        assert_eq!(bracketed(1.0, 0.0, 0.5625, rough, line), 0.5625);
    }
}
