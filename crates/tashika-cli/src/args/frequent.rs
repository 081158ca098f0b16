//! Short help of `render`: `-h` lists the options that most renders need, `--help` lists all.

use clap::{Command, CommandFactory, FromArgMatches};

use super::Args;

/// Options of `render` that `-h` lists.
const FREQUENT: [&str; 15] = [
    "camera",
    "environment",
    "light",
    "size",
    "error",
    "confidence",
    "time",
    "quality",
    "method",
    "audit",
    "seed",
    "output",
    "exposure",
    "serve",
    "threads",
];

/// Reads the command line. Ends the program where help is requested, or with a message where an
/// argument is wrong.
pub fn parsed() -> Args {
    let mut command = command();
    let matches = command.get_matches_mut();
    Args::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit())
}

fn command() -> Command {
    Args::command().mut_subcommand("render", |render| {
        let examples = render.get_after_help().cloned().unwrap_or_default();
        render
            .mut_args(|option| {
                let is_frequent = option.get_long().is_none_or(|long| FREQUENT.contains(&long));
                option.hide_short_help(!is_frequent)
            })
            .after_help(format!("`--help` lists all options.\n\n{examples}"))
            .after_long_help(examples)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The short help names each frequent option and no other, the long help all of them.
    #[test]
    fn the_short_help_lists_frequent_options_alone() {
        let mut command = command();
        let render = command.find_subcommand_mut("render").unwrap();
        let (short, long) = (render.render_help().to_string(), render.render_long_help().to_string());
        let lists = |text: &str, name: &str| {
            let of_line = |line: &str| {
                let begins = line.trim_start().split([' ', '[', '=']).find(|word| word.starts_with("--"));
                begins == Some(&format!("--{name}"))
            };
            text.lines().filter(|line| line.trim_start().starts_with('-')).any(of_line)
        };
        let options = render.get_arguments().filter_map(|option| option.get_long());
        for option in options.filter(|option| *option != "help") {
            assert_eq!(lists(&short, option), FREQUENT.contains(&option), "{option}");
            assert!(lists(&long, option), "{option}");
        }
        assert!(short.contains("`--help` lists all options.") && !long.contains("`--help` lists"));
    }
}
