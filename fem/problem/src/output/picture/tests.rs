//! Whole pictures: size, contents, determinism, errors.

use std::num::NonZeroUsize;

use forms_pictures::{png_file, svg_file};

use super::*;
use crate::element::CellShape;
use crate::field::Field;
use crate::mesh::{self, Mesh};
use crate::space::Space;

fn annulus() -> (Mesh<2>, Field<2>) {
    let mesh = mesh::annulus(20.0, 30.0, 2, 16, CellShape::Quadrilateral, 2).unwrap();
    let field =
        Field::interpolate(&Space::vector(&mesh, 2).unwrap(), |x| [0.05 * x[0], -0.05 * x[1]]).unwrap();
    (mesh, field)
}

/// Width, height and RGB of a PNG file's bytes.
fn decode(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let frame = reader.next_frame(&mut pixels).unwrap();
    (frame.width as usize, frame.height as usize, pixels)
}

/// Places at which the annulus of radii 20 and 30 is coloured and the page is white, read from the picture.
#[test]
fn the_body_is_where_it_should_be() {
    let (mesh, _) = annulus();
    let map = FieldMap::cell_by_cell(&mesh, |_, _| 3.0, "constant")
        .without_axes()
        .without_mesh_lines()
        .window([-40.0, 40.0], [-40.0, 40.0])
        .size(160.0, 160.0);
    let drawing = map.draw().unwrap();
    let (width, height, pixels) = decode(&png_file::encode(&drawing, 144.0, NonZeroUsize::MIN).unwrap());
    assert_eq!([width as f64, height as f64], drawing.size().map(|length| (2.0 * length).round()));
    // 160 pt for 80 units at 2 pixels per point: 4 pixels per unit, from the corner of the window.
    let [left, top] = [GAP_OF_LAYOUT, 1.5 * GAP_OF_LAYOUT];
    let middle = ColourMap::Viridis.at(0.5).rgb;
    for (x, y, inside) in [
        (0.0, 0.0, false),
        (25.0, 0.0, true),
        (0.0, -25.0, true),
        (-17.0, 17.0, true),
        (-21.5, -21.5, false),
        (19.0, 0.0, false),
        (-12.0, 12.0, false),
    ] {
        let column = ((left + 2.0 * (x + 40.0)) * 2.0) as usize;
        let row = ((top + 2.0 * (40.0 - y)) * 2.0) as usize;
        let pixel = &pixels[3 * (row * width + column)..][..3];
        let expected = if inside { middle } else { [255; 3] };
        assert!(pixel.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1), "({x}, {y}): {pixel:?}");
    }
}

/// The distance between neighbouring things in a layout \[pt\].
const GAP_OF_LAYOUT: f64 = axes::GAP;

#[test]
fn pictures_are_deterministic_in_both_formats() {
    let (mesh, field) = annulus();
    let panel = || {
        let map = FieldMap::of(&field, Shown::Magnitude, "‖u‖ [mm]").deformed(&field, 2.0);
        let map = map.undeformed_outline("before").arrows(&field, "u", "mm").levels(9).title("Annulus");
        let regions = MeshDrawing::new(&mesh).all_regions().cell_region("all").unwrap();
        Panel::new(2)
            .picture(&map)
            .unwrap()
            .picture(&regions)
            .unwrap()
            .letters()
            .title("Panel")
            .draw()
            .unwrap()
    };
    let [first, second] = [panel(), panel()].map(|drawing| {
        (png_file::encode(&drawing, 72.0, NonZeroUsize::MIN).unwrap(), svg_file::encode(&drawing).unwrap())
    });
    assert_eq!(first, second);
    let (width, height, pixels) = decode(&first.0);
    assert_eq!([width as f64, height as f64], panel().size().map(f64::round));
    let coloured = pixels.chunks(3).filter(|pixel| *pixel != [255, 255, 255]).count();
    assert!(coloured * 10 > width * height, "{coloured} of {} pixels", width * height);
    assert!(first.1.starts_with("<svg") && first.1.ends_with("</svg>\n"));
    assert!(first.1.contains("<image"));
    let mut vectors = first.1.lines().filter(|line| !line.starts_with("<image"));
    assert!(vectors.all(|line| !line.contains("NaN") && !line.contains("inf")));
}

/// Everything that a body's picture writes stays on the page.
#[test]
fn nothing_leaves_the_page() {
    let (_, field) = annulus();
    for (shown, label) in
        [(Shown::Component(0), "u_{x} [mm]"), (Shown::Magnitude, "a much longer label [mm]")]
    {
        let map = FieldMap::of(&field, shown, label).deformed(&field, 2.0).title("Title of the picture");
        let drawing = map.line(&[[-40.0, -33.0], [40.0, -33.0]], "obstacle", Colour::BLACK).draw().unwrap();
        let [width, height] = drawing.size();
        for item in drawing.items() {
            let drawing::Item::Path { segments, clip: None, .. } = item else { continue };
            for segment in segments {
                let (path::Segment::Move([x, y]) | path::Segment::Line([x, y])) = *segment else {
                    continue;
                };
                assert!((0.0..=width).contains(&x) && (0.0..=height).contains(&y), "({x}, {y})");
            }
        }
    }
}

#[test]
fn bad_data_are_named() {
    let (mesh, field) = annulus();
    let map = FieldMap::cell_by_cell(&mesh, |cell, _| if cell == 7 { f64::NAN } else { 1.0 }, "pressure");
    assert_eq!(map.draw().err().unwrap().to_string(), "\"pressure\" is NaN in cell 7, which cannot be drawn");
    let map = FieldMap::of(&field, Shown::Component(2), "u_{z}");
    assert!(matches!(map.draw(), Err(PictureError::Length { expected: 3, found: 2, .. })));
    let scalar = Field::interpolate(&Space::scalar(&mesh, 1).unwrap(), |x| x[0]).unwrap();
    let map = FieldMap::of(&field, Shown::Magnitude, "u").deformed(&scalar, 1.0);
    assert!(matches!(map.draw(), Err(PictureError::Length { expected: 2, found: 1, .. })));
    let small = mesh::annulus(1.0, 2.0, 1, 8, CellShape::Triangle, 1).unwrap();
    let other = Field::zero(&Space::vector(&small, 1).unwrap());
    let map = FieldMap::of(&field, Shown::Magnitude, "u").arrows(&other, "elsewhere", "mm");
    assert!(matches!(map.draw(), Err(PictureError::OtherMesh { name }) if name == "elsewhere"));
    assert!(matches!(MeshDrawing::new(&mesh).region("nowhere"), Err(PictureError::Mesh(_))));
    let map = FieldMap::of(&field, Shown::Magnitude, "u").window([1.0, 1.0], [0.0, 1.0]);
    assert!(matches!(map.draw(), Err(PictureError::Range { .. })));
    assert!(matches!(Panel::new(2).draw(), Err(PictureError::Empty { .. })));
}

/// A directory that cannot be made: the error names the file.
#[test]
fn files_that_cannot_be_written_are_named() {
    let (mesh, _) = annulus();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml").join("mesh.png");
    let error = MeshDrawing::new(&mesh).write_png(&path).unwrap_err();
    assert!(error.to_string().contains("mesh.png"), "{error}");
    assert!(MeshDrawing::new(&mesh).write_png_at(&path, f64::NAN).is_err());
}
