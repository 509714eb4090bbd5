//! Tests the pages and panels that a participant sees, drawn for a headset and for a desktop: they must fit, be large
//! enough and have the right buttons. The pictures are kept so that people can look at them. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::path::PathBuf;
use std::rc::Rc;

use cyclopean::display::content::Content;
use cyclopean::display::panel::{DrawnView, Panel, View, em_px};
use cyclopean::gpu::{Buffer, Frame, Gpu, GpuOptions, OwnDevice};
use cyclopean::study::content::content;
use cyclopean::study::language::LanguageError;
use cyclopean::study::protocol::{Input, Page, Screen, Setup};
use cyclopean::study::{Plan, validate};
use cyclopean_analysis::journal::record::{Kind, Shown, Trust};

/// The folder in which the pictures are kept.
fn gallery() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("panel");
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn gpu() -> Rc<Gpu> {
    Gpu::open(&OwnDevice::default(), &GpuOptions::from_environment()).unwrap()
}

fn load(name: &str, language: &str, kind: Kind) -> Content {
    try_load(name, language, kind).unwrap()
}

fn try_load(name: &str, language: &str, kind: Kind) -> Result<Content, LanguageError> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("studies/{name}.json"));
    let mut study = validate::load(&path).unwrap();
    study.definition.language = language.to_owned();
    let plan = Plan::draw(&study.definition, 0);
    let setup = Setup::new(&study.definition, &plan, 60.0, Trust::Predicted, 90.0);
    content(&study, &plan, &setup, kind)
}

struct Picture {
    drawn: DrawnView,
    /// The left and the right eye's picture.
    eyes: [image::RgbaImage; 2],
}

fn draw(gpu: &Rc<Gpu>, panel: &mut Panel, content: &Content, view: &View, size: (u32, u32)) -> Picture {
    let image = panel.image(size.0, size.1).unwrap();
    let drawn = panel.draw(content, view, &image).unwrap();
    let bytes = u64::from(size.0 * size.1 * 4);
    let buffer = Buffer::readback(gpu, "picture", 2 * bytes).unwrap();
    let mut frame = Frame::begin(gpu).unwrap();
    frame.copy_image(&image, &buffer);
    frame.finish().unwrap();
    let all = buffer.read();
    let eye = |i: usize| {
        let half = &all[i * bytes as usize..(i + 1) * bytes as usize];
        image::RgbaImage::from_raw(size.0, size.1, half.to_vec()).unwrap()
    };
    Picture { drawn, eyes: [eye(0), eye(1)] }
}

fn panel(chosen: Option<u32>, reminder: bool) -> Screen {
    Screen::Panel { presentation: 5, attempt: 0, chosen, reminder }
}

/// Every kind of screen in a session, with a name for its picture.
fn views(content: &Content) -> Vec<(String, View)> {
    let mut all: Vec<(String, View)> =
        Page::ALL.iter().map(|&p| (p.phase().to_owned(), View::of(&Screen::Page(p)))).collect();
    for at in [0, 3, 8] {
        if at < content.items.len() {
            all.push((format!("item-{at}"), View { hover: Some(1), ..View::of(&Screen::Item(at)) }));
        }
    }
    if !content.dots.is_empty() {
        all.push(("dots".to_owned(), View::of(&Screen::Dots(0))));
    }
    all.push(("blank".to_owned(), View::of(&Screen::Blank)));
    all.push(("panel".to_owned(), View::of(&panel(None, false))));
    all.push(("panel-hover".to_owned(), View { hover: Some(2), ..View::of(&panel(None, false)) }));
    all.push(("panel-chosen".to_owned(), View::of(&panel(Some(1), false))));
    all.push(("panel-reminder".to_owned(), View { time_left_s: Some(85), ..View::of(&panel(Some(1), true)) }));
    let stimulus =
        Screen::Stimulus { presentation: 5, attempt: 0, show: Shown::B, stimulus: 0, reference: None, frame: 0 };
    all.push(("label".to_owned(), View::of(&stimulus)));
    all
}

#[test]
fn every_page_in_every_language_fits_and_is_written_large() {
    let gpu = gpu();
    let recommended = [("en", Kind::Real), ("de", Kind::Pilot), ("fr", Kind::Real), ("zh", Kind::Simulated)];
    let cases = recommended.map(|(l, k)| ("recommended", l, k)).into_iter().chain([("quality", "en", Kind::Real)]);
    for (study, language, kind) in cases {
        let content = match try_load(study, language, kind) {
            // This machine may lack a font for Chinese.
            Err(error @ LanguageError::Font { .. }) => {
                eprintln!("SKIPPED: {error}");
                continue;
            }
            other => other.unwrap(),
        };
        // A headset with 20 pixels per degree, on which the panel is 50° wide, and a desktop with 40.
        for (px_per_degree, size, keys) in [(20.0, (1000, 720), false), (40.0, (1280, 720), true)] {
            let mut panel = Panel::new(&gpu, px_per_degree, content.font.as_deref(), keys).unwrap();
            for (name, view) in views(&content) {
                let picture = draw(&gpu, &mut panel, &content, &view, size);
                let file = format!("{study}-{language}-{px_per_degree}-{name}.png");
                picture.eyes[0].save(gallery().join(&file)).unwrap();
                let drawn = &picture.drawn;
                assert!(
                    drawn.scale * em_px(px_per_degree) >= 20.0,
                    "{file}: the text is too small, at {} of its size",
                    drawn.scale
                );
                for target in &drawn.targets {
                    let [left, top, right, bottom] = target.rect;
                    assert!(left >= 0.0 && top >= 0.0 && right <= size.0 as f32 && bottom <= size.1 as f32, "{file}");
                    // A pointing hand trembles by about half a degree, which is 10 pixels on the headset. Buttons must
                    // be much larger.
                    assert!(right - left > 40.0 && bottom - top > 40.0, "{file}: {target:?}");
                }
                assert_eq!(drawn.is_stereo, picture.eyes[0] != picture.eyes[1], "{file}");
            }
        }
    }
    gpu.check_validation().unwrap();
}

#[test]
fn what_is_pointed_at_is_what_is_meant() {
    let gpu = gpu();
    let content = load("recommended", "en", Kind::Real);
    let mut drawer = Panel::new(&gpu, 20.0, None, false).unwrap();
    let mut inputs = |screen: &Screen| {
        let picture = draw(&gpu, &mut drawer, &content, &View::of(screen), (1000, 720));
        let middle = |r: [f32; 4]| [(r[0] + r[2]) / 2.0, (r[1] + r[3]) / 2.0];
        for (i, target) in picture.drawn.targets.iter().enumerate() {
            assert_eq!(picture.drawn.at(middle(target.rect)), Some(i));
        }
        assert_eq!(picture.drawn.at([2.0, 2.0]), None);
        picture.drawn.targets.into_iter().map(|t| t.input).collect::<Vec<_>>()
    };
    let choices: Vec<Input> = (0..5).map(Input::Choose).collect();
    // The button that confirms appears only after a choice.
    assert_eq!(inputs(&panel(None, false)), choices);
    assert_eq!(inputs(&panel(Some(0), false)), [choices.clone(), vec![Input::Confirm]].concat());
    assert_eq!(inputs(&Screen::Page(Page::Consent)), [Input::Continue, Input::Decline]);
    assert_eq!(inputs(&Screen::Dots(0)), choices[..4]);
    assert_eq!(inputs(&Screen::Item(8)), [choices[..4].to_vec(), vec![Input::Decline]].concat());
    assert!(inputs(&Screen::Blank).is_empty());
    gpu.check_validation().unwrap();
}

#[test]
fn the_ground_is_the_blank_grey_and_a_stereogram_keeps_its_dots() {
    let gpu = gpu();
    let content = load("recommended", "en", Kind::Real);
    let mut drawer = Panel::new(&gpu, 40.0, None, true).unwrap();
    let blank = draw(&gpu, &mut drawer, &content, &View::of(&Screen::Blank), (640, 480));
    let page = draw(&gpu, &mut drawer, &content, &View::of(&Screen::Page(Page::Thanks)), (640, 480));
    for picture in [&blank, &page] {
        assert_eq!(picture.eyes[0].get_pixel(5, 5).0, [128, 128, 128, 255]);
    }
    assert!(blank.eyes[0].get_pixel(320, 240).0[0] < 30, "there is no cross in the middle");

    let dots = &content.dots[0];
    let picture = draw(&gpu, &mut drawer, &content, &View::of(&Screen::Dots(0)), (1000, 720));
    for eye in 0..2 {
        let image = &picture.eyes[eye];
        let row = |x: u32, y: u32| {
            (0..dots.size as u32).all(|i| {
                let wanted = dots.eyes[eye][i as usize];
                image.get_pixel(x + i, y).0[0] == wanted
            })
        };
        let found = (0..720).flat_map(|y| (0..1000 - dots.size as u32).map(move |x| (x, y))).find(|&(x, y)| row(x, y));
        let (x, y) = found.expect("the first row of dots, pixel for pixel");
        for (i, &wanted) in dots.eyes[eye].iter().enumerate() {
            let at = (x + (i % dots.size) as u32, y + (i / dots.size) as u32);
            assert_eq!(image.get_pixel(at.0, at.1).0[0], wanted, "eye {eye} dot {i}");
        }
    }

    // Over a stimulus everything except the letter is transparent.
    let stimulus =
        Screen::Stimulus { presentation: 5, attempt: 0, show: Shown::A, stimulus: 0, reference: None, frame: 0 };
    let view = View { label_at: Some([320.0, 400.0]), ..View::of(&stimulus) };
    let label = draw(&gpu, &mut drawer, &content, &view, (640, 480));
    assert_eq!(label.eyes[0].get_pixel(5, 5).0, [0, 0, 0, 0]);
    let written: Vec<u32> = label.eyes[0].enumerate_pixels().filter(|(.., p)| p.0[3] > 0).map(|(_, y, _)| y).collect();
    assert!(!written.is_empty() && written.iter().all(|y| (340..460).contains(y)));
    gpu.check_validation().unwrap();
}
