//! Completions for shells and pages for `man`. Both are generated from the definition of the
//! arguments.

use clap::{Command, CommandFactory};
use clap_complete::{Shell, generate};
use clap_mangen::Man;

use crate::args::{Args, ManArgs};
use crate::exit::{Failure, Outcome};
use crate::summary::print;

/// Prints the script by which a shell completes commands and options.
pub fn completions(shell: Shell) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    generate(shell, &mut Args::command(), "tashika", &mut script);
    print(&String::from_utf8_lossy(&script))?;
    Ok(Outcome::Done)
}

/// Prints the page of a command, or of the program.
pub fn man(typed: &ManArgs) -> Result<Outcome, Failure> {
    let mut command = Args::command();
    command.build();
    for word in &typed.command {
        let Some(inner) = command.find_subcommand(word).cloned() else {
            return Err(Failure::usage(format!("no command {word:?}; expected {}", names(&command))));
        };
        command = inner;
    }
    let mut page = Vec::new();
    let man = Man::new(command).source(concat!("tashika ", env!("CARGO_PKG_VERSION")));
    man.render(&mut page).map_err(|e| Failure::file(format!("cannot make the page: {e}")))?;
    print(&String::from_utf8_lossy(&page))?;
    Ok(Outcome::Done)
}

fn names(command: &Command) -> String {
    let names: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
    if names.is_empty() { "no more words".to_owned() } else { format!("one of {}", names.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each command with the words that lead to it.
    fn commands(command: &Command, path: &[String]) -> Vec<(Vec<String>, Command)> {
        let mut all = vec![(path.to_vec(), command.clone())];
        for inner in command.get_subcommands() {
            let path = [path, &[inner.get_name().to_owned()]].concat();
            all.extend(commands(inner, &path));
        }
        all
    }

    fn options(command: &Command) -> Vec<String> {
        command.get_opts().filter_map(|option| option.get_long()).map(|long| format!("--{long}")).collect()
    }

    fn built() -> Command {
        let mut command = Args::command();
        command.build();
        command
    }

    #[test]
    fn completions_name_every_command_and_every_option() {
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            let mut script = Vec::new();
            generate(shell, &mut Args::command(), "tashika", &mut script);
            let script = String::from_utf8(script).unwrap();
            let words: Vec<&str> =
                script.split(|c: char| !(c.is_alphanumeric() || "-_".contains(c))).collect();
            let mut count = 0;
            for (path, command) in commands(&built(), &[]) {
                for name in &path {
                    assert!(words.contains(&name.as_str()), "{shell}: {path:?}");
                }
                for option in options(&command) {
                    // Completions for fish have the bare name, after `-l`.
                    let bare = option.trim_start_matches('-');
                    let is_there = words.contains(&option.as_str()) || words.contains(&bare);
                    assert!(is_there, "{shell}: {path:?} {option}");
                    count += 1;
                }
            }
            assert!(count > 100, "{shell}: {count} options");
        }
    }

    #[test]
    fn pages_of_commands_name_every_option() {
        for (path, command) in commands(&built(), &[]) {
            let mut page = Vec::new();
            Man::new(command.clone()).render(&mut page).unwrap();
            let page = String::from_utf8(page).unwrap().replace("\\-", "-");
            for option in options(&command) {
                assert!(page.contains(&option), "{path:?} {option}");
            }
            for inner in command.get_subcommands() {
                assert!(page.contains(inner.get_name()), "{path:?} {}", inner.get_name());
            }
        }
    }
}
