//! A job as scripts for Slurm. One script traces the lights, an array job renders the shares, and a
//! last script merges them. A share is requeued if its machine is lost.

use super::job::Job;
use crate::summary::shell_word;

/// Placeholder for the number of the share; no path contains it.
const SHARE: &str = "\u{0}";

/// Quotes a word for a shell. `SHARE` is replaced by Slurm's variable for the number of the task.
fn quoted(word: &str) -> String {
    let parts: Vec<String> =
        word.split(SHARE).map(|p| if p.is_empty() { String::new() } else { shell_word(p) }).collect();
    if word.is_empty() { shell_word(word) } else { parts.join("\"$SLURM_ARRAY_TASK_ID\"") }
}

/// Scripts of the job: first the one to run, then those that it submits.
pub fn files(job: &Job) -> Vec<(String, String)> {
    let folder = shell_word(&job.folder.to_string_lossy());
    let name = shell_word(&job.name);
    let script = |line: &[String], more: &str| {
        let line: Vec<String> = line.iter().map(|word| quoted(word)).collect();
        format!("#!/bin/sh\n#SBATCH --job-name={name}\n{more}exec {}\n", line.join(" "))
    };
    let array = format!("#SBATCH --array=1-{}\n#SBATCH --requeue\n", job.shares);
    let share = script(&job.share(SHARE), &array);
    let mut submit =
        format!("#!/bin/sh\n# Submits everything, each step after the one before.\nset -e\ncd {folder}\n");
    let mut files = Vec::new();
    let mut after = String::new();
    if let Some(lights) = &job.lights {
        files.push(("lights.sh".to_owned(), script(lights, "")));
        submit.push_str("lights=$(sbatch --parsable lights.sh)\n");
        after = "--dependency=afterok:\"$lights\" ".to_owned();
    }
    files.push(("share.sh".to_owned(), share));
    files.push(("merge.sh".to_owned(), script(job.merge(), "")));
    submit.push_str(&format!("shares=$(sbatch --parsable {after}share.sh)\n"));
    submit.push_str("sbatch --dependency=afterok:\"$shares\" merge.sh\n");
    files.insert(0, ("submit.sh".to_owned(), submit));
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_shell_sees_the_variable_and_takes_nothing_else_apart() {
        let word = format!("/a b/it's/part-{SHARE}.exr");
        assert_eq!(quoted(&word), r#"'/a b/it'\''s/part-'"$SLURM_ARRAY_TASK_ID".exr"#);
        assert_eq!((quoted("--tiles"), quoted("")), ("--tiles".to_owned(), "''".to_owned()));
        assert_eq!(quoted(&format!("{SHARE}/16")), "\"$SLURM_ARRAY_TASK_ID\"/16");
    }
}
