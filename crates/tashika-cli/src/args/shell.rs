//! Arguments of `completions` and `man`.

use clap::Args as ClapArgs;
use clap_complete::Shell;

pub const COMPLETIONS_EXAMPLES: &str = "\
Examples:
  tashika completions bash > ~/.local/share/bash-completion/completions/tashika
  tashika completions zsh > ~/.zfunc/_tashika          with fpath+=~/.zfunc before compinit
  tashika completions fish > ~/.config/fish/completions/tashika.fish";

pub const MAN_EXAMPLES: &str = "\
Examples:
  tashika man | man -l -
  tashika man render > ~/.local/share/man/man1/tashika-render.1
  tashika man farm slurm";

#[derive(Debug, ClapArgs)]
pub struct CompletionsArgs {
    /// Shell that the script is made for
    #[arg(value_enum)]
    pub shell: Shell,
}

#[derive(Debug, ClapArgs)]
pub struct ManArgs {
    /// Command that the page describes; the program if none
    #[arg(value_name = "COMMAND")]
    pub command: Vec<String>,
}
