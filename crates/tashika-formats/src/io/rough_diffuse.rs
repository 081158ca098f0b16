//! Rough diffuse surfaces, approximated by Lambert surfaces of equal reflectance under uniform
//! light.
//!
//! The qualitative model (Oren and Nayar 1994, section 4.4)
//!
//! ```text
//! f = ρ/π (A + B max(0, cos Δφ) sin α tan β),   A = 1 − σ²/(2σ² + 0.66),   B = 0.45 σ²/(σ² + 0.09)
//! ```
//!
//! reflects the fraction `ρ (A + 0.214 B)` of uniform light into all directions together: 0.214 is
//! the cosine-weighted mean of `max(0, cos Δφ) sin α tan β` over both directions.

/// Factor on the reflectance for a standard deviation `sigma` of slopes (rad).
pub(super) fn scale(sigma: f32) -> f32 {
    const MEAN: f32 = 0.214;
    let s2 = sigma * sigma;
    if !s2.is_finite() {
        return 0.5;
    }
    1.0 - s2 / (2.0 * s2 + 0.66) + MEAN * 0.45 * s2 / (s2 + 0.09)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the mean with a sum over the cosines of both directions; the mean over the azimuth
    /// is 1/π.
    #[test]
    fn the_mean_over_all_directions_is_the_models() {
        let n = 200;
        let cosines = || (0..n).map(|i| (f64::from(i) + 0.5) / f64::from(n));
        let sine = |c: f64| (1.0 - c * c).sqrt();
        let of = |o: f64, i: f64| 4.0 * o * i * sine(o) * sine(i) / o.max(i) / std::f64::consts::PI;
        let mean: f64 = cosines().flat_map(|o| cosines().map(move |i| of(o, i))).sum();
        assert!((mean / f64::from(n * n) - 0.214).abs() < 1e-3);
        assert_eq!(scale(0.0), 1.0);
        // σ = 0.3: A = 0.8929, B = 0.225.
        assert!((scale(0.3) - 0.9410).abs() < 1e-4, "{}", scale(0.3));
    }
}
