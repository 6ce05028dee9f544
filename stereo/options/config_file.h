/// Configuration files: lines `KEY = VALUE`, where KEY is the long name of an option of the program. A line
/// that begins with # or ; is a comment. A value may be quoted; nothing in it is expanded. An option that can
/// be given several times may have several lines. A flag is `true` or `false`.
///
/// The command line wins: a key is ignored if its option is on the command line, or excludes one that is.
/// With a subcommand, only those keys count that are options of the subcommand, too.
///
/// CLI11 reads such files as well, but then an option from a file counts as given, so a file with `delay =
/// 30` would make --preview fail; and its errors do not name the file.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace farshade {

/// While the option `option` is on the command line, the options `ignored` are ignored in the file. All have
/// their dashes.
struct ConfigException {
  std::string option;
  std::string value{};  ///< of `option`; empty: any
  std::span<const char* const> ignored{};
};

struct ConfigRules {
  std::filesystem::path default_file;  ///< read if it exists and no --config is given
  std::vector<ConfigException> exceptions{};
};

/// Adds the option --config. Call it after the other options and subcommands were added.
void add_config_option(CLI::App& app, const ConfigRules& rules);

/// Like app.parse(argc, argv), with what the configuration file adds. Throws CLI::ParseError as it does, and
/// for a file that cannot be read, a line without a key, an unknown key (with a suggestion) and a value that
/// its option refuses. These errors name the file.
void parse_with_config(CLI::App& app, int argc, const char* const* argv, const ConfigRules& rules);

}  // namespace farshade
