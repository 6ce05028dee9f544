#include "stereo/head/writer.h"

#include <charconv>
#include <initializer_list>

#include "stereo/head/formats.h"

namespace farshade {
namespace {

/// The shortest text that reads back as the same double.
std::string text_of(double value) {
  char digits[32];
  return {digits, std::to_chars(std::begin(digits), std::end(digits), value).ptr};
}

std::string row_of(std::string stamp, std::initializer_list<double> values, char separator) {
  for (const double value : values) (stamp += separator) += text_of(value);
  return stamp += '\n';
}

std::string comment(std::string_view key, std::string_view value) {
  return ("# " + std::string(key) + ": ").append(value) + '\n';
}

std::string header(const HeadRecording& recording, std::string_view units, std::string_view columns) {
  std::string text = comment(formats::kAxesKey, formats::kAxes) + comment(formats::kUnitsKey, units) +
                     comment("clock", "monotonic") + comment("space", "head in stage") +
                     comment(formats::kEyeDistanceKey, text_of(recording.eye_distance_m));
  for (const Side side : kSides) {
    const EyeFov& fov = recording.fov[index_of(side)];
    text += comment(formats::kFovKeys[index_of(side)], text_of(fov.left_rad) + ' ' + text_of(fov.right_rad) +
                                                           ' ' + text_of(fov.up_rad) + ' ' +
                                                           text_of(fov.down_rad));
  }
  return text.append("#").append(columns) + '\n';
}

/// Seconds with nine decimals, exact.
std::string seconds_text(std::int64_t ns) {
  const std::uint64_t size = ns < 0 ? 0 - static_cast<std::uint64_t>(ns) : static_cast<std::uint64_t>(ns);
  std::string fraction = std::to_string(size % 1'000'000'000);
  fraction.insert(0, 9 - fraction.size(), '0');
  return (ns < 0 ? "-" : "") + std::to_string(size / 1'000'000'000) + '.' + fraction;
}

}  // namespace

std::string euroc_text(const HeadRecording& recording) {
  std::string text = header(recording, formats::kEurocUnits, formats::kEurocColumns);
  for (const auto& [time, head] : recording.samples) {
    const auto& [q, p] = head;
    text += row_of(std::to_string(ns_of(time)), {p.x, p.y, p.z, q.w, q.x, q.y, q.z}, ',');
  }
  return text;
}

std::string tum_text(const HeadRecording& recording) {
  std::string text = header(recording, formats::kTumUnits, formats::kTumColumns);
  for (const auto& [time, head] : recording.samples) {
    const auto& [q, p] = head;
    text += row_of(seconds_text(ns_of(time)), {p.x, p.y, p.z, q.x, q.y, q.z, q.w}, ' ');
  }
  return text;
}

}  // namespace farshade
