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
pub(crate) fn bisect(mut a: f64, mut b: f64, function: impl Fn(f64) -> f64) -> f64 {
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
