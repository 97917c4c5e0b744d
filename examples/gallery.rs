//! Regenerates the pictures of README and of the documentation with the programs that draw them.
//!
//! `cargo run --release --bin gallery` runs them one after the other and puts their pictures into `docs/pictures`;
//! `-- --list` says which program makes which, `-- NAME ...` makes only some.
//! Large pictures are reduced to at most 150 kB, about the width of a page of the book.

use std::error::Error;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::Instant;

use clap::Parser;
use forms_examples::command_line::program_with_options;
use forms_fem::output::{StandardOutput, tell, write_whole};

/// Regenerates the pictures of README and of the documentation
#[derive(Parser)]
#[command(version, name = "gallery")]
struct Options {
    /// Names of pictures, without directory and ending; all where none is given
    names: Vec<String>,
    /// Lists the pictures with their programs
    #[arg(long)]
    list: bool,
}

/// A program and the pictures that it makes.
struct Maker {
    /// Arguments of cargo.
    arguments: &'static [&'static str],
    /// The files that it writes, with their names in `docs/pictures`.
    pictures: &'static [(&'static str, &'static str)],
}

/// A tutorial with its picture.
macro_rules! tutorial {
    ($program:literal, $number:literal) => {
        Maker {
            arguments: &["--bin", $program],
            pictures: &[(concat!("out/", $program, ".png"), concat!("tutorial_", $number, ".png"))],
        }
    };
}

const MAKERS: [Maker; 46] = [
    tutorial!("01_poisson", "01"),
    tutorial!("02_elasticity", "02"),
    tutorial!("03_neo_hookean", "03"),
    tutorial!("04_signorini", "04"),
    tutorial!("05_plasticity", "05"),
    tutorial!("06_stokes", "06"),
    tutorial!("07_interior_penalty", "07"),
    tutorial!("08_ghost_penalty", "08"),
    tutorial!("09_multiplier_contact", "09"),
    tutorial!("10_thermoelasticity", "10"),
    tutorial!("11_shape_derivative", "11"),
    Maker {
        arguments: &["--bin", "hollow_cylinder"],
        pictures: &[("out/displacement.png", "hollow_cylinder.png")],
    },
    Maker {
        arguments: &["--bin", "hertz", "--", "ball"],
        pictures: &[
            ("out/hertz_ball.png", "hertz_ball.png"),
            ("out/hertz_ball_surface.png", "hertz_ball_surface.png"),
            ("out/hertz_ball_section.png", "hertz_ball_section.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "hertz", "--", "block"],
        pictures: &[
            ("out/hertz_block.png", "hertz_block.png"),
            ("out/hertz_block_section.png", "hertz_block_section.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "half_spaces"],
        pictures: &[
            ("out/half_spaces_pressure.png", "half_spaces_pressure.png"),
            ("out/half_spaces_friction.png", "half_spaces_friction.png"),
            ("out/half_spaces_ball.png", "half_spaces_ball.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "bar_impact"],
        pictures: &[
            ("out/bar_impact_energy.png", "bar_impact_energy.png"),
            ("out/bar_impact_force.png", "bar_impact_force.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "rolling_ring"],
        pictures: &[
            ("out/rolling_ring.png", "rolling_ring.png"),
            ("out/rolling_ring_course.png", "rolling_ring_course.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "eigenmodes"],
        pictures: &[
            ("out/membrane_modes.png", "membrane_modes.png"),
            ("out/buckled_column.png", "buckled_column.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "topology"],
        pictures: &[
            ("out/topology.png", "topology.png"),
            ("out/topology_compliance.png", "topology_compliance.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "closing_c"],
        pictures: &[
            ("out/closing_c.png", "closing_c.png"),
            ("out/closing_c_animation.png", "closing_c_animation.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "rigid_punch"],
        pictures: &[
            ("out/rigid_punch.png", "rigid_punch.png"),
            ("out/rigid_punch_forces.png", "rigid_punch_forces.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "adaptive"],
        pictures: &[
            ("out/adaptive/adaptive_l_shape.png", "adaptive_l_shape.png"),
            ("out/adaptive/adaptive_l_shape_mesh.png", "adaptive_l_shape_mesh.png"),
            ("out/adaptive/adaptive_contact.png", "adaptive_contact.png"),
            ("out/adaptive/adaptive_contact_mesh.png", "adaptive_contact_mesh.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "adaptive_hertz", "--", "cylinder"],
        pictures: &[("out/adaptive_hertz/adaptive_hertz_cylinder.png", "adaptive_hertz_cylinder.png")],
    },
    Maker {
        arguments: &[
            "--bin",
            "adaptive_hertz",
            "--",
            "ball",
            "--uniform",
            "4",
            "--unknowns",
            "30000",
            "--linear",
            "multigrid",
        ],
        pictures: &[(
            "out/adaptive_hertz/adaptive_hertz_ball_contact.png",
            "adaptive_hertz_ball_contact.png",
        )],
    },
    Maker {
        arguments: &[
            "--bin",
            "adaptive_hertz",
            "--",
            "cut-cylinder",
            "--unknowns",
            "3300",
            "--uniform",
            "256",
        ],
        pictures: &[("out/adaptive_hertz/adaptive_hertz_cut.png", "adaptive_hertz_cut.png")],
    },
    Maker {
        arguments: &["--bin", "adaptive_cylinder", "--", "--unknowns", "12000", "--reference", "100000"],
        pictures: &[
            ("out/adaptive_cylinder/adaptive_cylinder.png", "adaptive_cylinder.png"),
            ("out/adaptive_cylinder/adaptive_cylinder_mesh.png", "adaptive_cylinder_mesh.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "shallow_ironing"],
        pictures: &[
            ("out/shallow_ironing.png", "shallow_ironing.png"),
            ("out/shallow_ironing_forces.png", "shallow_ironing_forces.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "pressed_ring"],
        pictures: &[
            ("out/pressed_ring.png", "pressed_ring.png"),
            ("out/pressed_ring_forces.png", "pressed_ring_forces.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "arch"],
        pictures: &[("out/arch.png", "arch.png"), ("out/arch_curves.png", "arch_curves.png")],
    },
    Maker {
        arguments: &["--bin", "half_ring"],
        pictures: &[
            ("out/half_ring.png", "half_ring.png"),
            ("out/half_ring_newton.png", "half_ring_newton.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "contact_bench", "--", "--problems", "wavy", "--levels", "2", "--degrees", "2"],
        pictures: &[("out/contact_bench/wavy_pressures.png", "contact_bench_pressures.png")],
    },
    Maker {
        arguments: &["--bin", "sealed_ring"],
        pictures: &[
            ("out/sealed_ring.png", "sealed_ring.png"),
            ("out/sealed_ring_forces.png", "sealed_ring_forces.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "die_on_slab"],
        pictures: &[
            ("out/die_on_slab.png", "die_on_slab.png"),
            ("out/die_on_slab_forces.png", "die_on_slab_forces.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "elastic_die"],
        pictures: &[
            ("out/elastic_die.png", "elastic_die.png"),
            ("out/elastic_die_forces.png", "elastic_die_forces.png"),
        ],
    },
    Maker {
        arguments: &[
            "--bin",
            "shape_optimisation",
            "--",
            "figure-6",
            "--wall",
            "0",
            "--remesh-below",
            "0",
            "--anew",
        ],
        pictures: &[
            ("out/shape_optimisation/figure_6.png", "figure_6.png"),
            ("out/shape_optimisation/figure_6_holes.png", "figure_6_holes.png"),
            ("out/shape_optimisation/adjoint_21/history.png", "figure_6_history.png"),
            ("out/shape_optimisation/adjoint_21/shapes.png", "figure_6_shapes.png"),
        ],
    },
    Maker {
        arguments: &[
            "--bin",
            "shape_optimisation",
            "--",
            "figure-6",
            "--steps",
            "150",
            "--anew",
            "--out",
            "out/shape_optimisation_wall",
        ],
        pictures: &[("out/shape_optimisation_wall/figure_6_holes.png", "figure_6_wall.png")],
    },
    Maker {
        arguments: &["--bin", "shape_optimisation", "--", "even-pressure", "--anew"],
        pictures: &[
            ("out/shape_optimisation/even_pressure.png", "even_pressure.png"),
            ("out/shape_optimisation/even_pressure_pressure.png", "even_pressure_pressure.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "shape_optimisation", "--", "cantilever", "--anew"],
        pictures: &[("out/shape_optimisation/cantilever.png", "cantilever.png")],
    },
    Maker {
        arguments: &["--bin", "level_set_bridge", "--", "--anew"],
        pictures: &[("out/level_set_bridge/level_set_bridge.png", "level_set_bridge.png")],
    },
    Maker {
        arguments: &["--bin", "level_set_cantilever", "--", "--anew"],
        pictures: &[("out/level_set_cantilever/level_set_cantilever.png", "level_set_cantilever.png")],
    },
    // Five minutes of processor time.
    Maker {
        arguments: &["--bin", "level_set_wheel", "--", "--anew"],
        pictures: &[("out/level_set_wheel/level_set_wheel.png", "level_set_wheel.png")],
    },
    // A minute of processor time.
    Maker {
        arguments: &["--bin", "rolling_wheel", "--", "--anew"],
        pictures: &[
            ("out/rolling_wheel/rolling_wheel.png", "rolling_wheel.png"),
            ("out/rolling_wheel/rolling_wheel_animation.png", "rolling_wheel_animation.png"),
        ],
    },
    Maker {
        arguments: &["--bin", "pressed_knot"],
        pictures: &[("out/pressed_knot/pressed_knot.png", "pressed_knot.png")],
    },
    // The bars of docs/speed.md, from its measurements in docs/*.csv.
    Maker {
        arguments: &["--bin", "speed_charts"],
        pictures: &[
            ("out/speed_kernels.png", "speed_kernels.png"),
            ("out/speed_assembly.png", "speed_assembly.png"),
        ],
    },
    // Six minutes, and 2.1 million unknowns.
    Maker {
        arguments: &[
            "--bin",
            "convergence",
            "--",
            "--reference",
            "128",
            "--coarsest",
            "8",
            "--theta",
            "-1",
            "--split",
        ],
        pictures: &[
            ("out/convergence/figure_3_left_theta_-1.png", "convergence_figure_3_left.png"),
            ("out/convergence/figure_3_left_theta_-1.svg", "convergence_figure_3_left.svg"),
            ("out/convergence/figure_3_left_theta_-1.csv", "convergence_figure_3_left.csv"),
            ("out/convergence/figure_3_right_theta_-1.png", "convergence_figure_3_right.png"),
            ("out/convergence/figure_3_right_theta_-1.svg", "convergence_figure_3_right.svg"),
            ("out/convergence/figure_3_right_theta_-1.csv", "convergence_figure_3_right.csv"),
            ("out/convergence/figure_4_left_theta_-1.png", "convergence_figure_4_left.png"),
            ("out/convergence/figure_4_right_theta_-1.png", "convergence_figure_4_right.png"),
            ("out/convergence/figure_4_right_theta_-1.svg", "convergence_figure_4_right.svg"),
            ("out/convergence/figure_4_right_theta_-1.csv", "convergence_figure_4_right.csv"),
            ("out/convergence/figure_5_theta_-1.png", "convergence_figure_5.png"),
            ("out/convergence/figure_5_theta_-1.svg", "convergence_figure_5.svg"),
            ("out/convergence/figure_5_theta_-1.csv", "convergence_figure_5.csv"),
            ("out/convergence/split_facets_theta_-1.csv", "convergence_split_facets.csv"),
        ],
    },
    // Its finest mesh needs 10 GiB and minutes: last, so that all others are there.
    Maker {
        arguments: &["-p", "forms-bench", "--example", "scaling"],
        pictures: &[("out/scaling.png", "scaling.png")],
    },
];

fn main() -> ExitCode {
    program_with_options(run)
}

fn run(options: &Options, out: &mut StandardOutput) -> Result<(), Box<dyn Error>> {
    let stem = |name: &str| name.split('.').next().unwrap_or(name).to_owned();
    let mut known: Vec<String> =
        MAKERS.iter().flat_map(|maker| maker.pictures).map(|(_, to)| stem(to)).collect();
    known.dedup();
    if let Some(unknown) = options.names.iter().find(|name| !known.contains(&stem(name))) {
        return Err(format!("there is no picture \"{unknown}\"; there are {}", known.join(", ")).into());
    }
    let wanted = |maker: &&Maker| {
        let asked = |(_, to): &(&str, &str)| options.names.iter().any(|name| stem(name) == stem(to));
        options.names.is_empty() || maker.pictures.iter().any(asked)
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for maker in MAKERS.iter().filter(wanted) {
        let command = format!("cargo run --release {}", maker.arguments.join(" "));
        if options.list {
            out.line(&command);
            maker.pictures.iter().for_each(|(_, to)| out.line(format!("    docs/pictures/{to}")));
            continue;
        }
        tell(&command);
        let start = Instant::now();
        make(maker, &root)?;
        for (_, to) in maker.pictures {
            out.line(format!("docs/pictures/{to}: {:.1} s", start.elapsed().as_secs_f64()));
        }
    }
    Ok(())
}

/// Runs a program in the workspace and takes its pictures.
fn make(maker: &Maker, root: &Path) -> Result<(), Box<dyn Error>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut command = Command::new(&cargo);
    let status = command.args(["run", "--release"]).args(maker.arguments).current_dir(root).status();
    let status = status.map_err(|error| format!("{}: {error}", cargo.to_string_lossy()))?;
    if !status.success() {
        return Err(format!("{} ended with {status}", maker.arguments.join(" ")).into());
    }
    for (from, to) in maker.pictures {
        let from: PathBuf = root.join(from);
        let bytes = std::fs::read(&from).map_err(|error| format!("{}: {error}", from.display()))?;
        let is_reduced = REDUCED.iter().any(|name| to.starts_with(name));
        let bytes = if is_reduced { reduced(&bytes)? } else { bytes };
        let to = root.join("docs").join("pictures").join(to);
        write_whole(to, |file| std::io::Write::write_all(file, &bytes))?;
    }
    Ok(())
}

/// Names of the pictures that are reduced.
const REDUCED: [&str; 4] = ["tutorial_", "adaptive_hertz_cut", "closing_c.png", "pressed_knot"];

/// Most bytes of them.
const MOST_BYTES: usize = 150_000;

/// A PNG file of RGB at half of its resolution, or a third and so on if that has too many bytes.
fn reduced(bytes: &[u8]) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info()?;
    let mut pixels = vec![0; reader.output_buffer_size().ok_or("the picture is too large")?];
    let info = reader.next_frame(&mut pixels)?;
    let size = [info.width as usize, info.height as usize];
    let mut factor = 2;
    loop {
        let reduced = with_means(&pixels, size, factor)?;
        if reduced.len() <= MOST_BYTES {
            return Ok(reduced);
        }
        factor += 1;
    }
}

/// A PNG file whose pixels are the means of squares of pixels.
fn with_means(pixels: &[u8], [width, height]: [usize; 2], factor: usize) -> Result<Vec<u8>, Box<dyn Error>> {
    let (columns, rows) = (width / factor, height / factor);
    let count = factor * factor;
    let mut means = Vec::with_capacity(3 * columns * rows);
    for place in 0..3 * columns * rows {
        let (channel, x, y) = (place % 3, place / 3 % columns * factor, place / 3 / columns * factor);
        let inside = (0..count).map(|k| 3 * ((y + k / factor) * width + x + k % factor) + channel);
        let sum: usize = inside.map(|at| usize::from(pixels[at])).sum();
        means.push(((sum + count / 2) / count) as u8);
    }
    let mut written = Vec::new();
    let mut encoder = png::Encoder::new(&mut written, columns as u32, rows as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&means)?;
    writer.finish()?;
    Ok(written)
}
