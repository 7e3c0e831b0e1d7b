//! Roots of the few shapes of function that motion asks about.

/// The real roots of `a x^2 + b x + c`; NaN stands for one that is not there.
pub(crate) fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if a == 0.0 {
        return [-c / b, f64::NAN];
    }
    // Adding what has the same sign loses no digits; the other root follows from the product.
    let sum = -0.5 * (b + libm::copysign(libm::sqrt(discriminant), b));
    [sum / a, c / sum]
}

/// The root of a monotone function between `a` and `b`, where its signs differ: halved until no number lies
/// between.
pub(crate) fn between(mut a: f64, mut b: f64, function: impl Fn(f64) -> f64) -> f64 {
    let rising = function(a) < function(b);
    // A span of doubles has at most 2^64 members.
    for _ in 0..128 {
        let middle = 0.5 * (a + b);
        if middle <= a || middle >= b {
            break;
        }
        if (function(middle) > 0.0) == rising {
            b = middle;
        } else {
            a = middle;
        }
    }
    0.5 * (a + b)
}

/// Moments of a motion at which something may change, in order, kept in place.
#[derive(Clone, Debug)]
pub(crate) struct Moments {
    times: [f64; Self::CAPACITY],
    count: usize,
}

impl Moments {
    /// More than the boundaries of the workspace can cut a path: ten bounds, each also where the start lies beyond
    /// it, at most four cuts each, and the two edges of reach.
    const CAPACITY: usize = 96;

    pub(crate) fn new() -> Self {
        Self {
            times: [0.0; Self::CAPACITY],
            count: 0,
        }
    }

    /// Adds a moment; one that is not a positive number is nothing.
    pub(crate) fn add(&mut self, time: f64) {
        if time > 0.0
            && time.is_finite()
            && let Some(slot) = self.times.get_mut(self.count)
        {
            *slot = time;
            self.count += 1;
        }
    }

    /// The moments in order.
    pub(crate) fn sorted(&mut self) -> &[f64] {
        let times = self.times.get_mut(..self.count).unwrap_or_default();
        times.sort_unstable_by(f64::total_cmp);
        times
    }
}
