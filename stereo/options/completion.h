/// Shell completion that a program prints about itself: its options, subcommands and words come from the
/// same objects that parse the command line and print --help.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace farshade {

enum class Shell : std::uint8_t { Bash, Zsh };

/// A script that completes the options and subcommands of `app`, and the values of options that take one of
/// some words. Other values are completed as file names. `app` has a name: that of the program.
[[nodiscard]] std::string completion_script(const CLI::App& app, Shell shell);

/// Adds --completion, which prints the script to standard output and ends the parsing with CLI::Success.
/// `app` must outlive the parsing.
void add_completion_option(CLI::App& app);

}  // namespace farshade
