#include "stereo/head/reader.h"

#include <cmath>

#include "stereo/base/files.h"
#include "stereo/head/formats.h"
#include "stereo/head/rows.h"

namespace farshade {
namespace {

enum class Format { Euroc, Tum, EyeNavGs };

/// Detects the format by the first line that is not a comment. A file with only comments is an empty EuRoC
/// file.
Format format_of(std::string_view text) {
  rows::Lines lines(text, "");
  for (std::string_view line; lines.next(line);) {
    if (line.starts_with("ViewIndex,")) return Format::EyeNavGs;
    if (line.front() != '#') return line.find(',') == line.npos ? Format::Tum : Format::Euroc;
  }
  return Format::Euroc;
}

struct KnownScale {
  std::string_view name_part;
  double units_a_metre;
};
constexpr KnownScale kKnownScales[] = {{"eyenavgs_truck", 0.76}, {"eyenavgs_room", 2.0}};

Expected<double> scale_of(Format format, std::string_view name, std::optional<double> units_a_metre) {
  if (units_a_metre) {
    if (std::isfinite(*units_a_metre) && *units_a_metre > 0) return *units_a_metre;
    return fail(Fault::OutOfRange, "the scene scale of a recording must be a positive number");
  }
  if (format != Format::EyeNavGs) return 1.0;
  for (const KnownScale& known : kKnownScales)
    if (name.find(known.name_part) != name.npos) return known.units_a_metre;
  return fail(Fault::Unsupported,
              std::string(name) +
                  ": an EyeNavGS recording, whose name does not tell its scene: give --trace-scale, how many "
                  "of its units are a metre (0.76 in its scene truck, 2 in room)");
}

/// Refuses a table whose first row has semicolons, as spreadsheets write it in many languages.
Expected<void> check_separator(std::string_view text, std::string_view name) {
  rows::Lines lines(text, name);
  for (std::string_view line; lines.next(line);) {
    if (line.front() == '#') continue;
    if (line.find(';') == line.npos) return {};
    return rows::fail_at(
        lines.place(), Fault::Unsupported,
        "the columns are separated by semicolons: separate them by commas, and write decimals "
        "with a point");
  }
  return {};
}

}  // namespace

Expected<HeadRecording> parse_head_recording(std::string_view text, std::string_view name,
                                             std::optional<double> units_a_metre) {
  if (const Expected<void> sound = check_separator(text, name); !sound) return tl::unexpected(sound.error());
  const Format format = format_of(text);
  const Expected<double> scale = scale_of(format, name, units_a_metre);
  if (!scale) return tl::unexpected(scale.error());
  switch (format) {
    case Format::Tum:
      return formats::read_tum(text, name, *scale);
    case Format::EyeNavGs:
      return formats::read_eyenavgs(text, name, *scale);
    case Format::Euroc:
      break;
  }
  return formats::read_euroc(text, name, *scale);
}

Expected<HeadRecording> load_head_recording(const std::filesystem::path& path,
                                            std::optional<double> units_a_metre) {
  const Expected<std::vector<std::byte>> bytes = read_file(path, kMaxRecordingBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  return parse_head_recording(text, path.filename().string(), units_a_metre);
}

}  // namespace farshade
