//! Renders of real scenes. The scenes are not part of the project; without them this check is
//! skipped.

use std::fs;
use std::path::{Path, PathBuf};

use crate::shell::{Outcome, Shell};

/// Folder of the scenes, beside the checkout.
const SCENES: &str = "../shared/scenes";
/// List of the scenes that are rendered.
const LIST: &str = "record/contact-sheet/scenes.txt";
/// Fewest scenes of the list, and fewest corner cases.
const FEWEST: [usize; 2] = [30, 100];

/// Renders all scenes at a small size. Those of the list must give pictures. Corner cases and
/// damaged files must give a picture or a message, never a crash.
pub fn check(shell: &Shell, program: &Path) -> Outcome<()> {
    let scenes = shell.root().join(SCENES);
    if !(scenes.join("unpack").is_file() && shell.has("xz")) {
        return Ok(());
    }
    shell.step("real scenes");
    let folder = shell.folder("scenes")?;
    shell.command(scenes.join("unpack"), "-d").arg(&folder).run_quietly()?;
    let image = shell.folder("scene")?.join("scene.exr");
    // A scene takes a second or two. One that takes two minutes is taken to hang.
    let small = |scene: &Path| {
        let _ = fs::remove_file(&image);
        let options = "--allow-outside --allow-missing --size 64x36 --vpls 10k --passes 1 --quiet -o";
        let task = shell.command("timeout", "120").arg(program).arg("render").arg(scene);
        task.args(options.split(' ')).arg(&image).ended()
    };
    let list = fs::read_to_string(shell.root().join(LIST)).map_err(|e| format!("{LIST}: {e}"))?;
    let named = |line: &str| line.split(['#', '\t']).next().unwrap_or_default().trim_end().to_owned();
    let whole: Vec<PathBuf> =
        list.lines().map(named).filter(|name| !name.is_empty()).map(|name| folder.join(name)).collect();
    for scene in &whole {
        let (code, said) = small(scene)?;
        if code != Some(0) || !image.is_file() {
            return Err(format!("exit code {code:?} for {}: {said}", scene.display()));
        }
    }
    let odd = corner_cases(&folder)?;
    for scene in &odd {
        let (code, said) = small(scene)?;
        match code {
            Some(0) => {}
            Some(3) if !said.is_empty() => {}
            _ => return Err(format!("exit code {code:?} for {}: {said}", scene.display())),
        }
    }
    if whole.len() < FEWEST[0] || odd.len() < FEWEST[1] {
        return Err(format!("only {} scenes and {} corner cases were found", whole.len(), odd.len()));
    }
    shell.say(&format!("{} scenes and {} corner cases", whole.len(), odd.len()));
    Ok(())
}

/// Scenes in folders of conformance files, in order.
fn corner_cases(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let mut found = Vec::new();
    let mut waiting: Vec<PathBuf> = entries(folder)?
        .into_iter()
        .filter(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("conf-")))
        .collect();
    while let Some(path) = waiting.pop() {
        if path.is_dir() {
            waiting.extend(entries(&path)?);
        } else if path.extension().is_some_and(|ending| ["obj", "pbrt", "xml"].iter().any(|e| ending == *e)) {
            found.push(path);
        }
    }
    found.sort();
    Ok(found)
}

fn entries(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let read = fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    Ok(read.filter_map(|entry| Some(entry.ok()?.path())).collect())
}
