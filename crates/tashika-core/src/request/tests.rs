//! Defaults, given options, options without effect, and refused options.

use super::*;
use crate::film::Window;
use crate::scene::{Camera, builtin};

fn planned(request: &Request) -> Plan {
    request.plan_for_still_scene().unwrap()
}

fn refused(request: &Request) -> String {
    request.plan_for_still_scene().unwrap_err().to_string()
}

/// Returns a request with every option that can be given together.
fn all_said() -> Request {
    Request {
        claim: Some(ClaimName::Calibrated),
        truth: Some(Truth::Vpl),
        error: Some(0.1),
        control: Some(Controlled::Luminance),
        absolute: Some(0.5),
        confidence: Some(0.9),
        max_pairs: Some(7),
        paths: Some(5),
        vpls: Some(300),
        clamp: Some(Clamp::Off),
        instants: Some(8),
        gather: Some(3),
        filter: Some(Filter::Tent),
        seed: 9,
        ..Request::default()
    }
}

#[test]
fn what_is_not_said_is_the_default() {
    let options = ControlOptions::default();
    let lights = VplOptions::default();
    let ours = Plan {
        method: Method::Sum {
            method: SumMethod::Tashika(Promise::Calibrated),
            lights: Some(lights.clone()),
            options,
        },
        gather: GatherOptions::default(),
        unused: Vec::new(),
    };
    assert_eq!(planned(&Request::of_a_sum()), ours);
    let given = planned(&Request { lights_given: true, ..Request::default() });
    let method = SumMethod::Tashika(Promise::Calibrated);
    assert_eq!(given.method, Method::Sum { method, lights: None, options });
    let both = Request { lights_given: true, truth: Some(Truth::Transport), ..Request::default() };
    assert!(matches!(planned(&both).method, Method::Transport { lights: None, .. }));
    let certified = planned(&Request { claim: Some(ClaimName::Certified), ..Request::default() });
    assert!(matches!(certified.method, Method::Sum { .. }));

    let transport = Request { claim: Some(ClaimName::Calibrated), ..Request::default() };
    let of_sets = Plan {
        method: Method::Transport {
            lights: Some(VplOptions { count: 1_000_000, ..lights.clone() }),
            truth: Truth::Transport,
            options: ControlOptions { error: 0.05, ..options },
        },
        gather: GatherOptions { points: 51, ..GatherOptions::default() },
        unused: Vec::new(),
    };
    assert_eq!(planned(&transport), of_sets);
    // The counts follow the error, within limits.
    for (error, count, points) in
        [(0.02, 2_500_000, 128), (0.05, 1_000_000, 51), (0.5, 1_000_000, 32), (1e-3, 4_000_000, 256)]
    {
        let found = planned(&Request { error: Some(error), ..transport.clone() });
        let lights = Some(VplOptions { count, ..lights.clone() });
        let options = ControlOptions { error, ..options };
        let truth = Truth::Transport;
        assert_eq!(found.method, Method::Transport { lights, truth, options });
        assert_eq!(found.gather.points, points);
    }

    let path = Request { method: MethodName::Path, ..Request::default() };
    assert_eq!(planned(&path).method, Method::Path { stop: PathStop::Count(64) });
    let until = Request { error: Some(0.1), ..path };
    let told = ControlOptions { error: 0.1, ..options };
    let stop = PathStop::Until { options: told, first: 64, most: 1 << 20 };
    assert_eq!(planned(&until).method, Method::Path { stop });
    let named = Request { method: SumMethod::Tashika(Promise::Certified).into(), ..Request::default() };
    let both = Request { claim: Some(ClaimName::Calibrated), ..named };
    assert!(refused(&both).contains("tashika-certified"));
}

/// Without an error, the default method makes an audited picture, unless an option is set that only
/// claims about each pixel, or a number of paths, have.
#[test]
fn a_request_without_an_error_is_for_an_audited_picture() {
    let bare = Request::default();
    let Method::Audited { lights: Some(_), options, terms, passes: None } = planned(&bare).method else {
        panic!("{:?}", planned(&bare).method)
    };
    assert_eq!((options.error, terms), (0.1, AuditTerms::default()));
    let still_audited = [
        Request { absolute: Some(0.1), ..bare.clone() },
        Request { vpls: Some(1000), gather: Some(4), filter: Some(Filter::Tent), ..bare.clone() },
        Request { truth: Some(Truth::Transport), share: Some(0.9), ..bare.clone() },
        bare.by_paths(),
    ];
    assert!(still_audited.iter().all(|request| request.claim() == Some(ClaimName::Audited)));
    let of_pixels = [
        Request { error: Some(0.1), ..bare.clone() },
        Request { truth: Some(Truth::Vpl), ..bare.clone() },
        Request { control: Some(Controlled::Channels), ..bare.clone() },
        Request { confidence: Some(0.9), ..bare.clone() },
        Request { max_pairs: Some(9), ..bare.clone() },
        Request { paths: Some(9), ..bare.clone() },
        Request { lights_given: true, ..bare.clone() },
        Request { groups_asked: true, ..bare.clone() },
        Request { method: MethodName::Path, ..bare.clone() },
        Request { method: SumMethod::Mdlc.into(), ..bare.clone() },
    ];
    for request in of_pixels {
        assert_eq!(request.claim(), None, "{request:?}");
        assert!(!matches!(planned(&request).method, Method::Audited { .. }));
    }
}

/// A picture for which nothing else is set has a time limit in proportion to its pixels.
#[test]
fn bare_pictures_have_a_time_limit_by_their_pixels() {
    let bare = Request::default();
    let seconds = |pixels| bare.default_seconds(pixels).unwrap();
    assert_eq!([640 * 360, 1280 * 720, 16 * 9].map(seconds), [30.0, 120.0, 8.0]);
    for request in [
        Request { passes: Some(3), ..bare.clone() },
        Request { claim: Some(ClaimName::Audited), ..bare.clone() },
        Request { error: Some(0.1), ..bare.clone() },
    ] {
        assert_eq!(request.default_seconds(1000), None, "{request:?}");
    }
}

#[test]
fn passes_have_limits() {
    let with = |passes| Request { passes: Some(passes), ..Request::default() }.plan_for_still_scene();
    assert!(matches!(with(13).unwrap().method, Method::Audited { passes: Some(13), .. }));
    for passes in [0, 14, u64::MAX] {
        assert!(with(passes).unwrap_err().to_string().contains("1 to 13"));
    }
    let fixed = Request { passes: Some(3), ..Request::default() };
    assert!(fixed.check_passes(false, true).is_ok() && Request::default().check_passes(true, false).is_ok());
    for (has_time_limit, is_whole, said) in [(true, true, "with time"), (false, false, "with tiles")] {
        let refused = fixed.check_passes(has_time_limit, is_whole).unwrap_err().to_string();
        assert!(refused.starts_with("passes = 3") && refused.contains(said), "{refused}");
    }
}

#[test]
fn what_is_said_arrives() {
    let options = ControlOptions {
        error: 0.1,
        controlled: Controlled::Luminance,
        absolute_error: 0.5,
        confidence: 0.9,
        max_pairs: Some(7),
        seed: 9,
    };
    let lights = VplOptions { count: 300, clamp: Clamp::Off, instants: 8, seed: 9, ..VplOptions::default() };
    let found = planned(&all_said());
    let method = SumMethod::Tashika(Promise::Calibrated);
    assert_eq!(found.method, Method::Sum { method, lights: Some(lights.clone()), options });
    let gather = GatherOptions { points: 3, filter: Filter::Tent };
    assert_eq!((found.gather, found.unused), (gather, vec!["paths"]));

    let found = planned(&Request { truth: Some(Truth::Clamped), ..all_said() });
    let truth = Truth::Clamped;
    assert_eq!(found.method, Method::Transport { lights: Some(lights), truth, options });
    assert_eq!((found.gather, found.unused), (gather, vec!["instants", "paths"]));

    let of_paths = Request { method: MethodName::Path, ..all_said() };
    let stop = PathStop::Calibrated { options, most: 5 };
    assert_eq!(planned(&of_paths).method, Method::Path { stop });
    let found = planned(&Request { claim: Some(ClaimName::Certified), ..of_paths });
    let stop = PathStop::Until { options, first: 5, most: 5 };
    assert_eq!(found.method, Method::Path { stop });
    assert_eq!(found.gather.filter, Filter::Tent);
    assert_eq!(found.unused, ["vpls", "clamp", "instants", "gather", "claim", "truth", "max_pairs"]);

    let certified = Request { claim: Some(ClaimName::Certified), lights_given: true, ..Request::default() };
    let method = SumMethod::Tashika(Promise::Certified);
    let options = ControlOptions::default();
    assert_eq!(planned(&certified).method, Method::Sum { method, lights: None, options });
}

/// The number of VPLs of an audited picture rises as its error falls, within limits.
#[test]
fn audited_pictures_have_vpls_by_their_error() {
    let audited = Request { claim: Some(ClaimName::Audited), ..Request::default() };
    for (error, expected) in [
        (None, 250_000),
        (Some(0.3), 250_000),
        (Some(0.05), 1_000_000),
        (Some(0.04), 1_562_500),
        (Some(1e-3), 4_000_000),
    ] {
        let Method::Audited { lights: Some(lights), .. } =
            planned(&Request { error, ..audited.clone() }).method
        else {
            panic!("{error:?} is by paths alone")
        };
        assert_eq!(lights.count, expected, "{error:?}");
    }
}

/// Requests for a scene that needs paths. Path tracing replaces the default method, and makes the
/// requested claim if it can.
#[test]
fn what_is_claimed_is_kept_by_paths_where_nothing_else_can() {
    let claimed = |claim: Option<ClaimName>| Request { claim, ..Request::default() }.by_paths();
    let found = planned(&claimed(Some(ClaimName::Calibrated)));
    let Method::Path { stop: PathStop::Calibrated { options, .. } } = found.method else {
        panic!("{:?} claims nothing", found.method)
    };
    assert_eq!((options.error, &*found.unused), (0.05, [].as_slice()));
    let found = planned(&claimed(None));
    assert!(matches!(found.method, Method::Audited { lights: None, .. }) && found.unused.is_empty());
    let counted = Request { paths: Some(8), ..Request::default() };
    let stop = PathStop::Count(8);
    assert_eq!(planned(&counted.by_paths()).method, Method::Path { stop });
    let within = planned(&Request { error: Some(0.02), ..counted }.by_paths());
    assert!(matches!(within.method, Method::Path { stop: PathStop::Calibrated { most: 8, .. } }));
    let audited = Request { error: Some(0.2), ..claimed(Some(ClaimName::Audited)) };
    let found = planned(&audited);
    let Method::Audited { lights: None, options, terms, .. } = found.method else {
        panic!("{:?} sums over VPLs", found.method)
    };
    assert_eq!((options.error, terms, found.unused), (0.2, AuditTerms::default(), Vec::new()));
    let unused_options = Request { paths: Some(8), vpls: Some(100), confidence: Some(0.9), ..audited };
    assert_eq!(planned(&unused_options).unused, ["vpls", "paths", "confidence"]);
    let certified = claimed(Some(ClaimName::Certified));
    assert_eq!(certified.method, MethodName::default(), "paths prove nothing");
    let published = Request { method: SumMethod::Iwasaki2019.into(), ..Request::default() };
    assert_eq!(published.by_paths(), published);
}

#[test]
fn each_method_says_what_means_nothing_to_it() {
    let unused = |method, error| planned(&Request { method, error, ..all_said() }).unused;
    let ours_alone = ["control", "absolute"];
    let of_ours = ["claim"];
    let exact = [&["paths", "error"][..], &ours_alone, &["confidence"], &of_ours, &["max_pairs"]].concat();
    assert_eq!(unused(SumMethod::Exact.into(), Some(0.1)), exact);
    for method in [SumMethod::Lightcuts, SumMethod::Mdlc] {
        assert_eq!(
            unused(method.into(), None),
            [&["paths"][..], &ours_alone, &["confidence"], &of_ours].concat()
        );
    }
    for method in [SumMethod::Nabata2016, SumMethod::Sakai2018, SumMethod::Iwasaki2019] {
        assert_eq!(unused(method.into(), None), [&["paths"][..], &ours_alone, &of_ours].concat());
    }
    let of_lights = ["vpls", "clamp", "instants", "gather"];
    let of_vpls = ["truth", "max_pairs"];
    assert_eq!(unused(MethodName::Path, None), [&of_lights[..], &of_vpls].concat());
    let counted = Request { method: MethodName::Path, error: None, claim: None, ..all_said() };
    let of_claims = [&ours_alone[..], &["confidence"]].concat();
    assert_eq!(planned(&counted).unused, [&of_lights[..], &of_claims, &of_vpls].concat());
    let given = Request { method: MethodName::Path, lights_given: true, ..Request::default() };
    assert_eq!(planned(&given).unused, ["lights"]);
    let estimated = |method, truth| planned(&Request { method, truth: Some(truth), ..Request::default() });
    let named = SumMethod::Mdlc.into();
    assert!(estimated(MethodName::Path, Truth::Transport).unused.is_empty(), "that is its truth");
    assert!(
        estimated(named, Truth::Vpl).unused.is_empty() && !estimated(named, Truth::Clamped).unused.is_empty()
    );
}

/// One request for each pair of contradicting options. Each is refused with the expected message.
#[test]
fn options_that_contradict_each_other_are_refused() {
    let bare = Request::default;
    let path = || Request { method: MethodName::Path, ..bare() };
    let exact = || Request { method: SumMethod::Exact.into(), ..bare() };
    let mdlc = || Request { method: SumMethod::Mdlc.into(), ..bare() };
    let audited = || Request { claim: Some(ClaimName::Audited), ..bare() };
    let within = || Request { error: Some(0.1), ..bare() };
    let refused = |request: Request| request.check().unwrap_err().to_string();
    for (request, said) in [
        (Request { vpls: Some(7), ..path() }, "vpls = 7; expected none with method path"),
        (Request { clamp: Some(Clamp::Off), ..path() }, "clamp = off; expected none with method path"),
        (Request { gather: Some(7), ..path() }, "gather = 7; expected none with method path"),
        (Request { lights_given: true, ..path() }, "lights = given ones; expected none with method path"),
        (Request { instants: Some(7), ..path() }, "instants = 7; expected none with method path"),
        (Request { instants: Some(7), ..bare() }, "instants = 7; expected none with truth transport"),
        (Request { paths: Some(7), ..mdlc() }, "paths = 7; expected none with method mdlc"),
        (Request { paths: Some(7), ..audited() }, "paths = 7; expected none with claim audited"),
        (Request { error: Some(0.5), ..exact() }, "error = 0.5; expected none with method exact"),
        (Request { control: Some(Controlled::Channels), ..mdlc() }, "control = channels; expected none"),
        (Request { absolute: Some(0.5), ..path() }, "absolute = 0.5; expected none with method path, unless"),
        (
            Request { confidence: Some(0.5), ..path() },
            "confidence = 0.5; expected none with method path, unless",
        ),
        (Request { confidence: Some(0.5), ..mdlc() }, "confidence = 0.5; expected none with method mdlc"),
        (
            Request { confidence: Some(0.5), ..audited() },
            "confidence = 0.5; expected none with claim audited",
        ),
        (Request { share: Some(0.5), ..within() }, "share = 0.5; expected none without claim audited"),
        (
            Request { assurance: Some(0.5), ..within() },
            "assurance = 0.5; expected none without claim audited",
        ),
        (Request { passes: Some(5), ..within() }, "passes = 5; expected none without claim audited"),
        (
            Request { claim: Some(ClaimName::Certified), ..path() },
            "claim = certified; expected none with method path",
        ),
        (
            Request { claim: Some(ClaimName::Calibrated), ..mdlc() },
            "claim = calibrated; expected none with method mdlc",
        ),
        (
            Request { truth: Some(Truth::Transport), ..mdlc() },
            "truth = transport; expected vpl with method mdlc",
        ),
        (Request { truth: Some(Truth::Vpl), ..path() }, "truth = vpl; expected transport with method path"),
        (Request { max_pairs: Some(7), ..exact() }, "max_pairs = 7; expected none with method exact"),
        (Request { max_pairs: Some(7), ..audited() }, "max_pairs = 7; expected none with claim audited"),
        (Request { audit: Some(7), ..exact() }, "audit = 7; expected none with method exact"),
        (
            Request { audit: Some(7), paths: Some(8), ..path() },
            "audit = 7; expected none with method path, unless",
        ),
    ] {
        let found = refused(request);
        assert!(found.starts_with(said), "{found}, not {said}");
    }
    assert!(
        within().check_audited("time", "5s").unwrap_err().to_string().starts_with("time = 5s; expected none")
    );
    assert!([audited(), bare()].iter().all(|request| request.check_audited("time", "5s").is_ok()));
    for goes in [
        Request { error: Some(0.5), paths: Some(9), audit: Some(9), ..path() },
        Request { paths: Some(7), groups_asked: true, ..bare() },
        Request { truth: Some(Truth::Transport), ..path() },
        Request { audit: Some(9), ..mdlc() },
        bare(),
    ] {
        goes.check().unwrap();
    }
}

/// Options that have no effect because of the scene are reported; options that have no effect in
/// any scene are refused.
#[test]
fn a_scene_may_leave_an_option_without_meaning() {
    let still = builtin::tiny();
    let request = Request { paths: Some(7), ..Request::default() };
    request.check().unwrap();
    let said = request.check_in(&still).unwrap_err().to_string();
    assert!(said.starts_with("paths = 7; expected none with method tashika"), "{said}");
    let vpls = Request { vpls: Some(7), ..Request::default() };
    assert!(vpls.check_in(&still).unwrap().is_empty());
    assert_eq!(vpls.by_paths().unused(), ["vpls"]);
}

#[test]
fn a_quality_is_refused_beside_what_it_cannot_be() {
    let of = |request: Request, quality| request.with_quality(quality).map_err(|error| error.to_string());
    let claiming = |claim| Request { claim: Some(claim), ..Request::default() };
    let said = of(claiming(ClaimName::Calibrated), Quality::Draft).unwrap_err();
    assert!(said.starts_with("quality = draft; expected none with claim calibrated"), "{said}");
    let said = of(claiming(ClaimName::Audited), Quality::Final).unwrap_err();
    assert!(said.starts_with("quality = final; expected none with claim audited"), "{said}");
    let by = |method| Request { method, ..Request::default() };
    for quality in Quality::ALL {
        let said = of(by(SumMethod::Lightcuts.into()), quality).unwrap_err();
        assert!(said.contains("expected none with method lightcuts"), "{said}");
        assert!(of(by(MethodName::Path), quality).is_ok());
    }
    let certified = SumMethod::Tashika(Promise::Certified);
    let whole = of(by(certified.into()), Quality::Final).unwrap();
    let Method::Sum { method, options, .. } = planned(&whole).method else { panic!("{whole:?}") };
    assert_eq!((method, options.error), (certified, 0.02));
    assert!(of(by(certified.into()), Quality::Good).is_err());
    let own = of(Request { error: Some(0.3), ..Request::default() }, Quality::Good).unwrap();
    assert_eq!((own.error, own.claim), (Some(0.3), Some(ClaimName::Audited)), "the number may be said");
}

#[test]
fn what_does_not_go_together_is_refused() {
    let transport = Request { truth: Some(Truth::Transport), ..Request::default() };
    let certified = Request { claim: Some(ClaimName::Certified), ..transport };
    assert!(refused(&certified).contains("claim = certified; expected calibrated with truth transport"));
    let path = Request { method: MethodName::Path, ..Request::default() };
    assert!(
        refused(&Request { paths: Some(0), ..path.clone() }).contains("paths = 0; expected 1 to 4294967295")
    );
    assert!(refused(&Request { paths: Some(1 << 32), ..path }).contains("paths = 4294967296"));
    let bare = Request::default;
    assert!(refused(&Request { gather: Some(1 << 33), ..bare() }).contains("1 to 1024"));
    assert!(refused(&Request { vpls: Some(0), ..bare() }).contains("vpls = 0"));
    assert!(refused(&Request { error: Some(0.0), ..bare() }).contains("error = 0"));
}

#[test]
fn a_camera_that_shows_a_box_stands_where_the_size_asks() {
    let bounds = builtin::tiny().bounds();
    let overview = Camera::overview(bounds);
    let at = |size: [u32; 2]| Framing { size: Some(size), crop: None }.of(&overview).unwrap().camera;
    assert_eq!(at([100, 300]), overview.of_size([100, 300]));
    assert_ne!(at([100, 300]).position(), at([300, 100]).position());
    let unsaid = Framing::default().of(&overview).unwrap();
    assert_eq!((unsaid.size, unsaid.camera), ([640, 360], overview.of_size([640, 360])));
}

#[test]
fn the_frame_is_what_was_said_or_the_camera_says() {
    let mut camera = builtin::tiny().cameras()[0].clone();
    camera.resolution = None;
    camera.crop = None;
    let of = |size, crop, camera: &Camera| {
        let framed = Framing { size, crop }.of(camera).unwrap();
        (framed.size, framed.window)
    };
    let window = |x, y, width, height| Window { x, y, width, height };
    assert_eq!(of(None, None, &camera), ([640, 360], Window::full([640, 360])));
    camera.resolution = Some([100, 80]);
    camera.crop = Some(Window { x: 10, y: 20, width: 30, height: 40 });
    assert_eq!(of(None, None, &camera), ([100, 80], window(10, 20, 30, 40)));
    assert_eq!(
        of(Some([50, 40]), None, &camera),
        ([50, 40], Window::full([50, 40])),
        "its crop is in other pixels"
    );
    assert_eq!(of(None, Some(window(1, 2, 3, 4)), &camera), ([100, 80], window(1, 2, 3, 4)));
    assert!(Framing { size: None, crop: Some(window(90, 0, 11, 1)) }.of(&camera).is_err());
    let huge = Camera { resolution: Some([1 << 16; 2]), crop: None, ..camera.clone() };
    let error = Framing::default().of(&huge).unwrap_err().to_string();
    assert!(error.starts_with(&format!("camera {}: a film of 65536x65536; expected", huge.name)), "{error}");
    let error = Framing { size: Some([1 << 16; 2]), crop: None }.of(&huge).unwrap_err().to_string();
    assert!(error.starts_with("size = 65536x65536"), "{error}");
    assert!(
        Framing { size: None, crop: Some(window(90, 0, 11, 1)) }.check().is_ok(),
        "the camera may be larger"
    );
    assert!(Framing { size: Some([100, 80]), crop: Some(window(90, 0, 11, 1)) }.check().is_err());
}
