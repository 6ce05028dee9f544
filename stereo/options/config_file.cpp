#include "stereo/options/config_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <sstream>

#include "stereo/base/files.h"
#include "stereo/options/command_line.h"

namespace farshade {
namespace {

constexpr std::uint64_t kMost_bytes = std::uint64_t{64} * 1024;

struct Setting {
  std::string key, value;
};

/// What the text of a command line says before it is parsed.
struct Given {
  std::vector<Setting> options;  ///< their keys have dashes; in the order given
  std::optional<std::string> config;
  const CLI::App* command;  ///< the program, or its subcommand
  std::size_t command_at;   ///< index of the first argument that belongs to `command`
};

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& why) {
  throw CLI::ParseError(file.string() + ": " + why, CLI::ExitCodes::ConfigError);
}

/// A value without its quotes.
std::string unquoted(const std::string& value) {
  const bool quoted =
      value.size() >= 2 && (value.front() == '"' || value.front() == '\'') && value.back() == value.front();
  return quoted ? value.substr(1, value.size() - 2) : value;
}

std::vector<Setting> read_settings(const std::filesystem::path& file) {
  const Expected<std::vector<std::byte>> bytes = read_file(file, kMost_bytes);
  if (!bytes) throw CLI::ParseError(bytes.error().what, CLI::ExitCodes::FileError);
  std::istringstream text(std::string(reinterpret_cast<const char*>(bytes->data()), bytes->size()));
  std::vector<Setting> settings;
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    CLI::detail::trim(line);
    if (line.empty() || line.front() == '#' || line.front() == ';') continue;
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos || equals == 0)
      refuse(file, fmt::format("line {}: '{}' is not KEY = VALUE", number, line));
    settings.push_back({CLI::detail::trim_copy(line.substr(0, equals)),
                        unquoted(CLI::detail::trim_copy(line.substr(equals + 1)))});
  }
  return settings;
}

/// The subcommand of that name, or null.
const CLI::App* subcommand_of(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : commands_of(app))
    if (command->get_name() == name) return command;
  return nullptr;
}

/// Looks at options up to the first subcommand, and at those of the subcommand.
Given look_at(const CLI::App& app, int argc, const char* const* argv) {
  Given given{.options = {}, .config = std::nullopt, .command = &app, .command_at = 1};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::size_t equals = word.find('=');
    if (!word.starts_with('-')) {
      const CLI::App* const subcommand = given.command == &app ? subcommand_of(app, word) : nullptr;
      if (subcommand != nullptr)
        given.command = subcommand, given.command_at = static_cast<std::size_t>(i) + 1;
      continue;
    }
    const std::string name = word.substr(0, equals);
    const CLI::Option* const option = given.command->get_option_no_throw(name);
    std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
    const bool takes_next = equals == std::string::npos && option != nullptr &&
                            option->get_expected_min() > 0 && option->get_type_size() > 0 && i + 1 < argc;
    if (takes_next) value = argv[++i];
    given.options.push_back({name, value});
    if (name == "--config" && (takes_next || equals != std::string::npos)) given.config = value;
  }
  return given;
}

bool is_given(const Given& given, const std::string& option) {
  return std::ranges::find(given.options, option, &Setting::key) != given.options.end();
}

/// The option of a key in `app`; null if a file cannot set it.
const CLI::Option* option_of(const CLI::App& app, const std::string& key) {
  const CLI::Option* const option = app.get_option_no_throw("--" + key);
  return option != nullptr && option->get_configurable() ? option : nullptr;
}

std::vector<std::string> keys_of(const CLI::App& app) {
  std::vector<std::string> keys;
  for (const CLI::Option* option : app.get_options())
    if (option->get_configurable())
      keys.insert(keys.end(), option->get_lnames().begin(), option->get_lnames().end());
  return keys;
}

bool holds(const Given& given, const ConfigException& exception) {
  return std::ranges::any_of(given.options, [&](const Setting& option) {
    return option.key == exception.option && (exception.value.empty() || option.value == exception.value);
  });
}

/// Whether the command line takes the place of the key.
bool is_replaced(const Given& given, const std::string& key, const ConfigRules& rules) {
  const CLI::Option* const option = option_of(*given.command, key);
  if (option == nullptr || is_given(given, "--" + key)) return true;
  const auto excepts = [&](const ConfigException& exception) {
    return holds(given, exception) &&
           std::ranges::find(exception.ignored, "--" + key) != exception.ignored.end();
  };
  if (std::ranges::any_of(rules.exceptions, excepts)) return true;
  return std::ranges::any_of(option->get_excludes(),
                             [&](const CLI::Option* other) { return is_given(given, other->get_name()); });
}

/// `--key=value` for each key that counts.
std::vector<Setting> settings_that_count(const CLI::App& app, const Given& given, const ConfigRules& rules,
                                         const std::filesystem::path& file) {
  std::vector<Setting> settings = read_settings(file);
  for (const Setting& setting : settings)
    if (option_of(app, setting.key) == nullptr)
      refuse(file, fmt::format("unknown key '{}'{}", setting.key, suggestion(setting.key, keys_of(app))));
  std::erase_if(settings, [&](const Setting& setting) { return is_replaced(given, setting.key, rules); });
  return settings;
}

}  // namespace

void add_config_option(CLI::App& app, const ConfigRules& rules) {
  // parse_with_config() has read the file before this option is parsed.
  app.add_option_function<std::string>(
         "--config", [](const std::string&) {},
         "file that sets these options by lines such as size = 96x64; the command line overrides it; '': "
         "none")
      ->type_name("FILE")
      ->default_str(rules.default_file.string() + " if it exists")
      ->configurable(false);
}

void parse_with_config(CLI::App& app, int argc, const char* const* argv, const ConfigRules& rules) {
  const Given given = look_at(app, argc, argv);
  std::error_code ignored;
  const bool by_default = !given.config && std::filesystem::exists(rules.default_file, ignored);
  const std::filesystem::path file =
      by_default ? rules.default_file : std::filesystem::path(given.config.value_or(""));
  // These must work whatever the file contains.
  const bool reads =
      !file.empty() && std::ranges::none_of(std::array{"-h", "--help", "--version", "--completion"},
                                            [&](const char* option) { return is_given(given, option); });
  const std::vector<Setting> settings =
      reads ? settings_that_count(app, given, rules, file) : std::vector<Setting>();
  std::vector<std::string> arguments(argv + 1, argv + argc);
  std::vector<std::string> added;
  for (const Setting& setting : settings) added.push_back("--" + setting.key + "=" + setting.value);
  arguments.insert(arguments.begin() + static_cast<std::ptrdiff_t>(given.command_at - 1), added.begin(),
                   added.end());
  std::ranges::reverse(arguments);
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::Success&) {
    throw;
  } catch (const CLI::ParseError& error) {
    const std::string what = error.what();
    // These options are not on the command line, so an error that names one is the file's.
    for (const Setting& setting : settings)
      if (what.starts_with("--" + setting.key + ":") ||
          what.find("--" + setting.key + " ") != std::string::npos)
        refuse(file, what);
    throw;
  }
}

}  // namespace farshade
