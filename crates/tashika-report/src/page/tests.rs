//! Contents of pages, read back from their text.

use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value as Json;

use super::*;
use crate::color::{Rgb, srgb_encode};
use crate::film::{
    Claim, PictureClaim, PixelRecord, PlaneSpec, SCHEMA, SampleKind, Samples, Stop, Tone, Window, keys,
    planes,
};
use crate::{Named, Tolerance, ToleranceFrom, compare};

const fn spec(name: &'static str, channels: &'static [&'static str], kind: SampleKind) -> PlaneSpec {
    PlaneSpec { name, channels, unit: "1", kind, doc: "what it is" }
}
const SPECS: &[PlaneSpec] = &[
    spec("", &["R", "G", "B"], SampleKind::F32),
    spec("half_width", &["Y"], SampleKind::F32),
    spec("claim", &["id"], SampleKind::U32),
    spec("stop", &["id"], SampleKind::U32),
    spec("rays", &["n"], SampleKind::F32),
    spec("normal", &["X", "Y", "Z"], SampleKind::F32),
];

/// A cropped film of awkward numbers. Half-widths are 1 % of a luminance of approximately 2; the
/// last pixel claims nothing.
fn film(width: u32, height: u32) -> Film {
    let window = Window { x: 7, y: 3, width, height };
    let mut film = Film::new([width + 20, height + 20], window, SPECS).unwrap();
    for (i, (x, y)) in window.pixels().enumerate() {
        let v = 2.0 + 1e-7 * (i % 13) as f32;
        let last = i as u64 + 1 == window.area();
        film.plane_mut("").unwrap().set_f32(x, y, &[v, v, v]);
        film.plane_mut("half_width").unwrap().set_f32(x, y, &[0.02]);
        film.plane_mut("claim").unwrap().set_u32(x, y, &[if last { 0 } else { 3 }]);
        film.plane_mut("stop").unwrap().set_u32(x, y, &[if last { 4 } else { 3 }]);
        film.plane_mut("rays").unwrap().set_f32(x, y, &[i as f32]);
    }
    let metadata = film.metadata_mut();
    metadata.set("scene", "</script><script>alert(1)</script>");
    metadata.set("truth", "vpl");
    metadata.set("error", 0.02);
    metadata.set("confidence", 0.95);
    film
}

fn rendered(film: &Film) -> String {
    let rows = vec![("note".to_owned(), "<b>&".to_owned())];
    render_page(
        film,
        &RenderFacts {
            name: "a'\"<.exr".to_owned(),
            rows,
            command: Some("tashika render 'a b'".to_owned()),
            tone: Tone::Agx,
            luminance: None,
        },
    )
}

/// Data that the scripts of a page receive.
fn data(page: &str) -> Json {
    let begin = page.split("id=\"tashika-data\">").nth(1).unwrap();
    serde_json::from_str(begin.split("</script>").next().unwrap()).unwrap()
}

/// Decodes samples as assets/planes.js does.
fn samples(text: &str) -> Vec<u32> {
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(&*STANDARD.decode(text).unwrap()).read_to_end(&mut bytes).unwrap();
    for i in 1..bytes.len() {
        bytes[i] = bytes[i].wrapping_add(bytes[i - 1]);
    }
    let n = bytes.len() / 4;
    (0..n).map(|i| u32::from_le_bytes([0, 1, 2, 3].map(|k| bytes[k * n + i]))).collect()
}

fn plane(image: &Json, name: &str) -> Vec<u32> {
    let planes = image["planes"].as_array().unwrap();
    samples(planes.iter().find(|p| p["name"] == name).unwrap()["data"].as_str().unwrap())
}

#[test]
fn samples_are_in_the_page_bit_by_bit_channel_after_channel() {
    let film = film(31, 17);
    let image = &data(&rendered(&film))["images"][0];
    assert_eq!(image["window"], serde_json::json!([7, 3, 31, 17]));
    let Samples::F32(colors) = film.plane("").unwrap().samples() else { unreachable!() };
    let in_order: Vec<u32> =
        (0..3).flat_map(|c| colors.iter().skip(c).step_by(3).map(|v| v.to_bits())).collect();
    assert_eq!(plane(image, ""), in_order);
    assert_eq!(plane(image, "claim"), film.plane("claim").unwrap().u32_samples().unwrap());
    let names: Vec<&str> =
        image["planes"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["", "half_width", "claim", "stop", "rays"], "normals are not asked for");
}

/// The control lists all tones and begins with the requested one. Scripts receive the numbers of
/// published tones.
#[test]
fn pages_have_all_tones_and_begin_with_the_one_that_was_asked_for() {
    let page = rendered(&film(3, 2));
    for tone in Tone::ALL {
        let selected = if tone == Tone::Agx { " selected" } else { "" };
        assert_eq!(page.matches(&format!("<option{selected}>{tone}</option>")).count(), 1, "{tone}");
    }
    let record = record_script::record();
    assert_eq!(record["tones"].as_object().unwrap().keys().collect::<Vec<_>>(), ["aces", "agx", "filmic"]);
    assert_eq!(record["tones"]["aces"]["curve"]["rational"]["over"][2], 1.0);
    assert_eq!(record["tones"]["agx"]["curve"]["logarithmic"]["polynomial"].as_array().unwrap().len(), 7);
}

#[test]
fn names_and_metadata_are_never_markup() {
    let page = rendered(&film(3, 2));
    assert!(
        !page.contains("<script>") && !page.contains("alert(1)</script>"),
        "only the page's own scripts, which have a nonce"
    );
    assert_eq!(page.matches("</script>").count(), 2 + SCRIPTS.len());
    assert!(!page.contains("<b>&") && page.contains("&lt;b&gt;&amp;"));
    assert!(!page.contains("a'\"<.exr"));
    assert_eq!(data(&page)["images"][0]["metadata"]["scene"], "</script><script>alert(1)</script>");
    // Addresses appear only as the names of the SVG language.
    assert_eq!(
        page.matches("http").count(),
        page.matches("http://www.w3.org/").count() + page.matches("http-equiv").count()
    );
    assert_eq!(page, rendered(&film(3, 2)), "equal contents, equal bytes");
}

#[test]
fn of_large_films_the_page_holds_the_least_certain_pixel_of_each_block_and_where_it_is() {
    let film = film(900, 700);
    let page = rendered(&film);
    let image = &data(&page)["images"][0];
    // 900 · 700 pixels are more than twice as many as 300,000; there are 157,500 blocks of 2 × 2.
    assert_eq!(image["factor"], 2);
    assert!(page.contains(
        "Of each block of 2×2 pixels this page holds the one that is least certain, of 630,000 in all"
    ));
    let picks = samples(image["picks"].as_str().unwrap());
    let (rays, claims) = (plane(image, "rays"), plane(image, "claim"));
    assert_eq!((picks.len(), rays.len()), (450 * 350, 450 * 350));
    for (block, (pick, rays)) in picks.iter().zip(&rays).enumerate() {
        let (u, v) = (2 * (block as u32 % 450) + pick % 2, 2 * (block as u32 / 450) + pick / 2);
        assert_eq!(
            f32::from_bits(*rays),
            (v * 900 + u) as f32,
            "block {block} does not show the pixel it names"
        );
    }
    assert_eq!(
        (claims[450 * 350 - 1], picks[450 * 350 - 1]),
        (0, 3),
        "the one pixel without a claim is not hidden"
    );
}

#[test]
fn the_headline_and_the_lines_count_what_the_film_holds() {
    let mut film = film(5, 2);
    let page = rendered(&film);
    for words in [
        "90.0 % of 10 pixels claim to be within 2 % of the sum over its VPLs at 95 % confidence",
        "1 claims nothing: do not rely on it.",
        "9 carry calibrated intervals",
        "1 ran out of budget",
        "the sum over these VPLs",
        "tashika render &#x27;a b&#x27;",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // One pixel is out of budget but has an interval: a half-width of 0.02, relative to a luminance
    // of 2 to 2.1.
    film.plane_mut("claim").unwrap().set_u32(11, 4, &[3]);
    let page = rendered(&film);
    for words in [
        "90.0 % of 10 pixels claim to be within 2 % of the sum over its VPLs at 95 % confidence, half of the others to be within 1.00 %",
        "9 carry calibrated intervals",
        "1 ran out of budget, 1 with a wider interval",
    ] {
        assert!(page.contains(words), "{words}");
    }
    film.plane_mut("claim").unwrap().set_u32(11, 4, &[0]);
    film.plane_mut("stop").unwrap().set_u32(11, 4, &[5]);
    let page = rendered(&film);
    assert!(
        page.contains("90.0 % of 10 pixels claim")
            && page.contains("light was not found for 1: it comes over mirrors")
    );
    assert!(!page.contains("ran out of budget"));
    film.plane_mut("stop").unwrap().set_u32(11, 4, &[3]);
    for (x, y) in film.window().pixels().collect::<Vec<_>>() {
        film.plane_mut("claim").unwrap().set_u32(x, y, &[1]);
    }
    assert!(rendered(&film).contains("all 10 pixels are exact"));
    film.plane_mut("stop").unwrap().set_u32(7, 3, &[0]);
    assert!(rendered(&film).contains("NOT COMPLETE: 9 of 10 pixels were rendered."));
    for (x, y) in film.window().pixels().collect::<Vec<_>>() {
        film.plane_mut("claim").unwrap().set_u32(x, y, &[0]);
    }
    assert!(rendered(&film).contains("9 pixels, about whose error nothing is claimed"));
}

/// All pixels make published claims. The page states them as published, and does not call them
/// kept: only a page with a reference may do so.
#[test]
fn published_claims_are_told_as_such_and_none_is_called_kept() {
    let mut film = film(5, 2);
    for (x, y) in film.window().pixels().collect::<Vec<_>>() {
        film.plane_mut(planes::CLAIM).unwrap().set_u32(x, y, &[Claim::Published.id()]);
        film.plane_mut(planes::STOP).unwrap().set_u32(x, y, &[Stop::RuleMet.id()]);
    }
    let published = "all 10 pixels claim, as their method was published, to be within 2 % of the sum over its VPLs at 95 % confidence";
    assert!(headline(&film).ends_with(published), "{}", headline(&film));
    film.metadata_mut().set(keys::ERROR_ABSOLUTE, 0.5);
    film.metadata_mut().set(keys::CONTROL, "channels");
    let dark = "within 2 % of the sum over its VPLs, or 0.50 W·m⁻²·sr⁻¹ where it is dark, in each channel at 95 % confidence";
    assert!(headline(&film).ends_with(dark), "{}", headline(&film));
    let body = rendered(&film);
    let told = body.split("<script").next().unwrap();
    assert!(!told.contains("kept") && !told.contains("keep"), "{told}");
    film.metadata_mut().set(keys::AUDIT_WITHIN, 9_u32);
    film.metadata_mut().set(keys::AUDIT_OF, 10_u32);
    assert!(rendered(&film).contains("An audit found 9 of 10 pixels at random within the error."));
}

/// The page of an audited picture states the claim about the whole picture, and plots the possible
/// errors of the audited pixels.
#[test]
fn audited_pictures_are_told_as_a_whole() {
    let mut film = film(5, 2);
    assert!(rendered::plots(&film).iter().all(|plot| plot.name != "audited"));
    let claim = PictureClaim {
        error: 0.1,
        share: 0.9,
        assurance: 0.95,
        audited: 2,
        outside: 1,
        upper_outside: 0.99,
        reached: false,
        population: 10,
        looks: 1,
        passes: 3,
    };
    claim.describe(film.metadata_mut());
    let [first, second] = [0, 1].map(|k| film.window().pixels().nth(k).unwrap());
    let mut samples = vec![0.0; 3 * film.window().area() as usize];
    samples[..6].copy_from_slice(&[0.9, 1.1, 1.0, 2.0, 4.0, 2.0]);
    film.add_plane(&planes::AUDITED, Samples::F32(samples));
    for (x, y) in [first, second] {
        film.plane_mut(planes::RADIANCE).unwrap().set_f32(x, y, &[1.0; 3]);
        film.plane_mut(planes::HALF_WIDTH).unwrap().set_f32(x, y, &[0.5]);
    }
    assert!(
        headline(&film).ends_with("2 pixels were checked, 1 were not certainly within"),
        "{}",
        headline(&film)
    );
    let page = rendered(&film);
    assert!(page.contains("The aim is 90 % of the pixels") && !page.contains("ran out of budget"));
    assert!(page.contains("There is no map of half-widths") && !page.contains("do not rely on"));
    let plot = rendered::plots(&film).into_iter().find(|plot| plot.name == "audited").unwrap();
    // Errors of 0.1 and of 3, over a half-width of 0.5.
    let ratios: Vec<f64> =
        plot.csv.lines().skip(1).map(|line| line.split(',').nth(1).unwrap().parse().unwrap()).collect();
    assert!((ratios[0] - 0.2).abs() < 1e-6 && (ratios[1] - 6.0).abs() < 1e-6, "{}", plot.csv);
}

/// Pages have the half-widths if there are any, otherwise the standard error.
#[test]
fn a_page_without_a_map_has_standard_errors() {
    let size = [3, 1];
    let mut film = Film::new(size, Window::full(size), PixelRecord::PLANES).unwrap();
    let record = PixelRecord { standard_error: 0.1, stop: Stop::SampleCount, ..PixelRecord::default() };
    film.window().pixels().for_each(|(x, y)| record.store(&mut film, x, y));
    let names = |film: &Film| -> Vec<String> {
        let planes = data(&rendered(film))["images"][0]["planes"].as_array().unwrap().clone();
        planes.iter().map(|plane| plane["name"].as_str().unwrap().to_owned()).collect()
    };
    let has = |film: &Film, name: &str| names(film).iter().any(|known| known == name);
    assert!(has(&film, "standard_error") && !has(&film, "half_width"));
    PixelRecord { claim: Claim::Calibrated, half_width: 0.2, ..record }.store(&mut film, 1, 0);
    assert!(!has(&film, "standard_error") && has(&film, "half_width"));
}

/// All names that scripts use are in the tables, and scripts contain no name of a plane themselves.
#[test]
fn scripts_know_planes_codes_and_metadata_from_the_tables_alone() {
    let record = record_script::record();
    let mut asked = 0;
    for script in SCRIPTS {
        for (prefix, table) in [
            ("PLANE.", "plane"),
            ("KEY.", "key"),
            ("Record.plane.", "plane"),
            ("Record.key.", "key"),
            ("Record.claim.", "claim"),
            ("Record.stop.", "stop"),
            ("Record.control.", "control"),
        ] {
            for rest in script.split(prefix).skip(1) {
                let name: String =
                    rest.chars().take_while(|c| c.is_ascii_alphanumeric() || *c == '_').collect();
                assert!(!record[table][&name].is_null(), "{prefix}{name} is in no table");
                asked += 1;
            }
        }
        for row in SCHEMA.iter().filter(|row| !row.spec.name.is_empty()) {
            for quote in ['"', '\'', '`'] {
                let literal = format!("{quote}{}{quote}", row.spec.name);
                assert!(!script.contains(&literal), "{literal}: ask for Record.plane");
            }
        }
    }
    assert!(asked > 20, "{asked}");
    assert_eq!(record["plane"]["radiance"], "");
    assert_eq!((&record["claim"]["certified"], &record["stop"]["not_found"]), (&4.into(), &5.into()));
    let claim = SCHEMA.iter().position(|row| row.spec == planes::CLAIM).unwrap();
    assert_eq!(record["planes"][claim]["shown"]["code"][3]["label"], "calibrated");
}

#[test]
fn a_comparison_has_the_reference_beside_each_image_once() {
    let (film, mut reference) = (film(6, 4), film(6, 4));
    reference.plane_mut("").unwrap().set_f32(8, 4, &[1.0; 3]);
    let named = |name, film| Named { name: Path::new(name), film };
    let (a, b) = (named("a.exr", &film), named("b.exr", &reference));
    let comparison = compare(a, b, &Tolerance { relative: 0.02, absolute: 0.0 }).unwrap();
    let facts = CompareFacts { tolerance_from: ToleranceFrom::Asked, command: None, tone: Tone::Filmic };
    let page = compare_page(&comparison, a, b, &facts);
    assert!(page.contains("95.8 % of the pixels are within 2 % of the reference"));
    assert_eq!(page.matches("<option selected>filmic</option>").count(), 1);
    let held = data(&page);
    assert_eq!((held["tolerance"].as_f64(), held["images"].as_array().unwrap().len()), (Some(0.02), 1));
    let second = 24 + 7;
    assert_eq!(f32::from_bits(plane(&held["images"][0], "reference")[7]), 1.0);
    assert_eq!(
        f32::from_bits(plane(&held["images"][0], "reference")[second]),
        1.0,
        "in the second channel too"
    );

    let mut sheet = Page::new("both", "both");
    let shown = |label: &str, film| Shown { label: label.to_owned(), film, reference: Some(&reference) };
    sheet.images = Images::Embedded(vec![shown("a", &film), shown("b", &reference)]);
    let held = data(&sheet.html());
    let of_second = held["images"][1]["planes"].as_array().unwrap().last().unwrap();
    assert_eq!(
        (&of_second["name"], &of_second["same_as"], &of_second["data"]),
        (&"reference".into(), &0.into(), &Json::Null)
    );
}

/// The page states the origin of its tolerance, with separate words for each origin.
#[test]
fn a_comparison_says_where_its_tolerance_is_from() {
    let film = film(6, 4);
    let named = Named { name: Path::new("a.exr"), film: &film };
    let page = |tolerance_from, absolute| {
        let comparison = compare(named, named, &Tolerance { relative: 0.05, absolute }).unwrap();
        compare_page(
            &comparison,
            named,
            named,
            &CompareFacts { tolerance_from, command: None, tone: Tone::default() },
        )
    };
    for (from, words) in [
        (ToleranceFrom::Asked, "The tolerance of 5 % is what was asked for."),
        (ToleranceFrom::Image, "The tolerance of 5 % is the error that the image was rendered to."),
        (ToleranceFrom::Default, "The tolerance of 5 % is the default: none was asked for"),
    ] {
        assert!(page(from, 0.0).contains(words), "{words}");
    }
    let dark = "The tolerance of 5 %, or 0.5 W·m⁻²·sr⁻¹ where it is dark, is what was asked for.";
    assert!(page(ToleranceFrom::Asked, 0.5).contains(dark));
}

/// Without scripts the page shows the picture that the scripts begin with. The picture precedes the
/// controls either way, and the page explains its own terms.
#[test]
fn the_picture_comes_first_and_needs_no_scripts() {
    let film = film(900, 700);
    let page = rendered(&film);
    let held = page.split("src=\"data:image/png;base64,").nth(1).unwrap().split('"').next().unwrap();
    let picture = image::load_from_memory(&STANDARD.decode(held).unwrap()).unwrap().into_rgba8();
    assert_eq!(picture.dimensions(), (450, 350), "a pixel of each block");
    let reference = page_tone_of_two();
    assert!(picture.pixels().all(|p| p.0[..3].iter().all(|v| v.abs_diff(reference) <= 1)), "{reference}");
    let at = |words: &str| page.find(words).unwrap_or_else(|| panic!("{words} is not there"));
    assert!(at("<noscript><img") < at("<canvas") && at("<canvas") < at("<div class=\"bar\">"));
    assert!(at("<div class=\"bar\">") < at("<h2>Summary"));
    for word in ["half-width", "claim", "pair"] {
        assert!(page.contains(&format!("<dt>{word}</dt>")), "{word}");
    }
    let served = Page { images: Images::Served { nonce: "n".to_owned() }, ..Page::new("a", "b") };
    assert!(served.html().contains("The image needs JavaScript") && !served.html().contains("id=\"still\""));
}

/// The 8-bit code of a film of constant 2, whose log-average becomes middle gray, in the tone of
/// [`rendered`].
fn page_tone_of_two() -> u8 {
    (255.0 * srgb_encode(Tone::Agx.display(Rgb::gray(0.18), 1.0).g)).round() as u8
}

#[test]
fn plots_hold_the_numbers_that_they_draw() {
    let errors = vec![0.01, 0.02, 0.04, f64::NAN, f64::INFINITY];
    let plot = Plot::shares("name", "caption", "x", &[("a, b".to_owned(), errors)], Some(0.02));
    let lines: Vec<&str> = plot.csv.lines().collect();
    assert_eq!(
        lines,
        ["series,error,share", "\"a, b\",0.01,0.25", "\"a, b\",0.02,0.5", "\"a, b\",0.04,0.75"]
    );
    assert!(plot.svg.starts_with("<svg") && plot.svg.contains("<polyline") && plot.svg.contains("2.00 %"));
    let plot = Plot::histogram("name", "caption", "x", &[1.0, 1.0, 100.0, 0.0], &|v| v.to_string());
    let counts: Vec<u64> =
        plot.csv.lines().skip(1).map(|l| l.rsplit(',').next().unwrap().parse().unwrap()).collect();
    assert_eq!(
        (counts[0], counts[47], counts.iter().sum::<u64>()),
        (2, 1, 3),
        "zero has no place on the axis"
    );
    let found = Measured { label: "<m>".to_owned(), series: 0, x: 10.0, share: 0.9, low: 0.8, high: 0.95 };
    let other = Measured { label: "n".to_owned(), series: 1, x: 20.0, ..found.clone() };
    let plot = Plot::measured("name", "caption", ("x", &|v| v.to_string()), &[found, other], Some(0.95));
    assert!(plot.csv.contains("<m>,10,0.9,0.8,0.95\n") && !plot.svg.contains("<m>"));
    // Plots without data do not fail.
    for plot in [
        Plot::shares("n", "c", "x", &[], None),
        Plot::histogram("n", "c", "x", &[], &|v| v.to_string()),
        Plot::measured("n", "c", ("x", &|v| v.to_string()), &[], None),
        Plot::growth("n", "c", "x", "y", &[]),
    ] {
        assert!(plot.svg.ends_with("</svg>\n"), "{}", plot.svg);
    }
}
