//! Whether two measures put the same things into the same order.

/// Kendall's rank correlation of two measures of the same things, from -1 to 1, with ties (tau-b); `None` if
/// one measure is the same everywhere. Both have the shape `[n]`.
///
/// # Source
///
/// M. G. Kendall, *The treatment of ties in ranking problems*, Biometrika 33:239-251 (1945).
pub fn kendall_tau(one: &[f64], other: &[f64]) -> Option<f64> {
    let sign = |number: f64| f64::from(i8::from(number > 0.0) - i8::from(number < 0.0));
    let (mut concordance, mut of_one, mut of_other) = (0.0, 0.0, 0.0);
    for (index, (left, right)) in one.iter().zip(other).enumerate() {
        for (left_2, right_2) in one.iter().zip(other).take(index) {
            let (here, there) = (sign(left - left_2), sign(right - right_2));
            concordance += here * there;
            of_one += here * here;
            of_other += there * there;
        }
    }
    let pairs = libm::sqrt(of_one * of_other);
    (pairs > 0.0).then(|| concordance / pairs)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers are those of `scipy.stats.kendalltau`.
    #[test]
    fn orders_are_compared_with_their_ties() {
        let scores = [12.0, 2.0, 1.0, 12.0, 2.0];
        let tau = kendall_tau(&scores, &[1.0, 4.0, 7.0, 1.0, 0.0]).unwrap();
        assert!((tau + 0.471_404_520_791_031_7).abs() < 1e-12, "{tau}");
        assert_eq!(kendall_tau(&scores, &scores), Some(1.0));
        assert_eq!(kendall_tau(&[1.0, 2.0, 3.0], &[3.0, 2.0, 1.0]), Some(-1.0));
        assert_eq!(kendall_tau(&[1.0, 2.0], &[5.0, 5.0]), None);
        assert_eq!(kendall_tau(&[], &[]), None);
    }
}
