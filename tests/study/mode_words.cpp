#include "tests/study/mode_words.h"

#include <algorithm>
#include <charconv>
#include <functional>

#include "stereo/plan/plan_masks.h"

namespace farshade::study {
namespace {

/// The longest time that a frame waits for its own answer.
constexpr Duration kLongestWait = std::chrono::seconds(1);

/// A number in [least, most]; K or M may follow it.
std::optional<std::uint32_t> number_from(std::string_view text, std::uint32_t least, std::uint32_t most) {
  std::uint64_t value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit = text.substr(static_cast<std::size_t>(read.ptr - text.data()));
  if (read.ec != std::errc{} || value > most) return std::nullopt;
  if (!unit.empty() && unit != "K" && unit != "M") return std::nullopt;
  value *= unit.empty() ? 1 : unit == "K" ? 1'000 : 1'000'000;
  if (value < least || value > most) return std::nullopt;
  return static_cast<std::uint32_t>(value);
}

/// Applies the value of a word. Returns false for an invalid value.
using Setter = std::function<bool(std::string_view value, Play& play)>;

/// A word with one value besides its default.
template <class Set>
Setter only(std::string_view value, const Set& set) {
  return [=](std::string_view text, Play& play) { return text == value && (set(play), true); };
}

template <class Set>
Setter number(std::uint32_t least, std::uint32_t most, const Set& set) {
  return [=](std::string_view text, Play& play) {
    const std::optional<std::uint32_t> value = number_from(text, least, most);
    if (value) set(play, *value);
    return value.has_value();
  };
}

bool set_detail(std::string_view value, Play& play) {
  float limit_px = 0;
  const auto read = std::from_chars(value.data(), value.data() + value.size(), limit_px);
  if (read.ec != std::errc{} || read.ptr != value.data() + value.size()) return false;
  if (!(limit_px >= 0 && limit_px <= kMostDetail_px)) return false;
  play.detail_px = limit_px;
  return true;
}

bool set_predictor(std::string_view value, Play& play) {
  const std::optional<PredictorKind> kind = parse_predictor(value);
  play.request.predictor = kind.value_or(play.request.predictor);
  return kind.has_value();
}

bool set_edges(std::string_view value, Play& play) {
  if (value != "nearest" && value != "coverage") return false;
  play.reprojection.edges = value == "nearest" ? Edges::Nearest : Edges::Coverage;
  return true;
}

struct Word {
  std::string_view name;
  bool (*fits)(Mode mode);
  Setter set;
};

const std::vector<Word>& all_words() {
  const auto asks = [](Mode mode) { return answers_for(mode) != 0; };
  const auto reprojects = [](Mode mode) { return reprojects_masks(mode); };
  const auto widens = [](Mode mode) { return has_guard_band(mode); };
  const auto sends_positions = [](Mode mode) { return mode == Mode::ClientPositions; };
  const auto streams = [](Mode mode) { return mode == Mode::Remote || mode == Mode::Delta; };
  const auto only_hybrid = [](Mode mode) { return mode == Mode::Hybrid; };
  const auto maps = [](Mode mode) { return mode == Mode::Local; };
  const auto draws = [](Mode mode) { return mode != Mode::ServerGBuffer && mode != Mode::Remote; };
  using Value = std::uint32_t;
  static const std::vector<Word> words{
      {"detail", draws, &set_detail},
      {"predictor", asks, &set_predictor},
      {"every", asks, number(1, 64, [](Play& play, Value n) { play.request.every = n; })},
      {"ask", only_hybrid, only("whole", [](Play& play) { play.request.asks = Asks::Whole; })},
      {"code", only_hybrid, only("lz4", [](Play& play) { play.mode.mask_code = MaskCode::Lz4; })},
      {"wait", asks, only("", [](Play& play) { play.mask_wait = kLongestWait; })},
      {"reprojection", reprojects,
       only("off", [](Play& play) { play.reprojection.lookup = Lookup::Direct; })},
      {"band", widens, only("off", [](Play& play) { play.request.guard_band = GuardBandUse::Off; })},
      {"eyes", reprojects, only("this", [](Play& play) { play.reprojection.eyes = Eyes::This; })},
      {"gaps", reprojects, only("unknown", [](Play& play) { play.reprojection.gaps = Gaps::Unknown; })},
      {"edges", reprojects, &set_edges},
      {"bits", sends_positions,
       number(kLeastPosition_bits, kMostPosition_bits,
              [](Play& play, Value n) { play.mode.position_bits = n; })},
      {"bitrate", streams,
       number(kLeastVideo_bits, kMostVideo_bits, [](Play& play, Value n) { play.mode.bits_per_second = n; })},
      {"maps", maps,
       number(kLeastMapSide_px, kMostMapSide_px,
              [](Play& play, Value n) { play.mode.shadow_maps.side_px = n; })},
      {"pcf", maps,
       number(0, kMostPcfRadius, [](Play& play, Value n) { play.mode.shadow_maps.pcf_radius = n; })},
      {"redraw", maps, only("always", [](Play& play) { play.mode.shadow_maps.redraw = Redraw::Always; })},
  };
  return words;
}

/// Removes the first word, up to a comma, from `words` and returns it.
std::string_view next_word(std::string_view& words) {
  const std::size_t end = std::min(words.find(','), words.size());
  const std::string_view word = words.substr(0, end);
  words.remove_prefix(std::min(end + 1, words.size()));
  return word;
}

}  // namespace

Expected<void> set_mode(std::string_view words, Play& play) {
  const std::string_view name = next_word(words);
  const auto mode = std::ranges::find(kModes, name, &ModeName::name);
  if (mode == kModes.end()) return fail(Fault::Malformed, "no mode is called '" + std::string(name) + "'");
  play.mode.mode = mode->mode;
  while (!words.empty()) {
    const std::string_view word = next_word(words);
    const std::size_t equals = std::min(word.find('='), word.size());
    const auto known = std::ranges::find(all_words(), word.substr(0, equals), &Word::name);
    const std::string_view value = word.substr(std::min(equals + 1, word.size()));
    if (known == all_words().end() || !known->fits(mode->mode) || !known->set(value, play))
      return fail(Fault::Malformed, "mode " + std::string(name) + " has no '" + std::string(word) + "'");
  }
  return {};
}

}  // namespace farshade::study
