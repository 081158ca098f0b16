//! The steps of a render on many machines, as command lines of this program.

use std::path::{Path, PathBuf};

use tashika::request::{Method, MethodName};
use tashika::scene::builtin;

use crate::exit::Failure;
use crate::plan::FarmPlan;

/// Steps for an engine: first `lights`, if lights are traced for all shares; then each share; then
/// `merge`.
pub struct Job {
    /// Name of the job, for people.
    pub name: String,
    /// Absolute path of the folder of the job, valid on all machines.
    pub folder: PathBuf,
    /// Absolute path of the merged image.
    pub image: PathBuf,
    /// Number of shares of the tiles.
    pub shares: u32,
    /// Command line that traces the lights, if they are traced once for all shares.
    pub lights: Option<Vec<String>>,
    render: Vec<String>,
    merge: Vec<String>,
}

impl Job {
    /// Makes the steps from the checked arguments.
    pub fn new(plan: &FarmPlan) -> Result<Self, Failure> {
        let folder = absolute(&plan.folder)?;
        let image = absolute(&plan.render.outputs.exr)?;
        let program = plan.program.clone();
        let scene = match plan.scene.as_deref() {
            Some(scene) if !scene.starts_with(builtin::PREFIX) => {
                Some(path_text(&absolute(Path::new(scene))?)?)
            }
            scene => scene.map(str::to_owned),
        };
        // An absolute path is valid in any working folder.
        let typed: Vec<String> = plan
            .words
            .iter()
            .map(|word| {
                if Some(word) == plan.scene.as_ref() {
                    scene.clone().unwrap_or_default()
                } else {
                    word.clone()
                }
            })
            .collect();
        let mut words = without(&typed, &["-o", "--output", "--json", "--checkpoint", "--accept-budget"]);
        let asked = plan.render.stage.scene.lights();
        words = without(&words, &["--environment", "--light"]);
        if let Some(environment) = &asked.environment {
            words.extend(["--environment".to_owned(), environment.with_absolute_path()?.to_string()]);
        }
        for light in &asked.lights {
            words.extend(["--light".to_owned(), light.with_absolute_path()?.to_string()]);
        }
        let lights_file = path_text(&folder.join("lights.vpl"))?;
        if let Some(file) = plan.render.asked.vpl_file() {
            words = without(&words, &["--vpl-file"]);
            words.extend(["--vpl-file".to_owned(), path_text(&absolute(file)?)?]);
        }
        let denoiser = match plan.denoiser.as_deref() {
            Some(name) if !["own", "oidn"].map(Path::new).contains(&name) => {
                Some(path_text(&absolute(name)?)?)
            }
            name => name.map(path_text).transpose()?,
        };
        let denoiser: Vec<String> =
            denoiser.into_iter().flat_map(|name| ["--denoiser".to_owned(), name]).collect();
        words = without(&words, &["--denoiser"]);
        words.extend(denoiser.iter().cloned());
        let method = method_in_scene(plan)?;
        let (truth, traced) = match &method {
            Method::Sum { lights, .. } => (None, lights.is_some()),
            // With lights from a file and without `--truth`, the truth would be the sum over these
            // lights.
            Method::Transport { lights, truth, .. } => (lights.as_ref().map(|_| truth), lights.is_some()),
            Method::Audited { .. } | Method::Path { .. } => (None, false),
        };
        let lights = traced.then(|| {
            let mut line = vec![program.clone()];
            line.extend(without(&words, &QUIET));
            line.extend(["--write-vpls", &lights_file, "--quiet"].map(str::to_owned));
            words = without(&words, &["--vpls", "--clamp", "--instants", "--truth"]);
            words.extend(["--vpl-file".to_owned(), lights_file.clone()]);
            if let Some(truth) = truth {
                words.extend(["--truth".to_owned(), truth.to_string()]);
            }
            line
        });
        // Parts are written in the fastest layout. These options apply to the merged image only.
        let [layout, words] = split(&words, &["--exr", "--false-color", "--photometry"]);
        let mut render = vec![program.clone()];
        render.extend(words);
        // An engine would take any exit code except 0 for a lost worker.
        render.extend(["--checkpoint", "--accept-budget"].map(str::to_owned));
        let mut merge = vec![program, "merge".to_owned()];
        for number in 1..=plan.shares {
            merge.push(path_text(&folder.join(part(&number.to_string())))?);
        }
        merge.extend(["-o".to_owned(), path_text(&image)?, "--accept-budget".to_owned()]);
        merge.extend(denoiser);
        merge.extend(layout);
        let name =
            image.file_stem().map_or_else(|| "tashika".to_owned(), |n| n.to_string_lossy().into_owned());
        Ok(Self { name, folder, image, shares: plan.shares, lights, render, merge })
    }

    /// Command line of a share; `number` is the engine's notation for the number of the share.
    pub fn share(&self, number: &str) -> Vec<String> {
        let mut line = self.render.clone();
        let file = self.folder.join(part(number)).to_string_lossy().into_owned();
        line.extend(["--tiles".to_owned(), format!("{number}/{}", self.shares), "-o".to_owned(), file]);
        line
    }

    /// Command line that joins the parts.
    pub fn merge(&self) -> &[String] {
        &self.merge
    }
}

/// Method of the shares. The default method depends on the scene: scenes that move or scatter light
/// are rendered by path tracing, without VPLs.
fn method_in_scene(plan: &FarmPlan) -> Result<Method, Failure> {
    let asked = &plan.render.asked.request;
    let depends_on_scene = asked.method == MethodName::default() && !asked.lights_given;
    // If only the machines of the farm have the scene, it is checked there.
    let scene = depends_on_scene.then(|| plan.render.stage.scene.load().ok()).flatten();
    let planned = scene.map_or_else(|| asked.plan_for_still_scene(), |scene| asked.plan(&scene))?;
    Ok(planned.method)
}

fn part(number: &str) -> String {
    format!("part-{number}.exr")
}

fn absolute(path: &Path) -> Result<PathBuf, Failure> {
    std::path::absolute(path).map_err(|e| Failure::file(format!("{}: {e}", path.display())))
}

fn path_text(path: &Path) -> Result<String, Failure> {
    let text = path.to_str().map(str::to_owned);
    text.ok_or_else(|| Failure::usage(format!("{}: a job's paths have to be Unicode", path.display())))
}

/// Options without a value.
const FLAGS: [&str; 6] =
    ["--checkpoint", "--allow-outside", "--allow-missing", "--accept-budget", QUIET[0], QUIET[1]];
/// Names of the option that suppresses all messages.
const QUIET: [&str; 2] = ["--quiet", "-q"];

/// Splits words into the named options, with their values, and all other words.
fn split(words: &[String], names: &[&str]) -> [Vec<String>; 2] {
    let mut parts = [Vec::new(), Vec::new()];
    let mut words = words.iter();
    while let Some(word) = words.next() {
        let name = word.split_once('=').map_or(word.as_str(), |(name, _)| name);
        // The value of a short option may follow without a space: -oFILE.
        let short = names.iter().any(|n| n.len() == 2 && !word.starts_with("--") && word.starts_with(n));
        let named = short || names.contains(&name);
        let out = &mut parts[usize::from(!named)];
        out.push(word.clone());
        let has_value = word.contains('=') || (short && word.len() > 2) || FLAGS.contains(&name);
        if named && !has_value {
            out.extend(words.next().cloned());
        }
    }
    parts
}

fn without(words: &[String], names: &[&str]) -> Vec<String> {
    let [_, without] = split(words, names);
    without
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_found_with_their_values_however_they_are_written() {
        let words: Vec<String> =
            "render a.pbrt -o b.exr --vpls 5k --seed=3 -ob.exr --output c.exr --allow-outside --error 2% --checkpoint"
                .split(' ')
                .map(str::to_owned)
                .collect();
        let [named, _] = split(&words, &["--vpls", "--seed", "--allow-outside"]);
        assert_eq!(named.join(" "), "--vpls 5k --seed=3 --allow-outside");
        let rest = without(&words, &["-o", "--output", "--checkpoint"]);
        assert_eq!(rest.join(" "), "render a.pbrt --vpls 5k --seed=3 --allow-outside --error 2%");
    }
}
