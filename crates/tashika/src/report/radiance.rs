//! Two films as pictures of the same brightness.
//!
//! Both are multiplied by the same factor, so that the 98th percentile of the reference's luminance becomes white, and encoded as sRGB;
//! brighter channels are cut off. There is no shoulder, since it would hide differences between bright pixels.

use super::color_scale::{NO_VALUE, to_8_bits};
use super::compare::{Named, colors, luminance};
use super::picture::Picture;
use crate::color::srgb_encode;
use crate::error::Result;

/// Percent of the reference's pixels that are not cut off.
const SHOWN_PERCENT: usize = 98;

/// Pictures of a film and its reference; pixels that are not finite are gray.
pub(super) fn radiance_pictures(image: Named<'_>, reference: Named<'_>) -> Result<[Picture; 2]> {
    let mut luminances: Vec<f64> =
        colors(reference)?.map(luminance).filter(|l| l.is_finite() && *l > 0.0).collect();
    let white = if luminances.is_empty() {
        1.0
    } else {
        let rank = (luminances.len() * SHOWN_PERCENT / 100).min(luminances.len() - 1);
        *luminances.select_nth_unstable_by(rank, f64::total_cmp).1
    };
    let picture = |named: Named<'_>| -> Result<Picture> {
        let w = named.film.window();
        let shown = colors(named)?.map(|color| {
            if !color.is_finite() {
                return NO_VALUE;
            }
            color.to_array().map(|v| to_8_bits(srgb_encode((f64::from(v) / white).clamp(0.0, 1.0) as f32)))
        });
        Ok(Picture::of_pixels([w.width, w.height], shown))
    };
    Ok([picture(image)?, picture(reference)?])
}
