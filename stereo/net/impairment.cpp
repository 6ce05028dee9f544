#include "stereo/net/impairment.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

#include "stereo/base/check.h"

namespace farshade {
namespace {

/// Heap order: the earliest arrival is on top.
constexpr auto kLater = [](const InTransit* a, const InTransit* b) {
  return a->arrival != b->arrival ? a->arrival > b->arrival : a->order > b->order;
};

}  // namespace

Impairment::Impairment(const LinkModel& model, Time start, std::uint64_t stream)
    : model_(model),
      start_(start),
      random_(model.seed * 0x9e3779b97f4a7c15u + stream),
      bottleneck_free_(start) {
  check(model.burst >= 1, "a burst of losses is one or more");
}

void Impairment::follow(const LinkModel& model) {
  check(model.burst >= 1, "a burst of losses is one or more");
  model_ = model;
}

bool Impairment::push(Time now, const Peer& peer, std::span<const std::byte> bytes) {
  check(bytes.size() <= kMaxDatagram_bytes, "a datagram fits kMaxDatagram_bytes");
  const struct {
    double loss, jitter, reorder, duplicate, second_jitter, corrupt, corrupt_at;
  } draw{uniform(), uniform(), uniform(), uniform(), uniform(), uniform(), uniform()};
  const bool lost = loses(draw.loss);
  if (is_silent(now)) {
    ++counters_.lost;
    return true;
  }
  if (is_too_long(peer, bytes.size())) {
    ++counters_.too_long;
    return true;
  }
  const std::optional<Time> left = past_bottleneck(now, bytes.size());
  if (!left) {
    ++counters_.overflowed;
    return true;
  }
  // After the bottleneck, so that another loss rate does not change the times of other datagrams.
  if (lost) {
    ++counters_.lost;
    return true;
  }
  const bool held = draw.reorder < model_.reorder;
  const Time first = arrival(*left, draw.jitter) + (held ? model_.reorder_by : Duration::zero());
  InTransit* const item = put(first, peer, bytes);
  if (item == nullptr) return false;
  if (held) ++counters_.reordered;
  if (draw.corrupt < model_.corrupt && !bytes.empty()) {
    const auto bit = static_cast<std::size_t>(draw.corrupt_at * static_cast<double>(8 * bytes.size()));
    item->buffer[bit / 8] ^= std::byte{1} << (bit % 8);
    ++counters_.corrupted;
  }
  if (draw.duplicate < model_.duplicate &&
      put(arrival(*left, draw.second_jitter), peer, item->bytes()) != nullptr)
    ++counters_.duplicated;
  return true;
}

void Impairment::pop() {
  std::ranges::pop_heap(queue_, kLater);
  free_.push_back(queue_.back());
  queue_.pop_back();
}

/// Uniform in [0, 1). The distributions of std differ between standard libraries; the engine does not.
double Impairment::uniform() {
  return static_cast<double>(random_() >> 11) * 0x1p-53;
}

bool Impairment::is_silent(Time now) const {
  if (model_.silence_every == Duration::zero()) return false;
  return (now - start_) % model_.silence_every >= model_.silence_every - model_.silence;
}

bool Impairment::is_too_long(const Peer& peer, std::size_t size) const {
  constexpr std::size_t kHeadersV4_bytes = 20 + 8, kHeadersV6_bytes = 40 + 8;
  return model_.mtu_bytes != 0 &&
         size + (is_v4(peer) ? kHeadersV4_bytes : kHeadersV6_bytes) > model_.mtu_bytes;
}

/// With r = P(good | lost) and p = P(lost | good) the rate is p / (p + r) and a burst lasts 1 / r.
bool Impairment::loses(double draw) {
  const double r = std::min(1 / model_.burst, 1 - model_.loss);
  const double p = model_.loss * std::min(1.0, 1 / (model_.burst * (1 - model_.loss)));
  in_burst_ = draw < (in_burst_ ? 1 - r : p);
  return in_burst_;
}

/// The time at which the last byte leaves the bottleneck; nothing if its queue is full.
std::optional<Time> Impairment::past_bottleneck(Time now, std::size_t size) {
  if (model_.rate_bytes_per_s == 0) return now;
  const Time begins = std::max(now, bottleneck_free_);
  if (begins - now > model_.queue) return std::nullopt;
  const double takes_s = static_cast<double>(size) / model_.rate_bytes_per_s;
  bottleneck_free_ = begins + duration_from_ms(takes_s * 1e3);
  return bottleneck_free_;
}

Time Impairment::arrival(Time left, double jitter_draw) const {
  const double extra_ns = jitter_draw * static_cast<double>(model_.jitter.count());
  return left + model_.delay + Duration(static_cast<Duration::rep>(extra_ns));
}

InTransit* Impairment::put(Time arrival, const Peer& peer, std::span<const std::byte> bytes) {
  if (queue_.size() == kLinkCapacity) {
    ++counters_.overflowed;
    return nullptr;
  }
  if (free_.empty()) free_.push_back(owned_.emplace_back(std::make_unique<InTransit>()).get());
  InTransit* const item = free_.back();
  free_.pop_back();
  item->arrival = arrival;
  item->order = next_order_++;
  item->peer = peer;
  item->size = bytes.size();
  std::ranges::copy(bytes, item->buffer.begin());
  queue_.push_back(item);
  std::ranges::push_heap(queue_, kLater);
  return item;
}

namespace {

struct Unit {
  std::string_view name;
  double factor;
};
constexpr std::array kShares{Unit{"%", 0.01}};
constexpr std::array kCounts{Unit{"", 1}};
constexpr std::array kTimes_ns{Unit{"us", 1e3}, Unit{"ms", 1e6}, Unit{"s", 1e9}};
constexpr std::array kRates_bytes_per_s{Unit{"kbit", 1e3 / 8}, Unit{"Mbit", 1e6 / 8}, Unit{"Gbit", 1e9 / 8}};
constexpr double kMostTime_ns = 60e9;

/// The result of parsing a value.
enum class ParseResult { Sound, Malformed, OutOfRange };

ParseResult number(std::string_view text, std::span<const Unit> units, double least, double most,
                   double& into) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{}) return ParseResult::Malformed;
  const auto unit = std::ranges::find(units, std::string_view(stop, end), &Unit::name);
  if (unit == units.end()) return ParseResult::Malformed;
  value *= unit->factor;
  if (!(value >= least && value <= most)) return ParseResult::OutOfRange;
  into = value;
  return ParseResult::Sound;
}

ParseResult time(std::string_view text, Duration& into) {
  double ns = 0;
  const ParseResult read = number(text, kTimes_ns, 0, kMostTime_ns, ns);
  if (read == ParseResult::Sound) into = Duration(std::llround(ns));
  return read;
}

ParseResult silence(std::string_view text, LinkModel& model) {
  const std::size_t slash = text.find('/');
  if (slash == text.npos) return ParseResult::Malformed;
  const ParseResult part = time(text.substr(0, slash), model.silence);
  if (part != ParseResult::Sound) return part;
  const ParseResult whole = time(text.substr(slash + 1), model.silence_every);
  if (whole != ParseResult::Sound) return whole;
  const bool fits = model.silence <= model.silence_every && model.silence_every > Duration::zero();
  return fits ? ParseResult::Sound : ParseResult::OutOfRange;
}

ParseResult rate(std::string_view text, LinkModel& model) {
  constexpr double kLeast_bytes_per_s = 125, kMost_bytes_per_s = 125e9;
  return number(text, kRates_bytes_per_s, kLeast_bytes_per_s, kMost_bytes_per_s, model.rate_bytes_per_s);
}

ParseResult mtu(std::string_view text, LinkModel& model) {
  constexpr std::size_t kLeast_bytes = 576, kMost_bytes = 65'535;
  std::size_t bytes = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, bytes);
  if (error == std::errc::invalid_argument || stop != end) return ParseResult::Malformed;
  if (error != std::errc{} || bytes < kLeast_bytes || bytes > kMost_bytes) return ParseResult::OutOfRange;
  model.mtu_bytes = bytes;
  return ParseResult::Sound;
}

ParseResult seed(std::string_view text, LinkModel& model) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, model.seed);
  return error == std::errc{} && stop == end ? ParseResult::Sound : ParseResult::Malformed;
}

template <double LinkModel::*share>
ParseResult share_of(std::string_view text, LinkModel& model) {
  return number(text, kShares, 0, 1, model.*share);
}

template <Duration LinkModel::*span>
ParseResult time_of(std::string_view text, LinkModel& model) {
  return time(text, model.*span);
}

struct Setting {
  std::string_view name, example;
  ParseResult (*read)(std::string_view value, LinkModel& model);
};
constexpr std::array<Setting, 13> kSettings{{
    {"loss", "2%", share_of<&LinkModel::loss>},
    {"burst", "3", [](std::string_view v, LinkModel& m) { return number(v, kCounts, 1, 1000, m.burst); }},
    {"delay", "25ms", time_of<&LinkModel::delay>},
    {"jitter", "5ms", time_of<&LinkModel::jitter>},
    {"reorder", "2%", share_of<&LinkModel::reorder>},
    {"reorder_by", "10ms", time_of<&LinkModel::reorder_by>},
    {"duplicate", "1%", share_of<&LinkModel::duplicate>},
    {"corrupt", "0.5%", share_of<&LinkModel::corrupt>},
    {"rate", "10Mbit", rate},
    {"queue", "100ms", time_of<&LinkModel::queue>},
    {"mtu", "1400", mtu},
    {"silence", "2s/5s", silence},
    {"seed", "7", seed},
}};

std::string what_there_is() {
  std::string text = "a network is one of";
  for (const NamedNetwork& network : kNetworks) text += " " + std::string(network.name);
  text += " and/or words such as";
  char separator = ' ';
  for (const Setting& setting : kSettings) {
    text += separator + std::string(setting.name) + "=" + std::string(setting.example);
    separator = ',';
  }
  return text;
}

Expected<void> apply(std::string_view word, LinkModel& model) {
  const std::string quoted = "'" + std::string(word) + "'";
  const std::size_t equals = word.find('=');
  const auto setting = std::ranges::find(kSettings, word.substr(0, equals), &Setting::name);
  if (equals == word.npos || setting == kSettings.end())
    return fail(Fault::Malformed, quoted + " says nothing of a network: " + what_there_is());
  switch (setting->read(word.substr(equals + 1), model)) {
    case ParseResult::Sound:
      return {};
    case ParseResult::Malformed:
      return fail(Fault::Malformed, quoted + " cannot be read: write it like " + std::string(setting->name) +
                                        "=" + std::string(setting->example) + "; " + what_there_is());
    case ParseResult::OutOfRange:
      break;
  }
  return fail(Fault::OutOfRange,
              quoted +
                  " is out of range: rates are 0 to 100%, bursts 1 to 1000, times 0 to 60s, rates of "
                  "bytes 1kbit to 1000Gbit, an mtu 576 to 65535, and a silence is a part of its period");
}

}  // namespace

Expected<LinkModel> parse_link_model(std::string_view text) {
  LinkModel model;
  bool first = true;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t comma = std::min(text.find(',', at), text.size());
    const std::string_view word = text.substr(at, comma - at);
    at = comma + 1;
    const auto named = std::ranges::find(kNetworks, word, &NamedNetwork::name);
    if (std::exchange(first, false) && named != kNetworks.end()) {
      model = named->model;
      continue;
    }
    if (const Expected<void> applied = apply(word, model); !applied) return tl::unexpected(applied.error());
  }
  return model;
}

}  // namespace farshade
