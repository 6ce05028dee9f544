#include "tests/study/mode_words.h"

#include <charconv>
#include <functional>
#include <map>

namespace farshade::study {
namespace {

/// A frame that waits for its own masks gives up after this.
constexpr Duration kLongestWait = std::chrono::seconds(1);

std::optional<std::uint32_t> count_from(std::string_view text) {
  std::uint32_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size() || value == 0) return std::nullopt;
  return value;
}

/// Takes the value of a word; false: the word has no such value.
using Setter = std::function<bool(std::string_view value, Play& play)>;

/// A word that has one value beside its default.
template <class Set>
Setter only(std::string_view value, const Set& set) {
  return [=](std::string_view text, Play& play) { return text == value && (set(play), true); };
}

const std::map<std::string_view, Setter>& hybrid_words() {
  static const std::map<std::string_view, Setter> words{
      {"reprojection", only("off", [](Play& play) { play.carry_over.lookup = Lookup::Direct; })},
      {"band", only("off", [](Play& play) { play.request.guard_band = GuardBandUse::Off; })},
      {"eyes", only("this", [](Play& play) { play.carry_over.eyes = Eyes::This; })},
      {"gaps", only("unknown", [](Play& play) { play.carry_over.gaps = Gaps::Unknown; })},
      {"edges", only("nearest", [](Play& play) { play.carry_over.edges = Edges::Nearest; })},
      {"wait", only("", [](Play& play) { play.mask_wait = kLongestWait; })},
      {"predictor",
       [](std::string_view value, Play& play) {
         const std::optional<PredictorKind> kind = parse_predictor(value);
         play.request.predictor = kind.value_or(play.request.predictor);
         return kind.has_value();
       }},
      {"every",
       [](std::string_view value, Play& play) {
         const std::optional<std::uint32_t> every = count_from(value);
         play.request.every = every.value_or(play.request.every);
         return every.has_value();
       }},
  };
  return words;
}

struct NamedMode {
  Mode mode;
  const std::map<std::string_view, Setter>& words;
};

const std::map<std::string_view, NamedMode>& modes() {
  static const std::map<std::string_view, Setter> none;
  static const std::map<std::string_view, NamedMode> named{
      {"hybrid", {Mode::Hybrid, hybrid_words()}},
      {"full", {Mode::Full, none}},
  };
  return named;
}

/// Cuts the first of the words, which commas part, off `words`.
std::string_view next_word(std::string_view& words) {
  const std::size_t end = std::min(words.find(','), words.size());
  const std::string_view word = words.substr(0, end);
  words.remove_prefix(std::min(end + 1, words.size()));
  return word;
}

}  // namespace

Expected<void> set_mode(std::string_view words, Play& play) {
  const std::string_view name = next_word(words);
  const auto mode = modes().find(name);
  if (mode == modes().end()) return fail(Fault::Malformed, "no mode is called '" + std::string(name) + "'");
  play.mode = mode->second.mode;
  while (!words.empty()) {
    const std::string_view word = next_word(words);
    const std::size_t equals = std::min(word.find('='), word.size());
    const auto setter = mode->second.words.find(word.substr(0, equals));
    const std::string_view value = word.substr(std::min(equals + 1, word.size()));
    if (setter == mode->second.words.end() || !setter->second(value, play))
      return fail(Fault::Malformed, "mode " + std::string(name) + " has no '" + std::string(word) + "'");
  }
  return {};
}

}  // namespace farshade::study
