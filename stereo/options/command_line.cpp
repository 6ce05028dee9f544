#include "stereo/options/command_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <optional>

namespace farshade {
namespace {

/// Letters to insert, remove, replace or swap with their neighbour (optimal string alignment).
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> rows(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i)
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        rows[i][j] = i + j;
        continue;
      }
      rows[i][j] =
          std::min({rows[i - 1][j] + 1, rows[i][j - 1] + 1, rows[i - 1][j - 1] + (a[i - 1] != b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        rows[i][j] = std::min(rows[i][j], rows[i - 2][j - 2] + 1);
    }
  return rows[a.size()][b.size()];
}

/// The long names of the options of `app` and of the subcommands that were given, and the subcommands.
std::vector<std::string> known_words(const CLI::App& app) {
  std::vector<std::string> words = options_of(app);
  for (const CLI::App* command : commands_of(app)) words.push_back(command->get_name());
  for (const CLI::App* command : app.get_subcommands()) {
    const std::vector<std::string> more = known_words(*command);
    words.insert(words.end(), more.begin(), more.end());
  }
  return words;
}

/// The first argument that nothing takes.
std::string unknown_argument(const CLI::App& app) {
  const std::vector<std::string> remaining = app.remaining(true);
  if (remaining.empty()) return {};
  const std::string word = remaining.front().substr(0, remaining.front().find('='));
  const std::string kind = word.starts_with('-') ? "unknown option " : "unexpected argument ";
  return kind + word + suggestion(word, known_words(app));
}

std::string one_line(const CLI::App* app, const CLI::Error& error) {
  std::string what = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr)
    if (std::string unknown = unknown_argument(*app); !unknown.empty()) what = std::move(unknown);
  return fmt::format("{}: {} (see --help)\n", std::filesystem::path(app->get_name()).filename().string(),
                     what);
}

/// Shows "NUMBER (0 to 500, default: 20)".
class Help final : public CLI::Formatter {
 public:
  /// A flag that is false when given shows as any other flag.
  [[nodiscard]] std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    const std::string name = CLI::Formatter::make_option_name(option, is_positional);
    return name.substr(0, name.find('{'));
  }

  [[nodiscard]] std::string make_option_opts(const CLI::Option* option) const override {
    if (option->get_type_size() == 0) return {};
    // The type is followed by the descriptions of its checks: "FLOAT:0 to 500".
    const std::string full = option->get_type_name();
    const std::size_t end = full.find(':');
    const std::string type = full.substr(0, end);
    std::vector<std::string> more;
    if (end != std::string::npos) more.push_back(full.substr(end + 1));
    if (!option->get_default_str().empty()) more.push_back("default: " + option->get_default_str());
    if (option->get_required()) more.emplace_back("required");
    const bool is_number = type == "UINT" || type == "INT" || type == "FLOAT";
    const std::string shown = is_number ? "NUMBER" : type;
    return " " + shown + (more.empty() ? std::string() : fmt::format(" ({})", fmt::join(more, ", ")));
  }
};

}  // namespace

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string suggestion(const std::string& given, std::span<const std::string> words) {
  std::optional<std::string> best;
  std::size_t least = std::clamp<std::size_t>(given.size() / 3, 1, 3) + 1;
  for (const std::string& word : words)
    if (const std::size_t apart = distance(given, word); apart < least && !word.empty()) {
      least = apart;
      best = word;
    }
  return best ? "; did you mean " + *best + "?" : std::string();
}

void make_readable(CLI::App& app) {
  app.formatter(std::make_shared<Help>());
  app.failure_message(&one_line);
}

std::string joined(std::span<const std::string> words, const std::string& separator) {
  std::string text;
  for (const std::string& word : words)
    if (!word.empty()) text += (text.empty() ? "" : separator) + word;
  return text;
}

CLI::Validator one_of(std::vector<std::string> words) {
  return {[words = std::move(words)](std::string& given) {
            if (std::ranges::find(words, given) != words.end()) return std::string();
            return fmt::format("'{}' is not one of {}{}", given, joined(words, ", "),
                               suggestion(given, words));
          },
          ""};
}

}  // namespace farshade
