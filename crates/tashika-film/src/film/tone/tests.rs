//! Tone mappings against the formulas of their authors, and against properties that all of them
//! have.

use super::*;
use crate::color::srgb_decode;

fn gray(tone: Tone, v: f32) -> f32 {
    let shown = tone.display(Rgb::gray(v), 1.0);
    assert!(
        shown.max_channel() - shown.r.min(shown.g).min(shown.b) < 6e-4,
        "{tone} makes {v} of gray {shown:?}"
    );
    shown.g
}

/// The formula as Hable lists it, with his letters.
fn hable(x: f64) -> f64 {
    let [a, b, c, d, e, f] = [0.15, 0.50, 0.10, 0.20, 0.02, 0.30];
    let curve = |x: f64| ((x * (a * x + c * b) + d * e) / (x * (a * x + b) + d * f)) - e / f;
    curve(2.0 * x) / curve(11.2)
}

/// Product of a matrix given by columns, as shaders write it, and a colour.
fn columns(m: [[f64; 3]; 3], c: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|row| (0..3).map(|k| m[k][row] * c[k]).sum())
}

fn hill(c: [f64; 3]) -> [f64; 3] {
    let input = [[0.59719, 0.07600, 0.02840], [0.35458, 0.90834, 0.13383], [0.04823, 0.01566, 0.83777]];
    let output =
        [[1.60475, -0.10208, -0.00327], [-0.53108, 1.10813, -0.07276], [-0.07367, -0.00605, 1.07602]];
    let fit = |v: f64| (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    columns(output, columns(input, c).map(fit))
}

fn wrensch(c: [f64; 3]) -> [f64; 3] {
    let inset = [
        [0.842479062253094, 0.0423282422610123, 0.0423756549057051],
        [0.0784335999999992, 0.878468636469772, 0.0784336],
        [0.0792237451477643, 0.0791661274605434, 0.879142973793104],
    ];
    let outset = [
        [1.19687900512017, -0.0528968517574562, -0.0529716355144438],
        [-0.0980208811401368, 1.15190312990417, -0.0980434501171241],
        [-0.0990297440797205, -0.0989611768448433, 1.15107367264116],
    ];
    let (low, high) = (-12.47393, 4.026069);
    let contrast = |v: f64| {
        let x = (crate::math::elementary::ln_f64(v) / std::f64::consts::LN_2).clamp(low, high);
        let x = (x - low) / (high - low);
        let (x2, x4) = (x * x, x * x * x * x);
        15.5 * x4 * x2 - 40.14 * x4 * x + 31.96 * x4 - 6.868 * x2 * x + 0.4298 * x2 + 0.1191 * x - 0.00232
    };
    let shown = columns(outset, columns(inset, c).map(contrast));
    shown.map(|v| crate::math::elementary::powf_f64(v.clamp(0.0, 1.0), 2.2))
}

#[test]
fn published_tones_are_what_their_authors_wrote() {
    let colors = [
        [0.18, 0.18, 0.18],
        [0.5, 0.1, 0.02],
        [0.001, 0.002, 0.003],
        [4.0, 0.0, 0.3],
        [0.02, 30.0, 0.0],
        [1.0, 2.0, 8.0],
    ];
    for color in colors {
        for (tone, expected) in [
            (Tone::Filmic, color.map(hable)),
            (Tone::Aces, hill(color)),
            (Tone::Agx, wrensch(color)),
            (Tone::Linear, color),
        ] {
            let shown = tone.display(color.map(|v| v as f32).into(), 1.0).to_array().map(f64::from);
            // Sums of a few terms of size 40 at most, rounded to 2⁻²⁴ each, and a power of 2.2.
            let near = |(a, b): (&f64, &f64)| (a - b.clamp(0.0, 1.0)).abs() < 2e-5;
            assert!(
                shown.iter().zip(&expected).all(near),
                "{tone} of {color:?}: {shown:?}, not {expected:?}"
            );
        }
    }
}

#[test]
fn middle_gray_and_white_go_where_their_authors_say() {
    for tone in [Tone::Natural, Tone::Linear] {
        assert!((gray(tone, 0.18) - 0.18).abs() < 1e-6, "{tone}");
    }
    // Hable's linear white, halved by the exposure bias.
    assert!((gray(Tone::Filmic, 5.6) - 1.0).abs() < 1e-4 && gray(Tone::Filmic, 5.5) < 0.999);
    assert!((gray(Tone::Filmic, 0.18) - 0.128_338).abs() < 1e-5);
    // ACES shows middle gray at 4.8 of 48 cd/m²; the fit is close to that.
    assert!((gray(Tone::Aces, 0.18) - 0.10).abs() < 0.006, "{}", gray(Tone::Aces, 0.18));
    // The pivot of AgX: middle gray, ten of its 16.5 stops from black, has the code 0.5. The
    // tolerance covers three times the root mean squared error of the fit, and the error of the
    // matrices for gray.
    let code = powf(gray(Tone::Agx, 0.18), 1.0 / 2.2);
    assert!((code - 0.5).abs() < 0.006, "{code}");
    assert!((gray(Tone::Agx, 0.18) - 0.2145).abs() < 1e-3);
}

#[test]
fn brighter_grays_are_never_darker_and_black_is_black() {
    for tone in Tone::ALL {
        assert_eq!(tone.display(Rgb::BLACK, 1.0), Rgb::BLACK, "{tone}");
        let steps: Vec<f32> = (0..4000).map(|i| powf(10.0, i as f32 / 250.0 - 8.0)).collect();
        let shown: Vec<f32> = steps.iter().map(|&v| gray(tone, v)).collect();
        // The polynomial of AgX is rounded to some 2⁻²⁴ of its largest term, 32.
        let down = shown.windows(2).position(|w| w[1] < w[0] - 4e-6);
        assert!(down.is_none(), "{tone} at {}", steps[down.unwrap()]);
        assert!(shown[0] < 1e-6 && shown[3999] > 0.996, "{tone}: {} to {}", shown[0], shown[3999]);
    }
}

/// A saturated light keeps its hue or becomes white at any brightness; nothing becomes NaN.
#[test]
fn any_numbers_become_colours() {
    for tone in Tone::ALL {
        for brightness in [1e-30, 1e-3, 0.18, 1.0, 30.0, 1e5, 1e20, f32::MAX, f32::INFINITY] {
            for channels in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0; 3]] {
                let color = channels.map(|on| if on > 0.0 { brightness } else { 0.0 });
                let shown = tone.display(color.into(), 1.0);
                assert!(shown.to_array().iter().all(|v| (0.0..=1.0).contains(v)), "{tone}: {shown:?}");
                // Lit channels are not darker than unlit ones; in ACES and AgX hues may turn.
                let of = |on: bool| channels.iter().zip(shown.to_array()).filter(move |c| (*c.0 > 0.0) == on);
                let least = of(true).map(|c| c.1).fold(1.0, f32::min);
                let most = of(false).map(|c| c.1).fold(0.0, f32::max);
                assert!(least >= most - 1e-3, "{tone}: {color:?} becomes {shown:?}");
            }
        }
        let odd = [-1.0, f32::NAN, f32::NEG_INFINITY, -1e-40];
        for v in odd {
            assert_eq!(tone.display(Rgb::gray(v), 1.0), Rgb::BLACK, "{tone} of {v}");
            let one = tone.display(Rgb::new(v, 0.3, 0.3), 4.0);
            assert_eq!(one, tone.display(Rgb::new(0.0, 0.3, 0.3), 4.0), "{tone}: below zero is zero");
        }
        assert!(tone.display(Rgb::gray(f32::INFINITY), f32::MIN_POSITIVE).g > 0.99, "{tone}");
    }
}

#[test]
fn exposure_comes_before_the_tone() {
    for tone in Tone::ALL {
        let color = Rgb::new(0.4, 0.1, 0.02);
        assert_eq!(tone.display(color, 4.0), tone.display(color * 4.0, 1.0), "{tone}");
    }
    let map = ToneMap { exposure: Exposure::Stops(2.0), tone: Tone::Filmic };
    let (bytes, stops) = map.picture(&[(Rgb::gray(0.045), true), (Rgb::gray(9.0), false)]).unwrap();
    let code = f32::from(bytes[0]) / 255.0;
    assert!((srgb_decode(code) - 0.128_338).abs() < 0.003, "middle gray is 0.045 at two stops");
    assert_eq!((stops, bytes[3], bytes[7]), (2.0, 255, 0));
}

#[test]
fn tones_are_named() {
    for tone in Tone::ALL {
        assert_eq!(tone.to_string().parse::<Tone>().unwrap(), tone);
    }
    let wrong = "sepia".parse::<Tone>().unwrap_err().to_string();
    assert!(wrong.contains("tonemap = sepia; expected natural, linear, filmic, aces, agx"), "{wrong}");
}

#[test]
fn more_light_is_never_darker_and_the_knee_is_smooth() {
    let steps: Vec<f32> = (0..4000).map(|i| powf(10.0, i as f32 / 400.0 - 5.0)).collect();
    assert!(steps.windows(2).all(|w| shoulder(w[1]) >= shoulder(w[0])));
    let slope = |a: f32, b: f32| (shoulder(b) - shoulder(a)) / (b - a);
    // The curve's second derivative above the knee is at most 1/(1 − K) = 2.5.
    assert!((slope(KNEE - 0.01, KNEE) - slope(KNEE, KNEE + 0.01)).abs() < 2.5 * 0.01);
}

#[test]
fn hue_and_luminance_of_natural_pictures_survive_where_the_gamut_allows() {
    let bright = Tone::Natural.display(Rgb::new(8.0, 0.5, 0.1), 1.0);
    let luminance = Rgb::new(8.0, 0.5, 0.1).luminance();
    assert!((bright.luminance() - shoulder(luminance)).abs() < 1e-6);
    assert_eq!(bright.max_channel(), bright.r);
    assert!(bright.r <= 1.0 && bright.r > bright.g && bright.g > bright.b, "{bright:?}");
    // The direction from gray is that of the radiance: (c − L) in the same proportions.
    let ratio = |c: Rgb| (c.r - c.luminance()) / (c.b - c.luminance());
    assert!((ratio(bright) - ratio(Rgb::new(8.0, 0.5, 0.1))).abs() < 1e-4 * ratio(bright).abs());
}
