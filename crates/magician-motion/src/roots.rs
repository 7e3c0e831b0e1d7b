//! Root finding: quadratics and bisection.

/// Real roots of `a x^2 + b x + c`; NaN for a missing root.
pub(crate) fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let discriminant = b * b - 4.0 * a * c;
    if a == 0.0 {
        return [-c / b, f64::NAN];
    }
    // Adding terms of the same sign does not cancel; the other root follows from the product.
    let sum = -0.5 * (b + libm::copysign(libm::sqrt(discriminant), b));
    [sum / a, c / sum]
}

/// Root of a monotone function that changes its sign between `a` and `b`, bisected down to adjacent
/// numbers.
pub(crate) fn bisect(mut a: f64, mut b: f64, function: impl Fn(f64) -> f64) -> f64 {
    let rising = function(a) < function(b);
    // Two doubles have fewer than 2^64 numbers between them; 128 halvings leave room for any
    // rounding.
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
