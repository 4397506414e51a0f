//! How likely counts are that stray this far from what is expected.

/// The probability that chi^2 of so many degrees of freedom is larger than `square`: the upper incomplete gamma function.
pub(super) fn chance_of_more(square: f64, freedom: f64) -> f64 {
    let (a, x) = (0.5 * freedom, 0.5 * square);
    if !(x > 0.0) {
        return 1.0;
    }
    let scale = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        // The series of the lower function.
        let (mut term, mut sum) = (1.0 / a, 1.0 / a);
        for n in 1..10_000 {
            term *= x / (a + f64::from(n));
            sum += term;
            if term < 1e-15 * sum {
                break;
            }
        }
        return 1.0 - scale * sum;
    }
    // The continued fraction of the upper one, from its end.
    let mut tail = 0.0;
    for n in (1..2000).rev() {
        let n = f64::from(n);
        tail = n * (a - n) / (x + 2.0 * n + 1.0 - a + tail);
    }
    scale / (x + 1.0 - a + tail)
}

/// Stirling's series, from an argument of 10 on.
fn ln_gamma(x: f64) -> f64 {
    if x < 10.0 {
        return ln_gamma(x + 1.0) - x.ln();
    }
    let correction = (1.0 / 12.0 - 1.0 / (360.0 * x * x) + 1.0 / (1260.0 * x.powi(4))) / x;
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * std::f64::consts::PI).ln() + correction
}

/// What chi^2 and the degrees of freedom are of counts in boxes, where so many in all are expected with these shares. Boxes that
/// expect few are one.
pub(super) fn chi_square(shares: &[f64], counted: &[u32], total: u32) -> (f64, f64) {
    let (mut square, mut boxes, mut few) = (0.0, 0.0, [0.0; 2]);
    for (&share, &count) in shares.iter().zip(counted) {
        let want = share * f64::from(total);
        if want < 10.0 {
            few = [few[0] + want, few[1] + f64::from(count)];
        } else {
            square += (f64::from(count) - want).powi(2) / want;
            boxes += 1.0;
        }
    }
    if few[0] > 1.0 {
        square += (few[1] - few[0]).powi(2) / few[0];
        boxes += 1.0;
    }
    (square, boxes - 1.0)
}

#[test]
fn chances_of_chi_square_are_those_of_tables() {
    for (square, freedom, chance) in [
        (3.841_458_8, 1.0, 0.05),
        (10.827_566, 1.0, 0.001),
        (18.307_038, 10.0, 0.05),
        (2.558_212_4, 10.0, 0.99),
        (149.449_25, 100.0, 0.001),
        (1.386_294_4, 2.0, 0.5),
    ] {
        let got = chance_of_more(square, freedom);
        assert!((got / chance - 1.0).abs() < 1e-5, "{square} {freedom}: {got}");
    }
}
