/// One readable form for the options of all programs: words instead of the numbers of enumerations, plain
/// ranges and defaults in --help, and a suggestion after a misspelt word or option.
#pragma once

#include <CLI/CLI.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace farshade {

/// "; did you mean hybrid?" if one of `words` is close to `given`; otherwise empty.
[[nodiscard]] std::string suggestion(const std::string& given, std::span<const std::string> words);

/// Sets how `app` prints its help and its errors. Subcommands that are added later do the same.
void make_readable(CLI::App& app);

/// All subcommands of `app`, given or not.
[[nodiscard]] std::vector<const CLI::App*> commands_of(const CLI::App& app);

/// The long names of the options of `app`, such as --scene.
[[nodiscard]] std::vector<std::string> options_of(const CLI::App& app);

/// Accepts these words only. An empty word is accepted if it is one of them, but not named.
[[nodiscard]] CLI::Validator one_of(std::vector<std::string> words);

/// "hybrid|full".
[[nodiscard]] std::string joined(std::span<const std::string> words, const std::string& separator = "|");

/// The words of an option and what they stand for, in the order of --help.
template <class Value>
using Words = std::vector<std::pair<std::string, Value>>;

/// An option that takes one of `words`. Its default is the word for the present `value`, which must outlive
/// the parsing.
template <class Value>
CLI::Option* add_words(CLI::App& app, const std::string& name, Value& value, const Words<Value>& words,
                       const std::string& about) {
  std::vector<std::string> names;
  std::string present;
  for (const auto& [word, meaning] : words) {
    names.push_back(word);
    if (meaning == value) present = word;
  }
  const auto choose = [&value, words](const std::string& given) {
    for (const auto& [word, meaning] : words)
      if (word == given) value = meaning;
  };
  return app.add_option_function<std::string>(name, choose, about)
      ->type_name(joined(names))
      ->check(one_of(names))
      ->default_str(present);
}

}  // namespace farshade
