//! `cargo xtask instructions`: how many instructions an answer of each hot kernel takes, by callgrind, against committed limits.
//!
//! Unlike times these are the same on a busy machine; slower code shows at once, code that is only less parallel does not.
//! Callgrind (Nethercote and Seward 2007) hides AVX-512, so that AVX2 is counted. The kernels and their fixed inputs are in
//! `hot_kernels`. Without valgrind, on another target, without AVX2 or with another compiler nothing is judged, and that is said.

mod limits;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::files::{self, cargo, in_workspace};
use crate::summary;
use limits::Limits;

/// Count the instructions of the hot kernels under valgrind; fail beyond data/instructions.toml
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Write the counts found, and 3 %, as the new limits instead
    #[arg(long)]
    record: bool,
    /// Folder for callgrind's files
    #[arg(long, default_value = "target/instructions")]
    out: PathBuf,
}

/// Instructions of one kernel.
#[derive(Debug, Clone, PartialEq)]
struct Count {
    kernel: String,
    /// Of an answer.
    instructions: f64,
}

/// Whether no kernel is beyond its limit, or why that is not judged.
pub(crate) fn run(arguments: &Arguments) -> Result<bool, Box<dyn Error>> {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        return Ok(skipped("the limits are of x86_64 Linux"));
    }
    if Command::new("valgrind").arg("--version").stdout(Stdio::null()).status().is_err() {
        return Ok(skipped("valgrind is not installed (apt-get install valgrind)"));
    }
    let (counts, unknown) = counted(&built()?, &arguments.out)?;
    let (file, compiler) = (in_workspace("data/instructions.toml"), compiler()?);
    if arguments.record {
        if !unknown.is_empty() {
            return Err(unknown_to_valgrind(&unknown).into());
        }
        let before = Limits::from_toml(&fs::read_to_string(&file)?)?;
        files::write(&file, Limits::above(&counts, &compiler).no_looser_than(&before).to_toml())?;
        println!("written to data/instructions.toml");
        return Ok(true);
    }
    let limits = Limits::from_toml(&fs::read_to_string(file)?)?;
    println!("{}", table(&counts, &limits));
    if limits.compiler != compiler {
        return Ok(skipped(&format!("the limits are of rustc {}, this is {compiler}", limits.compiler)));
    }
    if !counts.iter().any(|count| count.kernel.ends_with("avx2")) {
        return Ok(skipped("this machine has no AVX2"));
    }
    if !unknown.is_empty() {
        skipped(&unknown_to_valgrind(&unknown));
    }
    let violations = limits.violations(&counts, &unknown);
    violations.iter().for_each(|violation| println!("VIOLATED {violation}"));
    Ok(violations.is_empty())
}

/// Valgrind 3.19 does not know `vmovq` between registers in its shorter form, which compilers choose where it fits.
fn unknown_to_valgrind(kernels: &[String]) -> String {
    format!("of {}, in which valgrind does not know an instruction", kernels.join(", "))
}

/// Says loudly that something is not judged.
fn skipped(why: &str) -> bool {
    eprintln!("== SKIPPED: instruction counts are not held against their limits: {why}");
    true
}

/// Builds the program to be counted.
fn built() -> Result<PathBuf, Box<dyn Error>> {
    let build = ["build", "--release", "--package", "hot_kernels"];
    if !Command::new(cargo()).args(build).current_dir(in_workspace("")).status()?.success() {
        return Err("hot_kernels does not build".into());
    }
    // This program may itself be of another profile.
    let folder = std::env::current_exe()?.ancestors().nth(2).map(Path::to_owned).ok_or("no target folder")?;
    Ok(folder.join("release/hot_kernels"))
}

/// The counts of all kernels, and the names of those in which valgrind does not know an instruction.
fn counted(program: &Path, out: &Path) -> Result<(Vec<Count>, Vec<String>), Box<dyn Error>> {
    let output = Command::new(program).output()?;
    if !output.status.success() {
        return Err(format!("hot_kernels: {}", String::from_utf8_lossy(&output.stderr)).into());
    }
    let names: Vec<String> =
        String::from_utf8(output.stdout)?.lines().filter_map(|line| Some(line.split_once(' ')?.0.to_owned())).collect();
    let (mut counts, mut unknown) = (Vec::new(), Vec::new());
    loop {
        let (more, is_all) = counted_from(counts.len() + unknown.len(), program, out)?;
        counts.extend(more);
        match names.get(counts.len() + unknown.len()) {
            Some(next) if !is_all => unknown.push(next.clone()),
            _ => return Ok((counts, unknown)),
        }
    }
}

/// Runs the program from a kernel on under callgrind, which writes a file for each call of `measured`; and whether it knew all
/// instructions. Each kernel runs once before it is named and measured.
fn counted_from(first: usize, program: &Path, out: &Path) -> Result<(Vec<Count>, bool), Box<dyn Error>> {
    if out.exists() {
        fs::remove_dir_all(out)?;
    }
    fs::create_dir_all(out)?;
    let file = |number: usize| out.join(format!("callgrind.{number}"));
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--zero-before=hot_kernels::measured", "--dump-after=hot_kernels::measured"])
        .arg(format!("--callgrind-out-file={}", out.join("callgrind").display()))
        .arg(program)
        .arg(first.to_string())
        .output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    let is_all = !said.contains("Unrecognised instruction");
    if is_all && !output.status.success() {
        return Err(format!("valgrind: {said}").into());
    }
    let kernels = String::from_utf8(output.stdout)?;
    let count = |(index, line): (usize, &str)| {
        let file = file(index + 1);
        let text = fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        Count::new(line, &text).ok_or_else(|| format!("{}: no count for {line:?}", file.display()).into())
    };
    let counts: Result<Vec<Count>, Box<dyn Error>> = kernels.lines().enumerate().map(count).collect();
    Ok((counts?, is_all))
}

impl Count {
    /// From the line that the program writes and callgrind's file.
    fn new(line: &str, callgrind: &str) -> Option<Self> {
        let (kernel, answers) = line.split_once(' ')?;
        let (answers, total) = (answers.parse::<u32>().ok()?, total(callgrind)?);
        (answers > 0).then(|| Self { kernel: kernel.to_owned(), instructions: total as f64 / f64::from(answers) })
    }
}

/// The total of a file of callgrind's.
fn total(callgrind: &str) -> Option<u64> {
    callgrind.lines().find_map(|line| line.strip_prefix("totals:"))?.trim().parse().ok()
}

/// The compiler's release, such as 1.95.0.
fn compiler() -> Result<String, Box<dyn Error>> {
    let version = String::from_utf8(Command::new("rustc").arg("--version").output()?.stdout)?;
    Ok(version.split_whitespace().nth(1).ok_or("rustc says no version")?.to_owned())
}

fn table(counts: &[Count], limits: &Limits) -> comfy_table::Table {
    let mut table = summary::with_header(&["kernel", "instructions an answer", "limit"]);
    for Count { kernel, instructions } in counts {
        let limit = limits.limit(kernel).map_or_else(|| "none".to_owned(), |limit| limit.to_string());
        table.add_row([kernel.clone(), format!("{instructions:.0}"), limit]);
    }
    summary::right_aligned(table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_count_is_callgrinds_total_over_the_answers() {
        let text = "# callgrind format\nevents: Ir\nfn=(1) hot_kernels::measured\n12 7\n\ntotals: 27868\n";
        let count = Count::new("constant-value 64", text).unwrap();
        assert_eq!(count, Count { kernel: "constant-value".to_owned(), instructions: 27868.0 / 64.0 });
        for (line, text) in [("constant-value", text), ("constant-value 0", text), ("a 64", "summary: 1"), ("a 64", "totals: x")]
        {
            assert_eq!(Count::new(line, text), None, "{line}");
        }
    }
}
