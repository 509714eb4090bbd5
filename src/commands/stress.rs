//! `cyclopean stress`: tests the numerical stability of the renderer, hazard by hazard.

use std::path::{Path, PathBuf};

use anyhow::Context as _;
use cyclopean_analysis::files;
use serde::Serialize;

use crate::console::{Console, check_interrupted};
use crate::gpu::DeviceInfo;
use crate::picture::{self, Part};
use crate::stress::{self, Bench, Case, CasePicture, Outcome, SWEEPS, SweepResult};

use super::WrongUsage;
use super::device;

/// Render every known numerical hazard, and measure how well the renderer copes with it.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder for stress.json and the pictures of failed cases.
    #[arg(long, short, default_value = "stress")]
    out: PathBuf,
    /// Run only cases and sweeps whose name contains this.
    #[arg(long, value_name = "PART")]
    only: Option<String>,
    /// List the cases and sweeps, but render nothing.
    #[arg(long)]
    list: bool,
    /// Judge a case or sweep by this number instead of its own bound, in the bound's unit; may be given more than once.
    #[arg(long, value_name = "NAME=NUMBER", value_parser = bound)]
    bound: Vec<(String, f64)>,
    /// Part of the device's name; by default the best device.
    #[arg(long)]
    device: Option<String>,
}

/// Parses `NAME=NUMBER`.
fn bound(text: &str) -> Result<(String, f64), String> {
    let wrong = || format!("`{text}` is no bound; give NAME=NUMBER, such as mirror=0.001");
    let (name, number) = text.split_once('=').ok_or_else(wrong)?;
    Ok((name.to_owned(), number.parse().map_err(|_| wrong())?))
}

/// `stress.json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    device: &'a DeviceInfo,
    failed: Vec<&'static str>,
    cases: Vec<Outcome>,
    sweeps: Vec<SweepResult>,
    /// Pictures of what failed.
    pictures: Vec<PathBuf>,
}

/// See [`Args`].
///
/// # Errors
/// Wrong usage, no device, an unwritable folder; and when any case fails.
pub fn run(args: Args, console: &Console) -> anyhow::Result<()> {
    let wanted = |name: &str| args.only.as_ref().is_none_or(|part| name.contains(part.as_str()));
    let mut cases: Vec<Case> = stress::cases().filter(|c| wanted(c.name)).copied().collect();
    let mut sweeps: Vec<_> = SWEEPS.iter().filter(|s| wanted(s.name)).copied().collect();
    if cases.is_empty() && sweeps.is_empty() {
        let part = args.only.unwrap_or_default();
        return Err(
            WrongUsage(format!("no case's name contains `{part}`; `cyclopean stress --list` names them")).into()
        );
    }
    for (name, number) in &args.bound {
        let of_cases = cases.iter_mut().filter(|c| c.name == name).map(|c| &mut c.bound);
        let of_sweeps = sweeps.iter_mut().filter(|s| s.name == name).map(|s| &mut s.bound);
        let found = of_cases.chain(of_sweeps).map(|b| *b = b.with_limit(*number)).count();
        if found == 0 {
            return Err(WrongUsage(format!("--bound {name}=…: no chosen case or sweep has this name")).into());
        }
    }
    if args.list {
        cases.iter().for_each(|c| console.line(format!("{:<28} {}: {}", c.name, c.hazard, c.checks)));
        sweeps.iter().for_each(|s| console.line(format!("{:<28} sweep: {}", s.name, s.about)));
        let names: Vec<_> = cases.iter().map(|c| c.name).chain(sweeps.iter().map(|s| s.name)).collect();
        return Ok(console.object(&serde_json::json!({ "names": names }))?);
    }
    let gpu = device::open(args.device.as_deref())?;
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot make the folder {}", args.out.display()))?;

    let mut bench = Bench::new(&gpu);
    let mut report = Report { device: gpu.info(), failed: vec![], cases: vec![], sweeps: vec![], pictures: vec![] };
    console.line(format!("{} · {}", gpu.info().name, gpu.info().driver));
    for case in &cases {
        check_interrupted()?;
        let outcome = stress::run(case, &mut bench)?;
        say(console, &outcome);
        if !outcome.passed {
            report.failed.push(case.name);
            report.pictures.extend(write(&args.out.join(case.name), &bench)?);
        }
        report.cases.push(outcome);
    }
    for sweep in &sweeps {
        check_interrupted()?;
        let along = stress::run_sweep(sweep, &mut bench)?;
        say_sweep(console, &along);
        if !along.passed {
            report.failed.push(sweep.name);
            report.pictures.extend(write(&args.out.join(sweep.name), &bench)?);
        }
        report.sweeps.push(along);
    }
    // This catches validation messages that belong to no single case.
    gpu.check_validation()?;
    files::write_bytes(&args.out.join("stress.json"), &serde_json::to_vec_pretty(&report)?)?;
    console.object(&report)?;
    let total = report.cases.len() + report.sweeps.len();
    anyhow::ensure!(
        report.failed.is_empty(),
        "{} of {total} failed ({}); their pictures lie in {}",
        report.failed.len(),
        report.failed.join(", "),
        args.out.display()
    );
    console.line(format!("all {total} passed; {}", args.out.join("stress.json").display()));
    Ok(())
}

fn say(console: &Console, o: &Outcome) {
    let word = if o.passed { "pass" } else { "FAIL" };
    let worst = o.worst.map_or_else(|| "–".to_owned(), number);
    console.line(format!("{word}  {:<28} {worst:>10} {} {} · {}", o.name, o.bound, o.unit, o.at));
    if !o.passed {
        console.line(format!("      {}: {}", o.hazard, o.checks));
    }
    if let Some(error) = &o.error {
        console.line(format!("      {error}"));
    }
}

fn say_sweep(console: &Console, a: &SweepResult) {
    let word = if a.passed { "pass" } else { "FAIL" };
    console.line(format!(
        "{word}  {:<28} {:>10} {} relative squared error, bias up to {:.2} % · {}",
        a.name,
        number(a.worst_error),
        a.bound,
        100.0 * a.worst_bias,
        a.about
    ));
    console.line(format!(
        "      {:>12} {:<10} {:>10} {:>10} {:>9} {:>9}",
        a.unit, "method", "error", "relMSE", "bias", "unknown"
    ));
    for r in &a.rows {
        console.line(format!(
            "      {:>12} {:<10} {:>10} {:>10} {:>7.2} % {:>7.2} %",
            r.value,
            r.method,
            number(r.relative_squared_error),
            number(r.relative_mse),
            100.0 * r.relative_bias,
            r.unknown_percent
        ));
    }
}

/// A number with three significant digits.
fn number(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        a if (1e-3..1e4).contains(&a) => format!("{x:.*}", (2 - a.log10().floor() as i32).max(0) as usize),
        _ => format!("{x:.2e}"),
    }
}

/// Writes every picture on the bench, in the order in which they were made.
fn write(folder: &Path, bench: &Bench) -> anyhow::Result<Vec<PathBuf>> {
    std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut written = Vec::new();
    for (i, shot) in bench.shots().iter().enumerate() {
        let plain = |c: char| if c.is_ascii_alphanumeric() || "=.@+-".contains(c) { c } else { '-' };
        let stem = format!("{i:03}-{}", shot.label.chars().map(plain).collect::<String>());
        written.extend(write_shot(folder, &stem, shot)?);
    }
    Ok(written)
}

fn write_shot(folder: &Path, stem: &str, shot: &CasePicture) -> Result<[PathBuf; 2], picture::PictureError> {
    let (exr, png) = (folder.join(format!("{stem}.exr")), folder.join(format!("{stem}.png")));
    let parts = [Part { layer: "", picture: &shot.linear }, Part { layer: "reflection", picture: &shot.reflection }];
    picture::write_exr(&exr, &parts)?;
    let [left, right] = &shot.display;
    picture::write_side_by_side(&png, shot.linear.width, shot.linear.height, [left, right])?;
    Ok([exr, png])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_and_numbers_are_read_and_written() {
        assert_eq!(bound("a-b=1e-3"), Ok(("a-b".to_owned(), 1e-3)));
        for wrong in ["", "a", "a=", "a=b"] {
            assert!(bound(wrong).expect_err("refused").contains("NAME=NUMBER"), "{wrong}");
        }
        assert_eq!(
            [0.0, 0.01234, 1.5, 123.4, 1e-5, 1e9].map(number),
            ["0", "0.0123", "1.50", "123", "1.00e-5", "1.00e9"]
        );
    }

    #[test]
    fn every_case_has_its_own_name() {
        let mut names: Vec<_> = stress::cases().map(|c| c.name).chain(SWEEPS.iter().map(|s| s.name)).collect();
        let before = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), before);
    }
}
